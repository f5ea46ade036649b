# SPDX-License-Identifier: GPL-3.0-or-later
"""session.live: a simulation's own script sends its steps; the dataset grows while others look at it."""
import json
import subprocess
import unittest

import numpy as np

from support import BIN, FolderCase, mote, needs_server, spawn  # isort: skip
from mote.arrays import upload_steps  # isort: skip

AXES = ["x", "px", "y"]
BOUNDS = [{"name": name, "min": -5, "max": 5} for name in AXES]
MASS = 510998.95


def rows(step, count=500):
    chance = np.random.default_rng(step)
    return {name: chance.normal(size=count) * (0.5 + 0.1 * step) for name in ("x", "px", "y", "z", "pz")}


def manifest(dataset):
    return json.loads((dataset / "manifest.json").read_text(encoding="utf-8"))


@needs_server
class LiveRunTest(FolderCase):
    def setUp(self):
        super().setUp()
        self.session = spawn(self.folder, device="cpu")
        self.addCleanup(lambda: self.session.close())
        self.live = self.folder / "live.mote"

    def begin(self, **options):
        return self.session.live("data/live.mote", axes=AXES, mass=MASS, **{"bounds": BOUNDS, **options})

    def test_steps_come_in_order_and_are_those_of_one_job(self):
        run = self.begin(title="a run")
        run.step(rows(0), time=0.0).wait()
        ds = self.session["data/live"]
        self.assertEqual((len(ds), ds.live, ds.title), (1, True, "a run"))
        jobs = [run.step(rows(step), time=step * 1e-9, iteration=10 * step) for step in range(1, 6)]
        run.close()
        self.assertTrue(all(job.state == "succeeded" for job in jobs))
        self.assertEqual((len(ds), ds.live), (6, False))
        self.assertEqual(list(ds.iterations), [0, 10, 20, 30, 40, 50])
        np.testing.assert_allclose(ds.t, np.arange(6) * 1e-9)
        self.assertEqual(ds.mass, MASS)
        wanted = rows(5)
        inside = np.all([abs(wanted[name]) < 5 for name in AXES], axis=0)
        np.testing.assert_allclose(np.sort(ds.get("z", step=5)), np.sort(wanted["z"][inside]), rtol=1e-6, atol=1e-7)
        self.session.prepare_arrays([rows(step) for step in range(6)], axes=AXES, output="data/once.mote", mass=MASS,
                                    time=np.arange(6) * 1e-9, iteration=[0, 10, 20, 30, 40, 50], bounds=BOUNDS).wait()
        once = self.folder / "once.mote"
        for path in once.iterdir():
            if not path.name.startswith("manifest"):
                self.assertEqual(path.read_bytes(), (self.live / path.name).read_bytes(), path.name)
        made, grown = (manifest(folder)["particles"] for folder in (once, self.live))
        self.assertEqual(made, grown)
        for step in (0, 5):
            pictures = [mote.View(self.session[name], step=step, size=(64, 48)).render().array
                        for name in ("data/live", "data/once")]
            self.assertTrue(np.array_equal(*pictures))
        done = subprocess.run([BIN / "mote-prep", "verify", self.live], capture_output=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual([path.name for path in self.folder.iterdir() if "partial" in path.name], [])

    def test_it_goes_on_after_the_script_and_the_server_have_ended(self):
        run = self.begin()
        run.step(rows(0))
        run.step(rows(1)).wait()
        with self.fails("internal", words="is iteration 1, and the live dataset has come to 1"):
            self.session.submit(run._request(upload_steps(self.session, 99, rows(1), MASS, None, 1)), again=True).wait()
        self.session.close()
        self.session = spawn(self.folder, device="cpu")
        ds = self.session["data/live"]
        self.assertEqual((len(ds), ds.live), (2, True))
        self.assertEqual(mote.View(ds, step=1, size=(32, 32)).render().array.shape, (32, 32, 4))
        with self.begin() as run:
            run.step(rows(2))
        self.assertEqual(list(self.session["data/live"].iterations), [0, 1, 2])
        self.assertFalse(self.session["data/live"].live)
        with self.fails("already_exists", "output", "not live"):
            self.begin()

    def test_what_does_not_fit_is_refused_and_the_rest_goes_on(self):
        run = self.begin()
        run.step(rows(0)).wait()
        before = manifest(self.live)
        for options, words in (({"bounds": []}, "bounds: is not that by which the live dataset"),
                               ({"volume_level": 4}, "volumeLevel: is not that by which")):
            with self.fails("internal", words=words):
                self.begin(**options).step(rows(1)).wait()
        with self.fails("internal", words="mass: is not that by which"):
            self.session.live("data/live.mote", axes=AXES, mass=938272088.0, bounds=BOUNDS).step(rows(1)).wait()
        with self.fails("internal", words="axes: is not that by which"):
            self.session.live("data/live.mote", axes=["x", "y", "px"], mass=MASS, bounds=BOUNDS).step(rows(1)).wait()
        missing = {name: column for name, column in rows(1).items() if name != "z"}
        run.step(missing)
        with self.fails("internal", words="z"):
            run.close()
        self.assertEqual(manifest(self.live), before)
        with self.fails("invalid_argument", "iteration", "2 or more"):
            run.step(rows(1), iteration=1)
        run.step(rows(2), iteration=7)
        run.close()
        run.close()
        self.assertEqual(list(self.session["data/live"].iterations), [0, 7])
        with self.fails("invalid_argument", "step"):
            run.step(rows(3))
        with self.fails("invalid_argument", words="follow"):
            self.session.prepare("data/live.mote", axes=AXES, output="data/other.mote", follow=True)
        with self.fails("invalid_argument", "follow"):
            self.begin(follow=True)
        with self.fails("already_exists"):
            self.session.prepare_arrays(rows(0), axes=AXES, output="data/live.mote")


if __name__ == "__main__":
    unittest.main()
