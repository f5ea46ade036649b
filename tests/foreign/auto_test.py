# SPDX-License-Identifier: GPL-3.0-or-later
"""What mote-prep auto chooses of files of each kind, that mote-frames draws the view that it writes, and what it leaves
where it fails."""
import json
import struct
import subprocess
import unittest
import zlib

import numpy

import beams
from beams import Beam, table, write_text
from look_test import box
from support import BIN, Case, needs_program, run


def png(values):
    """A grey picture of 8 bits."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = b"".join(b"\0" + row.tobytes() for row in values.astype(numpy.uint8))
    head = struct.pack(">IIBBBBB", values.shape[1], values.shape[0], 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def nrrd(values):
    sizes = " ".join(map(str, values.shape[::-1]))
    return f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {sizes}\nencoding: raw\n\n".encode() + values.tobytes()


def noise(side):
    """A ball in noise: its samples can be left out of no form, and take their bytes."""
    z, y, x = numpy.mgrid[-1:1:side * 1j, -1:1:side * 1j, -1:1:side * 1j]
    ball = 120 * (x * x + y * y + z * z < 0.6)
    return (ball + numpy.random.default_rng(5).integers(0, 120, ball.shape)).astype(numpy.uint8)


@needs_program
class Auto(Case):
    def auto(self, name, *options):
        """What is chosen, by what it is of."""
        said = json.loads(run("auto", self.folder / name, "--out", self.out, "--json", *options))
        self.assertEqual(said["view"], str(self.folder / "made.view.json"))
        self.assertTrue(all(each["why"] for each in said["chosen"]), said)
        return {each["what"]: each["value"] for each in said["chosen"]} | {"made": said["kind"]}

    @property
    def out(self):
        return self.folder / "made.mote"

    def left(self):
        return sorted(path.name for path in self.folder.iterdir() if "made" in path.name)

    def draw(self):
        """The view's picture is not of one colour."""
        subprocess.run([BIN / "mote-frames", self.folder / "made.view.json", "--spawn", f"data={self.folder}", "--device", "cpu",
                        "--size", "64x48", "--format", "exr", "--out", self.folder / "pictures"], check=True, capture_output=True)
        picture = self.folder / "pictures" / "frame-000000.exr"
        self.assertGreater(len(set(picture.read_bytes()[-4096:])), 8)

    def write_beam(self, beam, species=("electrons",)):
        with beams.openpmd(self.folder / "run.h5") as file:
            for name in species:
                beams.write_species(file.require_group(f"/data/1/particles/{name}"), beam)

    def test_a_beam(self):
        self.write_beam(Beam())
        chosen = self.auto("run.h5")
        self.assertEqual((chosen["made"], chosen["axes"], chosen["volume"]), ("particles", "x,px,y", "32 cells a side"))
        view = json.loads((self.folder / "made.view.json").read_text(encoding="utf-8"))["views"][0]
        self.assertEqual(view["annotations"], dict.fromkeys(("axes", "colorBar", "scaleBar", "labels"), True))
        self.draw()
        self.assertEqual(self.left(), ["made.mote", "made.view.json"])

    def test_a_plasma_along_each_direction(self):
        for axis, axes in zip("xyz", ("x_c,px,y", "y_c,py,x", "zeta,pz,x")):
            beam = Beam()
            columns = {"x": beam.x, "y": beam.y, "z": beam.zeta, "px": beam.px, "py": beam.py, "pz": beam.px}
            columns[f"p{axis}"] = numpy.abs(beam.px) * 1e3
            names = {name: f"{name} [{'eV/c' if name[0] == 'p' else 'm'}]" for name in columns}
            write_text(self.folder / f"{axis}.csv", table(list(names.values()), list(columns.values())))
            out = self.folder / f"{axis}.mote"
            said = json.loads(run("auto", self.folder / f"{axis}.csv", "--out", out, "--json"))
            self.assertEqual({each["what"]: each["value"] for each in said["chosen"]}["axes"], axes)

    def test_columns_that_do_not_vary_come_last(self):
        beam = Beam()
        flat = numpy.zeros(beam.count)
        write_text(self.folder / "flat.csv", table(["x [m]", "y [m]", "z [m]", "px [eV/c]", "py [eV/c]", "pz [eV/c]"],
                                                   [beam.x, flat, beam.zeta, flat, flat, flat + 1e8]))
        self.assertEqual(self.auto("flat.csv")["axes"], "x,z,y")

    def test_of_several_species_the_largest(self):
        with beams.openpmd(self.folder / "run.h5") as file:
            for name, count in (("few", 50), ("many", 200), ("some", 90)):
                beams.write_species(file.require_group(f"/data/1/particles/{name}"), Beam(count))
        chosen = self.auto("run.h5")
        self.assertEqual(chosen["kind"], 'particles "many"')
        manifest = json.loads((self.out / "manifest.json").read_text(encoding="utf-8"))
        self.assertEqual(int(manifest["particles"]["steps"][0]["particles"]), 200)

    def test_a_volume_is_exact_where_that_is_cheap(self):
        z, y, x = numpy.mgrid[0:40, 0:40, 0:40]
        (self.folder / "ball.nrrd").write_bytes(nrrd((200 * ((x - 20)**2 + (y - 20)**2 + (z - 20)**2 < 200)).astype(numpy.uint8)))
        chosen = self.auto("ball.nrrd")
        self.assertEqual((chosen["made"], chosen["form"]), ("hybrid", "all 40 samples along its longest axis"))
        self.draw()
        self.assertEqual(self.left(), ["made.mote", "made.view.json"])

    def test_a_volume_that_does_not_fit_is_not(self):
        steps = (numpy.arange(226) // 8 % 2).astype(numpy.uint8)
        boxes = 200 * (steps[:, None, None] ^ steps[None, :, None] ^ steps[None, None, :])
        (self.folder / "boxes.nrrd").write_bytes(nrrd(boxes))  # three bytes a sample are more than a quarter of 128 MiB
        self.assertRegex(self.auto("boxes.nrrd", "--memory", "128M")["form"],
                         r"^64 samples, and residuals above 0\.\d+ of the range$")

    def test_meshes_and_pictures(self):
        write_text(self.folder / "cube.obj", box())
        self.assertEqual(self.auto("cube.obj")["style"], "mesh")
        self.draw()
        for path in (self.folder / "made.view.json",):
            path.unlink()
        self.out.rename(self.folder / "cube.mote")
        (self.folder / "ramp.png").write_bytes(png(numpy.tile(numpy.arange(0, 240, 4), (40, 1))))
        self.assertEqual(self.auto("ramp.png")["style"], "stipples")
        self.assertEqual(self.left(), ["made-dots.mote", "made.mote", "made.view.json"])
        self.draw()

    def test_what_is_there_is_not_replaced(self):
        self.write_beam(Beam())
        for name in ("made.mote", "made.view.json", "made-dots.mote"):
            there = self.folder / name
            write_text(there, "mine")
            self.refused("exists, and is not replaced", run, "auto", self.folder / "run.h5", "--out", self.out)
            self.assertEqual((self.left(), there.read_text(encoding="utf-8")), ([name], "mine"))
            there.unlink()

    def test_damage_leaves_nothing(self):
        (self.folder / "short.nrrd").write_bytes(nrrd(noise(40))[:-1000])
        write_text(self.folder / "words.txt", "nothing that anybody reads\n")
        for name in ("short.nrrd", "words.txt"):
            self.refused(name, run, "auto", self.folder / name, "--out", self.out)
            self.assertEqual(self.left(), [])
        self.refused("--out", run, "auto", self.folder / "words.txt", "--out", self.folder / "made")


if __name__ == "__main__":
    unittest.main()
