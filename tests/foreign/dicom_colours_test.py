#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""DICOM files in colour, whose luminance is read, and those of one bit for each pixel."""
import io
import itertools
import unittest

import numpy
from PIL import Image
from pydicom.encaps import encapsulate
from pydicom.sequence import Sequence
from pydicom.uid import JPEGBaseline8Bit

import phantom
from dicom_files import DicomCase, compressed, enhanced, item, save, slices
from phantom import OBLIQUE, SIZES, VALUES
from support import needs_program, volume, volumes


@needs_program
class Colours(DicomCase):
    def test_colours(self):
        planes = numpy.stack([VALUES, 119 - VALUES, VALUES[::-1]], axis=-1)
        luminance = planes @ (0.2126, 0.7152, 0.0722)
        for planar in (0, 1):
            made = slices(kind="u1")
            for z, data in enumerate(made):
                data.SamplesPerPixel, data.PhotometricInterpretation, data.PlanarConfiguration = 3, "RGB", planar
                pixels = planes[z].transpose(2, 0, 1) if planar else planes[z]
                data.PixelData = pixels.astype("u1").tobytes()
            folder = save(self.folder / str(planar), made)
            self.assertIn("luminance", self.right(folder, luminance).notes)
            self.right(compressed(folder, self.folder / f"rle{planar}", "dcmcrle"), luminance)
        for data in made:
            data.PhotometricInterpretation = "YBR_FULL_422"
        self.refused("is in colour (YBR_FULL_422", volume, save(self.folder / "422", made))

    def test_luminance_and_differences_of_colours(self):
        """As PS3.3, C.7.6.3.1.2 has them, and as JPEG has them whatever the header says; by Pillow's JPEG and DCMTK's."""
        y, x = numpy.mgrid[0:24, 0:40]
        planes = [numpy.stack([4 * x + 20 + 5 * z, 7 * y + 30, 250 - 3 * x - 2 * y - 5 * z], -1).astype("u1") for z in range(SIZES[2])]
        luminance = numpy.stack(planes) @ (0.2126, 0.7152, 0.0722)

        def files(name, photometric, pixels, syntax=None):
            made = slices(phantom.PLAIN, luminance, kind="u1")
            for data, plane in zip(made, planes):
                data.SamplesPerPixel, data.PhotometricInterpretation, data.PlanarConfiguration = 3, photometric, 0
                data.PixelData = pixels(plane)
                if syntax:
                    data.file_meta.TransferSyntaxUID = syntax
                    data["PixelData"].is_undefined_length = True
            return save(self.folder / name, made)

        def held(folder):
            made = volume(folder)
            numpy.testing.assert_allclose(made.values, luminance, atol=3, err_msg=folder.name)
            self.assertIn("luminance", made.notes)

        def jpeg(plane, subsampling):
            file = io.BytesIO()
            Image.fromarray(plane).save(file, "JPEG", quality=98, subsampling=subsampling)
            return encapsulate([file.getvalue()])

        held(files("plain", "YBR_FULL", lambda plane: Image.fromarray(plane).convert("YCbCr").tobytes()))
        held(compressed(self.folder / "plain", self.folder / "rle", "dcmcrle"))
        red = files("red", "RGB", lambda plane: plane.tobytes())
        for options in (("+eb", "+q", "98"), ("+eb", "+q", "98", "+cr"), ("+e1",)):
            held(compressed(red, self.folder / "-".join(options), "dcmcjpeg", *options))
        held(compressed(red, self.folder / "j2k", "gdcmconv", "--j2k"))
        for subsampling, photometric in itertools.product((0, 1, 2), ("YBR_FULL_422", "YBR_FULL", "RGB")):
            held(files(f"{subsampling}{photometric}", photometric, lambda plane, some=subsampling: jpeg(plane, some), JPEGBaseline8Bit))

    def test_one_bit_for_each_pixel(self):
        """Frames of 20 pixels begin within bytes; segments are volumes, told apart by their numbers."""
        bits = (VALUES % 3 == 0).astype(int)
        for photometric, values in (("MONOCHROME2", bits), ("MONOCHROME1", 1 - bits)):
            made = enhanced(values=VALUES)
            made.PhotometricInterpretation = photometric
            made.BitsAllocated = made.BitsStored = 1
            made.HighBit = 0
            made.PixelData = numpy.packbits(bits.ravel().astype("u1"), bitorder="little").tobytes() + b"\0"
            made["PixelData"].VR = "OB"
            made.save_as(self.folder / (photometric + ".dcm"), write_like_original=False)
            self.right(self.folder / (photometric + ".dcm"), values)
        both = numpy.concatenate([bits, VALUES % 2])
        made = enhanced(values=numpy.concatenate([VALUES, VALUES]))
        made.BitsAllocated = made.BitsStored = 1
        made.HighBit = 0
        made.PixelData = numpy.packbits(both.ravel().astype("u1"), bitorder="little").tobytes()
        for i, group in enumerate(made.PerFrameFunctionalGroupsSequence):
            group.SegmentIdentificationSequence = Sequence([item(ReferencedSegmentNumber=1 + i // SIZES[2])])
        path = self.folder / "segments.dcm"
        made.save_as(path, write_like_original=False)
        steps = volumes(path)
        for step, values in zip(steps, (bits, VALUES % 2)):
            self.same(step, values, OBLIQUE)
        self.assertIn("told apart by their segment number", steps[0].notes)
        made.PixelData = made.PixelData[:-2]
        made.save_as(path, write_like_original=False)
        self.refused("need 3 bytes each, and 28 are there", volume, path)


if __name__ == "__main__":
    unittest.main()
