#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pictures of docs/VIEWER.md, but for the first, by a hand in a real window of a virtual display.

    MOTE_BIN=build/release/bin pictures.py OUT [NAME...]    names: layers, cut, brush, datasets, keys, views, cameras, time, clear, jobs, densities, saver,
                                                    files
"""
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import numpy
from PIL import Image

import hand
from desk_case import PANEL, data
from desk_made_test import descendant

PLOTS = {"beam": "x,px,y", "beam-xyz": "x,y,z", "beam-long": "z,pz,x", "beam-y": "y,py,x"}
LIST = (0, 80, PANEL, 720)
NAMES = ("layers", "cut", "brush", "datasets", "keys", "views", "cameras", "time", "clear", "jobs", "densities", "saver",
         "files")
STEP = 2


def prepare(folder):
    """Plots of a beam of 300,000 particles, a ball as a volume, a cube."""
    root = folder / "root"
    root.mkdir()
    for name in ("ct.mote", "magnet.mote"):
        shutil.copytree(data() / name, root / name)
    prep = lambda *arguments: subprocess.run([hand.BIN / "mote-prep", *map(str, arguments)], check=True,
                                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    prep("synth", "beam", "--particles", 300_000, "--steps", 6, "--seed", 1, "--out", root / "run.h5")
    for name, axes in PLOTS.items():
        prep("particles", root / "run.h5", "--axes", axes, "--out", root / f"{name}.mote")
    return root


class Pictures:

    def __init__(self, folder, server, out):
        self.folder, self.connection, self.out = folder, server.connection, out
        self.server = server.process.pid

    def viewer(self, view, exact=True):
        path = self.folder / "view.json"
        path.write_text(json.dumps(view), encoding="utf-8")
        viewer = hand.Viewer(["--connect", self.connection, "--view", path])
        if exact:
            viewer.see("exact", within=(PANEL, 60, 1280, 110))
        return viewer

    def keep(self, viewer, name):
        time.sleep(4.0)  # numbers of the line fall to rest
        Image.fromarray(viewer.picture()).save(self.out / f"viewer-{name}.png")
        viewer.close()

    @staticmethod
    def beam(*more, **annotations):
        return {"annotations": {"axes": True, **annotations},
                "layers": [{"dataset": "data/beam", "step": STEP, "particles": {}}, *more]}

    def layers(self):
        plot = {"dataset": "data/beam-xyz", "step": STEP, "particles": {"volume": {"colorMap": "viridis"}}}
        self.keep(self.viewer(self.beam(plot, {"dataset": "data/quadrupole", "mesh": {}})), "layers")

    def cut(self):
        viewer = self.viewer({
            "camera": {"eye": [-22, 32, 62], "target": [12, 12, 11], "up": [0, 1, 0], "fovYDegrees": 35},
            "layers": [{"dataset": "data/ct", "hybrid": {}, "clip": {
                "box": {"min": [0, 0, 0], "max": [24, 24, 15]}, "planes": [{"normal": [-0.4, 0, -1], "distance": -16.7}]}}]})
        viewer.key("c")
        viewer.move(1100, 500)
        viewer.wheel(1100, 600, -8)
        self.keep(viewer, "cut")

    def brush(self):
        viewer = self.viewer({"camera": {"eye": [3, 2, 5], "target": [0.5, 0.5, 0.5], "up": [0, 1, 0]},
                              "layers": [{"dataset": "data/magnet", "ink": {}}]})
        viewer.key("b")
        viewer.see("a drag paints", within=(0, 0, PANEL, 60))
        viewer.drag((420, 350), (500, 380), steps=12)
        viewer.see("dabs", within=(PANEL, 0, 1280, 720), least=0.9)
        self.keep(viewer, "brush")

    def datasets(self):
        viewer = self.viewer(self.beam())
        viewer.key("d")
        viewer.see(f"{len(PLOTS) + 2} of {len(PLOTS) + 2}", within=LIST)
        for _ in range(4):
            viewer.key("Down")
        self.keep(viewer, "datasets")

    def files(self):
        viewer = self.viewer(self.beam())
        viewer.key("shift+d")
        viewer.see("run.h5", within=LIST)
        viewer.type("run")
        viewer.key("Return")
        viewer.see("Prepare (")
        self.keep(viewer, "files")

    def keys(self):
        viewer = self.viewer(self.beam())
        viewer.key("?")
        viewer.see("Look from +x")
        self.keep(viewer, "keys")

    def cameras(self):
        viewer = self.viewer(self.beam())
        viewer.wheel(1100, 600, -40)
        for key, name in (("x", "along x"), ("y", "from above"), ("z", "")):
            viewer.key(key)
            if name:
                viewer.press("this camera's name", within=(PANEL, 0, 1280, 720))
                viewer.type(name)
                viewer.key("Return")
                viewer.see(name, within=(PANEL, 0, 1280, 720))
        y = viewer.see("from above", within=(PANEL, 0, 1280, 720))[1]
        viewer.click(*viewer.see("...", within=(1200, y - 12, 1280, y + 12), least=0.7))
        viewer.see("Replace by what is seen now")
        self.keep(viewer, "cameras")

    def time(self):
        viewer = self.viewer(self.beam())
        viewer.press("step", within=(820, 690, PANEL, 720))
        viewer.press("time", within=(820, 560, PANEL, 700))
        for key in ("Right", "Right", "Left"):  # two more are loaded
            viewer.key(key)
            viewer.see("exact", within=(PANEL, 60, 1280, 110))
            time.sleep(1.0)
        viewer.move(430, 705)
        self.keep(viewer, "time")

    def jobs(self):
        viewer = self.viewer(self.beam())
        for axis in ("t", "z"):
            y = viewer.see("Plot", within=(1190, 180, 1280, 400), least=0.9)[1]
            viewer.click(1186, y)
            viewer.wheel(1150, y + 60, 10)
            viewer.press(axis, within=(1120, y + 8, 1200, 700), least=0.9)
            viewer.press("Plot", within=(1190, 180, 1280, 400), least=0.9)
            if axis == "t":
                viewer.see("is made.")
                viewer.press("Put away")
        job = viewer.until(lambda: descendant(self.server, "mote-prep"), "the job")
        os.kill(job, signal.SIGSTOP)
        viewer.press("Jobs:", within=(PANEL, 680, 1280, 720))
        viewer.move(600, 600)
        self.keep(viewer, "jobs")
        os.kill(job, signal.SIGCONT)

    def densities(self):
        viewer = self.viewer(self.beam())
        viewer.wheel(1100, 600, -6)
        viewer.key("t")
        viewer.drag((560, 300), (640, 360))
        viewer.see("particles in it", within=(0, 0, PANEL, 60))
        self.keep(viewer, "densities")

    def saver(self):
        viewer = self.viewer(self.beam())
        viewer.press("data saver", within=(PANEL, 85, 1280, 115))
        viewer.drag((300, 300), (420, 330), steps=20)
        self.keep(viewer, "saver")

    def clear(self):
        viewer = self.viewer(self.beam())
        viewer.key("ctrl+p")
        viewer.press("as it is shown")
        viewer.press("without its background")
        viewer.press("Save", within=(380, 270, 640, 340), least=0.9)
        made = viewer.folder / "picture.png"
        viewer.until(made.exists, "the picture")
        with Image.open(made) as picture:
            both = Image.new("RGBA", (2 * picture.width, picture.height))
            for i, color in enumerate(((255, 255, 255, 255), (40, 90, 130, 255))):
                on = Image.new("RGBA", picture.size, color)
                on.alpha_composite(picture)
                both.paste(on, (i * picture.width, 0))
        both.convert("RGB").resize((both.width // 2, both.height // 2), Image.LANCZOS).save(self.out / "viewer-clear.png")
        viewer.close()

    def views(self):
        viewer = self.viewer(self.beam(colorBar=True))
        viewer.key("ctrl+4")
        middles = ((235, 172), (705, 172), (235, 516), (705, 516))
        for (x, y), name, key in list(zip(middles, PLOTS, ("", "z", "x", "y")))[1:]:
            viewer.click(x, y)
            viewer.key("d")
            viewer.press(f"data/{name}", within=LIST, least=0.95)
            viewer.until(lambda name=name: viewer.desk() and viewer.desk()["subject"] == f"data/{name}", name)
            viewer.key(key)
        viewer.click(*middles[0])
        viewer.key("l")
        viewer.see("Lasso: draw a line", within=(0, 0, 470, 40))
        x, y = middles[0][0] + 15, middles[0][1] - 15
        viewer.move(x, y - 35)
        viewer.display.button(1, True)
        for angle in numpy.linspace(0, 2 * math.pi, 24):
            viewer.move(x + 30 * math.sin(angle), y - 35 * math.cos(angle))
            time.sleep(0.03)
        viewer.display.button(1, False)
        viewer.until(lambda: all("selections" in view for view in viewer.panes()), "the selection in all")
        viewer.key("Escape")
        self.keep(viewer, "views")


def main(out, *names):
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    folder = hand.new_folder()
    root = prepare(folder)
    with hand.Server(folder, root) as server:
        pictures = Pictures(folder, server, out)
        for name in names or NAMES:
            getattr(pictures, name)()
            print(out / f"viewer-{name}.png", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
