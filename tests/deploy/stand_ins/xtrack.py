# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for xsuite in the commands of docs/PYTHON.md: names, units and types of what its Particles give."""
import numpy


class Particles:
    """Protons."""

    def __init__(self, **columns):
        length = len(columns["x"])
        self._fields = {name: numpy.array(values) for name, values in columns.items() if name != "p0c"}
        for name in ("y", "py"):
            self._fields.setdefault(name, numpy.zeros(length))
        self._fields |= {"p0c": numpy.full(length, columns["p0c"]), "weight": numpy.ones(length),
                         "state": numpy.ones(length, int), "particle_id": numpy.arange(length)}

    def to_dict(self):
        return {**self._fields, "mass0": 938272088.16, "q0": 1.0}
