# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of MAD-X and PTC, GPT, Ocelot, spiffe, PyORBIT and OPAL, written after their manuals and sources."""
import gzip
import itertools
import struct

import numpy

import beams
from beams import C, E, ELECTRON, PROTON, Beam, table, write_text
from support import Case, needs_program


@needs_program
class Tfs(Case):
    FORMATS = {"tfs"}

    def text(self, beam, header, energy, rows=None, segment=False, turn=0):
        rows = range(beam.count) if rows is None else rows
        lines = ['@ NAME             %08s "TRACKONE"', '@ TYPE %08s "TRACKONE"', *header,
                 "*  NUMBER  TURN  X  PX  Y  PY  T  PT  S  E", "$ %d %d %le %le %le %le %le %le %le %le"]
        if segment:
            lines.append("#segment       1       9 120       1 start")
        for i in rows:
            lines.append(" ".join(f"{value:.17g}" for value in (
                beam.id[i], turn, beam.x[i], beam.px[i] / beam.p0, beam.y[i], beam.py[i] / beam.p0, -C * beam.t[i], beam.pt[i],
                0.0, energy[i])))
        return "\n".join(lines) + "\n"

    def test_every_way_to_say_the_reference(self):
        for mass, p0 in ((ELECTRON, 1e8), (PROTON, 7e12), (PROTON, 3e8)):
            beam = Beam(mass=mass, p0=p0, charge=1)
            constant, own = numpy.full(beam.count, beam.e0 / 1e9), numpy.hypot(beam.p, mass) / 1e9
            giga = {"PC": f"@ PC %le {p0 / 1e9:.17g}", "MASS": f"@ MASS %le {mass / 1e9:.17g}", "CHARGE": "@ CHARGE %le 1",
                    "ENERGY": f"@ ENERGY %le {beam.e0 / 1e9:.17g}", "GAMMA": f"@ GAMMA %le {beam.e0 / mass:.17g}",
                    "PARTICLE": f'@ PARTICLE %08s "{"PROTON" if mass == PROTON else "ELECTRON"}"'}
            for names, energy, options in ((("PC", "MASS", "CHARGE"), constant, ()), (("ENERGY", "MASS"), constant, ()),
                                           (("PC",), constant, ("--mass", mass)), (("GAMMA", "MASS"), own, ()),
                                           (("PC", "PARTICLE"), own, ()), ((), constant, ("--mass", mass)),
                                           ((), own, ("--mass", mass)), (("MASS",), own, ())):
                with self.subTest(mass=mass, p0=p0, names=names):
                    path = write_text(self.folder / "trackone", self.text(beam, [giga[name] for name in names], energy))
                    made = beams.read(path, *options)
                    # What is found from energies of 17 digits is known to the share of the mass in them.
                    beam.hold(self, made.steps[0], "x y px py pz t", f"{mass} {names}", z=beam.zeta)
                    self.assertAlmostEqual(made.mass / mass, 1, 6)

    def test_steps(self):
        beam = Beam()
        header = [f"@ PC %le {beam.p0 / 1e9:.17g}", f"@ MASS %le {beam.mass / 1e9:.17g}"]
        energy = numpy.full(beam.count, beam.e0 / 1e9)
        first = self.text(beam, header, energy, segment=True)
        second = "\n".join(self.text(beam, [], energy, segment=True, turn=1).splitlines()[4:]) + "\n"
        made = beams.read(write_text(self.folder / "trackone", first + second))
        self.assertEqual(len(made.steps), 2)
        for step in made.steps:
            beam.hold(self, step, what="segments")
        turns = self.text(beam, header, energy) + "\n".join(self.text(beam, [], energy, turn=5).splitlines()[4:]) + "\n"
        made = beams.read(write_text(self.folder / "turns.tfs", turns))
        self.assertEqual([step.iteration for step in made.steps], [0, 5])
        files = []
        for i in range(beam.count):  # a file a particle, a line a turn
            text = self.text(beam, header, energy, [i]) + self.text(beam, [], energy, [i], turn=1).splitlines()[-1] + "\n"
            files.append(write_text(self.folder / f"track.obs0001.p{i + 1:04d}", text))
        made = beams.read(files)
        self.assertEqual(len(made.steps), 2)
        for step in made.steps:
            beam.hold(self, step, what="a file a particle")
        packed = self.folder / "track.tfs.gz"
        packed.write_bytes(gzip.compress(first.encode()))
        beam.hold(self, beams.read(packed).steps[0], what="gzipped")

    def test_what_is_no_track_is_refused(self):
        beam = Beam()
        energy = numpy.full(beam.count, beam.e0 / 1e9)
        self.refused("says neither PC nor MASS", beams.read, write_text(self.folder / "a.tfs", self.text(beam, [], energy)))
        optics = '@ TYPE %05s "TWISS"\n* NAME S X PX Y PY BETX\n$ %s %le %le %le %le %le %le\n "IP1" 0 0 0 0 0 1\n'
        self.refused("optics, no track", beams.read, write_text(self.folder / "b.tfs", optics))
        self.refused("without the column", beams.read, write_text(self.folder / "c.tfs", '@ TYPE %05s "SURVEY"\n* S Z\n$ %le %le\n 1 2\n'))


def gdf(beam, times, dtype="<f8", root=False):
    """GDF by its manual: a header, then blocks of name, type and length."""
    code = {"<f8": 3, "<f4": 0x90}[dtype]
    out = struct.pack("<II16s16s8B", 94325877, 0, b"GPT", b"", 1, 1, 3, 0, 0, 0, 0, 0)

    def block(name, kind, data):
        return struct.pack("<16sII", name.encode(), kind, len(data)) + data

    out += block("version", 0x400 | 1, b"3.10")
    columns = {"x": beam.x, "y": beam.y, "z": beam.zeta, "Bx": beam.px, "By": beam.py, "Bz": beam.pz}
    for time in times:
        if not root:
            out += block("time", 0x100 | 0x400 | 3, struct.pack("<d", time))
        for name, values in columns.items():
            values = values / (beam.gamma * beam.mass) if name.startswith("B") else values
            out += block(name, 0x800 | code, values.astype(dtype).tobytes())
        for name, values in (("G", beam.gamma), ("ID", beam.id), ("nmacro", beam.weight),
                             ("m", numpy.full(beam.count, beam.mass * E / C**2)), ("q", numpy.full(beam.count, -E)),
                             ("rmacro", numpy.ones(beam.count))):
            out += block(name, 0x800 | 3, values.astype("<f8").tobytes())
        if not root:
            out += block("", 0x200, b"")
    return out + block("cputime", 0x400 | 3, struct.pack("<d", 1.0))


@needs_program
class Gpt(Case):
    FORMATS = {"gpt"}

    def test_gdf(self):
        beam = Beam()
        for dtype, times, root in (("<f8", [0.0], False), ("<f8", [1e-9, 2e-9, 5e-9], False), ("<f4", [1e-9], False),
                                   ("<f8", [0.0], True)):
            with self.subTest(dtype=dtype, times=times, root=root):
                path = self.folder / "a.gdf"
                path.write_bytes(gdf(beam, times, dtype, root))
                made = beams.read(path)
                self.assertEqual(len(made.steps), len(times))
                self.assertAlmostEqual(made.mass / ELECTRON, 1, 9)
                for step, time in zip(made.steps, times):
                    self.assertEqual(step.time, 0.0 if root else time)
                    if dtype == "<f8":
                        beam.hold(self, step, "x y px py pz weight", str(times))
                    else:
                        numpy.testing.assert_allclose(step["x"], beam.x[beam.order], rtol=0, atol=1e-6 * abs(beam.x).max())
        whole = gdf(beam, [0.0])
        for cut in (20, 60, len(whole) // 2):
            (self.folder / "cut.gdf").write_bytes(whole[:cut])
            self.refused("cut.gdf", beams.read, self.folder / "cut.gdf")

    def test_text(self):
        beam = Beam()
        unit = beam.gamma * beam.mass
        beta = ["x", "y", "z", "Bx", "By", "Bz", "G", "ID", "nmacro", "m", "q"], [
            beam.x, beam.y, beam.zeta, beam.px / unit, beam.py / unit, beam.pz / unit, beam.gamma, beam.id, beam.weight,
            numpy.full(beam.count, beam.mass * E / C**2), numpy.full(beam.count, -E)]
        scaled = ["ID", "x", "y", "z", "GBx", "GBy", "GBz", "nmacro"], [
            beam.id, beam.x, beam.y, beam.zeta, beam.px / beam.mass, beam.py / beam.mass, beam.pz / beam.mass, beam.weight]
        for (names, columns), head in itertools.product((beta, scaled), ("", "time 1e-9\n", "time\n1e-9\n", "# GPT\n")):
            with self.subTest(names=names, head=head):
                text = head + table(names, columns, " ", "%.17g")
                made = beams.read(write_text(self.folder / "a.txt", text))
                beam.hold(self, made.steps[0], "x y px py pz weight", head)
                self.assertEqual(made.steps[0].time, 1e-9 if "time" in head else 0.0)
        block = table(*scaled, " ", "%.17g")
        made = beams.read(write_text(self.folder / "a.txt", "time 1e-9\n" + block + "\ntime 2e-9\n" + block))
        self.assertEqual([step.time for step in made.steps], [1e-9, 2e-9])


@needs_program
class Ocelot(Case):
    FORMATS = {"ocelot"}

    def test_archives(self):
        beam = Beam()
        particles = numpy.array([beam.x, beam.px / beam.p0, beam.y, beam.py / beam.p0, C * beam.t, beam.pt])
        charge = beam.weight * E
        for save, order, dtype in itertools.product((numpy.savez, numpy.savez_compressed), "CF", ("<f8", ">f8")):
            with self.subTest(save=save.__name__, order=order, dtype=dtype):
                save(self.folder / "a.npz", rparticles=numpy.array(particles, order=order, dtype=dtype), q_array=charge,
                     E=beam.e0 / 1e9, s=1.5)
                made = beams.read(self.folder / "a.npz")
                beam.hold(self, made.steps[0], "x y px py pz t", order, ids=False, z=beam.zeta, weight=charge)
                self.assertEqual(made.weight_unit, "C")


@needs_program
class Spiffe(Case):
    FORMATS = {"sdds"}

    def test_rings(self):
        beam = Beam()
        radius, pr, pphi = numpy.hypot(beam.x, beam.y), beam.px / beam.mass, beam.py / beam.mass
        for units in (True, False):
            head = "SDDS1\n"
            for name, unit in (("r", "m"), ("pr", "m$be$nc"), ("pphi", "m$be$nc"), ("pz", "m$be$nc"), ("t", "s"), ("q", "C")):
                head += f"&column name={name}, type=double" + (f', units="{unit}"' if units or name != "pr" else "") + ", &end\n"
            text = head + f"&data mode=ascii, &end\n{beam.count}\n" + table(
                None, [radius, pr, pphi, beam.pz / beam.mass, beam.t, numpy.full(beam.count, 1e-15)], " ", "%.17g")
            made = beams.read(write_text(self.folder / "a.sdds", text))
            step = made.steps[0]
            self.assertIn("rings", made.notes)
            made_radius = numpy.hypot(step["x"], step["y"])  # there are no ids: radii tell the rows apart
            here, there = numpy.argsort(made_radius), numpy.argsort(radius)
            numpy.testing.assert_allclose(made_radius[here], radius[there], rtol=1e-5)
            across = step["px"]**2 + step["py"]**2
            numpy.testing.assert_allclose(across[here], (beam.px**2 + beam.py**2)[there], rtol=1e-4)
            turn = (step["x"] * step["py"] - step["y"] * step["px"]) / made_radius  # about the axis
            numpy.testing.assert_allclose(turn[here], beam.py[there], rtol=1e-3, atol=100.0)
            self.assertAlmostEqual(step["weight"].sum() / (beam.count * 1e-15), 1, 6)


def pyorbit(beam, attributes=(), momentum=True, kinetic=False, mass=True, macro=0.0, time=0.0):
    """A bunch as Bunch.dumpBunch() writes it, with all digits."""
    columns = [beam.x, beam.px / beam.p0, beam.y, beam.py / beam.p0, beam.zeta, beam.pt * beam.p0 / 1e9]
    known = {"ParticleIdNumber": [beam.id], "macrosize": [beam.weight], "TurnNumber": [numpy.arange(beam.count)],
             "ParticleInitialCoordinates": [beam.x] * 6, "LostParticleAttributes": [numpy.full(beam.count, 12.5)],
             "SomethingNew": [beam.y, beam.y]}
    for name in sorted(attributes):
        columns += known[name]
    head = ["% PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES " + " ".join(sorted(attributes)),
            f"% BUNCH_ATTRIBUTE_DOUBLE charge   {beam.charge} ", "% BUNCH_ATTRIBUTE_DOUBLE classical_radius   1.5347e-18 ",
            f"% BUNCH_ATTRIBUTE_DOUBLE macro_size   {macro!r} "]
    if mass:
        head.append(f"% BUNCH_ATTRIBUTE_DOUBLE mass   {beam.mass / 1e9!r} ")
    head.append("%  SYNC_PART_COORDS 0 0 0  x, y, z positions in [m]")
    if momentum:
        head.append(f"%  SYNC_PART_MOMENTUM 0 0 {beam.p0 / 1e9!r}  px, py, pz momentum component in GeV/c")
    if kinetic:
        head.append(f"%  info only: energy of the synchronous particle [GeV] = {float(beam.e0 - beam.mass) / 1e9!r}")
    head += ["%  info only: beta=v/c of the synchronous particle = 0.5", f"%  SYNC_PART_TIME {time!r}  time in [sec]",
             "% x[m] px[rad] y[m] py[rad] z[m]  (pz or dE [GeV])"]
    return "\n".join(head) + "\n" + table(None, columns, " ", "%.17g")


@needs_program
class PyOrbit(Case):
    FORMATS = {"pyorbit"}

    def test_every_way_to_say_the_synchronous_particle(self):
        for mass, p0 in ((PROTON, 1.7e9), (PROTON, 7e12), (ELECTRON, 1e8)):
            beam = Beam(mass=mass, p0=p0, charge=1)
            for said, options in (({}, ()), ({"momentum": False, "kinetic": True}, ()), ({"mass": False}, ("--mass", mass)),
                                  ({"kinetic": True, "time": 2e-6}, ())):
                with self.subTest(mass=mass, p0=p0, said=said):
                    path = write_text(self.folder / "bunch.dat", pyorbit(beam, **said))
                    made = beams.read(path, *options)
                    beam.hold(self, made.steps[0], "x y px py pz t", str(said), ids=False, z=beam.zeta)
                    self.assertAlmostEqual(made.mass / mass, 1, 9)
                    self.assertAlmostEqual(made.charge / E, 1, 9)
                    self.assertEqual(made.steps[0].time, said.get("time", 0.0))

    def test_attributes(self):
        beam = Beam(mass=PROTON, p0=1.7e9, charge=1)
        for attributes in (("ParticleIdNumber",), ("ParticleIdNumber", "macrosize"), ("TurnNumber", "macrosize", "ParticleIdNumber"),
                           ("ParticleInitialCoordinates", "ParticleIdNumber"), ("LostParticleAttributes", "ParticleIdNumber"),
                           ("SomethingNew", "ParticleIdNumber", "macrosize")):
            with self.subTest(attributes=attributes):
                made = beams.read(write_text(self.folder / "bunch.dat", pyorbit(beam, attributes)))
                beam.hold(self, made.steps[0], what=str(attributes))
                if "macrosize" in attributes:
                    beam.hold(self, made.steps[0], "weight", str(attributes))
                if "LostParticleAttributes" in attributes:
                    self.assertTrue((made.steps[0]["lost"] == 1).all())
        made = beams.read(write_text(self.folder / "bunch.dat", pyorbit(beam, macro=2.5e5)))
        self.assertTrue((made.steps[0]["weight"] == 2.5e5).all())
        self.assertEqual(made.weight_unit, "1")

    def test_series_and_what_is_missing(self):
        beam = Beam(mass=PROTON, p0=1.7e9, charge=1)
        files = [write_text(self.folder / f"bunch_{i}.dat", pyorbit(beam, time=i * 1e-6)) for i in (2, 10, 1)]
        write_text(self.folder / "bunch_7.dat", pyorbit(beam)[:-30] + "\n")
        made = beams.read(self.folder)
        self.assertEqual([step.iteration for step in made.steps], [1, 2, 10])
        self.assertEqual([step.time for step in made.steps], [1 * 1e-6, 2 * 1e-6, 10 * 1e-6])
        self.assertIn("bunch_7.dat", made.notes)
        self.refused("SYNC_PART_MOMENTUM", beams.read, write_text(files[0], pyorbit(beam, momentum=False)))
        self.refused("says no mass", beams.read, write_text(files[0], pyorbit(beam, mass=False)))


@needs_program
class Opal(Case):
    FORMATS = {"opal", "csv"}  # a map makes a table of it

    def rows(self, beam, fifth):
        columns = [beam.x, beam.px / beam.mass, beam.y, beam.py / beam.mass, fifth, beam.pz / beam.mass]
        return columns, table(None, columns, " ", "%.17g")

    def test_distributions(self):
        for mass, options in ((ELECTRON, ()), (PROTON, ("--mass", PROTON))):
            beam = Beam(mass=mass)
            time = -1e-12 * abs(beam.zeta) / abs(beam.zeta).max()
            for name, fifth in (("z", beam.zeta), ("t", time)):
                columns, rows = self.rows(beam, fifth)
                names = f"x px y py {name} pz"
                unit = "m" if name == "z" else "s"
                dump = f"# x [m]            px [betax gamma] y [m]            py [betay gamma] {name} [{unit}]            pz [betaz gamma]"
                bins = table(None, [*columns, numpy.ones(beam.count)], " ", "%.17g")
                forms = {"counted": f"{beam.count}\n{rows}", "blanks": f"  {beam.count}  \n\n{rows}\n", "named": f"{beam.count}\n{names}\n{rows}",
                         "dump": f"{dump}\n# {beam.count}\n{rows}", "bins": f"{dump} Bin Number\n{bins}"}
                for what, text in forms.items():
                    with self.subTest(mass=mass, name=name, what=what):
                        made = beams.read(write_text(self.folder / "dist.dat", text), *options)
                        beam.hold(self, made.steps[0], "x y px py pz", what, ids=False, **{name: fifth})
                        self.assertIn("beta gamma", made.notes)
                        self.assertAlmostEqual(made.mass / mass, 1, 9)
                        self.assertEqual("taken for electrons" in made.notes, not options)

    def test_statistics_are_no_particles(self):
        text = "SDDS1\n" + "".join(f"&column name={name}, type=double, units={unit} &end\n" for name, unit in (
            ("t", "ns"), ("s", "m"), ("numParticles", "1"), ("rms_x", "m"), ("emit_x", "m")))
        path = write_text(self.folder / "run.stat", text + "&data mode=ascii, no_row_counts=1 &end\n0 0 10 1e-3 1e-6\n1 1 10 1e-3 1e-6\n")
        self.refused("statistics or optics (as OPAL's .stat", beams.read, path)

    def test_what_it_is_not(self):
        beam = Beam()
        _, rows = self.rows(beam, beam.zeta)
        path = write_text(self.folder / "dist.dat", f"{beam.count + 1}\n{rows}")
        self.refused("declares 121 particles and has 120", beams.read, path)
        volts = table(None, [beam.x, beam.px, beam.y, beam.py, beam.zeta, beam.pz], " ", "%.17g")
        path = write_text(self.folder / "ev.dat", f"{beam.count}\n{volts}")
        self.refused("which are no beta gamma", beams.read, path)
        made = beams.read(path, "--map", "x=1 [m],px=2 [eV/c],y=3 [m],py=4 [eV/c],z=5 [m],pz=6 [eV/c]")
        beam.hold(self, made.steps[0], ids=False, z=beam.zeta)
        self.refused("without names", beams.read, write_text(self.folder / "six.dat", rows))
        self.refused("is not a number", beams.read, write_text(self.folder / "word.dat", "2\nx px y py z pz\n1 2 3 4 5 6\n1 2 x 4 5 6\n"))
