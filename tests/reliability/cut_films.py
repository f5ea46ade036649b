# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of mote-frames whose line is cut, and clients whose server is gone for good."""
import json
import pathlib
import subprocess
import tempfile
import time

import varied_session
from cut_judge import Judge
from cutting_proxy import Cut
from own_server import mote

GONE_S = 8.0  # a client gives up after 5 s, and may be in the midst of a try


class Films:
    """Runs of mote-frames through a proxy: of one script, whose pictures are to be the same each time."""

    def __init__(self, program, proxy, folder):
        self._program, self._proxy, self._folder = program, proxy, folder
        self._script = folder / "script.json"
        views = [view for way in range(3) for view in varied_session.views(way)]
        self._script.write_text(json.dumps({"views": views}), encoding="utf-8")
        self.cuts = self.refused = 0
        self.returns, self.wrongs = [], []
        proxy.plan()
        self._uncut = self._run()
        if self._uncut[0] != 0 or len(self._uncut[2]) != len(views):
            raise RuntimeError(f"mote-frames draws nothing: {self._uncut[1]}")
        self.length = proxy.lines[0].count

    def _run(self):
        """(exit code, what it said, the pictures, the lines of its report)."""
        with tempfile.TemporaryDirectory(dir=self._folder) as out:
            done = subprocess.run([self._program, self._script, "--connect", self._proxy.file, "--out", out, "--quiet", "--json"],
                                  capture_output=True, text=True, timeout=120, check=False)
            pictures = {path.name: path.read_bytes() for path in pathlib.Path(out).iterdir()}
        frames = sorted(json.loads(line)["index"] for line in done.stdout.splitlines())
        return done.returncode, done.stderr, pictures, frames

    def turn(self, cuts):
        self._proxy.plan(*cuts)
        done = self._run()
        judge = Judge().look(self._proxy.lines)
        self.cuts += sum(line.reached for line in self._proxy.lines)
        self.returns += judge.returns
        self.wrongs += [f"mote-frames, {cuts}: {sentence}" for sentence in judge.wrongs]
        if done == self._uncut:
            return
        if not judge.has_session and len(self._proxy.lines) == 1 and done[0] == 1 and not done[2] and done[1].count("\n") == 1:
            self.refused += 1
        else:
            self.wrongs.append(f"mote-frames, {cuts}: code {done[0]}, {sorted(done[2])}, {done[1]!r}")

    def gone(self):
        """In the midst of the film; what is wrong with how it ends."""
        self._proxy.plan(Cut(self.length // 2, last=True))
        code, said, _, _ = self._run()
        seconds = time.monotonic() - self._proxy.lines[0].cut_at
        print(f"  without a server it ends after {seconds:.1f} s with code {code}: {said.strip()}")
        right = code == 1 and said.count("\n") == 1 and said.startswith("mote-frames: ") and seconds <= GONE_S
        return [] if right else ["mote-frames without a server does not end as it should"]


def gone(proxy, after):
    """The same of Python, after so many messages or bytes."""
    proxy.plan(Cut(after, last=True))
    with mote.connect(proxy.file) as session:
        try:
            while True:
                session.ping()
        except mote.Error as error:
            seconds, said = time.monotonic() - proxy.lines[0].cut_at, str(error)
    print(f"Python without a server ends after {seconds:.1f} s: {said}")
    return [] if said and "\n" not in said and seconds <= GONE_S else ["Python without a server does not end as it should"]
