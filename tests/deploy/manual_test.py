#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Manual pages and the completion know every option of every --help, and are what man and bash understand.

    manual_test.py MANUAL BIN
"""
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

BIN = pathlib.Path(sys.argv.pop(2))
MANUAL = pathlib.Path(sys.argv.pop(1))
PROGRAMS = ("mote", "mote-prep", "mote-server", "mote-supervise", "mote-frames", "mote-stats", "mote-view", "mote-web")
OPTION = re.compile(r"^ +(?:-\w,)?(--[a-z-]+)", re.MULTILINE)
FOOTER = re.compile(r"\n(Examples?:|Pictures are|Mouse:)")


def help_of(words):
    said = subprocess.run([BIN / words[0], *words[1:], "--help"], check=True, capture_output=True, text=True)
    return FOOTER.split(said.stdout)[0]


def commands():
    """Each program and subcommand, with its options."""
    waiting = [(name,) for name in PROGRAMS]
    while waiting:
        words = waiting.pop()
        text = help_of(words)
        yield words, OPTION.findall(text)
        below = re.search(r"^Subcommands:\n((?: .*\n?)*)", text, re.MULTILINE)
        waiting += [(*words, line.split()[0]) for line in (below[1].splitlines() if below else [])]


def completed(*words):
    """What bash offers for the last word."""
    script = f'source "{MANUAL}/completions/{words[0]}"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); ' \
             '_mote "$1"; printf "%s\\n" "${COMPREPLY[@]}"'
    said = subprocess.run(["bash", "-c", script, "bash", "-", *words], check=True, capture_output=True, text=True)
    return said.stdout.split()


class Manual(unittest.TestCase):
    def test_every_option_is_completed_and_told(self):
        found = list(commands())
        self.assertGreater(len(found), len(PROGRAMS) + 8)
        for words, options in found:
            with self.subTest(command=words):
                self.assertGreater(len(options), 0)
                self.assertEqual(sorted(completed(*words, "--")), sorted(options))
                page = (MANUAL / "man" / f"{'-'.join(words)}.1").read_text(encoding="utf-8").replace("\\-", "-")
                for option in options:
                    self.assertIn(f"\\fB{option}\\fR", page)

    def test_words_are_completed_where_they_stand(self):
        self.assertEqual(completed("mote-prep", "st"), ["stipple"])
        self.assertEqual(completed("mote-prep", "synth", ""), ["beam", "phantom", "coil"])
        self.assertEqual(completed("mote-prep", "particles", "--format", "impact"), ["impactz", "impactt"])
        self.assertEqual(completed("mote-prep", "particles", "--axes", str(MANUAL / "mad")), [str(MANUAL / "made")])
        self.assertEqual(completed("mote-view", "--screen"), ["--screenshot"])

    @unittest.skipUnless(shutil.which("groff"), "there is no groff")
    def test_pages_are_roff(self):
        pages = sorted((MANUAL / "man").glob("*.1"))
        self.assertGreater(len(pages), len(PROGRAMS))
        for page in pages:
            said = subprocess.run(["groff", "-man", "-ww", "-z", "-Tutf8", "-Kutf8", page], check=True,
                                  capture_output=True, text=True)
            self.assertEqual(said.stderr, "", page)


if __name__ == "__main__":
    unittest.main()
