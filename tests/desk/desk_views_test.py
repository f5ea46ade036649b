# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person does with several views in a window of mote-view, as desk_test.py; docs/VIEWER.md numbers it."""
import math
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

import numpy

import hand
from desk_case import PANEL, DeskCase, data, warm

BOTTOM = 688  # the picture's, above the time bar
LEFT, RIGHT = (235, 344), (705, 344)  # the middles of two panes


def pane(picture, index, count):
    """A pane's part of a picture of the window."""
    half = PANEL // 2
    left = half + 1 if index % 2 else 0
    top, bottom = (0, BOTTOM) if count == 2 else ((0, 343), (345, BOTTOM))[index // 2]
    return picture[top + 3:bottom - 3, left + 3:left + half - 4]


@unittest.skipIf(hand.missing(), hand.missing())
class Views(DeskCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = hand.new_folder()
        runs = cls.folder / "runs"
        runs.mkdir()
        for name in ("beam", "ct"):
            shutil.copytree(data() / f"{name}.mote", runs / f"{name}.mote")
        run = cls.folder / "short.h5"
        for words in (["synth", "beam", "--particles", 5000, "--steps", 3, "--seed", 2, "--out", run],
                      ["particles", run, "--axes", "x,px,y", "--out", runs / "short.mote"],
                      ["particles", run, "--axes", "z,pz,x", "--out", runs / "along.mote"]):
            subprocess.run([hand.BIN / "mote-prep", *map(str, words)], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
        cls.server = hand.Server(cls.folder, runs)

    def views(self, count, **how):
        """The beam in so many panes."""
        viewer = self.beam("--view", self.saved("beam.json", {"layers": [{"dataset": "data/beam", "particles": {}}]}), **how)
        self.split(viewer, count)
        return viewer

    def split(self, viewer, count):
        viewer.key(f"ctrl+{count}")
        viewer.until(lambda: len(viewer.panes()) == (count if count > 1 else 0), f"{count} panes")
        self.all_show(viewer, count)

    def all_show(self, viewer, count):
        viewer.until(lambda: all(warm(pane(viewer.picture(), i, count)).sum() > 300 for i in range(count)),
                     "the beam in each")

    def panes_show(self, viewer, holds, what="those views"):
        def check():
            panes = viewer.panes()
            return panes if panes and holds(panes) else None
        return viewer.until(check, what)

    def test_71_two_views_each_with_its_camera_and_layers(self):
        viewer = self.views(2)
        same = viewer.panes()
        self.assertEqual(same[0], same[1])
        viewer.drag(RIGHT, (RIGHT[0] + 90, RIGHT[1] + 40))
        self.panes_show(viewer, lambda panes: "camera" in panes[1] and "camera" not in panes[0])
        self.assertEqual(viewer.desk()["active"], 1)
        x, y = viewer.see("layer's opacity")
        viewer.drag((x - 90, y), (x - 220, y))  # the panel is the active one's
        self.panes_show(viewer, lambda panes: panes[1]["layers"][0].get("opacity", 1) < 0.6
                        and "opacity" not in panes[0]["layers"][0])
        viewer.key("v")
        viewer.until(lambda: viewer.desk()["active"] == 0, "the first")
        viewer.key("x")
        self.panes_show(viewer, lambda panes: "camera" in panes[0])
        blue = lambda index: (lambda edge: (edge[..., 2] > 200) & (edge[..., 0] < 120))(viewer.picture()[0, 471 * index + 9]).all()
        viewer.until(lambda: blue(0) and not blue(1), "the frame around the first")

    def test_72_a_step_is_all_panes(self):
        viewer = self.views(4)
        viewer.key("Right")
        self.panes_show(viewer, lambda panes: [view["layers"][0].get("step", 0) for view in panes] == [1] * 4)
        viewer.do("Link or unlink steps")
        viewer.key("Right")
        self.panes_show(viewer, lambda panes: [view["layers"][0].get("step", 0) for view in panes] == [2, 1, 1, 1])
        viewer.do("Link or unlink steps")
        self.panes_show(viewer, lambda panes: [view["layers"][0].get("step", 0) for view in panes] == [2] * 4)

    def test_73_a_shorter_run_stays_at_its_last_step_and_says_so(self):
        viewer = self.views(2)
        viewer.click(*RIGHT)
        viewer.key("d")
        viewer.press("data/short", within=self.LIST)
        self.panes_show(viewer, lambda panes: panes[1]["layers"][0]["dataset"] == "data/short")
        viewer.click(*LEFT)
        viewer.key("End")
        self.panes_show(viewer, lambda panes: [view["layers"][0].get("step") for view in panes] == [5, 2])
        viewer.see("step 2, its last", within=(470, 600, PANEL, BOTTOM))
        viewer.key("Home")
        viewer.gone("step 2, its last")

    def panes_after_lasso(self, viewer):
        """Draws a closed line in the left view; what both views hold then, which is the same selection."""
        viewer.move(LEFT[0], LEFT[1] - 60)
        viewer.display.button(1, True)
        for angle in numpy.linspace(0, 2 * math.pi, 20):
            viewer.move(LEFT[0] + 50 * math.sin(angle), LEFT[1] - 60 * math.cos(angle))
            time.sleep(0.03)
        viewer.display.button(1, False)
        panes = self.panes_show(viewer, lambda panes: all("selections" in view for view in panes))
        self.assertEqual(panes[0]["selections"], panes[1]["selections"])
        return panes

    def test_74_a_lasso_in_one_is_highlighted_in_all(self):
        viewer = self.views(2)
        viewer.drag(RIGHT, (RIGHT[0] + 90, RIGHT[1] + 40))
        self.panes_show(viewer, lambda panes: "camera" in panes[1])
        lit = lambda index: (lambda p: ((p[..., 1] > 140) & (p[..., 1] > p[..., 0] + 60)).sum())(
            pane(viewer.picture().astype(int), index, 2)[:560])  # above the triad
        self.assertLess(max(lit(0), lit(1)), 40)
        viewer.key("l")
        viewer.see("Lasso: draw a line", within=(470, 0, PANEL, 40))
        panes = self.panes_after_lasso(viewer)
        self.assertTrue(all("highlight" in view["layers"][0] for view in panes))
        viewer.until(lambda: lit(0) > 100 and lit(1) > 100, "the selection in both")
        viewer.key("Escape")
        viewer.key("ctrl+z")  # one step
        self.panes_show(viewer, lambda panes: not any("selections" in view for view in panes))

    def test_87_a_lasso_shows_in_plots_of_other_axes(self):
        viewer = self.views(2)
        for place, name in ((LEFT, "short"), (RIGHT, "along")):
            viewer.click(*place)
            viewer.key("d")
            viewer.press(f"data/{name}", within=self.LIST)
        self.panes_show(viewer, lambda panes: [view["layers"][0]["dataset"] for view in panes] == ["data/short", "data/along"])
        viewer.click(*LEFT)
        viewer.key("l")
        viewer.see("Lasso: draw a line", within=(0, 0, 470, 40))
        panes = self.panes_after_lasso(viewer)
        self.assertEqual(panes[1]["selections"][0]["selection"]["lasso"]["axes"], ["x", "px", "y"])
        lit = lambda index: (lambda p: ((p[..., 1] > 140) & (p[..., 1] > p[..., 0] + 60)).sum())(
            pane(viewer.picture().astype(int), index, 2)[:560])
        viewer.until(lambda: lit(0) > 100 and lit(1) > 100, "the selection in both")

    def test_75_cameras_go_together_on_request(self):
        viewer = self.views(4)
        viewer.do("Link or unlink cameras")
        viewer.until(lambda: "cameras" in viewer.desk()["links"], "the link")
        viewer.drag((700, 500), (760, 520))  # the lower right one
        panes = self.panes_show(viewer, lambda panes: all("camera" in view for view in panes))
        self.assertTrue(all(view["camera"] == panes[3]["camera"] for view in panes))
        viewer.key("[")
        self.panes_show(viewer, lambda panes: not any("camera" in view for view in panes))

    def test_76_random_actions_in_panes_taken_back_leave_the_first_view(self):
        viewer = self.views(2)
        first = viewer.panes()
        chance = random.Random(11)
        for _ in range(40):
            what = chance.randrange(6)
            if what == 0:
                begin = chance.randrange(50, 850), chance.randrange(50, 500)
                viewer.drag(begin, (begin[0] + chance.randrange(-40, 40), begin[1] + 20), steps=2)
            elif what == 1:
                viewer.key(chance.choice(["ctrl+1", "ctrl+2", "ctrl+4", "v"]))
            elif what == 2:
                viewer.key(chance.choice(["Left", "Right", "x", "shift+y", "o", "r"]))
            elif what == 3:
                viewer.wheel(chance.randrange(50, 850), 300, chance.choice([-2, 2]))
            else:
                viewer.click(chance.randrange(PANEL + 10, 1250), chance.randrange(145, 700))
            viewer.key("Escape")
        for _ in range(60):
            viewer.key("ctrl+z")
        viewer.until(lambda: not viewer.panes() and viewer.desk(), "one pane")
        viewer.key("ctrl+shift+z")  # the split, which was before
        for _ in range(60):
            viewer.key("[")
        self.assertEqual(self.panes_show(viewer, lambda panes: panes == first, "the first views"), first)

    def test_77_a_killed_viewer_loses_no_pane(self):
        viewer = self.views(4)
        viewer.drag((700, 500), (760, 520))
        viewer.do("Link or unlink cameras")
        viewer.do("Link or unlink cameras")
        viewer.do("Link or unlink steps")
        self.panes_show(viewer, lambda panes: "camera" in panes[3])
        before = viewer.until(lambda: "steps" not in viewer.desk()["links"] and viewer.desk(), "the links")
        viewer.process.send_signal(signal.SIGKILL)
        viewer.process.wait()
        again = self.viewer(state=viewer.folder)
        again.press("Take it up")
        self.panes_show(again, lambda panes: len(panes) == 4)
        self.assertEqual(again.desk(), before)
        self.all_show(again, 4)

    def test_78_at_rest_four_views_take_nothing(self):
        viewer = self.views(4)
        viewer.rests(0.04)  # the pulses of four lines
        viewer.key("Right")
        self.panes_show(viewer, lambda panes: panes[3]["layers"][0].get("step") == 1)

    def test_79_a_server_that_dies_is_said_once_and_all_views_come_back(self):
        folder = hand.new_folder()
        server = hand.Server(folder, data())
        viewer = hand.Viewer(["--connect", server.connection])
        self.addCleanup(viewer.close)
        viewer.see("exact")
        self.split(viewer, 4)

        def steps(key, what):
            before = [pane(viewer.picture(), i, 4) for i in range(4)]
            viewer.key(key)
            viewer.until(lambda: all(not numpy.array_equal(pane(viewer.picture(), i, 4), before[i]) for i in range(4)), what)

        children = pathlib.Path(f"/proc/{server.process.pid}/task/{server.process.pid}/children").read_text(encoding="ascii")
        os.kill(int(children.split()[0]), signal.SIGKILL)  # the process that serves; another takes its place
        steps("End", "the last step in each")
        server.close()
        viewer.see("Connect now", within=(0, 0, PANEL, 720))
        self.assertIsNone(viewer.where("Connect now", within=(0, 0, PANEL, 720), nth=1))
        with hand.Server(folder, data()):
            at = viewer.where("Connect now", within=(0, 0, PANEL, 720))
            if at:  # else it has tried again by itself meanwhile
                viewer.click(*at)
            viewer.gone("Connect now")
            steps("Home", "the first step in each")


if __name__ == "__main__":
    unittest.main()
