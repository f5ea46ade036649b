#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""DICOM: one patient in every form that is common lies where NIfTI has it, or is refused in a sentence."""
import gzip
import itertools
import shutil
import subprocess
import unittest
import zipfile

import nibabel
import numpy
from pydicom.sequence import Sequence
import phantom
from dicom_files import NAMES, PLAIN_SYNTAXES, DicomCase, blank, expected, item, numbers, save, slices, uid
from phantom import OBLIQUE, PLACES, SIZES, VALUES
from support import BIN, Refused, needs_program, run, volume, volumes


@needs_program
class Plain(DicomCase):
    def test_every_kind_of_number_in_every_syntax(self):
        forms = {"u1": (None,), "i1": (None, 7), "u2": (None, 12, 8), "i2": (None, 12), "u4": (None,), "i4": (None, 20)}
        for syntax, (kind, bits) in itertools.product(PLAIN_SYNTAXES, forms.items()):
            for stored in bits:
                folder = self.folder / f"{syntax}-{kind}-{stored}"
                values = VALUES - 60 if kind[0] == "i" else VALUES
                save(folder, slices(values=values, kind=kind, stored=stored, syntax=PLAIN_SYNTAXES[syntax]))
                if syntax == "big" and kind[1] == "1":
                    self.refused("words of the other byte order", volume, folder)
                    continue
                self.right(folder, values, what=folder.name)

    def test_bits_that_are_no_pixels(self):
        for high, kind in itertools.product((15, 13), ("u2", "i2")):
            folder = self.folder / f"{high}-{kind}"
            values = VALUES - 60 if kind == "i2" else VALUES
            made = slices(values=values, kind=kind, stored=12, high=high)
            for data in made:
                words = numpy.frombuffer(data.PixelData, "<u2") | ((1 << (high - 11)) - 1) | (0 if high == 15 else 1 << 15)
                data.PixelData = words.astype("<u2").tobytes()
            self.assertIn("bits of pixels outside", self.right(save(folder, made), values, what=folder.name).notes)

    def test_every_place(self):
        for name, place in PLACES.items():
            folder = save(self.folder / name, slices(place))
            made = self.right(folder, place=place, what=name)
            self.assertEqual((made.space, made.source_space, made.unit), ("ras", "left-posterior-superior", "mm"))
            for space, turn in (("lps", numpy.diag([-1, -1, 1, 1])), ("file", numpy.diag([-1, -1, 1, 1]))):
                values, there = expected(place)
                self.same(volume(folder, "--space", space), values, turn @ there, f"{name} {space}")

    def test_as_nifti_has_it(self):
        """The same volume as dcm2niix makes it, and nibabel reads it."""
        for name, place in PLACES.items():
            folder = save(self.folder / name, slices(place, kind="i2"))
            out = self.folder / (name + "-nii")
            out.mkdir()
            subprocess.run(["dcm2niix", "-o", out, "-f", "a", "-z", "n", folder], check=True, capture_output=True)
            image = nibabel.load(out / "a.nii")
            made = volume(folder)
            corners = numpy.array(list(itertools.product(*((0, n - 1) for n in SIZES), (1,))))[:, [0, 1, 2, 3]]
            there = numpy.linalg.inv(image.affine) @ made.affine
            values = numpy.asarray(image.dataobj)
            for corner in corners:
                i, j, k = numpy.rint(there @ corner)[:3].astype(int)
                numpy.testing.assert_allclose((there @ corner)[:3], (i, j, k), atol=1e-3)
                x, y, z, _ = corner
                self.assertAlmostEqual(made.values[z, y, x], values[i, j, k], delta=0.01)

    def test_slopes(self):
        made = slices(kind="i2", values=VALUES - 60)
        for data in made:
            data.RescaleSlope, data.RescaleIntercept, data.RescaleType = "2", "-1000", "HU"
        read = self.right(save(self.folder / "one", made), 2.0 * (VALUES - 60) - 1000)
        self.assertEqual(read.manifest["hybrid"]["valueUnit"], "HU")
        for modality, kind, unit in (("CT", None, "HU"), ("CT", "US", ""), ("MR", None, "")):
            made = slices(modality=modality)
            for data in made:
                data.RescaleSlope, data.RescaleIntercept = "1", "0"
                if kind:
                    data.RescaleType = kind
            made = self.right(save(self.folder / f"{modality}{kind}", made))
            self.assertEqual(made.manifest["hybrid"].get("valueUnit", ""), unit)
        made = slices()
        for z, data in enumerate(made):
            data.RescaleSlope, data.RescaleIntercept = numbers(0.5 + z)[0], numbers(-3.5 * z)[0]
        values = numpy.stack([(0.5 + z) * VALUES[z] - 3.5 * z for z in range(SIZES[2])])
        self.assertIn("differ from slice to slice", self.right(save(self.folder / "each", made), values).notes)

    def test_white_is_the_least(self):
        for kind, stored, top in (("u2", 12, 4095), ("u1", 8, 255), ("i2", 12, -1)):
            made = slices(kind=kind, stored=stored)
            for data in made:
                data.PhotometricInterpretation = "MONOCHROME1"
                data.RescaleSlope, data.RescaleIntercept = "2", "10"
            read = self.right(save(self.folder / (kind + str(stored)), made), 2.0 * (top - VALUES) + 10)
            self.assertIn("MONOCHROME1", read.notes)

    def test_floats(self):
        for name, kind, bits in (("FloatPixelData", "<f4", 32), ("DoubleFloatPixelData", "<f8", 64)):
            made = slices()
            for z, data in enumerate(made):
                del data.PixelData
                data.BitsAllocated = bits
                setattr(data, name, (VALUES[z] / 8 - 3).astype(kind).tobytes())
            self.right(save(self.folder / name, made), VALUES / 8 - 3)

    def test_numbers_that_are_no_greys(self):
        made = slices(kind="u1")
        for data in made:
            data.PhotometricInterpretation = "PALETTE COLOR"
            data.RescaleSlope, data.RescaleIntercept = "0", "5"
        notes = self.right(save(self.folder / "a", made), VALUES + 5).notes
        self.assertIn("a palette's colours, which are not looked up", notes)
        self.assertIn("a slope of 0, which was taken as 1", notes)

    def test_what_is_stepped_over(self):
        """Private elements, sequences of either length within each other, icons with pixels of their own."""
        for explicit, syntax in itertools.product((True, False), ("explicit", "implicit")):
            made = slices(syntax=PLAIN_SYNTAXES[syntax])
            for data in made:
                block = data.private_block(0x0009, "OF SOMEBODY", create=True)
                block.add_new(1, "UN", b"\0\1\2\3" * 5000)
                inner = item(ImagePositionPatient=["900", "900", "900"], Rows=1, PixelData=b"\0\0")
                inner["PixelData"].VR = "OW"
                nested = Sequence([item(ReferencedImageSequence=Sequence([inner])), inner])
                data.IconImageSequence, data.ReferencedImageSequence = Sequence([inner]), nested
                for each in (data["IconImageSequence"], data["ReferencedImageSequence"]):
                    each.is_undefined_length = explicit
                data.DataSetTrailingPadding = bytes(32)
            self.right(save(self.folder / f"{explicit}{syntax}", made), what=f"{explicit} {syntax}")

    def test_without_a_preamble(self):
        for syntax in ("explicit", "implicit"):
            folder = save(self.folder / syntax, slices(syntax=PLAIN_SYNTAXES[syntax]))
            for path in folder.iterdir():
                whole = path.read_bytes()
                head = 132 + 12 + int.from_bytes(whole[140:144], "little")
                path.write_bytes(whole[head:])
            self.right(folder, what=syntax)


@needs_program
class Series(DicomCase):
    def test_several_are_listed(self):
        save(self.folder / "a" / "one", slices(series=7))
        save(self.folder / "a" / "two" / "deep", slices(values=119 - VALUES, series=9, modality="MR"))
        folder = self.folder / "a"
        with self.assertRaises(Refused) as caught:
            volume(folder)
        self.assertIn("holds 2 series, by their numbers: 7 (CT, 6 pictures of 5 x 4), 9 (MR, 6 pictures of 5 x 4); "
                      "choose one by --series NUMBER", str(caught.exception))
        self.right(folder, options=("--series", "7"))
        self.right(folder, 119 - VALUES, options=("--series", uid(9)))
        self.refused("has no series of the number or UID", volume, folder, "--series", "8")
        self.refused("series: is one of DICOM", volume, self.nifti(), "--series", "8")

    def nifti(self):
        nibabel.save(nibabel.Nifti1Image(VALUES.transpose(2, 1, 0).astype("i2"), OBLIQUE), self.folder / "a.nii")
        return self.folder / "a.nii"

    def test_two_orientations_under_one_uid(self):
        made = slices(series=3) + slices(phantom.PLAIN, 119 - VALUES, series=3, first=50)
        folder = save(self.folder / "a", made)
        self.refused("holds 2 series", volume, folder, "--series", uid(3))
        self.right(folder, options=("--series", "1"))
        self.right(folder, 119 - VALUES, phantom.PLAIN, options=("--series", "2"))

    def test_archives_and_lists(self):
        folder = save(self.folder / "a", slices())
        for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            path = self.folder / f"a{method}.zip"
            with zipfile.ZipFile(path, "w", method) as archive:
                archive.writestr("DICOM/", b"")
                archive.writestr("DICOM/readme.txt", b"nothing")
                for file in folder.iterdir():
                    archive.write(file, f"DICOM/{file.name}")
            self.right(path, what=str(method))
        whole = bytearray(path.read_bytes())
        whole[whole.index(b"PK\1\2") - 8] ^= 0x55
        path.write_bytes(whole)
        try:  # one slice is damaged, and may be an outer one
            notes = volume(path).notes
            self.assertIn("1 DICOM file left out, which cannot be read", notes)
            self.assertIn("checksum", notes)
        except Refused as sentence:
            self.assertIn("is missing", str(sentence))
        files = sorted(folder.iterdir())
        steps = volumes(files)
        self.assertEqual(len(steps), 1)
        self.same(steps[0], VALUES, OBLIQUE)
        self.assertEqual(len(steps[0].manifest["request"]["volume"]["inputs"]), len(files))
        self.refused("is a single picture of a series", volume, files[0])
        (folder / "other.txt").write_text("text")
        self.right(folder / "IM*")
        self.refused("no file has a name like this", volume, folder / "XM*")
        for file in files:
            (folder / (file.name + ".gz")).write_bytes(gzip.compress(file.read_bytes()))
            file.unlink()
        self.right(folder)
        empty = self.folder / "b.zip"
        with zipfile.ZipFile(empty, "w") as archive:
            archive.writestr("a.txt", b"text")
        self.refused("without arrays (.npy) or DICOM files", volume, empty)

    def test_a_folder_of_other_things(self):
        folder = save(self.folder / "a" / "b" / "c", slices())
        for i in range(3000):
            (folder / f"note{i}.txt").write_text(f"{i}")
        report = blank(77, 4, "SR")
        report.save_as(folder / "report", write_like_original=False)
        self.refused("holds no picture (of a DICOMDIR, name the folder)", volume, folder / "report")
        (folder / "IM9999").write_bytes((folder / "IM0000").read_bytes()[:200])
        (folder / ".hidden").write_bytes((folder / "IM0000").read_bytes())
        made = self.right(self.folder / "a")
        self.assertIn("1 DICOM file without a picture left out", made.notes)
        self.assertIn("1 DICOM file left out, which cannot be read (the first: IM9999", made.notes)
        shutil.rmtree(folder)
        self.refused("is a folder without DICOM files, PNG or TIFF pictures", volume, self.folder / "a")

    def test_steps_of_a_series_are_folders(self):
        one = save(self.folder / "1", slices())
        two = save(self.folder / "2", slices(values=119 - VALUES, series=2))
        steps = volumes([one, two])
        self.assertEqual(len(steps), 2)
        self.same(steps[1], 119 - VALUES, OBLIQUE)

    def test_a_surface_of_a_folder(self):
        folder = save(self.folder / "a", slices())
        run("mesh", folder, "--isovalue", 60, "--out", self.folder / "m.mote")


@needs_program
class Slices(DicomCase):
    def test_what_is_missing_or_twice(self):
        made = slices()
        self.refused("a slice is missing between", volume, save(self.folder / "gap", made[:2] + made[3:]))
        self.refused("2 slices are missing between", volume, save(self.folder / "gaps", made[:1] + made[3:]))
        copies = save(self.folder / "copies", made + made[2:3])
        self.assertIn("being copies of others", self.right(copies).notes)
        twice = slices()[2]
        twice.SOPInstanceUID = twice.file_meta.MediaStorageSOPInstanceUID = uid(1, 99)
        self.refused("a slice is there twice", volume, save(self.folder / "twice", made + [twice]))

    def test_uneven_ones(self):
        for off, words in ((0.6, "unevenly"), (0.08, "off an even grid"), (0.0004, None)):
            made = slices(phantom.PLAIN)
            position = [float(x) for x in made[3].ImagePositionPatient]
            position[2] += off * phantom.SPACING[2]
            made[3].ImagePositionPatient = numbers(position)
            folder = save(self.folder / str(off), made)
            if off > 0.5:
                self.refused(words, volume, folder)
                continue
            notes = volume(folder).notes
            self.assertEqual(bool(words and words in notes), words is not None, notes)

    def test_a_tilted_gantry(self):
        place = phantom.PLAIN.copy()
        for name, place in PLACES.items():
            sheared = place.copy()
            row = place[:3, 0] / numpy.linalg.norm(place[:3, 0])
            sheared[:3, 2] += 0.7 * row
            made = self.right(save(self.folder / name, slices(place, shift=0.7)), place=sheared, what=name)
            self.assertIn("the grid is sheared", made.notes)

    def test_without_positions(self):
        for lost in (("ImagePositionPatient",), ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing")):
            made = slices()
            for data in made:
                for name in lost:
                    delattr(data, name)
                data.SliceThickness = "4"
            read = volume(save(self.folder / str(len(lost)), made))
            numpy.testing.assert_allclose(read.values, VALUES, atol=0.01)
            self.assertIn("says no positions", read.notes)
            self.assertEqual("says no orientation" in read.notes, len(lost) > 1)
            self.assertEqual(read.space, "")
            self.assertAlmostEqual(read.sizes[2], 4)

    def test_times(self):
        volumes_of = [VALUES, 119 - VALUES, VALUES[::-1]]
        kinds = {"trigger time": ("TriggerTime", (0, 250, 500)), "echo time": ("EchoTime", (1, 2.5, 4)),
                 "temporal position": ("TemporalPositionIdentifier", (1, 2, 3)),
                 "acquisition number": ("AcquisitionNumber", (4, 5, 6)), "numbers": (None, None)}
        for words, (name, values) in kinds.items():
            made = []
            for i, each in enumerate(volumes_of):
                some = slices(values=each, first=1 + 10 * i)
                for data in some:
                    if name:
                        setattr(data, name, str(values[i]))
                made += some
            folder = save(self.folder / words.replace(" ", "-"), made)
            steps = volumes(folder)
            self.assertEqual(len(steps), 3, words)
            for i, step in enumerate(steps):
                self.same(step, volumes_of[i], OBLIQUE, words)
            self.assertIn("told apart by their " + words, steps[0].notes)
            if words == "trigger time":
                times = [step.get("time", 0) for step in steps[0].manifest["hybrid"]["steps"]]
                numpy.testing.assert_allclose(times, (0, 0.25, 0.5))
        self.same(volume(folder, "--field", 1), volumes_of[1], OBLIQUE)

    def test_mosaics_and_others(self):
        made = slices()
        for data in made:
            data.ImageType = ["ORIGINAL", "PRIMARY", "M", "ND", "MOSAIC"]
        self.refused("is a mosaic", volume, save(self.folder / "mosaic", made))
        made = slices()
        made[1].Rows = 400
        self.refused("holds 2 series", volume, save(self.folder / "rows", made))
        for data in made:
            data.Rows = 400
        self.refused("need", volume, save(self.folder / "short", made))


@needs_program
class Private(DicomCase):
    def test_nobody_is_named(self):
        """Neither in the dataset nor in what is printed, be it made or refused."""
        planted = [word for value in NAMES.values() for word in (value, value.replace("^", " "))] + ["Planted", "PLANTED"]

        def clean(blob, what):
            for word in planted:
                self.assertNotIn(word.encode(), blob, what)
                self.assertNotIn(word.encode("utf-16-le"), blob, what)

        one, two = slices(), slices(series=2)
        gap = slices()[:2] + slices()[4:]
        short = slices()
        for data in short:
            data.Rows = 900
        cases = {"made": (one, 0), "listed": (one + two, 1), "gap": (gap, 1), "short": (short, 1),
                 "single": (one[:1], 1)}
        for what, (made, code) in cases.items():
            folder = save(self.folder / what, made)
            out = self.folder / (what + ".mote")
            done = subprocess.run([BIN / "mote-prep", "volume", folder, "--out", out], capture_output=True, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            clean(done.stdout + done.stderr, what)
            for path in out.rglob("*") if out.exists() else ():
                if path.is_file():
                    clean(path.read_bytes(), f"{what} {path.name}")
        shown = subprocess.run([BIN / "mote-prep", "info", self.folder / "made.mote", "--json"], capture_output=True, check=True)
        clean(shown.stdout, "info")


if __name__ == "__main__":
    unittest.main()
