#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths at 2^31 and 2^32, and around each limit, in every length field of the stream and of its messages.

    hostile_lengths.py [--build build/release] [--rounds 20]

Each is refused in a sentence, or its line closed, before memory is taken: the most that the server ever held is looked
at. Prints how many lengths were tried, how many were taken, and the growth of that; exits 1 where one was taken, the
server died, or it grew by more than one message that is allowed (1 MiB) and 16 MiB of its own play.
"""
import argparse
import pathlib
import struct
import sys
import tempfile

import own_server
from own_server import new

GROWTH_KIB = (16 + 1) << 10
EDGES = [edge + by for edge in (1 << 31, 1 << 32) for by in (-1, 0, 1)]


def lengths(limit):
    """Of a header's field beyond its limit; 2^32 and 2^32 + 1 do not fit into it and wrap."""
    return sorted({edge % (1 << 32) for edge in EDGES if edge % (1 << 32) > limit} | {limit + 1, 1 << 30})


def varint(number):
    data = bytearray()
    while number > 0x7F:
        data.append(number & 0x7F | 0x80)
        number >>= 7
    data.append(number)
    return bytes(data)


def headers():
    """(name, whether after a hello, bytes)."""
    for entered, limit in ((False, 4 << 10), (True, 1 << 20)):
        for length in lengths(limit):
            yield f"message of {length}", entered, struct.pack("<II", length, 0)
        for length in lengths(0):
            yield f"payload of {length}", entered, struct.pack("<II", 8, length)
            yield f"both of {length}", entered, struct.pack("<II", length, length)


def inner_fields():
    """Fields of messages with a length of their own: strings, bytes, messages within, and packed numbers."""
    # Of ClientMessage every field with a body, and within a view, a job and an upload each kind once.
    outer = [bytes([field << 3 & 0x7F | 2]) if field < 16 else varint(field << 3 | 2) for field in range(2, 20)]
    for length in EDGES:
        for number, key in enumerate(outer):
            yield f"field {number + 2} of {length}", key + varint(length)
        for field, inner in ((5, 2), (6, 1), (7, 1), (12, 2), (14, 1), (14, 3)):
            body = bytes([inner << 3 | 2]) + varint(length)
            yield f"field {field}.{inner} of {length}", bytes([field << 3 | 2]) + varint(len(body)) + body


def refused(line, entered, data, closed):
    """Whether the server refuses these bytes. A message that is none ends the line, too."""
    if not (line.enter() if entered else line.greet()):
        return False
    line.send(data)
    while True:
        heard = line.hear()
        if heard is None:
            return closed
        if heard.WhichOneof("body") == "failure":
            return bool(heard.failure.message) and "\n" not in heard.failure.message


def ranges(server):
    """Numbers of a size in messages that are valid otherwise; what refuses them and goes on."""
    wrongs, tried = [], 0
    with server.raw() as line:
        line.enter()
        for number in (1 << 31, (1 << 31) - 1, (1 << 32) - 1):
            for name in ("width", "height"):
                message = new("ClientMessage")
                message.request = tried = tried + 1
                message.set_view.view_id = tried
                message.set_view.view.width = message.set_view.view.height = 8
                setattr(message.set_view.view, name, number)
                heard = line.ask(message, ("frame",))
                if heard is None or heard.WhichOneof("body") != "failure":
                    wrongs.append(f"a picture with {name} {number} is not refused")
        for size in (1 << 31, 1 << 32, 1 << 63, (1 << 64) - 1):
            message = new("ClientMessage")
            message.request = tried = tried + 1
            message.upload.name, message.upload.size, message.upload.data = f"upload-{tried}", size, b"x"
            heard = line.ask(message, ("uploaded",))
            if heard is None:
                wrongs.append(f"an upload of {size} bytes ends the line")
    return tried, wrongs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--rounds", type=int, default=20, help="of the headers, as fast as they go")
    options = parser.parse_args()
    tried, wrongs = 0, []
    with tempfile.TemporaryDirectory(prefix="mote-lengths-") as folder:
        with own_server.OwnServer(options.build / "bin" / "mote-server", pathlib.Path(folder)) as server:
            with server.raw() as line:
                line.enter()
            before = server.memory("VmHWM")
            plan = [item for _ in range(options.rounds) for item in headers()]
            plan += [(name, True, struct.pack("<II", len(data), 0) + data) for name, data in inner_fields()]
            for name, entered, data in plan:
                tried += 1
                with server.raw() as line:
                    if not refused(line, entered, data, closed=not entered):
                        wrongs.append(f"{name}{'' if entered else ' before a hello'} is not refused in a sentence")
            more, wrong = ranges(server)
            tried, wrongs = tried + more, wrongs + wrong
            growth = server.memory("VmHWM") - before
            if server.is_hurt():
                wrongs.append("the server died")
            with server.session() as session:
                session.ping()
    for wrong in wrongs[:50]:
        print(wrong)
    print(f"{tried} lengths: {len(wrongs)} not refused; at its most the server grew by {growth / 1024:.1f} MiB")
    return 1 if wrongs or growth > GROWTH_KIB else 0


if __name__ == "__main__":
    sys.exit(main())
