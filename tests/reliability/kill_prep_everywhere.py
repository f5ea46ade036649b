#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-prep hurt at each of its writes, fsyncs and renames: killed, without space, with a disk that fails.

    kill_prep_everywhere.py [--build build/release] [--every 1] [--most 0]

Whatever happens, a dataset is there whole or not at all, what was there before is as it was, and an error is one
sentence. Prints how many faults there were and how many of them broke that; exits 1 where any did.
"""
import argparse
import hashlib
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

import strace_faults

FAULTS = ("signal=KILL", "error=ENOSPC", "error=EIO")


def digest(folder):
    """Of all names and bytes."""
    state = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        state.update(str(path.relative_to(folder)).encode() + b"\0")
        if path.is_file():
            state.update(path.read_bytes())
    return state.hexdigest()


class Work:
    """A folder with a run, a dataset that was there before, and one that is to be made."""

    def __init__(self, folder, prep):
        self.folder, self.prep = folder, prep
        self.run = folder / "run.h5"
        self.before, self.wanted = folder / "before.mote", folder / "wanted.mote"
        subprocess.run([prep, "synth", "beam", "--particles", "2000", "--steps", "2", "--seed", "1", "--quiet", "--out",
                        self.run], check=True)
        subprocess.run(self.command(self.before), check=True)
        self.digest = digest(self.before)

    def command(self, output):
        return [self.prep, "particles", self.run, "--axes", "x,px,y", "--threads", "1", "--memory", "200M", "--quiet",
                "--out", output]

    def clear(self):
        for path in self.folder.glob("wanted.mote*"):
            shutil.rmtree(path)

    def wrongs(self, done, fault):
        """What is not as it should be after a fault."""
        wrongs = []
        if digest(self.before) != self.digest:
            wrongs.append("the dataset that was there before is another")
        whole = self.wanted.exists() and self.verifies()
        if self.wanted.exists() and not whole:
            wrongs.append("a dataset is visible that is not whole")
        if fault.startswith("error") and done.returncode != 0:
            if self.wanted.exists():
                wrongs.append("it says that it failed, and the dataset is visible")
            text = done.stderr.decode(errors="replace").strip()
            if done.returncode not in (1, 2, 75):  # 75: it may go well later
                wrongs.append(f"it died, {done.returncode}: {text}")
            elif not text.startswith("mote-prep: ") or "\n" in text:
                wrongs.append(f"no clear error: {text!r}")
            if list(self.folder.glob("wanted.mote.partial-*")) and "unlink" not in text:
                wrongs.append("the unfinished dataset is left")
        if done.returncode == 0 and not whole:
            wrongs.append("it says that all is well, and the dataset is not there")
        return wrongs

    def verifies(self):
        return subprocess.run([self.prep, "verify", self.wanted], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, check=False).returncode == 0


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--build", default="build/release", type=pathlib.Path)
    arguments.add_argument("--every", default=1, type=int, help="of calls of one kind, only every so many-th is hurt")
    arguments.add_argument("--most", default=0, type=int, help="so many faults at most, drawn by lot; 0: all")
    options = arguments.parse_args()
    if shutil.which("strace") is None:
        print("skipped: this machine has no strace")
        return 77
    faults = broken = visible = 0
    with tempfile.TemporaryDirectory(prefix="mote-faults-") as name:
        work = Work(pathlib.Path(name), (options.build / "bin/mote-prep").resolve())
        calls = strace_faults.calls_of(work.command(work.wanted), work.folder / "calls")
        plan = [(fault, call, k) for fault in FAULTS for call, k in strace_faults.places(calls, options.every)
                if not (fault.startswith("error") and call.startswith("unlink"))]
        if options.most:
            plan = random.Random(15).sample(plan, min(options.most, len(plan)))
        for fault, call, k in plan:
            work.clear()
            done = strace_faults.run_hurt(work.command(work.wanted), call, k, fault)
            faults += 1
            visible += work.wanted.exists()
            wrongs = work.wrongs(done, fault)
            broken += bool(wrongs)
            for wrong in wrongs:
                print(f"{fault} at {call} {k}: {wrong}")
        work.clear()
        subprocess.run(work.command(work.wanted), check=True)  # and it goes on
    print(f"{faults} faults at {sum(calls.values())} calls of {len(calls)} kinds: {visible} datasets whole, "
          f"0 partial ones visible" if not broken else f"{faults} faults, {broken} broke the promise")
    return 1 if broken or not faults else 0


if __name__ == "__main__":
    sys.exit(main())
