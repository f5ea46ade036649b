# SPDX-License-Identifier: GPL-3.0-or-later
"""Quantities, records and expressions over them, wherever one may stand, with numpy as the judge."""
import json
import pathlib
import random
import subprocess
import tempfile
import unittest
import warnings

import numpy as np

from support import BIN, Case, mote, needs_server, prepare, spawn  # isort: skip

MASS = 510998.95
COUNT = 20000


def arrays(step):
    """A bunch in the laboratory's frame, 2 m a step, with particles at the edges of every formula."""
    rng = np.random.default_rng(step)
    c = {name: rng.normal(0.0, scale, COUNT) for name, scale in
         (("x", 1e-3), ("y", 2e-3), ("z", 1e-4), ("px", 1e4), ("py", 2e4), ("pz", 1e5), ("spin", 0.5))}
    c["z"] += 2.0 * step
    c["pz"] += 5e6
    c["t"] = 6.7e-9 * step + rng.normal(0.0, 1e-13, COUNT)
    c["weight"] = rng.uniform(0.5, 1.5, COUNT)
    for name in ("px", "py", "pz"):
        c[name][:4] = 0.0                                # no momentum
        c[name][4:8] = rng.normal(0.0, 1e-3, 4)          # gamma as near to 1 as can be
    c["pz"][8:12] *= -1.0                                # backwards
    c["x"][12:16] = c["y"][12:16] = 0.0                  # on the axis
    c["weight"][16:20] = 0.0
    return {**c, "turn [1]": np.arange(COUNT) % 7, "id": np.arange(1, COUNT + 1)}


def kinetic(p):
    return p * (p / (np.hypot(p, MASS) + MASS))


def derived(c, mean):
    """docs/NUMBERS.md, by numpy."""
    p = np.sqrt(c["px"] ** 2 + c["py"] ** 2 + c["pz"] ** 2)
    r = np.hypot(c["x"], c["y"])
    with np.errstate(all="ignore"):
        return {"r": r, "theta": np.arctan2(c["y"], c["x"]), "xp": c["px"] / c["pz"], "yp": c["py"] / c["pz"],
                "pr": np.where(r > 0, (c["x"] * c["px"] + c["y"] * c["py"]) / r, np.hypot(c["px"], c["py"])),
                "p": p, "delta": p / mean["p"] - 1, "gamma": np.sqrt(1 + (p / MASS) ** 2), "energy": kinetic(p),
                "zeta": c["z"] - mean["z"], "tau": c["t"] - mean["t"],
                **{f"{name}_c": c[name] - mean[name] for name in ("x", "y", "px", "py", "pz")}}


class Writer:
    """Random expressions, as ours and as numpy's."""

    ONE = {"abs": "np.abs", "sqrt": "np.sqrt", "exp": "np.exp", "log": "np.log", "log10": "np.log10", "sin": "np.sin",
           "cos": "np.cos", "tan": "np.tan", "asin": "np.arcsin", "acos": "np.arccos", "atan": "np.arctan",
           "sinh": "np.sinh", "cosh": "np.cosh", "tanh": "np.tanh", "floor": "np.floor", "ceil": "np.ceil",
           "round": "np.round", "sign": "np.sign"}
    TWO = {"hypot": "np.hypot", "atan2": "np.arctan2", "min": "np.minimum", "max": "np.maximum"}
    NAMES = ("x", "y", "z", "px", "spin", "r", "energy", "zeta", "delta", "turn")

    def __init__(self, seed):
        self.random = random.Random(seed)

    def both(self, depth):
        pick = self.random.choice
        if depth == 0:
            if self.random.random() < 0.7:
                name = pick(self.NAMES)
                return name, f"v[{name!r}]"
            number = pick(("2", "0.5", "1e-3", "3.25", "1e3", "pi"))
            return number, "np.pi" if number == "pi" else number
        kind = self.random.randrange(7)
        a, pa = self.both(depth - 1)
        b, pb = self.both(self.random.randrange(depth))
        if kind < 2:
            sign = pick("+-*/%")
            return f"({a} {sign} {b})", f"{'np.mod' if sign == '%' else ''}({pa} {',' if sign == '%' else sign} {pb})"
        if kind == 2:
            name = pick(tuple(self.ONE))
            return f"{name}({a})", f"{self.ONE[name]}({pa})"
        if kind == 3:
            name = pick(tuple(self.TWO))
            return f"{name}({a}, {b})", f"{self.TWO[name]}({pa}, {pb})"
        if kind == 4:
            sign = pick(("<", "<=", ">", ">=", "==", "!="))
            return f"where({a} {sign} {b}, {a}, -{b})", f"np.where({pa} {sign} {pb}, {pa}, -({pb}))"
        if kind == 5:
            return f"(-{a}^2)", f"(-({pa})**2)"
        return (f"({a} > 0 and not {b} > 1 or {a} < -1)",
                f"(1.0*(((np.asarray({pa}) > 0) & ~(np.asarray({pb}) > 1)) | (np.asarray({pa}) < -1)))")


@needs_server
class Quantities(Case):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.session = spawn(pathlib.Path(cls.folder.name), device="cpu")
        cls.addClassCleanup(cls.session.close)
        cls.steps = [arrays(step) for step in range(3)]
        cls.session.prepare_arrays(cls.steps, axes=["zeta", "hypot(x, y)*1e3", "pz"], output="data/bunch.mote",
                                   mass=MASS).wait()
        cls.ds = cls.session["data/bunch"]
        cls.columns = dict(zip(cls.ds.columns, cls.ds.get(list(cls.ds.columns), step=2)))
        cls.mean = {name[5:]: value for name, value in cls.ds.statistics(step=2).items() if name.startswith("mean_")}
        cls.values = {**cls.columns, **derived(cls.columns, cls.mean)}

    def test_records_are_kept_under_their_names(self):
        self.assertEqual(set(self.ds.columns), {"x", "y", "z", "t", "px", "py", "pz", "weight", "spin", "turn", "id"})
        self.assertEqual(self.ds.units["turn"], "1")
        order = np.argsort(self.columns["id"])
        np.testing.assert_array_equal(self.columns["turn"][order], np.arange(COUNT) % 7)
        np.testing.assert_allclose(self.columns["spin"][order], self.steps[2]["spin"], rtol=1e-6)

    def test_means_are_those_of_the_particles(self):
        for name in ("x", "y", "z", "t", "px", "py", "pz"):
            exact = np.average(self.steps[2][name].astype(np.longdouble), weights=self.steps[2]["weight"])
            self.assertAlmostEqual(self.mean[name], float(exact), delta=1e-9 * np.std(self.steps[2][name]))

    def test_every_quantity_is_numpy_s(self):
        expected = derived(self.columns, self.mean)
        found = self.ds.get(list(expected), step=2)
        for (name, values), own in zip(expected.items(), found):
            # A difference is as exact as what it is a difference of.
            near = 1e-15 * np.abs(self.columns.get(name[:-2], self.columns["z"])) if name.endswith("_c") else 1e-15
            np.testing.assert_allclose(own, values, rtol=4e-15, atol=np.max(near) if name != "tau" else 1e-22, err_msg=name)
        slow = expected["p"] < 1.0
        np.testing.assert_allclose(found[list(expected).index("energy")][slow], expected["p"][slow] ** 2 / (2 * MASS), rtol=1e-9)

    def test_random_expressions_are_numpy_s(self):
        write = Writer(5)
        pairs = [write.both(1 + i % 4) for i in range(600)]
        pairs = [pair for pair in pairs if len(pair[0]) < 500 and any(name in pair[0] for name in Writer.NAMES)]
        pairs = [pair for pair in pairs if "v[" in pair[1]]
        self.assertGreater(len(pairs), 450)
        nearly = {name: values * (1 + 3e-15) for name, values in self.values.items()}
        compared = 0.0
        for begin in range(0, len(pairs), 32):
            part = pairs[begin:begin + 32]
            found = self.ds.get([ours for ours, _ in part], step=2)
            for (ours, theirs), own in zip(part, found):
                expected, shifted = (self.numpy_s(theirs, values) for values in (self.values, nearly))
                # Where rounding decides (a cosine of 1e13, a wrap, a step) numpy itself says otherwise for its neighbour.
                steady = np.isclose(expected, shifted, rtol=1e-8, atol=1e-13, equal_nan=True)
                same = np.isclose(own, expected, rtol=1e-6, atol=1e-11, equal_nan=True)
                self.assertGreater(np.mean(same[steady]) if steady.any() else 1.0, 0.999, ours)
                compared += steady.mean()
        self.assertGreater(compared / len(pairs), 0.8)

    @staticmethod
    def numpy_s(formula, values):
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return np.broadcast_to(eval(formula, {"np": np, "v": values}), (COUNT,)).astype(float)

    def test_wherever_a_quantity_may_stand(self):
        v, w = self.values, self.columns["weight"]
        r = np.hypot(v["x"], v["y"])
        select = {"ranges": [{"column": "hypot(x,y)", "max": 1e-3}, {"column": "zeta", "min": 0}]}
        inside = (r <= 1e-3) & (v["zeta"] >= 0)
        np.testing.assert_array_equal(self.ds.get("id", step=2, select=select), self.columns["id"][inside])
        polygon = {"polygon": {"columns": ["zeta*1e3", "spin"], "points": [[0, 0], [1, 0], [0, 1]]}}
        np.testing.assert_array_equal(
            self.ds.get("id", step=2, select=polygon),
            self.columns["id"][(v["zeta"] * 1e3 >= 0) & (v["spin"] >= 0) & (v["zeta"] * 1e3 + v["spin"] < 1)])
        h, edges = self.ds.histogram("energy*1e-6", "x_c", bins=(20, 30), step=2)
        np.testing.assert_allclose(h, np.histogram2d(v["energy"] * 1e-6, v["x_c"], bins=edges, weights=w)[0], rtol=1e-12)
        statistics = self.ds.statistics(step=2, select=select,
                                        names=["mean_hypot(x,y)", "sigma_spin", "min_zeta", "max_turn*2", "cov_spin__zeta", "mean_x"])
        average = lambda q: np.average(q[inside], weights=w[inside])
        self.assertAlmostEqual(statistics["mean_hypot(x,y)"] / average(r), 1.0, delta=1e-12)
        self.assertAlmostEqual(statistics["sigma_spin"] ** 2 / average((v["spin"] - average(v["spin"])) ** 2), 1.0, delta=1e-12)
        self.assertEqual((statistics["min_zeta"], statistics["max_turn*2"]), (v["zeta"][inside].min(), 12.0))
        covariance = average((v["spin"] - average(v["spin"])) * (v["zeta"] - average(v["zeta"])))
        self.assertAlmostEqual(statistics["cov_spin__zeta"] / covariance, 1.0, delta=1e-9)
        whole = self.ds.statistics(step=2, names=["mean_x", "mean_spin"])
        self.assertEqual(whole["mean_x"], self.mean["x"])
        self.assertAlmostEqual(whole["mean_spin"], np.average(v["spin"], weights=w), delta=1e-12)
        slices = self.ds.statistics(step=2, slices=("zeta", 5), names=["n_particle", "mean_spin"])
        number = np.histogram(v["zeta"], bins=slices["slice_edges"])[0]
        np.testing.assert_array_equal(slices["slices"]["n_particle"], number)
        ids, path = self.ds.track(select={"ids": [100, 200]}, columns=["zeta", "px/pz"])
        own = [np.flatnonzero(self.columns["id"] == one)[0] for one in ids]
        np.testing.assert_array_equal(path[2], np.stack([v["zeta"][own], (v["px"] / v["pz"])[own]], axis=1))
        image = mote.View(self.ds, step=2, size=(96, 64), color_by="abs(spin)", annotations=True).render()
        self.assertGreater(image.array[..., :3].max(), 0)
        self.assertIn("<svg", self.ds.figure("zeta*1e3", "spin", step=2).svg)
        self.assertIn("<svg", self.ds.figure(statistics=["sigma_zeta", "mean_spin"]).svg)

    def test_a_plot_has_its_axes(self):
        self.assertEqual(self.ds.axes, ("zeta", "hypot(x, y)*1e3", "pz"))
        self.assertEqual(self.ds.units["zeta"], "m")
        low, high = self.ds.bounds["hypot(x, y)*1e3"]
        every = np.concatenate([np.hypot(step["x"], step["y"]) * 1e3 for step in self.steps])
        np.testing.assert_allclose([low, high], [every.min(), every.max()], rtol=1e-12)
        # A bunch that goes 2 m a step fills its axis in each.
        low, high = self.ds.bounds["zeta"]
        for step in range(3):
            zeta = self.ds.get("zeta", step=step)
            self.assertGreater(np.std(zeta) / (high - low), 0.03)

    def test_a_run_in_the_laboratory_fills_its_axes_in_each_step(self):
        """2 m a step, sigma_z 0.1 mm: over all steps the bunch is a hundred-thousandth of the axis."""
        folder = pathlib.Path(self.folder.name)
        steps = [{name: arrays(step)[name][20:] for name in ("x", "y", "z", "px", "py", "pz")} for step in range(6)]
        self.session.prepare_arrays(steps, axes=["z", "pz", "x"], output="data/run.mote", mass=MASS).wait()
        prepare("particles", folder / "run.mote", "--axes", "z,pz,x", "--bounds-of", "step", "--out", folder / "steps.mote")
        prepare("particles", folder / "run.mote", "--axes", "zeta,x,y", "--out", folder / "zeta.mote")
        of_step = [{"name": axis, "unit": "step"} for axis in ("z", "pz", "x")]  # as requests said before bounds_of
        self.session.prepare("data/run.mote", axes=["z", "pz", "x"], output="data/before.mote", bounds=of_step).wait()
        for step in range(6):
            self.assertEqual(self.session["data/before"].bounds_of(step), self.session["data/steps"].bounds_of(step))

        def shares(name, step, of_step):
            """The rms width of the bunch in parts of each axis."""
            ds = self.session[f"data/{name}"]
            bounds = ds.bounds_of(step) if of_step else ds.bounds
            return [np.std(ds.get(axis, step=step)) / (bounds[axis][1] - bounds[axis][0]) for axis in ds.axes]

        for step in range(6):
            self.assertLess(shares("run", step, True)[0], 1e-4)
            for name in ("steps", "zeta"):
                for share in shares(name, step, True):
                    self.assertTrue(0.03 < share < 1.0, (name, step, share))
        self.assertEqual(self.session["data/steps"].bounds["z"][1] > 9.9, True)
        # Ticks tell the step's own place.
        first, last = (mote.View(self.session["data/steps"], step=step, size=(320, 240), annotations={"axes": True}).render().array
                       for step in (0, 5))
        self.assertFalse(np.array_equal(first, last))
        ds = self.session["data/run"]
        z = ds.get("z", step=4)
        for what, values in (("step", z), ("selection", z[z > 8.0])):
            h, edges = ds.histogram("z", bins=50, step=4, range=what, select=mote.column("z") > 8.0, weighted=False)
            self.assertEqual((edges[0], edges[-1], h.sum()), (values.min(), values.max(), (z > 8.0).sum()))
        with self.fails("invalid_argument", "range"):
            ds.histogram("z", range="step")

    def test_what_is_wrong_is_said(self):
        with self.fails("not_found", words='at 3: "enrgy" is neither a column of the dataset nor derived from one; near it: energy'):
            self.ds.get("2*enrgy")
        with self.fails("not_found", words='"spinn" is neither'):
            self.ds.histogram("spinn", step=0)
        with self.fails("invalid_argument", words="there is no function \"foo\""):
            self.ds.get("foo(x)")
        with self.fails("not_found", words="near it: zeta"):
            self.ds.statistics(step=0, names=["mean_zetta"])
        for axes, words in ((["x", "y", "hypot(x"], "at 8: hypot is of 2 values"), (["x", "y", "wind"], "is neither a column of the run")):
            with self.fails("internal", words=words):
                self.session.prepare("data/bunch.mote", axes=axes, output="data/none.mote").wait()

    def test_mote_stats_tells_of_quantities(self):
        def told(*arguments):
            run = subprocess.run([str(BIN / "mote-stats"), "data/bunch", "--spawn", f"data={self.folder.name}", "--json", "--quiet",
                                  "--steps", "2:2:1", *arguments], check=True, capture_output=True, text=True)
            return json.loads(run.stdout)

        found = told("--columns", "zeta,hypot(x,y)")
        self.assertLess(abs(found["mean_zeta"]), 1e-9)
        w = self.columns["weight"]
        self.assertAlmostEqual(found["mean_hypot(x,y)"] / np.average(self.values["r"], weights=w), 1.0, delta=1e-12)
        self.assertIn("n_particle", found)
        self.assertNotIn("mean_x", found)
        counted = told("--histogram", "z,energy*1e-6", "--bins", "8", "--bounds-of", "step", "--unweighted")
        self.assertEqual((counted["particles"], counted["outside"]), (COUNT, 0))
        self.assertEqual((counted["edges"][0][0], counted["edges"][0][-1]), (self.columns["z"].min(), self.columns["z"].max()))

    def test_a_replot_keeps_all(self):
        self.session.prepare("data/bunch.mote", axes=["spin", "turn", "zeta"], output="data/again.mote").wait()
        again = self.session["data/again"]
        self.assertEqual(set(again.columns), set(self.ds.columns))
        self.assertEqual((again.units["spin"], again.units["zeta"]), ("1", "m"))

    def test_a_vectors_name_keeps_its_components(self):
        folder = pathlib.Path(self.folder.name)
        rng = np.random.default_rng(7)
        values = {name: rng.normal(size=50) for name in ("x", "px", "y", "spin_x", "spin_z")}
        np.savez(folder / "spins.npz", **values)
        prepare("particles", folder / "spins.npz", "--axes", "x,px,y", "--mass", MASS, "--columns", "x,spin",
                "--out", folder / "spins.mote")
        made = self.session["data/spins"]
        self.assertEqual(made.columns, ("x", "spin_x", "spin_z"))
        np.testing.assert_allclose(np.sort(made.get("spin_z", step=0)), np.sort(values["spin_z"]), rtol=1e-5, atol=1e-6)

    def test_a_column_may_be_an_expression(self):
        folder = pathlib.Path(self.folder.name)
        prepare("particles", folder / "bunch.mote", "--axes", "x,y,hypot(px,py)/pz", "--columns", "x,px/pz,zeta,hypot(x,y)",
                "--out", folder / "made.mote")
        made = self.session["data/made"]
        self.assertEqual(made.columns, ("x", "px/pz", "zeta", "hypot(x,y)"))
        self.assertEqual([made.units[name] for name in made.columns], ["m", "1", "m", "m"])
        found = np.sort(made.get("px/pz", step=2))
        with np.errstate(all="ignore"):
            slope = self.columns["px"] / self.columns["pz"]
        seen = np.isfinite(np.hypot(self.columns["px"], self.columns["py"]) / self.columns["pz"])
        np.testing.assert_allclose(found, np.sort(slope[seen]), rtol=1e-5, atol=1e-9)


if __name__ == "__main__":
    unittest.main()
