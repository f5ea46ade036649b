# SPDX-License-Identifier: GPL-3.0-or-later
"""How long ParaView takes for the points that `bench-device --export FOLDER` wrote; run by tests/bench/compare.

    pvbatch draw_points.py FOLDER [--translucent OPACITY] [--frames N] [--png FILE]

Opaque: 'Point Gaussian' of radius 0, which VTK draws as bare GL points without cells: its fastest way.
Translucent: 'Points' with depth peeling, its way of the right order.
"""
import argparse
import pathlib

import numpy as np
import paraview.simple as pv
from offscreen import keep_picture, make_view, measure, report, scene_of
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData


def vertices_of(count):
    """A vertex cell for each point, which the representation 'Points' draws."""
    cells = vtkCellArray()
    offsets = numpy_to_vtkIdTypeArray(np.arange(count + 1, dtype=np.int64), deep=1)
    points = numpy_to_vtkIdTypeArray(np.arange(count, dtype=np.int64), deep=1)
    cells.SetData(offsets, points)
    return cells


def source_of(folder, with_cells):
    positions = np.fromfile(pathlib.Path(folder) / "points.f32", dtype="<f4").reshape(-1, 3)
    points = vtkPoints()
    points.SetData(numpy_to_vtk(positions, deep=1))
    data = vtkPolyData()
    data.SetPoints(points)
    if with_cells:
        data.SetVerts(vertices_of(len(positions)))
    producer = pv.TrivialProducer()
    producer.GetClientSideObject().SetOutput(data)
    return producer, len(positions)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--translucent", type=float)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--png")
    options = parser.parse_args()
    scene = scene_of(options.folder)
    translucent = options.translucent is not None
    view = make_view(scene)
    if translucent:
        pv.GetSettingsProxy("RenderViewSettings").DepthPeeling = 1
    source, count = source_of(options.folder, translucent)
    shown = pv.Show(source, view)
    shown.SetRepresentationType("Points" if translucent else "Point Gaussian")
    shown.ColorArrayName = [None, ""]
    shown.AmbientColor = shown.DiffuseColor = scene["pointColor"]
    shown.Opacity = options.translucent if translucent else 1.0
    if translucent:
        shown.PointSize = 1
    else:
        shown.GaussianRadius = 0.0
    times = measure(view, scene, options.frames)
    picture = keep_picture(view, scene["eyes"][0], options.png)
    report(view, points=count, peels=view.MaximumNumberOfPeels if translucent else 0, **times, **picture)


main()
