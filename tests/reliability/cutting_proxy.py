# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands between a client and a server and cuts their line, after a message or a byte of either's.

Over a Unix socket it knows messages and hands on whole ones alone, one at a time of both sides, so that "after the
k-th" is a place. TLS it hands on as it comes, and counts bytes.
"""
import json
import os
import socket
import struct
import threading
import time
from typing import NamedTuple

CLIENT, SERVER = "client", "server"
_HEADER = struct.Struct("<II")  # as long as a greeting, which comes first


class Cut(NamedTuple):
    """Where a line is cut: after so many messages, or bytes, of both sides."""

    after: int
    midst: bool = False
    """In the midst of that message: its second half is lost."""
    reset: bool = False
    """As by a router that knows nothing of it any more: what was not read yet is lost (of TCP alone)."""
    last: bool = False
    """Nobody listens any more."""


class Messages:
    """The messages of one side; greetings count."""

    def __init__(self):
        self._data = bytearray()
        self._greeted = False

    def add(self, data):
        """(how much it counts, its bytes, what it says) of each that is whole now."""
        self._data += data
        while len(self._data) >= _HEADER.size:
            size, payload = _HEADER.unpack_from(self._data) if self._greeted else (0, 0)
            if len(self._data) < _HEADER.size + size + payload:
                return
            whole = bytes(self._data[:_HEADER.size + size + payload])
            del self._data[:len(whole)]
            self._greeted = True
            yield 1, whole, whole[_HEADER.size:_HEADER.size + size]


class Bytes:
    """The same of what is encrypted: nobody knows what it says."""

    def add(self, data):
        yield len(data), data, b""


class Line:
    """One connection. ``passed``: (time, whose, message) of all that was handed on whole."""

    def __init__(self, ends, cut, pieces, delay, ended):
        self._ends, self._plan, self._delay, self._ended = ends, cut, delay, ended
        self._lock = threading.Lock()
        self.passed, self.count, self.cut_at = [], 0, None
        for whose in ends:
            threading.Thread(target=self._hand_on, args=(whose, pieces()), daemon=True).start()

    def _hand_on(self, whose, pieces):
        try:
            while data := self._ends[whose].recv(1 << 20):
                time.sleep(self._delay)
                for weight, whole, message in pieces.add(data):
                    self._pass(whose, weight, whole, message)
        except OSError:
            pass  # it was cut, or an end went
        self._close()

    def _pass(self, whose, weight, whole, message):
        other = self._ends[SERVER if whose == CLIENT else CLIENT]
        with self._lock:
            if self.cut_at is not None:
                return
            room = self._plan.after - self.count if self._plan else weight + 1
            if room > weight or not self._plan.midst:
                other.sendall(whole if weight == 1 else whole[:room])
                self.passed.append((time.monotonic(), whose, message))
            else:
                other.sendall(whole[:len(whole) // 2])
            self.count += weight
            if room <= weight:
                self._cut()

    def _cut(self):
        self.cut_at = time.monotonic()
        self._close(reset=self._plan is not None and self._plan.reset)
        self._ended(self)

    def _close(self, reset=False):
        for end in self._ends.values():
            try:
                if reset:
                    end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                # Wakes the thread that reads it; what a reset is to lose is not ended in good order.
                end.shutdown(socket.SHUT_RD if reset else socket.SHUT_RDWR)
            except OSError:
                pass  # it is closed
            end.close()

    def cut(self):
        """Now, wherever it is."""
        with self._lock:
            if self.cut_at is None:
                self._cut()

    @property
    def reached(self):
        """Whether it was cut where that was planned."""
        return self._plan is not None and self.count >= self._plan.after

    @property
    def is_last(self):
        return self._plan is not None and self._plan.last


class Proxy:
    """Listens until its end; for a ``with`` statement. ``file``: the connection file that leads to it.

    ``delay``: seconds that each side's bytes are on their way.
    """

    def __init__(self, server_file, folder, delay=0.0):
        content = json.loads(server_file.read_text(encoding="utf-8"))
        kind, _, self._place = content["address"].partition(":")
        self._encrypted, self._delay = kind == "tcp", delay
        self._listener = self._listen(folder)
        content["address"] = self._address
        self.file = folder / "proxy.json"
        self.file.touch(0o600)
        self.file.write_text(json.dumps(content), encoding="utf-8")
        self._cuts, self.lines = [], []
        threading.Thread(target=self._accept, daemon=True).start()

    def _listen(self, folder):
        if self._encrypted:
            listener = socket.create_server(("127.0.0.1", 0))
            self._address = f"tcp:127.0.0.1:{listener.getsockname()[1]}"
            return listener
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(str(folder / "proxy.sock"))
        listener.listen()
        self._address = f"unix:{folder / 'proxy.sock'}"
        return listener

    def _connect(self):
        if not self._encrypted:
            line = socket.socket(socket.AF_UNIX)
            line.connect(self._place)
            return line
        host, port = self._place.rsplit(":", 1)
        line = socket.create_connection((host, int(port)))
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return line

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return  # closed
            ends = {CLIENT: client, SERVER: self._connect()}
            cut = self._cuts.pop(0) if self._cuts else None
            self.lines.append(Line(ends, cut, Bytes if self._encrypted else Messages, self._delay, self._was_cut))

    def _was_cut(self, line):
        if line.is_last:
            self.vanish()

    def plan(self, *cuts):
        """The next lines are cut so, one after the other; those after them are not. Forgets the lines before."""
        self._cuts, self.lines = list(cuts), []

    def vanish(self):
        """Nobody listens here any more."""
        try:
            self._listener.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it was closed before
        self._listener.close()
        if not self._encrypted and os.path.exists(self._address.removeprefix("unix:")):
            os.unlink(self._address.removeprefix("unix:"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.vanish()
        for line in self.lines:
            line.cut()
