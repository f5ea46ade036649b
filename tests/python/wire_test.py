# SPDX-License-Identifier: GPL-3.0-or-later
"""The byte stream and the connection file: cut anywhere, and wrong in any way. Pictures of any size come back bit by bit, and
damaged ones are refused; the encoder here is docs/PROTOCOL.md's text."""
import io
import os
import random
import struct
import unittest

import numpy as np
import zstandard
from PIL import Image as pil

from support import Case, FolderCase, mote  # isort: skip
from fake_server import TOKEN, FakeServer
from mote import messages, pixels, wire
from mote.image import Image, encode_srgb

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


class ConnectionFile(FolderCase):
    def setUp(self):
        super().setUp()
        self.path = os.path.join(self.folder, "connection.json")

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


def frame_of(width, height, encoding=pixels.ZSTD, format=pixels.SRGB8):
    frame = messages.new("Frame")
    frame.width, frame.height, frame.encoding, frame.format = width, height, encoding, format
    return frame


def filter_srgb(image):
    """Pixel by pixel, as the document says it."""
    out = bytearray()
    for row in image.tolist():
        left = [0, 0, 0]
        for pixel in row:
            out += bytes((a - b) % 256 for a, b in zip(pixel[:3], left))
            left = pixel[:3]
    return bytes(out)


def filter_halves(image):
    out = bytearray()
    for row in image.view(np.uint16).tolist():
        low, high, left = bytearray(), bytearray(), [0, 0, 0]
        for pixel in row:
            for a, b in zip(pixel[:3], left):
                low.append((a - b) % 65536 & 255)
                high.append((a - b) % 65536 >> 8)
            left = pixel[:3]
        out += low + high
    return bytes(out)


def pack(data):
    return bytearray(zstandard.ZstdCompressor(write_checksum=True, write_content_size=True).compress(data))


class Decode(Case):
    def setUp(self):
        self.numbers = np.random.default_rng(4)
        self.choice = random.Random(4)

    def sizes(self, count):
        return [(1, 1), (1, 7), (7, 1)] + [(self.choice.randint(1, 40), self.choice.randint(1, 40)) for _ in range(count)]

    def test_bytes_come_back(self):
        for width, height in self.sizes(60):
            image = self.numbers.integers(0, 256, (height, width, 4), dtype=np.uint8)
            image[..., 3] = 255
            got = pixels.decode_frame(frame_of(width, height), pack(filter_srgb(image)))
            self.assertEqual(got.dtype, np.uint8)
            np.testing.assert_array_equal(got, image)

    def test_halves_come_back(self):
        for width, height in self.sizes(60):
            image = self.numbers.integers(0, 65536, (height, width, 4), dtype=np.uint16).view(np.float16)
            image[..., 3] = 1
            got = pixels.decode_frame(frame_of(width, height, format=pixels.LINEAR_HALF), pack(filter_halves(image)))
            self.assertEqual(got.dtype, np.float16)
            np.testing.assert_array_equal(got.view(np.uint16), image.view(np.uint16))

    def test_jpeg_is_near(self):
        ramp = np.tile(np.linspace(0, 255, 64).astype(np.uint8)[None, :, None], (48, 1, 3))
        file = io.BytesIO()
        pil.fromarray(ramp).save(file, "JPEG", quality=95)
        got = pixels.decode_frame(frame_of(64, 48, pixels.JPEG), bytearray(file.getvalue()))
        # Quality 95 quantises a smooth ramp by a step or two of its lowest frequencies.
        self.assertLess(int(np.abs(got[..., :3].astype(int) - ramp).max()), 8)
        self.assertTrue((got[..., 3] == 255).all())
        for bad in (file.getvalue()[:-200], b"\xff\xd8nothing", b""):
            with self.fails("corrupt", "frame"):
                pixels.decode_frame(frame_of(64, 48, pixels.JPEG), bytearray(bad))
        with self.fails("corrupt", "frame", "64 x 48"):
            pixels.decode_frame(frame_of(64, 47, pixels.JPEG), bytearray(file.getvalue()))

    def test_damage_is_an_error_and_nothing_else(self):
        image = self.numbers.integers(0, 256, (20, 30, 4), dtype=np.uint8)
        image[..., 3] = 255
        whole = pack(filter_srgb(image))
        for _ in range(400):
            bad = bytearray(whole)
            for _ in range(self.choice.randint(1, 4)):
                bad[self.choice.randrange(len(bad))] ^= 1 << self.choice.randrange(8)
            bad = bad[: self.choice.choice([len(bad), self.choice.randrange(len(bad))])]
            try:
                np.testing.assert_array_equal(pixels.decode_frame(frame_of(30, 20), bad), image)
            except mote.Error as error:
                self.assertEqual(error.code, "corrupt")

    def test_lies_about_sizes_are_refused_before_memory_is_taken(self):
        for width, height in ((0, 5), (5, 0), (16385, 1), (16384, 16384), (2**32 - 1, 2**32 - 1)):
            with self.fails("corrupt", "frame"):
                pixels.decode_frame(frame_of(width, height), bytearray())
        bomb = pack(bytes(100_000_000))
        with self.fails("corrupt", "frame", "100000000"):
            pixels.decode_frame(frame_of(4, 4), bomb)
        unknown = bytearray(zstandard.ZstdCompressor(write_content_size=False).compress(bytes(100_000_000)))
        with self.fails("corrupt", "frame"):
            pixels.decode_frame(frame_of(4, 4), unknown)

    def test_pieces_and_unknown_encodings_are_refused(self):
        frame = frame_of(1, 1)
        frame.payload_begin = 3
        with self.fails("corrupt", "frame"):
            pixels.decode_frame(frame, pack(b"abc"))
        for encoding, format in ((3, 1), (9, 1), (0, 1), (pixels.ZSTD, 3), (pixels.JPEG, pixels.LINEAR_HALF)):
            with self.fails("unsupported", "frame"):
                pixels.decode_frame(frame_of(1, 1, encoding, format), pack(b"abc"))


class Pictures(Case):
    def test_an_image_is_what_it_was_in_all_its_forms(self):
        array = np.random.default_rng(5).integers(0, 256, (9, 13, 4), dtype=np.uint8)
        array[..., 3] = 255
        image = Image(array, 7, "paper", 1.5)
        self.assertEqual(image.size, (13, 9))
        np.testing.assert_array_equal(np.array(image.to_pil()), array[..., :3])
        np.testing.assert_array_equal(np.asarray(image), array)
        bundle, metadata = image._repr_mimebundle_()
        np.testing.assert_array_equal(np.array(pil.open(io.BytesIO(bundle["image/png"]))), array[..., :3])
        self.assertEqual(metadata["image/png"], {"width": 13, "height": 9})
        self.assertEqual(bundle["image/png"], image._repr_png_())
        with self.fails("unsupported", "a.svg", "View.save"):
            image.save("a.svg")
        with self.fails("unsupported", "a.nothing"):
            image.save("a.nothing")

    def test_light_becomes_srgb(self):
        for byte in range(256):
            encoded = byte / 255
            linear = encoded / 12.92 if encoded <= 0.04045 else ((encoded + 0.055) / 1.055) ** 2.4
            # float32 keeps far more than the 1/255 that a byte does.
            self.assertEqual(encode_srgb(np.full((1, 1, 4), linear, np.float32))[0, 0, 0], byte)
        strange = encode_srgb(np.array([[[np.nan, np.inf, -1, 1]]], np.float16))
        self.assertEqual(strange.tolist(), [[[0, 255, 0, 255]]])


if __name__ == "__main__":
    unittest.main()
