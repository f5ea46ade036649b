# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables with names, and those without: units in every notation, forms of momenta, maps of columns, xsuite."""
import itertools
import json
import math

import numpy

import beams
from beams import C, E, ELECTRON, PROTON, Beam, table, write_text
from support import Case, needs_program

ION = 11.2e9


@needs_program
class Tables(Case):
    FORMATS = {"csv", "impactz", "npy"}

    def test_units_in_every_notation(self):
        beam = Beam()
        columns = [beam.id, beam.x * 1e3, beam.y * 1e6, beam.px / 1e6, beam.py / 1e3, beam.pz / 1e9, beam.weight]
        plain = ["id", "x", "y", "px", "py", "pz", "weight"]
        units = ["", "mm", "um", "MeV/c", "keV/c", "GeV/c", ""]
        notations = {"brackets": "{} [{}]", "parentheses": "{}({})", "braces": "{} {{{}}}", "low line": "{}_{}", "slash": "{}/{}"}
        for (what, form), separator, upper in itertools.product(notations.items(), ",;\t", (False, True)):
            names = [form.format(name, unit) if unit else name for name, unit in zip(plain, units)]
            names = [name.upper() if upper and "[" not in form and form == "{}_{}" else name for name in names]
            with self.subTest(what=what, separator=separator, upper=upper):
                made = beams.read(write_text(self.folder / "a.txt", table(names, columns, separator)))
                beam.hold(self, made.steps[0], "x y px py pz weight", what)
                self.assertNotIn("no unit", made.notes)

    def test_units_in_a_line_below_the_names(self):
        beam = Beam()
        columns = [beam.id, beam.x * 1e3, beam.y * 1e6, beam.px / 1e6, beam.py / 1e3, beam.pz / 1e9]
        body = table(None, columns, " ")
        for header in ("id x y px py pz\n1 mm um MeV/c keV/c GeV/c\n", "# id x y px py pz\n# [1] [mm] [um] [MeV/c] [keV/c] [GeV/c]\n",
                       "A title\nand more of it\n id x(mm) y(um) px(MeV/c) py(keV/c) pz(GeV/c)\n",
                       "% id x [mm] y [um] px [MeV/c] py [keV/c] pz [GeV/c]\n%\n"):
            with self.subTest(header=header):
                beam.hold(self, beams.read(write_text(self.folder / "a.txt", header + body)).steps[0], what=header)

    def test_assumed_units_are_said(self):
        beam = Beam()
        made = beams.read(write_text(self.folder / "a.csv", table(["id", "x", "y", "px", "py [eV/c]"],
                                                                  [beam.id, beam.x, beam.y, beam.px, beam.py])))
        self.assertIn("no unit is given for x, y: taken as m", made.notes)
        self.assertIn("no unit is given for px: taken as eV/c", made.notes)

    def test_forms_of_momenta(self):
        beam = Beam()
        places = ["id", "x [m]", "y [m]"], [beam.id, beam.x, beam.y]
        speed = beam.p / (beam.gamma * beam.mass) / beam.p  # beta over momentum
        forms = {
            "m c": (["px [mc]", "py [m c]", "pz [#beta#gamma]"], [beam.px / beam.mass, beam.py / beam.mass, beam.pz / beam.mass]),
            "names of m c": (["GBx", "GBy", "ux"], None),
            "kg m/s": (["px [kg m/s]", "py [kg*m/s]", "pz [kg.m/s]"], [v * E / C for v in (beam.px, beam.py, beam.pz)]),
            "velocities": (["vx [m/s]", "vy [c]", "vz [m/s]"], [beam.px * speed * C, beam.py * speed, beam.pz * speed * C]),
            "slopes": (["xp [mrad]", "y' [rad]", "p [MeV/c]"], [1e3 * beam.px / beam.pz, beam.py / beam.pz, beam.p / 1e6]),
            "slopes and energy": (["xp", "yp", "ekin [MeV]"], [beam.px / beam.pz, beam.py / beam.pz,
                                                              beam.mass * (beam.gamma - 1) / 1e6]),
            "gamma": (["px [eV/c]", "py [eV/c]", "gamma"], [beam.px, beam.py, beam.gamma]),
            "the whole energy": (["px [eV/c]", "py [eV/c]", "etot [GeV]"], [beam.px, beam.py, beam.gamma * beam.mass / 1e9]),
        }
        for what, (names, columns) in forms.items():
            if columns is None:
                names, columns = ["GBx", "GBy", "uz"], [beam.px / beam.mass, beam.py / beam.mass, beam.pz / beam.mass]
            with self.subTest(what=what):
                text = table(places[0] + names, places[1] + columns, fmt="%.17g")
                made = beams.read(write_text(self.folder / "a.csv", text), "--mass", beam.mass)
                beam.hold(self, made.steps[0], what=what)

    def test_text_of_tracewin(self):
        beam = Beam(mass=PROTON, p0=3e8)
        names = ["x(mm)", "x'(mrad)", "y(mm)", "y'(mrad)", "Phase(deg)", "Time(s)", "Energy(MeV)", "Loss"]
        columns = [beam.x * 1e3, 1e3 * beam.px / beam.pz, beam.y * 1e3, 1e3 * beam.py / beam.pz, beam.t * 72e9, beam.t,
                   beam.mass * (beam.gamma - 1) / 1e6, beam.lost]
        text = "120 0.1 352.2\nof TraceWin\n" + table(names, columns, "   ", "%.17g")
        made = beams.read(write_text(self.folder / "part.txt", text), "--mass", PROTON)
        beam.hold(self, made.steps[0], "x y px py pz t lost", ids=False)

    def test_titles_of_fields(self):
        beam = Beam()
        fields = [("id", "<u8", beam.id), (("x [mm]", "x"), "<f8", beam.x * 1e3), (("of interest", "y"), ">f8", beam.y),
                  (("px [MeV/c]", "px"), "<f8", beam.px / 1e6), (("py [eV/c]", "py"), "<f8", beam.py), (("weight [C]", "weight"), "<f8", beam.weight * E)]
        array = numpy.empty(beam.count, [(name, dtype) for name, dtype, _ in fields])
        for name, _, values in fields:
            array[name[1] if isinstance(name, tuple) else name] = values
        numpy.save(self.folder / "titles.npy", array)
        made = beams.read(self.folder / "titles.npy")
        beam.hold(self, made.steps[0], "x y px py", weight=beam.weight * E)
        self.assertEqual(made.weight_unit, "C")

    def test_a_map_of_columns(self):
        beam = Beam()
        names = ["N", "PosX", "PosY", "P1", "P2", "P3", "W", "gone"]
        columns = [beam.id, beam.x * 1e3, beam.y * 1e2, beam.px / 1e6, beam.py / 1e6, beam.pz / 1e6, beam.weight, beam.lost]
        word = "id=N,x=PosX [mm],y=PosY [cm],px=P1 [MeV/c],py=P2[MeV/c],pz=P3 (MeV/c),weight=W,lost=gone"
        number = "id=1,x=2 [mm],y=3 [cm],px=4 [MeV/c],py=5 [MeV/c],pz=6 [MeV/c],weight=7,lost=8"
        for what, text, said in (("names", table(names, columns), word), ("a title", "my run\n" + table(names, columns), word),
                                 ("a comment", "# " + table(names, columns, " "), word),
                                 ("no names", table(None, columns), number), ("a count", f"{beam.count}\n" + table(None, columns), number), ("blanks", table(None, columns, "  "), number),
                                 ("tabs", table(None, columns, "\t"), number), ("names by numbers", table(names, columns), number)):
            with self.subTest(what=what):
                made = beams.read(write_text(self.folder / "a.dat", text), "--map", said)
                beam.hold(self, made.steps[0], "x y px py pz weight lost", what)
        path = write_text(self.folder / "b.dat", table(None, columns))
        self.refused("put a line of names over it", beams.read, path)
        self.refused("has no column 'Q'", beams.read, path, "--map", "x=Q")
        self.refused("is none of x, y, z", beams.read, path, "--map", "spin=1")

    def test_nine_columns_are_no_beam_of_impact(self):
        beam = Beam()
        path = write_text(self.folder / "fort.9", table(None, [beam.x, beam.px, beam.y, beam.py, beam.zeta, beam.pz, beam.weight,
                                                               beam.t, beam.gamma], " "))
        self.refused("this is no particle file of IMPACT-Z", beams.read, path, "--format", "impactz", "--mass", ELECTRON,
                     "--frequency", 2e8, "--kinetic-energy", 1e8)


@needs_program
class Xsuite(Case):
    FORMATS = {"csv", "json", "npz"}

    def columns(self, beam, longitudinal):
        columns = {"particle_id": beam.id, "state": numpy.where(beam.lost, -3, 1), "at_turn": numpy.full(beam.count, 3),
                   "x": beam.x, "px": beam.px / beam.p0, "y": beam.y, "py": beam.py / beam.p0, "zeta": beam.zeta,
                   "p0c": numpy.full(beam.count, beam.p0), "mass0": numpy.full(beam.count, beam.mass),
                   "q0": numpy.full(beam.count, float(beam.charge)), "weight": beam.weight, "s": numpy.zeros(beam.count)}
        if longitudinal == "delta":
            columns["delta"] = beam.delta
        if longitudinal == "ptau":
            columns["ptau"] = beam.pt
        if longitudinal == "pzeta":
            columns["pzeta"] = beam.pt / beam.beta0
        if longitudinal == "ratios":  # two species beside each other: momenta are over the mass, too
            columns |= {"delta": beam.delta, "chi": numpy.ones(beam.count), "charge_ratio": numpy.ones(beam.count)}
        return columns

    def hold(self, beam, made, what):
        beam.hold(self, made.steps[0], "x y px py pz weight lost t", what, z=beam.zeta)
        self.assertAlmostEqual(made.mass / beam.mass, 1, 9)
        self.assertAlmostEqual(made.charge / (beam.charge * E), 1, 9)
        self.assertEqual(made.weight_unit, "1")

    def test_csv(self):
        for (mass, p0, charge), longitudinal, index in itertools.product(
                ((ELECTRON, 1e8, -1), (PROTON, 7e12, 1), (PROTON, 3e8, 1), (ION, 5e10, 6)), ("delta", "ptau", "pzeta", "ratios"),
                (False, True)):
            beam = Beam(mass=mass, p0=p0, charge=charge)
            columns = self.columns(beam, longitudinal)
            names, values = list(columns), list(columns.values())
            if index:  # of pandas
                names, values = [""] + names, [numpy.arange(beam.count)] + values
            with self.subTest(mass=mass, longitudinal=longitudinal, index=index):
                path = write_text(self.folder / "p.csv", table(names, values, fmt="%.17g"))
                self.hold(beam, beams.read(path), f"{mass} {longitudinal}")

    def test_json_and_npz(self):
        beam = Beam(mass=PROTON, p0=3e9, charge=1)
        columns = self.columns(beam, "delta")
        lists = {name: values.tolist() for name, values in columns.items()}
        scalars = lists | {"mass0": beam.mass, "q0": float(beam.charge), "p0c": beam.p0}
        forms = {"lists": lists, "scalars": scalars, "within": {"version": "1", "particles": scalars, "note": ["a", None]},
                 "not a number": scalars | {"spin_x": [math.nan] * beam.count, "ok": True}}
        for what, value in forms.items():
            with self.subTest(what=what):
                path = write_text(self.folder / "p.json", json.dumps(value, indent=1))
                self.hold(beam, beams.read(path), what)
        steps = beams.read(write_text(self.folder / "s.json", json.dumps([scalars, scalars])))
        self.assertEqual(len(steps.steps), 2)
        for what, save in (("savez", numpy.savez), ("savez_compressed", numpy.savez_compressed)):
            with self.subTest(what=what):
                save(self.folder / "p.npz", **columns)
                self.hold(beam, beams.read(self.folder / "p.npz"), what)
        self.refused("is no JSON", beams.read, write_text(self.folder / "bad.json", '{"x": [1, 2'))
        self.refused("without lists", beams.read, write_text(self.folder / "o.json", '{"a": 1}'))

    def test_without_a_reference_momentum_nothing_is_believed(self):
        beam = Beam()
        columns = self.columns(beam, "delta")
        del columns["p0c"]
        path = write_text(self.folder / "p.csv", table(list(columns), list(columns.values())))
        self.refused("in units of the reference momentum", beams.read, path)
        numpy.savez(self.folder / "p.npz", **columns)
        self.refused("deviations from a reference particle", beams.read, self.folder / "p.npz")
