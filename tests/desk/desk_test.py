# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person does in mote-view, by mouse and keyboard in a real window; docs/VIEWER.md numbers it."""
import json
import math
import os
import pathlib
import random
import signal
import subprocess
import time
import unittest

import numpy

import hand
from desk_case import PANEL, DeskCase, data, warm


class Desk(DeskCase):


    # Nothing is final.

    def test_01_an_edit_is_taken_back_and_made_again(self):
        viewer = self.beam()
        viewer.press("Duplicate")
        viewer.shows(lambda view: len(view["layers"]) == 2)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: len(view["layers"]) == 1)
        viewer.key("ctrl+shift+z")
        viewer.shows(lambda view: len(view["layers"]) == 2)
        viewer.press("Undo")
        viewer.shows(lambda view: len(view["layers"]) == 1)

    def test_02_a_drag_is_one_step(self):
        viewer = self.beam()
        x, y = viewer.see("layer's opacity")
        viewer.drag((x - 90, y), (x - 220, y), steps=12)
        viewer.shows(lambda view: 0 < view["layers"][0].get("opacity", 1) < 0.6)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "opacity" not in view["layers"][0])

    def test_03_the_camera_goes_back_by_itself(self):
        viewer = self.beam()
        viewer.press("Duplicate")
        viewer.drag((300, 300), (450, 330))
        viewer.shows(lambda view: "camera" in view)
        viewer.key("[")
        viewer.shows(lambda view: "camera" not in view and len(view["layers"]) == 2)
        viewer.key("]")
        there = viewer.shows(lambda view: "camera" in view)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: len(view["layers"]) == 1 and view["camera"] == there["camera"])

    def test_04_random_actions_taken_back_leave_the_first_view(self):
        viewer = self.beam()
        chance = random.Random(7)
        viewer.press("Duplicate")
        first = viewer.shows(lambda view: len(view.get("layers", ())) == 2)
        begun = 0
        for _ in range(60):
            what = chance.randrange(5)
            if what == 0:
                begin = chance.randrange(100, 800), chance.randrange(100, 600)
                viewer.drag(begin, (begin[0] + chance.randrange(-90, 90), begin[1] + 20), steps=2)
            elif what == 1:
                viewer.key(chance.choice(["Left", "Right", "x", "shift+y", "o", "r"]))
            elif what == 2:
                viewer.wheel(400, 300, chance.choice([-2, 2]))
            else:
                viewer.click(chance.randrange(PANEL + 10, 1250), chance.randrange(145, 700))
            viewer.key("Escape")
            begun += 1
        self.assertEqual(begun, 60)
        for _ in range(80):
            viewer.key("ctrl+z")
        for _ in range(80):
            viewer.key("[")
        viewer.key("ctrl+shift+z")  # of the first step, which was before
        last = viewer.shows(lambda view: view == first, "the first view")
        self.assertEqual(last, first)

    # Nothing is lost.

    def test_05_another_dataset_and_back_changes_nothing(self):
        viewer = self.beam()
        x, y = viewer.see("layer's opacity")
        viewer.click(x - 150, y)
        viewer.key("Right")
        viewer.drag((300, 300), (450, 330))
        before = viewer.shows(lambda view: "camera" in view and view["layers"][0].get("step") == 1)
        viewer.press("data/beam", within=(PANEL, 130, 1160, 170))
        viewer.press("data/ct", within=self.LIST)
        viewer.until(lambda: viewer.desk()["subject"] == "data/ct", "the volume")
        self.assertEqual(viewer.desk()["views"]["data/beam"], before)
        viewer.press("data/ct", within=(PANEL, 130, 1160, 170))
        viewer.press("data/beam", within=self.LIST)
        viewer.until(lambda: viewer.desk()["subject"] == "data/beam", "the beam again")
        self.assertEqual(viewer.view(), before)

    def test_06_a_killed_viewer_loses_nothing(self):
        viewer = self.beam()
        viewer.press("Duplicate")
        viewer.drag((300, 300), (450, 330))
        before = viewer.shows(lambda view: "camera" in view and len(view["layers"]) == 2)
        viewer.process.send_signal(signal.SIGKILL)
        viewer.process.wait()
        again = self.viewer(state=viewer.folder)
        again.press("Take it up")
        again.shows(lambda view: view == before)

    def test_07_save_asks_where_and_overwrites_nothing_unasked(self):
        viewer = self.beam()
        viewer.press("Duplicate")
        viewer.key("ctrl+s")
        viewer.see("Save view")
        viewer.key("ctrl+a")
        viewer.type("kept.json")
        viewer.key("Return")
        kept = viewer.folder / "kept.json"
        viewer.until(kept.exists, "the file")
        first = kept.read_bytes()
        self.assertEqual(len(json.loads(first)["layers"]), 2)
        viewer.gone("Cancel")
        viewer.press("Duplicate")
        viewer.key("ctrl+s")
        viewer.see("Cancel")
        viewer.key("Return")
        viewer.see("is there already")
        self.assertEqual(kept.read_bytes(), first)
        viewer.key("Return")
        viewer.until(lambda: kept.read_bytes() != first, "the other view")

    def test_08_a_view_is_opened_in_the_window(self):
        viewer = self.beam()
        path = self.saved("opened.json", {"layers": [{"dataset": "data/beam", "step": 3, "particles": {}}]})
        viewer.key("ctrl+o")
        viewer.see("Cancel")
        viewer.key("ctrl+a")
        viewer.type(str(path))
        viewer.key("Return")
        viewer.shows(lambda view: view["layers"][0].get("step") == 3)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: view["layers"][0].get("step", 0) == 0)

    def test_09_closing_with_unsaved_work_asks_once(self):
        viewer = self.beam()
        viewer.press("Duplicate")
        viewer.shows(lambda view: len(view.get("layers", ())) == 2)
        viewer.ask_to_close()
        viewer.see("Changed since it was opened or saved")
        viewer.press("Stay")
        viewer.gone("Changed since it was opened or saved")
        viewer.ask_to_close()
        viewer.see("Changed since it was opened or saved")
        viewer.press("Close")
        self.assertEqual(viewer.process.wait(60), 0)

    def test_10_closing_without_work_asks_nothing(self):
        viewer = self.beam()
        viewer.drag((300, 300), (450, 330))
        viewer.key("Right")
        viewer.shows(lambda view: view["layers"][0].get("step") == 1)
        viewer.ask_to_close()
        self.assertEqual(viewer.process.wait(60), 0)

    def test_11_a_finished_plot_is_a_note(self):
        viewer = self.beam()
        y = viewer.see("Plot", within=(1190, 180, 1280, 400))[1]
        viewer.click(1186, y)
        viewer.press("z", within=(1120, y, 1200, 700), least=0.95)
        viewer.press("Plot", within=(1190, 180, 1280, 400))
        viewer.see("is made.")
        viewer.see("data/beam", within=(PANEL, 130, 1160, 170))
        viewer.press("Open it", within=(500, 500, PANEL, 720))
        viewer.until(lambda: viewer.desk() and viewer.desk()["subject"] == "data/beam-x-px-z", "the plot")

    def test_12_a_step_that_is_not_there_is_said_on_the_picture(self):
        path = self.saved("late.json", {"layers": [{"dataset": "data/beam", "step": 99, "particles": {}}]})
        viewer = self.viewer("--view", path)
        viewer.see("there is no step 99", within=(0, 0, PANEL, 720))
        viewer.press("Show step 5", within=(0, 0, PANEL, 720))
        viewer.shows(lambda view: view["layers"][0]["step"] == 5)
        viewer.gone("there is no step 99")

    def test_13_a_dataset_that_is_not_there_is_a_row_that_can_be_removed(self):
        path = self.saved("lost.json", {"layers": [{"dataset": "data/gone", "mesh": {}},
                                                   {"dataset": "data/beam", "particles": {}}]})
        viewer = self.viewer("--view", path)
        viewer.see("There is no dataset data/gone", within=(0, 0, PANEL, 720))
        viewer.see("data/gone (missing)", within=(PANEL, 0, 1280, 720))
        viewer.until(lambda: warm(viewer.picture()[:, :PANEL]).sum() > 2000, "the beam meanwhile")
        viewer.press("Remove its layer", within=(0, 0, PANEL, 720))
        viewer.shows(lambda view: [layer["dataset"] for layer in view["layers"]] == ["data/beam"])
        viewer.until(lambda: warm(viewer.picture()[:, :PANEL]).sum() > 2000, "the beam")

    def test_14_or_replaced(self):
        path = self.saved("lost2.json", {"layers": [{"dataset": "data/gone", "particles": {"volume": {"colorMap": "viridis"}}}]})
        viewer = self.viewer("--view", path)
        viewer.see("data/gone (missing)", within=(PANEL, 0, 1280, 720))
        viewer.press("Replace...")
        viewer.press("data/beam", within=self.LIST)
        viewer.shows(lambda view: view["layers"][0]["dataset"] == "data/beam"
                     and view["layers"][0]["particles"]["volume"]["colorMap"] == "viridis")

    # The first picture.

    def test_20_the_first_picture_fills_the_window(self):
        viewer = self.beam()
        viewer.see("exact")
        columns = numpy.nonzero(warm(viewer.picture()[:, :860]).any(0))[0]
        self.assertGreater(columns.max() - columns.min(), 0.5 * 860)
        picture = viewer.picture()[:, :PANEL].astype(int)
        white = (picture.min(2) > 200).sum()
        self.assertGreater(white, 600)  # axes, their numbers, the colour bar's

    def test_21_the_hand_begins_where_the_server_fitted(self):
        viewer = self.beam()
        width = lambda: (lambda c: c.max() - c.min())(numpy.nonzero(warm(viewer.picture()[:, :860]).any(0))[0])
        before = width()
        viewer.drag((450, 650), (452, 650))
        viewer.shows(lambda view: "camera" in view)
        viewer.until(lambda: abs(width() - before) < 25, f"a width of {before}")

    def test_22_fit_keeps_the_direction_and_twice_resets(self):
        viewer = self.beam()
        viewer.key("x")
        side = viewer.shows(lambda view: "camera" in view)["camera"]
        viewer.wheel(470, 360, -6)
        viewer.shows(lambda view: view["camera"]["eye"][0] > 1.2 * side["eye"][0])
        viewer.key("f")
        away = lambda camera: numpy.linalg.norm(numpy.subtract(camera["eye"], camera["target"]))
        fitted = viewer.shows(lambda view: abs(away(view["camera"]) - away(side)) < 1e-6, "a fit")
        way = numpy.subtract(fitted["camera"]["eye"], fitted["camera"]["target"])
        self.assertLess(abs(way[1]) + abs(way[2]), 1e-6 * abs(way[0]))
        viewer.key("f")
        viewer.shows(lambda view: "camera" not in view)

    # The hand.

    def test_23_five_taps_are_five_steps_in_a_large_window(self):
        viewer = self.beam(size=(3840, 2160))
        for _ in range(5):
            viewer.key("Right")
        viewer.shows(lambda view: view["layers"][0].get("step") == 5)
        for _ in range(5):
            viewer.key("ctrl+z")
        viewer.shows(lambda view: view["layers"][0].get("step", 0) == 0)

    def test_24_a_letter_with_ctrl_is_not_the_letter(self):
        viewer = self.beam()
        viewer.drag((300, 300), (450, 330))
        before = viewer.shows(lambda view: "camera" in view)
        for letter in "flphno":
            viewer.key("ctrl+" + letter)
            viewer.key("Escape")
        viewer.key("Right")
        after = viewer.shows(lambda view: view["layers"][0].get("step") == 1)
        self.assertEqual(after["camera"], before["camera"])
        self.assertIsNone(viewer.where("Lasso: draw a line"))

    def seen_at(self, camera, place):
        """Parts of a height from the picture's middle, y up."""
        eye, target, up = (numpy.array(camera[name], float) for name in ("eye", "target", "up"))
        ahead = (target - eye) / numpy.linalg.norm(target - eye)
        right = numpy.cross(ahead, up)
        right /= numpy.linalg.norm(right)
        way = numpy.subtract(place, eye)
        depth = way @ ahead
        height = 2 * depth * math.tan(math.radians(camera["fovYDegrees"]) / 2)
        return numpy.array([way @ right, way @ numpy.cross(right, ahead)]) / height

    def test_25_a_drag_turns_about_what_is_under_the_pointer(self):
        viewer = self.beam()
        viewer.drag((470, 600), (471, 600), button=3)  # says the camera
        one = viewer.shows(lambda view: "camera" in view)["camera"]
        viewer.drag((640, 300), (700, 300))
        other = viewer.shows(lambda view: view["camera"] != one)["camera"]
        self.assertNotAlmostEqual(one["target"][0], other["target"][0], 3)
        # One place is where it was before, and that is under the pointer.
        at = numpy.array([(640 - 470) / 688, (344 - 300) / 688])  # the picture is above the time bar
        eye, target = numpy.array(one["eye"]), numpy.array(one["target"])
        ahead = (target - eye) / numpy.linalg.norm(target - eye)
        right = numpy.cross(ahead, one["up"])
        right /= numpy.linalg.norm(right)
        height = 2 * math.tan(math.radians(one["fovYDegrees"]) / 2)
        along = ahead + height * (at[0] * right + at[1] * numpy.cross(right, ahead))
        away = [numpy.linalg.norm(self.seen_at(other, eye + depth * along) - at)
                for depth in numpy.linspace(0.2, 2.5, 400) * numpy.linalg.norm(target - eye)]
        self.assertLess(min(away), 0.005)

    def test_26_the_wheel_goes_to_what_is_under_the_pointer(self):
        viewer = self.beam()
        viewer.drag((470, 600), (471, 600), button=3)
        one = viewer.shows(lambda view: "camera" in view)["camera"]
        viewer.wheel(640, 300, 4)
        other = viewer.shows(lambda view: view["camera"] != one)["camera"]
        nearer = numpy.linalg.norm(numpy.subtract(other["eye"], other["target"]))
        self.assertLess(nearer, numpy.linalg.norm(numpy.subtract(one["eye"], one["target"])))
        self.assertGreater(numpy.linalg.norm(numpy.subtract(other["target"], one["target"])), 0.01)

    def test_27_keys_look_along_the_axes(self):
        viewer = self.beam()
        for key, axis, sign in (("x", 0, 1), ("shift+x", 0, -1), ("y", 1, 1), ("z", 2, 1), ("shift+z", 2, -1)):
            viewer.key(key)

            def there(view, axis=axis, sign=sign):
                if "camera" not in view:
                    return False
                way = numpy.subtract(view["camera"]["eye"], view["camera"]["target"])
                return sign * way[axis] > 0.999 * numpy.linalg.norm(way)

            viewer.shows(there, f"the sight of {key}")

    def test_28_a_click_on_the_triad_looks_along_an_axis(self):
        viewer = self.beam()
        viewer.click(73, 646)  # x's end
        view = viewer.shows(lambda view: "camera" in view)
        way = numpy.subtract(view["camera"]["eye"], view["camera"]["target"])
        self.assertGreater(way[0], 0.999 * numpy.linalg.norm(way))

    def test_29_shift_drag_rolls(self):
        viewer = self.beam()
        viewer.display.key("Shift_L", True)
        viewer.drag((700, 360), (470, 130), steps=16)
        viewer.display.key("Shift_L", False)
        view = viewer.shows(lambda view: "camera" in view)
        self.assertLess(view["camera"]["up"][1], 0.5)
        viewer.key("ctrl+z")
        viewer.key("[")
        viewer.shows(lambda view: "camera" not in view)

    def test_30_r_rolls_by_a_quarter(self):
        viewer = self.beam()
        viewer.key("r")
        viewer.shows(lambda view: "camera" in view and abs(view["camera"]["up"][1]) < 0.3)
        for _ in range(3):
            viewer.key("r")
        viewer.shows(lambda view: view["camera"]["up"][1] > 0.5)

    def test_31_a_right_drag_moves_along(self):
        viewer = self.beam()
        viewer.drag((470, 300), (570, 300), button=3)
        view = viewer.shows(lambda view: "camera" in view)
        self.assertNotEqual(view["camera"]["target"], [0, 0, 0])

    def test_32_orthographic_and_back(self):
        viewer = self.beam()
        viewer.key("o")
        viewer.shows(lambda view: "orthographicHeight" in view.get("camera", {}))
        viewer.key("o")
        viewer.shows(lambda view: "camera" in view and "orthographicHeight" not in view["camera"])

    def test_33_a_camera_is_typed(self):
        viewer = self.beam()
        viewer.move(1100, 500)
        viewer.wheel(1100, 600, -30)
        viewer.press("by numbers")
        viewer.wheel(1100, 600, -30)
        x, y = viewer.see("target")
        viewer.click(x - 210, y)
        viewer.key("ctrl+a")
        viewer.type("0.25")
        viewer.key("Return")
        viewer.shows(lambda view: view.get("camera", {}).get("target", [0])[0] == 0.25)

    def test_34_full_screen_and_back(self):
        viewer = self.beam(size=(1000, 600), display=None)
        viewer.key("F11")
        viewer.key("F11")
        viewer.key("Right")
        viewer.shows(lambda view: view["layers"][0].get("step") == 1)

    def test_35_all_keys_are_shown(self):
        viewer = self.beam()
        viewer.key("?")
        viewer.see("Look from +x")
        viewer.see("turn about what is under the pointer")
        viewer.key("Escape")
        viewer.gone("Look from +x")

    def test_36_a_command_is_found_by_its_name(self):
        viewer = self.beam()
        viewer.do("Look from +z")
        view = viewer.shows(lambda view: "camera" in view)
        way = numpy.subtract(view["camera"]["eye"], view["camera"]["target"])
        self.assertGreater(way[2], 0.999 * numpy.linalg.norm(way))

    def test_37_tab_hides_the_panel(self):
        viewer = self.beam()
        viewer.key("Tab")
        viewer.gone("Transfer functions")
        viewer.key("Tab")
        viewer.see("Transfer functions")

    def test_93_the_panels_edge_is_dragged(self):
        viewer = self.beam()
        edge = lambda viewer: viewer.where("Open...", within=(640, 0, 1280, 40))[0]
        before = edge(viewer)
        viewer.drag((PANEL + 2, 600), (PANEL - 98, 600))
        viewer.until(lambda: abs(edge(viewer) - before + 100) < 8, "a wider panel")
        viewer.see("exact", within=(PANEL - 100, 60, 1280, 110))
        viewer.see("838 x 688", within=(PANEL - 100, 60, 1280, 110), least=0.7)
        again = self.viewer(state=viewer.folder)
        again.until(lambda: again.where("Open...", within=(640, 0, 1280, 40)) and abs(edge(again) - before + 100) < 8, "the same again")
        again.move(PANEL - 98, 600)
        for down in (True, False, True, False):  # sooner than 0.3 s
            again.display.button(1, down)
            time.sleep(0.03)
        again.until(lambda: abs(edge(again) - before) < 3, "the usual one")

    # Rest.

    def test_38_at_rest_nothing_is_drawn(self):
        viewer = self.beam()
        viewer.rests(0.02)  # the line's own pulse
        viewer.key("Right")  # and it wakes
        viewer.shows(lambda view: view["layers"][0].get("step") == 1)

    def test_91_what_changes_is_drawn_as_all_is(self):
        viewer = self.beam()
        chance = random.Random(5)

        def resting():
            """The window, once it stays as it is for more than a second."""
            before, looks = None, 0
            def same():
                nonlocal before, looks
                time.sleep(0.3)
                seen = viewer.picture().copy()
                seen[52:112, PANEL:] = 0  # numbers of the line
                looks = looks + 1 if before is not None and numpy.array_equal(seen, before) else 0
                before = seen
                return looks == 4
            viewer.until(same, "rest")
            return before

        late = 0  # pictures of a server that had no processor for so long
        for _ in range(6):
            for _ in range(6):
                what = chance.randrange(6)
                if what == 0:
                    viewer.key(chance.choice(["Right", "x", "o", "?", "d", "n", "g", "c", "Tab", "ctrl+2", "ctrl+1"]))
                elif what == 1:
                    viewer.wheel(chance.choice([400, 1100]), 400, chance.choice([-2, 2]))
                elif what == 2:
                    begin = chance.randrange(100, 1200), chance.randrange(100, 600)
                    viewer.drag(begin, (begin[0] + chance.randrange(-60, 60), begin[1] + 20), steps=3)
                elif what == 3:
                    viewer.click(chance.randrange(PANEL + 10, 1250), chance.randrange(145, 700))
                else:
                    viewer.move(chance.randrange(1280), chance.randrange(720))
            viewer.key("Escape")
            viewer.key("Escape")
            viewer.wheel(1100, 400, 40)  # numbers of the line are where they were
            parts = resting()
            viewer.display.expose()
            viewer.until(lambda: viewer.picture()[700:, PANEL:].any(), "the window again")
            whole = resting()
            at = numpy.argwhere((parts != whole).any(2))
            late += len(at) > 0
            if late > 1 or (len(at) > 0 and at.max(0)[1] >= PANEL):
                viewer.keep("failed.png")
                self.fail(f"{len(at)} pixels from {at.min(0)} to {at.max(0)} differ; see {viewer.folder}/failed.png")

    def test_39_the_pointer_says_what_a_control_does(self):
        viewer = self.beam()
        viewer.move(*viewer.see("?", within=(1195, 0, 1230, 40), least=0.7))
        viewer.see("Keys", within=(1000, 0, 1280, 80))
        x, y = viewer.see("layer's opacity")
        viewer.move(x - 90, y)
        viewer.see("of all that the layer draws")
        viewer.move(*viewer.see("frames/s", within=(PANEL, 40, 1280, 80)))
        viewer.see("The last picture:")  # what limits them

    def test_70_a_light_window_stays_light(self):
        viewer = self.beam()
        ground = lambda viewer: viewer.picture()[714, 1270].astype(int).min()
        self.assertLess(ground(viewer), 60)
        viewer.do("Light or dark")
        viewer.until(lambda: ground(viewer) > 200, "light")
        again = self.beam(state=viewer.folder)
        self.assertGreater(ground(again), 200)
        again.do("Light or dark")
        again.until(lambda: ground(again) < 60, "dark")

    # Without a server.

    def alone(self, *target, **how):
        viewer = hand.Viewer(target, **how)
        self.addCleanup(viewer.close)
        viewer.see("exact")
        return viewer

    def test_40_a_run_is_prepared_and_shown(self):
        viewer = self.alone(data() / "run.h5")
        viewer.until(lambda: warm(viewer.picture()[:, :PANEL]).sum() > 2000, "the beam")
        made = list((viewer.folder / "cache" / "mote").glob("*.mote"))
        self.assertEqual(len(made), 1)
        before = made[0].stat().st_mtime_ns
        viewer.ask_to_close()
        viewer.process.wait(60)
        self.alone(data() / "run.h5", state=viewer.folder)
        self.assertEqual([path.stat().st_mtime_ns for path in (viewer.folder / "cache" / "mote").glob("*.mote")], [before])

    def test_41_a_dataset_is_shown(self):
        self.alone(data() / "ct.mote").see("data/ct", within=(PANEL, 130, 1160, 170))

    def test_42_a_folder_is_shown(self):
        self.alone(data()).see("data/beam", within=(PANEL, 130, 1160, 170))

    def test_43_a_root_is_served_by_the_viewer_itself(self):
        for end, status in ((lambda: viewer.ask_to_close(), 0), (lambda: viewer.process.terminate(), -signal.SIGTERM)):
            viewer = self.alone("--spawn", f"mine={data()}")
            viewer.see("mine/beam", within=(PANEL, 130, 1160, 170))
            found = subprocess.run(["pgrep", "-P", str(viewer.process.pid)], capture_output=True, check=True)
            server = pathlib.Path(f"/proc/{int(found.stdout.split()[0])}")
            end()
            self.assertEqual(viewer.process.wait(60), status)
            latest = time.monotonic() + 60
            while server.exists() and time.monotonic() < latest:
                time.sleep(0.05)
            self.assertFalse(server.exists())

    def test_44_a_file_that_is_not_there_is_one_sentence(self):
        viewer = hand.Viewer(["/nowhere/run.h5"])
        self.addCleanup(viewer.close)
        self.assertNotEqual(viewer.process.wait(60), 0)
        self.assertIn("/nowhere/run.h5: there is no such file or folder", viewer.said())

    def test_69_what_is_prepared_is_said_in_the_window(self):
        for cancelled in (False, True):
            viewer = hand.Viewer([data() / "run.h5"])
            self.addCleanup(viewer.close)
            preparing = lambda: subprocess.run(["pgrep", "-x", "-P", str(viewer.process.pid), "mote-prep"], capture_output=True,
                                               check=False).stdout
            child = int(viewer.until(preparing, "mote-prep"))
            os.kill(child, signal.SIGSTOP)  # as if it took long
            viewer.see("Preparing run.h5")
            if cancelled:
                viewer.press("Cancel")
            os.kill(child, signal.SIGCONT)
            if cancelled:
                self.assertNotEqual(viewer.process.wait(60), 0)
                self.assertFalse(pathlib.Path(f"/proc/{child}").exists())
                self.assertFalse(list((viewer.folder / "cache" / "mote").glob("*.mote")))
            else:
                viewer.until(lambda: warm(viewer.picture()[:, :PANEL]).sum() > 2000, "the beam")
                self.assertIn("mote-prep: kind: particles", viewer.said())

    # Time.

    def test_45_a_click_on_the_time_bar_goes_there(self):
        viewer = self.beam()
        viewer.click(598, 705)
        viewer.shows(lambda view: view["layers"][0].get("step") == 5)
        viewer.key("Home")
        viewer.shows(lambda view: view["layers"][0].get("step", 0) == 0)
        viewer.key("End")
        viewer.shows(lambda view: view["layers"][0].get("step") == 5)

    def test_46_steps_are_played_and_stop(self):
        viewer = self.beam()
        picture = lambda: viewer.picture()[100:600, 100:860]
        before = picture()
        viewer.press("Play")
        viewer.see("Pause")
        viewer.until(lambda: not numpy.array_equal(picture(), before), "another step")
        viewer.key("space")
        viewer.gone("Pause")

    def test_47_steps_are_played_backwards_without_a_loop(self):
        viewer = self.beam()
        viewer.key("End")
        viewer.press("loop", within=(600, 690, PANEL, 720))
        viewer.press("back", within=(600, 690, PANEL, 720))
        viewer.key("space")
        viewer.gone("Pause")
        viewer.shows(lambda view: view["layers"][0].get("step", 0) == 0)

    def test_94_ticks_lie_by_iterations_and_so_they_stay(self):
        viewer = self.beam()
        chooser, row = (820, 690, PANEL, 720), (140, 690, 320, 720)
        viewer.see("t = 0 ns", within=row)
        viewer.press("step", within=chooser)
        viewer.press("iteration", within=(820, 560, PANEL, 700))
        viewer.click(598, 705)
        viewer.see("iteration 480", within=row)
        viewer.see("400", within=(300, 690, 610, 720))  # between two steps
        viewer.shows(lambda view: view["layers"][0].get("step") == 5)
        again = self.beam(state=viewer.folder)
        again.see("iteration", within=chooser)
        again.display.resize(700, 720)
        again.press("...", within=(300, 690, 360, 720), least=0.7)
        for word in ("back", "loop"):
            again.press(word, within=(300, 600, 700, 720))
        again.key("Escape")
        again.key("End")
        again.shows(lambda view: view["layers"][0].get("step") == 5)
        again.key("space")
        again.shows(lambda view: view["layers"][0].get("step", 0) == 0)

    def test_55_axes_and_labels_are_switched(self):
        viewer = self.beam()
        viewer.move(1100, 600)
        viewer.wheel(1100, 600, -40)
        viewer.press("labels")
        viewer.shows(lambda view: view["annotations"].get("labels"))
        viewer.press("axes")
        viewer.shows(lambda view: "axes" not in view["annotations"])

    # Numbers.

    def test_56_a_lasso_selects(self):
        viewer = self.beam()
        viewer.key("l")
        viewer.see("Lasso: draw a line")
        viewer.move(470, 200)
        viewer.display.button(1, True)
        for angle in numpy.linspace(0, 2 * math.pi, 20):
            viewer.move(470 + 120 * math.sin(angle), 280 - 90 * math.cos(angle))
            time.sleep(0.03)
        viewer.display.button(1, False)
        viewer.shows(lambda view: view["selections"][0]["name"] == "lasso" and "highlight" in view["layers"][0])
        viewer.key("Escape")
        viewer.do("Fit to the selection")
        camera = viewer.shows(lambda view: "camera" in view, "a camera")["camera"]
        viewer.key("f")  # to all, from the same side
        wide = viewer.shows(lambda view: view["camera"] != camera)["camera"]
        away = lambda camera: numpy.linalg.norm(numpy.subtract(camera["eye"], camera["target"]))
        self.assertLess(away(camera), 0.95 * away(wide))
        self.assertGreater(away(camera), 0.2 * away(wide))
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "selections" not in view)

    def test_57_a_click_with_ctrl_picks_a_particle(self):
        viewer = self.beam()
        viewer.display.key("Control_L", True)
        viewer.click(470, 280)
        viewer.display.key("Control_L", False)
        viewer.press("Statistics")  # folded, the rest is to be seen
        viewer.see("Pick (P)")
        viewer.see("id", within=(PANEL, 300, 1280, 720))

    def test_58_the_histogram_comes_and_goes(self):
        viewer = self.beam()
        viewer.key("h")
        viewer.see("Histogram")
        viewer.key("h")
        viewer.gone("Histogram", within=(0, 0, PANEL, 720))

    def test_59_numbers_stand_beside_the_picture(self):
        viewer = self.beam()
        viewer.key("n")
        viewer.see("Statistics")
        viewer.see("norm_emit_x")

    # Films.

    def test_60_a_keyframe_is_added_taken_back_and_outlives_a_kill(self):
        viewer = self.beam()
        viewer.key("k")
        viewer.press("Add keyframe")
        viewer.until(lambda: viewer.desk() and viewer.desk()["film"], "the keyframe")
        viewer.key("ctrl+z")
        viewer.until(lambda: not viewer.desk()["film"], "its end")
        viewer.key("ctrl+shift+z")
        viewer.until(lambda: viewer.desk()["film"], "the keyframe")
        viewer.key("x")
        viewer.press("Add keyframe")
        film = viewer.until(lambda: len(viewer.desk()["film"]["keyframes"]) == 2 and viewer.desk()["film"], "another")
        viewer.process.send_signal(signal.SIGKILL)
        viewer.process.wait()
        again = self.viewer(state=viewer.folder)
        again.press("Take it up")
        again.until(lambda: again.desk() and again.desk()["film"] == film, "the film")

    # The line.

    def test_61_a_server_that_ends_is_said_and_waited_for(self):
        folder = hand.new_folder()
        server = hand.Server(folder, data())
        viewer = hand.Viewer(["--connect", server.connection])
        self.addCleanup(viewer.close)
        viewer.see("exact")
        server.close()
        viewer.see("Connect now", within=(0, 0, PANEL, 720))
        with hand.Server(folder, data()):
            at = viewer.where("Connect now", within=(0, 0, PANEL, 720))
            if at:  # else it has tried again by itself meanwhile
                viewer.click(*at)
            viewer.gone("Connect now")
            viewer.key("Right")
            viewer.shows(lambda view: view["layers"][0].get("step") == 1)


if __name__ == "__main__":
    unittest.main()
