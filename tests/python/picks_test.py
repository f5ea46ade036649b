# SPDX-License-Identifier: GPL-3.0-or-later
"""Picks of drawings in ink, asked of the real server: where lines of sight meet a box and a ball, by numpy."""
import unittest

import numpy as np

from support import FolderCase, mote, needs_server, prepare, spawn  # isort: skip

WIDTH, HEIGHT = 640, 400
CAMERAS = [{"eye": [3.0, 2.0, 5.0], "target": [0.4, 0.5, 0.5], "up": [0, 1, 0], "fovYDegrees": 30},
           {"eye": [-3.0, 2.5, 4.0], "target": [0.5, 0.5, 0.5], "up": [0.1, 1, 0], "orthographicHeight": 2.5}]
TURNED = np.array([[0.8, -0.6, 0, 0.1], [0.6, 0.8, 0, -0.2], [0, 0, 1.5, 0], [0, 0, 0, 1]])


def sight(camera, x, y):
    """The line of sight through a pixel's place, from the left upper corner: a point and a direction."""
    eye, target, up = (np.array(camera[name], float) for name in ("eye", "target", "up"))
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, ahead)
    half = camera["orthographicHeight"] / 2 if "orthographicHeight" in camera else np.tan(np.radians(camera["fovYDegrees"] / 2))
    aside = (2 * x / WIDTH - 1) * WIDTH / HEIGHT * half * right + (1 - 2 * y / HEIGHT) * half * above
    return (eye + aside, ahead) if "orthographicHeight" in camera else (eye, ahead + aside)


def in_unit_box(start, way):
    """Where the line enters [0, 1]^3, or None."""
    one, other = (0 - start) / way, (1 - start) / way
    begin, end = np.minimum(one, other).max(), np.maximum(one, other).min()
    return start + begin * way if begin < end else None


@needs_server
class Drawings(FolderCase):
    def setUp(self):
        super().setUp()
        (self.folder / "cube.obj").write_text("".join(f"v {i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8)) + "".join(
            f"f {a + 1} {b + 1} {d + 1}\nf {a + 1} {d + 1} {c + 1}\n"
            for a, b, c, d in ((0, 2, 1, 3), (4, 5, 6, 7), (0, 1, 4, 5), (2, 6, 3, 7), (0, 4, 2, 6), (1, 3, 5, 7))))
        prepare("mesh", self.folder / "cube.obj", "--out", self.folder / "cube.mote")
        self.session = spawn(self.folder)
        self.addCleanup(self.session.close)

    def view(self, camera, dataset, **layer):
        return mote.View.from_dict(self.session, {
            "width": WIDTH, "height": HEIGHT, "camera": camera, "layers": [{"dataset": dataset, **{"ink": {}, **layer}}]})

    def test_a_surface_is_met_where_the_line_of_sight_enters_it(self):
        cube = self.session["data/cube"]
        random = np.random.default_rng(5)
        met = 0
        for camera in CAMERAS:
            for transform in (np.eye(4), TURNED):
                view = self.view(camera, "data/cube", transform=transform.ravel().tolist())
                back = np.linalg.inv(transform)
                for x, y in random.uniform((150, 80), (490, 320), (12, 2)):
                    start, way = sight(camera, x, y)
                    expected = in_unit_box(back[:3, :3] @ start + back[:3, 3], back[:3, :3] @ way)
                    found = cube.pick(view, float(x), float(y))
                    self.assertEqual(found is None, expected is None, (x, y))
                    if expected is None:
                        continue
                    met += 1
                    self.assertEqual(found["layer"], 0)
                    # Rays and vertices are single floats.
                    np.testing.assert_allclose(found["position"], expected, atol=2e-5)
        self.assertGreater(met, 15)

    def test_what_is_cut_away_or_hidden_is_not_met(self):
        cube = self.session["data/cube"]
        camera = {"eye": [0.5, 0.5, 5], "target": [0.5, 0.5, 0], "up": [0, 1, 0], "orthographicHeight": 2}
        whole = cube.pick(self.view(camera, "data/cube"), 320, 200)
        np.testing.assert_allclose(whole["position"], [0.5, 0.5, 1], atol=2e-5)
        clip = {"planes": [{"normal": [0, 0, -1], "distance": -0.6}]}  # in front of it is what has z below 0.6
        cut = cube.pick(self.view(camera, "data/cube", clip=clip), 320, 200)
        self.assertLess(cut["position"][2], 0.6 + 1e-5)
        self.assertIsNone(cube.pick(self.view(camera, "data/cube", opacity=0), 320, 200))

    def test_the_surface_under_dots_is_met(self):
        prepare("stipple", self.folder / "cube.obj", "--points", "500", "--seed", "1", "--out", self.folder / "dots.mote")
        camera = {"eye": [0.5, 0.5, 5], "target": [0.5, 0.5, 0], "up": [0, 1, 0], "orthographicHeight": 2}
        found = self.session["data/dots"].pick(self.view(camera, "data/dots"), 320, 200)
        np.testing.assert_allclose(found["position"], [0.5, 0.5, 1], atol=2e-5)

    def test_a_ball_in_a_volume_is_met_on_its_side_towards_the_eye(self):
        size = 48
        z, y, x = np.mgrid[:size, :size, :size] - (size - 1) / 2
        radius = np.sqrt(x * x + y * y + z * z)
        (self.folder / "ball.raw").write_bytes(np.where(radius < 16, 255, 0).astype(np.uint8).tobytes())
        prepare("volume", self.folder / "ball.raw", "--dimensions", size, size, size, "--out", self.folder / "ball.mote")
        ball = self.session["data/ball"]
        camera = dict(eye=[0, 0, 200], target=[(size - 1) / 2] * 2 + [0], up=[0, 1, 0], orthographicHeight=60)
        camera["eye"][:2] = camera["target"][:2]
        view = self.view(camera, "data/ball", ink={"curve": [{"value": 120, "opacity": 0}, {"value": 130, "opacity": 1}]})
        scale = 60 / HEIGHT
        places = []
        for across in (-8, 0, 8):
            found = ball.pick(view, WIDTH / 2 + across / scale, HEIGHT / 2)
            places.append(np.array(found["position"]) - (size - 1) / 2)
        for across, place in zip((-8, 0, 8), places):
            np.testing.assert_allclose(place[:2], [across, 0], atol=1e-3)
            # Within a voxel: what is seen of a step of one voxel lies somewhere in it.
            self.assertAlmostEqual(place[2], np.sqrt(16.0 ** 2 - across ** 2), delta=1.5)
        self.assertIsNone(ball.pick(view, 5, 5))


if __name__ == "__main__":
    unittest.main()
