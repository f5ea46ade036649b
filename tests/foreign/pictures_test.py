#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacks of pictures by tifffile and Pillow: stored numbers, voxel sizes, channels and frames."""
import itertools
import unittest

import numpy
import tifffile
from PIL import Image

from phantom import SIZES, VALUES
from support import Case, needs_program, volume, volumes

TWO = numpy.stack([VALUES, 119 - VALUES], axis=1)  # [z, channel, y, x]


def diagonal(x, y, z):
    return numpy.diag([x, y, z, 1])


@needs_program
class Tiff(Case):
    def write(self, data, name="a.tif", **options):
        path = self.folder / name
        tifffile.imwrite(path, data, **options)
        return path

    def test_every_type_order_compression_and_layout(self):
        variants = {}
        for kind, order, layout in itertools.product(("u1", "i1", "u2", "i2", "u4", "i4", "f2", "f4", "f8"), "<>",
                                                     ({}, {"tile": (16, 16)}, {"compression": "zlib"}, {"bigtiff": True},
                                                      {"rowsperstrip": 1})):
            what = f"{kind}-{'big' if order == '>' else 'little'}-{'-'.join(layout)}"
            variants[what] = self.write(VALUES.astype(kind), what + ".tif", byteorder=order, metadata=None, **layout)
        self.all_same(variants, VALUES)

    def test_meanings_of_grey(self):
        labels = (VALUES % 7).astype("u1")
        table = numpy.random.default_rng(3).integers(0, 65535, (3, 256), dtype="u2")
        paths = {"palette": self.write(labels, "p.tif", photometric="palette", colormap=table, metadata=None),
                 "white": self.write(labels, "w.tif", photometric="miniswhite", metadata=None),
                 "black": self.write(labels, "b.tif", photometric="minisblack", metadata=None)}
        made = self.all_same(paths, labels)
        self.assertIn("numbers of its palette", made.notes)
        self.assertIn("though 0 is white", made.notes)

    def test_bits(self):
        """As many as are said, and one where none are."""
        wide = numpy.random.default_rng(4).integers(0, 2, (4, 20, 24), dtype="u1")
        said = self.write(wide.astype(bool), photometric="minisblack", metadata=None)
        self.same(volume(said), wide)
        folder = self.folder / "none"
        folder.mkdir()
        for z, page in enumerate(wide):
            bits = numpy.packbits(page, axis=1).tobytes()
            tags = [(256, 4, 24), (257, 4, 20), (259, 3, 1), (262, 3, 1), (273, 4, 8), (278, 4, 20), (279, 4, len(bits))]
            at = 8 + len(bits)
            ifd = len(tags).to_bytes(2, "little")
            for tag, kind, value in tags:
                ifd += tag.to_bytes(2, "little") + kind.to_bytes(2, "little") + (1).to_bytes(4, "little")
                ifd += value.to_bytes(4, "little")
            (folder / f"{z}.tif").write_bytes(b"II*\0" + at.to_bytes(4, "little") + bits + ifd + bytes(4))
            self.assertEqual(numpy.asarray(Image.open(folder / f"{z}.tif")).sum(), page.sum())
        self.same(volume(folder), wide)

    def test_sizes_of_imagej(self):
        data = VALUES.astype("u2")
        for unit, name in (("micron", "um"), ("um", "um"), ("\\u00B5m", "um"), ("mm", "mm"), ("nm", "nm")):
            path = self.write(data, imagej=True, resolution=(2, 0.5), metadata={"unit": unit, "spacing": 3.5, "axes": "ZYX"})
            made = volume(path)
            self.same(made, VALUES, diagonal(0.5, 2, 3.5), unit)
            self.assertEqual(made.unit, name)

    def test_hyperstacks_of_imagej(self):
        frames = numpy.stack([TWO, TWO[::-1]])  # [t, z, c, y, x]
        path = self.write(frames.astype("u1"), imagej=True, resolution=(1, 1),
                          metadata={"axes": "TZCYX", "unit": "um", "spacing": 2, "finterval": 0.25})
        self.refused("2 values for each voxel: ask for one of 0, 1", volume, path)
        for channel in (0, 1):
            made = volumes(path, "--field", f":{channel}")
            self.assertEqual(len(made), 2)
            for t, step in enumerate(made):
                self.same(step, frames[t, :, channel], diagonal(1, 1, 2))
                self.assertAlmostEqual(step.manifest["hybrid"]["steps"][t].get("time", 0), 0.25 * t)
        self.same(volume(path, "--field", "1:1"), frames[1, :, 1])
        path = self.write(TWO.astype("u1"), imagej=True, metadata={"axes": "ZCYX"})
        self.refused("ask for one of 0, 1", volume, path)
        self.same(volume(path, "--field", 1), TWO[:, 1])

    def test_ome(self):
        axes = {"ZCYX": TWO, "CZYX": TWO.transpose(1, 0, 2, 3)}
        for order, data in axes.items():
            path = self.write(data.astype("u2"), "a.ome.tif", ome=True, metadata={
                "axes": order, "PhysicalSizeX": 0.5, "PhysicalSizeXUnit": "µm", "PhysicalSizeY": 750.0,
                "PhysicalSizeYUnit": "nm", "PhysicalSizeZ": 2.0, "PhysicalSizeZUnit": "µm",
                "Channel": {"Name": ["DAPI", "GFP"]}})
            self.refused("0 is DAPI, 1 is GFP", volume, path)
            for field, channel in ((0, 0), ("GFP", 1), ("DAPI", 0)):
                made = volume(path, "--field", field)
                self.same(made, TWO[:, channel], diagonal(0.5, 0.75, 2), f"{order} {field}")
                self.assertEqual(made.unit, "um")

    def test_shapes_of_tifffile(self):
        """Its own description tells of more axes than a stack has: never one behind the other."""
        path = self.write(TWO.transpose(1, 0, 2, 3).astype("u1"), photometric="minisblack")
        made = volumes(path)
        self.assertEqual(len(made), 2)
        for i, step in enumerate(made):
            self.same(step, TWO[:, i])

    def test_resolution_with_its_unit(self):
        for unit, resolution, size in (("CENTIMETER", (100, 50), (0.1, 0.2)), ("INCH", (254, 127), (0.1, 0.2))):
            path = self.write(VALUES.astype("u1"), metadata=None, resolution=resolution, resolutionunit=unit)
            made = volume(path)
            self.same(made, VALUES, diagonal(*size, size[0]), unit)
            self.assertEqual(made.unit, "mm")
            self.assertIn("how far apart its slices", made.notes)
        path = self.write(VALUES.astype("u1"), metadata=None, resolution=(2, 1), resolutionunit="NONE")
        self.same(volume(path), VALUES, diagonal(1, 2, 1))
        path = self.write(VALUES.astype("u1"), metadata=None, resolution=(72, 72), resolutionunit="INCH")
        self.same(volume(path), VALUES, numpy.eye(4))

    def test_samples_of_a_pixel(self):
        pixels = numpy.moveaxis(TWO, 1, -1).astype("u1")
        for planar in ("contig", "separate"):
            data = pixels if planar == "contig" else TWO.astype("u1")
            path = self.write(data, photometric="minisblack", planarconfig=planar, metadata=None)
            self.refused("2 values for each voxel", volume, path)
            self.same(volume(path, "--field", 1), TWO[:, 1], what=planar)
        colours = numpy.random.default_rng(5).integers(0, 255, (4, 5, 6, 3), dtype="u1")
        path = self.write(colours, photometric="rgb", metadata=None)
        made = volume(path)
        self.same(made, colours @ numpy.array([0.2126, 0.7152, 0.0722]))
        self.assertIn("their luminance", made.notes)
        self.same(volume(path, "--field", 2), colours[..., 2])

    def test_reduced_pages_are_left_out(self):
        path = self.folder / "a.tif"
        with tifffile.TiffWriter(path) as file:
            for page in VALUES.astype("u1"):
                file.write(page, metadata=None, contiguous=False)
                file.write(page[::2, ::2], metadata=None, subfiletype=1, contiguous=False)
        made = volume(path)
        self.same(made, VALUES)
        self.assertIn("reduced pictures", made.notes)


@needs_program
class Png(Case):
    def stack(self, pages, mode, **options):
        for z, page in enumerate(pages):
            picture = Image.fromarray(page, mode)
            if mode == "P":
                picture.putpalette(list(range(255, -1, -1)) * 3)
            picture.save(self.folder / f"{z}.png", **options)
        return self.folder

    def test_stored_numbers(self):
        labels = (VALUES % 7).astype("u1")
        made = volume(self.stack(labels, "P"))
        self.same(made, labels)
        self.assertIn("numbers of its palette", made.notes)
        self.same(volume(self.stack(labels % 2, "P", bits=1)), labels % 2)
        self.same(volume(self.stack(VALUES.astype("u1"), "L", dpi=(254, 127))), VALUES, diagonal(0.1, 0.2, 0.1))
        self.assertEqual(SIZES[2], len(labels))


if __name__ == "__main__":
    unittest.main()
