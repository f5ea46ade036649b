#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A person flies, paints on a drawing and places layers in metres: docs/VIEWER.md, "What a person does"."""
import shutil
import signal
import subprocess
import time
import unittest
import unittest.mock

import numpy

import hand
from desk_case import PANEL, DeskCase, data, warm


def camera_of(view):
    return {name: numpy.array(view["camera"][name]) for name in ("eye", "target", "up")}


class DeskHand(DeskCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = hand.new_folder()
        root = cls.folder / "root"
        shutil.copytree(data(), root)
        subprocess.run([hand.BIN / "mote-prep", "mesh", root / "cube.obj", "--unit", "m", "--out", root / "block.mote"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.server = hand.Server(cls.folder, root)

    def hold(self, viewer, key, seconds=0.4):
        viewer.display.key(key, True)
        time.sleep(seconds)
        viewer.display.key(key, False)

    def test_80_a_flight_goes_ahead_and_is_one_step(self):
        path = self.saved("fly.json", {"camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]},
                                       "layers": [{"dataset": "data/beam", "particles": {}}]})
        viewer = self.beam("--view", path)
        viewer.key("shift+f")
        viewer.see("Flying", within=(0, 0, PANEL, 60))
        self.hold(viewer, "w")
        view = viewer.shows(lambda view: view["camera"]["eye"][2] < 3.8, "nearer")
        camera = camera_of(view)
        self.assertGreater(camera["eye"][2], 0.2)
        numpy.testing.assert_allclose(camera["eye"] - camera["target"], [0, 0, 4], atol=1e-9)
        numpy.testing.assert_allclose(camera["eye"][:2], 0, atol=1e-9)
        self.hold(viewer, "d")  # not the list of datasets
        view = viewer.shows(lambda view: view["camera"]["eye"][0] > 0.1, "to the right")
        self.assertIsNone(viewer.where("type to search", within=self.LIST))
        viewer.drag((400, 300), (300, 300))  # the picture goes to the left: the eye turns to the right
        view = viewer.shows(lambda view: camera_of(view)["target"][0] - camera_of(view)["eye"][0] > 0.2, "a look")
        viewer.key("Escape")
        viewer.gone("Flying", within=(0, 0, PANEL, 60))
        viewer.key("[")
        viewer.shows(lambda view: view["camera"]["eye"] == [0, 0, 4] and view["camera"]["target"] == [0, 0, 0],
                     "the camera before the flight")
        viewer.rests(0.05)

    def test_81_a_faster_flight_by_the_wheel(self):
        viewer = self.beam()
        viewer.key("shift+f")
        viewer.see("0.5 of the way", within=(0, 0, PANEL, 60))
        viewer.wheel(400, 300, 2)
        viewer.see("0.78 of the way", within=(0, 0, PANEL, 60))  # times 1.25 twice
        viewer.do("Fly")
        viewer.gone("Flying", within=(0, 0, PANEL, 60))

    def test_95_a_camera_gets_a_name_and_is_gone_back_to(self):
        panel = (PANEL, 0, 1280, 720)
        viewer = self.beam()
        viewer.key("x")
        side = viewer.shows(lambda view: "camera" in view)["camera"]
        viewer.move(1100, 600)
        viewer.wheel(1100, 600, -40)
        viewer.press("this camera's name", within=panel)
        viewer.type("from aside")
        viewer.key("Return")
        viewer.see("from aside", within=panel)
        viewer.drag((300, 300), (450, 330))
        away = viewer.shows(lambda view: view["camera"] != side)["camera"]
        viewer.press("from aside", within=panel)
        viewer.shows(lambda view: view["camera"] == side, "the side")
        viewer.key("[")  # the way there is one step
        viewer.shows(lambda view: view["camera"] == away, "where it was before")
        viewer.key("1")
        viewer.shows(lambda view: view["camera"] == side, "the side by its number")
        # It outlives the viewer, and is this dataset's.
        viewer.process.send_signal(signal.SIGKILL)
        viewer.process.wait()
        again = self.beam(state=viewer.folder)
        again.do("from aside")
        again.shows(lambda view: "camera" in view and view["camera"] == side, "the side again")
        again.wheel(1100, 600, -40)
        x, y = again.see("from aside", within=panel)
        dots = again.see("...", within=(1200, y - 12, 1280, y + 12), least=0.7)
        again.click(*dots)
        x, y = again.see("name", within=(PANEL - 200, y, 1280, 720), least=0.95)
        again.click(x - 60, y)
        again.key("ctrl+a")
        again.type("left")
        again.key("Return")
        again.gone("from aside", within=panel)
        y = again.see("left", within=(PANEL, y - 80, 1100, y + 20))[1]
        again.click(*dots)
        again.press("Remove", within=(PANEL - 200, y, 1280, 720))
        row = (PANEL, y - 60, 1100, y + 60)  # the panel may be scrolled less far then
        again.gone("left", within=row)
        again.key("ctrl+z")
        again.see("left", within=row)
        again.key("ctrl+z")
        again.see("from aside", within=row)

    def metres(self, stretch):
        """A cube of one metre, its faces a metre off the middle at most; a metre is 180 pixels across."""
        path = self.saved("metres.json", {
            "space": "metres", "stretch": stretch,
            "camera": {"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 4},
            "layers": [{"dataset": "data/block", "mesh": {}}]})
        viewer = self.viewer("--view", path)
        viewer.see("exact", within=(PANEL, 60, 1280, 110))
        return viewer

    @staticmethod
    def at(x, y, right=0, down=0):
        return round(470 + 180 * x + right), round(360 - 180 * y + down)

    def test_82_layers_in_metres_have_handles(self):
        viewer = self.metres([2, 1, 1])  # the cube's middle, 0.5 m, is seen at 1
        moved = lambda view: numpy.reshape(view["layers"][0]["transform"], (4, 4))
        viewer.key("g")
        viewer.drag(self.at(1, 0.5, right=90), self.at(1.5, 0.5, right=90))
        view = viewer.shows(lambda view: abs(view["layers"][0].get("transform", [0] * 16)[3] - 0.25) < 0.01)
        numpy.testing.assert_allclose(moved(view)[:, :3], numpy.eye(4)[:, :3], atol=1e-12)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "transform" not in view["layers"][0])
        # A quarter of a turn about z through its middle, in metres: right angles stay right ones.
        viewer.drag(self.at(1, 0.5, 62 * 0.7071, -31 * 0.7071), self.at(1, 0.5, -62 * 0.7071, -31 * 0.7071))
        view = viewer.shows(lambda view: "transform" in view["layers"][0])
        numpy.testing.assert_allclose(moved(view), [[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=0.06)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "transform" not in view["layers"][0])
        viewer.key("g")
        viewer.key("c")
        x, y = self.at(2, 0.5)
        viewer.until(lambda: viewer.picture()[y, x, 0] > 200 > 2 * viewer.picture()[y, x, 1] - 60, "the face's handle")
        viewer.drag(self.at(2, 0.5), self.at(1, 0.5), steps=12)
        box = viewer.shows(lambda view: "clip" in view["layers"][0])["layers"][0]["clip"]["box"]
        numpy.testing.assert_allclose(box["max"], [0.5, 1, 1], atol=0.02)

    def drawing(self):
        path = self.saved("drawing.json", {
            "camera": {"eye": [0.5, 0.5, 9], "target": [0.5, 0.5, 0], "up": [0, 1, 0], "orthographicHeight": 2},
            "layers": [{"dataset": "data/magnet", "ink": {"hatch": {"strength": 0}}}]})
        viewer = self.viewer("--view", path)
        viewer.see("exact", within=(PANEL, 60, 1280, 110))
        return viewer

    def test_83_a_brush_paints_a_drawing(self):
        viewer = self.drawing()
        paper = viewer.picture()[340:380, 420:520].mean()
        viewer.key("b")
        viewer.see("a drag paints", within=(0, 0, PANEL, 60))
        viewer.drag((380, 360), (560, 360), steps=12)
        regions = lambda view: view["layers"][0]["ink"].get("regions", [])
        view = viewer.shows(lambda view: regions(view) and len(regions(view)[0]["dabs"]) >= 30, "dabs")
        self.assertEqual(len(regions(view)), 1)
        region = regions(view)[0]
        dabs = numpy.reshape(region["dabs"], (-1, 3))
        numpy.testing.assert_allclose(dabs[:, 1:], [[0.5, 1]] * len(dabs), atol=0.01)  # the face that is seen
        self.assertLess(dabs[:, 0].min(), 0.3)
        self.assertGreater(dabs[:, 0].max(), 0.7)
        self.assertAlmostEqual(region["radius"], 24 / 360, delta=0.002)
        self.assertEqual(region["fill"], "ink")
        ink = lambda: viewer.picture()[350:370, 400:540].mean()
        viewer.move(200, 600)
        viewer.until(lambda: ink() < 0.3 * paper, "ink")
        viewer.see("dabs", within=(PANEL, 0, 1280, 720), least=0.9)
        viewer.key("ctrl+z")  # one stroke
        viewer.shows(lambda view: not regions(view))
        viewer.until(lambda: ink() > 0.8 * paper, "paper")
        viewer.key("ctrl+shift+z")
        viewer.shows(regions)
        viewer.press("erase", within=(PANEL, 0, 1280, 720), least=0.95)
        viewer.drag((380, 360), (470, 360), steps=12)
        view = viewer.shows(lambda view: 0 < len(regions(view)[0]["dabs"]) < len(region["dabs"]), "fewer dabs")
        viewer.until(lambda: numpy.reshape(regions(viewer.view())[0]["dabs"], (-1, 3))[:, 0].min() > 0.5, "the left gone")
        viewer.press("Remove", within=(PANEL, 0, 1280, 720), nth=1)
        viewer.shows(lambda view: not regions(view))

    def test_84_brushes_have_sizes(self):
        viewer = self.drawing()
        viewer.key("b")
        viewer.see("a drag paints", within=(0, 0, PANEL, 60))
        viewer.key("]")
        viewer.wheel(470, 360, 1)
        viewer.click(470, 360)
        regions = lambda view: view["layers"][0]["ink"].get("regions", [])
        view = viewer.shows(lambda view: regions(view), "a dab")
        self.assertAlmostEqual(regions(view)[0]["radius"], 24 * 1.15 ** 2 / 360, delta=0.003)
        viewer.click(30, 30)  # beside all of it
        viewer.key("Escape")
        viewer.gone("a drag paints", within=(0, 0, PANEL, 60))
        self.assertEqual(len(regions(viewer.view())[0]["dabs"]), 3)

    def test_85_how_far_a_file_is_prepared_is_said(self):
        folder = hand.new_folder()
        go = folder / "go"
        for program in ("mote-view", "mote-server"):
            shutil.copy(hand.BIN / program, folder / program)
        slow = folder / "mote-prep"  # that waits for us in between
        slow.write_text("#!/bin/sh\n"
                        """echo '{"progress": 0.37, "phase": "sorting step 1"}' >&3\n"""
                        f"while [ ! -e {go} ]; do sleep 0.05; done\n"
                        f'exec {(hand.BIN / "mote-prep").resolve()} "$@"\n')
        slow.chmod(0o755)
        with unittest.mock.patch("hand.BIN", folder):
            viewer = hand.Viewer([data() / "run.h5"])
        self.addCleanup(viewer.close)
        viewer.see("37%  sorting step 1", least=0.7)
        go.touch()
        viewer.until(lambda: warm(viewer.picture()[:, :PANEL]).sum() > 2000, "the beam")


if __name__ == "__main__":
    unittest.main()
