# SPDX-License-Identifier: GPL-3.0-or-later
"""View.show(): a view in a browser's frame and in Python at once, by a mote-web of the session's own."""
import http.client
import importlib.util
import json
import os
import pathlib
import re
import socket as socketlib
import subprocess
import sys
import tempfile
import types
import unittest
import urllib.parse
from unittest import mock

from support import BIN, BeamCase, mote, needs_server  # isort: skip
import notebook
from mote.messages import new  # noqa: E402

PAGE = BIN.parent / "share" / "mote" / "web" / "index.html"


class Browser:
    """What a page does with a room."""

    def __init__(self, url):
        self.url = urllib.parse.urlsplit(url)
        self.room = self.url.fragment.partition("room=")[2]
        answer, _ = self.ask("GET", f"{self.url.path}?{self.url.query}")
        self.status, self.policy = answer.status, answer.getheader("Content-Security-Policy")
        self.cookie = (answer.getheader("Set-Cookie") or "").partition(";")[0]

    def ask(self, method, path, body=None):
        line = http.client.HTTPConnection("127.0.0.1", self.url.port, timeout=30)
        line.request(method, path, body, {"Cookie": getattr(self, "cookie", ""), "Host": self.url.netloc,
                                          "Origin": f"http://{self.url.netloc}"})
        answer = line.getresponse()
        data = answer.read()
        line.close()
        return answer, data

    def view(self, after=0):
        answer, data = self.ask("GET", f"/room/{self.room}?after={after}")
        view = new("View")
        view.ParseFromString(data)
        return view, int(answer.getheader("X-Number"))

    def put(self, view):
        return self.ask("POST", f"/room/{self.room}", view.SerializeToString())[0].status


@needs_server
@unittest.skipUnless((BIN / "mote-web").exists() and PAGE.exists(), "mote-web's page is not built: node or npm is missing")
class Live(BeamCase):
    def show(self, view=None, **options):
        return (view or mote.View(self.ds, size=(320, 200))).show(program=str(BIN / "mote-web"), **options)

    def test_what_is_turned_by_hand_is_read_back(self):
        live = self.show()
        self.assertIsNone(live.camera)
        browser = Browser(live.url)
        self.assertEqual(browser.status, 200)
        self.assertIn("frame-ancestors 'self' http://localhost:*", browser.policy)
        view, number = browser.view()
        self.assertEqual([layer.dataset for layer in view.layers], ["data/beam"])
        view.camera.eye.extend([1, 2, 3])
        view.camera.target.extend([0, 0, 0])
        view.layers[0].step = 2
        self.assertEqual(browser.put(view), 200)
        self.assertEqual(live.camera["eye"], [1, 2, 3])
        self.assertEqual(live.view.to_dict()["layers"][0]["step"], 2)
        self.assertEqual(live.view.render().size, (320, 200))

    def test_what_python_changes_is_shown_from_the_same_side(self):
        live = self.show()
        browser = Browser(live.url)
        view, number = browser.view()
        view.camera.eye.extend([1, 2, 3])
        view.camera.target.extend([0, 0, 0])
        browser.put(view)
        live.update(mote.View(self.ds, step=1))
        shown, later = browser.view(after=number + 1)
        self.assertEqual((shown.layers[0].step, list(shown.camera.eye), later), (1, [1, 2, 3], number + 2))

    def test_a_link_is_for_one_browser_and_a_room_for_who_knows_it(self):
        live = self.show()
        browser = Browser(live.url)
        self.assertEqual(Browser(live.url).status, 403)
        self.assertEqual(browser.ask("GET", "/room/nothing")[0].status, 404)
        browser.cookie = ""
        self.assertEqual(browser.ask("GET", f"/room/{browser.room}")[0].status, 403)

    def show_in_notebook(self, **options):
        """What a cell has: its Live, the frame, the still picture."""
        shown = []
        python = types.ModuleType("IPython")
        python.get_ipython = lambda: self
        python.display = types.ModuleType("IPython.display")
        python.display.display = shown.append
        with mock.patch.dict(sys.modules, {"IPython": python, "IPython.display": python.display}):
            return self.show(**options), *shown

    def test_a_notebook_has_a_frame_and_a_still_picture(self):
        live, frame, still = self.show_in_notebook(height=300)
        self.assertIn(f'src="{live.url}"', frame._repr_html_())
        self.assertIn('"300px"', frame._repr_html_())
        self.assertIn("height:0", frame._repr_html_(), "a saved notebook has no hole where its page does not come any more")
        self.assertEqual(still.size, (320, 200))
        self.assertFalse(hasattr(live, "_repr_html_"), "the frame is shown once")

    @unittest.skipUnless(importlib.util.find_spec("nbconvert"), "nbconvert is not at hand")
    def test_nbconvert_makes_latex_of_pictures_and_figures(self):
        live, frame, still = self.show_in_notebook()
        figure = self.ds.figure("x", step=0)
        cell = {"cell_type": "code", "execution_count": 1, "metadata": {}, "source": "", "outputs": []}
        for value in (frame, still, live, figure):
            data, metadata = notebook.bundle(value)
            cell["outputs"].append({"output_type": "display_data", "data": data, "metadata": metadata})
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "shown.ipynb").write_text(json.dumps({"cells": [cell], "metadata": {}, "nbformat": 4, "nbformat_minor": 4}))
            done = subprocess.run([sys.executable, "-m", "nbconvert", "--to", "latex", "shown.ipynb"], cwd=folder, capture_output=True,
                                  text=True, check=False, env={**os.environ, "HOME": name})
            self.assertEqual(done.returncode, 0, done.stderr)
            text = (folder / "shown.tex").read_text()
            pictures = [(folder / name).read_bytes() for name in re.findall(r"image\{.*\{([^{}]+\.png)\}", text)]
        self.assertEqual(pictures, [still.png(), figure.png])
        self.assertNotIn("iframe", text)
        self.assertNotIn("token", text)

    def test_it_ends_with_its_session(self):
        with mote.connect(self.session.connection.file) as session:
            live = mote.View(session["data/beam"]).show(program=str(BIN / "mote-web"))
            process = live._web._process.pid
            self.assertTrue(pathlib.Path(f"/proc/{process}").exists())
        self.assertFalse(pathlib.Path(f"/proc/{process}").exists())

    def test_behind_jupyters_proxy_it_is_below_the_servers_path(self):
        with mote.connect(self.session.connection.file) as session, mock.patch("mote.live.jupyter_base", lambda: "/user/me/"):
            live = mote.View(session["data/beam"]).show(program=str(BIN / "mote-web"))
            self.assertRegex(live.url, r"^/user/me/proxy/\d+/\?token=\w+#room=\w+$")

    def test_jupyters_launcher_starts_it(self):
        from mote.jupyter import setup

        with mock.patch.dict(os.environ, {"MOTE_WEB": str(BIN / "mote-web"), "MOTE_CONNECTION": self.session.connection.file}):
            entry = setup()
        socket = self.plots / "web.sock"
        # What the proxy does with it.
        words = [word.format(unix_socket=socket, port=0, base_url="/user/me/") for word in entry["command"]]
        with subprocess.Popen(words, stdout=subprocess.PIPE) as process:
            self.assertTrue(process.stdout.readline().startswith(b"ready "))
            line = http.client.HTTPConnection("hub.example.org")
            line.sock = socketlib.socket(socketlib.AF_UNIX)
            line.sock.connect(str(socket))
            line.request("GET", "/")
            self.assertEqual(line.getresponse().status, 200)
            line.close()
            process.terminate()
            self.assertEqual(process.wait(30), 0)

    def test_a_program_that_is_not_there_is_told(self):
        with mote.connect(self.session.connection.file) as session, self.fails("not_found", "/nowhere/mote-web"):
            mote.View(session["data/beam"]).show(program="/nowhere/mote-web")


if __name__ == "__main__":
    unittest.main()
