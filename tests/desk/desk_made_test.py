#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A person has pictures and plots made: docs/VIEWER.md, "What a person does"."""
import json
import os
import pathlib
import signal
import subprocess
import unittest
import unittest.mock

import numpy
from PIL import Image

import hand
from desk_case import PANEL, DeskCase, warm


def descendant(process, name):
    """The id of a process of this name below another one, or None."""
    try:
        children = [child for task in pathlib.Path(f"/proc/{process}/task").iterdir()
                    for child in (task / "children").read_text(encoding="ascii").split()]
        for child in map(int, children):
            found = child if pathlib.Path(f"/proc/{child}/comm").read_text(encoding="utf-8").strip() == name else None
            found = found or descendant(child, name)
            if found:
                return found
    except OSError:  # it has ended meanwhile
        pass
    return None


class DeskMade(DeskCase):

    def test_53_a_picture_is_saved_at_any_size(self):
        viewer = self.beam()
        press_save = lambda: viewer.press("Save", within=(380, 240, 640, 340), least=0.9)

        def save(width, height):
            viewer.key("ctrl+p")
            x, y = viewer.see("pixels across and down")
            for at, pixels in ((x - 200, width), (x - 115, height)):
                viewer.click(at, y)
                viewer.key("ctrl+a")
                viewer.type(pixels)
            press_save()
        save("640", "480")
        path = viewer.folder / "picture.png"
        viewer.until(path.exists, "the picture")
        with Image.open(path) as picture:
            self.assertEqual(picture.size, (640, 480))
            small = numpy.asarray(picture.convert("RGB"), float)
        self.assertGreater(warm(small).sum(), 2000)
        # Four times as large it is the same picture, points and letters too.
        viewer.gone("Cancel")
        save("2560", "1920")
        viewer.see("is there already")
        before = path.stat().st_ino
        press_save()
        viewer.until(lambda: path.stat().st_ino != before, "the larger picture")
        with Image.open(path) as picture:
            self.assertEqual(picture.size, (2560, 1920))
            large = numpy.asarray(picture.convert("RGB").resize((640, 480), Image.BOX), float)
        light = lambda picture: (picture.mean(), (picture.max(2) > 60).mean())
        numpy.testing.assert_allclose(light(large), light(small), rtol=0.15)
        self.assertLess(numpy.abs(large - small).mean(), 8)

    def test_96_a_picture_without_its_background_and_the_window(self):
        viewer = self.beam()
        before = "as it is shown"

        def save(what, path):
            nonlocal before
            viewer.key("ctrl+p")
            viewer.see("pixels across and down")
            viewer.key("ctrl+a")
            viewer.type(path.name)
            viewer.press(before, within=(380, 190, 660, 280))
            viewer.press(what, within=(380, 220, 660, 340))
            before = what
            viewer.press("Save", within=(380, 270, 640, 340), least=0.9)
            viewer.until(path.exists, "the picture")
            viewer.gone("Cancel")

        shown = viewer.picture()[:560, :800].astype(float)  # beside the triad and notes
        clear = viewer.folder / "clear.png"
        save("without its background", clear)
        with Image.open(clear) as picture:
            self.assertEqual((picture.mode, picture.size), ("RGBA", (PANEL, 688)))
            pixels = numpy.asarray(picture, float)[:560, :800]
        opacity = pixels[..., 3:] / 255
        self.assertLess(opacity[:100, :100].max(), 0.01)
        self.assertLess(numpy.abs(opacity * pixels[..., :3] - shown).max(), 1.5)  # on black it is what is shown
        window = viewer.folder / "window.png"
        save("the whole window", window)
        with Image.open(window) as picture:
            self.assertEqual(picture.size, (1280, 720))
            kept = numpy.asarray(picture.convert("RGB")).astype(int)
        numpy.testing.assert_allclose(kept[:560, :800], shown, atol=1)  # nothing lies over it
        panel = viewer.picture()[130:, PANEL:1260].astype(int)
        numpy.testing.assert_allclose(kept[130:, PANEL:1260], panel, atol=1)

    def test_97_a_picture_is_copied(self):
        tools = hand.new_folder()
        with unittest.mock.patch.dict(os.environ, PATH=f"{tools}:/nowhere"):
            viewer = self.beam()
        shown = viewer.picture()[:560, :800]
        viewer.key("ctrl+c")
        viewer.see("that takes xclip", within=(400, 400, PANEL, 720))
        copied = tools / "copied"
        program = tools / "xclip"
        program.write_text(f"#!/bin/sh\n[ \"$4\" = image/png ] && /bin/cat > {copied}.part && /bin/mv {copied}.part {copied}\n",
                           encoding="utf-8")
        program.chmod(0o755)
        viewer.do("Copy picture")
        viewer.until(copied.exists, "the picture")
        with Image.open(copied) as picture:
            pixels = numpy.asarray(picture.convert("RGB"))
        numpy.testing.assert_array_equal(pixels[:560, :800], shown)

    def test_103_a_picture_is_copied_on_wayland(self):
        tools = hand.new_folder()
        copied = tools / "copied"
        program = tools / "wl-copy"
        program.write_text(f"#!/bin/sh\necho \"$@\" > {tools}/words\n/bin/cat > {copied}.part && /bin/mv {copied}.part {copied}\n",
                           encoding="utf-8")
        program.chmod(0o755)
        other = tools / "xclip"  # which is not asked
        other.write_text(f"#!/bin/sh\n/bin/cat > {tools}/other\n", encoding="utf-8")
        other.chmod(0o755)
        viewer = self.beam(PATH=f"{tools}:/nowhere", WAYLAND_DISPLAY="wayland-none")
        shown = viewer.picture()[:560, :800]
        viewer.key("ctrl+c")
        viewer.until(copied.exists, "the picture")
        self.assertEqual((tools / "words").read_text(encoding="utf-8"), "--type image/png\n")
        self.assertFalse((tools / "other").exists())
        with Image.open(copied) as picture:
            self.assertEqual(picture.format, "PNG")
            pixels = numpy.asarray(picture.convert("RGB"))
        numpy.testing.assert_array_equal(pixels[:560, :800], shown)

    def test_54_the_command_that_makes_the_picture_is_copied(self):
        viewer = self.beam()
        viewer.do("Copy the command that makes this picture")
        path = viewer.folder / "state" / "mote" / "views" / "view.json"
        viewer.until(path.exists, "the view")
        viewer.key("ctrl+o")  # a line to paste into
        viewer.see("Cancel")
        viewer.key("ctrl+a")
        viewer.key("ctrl+v")
        viewer.key("Home")
        viewer.see("mote-frames '")
        out = viewer.folder / "frames"
        subprocess.run([hand.BIN / "mote-frames", path, "--connect", self.server.connection, "--out", out], check=True,
                       stdout=subprocess.DEVNULL)
        with Image.open(out / "frame-000000.png") as made:
            made = numpy.asarray(made.convert("RGB"))
        self.assertEqual(made.shape[:2], (688, PANEL))
        viewer.key("Escape")
        viewer.gone("Cancel")
        shown = viewer.picture()[:560, :800]  # beside the triad and notes
        numpy.testing.assert_array_equal(shown, made[:560, :800])

    def test_98_jobs_stand_in_a_drawer_that_is_never_scrolled_away(self):
        viewer = self.beam()
        panel, drawer = (PANEL, 0, 1280, 720), (PANEL, 680, 1280, 720)
        viewer.see("Jobs:", within=drawer)
        y = viewer.see("Plot", within=(1190, 180, 1280, 400))[1]
        viewer.click(1186, y)
        viewer.press("z", within=(1120, y, 1200, 700), least=0.95)
        viewer.press("Plot", within=(1190, 180, 1280, 400))
        job = viewer.until(lambda: descendant(self.server.process.pid, "mote-prep"), "the job")
        os.kill(job, signal.SIGSTOP)  # as if it took long
        viewer.see("% of data/beam-x-px-z", within=drawer)
        viewer.key("n")
        viewer.see("norm_emit_x", within=panel)
        viewer.see("% of data/beam-x-px-z", within=drawer)
        viewer.key("Tab")
        viewer.see("Making data/beam-x-px-z")
        viewer.key("Tab")
        viewer.press("% of data/beam-x-px-z", within=drawer)
        viewer.press("Cancel", within=panel)
        os.kill(job, signal.SIGCONT)
        viewer.see("data/beam-x-px-z: cancelled", within=panel)
        viewer.see("data/beam-x-px-z was cancelled.", within=(0, 500, PANEL, 720))
        viewer.press("Try again", within=panel)
        viewer.see("data/beam-x-px-z: succeeded", within=panel)
        viewer.press("Open it", within=(PANEL, 400, 1280, 720))
        viewer.until(lambda: viewer.desk() and viewer.desk()["subject"] == "data/beam-x-px-z", "the plot")

    def test_102_a_film_is_made_again(self):
        script = self.saved("film.json", {
            "fps": 10, "view": {"width": 64, "height": 48, "layers": [{"dataset": "data/beam", "particles": {}}]},
            "moves": [{"seconds": 0.3, "turn": {"degrees": 90}}]})
        subprocess.run([hand.BIN / "mote-frames", script, "--connect", self.server.connection, "--detach"], check=True,
                       stdout=subprocess.DEVNULL)
        viewer = self.beam()
        viewer.press("3 frames succeeded", within=(PANEL, 680, 1280, 720))
        viewer.press("Again", within=(PANEL, 610, 1280, 720))
        viewer.see("pictures of data/beam, 3 frames: succeeded", within=(PANEL, 400, 1280, 720), nth=1)

    def test_113_strokes_of_a_film_stay(self):
        viewer = self.viewer("--view", self.saved("ink.json", {"layers": [{"dataset": "data/magnet", "ink": {}}]}))
        viewer.see("exact", within=(PANEL, 60, 1280, 110))
        viewer.key("k")
        viewer.press("Add keyframe")
        viewer.drag((300, 150), (340, 150))
        viewer.press("Add keyframe")
        viewer.until(lambda: len(viewer.desk()["film"]["keyframes"]) == 2, "another")
        viewer.press("Make film")

        def asked():
            """The script of the film, as its job has it."""
            for path in (self.folder / "server" / "jobs").glob("*/request.json"):
                request = json.loads(path.read_text(encoding="utf-8"))
                if "magnet" in json.dumps(request.get("film", {})):
                    return request["film"]["script"]
            return None

        # A film is coherent unless it says that it is not: this one says nothing.
        inks = [keyframe["view"]["layers"][0]["ink"] for keyframe in viewer.until(asked, "the job")["keyframes"]]
        self.assertEqual(len(inks), 2)
        for ink in inks:
            self.assertNotIn("coherent", ink)
        viewer.press("Cancel")

    def test_99_a_region_lights_its_densities(self):
        viewer = self.beam()
        plot = (PANEL, 552, 1260, 670)
        lit = lambda: (numpy.abs(viewer.picture()[plot[1]:plot[3], plot[0]:plot[2]].astype(int) - (206, 182, 108)).max(2) < 14)
        self.assertLess(lit().sum(), 30)
        viewer.key("t")
        viewer.see("Densities: drag a rectangle", within=(0, 0, PANEL, 60))
        view = viewer.view()
        viewer.drag((420, 250), (560, 330))
        viewer.see("particles in it", within=(0, 0, PANEL, 60))
        viewer.until(lambda: lit().sum() > 300, "its densities")
        middle = lit()
        viewer.drag((240, 240), (330, 390))  # the thin rim
        viewer.until(lambda: lit().sum() > 30 and not numpy.array_equal(lit(), middle), "others")
        columns = lambda seen: numpy.average(numpy.nonzero(seen)[1])
        viewer.until(lambda: columns(lit()) < columns(middle) - 10, "thinner ones")
        self.assertEqual(viewer.view(), view)  # the camera stays where it was
        viewer.key("Escape")
        viewer.until(lambda: lit().sum() < 30, "their end")

    def test_100_the_axis_of_densities_is_linear(self):
        viewer = self.beam()
        viewer.wheel(1100, 600, -6)
        panel = (PANEL, 0, 1280, 690)

        def share(title):
            """Of the columns of the plot below its title that are filled, how many stand in its left quarter."""
            y = viewer.see(title, within=panel)[1]
            filled = viewer.picture()[y + 60:y + 110, PANEL + 10:1256].astype(int).min(2) > 70
            return filled[:, :filled.shape[1] // 4].sum() / max(filled.sum(), 1)

        before = share("Volume: opacity over log density")
        viewer.press("linear axis", within=panel)
        viewer.until(lambda: share("Volume: opacity over density") > before + 0.1, "thin matter at the left")
        view = viewer.view()
        viewer.press("linear axis", within=panel)
        viewer.until(lambda: abs(share("Volume: opacity over log density") - before) < 0.01, "as before")
        self.assertEqual(viewer.view(), view)  # it is no edit

    def test_101_a_data_saver_asks_for_less(self):
        viewer = self.beam()
        viewer.press("data saver", within=(PANEL, 85, 1280, 115))
        viewer.see("Data saver: 470 x 344 pixels", within=(300, 650, PANEL, 690))
        viewer.see("470 x 344", within=(PANEL, 60, 1280, 110))
        viewer.drag((300, 300), (500, 330), steps=20)
        viewer.see("470 x 344", within=(PANEL, 60, 1280, 110))
        again = self.beam(state=viewer.folder)
        again.see("Data saver: 470 x 344 pixels", within=(300, 650, PANEL, 690))
        again.do("Data saver on or off")
        again.gone("Data saver:", within=(300, 650, PANEL, 690))
        again.see("940 x 688", within=(PANEL, 60, 1280, 110))


if __name__ == "__main__":
    unittest.main()
