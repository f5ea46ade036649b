#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sessions that open, orbit a beam and leave, for long: what the server keeps of them.

    soak.py [--build build/release] [--minutes 30] [--sessions 8]

Between the rounds nobody is connected, and the memory, descriptors and threads of the process that serves are looked
at. The first fifth of the time warms it up; of the rest a line of least squares through the resident memory tells the
slope. Prints it and the ranges; exits 1 where it is above 1 MiB an hour, where descriptors or threads are not constant,
or where the server died.
"""
import argparse
import math
import pathlib
import sys
import tempfile
import threading
import time

import own_server
from own_server import mote

SLOPE = 1.0  # MiB an hour
PICTURES = 12


def orbit(server, errors):
    """One session, from its opening to its end."""
    try:
        with server.session() as session:
            dataset = session["data/beam"]
            box = mote.View(dataset, size=(320, 240))
            for picture in range(PICTURES):
                angle = 2 * math.pi * picture / PICTURES
                camera = {"eye": [3 * math.cos(angle), 3 * math.sin(angle), 1.5], "target": [0, 0, 0]}
                box.replace(camera=camera, step=picture % len(dataset)).render()
            dataset.statistics(0)
    except mote.Error as error:
        errors.append(str(error))


def round_of(server, count, errors):
    threads = [threading.Thread(target=orbit, args=(server, errors), daemon=True) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(300)
        if thread.is_alive():
            errors.append("a session hangs")


def settled(server, count):
    """How many descriptors or threads there are once nobody leaves any more."""
    for _ in range(100):
        before = server.count(count)
        time.sleep(0.02)
        if server.count(count) == before:
            break
    return before


def line_through(samples):
    """(slope, its standard error) by least squares through (x, y)."""
    n = len(samples)
    mean_x, mean_y = sum(x for x, _ in samples) / n, sum(y for _, y in samples) / n
    spread = sum((x - mean_x) ** 2 for x, _ in samples)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in samples) / spread
    left = sum((y - mean_y - slope * (x - mean_x)) ** 2 for x, y in samples)
    return slope, math.sqrt(left / max(n - 2, 1) / spread)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--sessions", type=int, default=8, help="at a time")
    options = parser.parse_args()
    samples, errors, rounds = [], [], 0
    with tempfile.TemporaryDirectory(prefix="mote-soak-") as name:
        folder = pathlib.Path(name).resolve()
        own_server.make_beam(options.build, folder / "data", 100000, 3)
        with own_server.OwnServer(options.build / "bin" / "mote-server", folder) as server:
            begin = time.monotonic()
            while time.monotonic() - begin < 60 * options.minutes and not server.is_hurt() and len(errors) < 20:
                round_of(server, options.sessions, errors)
                rounds += 1
                descriptors, threads = settled(server, "fd"), settled(server, "task")
                samples.append((time.monotonic() - begin, server.memory() / 1024, descriptors, threads))
            if server.is_hurt():
                errors.append("the server died")
    for error in errors[:20]:
        print(error)
    late = [sample for sample in samples if sample[0] > 12 * options.minutes]
    if len(late) < 10:
        print(f"only {len(late)} rounds after the warm-up: give it more time")
        return 1
    slope, uncertain = line_through([(seconds / 3600, memory) for seconds, memory, _, _ in late])
    print(f"{rounds} rounds of {options.sessions} sessions in {options.minutes:g} minutes, {len(errors)} errors")
    print(f"memory: {late[0][1]:.1f} MiB to {late[-1][1]:.1f} MiB, slope {slope:+.2f} +- {uncertain:.2f} MiB an hour")
    constant = True
    for number, kind in ((2, "descriptors"), (3, "threads")):
        found = [sample[number] for sample in late]
        print(f"{kind}: {min(found)} to {max(found)}")
        constant = constant and min(found) == max(found)
    return 0 if not errors and constant and slope <= SLOPE else 1


if __name__ == "__main__":
    sys.exit(main())
