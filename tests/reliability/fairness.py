#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What one client that asks for exact pictures of 8192 x 4096, one after the other, costs another's quick ones.

    fairness.py [--build DIR] [--kind hybrid] [--pictures 500] [--width 8192] [--height 4096] [--interval 0.033]

A server draws on all processors: quick pictures of 640 x 480 for a client that turns a hybrid volume, first alone, then
beside another that wants large exact ones, of the same volume or of another kind: particles; ink (a surface of the
volume, hatched); stipple (the volume, in dots); surface. Prints p50 and p99 of the quick ones, how many large ones were
done meanwhile and how long one takes alone and beside. Fails where p99 is more than three times that alone, or no large
one was done.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

from clients import ROOT, Client, Server, make_volume, quantile, quick_times, summary, view_of


EDGE = 128  # of the volume


def prepare(programs, *command):
    subprocess.run([programs / "mote-prep", *map(str, command), "--quiet"], check=True, stdout=subprocess.DEVNULL)


def make_particles(programs, folder):
    prepare(programs, "synth", "beam", "--particles", 1000000, "--steps", 1, "--seed", 1, "--out", folder / "run.h5")
    prepare(programs, "particles", folder / "run.h5", "--axes", "x,px,y", "--out", folder / "data" / "beam.mote")


def make_surface(programs, folder):
    prepare(programs, "mesh", folder / "field.raw", "--dimensions", *3 * [EDGE], "--isovalue", 90, "--out",
            folder / "data" / "skin.mote")


def make_dots(programs, folder):
    prepare(programs, "stipple", "plane", "--points", 10000, "--out", folder / "data" / "plane.mote")


VOLUME = {"dataset": "data/field", "hybrid": {}}
# What a kind is made of beside the volume, and the layers of its large pictures.
KINDS = {
    "hybrid": (None, [VOLUME]),
    "particles": (make_particles, [{"dataset": "data/beam", "particles": {}}]),
    "ink": (make_surface, [{"dataset": "data/skin", "ink": {"hatch": {"strength": 1}}}]),
    "stipple": (make_dots, [VOLUME, {"dataset": "data/plane", "stipple": {"source": "layers"}}]),
    "surface": (make_surface, [{"dataset": "data/skin", "mesh": {}}]),
}


def large_view(kind, size, number):
    """Of what is no volume, from where all of it is seen."""
    view = view_of(*size, turn=0.1 * number)
    view["layers"] = KINDS[kind][1]
    if VOLUME not in view["layers"]:
        del view["camera"]
    return view


class Greedy(threading.Thread):
    """Asks for one large picture after another until it is told to end."""

    def __init__(self, file, kind, size):
        super().__init__(daemon=True)
        self._client, self._kind, self._size = Client(file), kind, size
        self.ending = threading.Event()
        self.times = []

    def draw(self):
        number = len(self.times) + 1
        begin = time.perf_counter()
        self._client.ask(number, large_view(self._kind, self._size, number), final_only=True)
        frame = self._client.picture(number)
        assert frame.final and frame.width == self._size[0]
        self.times.append(time.perf_counter() - begin)

    def run(self):
        try:
            while not self.ending.is_set():
                self.draw()
        except RuntimeError:
            if not self.ending.is_set():
                raise


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--kind", choices=KINDS, default="hybrid", help="of the large pictures")
    parser.add_argument("--pictures", type=int, default=500)
    parser.add_argument("--width", type=int, default=8192)
    parser.add_argument("--height", type=int, default=4096)
    parser.add_argument("--interval", type=float, default=0.033, help="seconds from one quick picture to the next")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_volume(options.build / "bin", folder, EDGE)
        if KINDS[options.kind][0]:
            KINDS[options.kind][0](options.build / "bin", folder)
        with Server(options.build / "bin", folder) as server:
            hand = Client(server.file)
            quick_times(hand, 50)
            alone = quick_times(hand, options.pictures, interval=options.interval)
            greedy = Greedy(server.file, options.kind, (options.width, options.height))
            greedy.draw()
            large_alone = greedy.times.pop()
            greedy.start()
            beside, begin = [], time.perf_counter()
            # At least one large picture must be done beside.
            while len(beside) < options.pictures or (not greedy.times and time.perf_counter() - begin < 600):
                beside += quick_times(hand, 50, interval=options.interval)
            done, took = len(greedy.times), time.perf_counter() - begin
            greedy.ending.set()
    print(summary("alone", alone))
    print(summary(f"beside exact {options.width} x {options.height} of kind {options.kind}", beside))
    print(f"{done} large pictures in {took:.1f} s; one alone takes {large_alone:.1f} s")
    ratio = quantile(beside, 0.99) / quantile(alone, 0.99)
    print(f"p99 beside over p99 alone: {ratio:.2f}")
    return 0 if ratio <= 3.0 and done > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
