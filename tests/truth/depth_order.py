#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How well a picture tells which of a volume and a mesh is in front, without and with depth contrast. Scenes of balls
and rings in a volume with a mesh before, behind and half in it are drawn; numpy alone knows from their distance
functions where one hides the other, and two observers, who see nothing but the picture and where the border lies, say
which side is nearer. Shares no code with Mote.

    depth_order.py --bin DIR [--scenes 48] [--first 0] [--contrasts 0 0.5 1] [--device cpu] [--keep DIR]

Prints a line a contrast, rates of right answers on places that nobody was told of:
  gap      the side that fades towards the background beside the border is the farther one: the gap that illustrators
           leave (Appel, Rohlf and Stein 1979, The haloed line effect for hidden line elimination)
  learned  a linear classifier of tones beside the border, their changes, and the border's bend (convex sides are more
           often figures: Kanizsa and Gerbino 1976), fitted to half of the scenes and asked about the others
  alike    the same, of places alone whose two sides differ by less than a tenth in lightness without contrast
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy
from PIL import Image

SIZE = (480, 360)
FOV = 23.0
SAMPLES = 80  # of the volume along an edge
REACH = 9     # pixels beside a border that observers look at


def ball(places, middle, radius):
    return numpy.linalg.norm(places - middle, axis=-1) - radius


def ring(places, middle, turn, radius, tube):
    """Distance to a torus around the z axis of its own frame."""
    own = (places - middle) @ turn
    around = numpy.hypot(own[..., 0], own[..., 1]) - radius
    return numpy.hypot(around, own[..., 2]) - tube


def turned(random):
    q, _ = numpy.linalg.qr(random.normal(size=(3, 3)))
    return q if numpy.linalg.det(q) > 0 else -q


def solids(random):
    """A distance function of some balls and rings in [-1, 1]^3."""
    parts = []
    for _ in range(random.integers(1, 4)):
        middle = random.uniform(-0.35, 0.35, 3)
        if random.random() < 0.5:
            parts.append(lambda p, m=middle, r=random.uniform(0.2, 0.4): ball(p, m, r))
        else:
            shape = turned(random), random.uniform(0.35, 0.5), random.uniform(0.07, 0.14)
            parts.append(lambda p, m=middle, s=shape: ring(p, m, *s))
    return lambda places: numpy.minimum.reduce([part(places) for part in parts])


def mesh_of(kind, path):
    """The unit ball, or a ring of radius 1 and tube 0.3, as triangles."""
    columns, rows = 96, 48
    u, v = numpy.meshgrid(2 * numpy.pi * numpy.arange(columns) / columns, numpy.arange(rows + 1) / rows, indexing="ij")
    if kind == "ball":
        v = numpy.pi * v
        places = numpy.stack([numpy.sin(v) * numpy.cos(u), numpy.sin(v) * numpy.sin(u), numpy.cos(v)], -1)
    else:
        v = 2 * numpy.pi * v
        out = 1 + 0.3 * numpy.cos(v)
        places = numpy.stack([out * numpy.cos(u), out * numpy.sin(u), 0.3 * numpy.sin(v)], -1)
    number = numpy.arange(columns * (rows + 1)).reshape(columns, rows + 1) + 1
    following = numpy.roll(number, -1, axis=0)
    a, b, c, d = number[:, :-1], following[:, :-1], following[:, 1:], number[:, 1:]
    triangles = numpy.concatenate([numpy.stack([a, b, c], -1).reshape(-1, 3), numpy.stack([a, c, d], -1).reshape(-1, 3)])
    with open(path, "w") as out:
        out.writelines(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in places.reshape(-1, 3))
        out.writelines(f"f {i} {j} {k}\n" for i, j, k in triangles)


class Scene:
    """A view, and what numpy knows of it."""

    def __init__(self, seed):
        random = numpy.random.default_rng(seed)
        self.name = f"solids{seed}"
        self.volume = solids(random)
        back = random.normal(size=3)
        self.eye = 4.5 * back / numpy.linalg.norm(back)
        self.up = [0, 1, 0] if abs(back[1]) < 0.9 * numpy.linalg.norm(back) else [1, 0, 0]
        self.kind = "ball" if random.random() < 0.5 else "ring"
        self.turn, self.scale = turned(random), random.uniform(0.3, 0.5)
        self.middle = random.uniform(-0.25, 0.25, 3) + random.uniform(-0.7, 0.7) * self.eye / 4.5
        self.background = 1.0 if random.random() < 0.5 else 0.0
        tone = random.uniform(0.45, 0.8)
        self.color = [tone, tone * random.uniform(0.85, 1), tone * random.uniform(0.85, 1)]
        self.mesh_color = list(numpy.clip(numpy.array(self.color) * random.uniform(0.85, 1.15, 3), 0, 1))

    def mesh(self, places):
        own = (places - self.middle) @ self.turn / self.scale
        if self.kind == "ball":
            return self.scale * ball(own, 0.0, 1.0)
        return self.scale * ring(own, 0.0, numpy.eye(3), 1.0, 0.3)

    def view(self, contrast):
        step = 2.0 / SAMPLES  # samples are the middles of cells
        to_world = [step, 0, 0, -1 + step / 2, 0, step, 0, -1 + step / 2, 0, 0, step, -1 + step / 2, 0, 0, 0, 1]
        placed = numpy.eye(4)
        placed[:3, :3], placed[:3, 3] = self.scale * self.turn, self.middle
        light = {"direction": [-0.4, 0.6, 0.7]}
        return {"width": SIZE[0], "height": SIZE[1], "background": [self.background] * 3, "depthContrast": contrast,
                "camera": {"eye": list(self.eye), "target": [0, 0, 0], "up": self.up, "fovYDegrees": FOV},
                "layers": [
                    {"dataset": f"data/{self.name}", "transform": to_world,
                     "hybrid": {"light": light, "curve": [{"value": -0.03, "opacity": 0, "color": self.color},
                                                          {"value": 0.03, "opacity": 0.95, "color": self.color}]}},
                    {"dataset": f"data/{self.kind}", "transform": list(placed.reshape(-1)),
                     "mesh": {"color": self.mesh_color, "light": light}}]}

    def depths(self):
        """Of the volume and of the mesh in each pixel's middle; infinite where it is missed."""
        back = self.eye / numpy.linalg.norm(self.eye)
        right = numpy.cross(self.up, back)
        right /= numpy.linalg.norm(right)
        x, y = numpy.meshgrid(numpy.arange(SIZE[0]) + 0.5 - SIZE[0] / 2, SIZE[1] / 2 - numpy.arange(SIZE[1]) - 0.5)
        unit = SIZE[1] / 2 / numpy.tan(numpy.radians(FOV) / 2)
        way = (x[..., None] * right + y[..., None] * numpy.cross(back, right)) / unit - back
        return [self._trace(one, way) for one in (self.volume, self.mesh)]

    def _trace(self, distance, way):
        """Along rays told by depth, as far as the distance functions leave room."""
        way = way.reshape(-1, 3)
        length = numpy.linalg.norm(way, axis=-1)
        depth, going = numpy.full(len(way), 2.5), numpy.arange(len(way))
        for _ in range(120):
            room = distance(self.eye + depth[going, None] * way[going]) / length[going]
            depth[going] += 0.95 * room
            going = going[(numpy.abs(room) > 1e-4) & (depth[going] < 7.0)]
        met = numpy.abs(distance(self.eye + depth[:, None] * way)) < 2e-3
        return numpy.where(met & (depth < 7.0), depth, numpy.inf).reshape(SIZE[1], SIZE[0])


def blurred(picture, deviation):
    reach = round(4 * deviation)
    weights = numpy.exp(-0.5 * (numpy.arange(-reach, reach + 1) / deviation) ** 2)
    weights /= weights.sum()
    for axis in (0, 1):
        picture = numpy.apply_along_axis(numpy.convolve, axis, picture, weights, mode="same")
    return picture


def borders(volume, mesh):
    """Places where one hides the other: column, row, the unit way towards the nearer one."""
    order = numpy.where(numpy.minimum(volume, mesh) == numpy.inf, -1, numpy.where(volume < mesh, 0, 1))
    depth = numpy.minimum(volume, mesh)
    found = []
    side = blurred(numpy.where(order == 1, 1.0, 0.0), 2.5)
    gy, gx = numpy.gradient(side)
    for dy, dx in ((0, 1), (1, 0)):
        one, other = order[:SIZE[1] - dy, :SIZE[0] - dx], order[dy:, dx:]
        with numpy.errstate(invalid="ignore"):
            step = depth[dy:, dx:] - depth[:SIZE[1] - dy, :SIZE[0] - dx]
        rows, columns = numpy.nonzero((one >= 0) & (other >= 0) & (one != other) & (numpy.abs(step) > 0.08))
        for row, column in zip(rows[::3], columns[::3]):
            way = numpy.array([gx[row, column], gy[row, column]])
            at = numpy.array([column + 0.5 + dx / 2, row + 0.5 + dy / 2])
            if numpy.linalg.norm(way) < 0.02 or not all(2 * REACH < a < s - 2 * REACH for a, s in zip(at, SIZE)):
                continue
            way /= numpy.linalg.norm(way)
            nearer = other[row, column] if step[row, column] < 0 else one[row, column]
            found.append((*at, *(way if nearer == 1 else -way)))
    return numpy.array(found).reshape(-1, 4), order


def profiles(lightness, places):
    """Tones across each border, from the farther side (-REACH) to the nearer (REACH), means along three pixels."""
    t = numpy.arange(-REACH, REACH + 1) + 0.0
    along = numpy.array([-1.0, 0.0, 1.0])
    x, y, dx, dy = (places[:, i, None, None] for i in range(4))
    columns = x + dx * t[:, None] - dy * along - 0.5
    rows = y + dy * t[:, None] + dx * along - 0.5
    left, top = numpy.floor(columns).astype(int), numpy.floor(rows).astype(int)
    u, v = columns - left, rows - top
    above = (1 - u) * lightness[top, left] + u * lightness[top, left + 1]
    below = (1 - u) * lightness[top + 1, left] + u * lightness[top + 1, left + 1]
    return ((1 - v) * above + v * below).mean(axis=2)


def bends(order, places):
    """By how much less than half of a disc around a border lies on its nearer side: convex where it is above 0."""
    x, y = numpy.meshgrid(numpy.arange(-12, 13), numpy.arange(-12, 13))
    disc = numpy.hypot(x, y) <= 12
    made = []
    for column, row, dx, dy in places:
        i, j = int(column), int(row)
        patch = order[max(j - 12, 0):j + 13, max(i - 12, 0):i + 13]
        if patch.shape != disc.shape:
            made.append(0.0)
            continue
        nearer = patch == order[int(row + 2 * dy), int(column + 2 * dx)]
        made.append(0.5 - numpy.count_nonzero(nearer & disc) / numpy.count_nonzero(disc))
    return numpy.array(made)


def lightness_of(picture):
    """CIE L*, 0 to 1, of a picture of 8 bits."""
    encoded = numpy.asarray(Image.open(picture).convert("RGB")) / 255.0
    linear = numpy.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    y = linear @ [0.2126, 0.7152, 0.0722]
    return numpy.where(y > 216 / 24389, 1.16 * numpy.cbrt(y) - 0.16, y * 243.89 / 27)


def cues(tones, bend, background):
    """What changes its sign where the sides change places: differences of tones and of their changes, by the
    background's, and the bend."""
    flip = tones[:, ::-1]
    odd = (tones - flip)[:, REACH + 1:]
    change = (numpy.abs(numpy.diff(tones, axis=1)) - numpy.abs(numpy.diff(flip, axis=1)))[:, REACH:]
    sign = 1.0 if background > 0.5 else -1.0
    return numpy.c_[sign * odd, odd, change, bend]


def gap_answers(tones, background):
    """Whether the nearer side fades less towards the background beside the border."""
    away = numpy.abs(tones - background)
    near = away[:, REACH + 5:].mean(axis=1) - away[:, REACH + 2:REACH + 4].mean(axis=1)
    far = away[:, :REACH - 4].mean(axis=1) - away[:, REACH - 3:REACH - 1].mean(axis=1)
    return near < far


def fitted(features):
    """Weights of a logistic classifier without a constant, by Newton's method with a small ridge."""
    weights = numpy.zeros(features.shape[1])
    for _ in range(30):
        chance = 1 / (1 + numpy.exp(-numpy.clip(features @ weights, -30, 30)))
        slope = features.T @ (1 - chance) - 1e-2 * weights
        bend = (features * (chance * (1 - chance))[:, None]).T @ features + 1e-2 * numpy.eye(len(weights))
        weights += numpy.linalg.solve(bend, slope)
    return weights


class Pictures:
    def __init__(self, folder, programs, device="cpu"):
        self.folder, self.programs, self.device = pathlib.Path(folder), pathlib.Path(programs), device
        (self.folder / "data").mkdir(parents=True, exist_ok=True)
        for kind in ("ball", "ring"):
            mesh_of(kind, self.folder / f"{kind}.obj")
            self._run("mote-prep", "mesh", self.folder / f"{kind}.obj", "--out", self.folder / "data" / f"{kind}.mote")

    def _run(self, program, *arguments):
        done = subprocess.run([self.programs / program, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{program}: {done.stderr}")

    def add(self, scene):
        places = 2 * (numpy.indices((SAMPLES,) * 3)[::-1].transpose(1, 2, 3, 0) + 0.5) / SAMPLES - 1
        values = numpy.clip(-scene.volume(places), -0.25, 0.25).astype(numpy.float32)  # z slowest
        source = self.folder / f"{scene.name}.npy"
        numpy.save(source, values)
        self._run("mote-prep", "volume", source, "--low", str(SAMPLES), "--error-grid", str(SAMPLES),
                  "--out", self.folder / "data" / f"{scene.name}.mote")

    def draw(self, scenes, contrast):
        """Lightness, one a scene."""
        script = self.folder / "views.json"
        script.write_text(json.dumps({"views": [scene.view(contrast) for scene in scenes]}))
        out = self.folder / f"out{contrast}"
        self._run("mote-frames", script, "--spawn", f"data={self.folder / 'data'}", "--device", self.device, "--out", out)
        return [lightness_of(one) for one in sorted(out.glob("*.png"))]


def measure(pictures, scenes, contrasts):
    """For each contrast how often each observer is right, and on how many places. `contrasts`: begin with 0."""
    for scene in scenes:
        pictures.add(scene)
    borders_of = [borders(*scene.depths()) for scene in scenes]
    results, alike = {}, None
    for contrast in contrasts:
        drawn = pictures.draw(scenes, contrast)
        tones = [profiles(lightness, places) for lightness, (places, _) in zip(drawn, borders_of)]
        if alike is None:
            alike = [abs(one[:, REACH + 3:REACH + 7].mean(axis=1) - one[:, REACH - 6:REACH - 2].mean(axis=1)) < 0.1
                     for one in tones]
        features = [cues(one, bends(order, places), scene.background)
                    for one, scene, (places, order) in zip(tones, scenes, borders_of)]
        weights = [fitted(numpy.concatenate(features[half::2])) for half in (0, 1)]
        right = [one @ weights[1 - i % 2] > 0 for i, one in enumerate(features)]
        gap = [gap_answers(one, scene.background) for one, scene in zip(tones, scenes)]
        hard = numpy.concatenate(alike)
        results[contrast] = {"gap": numpy.concatenate(gap).mean(), "learned": numpy.concatenate(right).mean(),
                             "alike": numpy.concatenate(right)[hard].mean(), "places": len(hard), "hard": hard.sum()}
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--bin", required=True)
    parser.add_argument("--scenes", type=int, default=48)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--contrasts", type=float, nargs="+", default=[0.0, 0.5, 1.0])
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--keep")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        pictures = Pictures(options.keep or folder, options.bin, options.device)
        scenes = [Scene(options.first + i) for i in range(options.scenes)]
        for contrast, found in measure(pictures, scenes, options.contrasts).items():
            print(f"contrast {contrast:4}  gap {found['gap']:.3f}  learned {found['learned']:.3f} of {found['places']}  "
                  f"alike {found['alike']:.3f} of {found['hard']}", flush=True)


if __name__ == "__main__":
    main()
