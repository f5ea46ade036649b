# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistics of the openPMD runs of others, as mote-prep finds them, against numpy on what h5py reads."""
import pathlib
import tempfile
import unittest

import numpy
import statistics_test as judge

try:
    import h5py
except ImportError:
    h5py = None

RUNS = pathlib.Path(__file__).resolve().parents[3] / "shared/data/particles"
LIGHT, CHARGE = 299792458.0, 1.602176634e-19


def number(item):
    """A record component in SI units: a dataset, or one value for all."""
    values = item[()] if isinstance(item, h5py.Dataset) else numpy.asarray(item.attrs["value"])
    return numpy.asarray(values, numpy.float64) * numpy.asarray(item.attrs["unitSI"], numpy.float64)


def component(species, record, axis, count):
    name = f"{record}/{axis}"
    values = number(species[name]) if name in species else 0.0
    if f"{record}Offset/{axis}" in species:
        values = values + number(species[f"{record}Offset/{axis}"])
    return numpy.broadcast_to(values, (count,)).astype(numpy.float64)


def rows(species, count):
    """The live particles of a step: m and eV/c of one real particle."""
    out = {axis: component(species, "position", axis, count) for axis in "xyz"}
    weight = next((number(species[name]) for name in ("weight", "weighting") if name in species), 1.0)
    out["weight"] = numpy.broadcast_to(weight, (count,)).astype(numpy.float64)
    whole = species["momentum"].attrs.get("macroWeighted", 0)
    for axis in "xyz":
        momentum = component(species, "momentum", axis, count) * LIGHT / CHARGE
        out["p" + axis] = momentum / out["weight"] if whole else momentum
    if "particleStatus" in species:
        alive = numpy.broadcast_to(number(species["particleStatus"]), (count,)) == 1
        out = {name: values[alive] for name, values in out.items()}
    return out


def lost(step, name):
    """What values far from 0 lost when they were rounded is no fault of what is made of their differences."""
    far = {one: 1 + 1e-3 * abs(step["mean_" + one]) / step["sigma_" + one] for one in ("x", "px", "y", "py", "z", "pz", "energy")
           if step["sigma_" + one] > 0}
    if name.startswith("cov_"):
        return numpy.prod([far.get(one, 1) for one in name[4:].split("__")])
    if "emit" in name or name.startswith(("twiss", "halo")):
        return far.get(name[-1], 1) * far.get("p" + name[-1], 1)
    return 1


@unittest.skipUnless(h5py and RUNS.is_dir(), "python3-h5py or the runs of others are missing")
class RunsOfOthers(unittest.TestCase):
    def held(self, name, places, axes="x,px,y", options=()):
        with tempfile.TemporaryDirectory() as folder:
            manifest, steps = judge.prepare(folder, [RUNS / name], "--axes", axes, *options)
        self.assertEqual(len(steps), len(places))
        with h5py.File(RUNS / name) as file:
            for place, step in zip(places, steps):
                species = file[place]
                wanted = rows(species, species["momentum/x"].shape[0])
                self.assertEqual(step["n_particle"], len(wanted["x"]))
                numbers = judge.expected(wanted, manifest["mass"])
                numbers = {name: value for name, value in numbers.items() if numpy.isfinite(value[0]) and value[1] > 0}
                numbers = {name: (value, scale * lost(step, name)) for name, (value, scale) in numbers.items()}
                self.assertGreater(len(numbers), 60)
                judge.AgainstNumpy.check(self, step, numbers)

    def test_astra(self):
        self.held("astra_particles.h5", ["screen/0", "screen/1"])

    def test_bmad(self):
        self.held("bmad_particles.h5", ["data/00001/particles"])

    def test_picongpu(self):
        self.held("picongpu_lwfa_000550.h5", ["data/550/particles/e"])


if __name__ == "__main__":
    unittest.main()
