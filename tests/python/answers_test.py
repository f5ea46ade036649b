# SPDX-License-Identifier: GPL-3.0-or-later
"""The real server's numbers, with numpy as the judge."""
import pathlib
import tempfile
import threading
import unittest

import numpy as np

from support import Case, make_beam, mote, needs_server, spawn  # isort: skip


@needs_server
class Answers(Case):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.plots = pathlib.Path(cls.folder.name)
        make_beam(cls.plots, particles=30000, steps=4)
        cls.session = spawn(cls.plots)
        cls.addClassCleanup(cls.session.close)
        cls.ds = cls.session["data/beam"]
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
