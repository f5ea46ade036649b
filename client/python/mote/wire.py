# SPDX-License-Identifier: GPL-3.0-or-later
"""How messages lie in the byte stream (docs/PROTOCOL.md, "The stream"), and where a server is found.

Pure functions over bytes, and the reader of one stream. Nothing here is believed: lengths are checked before memory
is taken.
"""
from __future__ import annotations

import json
import os
import re
import stat
import struct
from typing import Any, List, NamedTuple, Optional, Tuple

from .errors import Error, invalid

MAJOR, MINOR = 1, 3
GREETING = struct.pack("<4sHH", b"MOTE", MAJOR, MINOR)
_HEADER = struct.Struct("<II")

HELLO_LIMIT = 4 << 10
"""The most bytes of a client's first message."""
CLIENT_LIMIT = 1 << 20
"""The most bytes of a client's later messages."""
MESSAGE_LIMIT = 16 << 20
"""The most bytes of a server's message."""
PAYLOAD_LIMIT = (8 << 25) + (2 << 20)
"""The most bytes of a server's payload: the greatest picture, and a codec's share."""
MAX_PIXELS = 1 << 25
MAX_SIDE = 16384
MAX_QUEUED_VIEWS = 16

_FILE_LIMIT = 64 << 10


class Place(NamedTuple):
    """What a connection file says."""

    address: str
    """Of the Unix socket; of TCP as the file says it."""
    token: str
    pid: int
    tcp: Optional[Tuple[str, int]] = None
    """Host and port."""
    fingerprint: str = ""
    """Of the certificate, with TCP: its SHA-256."""


def check_size(size: int) -> None:
    """Raises Error (invalid_argument) where a server takes no request of so many bytes."""
    if size > CLIENT_LIMIT:
        raise invalid("", f"the request has {size} bytes, more than the {CLIENT_LIMIT} that a server takes")


def encode(message: bytes) -> bytes:
    """A frame of a client's, which has no payload."""
    return _HEADER.pack(len(message), 0) + message


class Reader:
    """Cuts a server's stream into messages. ``space()`` says where the next bytes go, ``took(n)`` that n are there."""

    def __init__(self) -> None:
        self._stage = self._greeting
        self._buffer = bytearray(len(GREETING))
        self._have = 0
        self._payload_size = 0
        self._message = bytearray()
        self._frames: List[Tuple[bytearray, bytearray]] = []

    def space(self) -> memoryview:
        """What is to be read next; never empty."""
        return memoryview(self._buffer)[self._have :]

    def took(self, count: int) -> None:
        """Raises Error (corrupt, unsupported, resource_exhausted) where the stream is none of ours."""
        self._have += count
        if self._have == len(self._buffer):
            self._stage()

    def frames(self) -> List[Tuple[bytearray, bytearray]]:
        """The messages that are complete, with their payloads; each once."""
        frames, self._frames = self._frames, []
        return frames

    def _expect(self, size: int, stage: Any) -> None:
        self._buffer, self._have, self._stage = bytearray(size), 0, stage
        if size == 0:
            stage()

    def _greeting(self) -> None:
        magic, major, _ = struct.unpack("<4sHH", self._buffer)
        if magic != b"MOTE":
            raise Error("corrupt", "greeting", "who answers there is no Mote server")
        if major != MAJOR:
            raise Error("unsupported", "greeting",
                        f"the server speaks protocol version {major}, this package {MAJOR}; use the same version of both")
        self._expect(_HEADER.size, self._header)

    def _header(self) -> None:
        message, payload = _HEADER.unpack(self._buffer)
        if message > MESSAGE_LIMIT:
            raise Error("resource_exhausted", "message", f"the server sends a message of {message} bytes")
        if payload > PAYLOAD_LIMIT:
            raise Error("resource_exhausted", "payload", f"the server sends a payload of {payload} bytes")
        self._payload_size = payload
        self._expect(message, self._body)

    def _body(self) -> None:
        self._message = self._buffer
        self._expect(self._payload_size, self._whole)

    def _whole(self) -> None:
        self._frames.append((self._message, self._buffer))
        self._expect(_HEADER.size, self._header)


def _read_private(path: str) -> bytes:
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY)
    except FileNotFoundError:
        raise Error("not_found", path, "there is no such connection file; is the server running?") from None
    except OSError as failure:
        code = "permission_denied" if isinstance(failure, PermissionError) else "internal"
        raise Error(code, path, f"cannot be read: {failure.strerror}") from None
    with os.fdopen(descriptor, "rb") as file:
        mode = os.fstat(descriptor).st_mode
        if not stat.S_ISREG(mode):
            raise invalid(path, "is no plain file")
        if mode & 0o077:
            raise Error("permission_denied", path, f"others may read this token (mode {mode & 0o7777:04o}); chmod 600 "
                        "it, and restart the server if they may have")
        return file.read(_FILE_LIMIT + 1)


def _is_hexadecimal(text: Any) -> bool:
    return isinstance(text, str) and bool(text) and not set(text) - set("0123456789abcdef")


def _tcp(path: str, address: str, fingerprint: Any) -> Tuple[str, int]:
    found = re.fullmatch(r"tcp:(?:\[([^\[\]]{1,255})\]|([^:\[\]]{1,255})):([0-9]{1,5})", address)
    if not found or int(found[3]) > 65535:
        raise invalid(path, f"{address!r} is no address")
    if not _is_hexadecimal(fingerprint) or len(fingerprint) != 64:
        raise invalid(path, "its certificate fingerprint is no SHA-256, and TCP is not used without TLS")
    return found[1] or found[2], int(found[3])


def _unix_path(path: str, address: str) -> str:
    kind, _, rest = address.partition(":")
    if kind != "unix" or not 0 < len(os.fsencode(rest)) <= 107:
        raise invalid(path, f"{address!r} is no address")
    return rest


def read_connection_file(path: str) -> Place:
    """Raises Error: not_found, permission_denied, invalid_argument, unsupported."""
    data = _read_private(path)
    try:
        content: Optional[Any] = json.loads(data) if len(data) <= _FILE_LIMIT else None
    except ValueError:
        content = None
    if not isinstance(content, dict):
        raise invalid(path, "is no connection file")
    address, token, fingerprint = (content.get(key) for key in ("address", "token", "certificateFingerprint"))
    if not isinstance(address, str):
        raise invalid(path, "says no address")
    tcp = _tcp(path, address, fingerprint) if address.startswith("tcp:") else None
    if not isinstance(token, str) or not _is_hexadecimal(token) or len(token) > 256:
        raise invalid(path, "its token is not hexadecimal")
    if content.get("protocolMajor") != MAJOR:
        raise Error("unsupported", path, f"the server speaks protocol version {content.get('protocolMajor')}, this "
                    f"package {MAJOR}; use the same version of both")
    pid = str(content.get("pid", "0"))
    return Place(address if tcp else _unix_path(path, address), token, int(pid) if pid.isdecimal() else 0, tcp,
                 str(fingerprint) if tcp else "")
