# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-prep particles --follow: a run that h5py writes meanwhile, as files and as iterations of one file, whole and
half-written; seen by a server, held against the same run prepared at once; killed at any moment."""
import json
import os
import pathlib
import random
import signal
import subprocess
import threading
import time
import unittest

import numpy as np

from support import BIN, FolderCase, mote, needs_server, spawn  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

COUNT = 400
WAIT = 60.0  # s, for what takes one
AXES = ("x", "px", "y")
BOUNDS = ("--bounds", "x=-4:4", "--bounds", "px=-400:400", "--bounds", "y=-4:4")


def rows(iteration, count=COUNT):
    """Wider with each iteration."""
    chance = np.random.default_rng(iteration)
    wide = 0.2 * (1 + iteration)
    return {"position": {axis: chance.normal(size=count) * wide for axis in "xyz"},
            "momentum": {axis: chance.normal(size=count) * 100 * wide for axis in "xyz"}}


def write_into(file, iteration, values=None):
    """openPMD 1.1, in SI; momenta in kg m/s."""
    if "openPMD" not in file.attrs:
        file.attrs.update({"openPMD": np.bytes_("1.1.0"), "openPMDextension": np.uint32(0),
                           "basePath": np.bytes_("/data/%T/"), "particlesPath": np.bytes_("particles/"),
                           "iterationEncoding": np.bytes_("groupBased"), "iterationFormat": np.bytes_("/data/%T/")})
    step = file.require_group("data").create_group(str(iteration))
    step.attrs.update({"time": float(iteration), "dt": 1.0, "timeUnitSI": 1e-9})
    for record, columns in (values or rows(iteration)).items():
        group = step.create_group(f"particles/beam/{record}")
        group.attrs["timeOffset"] = 0.0
        group.attrs["unitDimension"] = np.array([1, 0, 0, 0, 0, 0, 0] if record == "position" else
                                                [1, 1, -1, 0, 0, 0, 0], float)
        for axis, column in columns.items():
            group.create_dataset(axis, data=column)
            group[axis].attrs["unitSI"] = 1.0 if record == "position" else 5.344285992678308e-28  # eV/c


def write_iteration(path, iteration, mode="w", values=None):
    with h5py.File(path, mode) as file:
        write_into(file, iteration, values)


def wait_until(true, what):
    end = time.monotonic() + WAIT
    while not true():
        if time.monotonic() > end:
            raise AssertionError(f"after {WAIT} s: {what}")
        time.sleep(0.02)


def manifest(dataset):
    path = dataset / "manifest.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def steps(dataset):
    return manifest(dataset).get("particles", {}).get("steps", [])


def iterations(dataset):
    return [int(step.get("iteration", 0)) for step in steps(dataset)]


def is_live(dataset):
    return manifest(dataset).get("particles", {}).get("live", False)


def verify(dataset):
    done = subprocess.run([BIN / "mote-prep", "verify", dataset], capture_output=True, check=False)
    return done.returncode, (done.stdout + done.stderr).decode()


def prepare(run, dataset, *options):
    subprocess.run([BIN / "mote-prep", "particles", run, "--axes", ",".join(AXES), "--out", dataset, "--quiet", *options],
                   check=True, capture_output=True)


class Follower:
    """mote-prep on a run; ``said`` is what it wrote to stderr, once it has ended."""

    def __init__(self, run, dataset, *options):
        self.dataset = dataset
        self.said = ""
        self.process = subprocess.Popen(
            [BIN / "mote-prep", "particles", run, "--axes", ",".join(AXES), "--out", dataset, "--follow", "--json", *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.said += line.decode()

    def has(self, count):
        wait_until(lambda: len(steps(self.dataset)) >= count or self.process.poll() is not None,
                   f"{self.dataset.name} has {len(steps(self.dataset))} of {count} steps")
        if self.process.poll() is not None:
            self.end(None)
            raise AssertionError(self.said)

    def says(self, words):
        wait_until(lambda: words in self.said, f"{words!r} is not in {self.said!r}")

    def end(self, number=signal.SIGTERM):
        """Its exit code."""
        if number is not None:
            self.process.send_signal(number)
        self.process.wait(WAIT)
        self.reader.join()
        self.out = self.process.stdout.read().decode()
        self.process.stdout.close()
        self.process.stderr.close()
        return self.process.returncode


@unittest.skipUnless(h5py, "h5py is missing")
@needs_server
class FollowTest(FolderCase):
    def setUp(self):
        super().setUp()
        self.run, self.plots = self.folder / "run", self.folder / "plots"
        self.run.mkdir()
        self.plots.mkdir()
        self.pattern, self.live = self.run / "beam_%T.h5", self.plots / "live.mote"
        self.followers = []
        self.addCleanup(lambda: [one.end(signal.SIGKILL) for one in self.followers if one.process.poll() is None])

    def follow(self, run, *options):
        self.followers.append(Follower(run, self.live, *options))
        return self.followers[-1]

    def same_steps(self, once):
        """Byte by byte; of the manifests what is said of the steps."""
        names = sorted(path.name for path in once.iterdir() if not path.name.startswith("manifest"))
        self.assertEqual(names, sorted(path.name for path in self.live.iterdir() if not path.name.startswith("manifest")))
        for name in names:
            self.assertEqual((once / name).read_bytes(), (self.live / name).read_bytes(), name)
        made, grown = manifest(once)["particles"], manifest(self.live)["particles"]
        self.assertEqual(grown.pop("notes", None), made.pop("notes", None))
        self.assertEqual(grown, made)

    def test_files_become_steps_that_a_server_shows(self):
        follower = self.follow(self.pattern, *BOUNDS)
        write_iteration(self.run / "beam_3.h5", 3)
        follower.has(1)
        self.assertTrue(is_live(self.live))
        with spawn(self.plots, device="cpu") as session:
            ds = session["data/live"]
            self.assertEqual((len(ds), ds.live), (1, True))
            self.assertTrue([entry.live for entry in session.catalogue()][0])
            first = mote.View(ds, step=0, size=(96, 64)).render().array
            for iteration in (4, 10):
                write_iteration(self.run / f"beam_{iteration}.h5", iteration)
            follower.has(3)
            wait_until(lambda: len(ds) == 3, "the session sees three steps")
            self.assertEqual(list(ds.iterations), [3, 4, 10])
            self.assertEqual(follower.end(), 0)
            self.assertEqual(json.loads(follower.out)["steps"], 3)
            wait_until(lambda: not ds.live, "the session sees that no more come")
            prepare(self.pattern, self.plots / "once.mote", *BOUNDS)
            once = session["data/once"]
            for step in range(3):
                pictures = [mote.View(one, step=step, size=(96, 64)).render().array for one in (ds, once)]
                self.assertTrue(np.array_equal(*pictures), f"step {step}")
            self.assertFalse(np.array_equal(first, pictures[0]))
            x = ds.get("x", step=2)
            wanted = rows(10)["position"]["x"]
            kept = wanted[(abs(wanted) < 4) & (abs(rows(10)["position"]["y"]) < 4) & (abs(rows(10)["momentum"]["x"]) < 400)]
            np.testing.assert_allclose(np.sort(x), np.sort(kept), rtol=1e-6, atol=1e-7)
        self.same_steps(self.plots / "once.mote")
        self.assertFalse(is_live(self.live))
        self.assertEqual(verify(self.live)[0], 0)

    def test_iterations_of_one_file_become_steps(self):
        run = self.run / "beam.h5"
        for iteration in range(2):
            write_iteration(run, iteration, "a")
        follower = self.follow(run, *BOUNDS)
        follower.has(2)
        for iteration in range(2, 4):
            write_iteration(run, iteration, "a")  # never kept from its file
            follower.has(iteration + 1)
        with h5py.File(run, "a") as file:  # its own lock keeps nobody from reading
            for iteration in range(4, 7):
                write_into(file, iteration)
                file.flush()
                follower.has(iteration)
            self.assertEqual(iterations(self.live), list(range(6)), "the last one may not be whole")
        follower.has(7)
        self.assertEqual(follower.end(signal.SIGINT), 0)
        prepare(run, self.plots / "once.mote", *BOUNDS)
        self.same_steps(self.plots / "once.mote")

    def test_a_half_written_file_is_waited_for(self):
        follower = self.follow(self.pattern, *BOUNDS)
        write_iteration(self.run / "beam_0.h5", 0)
        follower.has(1)
        write_iteration(self.folder / "next.h5", 1)
        whole = (self.folder / "next.h5").read_bytes()
        half = self.run / "beam_1.h5"
        half.write_bytes(whole[:len(whole) // 2])
        follower.says("beam_1.h5")
        self.assertEqual(iterations(self.live), [0])
        half.write_bytes(whole)
        follower.has(2)
        with open(self.run / "beam_2.h5", "wb") as file:  # held open: not whole, whatever it holds
            write_iteration(self.folder / "third.h5", 2)
            file.write((self.folder / "third.h5").read_bytes())
            file.flush()
            time.sleep(1)  # four looks
            self.assertEqual(iterations(self.live), [0, 1])
        follower.has(3)
        self.assertEqual(follower.end(), 0)
        self.assertEqual(follower.said.count("tried again when it changes"), 1, follower.said)
        self.assertIn("beam_1.h5", follower.said)
        prepare(self.pattern, self.plots / "once.mote", *BOUNDS)
        self.same_steps(self.plots / "once.mote")

    def test_a_late_step_and_a_changed_one_are_said(self):
        follower = self.follow(self.pattern, *BOUNDS)
        write_iteration(self.run / "beam_5.h5", 5)
        follower.has(1)
        write_iteration(self.run / "beam_4.h5", 4)
        write_iteration(self.run / "beam_6.h5", 6)
        follower.has(2)
        self.assertEqual(iterations(self.live), [5, 6])
        write_iteration(self.run / "beam_5.h5", 5, values=rows(5, COUNT + 1))
        write_iteration(self.run / "beam_7.h5", 7)
        follower.has(3)
        self.assertEqual(follower.end(), 0)
        self.assertIn("step 4 came when the dataset had come to 5", follower.said)
        self.assertIn("beam_5.h5 was written to after its step was taken", follower.said)

    def test_bounds_are_those_of_the_first_steps_or_of_each(self):
        for iteration in range(3):
            write_iteration(self.run / f"beam_{iteration}.h5", iteration)
            if iteration == 0:
                follower = self.follow(self.pattern)
            follower.has(iteration + 1)
        self.assertEqual(follower.end(), 0)
        grown = manifest(self.live)["particles"]
        self.assertGreater(int(grown["steps"][2]["outside"]), 10)
        outside = sum(int(step.get("outside", 0)) for step in grown["steps"])
        self.assertIn(f"{outside} particles beyond the plot's bounds were left out, summed over all steps", grown["notes"])
        self.assertEqual(len([note for note in grown["notes"] if "summed over" in note]), 1)
        values = rows(0)
        self.assertEqual(grown["axes"][0]["max"], values["position"]["x"].max())
        self.live = self.plots / "own.mote"
        follower = self.follow(self.run, "--bounds-of", "step")
        follower.has(3)
        write_iteration(self.run / "beam_3.h5", 3)
        follower.has(4)
        self.assertEqual(follower.end(), 0)
        prepare(self.run, self.plots / "once.mote", "--bounds-of", "step")
        self.same_steps(self.plots / "once.mote")

    def test_it_ends_with_the_last_step_that_is_meant(self):
        follower = self.follow(self.pattern, "--steps", "0:4:2", *BOUNDS)
        for iteration in range(6):
            write_iteration(self.run / f"beam_{iteration}.h5", iteration)
        self.assertEqual(follower.end(None), 0)
        self.assertEqual(iterations(self.live), [0, 2, 4])
        self.assertFalse(is_live(self.live))

    def test_killed_at_any_moment_it_leaves_a_dataset_that_goes_on(self):
        chance = random.Random(int(os.environ.get("MOTE_SEED", "1")))
        write_iteration(self.run / "beam_0.h5", 0)
        self.follow(self.pattern, *BOUNDS).has(1)
        for iteration in range(1, int(os.environ.get("MOTE_KILLS", "6")) + 1):
            write_iteration(self.run / f"beam_{iteration}.h5", iteration)
            time.sleep(chance.uniform(0.0, 1.2))
            self.followers[-1].end(signal.SIGKILL)
            code, said = verify(self.live)
            self.assertEqual(code, 0, said)
            self.assertLess(len(steps(self.live)), iteration + 2)
            # As if it had come between the files and the manifest: they are of no step, and are written over.
            (self.live / f"step-{len(steps(self.live)):06d}.h5").write_bytes(b"left")
            self.assertEqual(verify(self.live)[0], 0)
            self.follow(self.pattern, *BOUNDS)
        write_iteration(self.run / f"beam_{iteration + 1}.h5", iteration + 1)
        self.followers[-1].has(iteration + 2)  # so that it is there to be told
        self.assertEqual(self.followers[-1].end(), 0)
        prepare(self.pattern, self.plots / "once.mote", *BOUNDS)
        self.same_steps(self.plots / "once.mote")
        self.assertEqual(verify(self.live)[0], 0)

    def test_what_does_not_go_on_is_refused(self):
        write_iteration(self.run / "beam_0.h5", 0)
        follower = self.follow(self.pattern, *BOUNDS)
        follower.has(1)
        second = self.follow(self.pattern, *BOUNDS)
        self.assertEqual(second.end(None), 1)
        self.assertIn("gets its steps from another program now", second.said)
        self.assertEqual(follower.end(signal.SIGKILL), -signal.SIGKILL)
        other = self.follow(self.pattern)
        self.assertEqual(other.end(None), 2)
        self.assertIn("bounds: is not that by which the live dataset live.mote was begun", other.said)
        again = self.follow(self.pattern, *BOUNDS)
        write_iteration(self.run / "beam_1.h5", 1)
        again.has(2)
        self.assertEqual(again.end(), 0)
        ended = self.follow(self.pattern, *BOUNDS)
        self.assertEqual(ended.end(None), 1)
        self.assertIn("is not live", ended.said)
        looked = Follower(self.live, self.plots / "none.mote")
        self.assertEqual(looked.end(None), 2)
        self.assertIn("is a dataset; the files of a run are followed", looked.said)
        nothing = Follower(self.run / "none_%T.h5", self.plots / "none.mote")
        self.followers.append(nothing)
        nothing.says("none_%T.h5: no file is there yet")
        self.assertEqual(nothing.end(), 128 + signal.SIGTERM)
        self.assertFalse((self.plots / "none.mote").exists())
        self.assertEqual(sorted(path.name for path in self.plots.iterdir() if "partial" in path.name and
                                str(follower.process.pid) not in path.name), [])


if __name__ == "__main__":
    unittest.main()
