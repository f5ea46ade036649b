# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-prep look held to the datasets that are made of the same files: every file that these tests read is looked at, too."""
import json
import os
import pathlib
import subprocess

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("MOTE_BIN", ROOT / "build" / "release" / "bin"))
SECONDS = 120  # no file of the tests takes a part of it
PASSED_ON = ("--mass", "--map", "--species", "--format", "--frequency", "--kinetic-energy", "--field", "--series")
formats = None  # those that the running test writes; None: any
family = ""  # what that test is of


def look(*arguments):
    """What is said of each input, and the exit status, which is 0 or 1 whatever the files hold."""
    done = subprocess.run([str(BIN / "mote-prep"), "look", "--json", "--quiet", *map(str, arguments)], capture_output=True,
                          text=True, check=False, timeout=SECONDS)
    assert done.returncode in (0, 1), f"mote-prep look {arguments} ended with {done.returncode}: {done.stderr}"
    assert "reader does not survive" not in done.stdout, f"mote-prep look {arguments}: {done.stdout}"
    return [json.loads(line) for line in done.stdout.splitlines()], done.returncode


def _passed(options):
    kept, words = [], [str(option) for option in options]
    for at, word in enumerate(words):
        if word in PASSED_ON:
            kept += words[at:at + 2]
    return kept


def hold(kind, inputs, options, manifest):
    """The format. `inputs` and `options` are those of the job; manifest: None where the file was refused."""
    if len(inputs) > 3:
        inputs = [inputs[0], inputs[-1]]  # one of them is like the next
    said, status = look(*inputs, *_passed(options))
    assert len(said) == len(inputs) or not said, said
    found = [each for each in said[0]["found"] if each["kind"] == kind] if said else []
    form = found[0]["format"] if found else family if formats is None else "/".join(sorted(formats))
    if "--dimensions" in options:
        form = "raw"
    if manifest is None or len(inputs) > 1 or {"--dimensions", "--isovalue"} & set(options):
        return form
    assert found, f"{inputs} is read as {kind}, and looks like {said}"
    if len(found) > 1:  # one of several species or fields
        return form
    assert formats is None or found[0]["format"] in formats, f"{inputs} is {found[0]['format']}, not {formats}"
    assert not found[0]["refused"], found
    {"particles": _particles, "volume": _volume, "mesh": _mesh}[kind](found[0], options, manifest[_NAMES[kind]])
    assert status == 0 or said[0]["refused"], said
    return form


_NAMES = {"particles": "particles", "volume": "hybrid", "mesh": "mesh"}


def _particles(found, options, manifest):
    steps = manifest["steps"]
    counts = [sum(int(step.get(name, 0)) for name in ("particles", "invalid", "outside")) for step in steps]
    assert found["steps"] == len(steps), found
    if "--lost" in options and options[options.index("--lost") + 1] == "with":
        assert found["counts"] == counts, (found["counts"], counts)
    assert found["iterations"] == [int(step.get("iteration", 0)) for step in steps], found
    assert found["times"] == [step.get("time", 0.0) for step in steps], found
    assert found["mass"] == manifest.get("mass", 0.0) and found["species"] == manifest.get("species", ""), found
    columns = {column["name"]: column for column in manifest.get("columns", [])}
    for column in found["columns"]:
        assert column["name"] in columns, (column, list(columns))
        if len(steps) == 1 and column["min"] is not None:
            own = columns[column["name"]]
            near = 1e-6 * max(abs(column["min"]), abs(column["max"]))
            assert abs(column["min"] - own.get("min", 0.0)) <= near and abs(column["max"] - own.get("max", 0.0)) <= near, (column, own)
    for note in found["notes"]:
        assert note in manifest.get("notes", []), (note, manifest.get("notes"))


def _volume(found, options, manifest):
    assert found["size"] == [int(size) for size in manifest["sourceSize"]], found
    assert found["type"] == manifest["scalarType"], found
    assert found["steps"] == len(manifest["steps"]), found
    (values,) = found["columns"]
    if len(manifest["steps"]) == 1:
        numpy.testing.assert_allclose([values["min"], values["max"]], [manifest.get("valueMin", 0.0), manifest.get("valueMax", 0.0)],
                                      rtol=1e-6)
    if not {"--space", "--spacing", "--origin"} & set(options):
        affine = numpy.array(manifest["indexToWorld"]).reshape(4, 4)
        numpy.testing.assert_allclose(found["voxelSize"], numpy.linalg.norm(affine[:3, :3], axis=0), rtol=1e-9)
        numpy.testing.assert_allclose(found["origin"], affine[:3, 3], rtol=1e-9, atol=1e-12)
        numpy.testing.assert_allclose(found["axes"], affine[:3, :3].T.ravel(), rtol=1e-9, atol=1e-12)
        assert found["space"] == manifest.get("space", "") and found["sourceSpace"] == manifest.get("sourceSpace", ""), found


def _mesh(found, _, manifest):
    assert found["triangles"] == int(manifest["triangles"]), found
    if not any("origin" in note or "taken off" in note for note in manifest.get("notes", [])):
        numpy.testing.assert_allclose([column["min"] for column in found["columns"]], manifest["boundsMin"], rtol=1e-6, atol=1e-12)
        numpy.testing.assert_allclose([column["max"] for column in found["columns"]], manifest["boundsMax"], rtol=1e-6, atol=1e-12)
