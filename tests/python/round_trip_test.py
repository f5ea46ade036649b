# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in every format, prepared, exported and prepared again: the same species, charge, counts, status and moments."""
import json
import pathlib
import struct
import subprocess
import tempfile
import unittest

import numpy as np

from support import BIN, Case, needs_server, prepare  # isort: skip

try:
    import h5py
except ImportError:
    h5py = None

C, E, ELECTRON, PROTON = 299792458.0, 1.602176634e-19, 510998.95, 938272088.16
COUNT, LOST = 600, 40
CHARGE = 1e-9  # of all particles


def beam(random):
    """In m, s, eV/c and C, about 20 MeV; the last ones are lost."""
    rows = {name: random.normal(size=COUNT) * scale for name, scale in
            (("x", 1e-3), ("y", 2e-3), ("z", 1e-3), ("px", 1e4), ("py", 2e4), ("pz", 1e5))}
    rows["z"] += 3.0
    rows["pz"] += 2e7
    rows["t"] = rows["z"] / C
    rows["weight"] = random.uniform(0.5, 1.5, COUNT)
    rows["weight"] *= CHARGE / rows["weight"].sum()
    rows["live"] = np.arange(COUNT) < COUNT - LOST
    return rows


def as_csv(path, rows):
    with open(path, "w", encoding="utf-8") as file:
        file.write("x [mm],y [mm],z [m],px [MeV/c],py [MeV/c],pz [GeV/c],charge [nC],alive\n")
        for row in zip(rows["x"] * 1e3, rows["y"] * 1e3, rows["z"], rows["px"] / 1e6, rows["py"] / 1e6, rows["pz"] / 1e9,
                       rows["weight"] * 1e9, rows["live"].astype(int)):
            file.write(",".join(repr(float(value)) for value in row) + "\n")


def as_npz(path, rows):
    values = {name: rows[name] for name in ("x", "y", "z", "px", "py", "pz", "t")}
    np.savez(path, **values, **{"charge": rows["weight"]}, alive=rows["live"])


def as_h5part(path, rows):
    with h5py.File(path, "w") as file:
        step = file.create_group("Step#0")
        step.attrs["MASS"] = ELECTRON * 1e-9
        file.attrs.update({"qUnit": np.bytes_("nC"), "pxUnit": np.bytes_("#beta#gamma"), "pyUnit": np.bytes_("#beta#gamma"),
                           "pzUnit": np.bytes_("#beta#gamma")})
        for name in ("x", "y", "z", "px", "py", "pz"):
            step[name] = rows[name] / (ELECTRON if name[0] == "p" else 1)
        step["q"] = -rows["weight"] * 1e9


def as_astra(path, rows):
    table = np.array([rows["x"], rows["y"], rows["z"], rows["px"], rows["py"], rows["pz"], rows["t"] * 1e9, -rows["weight"] * 1e9]).T
    table[1:, [2, 5, 6]] -= table[0, [2, 5, 6]]
    with open(path, "w", encoding="utf-8") as file:
        for row, live in zip(table, rows["live"]):
            file.write(" ".join(f"{value:.17e}" for value in row) + f" 2 {5 if live else -15}\n")


def as_sdds(path, rows):
    fields = (("x", "m"), ("xp", ""), ("y", "m"), ("yp", ""), ("t", "s"), ("p", "m$be$nc"))
    p = np.sqrt(rows["px"]**2 + rows["py"]**2 + rows["pz"]**2) / ELECTRON
    columns = (rows["x"], rows["px"] / rows["pz"], rows["y"], rows["py"] / rows["pz"], rows["t"], p)
    with open(path, "w", encoding="utf-8") as file:
        file.write("SDDS1\n&parameter name=Charge, type=double, units=C, &end\n")
        for name, unit in fields:
            file.write(f"&column name={name}, type=double, units={unit}, &end\n" if unit else
                       f"&column name={name}, type=double, &end\n")
        file.write(f"&data mode=ascii, &end\n{CHARGE!r}\n{COUNT}\n")
        for row in zip(*columns):
            file.write(" ".join(repr(float(value)) for value in row) + "\n")


def as_dst(path, rows):
    energy = np.sqrt(rows["px"]**2 + rows["py"]**2 + rows["pz"]**2 + PROTON**2) - PROTON
    table = np.array([rows["x"] * 100, rows["px"] / rows["pz"], rows["y"] * 100, rows["py"] / rows["pz"], rows["z"] - 3.0, energy / 1e6]).T
    with open(path, "wb") as file:
        file.write(struct.pack("<bbiddb", 125, 100, COUNT, CHARGE * 100e6 * 1e3, 100.0, 0))
        file.write(table.astype("<f8").tobytes() + struct.pack("<d", PROTON / 1e6))


def as_genesis(path, rows):
    gamma = np.sqrt(1 + (rows["px"]**2 + rows["py"]**2 + rows["pz"]**2) / ELECTRON**2)
    with h5py.File(path, "w") as file:
        for name, value in (("slicelength", 1e-6), ("slicespacing", 1e-6), ("refposition", 0.0), ("beamletsize", 4), ("one4one", 0),
                            ("slicecount", 1)):
            file[name] = [value]
        group = file.create_group("slice000001")
        values = {"gamma": gamma, "theta": rows["z"] - 3.0, "x": rows["x"], "y": rows["y"], "px": rows["px"] / ELECTRON,
                  "py": rows["py"] / ELECTRON, "current": [CHARGE * C / 1e-6]}
        for name, value in values.items():
            group[name] = value


def as_impactt(path, rows):
    table = np.array([rows["x"], rows["px"] / ELECTRON, rows["y"], rows["py"] / ELECTRON, rows["z"], rows["pz"] / ELECTRON]).T
    np.savetxt(path, table, fmt="%.17e")


def as_opal(path, rows):
    table = np.array([rows["x"], rows["px"] / ELECTRON, rows["y"], rows["py"] / ELECTRON, rows["z"], rows["pz"] / ELECTRON]).T
    np.savetxt(path, table, fmt="%.17e", header=str(COUNT), comments="")


def as_pyorbit(path, rows):
    p0 = float(rows["pz"].mean())
    e0, energy = np.hypot(p0, PROTON), np.sqrt(rows["px"]**2 + rows["py"]**2 + rows["pz"]**2 + PROTON**2)
    table = np.array([rows["x"], rows["px"] / p0, rows["y"], rows["py"] / p0, rows["z"], (energy - e0) / 1e9, rows["weight"] / E]).T
    np.savetxt(path, table, fmt="%.17e", comments="% ", header="\n".join((
        "PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES macrosize", "BUNCH_ATTRIBUTE_DOUBLE charge   1", f"BUNCH_ATTRIBUTE_DOUBLE mass   {PROTON / 1e9!r}",
        f" SYNC_PART_MOMENTUM 0 0 {p0 / 1e9!r}  px, py, pz", "x[m] px[rad] y[m] py[rad] z[m]  (pz or dE [GeV])")))


# Name, what writes it, options, and what is known: the species, whether charges, whether it marks lost particles.
FORMATS = [
    ("run.csv", as_csv, [], "", True, True),
    ("run.npz", as_npz, [], "", True, True),
    ("run.h5", as_h5part, [], "electron", True, False),
    ("run.0300.001", as_astra, [], "positron", True, True),
    ("run.sdds", as_sdds, [], "", True, False),
    ("run.dst", as_dst, [], "", True, False),
    ("run.par.h5", as_genesis, [], "electron", True, False),
    ("run.dat", as_opal, ["--mass", str(ELECTRON)], "", False, False),
    ("bunch.dat", as_pyorbit, [], "proton", True, False),
    ("run.txt", as_impactt, ["--format", "impactt", "--mass", str(ELECTRON)], "", False, False),
]


@needs_server
@unittest.skipUnless(h5py, "python3-h5py is missing")
class RoundTrip(Case):
    def statistics(self, dataset):
        said = subprocess.run([str(BIN / "mote-prep"), "info", str(dataset), "--json"], check=True, capture_output=True)
        particles = json.loads(said.stdout)["particles"]
        step = particles["steps"][0]
        return particles, dict(zip(particles["statisticNames"], map(float, step["statistics"]))), int(step.get("lost", 0))

    def test_rows_say_their_units(self):
        """What mote-stats writes row by row is read back as the same beam: charges are charges."""
        rows = beam(np.random.default_rng(12))
        with tempfile.TemporaryDirectory() as directory:
            folder = pathlib.Path(directory)
            as_npz(folder / "run.npz", rows)
            prepare("particles", folder / "run.npz", "--axes", "x,px,y", "--out", folder / "one.mote")
            one, first, _ = self.statistics(folder / "one.mote")
            for ending in ("csv", "npy"):
                with self.subTest(ending):
                    subprocess.run([str(BIN / "mote-stats"), "data/one", "--spawn", f"data={folder}", "--export", str(folder / f"rows.{ending}"),
                                    "--quiet"], check=True, capture_output=True)
                    prepare("particles", folder / f"rows.{ending}", "--axes", "x,px,y", "--out", folder / f"{ending}.mote")
                    two, second, _ = self.statistics(folder / f"{ending}.mote")
                    self.assertEqual((two["weightUnit"], one["weightUnit"]), ("C", "C"))
                    self.assertFalse([note for note in two.get("notes", []) if "unit" in note])
                    for name in ("charge", "sigma_x", "mean_x", "sigma_px", "sigma_pz"):
                        np.testing.assert_allclose(second[name], first[name], rtol=1e-6, err_msg=name)

    def test_every_format(self):
        random = np.random.default_rng(11)
        for name, write, options, species, charges, marks in FORMATS:
            for lost in ("without", "with") if marks else ("without",):
                with self.subTest(name, lost=lost), tempfile.TemporaryDirectory() as directory:
                    folder = pathlib.Path(directory)
                    rows = beam(random)
                    write(folder / name, rows)
                    prepare("particles", folder / name, "--axes", "x,px,y", "--lost", lost, *options, "--out", folder / "one.mote")
                    prepare("export", folder / "one.mote", "--openpmd", folder / "out.h5")
                    prepare("particles", folder / "out.h5", "--axes", "x,px,y", "--lost", lost, "--out", folder / "two.mote")
                    (one, first, gone), (two, second, _) = (self.statistics(folder / f"{which}.mote") for which in ("one", "two"))
                    self.assertEqual(one.get("species", ""), species)
                    if species:
                        self.assertEqual(two["species"], species)
                        self.assertAlmostEqual(two["particleCharge"], one["particleCharge"], delta=1e-12 * E)
                    self.assertEqual(gone, LOST if marks and lost == "without" else 0)
                    live = rows["live"] if marks and lost == "without" else np.full(COUNT, True)
                    self.assertEqual(first["n_particle"], live.sum())
                    self.assertEqual(second["n_particle"], first["n_particle"])
                    if charges:
                        part = rows["weight"][live].sum() / CHARGE if write in (as_csv, as_npz, as_h5part, as_astra, as_pyorbit) else 1.0
                        self.assertAlmostEqual(first["charge"], CHARGE * part, delta=1e-12 * CHARGE)
                        self.assertAlmostEqual(second["charge"], first["charge"], delta=1e-12 * CHARGE)
                    self.assertAlmostEqual(float(two["mass"]) if "mass" in one else 0, float(one.get("mass", 0)), delta=1e-3)
                    for axis in ("x", "y", "px", "py", "pz"):
                        np.testing.assert_allclose(second[f"sigma_{axis}"], first[f"sigma_{axis}"], rtol=1e-6, err_msg=axis)
                        np.testing.assert_allclose(second[f"mean_{axis}"], first[f"mean_{axis}"], rtol=0,
                                                   atol=1e-6 * first[f"sigma_{axis}"], err_msg=axis)


if __name__ == "__main__":
    unittest.main()
