# SPDX-License-Identifier: GPL-3.0-or-later
"""Answers become arrays, held against numpy over generated runs; and answers that cannot be true are refused."""
import random
import unittest
import warnings

import numpy as np
from support import Case, mote  # isort: skip
from fake_run import FakeRun
from fake_server import FakeServer


class WithRun(Case):
    def open(self, **options):
        run = FakeRun(**options)
        server = FakeServer(run.answer)
        self.enterContext(server)
        session = mote.connect(server.file)
        self.addCleanup(session.close)
        return run, session["data/beam"]


class Numbers(WithRun):
    def test_what_a_dataset_is(self):
        _, ds = self.open(steps=4, particles=9)
        self.assertEqual((len(ds), ds.axes, ds.columns, ds.kind, ds.mass), (4, ("x", "px", "y"), ("x", "px", "y", "id"),
                                                                         "particles", 5.11e5))
        self.assertEqual(ds.iterations.tolist(), [0, 10, 20, 30])
        self.assertEqual(ds.t.tolist(), [0, 0.5, 1, 1.5])
        self.assertEqual(ds.bounds["px"], (-4, 4))
        self.assertEqual(ds.manifest["particles"]["steps"][3]["iteration"], 30)
        self.assertIn("&lt;b&gt;fake", ds._repr_html_())
        self.assertIn("4 steps", repr(ds))

    def test_columns_come_whole_however_they_are_cut(self):
        numbers = random.Random(6)
        for seed in range(6):
            run, ds = self.open(seed=seed, particles=numbers.randint(1, 400), piece=numbers.randint(1, 90))
            for step in (0, -1, 1):
                x, identity = ds.get(["x", "id"], step=step)
                np.testing.assert_array_equal(x, run.values[step][:, 0])
                np.testing.assert_array_equal(identity, run.ids[step])
                self.assertEqual((x.dtype, identity.dtype), (np.float64, np.uint64))
                low = mote.column("px") > 0.3
                np.testing.assert_array_equal(ds.get("y", step, low), run.values[step][run.values[step][:, 1] > 0.3, 2])
            self.assertEqual(len(ds.get("y", 0, mote.column("px") > 100)), 0)

    def test_what_limits_numbers_is_a_warning(self):
        run, ds = self.open()
        low = mote.column("px") > 0.3
        asked = {"statistics": lambda: ds.statistics(step=1, select=low), "get": lambda: ds.get("x", 1, low),
                 "histogram": lambda: ds.histogram("x", bins=9, step=1)}
        for what, ask in asked.items():
            run.lie = lambda message, payload: (message, payload)
            with self.subTest(what=what), warnings.catch_warnings():
                warnings.simplefilter("error")
                ask()

            def limited(message, payload):
                message.answer.notes.append("x is coarse\x1b[31m")
                return message, payload
            run.lie = limited
            with self.subTest(what=what), warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("default")
                found = ask()
            self.assertEqual({str(each.message) for each in caught}, {"x is coarse\\x1b[31m"})
            self.assertEqual({each.category for each in caught}, {mote.CoarseNumbers})
            self.assertEqual({each.filename for each in caught}, {__file__})
        self.assertEqual(found.notes, ["x is coarse\x1b[31m"])

    def test_histograms_are_numpy_s(self):
        run, ds = self.open()
        x, px, _ = run.values[1].T
        got, edges = ds.histogram("x", bins=20, range=(-1, 2), step=1)
        expected, at = np.histogram(x, 20, (-1, 2), weights=run.weights[1])
        np.testing.assert_allclose(got, expected, rtol=1e-15)
        np.testing.assert_array_equal(edges, at)
        result = ds.histogram("x", "px", bins=(8, 9), range=[(-1, 1), None], step=1, weighted=False)
        got, (first, second) = result
        expected, one, two = np.histogram2d(x, px, (8, 9), [(-1, 1), (-4, 4)])
        np.testing.assert_array_equal(got, expected)
        np.testing.assert_array_equal(first, one)
        np.testing.assert_array_equal(second, two)
        self.assertEqual(result.particles, 500)
        waterfall, edges = ds.histogram("x", bins=7)
        self.assertEqual(waterfall.shape, (3, 7))
        some, _ = ds.histogram("x", bins=7, step=slice(0, 3, 2))
        np.testing.assert_array_equal(some, waterfall[::2])

    def test_statistics_of_whole_steps_are_those_of_preparation(self):
        run, ds = self.open()
        every = ds.statistics()
        self.assertEqual(every["sigma_x"].tolist(), [0, 0.25, 0.5])
        self.assertEqual((every["n_particle"].dtype, every["time"].tolist()), (np.int64, [0, 0.5, 1]))
        self.assertEqual(ds.statistics(step=-1), {"step": 2, "iteration": 20, "time": 1.0, "n_particle": 500, "sigma_x": 0.5})
        self.assertEqual(set(ds.statistics(names=["sigma_x"])), {"step", "iteration", "time", "sigma_x"})
        self.assertEqual(run.queries, [], "nothing was asked for")
        with self.fails("invalid_argument", "names"):
            ds.statistics(names=["norm_emit_q"])

    def test_statistics_of_a_selection(self):
        run, ds = self.open()
        select = {"ranges": [{"column": "px", "max": 0.0}]}
        got = ds.statistics(select=select)
        for step in range(3):
            keep = run.values[step][:, 1] <= 0
            self.assertEqual(got["n_particle"][step], keep.sum())
            self.assertEqual(got["sigma_x"][step], run.values[step][keep, 0].std())
        empty = ds.statistics(step=1, select=mote.column("x") > 99)
        self.assertEqual(empty["n_particle"], 0)
        self.assertTrue(np.isnan(empty["sigma_x"]))

    def test_slices(self):
        run, ds = self.open()
        got = ds.statistics(step=2, slices=("y", 5))
        self.assertEqual(got["slice_edges"].tolist(), np.linspace(-4, 4, 6).tolist())
        self.assertEqual(got["slices"]["n_particle"].tolist(), [0, 1, 2, 3, 4])
        self.assertEqual(ds.statistics(slices="y")["slices"]["sigma_x"].shape, (3, 50))
        self.assertEqual(run.queries[0].statistics.slices, "y")

    def test_ways_through_the_steps(self):
        for piece in (1, 13, 1000):
            run, ds = self.open(particles=60, piece=piece)
            ids, path = ds.track((mote.column("x") > 0.5).at(2), ["x", "y"])
            expected = run.ids[2][run.values[2][:, 0] > 0.5]
            np.testing.assert_array_equal(ids, expected)
            self.assertEqual(path.shape, (3, len(expected), 2))
            for step in range(3):
                for row, identity in enumerate(expected):
                    where = np.flatnonzero(run.ids[step] == identity)
                    wanted = run.values[step][where[0], ::2] if len(where) else [np.nan, np.nan]
                    np.testing.assert_array_equal(path[step, row], wanted)
            ids, path = ds.track(mote.ids(run.ids[0][:3]), "px")
            self.assertEqual(path.shape, (3, 3, 1))
        with self.fails("invalid_argument", "select.step"):
            ds.track({"density": {"max": 0.3}}, ["x"])

    def test_wrong_arguments_are_not_sent(self):
        run, ds = self.open()
        for ask, where in ((lambda: ds.get("x", step=3), "step"), (lambda: ds.get("x", step=-4), "step"),
                           (lambda: ds.histogram("x", bins=(3, 4)), "bins"), (lambda: ds.histogram("x", "y", range=[(0, 1)]), "range"),
                           (lambda: ds.statistics(step=slice(5, 9)), "steps"),
                           (lambda: ds.get("x", select={"range": []}), "select"), (lambda: ds.figure(), "figure")):
            with self.fails("invalid_argument", where):
                ask()
        self.assertEqual(run.queries, [])


class Lies(WithRun):
    """What a server sends that cannot be."""

    def lie(self, change, **options):
        run, ds = self.open(**options)

        def lie(message, payload):
            return message, change(message.answer, payload) or payload
        run.lie = lie
        return ds

    def test_lies_about_columns(self):
        def more(answer, payload):
            answer.columns.count += 1

        def huge(answer, payload):
            answer.columns.count = 2**61

        def other(answer, payload):
            answer.columns.names[0] = "z"

        def never_on(answer, payload):
            answer.columns.next, answer.columns.end = 0, False

        def wrong_step(answer, payload):
            answer.step += 1

        for change in (more, huge, other, never_on, wrong_step, lambda a, p: p[:-8], lambda a, p: p[:-3], lambda a, p: p + b"a"):
            with self.subTest(change.__name__), self.fails("corrupt"):
                self.lie(change).get(["x", "y"])

    def test_lies_about_histograms_and_statistics(self):
        def no_bins(answer, payload):
            del answer.histogram.axes[:]

        def one_edge(answer, payload):
            del answer.histogram.axes[0].values[1:]

        def more_bins(answer, payload):
            answer.histogram.axes[0].values.append(9)

        for change in (no_bins, one_edge, more_bins, lambda a, p: p + bytes(8)):
            with self.fails("corrupt"):
                self.lie(change).histogram("x")

        def fewer(answer, payload):
            del answer.statistics.values[-1]

        def renamed(answer, payload):
            answer.statistics.names[0] = str(answer.step)

        def cut(answer, payload):
            if answer.statistics.slices:
                del answer.statistics.slices[0].values[0]

        for change, options in ((fewer, {}), (renamed, {}), (cut, {"slices": "y"})):
            with self.fails("corrupt"):
                self.lie(change).statistics(select={}, **options)

    def test_lies_about_ways(self):
        def other_ids(answer, payload):
            return (np.frombuffer(payload[:8], np.uint64) + np.uint64(answer.step)).tobytes() + payload[8:]

        def uneven(answer, payload):
            answer.columns.end = answer.step == 0

        for change in (other_ids, uneven):
            with self.fails("corrupt"):
                self.lie(change, piece=10**6).track((mote.column("x") > 0).at(0), ["x"])


class Arrays(WithRun):
    def test_columns_arrive_as_they_were(self):
        run, ds = self.open()
        numbers = np.random.default_rng(8)
        for count in (1, 1000, 200_000):  # the last of them in several pieces
            x = numbers.normal(size=count)
            job = ds.session.prepare_arrays(
                {"x": x, "px": x.astype(np.float32), "y": np.arange(count)[::-1], "weight": 2.5, "id": np.arange(count)},
                axes=["x", "px", "y"], output="data/mine.mote", mass=0.511e6, time=1e-9, volume_level=5)
            self.assertEqual(job.wait(progress=False).state, "succeeded")
            request = job.status.request
            got = run.arrays(request.particles.inputs[0].split("/")[1])
            np.testing.assert_array_equal(got["x"], x)
            np.testing.assert_array_equal(got["px"], x.astype(np.float32))
            np.testing.assert_array_equal(got["y"], np.arange(count)[::-1])
            np.testing.assert_array_equal(got["weight"], np.full(count, 2.5))
            self.assertEqual((got["id"].dtype, got["mass"].item(), got["time"].item()), (np.uint64, 0.511e6, 1e-9))
            self.assertEqual((list(request.particles.axes), request.output, request.particles.mass,
                              request.particles.volume_level), (["x", "px", "y"], "data/mine.mote", 0.511e6, 5))

    def test_several_steps_are_several_files(self):
        run, ds = self.open()
        steps = [{"x": np.full(3, i), "y": [1, 2, 3], "z": np.zeros(3)} for i in range(4)]
        job = ds.session.prepare_arrays(steps, ["x", "y", "z"], "data/a.mote", time=[0, 1, 2, 3], iteration=[5, 6, 7, 8])
        files = [name.split("/")[1] for name in job.wait(progress=False).status.request.particles.inputs]
        self.assertEqual([run.arrays(name)["x"][0] for name in files], [0, 1, 2, 3])
        self.assertEqual([run.arrays(name)["iteration"] for name in files], [5, 6, 7, 8])
        self.assertEqual(files, sorted(files))

    def test_what_is_wrong_is_said_and_not_sent(self):
        run, ds = self.open()
        good = {"x": [1.0, 2], "y": [1, 2], "z": [0, 0]}
        for arrays, where, words in (
                ({}, "arrays", "dict"), ([], "arrays", "no step"), ([good, 7], "arrays[1]", "dict"), ({"x": 1.0}, "arrays", "single"),
                ({**good, "x": [1.0, 2, 3]}, "arrays", "x 3, y 2, z 2"), ({**good, "x": [[1.0, 2]]}, "arrays['x']", "(1, 2)"),
                ({**good, "x": [1j, 2]}, "arrays['x']", "complex"), ({**good, "x": ["a", "b"]}, "arrays['x']", "<U1"),
                ({**good, "x": [None, 1]}, "arrays['x']", "object"), ({**good, "id": [1.5, 2]}, "arrays['id']", "float64"),
                ({**good, "id": [-1, 2]}, "arrays['id']", "from 0 on"), ({**good, "a/b": [1, 2]}, "arrays", "a/b"),
                ({**good, "time": [1, 2]}, "arrays", "time"), ([good, {"x": [1, 2]}], "arrays", "differ")):
            with self.subTest(words), self.fails("invalid_argument", where, words):
                ds.session.prepare_arrays(arrays, ["x", "y", "z"], "data/a.mote")
        for options, where in (({"mass": -1}, "mass"), ({"time": [1, 2]}, "time"), ({"time": np.nan}, "time"),
                               ({"iteration": "a"}, "iteration")):
            with self.fails("invalid_argument", where):
                ds.session.prepare_arrays(good, ["x", "y", "z"], "data/a.mote", **options)
        self.assertEqual(run.files, {})

    def test_nan_is_told(self):
        run, ds = self.open()
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            ds.session.prepare_arrays({"x": [1, np.nan, np.inf], "y": [0, 0, 0], "z": 1}, ["x", "y", "z"], "data/a.mote")
        self.assertIn("2 of x", str(told[0].message))
        self.assertEqual(told[0].filename, __file__)


if __name__ == "__main__":
    unittest.main()
