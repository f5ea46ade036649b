#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs every command that a document prints, in their order, in a home of its own.

    docs_test.py BIN DOCUMENT [--keep DIR]

Blocks of sh and of python are run, one after the other, as somebody who reads would; servers stay until the document
ends. What stands between is told by comments of Markdown before a block:

    <!-- not run: WHY -->      the block is only shown
    <!-- file: NAME -->        the block is what this file holds
    <!-- before: COMMAND -->   is run first: what an example expects that a reader has

"node" is this machine, by a real sshd; a window is one of Xvfb that closes when it has drawn. Exits with 77 where
something of that is not installed.
"""
import argparse
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

from loopback_ssh import LoopbackSsh, missing

ROOT = pathlib.Path(__file__).resolve().parents[2]
PIECE = re.compile(r"^<!-- (?P<key>not run|file|before): (?P<text>.*?) -->$|^```(?P<kind>\w*)\n(?P<body>.*?)^```$",
                   re.M | re.S)
SERVER = re.compile(r"^mote-(?:server|web) (?!.*--(?:check-config|version|help))")
TIME = 400  # seconds, for what hangs: README takes 24 alone, and minutes where much else runs

# Functions of the shell that the commands run in.
PRELUDE = r"""
set -eu -o pipefail
servers=()
serve() {
    local ready
    exec {told}< <(exec "$@")
    servers+=($!)
    read -r -t 60 ready <&"$told"
    [[ $ready == ready* ]]
}
trap 'code=$?; for pid in "${servers[@]}"; do kill "$pid" || true; done; wait; exit $code' EXIT
"""
# In place of the viewer: it draws in a window of its own, and ends.
VIEWER = """#!{python}
import os, subprocess, sys
read, write = os.pipe()
screen = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
                          pass_fds=[write], stderr=subprocess.DEVNULL)
os.close(write)
number = os.read(read, 16).decode().strip()
code = subprocess.run([{viewer!r}, *sys.argv[1:], "--screenshot", "window.png", "--exit-after-still"],
                      env={{**os.environ, "DISPLAY": ":" + number}}).returncode
screen.terminate()
sys.exit(code)
"""


def commands_of(text):
    """Lines of a block, those that go on as one."""
    for command in re.sub(r"\\\n\s*", " ", text).splitlines():
        yield "serve " + command if SERVER.match(command) else command


def script_of(document):
    """What the document's blocks do, as one text for bash."""
    script, noted, python = [PRELUDE], {}, []

    def finish():
        if python:
            script.append("python3 - <<'END_OF_PYTHON'\n" + "".join(python) + "END_OF_PYTHON")
            python.clear()

    for piece in PIECE.finditer(document):
        if piece["key"] == "before":
            finish()
            script.append(piece["text"])
            continue
        if piece["key"]:
            noted[piece["key"]] = piece["text"]
            continue
        kind, body = piece["kind"], piece["body"]
        if "file" in noted:
            finish()
            script.append(f"cat >{shlex.quote(noted['file'])} <<'END_OF_FILE'\n{body}END_OF_FILE")
        elif "not run" not in noted and kind == "python":
            python.append(body)
        elif "not run" not in noted and kind == "sh":
            finish()
            script.append("\n".join(commands_of(body)))
        noted = {}
    finish()
    return "\n".join(script) + "\n"


def make_programs(folder, binaries, ssh):
    """What the commands find in PATH."""
    folder.mkdir()
    for program in binaries.glob("mote-*"):
        (folder / program.name).symlink_to(program.resolve())
    shutil.copy(binaries / "mote", folder / "mote")  # it looks for the others beside itself
    (folder / "mote-view").unlink(missing_ok=True)
    texts = {"mote-view": VIEWER.format(python=sys.executable, viewer=str((binaries / "mote-view").resolve())),
             "python3": f'#!/bin/sh\nexec {sys.executable} -B "$@"\n'}
    for name in ("ssh", "scp"):
        texts[name] = f'#!/bin/sh\nexec {ssh.command(shutil.which(name))} "$@"\n'
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii")
        (folder / name).chmod(0o700)


def run(binaries, document, folder):
    home = folder / "home"
    (home / "work").mkdir(parents=True)  # where the reader is
    ssh = LoopbackSsh(folder / "ssh", home)
    make_programs(folder / "bin", binaries, ssh)
    (folder / "run").mkdir(mode=0o700)
    script = script_of(document.read_text(encoding="utf-8"))
    # What the packages install.
    script = script.replace("/usr/share/doc/mote/examples", str(ROOT / "deploy"))
    (folder / "script.sh").write_text(script, encoding="utf-8")
    environment = {"PATH": f"{folder / 'bin'}:/usr/bin:/bin", "HOME": str(home), "LANG": "C.UTF-8",
                   "XDG_RUNTIME_DIR": str(folder / "run"), "PYTHONPATH": str(ROOT / "client" / "python"),
                   "MOTE_SOURCE": str(ROOT)}
    said = folder / "said"
    with open(said, "wb") as log:
        # A group of its own: where it takes too long, all that it has started ends.
        process = subprocess.Popen(["bash", "-x", folder / "script.sh"], cwd=home / "work", env=environment,
                                   stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                                   start_new_session=True)
        try:
            code = process.wait(TIME)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGTERM)
            code = process.wait(20) or 1
    ssh.close()
    if code != 0:
        print(said.read_text(encoding="utf-8", errors="replace")[-6000:])
    return code


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("binaries", type=pathlib.Path)
    parser.add_argument("document", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path, help="an empty folder for all that is made")
    options = parser.parse_args()
    absent = missing() + [name for name in ("jq", "Xvfb") if shutil.which(name) is None]
    if absent:
        print(f"not tested: {', '.join(absent)} is not installed")
        return 77
    if options.keep:
        return run(options.binaries.resolve(), options.document, options.keep.resolve())
    with tempfile.TemporaryDirectory(prefix="mote-", dir="/tmp") as name:
        return run(options.binaries.resolve(), options.document, pathlib.Path(name))


if __name__ == "__main__":
    sys.exit(main())
