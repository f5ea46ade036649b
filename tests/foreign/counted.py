# SPDX-License-Identifier: GPL-3.0-or-later
"""How many different files the tests of foreign files had read, by format: told when a program of them ends. Files that are
damaged on purpose do not count."""
import atexit
import collections
import hashlib
import pathlib

legal = True  # whether the running test writes files that their format's specification allows
_right, _refused = collections.defaultdict(set), collections.defaultdict(set)


def _content(path):
    """A file's bytes, those of all files of a folder, or a name that stands for several."""
    path = pathlib.Path(path)
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    return b"".join(file.read_bytes() for file in files if file.is_file()) or str(path.name).encode()


def add(kind, inputs, options, right):
    """One variant: its files and how they were asked for."""
    if not legal:
        return
    digest = hashlib.sha256(repr(options).encode())
    for path in inputs:
        digest.update(_content(path))
    (_right if right else _refused)[kind].add(digest.digest())


def _tell():
    kinds = sorted({*_right, *_refused})
    if kinds:
        right, refused = (sum(map(len, each.values())) for each in (_right, _refused))
        print("variants read right (refused for a reason): " +
              ", ".join(f"{kind} {len(_right[kind])} ({len(_refused[kind])})" for kind in kinds) + f"; {right} ({refused}) in all")


atexit.register(_tell)
