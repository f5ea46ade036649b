# SPDX-License-Identifier: GPL-3.0-or-later
"""How long ParaView takes for a volume of bytes; run by tests/bench/compare and tests/bench/hybrid/against_paraview.

    pvbatch draw_volume.py FOLDER MODE [--frames N] [--png FILE]

FOLDER holds scene.json and volume.u8, as `bench-device --export` writes them. Where the scene says so, samples lie
`spacing` apart from `origin` on and the volume is lit; else it fills [-1, 1]^3 and is not. MODE is 'GPU Based' or 'Ray
Cast Only'. The mapper behind these two modes is put into ParaView's view directly: its representation gives no access
to the distance between samples, which is held at a cell's edge.
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


def spacing_of(scene):
    return scene.get("spacing", 2.0 / scene["cells"])


def image_of(folder, scene):
    values = np.fromfile(pathlib.Path(folder) / "volume.u8", dtype=np.uint8)
    image = vtkImageData()
    image.SetDimensions(*[scene["cells"]] * 3)
    spacing = spacing_of(scene)
    image.SetSpacing(*[spacing] * 3)
    image.SetOrigin(*[scene.get("origin", -1.0 + spacing / 2.0)] * 3)  # samples lie at the centres of our cells
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
    light = scene.get("light")
    look.SetShade(light is not None)
    if light:
        look.SetAmbient(light["ambient"])
        look.SetDiffuse(light["diffuse"])
        look.SetSpecular(light["specular"])
        look.SetSpecularPower(32.0)
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
    volume.SetMapper(mapper_of(image_of(options.folder, scene), options.mode, spacing_of(scene)))
    volume.SetProperty(property_of(scene))
    view.GetRenderer().AddVolume(volume)
    view.CameraPosition = scene["eyes"][0]
    # The view knows only of its own representations.
    view.GetRenderer().ResetCameraClippingRange(volume.GetBounds())
    times = measure(view, scene, options.frames)
    picture = keep_picture(view, scene["eyes"][0], options.png)
    report(view, mode=options.mode, **times, **picture)


main()
