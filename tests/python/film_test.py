#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Films and series of a bunch that travels: one camera sees all of its steps, where nobody says another."""
import io
import unittest

import numpy
from support import FolderCase, mote, needs_server, spawn  # isort: skip
from PIL import Image

STEPS = 5


@needs_server
class Travel(FolderCase):
    """A ball of particles that goes from x = -1 to x = 1 m in a plot that holds the whole way."""

    def setUp(self):
        super().setUp()
        self.session = spawn(self.folder)
        self.addCleanup(self.session.close)
        random = numpy.random.default_rng(1)
        ball = random.uniform(-0.05, 0.05, (3, 500))
        steps = [{"x": ball[0] + x, "y": ball[1], "z": ball[2]} for x in numpy.linspace(-1, 1, STEPS)]
        self.session.prepare_arrays(steps, axes=["x", "y", "z"], output="data/ball.mote").wait()
        self.view = mote.View(self.session["data/ball"], size=(320, 180),
                              camera=None, style={"points": {"color": [1, 1, 1], "sizePixels": 2}})

    def goes_across(self, pictures):
        """Holds that all of the ball is in each picture, farther to the right from one to the next, and as large."""
        middles = []
        for picture in pictures:
            rows, columns = numpy.nonzero(numpy.asarray(picture)[..., :3].max(axis=2) > 40)
            self.assertGreater(len(columns), 20, "the ball is not in the picture")
            self.assertTrue(2 < columns.min() and columns.max() < 317 and 2 < rows.min() and rows.max() < 177,
                            "the ball is cut by the picture's edge")
            middles.append(columns.mean())
        self.assertTrue((numpy.diff(middles) > 20).all(), middles)

    def test_a_series_of_steps_has_one_camera(self):
        script = mote.Script.steps(self.view, range(STEPS))
        self.goes_across(image.array for image in script.frames())
        cameras = [view.to_dict()["camera"] for view in script.views]
        self.assertTrue(all(camera == cameras[0] for camera in cameras))

    def test_axes_stand_still_while_steps_are_played(self):
        annotated = self.view.replace(annotations={"axes": True, "color": [1, 0, 0]})
        views = mote.Script.steps(annotated, range(STEPS)).views
        pictures = [view.render().array.astype(int) for view in views]
        red = [picture[..., 0] - picture[..., 1] > 60 for picture in pictures]
        self.assertGreater(red[0].sum(), 100, "axes are in the picture")
        self.assertTrue(all((mask == red[0]).all() for mask in red[1:]))
        around = [view.to_dict()["annotations"]["axesAround"] for view in views]
        self.assertEqual(set(around), {"plot"})
        said = annotated.replace(annotations={"axes": True, "axesAround": "shown"})
        self.assertEqual(mote.Script.steps(said, range(STEPS)).views[0].to_dict()["annotations"]["axesAround"], "shown")

    def test_a_view_s_own_camera_stays(self):
        camera = {"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 35}
        for view in mote.Script.steps(self.view.replace(camera=camera), range(STEPS)).views:
            self.assertEqual(view.to_dict()["camera"], camera)

    def test_fit_sees_what_a_view_without_a_camera_sees(self):
        fitted = self.view.fit()
        self.assertTrue((fitted.render().array == self.view.render().array).all())
        with self.fails("invalid_argument", "step"):
            self.view.fit([STEPS])

    def test_a_film_that_plays_steps_sees_them_all(self):
        moves = [{"playSteps": {"from": 0, "to": STEPS - 1}, "seconds": 1}]
        job = self.session.film({"fps": STEPS, "view": self.view.to_dict(), "moves": moves}, video="").wait()
        pictures = []
        for frame in range(STEPS):
            job.save(self.folder / "frame.png", frame=frame)
            pictures.append(Image.open(io.BytesIO((self.folder / "frame.png").read_bytes())).convert("RGB"))
        self.goes_across(pictures)


if __name__ == "__main__":
    unittest.main()
