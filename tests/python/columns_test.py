# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of beams far from the origin, with lost particles before them: step, selections, exports and replots, held to numpy."""
import unittest
import warnings

import numpy as np

from support import FolderCase, mote, needs_server, prepare, spawn  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

EVERYTHING = {"ranges": [{"column": "x", "min": -1}]}
SPREAD = 3e-6  # m


def far_beam(random, ratio, lost, bunches=1):
    """Columns of a beam of this spread at so many spreads from 0 in z, its first rows lost at 0; with two bunches half of it at 0."""
    count = 2000 + lost
    rows = {name: random.normal(size=count) * scale for name, scale in
            (("x", 1e-4), ("y", 1e-4), ("z", SPREAD), ("px", 1e3), ("py", 1e3), ("pz", 1e4))}
    rows["z"][lost::bunches] += ratio * SPREAD
    rows["pz"] += 1e8
    rows["lost"] = np.arange(count) < lost
    for values in list(rows.values())[:-1]:
        values[:lost] = 0
    return rows


class Prepared(FolderCase):
    def make(self, name, rows, *options):
        np.savez(self.folder / f"{name}.npz", **rows)
        prepare("particles", self.folder / f"{name}.npz", "--axes", "x,px,y", *options, "--out", self.folder / f"{name}.mote")


@needs_server
class FarAway(Prepared):
    def check(self, dataset, live, whole, tolerance):
        """The statistics of the step, of a selection of all, of half and of what get() gives, against numpy's."""
        z = live["z"]
        above = live["x"] > 0
        selected = {"ranges": [{"column": "x", "min": 0}]}
        for select, values, bound in ((None, z, whole), (EVERYTHING, z, 1e-6), (selected, z[above], 1e-6)):
            said = dataset.statistics(step=0, select=select, names=["sigma_z", "mean_z", "min_z", "max_z"])
            sigma = values.std()
            got = {name: np.ravel(said[name])[0] for name in ("sigma_z", "mean_z", "min_z", "max_z")}
            self.assertAlmostEqual(got["sigma_z"], sigma, delta=bound * sigma + tolerance)
            for name, value in (("mean_z", values.mean()), ("min_z", values.min()), ("max_z", values.max())):
                self.assertAlmostEqual(got[name], value, delta=1e-4 * SPREAD + tolerance)
        got = np.sort(np.asarray(dataset.get("z")))
        np.testing.assert_allclose(got, np.sort(z), rtol=0, atol=1e-4 * SPREAD + tolerance)

    def test_wherever_the_beam_is(self):
        random = np.random.default_rng(7)
        cases = {f"beam{ratio:.0e}{lost}".replace("+", ""): (ratio, lost, 1)
                 for ratio, lost in ((1, 0), (1e3, 1), (1e6, 700), (1e9, 1), (1e12, 700))}
        cases.update({f"two{ratio:.0e}".replace("+", ""): (ratio, 1, 2) for ratio in (1e4, 1e9)})
        rows = {name: far_beam(random, *case) for name, case in cases.items()}
        for name, table in rows.items():
            self.make(name, table)
            prepare("export", self.folder / f"{name}.mote", "--openpmd", self.folder / f"{name}.h5")
            prepare("particles", self.folder / f"{name}.h5", "--axes", "x,px,y", "--out", self.folder / f"{name}-exported.mote")
            prepare("particles", self.folder / f"{name}.mote", "--axes", "x,px,z", "--out", self.folder / f"{name}-replot.mote")
            prepare("verify", self.folder / f"{name}.mote")
        session = spawn(self.folder)
        self.addCleanup(session.close)
        for name, (ratio, _, _) in cases.items():
            table = rows[name]
            live = {column: values[~table["lost"]] for column, values in table.items()}
            for made in (name, f"{name}-exported", f"{name}-replot"):
                with self.subTest(made):
                    # What doubles of the source itself resolve there.
                    whole = 1e-6 if made.endswith("exported") else 1e-12  # of columns, of the source
                    self.check(session[f"data/{made}"], live, whole, 4 * np.spacing(ratio * SPREAD))

    def test_what_is_too_coarse_is_said(self):
        rows = far_beam(np.random.default_rng(9), 1, 0)
        rows["x"][:5] = 5e-3 + 1e-10 * np.arange(5)  # steps of floats there are 4.7e-10
        self.make("beam", rows)
        session = spawn(self.folder)
        self.addCleanup(session.close)
        dataset, few = session["data/beam"], {"ranges": [{"column": "x", "min": 4e-3}]}
        asked = {"whole": (lambda: dataset.statistics(step=0), None), "all": (lambda: dataset.statistics(step=0, select=EVERYTHING), None),
                 "few": (lambda: dataset.statistics(step=0, select=few), "spread (sigma) of these particles"),
                 "another": (lambda: dataset.statistics(step=0, select=few, names="sigma_y"), None),
                 "values": (lambda: dataset.get("x", select=few), "span fewer than 100"),
                 "histogram": (lambda: dataset.histogram("x", bins=10, step=0), None),
                 "bins": (lambda: dataset.histogram("x", bins=10, range=(5e-3, 5e-3 + 1e-9), step=0), "neighbouring bins")}
        for what, (ask, words) in asked.items():
            with self.subTest(what=what), warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                ask()
                said = [str(each.message) for each in caught if each.category is mote.CoarseNumbers]
                self.assertEqual(len(said), 0 if words is None else 1, said)
                self.assertIn(words or "", "".join(said))

    def test_what_the_manifest_says_of_a_column(self):
        random = np.random.default_rng(8)
        self.make("near", far_beam(random, 1, 1))
        self.make("two", far_beam(random, 1e9, 1, 2))
        session = spawn(self.folder)
        self.addCleanup(session.close)
        for name, kind in (("near", None), ("two", "f64")):
            manifest = session[f"data/{name}"].manifest["particles"]
            names = [column["name"] for column in manifest["columns"]]
            z = names.index("z")
            self.assertEqual(manifest["columns"][z].get("type"), kind)
            self.assertLess(manifest["steps"][0]["columnResolution"][z], 1e-4 * SPREAD)
            self.assertEqual([column.get("type") for column in manifest["columns"][:z]], [None] * z)


@unittest.skipUnless(h5py, "python3-h5py is missing")
@needs_server
class LostAndLive(Prepared):
    def test_an_export_says_who_is_lost(self):
        table = far_beam(np.random.default_rng(9), 10, 300)
        for values in ("x", "y", "px", "py"):
            table[values] = np.random.default_rng(10).normal(size=2300)
        self.make("all", table, "--lost", "with")
        prepare("export", self.folder / "all.mote", "--openpmd", self.folder / "all.h5")
        with h5py.File(self.folder / "all.h5", "r") as file:
            beam = file["data/0/particles/beam"]
            status = beam["particleStatus"][()]
            x = beam["position/x"][()]
        self.assertEqual(sorted(set(status)), [1, 2])
        np.testing.assert_allclose(np.sort(x[status == 2]), np.sort(table["x"][:300]), rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
