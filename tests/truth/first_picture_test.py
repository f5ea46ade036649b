# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn first of anything, where a view says a dataset and a kind and nothing else: all of it, upright, from
the front, as large as may be, in tones that can be read. Data are generated; real pictures where there are any."""
import json
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

import numpy
from PIL import Image

BIN = pathlib.Path(os.environ["MOTE_BIN"])
ROOT = pathlib.Path(__file__).resolve().parents[2]
REAL = pathlib.Path(os.environ.get("MOTE_SHARED_DATA", ROOT.parent / "shared" / "data")) / "images"


def linear(encoded):
    return numpy.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def luminance(picture):
    return linear(picture) @ [0.2126, 0.7152, 0.0722]


def blurred(picture, sigma):
    reach = int(4 * sigma)
    kernel = numpy.exp(-0.5 * (numpy.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    for axis in (0, 1):
        padded = numpy.pad(picture, [(reach, reach) if a == axis else (0, 0) for a in (0, 1)], mode="symmetric")
        picture = numpy.apply_along_axis(lambda line: numpy.convolve(line, kernel, "valid"), axis, padded)
    return picture


class Desk:
    """A folder of datasets, and their pictures."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def run(self, *arguments):
        done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr

    def prepare(self, name, kind, *arguments):
        self.run(BIN / "mote-prep", kind, *arguments, "--quiet", "--out", self.path / f"{name}.mote")

    def draw(self, layers, size=(400, 300), **more):
        view = {"width": size[0], "height": size[1], "layers": layers, **more}
        (self.path / "views.json").write_text(json.dumps({"views": [view]}), encoding="utf-8")
        self.run(BIN / "mote-frames", self.path / "views.json", "--spawn", f"d={self.path}", "--device", "cpu", "--quiet",
                 "--out", self.path / "out")
        return numpy.asarray(Image.open(self.path / "out" / "frame-000000.png").convert("RGB")) / 255.0

    def first(self, name, kind, **more):
        return self.draw([{"dataset": f"d/{name}", kind: {}}], **more)


def lit(picture):
    return numpy.abs(picture - picture[0, 0]).max(axis=2) > 3 / 255


def mesh_text(vertices, triangles):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in vertices) + "".join(f"f {a} {b} {c}\n" for a, b, c in triangles)


class FirstPicture(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.desk = Desk()

    @classmethod
    def tearDownClass(cls):
        cls.desk.folder.cleanup()

    def assert_fits(self, picture, name):
        seen = lit(picture)
        rows, columns = numpy.nonzero(seen.any(axis=1))[0], numpy.nonzero(seen.any(axis=0))[0]
        high, wide = numpy.ptp(rows) + 1, numpy.ptp(columns) + 1
        fuller = max(high / seen.shape[0], wide / seen.shape[1])
        self.assertGreater(fuller, 0.85, name)
        self.assertLess(fuller, 0.95, name)
        for places, side in ((rows, seen.shape[0]), (columns, seen.shape[1])):
            if (numpy.ptp(places) + 1) / side > 0.85:
                self.assertAlmostEqual((places.min() + places.max() + 1) / 2 / side, 0.5, delta=0.02, msg=name)

    def particles(self, name, points):
        table = self.desk.path / f"{name}.csv"
        numpy.savetxt(table, points, delimiter=",", header="x [m],y [m],z [m]", comments="")
        self.desk.prepare(name, "particles", table, "--axes", "x,y,z")

    def test_all_of_it_is_seen_and_as_large_as_may_be(self):
        random = numpy.random.default_rng(3)
        turn = numpy.linalg.qr(random.normal(size=(3, 3)))[0]
        cigar = random.normal(size=(5000, 3)) * [3, 0.3, 0.3] @ turn
        self.particles("cigar", cigar)
        # One far out alone decides over the plot's box; what is selected lies in a corner of it.
        self.particles("stray", numpy.r_[0.3 * random.normal(size=(20000, 3)), [[4, 4, 4]]])
        self.assert_fits(self.desk.first("cigar", "particles"), "cigar")
        chosen = {"ranges": [{"column": "x", "max": 3}]}
        self.assert_fits(self.desk.draw([{"dataset": "d/stray", "particles": {}, "select": chosen}]), "selection")
        corners = random.normal(size=(4, 3)) * [1, 4, 1]
        (self.desk.path / "solid.obj").write_text(mesh_text(corners, [(1, 2, 3), (1, 2, 4), (1, 3, 4), (2, 3, 4)]),
                                                  encoding="utf-8")
        self.desk.prepare("solid", "mesh", self.desk.path / "solid.obj")
        for kind in ("mesh", "ink"):
            for size in ((400, 300), (300, 400), (900, 200)):
                self.assert_fits(self.desk.first("solid", kind, size=size), f"{kind} {size}")
        z, y, x = numpy.mgrid[0:60, 0:60, 0:60]
        ball = (numpy.hypot(numpy.hypot(x - 15, y - 40), 2 * (z - 20)) < 12) * 200
        (self.desk.path / "ball.raw").write_bytes(ball.astype("u1").tobytes())
        self.desk.prepare("ball", "volume", self.desk.path / "ball.raw", "--dimensions", 60, 60, 60)
        for kind in ("hybrid", "ink"):
            self.assert_fits(self.desk.first("ball", kind), f"ball, {kind}")

    def volume_files(self, body, right_left, front_back):
        """One body [z, y, x] whose x grows to the right (1) or left (-1), y to the front (1) or back, in formats."""
        data = body.astype("<i2").tobytes()
        n = body.shape[0]
        words = f"{'right' if right_left > 0 else 'left'}-{'anterior' if front_back > 0 else 'posterior'}-superior"
        nrrd = (f"NRRD0004\ntype: int16\ndimension: 3\nspace: {words}\nsizes: {n} {n} {n}\nspace directions: (1,0,0) "
                "(0,1,0) (0,0,1)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n")
        yield "nrrd", nrrd.encode() + data
        # MetaImage's world is LPS, NIfTI's RAS.
        mha = (f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix = "
               f"{-right_left} 0 0 0 {-front_back} 0 0 0 1\nOffset = 0 0 0\nAnatomicalOrientation = RAI\nElementSpacing = "
               f"1 1 1\nDimSize = {n} {n} {n}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n")
        yield "mha", mha.encode() + data
        header = bytearray(352)
        struct.pack_into("<i", header, 0, 348)
        struct.pack_into("<8h", header, 40, 3, n, n, n, 1, 1, 1, 1)
        struct.pack_into("<hh", header, 70, 4, 16)
        struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
        struct.pack_into("<f", header, 108, 352.0)
        struct.pack_into("<hh", header, 252, 0, 1)
        struct.pack_into("<12f", header, 280, right_left, 0, 0, 0, 0, front_back, 0, 0, 0, 0, 1, 0)
        header[344:348] = b"n+1\0"
        yield "nii", bytes(header) + data

    def test_patients_stand_and_are_seen_from_before(self):
        n = 40
        z, y, x = numpy.mgrid[0:n, 0:n, 0:n]
        for right_left, front_back in ((1, 1), (-1, -1), (-1, 1)):
            right, front = right_left * (x - n / 2), front_back * (y - n / 2)
            # A long body; its head is above, its left arm hangs out, and a wide plate lies behind its feet.
            body = (numpy.hypot(right, front) < 6) & (z > 4) & (z < 36)
            body |= (right < 0) & (right > -16) & (abs(front) < 3) & (abs(z - 28) < 3)
            for kind, data in self.volume_files(100 * body, right_left, front_back):
                name = f"{kind}{right_left}{front_back}".replace("-", "m")
                file = self.desk.path / f"{name}.{kind}"
                file.write_bytes(data)
                self.desk.prepare(name, "volume", file)
                seen = lit(self.desk.first(name, "hybrid", size=(300, 300)))
                rows, columns = numpy.nonzero(seen.any(axis=1))[0], numpy.nonzero(seen.any(axis=0))[0]
                self.assertGreater(numpy.ptp(rows), 1.2 * numpy.ptp(columns), f"{name} lies")
                widths = seen.sum(axis=1)
                self.assertLess(widths.argmax(), rows.mean(), f"{name} stands on its head")
                trunk = numpy.nonzero(seen[rows.max() - 20])[0].mean()
                self.assertGreater(columns.max() - trunk, 1.5 * (trunk - columns.min()), f"{name} is seen from behind")

    def test_who_prepares_says_what_is_up(self):
        # A tall box along x, the file says nothing of that.
        corners = [(x, y, z) for x in (0, 6) for y in (0, 1) for z in (0, 1)]
        triangles = [(1, 2, 3), (2, 3, 4), (5, 6, 7), (6, 7, 8), (1, 2, 5), (2, 5, 6), (3, 4, 7), (4, 7, 8)]
        (self.desk.path / "tall.obj").write_text(mesh_text(corners, triangles), encoding="utf-8")
        self.desk.prepare("lies", "mesh", self.desk.path / "tall.obj")
        self.desk.prepare("stands", "mesh", self.desk.path / "tall.obj", "--up", "x", "--front", "z")
        for name, wide in (("lies", True), ("stands", False)):
            rows, columns = numpy.nonzero(lit(self.desk.first(name, "mesh", size=(300, 300))))
            self.assertEqual(numpy.ptp(columns) > numpy.ptp(rows), wide, name)

    def test_drawings_are_on_white_paper(self):
        self.desk.prepare("paper", "stipple", "plane", "--points", 1000, "--seed", 1)
        self.particles("few", numpy.random.default_rng(4).normal(size=(56, 3)))
        Image.fromarray(numpy.full((60, 80), 255, "u1")).save(self.desk.path / "blank.png")
        self.desk.prepare("blank", "image", self.desk.path / "blank.png")
        dots = {"dataset": "d/paper", "stipple": {"image": "d/blank"}}
        points = {"dataset": "d/few", "particles": {}}
        ink = {"dataset": "d/few", "ink": {}}
        for layers, paper in (([ink], 1), ([dots], 1), ([points], 0), ([points, ink], 0), ([], 0),
                              ([points | {"opacity": 0}, dots], 1)):
            self.assertEqual(self.desk.draw(layers)[0, 0].min(), paper, layers)
        self.assertEqual(self.desk.draw([ink], background=[0, 0, 0])[0, 0].max(), 0)

    def test_few_particles_are_seen_on_black_and_on_white(self):
        self.particles("handful", numpy.random.default_rng(5).normal(size=(56, 3)))
        for background in (0, 1):
            picture = self.desk.first("handful", "particles", size=(800, 600), background=[background] * 3)
            off = numpy.abs(picture - background).max(axis=2)
            self.assertGreater((off > 0.3).sum(), 2 * 56, "pixels that are seen at once")
            self.assertLess(((off > 3 / 255) & (off < 0.1)).sum(), 0.2 * (off > 3 / 255).sum())

    def assert_is_seen_well(self, picture, most, name):
        off = numpy.abs(picture - picture[0, 0]).max(axis=2)[lit(picture)]
        self.assertLess((off < 0.12).mean(), most, f"{name}: what is too dark to see")

    def test_little_is_too_dark_to_see(self):
        random = numpy.random.default_rng(6)
        bunch = random.normal(size=(100000, 3)) * [1, 0.5, 0.5]
        halo = random.uniform(-3, 3, size=(3000, 3))
        self.particles("bunch", numpy.r_[bunch, halo])
        self.assert_is_seen_well(self.desk.first("bunch", "particles", size=(800, 600)), 0.04, "bunch")
        z, y, x = numpy.mgrid[0:80, 0:80, 0:80]
        ball = 200 / (1 + numpy.exp((numpy.hypot(numpy.hypot(x - 40, y - 35), z - 45) - 25) / 1.5))
        ball += random.normal(size=ball.shape) * 4 + 20
        (self.desk.path / "soft.raw").write_bytes(ball.clip(0, 255).astype("u1").tobytes())
        self.desk.prepare("soft", "volume", self.desk.path / "soft.raw", "--dimensions", 80, 80, 80)
        self.assert_is_seen_well(self.desk.first("soft", "hybrid", size=(800, 600)), 0.01, "ball")

    def test_lone_points_on_white_are_no_darker_than_dense_matter(self):
        random = numpy.random.default_rng(7)
        core = 0.5 * random.normal(size=(200000, 3))
        halo = random.uniform(-3, 3, size=(4000, 3))
        self.particles("core", numpy.r_[core, halo])
        picture = self.desk.first("core", "particles", size=(600, 600), background=[1, 1, 1])
        tone = luminance(picture)
        matter = blurred(tone, 4).min()
        self.assertLess(matter, 0.5, "matter stands out")
        self.assertLess((tone < 0.7 * matter).mean(), 1e-4, "dots that are darker than matter")

    def test_a_film_begins_where_its_view_is_fitted(self):
        self.particles("off", numpy.random.default_rng(8).normal(size=(3000, 3)) * [1, 0.1, 0.1])
        view = {"width": 120, "height": 90, "layers": [{"dataset": "d/off", "particles": {}}]}
        moved = {**view, "layers": [{**view["layers"][0], "opacity": 0.5}]}
        for name, script in (("keyframes", {"fps": 2, "keyframes": [{"seconds": 0, "view": view},
                                                                    {"seconds": 1, "view": moved}]}),
                             ("moves", {"fps": 2, "view": view, "moves": [{"turn": {"degrees": 90}, "seconds": 1}]})):
            (self.desk.path / "film.json").write_text(json.dumps(script), encoding="utf-8")
            self.desk.run(BIN / "mote-frames", self.desk.path / "film.json", "--spawn", f"d={self.desk.path}",
                          "--device", "cpu", "--quiet", "--out", self.desk.path / name)
            first = numpy.asarray(Image.open(self.desk.path / name / "frame-000000.png").convert("RGB")) / 255.0
            self.assertTrue((first == self.desk.draw(view["layers"], size=(120, 90))).all(), name)

    def test_every_kind_is_cut_where_its_clip_says(self):
        random = numpy.random.default_rng(9)
        self.particles("cloud", random.uniform(-1, 1, size=(100000, 3)))
        corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
        triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
        (self.desk.path / "box.obj").write_text(mesh_text(corners, triangles), encoding="utf-8")
        self.desk.prepare("box", "mesh", self.desk.path / "box.obj")
        self.desk.prepare("dots", "stipple", self.desk.path / "box.obj", "--points", 20000, "--seed", 1)
        (self.desk.path / "full.raw").write_bytes(numpy.full((40, 40, 40), 200, "u1").tobytes())
        self.desk.prepare("full", "volume", self.desk.path / "full.raw", "--dimensions", 40, 40, 40, "--spacing", 0.05,
                          0.05, 0.05, "--origin", -0.975, -0.975, -0.975)
        curve = [{"value": 0, "opacity": 0.5}]
        camera = {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 3}
        clip = {"planes": [{"normal": [2, 0, 0], "distance": 0.5}], "box": {"min": [-2, -0.5, -2], "max": [2, 2, 2]}}
        for dataset, kind, style in (("cloud", "particles", {}), ("box", "mesh", {}),
                                     ("box", "ink", {}), ("dots", "stipple", {}), ("full", "hybrid", {"curve": curve})):
            layer = {"dataset": f"d/{dataset}", kind: style}
            whole = lit(self.desk.draw([layer], size=(300, 300), camera=camera))
            left = lit(self.desk.draw([{**layer, "clip": clip}], size=(300, 300), camera=camera))
            rows, columns = numpy.nonzero(left)
            # A hundred pixels are a unit; a line is a pixel or two wide, and ink wavers about its outline.
            self.assertGreater(columns.min(), 175 - 4, f"{dataset} {kind}")
            self.assertLess(rows.max(), 200 + 4, f"{dataset} {kind}")
            self.assertLess(columns.min(), 185, f"{dataset} {kind}")
            self.assertGreater(rows.max(), 190, f"{dataset} {kind}")
            self.assertLess(numpy.nonzero(whole)[1].min(), 70, f"{dataset} {kind}")

    def assert_has_its_tones(self, picture, name):
        Image.fromarray(picture).save(self.desk.path / f"{name}.png")
        self.desk.prepare(name, "image", self.desk.path / f"{name}.png")
        drawn = self.desk.draw([{"dataset": "d/plane", "stipple": {"image": f"d/{name}"}}],
                               size=picture.shape[1::-1])
        wanted = luminance(numpy.atleast_3d(picture / 255.0) * numpy.ones(3))
        error = numpy.mean((blurred(luminance(drawn), 4) - blurred(wanted, 4)) ** 2)
        self.assertGreater(-10 * numpy.log10(error), 33, name)

    def test_stippled_photographs_have_the_light_of_their_pictures(self):
        self.desk.prepare("plane", "stipple", "plane", "--points", 60000, "--seed", 1)
        y, x = numpy.mgrid[0:240, 0:320]
        ramp = 255 * x / 319
        rings = 127.5 + 127.5 * numpy.sin(numpy.hypot(x - 160, y - 120) / 9)
        forms = 40 + 60 * (y > 150) + 150 * (numpy.hypot(x - 110, y - 90) < 60)
        for name, picture in (("ramp", ramp), ("rings", rings), ("forms", forms)):
            self.assert_has_its_tones(numpy.round(picture).astype("u1"), name)
        for file in sorted(REAL.glob("*.png")) if REAL.is_dir() else []:
            self.assert_has_its_tones(numpy.asarray(Image.open(file).convert("RGB")), file.stem)


if __name__ == "__main__":
    unittest.main()
