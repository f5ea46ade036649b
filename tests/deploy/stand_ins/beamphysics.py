# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for openPMD-beamphysics in the commands of docs/PYTHON.md: names, units and types of its ParticleGroup."""
import numpy

COUNT = 1000


class ParticleGroup:
    """Electrons of 100 MeV/c, of which every tenth is lost."""

    mass = 510998.95

    def __init__(self, h5):
        assert h5.endswith(".h5")
        random = numpy.random.default_rng(1)
        self._data = {name: random.normal(0, width, COUNT) for name, width in (
            ("x", 1e-3), ("y", 1e-3), ("z", 1e-3), ("px", 1e4), ("py", 1e4))}
        self._data["pz"], self._data["t"] = random.normal(1e8, 1e5, COUNT), numpy.zeros(COUNT)
        self._data["id"] = numpy.arange(1, COUNT + 1)
        self.weight = numpy.full(COUNT, 1e-12)
        self.status = numpy.where(numpy.arange(COUNT) % 10, 1, 2)

    def __getitem__(self, key):
        return self._data[key]
