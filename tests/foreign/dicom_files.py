# SPDX-License-Identifier: GPL-3.0-or-later
"""DICOM files of the known volume by pydicom, each said in the ways that PS3.3 and PS3.5 name."""
import random
import struct
import subprocess

import numpy
import pydicom
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import (DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, ExplicitVRLittleEndian,
                         ImplicitVRLittleEndian)

import phantom
from phantom import OBLIQUE, SIZES, VALUES
from support import Case, needs_program, volume

PLAIN_SYNTAXES = {"implicit": ImplicitVRLittleEndian, "explicit": ExplicitVRLittleEndian,
                  "deflated": DeflatedExplicitVRLittleEndian, "big": ExplicitVRBigEndian}
# Nobody must ever read any of these again.
NAMES = {"PatientName": "Doe^Planted", "PatientID": "PLANTED-4711", "PatientBirthDate": "19440229",
         "InstitutionName": "Planted Hospital", "ReferringPhysicianName": "Planted^Doctor",
         "OtherPatientIDs": "PLANTED-OTHER", "PatientAddress": "Planted Street 1", "AccessionNumber": "PLANTEDACC",
         "StudyDescription": "Planted study", "SeriesDescription": "Planted series", "OperatorsName": "Planted^Operator",
         "ImageComments": "Planted comment", "DeviceSerialNumber": "PLANTEDSERIAL", "StationName": "PLANTEDSTATION"}


def uid(*numbers):
    return "1.2.826.0.1.3680043.8.498." + ".".join(map(str, numbers))


def vectors(place):
    """In LPS: the steps along columns, rows and slices, and where the first voxel is."""
    matrix = phantom.said_in(place, "LPS")
    return (*matrix[:3, :3].T, matrix[:3, 3])


def expected(place, values=VALUES):
    """Slices come in ascending order along the normal of their planes, whatever the order of files."""
    x, y, z, _ = vectors(place)
    if numpy.dot(numpy.cross(x, y), z) > 0:
        return values, place
    turned = place @ numpy.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, values.shape[0] - 1], [0, 0, 0, 1]])
    return values[::-1], turned


def numbers(values):
    """As many digits as a decimal string may have."""
    return [f"{value:.10g}" for value in numpy.atleast_1d(values)]


def frame_place(place, z, shift=0.0):
    """Where a slice lies: position, orientation and the spacing of pixels. `shift`: along rows, as a gantry tilts."""
    x, y, step, origin = vectors(place)
    row, column = x / numpy.linalg.norm(x), y / numpy.linalg.norm(y)
    return (numbers(origin + z * step + z * shift * row), numbers(numpy.concatenate([row, column])),
            numbers([numpy.linalg.norm(y), numpy.linalg.norm(x)]))


def blank(instance=1, series=1, modality="CT", syntax=ExplicitVRLittleEndian):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    meta.MediaStorageSOPInstanceUID = uid(series, instance)
    meta.TransferSyntaxUID = syntax
    data = FileDataset(None, {}, file_meta=meta, preamble=bytes(128))
    data.is_little_endian, data.is_implicit_VR = syntax != ExplicitVRBigEndian, syntax == ImplicitVRLittleEndian
    data.SOPClassUID, data.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
    data.StudyInstanceUID, data.SeriesInstanceUID = uid(9), uid(series)
    data.Modality, data.SeriesNumber, data.InstanceNumber = modality, series, instance
    for name, value in NAMES.items():
        setattr(data, name, value)
    return data


def put_pixels(data, values, kind="u2", stored=None, high=None):
    """`values` [y, x], or [frame, y, x]. Bits that are not stored are 0."""
    kind = numpy.dtype(kind)
    bits = stored or 8 * kind.itemsize
    high = bits - 1 if high is None else high
    data.Rows, data.Columns = values.shape[-2:]
    if values.ndim == 3:
        data.NumberOfFrames = values.shape[0]
    data.SamplesPerPixel = 1
    data.PhotometricInterpretation = "MONOCHROME2"
    data.BitsAllocated, data.BitsStored, data.HighBit = 8 * kind.itemsize, bits, high
    data.PixelRepresentation = int(kind.kind == "i")
    words = (values.astype("i8") & (2 ** bits - 1)) << (high + 1 - bits)
    order = "<" if data.is_little_endian else ">"
    data.PixelData = words.astype(f"{order}u{kind.itemsize}").tobytes()
    if len(data.PixelData) % 2:
        data.PixelData += b"\0"
    data["PixelData"].VR = "OB" if kind.itemsize == 1 else "OW"


def slices(place=phantom.OBLIQUE, values=VALUES, kind="u2", stored=None, high=None, series=1, first=1, shift=0.0,
           **more):
    """The data sets of a series, in the order of their slices."""
    made = []
    for z, plane in enumerate(values):
        data = blank(first + z, series, **more)
        data.ImagePositionPatient, data.ImageOrientationPatient, data.PixelSpacing = frame_place(place, z, shift)
        put_pixels(data, plane, kind, stored, high)
        made.append(data)
    return made


def save(folder, made, seed=1):
    """Under names and in an order that say nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"IM{i:04d}" for i in range(len(made))]
    random.Random(seed).shuffle(names)
    for name, data in zip(names, made):
        data.save_as(folder / name, write_like_original=False)
    return folder


def item(**elements):
    made = Dataset()
    for name, value in elements.items():
        setattr(made, name, value)
    return made


def enhanced(place=phantom.OBLIQUE, values=VALUES, order=None, scales=None, times=None, **more):
    """One file of many frames, whose places stand in functional groups; `order`: of frames in the file."""
    order = range(len(values)) if order is None else order
    data = blank(1, 1, **more)
    put_pixels(data, values[list(order)], "u2")
    _, orientation, spacing = frame_place(place, 0)
    data.SharedFunctionalGroupsSequence = Sequence([item(
        PlaneOrientationSequence=Sequence([item(ImageOrientationPatient=orientation)]),
        PixelMeasuresSequence=Sequence([item(PixelSpacing=spacing, SliceThickness="1")]))])
    groups = []
    for at in order:
        z = at % SIZES[2]
        group = item(PlanePositionSequence=Sequence([item(ImagePositionPatient=frame_place(place, z)[0])]))
        if scales:
            group.PixelValueTransformationSequence = Sequence([item(
                RescaleSlope=numbers(scales[z][0])[0], RescaleIntercept=numbers(scales[z][1])[0], RescaleType="US")])
        if times:
            group.FrameContentSequence = Sequence([item(TemporalPositionIndex=times[at])])
        groups.append(group)
    data.PerFrameFunctionalGroupsSequence = Sequence(groups)
    return data


def siemens_header(**elements):
    """What Siemens' scanners write for themselves, in the form that dcm2niix and nibabel read: CSA2."""
    out = b"SV10\4\3\2\1" + struct.pack("<II", len(elements), 77)
    for name, texts in elements.items():
        out += struct.pack("<64si4siii", name.encode(), len(texts), b"FD", 4, 6, 77)
        for text in (*texts, *[""] * (6 - len(texts))):
            item_bytes = text.encode() + b"\0" if text else b""
            length = len(item_bytes)
            out += struct.pack("<4i", length, length, 77, length) + item_bytes + bytes(-length % 4)
    return out


def mosaic(place=phantom.OBLIQUE, values=VALUES, **more):
    """All slices in one picture, as Siemens' scanners write them."""
    across = int(numpy.ceil(numpy.sqrt(len(values))))
    rows, columns = values.shape[1:]
    picture = numpy.zeros((across * rows, across * columns), values.dtype)
    for z, plane in enumerate(values):
        picture[z // across * rows:, z % across * columns:][:rows, :columns] = plane
    data = blank(1, 1, modality="MR", **more)
    put_pixels(data, picture, "u2")
    x, y, step, origin = vectors(place)
    first = origin - (across - 1) / 2 * (columns * x + rows * y)
    data.ImagePositionPatient, data.ImageOrientationPatient = numbers(first), frame_place(place, 0)[1]
    data.PixelSpacing, data.SpacingBetweenSlices = frame_place(place, 0)[2], numbers(numpy.linalg.norm(step))[0]
    data.SliceThickness = data.SpacingBetweenSlices
    data.ImageType, data.Manufacturer = ["ORIGINAL", "PRIMARY", "M", "ND", "MOSAIC"], "SIEMENS"
    block = data.private_block(0x0029, "SIEMENS CSA HEADER", create=True)
    block.add_new(0x10, "OB", siemens_header(
        EchoLinePosition=["64"], NumberOfImagesInMosaic=[str(len(values))], SliceNormalVector=[f"{n:.8f}" for n in step / numpy.linalg.norm(step)]))
    return data


def compressed(folder, into, program, *options):
    """A folder's files by other people's compressors."""
    into.mkdir(parents=True, exist_ok=True)
    for path in sorted(folder.iterdir()):
        subprocess.run([program, *options, str(path), str(into / path.name)], check=True, capture_output=True)
    return into


def syntax_of(folder):
    return pydicom.dcmread(next(iter(sorted(folder.iterdir()))), stop_before_pixels=True).file_meta.TransferSyntaxUID


@needs_program
class DicomCase(Case):
    """One reading, held to the known volume."""

    def right(self, path, values=VALUES, place=OBLIQUE, what="", options=()):
        values, place = expected(place, values)
        made = volume(path, *options)
        self.same(made, values, place, what)
        return made
