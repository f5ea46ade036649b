#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A person prepares files of the server, and sees what of a run is loaded: docs/VIEWER.md, "What a person does"."""
import json
import shutil
import time
import unittest

import hand
from desk_case import PANEL, DeskCase, data

PAGE = (0, 70, PANEL, 650)  # the browser
FILES, CONTENT = (0, 110, 445, 650), (445, 110, PANEL, 650)
DRAWER = (PANEL, 680, 1280, 720)


class DeskFiles(DeskCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = hand.new_folder()
        cls.root = cls.folder / "root"
        shutil.copytree(data(), cls.root)
        runs = cls.root / "runs" / "2026"
        runs.mkdir(parents=True)
        shutil.copy(cls.root / "run.h5", runs / "shot.h5")
        (runs / "noise.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(256)) * 8)
        (cls.root / "turns").mkdir()
        for turn in range(1, 4):
            rows = "".join(f"{x * 1e-4},{turn * x * 10},{(x * x % 7) * 1e-4}\n" for x in range(-500, 500))
            (cls.root / "turns" / f"turn_{turn}.csv").write_text("x [m],px [eV/c],y [m]\n" + rows, encoding="ascii")
        (cls.root / "Μετρήσεις").mkdir()
        (cls.root / "many").mkdir()
        for number in range(10_000):
            (cls.root / "many" / f"scan_{number}.h5").touch()
        cls.server = hand.Server(cls.folder, cls.root)

    def manifest(self, name):
        return json.loads((self.root / f"{name}.mote" / "manifest.json").read_text(encoding="utf-8"))

    def test_104_a_file_is_found_looked_at_and_prepared_by_keys(self):
        viewer = self.beam()
        viewer.key("shift+d")
        viewer.see("Enter opens", within=PAGE)
        viewer.see("Μετρήσεις", within=FILES)
        viewer.type("2026")  # there is none here
        viewer.see("0 of", within=PAGE)
        for _ in "2026":
            viewer.key("BackSpace")
        viewer.type("runs")
        viewer.key("Return")
        for end in ("BackSpace", None):  # up, and down again
            viewer.see("2026/", within=FILES)
            viewer.type("20")
            viewer.key("Return")
            viewer.see("shot.h5", within=FILES)
            if end:
                viewer.key(end)
        viewer.type("sh")
        viewer.key("Return")
        viewer.see("proton", within=CONTENT)
        viewer.see("20000 in a step", within=CONTENT)
        viewer.see("eV/c", within=CONTENT, least=0.75)
        viewer.key("ctrl+Return")
        viewer.see("data/runs/2026/shot is made", within=(0, 550, PANEL, 720))
        self.assertEqual(self.manifest("runs/2026/shot")["request"]["particles"]["axes"], ["x", "px", "y"])
        viewer.press("Open it", within=(0, 550, PANEL, 720))
        viewer.until(lambda: viewer.desk() and viewer.desk()["subject"] == "data/runs/2026/shot", "the plot")

    def test_105_a_file_is_prepared_by_the_mouse_with_options(self):
        viewer = self.beam()
        viewer.key("d")
        viewer.press("Prepare a file...", within=(0, 70, PANEL, 140))
        viewer.press("runs/", within=FILES)
        viewer.press("2026/", within=FILES)
        viewer.press("shot.h5", within=FILES)
        viewer.see("proton", within=CONTENT)
        x, y = viewer.see("axes", within=(700, 400, PANEL, 650))
        viewer.click(x - 50, y)  # the last of three lists
        viewer.press("z", within=(560, y, 740, 720), least=0.9)
        x, y = viewer.see("dataset", within=(700, 450, PANEL, 650))
        viewer.click(x - 200, y)
        viewer.key("ctrl+a")
        viewer.type("data/long")
        x, y = viewer.see("title", within=(700, 450, PANEL, 650))
        viewer.click(x - 200, y)
        viewer.type("A shot")
        viewer.press("Prepare (", within=CONTENT)
        viewer.see("data/long", within=DRAWER)
        viewer.see("data/long is made", within=(0, 550, PANEL, 720))
        manifest = self.manifest("long")
        self.assertEqual(manifest["title"], "A shot")
        self.assertEqual(manifest["request"]["particles"]["axes"], ["x", "px", "z"])
        viewer.key("d")
        viewer.see("A shot", within=self.LIST)
        # Next time it goes on where it was; the row above leads out, a dataset is opened.
        viewer.press("Prepare a file...", within=(0, 70, PANEL, 140))
        viewer.press("server", within=(0, 110, 300, 135))
        viewer.press("data/", within=FILES)
        viewer.press("magnet.mote", within=FILES)
        viewer.until(lambda: viewer.desk() and viewer.desk()["subject"] == "data/magnet", "the surface")

    def test_106_what_cannot_be_prepared_is_said(self):
        viewer = self.beam()
        viewer.key("shift+d")
        viewer.press("runs/", within=FILES)
        viewer.press("2026/", within=FILES)
        viewer.press("noise.h5", within=FILES)
        viewer.see("damaged or cut short", within=CONTENT, least=0.7)
        self.assertIsNone(viewer.where("Prepare (", within=CONTENT))
        gone = self.root / "runs" / "2026" / "gone.h5"
        gone.touch()
        viewer.press("/ runs", within=(0, 110, 445, 135))
        viewer.press("2026/", within=FILES)
        viewer.see("gone.h5", within=FILES)
        gone.unlink()
        viewer.press("gone.h5", within=FILES)
        viewer.see("cannot be found beneath its root", within=CONTENT)
        # What is typed wrong is said at the button.
        viewer.press("shot.h5", within=FILES)
        viewer.see("proton", within=CONTENT)
        x, y = viewer.see("dataset", within=(700, 450, PANEL, 650))
        viewer.click(x - 200, y)
        viewer.key("ctrl+a")
        viewer.type("nowhere")
        viewer.press("Prepare (", within=CONTENT)
        viewer.see("is ROOT/NAME", within=CONTENT)

    def test_107_ten_thousand_files_stay_smooth(self):
        viewer = self.beam()
        viewer.key("shift+d")
        viewer.press("many/", within=FILES)
        viewer.see("10000 of 10000", within=PAGE)
        viewer.type("9 77")
        viewer.see("of 10000", within=PAGE)
        viewer.see("scan_779.h5", within=FILES)
        begun, before = time.monotonic(), viewer.processor()
        for _ in range(40):
            viewer.key("Down")
        self.assertLess(viewer.processor() - before, 0.9 * (time.monotonic() - begun))  # it is not busy all the time
        viewer.key("Escape")
        viewer.gone("of 10000", within=PAGE)
        viewer.rests(0.05)

    def test_108_a_viewer_alone_lists_its_own_folder(self):
        viewer = hand.Viewer([self.root])
        self.addCleanup(viewer.close)
        viewer.see("exact", within=(PANEL, 60, 1280, 110))
        viewer.key("shift+d")
        viewer.press("cube.obj", within=FILES)
        viewer.see("12 triangles", within=CONTENT)
        viewer.see("becomes", within=CONTENT)

    def test_110_several_files_are_one_run(self):
        viewer = self.beam()
        viewer.key("shift+d")
        viewer.press("turns/", within=FILES)
        viewer.see("turn_3.csv", within=FILES)
        viewer.type("turn")
        viewer.press("(these 3 files", within=FILES)
        viewer.see("the first of 3 files", within=CONTENT)
        viewer.see("particles", within=CONTENT)
        viewer.key("ctrl+Return")
        viewer.see("data/turns/turn is made", within=(0, 550, PANEL, 720))
        manifest = self.manifest("turns/turn")
        self.assertEqual(len(manifest["particles"]["steps"]), 3)

    def test_111_a_server_without_datasets_offers_its_files(self):
        folder = hand.new_folder()
        (folder / "raw").mkdir()
        shutil.copy(data() / "cube.obj", folder / "raw")
        server = hand.Server(folder, folder / "raw")
        self.addCleanup(server.close)
        viewer = hand.Viewer(["--connect", server.connection])
        self.addCleanup(viewer.close)
        viewer.see("the server has no datasets yet")
        viewer.press("Prepare a file...", within=(400, 550, PANEL, 720))
        viewer.press("cube.obj", within=FILES)
        viewer.see("12 triangles", within=CONTENT)
        viewer.key("ctrl+Return")
        viewer.see("data/cube is made", within=(400, 500, PANEL, 720))
        viewer.press("Open it", within=(400, 500, PANEL, 720))
        viewer.see("data/cube", within=(PANEL, 130, 1160, 170))
        viewer.see("exact", within=(PANEL, 60, 1280, 110))

    def test_109_the_time_bar_shows_what_is_loaded(self):
        viewer = self.beam()
        track = slice(713, 720), slice(306, 600)

        def green():
            """Columns of the track in which the line is."""
            r, g, b = (viewer.picture()[track].astype(int)[..., i] for i in range(3))
            return ((g > r + 40) & (g > b + 20)).any(0).sum()
        one = viewer.until(green, "the first step")
        self.assertLess(one, 100)
        for step in range(1, 6):
            viewer.key("Right")
            viewer.shows(lambda view, step=step: view["layers"][0].get("step") == step, f"step {step}")
            viewer.see("exact", within=(PANEL, 60, 1280, 110))
        viewer.until(lambda: green() > 250, "all steps")
        viewer.move(365, 705)
        viewer.see("in the server's memory", within=(200, 560, PANEL, 720))
        viewer.move(300, 300)
        viewer.rests(0.05)


if __name__ == "__main__":
    unittest.main()
