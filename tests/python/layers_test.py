# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that are hidden or have names, lassos that say their plot, and what the catalogue tells of files, asked of the real
server: held to pictures without the layers, and to particles that numpy projects."""
import json
import pathlib
import tempfile
import time
import unittest

import numpy as np

from support import Case, mote, needs_server, prepare, spawn  # isort: skip
from mote.messages import to_dict, to_message  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

COUNT, STEPS = 4000, 2
CAMERA = {"eye": [1.2, 2.0, 3.5], "target": [0.1, 0.0, -0.1], "up": [0, 1, 0], "fovYDegrees": 40}
FLAT = {"eye": [1.2, 2.0, 3.5], "target": [0.1, 0.0, -0.1], "up": [0.2, 1, 0], "orthographicHeight": 2.5}
ASPECT = 1.6
LINE = np.array([[0.3, 0.2], [0.75, 0.35], [0.6, 0.8], [0.5, 0.45], [0.35, 0.7]])
TURNED = np.array([[0.8, -0.6, 0, 0.1], [0.6, 0.8, 0, 0], [0, 0, 1.3, -0.2], [0, 0, 0, 1]])


def within(line, x, y):
    """Even-odd."""
    inside = np.zeros(len(x), bool)
    for (ax, ay), (bx, by) in zip(line, np.roll(line, -1, axis=0)):
        crosses = (ay <= y) != (by <= y)
        inside ^= crosses & (x < ax + (bx - ax) * (y - ay) / (by - ay))
    return inside


def surrounded(camera, transform, places):
    """Which places of a plot are seen within the line, by a camera of our own."""
    eye, target, up = (np.array(camera[name], float) for name in ("eye", "target", "up"))
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, up) / np.linalg.norm(np.cross(ahead, up))
    world = places @ transform[:3, :3].T + transform[:3, 3] - eye
    depth = world @ ahead
    half = np.full(len(depth), camera["orthographicHeight"] / 2) if "orthographicHeight" in camera \
        else depth * np.tan(np.radians(camera["fovYDegrees"] / 2))
    return within(LINE, 0.5 + world @ right / (2 * half * ASPECT), 0.5 - world @ np.cross(right, ahead) / (2 * half))


@needs_server
class Layers(Case):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        random = np.random.default_rng(11)
        scale = (1 + np.arange(STEPS))[:, None]
        columns = {name: random.normal(0, 1e-3 * scale, (STEPS, COUNT)) for name in "xyz"}
        columns.update({name: random.normal(0, 2e4, (STEPS, COUNT)) for name in ("px", "py", "pz")})
        columns["id"] = np.array([random.permutation(COUNT) for _ in range(STEPS)])
        np.savez(cls.folder / "run.npz", **columns)
        for name, *options in (("phase", "--axes", "x,px,y"), ("space", "--axes", "z,y,x"),
                               ("part", "--axes", "x,px,y", "--bounds", "x=-1e-3:1e-3")):
            prepare("particles", cls.folder / "run.npz", *options, "--out", cls.folder / f"{name}.mote")
        session = spawn(cls.folder)
        cls.addClassCleanup(session.close)
        cls.session = session
        cls.phase, cls.space, cls.part = (session[f"data/{name}"] for name in ("phase", "space", "part"))

    def pixels(self, *layers, **options):
        return np.asarray(mote.View(list(layers), size=(96, 64), **options).render().array)

    # ------------------------------------------------------------------------------------------ layers

    def test_a_hidden_layer_is_not_there(self):
        first = {"annotations": True, "camera": CAMERA}
        for kind, style in (("particles", {}), ("ink", {"hatch": {"strength": 0.5}})):
            shown = mote.Layer(self.phase, 1, kind=kind, style=style)
            other = {"style": {"points": {"sizePixels": 3}}, "highlight": {}, "color_by": "y", "transform": TURNED}
            for options in (first, {}):
                with self.subTest(kind=kind, **options):
                    alone = self.pixels(shown, **options)
                    self.assertGreater(alone[..., :3].std(), 0)
                    for layers in ((mote.Layer(self.space, hidden=True, **other), shown),
                                   (shown, mote.Layer(self.space, hidden=True, **other))):
                        np.testing.assert_array_equal(self.pixels(*layers, **options), alone)
                    both = self.pixels(shown, mote.Layer(self.space, **other), **options)
                    self.assertTrue((both != alone).any())

    def test_where_all_are_hidden_nothing_is_seen(self):
        for options in ({}, {"camera": CAMERA}, {"annotations": True}):
            image = self.pixels(*(mote.Layer(self.phase, step, hidden=True) for step in (0, 1)), **options)
            self.assertEqual(int(image[..., :3].max()), 0)
        page = self.folder / "page.svg"
        mote.View([mote.Layer(self.phase, kind="ink", hidden=True)], size=(64, 48)).save(page)
        self.assertIn("<svg", page.read_text(encoding="utf-8")[:400])

    def test_a_hidden_layer_is_not_picked(self):
        shown, hidden = mote.Layer(self.phase, 1), mote.Layer(self.phase, 1, hidden=True)
        camera = {**CAMERA, "target": [0, 0, 0]}
        found = self.phase.pick(mote.View(shown, size=(96, 64), camera=camera), 48, 32, radius=500)
        self.assertIsNotNone(found)
        self.assertIsNone(self.phase.pick(mote.View(hidden, size=(96, 64), camera=camera), 48, 32, radius=500))

    def test_it_is_checked_with_the_view(self):
        view = mote.View([mote.Layer(self.phase, 1), mote.Layer(self.space, name="Ränder", hidden=True)], size=(64, 48))
        self.assertEqual([layer.name for layer in view.layers], ["", "Ränder"])
        self.assertEqual(mote.View.from_dict(self.session, view.to_dict()).layers[1].hidden, True)
        for change, code, where in (({"name": "a" * 201}, "invalid_argument", "view.layers[1].name"),
                                    ({"name": "a\nb"}, "invalid_argument", "view.layers[1].name"),
                                    ({"opacity": 2}, "invalid_argument", "view.layers[1].opacity"),
                                    ({"dataset": "data/none"}, "not_found", "layers[1].dataset")):
            plain = view.to_dict()
            plain["layers"][1].update(change)
            with self.subTest(change=change), self.fails(code, where):
                mote.View.from_dict(self.session, plain).render()

    # ------------------------------------------------------------------------------------------ lassos

    def expected(self, dataset, step, camera, transform, plot):
        columns = dataset.get(list(plot), step)
        low, high = np.array(list(plot.values())).T
        places = 2 * (np.stack(columns, 1) - low) / (high - low) - 1
        return surrounded(camera, transform, places) & (np.abs(places) <= 1 + 2e-6).all(1)

    def test_a_lasso_means_the_same_in_all_plots(self):
        derived = {"r": (0.0, 4e-3), "xp": (-3.0, 3.0), "z": (-3e-3, 2e-3)}
        for camera in (CAMERA, FLAT):
            for plot in (self.phase.bounds, self.space.bounds, self.part.bounds, derived):
                chosen = mote.lasso(camera, ASPECT, LINE, TURNED, plot=plot)
                for dataset in (self.phase, self.space, self.part):
                    for step in range(STEPS):
                        with self.subTest(plot=plot, dataset=dataset.name, step=step):
                            ids = dataset.get("id", step)[self.expected(dataset, step, camera, TURNED, plot)]
                            self.assertGreater(len(ids), 20)
                            self.assertLess(len(ids), 0.9 * COUNT)
                            self.assertEqual(sorted(dataset.get("id", step, chosen)), sorted(ids))
        # Of a step's particles: the same in the other one.
        there = mote.lasso(CAMERA, ASPECT, LINE, TURNED, plot=self.phase.bounds).at(0)
        self.assertEqual(sorted(self.space.get("id", 1, there)), sorted(self.phase.get("id", 0, there)))

    def test_it_is_what_it_was_in_its_own_plot(self):
        # But for what packed positions round.
        said, plain = (mote.lasso(CAMERA, ASPECT, LINE, TURNED, plot=plot) for plot in (self.phase.bounds, None))
        one, other = (set(self.phase.get("id", 1, select).tolist()) for select in (said, plain))
        self.assertLess(len(one ^ other), 5)
        self.assertGreater(len(one), 100)

    def test_pictures_and_exports_hold_it(self):
        chosen = mote.lasso(CAMERA, ASPECT, LINE, TURNED, plot=self.phase.bounds)
        ids = self.space.get("id", 1, chosen)
        by_lasso, by_ids = (self.pixels(mote.Layer(self.space, 1, select=select)) for select in (chosen, mote.ids(ids)))
        np.testing.assert_array_equal(by_lasso, by_ids)
        if h5py is None:
            return
        self.space.export(1, chosen).wait(progress=False).save(self.folder / "chosen.h5")
        select = self.folder / "select.json"
        select.write_text(json.dumps(to_dict(to_message("Selection", chosen))), encoding="utf-8")
        prepare("export", self.folder / "space.mote", "--openpmd", self.folder / "prep.h5", "--steps", "1", "--select", select)
        for name in ("chosen.h5", "prep.h5"):
            with h5py.File(self.folder / name, "r") as file:
                step, = file["data"].values()
                species, = step["particles"].values()
                self.assertEqual(sorted(species["id"][()]), sorted(ids), name)

    def test_what_is_wrong_is_said(self):
        plot = self.phase.bounds
        for change, code, where in ((dict(list(plot.items())[:2]), "invalid_argument", "query.select.lasso.axes"),
                                    ({**dict(list(plot.items())[:2]), "none": (0, 1)}, "not_found", "select.lasso.axes"),
                                    ({**plot, "y": (1, 1)}, "invalid_argument", "query.select.lasso.bounds[2]"),
                                    ({**plot, "y": (0, 1e301)}, "invalid_argument", "query.select.lasso.bounds[2][1]")):
            with self.subTest(change=change), self.fails(code, where):
                self.phase.statistics(1, mote.lasso(CAMERA, ASPECT, LINE, plot=change))

    # --------------------------------------------------------------------------------------- catalogue

    def test_the_catalogue_tells_sizes_and_dates(self):
        for entry in self.session.catalogue():
            folder = self.folder / (entry.name.split("/")[1] + ".mote")
            files = sum(path.stat().st_size for path in folder.iterdir() if path.name != "manifest.digest")
            self.assertEqual(entry.bytes, files, [path.name for path in folder.iterdir()])
            self.assertEqual(entry.prepared_ms // 1000, int((folder / "manifest.json").stat().st_mtime))
            self.assertLess(abs(time.time() - entry.prepared_ms / 1000), 3600)
        html = self.session._repr_html_()
        self.assertIn("MB</td>", html)
        self.assertIn(time.strftime("%Y-"), html)


if __name__ == "__main__":
    unittest.main()
