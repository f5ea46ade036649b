# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of MAD-X and PTC, GPT, Ocelot and spiffe, written after their manuals."""
import gzip
import itertools
import struct

import numpy

import beams
from beams import C, E, ELECTRON, PROTON, Beam, table, write_text
from support import Case, needs_program


@needs_program
class Tfs(Case):
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
