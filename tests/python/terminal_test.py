# SPDX-License-Identifier: GPL-3.0-or-later
"""No client hands a terminal what a server says for it to obey: the title, the clipboard (OSC 52), a line wiped out."""
import contextlib
import json
import os
import re
import subprocess
import unittest

from support import BIN, FolderCase, mote  # isort: skip
from fake_server import FakeServer  # isort: skip

# The clipboard set by OSC 52, the same in C1, a window's title, a line that is wiped, a carriage return.
EVIL = "gone\x1b]52;c;cm0gLXJm\x07 \x9d52;c;cm0gLXJm\x9c \x1b]0;title\x07\x1b[2K\r\x08\x7f"
OBEYED = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
SCRIPT = {"views": [{"width": 64, "height": 64, "layers": [{"dataset": "data/a", "particles": {}}]}]}


def refuse(peer, message):
    """Ends whatever was asked with a sentence that means harm, and says so fatally."""
    if message.WhichOneof("body") not in ("credit", "ping"):
        peer.fail(message, "not_found", "dataset" + EVIL, EVIL, fatal=True)


@contextlib.contextmanager
def screen():
    """A display for as long as it is needed."""
    process = subprocess.Popen(["Xvfb", "-displayfd", "1", "-screen", "0", "800x600x24", "-noreset"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        yield ":" + process.stdout.readline().decode().strip()
    finally:
        process.terminate()
        process.wait()
        process.stdout.close()


class Terminal(FolderCase):
    def said(self, *words, **environment):
        """What a program writes when the server that it asks means harm."""
        if not (BIN / words[0]).exists():
            self.skipTest(f"{words[0]} is not there")
        with FakeServer(refuse) as server:
            done = subprocess.run([BIN / words[0], *words[1:], "--connect", server.file], capture_output=True, timeout=60,
                                  env={**os.environ, **environment})
        self.assertNotEqual(done.returncode, 0)
        text = (done.stdout + done.stderr).decode()
        self.assertIn("\\x1b]52;c;cm0gLXJm\\x07", text, "the sentence is shown, and not lost")
        return text

    def harmless(self, text):
        self.assertIsNone(OBEYED.search(text), repr(text))

    def test_mote_frames(self):
        script = self.folder / "script.json"
        script.write_text(json.dumps(SCRIPT), encoding="utf-8")
        self.harmless(self.said("mote-frames", script, "--out", self.folder / "out"))

    def test_mote_stats(self):
        self.harmless(self.said("mote-stats", "data/a"))

    @unittest.skipUnless(os.path.exists("/usr/bin/Xvfb"), "there is no Xvfb")
    def test_mote_view(self):
        view = self.folder / "view.json"
        view.write_text(json.dumps(SCRIPT["views"][0]), encoding="utf-8")
        with screen() as display:
            self.harmless(self.said("mote-view", "--view", view, "--exit-after-still", DISPLAY=display))

    def test_an_error_of_the_package(self):
        error = mote.Error("internal", "a" + EVIL, EVIL)
        self.harmless(str(error))
        self.assertIn("\\x1b]52", str(error))
        self.assertEqual(error.message, EVIL, "the text itself stays as it was")
        with FakeServer(refuse) as server, self.assertRaises(mote.Error) as caught:
            with mote.connect(server.file) as session:
                session["data/a"]
        self.harmless(str(caught.exception))

    def test_mote_prep(self):
        place = self.folder / f"run{EVIL}".replace("/", "")
        done = subprocess.run([BIN / "mote-prep", "info", place], capture_output=True)
        self.assertNotEqual(done.returncode, 0)
        self.harmless((done.stdout + done.stderr).decode())


if __name__ == "__main__":
    unittest.main()
