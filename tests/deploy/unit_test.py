#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The systemd unit: what systemd itself says of its exposure, and what the server and its jobs need of it.

    unit_test.py DEPLOY
"""
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

UNIT = pathlib.Path(sys.argv.pop(1)) / "mote-server.service"
MOST_EXPOSED = 3.0


class Unit(unittest.TestCase):
    def settings(self):
        """The last value of each key, continued lines joined."""
        text = UNIT.read_text(encoding="utf-8").replace("\\\n", "")
        return dict(re.findall(r"^(\w+)=(.*)$", text, re.MULTILINE))

    @unittest.skipUnless(shutil.which("systemd-analyze"), "there is no systemd-analyze")
    def test_it_is_little_exposed(self):
        said = subprocess.run(["systemd-analyze", "security", "--offline=true", "--no-pager", UNIT],
                              capture_output=True, text=True)
        found = re.search(r"exposure level for \S+: ([0-9.]+)", said.stdout)
        self.assertTrue(found, said.stdout + said.stderr)
        self.assertLessEqual(float(found[1]), MOST_EXPOSED, said.stdout)
        self.assertNotRegex(said.stderr, r"Unknown key|ignoring|Failed to parse")

    def test_it_bounds_what_the_server_and_its_jobs_take(self):
        settings = self.settings()
        self.assertEqual(settings["KillMode"], "process", "jobs outlive their server")
        self.assertEqual(settings["OOMPolicy"], "continue", "a job that is killed does not end the server")
        self.assertEqual(settings["LimitCORE"], "0")
        for key in ("TasksMax", "MemoryMax", "TimeoutStopSec"):
            self.assertIn(key, settings)
        self.assertGreater(int(settings["TimeoutStopSec"]), 10, "draining takes up to 10 s")

    def test_jobs_can_give_up_their_rights(self):
        allowed = self.settings()["SystemCallFilter"].split()
        for call in ("seccomp", "landlock_create_ruleset", "landlock_add_rule", "landlock_restrict_self"):
            self.assertIn(call, allowed)


if __name__ == "__main__":
    unittest.main()
