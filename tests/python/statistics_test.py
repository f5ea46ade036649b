# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistics of whole steps, as mote-prep finds them, against numpy in double precision and against what a
tracking code printed of the same particles; and of the openPMD runs of others, against numpy on what h5py reads."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

try:
    import h5py
except ImportError:
    h5py = None

PREP = pathlib.Path(os.environ["MOTE_BIN"]) / "mote-prep"
RUNS = pathlib.Path(__file__).resolve().parents[3] / "shared/data/particles"
SHARED = RUNS / "impactz_dtl_20k"
COORDINATES = ["x", "y", "z", "px", "py", "pz"]
MASS = 938.27208816e6
LIGHT, CHARGE = 299792458.0, 1.602176634e-19


def prepare(directory, inputs, *options):
    output = pathlib.Path(directory) / "out.mote"
    if "--axes" not in options:
        options += ("--axes", "x,px,y")
    done = subprocess.run([str(PREP), "particles", *map(str, inputs), "--out", str(output), "--quiet", *options],
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    manifest = json.loads((output / "manifest.json").read_text())["particles"]
    names = manifest["statisticNames"]
    values = [[float(v) for v in step["statistics"]] for step in manifest["steps"]]
    return manifest, [dict(zip(names, row)) for row in values]


def expected(rows, mass):
    """Rows by name, each finite, and weights: the definitions of docs/NUMBERS.md. Of numbers and their scale."""
    wide = {name: numpy.asarray(values, dtype=numpy.longdouble) for name, values in rows.items()}
    weight = wide.pop("weight")
    total = weight.sum()
    wide["p"] = numpy.sqrt(wide["px"] ** 2 + wide["py"] ** 2 + wide["pz"] ** 2)
    wide["energy"] = numpy.sqrt(wide["p"] ** 2 + numpy.longdouble(mass) ** 2) - numpy.longdouble(mass)
    wide["gamma"] = 1 + wide["energy"] / mass
    wide["xp"] = wide["px"] / wide["pz"]
    wide["yp"] = wide["py"] / wide["pz"]
    mean = {name: (weight * values).sum() / total for name, values in wide.items()}
    wide["delta"] = wide["p"] / mean["p"] - 1
    mean["delta"] = (weight * wide["delta"]).sum() / total
    centred = {name: values - mean[name] for name, values in wide.items()}

    def moment(*names):
        return (weight * numpy.prod([centred[name] for name in names], axis=0)).sum() / total

    sigma = {name: numpy.sqrt(moment(name, name)) for name in wide}
    out = {}
    for name in wide:
        scale = abs(mean[name]) + sigma[name]
        out["mean_" + name] = (mean[name], scale)
        out["sigma_" + name] = (sigma[name], sigma[name] + 1e-3 * abs(mean[name]) + 1e-3 * (name == "delta"))
        out["min_" + name] = (wide[name].min(), abs(wide[name]).max() + (name == "delta"))
        out["max_" + name] = (wide[name].max(), abs(wide[name]).max() + (name == "delta"))
    pairs = ["x", "px", "y", "py", "z", "pz", "energy"]
    for i, a in enumerate(pairs):
        for b in pairs[i + 1:]:
            out[f"cov_{a}__{b}"] = (moment(a, b), sigma[a] * sigma[b])
    for plane in "xyz":
        for name, momentum, scale in ((f"norm_emit_{plane}", "p" + plane, mass),
                                      (f"emit_{plane}", plane + "p" if plane != "z" else "delta", 1.0)):
            square = moment(plane, plane) * moment(momentum, momentum)
            emittance = numpy.sqrt(square - moment(plane, momentum) ** 2)
            # What the difference of products loses.
            loss = square / emittance ** 2
            out[name] = (emittance / scale, loss * emittance / scale)
            if scale != 1.0:
                continue
            out[f"twiss_beta_{plane}"] = (moment(plane, plane) / emittance, loss * moment(plane, plane) / emittance)
            out[f"twiss_alpha_{plane}"] = (-moment(plane, momentum) / emittance, loss ** 1.5)
        p = "p" + plane
        out[f"halo_h_{plane}"] = (moment(*[plane] * 4) / moment(plane, plane) ** 2 - 2, 4)
        out.update(percentiles(plane, centred, weight, mass, moment))
    return out


def percentiles(plane, centred, weight, mass, moment):
    q, p = centred[plane], centred["p" + plane]
    action = (moment("p" + plane, "p" + plane) * q * q - 2 * moment(plane, "p" + plane) * q * p
              + moment(plane, plane) * p * p)
    order = numpy.argsort(action)
    shares = numpy.floor(weight / weight.max() * 2.0 ** 31 + 0.5)[order].cumsum()
    out = {}
    for percent in (90, 95, 99):
        count = numpy.searchsorted(shares * 100, shares[-1] * percent) + 1
        some = order[:count]
        w = weight[some]
        qq, qp, pp = ((w * a).sum() / w.sum() for a in (q[some] ** 2, q[some] * p[some], p[some] ** 2))
        emittance = numpy.sqrt(qq * pp - qp * qp)
        out[f"emit{percent}_action_{plane}"] = (emittance / mass, qq * pp / emittance / mass)
    return out


class AgainstNumpy(unittest.TestCase):
    def check(self, statistics, wanted):
        for name, (value, scale) in wanted.items():
            self.assertLessEqual(abs(statistics[name] - float(value)), 1e-12 * float(abs(scale)), name)

    def generated(self, seed, count, broken):
        random = numpy.random.default_rng(seed)
        normal = random.normal(size=(6, count))
        rows = {"x": 1e-3 * normal[0] + 2e-3, "px": 2e5 * normal[1] + 3e5 * normal[0],
                "y": 2e-3 * normal[2] - 1e-3, "py": 1e5 * normal[3] - 2e5 * normal[2],
                "z": 0.01 * normal[4] + 10, "pz": 1e9 * (1 + 1e-3 * normal[5] + 1e-3 * normal[4])}
        rows["weight"] = numpy.exp(normal[0]) * 1e6 if seed % 2 else numpy.ones(count)
        if broken:
            for name in ("x", "py", "z", "weight"):
                rows[name][random.integers(0, count, 7)] = numpy.nan
            rows["weight"][random.integers(0, count, 7)] = -1.0
        return rows

    def test_generated_beams(self):
        for seed, count, broken in ((1, 50000, False), (2, 150001, False), (3, 300000, True), (4, 100, True)):
            with self.subTest(seed=seed), tempfile.TemporaryDirectory() as directory:
                rows = self.generated(seed, count, broken)
                table = pathlib.Path(directory) / "beam.npy"
                numpy.save(table, numpy.stack([rows[n] for n in COORDINATES + ["weight"]], axis=1))
                # The reader makes weights of charges, whose sign says nothing.
                rows["weight"] = abs(rows["weight"])
                good = numpy.all([numpy.isfinite(values) for values in rows.values()], axis=0)
                manifest, steps = prepare(directory, [table], "--mass", str(MASS))
                self.assertEqual(manifest["mass"], MASS)
                self.assertEqual(steps[0]["n_particle"], count)
                self.assertEqual(steps[0]["n_finite"], good.sum())
                self.check(steps[0], expected({n: v[good] for n, v in rows.items()}, MASS))
                self.same_for_any_memory_and_threads(directory, table, steps[0])

    def same_for_any_memory_and_threads(self, directory, table, first):
        for name, options in (("a", ["--threads", "1"]), ("b", ["--threads", "3", "--memory", "400M"])):
            other = pathlib.Path(directory) / name
            other.mkdir()
            _, again = prepare(other, [table], "--mass", str(MASS), *options)
            self.assertEqual(repr(again[0]), repr(first))


class OfChosenParticles(unittest.TestCase):
    def test_lost_particles(self):
        random = numpy.random.default_rng(7)
        count = 20000
        rows = {name: random.normal(size=count) for name in COORDINATES}
        rows["pz"] += 1e6
        lost = (random.random(count) < 0.3).astype(float)
        ids = random.permutation(count)
        with tempfile.TemporaryDirectory() as directory:
            table = pathlib.Path(directory) / "beam.npz"
            numpy.savez(table, lost=lost, id=ids, weight=numpy.full(count, 1e-15), **rows)
            for which, taken in (("without", lost == 0), ("with", lost >= 0), ("only", lost == 1)):
                with self.subTest(which=which):
                    folder = pathlib.Path(directory) / which
                    folder.mkdir()
                    manifest, steps = prepare(folder, [table], "--lost", which)
                    step = manifest["steps"][0]
                    self.assertEqual(int(step["particles"]), taken.sum())
                    self.assertEqual(int(step.get("lost", 0)), lost.sum() if which == "without" else 0)
                    self.assertEqual(manifest.get("lostParticles", "without"), which)
                    self.assertEqual(steps[0]["n_particle"], taken.sum())
                    self.assertEqual(steps[0]["n_lost"], lost.sum())
                    self.assertAlmostEqual(steps[0]["mean_x"], rows["x"][taken].mean(), delta=1e-13)
                    self.replot(folder, which, manifest, steps)

    def replot(self, folder, which, manifest, steps):
        """From its columns, when the source is not read: other axes, the same numbers."""
        again = folder / "again"
        again.mkdir()
        other, same = prepare(again, [folder / "out.mote"], "--axes", "z,py,pz")
        self.assertEqual(repr(same), repr(steps))
        self.assertEqual(other.get("lostParticles"), manifest.get("lostParticles"))
        self.assertEqual([axis["name"] for axis in other["axes"]], ["z", "py", "pz"])
        self.assertEqual(other["ids"], True)
        self.assertEqual(other["steps"][0]["particles"], manifest["steps"][0]["particles"])
        for one, two in zip(manifest["columns"], other["columns"]):
            self.assertEqual(one["name"], two["name"])
            width = one.get("max", 0) - one.get("min", 0)
            self.assertAlmostEqual(one.get("min", 0), two.get("min", 0), delta=1e-6 * width)
            self.assertAlmostEqual(one.get("max", 0), two.get("max", 0), delta=1e-6 * width)
        wrong = "with" if which != "with" else "only"
        refused = subprocess.run([str(PREP), "particles", str(folder / "out.mote"), "--axes", "z,py,pz", "--lost",
                                  wrong, "--out", str(folder / "no.mote")], capture_output=True, text=True)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("lost", refused.stderr)

    def test_a_dataset_without_columns_says_how_to_make_them(self):
        with tempfile.TemporaryDirectory() as directory:
            table = pathlib.Path(directory) / "beam.npy"
            numpy.save(table, numpy.random.default_rng(1).normal(size=(1000, 6)))
            prepare(directory, [table], "--columns", "none")
            refused = subprocess.run([str(PREP), "particles", f"{directory}/out.mote", "--axes", "z,py,pz", "--out",
                                      f"{directory}/no.mote"], capture_output=True, text=True)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn("columns", refused.stderr)
            self.assertIn("mote-prep particles", refused.stderr)


class Columns(unittest.TestCase):
    """The files of columns, read by their digest as any program could."""

    @staticmethod
    def arrays(dataset):
        digest = json.loads((dataset / "columns-000000.digest").read_text())
        data = (dataset / "columns-000000.h5").read_bytes()
        kinds = {"columns/id": numpy.uint64, "ids/point": numpy.uint32}
        found = {}
        for array in digest["arrays"]:
            name = array["name"].strip("/")
            shape = [int(n) for n in array["shape"]]
            found[name] = numpy.frombuffer(data, kinds.get(name, numpy.float32), numpy.prod(shape, dtype=int),
                                           int(array.get("offset", 0)))
        return found

    def test_hold_the_source_in_the_order_of_points(self):
        random = numpy.random.default_rng(5)
        count = 70000
        rows = {name: random.normal(size=count) for name in COORDINATES}
        rows["z"] = 100 + 1e-3 * rows["z"]
        rows["z"][random.integers(0, count, 50)] = numpy.nan  # not an axis: the points stay
        for ids in (None, random.permutation(count) * 1000 + 2 ** 40, random.integers(0, 500, count)):
            with self.subTest(ids=ids is not None), tempfile.TemporaryDirectory() as directory:
                table = pathlib.Path(directory) / "beam.npz"
                numpy.savez(table, **rows, **({} if ids is None else {"id": ids}))
                manifest, _ = prepare(directory, [table])
                self.assertEqual(manifest.get("ids", False), ids is not None)
                dataset = pathlib.Path(directory) / "out.mote"
                found = self.arrays(dataset)
                offsets = [float(v) for v in manifest["steps"][0]["columnOffset"]]
                self.hold(manifest, found, offsets, rows, ids)
                self.damage_is_found(dataset)

    def hold(self, manifest, found, offsets, rows, ids):
        # Which row a point is: x has no two equal values.
        x = numpy.float32(rows["x"] - offsets[[c["name"] for c in manifest["columns"]].index("x")])
        row = numpy.argsort(x, kind="stable")[numpy.argsort(numpy.argsort(found["columns/x"], kind="stable"))]
        sure = numpy.isin(x[row], numpy.unique(x)[numpy.unique(x, return_counts=True)[1] == 1])
        self.assertGreater(sure.sum(), 0.9 * len(x))
        for column, offset in zip(manifest["columns"], offsets):
            if column["name"] not in rows:
                continue
            wanted = numpy.float32(rows[column["name"]][row] - offset)
            numpy.testing.assert_array_equal(found["columns/" + column["name"]][sure], wanted[sure])
        if ids is None:
            self.assertNotIn("columns/id", found)
            return
        numpy.testing.assert_array_equal(found["columns/id"][sure], numpy.uint64(ids[row][sure]))
        numpy.testing.assert_array_equal(found["ids/point"], numpy.argsort(found["columns/id"], kind="stable"))

    def damage_is_found(self, dataset):
        for array in json.loads((dataset / "columns-000000.digest").read_text())["arrays"]:
            path = dataset / "columns-000000.h5"
            data = bytearray(path.read_bytes())
            at = int(array.get("offset", 0)) + 5
            data[at] ^= 1
            path.write_bytes(data)
            done = subprocess.run([str(PREP), "verify", str(dataset)], capture_output=True, text=True)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("columns-000000", done.stdout + done.stderr)
            data[at] ^= 1
            path.write_bytes(data)
        done = subprocess.run([str(PREP), "verify", str(dataset)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_are_the_same_bytes_for_little_memory(self):
        random = numpy.random.default_rng(6)
        with tempfile.TemporaryDirectory() as directory:
            table = pathlib.Path(directory) / "beam.npy"
            numpy.save(table, random.normal(size=(600000, 7)) ** 2)
            files = []
            for name, options in (("one", []), ("two", ["--memory", "170M", "--threads", "1"])):
                folder = pathlib.Path(directory) / name
                folder.mkdir()
                prepare(folder, [table], *options)
                files.append(json.loads((folder / "out.mote/manifest.json").read_text())["files"])
            self.assertEqual(files[0], files[1])


class AgainstImpactZ(unittest.TestCase):
    """What IMPACT-Z 2.7.1 writes of the run in fort.18 and fort.24 to fort.26, at the places of its dumps: gamma
    of the reference particle; of x mean, rms, alpha and normalised emittance; of the phase its rms [degrees], of
    the energy its rms [MeV], and their emittance [degree MeV]."""

    FREQUENCY = 324e6
    REST = 939.29432e6
    PRINTED = {
        101: (3.902247472327199e-06, 0.000686781208630058, -2.098529411451075, 2.1245086294924728e-07,
              8.261511979384922, 0.011121678166045201, 0.09112168521467384),
        102: (8.610477465771472e-06, 0.00157056272747716, -3.7014901277143, 2.1338380927944273e-07,
              7.947148300003724, 0.013929427376844501, 0.0924365308953001),
        103: (8.236354231777483e-06, 0.0015928988408179653, -4.284398169199605, 2.1667714395467947e-07,
              7.316618424089981, 0.019382978131116422, 0.0952511680668713),
        104: (1.5083829266782717e-05, 0.0026327654805977786, -3.8507453103985263, 2.2199700082218328e-07,
              6.402671164183013, 0.02548825917224679, 0.09846971560964796),
        105: (1.113646092934059e-05, 0.002168951245805118, -2.071511812762586, 2.33512410183527e-07,
              5.298600455441468, 0.03089619238584891, 0.10186344448651229),
        106: (1.7906728688689485e-05, 0.002915867208593656, -0.29837506570311123, 2.3454798862892837e-07,
              4.170216132306494, 0.03502771418254988, 0.10506828552314959),
        107: (1.1979131858290813e-05, 0.0021137092401855226, 1.6653332097017852, 2.4785401875403334e-07,
              3.241596339121596, 0.0377614088066412, 0.10877810580137545),
        108: (1.3278751322599779e-05, 0.0025723014901826405, 2.7545063200467244, 2.5078958015871904e-07,
              2.82867026875888, 0.03865828414012062, 0.10934705884148915),
        109: (6.948366080801727e-06, 0.0015989552853006154, 3.3908387499262567, 2.488685064771789e-07,
              3.1971982163735224, 0.038608346971223256, 0.1090575130334498),
        110: (4.657576806729348e-06, 0.0015959870773084755, 2.9378757861078966, 2.477037172805104e-07,
              4.063701818929477, 0.037681555304629404, 0.10865146147449058),
        111: (2.653586791539328e-06, 0.0013013942709450433, 4.393227724489209, 2.472828935120297e-07,
              4.60633672513179, 0.0387821253066451, 0.10869815726521884),
        112: (-2.066123835127522e-06, 0.0005483379246279897, 1.5247271262222115, 2.4587923632068737e-07,
              5.988036253258522, 0.04184010660718272, 0.10944331658564749),
        113: (-4.5074159352410835e-06, 0.00034040782022852316, 0.18167282678015384, 2.45535456764039e-07,
              6.738261605267439, 0.04356746232773451, 0.1104005245195987),
    }

    # Of x, with its output of percentiles: it finds the cut from a histogram, to a few of 20,000 particles.
    PERCENTILES = {
        101: (1.741801505692056e-07, 1.910418036832432e-07, 2.073475007362933e-07),
        102: (1.7455070569800759e-07, 1.9158482724577679e-07, 2.080943581246771e-07),
        103: (1.7604564184343142e-07, 1.9352954532692518e-07, 2.1091706549735269e-07),
        104: (1.78717288675124e-07, 1.9727634919598632e-07, 2.1547103669008066e-07),
        105: (1.851178835472129e-07, 2.0524404328155738e-07, 2.2576123306638473e-07),
        106: (1.840041141124159e-07, 2.0401834483606487e-07, 2.2596246221442645e-07),
        107: (1.9356468697061738e-07, 2.1490756952462341e-07, 2.3869459812194297e-07),
        108: (1.9530627186928473e-07, 2.1713549539469804e-07, 2.414635254496689e-07),
        109: (1.9438313071260431e-07, 2.16036899269374e-07, 2.3983618110595834e-07),
        110: (1.940790659754939e-07, 2.153107793095532e-07, 2.3881650262123904e-07),
        111: (1.9426577395978783e-07, 2.1521223712657972e-07, 2.3832165797344143e-07),
        112: (1.9378243291288527e-07, 2.1463305899655188e-07, 2.37269685246392e-07),
        113: (1.93613352357969e-07, 2.1431210832467523e-07, 2.36914074953621e-07),
    }

    def test_printed_digits(self):
        if not SHARED.is_dir():
            self.skipTest("the run of IMPACT-Z is not beside this tree")
        with tempfile.TemporaryDirectory() as directory:
            names = [SHARED / f"fort.{number}.txt.gz" for number in self.PRINTED]
            _, steps = prepare(directory, names, "--format", "impactz")
        for number, step in zip(self.PRINTED, steps):
            x, sigma, alpha, emittance, phase, energy, both = self.PRINTED[number]
            degrees = 360 * self.FREQUENCY
            area = numpy.sqrt(step["sigma_t"] ** 2 * step["sigma_energy"] ** 2 - step["cov_t__energy"] ** 2)
            found = {
                "mean_x": (step["mean_x"], x, sigma),
                "sigma_x": (step["sigma_x"], sigma, sigma),
                "alpha": (-step["cov_x__px"] / step["norm_emit_x"] / self.REST, alpha, abs(alpha) + 1),
                "norm_emit_x": (step["norm_emit_x"], emittance, emittance),
                "sigma_t": (step["sigma_t"] * degrees, phase, phase),
                "sigma_energy": (step["sigma_energy"] * 1e-6, energy, energy),
                "t and energy": (area * degrees * 1e-6, both, both * 10),
            }
            for percent, printed in zip((90, 95, 99), self.PERCENTILES[number]):
                self.assertLessEqual(abs(step[f"emit{percent}_action_x"] / printed - 1), 1e-3)
            for name, (value, printed, scale) in found.items():
                self.assertLessEqual(abs(value - printed), 1e-11 * scale, f"{name} of fort.{number}")


def number(item):
    """A record component in SI units: a dataset, or one value for all."""
    values = item[()] if isinstance(item, h5py.Dataset) else numpy.asarray(item.attrs["value"])
    return numpy.asarray(values, numpy.float64) * numpy.asarray(item.attrs["unitSI"], numpy.float64)


def component(species, record, axis, count):
    name = f"{record}/{axis}"
    values = number(species[name]) if name in species else 0.0
    if f"{record}Offset/{axis}" in species:
        values = values + number(species[f"{record}Offset/{axis}"])
    return numpy.broadcast_to(values, (count,)).astype(numpy.float64)


def rows(species, count):
    """The live particles of a step: m and eV/c of one real particle."""
    out = {axis: component(species, "position", axis, count) for axis in "xyz"}
    weight = next((number(species[name]) for name in ("weight", "weighting") if name in species), 1.0)
    out["weight"] = numpy.broadcast_to(weight, (count,)).astype(numpy.float64)
    whole = species["momentum"].attrs.get("macroWeighted", 0)
    for axis in "xyz":
        momentum = component(species, "momentum", axis, count) * LIGHT / CHARGE
        out["p" + axis] = momentum / out["weight"] if whole else momentum
    if "particleStatus" in species:
        alive = numpy.broadcast_to(number(species["particleStatus"]), (count,)) == 1
        out = {name: values[alive] for name, values in out.items()}
    return out


def lost(step, name):
    """What values far from 0 lost when they were rounded is no fault of what is made of their differences."""
    far = {one: 1 + 1e-3 * abs(step["mean_" + one]) / step["sigma_" + one] for one in ("x", "px", "y", "py", "z", "pz", "energy")
           if step["sigma_" + one] > 0}
    if name.startswith("cov_"):
        return numpy.prod([far.get(one, 1) for one in name[4:].split("__")])
    if "emit" in name or name.startswith(("twiss", "halo")):
        return far.get(name[-1], 1) * far.get("p" + name[-1], 1)
    return 1


@unittest.skipUnless(h5py and RUNS.is_dir(), "python3-h5py or the runs of others are missing")
class RunsOfOthers(unittest.TestCase):
    def held(self, name, places, axes="x,px,y", options=()):
        with tempfile.TemporaryDirectory() as folder:
            manifest, steps = prepare(folder, [RUNS / name], "--axes", axes, *options)
        self.assertEqual(len(steps), len(places))
        with h5py.File(RUNS / name) as file:
            for place, step in zip(places, steps):
                species = file[place]
                wanted = rows(species, species["momentum/x"].shape[0])
                self.assertEqual(step["n_particle"], len(wanted["x"]))
                numbers = expected(wanted, manifest["mass"])
                numbers = {name: value for name, value in numbers.items() if numpy.isfinite(value[0]) and value[1] > 0}
                numbers = {name: (value, scale * lost(step, name)) for name, (value, scale) in numbers.items()}
                self.assertGreater(len(numbers), 60)
                AgainstNumpy.check(self, step, numbers)

    def test_astra(self):
        self.held("astra_particles.h5", ["screen/0", "screen/1"])

    def test_bmad(self):
        self.held("bmad_particles.h5", ["data/00001/particles"])

    def test_picongpu(self):
        self.held("picongpu_lwfa_000550.h5", ["data/550/particles/e"])


if __name__ == "__main__":
    unittest.main()
