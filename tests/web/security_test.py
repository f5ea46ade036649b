# SPDX-License-Identifier: GPL-3.0-or-later
"""Who gets into mote-web and who does not; and that who does harm harms nobody else. docs/WEB.md, "What is checked"."""
import http.cookies
import json
import os
import pathlib
import re
import resource
import signal
import socket
import ssl
import subprocess
import time
import unittest

from gateway import BIN, ROOT, Answer, Closed, WebCase, WebSocket, frame  # isort: skip
from mote.messages import new  # noqa: E402


def hello(**fields):
    message = new("ClientMessage")
    message.hello.client, message.hello.minor = "test", 3
    for name, value in fields.items():
        setattr(message.hello, name, value)
    return message


def messages(web_socket, most=1000):
    """What the server says, message after message."""
    for _ in range(most):
        kind, data = web_socket.receive()
        if kind == 2:
            size = int.from_bytes(data[:4], "little")
            message = new("ServerMessage")
            message.ParseFromString(data[8:8 + size])
            yield message, data[8 + size:]


def wait_for(web_socket, kind):
    return next(found for found in messages(web_socket) if found[0].WhichOneof("body") == kind)


class Entrance(WebCase):
    def test_without_a_token_everything_is_forbidden(self):
        web = self.web()
        for path in ("/", "/index.html", "/page.js", "/ws", "/nothing", "/?token=", "/?token=" + 64 * "0"):
            self.assertEqual(web.ask(path).status, 403, path)
        self.assertEqual(web.ask("/link", "POST", b"owner", Origin=f"http://{web.host}").status, 403)
        self.assertEqual(web.socket().status, 403)
        # A wrong guess uses nothing up.
        self.assertEqual(web.ask(f"/?token={web.token}").status, 200)

    def test_a_token_gives_a_cookie_once(self):
        web = self.web()
        answer = web.ask(f"/?token={web.token}")
        self.assertEqual(answer.status, 200)
        self.assertIn(b"<title>page</title>", answer.body)
        self.assertEqual(answer.headers["cache-control"], "no-store")
        cookie = http.cookies.SimpleCookie(answer.headers["set-cookie"])
        (name, morsel), = cookie.items()
        self.assertTrue(morsel["httponly"])
        self.assertEqual(morsel["samesite"], "Strict")
        # Browsers then take the folder of the page, whatever a proxy made of it.
        self.assertEqual((morsel["path"], morsel["domain"]), ("", ""))
        self.assertNotIn(web.token, morsel.value)
        self.assertEqual(web.ask(f"/?token={web.token}").status, 403, "a token that was used")
        self.assertEqual(web.ask("/page.js", Cookie=f"{name}={morsel.value}").status, 200)
        self.assertEqual(web.ask("/page.js", Cookie=f"{name}={morsel.value[:-1]}x").status, 403)
        self.assertEqual(web.ask("/page.js", Cookie=f"other={morsel.value}").status, 403)
        self.assertEqual(web.ask("/page.js", Cookie=f"a=b; {name}={morsel.value}; c=d").status, 200)

    def test_the_next_link_is_told_when_one_was_used(self):
        web = self.web()
        web.cookie()
        again = web.line("link ").partition("?token=")[2]
        self.assertEqual(web.ask(f"/?token={again}").status, 200)

    def test_the_cookie_is_secure_behind_https(self):
        web = self.web()
        self.assertIn("; Secure", web.ask(f"/?token={web.token}", X_Forwarded_Proto="https").headers["set-cookie"])

    def test_other_hosts_are_refused(self):
        web = self.web()
        cookie = web.cookie()
        for host in ("evil.example", f"evil.example:{web.port}", "127.0.0.1.evil.example", "", "localhost@evil", "10.0.0.1"):
            self.assertEqual(web.ask("/", Cookie=cookie, Host=host).status, 403, host)
        for host in (web.host, f"localhost:{web.port}", f"[::1]:{web.port}", "localhost:8888"):
            self.assertEqual(web.ask("/", Cookie=cookie, Host=host).status, 200, host)

    def test_other_origins_open_no_socket(self):
        web = self.web()
        cookie = web.cookie()
        for origin in ("http://evil.example", f"http://evil.example:{web.port}", "null", "file://", "http://localhost:1",
                       f"http://{web.host}.evil.example", None):
            answer = web.socket(cookie, Origin=origin)
            self.assertIsInstance(answer, Answer, origin)
            self.assertEqual(answer.status, 403, origin)
        self.assertTrue(web.opens(cookie))

    def test_an_origin_that_was_named_opens_one(self):
        web = self.web("--origin", "https://hub.example.org")
        self.assertEqual((web.host, web.base), ("hub.example.org", "/"))
        web.port = int(web.line("listens at ").rpartition(":")[2])
        cookie = web.cookie()
        self.assertTrue(web.opens(cookie, Origin="https://hub.example.org"))
        # A proxy may ask by our own name: the page is still the hub's.
        self.assertTrue(web.opens(cookie, Host=f"127.0.0.1:{web.port}", Origin="https://hub.example.org"))
        self.assertFalse(web.opens(cookie, Origin="https://other.example.org"))
        self.assertEqual(web.ask("/", Cookie=cookie, Host="other.example.org").status, 403)

    def test_nobody_frames_it(self):
        web = self.web()
        policy = web.ask(f"/?token={web.token}").headers
        self.assertIn("frame-ancestors 'self'", policy["content-security-policy"])
        self.assertEqual(policy["x-frame-options"], "SAMEORIGIN")
        named = self.web("--frame-ancestor", "http://localhost:8888")
        policy = named.ask(f"/?token={named.token}").headers
        self.assertIn("frame-ancestors 'self' http://localhost:8888", policy["content-security-policy"])
        self.assertNotIn("x-frame-options", policy)

    def test_the_policy_allows_no_foreign_and_no_inline_code(self):
        web = self.web()
        for path in (f"/?token={web.token}", "/page.js"):
            headers = web.ask(path).headers
            policy = headers["content-security-policy"]
            self.assertIn("default-src 'none'", policy)
            for word in ("unsafe-inline", "'unsafe-eval'", "data:", " * ", "https:"):
                self.assertNotIn(word, policy)
            self.assertEqual(headers["x-content-type-options"], "nosniff")
            self.assertEqual(headers["referrer-policy"], "no-referrer")
        html = (ROOT / "client" / "web" / "page" / "index.html").read_text()
        self.assertNotRegex(html, r"<script(?![^>]*\bsrc=)")
        self.assertNotRegex(html, r"\s(?:on\w+|style)=")
        self.assertNotRegex(html, r"(?:src|href)=\"(?:/|https?:)")

    def test_files_beyond_the_page_are_not_there(self):
        web = self.web()
        cookie = web.cookie()
        for path in ("/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/.", "/index.html/"):
            self.assertEqual(web.ask(path, Cookie=cookie).status, 404, path)
        self.assertEqual(web.ask("/", "DELETE", Cookie=cookie).status, 405)
        self.assertEqual(web.ask("/ws", Cookie=cookie).status, 426)

    def test_long_and_broken_requests_end(self):
        web = self.web()
        for data in (b"GET / HTTP/1.1\r\nHost: " + 40_000 * b"a" + b"\r\n\r\n", b"\x16\x03\x01\x02\x00\x01", b"GET\r\n\r\n",
                     b"POST /link HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\n"):
            with web.connect() as line:
                line.sendall(data)
                self.assertEqual(Answer.read(line).status, 0)
        self.assertEqual(web.ask(f"/?token={web.token}").status, 200)

    def test_wrong_usage_is_told(self):
        for words in (["--no-token"], ["--tls-key", "key.pem"], ["--base-url", "x"], ["--origin", "hub"], ["--listen", "nowhere"], ["--listen", "127.0.0.1:x"],
                      ["--frame-ancestor", "*"], ["--spawn", "data=/tmp"]):
            run = subprocess.run([BIN / "mote-web", "--connect", self.server.file, *words], capture_output=True, text=True)
            self.assertEqual(run.returncode, 2, words)
            self.assertIn(words[0], run.stderr)
        run = subprocess.run([BIN / "mote-web", "--connect", "/nowhere.json", "--page", str(ROOT / "client/web/page")],
                             capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stderr.count("\n")), (1, 1), run.stderr)


class Proxies(WebCase):
    def test_one_that_keeps_the_prefix(self):
        web = self.web("--base-url", "/node/n1/80/")
        self.assertEqual(web.ask(f"/node/n1/80/?token={web.token}").status, 200)
        cookie = web.cookie(web.line("link ").partition("?token=")[2])
        self.assertEqual(web.ask("/node/n1/80/page.js", Cookie=cookie).status, 200)
        self.assertTrue(web.opens(cookie, "/node/n1/80/ws"))
        moved = web.ask("/node/n1/80", Cookie=cookie)
        self.assertEqual((moved.status, moved.headers["location"]), (308, "/node/n1/80/"))

    def test_one_that_strips_it(self):
        for options in ((), ("--base-url", "/node/n1/80/")):
            web = self.web(*options)
            cookie = web.cookie()
            self.assertEqual(web.ask("/page.js", Cookie=cookie).status, 200)
            self.assertTrue(web.opens(cookie, "/ws"))

    def test_a_socket_for_a_proxy_that_knows_its_user(self):
        path = self.folder / "web.sock"
        web = self.web("--listen", f"unix:{path}", "--no-token")
        self.assertEqual(os.stat(path).st_mode & 0o777, 0o600)

        def connect():
            line = socket.socket(socket.AF_UNIX)
            line.settimeout(30)
            line.connect(str(path))
            return line

        hub = {"Host": "hub.example.org"}
        self.assertEqual(web.ask("/", connection=connect(), **hub).status, 200)
        self.assertTrue(web.opens(None, connection=connect(), Origin="https://hub.example.org", **hub))
        # A proxy that rewrites Host says whose it was.
        self.assertTrue(web.opens(None, connection=connect(), Origin="https://hub.example.org", Host="localhost",
                                         X_Forwarded_Host="hub.example.org"))
        self.assertEqual(web.socket(None, connection=connect(), Origin="https://evil.example", **hub).status, 403)
        # A second one does not take it away.
        run = subprocess.run([BIN / "mote-web", "--connect", self.server.file, "--page", web.page, "--listen", f"unix:{path}"],
                             capture_output=True, text=True, timeout=30)
        self.assertEqual(run.returncode, 1)
        self.assertIn(str(path), run.stderr)
        self.assertEqual(web.ask("/", connection=connect(), **hub).status, 200)
        web.close()
        self.assertFalse(path.exists())


class Encrypted(WebCase):
    """TLS of its own, by a certificate that OpenSSL's program made."""

    def certificate(self, name):
        key, certificate = self.folder / f"{name}.key", self.folder / f"{name}.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext",
                        "subjectAltName=DNS:localhost", "-keyout", key, "-out", certificate], check=True, capture_output=True)
        return certificate, key

    def test_browsers_speak_https_and_nothing_else(self):
        certificate, key = self.certificate("own")
        web = self.web("--tls-certificate", certificate, "--tls-key", key, trusted=certificate)
        self.assertTrue(web.url.startswith("https://"))
        answer = web.ask(f"/?token={web.token}")
        self.assertEqual(answer.status, 200)
        self.assertTrue(http.cookies.SimpleCookie(answer.headers["set-cookie"]).popitem()[1]["secure"])
        cookie = web.cookie(web.line("link https://").partition("?token=")[2])
        web_socket = web.socket(cookie)
        self.addCleanup(web_socket.close)
        web_socket.send(frame(hello()))
        wait_for(web_socket, "welcome")
        self.assertFalse(web.opens(cookie, Origin="https://evil.example"))
        trusting, web.tls = web.tls, None
        self.assertEqual(web.ask("/page.js", Cookie=cookie).status, 0)  # in the clear
        web.tls = trusting
        web.tls.maximum_version = ssl.TLSVersion.TLSv1_2
        with self.assertRaises(ssl.SSLError):
            web.connect()

    def test_who_does_not_shake_hands_is_dropped(self):
        certificate, key = self.certificate("slow")
        web = self.web("--tls-certificate", certificate, "--tls-key", key, trusted=certificate)
        cookie = web.cookie()
        silent = [socket.create_connection(("127.0.0.1", web.port)) for _ in range(600)]
        self.addCleanup(lambda: [line.close() for line in silent])
        self.assertEqual(web.ask("/page.js", Cookie=cookie).status, 200)
        self.assertLess(web.descriptors(), 400)

    def test_files_that_do_not_fit_are_told(self):
        (certificate, key), (_, other) = self.certificate("one"), self.certificate("two")
        locked = self.folder / "locked.key"
        subprocess.run(["openssl", "rsa", "-in", key, "-aes128", "-passout", "pass:secret", "-out", locked], check=True, capture_output=True)
        page = self.folder / "page"
        page.mkdir(exist_ok=True)
        (page / "index.html").write_text("page")
        for words, named in (([key], key), ([certificate], certificate), ([certificate, "--tls-key", other], other),
                             ([certificate, "--tls-key", locked], locked), (["/nowhere.pem"], "/nowhere.pem")):
            run = subprocess.run([BIN / "mote-web", "--connect", self.server.file, "--page", page, "--tls-certificate", *words],
                                 capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=30)
            self.assertEqual((run.returncode, run.stderr.count("\n")), (1, 1), run.stderr)
            self.assertIn(str(named), run.stderr)


class Bridge(WebCase):
    def opened(self, web, cookie=None, **fields):
        web_socket = web.socket(cookie or web.cookie())
        self.addCleanup(web_socket.close)
        web_socket.send(frame(hello(**fields)))
        return web_socket

    def test_a_hello_is_answered_and_the_servers_token_stays_away(self):
        web = self.web()
        web_socket = self.opened(web, token="guess")
        kind, words = web_socket.receive()
        self.assertEqual((kind, json.loads(words)), (1, {"role": "owner"}))
        kind, data = web_socket.receive()
        self.assertEqual(kind, 2)
        self.assertNotIn(self.server.content["token"].encode(), data)
        message = new("ServerMessage")
        message.ParseFromString(data[8:])
        self.assertEqual(message.WhichOneof("body"), "welcome")

    def test_a_picture_comes_whole(self):
        web = self.web()
        web_socket = self.opened(web)
        wait_for(web_socket, "welcome")
        message = new("ClientMessage")
        message.request = 7
        view = message.set_view
        view.view.width, view.view.height, view.view_id, view.final_only = 320, 200, 1, True
        layer = view.view.layers.add()
        layer.dataset = "data/beam"
        layer.particles.SetInParent()
        web_socket.send(frame(message))
        answer, payload = wait_for(web_socket, "frame")
        self.assertTrue(answer.frame.final)
        self.assertEqual((answer.frame.width, answer.frame.height), (320, 200))
        from mote.pixels import decode_frame
        direct = self.direct(view.view)
        self.assertEqual(decode_frame(answer.frame, payload).tobytes(), direct)

    def direct(self, view):
        """The same picture by the package's own line."""
        import mote
        with mote.connect(self.server.file) as session:
            return mote.View.from_dict(session, {"width": view.width, "height": view.height,
                                                 "layers": [{"dataset": "data/beam", "particles": {}}]}).render().array.tobytes()

    def test_what_is_no_message_ends_the_socket(self):
        web = self.web()
        cookie = web.cookie()
        job = new("ClientMessage")
        job.list_datasets.SetInParent()
        long = hello(client=5000 * "x")
        for data in (b"", b"MOTE", b"\x05\0\0\0\0\0\0\0ab", b"\0\0\0\0\x01\0\0\0x", frame(job), frame(long), 9 * b"\xff"):
            web_socket = web.socket(cookie)
            self.addCleanup(web_socket.close)
            web_socket.send(data)
            with self.assertRaises(Closed) as closed:
                for _ in messages(web_socket):
                    pass
            self.assertEqual(closed.exception.code, 1008, data[:20])
        self.assertEqual(self.opened(web, cookie).receive()[0], 1)

    def test_a_message_of_more_than_a_mebibyte_ends_it(self):
        web = self.web()
        web_socket = self.opened(web)
        wait_for(web_socket, "welcome")
        with self.assertRaises(Closed) as closed:
            web_socket.send(b"\0" * ((1 << 20) + 100))
            for _ in messages(web_socket):
                pass
        self.assertIn(closed.exception.code, (1009, 1006, 1011))

    def test_followers_look_and_do_nothing(self):
        web = self.web()
        owner = web.cookie()
        answer = web.ask("/link", "POST", b"follower", Cookie=owner, Origin=f"http://{web.host}")
        self.assertEqual(answer.status, 200)
        follower = web.cookie(json.loads(answer.body)["token"])
        self.assertNotEqual(owner, follower)
        self.assertEqual(web.ask("/link", "POST", b"owner", Cookie=follower, Origin=f"http://{web.host}").status, 403)
        self.assertEqual(web.ask("/link", "POST", b"owner", Cookie=owner, Origin="http://evil.example").status, 403)
        web_socket = self.opened(web, follower)
        self.assertEqual(json.loads(web_socket.receive()[1]), {"role": "follower"})
        wait_for(web_socket, "welcome")
        message = new("ClientMessage")
        message.request = 1
        message.list_datasets.SetInParent()
        web_socket.send(frame(message))
        wait_for(web_socket, "catalogue")
        message = new("ClientMessage")
        message.cancel_job.id = "1"
        web_socket.send(frame(message))
        with self.assertRaises(Closed) as closed:
            for _ in messages(web_socket):
                pass
        self.assertEqual(closed.exception.code, 1008)

    def test_read_only_is_for_everybody(self):
        web = self.web("--read-only")
        self.assertEqual(json.loads(self.opened(web).receive()[1]), {"role": "follower"})

    def test_a_server_that_is_not_there_is_told(self):
        gone = self.folder / "gone.json"
        gone.write_text(json.dumps({**self.server.content, "address": f"unix:{self.folder}/none.sock"}))
        gone.chmod(0o600)
        from gateway import Web
        with Web("--connect", gone) as web:
            web_socket = web.socket(web.cookie())
            self.addCleanup(web_socket.close)
            with self.assertRaises(Closed) as closed:
                for _ in messages(web_socket):
                    pass
            self.assertEqual((closed.exception.code, closed.exception.reason), (1013, "the server is not there"))


class Harm(WebCase):
    def test_ten_thousand_half_open_sockets(self):
        web = self.web()
        cookie = web.cookie()
        count = 10_000
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        most = count + 200 if hard == resource.RLIM_INFINITY else min(hard, count + 200)
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, most), hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        before = web.memory()
        held = []
        self.addCleanup(lambda: [line.close() for line in held])
        for i in range(min(count, most - 200)):
            line = web.connect()
            if i % 2:
                line.sendall(b"GET / HTTP/1.1\r\nHost: local")
            held.append(line)
            if i % 1000 == 0:
                self.assertEqual(web.ask("/page.js", Cookie=cookie).status, 200)
        self.assertEqual(web.ask("/page.js", Cookie=cookie).status, 200)
        self.assertTrue(web.opens(cookie))
        self.assertLess(web.descriptors(), 400)
        # A sanitizer keeps what was freed.
        self.assertLess(web.memory() - before, (256 if "/asan/" in str(BIN) or "/tsan/" in str(BIN) else 32) << 10)

    def test_one_that_reads_nothing(self):
        web = self.web()
        cookie = web.cookie()
        # Small buffers of ours: what it does not read stands in the gateway and before it.
        line = socket.socket()
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        line.settimeout(30)
        line.connect(("127.0.0.1", web.port))
        deaf = web.socket(cookie, connection=line)
        self.addCleanup(deaf.close)
        deaf.send(frame(hello(receipts=True)))
        before = web.memory()
        for i in range(200):
            message = new("ClientMessage")
            view = message.set_view
            view.view.width, view.view.height, view.view_id = 1280, 720, i + 1
            layer = view.view.layers.add()
            layer.dataset, layer.opacity = "data/beam", 0.5 + i / 1000
            layer.particles.SetInParent()
            deaf.send(frame(message))
        # Others are served meanwhile.
        other = web.socket(cookie)
        self.addCleanup(other.close)
        other.send(frame(hello()))
        wait_for(other, "welcome")
        message = new("ClientMessage")
        view = message.set_view
        view.view.width, view.view.height, view.view_id, view.final_only = 64, 64, 1, True
        layer = view.view.layers.add()
        layer.dataset = "data/beam"
        layer.particles.SetInParent()
        other.send(frame(message))
        wait_for(other, "frame")
        self.assertLess(web.memory() - before, (64 if "/asan/" in str(BIN) or "/tsan/" in str(BIN) else 8) << 10)

    def test_it_ends_with_a_server_of_its_own(self):
        from gateway import Web
        with Web("--spawn", f"data={self.folder}") as web:
            children = pathlib.Path(f"/proc/{web.process.pid}/task/{web.process.pid}/children").read_text().split()
            self.assertEqual(len(children), 1)
            os.kill(int(children[0]), signal.SIGKILL)
            self.assertEqual(web.process.wait(30), 1)
            self.assertIn(b"mote-server: ended", web.process.stderr.read())

    def test_sigterm_ends_it_with_sockets_open(self):
        web = self.web()
        web_socket = web.socket(web.cookie())
        self.addCleanup(web_socket.close)
        web_socket.send(frame(hello()))
        wait_for(web_socket, "welcome")
        begun = time.monotonic()
        web.process.send_signal(signal.SIGTERM)
        self.assertEqual(web.process.wait(30), 0)
        self.assertLess(time.monotonic() - begun, 5)


if __name__ == "__main__":
    unittest.main()
