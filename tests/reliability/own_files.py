#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Own files of every kind: every byte of small ones and every 4,093rd of large ones changed in 8 ways, and every length.

    own_files.py [--build build/release] [--every 1] [--questions 4000] [--jobs CORES] [--only NAME ...]

With the hashes as they were, and made anew; what is loaded of the latter is drawn, selected from or counted, one
question a change, and so is one error in eight. Then as many questions of each while its files are changed, cut off and put back in place. The work is
done by test-damage in pieces, a process each: one that dies or hangs is counted, with the change that it came to, and
the rest of its piece goes on. Prints for each dataset how many changes were errors, gave the same content or other
content, how many questions were answered, the slowest and the most memory; exits 1 where other content came without an
error though the hashes are old, a process died, or a change took 5 s.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import own_server

SMALL = ["particles", "hybrid", "hybridOfFlatPoints", "stippledPlane", "stippledSurface", "mesh", "image"]
LARGE = ["largeParticles", "largeHybrid", "largePlane", "largeSurface", "largeMesh", "largeImage"]
PIECE = 5000
LONGEST = 5.0  # seconds that a change may take
HANGS = 60.0  # without a step forward
WAYS = {"old": "hashes as they were", "anew": "hashes made anew", "rewritten": "rewritten meanwhile"}
COUNTED = ["tried", "errors", "same", "other", "asked", "answers"]
GREATEST = ["slowestRead", "slowestAnswer", "mostMemory"]


class Figures:
    """What came of a dataset in one way."""

    def __init__(self):
        self.numbers = dict.fromkeys(COUNTED + GREATEST, 0)
        self.deaths, self.wrongs = [], []

    def add(self, record):
        for name in COUNTED:
            self.numbers[name] += record[name]
        for name in GREATEST:
            self.numbers[name] = max(self.numbers[name], record[name])

    def hurt(self):
        slow = max(self.numbers["slowestRead"], self.numbers["slowestAnswer"]) >= LONGEST
        return bool(self.deaths or self.wrongs or slow)

    def __str__(self):
        return ("{tried} changes: {errors} errors, {same} the same, {other} other; {asked} questions: {answers} answered; "
                "slowest read {slowestRead:.3f} s, answer {slowestAnswer:.3f} s; at most {mostMemory} MiB; "
                ).format(**self.numbers) + f"{len(self.deaths)} deaths"


def step_of(record):
    """What a process has told last; nothing where it has not begun."""
    try:
        return json.loads(record.read_text())
    except (OSError, ValueError):
        return None


def await_end(process, record):
    """Waits as long as it comes forward; whether it hung."""
    before, since = None, time.monotonic()
    while True:
        try:
            process.wait(timeout=2)
            return False
        except subprocess.TimeoutExpired:
            now = step_of(record)
            if now != before:
                before, since = now, time.monotonic()
            elif time.monotonic() - since > HANGS:
                process.kill()
                process.wait()
                return True


def run(program, folder, sample, way, first, end):
    """One process: what it told last, what it printed, and whether it came to its end."""
    record = folder / f"{sample}-{way}-{first}"
    record.unlink(missing_ok=True)
    words = f"{sample} {way} {first} {end} {record}"
    with tempfile.TemporaryFile(dir=folder) as output:
        process = subprocess.Popen(
            [program, "--gtest_filter=OwnFiles.DISABLED_Piece", "--gtest_also_run_disabled_tests"], stdout=output,
            stderr=subprocess.STDOUT, env={**os.environ, "MOTE_OWN_FILES": words, "TMPDIR": str(folder)})
        hung = await_end(process, record)
        output.seek(0)
        text = output.read().decode(errors="replace")
    told = step_of(record)
    if told is None:
        raise SystemExit(f"{words}: it did not begin\n{text}")
    record.unlink()
    return told, text, "hung" if hung else process.returncode


def piece(program, folder, sample, way, first, end):
    """Figures of changes first to end; a death leaves out one."""
    figures = Figures()
    while first < end:
        told, text, code = run(program, folder, sample, way, first, end)
        figures.add(told)
        ended = told["next"] >= min(end, told["total"])
        if not ended:
            figures.deaths.append(f"{sample}, {WAYS[way]}: number {told['next']} ({code})\n{text[-2000:]}")
        elif code != 0:
            figures.wrongs.append(text)
        first = end if ended else told["next"] + 1
    return figures


def plan(program, folder, options):
    """(sample, way, first, end) of each piece."""
    for way in ("old", "anew"):
        for sample in SMALL + LARGE:
            if options.only and sample not in options.only:
                continue
            total = run(program, folder, sample, way, 0, 0)[0]["total"]
            for first in range(0, total, PIECE * options.every):
                yield sample, way, first, min(first + PIECE, total)
    for sample in SMALL:
        if not options.only or sample in options.only:
            for first in range(0, options.questions, PIECE):
                yield sample, "rewritten", first, min(first + PIECE, options.questions)


def join(figures, more):
    figures.add(more.numbers)
    figures.deaths += more.deaths
    figures.wrongs += more.wrongs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--every", type=int, default=1, help=f"of pieces of {PIECE} changes, so many-th ones alone")
    parser.add_argument("--questions", type=int, default=4000, help="of each dataset while it is rewritten")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--only", nargs="*", default=[], help="these datasets: " + ", ".join(SMALL + LARGE))
    options = parser.parse_args()
    program = options.build / "tests" / "test-damage"
    all_figures, begun = {}, time.monotonic()
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # files are written a million times
    with tempfile.TemporaryDirectory(prefix="mote-own-files-", dir=memory) as name:
        folder = pathlib.Path(name)
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            pieces = {pool.submit(piece, program, folder, *what): what for what in plan(program, folder, options)}
            for done in concurrent.futures.as_completed(pieces):
                sample, way, first, _ = pieces[done]
                print(f"{sample}, {WAYS[way]}, from {first}: {done.result()}", flush=True)
                join(all_figures.setdefault((way, sample), Figures()), done.result())
    total = Figures()
    for (way, sample), figures in sorted(all_figures.items()):
        print(f"{sample}, {WAYS[way]}: {figures}")
        join(total, figures)
    for text in (total.deaths + total.wrongs)[:20]:
        print(text)
    wrong = sum(figures.numbers["other"] for (way, _), figures in all_figures.items() if way == "old")
    print(f"{total}; {wrong} other contents without an error where hashes are old; {time.monotonic() - begun:.0f} s")
    return 1 if wrong or total.hurt() else 0


if __name__ == "__main__":
    sys.exit(main())
