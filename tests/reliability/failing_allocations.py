#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-prep without memory: its k-th allocation fails, of each kind of job, or all from the k-th on.

    failing_allocations.py [--build build/release] [--most 200] [--only KIND ...]

Half of the k lie evenly from the first allocation to the last, half closer together at the begin. Whatever fails, a
dataset is there whole or not at all, what was there before is as it was, and either all is well, as of a library that
goes on without, or there is an exit code and, as the last line, a sentence. Prints how many faults there were, how many
were survived, and which libraries ended the process themselves; exits 1 where anything broke. Of the server:
failing_server_allocations.py.
"""
import argparse
import collections
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

import failing
from kill_prep_everywhere import digest

MANY = {"one": 1, "all": 1 << 40}
EDGE = 16  # of the volume and the picture


def picture():
    """A grey PNG."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(16 * (x ^ y) for x in range(EDGE)) for y in range(EDGE))
    head = struct.pack(">IIBBBBB", EDGE, EDGE, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def make_inputs(folder):
    cells = [(x, y, z) for z in range(EDGE) for y in range(EDGE) for x in range(EDGE)]
    (folder / "ball.raw").write_bytes(bytes((x * x + y * y + z * z) % 251 for x, y, z in cells))
    (folder / "corner.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
                                       encoding="ascii")
    (folder / "picture.png").write_bytes(picture())


KINDS = {
    "synth": "synth beam --particles 200 --steps 1 --seed 1 --quiet --out wanted.h5",
    "particles": "particles run.h5 --axes x,px,y --threads 1 --memory 200M --quiet --out wanted.mote",
    "volume": "volume ball.raw --dimensions 16 16 16 --low 8 --threshold 0.05 --threads 1 --quiet --out wanted.mote",
    "mesh": "mesh corner.obj --threads 1 --quiet --out wanted.mote",
    "surface": "mesh ball.raw --dimensions 16 16 16 --isovalue 100 --threads 1 --quiet --out wanted.mote",
    "image": "image picture.png --threads 1 --quiet --out wanted.mote",
    "stipple": "stipple plane --points 200 --threads 1 --quiet --out wanted.mote",
    "export": "export before.mote --openpmd wanted.h5 --threads 1 --quiet",
    "info": "info before.mote",
    "verify": "verify before.mote",
}


class Work:
    """A folder with inputs and a dataset that was there before."""

    def __init__(self, folder, prep, preloaded):
        self.folder, self.prep, self.preloaded = folder, prep, preloaded
        make_inputs(folder)
        self.call("synth beam --particles 200 --steps 1 --seed 1 --quiet --out run.h5")
        self.call("particles run.h5 --axes x,px,y --quiet --out before.mote")
        self.digest = digest(folder / "before.mote")

    def call(self, words):
        subprocess.run([self.prep, *words.split()], cwd=self.folder, check=True, stdout=subprocess.DEVNULL)

    def run(self, kind, **fields):
        """A run of that kind, from a clean place: (what came of it, its order)."""
        for path in self.folder.glob("wanted*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        order = failing.Order(self.folder / "order", **fields)
        done = subprocess.run([self.prep, *KINDS[kind].split()], cwd=self.folder, check=False, capture_output=True,
                              env=order.environment(self.preloaded, "mote-prep"))
        return done, order

    def whole(self, wanted):
        """A dataset says so itself; a file is as large as one that was made well."""
        if wanted.suffix != ".mote":
            return wanted.stat().st_size == self.size
        return subprocess.run([self.prep, "verify", wanted], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              check=False).returncode == 0

    def measure(self, kind):
        """The number of allocations of a run that goes well."""
        done, order = self.run(kind)
        if done.returncode != 0:
            raise RuntimeError(f"{kind} does not go well: {done.stderr.decode()}")
        self.output = done.stdout
        self.wanted = [path for path in self.folder.glob("wanted*")]
        self.size = sum(path.stat().st_size for path in self.wanted)
        return order["count"]

    def wrongs(self, done, many):
        """What is not as it should be after a fault, but for deaths.

        Without any memory a draft may stay: others sweep it.
        """
        if digest(self.folder / "before.mote") != self.digest:
            yield "the dataset that was there before is another"
        left = sorted(self.folder.glob("wanted*"))
        there = [path for path in left if path in self.wanted]
        if there and not self.whole(there[0]):
            yield "an output is visible that is not whole"
        if done.returncode == 0 and self.wanted and not there:
            yield "it says that all is well, and its output is not there"
        if done.returncode == 0 and done.stdout != self.output:
            yield f"it says that all is well, and says something else: {done.stdout!r}"
        if done.returncode > 0 and not died(done):
            text = done.stderr.decode(errors="replace").strip()
            # Libraries may say something before it; the last line is what a job's error is.
            if done.returncode not in (1, 2, 75) or not text.rpartition("\n")[2].startswith("mote-prep: "):
                yield f"no clear error, {done.returncode}: {text!r}"
            if there:
                yield "it says that it failed, and the output is visible"
            if left != there and many == "one":
                yield f"left: {[path.name for path in left]}"


def died(done):
    """Of a signal, or of a library's exit() without a word."""
    return done.returncode < 0 or (done.returncode > 0 and not done.stderr.strip())


class Verdict:
    """What came of all faults."""

    def __init__(self):
        self.faults = self.survived = self.broken = 0
        self.ends = collections.Counter()  # by library: how often it ended the process itself

    def add(self, name, done, order, wrongs):
        self.faults += 1
        self.survived += done.returncode == 0
        ended = order.ended_by() if died(done) else None
        if ended:
            self.ends[ended] += 1
        elif died(done):
            wrongs.append(f"it died, {done.returncode}: {done.stderr.decode(errors='replace').strip()!r}")
            wrongs.append(f"at {order.text()}")
        self.broken += bool(wrongs)
        for wrong in wrongs:
            print(f"{name}: {wrong}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default="build/release", type=pathlib.Path)
    parser.add_argument("--most", default=200, type=int, help="so many k of each kind of job")
    parser.add_argument("--only", nargs="+", choices=KINDS, default=list(KINDS), metavar="KIND")
    options = parser.parse_args()
    preloaded = failing.preload(options.build)
    if preloaded is None:
        print("skipped: the tests were not built, or with a sanitizer, which has its own malloc")
        return 77
    verdict = Verdict()
    with tempfile.TemporaryDirectory(prefix="mote-memory-") as name:
        work = Work(pathlib.Path(name), (options.build / "bin/mote-prep").resolve(), preloaded)
        for kind in options.only:
            count = work.measure(kind)
            for many, allocations in MANY.items():
                for k in failing.places(count, options.most):
                    done, order = work.run(kind, first=k, many=allocations)
                    if order["failed"]:  # from run to run there are some more or less
                        verdict.add(f"{kind}, {many} from {k} of {count}", done, order, list(work.wrongs(done, many)))
            print(f"{kind}: {count} allocations; so far {verdict.faults} faults, {verdict.broken} broke", flush=True)
    print(f"{verdict.faults} faults, {verdict.survived} survived, {sum(verdict.ends.values())} ended by a library "
          f"({dict(verdict.ends)}): {verdict.broken} broke the promise")
    return 1 if verdict.broken or not verdict.faults else 0


if __name__ == "__main__":
    sys.exit(main())
