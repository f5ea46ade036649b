#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What one of 16 clients that stops reading, or asks without end, costs the 15 others, and what is held for it.

    stalled_client.py [--build DIR] [--clients 16] [--pictures 60] [--flood]

Fifteen clients turn a volume, each at its own pace; the sixteenth does too, and then asks on and reads nothing: for
views, and for lists of jobs (--flood: as fast as its socket takes them). Prints p50 and p99 of the others without and
with it, by how much the server grew meanwhile, and which view the sixteenth sees when it reads again. Fails where the
others' p99 grew by more than a tenth, more than 8 MiB and two frames were held, or it saw more than what was on its
way and the newest.
"""
import argparse
import pathlib
import sys
import tempfile
import threading
import time

from clients import ROOT, Client, Server, make_volume, quantile, quick_times, summary, view_of

LARGE = (1920, 1080)  # of the one that stops


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


class Staller(threading.Thread):
    """Asks for view after view, and for jobs, and reads nothing."""

    def __init__(self, client, pause):
        super().__init__(daemon=True)
        self._client, self._pause = client, pause
        self.ending = threading.Event()
        self.asked = 0

    def run(self):
        while not self.ending.wait(self._pause):
            self.ask()

    def ask(self):
        if self._client.full:
            return
        self.asked += 1
        self._client.ask(self.asked, view_of(*LARGE, turn=0.02 * self.asked))
        if self.asked % 10 == 0:
            self._client.list_jobs()


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
            clients = [Client(server.file) for _ in range(options.clients)]
            others, one = clients[1:], clients[0]
            quick_times(one, 10, size=LARGE)
            all_times(others, 10, options.interval)
            alone = all_times(others, options.pictures, options.interval)
            before = server.memory()
            staller = Staller(one, 0.0005 if options.flood else 0.03)
            staller.start()
            time.sleep(1.0)
            beside = all_times(others, options.pictures, options.interval)
            grown = 1024 * (server.memory() - before)
            staller.ending.set()
            staller.join()
            seen = views_seen(one, staller.asked)
    print(summary(f"{len(others)} others alone", alone))
    print(summary("beside one that reads nothing", beside))
    print(f"it asked for {staller.asked} views; the server grew by {grown / 2**20:.1f} MiB")
    print(f"it reads again and sees views {', '.join(map(str, seen))}")
    ratio = quantile(beside, 0.99) / quantile(alone, 0.99)
    print(f"p99 beside over p99 alone: {ratio:.3f}")
    frame = LARGE[0] * LARGE[1] * 3
    return 0 if ratio <= 1.1 and grown <= 2 * frame + (8 << 20) and len(seen) <= 2 else 1


def views_seen(client, last):
    """What comes until the newest does: one that was on its way, and the newest."""
    seen = []
    while not seen or seen[-1] != last:
        frame = client.receive("frame")
        if frame.payload_begin == 0:
            seen.append(frame.view_id)
        client.credit()
    return seen


if __name__ == "__main__":
    sys.exit(main())
