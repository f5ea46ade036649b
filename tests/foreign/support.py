# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of foreign files share: mote-prep run on a file, and its dataset read back without code of ours."""
import contextlib
import dataclasses
import json
import pathlib
import subprocess
import tempfile
import unittest

import h5py
import numpy
import zstandard

import counted
import looked
from looked import BIN

__all__ = ["BIN", "Case", "Mesh", "Refused", "Volume", "info", "make", "mesh", "needs_program", "run", "volume", "volumes"]
needs_program = unittest.skipUnless((BIN / "mote-prep").exists(), f"mote-prep is not in {BIN}")


class Refused(Exception):
    """What mote-prep says of a file that it does not take: one sentence."""


def run(*arguments):
    """mote-prep's output; Refused with its sentence where it fails."""
    done = subprocess.run([str(BIN / "mote-prep"), *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return done.stdout
    if done.returncode not in (1, 2):
        raise AssertionError(f"mote-prep ended with {done.returncode}: {done.stderr}")
    raise Refused(done.stderr.strip().splitlines()[-1])


def make(kind, made, *arguments, apart=False):
    """The manifest of the dataset that mote-prep makes; what look says of the same files is held to it. `apart`: each
    input is a variant of its own."""
    words = [str(word) for word in arguments]
    first = next((at for at, word in enumerate(words) if word.startswith("--")), len(words))
    inputs, options = words[:first], words[first:]
    try:
        run(kind, *arguments, "--out", made, "--quiet")
    except Refused:
        counted.add(looked.hold(kind, inputs, options, None), inputs, options, False)
        raise
    manifest = json.loads((made / "manifest.json").read_text(encoding="utf-8"))
    said = looked.hold(kind, inputs, options, manifest)
    for variant in [[each] for each in inputs] if apart else [inputs]:
        counted.add(said, variant, options, True)
    return manifest


@dataclasses.dataclass
class Volume:
    """A step of a hybrid volume at the source's own resolution; values [z, y, x]."""
    values: numpy.ndarray
    affine: numpy.ndarray  # 4 x 4, from indices x, y, z to the world
    unit: str
    space: str
    source_space: str
    notes: str
    manifest: dict

    @property
    def sizes(self):
        return numpy.linalg.norm(self.affine[:3, :3], axis=0)


@contextlib.contextmanager
def _dataset(kind, *arguments, apart=False):
    with tempfile.TemporaryDirectory() as folder:
        made = pathlib.Path(folder) / "a.mote"
        yield made, make(kind, made, *arguments, apart=apart)


def volumes(paths, *options, apart=False):
    """All steps of what mote-prep volume makes of a file, or of several of one size and place: 16 bits of the range
    of values."""
    inputs = [paths] if isinstance(paths, (str, pathlib.Path)) else paths
    with _dataset("volume", *inputs, "--low", 65536, "--value-bits", 16, *options, apart=apart) as (folder, manifest):
        hybrid = manifest["hybrid"]
        steps = []
        for step in hybrid["steps"]:
            plain = folder / "plain.h5"
            with open(folder / step["file"], "rb") as packed, open(plain, "wb") as out:
                zstandard.ZstdDecompressor().copy_stream(packed, out)
            with h5py.File(plain) as file:
                codes = file["/volume/value"][...].astype(float)
            values = step.get("valueMin", 0.0) + codes * step.get("valueStep", 0.0)
            affine = numpy.array(hybrid["indexToWorld"]).reshape(4, 4)
            steps.append(Volume(values.reshape(hybrid["sourceSize"][::-1]), affine, hybrid.get("worldUnit", ""),
                                hybrid.get("space", ""), hybrid.get("sourceSpace", ""),
                                "\n".join(hybrid.get("notes", [])), manifest))
        return steps


def info(path, *options):
    """What mote-prep info says of the dataset of a volume."""
    with _dataset("volume", path, *options) as (folder, _):
        return run("info", folder)


def volume(path, *options):
    steps = volumes(path, *options)
    assert len(steps) == 1, f"{len(steps)} steps"
    return steps[0]


@dataclasses.dataclass
class Mesh:
    """What mote-prep mesh makes of a file."""
    points: numpy.ndarray
    triangles: numpy.ndarray
    intersections: numpy.ndarray  # pairs of triangles
    notes: str
    manifest: dict

    @property
    def area(self):
        a, b, c = (self.points[self.triangles[:, i]].astype(float) for i in range(3))
        return float(numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1).sum() / 2)

    @property
    def enclosed(self):
        """The volume within, with the sign of the triangles' turn."""
        a, b, c = (self.points[self.triangles[:, i]].astype(float) for i in range(3))
        return float(numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6)


def mesh(path, *options):
    with _dataset("mesh", path, *options) as (folder, manifest):
        with h5py.File(folder / "mesh.h5") as file:
            pairs = file["/mesh/intersection"][...] if "intersection" in file["/mesh"] else numpy.zeros((0, 2), int)
            return Mesh(file["/mesh/position"][...], file["/mesh/triangle"][...], pairs,
                        "\n".join(manifest["mesh"].get("notes", [])), manifest)


class Case(unittest.TestCase):
    """A folder for each test, and ways to compare."""

    FORMATS = None  # those that the files of a test are of, as --format has them

    def setUp(self):
        looked.formats, looked.family = self.FORMATS, type(self).__name__
        counted.legal = "damage" not in self.id()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def same(self, made, values, affine=None, what=""):
        """Values [z, y, x] to the step of 16 bits, and places to 1e-6 of a voxel."""
        self.assertEqual(made.values.shape, values.shape, what)
        step = (float(values.max()) - float(values.min())) / 65535
        numpy.testing.assert_allclose(made.values, values, rtol=0, atol=0.51 * step + 1e-6 * abs(values).max(), err_msg=what)
        if affine is not None:
            numpy.testing.assert_allclose(made.affine, affine, rtol=1e-6, atol=1e-6, err_msg=what)

    def all_same(self, variants, values, affine=None, options=()):
        """Files of one size and place, by what each is: read as the steps of one series."""
        steps = volumes(list(variants.values()), *options, apart=True)
        self.assertEqual(len(steps), len(variants))
        for what, made in zip(variants, steps):
            self.same(made, values, affine, what)
        return steps[0]

    def refused(self, words, made, *arguments):
        with self.assertRaises(Refused) as caught:
            made(*arguments)
        self.assertIn(words, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))
