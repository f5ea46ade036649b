# SPDX-License-Identifier: GPL-3.0-or-later
"""A server that says what a test wants it to say, lies and half sentences too.

A test gives a function of (peer, message); it is called for each message of a client, the hello left out. Written from
docs/PROTOCOL.md and not from the package, so that both do not share a mistake; only the messages' classes are shared.
"""
import json
import os
import shutil
import socket
import struct
import tempfile
import threading

from mote import messages

TOKEN = "0123456789abcdef" * 4


class Peer:
    """One client, on the server's side."""

    def __init__(self, line):
        self.line = line

    def send_bytes(self, data):
        self.line.sendall(data)

    def send(self, message, payload=b""):
        data = message.SerializeToString()
        self.send_bytes(struct.pack("<II", len(data), len(payload)) + data + bytes(payload))

    def reply(self, asked, body, payload=b"", **fields):
        """A message that answers another."""
        message = messages.new("ServerMessage")
        message.reply_to = asked.request
        target = getattr(message, body)
        target.SetInParent()
        for name, value in fields.items():
            setattr(target, name, value)
        self.send(message, payload)
        return message

    def fail(self, asked, code, where, sentence, fatal=False):
        self.reply(asked, "failure", code=code, where=where, message=sentence, fatal=fatal)

    def take(self, count):
        data = b""
        while len(data) < count:
            piece = self.line.recv(count - len(data))
            if not piece:
                raise EOFError
            data += piece
        return data

    def hear(self):
        """The next message of the client. Raises EOFError."""
        message, payload = struct.unpack("<II", self.take(8))
        assert payload == 0
        return messages.parse("ClientMessage", self.take(message))

    def hang_up(self):
        self.line.shutdown(socket.SHUT_RDWR)


class FakeServer:
    """As a context manager; ``file`` is its connection file."""

    def __init__(self, answer=lambda peer, message: None, greeting=struct.pack("<4sHH", b"MOTE", 1, 2), welcome=True,
                 minor=2, more=lambda hello: {}):
        """``more``: what else a welcome says, by the hello that it answers; a tuple: the failure that it is instead."""
        self.answer, self.greeting, self.welcome, self.minor, self.more = answer, greeting, welcome, minor, more
        self.folder = tempfile.mkdtemp(prefix="mote-fake-")
        self.file = os.path.join(self.folder, "connection.json")
        self.socket_path = os.path.join(self.folder, "s")
        self.said = []  # by all clients
        self.hellos = []
        self.connections = 0
        self.errors = []
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(self.socket_path)
        self._listener.listen()
        self._peers, self._threads = [], []
        self.write_file()
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    def write_file(self, mode=0o600, **changed):
        content = {"address": "unix:" + self.socket_path, "token": TOKEN, "pid": str(os.getpid()), "protocolMajor": 1,
                   "protocolMinor": 2, **changed}
        with open(self.file, "w", encoding="utf-8") as file:
            json.dump(content, file)
        os.chmod(self.file, mode)

    def _accept(self):
        while True:
            try:
                line, _ = self._listener.accept()
            except OSError:
                return
            self.connections += 1
            self._peers.append(line)
            thread = threading.Thread(target=self._serve, args=(Peer(line),), daemon=True)
            self._threads.append(thread)
            thread.start()

    def _serve(self, peer):
        try:
            peer.send_bytes(self.greeting)
            if peer.take(8)[:4] != b"MOTE":
                raise AssertionError("the client greets in another way")
            hello = peer.hear()
            self.hellos.append(hello)
            if not self.welcome:
                return
            if hello.hello.token != TOKEN:
                peer.fail(hello, "permission_denied", "hello.token", "the token is not this server's", fatal=True)
                return
            more = self.more(hello.hello)
            if isinstance(more, tuple):
                peer.fail(hello, *more, fatal=True)
                return
            peer.reply(hello, "welcome", server="fake", minor=self.minor, device="paper", frame_credits=2, **more)
            while True:
                message = peer.hear()
                self.said.append(message)
                self.answer(peer, message)
        except (EOFError, OSError):
            pass
        except BaseException as failure:  # shown by the test that looks
            self.errors.append(failure)
        finally:
            peer.line.close()

    def bodies(self):
        """What clients said, by name."""
        return [message.WhichOneof("body") for message in self.said]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self._listener.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._listener.close()
        for line in self._peers:
            try:
                line.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        for thread in [self._thread, *self._threads]:
            thread.join(10)
        shutil.rmtree(self.folder, ignore_errors=True)
        if self.errors:
            raise self.errors[0]
