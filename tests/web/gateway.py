# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-web as a process, and a browser's side of it that shares no code with it: HTTP and WebSockets over sockets."""
import base64
import hashlib
import os
import pathlib
import re
import select
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("MOTE_BIN", ROOT / "build" / "release" / "bin"))
sys.path.insert(0, str(ROOT / "tests" / "python"))
sys.path.insert(0, str(ROOT / "client" / "python"))

from real_server import RealServer  # noqa: E402

_READY = 60.0


class Web:
    """A mote-web that is ready; for a ``with`` statement. Its page is a folder of two files unless another is said.
    ``trusted``: the certificate by which it speaks TLS."""

    def __init__(self, *options, page=None, trusted=None):
        self.tls = ssl.create_default_context(cafile=trusted) if trusted else None
        self._folder = tempfile.TemporaryDirectory()
        if page is None:
            page = pathlib.Path(self._folder.name)
            (page / "index.html").write_text("<!doctype html><title>page</title>")
            (page / "page.js").write_text("'script'")
        self.page = page
        self.process = subprocess.Popen([str(BIN / "mote-web"), "--page", str(page), *map(str, options)],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0)
        self.url = self.line("ready ")
        found = re.fullmatch(r"https?://([^/]+)(/[^?]*)(?:\?token=(\w+))?", self.url)
        self.host, self.base, self.token = found.groups()
        self.port = int(self.host.rpartition(":")[2]) if ":" in self.host else None

    def line(self, begin):
        """What follows this word on the next line that it prints."""
        readable, _, _ = select.select([self.process.stdout], [], [], _READY)
        text = self.process.stdout.readline().decode() if readable else ""
        if not text.startswith(begin):
            self.process.kill()
            raise RuntimeError(f"not {begin!r} but {text!r}: {self.process.communicate()[1].decode()}")
        return text[len(begin):].strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Its exit code."""
        self.process.terminate()
        code = self.process.wait(30)
        self.process.stdout.close()
        self.process.stderr.close()
        self._folder.cleanup()
        return code

    def memory(self):
        """Resident, KiB."""
        text = pathlib.Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        return int(re.search(r"VmRSS:\s+(\d+)", text)[1])

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def connect(self):
        line = socket.create_connection(("127.0.0.1", self.port), timeout=30)
        return self.tls.wrap_socket(line, server_hostname="localhost") if self.tls else line

    def cookie(self, token=None):
        """What a browser keeps that opened the link."""
        answer = self.ask(f"{self.base}?token={token or self.token}")
        return answer.headers["set-cookie"].partition(";")[0]

    def ask(self, path, method="GET", body=b"", connection=None, **headers):
        """One request and its answer, on a connection of its own."""
        fields = {"Host": self.host, "Connection": "close", **{name.replace("_", "-"): value for name, value in headers.items()}}
        if body:
            fields["Content-Length"] = str(len(body))
        head = f"{method} {path} HTTP/1.1\r\n" + "".join(f"{name}: {value}\r\n" for name, value in fields.items())
        with connection or self.connect() as line:
            line.sendall(head.encode() + b"\r\n" + body)
            return Answer.read(line)

    def socket(self, cookie=None, path=None, connection=None, **headers):
        """A WebSocket that was accepted, or the answer that refused it."""
        fields = {"Host": self.host, "Origin": f"{self.url.partition(':')[0]}://{self.host}", **{name.replace("_", "-"): value for name, value in headers.items()}}
        if cookie:
            fields["Cookie"] = cookie
        line = connection or self.connect()
        return WebSocket.open(line, path or f"{self.base}ws", {name: value for name, value in fields.items() if value})

    def opens(self, *arguments, **more):
        """Whether there is a WebSocket for who asks so."""
        made = self.socket(*arguments, **more)
        if isinstance(made, WebSocket):
            made.close()
        return isinstance(made, WebSocket)


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @classmethod
    def read(cls, line):
        data = b""
        while True:
            try:
                part = line.recv(65536)
            except (ConnectionResetError, ssl.SSLEOFError):
                break
            if not part:
                break
            data += part
        head, _, body = data.partition(b"\r\n\r\n")
        return cls.parse(head, body)

    @classmethod
    def parse(cls, head, body=b""):
        first, *fields = head.decode("latin-1").split("\r\n")
        status = int(first.split(" ")[1]) if first else 0
        headers = {name.strip().lower(): value.strip() for name, _, value in (field.partition(":") for field in fields)}
        return cls(status, headers, body)


class Closed(Exception):
    """The other side closed the WebSocket."""

    def __init__(self, code, reason):
        super().__init__(f"{code} {reason}")
        self.code, self.reason = code, reason


class WebSocket:
    """RFC 6455, a client's side."""

    def __init__(self, line):
        self.line, self.bytes = line, b""

    @classmethod
    def open(cls, line, path, fields):
        key = base64.b64encode(os.urandom(16)).decode()
        fields = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Key": key, "Sec-WebSocket-Version": "13",
                  "Sec-WebSocket-Protocol": "mote.1", **fields}
        head = f"GET {path} HTTP/1.1\r\n" + "".join(f"{name}: {value}\r\n" for name, value in fields.items())
        line.sendall(head.encode() + b"\r\n")
        made = cls(line)
        while b"\r\n\r\n" not in made.bytes:
            part = line.recv(65536)
            if not part:
                break
            made.bytes += part
        answer, _, made.bytes = made.bytes.partition(b"\r\n\r\n")
        answer = Answer.parse(answer)
        if answer.status != 101:
            line.close()
            return answer
        expected = hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()
        assert answer.headers["sec-websocket-accept"] == base64.b64encode(expected).decode()
        return made

    def close(self):
        self.line.close()

    def send(self, data, opcode=2):
        mask = os.urandom(4)
        size = len(data)
        head = bytes([0x80 | opcode])
        if size < 126:
            head += bytes([0x80 | size])
        elif size < 65536:
            head += struct.pack(">BH", 0x80 | 126, size)
        else:
            head += struct.pack(">BQ", 0x80 | 127, size)
        masked = bytes(byte ^ mask[i & 3] for i, byte in enumerate(data))
        try:
            self.line.sendall(head + mask + masked)
        except ConnectionError as error:  # it has not read to the end
            raise Closed(1006, "without a word") from error

    def _take(self, count):
        while len(self.bytes) < count:
            try:
                part = self.line.recv(1 << 20)
            except ConnectionResetError:
                part = b""
            if not part:
                raise Closed(1006, "without a word")
            self.bytes += part
        taken, self.bytes = self.bytes[:count], self.bytes[count:]
        return taken

    def receive(self):
        """One message: (opcode, bytes). Raises Closed."""
        whole, kind = b"", 0
        while True:
            first, second = self._take(2)
            assert second & 0x80 == 0, "a server masks nothing"
            size = second & 0x7F
            if size == 126:
                size, = struct.unpack(">H", self._take(2))
            elif size == 127:
                size, = struct.unpack(">Q", self._take(8))
            data = self._take(size)
            opcode = first & 15
            if opcode == 8:
                raise Closed(struct.unpack(">H", data[:2])[0] if len(data) > 1 else 1005, data[2:].decode())
            if opcode == 9:
                self.send(data, 10)
                continue
            kind = opcode or kind
            whole += data
            if first & 0x80:
                return kind, whole


def frame(message):
    """A message of the protocol as it travels."""
    data = message.SerializeToString()
    return struct.pack("<II", len(data), 0) + data


class WebCase(unittest.TestCase):
    """With a mote-server of the class's own, whose data are a small beam."""

    @classmethod
    def setUpClass(cls):
        if not (BIN / "mote-web").exists():
            raise unittest.SkipTest(f"mote-web is not in {BIN}")
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        (cls.folder / "data").mkdir()
        for words in (["synth", "beam", "--particles", "20000", "--steps", "3", "--seed", "1", "--out", cls.folder / "run.h5"],
                      ["particles", cls.folder / "run.h5", "--axes", "x,px,y", "--out", cls.folder / "data" / "beam.mote"]):
            subprocess.run([str(BIN / "mote-prep"), *map(str, words), "--quiet"], check=True, capture_output=True)
        cls.server = RealServer(BIN / "mote-server", cls.folder)
        cls.addClassCleanup(cls.server.close)

    def web(self, *options, **more):
        web = Web("--connect", self.server.file, *options, **more)
        self.addCleanup(web.close)
        return web
