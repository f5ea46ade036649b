# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of particles, read by h5py from the standard's pages alone, and held to the run that they come from."""
import json
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

from support import BIN, Case, make_beam, needs_server, prepare, spawn  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

C, E = 299792458.0, 1.602176634e-19
MOMENTUM = E / C  # kg m/s in an eV/c
DIMENSIONS = {"position": (1, 0, 0), "momentum": (1, 1, -1), "time": (0, 0, 1), "weight": (0, 0, 1, 1), "weighting": (0,),
              "mass": (0, 1), "charge": (0, 0, 1, 1), "id": (0,), "particleStatus": (0,)}


def record(species, name):
    """A component in SI, a constant one too; the record's powers of the SI's base units."""
    item = species[name]
    home = species[name.split("/")[0]]
    values = item[()] if isinstance(item, h5py.Dataset) else np.full(item.attrs["shape"], item.attrs["value"])
    return values * item.attrs["unitSI"] if name != "id" else values, tuple(home.attrs["unitDimension"])


class Export:
    """A file of openPMD with the beam physics extension, by iteration."""

    def __init__(self, path):
        self.file = h5py.File(path, "r")
        attributes = self.file.attrs
        for name, value in (("openPMD", "1.1.0"), ("basePath", "/data/%T/"), ("particlesPath", "particles/"),
                            ("iterationEncoding", "groupBased")):
            assert attributes[name].decode() == value, name
        assert "BeamPhysics" in attributes["openPMDextension"].decode()
        self.steps = {int(name): group["particles/beam"] for name, group in self.file["data"].items()}
        self.times = {int(name): group.attrs["time"] * group.attrs["timeUnitSI"] for name, group in self.file["data"].items()}

    def get(self, step, name):
        values, dimension = record(self.steps[step], name)
        expected = DIMENSIONS[name.split("/")[0]]
        assert dimension == expected + (0,) * (7 - len(expected)), (name, dimension)
        return values


@needs_server
@unittest.skipUnless(h5py, "python3-h5py is missing")
class WithRun(Case):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.plots = pathlib.Path(cls.folder.name)
        make_beam(cls.plots, particles=3000, steps=4)
        with h5py.File(cls.plots / "run.h5", "r") as run:
            cls.source = {int(name): cls.columns(group["particles/beam"]) for name, group in run["data"].items()}
            cls.weight = next(iter(run["data"].values()))["particles/beam/weighting"].attrs["value"]
            cls.times = {int(name): group.attrs["time"] for name, group in run["data"].items()}

        # Whether the dataset knows what its weights count.
        cls.counted = cls.info("beam.mote").get("weightUnit") == "1"

    @classmethod
    def info(cls, name):
        """The manifest of a dataset of particles."""
        said = subprocess.run([str(BIN / "mote-prep"), "info", str(cls.plots / name), "--json"], check=True, capture_output=True)
        return json.loads(said.stdout)["particles"]

    @staticmethod
    def columns(species):
        """What the run's own file says, by id."""
        order = np.argsort(species["id"][()])
        found = {f"position/{axis}": species[f"position/{axis}"][()].astype(float)[order] for axis in "xyz"}
        found.update({f"momentum/{axis}": species[f"momentum/{axis}"][()][order] * MOMENTUM for axis in "xyz"})
        found["id"] = species["id"][()][order]
        return found

    def check(self, path, steps, ids=None):
        """All that the file holds; of these particles alone."""
        exported = Export(path)
        numbers = sorted(self.source)
        self.assertEqual(sorted(exported.steps), [numbers[step] for step in steps])
        for number, species in exported.steps.items():
            source = self.source[number]
            got = exported.get(number, "id")
            order = np.argsort(got)
            np.testing.assert_array_equal(got[order], source["id"] if ids is None else ids)
            keep = np.searchsorted(source["id"], got[order])
            for name, values in source.items():
                if name == "id":
                    continue
                # Columns are floats about the middle of their range.
                tolerance = np.ptp(values) * 2.0**-23
                np.testing.assert_allclose(exported.get(number, name)[order], values[keep], rtol=1e-14, atol=tolerance)
            np.testing.assert_allclose(exported.times[number], self.times[number], rtol=1e-15)
            np.testing.assert_allclose(exported.get(number, "time"), self.times[number], rtol=1e-15)
            np.testing.assert_allclose(exported.get(number, "mass"), 938.27208816e6 * E / C**2, rtol=1e-12)
            np.testing.assert_allclose(exported.get(number, "charge"), E, rtol=1e-15)
            self.assertTrue((exported.get(number, "particleStatus") == 1).all())
            weights = exported.get(number, "weighting")
            self.assertEqual(species.attrs["speciesType"].decode(), "proton")
            self.assertEqual(species.attrs["numParticles"], len(got))
            np.testing.assert_allclose(weights, self.weight, rtol=1e-6)
            self.assertEqual("weight" in species, self.counted)
            if self.counted:
                np.testing.assert_allclose(exported.get(number, "weight"), weights * E, rtol=1e-15)
                np.testing.assert_allclose(species.attrs["totalCharge"] * species.attrs["chargeUnitSI"], weights.sum() * E,
                                           rtol=1e-12)
        return exported

    def chosen(self, step, low):
        """Ids of the particles with x of at least `low` in a step."""
        source = self.source[sorted(self.source)[step]]
        return source["id"][source["position/x"] >= low]


class Program(WithRun):
    def test_whole_runs(self):
        out = self.plots / "whole.h5"
        prepare("export", self.plots / "beam.mote", "--openpmd", out)
        self.check(out, range(4))

    def test_a_halo_is_followed_through_the_steps(self):
        selection = self.plots / "halo.json"
        # Between two values, so that rounding moves no particle over the bound.
        x = np.sort(self.source[sorted(self.source)[3]]["position/x"])
        low = (x[-300] + x[-301]) / 2
        selection.write_text(json.dumps({"ranges": [{"column": "x", "min": low}], "step": 3}), encoding="utf-8")
        out = self.plots / "halo.h5"
        done = subprocess.run([str(BIN / "mote-stats"), "data/beam", "--spawn", f"data={self.plots}", "--select", str(selection),
                               "--steps", "0:3:3", "--export", str(out)], capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.check(out, (0, 3), self.chosen(3, low))

    def test_a_replot_shows_the_same_particles(self):
        prepare("export", self.plots / "beam.mote", "--openpmd", self.plots / "again.h5")
        prepare("particles", self.plots / "again.h5", "--axes", "x,px,y", "--out", self.plots / "again.mote")
        self.addCleanup((self.plots / "again.h5").unlink)
        infos = [self.info(name) for name in ("beam.mote", "again.mote")]
        for one, two in zip(*(info["steps"] for info in infos)):
            self.assertEqual((one["iteration"] if "iteration" in one else 0, one["particles"]),
                             (two["iteration"] if "iteration" in two else 0, two["particles"]))
            self.assertAlmostEqual(one["totalWeight"], two["totalWeight"], delta=1e-6 * one["totalWeight"])
        for one, two in zip(*(info["axes"] for info in infos)):
            np.testing.assert_allclose([one["min"], one["max"]], [two["min"], two["max"]], rtol=1e-5)


ELECTRON, PROTON, CARBON = 9.1093837015e-31, 1.67262192369e-27, 1.99264687e-26  # kg
# What a file says, and what openPMD-beamphysics and openPMD's SpeciesType make of it.
SPECIES = [
    ({"group": "positrons", "charge": E, "mass": ELECTRON}, ("positron", ELECTRON, E)),
    ({"group": "electrons", "charge": -E, "mass": ELECTRON}, ("electron", ELECTRON, -E)),
    ({"group": "beam", "type": "antiproton", "unit": "C"}, ("antiproton", PROTON, -E)),
    ({"group": "beam", "type": "electron", "unit": "C", "status": [1, 0, 3]}, ("electron", ELECTRON, -E)),
    ({"group": "C6+", "charge": 6 * E, "mass": CARBON}, ("#12C+6", CARBON, 6 * E)),
    ({"group": "ions", "type": "#12C+3"}, ("#12C+3", CARBON - 3 * ELECTRON, 3 * E)),
    ({"group": "beam", "type": "H-", "status": [1, 1, 5, 0]}, ("H-", PROTON + 2 * ELECTRON, -E)),
]


def write_species(path, random, said):
    """A step of 500 particles; its weights, as charges of macro-particles in C, and who of them is lost."""
    count, each = 500, said.get("charge", said.get("each", E))
    with h5py.File(path, "w") as file:
        file.attrs.update({"openPMD": np.bytes_("2.0.0"), "basePath": np.bytes_("/data/%T/"), "particlesPath": np.bytes_("particles/"),
                           "openPMDextension": np.bytes_("BeamPhysics;SpeciesType")})
        group = file.create_group(f"data/4/particles/{said['group']}")
        if "type" in said:
            group.attrs["speciesType"] = np.bytes_(said["type"])

        def add(name, values, unit=1.0, dimension=()):
            group[name] = values
            group[name].attrs.update({"unitSI": unit, "macroWeighted": 0, "weightingPower": 1.0})
            (group[name.split("/")[0]]).attrs["unitDimension"] = np.array(list(dimension) + [0.0] * (7 - len(dimension)))

        for axis in "xyz":
            add(f"position/{axis}", random.normal(size=count), 1e-3, (1,))
            add(f"momentum/{axis}", 1e9 * (axis == "z") + 1e5 * random.normal(size=count), MOMENTUM, (1, 1, -1))
        weights = random.uniform(0.5, 1.5, count) * 1e-12
        if said.get("unit") == "C":
            add("weight", weights, 1.0, (0, 0, 1, 1))
        else:
            add("weighting", weights / abs(each))
        for name, dimension in (("mass", (0, 1)), ("charge", (0, 0, 1, 1))):
            if name in said:
                constant = group.create_group(name)
                constant.attrs.update({"value": said[name], "shape": [count], "unitSI": 1.0, "macroWeighted": 0, "weightingPower": 1.0})
        status = np.resize(said.get("status", [1]), count)
        add("particleStatus", status)
    return weights, (status != 1) & (status != 0)


@needs_server
@unittest.skipUnless(h5py, "python3-h5py is missing")
class RoundTrip(Case):
    def test_every_species_comes_back(self):
        random = np.random.default_rng(3)
        for said, (species, mass, charge) in SPECIES:
            for lost in ("without", "with"):
                with self.subTest(said, lost=lost), tempfile.TemporaryDirectory() as directory:
                    folder = pathlib.Path(directory)
                    weights, gone = write_species(folder / "run.h5", random, {**said, "each": charge})
                    source = folder / "run.h5"
                    for again in ("one", "two"):
                        prepare("particles", source, "--axes", "x,px,y", "--lost", lost, "--out", folder / f"{again}.mote")
                        source = folder / f"{again}.h5"
                        prepare("export", folder / f"{again}.mote", "--openpmd", source)
                        exported = Export(source)
                        beam = exported.steps[4]
                        self.assertEqual(beam.attrs["speciesType"].decode(), species)
                        np.testing.assert_allclose(exported.get(4, "charge"), charge, rtol=1e-12)
                        # The binding of electrons is left out.
                        np.testing.assert_allclose(exported.get(4, "mass"), mass, rtol=1e-7)
                        status = exported.get(4, "particleStatus")
                        self.assertEqual((status == 1).sum(), (~gone).sum())
                        self.assertEqual((status != 1).sum(), gone.sum() if lost == "with" else 0)
                        kept = weights if lost == "with" else weights[~gone]
                        np.testing.assert_allclose(np.sort(exported.get(4, "weight")), np.sort(kept), rtol=1e-14)
                        np.testing.assert_allclose(np.sort(exported.get(4, "weighting")), np.sort(kept) / abs(charge), rtol=1e-14)
                        np.testing.assert_allclose(beam.attrs["totalCharge"], kept.sum(), rtol=1e-13)


class Package(WithRun):
    def test_exports_are_jobs(self):
        session = spawn(self.plots)
        self.addCleanup(session.close)
        dataset = session["data/beam"]
        out = self.plots / "package.h5"
        low = 1e-3
        job = dataset.export(step=2, select={"ranges": [{"column": "x", "min": low}]}).wait()
        job.save(out)
        exported = Export(out)
        (number,) = exported.steps
        self.assertEqual(number, sorted(self.source)[2])
        self.assertAlmostEqual(len(exported.get(number, "id")), len(self.chosen(2, low)), delta=2)
        self.assertTrue((exported.get(number, "position/x") >= low).all())
        dataset.export(step=slice(1, 3)).wait().save(self.plots / "two.h5")
        self.check(self.plots / "two.h5", (1, 2))
        with self.fails("internal", words="wind"):
            dataset.export(columns=["wind"]).wait()
        self.assertEqual(dataset.export(select={"ranges": [{"column": "x", "min": 7}]}).wait().state, "succeeded")


if __name__ == "__main__":
    unittest.main()
