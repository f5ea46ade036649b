#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The most memory that a server takes, beside what it may take, while it draws the largest pictures of every kind.

    peak_memory.py [--build DIR] [--memory 512M,1G,8G] [--kinds hybrid,mesh,...] [--layers 1,8] [--clients 1,6]
                   [--size 8192x4096] [--patience 600] [--heaviest]

For each bound, kind, count of layers and of clients a server of its own: each client asks for one exact picture, at the
same time. A picture comes, or a sentence that says that there is no memory for it. Prints the greatest VmHWM of each and
what came, and fails where one is more than 64 MB beyond its bound, or anything else came. --patience: seconds that a
client waits; six drawings of the largest size take longer than ten minutes. --heaviest: a few cases that take most.
"""
import argparse
import itertools
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import threading
import zlib

from clients import ROOT, Client, Server, make_volume

EDGE = 96  # of the volume
BEYOND = 64 * 1000 * 1000
MOST = {"memory": "512M,1G,8G", "layers": "1,8", "clients": "1,6"}


def prepare(programs, *command):
    subprocess.run([programs / "mote-prep", *map(str, command), "--quiet"], check=True, stdout=subprocess.DEVNULL)


def png(width, height):
    """A picture in colour, of gradients."""
    row = b"\0" + b"".join(bytes((x % 256, x // 16 % 256, 90)) for x in range(width))
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(row * height, 1)),
              (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(data)) + name + data
                                            + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks)


def make_data(programs, folder):
    """A volume that fills the picture, a surface of it, particles, dots of a plane and of the surface, and a photograph."""
    make_volume(programs, folder, EDGE)
    data = folder / "data"
    prepare(programs, "synth", "beam", "--particles", 100000, "--steps", 2, "--seed", 1, "--out", folder / "run.h5")
    prepare(programs, "particles", folder / "run.h5", "--axes", "x,px,y", "--columns", "x,px,y,id", "--out",
            data / "beam.mote")
    prepare(programs, "mesh", folder / "field.raw", "--dimensions", *3 * [EDGE], "--isovalue", 40, "--out",
            data / "skin.mote")
    prepare(programs, "stipple", "plane", "--points", 10000, "--out", data / "plane.mote")
    (folder / "tetrahedron.off").write_text("OFF\n4 4 0\n1 1 1\n-1 -1 1\n-1 1 -1\n1 -1 -1\n"
                                            "3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n", encoding="ascii")
    prepare(programs, "stipple", folder / "tetrahedron.off", "--points", 5000, "--out", data / "dots.mote")
    (folder / "photo.png").write_bytes(png(6000, 4000))
    prepare(programs, "image", folder / "photo.png", "--out", data / "photo.mote")


BEAM, FIELD, SKIN = "data/beam", "data/field", "data/skin"
INK = {"hatch": {"strength": 1}}
DOTTED = {"dataset": "data/plane", "stipple": {"source": "layers"}}
# The layer that there is one of or eight, and what else a view has.
KINDS = {
    "hybrid": ({"dataset": FIELD, "hybrid": {}}, {}),
    "particles": ({"dataset": BEAM, "particles": {}}, {}),
    "points": ({"dataset": BEAM, "particles": {"points": {"linked": False, "curve": [{"density": 0, "fraction": 1}]}}}, {}),
    "coloured": ({"dataset": BEAM, "particles": {}, "colorBy": {"column": "px"}}, {}),
    "highlight": ({"dataset": BEAM, "particles": {"points": {"sizePixels": 8}}, "highlight":
                   {"selection": {"ranges": [{"column": "x", "min": 0}]}}}, {}),
    "stipple": ({"dataset": "data/dots", "stipple": {"spacingPixels": 3}}, {}),
    "dotted": ({"dataset": FIELD, "hybrid": {}}, {"last": DOTTED}),
    "mesh": ({"dataset": SKIN, "mesh": {}}, {}),
    "glass": ({"dataset": SKIN, "mesh": {"opacity": 0.4}}, {}),
    "image": ({"dataset": "data/photo", "image": {}, "opacity": 0.5}, {}),
    "ink": ({"dataset": SKIN, "ink": INK}, {}),
    "wash": ({"dataset": SKIN, "ink": {**INK, "wash": {}}}, {}),
    "field-ink": ({"dataset": FIELD, "ink": INK}, {}),
    "beam-ink": ({"dataset": BEAM, "ink": INK}, {}),
    "page": ({"dataset": SKIN, "ink": INK}, {"page": {"format": "PDF"}, "size": (4096, 4096)}),
    "half": ({"dataset": SKIN, "mesh": {}}, {"format": "LINEAR_HALF"}),
    "axes": ({"dataset": BEAM, "particles": {}}, {"annotations": {"axes": True, "colorBar": True}}),
}
# Those that took far more than their bound before it was one; smaller where they take long.
LARGEST = (8192, 4096)
HEAVIEST = [(("512M", "mesh", 8, 1), (2048, 1024)), (("512M", "ink", 1, 6), LARGEST), (("512M", "ink", 1, 6), (960, 540)),
            (("512M", "axes", 1, 4), LARGEST), (("512M", "coloured", 1, 1), LARGEST),
            (("512M", "highlight", 1, 2), (4096, 2048)), (("512M", "page", 1, 1), LARGEST)]


def view_of(kind, layers, turn, size):
    """Close by, so that most of the picture is covered; surfaces from where all of them is seen."""
    layer, more = KINDS[kind]
    width, height = more.get("size", size)
    view = {"width": width, "height": height}
    if layer["dataset"] in (BEAM, FIELD):
        view["camera"] = {"eye": [1.3, 0.1 * turn, 0.5], "target": [0, 0, 0], "up": [0, 0, 1]}
    view["layers"] = [dict(layer) for _ in range(layers)]
    for number, one in enumerate(view["layers"] if "image" not in layer else ()):
        one["transform"] = [1, 0, 0, 0.01 * number, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    if "last" in more:
        view["layers"].append(more["last"])
    if "annotations" in more:
        view["annotations"] = more["annotations"]
    return view


class Asker(threading.Thread):
    """Asks for one picture; what came is a word."""

    def __init__(self, file, view, more, patience):
        super().__init__(daemon=True)
        self._client, self._view, self._more, self._patience = Client(file), view, more, patience
        self.came = "nothing"

    def run(self):
        try:
            self._client.ask(1, self._view, final_only=True, **{key: self._more[key] for key in ("page", "format")
                                                                if key in self._more})
            self._client.picture(1, self._patience)
            self.came = "picture"
        except Exception as failure:  # pylint: disable=broad-except
            self.came = "refused" if "MiB" in str(failure) or "memory" in str(failure) else str(failure)


def measure(programs, folder, case, size, patience):
    """MB at most, and what came to the clients."""
    memory, kind, layers, clients = case
    # A picture may take minutes, and these clients say nothing meanwhile.
    with Server(programs, folder, "--memory", memory, "--silence", "0") as server:
        askers = [Asker(server.file, view_of(kind, layers, turn, size), KINDS[kind][1], patience) for turn in range(clients)]
        for asker in askers:
            asker.start()
        for asker in askers:
            asker.join()
        peak = server.memory("VmHWM") * 1024 / 1e6
    return peak, sorted(asker.came for asker in askers)


def bytes_of(memory):
    return int(memory[:-1]) * {"M": 2 ** 20, "G": 2 ** 30}[memory[-1]]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--kinds", default=",".join(KINDS))
    for name, value in MOST.items():
        parser.add_argument(f"--{name}", default=value)
    parser.add_argument("--size", default="8192x4096")
    parser.add_argument("--patience", type=float, default=600.0)
    parser.add_argument("--heaviest", action="store_true")
    options = parser.parse_args()
    all_of = itertools.product(options.memory.split(","), options.kinds.split(","), map(int, options.layers.split(",")),
                               map(int, options.clients.split(",")))
    own_size = tuple(map(int, options.size.split("x")))
    cases = HEAVIEST if options.heaviest else [(case, own_size) for case in all_of]
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_data(options.build / "bin", folder)
        for case, size in cases:
            peak, came = measure(options.build / "bin", folder, case, size, options.patience)
            most = (bytes_of(case[0]) + BEYOND) / 1e6
            good = peak <= most and set(came) <= {"picture", "refused"}
            failed += not good
            memory, kind, layers, clients = case
            print(json.dumps({"memory": memory, "kind": kind, "layers": layers, "clients": clients, "size": size,
                              "peak": round(peak), "most": round(most),
                              "came": {word: came.count(word) for word in sorted(set(came))}, "good": good}), flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
