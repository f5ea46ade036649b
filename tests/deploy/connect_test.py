#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""mote connect, over a real sshd on this machine: it gets there, runs what it is to run, and leaves nothing.

    connect_test.py BIN

Exits with 77 where there is no sshd.
"""
import getpass
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from loopback_ssh import LoopbackSsh, missing

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "python"))

from real_server import RealServer  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1))


class Connect(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="mote-", dir="/tmp")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.home, self.here = self.folder / "home", self.folder / "here"
        self.home.mkdir()
        self.here.mkdir(mode=0o700)
        self.ssh = LoopbackSsh(self.folder / "ssh", self.home)
        self.server = RealServer(BIN / "mote-server", self.home)
        self.addCleanup(self.server.close)

    def connect(self, *words):
        environment = {**os.environ, "MOTE_SSH": self.ssh.command(), "XDG_RUNTIME_DIR": str(self.here)}
        return subprocess.run([BIN / "mote", "connect", "node", *words], env=environment, capture_output=True, text=True,
                              timeout=60, check=False)

    def test_runs_a_command_on_the_server_there(self):
        for _ in range(2):  # also on the second day
            said = self.connect("--file", "connection.json", "--", "mote-stats", "data/beam")
            self.assertIn('there is no dataset "data/beam"', said.stderr)
            self.assertEqual(said.returncode, 1)
            self.assertEqual(list(self.here.iterdir()), [])

    def test_the_viewer_goes_there_by_itself(self):
        environment = {**os.environ, "MOTE_SSH": self.ssh.command(), "XDG_RUNTIME_DIR": str(self.here)}
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            environment.pop(name, None)
        node = f"{getpass.getuser()}@node"
        look = lambda *words: subprocess.run([BIN.resolve() / "mote-view", *words], env=environment, cwd=self.folder,
                                             capture_output=True, text=True, timeout=60, check=False)
        said = look("--size", "640x480", node)
        self.assertEqual(said.returncode, 1)
        self.assertIn(f"{node}: there is no .mote/connection.json", said.stderr)
        (self.home / ".mote").mkdir()
        (self.home / "connection.json").rename(self.home / ".mote" / "connection.json")
        said = look("--size", "640x480", node)
        self.assertIn("mote-view: no window system can be reached", said.stderr)  # all else is there
        (self.folder / node).mkdir()  # a folder of this name is one
        said = look(node)
        self.assertNotIn("connection.json", said.stderr)
        self.assertEqual(list(self.here.iterdir()), [])

    def test_other_commands_are_told_of_the_file(self):
        said = self.connect("--file", "connection.json", "--", "sh", "-c",
                            'stat -c %a "$MOTE_CONNECTION"; cat "$MOTE_CONNECTION"; exit 7')
        self.assertEqual(said.returncode, 7, said.stderr)
        mode, text = said.stdout.split("\n", 1)
        self.assertEqual(mode, "600")
        content = json.loads(text)
        self.assertEqual(content["token"], self.server.content["token"])
        self.assertTrue(content["address"].startswith(f"unix:{self.here}/"), content["address"])

    def test_where_there_is_no_server_it_says_so(self):
        said = self.connect()
        self.assertEqual(said.returncode, 1)
        self.assertIn("node: there is no .mote/connection.json and no .local/state/mote/connection.json", said.stderr)
        (self.home / "other.json").write_text("{}", encoding="ascii")
        said = self.connect("--file", "other.json")
        self.assertIn("what lies there is no connection file", said.stderr)
        self.assertEqual(list(self.here.iterdir()), [])

    def test_a_server_that_is_gone_is_told_of(self):
        kept = self.home / "kept.json"
        kept.write_bytes((self.home / "connection.json").read_bytes())
        self.server.close()
        said = self.connect("--file", "kept.json", "--", "mote-stats", "data/beam")
        self.assertEqual(said.returncode, 1)
        self.assertIn("node: no server answers there any more", said.stderr)

    def test_a_program_that_is_missing_is_told_of_before_ssh_asks_for_anything(self):
        for name in ("mote-nothing", "nothing-of-this-name"):
            said = subprocess.run([BIN / "mote", "connect", "--ssh", "false", "node", "--", name], capture_output=True, text=True,
                                  check=False)
            self.assertEqual((said.returncode, said.stdout), (1, ""))
            self.assertIn(f"mote: {name}: there is no such program", said.stderr)
            self.assertNotIn("\n", said.stderr.strip())

    def test_a_command_without_its_dashes_is_told_how_it_is_written(self):
        said = subprocess.run([BIN / "mote", "connect", "node", "mote-stats", "data/beam"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(said.returncode, 2)
        self.assertIn("mote connect node -- mote-stats data/beam", said.stderr)

    def test_words_that_ssh_would_take_for_options_are_none(self):
        said = subprocess.run([BIN / "mote", "connect", "--", "-oProxyCommand=true"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(said.returncode, 2)


if __name__ == "__main__":
    if missing():
        print(f"not tested: {', '.join(missing())} is not installed (Debian: openssh-server, openssh-client)")
        sys.exit(77)
    unittest.main()
