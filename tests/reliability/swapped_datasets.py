# SPDX-License-Identifier: GPL-3.0-or-later
"""A dataset whose folder and files change places with links to another's that lies outside, while it is looked at.

The other one has more particles and other bounds, so that its bytes are told from the dataset's own: by what an answer
holds, or by an error that speaks of bytes that are none of the dataset's.
"""
import os
import pathlib
import subprocess

from own_server import mote

NAME = "many.mote"
STEPS = 80  # more than a server keeps open, so that each look opens files
_PARTICLES, _OTHERS = 100, 150
_AXES = "x,px,y"
# What is said of a file that was opened and is another's.
_FOREIGN = ("differs from its hash", "differs from its digest", "where the manifest says")


def make(build, data, outside, links, title):
    """The dataset, the one outside, and a link to that and to each of its files, all of which lie in `links`."""
    prep = build / "bin" / "mote-prep"
    links.mkdir()
    for folder, particles, more in ((data, _PARTICLES, ()), (outside, _OTHERS, ("--title", title))):
        run = links / "run.h5"
        subprocess.run([prep, "synth", "beam", "--particles", str(particles), "--steps", str(STEPS), "--seed", str(particles),
                        "--quiet", "--out", run], check=True)
        subprocess.run([prep, "particles", run, "--axes", _AXES, "--quiet", *more, "--out", folder / NAME], check=True)
        run.unlink()
    for path in (outside / NAME, *(outside / NAME).iterdir()):
        os.symlink(path, links / path.name)


def places(data, links):
    """What changes places with a link, without end: the folder, then its manifest, then files of every step."""
    folder = data / NAME
    manifest = [folder / "manifest.json", folder / "manifest.digest"]
    others = sorted(set(folder.iterdir()) - set(manifest))
    while True:
        for file in others:
            for path in (folder, *manifest, file):
                yield path, links / path.name


class Looks:
    """Looks at the dataset; `wrongs` are its escapes."""

    def __init__(self, session):
        self._session = session
        self.number = self.whole = 0
        self.wrongs = []
        dataset = session[self._name]
        self._facts = self._facts_of(dataset)
        self._steps = [self._look(dataset, step) for step in range(STEPS)]

    _name = "data/" + pathlib.PurePath(NAME).stem

    @staticmethod
    def _facts_of(dataset):
        return dataset.title, dataset.bounds, list(dataset.particles)

    @staticmethod
    def _look(dataset, step):
        picture = mote.View(dataset, step, size=(8, 8)).render()
        return picture.array.tobytes(), dataset.get("x", step).tobytes()

    def look(self):
        """At the next step, all of it; what is refused is no escape."""
        step = self.number % STEPS
        self.number += 1
        try:
            dataset = self._session[self._name]
            if self._facts_of(dataset) != self._facts:
                self.wrongs.append(f"the description of {NAME} is another's")
            if self._look(dataset, step) != self._steps[step]:
                self.wrongs.append(f"step {step} of {NAME} is another's")
            self.whole += 1
        except mote.Error as error:
            if any(words in str(error) for words in _FOREIGN):
                self.wrongs.append(f"a file that is not of {NAME} was opened: {error}")
