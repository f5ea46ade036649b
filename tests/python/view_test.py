# SPDX-License-Identifier: GPL-3.0-or-later
"""Views and selections: what they become on the wire, how pictures are asked for and what of them is believed."""
import itertools
import os
import signal
import tempfile
import threading
import unittest

import numpy as np
from support import Case, mote  # isort: skip
from fake_run import FakeRun
from fake_server import FakeServer
from mote import messages
from wire_test import filter_halves, filter_srgb, pack


def picture(view):
    """What a fake server draws: a picture that tells its view's step."""
    image = np.zeros((view.height, view.width, 4), np.uint8)
    image[..., :3] = np.arange(view.width)[None, :, None] * 3 + view.layers[0].step
    image[..., 3] = 255
    return image


class Studio(FakeRun):
    """Draws views; ``hold`` keeps them until that many wait, ``broken`` steps fail."""

    def __init__(self):
        super().__init__(steps=40)
        self.hold, self.waiting, self.broken = 1, [], ()

    def answer(self, peer, asked):
        if asked.WhichOneof("body") != "set_view":
            super().answer(peer, asked)
            return
        self.waiting.append(asked)
        if len(self.waiting) >= self.hold:
            for item in self.waiting:
                self.draw(peer, item)
            self.waiting = []

    def draw(self, peer, asked):
        view = asked.set_view
        if view.view.layers[0].step in self.broken:
            peer.fail(asked, "internal", "device", "it does not draw")
            return
        fields = {"view_id": view.view_id, "width": view.view.width, "height": view.view.height, "encoding": 2,
                  "format": view.format, "final": True, "points_drawn": 5, "device": "paper", "total_ms": 2.0}
        if view.HasField("page"):
            peer.reply(asked, "frame", b"<svg/>", **{**fields, "encoding": 4})
        elif view.format == 2:
            image = picture(view.view).astype(np.float16)
            peer.reply(asked, "frame", pack(filter_halves(image)), **fields)
        else:
            peer.reply(asked, "frame", pack(filter_srgb(picture(view.view))), **fields)


class WithStudio(Case):
    def setUp(self):
        self.studio = Studio()
        self.server = FakeServer(self.studio.answer)
        self.enterContext(self.server)
        self.session = mote.connect(self.server.file)
        self.addCleanup(self.session.close)
        self.ds = self.session["data/beam"]

    def views_heard(self):
        return [message.set_view for message in self.server.said if message.WhichOneof("body") == "set_view"]


class Views(WithStudio):
    def test_what_a_view_says(self):
        view = mote.View(self.ds, step=-1, size=(64, 48), color_by="energy", select=mote.column("x") >= 1,
                         highlight=mote.density(max=0.3), annotations="Halo", background=(1, 1, 1), opacity=0.5,
                         camera={"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_degrees": 30},
                         style={"points": {"linked": True}}, paths=np.array([1, 2], np.uint64), transform=np.eye(4))
        self.assertEqual(view.to_dict(), {
            "width": 64, "height": 48, "background": [1.0, 1.0, 1.0],
            "camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 30},
            "annotations": {"axes": True, "colorBar": True, "scaleBar": True, "labels": True, "title": "Halo"},
            "layers": [{"dataset": "data/beam", "step": 39, "transform": np.eye(4).reshape(-1).tolist(), "opacity": 0.5,
                        "particles": {"points": {"linked": True}}, "colorBy": {"column": "energy"},
                        "select": {"ranges": [{"column": "x", "min": 1.0}]},
                        "highlight": {"selection": {"density": {"max": 0.3}}}, "paths": {"ids": [1, 2]}}]})
        self.assertEqual(mote.View.from_dict(self.session, view.to_dict()).message, view.message)
        self.assertEqual(self.session.view(view.to_dict()).replace(step=2, size=(8, 8)).message.layers[0].step, 2)
        self.assertIn("data/beam[39]", repr(view))

    def test_options_are_checked(self):
        for options, where in (({"color": 1}, None), ({"style": {"pionts": {}}}, "layers[0].particles"),
                               ({"select": {"ranges": 1}}, "layers[0].select.ranges"), ({"step": 40}, "step"),
                               ({"size": (-1, 5)}, "width"), ({"annotations": {"axis": True}}, "annotations")):
            if where is None:
                with self.assertRaises(TypeError):
                    mote.View(self.ds, **options)
            else:
                with self.subTest(where), self.fails("invalid_argument", where):
                    mote.View(self.ds, **options)

    def test_layers_share_a_view(self):
        layers = [mote.Layer(self.ds, 1), mote.Layer(self.ds, 2, kind="ink", style={"hatch": {"strength": 0.5}})]
        view = mote.View(layers, size=(4, 4))
        self.assertEqual([layer.WhichOneof("kind") for layer in view.message.layers], ["particles", "ink"])
        for wrong in ([], [self.ds], "data/beam"):
            with self.assertRaises((TypeError, AttributeError)):
                mote.View(wrong)
        with self.assertRaises(TypeError):
            mote.View(layers, color_by="x")

    def test_a_picture_is_what_was_drawn(self):
        view = mote.View(self.ds, step=3, size=(31, 17))
        image = view.render()
        np.testing.assert_array_equal(image.array, picture(view.message))
        self.assertIsNone(image.linear)
        self.assertEqual((image.points_drawn, image.device), (5, "paper"))
        light = view.render(linear=True)
        self.assertEqual((light.linear.dtype, light.linear[0, 2, 0], light.array[0, 2, 0]), (np.float16, 9.0, 255))
        heard = self.views_heard()
        self.assertTrue(all(item.final_only and item.queued for item in heard))
        self.assertEqual([item.format for item in heard], [1, 2])
        self.assertIn("image/png", view._repr_mimebundle_()[0])

    def test_credits_are_given_back(self):
        for step in range(10):
            mote.View(self.ds, step=step, size=(5, 5)).render()
        self.session["data/beam"]  # what was said before it has arrived
        given = sum(m.credit.frames for m in self.server.said if m.WhichOneof("body") == "credit")
        self.assertEqual(given, 10)

    def test_a_view_that_fails_is_not_the_end(self):
        self.studio.broken = (2,)
        with self.fails("internal", "device", "does not draw"):
            mote.View(self.ds, step=2, size=(5, 5)).render()
        mote.View(self.ds, step=3, size=(5, 5)).render()

    def test_documents(self):
        with tempfile.TemporaryDirectory() as folder:
            for index, name in enumerate(("a.svg", "b.eps", "c.pdf")):
                path = os.path.join(folder, name)
                mote.View(self.ds, size=(5, 5)).save(path, width=80)
                with open(path, "rb") as file:
                    self.assertEqual(file.read(), b"<svg/>")
                self.assertEqual((self.views_heard()[-1].page.format, self.views_heard()[-1].page.width), (index + 1, 80))
            mote.View(self.ds, size=(5, 5)).save(os.path.join(folder, "d.png"))
            self.assertEqual(os.listdir(folder).count("d.png"), 1)

    def test_a_script_asks_ahead_and_keeps_its_order(self):
        script = mote.Script.steps(mote.View(self.ds, size=(6, 4)), range(20))
        self.studio.hold = 2  # no picture before two are asked for
        for step, image in enumerate(script):
            np.testing.assert_array_equal(image.array, picture(script.views[step].message))
        self.assertEqual(len(script.to_dict()["views"]), 20)

    def test_a_script_that_is_left_frees_its_views(self):
        script = mote.Script.steps(mote.View(self.ds, size=(6, 4)), range(20))
        self.assertEqual(len(list(itertools.islice(script.frames(), 2))), 2)
        frames = script.frames()
        next(frames)
        frames.close()
        self.session["data/beam"]
        self.assertEqual(self.session.connection._questions, {})
        self.assertEqual(self.session.connection.views_under_way(), 0)

    def test_many_threads_never_have_more_views_under_way_than_the_server_takes(self):
        most = []

        def draw(step):
            view = mote.View(self.ds, step=step, size=(6, 4))
            np.testing.assert_array_equal(view.render().array, picture(view.message))
            most.append(self.session.connection.views_under_way())

        threads = [threading.Thread(target=draw, args=(step,)) for step in range(40)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(most), 40)
        self.assertLessEqual(max(most), 16)

    def test_an_interrupted_picture_is_thrown_away(self):
        self.studio.hold = 2

        def interrupt(peer, asked, answer=self.server.answer):
            answer(peer, asked)
            if asked.WhichOneof("body") == "set_view" and len(self.studio.waiting) == 1:
                os.kill(os.getpid(), signal.SIGINT)

        self.server.answer = interrupt
        with self.assertRaises(KeyboardInterrupt):
            mote.View(self.ds, step=1, size=(5, 5)).render()
        self.server.answer = self.studio.answer
        view = mote.View(self.ds, step=7, size=(5, 5))
        np.testing.assert_array_equal(view.render().array, picture(view.message))


class Old(Case):
    def test_an_older_server_gets_one_view_at_a_time(self):
        studio = Studio()
        with FakeServer(studio.answer, minor=1) as server:
            session = mote.connect(server.file)
            self.addCleanup(session.close)
            list(mote.Script.steps(mote.View(session["data/beam"], size=(5, 5)), range(1)))
            heard = [m.set_view for m in server.said if m.WhichOneof("body") == "set_view"]
            self.assertEqual([item.queued for item in heard], [False])


class Selections(Case):
    def test_operators_make_the_interface_s_dicts(self):
        x, px = mote.column("x"), mote.column("px")
        self.assertEqual((x >= 1).to_dict(), {"ranges": [{"column": "x", "min": 1.0}]})
        self.assertEqual(dict(x.between(-1, 1)), {"ranges": [{"column": "x", "min": -1.0, "max": 1.0}]})
        self.assertEqual(((x >= 1) & (px <= 2) & {"ids": [1]}).to_dict(), {"all": [
            {"ranges": [{"column": "x", "min": 1.0}]}, {"ranges": [{"column": "px", "max": 2.0}]}, {"ids": [1]}]})
        self.assertEqual(({"ids": [1]} | mote.density(max=0.3)).to_dict(), {"any": [{"ids": [1]}, {"density": {"max": 0.3}}]})
        self.assertEqual((~mote.outermost("x", 0.1)).at(5).to_dict(),
                         {"not": {"outermost": {"plane": "x", "share": 0.1}}, "step": 5})
        with self.assertRaises(TypeError):
            1 < x < 2
        with self.assertRaises(TypeError):
            (x > 1) & 7
        with self.fails("invalid_argument", "x.min"):
            x > float("nan")

    def test_a_strict_bound_does_not_belong_to_its_range(self):
        numbers = np.random.default_rng(9)
        for bound in [0.0, 1e-3, -2.5, 1e300, 5e-324, *numbers.normal(size=50)]:
            low = (mote.column("x") > bound)["ranges"][0]["min"]
            high = (mote.column("x") < bound)["ranges"][0]["max"]
            self.assertTrue(high < bound < low)
            self.assertEqual((np.nextafter(low, -np.inf), np.nextafter(high, np.inf)), (bound, bound))

    def test_all_of_them_are_messages(self):
        x = mote.column("x") > 1
        for selection in (x, x & x, x | x, ~x, x.at(3), mote.ids(np.arange(5)), mote.density(0.1, 0.2),
                          mote.polygon(("x", "px"), np.zeros((4, 2))), mote.outermost("y", 0.5),
                          mote.lasso({"eye": [0, 0, 1]}, 1.5, [[0, 0], [1, 0], [1, 1]], np.eye(4).reshape(-1))):
            self.assertGreater(messages.to_message("Selection", selection).ByteSize(), 0)


if __name__ == "__main__":
    unittest.main()
