#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What one client that asks for exact pictures of 8192 x 4096, one after the other, costs another's quick ones.

    fairness.py [--build DIR] [--pictures 500] [--width 8192] [--height 4096] [--interval 0.033]

A server draws a hybrid volume on all processors: quick pictures of 640 x 480 for a client that turns it, first alone,
then beside another that wants large exact ones. Prints p50 and p99 of the quick ones, how many large ones were done
meanwhile and how long one takes alone and beside. Fails where p99 is more than three times that alone, or no large one
was done.
"""
import argparse
import pathlib
import sys
import tempfile
import threading
import time

from clients import ROOT, Client, Server, make_volume, quantile, quick_times, summary, view_of


class Greedy(threading.Thread):
    """Asks for one large picture after another until it is told to end."""

    def __init__(self, file, size):
        super().__init__(daemon=True)
        self._client, self._size = Client(file), size
        self.ending = threading.Event()
        self.times = []

    def draw(self):
        number = len(self.times) + 1
        begin = time.perf_counter()
        self._client.ask(number, view_of(*self._size, turn=0.1 * number), final_only=True)
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
    parser.add_argument("--pictures", type=int, default=500)
    parser.add_argument("--width", type=int, default=8192)
    parser.add_argument("--height", type=int, default=4096)
    parser.add_argument("--interval", type=float, default=0.033, help="seconds from one quick picture to the next")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_volume(options.build / "bin", folder)
        with Server(options.build / "bin", folder) as server:
            hand = Client(server.file)
            quick_times(hand, 50)
            alone = quick_times(hand, options.pictures, interval=options.interval)
            greedy = Greedy(server.file, (options.width, options.height))
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
    print(summary(f"beside exact {options.width} x {options.height}", beside))
    print(f"{done} large pictures in {took:.1f} s; one alone takes {large_alone:.1f} s")
    ratio = quantile(beside, 0.99) / quantile(alone, 0.99)
    print(f"p99 beside over p99 alone: {ratio:.2f}")
    return 0 if ratio <= 3.0 and done > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
