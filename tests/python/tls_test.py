# SPDX-License-Identifier: GPL-3.0-or-later
"""The real server over TCP: TLS 1.3 and the right certificate and token, or nothing."""
import json
import os
import pathlib
import shutil
import socket
import ssl
import subprocess
import tempfile
import threading
import unittest

from support import BIN, Case, make_beam, mote, needs_server  # isort: skip
from mote.messages import new  # isort: skip
from mote.opening import open_socket  # isort: skip
from mote.wire import Place  # isort: skip
from tls_server import TlsServer, Recorded, context, frame, GREETING  # isort: skip

SCRIPT = {"views": [{"width": 96, "height": 64, "layers": [{"dataset": "data/beam", "particles": {
    "volume": {"curve": [{"density": 0.4, "opacity": 0}, {"density": 1, "opacity": 0.3}], "colorMap": "inferno"},
    "points": {"linked": True, "opacity": 0.6, "sizePixels": 1, "color": [1.0, 0.85, 0.6]}}}]}]}


def hello(token):
    message = new("ClientMessage")
    message.hello.token = token
    return message


@needs_server
class WithTls(Case):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "data").mkdir()
        make_beam(cls.folder / "data")
        cls.server = TlsServer(BIN / "mote-server", cls.folder)
        cls.addClassCleanup(cls.server.close)

    def write(self, **changed):
        """A connection file like the server's, but for this."""
        file = self.folder / "other.json"
        file.write_text(json.dumps({**self.server.content, **changed}))
        os.chmod(file, 0o600)
        return file

    def frames(self, file, name):
        """What mote-frames says and draws by a connection file."""
        script, out = self.folder / "script.json", self.folder / name
        script.write_text(json.dumps(SCRIPT))
        done = subprocess.run([BIN / "mote-frames", script, "--connect", file, "--out", out], capture_output=True, text=True,
                              timeout=60)
        pictures = [path.read_bytes() for path in sorted(out.glob("*.png"))] if out.exists() else []
        return done, pictures

    def still_serves(self):
        with mote.connect(self.server.file) as session:
            self.assertIn("data/beam", session.datasets)


class Pictures(WithTls):
    def test_are_the_same_as_over_a_unix_socket(self):
        encrypted, over_tcp = self.frames(self.server.file, "tcp")
        self.assertEqual(encrypted.returncode, 0, encrypted.stderr)
        plain, over_unix = self.frames(self.write(address=f"unix:{self.folder}/state/mote.sock"), "unix")
        self.assertEqual(plain.returncode, 0, plain.stderr)
        self.assertEqual(over_tcp, over_unix)
        self.assertEqual(len(over_tcp), 1)

    def test_of_python_come_over_it_too(self):
        with mote.connect(self.server.file) as session:
            (x,) = session["data/beam"].get(["x"], step=0)
            self.assertGreater(len(x), 1000)
            picture = mote.View(session["data/beam"], size=(400, 300)).render()
            self.assertEqual(picture.array.shape[:2], (300, 400))


class Refused(WithTls):
    def test_another_certificate(self):
        other = self.write(certificateFingerprint="ab" * 32)
        with self.fails("permission_denied", words="certificate"):
            mote.connect(other)
        done, pictures = self.frames(other, "refused")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("fingerprint", done.stderr)
        self.assertEqual(pictures, [])
        self.still_serves()

    def test_no_certificate(self):
        other = self.write(certificateFingerprint="")
        with self.fails("invalid_argument", words="fingerprint"):
            mote.connect(other)
        done, _ = self.frames(other, "refused")
        self.assertNotEqual(done.returncode, 0)

    def test_a_wrong_token(self):
        other = self.write(token="00" * 32)
        with self.fails("permission_denied", words="token"):
            mote.connect(other)
        done, _ = self.frames(other, "refused")
        self.assertIn("token", done.stderr)
        self.still_serves()

    def test_older_versions_of_tls(self):
        with self.server.connect() as line, self.assertRaises(ssl.SSLError):
            context(ssl.TLSVersion.TLSv1_2).wrap_socket(line)
        self.still_serves()

    def test_who_speaks_no_tls(self):
        with self.server.connect() as line:
            line.sendall(GREETING + frame(hello(self.server.content["token"])))
            answer = b""
            while piece := receive(line):
                answer += piece
            self.assertNotIn(b"MOTE", answer)
        self.still_serves()


def receive(line):
    """Nothing at the end, however it came."""
    try:
        return line.recv(4096)
    except ConnectionResetError:
        return b""


class CutShort(WithTls):
    def test_a_handshake_after_each_byte(self):
        limit, more = 0, True
        while more:
            with self.server.connect() as line:
                more = Recorded(line, hello(self.server.content["token"])).send(limit)
                line.shutdown(socket.SHUT_WR)
                if more:
                    while receive(line):
                        pass  # whatever it says, it ends
            limit += 1
        self.assertGreater(limit, 300)  # a ClientHello alone takes more than 200
        self.still_serves()


class HandshakeThatBreaks(Case):
    def test_is_a_line_that_broke_and_no_lack_of_tls(self):
        for answer in (b"", b"\x16\x03\x03\x00\x7a\x02"):  # the beginning of a ServerHello
            with socket.create_server(("127.0.0.1", 0)) as listener:
                def serve(listener=listener, answer=answer):
                    line, _ = listener.accept()
                    line.recv(4096)
                    line.sendall(answer)
                    line.close()

                server = threading.Thread(target=serve)
                server.start()
                with self.fails("internal", words="closed"):  # after which who comes back tries again
                    open_socket(Place("tcp:here", "00", 0, listener.getsockname(), "00" * 32))
                server.join()


@needs_server
class Certificate(Case):
    def test_stays_when_the_server_goes(self):
        with tempfile.TemporaryDirectory() as folder:
            with TlsServer(BIN / "mote-server", folder) as one:
                mote.connect(one.file).close()
                self.assertEqual(one.close(), 0)
            with TlsServer(BIN / "mote-server", folder) as two:
                mote.connect(two.file).close()
            self.assertEqual(one.content["certificateFingerprint"], two.content["certificateFingerprint"])
            self.assertNotEqual(one.content["token"], two.content["token"])


if __name__ == "__main__":
    unittest.main()
