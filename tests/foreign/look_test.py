# SPDX-License-Identifier: GPL-3.0-or-later
"""What mote-prep look says of files whole and damaged. That it agrees with the datasets of all other files of these tests is
held where they are read (looked.py)."""
import json
import subprocess
import unittest

import h5py
import numpy

import beams
import looked
from beams import Beam, table, write_text
from support import BIN, Case, needs_program


def box(scale=1.0):
    """A cube as OBJ."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
    return "".join(f"v {x * scale} {y * scale} {z * scale}\n" for x, y, z in corners) + "".join(
        "f " + " ".join(map(str, face)) + "\n" for face in faces)


@needs_program
class Look(Case):
    def files(self):
        """One file of each kind, by what it is."""
        beam = Beam()
        values = numpy.arange(60, dtype="<i2").reshape(3, 4, 5)
        with beams.openpmd(self.folder / "run.h5") as file:
            beams.write_species(file.require_group("/data/1/particles/electrons"), beam, chunks=(50,), compression="gzip")
        with h5py.File(self.folder / "opal.h5", "w") as file:
            step = file.create_group("Step#0")
            for name in ("x", "y", "z", "px", "py", "pz"):
                step.create_dataset(name, data=beam.x)
        numpy.save(self.folder / "six.npy", numpy.stack([beam.x, beam.y, beam.zeta, beam.px, beam.py, beam.pz], axis=1))
        numpy.savez(self.folder / "columns.npz", x=beam.x, px=beam.px, y=beam.y)
        write_text(self.folder / "table.csv", table(["x [mm]", "px [eV/c]", "y [m]"], [beam.x, beam.px, beam.y]))
        (self.folder / "cube.nrrd").write_bytes(
            b"NRRD0004\ntype: int16\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: raw\nspacings: 1 2 3\n\n" + values.tobytes())
        write_text(self.folder / "cube.obj", box())
        write_text(self.folder / "cube.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        return {"run.h5": "openpmd", "opal.h5": "h5part", "six.npy": "npy", "columns.npz": "npz", "table.csv": "csv",
                "cube.nrrd": "nrrd", "cube.obj": "obj", "cube.off": "off"}

    def test_what_files_are(self):
        kinds = self.files()
        said, status = looked.look(*(self.folder / name for name in kinds))
        self.assertEqual(status, 0)
        self.assertEqual([each["input"] for each in said], [str(self.folder / name) for name in kinds])
        for name, each in zip(kinds, said):
            self.assertEqual(each["found"][0]["format"], kinds[name], name)
            self.assertEqual(each["refused"], [], name)
        by_name = {name: each["found"][0] for name, each in zip(kinds, said)}
        beam = Beam()
        for name in ("run.h5", "opal.h5", "six.npy", "columns.npz", "table.csv"):
            self.assertEqual(by_name[name]["counts"], [beam.count], name)
        x = next(column for column in by_name["table.csv"]["columns"] if column["name"] == "x")
        self.assertEqual((x["unit"], x["invalid"]), ("m", 0))
        numpy.testing.assert_allclose([x["min"], x["max"]], [1e-3 * beam.x.min(), 1e-3 * beam.x.max()], rtol=1e-9)
        cube = by_name["cube.nrrd"]
        self.assertEqual((cube["size"], cube["type"], cube["voxelSize"]), ([5, 4, 3], "i16", [1, 2, 3]))
        self.assertEqual((cube["columns"][0]["min"], cube["columns"][0]["max"]), (0, 59))
        self.assertEqual((by_name["cube.obj"]["vertices"], by_name["cube.obj"]["faces"]), (8, 12))
        self.assertEqual([column["max"] for column in by_name["cube.obj"]["columns"]], [1, 1, 1])

    def test_assumptions_and_refusals_are_told(self):
        beam = Beam()
        path = write_text(self.folder / "a.csv", table(["x", "y", "px"], [beam.x, beam.y, beam.px]))
        (said,), status = looked.look(path)
        self.assertEqual(status, 0)
        self.assertIn("no unit is given for x, y: taken as m", said["found"][0]["notes"])
        for name, content, sentence in (
                ("a.root", b"root\0\0\xf0", "is a ROOT file"), ("nine.txt", b"1 2 3 4 5 6 7 8 9\n" * 3, "without names"),
                ("cut.nrrd", b"NRRD0004\ntype: int16\ndimension: 3\nsizes: 5 4 3\nencoding: raw\nendian: little\n\n12", "120 bytes"),
                ("furlong.csv", b"x [furlong],px [eV/c],y [m]\n1,2,3\n", "'furlong', which is not known"), ("empty", b"", "is empty"),
                ("a.raw", bytes(range(256)) * 4, "a raw one is read by mote-prep volume, with --dimensions"), ("a.raw", bytes(range(256)) * 4, "--map"),
                ("cut.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n", "cut.ply")):
            with self.subTest(name=name):
                (self.folder / name).write_bytes(content)
                (said,), status = looked.look(self.folder / name)
                self.assertEqual((status, said["found"]), (1, []), said)
                self.assertIn(sentence, " ".join(said["refused"]))
        done = subprocess.run([BIN / "mote-prep", "look", self.folder / "none"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("there is no file", done.stderr)

    def test_species_fields_and_series(self):
        with beams.openpmd(self.folder / "run.h5") as file:
            for step, count in ((1, 120), (5, 70)):
                group = file.require_group(f"/data/{step}")
                group.attrs["time"], group.attrs["timeUnitSI"] = step * 1e-9, 1.0
                for name in ("electrons", "positrons"):
                    beams.write_species(group.require_group("particles/" + name), Beam(count))
            for step in ("1", "5"):
                meshes = file.require_group(f"/data/{step}/fields")
                for name, low in (("rho", 0.0), ("phi", 5.0)):
                    field = meshes.create_dataset(name, data=low + numpy.arange(24.0).reshape(2, 3, 4))
                    for key, value in (("geometry", numpy.bytes_("cartesian")), ("dataOrder", numpy.bytes_("C")), ("gridUnitSI", 1.0),
                                       ("axisLabels", numpy.array([b"z", b"y", b"x"])), ("gridSpacing", [1.0, 1.0, 1.0]),
                                       ("gridGlobalOffset", [0.0, 0.0, 0.0]), ("unitSI", 1.0), ("position", [0.0, 0.0, 0.0])):
                        field.attrs[key] = value
            file.attrs["meshesPath"] = numpy.bytes_("fields/")
        (said,), status = looked.look(self.folder / "run.h5")
        self.assertEqual(status, 0, said)
        found = {(each["kind"], each.get("name")): each for each in said["found"]}
        self.assertEqual(set(found), {("particles", "electrons"), ("particles", "positrons"), ("volume", "rho"), ("volume", "phi")})
        self.assertEqual(found["particles", "electrons"]["counts"], [120, 70])
        self.assertEqual(found["particles", "positrons"]["species"], "positron")
        self.assertEqual(found["particles", "electrons"]["times"], [1e-9, 5e-9])
        self.assertEqual(found["volume", "phi"]["columns"][0]["min"], 5.0)
        self.assertEqual(found["volume", "phi"]["steps"], 2)
        (said,), status = looked.look(self.folder / "run.h5", "--field", "psi")
        self.assertEqual((status, said["found"]), (1, []))
        self.assertIn("psi", said["refused"][0])
        (self.folder / "vector.nrrd").write_bytes(b"NRRD0004\ntype: int16\ndimension: 4\nsizes: 2 5 4 3\nkinds: vector domain domain domain\n"
                                                  b"endian: little\nencoding: raw\n\n" + numpy.arange(120, dtype="<i2").tobytes())
        (said,), status = looked.look(self.folder / "vector.nrrd")
        self.assertEqual([(each["name"], each["columns"][0]["max"]) for each in said["found"]], [(":0", 118), (":1", 119)])
        for i in (1, 2, 10):
            write_text(self.folder / f"beam_{i}.csv", table(["x [m]", "y [m]"], [[i, 2], [3, 4]]))
        (said,), status = looked.look(self.folder / "beam_%T.csv", "--all")
        self.assertEqual((said["found"][0]["steps"], said["found"][0]["columns"][0]["max"]), (3, 10.0))

    def test_damaged_files_are_looked_at(self):
        random = numpy.random.default_rng(7)
        for name in self.files():
            whole = (self.folder / name).read_bytes()
            for i in range(12):
                damaged = bytearray(whole)
                if i % 3 == 0:
                    damaged = damaged[:random.integers(len(whole))]
                for _ in range(0 if i % 3 == 0 else 1 + i):
                    damaged[random.integers(len(damaged))] ^= 1 << random.integers(8)
                path = self.folder / ("damaged." + name.split(".")[-1])
                path.write_bytes(damaged)
                done = subprocess.run([BIN / "mote-prep", "look", "--json", path], capture_output=True, check=False,
                                      timeout=looked.SECONDS)
                self.assertIn(done.returncode, (0, 1), (name, i, done.stderr))
                (said,) = [json.loads(line) for line in done.stdout.splitlines()]
                self.assertTrue(said["found"] or said["refused"], (name, i))


if __name__ == "__main__":
    unittest.main()
