#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts the line of a session at every message of either side: it is back, as it was, within 1 s and two round trips.

    cut_line.py [--build build/release] [--cuts 500] [--films 40] [--tls] [--delay 0]

Python's client says a bit of everything (varied_session.py), and its line is cut after each message in turn, then in
the midst of each, then again while it comes back; at the end of each session once more, to see what the server kept.
mote-frames draws a script whose pictures must have the same bytes, each once. With --tls both go over TLS on loopback,
and the line is cut after so many bytes, an even distance apart. At last the server is gone for good: both clients say so
in a sentence. Prints how long returns took and what was not as it was; exits 1 where anything was not, or took longer.
"""
import argparse
import itertools
import pathlib
import statistics
import sys
import tempfile
import threading
import time

import own_server
import varied_session
from cut_films import Films, gone
from cut_judge import Judge, Return, tells_jobs_unasked
from cutting_proxy import Cut, Proxy
from own_server import mote

PROMISE_S = 1.0  # and two round trips
RETURN_MESSAGES = 6  # of a line that comes back: greetings, hello, welcome, and what follows


class Welcomes(threading.Thread):
    """When a client of Python's was welcome: what a line that is encrypted does not tell."""

    def __init__(self, connection):
        super().__init__(daemon=True)
        self._connection, self.times = connection, []
        self.start()

    def run(self):
        known = None
        try:
            while self._connection.wait_for(lambda: self._connection.welcome is not known):
                known = self._connection.welcome
                self.times.append(time.monotonic())
        except mote.Error:
            pass  # closed


def within(seconds, condition):
    """What no condition of a client tells is looked for again and again."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    return condition()


class Talks:
    """Sessions of Python's through a proxy, each cut somewhere."""

    def __init__(self, proxy, encrypted):
        self._proxy, self._encrypted = proxy, encrypted
        self.cuts = self.refused = 0
        self.returns, self.wrongs, self.titles = [], [], []
        self._uncut = [self._uncut_way(way) for way in range(varied_session.WAYS)]

    def _uncut_way(self, way):
        self._proxy.plan()
        with mote.connect(self._proxy.file) as session:
            heard = self._session(session, way).heard
        self.length = self._proxy.lines[0].count
        return heard

    def round_trip(self):
        with mote.connect(self._proxy.file) as session:
            return statistics.median(session.ping() for _ in range(9))

    def _session(self, session, way):
        self.titles.append(f"turn {len(self.titles)}")
        talk = varied_session.VariedSession(session, way, self.titles[-1])
        talk.run()
        return talk

    def turn(self, cuts):
        self._proxy.plan(*cuts)
        session = self._connect(len(cuts))
        way = len(self.titles) % varied_session.WAYS
        with session:
            welcomes = Welcomes(session.connection)
            try:
                talk = self._session(session, way)
                differing = [name for name, value in self._uncut[way].items() if talk.heard[name] != value]
                self.wrongs += [f"{cuts}: another {name}" for name in differing]
                self._look_back(session, talk, cuts)
            except (mote.Error, RuntimeError) as error:
                self.wrongs.append(f"{cuts}: {error!r}")
        self._judge(welcomes, cuts)

    def _connect(self, tries):
        """Before the first welcome there is no session that could go on: who connects is told, and connects anew."""
        for _ in range(tries):
            try:
                return mote.connect(self._proxy.file)
            except mote.Error:
                self.refused += 1
                if not self._encrypted and Judge().look(self._proxy.lines).has_session:
                    self.wrongs.append("a client that was welcome was refused")
        return mote.connect(self._proxy.file)

    def _look_back(self, session, talk, cuts):
        """What the server has of the session is seen when its line is cut once more."""
        connection, before = session.connection, session.connection.welcome
        connection.jobs.clear()
        self._proxy.lines[-1].cut()
        back = connection.wait_for(lambda: connection.welcome is not before, 10)
        if not back or not connection.welcome.resumed or connection.welcome.view.view != talk.shown:
            self.wrongs.append(f"{cuts}: the session is back without its view")
        if not connection.wait_for(lambda: any(job.request.title == talk.title for job in connection.jobs.values()), 10):
            self.wrongs.append(f"{cuts}: the session is back without its jobs")
        if not self._encrypted and not within(10, lambda: tells_jobs_unasked(self._proxy.lines[-1])):
            self.wrongs.append(f"{cuts}: the server forgot that jobs are watched")

    def _judge(self, welcomes, cuts):
        lines = self._proxy.lines
        self.cuts += sum(line.reached for line in lines)
        if self._encrypted:
            ends = [line.cut_at for line in lines if line.cut_at is not None]
            for welcome in welcomes.times[1:]:
                self.returns.append(Return(welcome - max(end for end in ends if end < welcome), None))
            return
        judge = Judge().look(lines)
        self.returns += judge.returns
        self.wrongs += [f"{cuts}: {sentence}" for sentence in judge.wrongs]

    def judge_jobs(self, file):
        """Each once, though its answer was lost."""
        with mote.connect(file) as session:
            known = [job.status.request.title for job in session.jobs]
        self.wrongs += [f"{title} has {known.count(title)} jobs" for title in self.titles if known.count(title) != 1]


def _again(number, encrypted):
    """Where the line that comes back is cut: in the hands that are shaken, or about the welcome."""
    return Cut(100 + 7919 * number % 3000 if encrypted else 1 + number % RETURN_MESSAGES)


def each_message(length):
    """After each message, in the midst of each, after each and once more on the way back; and so on."""
    for number in itertools.count():
        at, turn = number % length + 1, number // length % 3
        yield [Cut(at, midst=turn == 1)] + ([_again(number, False)] if turn == 2 else [])


def spread(length, count, encrypted):
    """An even distance apart; every other by a reset, every fourth once more on the way back."""
    for number in range(count):
        first = Cut(1 + number * length // count, reset=encrypted and number % 2 == 1)
        yield [first] + ([_again(number, encrypted)] if number % 4 == 3 else [])


def _quantiles(seconds):
    return f"{1000 * statistics.median(seconds):.0f} ms (p50), {1000 * max(seconds):.0f} ms at worst"


def told(name, some, limit):
    """Prints figures; what was wrong, and what took too long."""
    print(f"{name}: {some.cuts} cuts, {some.refused} of them before there was a session; {len(some.wrongs)} were not as before",
          flush=True)
    session = [item.session for item in some.returns]
    state = [item.state for item in some.returns if item.state is not None]
    for what, seconds in (("the session is back", session), ("its state", state)):
        if seconds:
            print(f"  {what} after {_quantiles(seconds)}, of {1000 * limit:.0f} ms", flush=True)
    return some.wrongs + [f"{name}: a return took {seconds:.2f} s" for seconds in [*session, *state] if seconds > limit]


def run(options, folder):
    varied_session.make_data(options.build, folder)
    programs, more = options.build / "bin", ["--listen", "tcp:127.0.0.1:0"] if options.tls else []
    with own_server.OwnServer(programs / "mote-server", folder, *more) as server:
        with Proxy(server.file, folder, options.delay / 2000) as proxy:
            talks = Talks(proxy, options.tls)
            limit = PROMISE_S + 2 * talks.round_trip()
            for cuts in spread(talks.length, options.cuts, True) if options.tls else each_message(talks.length):
                talks.turn(cuts)
                if talks.cuts >= options.cuts:
                    break
            talks.judge_jobs(server.file)
            wrongs = told("Python", talks, limit)
            films = Films(programs / "mote-frames", proxy, folder)
            for cuts in spread(films.length, options.films, options.tls):
                films.turn(cuts)
            wrongs += told("mote-frames", films, limit)
            wrongs += films.gone()
        with Proxy(server.file, folder) as proxy:
            wrongs += gone(proxy, talks.length)
        if server.is_hurt():
            wrongs.append("the server died")
    return wrongs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--cuts", type=int, default=500, help="of Python's lines")
    parser.add_argument("--films", type=int, default=40, help="runs of mote-frames")
    parser.add_argument("--tls", action="store_true", help="over TLS, cut after so many bytes")
    parser.add_argument("--delay", type=float, default=0.0, help="ms that a round trip takes at least")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mote-cut-") as name:
        wrongs = run(options, pathlib.Path(name).resolve())
    for sentence in wrongs[:50]:
        print(sentence)
    print(f"{len(wrongs)} promises broken")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
