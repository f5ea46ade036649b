#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What one of 16 clients that stops reading, or asks without end, costs the 15 others, and what is held for it.

    stalled_client.py [--build DIR] [--clients 16] [--pictures 60] [--flood]

Fifteen clients turn a volume, each at its own pace; the sixteenth does too, and then asks on and reads nothing: for
views, and for lists of jobs (--flood: as fast as its socket takes them). Prints p50 and p99 of the others without and
with it, by how much the server grew meanwhile, and which views the sixteenth sees when it reads again. Fails where the
others' p99 grew by more than a tenth, more than 8 MiB and two frames were held, or it saw more than the two frames that
it had credit for and the newest.
"""
import argparse
import multiprocessing
import pathlib
import sys
import tempfile
import threading
import time

from clients import ROOT, Client, Server, make_volume, quantile, quick_times, summary, view_of

LARGE = (1920, 1080)  # of the one that stops
CREDITS = 2  # frames that are on their way to who returns none


def all_times(clients, count, interval):
    """Of so many pictures of each client, at once."""
    times = []

    def one(client):
        times.extend(quick_times(client, count, size=(160, 120), interval=interval))

    threads = [threading.Thread(target=one, args=(client,)) for client in clients]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return times


def stall(file, pause, started, ending, seen):
    """A process of its own: draws a while, then asks for view after view, and for jobs, and reads nothing until it ends."""
    client = Client(file)
    quick_times(client, 10, size=LARGE)
    started.set()
    asked = 0
    while not ending.wait(pause):
        if client.full:
            continue
        asked += 1
        client.ask(asked, view_of(*LARGE, turn=0.02 * asked))
        if asked % 10 == 0:
            client.list_jobs()
    seen.put((asked, views_seen(client, asked)))


def views_seen(client, last):
    """What comes until the newest does."""
    seen = []
    while not seen or seen[-1] != last:
        frame = client.receive("frame")
        if frame.payload_begin == 0:
            seen.append(frame.view_id)
        client.credit()
    return seen


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--clients", type=int, default=16)
    parser.add_argument("--pictures", type=int, default=60)
    parser.add_argument("--interval", type=float, default=0.25, help="seconds from one picture of a client to the next")
    parser.add_argument("--flood", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_volume(options.build / "bin", folder)
        with Server(options.build / "bin", folder) as server:
            others = [Client(server.file) for _ in range(options.clients - 1)]
            all_times(others, 10, options.interval)
            alone = all_times(others, options.pictures, options.interval)
            context = multiprocessing.get_context("spawn")
            started, ending, told = context.Event(), context.Event(), context.SimpleQueue()
            one = context.Process(target=stall, args=(server.file, 0.0005 if options.flood else 0.03, started, ending, told))
            one.start()
            started.wait()
            before = server.memory() * 1024
            time.sleep(1.0)
            beside = all_times(others, options.pictures, options.interval)
            grown = server.memory() * 1024 - before
            ending.set()
            asked, seen = told.get()
            one.join()
    print(summary(f"{len(others)} others alone", alone))
    print(summary("beside one that reads nothing", beside))
    print(f"it asked for {asked} views; the server grew by {grown / 2**20:.1f} MiB")
    print(f"it reads again and sees views {', '.join(map(str, seen))}")
    ratio = quantile(beside, 0.99) / quantile(alone, 0.99)
    print(f"p99 beside over p99 alone: {ratio:.3f}")
    frame = LARGE[0] * LARGE[1] * 3
    held = grown <= CREDITS * frame + (8 << 20)
    return 0 if ratio <= 1.1 and held and len(seen) <= CREDITS + 1 else 1


if __name__ == "__main__":
    sys.exit(main())
