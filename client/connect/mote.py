#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mote in one word: connects to a server on another machine, and runs Mote's programs."""
import argparse
import contextlib
import difflib
import json
import os
import pathlib
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

VERSION = "@PROJECT_VERSION@"
PROGRAMS = ("frames", "prep", "server", "stats", "view", "web")
# Where servers are told to keep the file by README.md and by docs/RUNBOOK.md.
PLACES = (".mote/connection.json", ".local/state/mote/connection.json")
PATIENCE = 20.0  # seconds for a socket that ssh opens

HELP = """Connects to a server on another machine, and runs Mote's programs.
Usage: mote [OPTIONS] SUBCOMMAND

Options:
  -h,--help                   Print this help message and exit
  --version                   Display program version information and exit

Subcommands:
  connect                     Look at what a server on another machine shows

Examples:
  mote connect user@node
  mote prep look run.h5

Any other word is a program: mote prep is mote-prep, and so are frames, server, stats, view and web.
"""
CONNECT_HELP = f"""Look at what a server on another machine shows
Usage: mote connect [OPTIONS] NODE [-- COMMAND...]

Positionals:
  NODE TEXT REQUIRED          The machine as ssh knows it, [USER@]NODE
  COMMAND TEXT ...            What is run in place of the viewer; --connect is added to Mote's programs, and others have the connection file in the variable MOTE_CONNECTION

Options:
  -h,--help                   Print this help message and exit
  --file PATH                 The server's connection file there; unless given ~/{PLACES[0]}, else ~/{PLACES[1]}
  --ssh COMMAND               ssh and its options; unless given the variable MOTE_SSH, else ssh

Examples:
  mote connect user@node
  mote connect node --file plots/here.json
  mote connect node -- mote-stats data/beam

ssh asks for a password once at most. The connection file is fetched, a socket that only you may open leads to the
server, and all is taken away when the viewer or the command ends.
"""


class Failure(Exception):
    """A sentence for people."""


def program(name):
    """The program of that name: of Mote's the one beside this, else the one in PATH."""
    beside = pathlib.Path(__file__).resolve().parent / name
    found = str(beside) if name.startswith("mote-") and beside.is_file() else shutil.which(name)
    if found is None:
        also = "neither beside this program nor" if name.startswith("mote-") else "not"
        raise Failure(f"{name}: there is no such program: it is {also} in PATH")
    return found


class Tunnel:
    """One line to a node, as ssh makes it; all of it lies in a folder of its own, and ends with it."""

    def __init__(self, ssh, node, folder):
        self._ssh, self._node, self._folder = ssh, node, folder

    def _run(self, *words, **more):
        return subprocess.run([*self._ssh, "-S", self._folder / "line", *words], check=False, **more)

    def open(self):
        """Asks for a password where ssh does."""
        done = self._run("-M", "-f", "-N", "-o", "ControlPersist=yes", "-o", "StreamLocalBindUnlink=yes", self._node)
        if done.returncode != 0:
            raise Failure(f"{self._node}: ssh does not get there")

    def close(self):
        self._run("-O", "exit", self._node, stderr=subprocess.DEVNULL)

    def leads_nowhere(self, address):
        """Whether ssh finds nobody at the end of a way that it has opened: it ends such a line at once."""
        unix = address.startswith("unix:")
        with socket.socket(socket.AF_UNIX if unix else socket.AF_INET) as line:
            line.settimeout(PATIENCE / 4)
            try:
                line.connect(address[5:] if unix else ("127.0.0.1", int(address.rpartition(":")[2])))
                return line.recv(1) == b""
            except TimeoutError:
                return False  # whoever listens there waits for us
            except OSError:
                return True

    def read(self, places):
        """The first of some files there."""
        tries = "; ".join(f"cat -- {shlex.quote(place)} 2>/dev/null && exit 0" for place in places)
        done = self._run("--", self._node, f"{tries}; exit 44", stdout=subprocess.PIPE)
        if done.returncode == 44:
            raise Failure(f"{self._node}: there is no {' and no '.join(places)}; start mote-server there, or say where "
                          "its connection file is by --file")
        if done.returncode != 0:
            raise Failure(f"{self._node}: the connection file cannot be read")
        return done.stdout

    def lead(self, here, there):
        """A socket here to an address there."""
        done = self._run("-O", "forward", "-L", f"{here}:{there}", self._node, stdout=subprocess.DEVNULL)
        if done.returncode != 0:
            raise Failure(f"{self._node}: ssh does not lead to {there}; does the node allow AllowStreamLocalForwarding "
                          "and AllowTcpForwarding?")


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def address_here(address, folder, tunnel):
    """What an address there is here, with a way to it."""
    kind, _, place = address.partition(":")
    if kind == "unix":
        here = folder / "server"
        tunnel.lead(here, place)
        end = time.monotonic() + PATIENCE
        while not here.exists():
            if time.monotonic() > end:
                raise Failure(f"ssh made no socket {here}")
            time.sleep(0.02)
        return f"unix:{here}"
    if kind == "tcp":
        port = free_port()
        host, _, its_port = place.rpartition(":")
        tunnel.lead(f"127.0.0.1:{port}", f"{host}:{its_port}")
        return f"tcp:127.0.0.1:{port}"
    raise Failure(f"the connection file has an address that is not known here: {address}")


def connection_here(text, folder, tunnel):
    """The connection file of a server there, as one of it here."""
    try:
        content = json.loads(text)
        address = content["address"]
    except (ValueError, KeyError, TypeError):
        raise Failure("what lies there is no connection file of mote-server") from None
    content["address"] = address_here(str(address), folder, tunnel)
    file = folder / "connection.json"
    with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as out:
        json.dump(content, out)
    return file


def command_of(words, file):
    """The command with its connection file."""
    more = [] if "--connect" in words or not words[0].startswith("mote-") else ["--connect", str(file)]
    return [program(words[0]), *words[1:], *more]


def connect(options):
    """Its exit code."""
    ssh = shlex.split(options.ssh)
    if shutil.which(ssh[0]) is None:
        raise Failure(f"{ssh[0]} is not installed (Debian: openssh-client)")
    words = options.command or ["mote-view"]
    program(words[0])  # before anybody is asked for a password
    # A path of a socket has 107 bytes at most: not beneath a folder that may be deep.
    base = os.environ.get("XDG_RUNTIME_DIR") or "/tmp"
    with tempfile.TemporaryDirectory(prefix="mote-", dir=base) as name, contextlib.ExitStack() as last:
        folder = pathlib.Path(name)
        tunnel = Tunnel(ssh, options.node, folder)
        tunnel.open()
        last.callback(tunnel.close)
        file = connection_here(tunnel.read([options.file] if options.file else PLACES), folder, tunnel)
        command = command_of(words, file)
        # Of Ctrl-C it is told itself.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        process = subprocess.Popen(command, env={**os.environ, "MOTE_CONNECTION": str(file)},
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        signal.signal(signal.SIGTERM, lambda *_: process.terminate())
        code = process.wait()
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        if code == 1 and tunnel.leads_nowhere(address):
            raise Failure(f"{options.node}: no server answers there any more, though its connection file is there; start "
                          "mote-server there again")
        return 128 - code if code < 0 else code


class Parser(argparse.ArgumentParser):
    """Says what is wrong as Mote's other programs do."""

    def error(self, message):
        print(f"{self.prog}: {message}\nRun with --help for more information.", file=sys.stderr)
        sys.exit(2)


def parse(words):
    parser = Parser(prog="mote connect", add_help=False, allow_abbrev=False)
    parser.add_argument("node", metavar="NODE")
    parser.add_argument("--file")
    parser.add_argument("--ssh", default=os.environ.get("MOTE_SSH", "ssh"))
    words, command = (words[:words.index("--")], words[words.index("--") + 1:]) if "--" in words else (words, [])
    options, more = parser.parse_known_args(words)
    if more and more[0].startswith("-"):
        parser.error(f"there is no option {more[0]}")
    if more:
        parser.error(f"{more[0]} is not expected here; a command is written after --: mote connect {options.node} -- "
                     f"{shlex.join(more)}")
    if options.node.startswith("-"):
        parser.error("a node does not begin with a dash")
    options.command = command
    return options


def main():
    words = sys.argv[1:]
    if words and words[0] in PROGRAMS:
        os.execv(program(f"mote-{words[0]}"), [f"mote-{words[0]}", *words[1:]])
    if words[:1] == ["--version"]:
        print(f"mote {VERSION}")
        return 0
    if words[:1] in (["-h"], ["--help"]):
        print(HELP, end="")
        return 0
    if words[:1] != ["connect"]:
        near = difflib.get_close_matches(words[0], ["connect", *PROGRAMS], 1) if words else []
        said = f"there is no subcommand {words[0]}" if words else "a subcommand is required"
        said += f"; near it: {near[0]}" if near else ""
        Parser(prog="mote", add_help=False).error(said)
    own = words[1:words.index("--")] if "--" in words else words[1:]
    if "-h" in own or "--help" in own:
        print(CONNECT_HELP, end="")
        return 0
    return connect(parse(words[1:]))


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
    except Failure as failure:
        print(f"mote: {failure}", file=sys.stderr)
        sys.exit(1)
