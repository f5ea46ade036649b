# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the Python package share: where the programs lie, and data that they make themselves."""
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "client" / "python"
BIN = pathlib.Path(os.environ.get("MOTE_BIN", ROOT / "build" / "release" / "bin"))
sys.path.insert(0, str(PACKAGE))

import mote  # noqa: E402

needs_server = unittest.skipUnless((BIN / "mote-server").exists() and (BIN / "mote-prep").exists(),
                                   f"the programs are not in {BIN}")


def prepare(*arguments):
    """Runs mote-prep."""
    subprocess.run([str(BIN / "mote-prep"), *map(str, arguments), "--quiet"], check=True, capture_output=True)


def make_beam(folder, particles=3000, steps=3):
    """A run and its plot beneath a folder: run.h5 and beam.mote."""
    prepare("synth", "beam", "--particles", particles, "--steps", steps, "--seed", 1, "--out", folder / "run.h5")
    prepare("particles", folder / "run.h5", "--axes", "x,px,y", "--out", folder / "beam.mote")


def spawn(folder, **options):
    return mote.spawn(data=folder, program=BIN / "mote-server", **options)


class Case(unittest.TestCase):
    """Errors of the package, held against what they should say."""

    @contextlib.contextmanager
    def fails(self, code, where=None, words=""):
        with self.assertRaises(mote.Error) as caught:
            yield caught
        error = caught.exception
        self.assertEqual(error.code, code, str(error))
        if where is not None:
            self.assertEqual(error.where, where, str(error))
        self.assertIn(words, str(error))
        self.assertNotIn("\n", str(error), "an error is one sentence")


class FolderCase(Case):
    """With a folder of each test's own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class BeamCase(Case):
    """With a server of the class's own, whose data beneath ``plots`` are a beam: ``ds``."""

    particles, steps = 3000, 3

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.plots = pathlib.Path(folder.name)
        make_beam(cls.plots, cls.particles, cls.steps)
        cls.session = spawn(cls.plots)
        cls.addClassCleanup(cls.session.close)
        cls.ds = cls.session["data/beam"]
