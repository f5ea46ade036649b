#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-server without memory: the k-th allocation of the process that serves fails, and some after it, in a session.

    failing_server_allocations.py [--build build/release] [--most 200] [--many 1 4 64]

The session lists, draws a picture, submits a job and lists jobs; of `--many` each says how many allocations fail in a
row. Each wish is answered by an error or rightly, and the next session has all that it asks for. Where little is asked
for and not found the process ends, and the supervisor starts another. The supervisor of a job is hurt likewise, in the job's first run: the job is run again. At last all is started anew: a job that was told is
there, and none ran beside itself or more often than it was interrupted and once. Prints how many faults there were, how
often the server died and of whom, and how many broke the promise; exits 1 where any did.
"""
import argparse
import collections
import pathlib
import sys
import tempfile
import threading
import time

import failing
import kill_server_everywhere
import own_server
from kill_server_everywhere import Place

mote = own_server.mote

PATIENCE_S = 20.0
RESTART_S = 5.0


def picture(session):
    view = mote.View(session["data/beam"], size=(64, 48))
    return view.render().array.tobytes()


class Wishes:
    """Of one session: each is answered in time, rightly or by an error."""

    def __init__(self, wrongs):
        self._wrongs = wrongs
        self._silent = False

    def __call__(self, name, function):
        """The answer; None where it is an error, or where none came to this or an earlier wish."""
        answers = []

        def ask():
            try:
                answers.append(function())
            except mote.Error as error:
                answers.append(None)
                if "\n" in str(error):
                    self._wrongs.append(f"{name}: no sentence: {error}")
        if self._silent:
            return None
        asking = threading.Thread(target=ask, daemon=True)
        asking.start()
        asking.join(PATIENCE_S)
        if not answers:
            self._silent = True
            self._wrongs.append(f"{name}: no answer")
            return None
        return answers[0]


class Run:
    """A server that is hurt again and again, and what it told."""

    def __init__(self, place, preloaded):
        self.place, self.here, self.told = place, place.fresh(), {}
        (place.folder / "source" / "beam.mote").rename(self.here / "data" / "beam.mote")
        self.order = failing.Order(place.folder / "order")
        self.environment = self.order.environment(preloaded, "mote-server")
        self.preloaded = preloaded
        self.sessions = self.deaths = 0
        self.right = None
        self.hurt_jobs = set()  # whose supervisors were

    def start(self):
        self.order["first"] = 0
        self.server = own_server.OwnServer(self.place.bin / "mote-server", self.here, env=self.environment)
        self.order["process"] = self.server.serving
        with self.server.session() as session:
            self.right = picture(session)

    def session(self, wrongs):
        """All wishes of one session; a job that was told is kept in mind."""
        self.sessions += 1
        wish = Wishes(wrongs)
        session = wish("connect", self.server.session)
        if session is None:
            return
        wish("list", lambda: session.datasets)
        if wish("view", lambda: picture(session)) not in (None, self.right):
            wrongs.append("view: another picture than is right")
        output = f"data/{self.sessions}.mote"
        job = wish("submit", lambda: session.prepare("data/run.h5", axes=["x", "px", "y"], output=output))
        wish("jobs", lambda: session.jobs)
        if job is not None and self.sessions % 8 == 0:  # the end of each takes its time
            session.connection.wait_for(lambda: job.finished, PATIENCE_S)
            if not job.finished and not session.connection.lost:
                wrongs.append(f"job {job.id} does not end: it is {job.state}, {job.phase} {job.waits_for}")
        self.told.update(session.connection.jobs)
        session.close()

    def hurt(self, first, many):
        """(faults, what is wrong, who ended the server)."""
        order, wrongs, ended = self.order, [], None
        order.forget()
        order["many"], order["first"] = many, first
        self.session(wrongs)
        order["first"] = 0
        failed = order["failed"]
        session = self.next_session()
        if self.server.is_hurt():
            self.deaths += 1
            ended = order.ended_by() or "mote-server"
        if session is None:
            wrongs.append(f"there is no next session; the supervisor: {self.server.process.poll()}")
            self.server.kill()
            self.start()
            return failed, wrongs, ended
        self.server.follow()
        order["process"] = self.server.serving
        wish = Wishes(wrongs)
        if wish("the next view", lambda: picture(session)) != self.right:
            wrongs.append("the next session sees another picture, or none")
        if not wish("the next list", lambda: session.datasets):
            wrongs.append("the next session sees no datasets")
        session.close()
        return failed, wrongs, ended

    def next_session(self):
        """The supervisor may be about to start another server; None where there is none in time."""
        end = time.monotonic() + RESTART_S
        while self.server.process.poll() is None and time.monotonic() < end:
            try:
                return self.server.session()
            except mote.Error:
                time.sleep(0.05)
        return None

    def settle(self):
        """Waits for the jobs of all sessions before: their supervisors are not to be hurt, nor counted."""
        with self.server.session() as session:
            for job in session.jobs:
                kill_server_everywhere.follow(self.server, job)

    def hurt_supervisor(self, first, many):
        """Of a job, in its first run: (allocations, faults, what is wrong, who ended its program)."""
        order, wrongs = failing.Order(self.place.folder / "job-order", first=first, many=many), []
        self.place.hurt_jobs(f"env LD_PRELOAD={self.preloaded} MOTE_FAIL_PROGRAM=mote-supervise "
                             f"MOTE_FAIL_ORDER={order.file}")
        self.sessions += 1
        with self.server.session() as session:
            job = kill_server_everywhere.submit(session, self.sessions)
            kill_server_everywhere.follow(self.server, job)
            ended = None
            if job.state != "succeeded" and order["failed"] and not order.text():
                ended = "libseccomp"  # no trace can be written any more: it makes the filter, and dies or turns round
                job.cancel()
                kill_server_everywhere.follow(self.server, job)
            elif job.state != "succeeded":
                wrongs.append(f"its job is {job.state}: {job.error or job.waits_for}")
            self.told.update(session.connection.jobs)
            if order["failed"]:
                self.hurt_jobs.add(job.id)
        if self.server.is_hurt():
            wrongs.append("the server died of a job's supervisor")
        self.place.hurt_jobs("")
        return order["count"], order["failed"], wrongs, ended

    def judge(self):
        """Of the jobs, after all faults: the server is killed and started again without the library."""
        self.server.kill()
        del self.order
        wrongs = kill_server_everywhere.judge(self.place, self.here, self.told, kill_server_everywhere.Verdict(),
                                              places_fault=False)
        # A job whose supervisor was hurt was not interrupted: it is run again as after any fault of the place.
        again = tuple(f"job {identity} ran 2 times and was interrupted 0 times" for identity in self.hurt_jobs)
        return [wrong for wrong in wrongs if wrong not in again]


class Tally:
    """Of all faults."""

    def __init__(self):
        self.faults = self.broken = 0
        self.ends = collections.Counter()  # of the server and of jobs' programs, by who ended them

    def add(self, name, failed, wrongs, ended=None):
        self.faults += failed > 0
        self.broken += bool(wrongs)
        if ended:
            self.ends[ended] += 1
        for wrong in wrongs:
            print(f"{name}: {wrong}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--most", default=200, type=int, help="so many k of each number of failures in a row")
    parser.add_argument("--many", nargs="+", type=int, default=[1, 4, 64])
    options = parser.parse_args()
    preloaded = failing.preload(options.build)
    if preloaded is None:
        print("skipped: the tests were not built, or with a sanitizer, which has its own malloc")
        return 77
    tally = Tally()
    with tempfile.TemporaryDirectory(prefix="mote-memory-") as name:
        run = Run(Place(pathlib.Path(name).resolve(), options.build), preloaded)
        run.start()
        run.hurt(0, 0)  # what is done at first only
        run.hurt(0, 0)
        count = run.order["count"]
        for many in options.many:
            for k in failing.places(count, options.most):
                failed, wrongs, ended = run.hurt(k, many)
                tally.add(f"{many} from {k} of {count}", failed, wrongs, ended)
            print(f"{many} in a row: so far {tally.faults} faults, {run.deaths} deaths, {tally.broken} broke",
                  flush=True)
        run.settle()
        of_supervisor, _, _, _ = run.hurt_supervisor(0, 0)
        for many in (1, 1 << 40):
            for k in failing.places(of_supervisor, max(options.most // 4, 4)):
                _, failed, wrongs, ended = run.hurt_supervisor(k, many)
                which = "one" if many == 1 else "all"
                tally.add(f"a job's supervisor, {which} from {k} of {of_supervisor}", failed, wrongs, ended)
        tally.add("at last", 0, run.judge())
    print(f"{tally.faults} faults at {count} allocations of a session and {of_supervisor} of a job's supervisor, "
          f"{run.deaths} deaths of the server (ended: {dict(tally.ends)}), {len(run.told)} jobs told: {tally.broken} "
          f"broke the promise")
    return 1 if tally.broken or not tally.faults else 0


if __name__ == "__main__":
    sys.exit(main())
