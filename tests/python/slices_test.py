# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistics of slices, of even length and of equal charge, from Python and from mote-stats, held to numpy."""
import csv
import json
import subprocess
import unittest

import numpy as np

from support import BIN, FolderCase, needs_server, prepare, spawn  # isort: skip

NAMES = ["mean_x", "sigma_x", "sigma_px", "norm_emit_x", "mean_energy", "charge", "n_particle"]
MASS = 0.51099895e6


def edges_of(values, weights, count, of):
    if of == "even":
        return np.linspace(values.min(), values.max(), count + 1)
    order = np.argsort(values, kind="stable")
    above = np.cumsum(weights[order])
    inner = np.searchsorted(above, np.arange(1, count) / count * above[-1] * (1 + 1e-13), side="right")
    return np.array([values.min(), *values[order][inner], values.max()])


def slices_of(values, edges):
    return np.clip(np.searchsorted(edges[1:-1], values, side="right"), 0, edges.size - 2)


def statistics(rows, which):
    """Of the rows of a slice, by name."""
    x, px, weight = rows["x"][which], rows["px"][which], rows["weight"][which]
    if weight.sum() == 0:
        return {name: np.nan for name in NAMES}
    mean = lambda values: np.average(values, weights=weight)
    xx, pp, xp = mean((x - mean(x))**2), mean((px - mean(px))**2), mean((x - mean(x)) * (px - mean(px)))
    energy = np.sqrt(px**2 + rows["py"][which]**2 + rows["pz"][which]**2 + MASS**2) - MASS
    return {"mean_x": mean(x), "sigma_x": np.sqrt(xx), "sigma_px": np.sqrt(pp), "norm_emit_x": np.sqrt(xx * pp - xp**2) / MASS,
            "mean_energy": mean(energy), "n_particle": which.sum()}


@needs_server
class Slices(FolderCase):
    def setUp(self):
        super().setUp()
        random = np.random.default_rng(11)
        count = 20000
        z = np.concatenate([random.normal(0, 1e-3, count - 2000), random.standard_cauchy(1000) * 1e-3, np.full(1000, 5e-4)])
        self.rows = {"x": random.normal(0, 1e-4, count) * (1 + 100 * np.abs(z)), "y": random.normal(0, 1e-4, count), "z": z,
                     "px": random.normal(0, 1e3, count) + 1e6 * z, "py": random.normal(0, 1e3, count), "pz": random.normal(1e8, 1e5, count),
                     "weight": random.uniform(0.0, 2.0, count)}
        np.savez(self.folder / "beam.npz", **self.rows)
        prepare("particles", self.folder / "beam.npz", "--axes", "x,px,z", "--mass", MASS, "--out", self.folder / "beam.mote")

    def check(self, edges, slices, rows, along, of):
        """What was told, by name, to what numpy makes of the columns that the dataset has."""
        values = rows["hypot"] if along.startswith("hypot") else rows[along]
        expected = edges_of(values, rows["weight"], len(edges) - 1, of)
        np.testing.assert_allclose(edges, expected, rtol=1e-12, atol=1e-15 * np.ptp(values))
        at = slices_of(values, np.asarray(edges))
        for i in range(len(edges) - 1):
            found = statistics(rows, at == i)
            for name, value in found.items():
                told = np.nan if slices[name][i] is None else float(slices[name][i])
                if np.isnan(value):
                    self.assertTrue(np.isnan(told) or name == "n_particle", f"{name} of slice {i}")
                else:
                    self.assertAlmostEqual(told, value, delta=1e-9 * abs(value) + 1e-9 * np.abs(rows["x"]).max() * (name == "mean_x"),
                                           msg=f"{name} of slice {i}")
        if of == "charge" and len(edges) > 2:
            weights = np.bincount(at, rows["weight"], len(edges) - 1)
            self.assertLess(np.abs(np.cumsum(weights)[:-1] / weights.sum() - np.arange(1, len(edges) - 1) / (len(edges) - 1)).max(),
                            0.06, "within the thousand particles of one place")

    def test_even_or_of_equal_charge(self):
        with spawn(self.folder) as session:
            dataset = session["data/beam"]
            rows = dict(zip(self.rows, dataset.get(list(self.rows))))
            rows["hypot"] = np.sqrt(rows["x"]**2 + rows["y"]**2)
            some = rows["x"] > 2e-5
            chosen = {name: values[some] for name, values in rows.items()}
            for along, count, of in (("z", 50, "charge"), ("z", 1, "charge"), ("z", 256, "charge"), ("pz", 7, "even"),
                                     ("hypot(x, y)", 13, "charge")):
                for select, of_rows in ((None, rows), ({"ranges": [{"column": "x", "min": np.nextafter(2e-5, 1)}]}, chosen)):
                    found = dataset.statistics(step=0, select=select, slices=(along, count, of))
                    self.assertEqual(found["slices"]["mean_x"].shape, (count,))
                    self.check(found["slice_edges"], found["slices"], of_rows, along, of)
            default = dataset.statistics(step=0, slices="z")
            self.assertEqual(default["slice_edges"].size, 51)
            np.testing.assert_array_equal(default["slice_edges"], dataset.statistics(step=0, slices=("z", 50, "even"))["slice_edges"])
            with self.fails("invalid_argument", words="charge"):
                dataset.statistics(step=0, slices=("z", 50, "energy"))

    def stats(self, *words):
        done = subprocess.run([str(BIN / "mote-stats"), "data/beam", "--spawn", f"data={self.folder}", "--quiet", *map(str, words)],
                              capture_output=True, text=True, check=False, timeout=60)
        return done.returncode, done.stdout, done.stderr

    def test_mote_stats_in_each_form(self):
        with spawn(self.folder) as session:
            found = session["data/beam"].statistics(step=0, slices=("z", 12, "charge"))
        edges, slices = found["slice_edges"], found["slices"]
        words = ("--slices", "z:12:charge", "--columns", "x,px,y,py,z,pz,energy")
        code, text, errors = self.stats(*words, "--json")
        self.assertEqual((code, errors), (0, ""))
        line = json.loads(text)
        np.testing.assert_array_equal(line["slice_edges"], edges)
        for name in ("mean_x", "norm_emit_x", "mean_energy", "n_particle"):
            np.testing.assert_array_equal(np.array(line["slices"][name], float), slices[name])
        self.assertEqual(self.stats(*words, "--csv", self.folder / "slices.csv")[0], 0)
        with open(self.folder / "slices.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([int(row["slice"]) for row in rows], list(range(12)))
        np.testing.assert_array_equal([float(row["z_from [m]"]) for row in rows], edges[:-1])
        np.testing.assert_array_equal([float(row["z_to [m]"]) for row in rows], edges[1:])
        np.testing.assert_array_equal([float(row["norm_emit_x [m]"]) for row in rows], slices["norm_emit_x"])
        self.assertEqual(self.stats(*words, "--npy", self.folder / "slices.npy")[0], 0)
        table = np.load(self.folder / "slices.npy")
        self.assertEqual(table.shape, (12,))
        np.testing.assert_array_equal(table["z_to"], edges[1:])
        np.testing.assert_array_equal(table["sigma_x [m]"], slices["sigma_x"])
        code, text, _ = self.stats("--slices", "z:12")
        self.assertEqual((code, len(text.splitlines())), (0, 15), text)
        self.assertIn("z_from", text)

    def test_what_is_wrong_is_said(self):
        for words, said in ((("--slices", "z:0"), "COLUMN:COUNT"), (("--slices", "z:5:energy"), "COLUMN:COUNT"), (("--slices", ":5"), "missing"),
                            (("--slices", "z", "--histogram", "x"), "not of a histogram")):
            code, text, errors = self.stats(*words)
            self.assertEqual((code, text), (2, ""), words)
            self.assertIn(said, errors)
        for words, said in ((("--slices", "z:257"), "1 to 256"), (("--slices", "spin:5"), "spin")):
            code, text, errors = self.stats(*words)
            self.assertEqual((code, text), (1, ""), words)
            self.assertIn(said, errors)


if __name__ == "__main__":
    unittest.main()
