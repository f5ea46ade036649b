# SPDX-License-Identifier: GPL-3.0-or-later
"""What mote-prep run makes of a file of several species and meshes: all of them stand where they are in the view that it
writes, and nothing is left where it fails."""
import json
import subprocess
import unittest

import numpy

import beams
from beams import Beam
from support import BIN, Case, needs_program, run


@needs_program
class Run(Case):
    def write(self, later=()):
        """Two iterations; a species of `later` begins with the second. A mesh whose values are their places."""
        with beams.openpmd(self.folder / "run.h5") as file:
            for iteration in (1, 2):
                for name, seed in (("electrons", 1), ("ions", 2), ("c++", 3)):
                    if iteration == 1 and name in later:
                        continue
                    beam = Beam(200, seed=seed)
                    beam.x = beam.x * seed + 1e-3 * seed
                    beams.write_species(file.require_group(f"/data/{iteration}/particles/{name}"), beam)
                rho = numpy.arange(3 * 4 * 5, dtype=float).reshape(3, 4, 5)
                mesh = file.require_group(f"/data/{iteration}/meshes").create_dataset("rho", data=rho)
                mesh.attrs.update({"geometry": numpy.bytes_("cartesian"), "dataOrder": numpy.bytes_("C"),
                                   "axisLabels": numpy.array([b"z", b"y", b"x"]), "gridSpacing": [3e-3, 2e-3, 1e-3],
                                   "gridGlobalOffset": [-4e-3, -5e-3, -6e-3], "gridUnitSI": 1.0, "position": [0.0, 0.0, 0.0],
                                   "unitSI": 1.0, "unitDimension": numpy.zeros(7), "timeOffset": 0.0})
            file.attrs["meshesPath"] = numpy.bytes_("meshes/")

    def run_all(self, *options):
        said = json.loads(run("run", self.folder / "run.h5", "--out", self.folder / "made", "--json", *options))
        view = json.loads((self.folder / "made.view.json").read_text(encoding="utf-8"))["views"][0]
        self.assertEqual(said["view"], str(self.folder / "made.view.json"))
        self.assertEqual([each["output"] for each in said["datasets"]],
                         [str(self.folder / f"{layer['dataset'].removeprefix('data/')}.mote") for layer in view["layers"]])
        return [(each, json.loads((self.folder / each["output"] / "manifest.json").read_text(encoding="utf-8")), layer)
                for each, layer in zip(said["datasets"], view["layers"])]

    def left(self):
        return sorted(path.name for path in self.folder.iterdir() if "made" in path.name)

    def test_all_stand_where_they_are(self):
        self.write()
        parts = self.run_all("--axes", "z,x,y", "--meshes", "rho")
        self.assertEqual([each["name"] for each, _, _ in parts], ["c++", "electrons", "ions", "rho"])
        self.assertEqual(self.left(), ["made-c__.mote", "made-electrons.mote", "made-ions.mote", "made-rho.mote", "made.view.json"])
        axes = parts[0][1]["particles"]["axes"]
        low, high = (numpy.array([axis.get(end, 0.0) for axis in axes]) for end in ("min", "max"))
        places = numpy.random.default_rng(4).uniform(-1e-2, 1e-2, (50, 3))  # z, x, y in m
        wanted = 2 * (places - low) / (high - low) - 1
        for each, manifest, layer in parts:
            if each["kind"] == "particles":
                own = manifest["particles"]["axes"]
                begin, end = (numpy.array([axis.get(name, 0.0) for axis in own]) for name in ("min", "max"))
                inside = 2 * (places - begin) / (end - begin) - 1
            else:
                unit = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}[manifest["hybrid"]["worldUnit"]]
                inside = places[:, [1, 2, 0]] / unit
            place = numpy.array(layer.get("transform", numpy.eye(4).ravel())).reshape(4, 4)
            numpy.testing.assert_allclose(inside @ place[:3, :3].T + place[:3, 3], wanted, rtol=1e-9, atol=1e-9, err_msg=each["name"])
        drawn = subprocess.run([BIN / "mote-frames", self.folder / "made.view.json", "--spawn", f"data={self.folder}", "--device", "cpu",
                                "--size", "64x48", "--annotate", "--out", self.folder / "pictures"], capture_output=True, text=True)
        self.assertEqual(drawn.returncode, 0, drawn.stderr)

    def test_the_step_is_one_in_which_all_are(self):
        self.write(later=("ions",))
        for each, manifest, layer in self.run_all("--axes", "x,px,y"):
            self.assertEqual(manifest["particles"]["steps"][layer.get("step", 0)]["iteration"], "2", each["name"])

    def test_those_that_are_named(self):
        self.write()
        self.assertEqual([each["name"] for each, _, _ in self.run_all("--axes", "x,px,y", "--species", "ions,electrons", "--steps", "1:1:1")],
                         ["ions", "electrons"])

    def test_where_it_fails_nothing_is_left(self):
        self.write()
        every = ("run", self.folder / "run.h5", "--out", self.folder / "made", "--axes")
        self.refused("along x, y and z", run, *every, "x,px,y", "--meshes", "rho")
        self.refused("nothing", run, *every, "x,y,z", "--meshes", "nothing")
        self.refused("muons", run, *every, "x,px,y", "--species", "ions,muons")
        self.refused("names ions twice", run, *every, "x,px,y", "--species", "ions,ions")
        self.refused("nonsense", run, *every, "x,px,nonsense")
        self.assertEqual(self.left(), [])

    def test_what_is_there_is_not_replaced(self):
        self.write()
        for name in ("made-ions.mote", "made.view.json"):
            there = self.folder / name
            there.write_text("mine", encoding="utf-8")
            self.refused("exist", run, "run", self.folder / "run.h5", "--out", self.folder / "made", "--axes", "x,px,y")
            self.assertEqual((self.left(), there.read_text(encoding="utf-8")), ([name], "mine"))
            there.unlink()


if __name__ == "__main__":
    unittest.main()
