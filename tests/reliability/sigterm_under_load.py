#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""SIGTERM while clients ask for pictures and jobs run and wait.

    sigterm_under_load.py [--build build/release] [--clients 16] [--rounds 5]

Each client hears that the server ends and why; nobody is let in any more; the exit code is 0 within 10 s. The jobs are
there again in the next server: the one that ran goes on or is done, those that waited are run. Prints the longest end
and what broke; exits 1 where anything did.
"""
import argparse
import pathlib
import sys
import tempfile
import threading
import time

import own_server
from own_server import mote

END_S = 10.0


class Client(threading.Thread):
    """Asks for one picture after another until it hears the end."""

    def __init__(self, server, number, busy):
        super().__init__(daemon=True)
        self._server, self._number, self._busy = server, number, busy
        self.error, self.pictures = None, 0

    def run(self):
        try:
            with self._server.session() as session:
                view = mote.View(session["data/beam"], size=(320, 240))
                while True:
                    # Another picture each time, that nothing is kept of.
                    view.replace(background=[self._number / 100, self.pictures % 100 / 100, 0.5]).render()
                    self.pictures += 1
                    if self.pictures == 2:
                        self._busy.release()
        except mote.Error as error:
            self.error = error
            if self.pictures < 2:
                self._busy.release()


class Knocker(threading.Thread):
    """Asks to be let in, again and again, until the server is gone; counts who was let in after the signal."""

    def __init__(self, server):
        super().__init__(daemon=True)
        self._server = server
        self.signalled, self.gone = threading.Event(), threading.Event()
        self.entered = 0

    def run(self):
        while not self.gone.is_set():
            try:
                late = self.signalled.is_set()
                with self._server.session() as session:
                    session.ping()
                self.entered += late
            except mote.Error:
                pass


def submit(session, number):
    return session.prepare("data/large.h5", axes=["x", "px", "y"], output=f"data/made-{number}.mote").id


def end_once(server, clients):
    """(seconds, code, wrongs, ids of jobs)."""
    with server.session() as session:
        jobs = [submit(session, number) for number in range(4)]
        session.connection.wait_for(lambda: session.job(jobs[0]).state != "queued", 60)
    busy = threading.Semaphore(0)
    crowd = [Client(server, number, busy) for number in range(clients)]
    for client in crowd:
        client.start()
    for _ in crowd:
        busy.acquire(timeout=120)
    knocker = Knocker(server)
    knocker.start()
    begin = time.perf_counter()
    knocker.signalled.set()
    code = server.end(END_S * 3)
    seconds = time.perf_counter() - begin
    knocker.gone.set()
    knocker.join(60)
    wrongs = []
    for client in crowd:
        client.join(60)
        error = client.error
        if error is None or error.code != "cancelled" or error.where != "server":
            wrongs.append(f"a client that had {client.pictures} pictures heard: {error}")
    # One may have been let in between the signal's sending and its arrival.
    if knocker.entered > 1:
        wrongs.append(f"{knocker.entered} sessions were let in after the signal")
    return seconds, code, wrongs, jobs


def judge_jobs(build, folder, jobs):
    wrongs = []
    with own_server.OwnServer(build / "bin" / "mote-server", folder) as server, server.session() as session:
        known = {job.id: job for job in session.jobs}
        for identity in jobs:
            if identity not in known:
                wrongs.append(f"job {identity} is lost")
                continue
            job = known[identity]
            try:
                job.wait(timeout=120, progress=False)
            except mote.Error as error:
                wrongs.append(f"job {identity}: {error}")
            if job.interrupted:
                wrongs.append(f"job {identity} did not live on: it was interrupted")
    return wrongs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--clients", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--particles", type=int, default=1000000, help="of the run that jobs read")
    options = parser.parse_args()
    longest, wrongs = 0.0, []
    for number in range(options.rounds):
        with tempfile.TemporaryDirectory(prefix="mote-end-") as name:
            folder = pathlib.Path(name).resolve()
            own_server.make_beam(options.build, folder / "large", options.particles)
            own_server.make_beam(options.build, folder / "data", 20000)
            (folder / "large" / "run.h5").rename(folder / "data" / "large.h5")
            with own_server.OwnServer(options.build / "bin" / "mote-server", folder) as server:
                seconds, code, wrong, jobs = end_once(server, options.clients)
            longest = max(longest, seconds)
            if code != 0:
                wrong.append(f"the exit code is {code}")
            if seconds > END_S:
                wrong.append(f"it took {seconds:.1f} s")
            wrong += judge_jobs(options.build, folder, jobs)
            for sentence in wrong:
                print(f"round {number + 1}: {sentence}", flush=True)
            wrongs += wrong
    print(f"{options.rounds} ends under {options.clients} clients and 4 jobs: the longest took {longest:.2f} s; "
          f"{len(wrongs)} promises broken")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
