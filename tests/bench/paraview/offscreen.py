# SPDX-License-Identifier: GPL-3.0-or-later
"""What both ParaView drivers share: a bare view of the given size and camera, and the clock around a still picture."""
import json
import pathlib
import statistics
import time

import paraview.simple as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGWriter


def scene_of(folder):
    return json.loads((pathlib.Path(folder) / "scene.json").read_text())


def make_view(scene):
    view = pv.CreateRenderView()
    view.ViewSize = [scene["width"], scene["height"]]
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.BackgroundColorMode = "Single Color"
    view.Background = [0, 0, 0]
    view.CameraViewAngle = scene["fovYDegrees"]
    view.CameraFocalPoint = scene["target"]
    view.CameraViewUp = scene["up"]
    view.GetRenderWindow().SetMultiSamples(0)  # one sample a pixel, as we draw
    return view


def still_seconds(view, eye):
    """Until the driver has really drawn, not only until it has been told to."""
    view.CameraPosition = eye
    start = time.perf_counter()
    view.StillRender()
    view.GetRenderWindow().WaitForCompletion()
    return time.perf_counter() - start


def measure(view, scene, frames):
    """The first picture sends the data to the driver; it is told apart."""
    first = still_seconds(view, scene["eyes"][0])
    turns = [scene["eyes"][i % len(scene["eyes"])] for i in range(1, frames + 1)]
    times = [still_seconds(view, eye) for eye in turns]
    return {"firstMs": 1e3 * first, "ms": 1e3 * statistics.median(times), "fastestMs": 1e3 * min(times),
            "frames": frames}


def keep_picture(view, eye, path):
    """Saves the picture from `eye`; how much of it is lit and how bright it is, to be held against ours."""
    view.CameraPosition = eye
    image = view.CaptureWindow(1)  # renders once more
    if path:
        writer = vtkPNGWriter()
        writer.SetFileName(path)
        writer.SetInputData(image)
        writer.Write()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars())[:, :3]
    return {"lit": float((pixels.max(1) > 0).mean()), "mean": float(pixels.mean())}


def report(view, **values):
    window = view.GetRenderWindow()
    capabilities = window.ReportCapabilities().splitlines()
    renderer = [line.split(":", 1)[1].strip() for line in capabilities if "renderer string" in line]
    values["renderer"] = renderer[0] if renderer else window.GetClassName()
    version = pv.GetParaViewVersion()
    values["version"] = f"{version.major}.{version.minor}"
    values["size"] = list(window.GetSize())
    print("RESULT " + json.dumps(values), flush=True)
