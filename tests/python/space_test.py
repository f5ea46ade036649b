# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of worlds, and views whose layers lie in metres: held to the same views with matrices that numpy makes."""
import json
import subprocess
import unittest

import numpy as np

from support import BIN, FolderCase, mote, needs_server, prepare, spawn  # isort: skip

CORNERS = np.array([(x, y, z) for x in (-5, 5) for y in (-5, 5) for z in (-5, 5)], float)
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
SIZE = (200, 150)
MICRO = np.diag([1e6, 1e6, 1e6, 1.0])  # a world in micrometres looks the same


def write_mesh(path):
    """A cube with edges of 10."""
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in CORNERS] + ["f " + " ".join(str(i + 1) for i in face) for face in FACES]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_volume(path, unit=""):
    """A bump of 16 samples an edge, samples 2 apart; as NRRD."""
    grid = np.indices((16, 16, 16)) - 7.5
    units = f'space units: "{unit}" "{unit}" "{unit}"\n' if unit else ""
    head = f"NRRD0004\ntype: float\ndimension: 3\nsizes: 16 16 16\nspace dimension: 3\n{units}" \
        "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (-15,-15,-15)\nendian: little\nencoding: raw\n\n"
    path.write_bytes(head.encode() + np.exp(-(grid**2).sum(0) / 20).astype("<f4").tobytes())


def stretched(by):
    return np.diag([*by, 1.0])


def place_of(bounds):
    """Of a plot: its box of [-1, 1] to metres, by the names of its axes."""
    place = np.zeros((4, 4))
    place[3, 3] = 1
    for i, (name, (low, high)) in enumerate(bounds.items()):
        place["xyz".index(name), i] = (high - low) / 2
        place["xyz".index(name), 3] = (high + low) / 2
    return place


def pixels(*arguments, **options):
    return np.asarray(mote.View(*arguments, size=SIZE, **options).render().array).astype(float)


@needs_server
class InMetres(FolderCase):
    def beam(self, name, *options, axes="x,y,z", at=0.0, spread=1e-6, steps=1):
        random = np.random.default_rng(3)
        columns = {name: random.normal(0, spread * (1 + np.arange(steps))[:, None], (steps, 3000)) for name in "xyz"}
        columns["z"] += at
        columns["px"] = random.normal(0, 1e3, (steps, 3000))
        np.savez(self.folder / f"{name}.npz", **columns)
        prepare("particles", self.folder / f"{name}.npz", "--axes", axes, *options, "--out", self.folder / f"{name}.mote")

    def mesh(self, name, *options):
        write_mesh(self.folder / "cube.obj")
        prepare("mesh", self.folder / "cube.obj", *options, "--out", self.folder / f"{name}.mote")

    def same(self, shown, expected):
        # The matrices differ in their last digits: a point at a pixel's edge may be in its neighbour.
        self.assertGreater(shown.max(), 60, "something is shown")
        self.assertLess(np.mean(np.abs(shown - expected).max(2) > 8), 1e-3)
        self.assertLess(np.mean((shown - expected)**2), 255**2 * 10**-5)

    def test_layers_lie_where_matrices_of_numpy_put_them(self):
        self.beam("beam", at=2e-6)
        self.beam("turned", axes="z,x,y", at=2e-6)
        self.mesh("cube", "--unit", "um")
        write_volume(self.folder / "bump.nrrd", "nm")
        prepare("volume", self.folder / "bump.nrrd", "--out", self.folder / "bump.mote")
        turn = np.array([[0, -1, 0, 1e-6], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
        stretch = (2.0, 1.0, 0.5)
        with spawn(self.folder) as session:
            beam, plot, cube, bump = (session[f"data/{name}"] for name in ("beam", "turned", "cube", "bump"))
            own = {beam.name: place_of(beam.bounds), plot.name: place_of(plot.bounds), cube.name: np.diag([1e-6, 1e-6, 1e-6, 1]),
                   bump.name: np.diag([1e-9, 1e-9, 1e-9, 1])}
            self.same(pixels(plot, space="metres"), pixels(beam, space="metres"))
            for datasets in ((beam,), (plot,), (cube,), (bump,), (beam, cube), (cube, bump)):
                for by, moved in (((1, 1, 1), np.eye(4)), (stretch, np.eye(4)), (stretch, turn)):
                    styles = [{"opacity": 0.3} if one is cube else None for one in datasets]
                    metres = [mote.Layer(one, style=style, transform=moved) for one, style in zip(datasets, styles)]
                    world = [mote.Layer(one, style=style, transform=MICRO @ stretched(by) @ moved @ own[one.name])
                             for one, style in zip(datasets, styles)]
                    self.same(pixels(metres, space="metres", stretch=by), pixels(world))

    def test_a_beam_of_micrometres_a_kilometre_away_is_as_sharp(self):
        bounds = [word for axis in "xy" for word in ("--bounds", f"{axis}=-5e-6:5e-6")]
        self.beam("near", *bounds, "--bounds", "z=-5e-6:5e-6")
        self.beam("far", *bounds, "--bounds", "z=999.999995:1000.000005", at=1000.0)
        with spawn(self.folder) as session:
            near, far = session["data/near"], session["data/far"]
            self.same(pixels(far, space="metres"), pixels(far))
            self.same(pixels(near, space="metres"), pixels(near))

    def test_steps_with_bounds_of_their_own(self):
        self.beam("grows", "--bounds-of", "step", steps=3)
        with spawn(self.folder) as session:
            beam = session["data/grows"]
            places = [place_of(beam.bounds_of(step)) for step in range(3)]
            camera = {"eye": [0, 0, 3e-5], "target": [0, 0, 0], "up": [0, 1, 0]}
            above = {**camera, "eye": [0, 0, 30]}  # in micrometres
            for step in range(3):
                self.same(pixels(beam, step, space="metres", camera=camera),
                          pixels(mote.Layer(beam, step, transform=MICRO @ places[step]), camera=above))
            between = 0.75 * places[0] + 0.25 * places[2]
            self.same(pixels(mote.Layer(beam, 0, towards=(2, 0.25)), space="metres", camera=camera),
                      pixels(mote.Layer(beam, 0, towards=(2, 0.25), transform=MICRO @ between), camera=above))
            view = mote.View(beam, 1, size=SIZE, space="metres", camera=camera)
            x, y = beam.get(["x", "y"], step=1, select={"ranges": [{"column": "z", "min": 0}]})
            i = int(np.argmax(np.hypot(x, y)))
            tangent = np.tan(np.radians(35 / 2)) * 3e-5
            picked = beam.pick(view, (x[i] / (tangent * 4 / 3) + 1) * SIZE[0] / 2, (1 - y[i] / tangent) * SIZE[1] / 2, radius=8)
            self.assertAlmostEqual(np.hypot(picked["values"]["x"] - x[i], picked["values"]["y"] - y[i]), 0, delta=1.5e-6)

    def test_a_lasso_takes_what_it_surrounds(self):
        self.beam("beam", spread=1e-9, at=1e-8)
        with spawn(self.folder) as session:
            beam = session["data/beam"]
            camera = {"eye": [0, 0, 5e-8], "target": [0, 0, 1e-8], "up": [0, 1, 0]}
            right = mote.lasso(camera, 4 / 3, [[0.5, -9], [9, -9], [9, 9], [0.5, 9]], place_of(beam.bounds).ravel().tolist())
            x = beam.get("x", select=right)
            self.assertEqual(x.size, (beam.get("x") > 0).sum())
            self.assertGreater(x.min(), 0)

    def test_what_has_no_place_is_said(self):
        self.beam("phase", axes="x,px,y")
        self.mesh("plain")
        with spawn(self.folder) as session:
            for name, words in (("phase", "a plot along x, px, y"), ("plain", "--unit")):
                with self.fails("invalid_argument", "layers[0].dataset", words):
                    pixels(session[f"data/{name}"], space="metres")
            phase = session["data/phase"]
            with self.fails("invalid_argument", words="stretch"):
                pixels(phase, stretch=[1, 1, 1])
            with self.fails("invalid_argument", words="space"):
                pixels(phase, space="feet")

    def frames(self, script):
        (self.folder / "film.json").write_text(json.dumps(script), encoding="utf-8")
        return subprocess.run([str(BIN / "mote-frames"), str(self.folder / "film.json"), "--spawn", f"data={self.folder}", "--device", "cpu",
                               "--out", str(self.folder / "pictures")], capture_output=True, text=True, check=False, timeout=60)

    def test_a_film_stays_in_its_space(self):
        self.beam("beam")
        view = {"width": 64, "height": 48, "space": "metres", "layers": [{"dataset": "data/beam", "particles": {}}]}
        longer = {**view, "stretch": [1, 1, 4]}
        plain = {key: value for key, value in view.items() if key != "space"}
        frames = [{"seconds": i / 10, "view": one} for i, one in enumerate((view, longer))]
        done = self.frames({"fps": 20, "keyframes": frames})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(list((self.folder / "pictures").glob("*.png"))), 3)
        done = self.frames({"fps": 20, "keyframes": [frames[0], {"seconds": 0.1, "view": plain}]})
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("keyframes[1].view.space", done.stderr)


@needs_server
class Units(FolderCase):
    def refused(self, *words):
        done = subprocess.run([str(BIN / "mote-prep"), *map(str, words), "--out", str(self.folder / "none.mote"), "--quiet"],
                              capture_output=True, text=True, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertFalse((self.folder / "none.mote").exists())
        return done.stderr

    def manifest(self, name):
        return json.loads((self.folder / f"{name}.mote" / "manifest.json").read_text(encoding="utf-8"))

    def info(self, name):
        return subprocess.run([str(BIN / "mote-prep"), "info", str(self.folder / f"{name}.mote")], capture_output=True, text=True, check=True).stdout

    def test_what_a_mesh_has_is_what_is_said(self):
        write_mesh(self.folder / "cube.obj")
        for name, options in (("plain", ()), ("mm", ("--unit", "mm"))):
            prepare("mesh", self.folder / "cube.obj", *options, "--out", self.folder / f"{name}.mote")
            prepare("stipple", self.folder / "cube.obj", "--points", "200", *options, "--out", self.folder / f"{name}-dots.mote")
        for name in ("plain", "plain-dots"):
            self.assertNotIn("worldUnit", self.manifest(name))
            self.assertIn("of an unknown unit", self.info(name))
        for name in ("mm", "mm-dots"):
            self.assertEqual(self.manifest(name)["worldUnit"], "mm")
            self.assertIn("to [5, 5, 5] mm", self.info(name))
        self.assertIn("UNIT", self.refused("mesh", self.folder / "cube.obj", "--unit", "furlong").upper())
        looked = subprocess.run([str(BIN / "mote-prep"), "look", str(self.folder / "cube.obj")], capture_output=True, text=True, check=True)
        self.assertIn("--unit", looked.stdout)

    def test_a_volume_s_file_goes_before(self):
        for said, asked, expected in (("", "mm", "mm"), ("", "", ""), ("mm", "", "mm"), ("millimeter", "mm", "mm"), ("micron", "um", "um"),
                                      ("pixels", "cm", "cm")):
            path = self.folder / f"{said or 'none'}-{asked or 'none'}.nrrd"
            write_volume(path, said)
            for kind, options in (("volume", ()), ("mesh", ("--isovalue", "0.5"))):
                output = path.with_name(f"{path.stem}-{kind}.mote")
                prepare(kind, path, *options, *(("--unit", asked) if asked else ()), "--out", output)
                manifest = self.manifest(output.stem)
                found = (manifest["hybrid"] if kind == "volume" else manifest).get("worldUnit", "")
                self.assertEqual(found, expected, f"{kind} of {said!r} asked for {asked!r}")
        write_volume(self.folder / "mm.nrrd", "mm")
        for kind, options in (("volume", ()), ("mesh", ("--isovalue", "0.5"))):
            said = self.refused(kind, self.folder / "mm.nrrd", *options, "--unit", "cm")
            self.assertIn("unit: the file says that its lengths are in mm, not cm", said)


if __name__ == "__main__":
    unittest.main()
