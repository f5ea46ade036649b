# SPDX-License-Identifier: GPL-3.0-or-later
"""How long ParaView takes for the volume that `bench-device --export FOLDER` wrote; run by tests/bench/compare.

    pvbatch draw_volume.py FOLDER MODE [--frames N] [--png FILE]

MODE is 'GPU Based' or 'Ray Cast Only'. The mapper behind these two modes is put into ParaView's view directly: its
representation gives no access to the distance between samples, which is held at a cell's edge.
"""
import argparse
import pathlib

import numpy as np
from offscreen import keep_picture, make_view, measure, report, scene_of
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolume, vtkVolumeProperty
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

STEPS = 255.0  # the volume holds t in this many steps, so that bytes say the same as our floats


def image_of(folder, cells):
    values = np.fromfile(pathlib.Path(folder) / "volume.u8", dtype=np.uint8)
    image = vtkImageData()
    image.SetDimensions(cells, cells, cells)
    spacing = 2.0 / cells
    image.SetSpacing(spacing, spacing, spacing)
    image.SetOrigin(*[-1.0 + spacing / 2.0] * 3)  # samples lie at the centres of our cells
    image.GetPointData().SetScalars(numpy_to_vtk(values, deep=1))
    return image


def property_of(scene):
    opacity = vtkPiecewiseFunction()
    for t, value in scene["opacity"]:
        opacity.AddPoint(STEPS * t, value)
    color = vtkColorTransferFunction()
    last = len(scene["colors"]) - 1
    for i, rgb in enumerate(scene["colors"]):
        color.AddRGBPoint(STEPS * i / last, *rgb)
    look = vtkVolumeProperty()
    look.SetScalarOpacity(opacity)
    look.SetColor(color)
    look.SetScalarOpacityUnitDistance(scene["opacityLength"])
    look.SetInterpolationTypeToLinear()
    look.ShadeOff()
    return look


def mapper_of(image, mode, distance):
    mapper = vtkSmartVolumeMapper()
    mapper.SetInputData(image)
    if mode == "GPU Based":
        mapper.SetRequestedRenderModeToGPU()
    else:
        mapper.SetRequestedRenderModeToRayCast()
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetInteractiveAdjustSampleDistances(0)
    mapper.SetSampleDistance(distance)
    return mapper


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("mode", choices=["GPU Based", "Ray Cast Only"])
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--png")
    options = parser.parse_args()
    scene = scene_of(options.folder)
    view = make_view(scene)
    volume = vtkVolume()
    distance = 2.0 / scene["cells"]
    volume.SetMapper(mapper_of(image_of(options.folder, scene["cells"]), options.mode, distance))
    volume.SetProperty(property_of(scene))
    view.GetRenderer().AddVolume(volume)
    view.CameraPosition = scene["eyes"][0]
    view.StillRender()
    view.GetRenderer().ResetCameraClippingRange()  # the view knows only of its own representations
    times = measure(view, scene, options.frames)
    picture = keep_picture(view, scene["eyes"][0], options.png)
    report(view, mode=options.mode, **times, **picture)


main()
