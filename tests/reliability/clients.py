# SPDX-License-Identifier: GPL-3.0-or-later
"""A server with a volume to look at, and clients that do to it what the scripts beside this file measure."""
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "client" / "python"), str(ROOT / "tests" / "python")]

import numpy  # noqa: E402
from mote import wire  # noqa: E402
from mote.line import Line  # noqa: E402
from mote.messages import new, to_message  # noqa: E402
from real_server import RealServer  # noqa: E402


def make_volume(programs, folder, edge=128):
    """data/field, a hybrid volume of waves in a ball: something is seen in most of it."""
    (folder / "data").mkdir()
    x = numpy.linspace(-1.0, 1.0, edge)
    z, y, x = numpy.meshgrid(x, x, x, indexing="ij")
    field = numpy.exp(-2.0 * (x * x + y * y + z * z)) * (1.0 + 0.5 * numpy.sin(9.0 * x) * numpy.sin(11.0 * y + 3.0 * z))
    raw = folder / "field.raw"
    numpy.round(170.0 * field).clip(0, 255).astype(numpy.uint8).tofile(raw)
    subprocess.run([programs / "mote-prep", "volume", raw, "--dimensions", *3 * [str(edge)], "--threshold", "0.01",
                    "--out", folder / "data" / "field.mote"], check=True, stdout=subprocess.DEVNULL)


def view_of(width, height, turn=0.0):
    """A view of the volume that fills the picture, as a script has it."""
    eye = [2.2 * numpy.cos(turn), 2.2 * numpy.sin(turn), 0.6]
    return {"width": width, "height": height, "background": [0, 0, 0],
            "camera": {"eye": eye, "target": [0, 0, 0], "up": [0, 0, 1]},
            "layers": [{"dataset": "data/field", "hybrid": {}}]}


class Server(RealServer):
    """Its device has all threads; ``programs``: the folder of mote-server."""

    def __init__(self, programs, folder, *options):
        super().__init__(programs / "mote-server", folder, *options)


class Client:
    """A line that asks for views and reads frames, or does not."""

    def __init__(self, file):
        wake, self._never = os.pipe()
        place = wire.read_connection_file(str(file))
        self._line = Line(place, wake)
        self._request = 0
        hello = self._message()
        hello.hello.token, hello.hello.client, hello.hello.minor = place.token, "a measurement", wire.MINOR
        self._send(hello)
        self.receive("welcome")

    def _message(self):
        self._request += 1
        message = new("ClientMessage")
        message.request = self._request
        return message

    def _send(self, message):
        self._line.send(wire.encode(message.SerializeToString()))

    def ask(self, number, view, final_only=False, page=None, format=None):
        """For the quick picture of a view that moves, or for the exact one, also as a document."""
        message = self._message()
        asked = message.set_view
        asked.view.CopyFrom(to_message("View", view))
        asked.view_id, asked.moving, asked.final_only = number, not final_only, final_only
        if page:
            asked.page.CopyFrom(to_message("Page", page))
        if format:
            asked.format = {"SRGB8": 1, "LINEAR_HALF": 2}[format]
        self._send(message)

    def credit(self):
        """For a frame that came."""
        message = self._message()
        message.credit.frames = 1
        self._send(message)

    @property
    def full(self):
        """Whether the server takes no more of what is asked."""
        return self._line.full

    def list_jobs(self):
        """Asks, and reads nothing."""
        message = self._message()
        message.list_jobs.count = 200
        self._send(message)

    def receive(self, kind, timeout=600.0):
        """The next message of this kind."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            for message, _ in self._line.turn(1.0):
                if message.WhichOneof("body") == "failure":
                    raise RuntimeError(message.failure.message)
                if message.WhichOneof("body") == kind:
                    return getattr(message, kind)
        raise RuntimeError(f"no {kind} came")

    def picture(self, number, timeout=600.0):
        """Waits for the whole frame of a view; returns it, or the newest that came in its place."""
        while True:
            frame = self.receive("frame", timeout)
            self.credit()
            if frame.view_id == number:
                return frame

    def close(self):
        self._line.__exit__(None, None, None)


def quick_times(client, count, size=(640, 480), interval=0.0):
    """Seconds that each quick picture of a view that turns took, from its question to its frame."""
    times = []
    for number in range(1, count + 1):
        begin = time.perf_counter()
        client.ask(number, view_of(*size, turn=0.02 * number))
        client.picture(number)
        times.append(time.perf_counter() - begin)
        time.sleep(max(0.0, interval - times[-1]))
    return times


def quantile(times, share):
    """Of seconds, in milliseconds."""
    return 1000.0 * sorted(times)[int(share * (len(times) - 1))]


def summary(name, times):
    return f"{name}: {len(times)} pictures, p50 {quantile(times, 0.5):.1f} ms, p99 {quantile(times, 0.99):.1f} ms"
