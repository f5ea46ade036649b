# SPDX-License-Identifier: GPL-3.0-or-later
"""A beam that the tests of foreign particle files write in every way, and datasets of particles read back without code of
ours."""
import dataclasses
import tempfile
import pathlib

import h5py
import numpy

from support import make

C, E = 299792458.0, 1.602176634e-19
ELECTRON, PROTON = 510998.95, 938272088.16  # eV
AXES = "x,y,px"


@dataclasses.dataclass
class Step:
    """Columns in the order of their ids, or of x, and how far a value may be from what was written, by column."""
    columns: dict
    resolution: dict
    time: float
    iteration: int

    def __getitem__(self, name):
        return self.columns[name]


@dataclasses.dataclass
class Run:
    steps: list
    notes: str
    mass: float
    species: str
    charge: float
    weight_unit: str
    statistics: dict  # of the first step


def read(path, *options, axes=AXES):
    """What mote-prep particles makes of a file: every column of every step."""
    paths = path if isinstance(path, list) else [path]
    with tempfile.TemporaryDirectory() as folder:
        made = pathlib.Path(folder) / "a.mote"
        manifest = make("particles", made, *paths, "--axes", axes, "--lost", "with", *options)["particles"]
        names = [column["name"] for column in manifest["columns"]]
        steps = []
        for entry in manifest["steps"]:
            columns, resolution = {}, dict(zip(names, entry.get("columnResolution", [0] * len(names))))
            with h5py.File(made / entry["columnsFile"]) as file:
                # Without ids the order of the rows is not kept: then they are those of rising x.
                key = "id" if "id" in file["/columns"] else "x"
                columns["id"] = file["/columns/" + key][...]
                order = numpy.argsort(columns["id"], kind="stable")
                columns["id"] = columns["id"][order]
                for name, offset in zip(names, entry["columnOffset"]):
                    columns[name] = (file["/columns/" + name][...].astype(float) + offset)[order]
            steps.append(Step(columns, resolution, entry.get("time", 0.0), int(entry.get("iteration", 0))))
        return Run(steps, "\n".join(manifest.get("notes", [])), manifest.get("mass", 0.0), manifest.get("species", ""),
                   manifest.get("particleCharge", 0.0), manifest.get("weightUnit", ""),
                   dict(zip(manifest.get("statisticNames", []), manifest["steps"][0].get("statistics", []))))


class Beam:
    """Particles around a reference particle of mass and p0 (eV), by ids from 1; a few are lost."""

    def __init__(self, count=120, mass=ELECTRON, p0=1.0e8, charge=-1, seed=31):
        random = numpy.random.default_rng(seed)
        self.count, self.mass, self.p0, self.charge = count, mass, p0, charge
        self.id = random.permutation(count) + 1
        self.x, self.y = 1e-4 * random.standard_normal((2, count))
        self.zeta = 2e-5 * random.standard_normal(count)
        self.px, self.py = 5e-3 * p0 * random.standard_normal((2, count))
        self.delta = 1e-2 * random.standard_normal(count)
        self.p = p0 * (1 + self.delta)
        self.pz = numpy.sqrt(self.p**2 - self.px**2 - self.py**2)
        self.weight = random.uniform(1e4, 1e5, count)
        self.lost = random.random(count) < 0.1
        self.gamma = numpy.sqrt((self.p / mass) ** 2 + 1)
        self.e0 = numpy.hypot(p0, mass)
        self.beta0 = p0 / self.e0
        self.pt = (numpy.hypot(self.p, mass) - self.e0) / p0
        self.t = -self.zeta / (self.beta0 * C)

    @property
    def order(self):
        return numpy.argsort(self.id)

    def hold(self, case, step, names="x y px py pz", what="", ids=True, **others):
        """The step has the beam: each value to its column's resolution, and what float64 loses on the way."""
        order = self.order if ids else numpy.argsort(self.x)
        expected = {name: getattr(self, name) for name in names.split()} | others
        for name, values in expected.items():
            case.assertIn(name, step.columns, what)
            values = numpy.asarray(values, float)[order]
            near = 0.51 * step.resolution[name] + 1e-9 * abs(values).max()
            numpy.testing.assert_allclose(step[name], values, rtol=0, atol=near, err_msg=f"{what}: {name}")


def write_text(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def table(names, columns, separator=",", fmt="%.15g"):
    rows = [separator.join(names)] if names else []
    rows += [separator.join(fmt % value for value in row) for row in zip(*columns)]
    return "\n".join(rows) + "\n"


def component(group, name, values, unit=1.0, **options):
    item = group.create_dataset(name, data=values, **options)
    item.attrs["unitSI"] = unit
    return item


def constant(group, name, value, shape):
    item = group.create_group(name)
    item.attrs["value"] = value
    item.attrs["unitSI"] = 1.0
    if shape is not None:
        item.attrs["shape"] = numpy.array(shape, dtype="u8")
    return item


def write_species(group, beam, **options):
    """Records in SI units; momenta in eV/c by their unitSI."""
    for axis, values in zip("xyz", (beam.x, beam.y, beam.zeta)):
        component(group, "position/" + axis, values, **options)
    for axis, values in zip("xyz", (beam.px, beam.py, beam.pz)):
        component(group, "momentum/" + axis, values, E / C, **options)
    component(group, "weighting", beam.weight, **options)
    component(group, "id", beam.id.astype("u8"), **options)
    return group


def openpmd(path, base="/data/%T/", particles="particles/", root="/", encoding="groupBased"):
    """A file with the root's attributes, open for writing."""
    file = h5py.File(path, "w")
    attributes = file.require_group(root).attrs
    for name, value in (("openPMD", "1.1.0"), ("basePath", base), ("particlesPath", particles),
                        ("iterationEncoding", encoding)):
        attributes[name] = numpy.bytes_(value)
    attributes["openPMDextension"] = numpy.uint32(0)
    return file
