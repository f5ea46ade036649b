# SPDX-License-Identifier: GPL-3.0-or-later
"""A mote-server of a script's own: all that it has lies in one folder, and it ends with the script."""
import json
import os
import pathlib
import select
import subprocess
import time

_READY = 60.0


class NotReady(RuntimeError):
    """A server that did not come to its work; how it ended."""


class RealServer:
    """One that is ready, on a Unix socket unless options say another place; for a ``with`` statement.

    ``before``: words before its command line, as of strace; more names are Popen's.
    """

    def __init__(self, program, folder, *options, before=(), **popen):
        self.program, self.folder = pathlib.Path(program).resolve(), pathlib.Path(folder)
        (self.folder / "data").mkdir(exist_ok=True)
        self.file = self.folder / "connection.json"
        begin = time.perf_counter()
        with open(self.folder / "server.log", "ab") as log:
            self.process = subprocess.Popen(
                [*map(str, before), str(self.program), "--root", f"data={self.folder / 'data'}", "--state",
                 str(self.folder / "state"), "--connection", str(self.file), "--device", "cpu", *options],
                stdout=subprocess.PIPE, stderr=log, **popen)
        readable, _, _ = select.select([self.process.stdout], [], [], _READY)
        if not readable or not self.process.stdout.readline().startswith(b"ready "):
            self.close()
            raise NotReady(f"the server is not ready: code {self.process.returncode}")
        self.seconds = time.perf_counter() - begin
        self.content = json.loads(self.file.read_text(encoding="utf-8"))
        self.serving = int(self.content["pid"])  # the process that the first one watches

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Its exit code."""
        self.process.terminate()
        code = self.process.wait(60)
        self.process.stdout.close()
        return code

    def memory(self, field="VmRSS"):
        """Of the process that serves, KiB; "VmHWM": the most that it ever was."""
        for line in pathlib.Path(f"/proc/{self.serving}/status").read_text(encoding="ascii").splitlines():
            if line.startswith(field + ":"):
                return int(line.split()[1])
        raise RuntimeError(f"no {field} of process {self.serving}")

    def count(self, kind):
        """Its "task"s (threads) or "fd"s."""
        return len(os.listdir(f"/proc/{self.serving}/{kind}"))
