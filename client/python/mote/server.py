# SPDX-License-Identifier: GPL-3.0-or-later
"""PrivateServer: a mote-server of our own, in a temporary folder, until it is stopped or Python is gone.

A small shell keeps it: it waits at a pipe whose other end we hold, so that the server ends and its folder is removed
even where Python is killed. It stands in a session of its own: a Ctrl-C at the terminal is for us alone.
"""
from __future__ import annotations

import os
import select
import shutil
import signal
import subprocess
import tempfile
import time
from typing import Dict, List, Optional

from .errors import Error, invalid

READY_TIMEOUT = 120.0
"""Seconds; a software rasteriser compiles its shaders before it is ready, and minutes mean that it hangs."""
_END_TIMEOUT = 15.0  # the server promises to end within 10 s

_KEEPER = """
folder=$1
shift
"$@" </dev/null 2>"$folder/log" &
server=$!
exec >/dev/null 2>&1
read -r word
kill -TERM $server
wait $server
rm -rf "$folder"
"""


def find_program(program: Optional[str]) -> str:
    """The server's program: the one that is asked for, else MOTE_SERVER, the one in PATH, or that of the source tree."""
    if program is None:
        beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), *[os.pardir] * 3, "build/release/bin/mote-server")
        program = os.environ.get("MOTE_SERVER") or shutil.which("mote-server") or os.path.normpath(beside)
    if not os.access(program, os.X_OK) or os.path.isdir(program):
        raise Error("not_found", program, "there is no server to start here; say where it is: program=")
    return os.path.abspath(program)


def _roots(roots: Dict[str, str]) -> List[str]:
    if not roots:
        raise invalid("data", "say where datasets lie: mote.spawn(data=FOLDER)")
    words = []
    for name, folder in roots.items():
        if not os.path.isdir(folder):
            raise Error("not_found", os.fspath(folder), f"there is no such folder to be the root {name!r}")
        words += ["--root", f"{name}={os.path.abspath(folder)}"]
    return words


class PrivateServer:
    """Starts at once; ``wait_until_ready`` says when it can be used. Main thread or one at a time."""

    def __init__(self, program: Optional[str], roots: Dict[str, str], options: List[str]) -> None:
        words = [find_program(program), *_roots(roots)]
        self._process_id = os.getpid()
        self.folder = tempfile.mkdtemp(prefix="mote-")
        self.connection_file = os.path.join(self.folder, "connection.json")
        os.mkdir(os.path.join(self.folder, "state"), 0o700)
        words += ["--state", os.path.join(self.folder, "state"), "--connection", self.connection_file, *options]
        try:
            self._keeper = subprocess.Popen(["/bin/sh", "-c", _KEEPER, "mote", self.folder, *words],
                                            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                            start_new_session=True)
        except BaseException:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    def wait_until_ready(self) -> None:
        """Raises Error with the server's own reason where it ends before."""
        said = b""
        end = time.monotonic() + READY_TIMEOUT
        # The line is short; a server that says more than this first is not ours.
        while len(said) < 4096:
            if not self._readable(max(end - time.monotonic(), 0.0)):
                raise Error("internal", "mote-server", "did not become ready in time")
            assert self._keeper.stdout is not None
            piece = os.read(self._keeper.stdout.fileno(), 512)
            if not piece:
                raise Error("internal", "mote-server", self.last_words() or "ended before it was ready and gave no reason")
            said += piece
            if said.endswith(b"\n") and (said.startswith(b"ready") or b"\nready" in said):
                return
        raise Error("internal", "mote-server", "did not say that it is ready")

    def _readable(self, timeout: float) -> bool:
        assert self._keeper.stdout is not None
        poll = select.poll()
        poll.register(self._keeper.stdout, select.POLLIN)
        return bool(poll.poll(timeout * 1000))

    def ended(self) -> Optional[str]:
        """Why the server is gone, in its own words; None while it is there."""
        if self._keeper.stdout is None or self._keeper.stdout.closed:
            return "the server was stopped"
        if not self._readable(0.0) or os.read(self._keeper.stdout.fileno(), 4096):
            return None
        return self.last_words() or "ended and gave no reason"

    def last_words(self) -> str:
        """The last line of its log."""
        try:
            with open(os.path.join(self.folder, "log"), encoding="utf-8", errors="replace") as log:
                lines = [line.strip() for line in log.read()[-65536:].splitlines() if line.strip()]
        except OSError:
            return ""
        return lines[-1].replace("mote-server: ", "", 1) if lines else ""

    def stop(self) -> None:
        """Ends the server and removes its folder. Again: nothing."""
        if os.getpid() != self._process_id or self._keeper.stdin is None or self._keeper.stdin.closed:
            return
        try:
            self._keeper.stdin.write(b"end\n")
            self._keeper.stdin.flush()
        except OSError:
            pass  # the keeper is gone
        try:
            self._keeper.wait(_END_TIMEOUT)
        except subprocess.TimeoutExpired:
            pass
        finally:
            self._clear_away()

    def _clear_away(self) -> None:
        assert self._keeper.stdin is not None and self._keeper.stdout is not None
        if self._keeper.poll() is None:
            os.killpg(self._keeper.pid, signal.SIGKILL)
            self._keeper.wait()
        for pipe in (self._keeper.stdin, self._keeper.stdout):
            try:
                pipe.close()
            except OSError:
                pass
        shutil.rmtree(self.folder, ignore_errors=True)
