# SPDX-License-Identifier: GPL-3.0-or-later
"""A real server that listens on TCP, and ends of connections to it that do as they please."""
import socket
import ssl
import struct

from real_server import RealServer

GREETING = struct.pack("<4sHH", b"MOTE", 1, 3)


class TlsServer(RealServer):
    """On a port of the loopback device, which is ``place``."""

    def __init__(self, program, folder, *options):
        super().__init__(program, folder, "--listen", "tcp:127.0.0.1:0", *options)
        host, port = self.content["address"].removeprefix("tcp:").rsplit(":", 1)
        self.place = (host, int(port))

    def connect(self):
        """A TCP connection on which nothing was said."""
        line = socket.create_connection(self.place, 60)
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return line


def context(version=ssl.TLSVersion.TLSv1_3):
    """Of a client that believes every certificate."""
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    made.check_hostname, made.verify_mode = False, ssl.CERT_NONE
    made.minimum_version = made.maximum_version = version
    return made


def frame(message):
    """A message of a client as it goes over the wire."""
    data = message.SerializeToString()
    return struct.pack("<II", len(data), 0) + data


class Recorded:
    """What a client says up to its hello, as TLS makes it, with a way to stop after any byte."""

    def __init__(self, line, hello):
        self._line, self._hello = line, hello
        self._in, self._out = ssl.MemoryBIO(), ssl.MemoryBIO()
        self._tls = context().wrap_bio(self._in, self._out)
        self.sent = 0

    def _send(self, limit):
        data = self._out.read()[:max(0, limit - self.sent)]
        self._line.sendall(data)
        self.sent += len(data)
        return self.sent < limit

    def _handshake(self, limit):
        while True:
            try:
                self._tls.do_handshake()
                return self._send(limit)
            except ssl.SSLWantReadError:
                if not self._send(limit):
                    return False
                received = self._line.recv(65536)
                if not received:
                    return False
                self._in.write(received)

    def send(self, limit):
        """Up to that many bytes; whether there was more to say."""
        if not self._handshake(limit):
            return True
        self._tls.write(GREETING + frame(self._hello))
        return not self._send(limit)
