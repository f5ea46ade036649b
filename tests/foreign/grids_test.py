#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""VTK images by VTK's own writer, and OpenVDB grids by its Python module."""
import itertools
import unittest

import numpy
import pyopenvdb
import vtk
from vtk.util.numpy_support import numpy_to_vtk

import looked
import phantom
from phantom import SIZES, VALUES
from support import Case, needs_program, volume


@needs_program
class Vti(Case):
    def image(self, kind="i2", cells=False):
        image = vtk.vtkImageData()
        image.SetDimensions(*(n + cells for n in SIZES))
        image.SetSpacing(*phantom.SPACING)
        image.SetOrigin(*phantom.ORIGIN)
        self.add(image.GetCellData() if cells else image.GetPointData(), VALUES.astype(kind), "density")
        return image

    def add(self, data, values, name, first=False):
        array = numpy_to_vtk(values.ravel(), deep=True)
        array.SetName(name)
        data.AddArray(array)

    def write(self, image, mode="appended", packed=True, name="a.vti", encoded=True, wide=True):
        writer = vtk.vtkXMLImageDataWriter()
        writer.SetFileName(str(self.folder / name))
        writer.SetInputData(image)
        {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary,
         "appended": writer.SetDataModeToAppended}[mode]()
        if not packed:
            writer.SetCompressorTypeToNone()
        writer.SetEncodeAppendedData(encoded)
        (writer.SetHeaderTypeToUInt64 if wide else writer.SetHeaderTypeToUInt32)()
        self.assertEqual(writer.Write(), 1)
        return self.folder / name

    def test_every_type_and_form(self):
        variants = {}
        for kind, mode, packed in itertools.product(("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"),
                                                    ("ascii", "binary", "appended"), (False, True)):
            what = f"{kind}-{mode}-{packed}"
            variants[what] = self.write(self.image(kind), mode, packed, what + ".vti")
        for encoded, wide in itertools.product((False, True), (False, True)):
            what = f"{encoded}-{wide}"
            variants[what] = self.write(self.image(), "appended", True, what + ".vti", encoded, wide)
        self.all_same(variants, VALUES, phantom.affine(numpy.eye(3)))

    def test_vectors(self):
        """Each component by its number, and the length of the vector."""
        planes = numpy.stack([VALUES, 119 - VALUES, VALUES[::-1]], axis=-1).astype("f4")
        place = phantom.affine(numpy.eye(3))
        for mode, packed in itertools.product(("ascii", "binary", "appended"), (False, True)):
            image = vtk.vtkImageData()
            image.CopyStructure(self.image())
            array = numpy_to_vtk(planes.reshape(-1, 3), deep=True)
            array.SetName("velocity")
            image.GetPointData().AddArray(array)
            path = self.write(image, mode, packed)
            for i in range(3):
                self.same(volume(path, "--field", f"velocity:{i}"), planes[..., i], place, f"{mode} {i}")
            self.same(volume(path, "--field", "velocity:magnitude"), numpy.linalg.norm(planes, axis=-1), place, mode)
            self.refused("it holds velocity (3 values)", volume, path)
            self.refused("ask for one as the field, velocity:0 to velocity:2", volume, path, "--field", "velocity")

    def test_arrays_that_are_no_volume(self):
        """Field data, ghosts and ids before the array, active or not."""
        for mode, cells in itertools.product(("ascii", "binary", "appended"), (False, True)):
            image = vtk.vtkImageData()
            image.CopyStructure(self.image(cells=cells))
            field = numpy_to_vtk(numpy.array([1.5]), deep=True)
            field.SetName("TimeValue")
            image.GetFieldData().AddArray(field)
            many = numpy_to_vtk(numpy.arange(120.0), deep=True)
            many.SetName("looks like a volume")
            image.GetFieldData().AddArray(many)
            data = image.GetCellData() if cells else image.GetPointData()
            for name, kind in (("vtkGhostType", "u1"), ("vtkOriginalPointIds", "i8"), ("density", "f4")):
                self.add(data, VALUES.astype(kind) if name == "density" else numpy.zeros(120, kind), name)
            place = phantom.affine(numpy.eye(3))
            if cells:
                place[:3, 3] += numpy.array(phantom.SPACING) / 2
            self.same(volume(self.write(image, mode)), VALUES, place, mode)
            self.assertRaises(Exception, volume, self.write(image, mode), "--field", "TimeValue")


    def test_look_tells_of_every_array(self):
        """With the components, type and range of each, that which is read without a name first."""
        velocity = numpy.stack([VALUES, 119 - VALUES, -VALUES], axis=-1).astype("f4")
        for mode, packed in itertools.product(("ascii", "binary", "appended"), (False, True)):
            image = vtk.vtkImageData()
            image.CopyStructure(self.image())
            array = numpy_to_vtk(velocity.reshape(-1, 3), deep=True)
            array.SetName("velocity")
            image.GetPointData().AddArray(array)
            self.add(image.GetPointData(), numpy.zeros(120, "u1"), "vtkGhostType")
            self.add(image.GetPointData(), 2.0 * VALUES, "pressure")
            self.add(image.GetPointData(), VALUES.astype("i2"), "density")
            self.add(image.GetCellData(), numpy.arange(60, dtype="i4"), "material")
            image.GetPointData().SetActiveScalars("density")
            (said,), status = looked.look(self.write(image, mode, packed))
            self.assertEqual((status, said["refused"]), (0, []), said)
            told = [(each["name"], each["components"], each["type"], *(each["columns"][0][end] for end in ("min", "max")))
                    for each in said["found"]]
            length = float(numpy.linalg.norm(velocity, axis=-1).max())
            shortest = float(numpy.linalg.norm(velocity, axis=-1).min())
            self.assertEqual(told[0], ("density", 1, "i16", 0, 119), mode)
            self.assertEqual(set(told[:4] + told[5:]), {
                ("density", 1, "i16", 0, 119), ("velocity:0", 3, "f32", 0, 119), ("velocity:1", 3, "f32", 0, 119),
                ("velocity:2", 3, "f32", -119, 0), ("pressure", 1, "f64", 0, 238), ("material", 1, "i32", 0, 59)})
            self.assertEqual(told[4][:3], ("velocity:magnitude", 3, "f32"))
            numpy.testing.assert_allclose(told[4][3:], (shortest, length), rtol=1e-6)


@needs_program
class Vdb(Case):
    def test_look_tells_of_every_grid(self):
        grids = []
        for name, low in (("heat", 5.0), ("fuel", -3.0)):
            grid = pyopenvdb.FloatGrid()
            grid.copyFromArray(low + numpy.arange(24.0).reshape(2, 3, 4))
            grid.name = name
            grids.append(grid)
        path = self.folder / "a.vdb"
        vectors = pyopenvdb.Vec3SGrid()
        vectors.name = "speed"
        vectors.fill((0, 0, 0), (3, 3, 3), (1.0, 2.0, 3.0))
        pyopenvdb.write(str(path), [vectors, *grids])
        (said,), status = looked.look(path)
        self.assertEqual((status, said["refused"]), (1, []))
        self.assertEqual([(each["name"], each["components"]) for each in said["found"]], [("heat", 1), ("speed", 3), ("fuel", 1)])
        heat, speed, fuel = said["found"]
        self.assertEqual([(each["columns"][0]["min"], each["columns"][0]["max"]) for each in (heat, fuel)], [(5, 28), (-3, 20)])
        self.assertEqual((heat["type"], heat["refused"]), ("f32", []))
        self.assertIn("holds values of type vec3s", speed["refused"][0])
        self.same(volume(path), (5.0 + numpy.arange(24.0).reshape(2, 3, 4)).transpose(2, 1, 0))

    def write(self, grid):
        grid.name = "density"
        path = self.folder / "a.vdb"
        pyopenvdb.write(str(path), grid)
        return path

    def test_grids(self):
        shape = (20, 17, 13)
        rng = numpy.random.default_rng(8)
        for form, kind in (("FloatGrid", "f4"), ("DoubleGrid", "f8"), ("Int32Grid", "i4")):
            if not hasattr(pyopenvdb, form):
                continue  # Debian's has floats alone
            values = rng.integers(1, 1000, shape).astype(kind)
            grid = getattr(pyopenvdb, form)()
            grid.copyFromArray(values)
            grid.transform = pyopenvdb.createLinearTransform(0.5)
            made = volume(self.write(grid))
            self.same(made, values.transpose(2, 1, 0).astype(float), numpy.diag([0.5, 0.5, 0.5, 1]), kind)

    def test_one_missing_sample_is_one(self):
        """At every place of a leaf: the first, one within, the last."""
        values = numpy.random.default_rng(9).integers(1, 1000, (16, 16, 16)).astype("f4")
        for place in ((0, 0, 0), (8, 0, 8), (3, 4, 5), (15, 15, 15), (8, 8, 8)):
            grid = pyopenvdb.FloatGrid()
            grid.copyFromArray(values)
            grid.getAccessor().setValueOn(place, float("nan"))
            made = volume(self.write(grid))
            wanted = values.copy()
            wanted[place] = numpy.delete(values.ravel(), numpy.ravel_multi_index(place, values.shape)).min()
            self.same(made, wanted.transpose(2, 1, 0), what=str(place))
            self.assertEqual(int(made.manifest["hybrid"]["steps"][0]["invalid"]), 1)


if __name__ == "__main__":
    unittest.main()
