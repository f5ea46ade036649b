# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the desk share: datasets, a server, and a viewer with the beam in it."""
import functools
import json
import subprocess
import unittest

import numpy

import hand

PANEL = 940  # the panel's left edge in a window of 1280


@functools.cache
def data():
    """A beam of six steps and its run, a plot of other axes, a volume, a surface; made once."""
    folder = hand.new_folder()
    prep = lambda *arguments: subprocess.run([hand.BIN / "mote-prep", *map(str, arguments)], check=True,
                                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    prep("synth", "beam", "--particles", 20000, "--steps", 6, "--seed", 1, "--out", folder / "run.h5")
    prep("particles", folder / "run.h5", "--axes", "x,px,y", "--out", folder / "beam.mote")
    size = 24
    z, y, x = numpy.mgrid[:size, :size, :size] - (size - 1) / 2
    ball = numpy.clip(255 * (1 - numpy.sqrt(x * x + y * y + z * z) / size * 2), 0, 255).astype(numpy.uint8)
    (folder / "ball.raw").write_bytes(ball.tobytes())
    prep("volume", folder / "ball.raw", "--dimensions", size, size, size, "--out", folder / "ct.mote")
    (folder / "cube.obj").write_text("".join(f"v {i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8)) + "".join(
        f"f {a + 1} {b + 1} {d + 1}\nf {a + 1} {d + 1} {c + 1}\n"
        for a, b, c, d in ((0, 2, 1, 3), (4, 5, 6, 7), (0, 1, 4, 5), (2, 6, 3, 7), (0, 4, 2, 6), (1, 3, 5, 7))))
    prep("mesh", folder / "cube.obj", "--title", "Dipole", "--out", folder / "magnet.mote")
    return folder


def warm(picture):
    """Where the beam is: neither grey nor blue."""
    r, b = picture[..., 0].astype(int), picture[..., 2].astype(int)
    return (r > 90) & (r > b + 40)


@unittest.skipIf(hand.missing(), hand.missing())
class DeskCase(unittest.TestCase):
    """A server with its data, and a person before it."""

    LIST = (0, 80, PANEL, 720)  # of the datasets

    @classmethod
    def setUpClass(cls):
        cls.folder = hand.new_folder()
        cls.server = hand.Server(cls.folder, data())

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def viewer(self, *more, **how):
        viewer = hand.Viewer(["--connect", self.server.connection, *more], **how)
        self.addCleanup(viewer.close)
        return viewer

    def beam(self, *more, **how):
        """The viewer with the beam in it, at rest."""
        viewer = self.viewer(*more, **how)
        viewer.see("exact", within=(viewer.size[0] - 340, 60, viewer.size[0], 110))
        viewer.until(lambda: warm(viewer.picture()[:, :PANEL]).sum() > 2000, "the beam")
        return viewer

    def saved(self, name, view):
        path = self.folder / name
        path.write_text(json.dumps(view), encoding="utf-8")
        return path
