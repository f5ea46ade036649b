# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments that nobody expects: each is taken as it was meant or is an error that names it, never something else, and
what is refused is not sent."""
import decimal
import os
import tempfile
import unittest
import warnings

import numpy as np
from support import mote  # isort: skip
from mote import messages
from numbers_test import WithRun
from view_test import WithStudio

EMPTY = ([], (), np.array([]), np.array([], np.uint64))


class Refusals(WithRun):
    def refuse(self, cases):
        """Each of (call, where): an Error of an argument, and nothing was asked."""
        before = len(self.run_.queries)
        for index, (call, where) in enumerate(cases):
            with self.subTest(index=index, where=where), self.fails("invalid_argument", where):
                call()
        self.assertEqual(len(self.run_.queries), before)

    def setUp(self):
        self.run_, self.ds = self.open(steps=4, particles=50)


class Steps(Refusals):
    def test_numpy_s_numbers_and_lists_are_steps(self):
        x = [values[:, 0] for values in self.run_.values]
        for step in (2, -2, np.int64(2), np.uint8(2), np.array(2), np.int32(-2)):
            np.testing.assert_array_equal(self.ds.get("x", step), x[2])
            self.assertEqual(self.ds.statistics(step)["step"], 2)
            self.assertEqual(mote.View(self.ds, step).message.layers[0].step, 2)
        for steps, expected in ((slice(None), [0, 1, 2, 3]), (slice(-2, None), [2, 3]), (range(1, 4, 2), [1, 3]), ([0, 2], [0, 2]),
                                (np.arange(3), [0, 1, 2]), ([-1], [3]), ((1, 2, 3), [1, 2, 3]), (None, [0, 1, 2, 3])):
            for select in (None, {}):
                self.assertEqual(self.ds.statistics(steps, select)["step"].tolist(), expected)

    def test_one_step_is_not_several(self):
        for steps in (slice(0, 2), slice(1, 2), slice(None), range(2), [1], np.array([1]), None, (), iter([1])):
            self.refuse([(lambda: self.ds.get("x", step=steps), "step"), (lambda: mote.Layer(self.ds, steps), "step"),
                         (lambda: self.ds.view(steps), "step")])

    def test_what_is_no_step(self):
        for step in (True, False, np.bool_(True), 1.0, np.float64(1), "1", b"1", "first", 1j, 4, -5, {}, {1}, [True], [1.0],
                     [[1]], np.array([[1]]), np.nan, 2**70, object()):
            for ask in (self.ds.get, self.ds.histogram):
                self.refuse([(lambda: ask("x", step=step), "step")])
            self.refuse([(lambda: self.ds.statistics(step), "step"), (lambda: self.ds.export(step), "step")])
        for steps in (slice(3, 0, -1), slice(None, None, -1), range(3, -1, -1), [], (), range(0), slice(2, 2), [0, 1, 3], [2, 1],
                      [1, 1], range(-2, 0), range(2, 6), np.array([], int), slice("a", "b"), slice(0.5, 2)):
            self.refuse([(lambda: self.ds.statistics(steps), "steps"), (lambda: self.ds.histogram("x", step=steps), "steps"),
                         (lambda: self.ds.track({"ids": [1]}, "x", steps), "steps"), (lambda: self.ds.export(steps), "steps"),
                         (lambda: self.ds.figure("x", step=steps), "steps")])


class Names(Refusals):
    def test_one_name_is_not_its_letters(self):
        for select in (None, {}):
            self.assertEqual(set(self.ds.statistics(1, select, names="sigma_x")) & {"n_particle", "sigma_x"},
                             {"sigma_x"} if select is None else {"n_particle", "sigma_x"})
        self.assertEqual(list(self.run_.queries[-1].statistics.names), ["sigma_x"])
        ids, path = self.ds.track({"ids": [1, 2]}, "px")
        self.assertEqual(path.shape, (4, 2, 1))
        figure = self.ds.figure(statistics="sigma_x")
        self.assertEqual(figure._fields["statistics"], ["sigma_x"])
        job = self.ds.export(columns="px")
        self.assertEqual(list(job.status.request.export.columns), ["px"])

    def test_names_of_numpy_and_twice_the_same(self):
        x, again, px = self.ds.get(np.array(["x", "x", "px"]), 1)
        np.testing.assert_array_equal(x, again)
        np.testing.assert_array_equal(px, self.run_.values[1][:, 1])
        (y,) = self.ds.get((name for name in ["y"]))
        np.testing.assert_array_equal(y, self.run_.values[0][:, 2])
        self.assertEqual(set(self.ds.statistics(names=["sigma_x", "sigma_x"])), {"step", "iteration", "time", "sigma_x"})

    def test_what_is_no_name(self):
        for names in (None, 5, b"x", {"x", "px"}, {"x": 1}, ["x", 5], ["x", None], ["x", ""], "", [["x"]], [b"x"], np.array([1.0])):
            self.refuse([(lambda: self.ds.get(names), "columns"), (lambda: self.ds.track({"ids": [1]}, names), "columns")])
            if names is not None:
                self.refuse([(lambda: self.ds.statistics(names=names), "names"),
                             (lambda: self.ds.figure(statistics=names), "statistics"),
                             (lambda: self.ds.export(columns=names), "columns"),
                             (lambda: self.ds.session.prepare("a/b", axes=names, output="a/c.mote"), "axes")])
            if names not in ("x", None):
                self.refuse([(lambda: self.ds.histogram(names), "columns"), (lambda: self.ds.figure(names), "columns")])
        self.refuse([(lambda: self.ds.session.prepare("a/b", axes="xyz", output="a/c.mote"), "axes")])

    def test_no_names_are_not_all(self):
        for names in EMPTY:
            self.refuse([(lambda: self.ds.get(names), "columns"), (lambda: self.ds.statistics(names=names), "names"),
                         (lambda: self.ds.statistics(select={}, names=names), "names"),
                         (lambda: self.ds.export(columns=names), "columns"),
                         (lambda: self.ds.figure(statistics=names), "statistics"),
                         (lambda: self.ds.session.prepare(names, output="a/b.mote"), "input")])
        ids, path = self.ds.track({"ids": [1, 2]}, [])
        self.assertEqual((ids.tolist(), path.shape), ([1, 2], (4, 2, 0)))

    def test_ids_are_no_numbers_of_a_path(self):
        self.refuse([(lambda: self.ds.track({"ids": [1]}, ["x", "id"]), "columns")])


class Numbers(Refusals):
    def test_bins(self):
        for bins in (np.int64(7), np.array(7), [7], (np.uint16(7),), np.array([7])):
            self.assertEqual(self.ds.histogram("x", bins=bins, step=0)[0].shape, (7,))
        self.assertEqual(self.ds.histogram("x", "y", bins=np.array([3, 4]), step=0)[0].shape, (3, 4))
        for bins in (True, 7.0, "7", "auto", b"7", [1.0], ["7"], [], [1, 2, 3], np.linspace(0, 1, 5), {7}, {"x": 7}, 7j,
                     np.array([[7]])):
            self.refuse([(lambda: self.ds.histogram("x", bins=bins), "bins"), (lambda: self.ds.figure("x", bins=bins), "bins")])
        self.refuse([(lambda: self.ds.histogram("x", "y", bins="12"), "bins")])

    def test_ranges(self):
        for limits in ((-1, 2), [-1.0, np.float32(2)], np.array([-1, 2])):
            np.testing.assert_array_equal(self.ds.histogram("x", bins=3, range=limits, step=0)[1], [-1, 0, 1, 2])
        for limits in ((), [], (1,), (1, 2, 3), (2, 1), (1, 1), (0, np.nan), (0, np.inf), "01", 5, {1, 2}, (1, "2"), ((0, 1),),
                       np.array([]), (None, 1), (1j, 2)):
            self.refuse([(lambda: self.ds.histogram("x", range=limits), "range")])
        for limits in ((0, 1), [(0, 1)], [(0, 1), ()], [(0, 1), (1, 0)], "01", [None, None, None]):
            self.refuse([(lambda: self.ds.histogram("x", "y", range=limits), "range")])

    def test_slices(self):
        for slices in ("y", ("y",), ["y", None]):
            self.assertEqual(self.ds.statistics(0, slices=slices)["slices"]["sigma_x"].shape, (50,))
        self.assertEqual(self.ds.statistics(0, slices=("y", np.int64(5)))["slices"]["sigma_x"].shape, (5,))
        for slices in ("", (), ("y", 5, 6), (5, "y"), ("y", "5"), ("y", True), ("y", 5.5), 5, {"y": 5}, [None, 5], ("", 5)):
            self.refuse([(lambda: self.ds.statistics(slices=slices), "slices")])

    def test_switches(self):
        self.assertEqual(self.ds.histogram("x", weighted=np.bool_(False), step=0)[0].sum(), 50)
        for switch in ("no", 0, 1, None, [], np.array([True])):
            self.refuse([(lambda: self.ds.histogram("x", weighted=switch), "weighted"),
                         (lambda: self.ds.session.submit({}, again=switch), "again")])
        for limit in ("5", 1.5, -1, True, 2**31):
            self.refuse([(lambda: self.ds.session.submit({}, time_limit=limit), "time_limit")])

    def test_a_figure_drops_nothing(self):
        for options in ({"y": "x"}, {"bins": 5}, {"range": (0, 1)}, {"weighted": False}):
            self.refuse([(lambda: self.ds.figure(statistics="sigma_x", **options), "figure")])
        self.refuse([(lambda: self.ds.figure(y="x"), "figure"), (lambda: self.ds.figure("x", format="svg"), "format"),
                     (lambda: self.ds.figure("x", histogram={}), "histogram")])

    def test_a_pick_is_of_a_view(self):
        self.refuse([(lambda: self.ds.pick({}, 1, 2), "view"), (lambda: self.ds.pick(None, 1, 2), "view"),
                     (lambda: self.ds.pick(mote.View(self.ds), "1", 2), "pick.x"),
                     (lambda: self.ds.pick(mote.View(self.ds), 1, np.nan), "pick.y"),
                     (lambda: self.ds.pick(mote.View(self.ds), [1], 2), "pick.x")])


class Selected(Refusals):
    def test_no_ids_are_no_particles(self):
        for empty in (*EMPTY, set(), range(0), iter(())):
            none = mote.ids(empty)
            self.assertEqual(messages.to_dict(messages.to_message("Selection", none)), {"nothing": True})
            self.assertEqual(len(self.ds.get("x", 0, none)), 0)
            self.assertEqual(self.ds.statistics(0, none)["n_particle"], 0)
            self.assertEqual(self.ds.histogram("x", step=0, select=none)[0].sum(), 0)
            ids, path = self.ds.track(none, ["x", "px"])
            self.assertEqual((len(ids), path.shape), (0, (4, 0, 2)))

    def test_a_list_that_is_there_and_empty_selects_nothing(self):
        for name in ("ids", "ranges", "any", "all"):
            for empty in ([], (), np.array([])):
                message = messages.to_message("Selection", {"step": 1, name: empty})
                self.assertTrue(message.nothing, name)
            for others in ({"nothing": False, name: []}, {name: [], "nothing": False}):
                self.assertTrue(messages.to_message("Selection", others).nothing, name)
            self.assertFalse(messages.to_message("Selection", {name: None}).nothing, name)
        self.assertFalse(messages.to_message("Selection", {}).nothing)
        inner = messages.to_message("Selection", {"not": {"any": [{"ids": []}, {"ids": [1]}]}})
        self.assertFalse(inner.nothing)
        self.assertEqual([part.nothing for part in inner.negated.any], [True, False])
        layer = mote.View(self.ds, select={"any": []}, highlight=mote.ids([]), selections={"none": {"ranges": []}}).to_dict()
        self.assertEqual(layer["layers"][0]["select"], {"nothing": True})
        self.assertEqual(layer["layers"][0]["highlight"]["selection"], {"nothing": True})
        self.assertEqual(layer["selections"][0]["selection"], {"nothing": True})
        self.assertEqual(self.ds.session.view(layer).to_dict(), layer)
        self.assertTrue(self.ds.export(select=mote.ids([])).status.request.export.select.nothing)

    def test_operators_keep_what_is_empty(self):
        def plain(selection):
            return messages.to_dict(messages.to_message("Selection", selection))

        x, none = mote.column("x") > 1, mote.Selection({"all": []})
        for both in (x & none, none & x, {"all": []} & x):
            self.assertIn({"nothing": True}, plain(both)["all"])
        self.assertEqual(len(plain(x & none)["all"]), 2)
        self.assertEqual(plain(mote.Selection({"any": []}) | {"any": []}), {"any": [{"nothing": True}, {"nothing": True}]})
        self.assertEqual(plain(~mote.ids([])), {"not": {"nothing": True}})
        self.assertEqual(plain(mote.ids([]).at(2)), {"nothing": True, "step": 2})

    def test_ids_are_taken_when_they_are_given(self):
        numbers = np.array([3, 1], np.uint64)
        for values in (numbers, [3, 1], (3, 1), iter([3, 1]), {1, 3}, range(1, 4, 2), np.array([3.0, 1.0])):
            chosen = mote.ids(values)
            for _ in range(2):  # what gives its items once is not empty the second time
                self.assertEqual(sorted(messages.to_message("Selection", chosen).ids), [1, 3])
        chosen = mote.ids(numbers)
        numbers[0] = 7
        self.assertEqual(list(messages.to_message("Selection", chosen).ids), [3, 1])
        self.refuse([(lambda: self.ds.get("x", 0, {"ids": iter([1])}), "select.ids")])

    def test_what_is_no_selection(self):
        for select in ([], [1, 2], "x", 5, True, np.ones(50, bool), mote.column("x"), ()):
            self.refuse([(lambda: self.ds.get("x", 0, select), "select"), (lambda: self.ds.statistics(0, select), "select"),
                         (lambda: self.ds.track(select, "x"), "select"), (lambda: mote.View(self.ds, select=select), None)])
        self.refuse([(lambda: self.ds.track(None, "x"), "select")])
        for ids in (5, "12", b"12", {"a": 1}, None, 1.5):
            self.refuse([(lambda: mote.ids(ids), "ids")])
        for ids in ([-1], [1.5], ["1"], [None], [True], [2**64], [float(2**53)], [[1]], np.ma.array([1, 2], mask=[0, 1])):
            self.refuse([(lambda: self.ds.get("x", 0, mote.ids(ids)), None)])
        for step in (-1, 1.5, "1", True, slice(1)):
            self.refuse([(lambda: self.ds.get("x", 0, mote.ids([1]).at(step)), "select.step")])

    def test_bounds(self):
        x = mote.column("x")
        self.assertEqual((x == 3).to_dict(), {"ranges": [{"column": "x", "min": 3.0, "max": 3.0}]})
        self.assertEqual((x != 3).to_dict(), {"not": (x == 3).to_dict()})
        for number in (1e-3, np.float64(1e-3), np.array(1e-3), decimal.Decimal("1e-3")):
            self.assertEqual((x >= number).to_dict(), (x >= 1e-3).to_dict())
        self.assertEqual((np.float64(1) <= x).to_dict(), (x >= 1).to_dict())
        self.assertEqual((np.float32(1) > x).to_dict(), (x < 1).to_dict())
        for bound in ("1", None, [1], np.array([1.0, 2.0]), np.array([1.0]), True, np.nan, 1j, x, 2**53 + 1, b"1", np.ma.masked,
                      np.datetime64("2020")):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # numpy's, of what is masked
                self.refuse([(lambda: x >= bound, "x.min"), (lambda: x < bound, "x.max"), (lambda: x == bound, "x.min"),
                             (lambda: x.between(0, bound), "x.max")])
        for name in (None, "", 5, ["x"]):
            self.refuse([(lambda: mote.column(name), "column")])
        with self.assertRaises(TypeError):
            np.array([1.0, 2.0]) & (x > 1)

    def test_shapes(self):
        corners = [[0, 0], [1, 0], [0, 1]]
        for points in (corners, np.array(corners), iter(corners), np.array(corners, np.float32)):
            chosen = mote.polygon(("x", "px"), points)
            self.assertEqual(len(messages.to_message("Selection", chosen).polygon.points), 3)
            self.assertEqual(len(messages.to_message("Selection", chosen).polygon.points), 3)
        eye = {"eye": [0, 0, 1]}
        for transform in (np.eye(4), np.eye(4).tolist(), np.eye(4).reshape(-1), list(range(16))):
            lasso = messages.to_message("Selection", mote.lasso(eye, 1.5, corners, transform)).lasso
            self.assertEqual(len(lasso.transform), 16)
            self.assertEqual(len(mote.View(self.ds, transform=transform).message.layers[0].transform), 16)
        for transform in ([], np.eye(3), [1] * 15, "a" * 16, 5, [[1, 2], [3, 4], [5, 6], [7, 8]]):
            self.refuse([(lambda: mote.lasso(eye, 1.5, corners, transform), "transform"),
                         (lambda: mote.View(self.ds, transform=transform), "transform")])
        self.refuse([(lambda: mote.polygon("xy", corners), "columns"), (lambda: mote.polygon({"x", "y"}, corners), "columns"),
                     (lambda: mote.polygon(("x", "y"), "012"), "points")])
        masked = np.ma.array(corners, mask=[[0, 0], [0, 1], [0, 0]])
        self.refuse([(lambda: self.ds.get("x", 0, mote.polygon(("x", "y"), masked)), "select.polygon.points[1][1]")])


class Looks(WithStudio):
    def refuse(self, call, where):
        with self.subTest(where), self.fails("invalid_argument", where):
            call()

    def test_what_a_view_cannot_do(self):
        for options, where in (
                ({"size": 5}, "size"), ({"size": "12"}, "size"), ({"size": (1, 2, 3)}, "size"), ({"size": (1.5, 2)}, "width"),
                ({"style": []}, "layers[0].particles"), ({"style": False}, "layers[0].particles"), ({"kind": "step"}, "kind"),
                ({"kind": ""}, "kind"), ({"selections": [1]}, "selections"), ({"color_by": ("x", ())}, "color_by"),
                ({"color_by": ("x",)}, "layers[0].colorBy"), ({"color_by": {"column": "x", "colorMap": "a", "color_map": "b"}},
                                                             "layers[0].colorBy.color_map"),
                ({"towards": 5}, "towards"), ({"towards": (1,)}, "towards"), ({"towards": (99, 0.5)}, "towards.step"),
                ({"towards": {"steps": 1}}, "layers[0].towards"),
                ({"paths": 5}, "paths"), ({"paths": "12"}, "paths"), ({"opacity": "1"}, "layers[0].opacity"),
                ({"opacity": np.array([0.5])}, "layers[0].opacity"), ({"background": "red"}, "background"),
                ({"background": {0, 1, 2}}, "background"), ({"camera": [1]}, "camera"), ({"annotations": 1}, "annotations")):
            self.refuse(lambda: mote.View(self.ds, **options), where)
        view = mote.View(self.ds, size=(8, 8))
        self.refuse(lambda: view.replace(step=-1), "layers[0].step")
        self.refuse(lambda: view.replace(step=slice(2)), "layers[0].step")
        self.refuse(lambda: view.replace(size="88"), "size")
        self.refuse(lambda: view.replace(color_by="x"), "")
        self.refuse(lambda: view.render(linear="no"), "linear")
        self.refuse(lambda: mote.Script([view, 5]), "views[1]")
        for wrong in ("data/beam", None, 5):
            with self.assertRaises(TypeError):
                mote.Layer(wrong)

    def test_a_layer_can_be_used_twice(self):
        layer = mote.Layer(self.ds, paths=iter([4, 2]), select=mote.ids(iter([1])))
        for _ in range(2):
            shown = mote.View(layer).message.layers[0]
            self.assertEqual((list(shown.paths.ids), list(shown.select.ids)), ([4, 2], [1]))

    def test_a_layer_is_on_its_way_to_another_step(self):
        for towards in ((-1, 0.25), {"step": len(self.ds) - 1, "share": 0.25}):
            shown = mote.View(self.ds, towards=towards).message.layers[0]
            self.assertEqual((shown.towards.step, shown.towards.share), (len(self.ds) - 1, 0.25))
        self.assertFalse(mote.View(self.ds).message.layers[0].HasField("towards"))
        self.assertFalse(mote.View(self.ds, towards=(1, 0.5)).replace(step=1).message.layers[0].HasField("towards"))

    def test_a_view_is_of_one_session(self):
        other = mote.connect(self.server.file)
        self.addCleanup(other.close)
        self.refuse(lambda: mote.View([mote.Layer(self.ds), mote.Layer(other["data/beam"])]), "layers")

    def test_replaced_fields_are_taken_as_they_are_given(self):
        view = mote.View(self.ds, size=(8, 8)).replace(selections={"a": mote.ids([])}, layers=[mote.Layer(self.ds, 3)])
        self.assertEqual((view.message.layers[0].step, view.message.selections[0].selection.nothing), (3, True))

    def test_a_file_has_the_options_of_its_kind(self):
        view = mote.View(self.ds, size=(8, 8))
        with tempfile.TemporaryDirectory() as folder:
            self.refuse(lambda: view.save(os.path.join(folder, "a.png"), width=100), "width")
            self.refuse(lambda: view.save(os.path.join(folder, "a.svg"), quality=5), "quality")
            self.assertEqual(os.listdir(folder), [])


class Arrays(Refusals):
    good = {"x": [1.0, 2, 3], "y": [1, 2, 3], "z": [0, 0, 0]}

    def prepare(self, arrays, **options):
        return self.ds.session.prepare_arrays(arrays, options.pop("axes", ["x", "y", "z"]), "data/a.mote", **options)

    def test_columns_that_the_job_would_pass_by(self):
        for name in ("file", "energy", "zeta", "time", "iteration", "mass", "", 5, "x y", "arr_0", "a/b", "a [m] b"):
            self.refuse([(lambda: self.prepare({**self.good, name: [1, 2, 3]}), "arrays")])
        for one, two in (("x", "X"), ("weight", "w"), ("id", "particle_id"), ("px", "momentum_x")):
            self.refuse([(lambda: self.prepare({**self.good, one: [1, 2, 3], two: [1, 2, 3]}), "arrays")])
        self.assertEqual(self.run_.files, {})

    def test_all_columns_that_are_promised_are_sent(self):
        job = self.prepare({**self.good, "px": 1, "py": 2, "pz": 3, "t": 4, "charge": 1e-12, "status": [1, 1, 0],
                            "id": np.array([3, 2**64 - 1, 5], np.uint64)})
        got = self.run_.arrays(job.status.request.particles.inputs[0].split("/")[1])
        self.assertEqual(set(got) - {"iteration"}, {"x", "y", "z", "px", "py", "pz", "t", "charge", "status", "id"})
        self.assertEqual(got["id"].tolist(), [3, 2**64 - 1, 5])

    def test_records_are_sent_and_kept(self):
        job = self.prepare({**self.good, "charge": 1e-12, "spin [hbar]": [0.5, -0.5, 0.5], "turn": 7})
        got = self.run_.arrays(job.status.request.particles.inputs[0].split("/")[1])
        self.assertEqual(got["spin [hbar]"].tolist(), [0.5, -0.5, 0.5])
        self.assertEqual(list(job.status.request.particles.columns), ["x", "y", "z", "weight", "spin", "turn"])
        job = self.prepare({**self.good, "turn": 7}, columns=["x", "turn"])
        self.assertEqual(list(job.status.request.particles.columns), ["x", "turn"])

    def test_derived_names_are_those_of_the_table(self):
        import pathlib
        import re

        from mote.arrays import _DERIVED

        table = pathlib.Path(__file__).parents[2] / "protocol" / "quantity" / "known_quantity.cpp"
        names = re.findall(r'^        \{"(\w+)",', table.read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(names[8:], list(_DERIVED))

    def test_what_is_masked_is_missing(self):
        x = np.ma.array([1, 2, 3], mask=[0, 1, 0])
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            job = self.prepare({**self.good, "x": x})
        self.assertIn("1 of x", str(told[0].message))
        got = self.run_.arrays(job.status.request.particles.inputs[0].split("/")[1])
        np.testing.assert_array_equal(got["x"], [1, np.nan, 3])
        self.prepare({**self.good, "x": np.ma.array([1, 2, 3])})
        for name in ("id", "status", "alive"):
            self.refuse([(lambda: self.prepare({**self.good, name: x}), f"arrays['{name}']")])
        self.refuse([(lambda: self.prepare(self.good, time=np.ma.array([1.0], mask=[True])), "time")])

    def test_what_cannot_be_a_column(self):
        for values in ("123", [1, 2, "3"], [[1], [2], [3]], [[1, 2], [3]], [1, 2, None], np.array([1, 2, 3j]), [{}, {}, {}],
                       np.array(["2020", "2021", "2022"], "datetime64[Y]"), b"123", {1, 2, 3}, object()):
            self.refuse([(lambda: self.prepare({**self.good, "x": values}), "arrays['x']")])
        for ids in (5, [1.0, 2, 3], [True, False, True], [-1, 2, 3], ["1", "2", "3"]):
            self.refuse([(lambda: self.prepare({**self.good, "id": ids}), "arrays['id']")])
        self.refuse([(lambda: self.prepare(np.zeros((3, 3))), "arrays"), (lambda: self.prepare("xyz"), None),
                     (lambda: self.prepare(iter([self.good])), "arrays"), (lambda: self.prepare(None), "arrays")])

    def test_what_else_is_said(self):
        for options, where in (({"mass": True}, "mass"), ({"mass": "1"}, "mass"), ({"mass": np.nan}, "mass"), ({"mass": 0}, "mass"),
                               ({"iteration": 1.5}, "iteration"), ({"iteration": 2**60}, "iteration"), ({"iteration": True}, "iteration"),
                               ({"time": "1"}, "time"), ({"time": [[1.0]]}, "time"), ({"axes": "xyz"}, "axes"),
                               ({"axes": {"x", "y", "z"}}, "axes"), ({"axes": None}, "axes"), ({"axes": []}, "axes"),
                               ({"inputs": ["a"]}, "inputs"), ({"volume_levels": 5}, "particles"), ({"kind": "mesh"}, "particles")):
            self.refuse([(lambda: self.prepare(self.good, **options), where)])
        self.assertEqual(self.run_.files, {}, "nothing is uploaded for a job that cannot be")
        job = self.prepare(self.good, mass=np.float32(2), time=np.float64(3), iteration=np.int64(4))
        self.assertEqual(job.status.request.particles.mass, 2)
        self.refuse([(lambda: self.ds.session.prepare("a/b", output="a/c.mote", inputs=["x"]), "inputs")])
        for frame in (-1, "1", 1.5, True):
            self.refuse([(lambda: job.save("/nowhere/film", frame), "frame")])


if __name__ == "__main__":
    unittest.main()
