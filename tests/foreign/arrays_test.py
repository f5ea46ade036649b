#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""NumPy arrays and maps of electron microscopes: every type, byte order and order of axes gives the same voxels."""
import gzip
import io
import itertools
import struct
import unittest
import zipfile

import h5py
import mrcfile
import numpy

import looked
import phantom
from phantom import SIZES, VALUES
from support import Case, needs_program, run, volume, volumes

UNIT = numpy.eye(4)


@needs_program
class Npy(Case):
    def save(self, values, name="a.npy"):
        numpy.save(self.folder / name, values)
        return self.folder / name

    def test_every_type_and_order(self):
        variants = {}
        for kind, order, fortran in itertools.product(("b1", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8"),
                                                      "<>", (False, True)):
            if kind == "b1":
                continue
            values = VALUES.astype(order + kind)
            what = f"{kind}-{'big' if order == '>' else 'little'}-{fortran}"
            variants[what] = self.save(numpy.asfortranarray(values) if fortran else values, what + ".npy")
        made = self.all_same(variants, VALUES, UNIT)
        self.assertIn("dimensions are z, y and x", made.notes)
        self.same(volume(self.save(VALUES > 60)), (VALUES > 60).astype(int))
        self.same(volume(self.save((VALUES / 16 - 3).astype("f2"))), VALUES / 16 - 3)

    def test_versions(self):
        for version in ((1, 0), (2, 0), (3, 0)):
            with open(self.folder / "a.npy", "wb") as file:
                numpy.lib.format.write_array(file, VALUES.astype("<i2"), version)
            self.same(volume(self.folder / "a.npy"), VALUES, UNIT)

    def test_spacing_is_given(self):
        made = volume(self.save(VALUES.astype("u1")), "--spacing", 1, 2, 3, "--origin", 4, 5, 6)
        numpy.testing.assert_allclose(made.affine, phantom.affine(numpy.eye(3), (4, 5, 6), (1, 2, 3)))

    def test_series(self):
        both = numpy.stack([VALUES, 119 - VALUES])
        for fortran in (False, True):
            path = self.save(numpy.asfortranarray(both.astype("u2")) if fortran else both.astype("u2"))
            steps = volumes(path)
            self.assertEqual(len(steps), 2)
            self.same(steps[1], both[1])
            self.same(volume(path, "--field", 0), both[0])
        self.refused("has no number 2", volume, path, "--field", 2)

    def test_archives(self):
        for save in (numpy.savez, numpy.savez_compressed):
            path = self.folder / "a.npz"
            save(path, density=VALUES.astype("i2"), spacing=numpy.ones(3))
            self.same(volume(path), VALUES, UNIT)
            save(path, density=VALUES.astype("i2"), other=numpy.stack([VALUES, 119 - VALUES]).astype("f4"))
            self.refused("holds several arrays: ask for one as the field; it holds density (6 x 4 x 5), other (2 x 6 x 4 x 5)",
                         volume, path)
            (said,), _ = looked.look(path)
            self.assertEqual([(each["name"], each["size"], each["steps"]) for each in said["found"] if each["kind"] == "volume"],
                             [("density", [*SIZES], 1), ("other", [*SIZES], 2)])
            self.same(volume(path, "--field", "density"), VALUES)
            self.same(volumes(path, "--field", "other")[1], 119 - VALUES)
            self.same(volume(path, "--field", "other:1"), 119 - VALUES)
            self.refused("has no array of the name", volume, path, "--field", "nothing")
        numpy.savez(self.folder / "b.npz", a=numpy.array([None]))
        self.refused("b.npz: a", volume, self.folder / "b.npz")
        # Damage in a volume that is not asked for is damage of the array.
        whole = bytearray(path.read_bytes())
        whole[whole.rindex(b"PK\1\2", 0, whole.rindex(b"PK\1\2")) - 8] ^= 0x55
        path.write_bytes(whole)
        self.refused("a.npz: other", volume, path, "--field", "other:0")

    def test_what_is_no_volume(self):
        self.refused("is an array of 4 x 5: a volume has three dimensions", volume, self.save(VALUES[0]))
        self.refused("three dimensions", volume, self.save(numpy.zeros((2, 2, 2, 2, 2))))
        self.refused("no plain numbers", volume, self.save(VALUES.astype("c8")))
        self.refused("no plain numbers", volume, self.save(VALUES.astype([("a", "f4"), ("b", "f4")])))
        self.refused("no voxels", volume, self.save(numpy.zeros((0, 4, 5))))
        big = VALUES.astype("i8") * 2 ** 40
        big[0, 0, 0] += 1
        self.refused("64-bit integer", volume, self.save(big))
        self.save(VALUES).write_bytes((self.folder / "a.npy").read_bytes()[:-3])
        self.refused("declares 960 bytes of data, and it holds 957", volume, self.folder / "a.npy")
        head = io.BytesIO()
        numpy.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": True, "shape": (60000, 60000, 60000)})
        (self.folder / "a.npy").write_bytes(head.getvalue() + bytes(100))
        self.refused("a.npy", volume, self.folder / "a.npy")


def mrc_head(values, mode, order="<", **fields):
    """The 1024 bytes of ccpem.ac.uk/mrc_format/mrc2014.php by hand; `values` [section, row, column]."""
    head = bytearray(1024)
    said = {"size": values.shape[::-1], "mode": (mode,), "start": (0, 0, 0), "grid": values.shape[::-1],
            "cell": (5.0, 4.0, 6.0), "angles": (90.0, 90.0, 90.0), "axes": (1, 2, 3), "group": (1,), "extended": (0,),
            "origin": (0.0, 0.0, 0.0), "map": b"MAP ", "stamp": b"\x44\x44\0\0" if order == "<" else b"\x11\x11\0\0", **fields}
    places = {"size": 0, "mode": 12, "start": 16, "grid": 28, "cell": 40, "angles": 52, "axes": 64, "group": 88, "extended": 92,
              "imod": 152, "origin": 196, "map": 208, "stamp": 212}
    for name, value in said.items():
        if not isinstance(value, bytes):
            kind = "f" if isinstance(value[0], float) else "i"
            value = struct.pack(f"{order}{len(value)}{kind}", *value)
        head[places[name]:places[name] + len(value)] = value
    return bytes(head)


@needs_program
class Mrc(Case):
    def write(self, values, mode=1, kind="i2", order="<", extra=b"", name="a.mrc", **fields):
        path = self.folder / name
        path.write_bytes(mrc_head(values, mode, order, **fields) + extra + values.astype(order + kind).tobytes())
        return path

    def test_every_mode_and_byte_order(self):
        variants = {}
        for (mode, kind), order in itertools.product(((0, "i1"), (1, "i2"), (2, "f4"), (6, "u2"), (12, "f2")), "<>"):
            what = f"{mode}{'little' if order == '<' else 'big'}"
            variants[what] = self.write(VALUES, mode, kind, order, name=what + ".mrc")
        made = self.all_same(variants, VALUES, UNIT)
        self.assertEqual(made.unit, "angstrom")
        self.same(volume(self.write(VALUES - 60, 0, "i1")), VALUES - 60)
        imod = struct.pack("<2i", 1146047817, 0)
        made = volume(self.write(VALUES + 100, 0, "u1", imod=imod))
        self.same(made, VALUES + 100)
        self.assertIn("no sign", made.notes)
        for stamp in (b"\x44\x41\0\0", b"\0\0\0\0"):
            self.same(volume(self.write(VALUES, stamp=stamp)), VALUES, UNIT)
        made = volume(self.write(VALUES, order=">", stamp=b"\0\0\0\0"))
        self.same(made, VALUES, UNIT)
        self.assertIn("MACHST", made.notes)

    def test_what_mrcfile_writes(self):
        for kind in ("int8", "int16", "float32", "uint16", "float16"):
            for packed in (None, "gzip"):
                path = self.folder / "a.mrc"
                with mrcfile.new(path, overwrite=True, compression=packed) as file:
                    file.set_data(VALUES.astype(kind))
                    file.voxel_size = phantom.SPACING
                    file.header.origin = phantom.ORIGIN
                    file.set_volume()
                made = volume(path)
                self.same(made, VALUES, phantom.affine(numpy.eye(3)), f"{kind} {packed}")
                with mrcfile.open(path) as file:
                    self.same(made, numpy.asarray(file.data))
                    numpy.testing.assert_allclose(made.sizes, list(file.voxel_size.tolist()), rtol=1e-6)

    def test_axes(self):
        """Columns, rows and sections along x, y and z in every order: a voxel lies where its density is."""
        cell = (2.0 * SIZES[0], 3.0 * SIZES[1], 5.0 * SIZES[2])
        for axes in itertools.permutations((0, 1, 2)):  # of columns, rows, sections
            stored = VALUES.transpose([2 - axes[2], 2 - axes[1], 2 - axes[0]])
            start = [(10, 20, 30)[axis] for axis in axes]
            path = self.write(stored, axes=[axis + 1 for axis in axes], start=start, cell=cell, grid=SIZES)
            made = volume(path)
            for index in numpy.ndindex(*made.values.shape):
                place = made.affine @ (*index[::-1], 1)
                x, y, z = numpy.rint(place[:3] / (2, 3, 5) - (10, 20, 30)).astype(int)
                numpy.testing.assert_allclose(place[:3], ((x + 10) * 2, (y + 20) * 3, (z + 30) * 5), rtol=1e-6)
                self.assertAlmostEqual(made.values[index], VALUES[z, y, x], delta=0.01)

    def test_part_of_a_cell(self):
        """Intervals of the cell, not voxels of the map, say how large a voxel is."""
        made = volume(self.write(VALUES, grid=(50, 40, 60), cell=(100.0, 120.0, 300.0), start=(3, -4, 5)))
        self.same(made, VALUES, phantom.affine(numpy.eye(3), (6, -12, 25), (2, 3, 5)))
        made = volume(self.write(VALUES, origin=(1.5, 2.5, -3.5), start=(3, -4, 5)))
        self.same(made, VALUES, phantom.affine(numpy.eye(3), (1.5, 2.5, -3.5), (1, 1, 1)))
        self.assertIn("goes before NXSTART", made.notes)

    def test_oblique_cells(self):
        made = volume(self.write(VALUES, angles=(90.0, 90.0, 120.0), cell=(10.0, 8.0, 12.0)))
        b = 2 * numpy.array([numpy.cos(numpy.radians(120)), numpy.sin(numpy.radians(120)), 0])
        expected = numpy.eye(4)
        expected[:3, :3] = numpy.column_stack([(2, 0, 0), b, (0, 0, 2)])
        self.same(made, VALUES, expected)
        self.assertIn("oblique", made.notes)
        made = volume(self.write(VALUES, angles=(70.0, 80.0, 100.0)))
        lengths, axes = numpy.linalg.norm(made.affine[:3, :3], axis=0), made.affine[:3, :3]
        numpy.testing.assert_allclose(lengths, 1, rtol=1e-6)
        cosines = [axes[:, i] @ axes[:, j] for i, j in ((1, 2), (0, 2), (0, 1))]
        numpy.testing.assert_allclose(cosines, numpy.cos(numpy.radians((70, 80, 100))), atol=1e-6)
        self.refused("no cell", volume, self.write(VALUES, angles=(10.0, 10.0, 170.0)))

    def test_extended_headers_stacks_and_gzip(self):
        self.same(volume(self.write(VALUES, extra=bytes(range(160)), extended=(160,))), VALUES, UNIT)
        path = self.write(VALUES)
        (self.folder / "a.map.gz").write_bytes(gzip.compress(path.read_bytes()))
        self.same(volume(self.folder / "a.map.gz"), VALUES, UNIT)
        both = numpy.concatenate([VALUES, 119 - VALUES])
        path = self.write(both, group=(401,), grid=SIZES)
        steps = volumes(path)
        self.assertEqual(len(steps), 2)
        self.same(steps[1], 119 - VALUES, UNIT)
        self.assertIn("stack of pictures", volume(self.write(VALUES, group=(0,))).notes)
        made = volume(self.write(VALUES, cell=(0.0, 0.0, 0.0), axes=(0, 0, 0)))
        self.same(made, VALUES, UNIT)
        self.assertIn("says no size of a voxel", made.notes)
        self.assertEqual(made.unit, "")

    def test_what_is_not_read(self):
        for mode in (3, 4, 16, 101, 7):
            self.refused(f"MODE: is {mode}", volume, self.write(VALUES, mode))
        self.refused("says axes 1, 1 and 3", volume, self.write(VALUES, axes=(1, 1, 3)))
        self.refused("a.mrc", volume, self.write(VALUES, size=(5, 4, 60000)))
        self.refused("nsymbt", volume, self.write(VALUES, extended=(-4,)))
        self.refused("NX", volume, self.write(VALUES, size=(5, -4, 6)))
        path = self.write(VALUES)
        path.write_bytes(path.read_bytes()[:-1])
        self.refused("and it holds 239", volume, path)


@needs_program
class NoVolumes(Case):
    def test_known_formats_say_what_to_do(self):
        """By their first bytes; none of these is a volume, and none is only "unknown"."""
        known = {b"CDF\1": "netCDF", b"\x89HDF\r\n\x1a\n": None, b"MATLAB 5.0 MAT-file": "scipy", b"SIMPLE  =": "FITS",
                 b"# vtk DataFile Version 3.0\n": "ParaView", b"# AmiraMesh BINARY\n": "Amira", b"ZISRAWFILE": "OME-TIFF",
                 b"\xda\xce\xbe\n": "ND2", b"!INTERFILE": "medcon", b"MATRIX72v": "ECAT", struct.pack("<i", 348): "Analyze",
                 b"\xff\xd8\xff\xe0": "JPEG", b"solid x\n": "mote-prep mesh", b"BZh9": "unpack", b"\x28\xb5\x2f\xfd": "unpack",
                 b"<?xml version='1.0'?><VTKFile type='RectilinearGrid'>": None, b"%PDF-1.4": "PDF"}
        for begin, words in known.items():
            path = self.folder / "a.bin"
            path.write_bytes(begin + bytes(2000))
            self.refused(words or "a.bin", volume, path)
        store = self.folder / "a.zarr"
        store.mkdir()
        (store / ".zarray").write_text("{}")
        self.refused("Zarr store", volume, store)
        with h5py.File(self.folder / "a.h5", "w") as file:
            file["a"] = VALUES
        self.refused("h5py reads it: numpy.save the array", volume, self.folder / "a.h5")


@needs_program
class Zip(Case):
    def test_other_archives(self):
        with zipfile.ZipFile(self.folder / "a.zip", "w") as archive:
            archive.writestr("a/b.txt", b"text")
        self.refused("is a zip archive without arrays (.npy) or DICOM files", volume, self.folder / "a.zip")
        (self.folder / "b.zip").write_bytes((self.folder / "a.zip").read_bytes()[:-8])
        self.refused("b.zip", volume, self.folder / "b.zip")
        self.refused("is none of auto", run, "volume", self.folder / "a.zip", "--format", "tiff", "--out", self.folder / "c.mote")


if __name__ == "__main__":
    unittest.main()
