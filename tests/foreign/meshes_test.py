#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in every form: areas, enclosed volumes and counts are those of the shape, or of VTK."""
import itertools
import unittest

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from support import Case, mesh, needs_program

CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]  # seen from outside


def obj(points, faces, end="\n"):
    return end.join([f"v {x!r} {y!r} {z!r}" for x, y, z in points] +
                    ["f " + " ".join(str(i + 1) for i in face) for face in faces]) + end


def star(corners, turn=0.0):
    angles = 2 * numpy.pi * numpy.arange(corners) / corners + turn
    radii = numpy.where(numpy.arange(corners) % 2 == 0, 1.0, 0.4)
    return numpy.stack([radii * numpy.cos(angles), radii * numpy.sin(angles)], axis=1)


def comb(teeth):
    """A back with teeth: many corners that turn the other way, all in a row."""
    top = [(2 * i + j, 3.0) if j in (0, 1) else None for i in range(teeth) for j in (0, 1)]
    outline = [(0.0, 0.0), (2.0 * teeth, 0.0)]
    for i in reversed(range(teeth)):
        outline += [(2 * i + 2.0, 1.0), (2 * i + 1.5, 3.0), (2 * i + 1.0, 1.0)]
    return numpy.array(outline), len(top)


def area_of(outline):
    x, y = outline.T
    return abs(numpy.dot(x, numpy.roll(y, -1)) - numpy.dot(y, numpy.roll(x, -1))) / 2


@needs_program
class Meshes(Case):
    def write(self, data, name="a.obj"):
        path = self.folder / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return path

    def cube(self, path, words=""):
        made = mesh(path)
        self.assertAlmostEqual(made.area, 6, 5, str(path))
        self.assertAlmostEqual(made.enclosed, 1, 5, str(path))
        self.assertEqual(len(made.triangles), 12)
        self.assertIn(words, made.notes)

    def test_polygons_of_any_size(self):
        outlines = [star(66), star(67), star(200, 0.3), star(2001), comb(30)[0], comb(500)[0]]
        for outline, (tilt, far) in itertools.product(outlines, ((0, 0), (1, 0), (0, 5e6))):
            flat = numpy.column_stack([outline, numpy.zeros(len(outline))])
            points = flat[:, [2, 0, 1]] if tilt else flat
            path = self.write(obj([tuple(map(float, p)) for p in points + far], [range(len(points))]))
            made = mesh(path)
            self.assertEqual(len(made.triangles), len(outline) - 2)
            self.assertLess(abs(made.area / area_of(outline) - 1), 1e-5, f"{len(outline)} {tilt} {far}")

    def test_places_far_away(self):
        x, y = numpy.meshgrid(numpy.arange(41) * 0.1, numpy.arange(41) * 0.1, indexing="ij")
        for origin in ((448123.4, 5450321.7, 112.25), (-1e7, 3e6, 0.0), (0.0, 0.0, 6378137.0)):
            points = numpy.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]) + origin
            faces = [(41 * i + j, 41 * i + 41 + j, 41 * i + 42 + j, 41 * i + 1 + j) for i in range(40) for j in range(40)]
            made = mesh(self.write(obj([tuple(map(float, p)) for p in points], faces)))
            self.assertEqual(len(made.triangles), 3200)
            self.assertLess(abs(made.area - 16), 1e-4)
            said = [float(word.strip("(),")) for word in made.notes.split(" was taken off")[0].split()]
            numpy.testing.assert_allclose(numpy.sort(made.points.astype(float) + said, axis=0), numpy.sort(points, axis=0),
                                          atol=1e-5)
        near = mesh(self.write(obj([tuple(map(float, p)) for p in points - origin + 20], faces)))
        self.assertEqual(near.notes, "")
        self.assertGreater(near.points.min(), 19)

    def test_forms_of_obj(self):
        text = obj(CUBE, SIDES)
        variants = {"marked": b"\xef\xbb\xbf" + text.encode(), "crlf": obj(CUBE, SIDES, "\r\n"),
                    "goes on": text.replace("f 1 2 4 3", "f 1 2\\\n 4 3"),
                    "goes on after a blank": text.replace("f 1 2 4 3", "f 1 2 4 \\\r\n3"),
                    "split vertex": text.replace("v 0 0 1", "v 0 0\\\n 1"),
                    "faces first": "\n".join(sorted(text.splitlines(), key=lambda line: line[0] != "f")),
                    "slashes": "vt 0 0\nvn 0 0 1\n" + text.replace("f 1 2 4 3", "f 1/1/1 2/1 4//1 3/1/1"),
                    "negative": text.replace("f 1 2 4 3", "f -8 -7 -5 -6"),
                    "weights": text.replace("v 0 0 1\n", "v 0 0 1 1.0 0.5 0.5 0.5\n"), "upper": text}
        for what, data in variants.items():
            with self.subTest(what):
                self.cube(self.write(data))
        self.cube(self.write(text + "f 1 2\nf 3\n"), "2 faces of fewer than three corners left out")
        self.refused("UTF-16", mesh, self.write(text.encode("utf-16")))

    def test_forms_of_off(self):
        body = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE)
        faces = "".join(f"4 {' '.join(map(str, face))}\n" for face in SIDES)
        for head in ("OFF\n8 6 0\n", "OFF8 6 0\n", "OFF 8 6 0\n", "OFF\n8\n6\n0\n", "OFF\n8 6\n", "OFF\n# a cube\n8 6 12\n",
                     "8 6 0\n", "OFF\n8\n6\n12\n", "COFF\n8 6 0\n", "OFF\n\n8 6\n0\n"):
            with self.subTest(head):
                self.cube(self.write(head + body + faces, "a.off"))
        self.cube(self.write("OFF 8 7 0\n" + body + faces + "2 0 1\n", "a.off"), "faces of fewer than three corners")

    def stl(self, count=None, head=b"", tail=b""):
        triangles = [(a, b, c) for s in SIDES for a, b, c in ((s[0], s[1], s[2]), (s[0], s[2], s[3]))]
        data = head.ljust(80, b" ") + (len(triangles) if count is None else count).to_bytes(4, "little")
        for triangle in triangles:
            corners = numpy.array([(0, 0, 0)] + [CUBE[i] for i in triangle], "<f4")
            data += corners.tobytes() + bytes(2)
        return data + tail

    def test_forms_of_stl(self):
        text = "solid cube\n"
        for side in SIDES:
            for a, b, c in ((0, 1, 2), (0, 2, 3)):
                corners = "".join(f"vertex {' '.join(map(str, CUBE[side[i]]))}\n" for i in (a, b, c))
                text += f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"
        text += "endsolid cube\n"
        for data in (text, text.upper(), text.title(), text.replace("\n", "\r\n"), self.stl(), self.stl(head=b"solid cube"),
                     self.stl(tail=b"more")):
            self.cube(self.write(data, "a.stl"))
        self.cube(self.write(self.stl(0), "a.stl"), "says 0 triangles; the 12 that follow were read")
        self.cube(self.write(self.stl(tail=bytes(100)), "a.stl"), "bytes for 2 more follow")
        self.refused("says 13 triangles", mesh, self.write(self.stl(13), "a.stl"))

    def ply(self, encoding, faces_first, number="float", index="int"):
        kinds = {"float": "f4", "double": "f8", "int": "i4", "uchar": "u1", "ushort": "u2"}
        order = ">" if "big" in encoding else "<"
        head = {"v": "element vertex 8\n" + "".join(f"property {number} {axis}\n" for axis in "xyz"),
                "f": f"element face 6\nproperty list uchar {index} vertex_indices\n"}
        if encoding == "ascii":
            body = {"v": "".join(f"{x} {y} {z}\n" for x, y, z in CUBE).encode(),
                    "f": "".join(f"4 {' '.join(map(str, s))}\n" for s in SIDES).encode()}
        else:
            body = {"v": numpy.array(CUBE, order + kinds[number]).tobytes(),
                    "f": b"".join(b"\x04" + numpy.array(s, order + kinds[index]).tobytes() for s in SIDES)}
        parts = "fv" if faces_first else "vf"
        text = f"ply\nformat {encoding} 1.0\ncomment c:\\\n" + "".join(head[p] for p in parts) + "end_header\n"
        return text.encode() + b"".join(body[p] for p in parts)

    def test_forms_of_ply(self):
        for encoding, first, number, index in itertools.product(
                ("ascii", "binary_little_endian", "binary_big_endian"), (False, True), ("float", "double"),
                ("int", "uchar", "ushort")):
            self.cube(self.write(self.ply(encoding, first, number, index), "a.ply"))

    def test_as_vtk_reads_them(self):
        """A sphere by VTK's writers."""
        source = vtk.vtkSphereSource()
        source.SetThetaResolution(24)
        source.SetPhiResolution(16)
        source.Update()
        measure = vtk.vtkMassProperties()
        measure.SetInputData(source.GetOutput())
        for writer, name, binary in ((vtk.vtkPLYWriter, "s.ply", False), (vtk.vtkPLYWriter, "s.ply", True),
                                     (vtk.vtkSTLWriter, "s.stl", False), (vtk.vtkSTLWriter, "s.stl", True),
                                     (vtk.vtkOBJWriter, "s.obj", None)):
            made = writer()
            if binary is not None:
                (made.SetFileTypeToBinary if binary else made.SetFileTypeToASCII)()
            made.SetFileName(str(self.folder / name))
            made.SetInputData(source.GetOutput())
            made.Write()
            read = mesh(self.folder / name)
            self.assertEqual(len(read.triangles), source.GetOutput().GetNumberOfPolys())
            self.assertLess(abs(read.area / measure.GetSurfaceArea() - 1), 1e-5, name)
            self.assertLess(abs(read.enclosed / measure.GetVolume() - 1), 1e-5, name)

    def test_which_triangles_cut_each_other(self):
        """Those pairs of two spheres that VTK finds, near the origin and far from it."""
        def sphere(middle, sides):
            source = vtk.vtkSphereSource()
            source.SetCenter(*middle)
            source.SetRadius(1)
            source.SetThetaResolution(sides)
            source.SetPhiResolution(sides)
            source.Update()
            return source.GetOutput()

        for far, middle in itertools.product((0.0, 250.0), ((0.7, 0.41, 0.33), (1.1, -0.9, 0.2), (2.3, 0.1, 0.2))):
            one, other = (sphere(numpy.array(at) + far, sides) for at, sides in (((0, 0, 0), 20), (middle, 23)))
            both = vtk.vtkAppendPolyData()
            both.AddInputData(one)
            both.AddInputData(other)
            writer = vtk.vtkPLYWriter()
            writer.SetFileName(str(self.folder / "a.ply"))
            writer.SetInputConnection(both.GetOutputPort())
            writer.Write()
            wanted = set()
            if middle[0] < 2:
                cut = vtk.vtkIntersectionPolyDataFilter()
                cut.SetInputData(0, one)
                cut.SetInputData(1, other)
                cut.SplitFirstOutputOff()
                cut.SplitSecondOutputOff()
                cut.Update()
                cells = cut.GetOutput(0).GetCellData()
                first, second = (vtk_to_numpy(cells.GetArray(f"Input{i}CellID")) for i in (0, 1))
                wanted = set(zip(first.tolist(), (second + one.GetNumberOfCells()).tolist()))
                self.assertGreater(len(wanted), 100)
            self.assertEqual(set(map(tuple, mesh(self.folder / "a.ply").intersections.tolist())), wanted)

    def test_surfaces_of_volumes_far_away(self):
        """A ball in a volume of far origin is as round as one at 0."""
        z, y, x = numpy.mgrid[0:24, 0:24, 0:24] - 11.5
        data = (100 - 8 * numpy.sqrt(x * x + y * y + z * z)).astype("<f4").tobytes()
        areas = []
        for origin in ("0 0 0", "448123.4 5450321.7 112.25"):
            path = self.write(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 24 24 24\nencoding: raw\nendian: little\n"
                              b"space dimension: 3\nspace directions: (.01,0,0) (0,.01,0) (0,0,.01)\nspace origin: (" +
                              origin.replace(" ", ",").encode() + b")\n\n" + data, "a.nrrd")
            made = mesh(path, "--isovalue", 36)
            areas.append(made.area)
        self.assertIn("was taken off all places", made.notes)
        self.assertLess(abs(areas[1] / areas[0] - 1), 1e-4)


if __name__ == "__main__":
    unittest.main()
