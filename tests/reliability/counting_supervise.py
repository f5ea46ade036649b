#!/usr/bin/python3 -IBS
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in mote-supervise's place: counts the runs that really begin, and says where one begins beside another.

FOLDER/runs/ID gets a line "PID BEGUN" for each, with "beside" where the run before still lives. The first run of each
job is hurt where FOLDER/hurt says how: words for strace. Then it becomes the supervisor, whose path FOLDER/supervise
holds. FOLDER is that of this file.
"""
import os
import socket
import sys

GATE = 3


def begun(number):
    """When a process began; None where there is none."""
    try:
        with open(f"/proc/{number}/stat", encoding="ascii", errors="replace") as file:
            words = file.read().rpartition(")")[2].split()
    except OSError:
        return None
    return None if words[0] in "ZX" else words[19]


def count_run(folder, identity):
    """How many runs there were before."""
    path = os.path.join(folder, "runs", identity)
    before = []
    if os.path.exists(path):
        with open(path, encoding="ascii") as file:
            before = [line.split() for line in file]
    beside = any(begun(words[0]) == words[1] for words in before)
    with open(path, "a", encoding="ascii") as file:
        file.write(f"{os.getpid()} {begun(os.getpid())}{' beside' if beside else ''}\n")
    return len(before)


def content(path):
    """"" where there is no such file."""
    if not os.path.exists(path):
        return ""
    with open(path, encoding="utf-8") as file:
        return file.read().strip()


def main():
    folder = os.path.dirname(os.path.abspath(sys.argv[0]))
    supervise = content(os.path.join(folder, "supervise"))
    if os.read(GATE, 1) != b"g":
        return 0  # nobody lets it begin: this is no run
    identity = os.path.basename(sys.argv[sys.argv.index("--directory") + 1])
    before = count_run(folder, identity)
    ours, theirs = socket.socketpair()
    ours.send(b"g")
    os.dup2(theirs.fileno(), GATE, inheritable=True)
    hurt = content(os.path.join(folder, "hurt")).split() if before == 0 else []
    words = [*hurt, supervise, *sys.argv[1:]]
    os.execvp(words[0], words)
    return 1


if __name__ == "__main__":
    sys.exit(main())
