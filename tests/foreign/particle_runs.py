# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of elegant (SDDS), ASTRA, TraceWin, Genesis, IMPACT-T and OPAL (H5Part), written after their manuals in every form that
these name."""
import gzip
import itertools
import struct

import h5py
import numpy

import beams
from beams import C, E, ELECTRON, PROTON, Beam, table, write_text
from support import Case, needs_program

SDDS_TYPES = {"short": "i2", "ushort": "u2", "long": "i4", "ulong": "u4", "long64": "i8", "ulong64": "u8", "float": "f4",
              "double": "f8", "character": "S1"}


def words(text, order):
    return struct.pack(order + "i", len(text)) + text.encode()


def sdds_head(version, columns, fixed, data, arrays):
    """`columns`: of name, type and unit."""
    head = [f"SDDS{version}", "&description text=\"a beam, quoted\", contents=\"phase space\", &end",
            "&parameter name=Step, type=long, &end", "&parameter name=Charge, units=C, type=double" +
            (f", fixed_value={fixed!r}" if fixed is not None else "") + ", &end",
            "&parameter name=Title, type=string, description=\"a text, with a comma\", &end"]
    if arrays:
        head.append("&array name=Twiss, type=double, dimensions=2, &end")
    head += [f"&column name={name}, type={kind}" + (f", units=\"{unit}\"" if unit else "") + ", &end" for name, kind, unit in columns]
    return "\n".join(head) + f"\n&data {data}, &end\n"


class Page:
    """One page of columns, in each of SDDS's forms."""

    def __init__(self, columns, step, charge, arrays):
        self.columns, self.step, self.charge, self.arrays = columns, step, charge, arrays
        self.rows = len(columns[0][1])

    def text(self, counts=True, lines=1, fixed=False):
        out = f"! page\n{self.step}\n" + ("" if fixed else f"{self.charge!r}\n") + "\"page of a run\"\n"
        out += "2 3\n1 2 3 4\n5 6\n" if self.arrays else ""
        out += f"{self.rows}\n" if counts else ""
        for row in range(self.rows):
            cells = [f"\"{values[row]}\"" if kind == "string" else repr(values[row].item()) for kind, values in self.columns]
            part = -(-len(cells) // lines)
            out += "".join(" ".join(cells[i:i + part]) + "\n" for i in range(0, len(cells), part))
        return out + ("" if counts else "\n")

    def binary(self, order, by_columns=False, wide=False, fixed=False):
        out = struct.pack(order + "iq", -2 ** 31, self.rows) if wide else struct.pack(order + "i", self.rows)
        out += struct.pack(order + "i", self.step) + (b"" if fixed else struct.pack(order + "d", self.charge)) + words("page of a run", order)
        if self.arrays:
            out += struct.pack(order + "ii6d", 2, 3, 1, 2, 3, 4, 5, 6)
        cells = [[words(text, order) for text in values] if kind == "string" else
                 [values[i:i + 1].astype(order + SDDS_TYPES[kind]).tobytes() for i in range(self.rows)] for kind, values in self.columns]
        return out + b"".join(itertools.chain(*(cells if by_columns else zip(*cells))))


@needs_program
class Sdds(Case):
    FORMATS = {"sdds"}

    def columns(self, beam, kind="double", number="long", label=True):
        slopes = {"x": (beam.x, "m"), "xp": (beam.px / beam.pz, ""), "y": (beam.y, "m"), "yp": (beam.py / beam.pz, ""),
                  "t": (beam.t + 1e-9, "s"), "p": (beam.p / beam.mass, "m$be$nc")}
        made = [(name, kind, unit, values.astype(SDDS_TYPES[kind])) for name, (values, unit) in slopes.items()]
        made.append(("particleID", number, "", beam.id.astype(SDDS_TYPES[number])))
        if label:
            made.insert(3, ("label", "string", "", [f"no {i}" for i in range(beam.count)]))
        return made

    def write(self, beam, name, mode, version=1, steps=1, kind="double", number="long", arrays=False, fixed=None, label=True,
              data="", **form):
        columns = self.columns(beam, kind, number, label)
        head = sdds_head(version, [each[:3] for each in columns], fixed, f"mode={mode}{data}", arrays)
        pages = [Page([(form_, values) for _, form_, _, values in columns], step, 1e-12, arrays) for step in range(steps)]
        path = self.folder / name
        if mode == "ascii":
            more = form.pop("more", "")
            path.write_text(head + more + "".join(page.text(fixed=fixed is not None, **form) for page in pages), encoding="ascii")
        else:
            path.write_bytes(head.encode() + b"".join(page.binary(fixed=fixed is not None, **form) for page in pages))
        return path

    def hold_written(self, made, beam, kind="double", steps=1, what=""):
        """What the written numbers say, worked out in doubles."""
        self.assertEqual(len(made.steps), steps, what)
        stored = {name: numpy.asarray(values, float) for name, _, _, values in self.columns(beam, kind, label=False)}
        pz = ELECTRON * stored["p"] / numpy.sqrt(1 + stored["xp"]**2 + stored["yp"]**2)
        px, py = stored["xp"] * pz, stored["yp"] * pz
        z = -(stored["t"] - stored["t"].mean()) * C * pz / numpy.sqrt(ELECTRON**2 + px**2 + py**2 + pz**2)
        for step in made.steps:
            beam.hold(self, step, "", what, x=stored["x"], y=stored["y"], px=px, py=py, pz=pz, t=stored["t"], z=z,
                      weight=numpy.full(beam.count, 1e-12 / beam.count))

    def test_every_form(self):
        beam = Beam()
        binary = itertools.product((("little", "<"), ("big", ">")), (False, True), ("double", "float"), ("long", "ulong64"), (1, 5),
                                   (False, True))
        for (word, order), by_columns, kind, number, version, arrays in binary:
            what = f"{word}-{by_columns}-{kind}-{number}-{version}-{arrays}"
            data = f", endian={word}" + (", column_major_order=1" if by_columns else "")
            path = self.write(beam, "a.sdds", "binary", version, 2, kind, number, arrays, data=data, order=order,
                              by_columns=by_columns)
            self.hold_written(beams.read(path), beam, kind, 2, what)
        for kind, number, version, lines, arrays in itertools.product(("double", "float"), ("short", "long64"), (1, 5), (1, 3), (False, True)):
            data = f", lines_per_row={lines}" if lines != 1 else ""
            path = self.write(beam, "a.sdds", "ascii", version, 2, kind, number, arrays, data=data, lines=lines)
            self.hold_written(beams.read(path), beam, kind, 2, f"{kind}-{number}-{version}-{lines}-{arrays}")

    def test_what_a_page_may_leave_out(self):
        beam = Beam()
        self.hold_written(beams.read(self.write(beam, "a.sdds", "ascii", fixed=1e-12)), beam, what="fixed, text")
        self.hold_written(beams.read(self.write(beam, "a.sdds", "binary", fixed=1e-12, order="<")), beam, what="fixed, binary")
        wide = self.write(beam, "a.sdds", "binary", 5, data=", endian=big", order=">", wide=True)
        self.hold_written(beams.read(wide), beam, what="counts of 64 bits")
        uncounted = self.write(beam, "a.sdds", "ascii", data=", no_row_counts=1", counts=False, label=False)
        self.hold_written(beams.read(uncounted), beam, what="no counts")
        more = self.write(beam, "a.sdds", "ascii", data=", additional_header_lines=2", more="one\ntwo\n")
        self.hold_written(beams.read(more), beam, what="more lines")
        path = self.write(beam, "a.sdds", "binary", order="<")
        packed = self.folder / "a.sdds.gz"
        packed.write_bytes(gzip.compress(path.read_bytes(), mtime=0))
        self.hold_written(beams.read(packed), beam, what="gzipped")
        # Neither the header nor a comment says the order of bytes: pages that make sense do.
        self.hold_written(made := beams.read(self.write(beam, "a.sdds", "binary", order=">")), beam, what="order not said")
        self.assertIn("big-endian", made.notes)

    def test_what_is_refused(self):
        beam = Beam()
        whole = self.write(beam, "a.sdds", "binary", order="<").read_bytes()
        for cut in (len(whole) - 3, len(whole) // 2):
            (self.folder / "b.sdds").write_bytes(whole[:cut])
            self.refused("b.sdds", beams.read, self.folder / "b.sdds")
        write_text(self.folder / "c.sdds", "SDDS1\n&include filename=\"x\", &end\n&data mode=ascii, &end\n")
        self.refused("include", beams.read, self.folder / "c.sdds")


@needs_program
class Astra(Case):
    FORMATS = {"astra"}

    def rows(self, beam, species, status):
        """The first row is absolute, all others are relative to it along z."""
        own = numpy.array([beam.x, beam.y, beam.zeta + 1.5, beam.px, beam.py, beam.pz, 1e9 * beam.t + 3.0,
                           numpy.full(beam.count, -1e-6), numpy.full(beam.count, species), status])
        own[[2, 5, 6], 1:] -= own[[2, 5, 6], :1]
        return own

    def test_species_states_and_forms(self):
        masses = {1: (ELECTRON, "electron"), 2: (ELECTRON, "positron"), 3: (PROTON, "proton")}
        for species, packed, name, form in itertools.product(masses, (False, True), ("run.0150.001", "b.ini"), ("%.15E", "%.17g")):
            mass, word = masses[species]
            beam = Beam(mass=mass, p0=1e9)
            status = numpy.where(beam.lost, -15, numpy.where(numpy.arange(beam.count) % 7 == 0, -1, 5))
            status[0] = 5
            lines = []
            for row in self.rows(beam, species, status).T:
                lines.append(" ".join(form % value for value in row[:8]) + f" {row[8]:.0f} {row[9]:.0f}")
            text = "\n".join(lines) + "\n"
            path = self.folder / (name + (".gz" if packed else ""))
            path.write_bytes(gzip.compress(text.encode(), mtime=0) if packed else text.encode())
            made = beams.read(path)
            what = f"{path.name} {word}"
            self.assertEqual(made.species, word)
            beam.hold(self, made.steps[0], "x y px py pz", what, ids=False, z=beam.zeta + 1.5, t=beam.t + 3e-9, lost=status < -6,
                      weight=numpy.full(beam.count, 1e-15))
            self.assertAlmostEqual(made.mass / mass, 1, 6)
            self.assertAlmostEqual(made.steps[0].time, beam.t[0] + 3e-9, delta=1e-15)


@needs_program
class TraceWin(Case):
    FORMATS = {"tracewin"}

    def test_dst(self):
        for mass, current, frequency in itertools.product((ELECTRON, PROTON), (0.1, 25.0), (175.0, 352.2)):
            beam = Beam(mass=mass, p0=3e8)
            energy = numpy.hypot(beam.p, mass) - mass
            rows = numpy.stack([100 * beam.x, beam.px / beam.pz, 100 * beam.y, beam.py / beam.pz,
                                2e6 * numpy.pi * frequency * beam.t, energy / 1e6], axis=1)
            path = self.folder / "part.dst"
            path.write_bytes(struct.pack("<2Bi2dB", 125, 100, beam.count, current, frequency, 0) +
                             rows.astype("<f8").tobytes() + struct.pack("<d", mass / 1e6))
            made = beams.read(path)
            velocity = C * beam.pz / numpy.hypot(beam.p, mass)
            charge = 1e-3 * current / (1e6 * frequency * beam.count)
            beam.hold(self, made.steps[0], "x y px py pz t", f"{mass} {current}", ids=False, z=-velocity * beam.t,
                      weight=numpy.full(beam.count, charge))
            whole = path.read_bytes()
            for odd in (whole[:-1], whole + b"\0"):
                path.write_bytes(odd)
                self.refused("part.dst", beams.read, path)


@needs_program
class ImpactT(Case):
    FORMATS = {"impactt"}

    def test_six_columns(self):
        for mass, first, packed, fmt in itertools.product((ELECTRON, PROTON), (False, True), (False, True), ("%.17g", "%.16E")):
            beam = Beam(mass=mass, p0=1e9)
            text = table(None, [beam.x, beam.px / mass, beam.y, beam.py / mass, beam.zeta, beam.pz / mass], " ", fmt)
            text = f"{beam.count}\n{text}" if first else text
            path = self.folder / ("fort.50.gz" if packed else "fort.50")
            path.write_bytes(gzip.compress(text.encode(), mtime=0) if packed else text.encode())
            made = beams.read(path, "--format", "impactt", "--mass", mass)
            beam.hold(self, made.steps[0], "x y px py pz", f"{mass} {first} {fmt}", ids=False, z=beam.zeta)


@needs_program
class ImpactZ(Case):
    FORMATS = {"impactz"}

    def test_columns_without_names(self):
        for (mass, charge), columns, packed, fmt in itertools.product(((ELECTRON, -1), (PROTON, 1)), (7, 8, 9), (False, True),
                                                                      ("%.17g", "%.16E")):
            beam = Beam(mass=mass, p0=1e9, charge=charge)
            frequency = 3.5e8
            turn = 2 * numpy.pi * frequency
            rows = [beam.x * turn / C, beam.px / mass, beam.y * turn / C, beam.py / mass, turn * beam.t, beam.e0 / mass - beam.gamma,
                    numpy.full(beam.count, charge / mass), charge * beam.weight * E, beam.id, numpy.zeros(beam.count)]
            text = table(None, rows[:columns], " ", fmt)
            path = self.folder / ("fort.101.gz" if packed else "fort.101")
            path.write_bytes(gzip.compress(text.encode(), mtime=0) if packed else text.encode())
            options = ("--format", "impactz", "--mass", mass, "--frequency", frequency, "--kinetic-energy", beam.e0 - mass)
            made = beams.read(path, *options)
            beam.hold(self, made.steps[0], "x y px py pz t", f"{mass} {columns} {fmt}", ids=columns > 8, z=beam.zeta,
                      **({"weight": beam.weight * E} if columns > 7 else {}))
            self.assertEqual(made.steps[0].iteration, 101)


@needs_program
class H5Part(Case):
    FORMATS = {"h5part"}

    def test_units_types_and_orders(self):
        lengths, momenta = {"m": 1.0, "mm": 1e-3}, {"eV/c": 1.0, "MeV/c": 1e6, "#beta#gamma": None}
        for (length, metre), (momentum, unit), kind, packed in itertools.product(lengths.items(), momenta.items(), ("<f8", ">f8"), (False, True)):
            beam = Beam(mass=PROTON, p0=1e9)
            unit = unit or beam.mass
            path = self.folder / "a.h5"
            with h5py.File(path, "w") as file:
                for axis in "xyz":
                    file.attrs[axis + "Unit"], file.attrs[f"p{axis}Unit"] = numpy.bytes_(length), numpy.bytes_(momentum)
                for number in (3, 12):
                    step = file.create_group(f"Step#{number}")
                    step.attrs["TIME"] = [number * 1e-9]
                    step.attrs["MASS"] = [beam.mass / 1e9]
                    form = {"chunks": (50,), "compression": "gzip"} if packed else {}
                    for name, values in (("x", beam.x / metre), ("y", beam.y / metre), ("z", beam.zeta / metre), ("px", beam.px / unit),
                                         ("py", beam.py / unit), ("pz", beam.pz / unit), ("q", numpy.full(beam.count, 1e-15))):
                        step.create_dataset(name, data=values.astype(kind), **form)
                    step["id"] = beam.id.astype("i8")
            made = beams.read(path, "--mass", beam.mass) if momentum != "#beta#gamma" else beams.read(path)
            self.assertEqual([step.iteration for step in made.steps], [3, 12])
            for step, number in zip(made.steps, (3, 12)):
                self.assertAlmostEqual(step.time, number * 1e-9)
                beam.hold(self, step, "x y px py pz", f"{length} {momentum} {kind}", z=beam.zeta, weight=numpy.full(beam.count, 1e-15))


@needs_program
class Genesis(Case):
    FORMATS = {"genesis4"}

    def test_slices(self):
        for kind, order, slices_ in itertools.product(("f8", "f4"), "<>", (1, 4)):
            beam = Beam(p0=3e8)
            cut = numpy.array_split(numpy.arange(beam.count), slices_)
            spacing, length, current = 4e-7, 1e-7, 120.0
            written = {"x": beam.x, "y": beam.y, "px": beam.px / beam.mass, "py": beam.py / beam.mass,
                       "theta": beam.zeta / 2e-5, "gamma": beam.gamma}
            with h5py.File(self.folder / "a.par.h5", "w") as file:
                for name, value in (("slicecount", slices_), ("slicespacing", spacing), ("slicelength", length),
                                    ("refposition", 0.0), ("beamletsize", 4), ("one4one", 0)):
                    file[name] = numpy.array([value], dtype="i4" if isinstance(value, int) else "f8")
                for number, rows in enumerate(cut):
                    group = file.create_group(f"slice{number + 1:06d}")
                    group["current"] = numpy.array([current], order + "f8")
                    for name, values in written.items():
                        group[name] = values[rows].astype(order + kind)
            made = beams.read(self.folder / "a.par.h5")
            stored = {name: values.astype(kind).astype(float) for name, values in written.items()}
            number = numpy.concatenate([numpy.full(len(rows), n) for n, rows in enumerate(cut)])
            share = numpy.concatenate([numpy.full(len(rows), current * spacing / C / len(rows)) for rows in cut])
            pz = ELECTRON * numpy.sqrt(stored["gamma"]**2 - 1 - stored["px"]**2 - stored["py"]**2)
            expected = {"x": stored["x"], "y": stored["y"], "px": ELECTRON * stored["px"], "py": ELECTRON * stored["py"], "pz": pz,
                        "z": number * spacing + stored["theta"] / (2 * numpy.pi) * length, "weight": share}
            beam.hold(self, made.steps[0], "", f"{kind} {order} {slices_}", ids=False, **expected)
