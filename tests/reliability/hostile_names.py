#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that lead out of the roots, asked for over the wire; and links that are swapped beside those who open them.

    hostile_names.py [--build build/release] [--swaps 100000]

200 names stand wherever a message has one: datasets of descriptions, views and queries, inputs and outputs of every
kind of job, uploads. A second process swaps a link, then a folder and a link, between a place beneath the root and one
outside, while datasets are described and drawn and jobs read and write through it; then a dataset's folder, its manifest
and its files, each with a link to another's outside, while it is described and its steps are drawn and read. What lies
outside says so in its title and has other numbers. Prints how many names and swaps there were and how many escaped; exits
1 where any did, or the server died.
"""
import argparse
import ctypes
import multiprocessing
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

import own_server
import swapped_datasets
from kill_prep_everywhere import digest
from own_server import mote, new

SECRET = "this lies outside"
SWAPS_AN_OPEN = 50
_AT_FDCWD, _EXCHANGE = -100, 2


def names(outside):
    """200 of them; `outside` is the absolute path of what must not be reached."""
    deep = "../" * 40
    parts = ["..", ".", "", "../outside", "../../outside", f"{deep}etc/passwd", "x/../../outside", "./../outside",
             "link", "link/beam", "link/beam.mote", "chain/beam.mote", "loop", "loop/x", "proc", "proc/self/root", "root",
             "root/etc/passwd", "fd", "dangling", "beam.mote/../../outside/beam.mote", "beam.mote/../link/run.h5",
             "/etc/passwd", f"/{outside}", outside, f"{outside}/beam.mote", "~", "~root", "$HOME", "$(id)", "`id`", "%2e%2e",
             "%2e%2e%2foutside", "..%2foutside", "..\\outside", "c:\\outside", "\\\\host\\share", "file:///etc/passwd",
             "\x00", "beam\x00.mote", "../outside\x00.mote", "beam.mote\x00/../../outside", "\n", "..\n", "\n../outside",
             "beam\n.mote", "\r../outside", "\t", "\x1b]52;c;aGk=\x07", "\x7f", "\u202e..", "\uff0e\uff0e/outside",
             "\u2024\u2024/outside", "\u2215etc\u2215passwd", "..\u2044outside", "..\u200b/outside", "\ufeff../outside",
             "e\u0301", "\u00e9", "\U0001f4a5", "\ufffd", "-rf", "--out=/tmp/x", "-", "--", "*", "?", "[a-z]", "{a,b}", "|id",
             ";id", "&id", "'", '"', "a" * 255, "a" * 256, "a" * 4095, "a" * 5000, "a/" * 2000 + "b", "../" * 1400, "." * 300,
             "...", "....", ". .", " ", " ..", ".. ", "CON", "NUL.mote", "beam.mote ", " beam.mote", "beam.mote.",
             "/dev/zero", "/dev/fd/0", "/proc/self/environ", "/proc/self/mem", "/proc/1/root/etc/passwd"]
    given = [f"data/{part}" for part in parts]
    given += [f"data//{part}" for part in parts[:30]]
    given += [part for part in parts[:60]]
    given += ["data", "data/", "data//", "/data/beam", "DATA/beam", "other/beam", "data\x00/beam", "data\n/beam", ":", "/"]
    return list(dict.fromkeys(given))[:200]


class Place:
    """A root with links that lead out of it, and what lies there."""

    def __init__(self, folder, build):
        self.folder, self.prep = folder, build / "bin" / "mote-prep"
        self.data, self.outside, self.links = folder / "data", folder / "outside", folder / "links"
        own_server.make_beam(build, self.data)
        self.outside.mkdir()
        subprocess.run([self.prep, "particles", self.data / "run.h5", "--axes", "x,px,y", "--quiet", "--title", SECRET,
                        "--out", self.outside / "beam.mote"], check=True)
        os.link(self.data / "run.h5", self.outside / "run.h5")
        links = {"link": "../outside", "chain": "link", "loop": "loop", "proc": "/proc", "root": "/", "fd": "/dev/fd",
                 "dangling": "../outside/new", "into.mote": "../outside/into.mote",
                 "beam-out.mote": str(self.outside / "beam.mote")}
        for name, target in links.items():
            os.symlink(target, self.data / name)
        swapped_datasets.make(build, self.data, self.outside, self.links, SECRET)
        self.digest = digest(self.outside)

    def wrongs(self):
        if digest(self.outside) != self.digest:
            yield "what lies outside was changed"
        strangers = {path.name for path in self.folder.iterdir()} - {"data", "outside", "links", "state",
                                                                    "connection.json", "server.log"}
        if strangers:
            yield f"files appeared outside: {sorted(strangers)}"


def requests(name):
    """(what, message, answers that are none of an escape) of each place where a message has a name."""
    message = new("ClientMessage")
    message.describe.dataset = name
    yield "describe", message, ("description",)
    message = new("ClientMessage")
    view = message.set_view.view
    view.width = view.height = 8
    view.layers.add().dataset = name
    view.layers[0].particles.SetInParent()
    message.set_view.final_only = True
    yield "view", message, ("frame",)
    message = new("ClientMessage")
    message.query.dataset = name
    message.query.statistics.SetInParent()
    yield "query", message, ("answer",)
    message = new("ClientMessage")
    message.upload.name, message.upload.size, message.upload.data = name, 1, b"x"
    yield "upload", message, ("uploaded",)
    for kind, field in (("particles", "inputs"), ("volume", "inputs"), ("mesh", "input"), ("image", "input"),
                        ("stipple", "mesh"), ("export", "dataset")):
        message = new("ClientMessage")
        job = message.submit_job.job
        part = getattr(job, kind)
        part.SetInParent()
        if field == "inputs":
            part.inputs.append(name)
        else:
            setattr(part, field, name)
        if kind == "particles":
            part.axes.extend(["x", "px", "y"])
        if kind == "stipple":
            part.points = 10
        if kind != "export":
            job.output = "data/made.mote"
        yield kind + "." + field, message, ("job",)
    message = new("ClientMessage")
    message.submit_job.job.output = name
    message.submit_job.job.particles.inputs.append("data/run.h5")
    message.submit_job.job.particles.axes.extend(["x", "px", "y"])
    yield "output", message, ("job",)


def look(heard):
    """What an answer says of what lies outside; "" where nothing."""
    return "it tells of what lies outside" if SECRET.encode() in heard.SerializeToString() else ""


def ask_names(server, place):
    """How many were asked, and what escaped."""
    asked, wrongs, number = 0, [], 0
    line = None
    for name in names(str(place.outside)):
        for what, message, answers in requests(name):
            if line is None:
                line = server.raw()
                line.enter()
            number += 1
            asked += 1
            message.request = number
            if what == "view":
                message.set_view.view_id = number
            heard = line.ask(message, answers)
            if heard is None:  # it may end the line, and must not end the server
                line.line.close()
                line = None
                continue
            wrong = look(heard)
            body = heard.WhichOneof("body")
            if body == "failure" and not heard.failure.message:
                wrong = "it is refused without a word"
            if body != "failure" and not is_harmless(what, name, heard):
                wrong = f"it is answered by {body}"
            if wrong:
                wrongs.append(f"{what} of {name[:80]!r}: {wrong}")
    if line is not None:
        line.line.close()
    with server.raw() as last:  # bytes that are no text
        last.enter()
        bad = b"data/\xff\xfe../outside"
        body = b"\x0a" + bytes([len(bad)]) + bad
        last.send(struct.pack("<II", 2 + len(body), 0) + b"\x32" + bytes([len(body)]) + body)
        heard = last.hear()
        if heard is not None and heard.WhichOneof("body") != "failure":
            wrongs.append("a name that is no text is not refused")
    return asked, wrongs


def is_harmless(what, name, heard):
    """Whether a name that looks bad is only an odd name beneath the root, or of an upload."""
    if what == "upload":
        return "/" not in name and not name.startswith(".")
    if what == "stipple.mesh" and not name:
        return True  # the plane
    if name == "data":
        return what != "output"  # the root itself, which no job can read or make
    if what == "output":
        inside = name.startswith("data/") and ".." not in name.split("/")
        return inside and "link" not in name and "chain" not in name and heard.job.request.output == name
    return False


def exchange(libc, one, other):
    if libc.renameat2(_AT_FDCWD, os.fsencode(one), _AT_FDCWD, os.fsencode(other), _EXCHANGE) != 0:
        raise OSError(ctypes.get_errno(), "renameat2")


def swap(place, count, swaps, opens):
    """Half of them: a link alone points to and fro, then a folder and a link change places. Then what a dataset has of
    its own leaves its place to a link and comes back. So many an open."""
    libc = ctypes.CDLL(None, use_errno=True)
    data = place.data
    inside, way = data / "inside", data / "way"

    def count_one():
        swaps.value += 1
        while swaps.value > SWAPS_AN_OPEN * (opens.value + 1) and os.getppid() != 1:
            os.sched_yield()

    quarter = count // 4
    for number in range(quarter):
        spare = data / ".spare"
        os.symlink("../outside" if number % 2 == 0 else "inside", spare)
        os.rename(spare, way)
        count_one()
    other = data / "out"
    os.symlink("../outside", other)
    for _ in range(quarter):
        exchange(libc, inside, other)
        count_one()
    changes = swapped_datasets.places(data, place.links)
    while swaps.value < count:
        own, link = next(changes)
        for _ in range(min(2, count - swaps.value)):
            exchange(libc, own, link)
            count_one()


def open_beside(server, place, count):
    """Opens whatever a name leads to while it is swapped; (swaps, opens, wrongs)."""
    inside = place.data / "inside"
    inside.mkdir()
    for name in ("beam.mote", "run.h5"):
        subprocess.run(["cp", "-r", place.data / name, inside / name], check=True)
    os.symlink("inside", place.data / "way")
    swaps, opens = multiprocessing.Value("q", 0, lock=False), multiprocessing.Value("q", 0, lock=False)
    swapper = multiprocessing.Process(target=swap, args=(place, count, swaps, opens), daemon=True)
    wrongs, jobs = [], []
    with server.session() as session:
        looks = swapped_datasets.Looks(session)
        swapper.start()
        while swapper.is_alive():
            for way in ("data/way", "data/inside", "data/out"):
                opens.value += 1
                try:
                    dataset = session[f"{way}/beam"]
                    if dataset.title == SECRET:
                        wrongs.append(f"{way}/beam is the one that lies outside")
                    mote.View(dataset, size=(8, 8)).render()
                except mote.Error:
                    pass
                if opens.value % 40 < 3:  # jobs are slower than swaps
                    try:
                        output = f"{way}/new-{opens.value}.mote"
                        jobs.append(session.prepare(f"{way}/run.h5", axes=["x", "px", "y"], output=output))
                    except mote.Error:
                        pass
            opens.value += 2
            looks.look()
            if any(entry.title == SECRET for entry in session.catalogue()):
                wrongs.append("the catalogue has what lies outside")
        swapper.join()
        wrongs += looks.wrongs
        if looks.whole == 0:
            wrongs.append("no look at a dataset whose files were swapped saw it whole")
        for job in jobs:
            try:
                job.wait(timeout=60, progress=False)
            except mote.Error:
                pass
    if swaps.value != count:
        wrongs.append(f"only {swaps.value} swaps were made")
    print(f"{looks.whole} of {looks.number} looks at a dataset whose files were swapped saw it whole")
    return swaps.value, opens.value + len(jobs), wrongs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--swaps", type=int, default=100000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mote-names-") as name:
        place = Place(pathlib.Path(name).resolve(), options.build)
        with own_server.OwnServer(options.build / "bin" / "mote-server", place.folder) as server:
            asked, wrongs = ask_names(server, place)
            wrongs += place.wrongs()
            swaps, opens, escaped = open_beside(server, place, options.swaps)
            wrongs += escaped
            if server.is_hurt():
                wrongs.append("the server died")
        wrongs += place.wrongs()
    for wrong in wrongs[:50]:
        print(wrong)
    print(f"200 names in {asked} requests, {swaps} swaps beside {opens} opens: {len(wrongs)} escapes")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
