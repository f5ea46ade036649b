#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""DICOM files that are compressed, and those of many frames."""
import itertools
import subprocess
import unittest

import nibabel
import numpy
from pydicom.sequence import Sequence

import phantom
from dicom_files import (DicomCase, compressed, enhanced, expected, item, mosaic, numbers, put_pixels, save, siemens_header, slices,
                         syntax_of, uid)
from phantom import OBLIQUE, PLACES, SIZES, VALUES
from support import Refused, needs_program, volume, volumes

LARGE = numpy.kron(VALUES, numpy.ones((1, 8, 8), int))  # OpenJPEG's writer dies of pictures as small as the other


@needs_program
class Compressed(DicomCase):
    def test_what_compressors_write(self):
        forms = {"u1-8": LARGE, "u2-12": LARGE, "i2-16": LARGE - 60, "u2-16": LARGE * 500}
        writers = {"jpeg": ("dcmcjpeg", "+e1"), "jpeg14": ("dcmcjpeg", "+el"), "jpegls": ("dcmcjpls",),
                   "rle": ("dcmcrle",), "j2k": ("gdcmconv", "--j2k"), "gdcm-jpeg": ("gdcmconv", "--jpeg"),
                   "gdcm-jpegls": ("gdcmconv", "--jpegls"), "gdcm-rle": ("gdcmconv", "--rle")}
        seen = set()
        for form, values in forms.items():
            kind, stored = form.split("-")
            plain = save(self.folder / form, slices(kind=kind, stored=int(stored), values=values))
            for name, command in writers.items():
                made = compressed(plain, self.folder / f"{name}-{form}", *command)
                seen.add(syntax_of(made))
                self.right(made, values, what=made.name)
        self.assertEqual(seen, {"1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80",
                                "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.5"})

    def test_losses_are_said(self):
        smooth = numpy.add.outer(numpy.arange(8) * 4, numpy.add.outer(numpy.arange(32), numpy.arange(40))).astype(int)
        folder = save(self.folder / "plain", slices(phantom.PLAIN, smooth, kind="u1"))
        made = compressed(folder, self.folder / "lossy", "dcmcjpeg", "+eb", "+q", "100")
        self.assertEqual(syntax_of(made), "1.2.840.10008.1.2.4.50")
        read = volume(made)
        numpy.testing.assert_allclose(read.values, smooth, atol=2.5)
        self.assertIn("with losses", read.notes)

    def test_many_frames(self):
        plain = save(self.folder / "plain", [enhanced(values=LARGE)])
        for name, command in (("jpeg", ("dcmcjpeg", "+e1")), ("rle", ("dcmcrle",)), ("j2k", ("gdcmconv", "--j2k"))):
            self.right(next(compressed(plain, self.folder / name, *command).iterdir()), LARGE, what=name)
        # Frames in several fragments each, with the table that says so.
        cut = compressed(plain, self.folder / "cut", "dcmcjpeg", "+e1", "+fs", "1")
        self.right(next(cut.iterdir()), LARGE)

    def test_what_is_not_decoded(self):
        made = slices()
        for data in made:
            data.file_meta.TransferSyntaxUID = "1.2.840.10008.1.2.4.100"
            data.PixelData = b"\xfe\xff\0\xe0\0\0\0\0\xfe\xff\0\xe0\4\0\0\0\1\2\3\4\xfe\xff\xdd\xe0\0\0\0\0"
        folder = save(self.folder / "a", made)
        self.refused("its pixels are in MPEG-2, which is not read: gdcmconv --raw or dcm2niix", volume, folder)
        for path in folder.iterdir():
            path.write_bytes(path.read_bytes().replace(b"1.2.840.10008.1.2.4.100", b"1.2.840.10008.1.2.4.201"))
        self.refused("its pixels are in transfer syntax 1.2.840.10008.1.2.4.201", volume, folder)

    def test_damage_is_an_error(self):
        plain = save(self.folder / "plain", slices(kind="u2", stored=12, values=LARGE))
        for name, command in (("jpeg", ("dcmcjpeg", "+e1")), ("jpegls", ("dcmcjpls",)), ("rle", ("dcmcrle",)),
                              ("j2k", ("gdcmconv", "--j2k"))):
            folder = compressed(plain, self.folder / name, *command)
            path = sorted(folder.iterdir())[2]
            whole = path.read_bytes()
            begin = whole.rindex(b"\xfe\xff\0\xe0")
            for seed in range(8):
                odd = bytearray(whole)
                for at in numpy.random.default_rng(seed).integers(begin + 8, len(whole) - 8, 4):
                    odd[at] ^= 0x5a
                path.write_bytes(odd)
                try:
                    volume(folder)  # another picture, where nothing tells
                except Refused as sentence:
                    self.assertIn(path.name, str(sentence))
            path.write_bytes(whole[:begin + 8 + 10])
            self.refused(path.name, volume, folder)


@needs_program
class Frames(DicomCase):
    def test_functional_groups(self):
        for order in (None, [3, 1, 5, 0, 2, 4]):
            path = self.folder / "a.dcm"
            enhanced(order=order).save_as(path, write_like_original=False)
            self.right(path)
        scales = [(0.5 + z, 3.0 * z) for z in range(SIZES[2])]
        enhanced(scales=scales).save_as(path, write_like_original=False)
        self.right(path, numpy.stack([a * VALUES[z] + b for z, (a, b) in enumerate(scales)]))

    def test_times_in_functional_groups(self):
        both = numpy.concatenate([VALUES, 119 - VALUES])
        times = [1] * SIZES[2] + [2] * SIZES[2]
        path = self.folder / "a.dcm"
        enhanced(values=both, order=[i % 2 * 6 + i // 2 for i in range(12)], times=times).save_as(
            path, write_like_original=False)
        steps = volumes(path)
        self.assertEqual(len(steps), 2)
        self.same(steps[0], VALUES, OBLIQUE)
        self.same(steps[1], 119 - VALUES, OBLIQUE)
        self.assertIn("temporal position", steps[0].notes)

    def test_mosaics(self):
        """Where dcm2niix has them, which takes them apart, too; of several, each is a volume."""
        for name, place in PLACES.items():
            if name == "mirrored":
                place = place @ numpy.diag([1, 1, -1, 1])  # slices go along the normal here, as a scanner has it
            folder = save(self.folder / name, [mosaic(place)])
            made = self.right(folder, place=place, what=name)
            out = self.folder / (name + "-nii")
            out.mkdir()
            subprocess.run(["dcm2niix", "-o", out, "-f", "a", "-z", "n", folder], check=True, capture_output=True)
            image = nibabel.load(out / "a.nii")
            self.assertEqual(image.shape, SIZES)
            corners = numpy.array(list(itertools.product(*((0, n - 1) for n in SIZES), (1,))))
            there = (numpy.linalg.inv(image.affine) @ made.affine @ corners.T).T[:, :3]
            numpy.testing.assert_allclose(there, numpy.rint(there), atol=1e-3)
            for (x, y, z, _), index in zip(corners, numpy.rint(there).astype(int)):
                self.assertAlmostEqual(made.values[z, y, x], numpy.asarray(image.dataobj)[tuple(index)], delta=0.01)
        both = [mosaic(), mosaic(values=119 - VALUES)]
        for number, data in enumerate(both):
            data.SOPInstanceUID = data.file_meta.MediaStorageSOPInstanceUID = uid(1, 40 + number)
            data.InstanceNumber = data.AcquisitionNumber = 1 + number
        steps = volumes(save(self.folder / "both", both))
        for step, values in zip(steps, (VALUES, 119 - VALUES)):
            self.same(step, *expected(OBLIQUE, values))
        self.assertIn("told apart by their acquisition number", steps[0].notes)
        odd = mosaic()
        odd[0x00291010].value = siemens_header(NumberOfImagesInMosaic=["6"])
        self.refused("is a single picture", volume, save(self.folder / "odd", [odd]))

    def test_dose(self):
        made = slices()[0]
        put_pixels(made, VALUES, "u4")
        made.Modality, made.DoseUnits, made.DoseGridScaling = "RTDOSE", "GY", "0.25"
        made.FrameIncrementPointer = 0x3004000C
        made.GridFrameOffsetVector = numbers(numpy.arange(SIZES[2]) * phantom.SPACING[2])
        path = self.folder / "dose.dcm"
        made.save_as(path, write_like_original=False)
        self.assertEqual(self.right(path, 0.25 * VALUES).manifest["hybrid"]["valueUnit"], "Gy")
        made.GridFrameOffsetVector = numbers([0, 1, 2, 4, 5, 6])
        made.save_as(path, write_like_original=False)
        self.refused("a slice is missing", volume, path)

    def test_of_a_camera(self):
        made = slices()[0]
        put_pixels(made, VALUES, "u2")
        made.Modality, made.SpacingBetweenSlices = "NM", str(phantom.SPACING[2])
        made.FrameIncrementPointer = 0x00540080
        made.DetectorInformationSequence = Sequence([item(ImagePositionPatient=made.ImagePositionPatient,
                                                          ImageOrientationPatient=made.ImageOrientationPatient), item()])
        del made.ImagePositionPatient, made.ImageOrientationPatient
        path = self.folder / "spect.dcm"
        made.save_as(path, write_like_original=False)
        self.right(path)
        made.FrameIncrementPointer = 0x00181063
        made.save_as(path, write_like_original=False)
        self.refused("a film", volume, path)


if __name__ == "__main__":
    unittest.main()
