#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""NRRD, NIfTI and MetaImage: one patient in every form that their specifications name lies at one place."""
import bz2
import gzip
import itertools
import subprocess
import unittest
import zlib

import nibabel
import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

import phantom
from phantom import OBLIQUE, PLACES, PLAIN, SIZES, VALUES
from support import Case, info, needs_program, run, volume, volumes

TYPES = {"int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
         "longlong": "i8", "ulonglong": "u8", "float": "f4", "double": "f8"}


def vector(numbers):
    return "(" + ",".join(f"{number:.17g}" for number in numbers) + ")"


def nrrd_place(place, space="LPS", said=None):
    """The lines of a NRRD header that say where voxels are that lie at `place` in RAS."""
    matrix = phantom.said_in(place, space)
    directions = " ".join(vector(matrix[:3, i]) for i in range(3))
    return f"space: {said or space}\nspace directions: {directions}\nspace origin: {vector(matrix[:3, 3])}\n"


def encoded(data, encoding):
    if encoding in ("gzip", "gz", "GZip"):
        return gzip.compress(data)
    if encoding in ("bzip2", "bz2"):
        return bz2.compress(data)
    if encoding == "hex":
        text = data.hex()
        return "\n".join(text[i:i + 70] for i in range(0, len(text), 70)).encode()
    return data


@needs_program
class Nrrd(Case):
    def write(self, header, data=b"", name="a.nrrd"):
        path = self.folder / name
        path.write_bytes(b"NRRD0005\n" + header.encode() + b"\n" + data)
        return path

    def header(self, kind="int8", more="", encoding="raw", endian="little"):
        return (f"type: {kind}\ndimension: 3\nsizes: {SIZES[0]} {SIZES[1]} {SIZES[2]}\nencoding: {encoding}\n"
                f"endian: {endian}\n{more}")

    def test_every_type_encoding_and_byte_order(self):
        variants = {}
        for kind, encoding, endian in itertools.product(TYPES, ("raw", "gzip", "bzip2", "hex", "GZip"),
                                                        ("little", "big")):
            order = "<" if endian == "little" else ">"
            data = encoded(VALUES.astype(order + TYPES[kind]).tobytes(), encoding)
            what = f"{kind}-{encoding}-{endian}"
            variants[what] = self.write(self.header(kind, nrrd_place(OBLIQUE), encoding, endian), data, what + ".nrrd")
        self.all_same(variants, VALUES, OBLIQUE)

    def test_what_teem_writes(self):
        """Files by teem itself, from ours that is raw."""
        plain = self.write(self.header("short", nrrd_place(OBLIQUE, "LAS")), VALUES.astype("<i2").tobytes())
        variants = {}
        for encoding, ending, endian in itertools.product(("raw", "ascii", "hex", "gzip", "bzip2"),
                                                          ("nrrd", "nhdr"), ("little", "big")):
            if (encoding, endian) == ("ascii", "big"):
                continue  # teem 1.12 swaps the bytes first, and writes other numbers
            path = self.folder / f"{encoding}-{endian}.{ending}"
            done = subprocess.run(["teem-unu", "save", "-f", "nrrd", "-e", encoding, "-en", endian, "-i", plain, "-o", path],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            variants[path.name] = path
        self.all_same(variants, VALUES, OBLIQUE)

    def test_every_space(self):
        data = VALUES.astype("u1").tobytes()
        words = {"RAS": ("right-anterior-superior", "RAS", "Right-Anterior-Superior", "ras"),
                 "LAS": ("left-anterior-superior", "LAS", "LEFT-ANTERIOR-SUPERIOR"),
                 "LPS": ("left-posterior-superior", "LPS", "Left-posterior-superior", "lps")}
        for (name, place), (space, spellings) in itertools.product(PLACES.items(), words.items()):
            variants = {said: self.write(self.header("uchar", nrrd_place(place, space, said)), data, f"{i}.nrrd")
                        for i, said in enumerate(spellings)}
            made = self.all_same(variants, VALUES, place)
            self.assertEqual(made.space, "ras", name)
            self.assertEqual(made.source_space, words[space][0])
            self.all_same(variants, VALUES, numpy.diag([-1, -1, 1, 1]) @ place, ("--space", "lps"))
            self.all_same(variants, VALUES, phantom.said_in(place, space), ("--space", "file"))

    def test_spaces_that_are_no_patients(self):
        data = VALUES.astype("u1").tobytes()
        place = nrrd_place(OBLIQUE, "RAS", "3D-right-handed")
        self.same(volume(self.write(self.header("uchar", place), data)), VALUES, OBLIQUE)
        made = volume(self.write(self.header("uchar", nrrd_place(OBLIQUE, "RAS", "3D-left-handed")), data))
        self.same(made, VALUES, numpy.diag([1, 1, -1, 1]) @ OBLIQUE)
        self.assertIn("left-handed", made.notes)
        made = volume(self.write(self.header("uchar", "space dimension: 3\n" + nrrd_place(OBLIQUE, "RAS").split("\n", 1)[1]),
                                 data))
        self.same(made, VALUES, OBLIQUE)
        self.assertEqual(made.space, "")

    def test_spacings_with_an_origin_of_space(self):
        data = VALUES.astype("u1").tobytes()
        more = "space: LPS\nspacings: 0.75 1.5 2.25\nspace origin: (12.5,-31.25,7)\n"
        self.same(volume(self.write(self.header("uchar", more), data)), VALUES,
                  phantom.affine(numpy.diag([-1, -1, 1])))

    def test_mins_and_maxs(self):
        data = VALUES.astype("u1").tobytes()
        more = "axis mins: 1 2 3\naxis maxs: 6 10 15\ncenters: cell cell cell\n"
        made = volume(self.write(self.header("uchar", more), data))
        self.same(made, VALUES, phantom.affine(numpy.eye(3), (1.5, 3, 4), (1, 2, 2)))
        more = "axis mins: 1 2 3\naxis maxs: 5 8 13\ncenters: node node node\n"
        self.same(volume(self.write(self.header("uchar", more), data)), VALUES,
                  phantom.affine(numpy.eye(3), (1, 2, 3), (1, 2, 2)))

    def test_files_beside_the_header(self):
        slices = [VALUES[z].astype("<i2").tobytes() for z in range(SIZES[2])]
        for z, data in enumerate(slices):
            (self.folder / f"s{z:02d}.raw").write_bytes(data)
            (self.folder / f"d{SIZES[2] - z:02d}.raw").write_bytes(data)
        variants = {}
        for i, field in enumerate(("s%02d.raw 0 5 1", "d%02d.raw 6 1 -1", "s%02d.raw 0 5 1 2",
                      "LIST\n" + "\n".join(f"s{z:02d}.raw" for z in range(SIZES[2])), "list 2\n" +
                      "\n".join(f"d{6 - z:02d}.raw" for z in range(SIZES[2])))):
            path = self.folder / f"{i}.nhdr"
            path.write_text("NRRD0004\n" + self.header("short", nrrd_place(PLAIN) + f"data file: {field}\n"),
                            encoding="ascii")
            variants[field] = path
        self.all_same(variants, VALUES, PLAIN)

    def test_skips(self):
        raw = VALUES.astype("<i2").tobytes()
        variants = {"lines": self.write(self.header("short", "line skip: 2\n"), b"a\nb\n" + raw, "lines.nrrd")}
        for encoding in ("raw", "gzip", "bzip2"):
            for skip, junk in (("-1", b"junk of any length"), ("7", b"1234567")):
                variants[encoding + skip] = self.write(self.header("short", f"byte skip: {skip}\n", encoding),
                                                       encoded(junk + raw, encoding), f"{encoding}{skip}.nrrd")
        self.all_same(variants, VALUES)

    def test_bytes_behind_the_data(self):
        raw = VALUES.astype("u1").tobytes()
        for encoding in ("raw", "gzip", "bzip2"):
            made = volume(self.write(self.header("uchar", "", encoding), encoded(raw + b"!", encoding)))
            self.same(made, VALUES, what=encoding)
            self.assertIn("a byte behind its last value was left out", made.notes)
            self.refused("and it holds", volume,
                         self.write(self.header("uchar", "", encoding), encoded(raw + raw, encoding)))
        self.refused("and it holds", volume, self.write(self.header("uchar"), raw[:-1]))

    def test_several_volumes_and_components(self):
        both = numpy.stack([VALUES, 119 - VALUES])
        common = "type: uchar\ndimension: 4\nencoding: raw\n"
        series = common + f"sizes: {SIZES[0]} {SIZES[1]} {SIZES[2]} 2\nkinds: space space space time\n"
        path = self.write(series, both.astype("u1").tobytes())
        for i, made in enumerate(volumes(path)):
            self.same(made, both[i])
        self.same(volume(path, "--field", 1), both[1])
        self.refused("has no number 2", volume, path, "--field", 2)
        parts = common + f"sizes: 2 {SIZES[0]} {SIZES[1]} {SIZES[2]}\nkinds: vector domain domain domain\n"
        path = self.write(parts, numpy.moveaxis(both, 0, -1).astype("u1").tobytes())
        self.refused("2 values for each voxel: ask for one of 0, 1", volume, path)
        self.same(volume(path, "--field", 1), both[1])
        four = f"{series}space: LPST\nspace directions: (1,0,0,0) (0,1,0,0) (0,0,2,0) (0,0,0,1)\n"
        self.same(volumes(self.write(four, both.astype("u1").tobytes()))[1], both[1],
                  numpy.diag([-1, -1, 2, 1]))

    def test_long_integers(self):
        labels = VALUES.astype("<i8") * 2 ** 40
        self.same(volume(self.write(self.header("int64"), labels.tobytes())), labels.astype(float))
        labels[0, 0, 0] += 1
        self.refused("64-bit integer", volume, self.write(self.header("int64"), labels.tobytes()))


@needs_program
class Nifti(Case):
    def save(self, image, name="a.nii"):
        nibabel.save(image, self.folder / name)
        return self.folder / name

    def test_every_type_version_byte_order_and_place(self):
        data = VALUES.transpose(2, 1, 0)
        for (name, place), second in itertools.product(PLACES.items(), (False, True)):
            variants = {}
            for kind, order in itertools.product(("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"), "<>"):
                form = nibabel.Nifti2Image if second else nibabel.Nifti1Image
                header = form.header_class(endianness=order)
                header.set_data_dtype(numpy.dtype(kind).newbyteorder(order))
                image = form(data.astype(kind), place, header)
                image.header.set_xyzt_units("mm")
                what = f"{name}-{kind}-{'big' if order == '>' else 'little'}-{second}"
                variants[what] = self.save(image, what + ".nii")
            self.all_same(variants, VALUES, nibabel.load(variants[what]).affine)

    def test_forms(self):
        data = VALUES.transpose(2, 1, 0).astype("i2")
        for (name, place), (sform, qform) in itertools.product(PLACES.items(), ((1, 0), (0, 1), (4, 3))):
            image = nibabel.Nifti1Image(data, place)
            image.set_sform(place, sform)
            image.set_qform(place, qform)
            path = self.save(image)
            self.same(volume(path), VALUES, nibabel.load(path).affine, f"{name} {sform} {qform}")
        image = nibabel.Nifti1Image(data, OBLIQUE)
        image.set_qform(OBLIQUE, 1)
        path = self.save(image)
        whole = bytearray(path.read_bytes())
        whole[280:328] = bytes(48)  # a sform that says nothing, though its code says that it does
        path.write_bytes(whole)
        made = volume(path)
        numpy.testing.assert_allclose(made.affine, OBLIQUE, atol=2e-5)
        self.assertIn("srow: is no map", made.notes)
        whole[252:254] = bytes(2)
        path.write_bytes(whole)
        made = volume(path)
        self.same(made, VALUES, numpy.diag([*phantom.SPACING, 1]))
        self.assertEqual(made.space, "")
        self.assertIn("says no orientation", made.notes)

    def test_containers_slopes_and_units(self):
        image = nibabel.Nifti1Image(VALUES.transpose(2, 1, 0).astype("i2"), OBLIQUE)
        image.header.set_slope_inter(0.5, -20)
        for unit, name in (("mm", "mm"), ("meter", "m"), ("micron", "um"), ("unknown", "mm")):
            image.header.set_xyzt_units(unit)
            made = volume(self.save(image, "a.nii.gz"))
            self.same(made, 0.5 * VALUES - 20, OBLIQUE)
            self.assertEqual(made.unit, name)
            self.assertEqual("does not say the unit of its lengths" in made.notes, unit == "unknown")
        self.assertEqual(volume(self.folder / "a.nii.gz", "--unit", "cm").unit, "cm")
        pair = nibabel.Nifti1Pair(VALUES.transpose(2, 1, 0).astype("i2"), OBLIQUE)
        nibabel.save(pair, self.folder / "b.hdr")
        self.same(volume(self.folder / "b.hdr"), VALUES, OBLIQUE)

    def test_times(self):
        both = numpy.stack([VALUES, 119 - VALUES, VALUES[::-1]])
        image = nibabel.Nifti1Image(both.transpose(3, 2, 1, 0).astype("u1"), OBLIQUE)
        image.header.set_xyzt_units("mm", "msec")
        image.header.set_zooms((*phantom.SPACING, 1500))
        path = self.save(image)
        made = volumes(path)
        self.assertEqual(len(made), 3)
        for i, step in enumerate(made):
            self.same(step, both[i], OBLIQUE)
            self.assertAlmostEqual(step.manifest["hybrid"]["steps"][i].get("time", 0), 1.5 * i)
        self.same(volume(path, "--field", 2), both[2], OBLIQUE)
        self.refused("has no number 3", volume, path, "--field", 3)
        self.refused("3 volumes: ask for one of 0, 1, 2",
                     lambda: run("mesh", path, "--isovalue", 60, "--out", self.folder / "m.mote"))


@needs_program
class MetaImage(Case):
    def header(self, place, kind="MET_SHORT", more="", data="LOCAL"):
        matrix = phantom.said_in(place, "LPS")
        spacing = numpy.linalg.norm(matrix[:3, :3], axis=0)
        directions = (matrix[:3, :3] / spacing).T.ravel()
        text = " ".join(f"{number:.17g}" for number in directions)
        return (f"ObjectType = Image\nNDims = 3\nTransformMatrix = {text}\n"
                f"Offset = {' '.join(f'{x:.17g}' for x in matrix[:3, 3])}\n"
                f"ElementSpacing = {' '.join(f'{x:.17g}' for x in spacing)}\n"
                f"DimSize = {SIZES[0]} {SIZES[1]} {SIZES[2]}\nElementType = {kind}\n{more}ElementDataFile = {data}\n")

    def test_every_type_order_and_place(self):
        kinds = {"MET_CHAR": "i1", "MET_UCHAR": "u1", "MET_SHORT": "i2", "MET_USHORT": "u2", "MET_INT": "i4",
                 "MET_UINT": "u4", "MET_LONG_LONG": "i8", "MET_FLOAT": "f4", "MET_DOUBLE": "f8"}
        for name, place in PLACES.items():
            variants = {}
            for (kind, numbers), msb, packed in itertools.product(kinds.items(), (False, True), (False, True)):
                data = VALUES.astype((">" if msb else "<") + numbers).tobytes()
                more = (f"BinaryData = True\nBinaryDataByteOrderMSB = {msb}\nCompressedData = {packed}\n"
                        f"AnatomicalOrientation = RAI\n")
                what = f"{name}-{kind}-{msb}-{packed}"
                variants[what] = self.folder / (what + ".mha")
                variants[what].write_bytes(self.header(place, kind, more).encode() +
                                           (zlib.compress(data) if packed else data))
            made = self.all_same(variants, VALUES, place)
            self.assertEqual(made.source_space, "left-posterior-superior")

    def test_as_vtk_reads_it(self):
        path = self.folder / "a.mha"
        path.write_bytes(self.header(PLAIN).encode() + VALUES.astype("<i2").tobytes())
        reader = vtk.vtkMetaImageReader()
        reader.SetFileName(str(path))
        reader.Update()
        image = reader.GetOutput()
        read = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
        made = volume(path, "--space", "file")
        self.same(made, read)
        numpy.testing.assert_allclose(made.sizes, image.GetSpacing())
        numpy.testing.assert_allclose(made.affine[:3, 3], image.GetOrigin())

    def test_series_and_channels(self):
        both = numpy.stack([VALUES, 119 - VALUES])
        path = self.folder / "a.mha"
        text = self.header(PLAIN, "MET_UCHAR", "ElementNumberOfChannels = 2\n")
        path.write_bytes(text.encode() + numpy.moveaxis(both, 0, -1).astype("u1").tobytes())
        self.refused("2 values for each voxel", volume, path)
        self.same(volume(path, "--field", 1), both[1], PLAIN)


@needs_program
class Together(Case):
    def test_one_patient_lies_at_one_place(self):
        """Of all formats, by default and where the other frame is asked for."""
        nrrd, meta, nifti = self.folder / "a.nrrd", self.folder / "a.mha", self.folder / "a.nii"
        data = VALUES.astype("<i2").tobytes()
        for place in PLACES.values():
            nibabel.save(nibabel.Nifti1Image(VALUES.transpose(2, 1, 0).astype("i2"), place), nifti)
            meta.write_bytes(MetaImage().header(place).encode() + data)
            nrrd.write_bytes(b"NRRD0005\n" + Nrrd().header("short", nrrd_place(place, "LAS")).encode() + b"\n" + data)
            for options, frame in (((), "RAS"), (("--space", "lps"), "LPS")):
                for path in (nrrd, meta, nifti):
                    self.same(volume(path, *options), VALUES, phantom.said_in(place, frame), f"{path} {options}")
        said = info(nrrd)
        for words in ("voxels   0.75 x 1.5 x 2.25", "origin   -12.5, 31.25, 7", "space    ras, the source's left-"):
            self.assertIn(words, said)
        self.refused("none of ras, lps and file", volume, nrrd, "--space", "las")

    def test_a_threshold_need_not_be_given(self):
        path = self.folder / "a.nrrd"
        path.write_bytes(b"NRRD0005\n" + Nrrd().header("uchar").encode() + b"\n" + VALUES.astype("u1").tobytes())
        self.assertIn("--threshold says another", volume(path).notes)


if __name__ == "__main__":
    unittest.main()
