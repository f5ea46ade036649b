#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What 1,000 connections that show no token, renewed for ever, cost those who have shown one.

    half_open.py [--build DIR] [--connections 1000] [--rounds 6] [--pictures 150]

A server on TCP with TLS draws small pictures for one client, as fast as it asks, in turns without and with the
strangers. Prints how long a picture takes with and without them, how long a newcomer needs to be let in among them, and
how many it asked in vain. Fails where pictures take more than a tenth longer (median), or a newcomer stays out.
"""
import argparse
import multiprocessing
import pathlib
import select
import socket
import statistics
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "client" / "python"), str(ROOT / "tests" / "python")]

import mote  # noqa: E402
from tls_server import TlsServer  # noqa: E402


def keep_half_open(place, count, on, opened):
    """While `on` is set: so many connections that say nothing; each that is closed is opened again."""
    while True:
        on.wait()
        poll, lines = select.poll(), {}

        def renew():
            line = socket.socket()
            line.setblocking(False)
            line.connect_ex(place)
            lines[line.fileno()] = line
            poll.register(line, select.POLLIN)
            opened.value += 1

        for _ in range(count):
            renew()
        while on.is_set():
            for descriptor, _ in poll.poll(50):
                poll.unregister(descriptor)
                lines.pop(descriptor).close()
                renew()
        for line in lines.values():
            line.close()


def picture_times(session, count):
    """Seconds that each of so many pictures took."""
    times = []
    for number in range(count):
        view = session.view({"width": 320, "height": 240, "background": [number / count, 0.5, 0.5]})
        begin = time.perf_counter()
        view.render()
        times.append(time.perf_counter() - begin)
    return times


def enter(file):
    """Seconds until a newcomer is let in, and how often it was refused before."""
    begin, refused = time.perf_counter(), 0
    while time.perf_counter() - begin < 60:
        try:
            mote.connect(file).close()
            return time.perf_counter() - begin, refused
        except mote.Error as error:
            if error.code not in ("resource_exhausted", "internal"):
                raise
            refused += 1
    return float("inf"), refused


def measure(server, options):
    """Seconds a picture without and with strangers, and what newcomers met."""
    on, opened = multiprocessing.Event(), multiprocessing.Value("q", 0, lock=False)
    strangers = multiprocessing.Process(target=keep_half_open, args=(server.place, options.connections, on, opened),
                                        daemon=True)
    strangers.start()
    alone, beside, entries = [], [], []
    try:
        with mote.connect(server.file) as session:
            picture_times(session, 20)
            for _ in range(options.rounds):
                alone += picture_times(session, options.pictures)
                on.set()
                entries.append(enter(server.file))  # and the strangers are all there by then
                beside += picture_times(session, options.pictures)
                entries.append(enter(server.file))
                on.clear()
    finally:
        strangers.terminate()
        strangers.join()
    return alone, beside, entries, opened.value


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--connections", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--pictures", type=int, default=150)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, TlsServer(options.build / "bin" / "mote-server", folder) as server:
        alone, beside, entries, opened = measure(server, options)
    for name, times in (("alone", alone), (f"beside {options.connections} half-open", beside)):
        times.sort()
        print(f"{name}: {len(times)} pictures, p50 {1000 * statistics.median(times):.2f} ms, "
              f"p99 {1000 * times[int(0.99 * (len(times) - 1))]:.2f} ms")
    ratio = statistics.median(beside) / statistics.median(alone)
    longest, refused = max(seconds for seconds, _ in entries), sum(times for _, times in entries)
    print(f"p50 beside them over p50 alone: {ratio:.3f}; {opened} connections were opened")
    print(f"{len(entries)} newcomers among them: the slowest was in after {longest:.2f} s; {refused} refusals in all")
    return 0 if ratio <= 1.1 and longest < 60 else 1


if __name__ == "__main__":
    sys.exit(main())
