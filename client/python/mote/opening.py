# SPDX-License-Identifier: GPL-3.0-or-later
"""How the socket of a line is opened: to a Unix socket as it is, over TCP by TLS 1.3 alone, with the certificate whose
fingerprint the connection file says (docs/PROTOCOL.md, "TCP and TLS")."""
from __future__ import annotations

import hashlib
import hmac
import socket
import ssl
from typing import Union

from .errors import Error
from .wire import Place

_CONNECT_TIMEOUT = 10.0
_NO_PLACE = "TLSV1_ALERT_INTERNAL_ERROR"


class EncryptedSocket:
    """A TLS connection that does not block, as a Line uses it."""

    def __init__(self, line: ssl.SSLSocket) -> None:
        self._line = line
        self.fileno, self.close, self.pending = line.fileno, line.close, line.pending

    def send(self, data: memoryview, _flags: int = 0) -> int:
        """Raises BlockingIOError where nothing can be sent now."""
        try:
            return self._line.send(data)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            raise BlockingIOError from None

    def recv_into(self, buffer: memoryview) -> int:
        """Raises BlockingIOError where there is nothing now."""
        try:
            return self._line.recv_into(buffer)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            raise BlockingIOError from None


AnySocket = Union[socket.socket, EncryptedSocket]


def _connect(place: Place) -> socket.socket:
    if place.tcp:
        line = socket.create_connection(place.tcp, _CONNECT_TIMEOUT)
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return line
    line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        line.settimeout(_CONNECT_TIMEOUT)
        line.connect(place.address)
    except BaseException:
        line.close()
        raise
    return line


def _encrypt(line: socket.socket, place: Place) -> ssl.SSLSocket:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    # The fingerprint says more than any authority, and is looked at before anything is said.
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    encrypted = context.wrap_socket(line)
    certificate = encrypted.getpeercert(binary_form=True) or b""
    if not hmac.compare_digest(hashlib.sha256(certificate).hexdigest(), place.fingerprint):
        encrypted.close()
        raise Error("permission_denied", place.address, "its certificate is not the one whose fingerprint the connection "
                    "file says: this is another server, or somebody stands in between")
    return encrypted


def open_socket(place: Place) -> AnySocket:
    """Raises Error where nobody listens, or the server is another one."""
    try:
        line = _connect(place)
        if not place.tcp:
            line.setblocking(False)
            return line
        try:
            encrypted = _encrypt(line, place)
            encrypted.setblocking(False)
            return EncryptedSocket(encrypted)
        except BaseException:
            line.close()
            raise
    except (FileNotFoundError, ConnectionRefusedError):
        raise Error("not_found", place.address, "no server listens here; is it still running?") from None
    except PermissionError:
        raise Error("permission_denied", place.address, "this server is another user's") from None
    except (ssl.SSLEOFError, ssl.SSLZeroReturnError):
        # A line that broke, like any other: who comes back tries again.
        raise Error("internal", place.address, "the server closed the connection while it was opened") from None
    except ssl.SSLError as failure:
        if failure.reason == _NO_PLACE:
            raise Error("resource_exhausted", "server", "too many connections that have shown no token are there; "
                        "try again") from None
        raise Error("unsupported", place.address, f"no TLS 1.3 with this server: {failure.reason}") from None
    except OSError as failure:
        raise Error("internal", place.address, f"no connection to the server: {failure.strerror or failure}") from None
