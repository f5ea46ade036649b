# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of DICOM files share: one reading held to the known volume."""
from dicom_files import expected
from phantom import OBLIQUE, VALUES
from support import Case, needs_program, volume


@needs_program
class DicomCase(Case):
    def right(self, path, values=VALUES, place=OBLIQUE, what="", options=()):
        values, place = expected(place, values)
        made = volume(path, *options)
        self.same(made, values, place, what)
        return made
