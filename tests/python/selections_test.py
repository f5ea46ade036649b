# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing and everything, asked of the real server and programs: in numbers, pictures, exports and files of JSON."""
import json
import subprocess
import unittest

import numpy as np
from PIL import Image as pil
from support import BIN, BeamCase, mote, needs_server  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

EMPTY = [{name: []} for name in ("ids", "ranges", "any", "all")]
NOTHING = [*EMPTY, {"ids": [], "density": {"max": 0.9}}, {"any": [{"ids": []}, {"ranges": []}]}, {"all": [{}, {"any": []}]},
           {"not": {}}, {"ids": [], "step": 1}, {"not": {"not": {"all": []}}}]
EVERYTHING = [{}, *[{"not": empty} for empty in EMPTY], {"any": [{"ids": []}, {}]}, {"ids": None, "any": None}]


def written(folder, select):
    """As a file, whose nulls say the same as Python's None."""
    path = folder / "select.json"
    path.write_text(json.dumps(select), encoding="utf-8")
    return path


def run(program, *words):
    return subprocess.run([str(BIN / program), *map(str, words)], capture_output=True, text=True, check=True, timeout=120).stdout


@needs_server
class Selections(BeamCase):
    def counts(self, select):
        return self.ds.statistics(select=select)["n_particle"].tolist()

    def test_numbers(self):
        every = self.ds.particles.tolist()
        self.assertTrue(all(every))
        for select in NOTHING:
            with self.subTest(select=select):
                self.assertEqual(self.counts(select), [0, 0, 0])
                self.assertTrue(np.isnan(self.ds.statistics(1, select)["sigma_x"]))
                counts = self.ds.histogram("x", "px", bins=8, select=select)
                self.assertEqual((float(counts[0].sum()), counts.particles.tolist()), (0.0, [0, 0, 0]))
                self.assertEqual([len(column) for column in self.ds.get(["x", "id"], 1, select)], [0, 0])
        for select in EVERYTHING:
            with self.subTest(select=select):
                self.assertEqual(self.counts(select), every)
                self.assertEqual(self.ds.histogram("x", bins=8, select=select).particles.tolist(), every)
                np.testing.assert_array_equal(self.ds.get("id", 1, select), self.ds.get("id", 1))
        ids, path = self.ds.track(mote.ids([]), ["x", "px"])
        self.assertEqual((len(ids), path.shape), (0, (3, 0, 2)))
        ids, path = self.ds.track({"not": {"any": []}, "step": 0}, "x")
        self.assertEqual(len(ids), every[0])
        self.assertEqual(len(self.ds.statistics(1, mote.ids([]), slices=("x", 4))["slices"]["n_particle"]), 4)

    def test_pictures(self):
        def image(**options):
            return mote.View(self.ds, step=1, size=(96, 64), **options).render()

        every = image()
        self.assertGreater(every.points_drawn, 0)
        for select in NOTHING:
            with self.subTest(select=select):
                none = image(select=select)
                self.assertEqual((none.points_drawn, int(none.array[..., :3].max())), (0, 0))
                np.testing.assert_array_equal(image(highlight=select).array, every.array)
        for select in EVERYTHING:
            with self.subTest(select=select):
                np.testing.assert_array_equal(image(select=select).array, every.array)
        lit = image(highlight={}).array
        self.assertFalse((lit == every.array).all())
        np.testing.assert_array_equal(image(highlight={"not": {"ids": []}}).array, lit)
        np.testing.assert_array_equal(image(select={"named": "none"}, selections={"none": {"ids": []}}).array,
                                      image(select=mote.ids([])).array)

    def test_a_pick_finds_nothing_where_nothing_is(self):
        camera = {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]}
        for select, found in ((None, True), ({"not": {"ids": []}}, True), (mote.ids([]), False)):
            view = mote.View(self.ds, step=1, size=(96, 64), camera=camera, select=select)
            first, again = (self.ds.pick(view, 48, 32, radius=500) for _ in range(2))  # what is chosen is kept
            self.assertEqual(first is not None, found, select)
            self.assertEqual(again, first)

    def test_a_pick_finds_what_a_plot_draws_by_itself(self):
        # So few particles are all points, in the core too; nobody says so.
        camera = {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]}
        points = {"points": {"linked": False, "curve": [{"density": 0, "fraction": 1}]}}
        for x, y in ((320, 240), (300, 250), (333, 231)):
            by_plot, said = (self.ds.pick(mote.View(self.ds, step=1, size=(640, 480), camera=camera, **style), x, y, radius=20)
                             for style in ({}, {"style": points}))
            self.assertIsNotNone(said)
            self.assertEqual(by_plot, said)

    def test_figures(self):
        # Only that they are drawn: of no particles, too.
        for select in (mote.ids([]), {}):
            self.assertIn("<svg", self.ds.figure("x", "px", step=1, select=select, bins=8).svg[:400])

    @unittest.skipUnless(h5py, "python3-h5py is missing")
    def test_exports(self):
        count = int(self.ds.particles[1])
        for select, rows in [(select, 0) for select in NOTHING] + [(select, count) for select in EVERYTHING]:
            with self.subTest(select=select):
                out = self.plots / "export.h5"
                out.unlink(missing_ok=True)
                self.ds.export(1, select).wait(progress=False).save(out)
                self.assertEqual(self.rows(out), [rows])
                out.unlink()
                run("mote-prep", "export", self.plots / "beam.mote", "--openpmd", out, "--steps", "1", "--select",
                    written(self.plots, select), "--quiet")
                self.assertEqual(self.rows(out), [rows])

    @staticmethod
    def rows(path):
        with h5py.File(path, "r") as file:
            return [int(species.attrs["numParticles"]) for step in file["data"].values() for species in step["particles"].values()]

    @unittest.skipUnless((BIN / "mote-stats").exists(), "there is no mote-stats")
    def test_files_of_mote_stats(self):
        every = self.ds.particles.tolist()
        for select, counts in [(select, [0, 0, 0]) for select in NOTHING] + [(select, every) for select in EVERYTHING]:
            with self.subTest(select=select):
                lines = run("mote-stats", "data/beam", "--connect", self.session._server.connection_file, "--json", "--select",
                            written(self.plots, select)).splitlines()
                self.assertEqual([json.loads(line)["n_particle"] for line in lines], counts)

    @unittest.skipUnless((BIN / "mote-frames").exists(), "there is no mote-frames")
    def test_files_of_mote_frames(self):
        views = []
        for select in (*EMPTY, {"not": {"ids": []}}):
            view = mote.View(self.ds, step=1, size=(48, 32)).to_dict()
            view["layers"][0]["select"] = select
            views.append(view)
        named = mote.View(self.ds, step=1, size=(48, 32), select={"named": "a"}, selections={"a": {}}).to_dict()
        named["selections"][0]["selection"] = {"any": []}
        script = self.plots / "script.json"
        script.write_text(json.dumps({"views": [*views, named]}), encoding="utf-8")
        run("mote-frames", script, "--connect", self.session._server.connection_file, "--out", self.plots / "frames", "--quiet")
        for index in range(6):
            pixels = np.array(pil.open(self.plots / "frames" / f"frame-{index:06d}.png").convert("RGB"))
            self.assertEqual(bool(pixels.any()), index == 4, index)


if __name__ == "__main__":
    unittest.main()
