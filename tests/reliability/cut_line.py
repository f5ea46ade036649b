#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts the line of a session after each message of the server's: it is back with the same view and the same jobs.

    cut_line.py [--build DIR] [--cuts 500]

Each turn opens a session, shows a view and watches jobs, hears so many messages, cuts the line and takes the session up
again. Prints the slowest return; fails where a view or a job is another.
"""
import argparse
import pathlib
import socket
import struct
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "client" / "python")]

import mote  # noqa: E402
from mote import messages, wire  # noqa: E402


class Line:
    """Says hello; ``welcome`` is the answer."""

    def __init__(self, place, resume=""):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(60)
        self.socket.connect(place.address)
        self.socket.sendall(wire.GREETING)
        self.take(len(wire.GREETING))
        self.say(lambda m: None, token=place.token, resume=resume)
        self.welcome = self.hear().welcome

    def say(self, fill, **hello):
        message = messages.new("ClientMessage")
        message.request = 1
        for name, value in hello.items():
            setattr(message.hello, name, value)
        fill(message)
        self.socket.sendall(wire.encode(message.SerializeToString()))

    def take(self, count):
        data = b""
        while len(data) < count:
            piece = self.socket.recv(count - len(data))
            if not piece:
                raise EOFError("the server closed the line")
            data += piece
        return data

    def hear(self):
        size, payload = struct.unpack("<II", self.take(8))
        message = messages.parse("ServerMessage", self.take(size))
        self.take(payload)
        return message


def turn(place, number):
    """Seconds that the return took."""
    line = Line(place)
    wanted = messages.new("ClientMessage")
    wanted.set_view.view_id = number + 1
    wanted.set_view.view.width = wanted.set_view.view.height = 16 + number % 32
    line.say(lambda m: m.watch_jobs.SetInParent())
    line.say(lambda m: m.CopyFrom(wanted))
    jobs = None
    heard = 0
    while jobs is None or heard < 1 + number % 3:  # jobs, the quick picture, the exact one
        message = line.hear()
        heard += 1
        jobs = message.jobs if message.WhichOneof("body") == "jobs" else jobs
    line.say(lambda m: m.ping.SetInParent())
    while line.hear().WhichOneof("body") != "pong":
        pass  # the view was heard
    line.socket.close()
    begin = time.perf_counter()
    again = Line(place, line.welcome.resume)
    seconds = time.perf_counter() - begin
    assert again.welcome.resumed and again.welcome.view == wanted.set_view, "another view"
    message = again.hear()
    while message.WhichOneof("body") != "jobs":
        message = again.hear()
    assert message.jobs == jobs, "other jobs"
    again.socket.close()
    return seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--cuts", type=int, default=500)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, mote.spawn(data=folder, program=options.build / "bin" / "mote-server") as own:
        place = wire.read_connection_file(own._server.connection_file)
        slowest = max(turn(place, number) for number in range(options.cuts))
    print(f"{options.cuts} cuts: the same view and jobs each time; the slowest return took {1000 * slowest:.1f} ms")
    return 0 if slowest <= 1.0 else 1


if __name__ == "__main__":
    sys.exit(main())
