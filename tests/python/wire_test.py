# SPDX-License-Identifier: GPL-3.0-or-later
"""The byte stream and the connection file: cut anywhere, and wrong in any way."""
import os
import random
import struct
import tempfile
import unittest

from support import Case, mote  # isort: skip
from fake_server import TOKEN, FakeServer
from mote import wire

GREETING = struct.pack("<4sHH", b"MOTE", 1, 7)


def feed(reader, data, cut):
    """All bytes, in pieces of at most `cut` that are never more than the reader has space for."""
    frames = []
    while data:
        space = reader.space()
        count = min(len(space), len(data), cut())
        space[:count] = data[:count]
        reader.took(count)
        data = data[count:]
        frames += reader.frames()
    return frames


class Stream(Case):
    def test_frames_are_found_however_the_stream_is_cut(self):
        random_numbers = random.Random(1)
        for _ in range(200):
            sent = [(random_numbers.randbytes(random_numbers.choice([0, 1, 7, 300])),
                     random_numbers.randbytes(random_numbers.choice([0, 0, 1, 5000]))) for _ in range(5)]
            data = GREETING + b"".join(struct.pack("<II", len(m), len(p)) + m + p for m, p in sent)
            most = random_numbers.choice([1, 3, 8, 10000])
            got = feed(wire.Reader(), data, lambda: random_numbers.randint(1, most))
            self.assertEqual([(bytes(m), bytes(p)) for m, p in got], sent)

    def test_what_is_too_long_takes_no_memory(self):
        for message, payload, where in ((wire.MESSAGE_LIMIT + 1, 0, "message"), (2**32 - 1, 2**32 - 1, "message"),
                                        (0, wire.PAYLOAD_LIMIT + 1, "payload")):
            with self.fails("resource_exhausted", where):
                feed(wire.Reader(), GREETING + struct.pack("<II", message, payload), lambda: 8)

    def test_other_greetings_are_refused(self):
        with self.fails("corrupt", "greeting"):
            feed(wire.Reader(), b"HTTP/1.1", lambda: 8)
        with self.fails("unsupported", "greeting", "version 2"):
            feed(wire.Reader(), struct.pack("<4sHH", b"MOTE", 2, 0), lambda: 8)

    def test_limits_are_those_of_the_protocol(self):
        self.assertEqual((wire.CLIENT_LIMIT, wire.MESSAGE_LIMIT, wire.PAYLOAD_LIMIT), (2**20, 2**24, 258 * 2**20))

    def test_a_request_that_no_server_takes_is_not_sent(self):
        wire.check_size(2**20)
        with self.fails("invalid_argument", words="1048577 bytes"):
            wire.check_size(2**20 + 1)


class ConnectionFile(Case):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "connection.json")

    def write(self, text, mode=0o600):
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(self.path, mode)

    def test_what_the_server_writes_is_read(self):
        self.write('{"address": "unix:/tmp/s", "token": "0a", "pid": "4711", "protocolMajor": 1, "more": {}}')
        self.assertEqual(wire.read_connection_file(self.path), ("/tmp/s", "0a", 4711, None, ""))

    def test_what_is_wrong_is_said(self):
        good = '{"address": "%s", "token": "%s", "protocolMajor": %d}'
        for text, code in (("", "invalid_argument"), ("[]", "invalid_argument"), ("{", "invalid_argument"),
                           (good % ("unix:", "0a", 1), "invalid_argument"),
                           (good % ("unix:/" + 107 * "a", "0a", 1), "invalid_argument"),
                           (good % ("tcp:a:1", "0a", 1), "invalid_argument"), (good % ("unix:/s", "0A", 1), "invalid_argument"),
                           (good % ("unix:/s", "", 1), "invalid_argument"), (good % ("unix:/s", "0a", 2), "unsupported"),
                           ('{"address": 7}', "invalid_argument"), (" " * 70000, "invalid_argument")):
            self.write(text)
            with self.subTest(text[:60]), self.fails(code, self.path):
                wire.read_connection_file(self.path)

    def test_a_file_that_others_may_read_is_refused(self):
        self.write("{}", 0o640)
        with self.fails("permission_denied", self.path, "0640"):
            wire.read_connection_file(self.path)

    def test_what_is_no_file_is_refused(self):
        with self.fails("not_found", self.path):
            wire.read_connection_file(self.path)
        os.mkfifo(self.path, 0o600)
        with self.fails("invalid_argument", self.path):
            wire.read_connection_file(self.path)

    def test_a_server_that_is_gone_is_said_to_be(self):
        with FakeServer() as server:
            server.write_file(address="unix:/nowhere/at/all")
            with self.fails("not_found", "/nowhere/at/all"):
                mote.connect(server.file)
            server.write_file(token="00")
            with self.fails("permission_denied", "hello.token"):
                mote.connect(server.file)
            self.assertEqual(server.hellos[0].hello.token, "00")
            server.write_file(token=TOKEN)
            mote.connect(server.file).close()


if __name__ == "__main__":
    unittest.main()
