#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds pictures of particles against the particles themselves: numpy projects all of them, and what each pixel shows
is compared with what lies in it. Shares no code with Mote.

    truth.py --bin DIR [--sets 100] [--first 0] [--most 1000000] [--device cpu] [--keep DIR]

Prints a line a set and the worst of each measure:
  black   share of the pixels that hold particles of which no component is above 8 of 255
  rank    rank correlation of light with weight, means of 3 x 3 pixels, where there is any of either
  falls   share of neighbouring patches of 9 x 9 pixels where weight rises by a fifth and light falls by a fiftieth
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import data  # noqa: E402

SIZE = (640, 360)
CAMERA = {"eye": [2.2, 1.9, 4.2], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 35}
POINTS = {"volume": {"curve": [{"density": 0, "opacity": 0}]},
          "points": {"linked": False, "curve": [{"density": 0, "fraction": 1}]}}


def project(places, size=SIZE, camera=CAMERA):
    """Columns, rows and depths of places in layer space."""
    eye, target, up = (numpy.array(camera[key], float) for key in ("eye", "target", "up"))
    back = (eye - target) / numpy.linalg.norm(eye - target)
    right = numpy.cross(up, back)
    right /= numpy.linalg.norm(right)
    seen = (places - eye) @ numpy.c_[right, numpy.cross(back, right), back]
    depth = -seen[:, 2]
    scale = size[1] / 2 / numpy.tan(numpy.radians(camera["fovYDegrees"]) / 2) / depth
    return size[0] / 2 + seen[:, 0] * scale, size[1] / 2 - seen[:, 1] * scale, depth


def weight_map(places, weight, size=SIZE, camera=CAMERA):
    x, y, depth = project(places, size, camera)
    inside = (depth > 0) & (x >= 0) & (x < size[0]) & (y >= 0) & (y < size[1])
    pixel = y[inside].astype(int) * size[0] + x[inside].astype(int)
    return numpy.bincount(pixel, weight[inside], size[0] * size[1]).reshape(size[1], size[0])


def light_map(picture):
    """Linear luminance, and the greatest component of 255."""
    pixels = numpy.asarray(Image.open(picture).convert("RGB"))
    s = pixels / 255.0
    linear = numpy.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)
    return linear @ numpy.array([0.2126, 0.7152, 0.0722]), pixels.max(axis=2)


def mean(values, edge):
    """Of the square of pixels around each."""
    sums = numpy.pad(values, edge // 2).cumsum(0).cumsum(1)
    sums = numpy.pad(sums, ((1, 0), (1, 0)))
    return (sums[edge:, edge:] - sums[:-edge, edge:] - sums[edge:, :-edge] + sums[:-edge, :-edge]) / edge ** 2


def ranks(values):
    _, inverse, counts = numpy.unique(values, return_inverse=True, return_counts=True)
    return (numpy.cumsum(counts) - (counts - 1) / 2)[inverse]


def rank_correlation(one, other):
    a, b = ranks(one), ranks(other)
    a, b = a - a.mean(), b - b.mean()
    norm = numpy.sqrt((a * a).sum() * (b * b).sum())
    return float((a * b).sum() / norm) if norm > 0 else 1.0


def falling(weight, light):
    """Share of pairs of patches, of those where the weight rises."""
    weight, light = mean(weight, 9), mean(light, 9)
    rises = falls = 0
    for step in ((9, 0), (0, 9)):
        for sign in (1, -1):
            w, l = numpy.roll(weight, (sign * step[0], sign * step[1]), (0, 1)), \
                numpy.roll(light, (sign * step[0], sign * step[1]), (0, 1))
            up = (weight > 0) & (w > 1.2 * weight)
            rises += int(up.sum())
            falls += int((up & (l < 0.98 * light)).sum())
    return falls / max(rises, 1)


def measure(weight, picture):
    light, most = light_map(picture)
    held = weight > 0
    w, l = mean(weight, 3), mean(light, 3)
    some = (w > 0) | (l > 0)
    return {"black": float((most[held] <= 8).mean()) if held.any() else 0.0,
            "rank": rank_correlation(w[some], l[some]) if some.any() else 1.0,
            "falls": falling(weight, light)}


class Plots:
    """Datasets of generated particles in a folder, and pictures of them."""

    def __init__(self, folder, programs):
        self.folder, self.programs = pathlib.Path(folder), pathlib.Path(programs)
        (self.folder / "plots").mkdir(parents=True, exist_ok=True)

    def add(self, name, places, weight, columns="none"):
        """Returns the places in layer space of the particles that the plot holds. `columns`: by name, kept beside them."""
        table = self.folder / f"{name}.npz"
        x, y, z = numpy.ascontiguousarray(places.T)
        numpy.savez(table, x=x, y=y, z=z, weight=weight)
        plot = self.folder / "plots" / f"{name}.mote"
        subprocess.run([str(self.programs / "mote-prep"), "particles", str(table), "--axes", "x,y,z", "--out", str(plot),
                        "--columns", columns, "--quiet"], check=True, capture_output=True)
        table.unlink()
        axes = json.loads((plot / "manifest.json").read_text())["particles"]["axes"]
        low = numpy.array([axis.get("min", 0.0) for axis in axes])
        high = numpy.array([axis.get("max", 0.0) for axis in axes])
        return 2 * (places - low) / (high - low) - 1

    def draw(self, views, out, device="cpu", form="png"):
        """Pictures of views, in their order, in a format of mote-frames."""
        script = self.folder / f"{out}.json"
        script.write_text(json.dumps({"views": views}))
        subprocess.run([str(self.programs / "mote-frames"), str(script), "--spawn", f"data={self.folder / 'plots'}",
                        "--device", device, "--out", str(self.folder / out), "--format", form, "--quiet"], check=True, capture_output=True)
        return [self.folder / out / f"frame-{i:06d}.png" for i in range(len(views))]


def view(name, style=None, size=SIZE, camera=CAMERA, **more):
    return {"width": size[0], "height": size[1], "camera": camera,
            "layers": [{"dataset": f"data/{name}", "particles": style or {}}], **more}


def hold(plots, seeds, most, device):
    """A measure of each set and of the same set as points alone: yields (name, count, default, points)."""
    sets = []
    for seed in seeds:
        form, places, weight = data.particles(seed, most)
        name = f"{seed:04d}-{form}"
        inside = plots.add(name, places, weight)
        kept = numpy.all(numpy.abs(inside) <= 1, axis=1)
        sets.append((name, int(kept.sum()), weight_map(inside[kept], weight[kept])))
    pictures = plots.draw([view(name, style) for name, _, _ in sets for style in (None, POINTS)], "frames", device)
    for i, (name, count, weight) in enumerate(sets):
        yield name, count, measure(weight, pictures[2 * i]), measure(weight, pictures[2 * i + 1])


def worst(results):
    return {"black": max(r["black"] for r in results), "rank": min(r["rank"] for r in results),
            "falls": max(r["falls"] for r in results)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True)
    parser.add_argument("--sets", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--most", type=int, default=1_000_000)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--keep", help="a folder for plots and pictures")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        plots = Plots(options.keep or folder, options.bin)
        drawn, points = [], []
        batch = 20
        for first in range(options.first, options.first + options.sets, batch):
            seeds = range(first, min(first + batch, options.first + options.sets))
            for name, count, one, other in hold(plots, seeds, options.most, options.device):
                drawn.append(one)
                points.append(other)
                print(f"{name:16} {count:8}  " + "  ".join(f"{k} {one[k]:.4f} ({other[k]:.4f})" for k in one), flush=True)
    print("worst            default " + json.dumps(worst(drawn)))
    print("                 points  " + json.dumps(worst(points)))


if __name__ == "__main__":
    main()
