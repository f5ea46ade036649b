# SPDX-License-Identifier: GPL-3.0-or-later
"""The real server, from Python: pictures, numbers, jobs, and that nothing of it stays behind."""
import glob
import json
import os
import pathlib
import select
import signal
import subprocess
import sys
import threading
import unittest

import numpy as np
from PIL import Image as pil

from support import BIN, PACKAGE, BeamCase, FolderCase, mote, needs_server, prepare, spawn  # isort: skip


def processes_of(folder):
    """The processes that have a folder's name in their command line."""
    found = []
    for place in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            words = pathlib.Path(place).read_bytes()
        except OSError:
            continue
        if os.fsencode(str(folder)) in words:
            found.append(int(place.split("/")[2]))
    return [number for number in found if number != os.getpid()]


def wait_for_end(processes):
    """Of processes that are not our children."""
    for number in processes:
        try:
            process = os.pidfd_open(number)
        except ProcessLookupError:
            continue
        try:
            select.select([process], [], [], 60)
        finally:
            os.close(process)


@needs_server
class Looking(BeamCase):
    def test_what_is_there(self):
        self.assertEqual(self.session.datasets, ["data/beam"])
        self.assertEqual((self.ds.axes, len(self.ds), self.ds.kind), (("x", "px", "y"), 3, "particles"))
        self.assertEqual(self.ds.units["px"], "eV/c")
        self.assertTrue((np.diff(self.ds.t) > 0).all())
        self.assertLessEqual(int(self.ds.particles.max()), 3000)
        with self.fails("not_found"):
            self.session["data/none"]

    def test_pictures_are_those_of_mote_frames(self):
        if not (BIN / "mote-frames").exists():
            self.skipTest("there is no mote-frames")
        view = mote.View(self.ds, step=1, size=(320, 200), style={"points": {"opacity": 0.7}}, background=[0.1, 0.2, 0.3])
        script = self.plots / "script.json"
        script.write_text(json.dumps(mote.Script([view]).to_dict()), encoding="utf-8")
        subprocess.run([str(BIN / "mote-frames"), str(script), "--spawn", f"data={self.plots}", "--device", "cpu", "--out",
                        str(self.plots / "frames"), "--quiet"], check=True, capture_output=True)
        expected = np.array(pil.open(self.plots / "frames" / "frame-000000.png").convert("RGB"))
        image = view.render()
        np.testing.assert_array_equal(image.array[..., :3], expected)
        self.assertGreater(int(expected.max()), int(expected.min()), "something is seen")

    def test_light_and_bytes_are_one_picture(self):
        view = mote.View(self.ds, size=(160, 120))
        light = view.render(linear=True)
        # A half has 11 bits: rounding moves an encoded value by less than a step of a byte.
        difference = np.abs(light.array.astype(int) - view.render().array)
        self.assertLessEqual(int(difference.max()), 1)

    def test_a_script_is_its_views(self):
        view = mote.View(self.ds, size=(64, 64)).fit(range(3))
        frames = [image.array for image in mote.Script.steps(view, range(3)).frames()]
        for step in range(3):
            np.testing.assert_array_equal(frames[step], view.replace(step=step).render().array)

    def test_a_document(self):
        path = self.plots / "paper.svg"
        mote.View(self.ds, size=(64, 64)).save(path, width=40)
        self.assertIn(b'width="40mm"', path.read_bytes()[:400])

    def test_a_document_is_as_wide_as_the_view_says_it_is_printed(self):
        path = self.plots / "paper.svg"
        view = mote.View(self.ds, size=(80, 60), annotations={"axes": True, "printWidth": 86})
        view.save(path)
        self.assertIn(b'width="86mm" height="64.5mm"', path.read_bytes()[:400])
        view.save(path, margin=7)
        self.assertIn(b'width="100mm" height="78.5mm"', path.read_bytes()[:400])
        view.save(path, height=30)
        self.assertIn(b'width="40mm" height="30mm"', path.read_bytes()[:400])
        mote.View(self.ds, size=(96, 48), annotations=True).save(path)  # an inch
        self.assertIn(b'width="25.4mm" height="12.7mm"', path.read_bytes()[:400])

    def test_a_view_that_the_server_refuses(self):
        fields = mote.View(self.ds, size=(64, 64)).to_dict()
        fields["layers"][0]["dataset"] = "data/gone"
        with self.fails("not_found"):
            self.session.view(fields).render()
        with self.fails("invalid_argument"):
            mote.View(self.ds, size=(64, 64), camera={"eye": [0, 0, 0], "target": [0, 0, 0]}).render()
        mote.View(self.ds, size=(64, 64)).render()

    def test_a_server_that_is_killed_is_there_again(self):
        with open(self.session._server.connection_file, encoding="utf-8") as file:
            number = int(json.load(file)["pid"])
        before = mote.View(self.ds, size=(64, 64)).render()
        os.kill(number, signal.SIGKILL)
        np.testing.assert_array_equal(mote.View(self.ds, size=(64, 64)).render().array, before.array)


@needs_server
class Working(BeamCase):
    def test_a_job_makes_a_dataset(self):
        job = self.session.prepare("data/run.h5", axes=["x", "y", "z"], output="data/other.mote", title="others", steps="0:2:2")
        self.assertEqual(job.wait(progress=False).state, "succeeded")
        self.assertEqual((job.progress, job.output, job.error), (1.0, "data/other.mote", ""))
        ds = self.session["data/other"]
        self.assertEqual((ds.axes, len(ds), ds.title), (("x", "y", "z"), 2, "others"))
        self.assertIn(job.id, [other.id for other in self.session.jobs])
        self.assertEqual(self.session.job(job.id).state, "succeeded")

    def test_arrays_become_a_dataset(self):
        numbers = np.random.default_rng(3)
        columns = {name: numbers.normal(size=200) for name in ("x", "y", "z", "px", "py", "pz", "t")}
        columns["x"] = np.ma.array(columns["x"], mask=np.arange(200) == 7)
        alive = np.arange(200) >= 3
        with self.assertWarns(UserWarning):
            job = self.session.prepare_arrays({**columns, "charge": 1e-12, "alive": alive, "id": np.arange(200) * 2**50}, ["x", "px", "z"],
                                              "data/arrays.mote", mass=0.511e6, title="mine")
        job.wait(progress=False)
        ds = self.session["data/arrays"]
        kept = alive & (np.arange(200) != 7)
        self.assertEqual((ds.particles.tolist(), ds.title), ([int(kept.sum())], "mine"))
        ids, y = ds.get(["id", "y"])
        order = np.argsort(ids)
        np.testing.assert_array_equal(ids[order], (np.arange(200, dtype=np.uint64) * 2**50)[kept])
        np.testing.assert_allclose(y[order], columns["y"][kept], rtol=1e-5, atol=1e-5)

    def test_a_job_that_fails_says_why(self):
        with self.fails("not_found"):
            self.session.prepare("data/none.h5", axes=["x", "y", "z"], output="data/none.mote").wait(progress=False)
        (self.plots / "bad.h5").write_bytes(b"nothing")
        job = self.session.prepare("data/bad.h5", axes=["x", "y", "z"], output="data/bad.mote")
        with self.fails("internal", "data/bad.mote"):
            job.wait(progress=False)
        self.assertEqual(job.state, "failed")
        for options, where in (({"axes": ["x", "x", "y"]}, None), ({"axes": ["x"], "colour": 1}, "particles"), ({"kind": "magic"}, "kind")):
            with self.fails("invalid_argument", where):
                self.session.prepare("data/run.h5", output="data/no.mote", **options)

    def test_a_job_is_cancelled(self):
        job = self.session.prepare("data/run.h5", axes=["x", "px", "z"], output="data/cancelled.mote")
        job.cancel()
        if job.state == "succeeded":
            return  # it was quicker
        with self.fails("cancelled", "data/cancelled.mote"):
            job.wait(progress=False)

    def test_an_image_and_a_mesh(self):
        pil.fromarray(np.arange(64, dtype=np.uint8).reshape(8, 8)).save(self.plots / "ramp.png")
        self.session.prepare("data/ramp.png", kind="image", output="data/ramp.mote").wait(progress=False)
        self.assertEqual((self.session["data/ramp"].kind, len(self.session["data/ramp"])), ("image", 1))
        with self.fails("unsupported", "data/ramp"):
            self.session["data/ramp"].get("x")
        image = mote.View(self.session["data/ramp"], size=(8, 8)).render()
        np.testing.assert_array_equal(image.array[:, :, 0], np.arange(64).reshape(8, 8))
        np.testing.assert_array_equal(image.array[:, :, 1], image.array[:, :, 2])


def linear_light(bytes_):
    """Of sRGB, 0 to 255 (IEC 61966-2-1)."""
    x = np.asarray(bytes_, dtype=float) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def encoded_light(light):
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0) ** (1 / 2.4) - 0.055)


@needs_server
class Images(BeamCase):
    """Pictures behind everything, held against numpy."""

    particles, steps = 1000, 1

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        random = np.random.default_rng(7)
        y, x = np.mgrid[0:120, 0:160]
        smooth = np.stack([x / 160, y / 120, (x + y) / 280], axis=-1) * 200
        cls.photo = np.clip(smooth + random.normal(0, 25, (120, 160, 3)), 0, 255).astype(np.uint8)
        pil.fromarray(cls.photo).save(cls.plots / "photo.png")
        prepare("image", cls.plots / "photo.png", "--out", cls.plots / "photo.mote")
        prepare("stipple", "plane", "--points", 4000, "--seed", 1, "--out", cls.plots / "plane.mote")

    def render(self, *layers, size, **more):
        return mote.View(list(layers), size=size, **more).render()

    def layer(self, name, **more):
        return mote.Layer(self.session[f"data/{name}"], **more)

    def test_as_large_as_it_is_it_is_what_it_is(self):
        image = mote.View(self.session["data/photo"], size=(160, 120)).render()
        np.testing.assert_array_equal(image.array[..., :3], self.photo)
        # A view at its side has background there.
        wide = mote.View(self.session["data/photo"], size=(180, 120), background=[1, 0, 0]).render().array[..., :3]
        np.testing.assert_array_equal(wide[:, 10:170], self.photo)
        self.assertTrue((wide[:, :10] == [255, 0, 0]).all() and (wide[:, 170:] == [255, 0, 0]).all())

    def test_smaller_it_has_the_mean_light(self):
        image = mote.View(self.session["data/photo"], size=(40, 30)).render()
        mean = linear_light(self.photo).reshape(30, 4, 40, 4, 3).mean(axis=(1, 3))
        # Half floats keep light to 2^-11 of it: less than a step beside the rounding to one.
        self.assertLessEqual(np.abs(image.array[..., :3] - encoded_light(mean)).max(), 0.6)

    def test_opacity_mixes_light_with_the_background(self):
        image = self.render(self.layer("photo", opacity=0.25), size=(160, 120), background=[0.5, 0.5, 0.5])
        mixed = 0.25 * linear_light(self.photo) + 0.75 * linear_light(127.5)
        self.assertLessEqual(np.abs(image.array[..., :3] - encoded_light(mixed)).max(), 0.6)

    def test_what_has_a_depth_lies_before_it(self):
        camera = {"eye": [0, 0, 4], "target": [0, 0, 0]}
        beam = mote.Layer(self.ds, style={"points": {"opacity": 1, "sizePixels": 3, "linked": False, "color": [0, 1, 0],
                                                     "curve": [{"density": 0, "fraction": 1}]}})
        for layers in ([self.layer("photo"), beam], [beam, self.layer("photo")]):
            seen = self.render(*layers, size=(160, 120), camera=camera).array[..., :3]
            alone = self.render(beam, size=(160, 120), camera=camera).array[..., :3]
            covered = (alone == [0, 255, 0]).all(axis=-1)
            self.assertGreater(covered.sum(), 100)
            # At a disc's edge up to a 255th of what lies behind comes through: less than 16 steps, as sRGB has it.
            self.assertLess(np.abs(seen[covered].astype(int) - [0, 255, 0]).max(), 16)
            empty = (alone == 0).all(axis=-1)
            np.testing.assert_array_equal(seen[empty], self.photo[empty])

    def test_dots_in_the_tones_of_the_layers_before(self):
        def dots(*before, style):
            return self.render(*before, self.layer("plane", style=style), size=(160, 120), background=[1, 1, 1]).array[..., 0]

        # What an image layer shows as large as it is is the image: the same dots, but for what its eight bits round away.
        by_layers = dots(self.layer("photo"), style={"source": "layers"}).astype(int)
        by_image = dots(style={"image": "data/photo"}).astype(int)
        self.assertGreater((by_layers < 128).mean(), 0.1)
        self.assertLess((np.abs(by_layers - by_image) > 128).mean(), 0.02)
        # Seen from afar the dots are the photograph: means over 20 x 20 pixels.
        light = linear_light(self.photo) @ [0.2126, 0.7152, 0.0722]
        far = [each.reshape(6, 20, 8, 20).mean(axis=(1, 3)) for each in (linear_light(by_layers), light)]
        self.assertLess(np.abs(far[0] - far[1]).max(), 0.08)

    def test_what_an_image_cannot_have(self):
        for more, where in (({"transform": np.diag([2, 2, 2, 1])}, "transform"), ({"select": {"ids": [1]}}, "select")):
            with self.fails("invalid_argument", f"view.layers[0].{where}"):
                self.render(self.layer("photo", **more), size=(16, 12))
        with self.fails("invalid_argument", "layers[0].dataset", "not an image"):
            self.render(self.layer("beam", kind="image"), size=(16, 12))
        with self.fails("invalid_argument", "layers[0].dataset", "not particles"):
            self.render(self.layer("photo", kind="particles"), size=(16, 12))


@needs_server
class Spawning(FolderCase):
    def setUp(self):
        super().setUp()
        self.plots = self.folder

    def test_what_cannot_be_started(self):
        with self.fails("not_found", str(self.plots / "none")):
            spawn(self.plots / "none")
        with self.fails("not_found", words="program="):
            mote.spawn(data=self.plots, program="/nowhere/mote-server")
        with self.fails("invalid_argument", "data"):
            mote.spawn(program=BIN / "mote-server")
        with self.fails("internal", "mote-server", "--device"):
            spawn(self.plots, device="magic")
        with self.fails("internal", "mote-server"):
            mote.spawn(data=self.plots, program="/bin/true")

    def test_it_ends_with_its_session(self):
        for end in ("close", "with"):
            session = spawn(self.plots)
            private = session._server.folder
            self.assertTrue(processes_of(private))
            if end == "close":
                session.close()
            else:
                with session:
                    pass
            self.assertEqual(processes_of(private), [])
            self.assertFalse(os.path.exists(private))
            with self.fails("cancelled"):
                session.datasets

    def start_python(self, text):
        words = f"import mote\ns = mote.spawn(data={str(self.plots)!r}, program={str(BIN / 'mote-server')!r})\n" \
                f"print(s._server.folder, flush=True)\n{text}"
        child = subprocess.Popen([sys.executable, "-c", words], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(PACKAGE)})
        self.addCleanup(child.stdin.close)
        self.addCleanup(child.stdout.close)
        self.addCleanup(child.stderr.close)
        return child, child.stdout.readline().strip()

    def test_it_ends_with_python(self):
        for text, code in (("", 0), ("raise SystemExit(3)", 3), ("1 / 0", 1)):
            child, private = self.start_python(text)
            self.assertEqual(child.wait(60), code)
            self.assertEqual(processes_of(private), [])
            self.assertFalse(os.path.exists(private), text)

    def test_it_ends_where_python_is_killed(self):
        for number in (signal.SIGKILL, signal.SIGTERM):
            child, private = self.start_python("input()")
            processes = processes_of(private)
            self.assertTrue(processes)
            child.send_signal(number)
            child.wait(60)
            wait_for_end(processes)
            self.assertEqual(processes_of(private), [])
            self.assertFalse(os.path.exists(private))

    def test_many_sessions_with_one_server(self):
        with spawn(self.plots) as session:
            others = [mote.connect(session._server.connection_file) for _ in range(5)]
            self.assertEqual([other.datasets for other in others], [[]] * 5)
            self.assertLess(others[0].ping(), 60)
            for other in others:
                other.close()
            prepare("stipple", "plane", "--points", 200, "--seed", 1, "--out", self.plots / "dots.mote")
            self.assertEqual(session.datasets, ["data/dots"])
            with self.fails("unsupported", "layers[0].dataset", "image"):
                mote.View(session["data/dots"], size=(32, 32)).render()

    def test_a_connection_outlives_what_it_does_not_own(self):
        with spawn(self.plots) as session:
            other = mote.connect(session._server.connection_file)
        with self.assertRaises(mote.Error):
            other.datasets
        other.close()


@needs_server
class Answers(BeamCase):
    """Numbers, with numpy as the judge."""

    particles, steps = 30000, 4

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.columns = dict(zip(cls.ds.columns, cls.ds.get(list(cls.ds.columns), step=3)))

    def test_selections_hold_what_numpy_finds(self):
        c = self.columns
        r = np.hypot(c["x"], c["y"])
        for select, expected in (
                ({}, np.ones(30000, bool)),
                ({"ranges": [{"column": "x", "min": 1e-4, "max": 2e-3}]}, (c["x"] >= 1e-4) & (c["x"] <= 2e-3)),
                ({"ranges": [{"column": "r", "max": 1e-3}]}, r <= 1e-3),
                ({"not": {"ranges": [{"column": "r", "max": 1e-3}]}}, r > 1e-3),
                ({"any": [{"ranges": [{"column": "x", "max": 0}]}, {"ranges": [{"column": "y", "max": 0}]}]}, (c["x"] <= 0) | (c["y"] <= 0)),
                ({"polygon": {"columns": ["x", "y"], "points": [[0, 0], [2e-3, 0], [0, 2e-3]]}},
                 (c["x"] >= 0) & (c["y"] >= 0) & (c["x"] + c["y"] < 2e-3)),
                ({"ids": [1, 5, 10 ** 15]}, np.isin(c["id"], [1, 5]))):
            ids = self.ds.get("id", step=3, select=select)
            np.testing.assert_array_equal(ids, c["id"][expected], err_msg=str(select))
            self.assertEqual(self.ds.statistics(step=3, select=select or None, names=["n_particle"])["n_particle"], expected.sum())

    def test_statistics_are_those_of_numpy(self):
        select = {"ranges": [{"column": "x", "min": -1e-3}]}
        inside = self.columns["x"] >= -1e-3
        found = self.ds.statistics(step=3, select=select)
        w = self.columns["weight"][inside]
        for name in ("x", "y", "z", "px", "py", "pz"):
            q = self.columns[name][inside]
            mean = np.average(q, weights=w)
            sigma = np.sqrt(np.average((q - mean) ** 2, weights=w))
            self.assertAlmostEqual(found[f"mean_{name}"], mean, delta=1e-7 * sigma)
            self.assertAlmostEqual(found[f"sigma_{name}"] / sigma, 1.0, delta=1e-7)
            self.assertEqual((found[f"min_{name}"], found[f"max_{name}"]), (q.min(), q.max()))
        x, px = (self.columns[name][inside] - np.average(self.columns[name][inside], weights=w) for name in ("x", "px"))
        emittance = np.sqrt(np.average(x * x, weights=w) * np.average(px * px, weights=w) - np.average(x * px, weights=w) ** 2)
        self.assertAlmostEqual(found["norm_emit_x"] / (emittance / self.ds.mass), 1.0, delta=1e-7)

    def test_of_no_particle_nothing_is_defined(self):
        none = self.ds.statistics(step=0, select={"ranges": [{"column": "x", "min": 1e9}]})
        self.assertEqual(none["n_particle"], 0)
        self.assertTrue(np.isnan(none["mean_x"]) and np.isnan(none["norm_emit_x"]))
        self.assertEqual(len(self.ds.get("x", step=0, select={"ranges": [{"column": "x", "min": 1e9}]})), 0)

    def test_slices_are_parts_of_the_whole(self):
        found = self.ds.statistics(step=2, slices=("z", 7), names=["n_particle", "mean_x"])
        z, x = self.ds.get(["z", "x"], step=2)
        edges = found["slice_edges"]
        np.testing.assert_array_equal(found["slices"]["n_particle"], np.histogram(z, bins=edges)[0])
        np.testing.assert_allclose(found["slices"]["mean_x"][3], x[(z >= edges[3]) & (z < edges[4])].mean(), rtol=1e-9)

    def test_histograms_are_those_of_numpy(self):
        c = self.columns
        for weighted in (True, False):
            w = c["weight"] if weighted else np.ones(30000)
            found = self.ds.histogram("x", "px", bins=(512, 300), step=3, weighted=weighted)
            h, (ex, ey) = found
            np.testing.assert_allclose(h, np.histogram2d(c["x"], c["px"], bins=(ex, ey), weights=w)[0], rtol=1e-12)
            self.assertEqual((found.particles, found.outside), (30000, 0))
        found = self.ds.histogram("x", bins=64, range=(-1e-3, 1e-3), step=3)
        np.testing.assert_allclose(found[0], np.histogram(c["x"], bins=64, range=(-1e-3, 1e-3), weights=c["weight"])[0], rtol=1e-12)
        inside = np.abs(c["x"]) <= 1e-3
        self.assertEqual(found.particles, inside.sum())
        self.assertAlmostEqual(found.outside / c["weight"][~inside].sum(), 1.0, delta=1e-12)
        waterfall, edges = self.ds.histogram("energy", bins=20)
        self.assertEqual(waterfall.shape, (4, 20))
        self.assertAlmostEqual(waterfall.sum() / (4 * c["weight"].sum()), 1.0, delta=1e-12)

    def test_particles_are_followed_by_their_ids(self):
        select = {"density": {"max": 0.4}, "step": 3}
        ids, path = self.ds.track(select=select, columns=["x", "delta"])
        np.testing.assert_array_equal(ids, np.sort(self.ds.get("id", step=3, select={"density": {"max": 0.4}})))
        for step in range(4):
            own, x, delta = self.ds.get(["id", "x", "delta"], step=step)
            order = np.argsort(own)
            places = order[np.searchsorted(own, ids, sorter=order)]
            np.testing.assert_array_equal(path[step], np.stack([x[places], delta[places]], axis=1))
        missing, path = self.ds.track(select={"ids": [3, 10 ** 12]}, columns=["x"])
        self.assertEqual(missing.tolist(), [3, 10 ** 12])
        self.assertTrue(np.isnan(path[:, 1]).all() and not np.isnan(path[:, 0]).any())

    def test_a_pick_is_the_nearest(self):
        camera = {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 2.5}
        view = mote.View(self.ds, step=3, size=(500, 400), camera=camera, 
                         style={"points": {"linked": False, "curve": [{"density": 0, "fraction": 1}]}})
        b = self.ds.bounds
        u = [2 * (self.columns[n] - b[n][0]) / (b[n][1] - b[n][0]) - 1 for n in self.ds.axes]
        sx, sy = 250 + u[0] * 160, 200 - u[1] * 160
        for x, y in ((250, 200), (230.5, 240), (20, 30)):
            found = self.ds.pick(view, x, y, radius=400)
            distance = np.hypot(sx - x, sy - y)
            # A place is kept to a 65536th of its cell.
            self.assertAlmostEqual(found["distance"], distance.min(), delta=0.01)
            self.assertAlmostEqual(distance[found["point"]], distance.min(), delta=0.01)
            self.assertEqual(found["id"], self.columns["id"][found["point"]])
            self.assertEqual(found["values"]["x"], self.columns["x"][found["point"]])
        self.assertIsNone(self.ds.pick(view, -900, -900))

    def test_what_is_wrong_is_said_where(self):
        for ask, code, where in (
                (lambda: self.ds.get("charm"), "not_found", "names[0]"),
                (lambda: self.ds.get("x", select={"ranges": [{"column": "nix"}]}), "not_found", "select.ranges[0].column"),
                (lambda: self.ds.get("x", select={"step": 77}), "not_found", "select.step"),
                (lambda: self.ds.get("x", select={"polygon": {"columns": ["x", "y"], "points": [[0, 0], [1, 1]]}}), "invalid_argument", None),
                (lambda: self.ds.histogram("x", range=(1, 0), step=0), "invalid_argument", "range"),
                (lambda: self.ds.histogram("x", bins=5000, step=0), "invalid_argument", "query.histogram.axes[0].bins"),
                (lambda: self.ds.histogram("x", bins=0, step=0), "invalid_argument", "query.histogram.axes[0].bins"),
                (lambda: self.ds.statistics(step=0, slices=("x", 0)), "invalid_argument", "query.statistics.sliceCount"),
                (lambda: self.ds.statistics(step=0, slices=("x", 257)), "invalid_argument", "query.statistics.sliceCount"),
                (lambda: self.ds.statistics(step=0, select={"ids": [1]}, names=["luck"]), "not_found", "names[0]")):
            with self.fails(code, where):
                ask()

    def test_many_ask_at_once(self):
        failures = []

        def ask():
            try:
                with mote.connect(self.session._server.connection_file) as other:
                    ds = other["data/beam"]
                    for step in range(4):
                        if len(ds.get("x", step=step, select={"ranges": [{"column": "r", "max": 1e-3}]})) == 0:
                            failures.append("nothing")
            except Exception as error:  # noqa: BLE001
                failures.append(error)

        threads = [threading.Thread(target=ask) for _ in range(25)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(120)
        self.assertEqual(failures, [])

    def test_numpy_arrays_become_a_dataset(self):
        random = np.random.default_rng(0)
        arrays = {name: random.normal(size=4000) for name in ("x", "px", "y")}
        other = mote.connect(self.session._server.connection_file)
        other.prepare_arrays(arrays, axes=["x", "px", "y"], output="data/mine.mote", mass=0.511e6).wait(progress=False)
        np.testing.assert_allclose(np.sort(other["data/mine"].get("x")), np.sort(arrays["x"]), atol=1e-6)
        other.close()


if __name__ == "__main__":
    unittest.main()
