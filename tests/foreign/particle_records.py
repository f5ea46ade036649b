# SPDX-License-Identifier: GPL-3.0-or-later
"""openPMD in rare and damaged forms, and what is said of files that are not read."""
import itertools

import h5py
import numpy

import beams
from beams import C, E, ELECTRON, Beam, write_text
from support import Case, needs_program


@needs_program
class OpenPmd(Case):
    FORMATS = {"openpmd", "csv"}  # csv: beside it in a folder

    def write(self, name="a.h5", steps=("1",), change=None, **options):
        beam = Beam()
        path = self.folder / name
        with beams.openpmd(path) as file:
            for step in steps:
                group = beams.write_species(file.require_group(f"/data/{step}/particles/electrons"), beam, **options)
                if change:
                    change(group, step)
        return beam, path

    def test_constants_of_any_shape(self):
        for shape in ([1], [120], [120, 1], [], None, [7]):
            def change(group, _, shape=shape):
                for axis in "xyz":
                    beams.constant(group, "positionOffset/" + axis, 0.0, shape)
                beams.constant(group, "mass", ELECTRON * E / C**2, shape)
                beams.constant(group, "charge", -E, shape)
                del group["weighting"]
                beams.constant(group, "weighting", 3.5, shape)
            with self.subTest(shape=shape):
                beam, path = self.write(change=change)
                made = beams.read(path)
                beam.hold(self, made.steps[0], what=str(shape), weight=numpy.full(beam.count, 3.5))
                self.assertAlmostEqual(made.mass / ELECTRON, 1, 6)

    def test_a_record_that_cannot_be_read_is_missing(self):
        def damaged(group, name, kind):
            values = group[name][...]
            del group[name]
            if kind == "empty":
                group.create_dataset(name, data=values[:0])
            elif kind == "null":
                group.create_dataset(name, data=h5py.Empty("f8"))
            elif kind == "nothing":
                group.create_group(name)
            elif kind == "doubled":
                group.create_dataset(name, data=numpy.concatenate([values, values]))
            elif kind == "square":
                group.create_dataset(name, data=numpy.stack([values, values]))
            elif kind == "text":
                group.create_dataset(name, data=numpy.full(len(values), b"x"))
            else:
                group.create_dataset(name, data=values.astype("i8"), chunks=(40,), scaleoffset=0)
        for name, kind in itertools.product(("position/z", "momentum/z", "momentum/x", "weighting"),
                                            ("empty", "null", "nothing", "doubled", "square", "text", "scaleoffset")):
            with self.subTest(name=name, kind=kind):
                beam, path = self.write(change=lambda group, _, n=name, k=kind: damaged(group, n, k))
                made = beams.read(path, axes="x,y,py")
                column = {"position/z": "z", "momentum/z": "pz", "momentum/x": "px", "weighting": "weight"}[name]
                self.assertNotIn(column, made.steps[0].columns)
                self.assertIn(f"record '{name}' is left out", made.notes)
                beam.hold(self, made.steps[0], "x y py", name)
        for kind in ("empty", "doubled", "scaleoffset", "nothing"):
            with self.subTest(name="id", kind=kind):
                beam, path = self.write(change=lambda group, _, k=kind: damaged(group, "id", k))
                beam.hold(self, beams.read(path).steps[0], what=kind, ids=False)

    def test_filters_of_h5py(self):
        for filters in ({"compression": "gzip"}, {"compression": "lzf"}, {"compression": "lzf", "shuffle": True},
                        {"compression": "lzf", "shuffle": True, "fletcher32": True}, {"shuffle": True, "fletcher32": True}):
            for chunk in (1, 37, 120):
                with self.subTest(filters=filters, chunk=chunk):
                    beam, path = self.write(chunks=(chunk,), **filters)
                    beam.hold(self, beams.read(path).steps[0], "x y px py pz weight", str(filters))

        def even(group, _):  # what compresses well is copies of copies
            del group["weighting"]
            group.create_dataset("weighting", data=numpy.full(120, 3.5), chunks=(120,), compression="lzf")
        beam, path = self.write(change=even)
        beam.hold(self, beams.read(path).steps[0], weight=numpy.full(120, 3.5))

    def test_odd_steps_are_left_out(self):
        def change(group, step):
            if step == "2":
                for record in list(group):
                    del group[record]
                group.create_group("position/x")
        beam, path = self.write(steps=("1", "2", "3"), change=change)
        made = beams.read(path)
        self.assertEqual([step.iteration for step in made.steps], [1, 3])
        self.assertIn("a step cannot be read and is left out", made.notes)
        whole = path.read_bytes()
        (self.folder / "b.h5").write_bytes(whole[:300])
        made = beams.read([path, self.folder / "b.h5"])
        self.assertEqual(len(made.steps), 2)
        self.assertIn("b.h5", made.notes)
        self.refused("b.h5", beams.read, self.folder / "b.h5")

        def one(group, step):
            if step == "2":
                del group["momentum/x"]
                group.create_dataset("momentum/x", data=h5py.Empty("f8"))
        beam, path = self.write("c.h5", steps=("1", "2"), change=one)
        made = beams.read(path, axes="x,y,py")
        beam.hold(self, made.steps[0], what="the whole step")
        self.assertTrue(numpy.isnan(made.steps[1]["px"]).all())

    def test_a_species_may_begin_later(self):
        def change(group, step):
            group.parent.create_group("ions")
            if step == "0":
                group.parent.move("electrons", "other")
            beams.write_species(group.parent["ions"], Beam(seed=5))
        beam, path = self.write(steps=("0", "100"), change=change)
        made = beams.read(path, "--species", "electrons")
        self.assertEqual([len(step["x"]) for step in made.steps], [0, 120])
        beam.hold(self, made.steps[1])
        self.refused("holds no species 'muons', but ions", beams.read, path, "--species", "muons")

    def test_particles_below_groups(self):
        beam = Beam()
        cases = {"archive": ("/lume/output/particles/final_particles",), "numbers": ("/gpt/output/particles/0", "/gpt/output/particles/7"),
                 "root": ("/final",)}
        for what, groups in cases.items():
            with self.subTest(what=what), h5py.File(self.folder / f"{what}.h5", "w") as file:
                for group in groups:
                    beams.write_species(file.require_group(group), beam).attrs["speciesType"] = numpy.bytes_("electron")
                file.require_group("/lume/input/numbers")
                file.close()
                made = beams.read(self.folder / f"{what}.h5")
                self.assertEqual(len(made.steps), len(groups))
                beam.hold(self, made.steps[-1], what=what)
        with beams.openpmd(self.folder / "below.h5", root="/a/b") as file:
            beams.write_species(file.require_group("/a/b/data/5/particles/e"), beam)
        beam.hold(self, beams.read(self.folder / "below.h5").steps[0])
        with h5py.File(self.folder / "two.h5", "w") as file:
            for name in ("initial_particles", "final_particles"):
                beams.write_species(file.require_group("/run/" + name), beam)
        self.refused("choose one with --species", beams.read, self.folder / "two.h5")
        beam.hold(self, beams.read(self.folder / "two.h5", "--species", "final_particles").steps[0])

    def test_variable_iterations(self):
        beam = Beam()
        for base in ("/data/%T/", "/data/", "/data"):
            with self.subTest(base=base):
                with beams.openpmd(self.folder / "v.h5", base=base, encoding="variableBased") as file:
                    beams.write_species(file.require_group("/data/particles/e"), beam)
                    file["/data"].attrs["snapshot"] = numpy.uint64(42)
                made = beams.read(self.folder / "v.h5")
                self.assertEqual(made.steps[0].iteration, 42)
                beam.hold(self, made.steps[0])

    def test_neutral_particles_have_no_charge(self):
        for species, charge, each in (("photon", None, 0), ("neutron", None, 0), ("#12C", 0.0, 0), ("#12C", None, 1), ("#12C", 6 * E, 6),
                                      ("electron", None, 1), ("other", None, 1)):
            def change(group, _, species=species, charge=charge):
                group.attrs["speciesType"] = numpy.bytes_(species)
                if charge is not None:
                    beams.constant(group, "charge", charge, [120])
                group.parent.move("electrons", "those")
            with self.subTest(species=species, charge=charge):
                beam, path = self.write(change=change)
                made = beams.read(path)
                numpy.testing.assert_allclose(made.statistics["charge"], each * E * beam.weight.sum(), rtol=1e-12, atol=0)
                self.assertEqual(made.species, "#12C+0" if charge == 0 else made.species)

    def test_photons_have_the_energy_p_c(self):
        def change(group, _):
            beams.constant(group, "mass", 0.0, [120])
            group.parent.move("electrons", "photons")
        beam, path = self.write(change=change)
        beam.hold(self, beams.read(path, axes="x,y,energy").steps[0])

    def test_folders(self):
        beam, _ = self.write("run_1.h5")
        self.write("run_2.h5", steps=("2",))
        write_text(self.folder / "README.txt", "notes\n")
        made = beams.read(self.folder)
        self.assertEqual(len(made.steps), 2)
        self.assertIn("1 of the files is left out", made.notes)
        beam.hold(self, made.steps[1])

    def test_folders_of_several_formats(self):
        beam, _ = self.write("run_1.h5")
        rows = beams.table(["id", "x [m]", "y [m]", "px [eV/c]", "py [eV/c]", "pz [eV/c]"],
                           [beam.id, beam.x, beam.y, beam.px, beam.py, beam.pz], fmt="%.17g")
        write_text(self.folder / "a_first.csv", rows)
        self.refused("as many files of", beams.read, self.folder)
        for chosen in ("csv", "openpmd"):
            made = beams.read(self.folder, "--format", chosen)
            beam.hold(self, made.steps[0], what=chosen)
            self.assertEqual(len(made.steps), 1)
            self.assertTrue("left out" in made.notes, made.notes)
        self.write("run_2.h5", steps=("2",))
        made = beams.read(self.folder)
        self.assertEqual([step.iteration for step in made.steps], [1, 2])
        self.assertIn("a_first.csv is csv, not openpmd", made.notes)
        self.refused("is of another format", beams.read, [self.folder / "run_1.h5", self.folder / "a_first.csv"])


@needs_program
class Refusals(Case):
    def test_known_formats_are_named(self):
        known = {
            "DICOM": b"\0" * 128 + b"DICM", "ROOT": b"root\0\0\xf0", "netCDF": b"CDF\x01\0\0\0\0", "HDF4": b"\x0e\x03\x13\x01",
            "MATLAB": b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "FITS": b"SIMPLE  =                    T", "Parquet": b"PAR1\x15\0",
            "Arrow": b"ARROW1\0\0", "SQLite": b"SQLite format 3\0", "VTK": b"# vtk DataFile Version 3.0\nx\nASCII\n",
            "NRRD": b"NRRD0004\ntype: float\n", "MetaImage": b"ObjectType = Image\nNDims = 3\n", "OpenVDB": b" BDV\0\0\0\0",
            "PLY": b"ply\nformat ascii 1.0\n", "STL": b"solid cube\n facet normal 0 0 1\n", "OFF": b"OFF\n8 6 0\n",
            "glTF": b"glTF\x02\0\0\0", "STEP": b"ISO-10303-21;\nHEADER;\n", "Gmsh": b"$MeshFormat\n2.2 0 8\n",
            "PNG": b"\x89PNG\r\n\x1a\n\0", "JPEG": b"\xff\xd8\xff\xe0\0", "TIFF": b"II*\0\x08\0\0\0", "OpenEXR": b"v/1\x01\x02\0\0\0",
            "GIF": b"GIF89a\x01\0", "PDF": b"%PDF-1.5\n", "program": b"\x7fELF\x02\x01", "bzip2": b"BZh91AY\0", "xz": b"\xfd7zXZ\0",
            "Zstandard": b"\x28\xb5\x2f\xfd\0", "7-Zip": b"7z\xbc\xaf\x27\x1c\0", "tar": b"a" + b"\0" * 256 + b"ustar\0",
            "pickle": b"\x80\x04\x95\0", "Excel": b"\xd0\xcf\x11\xe0\0", "NIfTI": b"\x5c\x01\0\0" + b"\0" * 340 + b"n+1\0",
            "MRC": b"\0" * 208 + b"MAP ", "LAMMPS": b"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n",
            "XDMF": b"<?xml version='1.0'?>\n<Xdmf Version='2.0'>\n", "VTK image": b'<?xml version="1.0"?>\n<VTKFile type="ImageData">\n',
            "web page": b"<!DOCTYPE html>\n<html>\n", "Git LFS": b"version https://git-lfs.github.com/spec/v1\n", "ADIOS2": b"ADIOS-BP v2.8\0",
        }
        for what, begin in known.items():
            with self.subTest(what=what):
                path = self.folder / "file"
                path.write_bytes(begin)
                self.refused(what, beams.read, path)
        store = self.folder / "a.zarr"
        store.mkdir()
        write_text(store / ".zgroup", "{}")
        self.refused("Zarr", beams.read, store)
