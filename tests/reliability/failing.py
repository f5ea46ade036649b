# SPDX-License-Identifier: GPL-3.0-or-later
"""Allocations that fail: orders for failing_allocation.cpp, the library that makes them fail."""
import mmap
import os
import pathlib
import re
import struct

_FIELDS = ("process", "least", "first", "many", "count", "failed")  # of 8 bytes each, as the library has them
_SIZE = 8 * len(_FIELDS)
# They ask for whoever calls them.
_CARRIERS = ("failing_allocation", "libc.so", "libgcc_s.so", "libstdc++.so")


def preload(build):
    """None where it was not built."""
    path = (pathlib.Path(build) / "tests" / "failing_allocation.so").resolve()
    return path if path.exists() else None


def places(count, most):
    """Numbers from 1 to count, so many at most: half of them evenly spread, half closer together at the begin."""
    if count <= most:
        return list(range(1, count + 1))
    half = most // 2
    even = {1 + round(i * (count - 1) / (half - 1)) for i in range(half)}
    dense = {round(count ** (i / (most - half - 1))) for i in range(most - half)}
    return sorted(even | dense)


class Order:
    """Says which allocations of a program fail, and how many it made; its fields may be read and set while it runs."""

    def __init__(self, file, **fields):
        self.file = pathlib.Path(file)
        self.file.write_bytes(bytes(_SIZE))
        with open(self.file, "r+b") as opened:
            self._map = mmap.mmap(opened.fileno(), _SIZE)
        self.forget()
        for name, value in {"many": 1, **fields}.items():
            self[name] = value

    def __getitem__(self, name):
        return struct.unpack_from("=Q", self._map, 8 * _FIELDS.index(name))[0]

    def __setitem__(self, name, value):
        struct.pack_into("=Q", self._map, 8 * _FIELDS.index(name), value)

    def environment(self, preloaded, program):
        return {**os.environ, "LD_PRELOAD": str(preloaded), "MOTE_FAIL_PROGRAM": program,
                "MOTE_FAIL_ORDER": str(self.file)}

    def forget(self):
        """What became of the faults before."""
        for kind in ("trace", "abort"):
            self._file_of(kind).unlink(missing_ok=True)
        self["failed"] = self["count"] = 0

    def _file_of(self, kind):
        return self.file.with_name(f"{self.file.name}.{kind}")

    def _frames(self, kind):
        """Names of programs and libraries with their functions, the innermost first, up to the end of main()."""
        file = self._file_of(kind)
        lines = file.read_text(errors="replace").splitlines() if file.exists() else []
        frames = [os.path.basename(line.partition("[")[0]) for line in lines]
        ends = [number for number, frame in enumerate(frames) if "(exit+" in frame]
        return frames[:ends[0]] if ends else frames

    def ended_by(self):
        """The library of others that a process died of; None: our own code let it die.

        Of an exception that nobody caught it is our own where any of ours called the library, which may well throw.
        """
        frames = self._frames("abort")
        # An exception that leaves a destructor ends the program, whoever called.
        # (Those of std are compiled into whoever used them first.)
        destructors = [frame for frame in frames if re.search(r"D[012]Ev\+", frame) and "(_ZNSt" not in frame]
        if destructors and not destructors[0].startswith("mote-"):
            return destructors[0].partition("(")[0]
        if any(frame.startswith("mote-") for frame in frames):
            return None
        for frame in frames or self._frames("trace"):
            if not frame.startswith(_CARRIERS):
                return None if frame.startswith("mote-") else frame.partition("(")[0]
        return None

    def text(self):
        """Where the process died, else what asked for the memory; for people with addr2line."""
        return " < ".join(self._frames("abort") or self._frames("trace"))
