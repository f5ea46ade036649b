# SPDX-License-Identifier: GPL-3.0-or-later
"""A server of a script's own on a Unix socket: started, hurt, ended and started again, by its own process ids alone."""
import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "client" / "python"), str(ROOT / "tests" / "python")]

import mote  # noqa: E402
from mote.messages import new, parse  # noqa: E402
from real_server import NotReady, RealServer  # noqa: E402, F401

GREETING = struct.pack("<4sHH", b"MOTE", 1, 3)


def add_build(parser):
    """The option that all scripts have."""
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")


def make_beam(build, folder, particles=2000, steps=1):
    """A run and its plot beneath a folder: run.h5 and beam.mote."""
    prep = build / "bin" / "mote-prep"
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([prep, "synth", "beam", "--particles", str(particles), "--steps", str(steps), "--seed", "1", "--quiet",
                    "--out", folder / "run.h5"], check=True)
    subprocess.run([prep, "particles", folder / "run.h5", "--axes", "x,px,y", "--quiet", "--out", folder / "beam.mote"],
                   check=True)


def descendants(number):
    """The processes below one, nearest first."""
    found = []
    for tasks in pathlib.Path(f"/proc/{number}/task").glob("*/children"):
        try:
            below = [int(word) for word in tasks.read_text(encoding="ascii").split()]
        except OSError:
            continue
        found += below
        for child in below:
            found += descendants(child)
    return found


def is_program(number, program):
    """Whether a process runs that program, and not what it is about to start."""
    try:
        return os.path.samefile(f"/proc/{number}/exe", program)
    except OSError:
        return False


class OwnServer(RealServer):
    """One of one thread, which may be killed; ``before`` may be what hurts it."""

    def __init__(self, program, folder, *options, **popen):
        super().__init__(program, folder, "--threads", "1", *options, **popen)

    def close(self):
        self.kill()

    def _own(self):
        """Its processes that run the server's program: the supervisor, the one that serves, and what that just forks."""
        numbers = [self.process.pid, *descendants(self.process.pid)]
        return [number for number in numbers if is_program(number, self.program)]

    def _serving(self):
        own = self._own()
        return own[1] if len(own) > 1 else 0

    def is_hurt(self):
        """Whether the process that served at first is gone."""
        return self._serving() != self.serving or self.process.poll() is not None

    def follow(self):
        """What is there now counts as what served at first."""
        self.serving = self._serving()

    def kill(self):
        """At once, the supervisor first, or it would start another. Jobs live on."""
        own = self._own()
        for number in own:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        if self.process.poll() is None and self.process.pid not in own:
            self.process.terminate()  # what traced it ends with it
        try:
            self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()

    def end(self, timeout=60):
        """Asked to; its exit code."""
        own = self._own()
        if own:
            os.kill(own[0], signal.SIGTERM)
        code = self.process.wait(timeout)
        self.process.stdout.close()
        return code

    def session(self):
        return mote.connect(self.file)

    def raw(self):
        """A line on which nothing was said."""
        line = socket.socket(socket.AF_UNIX)
        line.settimeout(60)
        line.connect(self.content["address"].removeprefix("unix:"))
        return RawLine(line, self.content["token"])


class RawLine:
    """A client's end that may say what no client says. For a ``with`` statement."""

    def __init__(self, line, token):
        self.line, self._token = line, token

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.line.close()

    def send(self, data):
        """False where the server does not listen any more."""
        try:
            self.line.sendall(data)
        except (BrokenPipeError, ConnectionResetError):
            return False
        return True

    def say(self, message):
        data = message if isinstance(message, bytes) else message.SerializeToString()
        return self.send(struct.pack("<II", len(data), 0) + data)

    def _take(self, size):
        data = bytearray()
        while len(data) < size:
            try:
                piece = self.line.recv(size - len(data))
            except ConnectionResetError:
                return None
            if not piece:
                return None
            data += piece
        return bytes(data)

    def greet(self):
        return self.send(GREETING) and self._take(len(GREETING)) is not None

    def hear(self):
        """The next message of the server; None where it closed the line."""
        header = self._take(8)
        if header is None:
            return None
        size, payload = struct.unpack("<II", header)
        data = self._take(size)
        if data is None or (payload and self._take(payload) is None):
            return None
        return parse("ServerMessage", data)

    def enter(self):
        """Greets, says hello and hears the welcome."""
        hello = new("ClientMessage")
        hello.hello.token, hello.hello.client, hello.hello.minor = self._token, "a script", 3
        if not self.greet() or not self.say(hello):
            return False
        heard = self.hear()
        return heard is not None and heard.WhichOneof("body") == "welcome"

    def ask(self, message, bodies):
        """The next message of one of these kinds, or a failure, that answers it; None where the line ended."""
        if not self.say(message):
            return None
        while True:
            heard = self.hear()
            if heard is None or (heard.reply_to == message.request and heard.WhichOneof("body") in (*bodies, "failure")):
                return heard
