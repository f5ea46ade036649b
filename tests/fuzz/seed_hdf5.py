# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeds of the corpus hdf5: files of every reader of HDF5, as text (hdf5_text.h)."""

AXES = "xyz"


def lines(*parts):
    return "".join(part if part.endswith("\n") else part + "\n" for part in parts)


# ----------------------------------------------------------------------------------------------- openPMD


def root(base="/data/%T/", version="1.1.0", particles="particles/", kind="fixed"):
    return lines(f"text / openPMD {kind} {version}", f"text / basePath {kind} {base}", f"text / particlesPath {kind} {particles}")


def records(group, count=5, kind="f64", storage="plain", extra=""):
    text = ""
    for number, axis in enumerate(AXES):
        text += lines(f"data {group}/position/{axis} {kind} {count} {storage} {number} 0.5 -1",
                      f"numbers {group}/position/{axis} unitSI f64 - 1e-3",
                      f"data {group}/momentum/{axis} {kind} {count} {storage} 1e-22 2e-22")
    return text + lines(f"numbers {group}/momentum unitDimension f64 7 1 1 -1 0 0 0 0") + extra


def openpmd(group="/data/3/particles/electrons", **more):
    return root() + records(group, **more) + lines("numbers /data/3 time f64 - 2", "numbers /data/3 timeUnitSI f64 - 1e-9")


E = "/data/3/particles/electrons"
IMPACTX = lines(f"data {E}/position/x f64 4 plain 1e-3", f"data {E}/position/y f64 4 plain 1e-3", f"data {E}/position/t f64 4 plain 1e-4 0",
                f"data {E}/momentum/x f64 4 plain 1e-3", f"data {E}/momentum/y f64 4 plain 1e-3", f"data {E}/momentum/t f64 4 plain 1e-3")
REFERENCE = [f"numbers {E} gamma_ref f64 - 3", f"numbers {E} mass_ref f64 - 9.1e-31", f"numbers {E} t_ref f64 - 2"]


def without(text, *words):
    return "".join(line + "\n" for line in text.splitlines() if not any(word in line for word in words))


def openpmd_seeds():
    whole = openpmd()
    weights = lines(f"data {E}/weighting f64 5 plain 2 -3", f"numbers {E}/momentum macroWeighted u32 - 1")
    ids = lines(f"data {E}/id u64 5 plain 7 8 9 10 11", f"data {E}/particleStatus u8 5 plain 1 0")
    mass = lines(f"group {E}/mass", f"numbers {E}/mass value f64 - 1.8e-30", f"numbers {E}/mass shape u64 1 5")
    ok = {
        "plain": whole, "chunks": openpmd(storage="chunks,shuffle,deflate,fletcher"), "big": openpmd(kind="f32be"),
        "variable": root(kind="variable") + records(E), "unnamed": root() + records("/data/3/particles"),
        "direct": without(root(), "particlesPath") + records("/data/3/beam"), "version2": root(version="2.0.0") + records(E),
        "one": root(base="/run") + records("/run/particles/p"), "pattern": root(base="/run/step_%06T/state") + records("/run/step_000004/state/particles/p"),
        "weights": whole + weights, "power": whole + weights + lines(f"numbers {E}/momentum weightingPower f64 - 0.5"),
        "ids": whole + ids, "columns": openpmd(count="5x1"), "integers": openpmd(kind="i16"), "mass": whole + mass,
        "massweights": whole + mass + weights + lines(f"numbers {E}/mass macroWeighted u32 - 1"),
        "massdata": whole + lines(f"data {E}/mass f64 5 plain 1e-30 2e-30"), "charge": whole + lines(f"data {E}/weight f64 5 plain -1e-12"),
        "offset": whole + "".join(lines(f"group {E}/positionOffset/{a}", f"numbers {E}/positionOffset/{a} value f64 - 3") for a in AXES),
        "time": whole + lines(f"data {E}/time f64 5 plain 1e-9"),
        "timeoffset": without(whole, " time f64", "timeUnit") + lines(f"data {E}/time f64 5 plain 1e-9", f"data {E}/timeOffset f64 5 plain 2"),
        "total": without(whole, "momentum/z") + lines(f"data {E}/totalMomentum f64 5 plain 9e-22"),
        "type": whole + lines(f"text {E} speciesType fixed proton"), "typeunknown": whole + lines(f"text {E} speciesType variable kaon"),
        "typeiteration": whole + lines("text /data/3 speciesType fixed muon"), "steps": whole + records("/data/10/particles/electrons"),
        "masses": whole + lines(f"text {E} speciesType fixed proton") + records("/data/10/particles/electrons"),
        "empty": whole + records("/data/10/particles/electrons", count=0), "impactx": root() + IMPACTX + lines(*REFERENCE),
        "links": whole + lines(f"soft {E}/id {E}/position/x", f"hard {E}/weighting {E}/position/x", "soft /data/7 3", "soft /data/8 /data/3"),
        "constant": root() + "".join(lines(f"group {E}/{r}/{a}", f"numbers {E}/{r}/{a} value f64 - 1", f"numbers {E}/{r}/{a} shape u64 1 6")
                                     for r in ("position", "momentum") for a in AXES),
        "scalar": openpmd(count="-"), "null": openpmd(count="null"), "compact": openpmd(storage="compact"),
        "dangling": whole + lines("soft /data/9 /nowhere", f"soft {E}/mass /data/3/x/y"),
        "constantid": whole + lines(f"group {E}/id", f"numbers {E}/id value f64 - -4"), "recordunit": whole + lines(f"numbers {E}/momentum unitSI f64 - 2"),
    }
    for name in ok:
        yield f"ok-openpmd-{name}", "particles openpmd\n" + ok[name]
    second = whole + records("/data/3/particles/protons")
    yield "ok-openpmd-auto", "particles auto\n" + whole
    yield "ok-openpmd-twice", "particles auto - 0 twice\n" + whole
    yield "ok-openpmd-species", "particles openpmd protons\n" + second
    yield "ok-openpmd-some", "particles openpmd protons\n" + second + records("/data/7/particles/electrons") + records("/data/7/particles/muons")
    yield "ok-openpmd-unnamed-type", "particles openpmd muon\n" + root() + records("/data/3/particles") + lines("text /data/3/particles speciesType fixed muon")
    yield "bad-openpmd-unnamed", "particles openpmd muon\n" + root() + records("/data/3/particles") + lines("text /data/3/particles speciesType fixed proton")
    yield "bad-openpmd-unnamed-type", "particles openpmd muon\n" + root() + records("/data/3/particles")
    yield "bad-openpmd-species", "particles openpmd muons\n" + second
    yield "bad-openpmd-several", "particles openpmd\n" + second
    bad = {
        "version": root(version="3.0") + records(E), "iterations": root() + lines("group /data/x"), "base": root(base="/else/%T/") + records(E),
        "one": root(base="/else") + records(E), "none": root() + lines("group /data/3/particles"), "rows": whole + lines(f"data {E}/id u64 4 plain"),
        "dimension": whole.replace("unitDimension f64 7 1 1", "unitDimension f64 7 1 0"),
        "infinite": without(whole, "unitSI") + lines(f"numbers {E}/position/x unitSI f64 - inf"),
        "value": without(whole, "position/x ") + lines(f"group {E}/position/x"),
        "shape": without(whole, "position/x ") + lines(f"group {E}/position/x", f"numbers {E}/position/x value f64 - 1", f"numbers {E}/position/x shape f64 - 2.5"),
        "constants": ok["constant"].replace("u64 1 6", "f64 2 4194304 16"),
        "external": without(whole, "position/x ") + lines(f"external {E}/position/x"), "circle": whole + lines(f"soft {E}/id {E}/id"),
        "outside": openpmd(storage="external"),
        "unwritten": openpmd(storage="unwritten"), "hugechunks": openpmd(storage="chunks,unwritten", count=400000000), "nbit": openpmd(storage="chunks,nbit"),
        "text": openpmd(kind="text"), "compound": openpmd(kind="compound"), "opaque": openpmd(kind="opaque"), "table": openpmd(count="3x4"),
        "cut": whole + "cut 900", "macro": whole + lines(f"numbers {E}/momentum macroWeighted u32 - 1"),
        "massmacro": whole + mass + lines(f"numbers {E}/mass macroWeighted u32 - 1"), "textunit": without(whole, "unitSI") + lines(f"text {E}/position/x unitSI fixed m"),
        "timetext": without(whole, " time ") + lines("text /data/3 time fixed now"), "numbertype": whole + lines(f"numbers {E} speciesType f64 - 1"),
        "emptyunit": without(whole, "unitSI") + lines(f"numbers {E}/position/x unitSI f64 0"), "reference": root() + IMPACTX,
        "gamma": root() + IMPACTX + lines(f"numbers {E} gamma_ref f64 - 0.5"), "referencemass": root() + IMPACTX + lines(REFERENCE[0], f"numbers {E} mass_ref f64 - -1"),
        "timeattribute": root() + IMPACTX + lines(REFERENCE[0], f"text {E} t_ref fixed x"), "basenumber": "numbers / basePath f64 - 1\n" + records(E),
        "isdata": root() + lines("data /data f64 3 plain"), "species": root() + lines("data /data/3/particles f64 3 plain"),
    }
    # A record that cannot be read is left out, and a note says so.
    left_out = {"rows", "infinite", "value", "shape", "external", "circle", "textunit", "emptyunit", "basenumber"}
    for name in bad:
        yield f"{'ok' if name in left_out else 'bad'}-openpmd-{name}", "particles openpmd\n" + bad[name]


# ---------------------------------------------------------------------------- H5Part, Genesis 4, elegant


def h5part(number=0, count=4, names="x y z px py pz q id", more=""):
    return "".join(f"data /Step#{number}/{name} f64 {count} plain 1 2 -3\n" for name in names.split()) + more


def genesis(count=3, current=10, number=1):
    group = f"/slice{number:06d}"
    return lines("data /slicelength f64 1 plain 1e-6", "data /slicespacing f64 1 plain 2e-6", "data /beamletsize i32 1 plain 4") + "".join(
        f"data {group}/{name} f64 {count} plain 3\n" for name in ("x", "y", "px", "py", "gamma", "theta")) + f"data {group}/current f64 1 plain {current}\n"


def elegant(page=1, count=4, kind="f64"):
    return "".join(f"data /page{page}/columns/{name} {kind} {count} plain 1e-3 2e-3 1\n" for name in ("x", "xp", "y", "yp", "t", "p", "particleID"))


def other_seeds():
    units = "".join(f"text / {name}Unit fixed {unit}\n" for name, unit in
                    (("x", "mm"), ("y", "m"), ("z", "m"), ("px", "#beta#gamma"), ("py", "MeV/c"), ("pz", "eV/c"), ("q", "nC"), ("id", "1")))
    opal = h5part() + units + lines("numbers /Step#0 MASS f64 - 0.938", "numbers /Step#0 TIME f64 - 1e-9")
    two = genesis() + "".join(genesis(2, 20, 3).splitlines(True)[3:])
    columns = elegant() + "".join(f"text /page1/columns/{n} units fixed {u}\n" for n, u in
                                  (("x", "m"), ("xp", "mrad"), ("y", "m"), ("yp", "rad"), ("t", "s"), ("p", "m$be$nc")))
    parameters = lines("data /page1/parameters/Charge f64 1 plain 1e-9", "data /page1/parameters/Step i32 1 plain 1",
                       "data /page1/parameters/pCentral f64 0 plain", "data /page1/parameters/Name text 1 plain", "text /page1/parameters/Charge units fixed C")
    ok = {
        "h5part": ("h5part", h5part()), "h5part-auto": ("auto", h5part()), "h5part-units": ("h5part", opal),
        "h5part-steps": ("h5part", h5part() + h5part(2) + h5part(1, 0)), "h5part-time": ("h5part - 1e6 twice", h5part(names="x y z px py pz time weight")),
        "h5part-empty": ("h5part", h5part() + h5part(3, 2, "x")), "h5part-group": ("h5part", h5part(names="x px") + lines("group /Step#0/y")),
        "genesis": ("genesis4", genesis()), "genesis-auto": ("auto", genesis()), "genesis-slices": ("genesis4 - 1e6 twice", two),
        "genesis-one": ("genesis4", genesis() + "data /one4one i32 1 plain 1\n"), "genesis-dark": ("genesis4", genesis(current=0)),
        "genesis-empty": ("genesis4", genesis(0)), "genesis-gap": ("genesis4", genesis() + "group /slice000002\n"),
        "elegant": ("elegant", elegant()), "elegant-auto": ("auto", columns + parameters), "elegant-pages": ("elegant - 1e6 twice", columns + elegant(2) + parameters),
        "elegant-big": ("elegant", elegant(kind="f32be")), "elegant-text": ("elegant", elegant() + "data /page1/columns/name text 4 plain\n"),
    }
    bad = {
        "h5part-none": ("h5part", "group /Step\n"), "h5part-columns": ("h5part", "group /Step#0\n"), "h5part-rows": ("h5part", h5part() + "data /Step#0/t f64 3 plain\n"),
        "h5part-unit": ("h5part", h5part() + "text /Step#0 xUnit fixed furlong\n"), "h5part-mass": ("h5part", h5part() + "text / pxUnit fixed mc\n"),
        "h5part-dataset": ("h5part", "data /Step#0 f64 3 plain\n"), "h5part-species": ("h5part protons", h5part()),
        "h5part-table": ("h5part", h5part(count="3x2")), "genesis-length": ("genesis4", genesis().replace("1e-6", "-1")), "genesis-missing": ("genesis4", "group /a\n"),
        "genesis-rows": ("genesis4", genesis().replace("/px f64 3", "/px f64 2")), "genesis-current": ("genesis4", without(genesis(), "current")),
        "genesis-column": ("genesis4", without(genesis(), "/px")), "genesis-numbers": ("genesis4", genesis().replace("spacing f64 1", "spacing f64 2")),
        "elegant-none": ("elegant", "group /page1/columns\n"), "elegant-rows": ("elegant", elegant().replace("/y f64 4", "/y f64 3")),
        "elegant-page": ("elegant", elegant() + "group /page2\n"), "elegant-unit": ("elegant", elegant() + "text /page1/columns/x units fixed furlong\n"),
        "elegant-slope": ("elegant", elegant() + "text /page1/columns/xp units fixed furlong\n"), "elegant-unwritten": ("elegant", elegant().replace("plain", "unwritten")),
        "elegant-charge": ("elegant", elegant() + parameters.replace("units fixed C", "units fixed furlong")), "auto": ("auto", "group /a\n"),
        "auto-cut": ("auto", h5part() + "cut 3000\n"), "nothing": ("nothing", h5part()),
        "elegant-textx": ("elegant", elegant().replace("/x f64", "/x text")), "elegant-group": ("elegant", elegant() + "group /page1/columns/sub\n"),
    }
    for prefix, seeds in (("ok", ok), ("bad", bad)):
        for name, (head, text) in seeds.items():
            yield f"{prefix}-{name}", f"particles {head}\n{text}"


# ------------------------------------------------------------------------------------------------ meshes


def mesh(shape="4x3x2", labels="z|y|x", record="/data/5/fields/rho", component="", kind="f32", storage="plain", iteration=5):
    dimensions = len(labels.split("|"))
    return lines("text / openPMD fixed 1.1.0", "text / basePath fixed /data/%T/", "text / meshesPath fixed fields/",
                 f"data {record}{component} {kind} {shape} {storage} 1 2 3", f"text {record} axisLabels fixed {labels}",
                 f"numbers {record} gridSpacing f64 {dimensions} 1e-6", f"numbers {record} gridGlobalOffset f64 {dimensions} 0",
                 f"numbers {record}{component} position f64 {dimensions} 0.5", f"numbers /data/{iteration} time f64 - 1")


def mesh_seeds():
    rho = "/data/5/fields/rho"
    theta = mesh("3x4x6", "r|z", component="/t") + lines(f"text {rho} geometry fixed thetaMode")
    other = mesh(record="/data/7/fields/rho", iteration=7)
    ok = {
        "mesh": ("openpmd", mesh()), "mesh-auto": ("auto", mesh()), "mesh-field": ("openpmd rho", mesh()), "mesh-chunks": ("openpmd", mesh(storage="chunks,deflate")),
        "mesh-plane": ("openpmd", mesh("4x3", "y|x")), "mesh-component": ("openpmd E/x", mesh(record="/data/5/fields/E", component="/x")),
        "mesh-fortran": ("openpmd", mesh() + f"text {rho} dataOrder fixed F\n"), "mesh-grid": ("openpmd", mesh() + f"numbers {rho} gridUnitSI f64 - 2\n"),
        "mesh-grids": ("openpmd", mesh() + f"numbers {rho} gridUnitSI f64 3 2 3 4\n"), "mesh-steps": ("openpmd", mesh() + other),
        "mesh-iteration": ("openpmd 7:rho", mesh() + other), "mesh-unit": ("openpmd", mesh() + lines(
            f"numbers {rho} unitDimension f64 7 1 1 -3 -1 0 0 0", f"numbers {rho} unitSI f64 - 2", "numbers /data/5 timeUnitSI f64 - 1e-15")),
        "mesh-theta": ("openpmd", theta), "mesh-angle": ("openpmd rho/t@30", theta), "mesh-imag": ("openpmd", theta + f"text {rho} geometryParameters fixed m=2;imag=-\n"),
        "mesh-zr": ("openpmd", mesh("3x6x4", "z|r", component="/z") + lines(f"text {rho} geometry variable thetaMode")),
        "mesh-far": ("openpmd", theta.replace("gridGlobalOffset f64 2 0", "gridGlobalOffset f64 2 5e-6 0")),
        "mesh-constant": ("openpmd rho", mesh() + "group /data/5/fields/B\n"), "mesh-space": ("openpmd", mesh(labels="x|z", shape="3x5")),
    }
    for kind in ("i8", "u8", "i16", "u16be", "i32", "u32", "i64", "f64", "f32be"):
        ok["mesh-" + kind] = ("openpmd", mesh(kind=kind) + f"numbers {rho} unitSI f64 - 0.5\n")
    bad = {
        "mesh-none": ("openpmd", without(mesh(), "data ") + "group /data/5\n"), "mesh-unknown": ("openpmd phi", mesh()), "mesh-several": ("openpmd", mesh() + "group /data/5/fields/B/x\n"),
        "mesh-iteration": ("openpmd 9:rho", mesh() + other), "mesh-labels": ("openpmd", without(mesh(), "axisLabels")), "mesh-names": ("openpmd", mesh(labels="y|x")),
        "mesh-spacing": ("openpmd", mesh().replace("f64 3 1e-6", "f64 3 0")), "mesh-spacings": ("openpmd", mesh().replace("gridSpacing f64 3", "gridSpacing f64 2")),
        "mesh-nospacing": ("openpmd", without(mesh(), "gridSpacing")), "mesh-infinite": ("openpmd", mesh().replace("f64 3 1e-6", "f64 3 inf")),
        "mesh-axis": ("openpmd", mesh(labels="z|y|q")), "mesh-axes": ("openpmd", mesh(labels="z|y|y")), "mesh-geometry": ("openpmd", mesh() + f"text {rho} geometry fixed spherical\n"),
        "mesh-rank": ("openpmd", mesh("4", "x")), "mesh-four": ("openpmd", mesh("2x2x2x2", "w|z|y|x")), "mesh-even": ("openpmd", theta.replace("3x4x6", "2x4x6")),
        "mesh-thetarank": ("openpmd", theta.replace("3x4x6", "4x6")), "mesh-thetaaxis": ("openpmd", theta.replace("r|z", "x|z")), "mesh-unit": ("openpmd", mesh() + f"numbers {rho} unitSI f64 - nan\n"),
        "mesh-angle": ("openpmd rho@30", mesh()), "mesh-words": ("openpmd :rho", mesh()), "mesh-slash": ("openpmd rho/", mesh()), "mesh-degrees": ("openpmd rho@x", mesh()),
        "mesh-constant": ("openpmd B", mesh() + "group /data/5/fields/B\n"), "mesh-empty": ("openpmd", mesh("0x3x2")), "mesh-dataset": ("openpmd", mesh().replace("fields/\n", "fields/rho\n")),
        "mesh-huge": ("openpmd", mesh("70000x3x2", storage="chunks,unwritten")), "mesh-modes": ("openpmd", theta.replace("3x4x6 plain", "4001x900x900 chunks,unwritten")),
        "mesh-text": ("openpmd", mesh(kind="text")), "mesh-labelnumber": ("openpmd", without(mesh(), "axisLabels") + f"numbers {rho} axisLabels f64 3 1\n"),
        "mesh-seventeen": ("openpmd", without(mesh(), "axisLabels") + f"text {rho} axisLabels fixed {'|'.join('x' * 17)}\n"), "mesh-auto": ("auto", "group /a\n"),
        "mesh-groupless": ("openpmd", without(mesh(), "data ", "time") + "data /data/5 f64 3 plain\n"),
    }
    for prefix, seeds in (("ok", ok), ("bad", bad)):
        for name, (head, text) in seeds.items():
            yield f"{prefix}-{name}", f"volume {head}\n{text}"


def seeds():
    for make in (openpmd_seeds, other_seeds, mesh_seeds):
        for name, text in make():
            yield "hdf5", name, text
