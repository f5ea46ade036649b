# SPDX-License-Identifier: GPL-3.0-or-later
"""Several species of an openPMD run as one plot, held to numpy on what h5py wrote."""
import subprocess
import unittest

import numpy as np

from support import BIN, FolderCase, needs_server, prepare, spawn  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

LIGHT, CHARGE = 299792458.0, 1.602176634e-19
ELECTRON, PROTON = 9.1093837015e-31, 1.67262192369e-27  # kg
ITERATIONS = (0, 100)


def in_ev(kilograms):
    return kilograms * LIGHT**2 / CHARGE


class Species:
    """Rows of one, by iteration."""

    def __init__(self, random, name, counts, mass, charge, *, weight=10.0, ids=True):
        self.name, self.mass, self.charge, self.ids, self.weight = name, mass, charge, ids, weight
        self.rows = {iteration: {
            "position": random.normal(0, 1e-6, (3, count)), "momentum": random.normal(0, 2 * mass * LIGHT, (3, count)),
            "weight": random.uniform(0.5, 1.5, count) * (weight or 1)} for iteration, count in zip(ITERATIONS, counts)}

    def write(self, group, iteration):
        rows = self.rows[iteration]
        count = rows["weight"].size
        if count == 0:
            return
        own = group.create_group(f"particles/{self.name}")
        for record, dimension in (("position", [1, 0, 0, 0, 0, 0, 0]), ("momentum", [1, 1, -1, 0, 0, 0, 0])):
            for axis, values in zip("xyz", rows[record]):
                own.create_dataset(f"{record}/{axis}", data=values).attrs["unitSI"] = 1.0
            own[record].attrs["unitDimension"] = dimension
        if self.weight:
            own.create_dataset("weighting", data=rows["weight"]).attrs["unitSI"] = 1.0
        for record, value in (("mass", self.mass), ("charge", self.charge)):
            constant = own.create_group(record)
            constant.attrs.update({"value": value, "shape": [count], "unitSI": 1.0})
        if self.ids:
            own.create_dataset("id", data=np.arange(count, dtype=np.uint64)).attrs["unitSI"] = 1.0

    def energy(self, iteration):
        momentum = np.linalg.norm(self.rows[iteration]["momentum"], axis=0) * LIGHT / CHARGE
        rest = in_ev(self.mass)
        return np.sqrt(momentum**2 + rest**2) - rest


def write_run(path, species):
    with h5py.File(path, "w") as file:
        file.attrs.update({"openPMD": np.bytes_("1.1.0"), "basePath": np.bytes_("/data/%T/"), "particlesPath": np.bytes_("particles/")})
        for iteration in ITERATIONS:
            group = file.create_group(f"data/{iteration}")
            group.attrs.update({"time": iteration * 1e-12, "timeUnitSI": 1.0})
            for one in species:
                one.write(group, iteration)


@needs_server
@unittest.skipUnless(h5py, "there is no h5py")
class Joined(FolderCase):
    def make(self, species, *options, axes="x,y,z"):
        write_run(self.folder / "run.h5", species)
        prepare("particles", self.folder / "run.h5", "--axes", axes, "--species", ",".join(one.name for one in species), *options,
                "--out", self.folder / "both.mote")

    def refused(self, species, *words):
        done = subprocess.run([str(BIN / "mote-prep"), "particles", str(self.folder / "run.h5"), "--axes", "x,y,z", "--species",
                               species, "--quiet", "--out", str(self.folder / "none.mote")], capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertFalse((self.folder / "none.mote").exists())
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def check_step(self, dataset, species, step):
        iteration = ITERATIONS[step]
        species = [one for one in enumerate(species) if one[1].rows[iteration]["weight"].size]
        names = ["species", "mass", "particle_charge", "x", "pz", "weight", "energy", "gamma"]
        got = dict(zip(["id"] + names, dataset.get(["id"] + names, step=step)))
        self.assertEqual(np.unique(got["id"]).size, got["id"].size)
        for place, one in species:
            rows = one.rows[iteration]
            mine = got["species"] == place
            order = np.argsort(got["id"][mine])
            np.testing.assert_array_equal(np.sort(got["id"][mine]), np.arange(mine.sum(), dtype=np.uint64) | np.uint64(place << 56))
            rest = in_ev(one.mass)
            expected = {"mass": rest, "particle_charge": one.charge, "x": rows["position"][0], "weight": rows["weight"],
                        "pz": rows["momentum"][2] * LIGHT / CHARGE, "energy": one.energy(iteration),
                        "gamma": one.energy(iteration) / rest + 1}
            for name, values in expected.items():
                # Columns are floats of 24 bits about an offset, of all species together.
                scale = np.abs(got[name]).max()
                np.testing.assert_allclose(got[name][mine][order], np.broadcast_to(values, mine.sum()), rtol=1e-6, atol=2e-7 * scale,
                                           err_msg=f"{name} of {one.name} in step {step}")
        self.assertEqual(got["id"].size, sum(one.rows[iteration]["weight"].size for _, one in species))

    def test_each_particle_keeps_what_it_is(self):
        random = np.random.default_rng(5)
        species = [Species(random, "electrons", (3000, 2500), ELECTRON, -CHARGE),
                   Species(random, "protons", (0, 2000), PROTON, CHARGE, weight=3.0),
                   Species(random, "alphas", (700, 1), 6.6446573357e-27, 2 * CHARGE, weight=1.0)]
        self.make(species)
        with spawn(self.folder) as session:
            dataset = session["data/both"]
            self.assertEqual(list(dataset.iterations), list(ITERATIONS))
            np.testing.assert_allclose(dataset.t, [0, 1e-10])
            for step in range(2):
                self.check_step(dataset, species, step)
            found = dataset.statistics(step=1)
            momenta = np.concatenate([one.rows[100]["momentum"][0] for one in species]) * LIGHT / CHARGE
            weights = np.concatenate([one.rows[100]["weight"] for one in species])
            self.assertAlmostEqual(found["mean_px"], np.average(momenta, weights=weights), delta=1e-9 * np.abs(momenta).max())
            for name in ("norm_emit_x", "mean_energy", "mean_gamma", "charge"):
                self.assertTrue(np.isnan(found[name]), f"{name} needs one mass, or one charge")
            selected = dataset.statistics(step=1, select={"ranges": [{"column": "species", "min": 1, "max": 1}]})
            self.assertEqual(selected["n_particle"], 2000)
            sums = np.array([(one.rows[100]["weight"] * one.charge).sum() for one in species]).sum()
            weight, charge = dataset.get(["weight", "particle_charge"], step=1)
            self.assertAlmostEqual((weight * charge).sum() / sums, 1.0, delta=1e-5)

    def test_energies_are_axes_by_each_particle_s_mass(self):
        random = np.random.default_rng(6)
        species = [Species(random, "protons", (400, 500), PROTON, CHARGE), Species(random, "electrons", (300, 600), ELECTRON, -CHARGE)]
        self.make(species, axes="energy,z,gamma")
        with spawn(self.folder) as session:
            axes = list(session["data/both"].bounds.values())
        energies = np.concatenate([one.energy(iteration) for one in species for iteration in ITERATIONS])
        self.assertAlmostEqual(axes[0][0], energies.min(), delta=0.01 * np.ptp(energies))
        self.assertAlmostEqual(axes[0][1], energies.max(), delta=0.01 * np.ptp(energies))
        prepare("particles", self.folder / "both.mote", "--axes", "energy,x,pz", "--out", self.folder / "again.mote")
        with spawn(self.folder) as session:
            again = list(session["data/again"].bounds.values())
        self.assertAlmostEqual(again[0][1] / axes[0][1], 1, delta=1e-5)

    def test_of_one_mass_it_is_as_of_one_species(self):
        random = np.random.default_rng(7)
        species = [Species(random, "left", (500, 10), ELECTRON, -CHARGE), Species(random, "right", (300, 40), ELECTRON, -CHARGE, ids=False)]
        self.make(species)
        with spawn(self.folder) as session:
            dataset = session["data/both"]
            self.assertNotIn("mass", dataset.columns)
            self.assertNotIn("id", dataset.columns)
            found = dataset.statistics(step=0)
        weights = np.concatenate([one.rows[0]["weight"] for one in species])
        energies = np.concatenate([one.energy(0) for one in species])
        self.assertAlmostEqual(found["charge"] / (weights.sum() * CHARGE), 1, delta=1e-12)
        self.assertAlmostEqual(found["mean_energy"] / np.average(energies, weights=weights), 1, delta=1e-6)

    def test_what_cannot_be_one_is_said(self):
        random = np.random.default_rng(8)
        write_run(self.folder / "run.h5", [Species(random, "electrons", (5, 5), ELECTRON, -CHARGE),
                                           Species(random, "ions", (0, 5), PROTON, CHARGE)])
        self.refused("electrons,electrons", "species: names electrons twice")
        self.refused("electrons,,ions", "comma without a name")
        self.refused("electrons,muons", "holds no species 'muons', but electrons, ions")
        self.refused(",".join(f"s{i}" for i in range(65)), "65 species")


if __name__ == "__main__":
    unittest.main()
