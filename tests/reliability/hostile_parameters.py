#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""1,000 strings in each parameter of a job that is a string: they reach the job as they are, or are refused.

    hostile_parameters.py [--build build/release] [--strings 1000] [--seed 15]

Words of shells, lines for Slurm, options, quotes, control characters and NUL. In the supervisor's place stands a program
that writes down the words, the request and the environment it was started with. Each string arrives with every byte in
the request and makes no word of the command line another, or is refused in a sentence; none of the files whose making
the strings ask for is there in the end. Prints how many were tried, arrived and were refused; exits 1 where one arrived
changed, had an effect, or the server died. With Slurm: SlurmJobTest.WordsOfTheUserAreNoWordsForAShell.
"""
import argparse
import json
import os
import pathlib
import random
import shutil
import sys
import tempfile

from google.protobuf import json_format

import own_server
import mote.messages  # own_server says where it lies
from own_server import mote

BATCH = 200
NESTS = ["{}", "$({})", "`{}`", ";{};", "|{}|", "&{}&", "\n{}\n", "'{}'", '"{}"', '";{};"', "';{};'", "-{}", "--{}", "${{{}}}",
         "\r\n{}", "\n#SBATCH {}\n", "#{}", "\\{}", "x={}", "{}\x1b[0m", "~{}", "%{}", "!{}", "<({})", ">{}", "*{}?"]
SEEDS = ["touch CANARY", "#SBATCH --output=CANARY", "--out CANARY", "--directory CANARY", "rm -rf .", "id>CANARY", "-",
         "--", "-rf", "--help", "\x00", "a\x00b", "\n", "$HOME", "$IFS", "../x", "/etc/passwd", "%s%n", "\u202e", "\U0001f4a5",
         "e\u0301", "'", '"', "\\", " ", "\t", "", "a" * 300, "\x7f", "\x01", "=cmd", "{a,b}", "*", "\u2028", "x"]


def strings(count, seed):
    """Different ones; of the seeds each alone first, then nested at random."""
    found = dict.fromkeys(SEEDS)
    dice = random.Random(seed)
    while len(found) < count:
        text = dice.choice(SEEDS)
        for _ in range(dice.randint(1, 3)):
            text = dice.choice(NESTS).format(text)
        if dice.random() < 0.3:
            text += "".join(chr(dice.choice([*range(1, 0x7F), 0xE9, 0x2603])) for _ in range(dice.randint(1, 12)))
        found[text] = None
    return list(found)[:count]


def particles(**more):
    return {"output": "data/made.mote", "particles": {"inputs": ["data/run.h5"], "axes": ["x", "px", "y"], **more}}


def of_kind(kind, **fields):
    return {"output": "data/made.mote", kind: fields}


def in_volume(**source):
    return of_kind("volume", inputs=["data/run.h5"], source=source)


# Each makes a request with the string in one place.
PARAMETERS = {
    "title": lambda s: {"title": s, **particles()},
    "output": lambda s: {**particles(), "output": f"data/{s}.mote"},
    "particles.inputs": lambda s: particles(inputs=[f"data/{s}.h5"]),
    "particles.axes": lambda s: particles(axes=["x", "px", s]),
    "particles.format": lambda s: particles(format=s),
    "particles.species": lambda s: particles(species=s),
    "particles.steps": lambda s: particles(steps=s),
    "particles.columns": lambda s: particles(columns=[s]),
    "particles.lost": lambda s: particles(lost=s),
    "particles.bounds.name": lambda s: particles(bounds=[{"name": s, "min": 0, "max": 1}]),
    "stipple.mesh": lambda s: of_kind("stipple", mesh=f"data/{s}.h5", points=10),
    "mesh.input": lambda s: of_kind("mesh", input=f"data/{s}.h5"),
    "image.input": lambda s: of_kind("image", input=f"data/{s}.h5"),
    "volume.inputs": lambda s: of_kind("volume", inputs=[f"data/{s}.h5"]),
    "volume.filter": lambda s: of_kind("volume", inputs=["data/run.h5"], filter=s),
    "volume.representation": lambda s: of_kind("volume", inputs=["data/run.h5"], representation=s),
    "volume.source.format": lambda s: in_volume(format=s),
    "volume.source.type": lambda s: in_volume(type=s),
    "volume.source.field": lambda s: in_volume(field=s),
    "export.dataset": lambda s: {"export": {"dataset": f"data/{s}.mote"}},
    "export.steps": lambda s: {"export": {"dataset": "data/beam.mote", "steps": s}},
    "export.columns": lambda s: {"export": {"dataset": "data/beam.mote", "columns": [s]}},
    "film.format": lambda s: {"film": {"script": {"views": [{"width": 8, "height": 8}]}, "format": s}},
    "film.video": lambda s: {"film": {"script": {"views": [{"width": 8, "height": 8}]}, "video": s}},
}


class Place:
    """A server whose supervisor only writes down, and files of which each string names one, where it can."""

    def __init__(self, folder, build, texts):
        self.folder, self.bin, self.data = folder, folder / "bin", folder / "data"
        (self.bin / "runs").mkdir(parents=True)
        shutil.copy2((build / "bin" / "mote-server").resolve(), self.bin / "mote-server")
        for program in ("mote-prep", "mote-frames"):
            os.symlink((build / "bin" / program).resolve(), self.bin / program)
        shutil.copy2(pathlib.Path(__file__).with_name("recording_supervise.py"), self.bin / "mote-supervise")
        own_server.make_beam(build, self.data)
        for text in texts:
            try:
                os.link(self.data / "run.h5", self.data / f"{text}.h5")
            except (OSError, ValueError):
                pass  # no file can be called so
        (folder / "here").mkdir()
        self.before = self.content()

    def content(self):
        """The names of all files but those of the server's own."""
        own = {"bin", "state"}
        return {str(path) for top in self.folder.iterdir() if top.name not in own for path in [top, *top.rglob("*")]}

    def run(self, identity):
        path = self.bin / "runs" / identity
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None

    def strangers(self):
        return sorted(self.content() - self.before - {str(self.folder / name) for name in ("connection.json", "server.log")})


def hides(text, words):
    """Whether a string became a word of a command line, or a part of one."""
    return len(text) > 8 and any(text in word for word in words)


def request_of(name, text, number):
    """With an output of its own, as no two jobs may make the same."""
    request = PARAMETERS[name](text)
    if name != "output" and "output" in request:
        request["output"] = f"data/made-{number}.mote"
    return mote.messages.to_message("JobRequest", request)


def judge(place, job, name, wanted, text, plain):
    """What is wrong with a job that was let in."""
    run = place.run(job.id)
    if run is None:
        return f"job {job.id} was never run: {job.error}"
    arrived = json_format.Parse(run["request"], mote.messages.new("JobRequest"))
    if wanted.HasField("film"):
        wanted, arrived = (wanted.film.video, wanted.film.format), (arrived.film.video, arrived.film.format)
    if arrived != wanted:
        return f"it arrived changed: {run['request'][:200]!r}"
    if hides(text, run["words"]):
        return "it became a word of the command line"
    shape = [word for word in run["words"] if job.id not in word and str(place.data) not in word]
    if plain.setdefault(name.split(".")[0] if "." in name else "particles", shape) != shape:
        return f"it changed the command line: {run['words']}"
    return ""


def submit(session, request):
    message = mote.messages.new("ClientMessage")
    message.submit_job.job.CopyFrom(request)
    message.submit_job.again = True
    session.connection.watch_jobs()
    return mote.Job(session, session.connection.ask(message, "job").message.job.id)


def try_parameter(place, session, name, texts, plain):
    """(arrived, refused, wrongs) of one parameter."""
    arrived, refused, wrongs, jobs = 0, 0, [], []

    def settle():
        nonlocal arrived
        for job, wanted, text in jobs:
            try:
                job.wait(timeout=120, progress=False)
            except mote.Error:
                pass
            wrong = judge(place, job, name, wanted, text, plain)
            arrived += not wrong
            if wrong:
                wrongs.append(f"{name} {text[:80]!r}: {wrong}")
        jobs.clear()

    for number, text in enumerate(texts):
        try:
            wanted = request_of(name, text, number)
            jobs.append((submit(session, wanted), wanted, text))
        except mote.Error as error:
            if session.connection.lost is not None:
                raise
            refused += 1
            if "\n" in str(error) or not str(error):
                wrongs.append(f"{name} {text[:80]!r}: no sentence: {str(error)!r}")
        if len(jobs) >= BATCH:
            settle()
    settle()
    return arrived, refused, wrongs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--strings", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=15)
    options = parser.parse_args()
    texts, wrongs, plain = strings(options.strings, options.seed), [], {}
    with tempfile.TemporaryDirectory(prefix="mote-words-") as name:
        place = Place(pathlib.Path(name).resolve(), options.build, texts)
        with own_server.OwnServer(place.bin / "mote-server", place.folder, cwd=place.folder / "here") as server:
            with server.session() as session:
                for parameter in PARAMETERS:
                    arrived, refused, wrong = try_parameter(place, session, parameter, texts, plain)
                    print(f"{parameter}: {arrived} arrived as they were, {refused} were refused", flush=True)
                    wrongs += wrong
            if server.is_hurt():
                wrongs.append("the server died")
        strangers = place.strangers()
    for wrong in wrongs[:50]:
        print(wrong)
    print(f"{len(texts)} strings in each of {len(PARAMETERS)} parameters: {len(wrongs)} arrived changed, {len(strangers)} "
          f"side effects {strangers[:5] if strangers else ''}".rstrip())
    return 1 if wrongs or strangers else 0


if __name__ == "__main__":
    sys.exit(main())
