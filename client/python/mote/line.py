# SPDX-License-Identifier: GPL-3.0-or-later
"""Line: one connected socket, from its opening to its end, never reused. One thread; another may wake it by a pipe."""
from __future__ import annotations

import os
import select
import socket
from collections import deque
from types import TracebackType
from typing import Deque, List, Optional, Tuple, Type

from . import wire
from .errors import Error
from .messages import Message, parse
from .opening import EncryptedSocket, open_socket

_ENOUGH = 4 << 20  # bytes that wait to be sent; who has more to say waits until they are gone


class Line:
    """Raises Error where nobody listens. Both sides greet, neither waits for the other."""

    def __init__(self, place: wire.Place, wake: int) -> None:
        self._socket = open_socket(place)
        self._wake = wake
        self._reader = wire.Reader()
        self._out: Deque[memoryview] = deque([memoryview(wire.GREETING)])
        self._waiting = len(wire.GREETING)
        self.progress = 0
        """Grows with each byte that comes, and with those that go while others wait for them."""
        self._poll = select.poll()
        self._poll.register(wake, select.POLLIN)

    def __enter__(self) -> Line:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self._socket.close()

    @property
    def full(self) -> bool:
        """Whether enough waits to be sent."""
        return self._waiting >= _ENOUGH

    def send(self, data: bytes) -> None:
        """Is sent in the next turns."""
        self._out.append(memoryview(data))
        self._waiting += len(data)
        self._write()

    def turn(self, timeout: Optional[float]) -> List[Tuple[Message, bytearray]]:
        """Waits until something can be read or sent, the pipe wakes it or time is over; what has arrived.

        Raises Error where the other side has closed the line or sends what is no message.
        """
        self._poll.register(self._socket, select.POLLIN | (select.POLLOUT if self._out else 0))
        events = dict(self._poll.poll(None if timeout is None else max(timeout, 0.0) * 1000 + 1))
        if self._wake in events:
            os.read(self._wake, 4096)
        if events.get(self._socket.fileno(), 0) & select.POLLOUT:
            self._write()
        if events.get(self._socket.fileno(), 0) & ~select.POLLOUT:
            self._read()
            # What TLS has decrypted already is nothing that the poll sees.
            while isinstance(self._socket, EncryptedSocket) and self._socket.pending() > 0:
                self._read()
        return [(parse("ServerMessage", message), payload) for message, payload in self._reader.frames()]

    def _write(self) -> None:
        while self._out:
            try:
                count = self._socket.send(self._out[0], socket.MSG_NOSIGNAL)
            except (BlockingIOError, InterruptedError):
                return
            except OSError:
                # A server that closes has said why: what it sent is read first, and its end found there.
                self._out.clear()
                self._waiting = 0
                return
            self._waiting -= count
            self.progress += count if self._waiting else 0
            if count == len(self._out[0]):
                self._out.popleft()
            else:
                self._out[0] = self._out[0][count:]

    def _read(self) -> None:
        try:
            count = self._socket.recv_into(self._reader.space())
        except (BlockingIOError, InterruptedError):
            return
        except OSError as failure:
            raise Error("internal", "", f"the server's line broke: {failure.strerror}") from None
        if count == 0:
            raise Error("internal", "", "the server closed the connection")
        self.progress += count
        self._reader.took(count)
