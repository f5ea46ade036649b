# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeds of the corpora files and pictures, and those of mesh in all that a PLY file may be stored as."""
import gzip
import struct

import seed_tables


def pack(files):
    """The files of an input, one after the other."""
    data = b""
    for name, content in files.items():
        content = content if isinstance(content, bytes) else content.encode()
        data += f"{name} {len(content)}\n".encode() + content
    return data


# ------------------------------------------------------------------------------------- several files

DECK = ("! a deck\n1 1 /\n6 1000 2 0 1\n32 32 64 1 0.02 0.02 0.1\n3 0 0 1\n1000\n0.5D-1\n-1.064629e-9\n7*0.0\n3*1.0 2*2.0 0.0 0.0\n0 0 0 /\n"
        "0.05 1.0d8 5.0D+8 -1.0 1000.0e6 0.0\n0.25 10 20 0 1.0 /\n0.0 0 101 -2 1 /\n0.5 10 20 0 1.0 /\n0.0 0 102 -2 /\n0 0 0 -99 /\n")
DECK_T = "1 1\n1e-12 100 1\n6 1000 1\n16 16 16 1 0.01 0.01 0.1\n2 0 0 1\n7*0.0\n7*0.0\n7*0.0\n0.1 1e5 511000 -1.0 1.3e9 0.0\n"
TRACK = "0.0 0.0 1.2 0 0 0\n0.25 1.5 1.3 0 0 0\n1.0 3.0 1.4 0 0 0\n"
ROW_Z = "1e-3 2e-3 1e-3 2e-3 1e-3 2e-3 -1.5e-7 1e-12 {}\n"  # of charge states of masses of 1e6 and 1000e6 eV
ROW_T = "1e-3 2e-3 1e-3 2e-3 1e-3 2e-3\n"
ROW_A = "0 0 {} 0 0 1e6 0 -1e-3 {} {}\n"


def astra(species=1, status=5):
    return ROW_A.format(1, species, status) + ROW_A.format(1e-3, species, status)


def tables():
    z = "".join(ROW_Z.format(i) for i in range(3))
    csv = "x [m],px [eV/c],y [m]\n1,2,3\n4,5,6\n"
    six = {name: seed_tables.npy([1.0, 2.0]) for name in ("x", "px", "y", "py", "z", "pz")}
    beam = seed_tables.npz(**six)
    ok = {
        "impactz-deck": ("auto fort.101", {"fort.101": z, "ImpactZ.in": DECK}), "impactz-track": ("auto fort.101,fort.102", {
            "fort.101": z, "fort.102": z, "ImpactZ.in": DECK, "fort.18": TRACK}), "impactt-deck": ("auto fort.40", {"fort.40": 3 * ROW_T, "ImpactT.in": DECK_T}),
        "impactz-energy": ("impactz fort.101 1e9 1e6 1e7", {"fort.101": z}), "impactz-frequency": ("auto a 1e9 1e6", {"a": z}), "impactt-auto": ("auto a 1e9", {"a": 2 * ROW_T}),
        "impactt": ("impactt a", {"a": 2 * ROW_T}), "impactz-broken": ("impactz a 1e9 1e6", {"a": z, "ImpactZ.in": DECK[:60]}), "impactz-counted": ("impactz a 1e9 1e6", {"a": "7\n" + z}),
        "impactz-outside": ("impactz fort.7", {"fort.7": z, "ImpactZ.in": DECK.replace("1000.0e6", "1e9"), "fort.18.txt": TRACK}), "impactz-gzip": ("auto fort.101", {
            "fort.101": z, "ImpactZ.in.gz": gzip.compress(DECK.encode(), mtime=0)}), "impactz-many": ("impactz a 1e9 1e6", {"a": 2000 * ROW_Z.format(1)}),
        "astra": ("auto run.0100.001,run.0050.001", {"run.0100.001": astra(), "run.0050.001": astra()}), "astra-proton": ("astra a.ini", {"a.ini": astra(3)}), "astra-own": ("astra a", {"a": astra(9)}),
        "astra-lost": ("astra a.0x.001", {"a.0x.001": astra(status=-15)}), "csv-series": ("csv run_%T.csv", {f"run_{i}.csv": csv for i in (1, 10, 2)}), "csv-two": ("auto b2.csv,b1.csv", {"b1.csv": csv, "b2.csv": csv}),
        "npz-mass": ("npz a.npz", {"a.npz": seed_tables.npz(**six, mass=seed_tables.npy([5e5], shape="()"))}), "npz-masses": ("npz a.npz,b.npz", {
            "a.npz": seed_tables.npz(**six, mass=seed_tables.npy([5e5], shape="(1,)")), "b.npz": beam}), "npz-order": ("auto a2.npz,a1.npz", {"a2.npz": beam, "a1.npz": beam}),
        "npz-steps": ("npz a.npz,b.npz", {n: seed_tables.npz(x=seed_tables.npy(range(4), shape=(2, 2)), iteration=seed_tables.npy([i, 1], "<i8")) for i, n in enumerate(("a.npz", "b.npz"))}),
        "sdds": ("sdds a.sdds,b.sdds", {n: seed_tables.text(more="&parameter name=Charge, type=double, units=nC &end\n", values="1\n") for n in ("a.sdds", "b.sdds")}), "csv-numbers": ("csv a", {"a": "# x y z\n1 2 3\n"}),
        "csv-quoted": ("csv a", {"a": '"x";"y [mm]";"note"\n1;2;"a ; b"\n3;4;\n'}), "csv-huge": ("csv a", {"a": "x,y,id\n1e999,-1e-999,18446744073709551615\n1d3,.5,7\n"}), "csv-many": ("csv a", {"a": "x,y\n" + 3000 * "1,2\n"}),
        "csv-id": ("csv a", {"a": "x,id\n1,2.0\n3,1e3\n"}), "tracewin": ("tracewin a.dst,b.dst", {}),
    }
    orbit = ("% PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES ParticleIdNumber macrosize\n% BUNCH_ATTRIBUTE_DOUBLE charge   1\n% BUNCH_ATTRIBUTE_DOUBLE mass   0.938272\n"
             "%  SYNC_PART_MOMENTUM 0 0 1.696  px, py, pz\n%  SYNC_PART_TIME 1e-8  time in [sec]\n% x[m] px[rad] y[m] py[rad] z[m]  (pz or dE [GeV])\n1e-3 1e-4 2e-3 2e-4 0.1 1e-3 7 1e5\n0 0 0 0 0 0 8 1e5\n")
    ok |= {
        "pyorbit": ("auto b2.dat,b1.dat", {"b1.dat": orbit, "b2.dat": orbit}), "pyorbit-energy": ("pyorbit a", {"a": orbit.replace("SYNC_PART_MOMENTUM 0 0 1.696", "info only: energy of the synchronous particle [GeV] = 1")}),
        "pyorbit-six": ("pyorbit a", {"a": orbit.replace(" 7 1e5", "").replace(" 8 1e5", "")}), "opal": ("auto a", {"a": "2\n" + 2 * ROW_T}), "opal-named": ("auto a", {"a": "2\nx px y py t pz\n" + 2 * ROW_T}),
        "opal-dump": ("auto a", {"a": "# x [m] px [betax gamma] y [m] py [betay gamma] t [s] pz [betaz gamma] Bin Number\n" + 2 * ROW_T.replace("\n", " 1\n")}),
    }
    dst = b"\x7d\x64" + struct.pack("<idd", 1, 1.0, 352.2) + b"\0" + struct.pack("<6d", 1, 1e-3, 0.2, 2e-3, 0.0, 3.0)
    ok["tracewin"] = (ok["tracewin"][0], {n: dst + struct.pack("<d", 938.272) for n in ("a.dst", "b.dst")})
    bad = {
        "impactz-nothing": ("impactz a", {"a": z}), "impactz-mass": ("impactz a 1e9", {"a": z}), "impactz-deck": ("impactz a", {"a": z, "ImpactZ.in": DECK[:60]}), "impactz-energy": ("impactz a 1e9 1e6 -5", {"a": z}),
        "impactz-reference": ("impactz a", {"a": z, "ImpactZ.in": DECK.replace("5.0D+8", "0")}), "impactz-states": ("impactz a", {"a": z, "ImpactZ.in": DECK.replace("3 0 0 1\n", "3 0 0 0\n")}),
        "impactz-track": ("auto a", {"a": z, "ImpactZ.in": DECK, "fort.18": "1 2 0.5\n"}), "impactz-trackless": ("auto a", {"a": z, "ImpactZ.in": DECK, "fort.18": "\n"}), "table": ("auto a", {"a": "1 2 3\n4 5 6\n"}),
        "table-ten": ("auto a", {"a": 2 * "1 2 3 4 5 6 7 8 9.5 10\n"}), "table-nine": ("auto a", {"a": z}), "both": ("auto a", {"a": z, "ImpactZ.in": DECK, "ImpactT.in": DECK_T}),
        "astra-species": ("astra a,b", {"a": astra(), "b": astra(3)}), "astra-kind": ("astra a", {"a": astra(0.5)}), "formats": ("auto a,b", {"a": "x,y\n1,2\n", "b": beam}), "folder": ("auto .", {"a": "1"}),
        "adios": ("auto .", {"md.idx": "", "data.0": ""}), "adios5": ("auto .", {"md.idx": "", "mmd.0": ""}), "adios-file": ("auto a.bp", {"a.bp": "ADIOS-BP v4"}), "adios-name": ("auto b.bp", {"b.bp": "1 2 3\n"}), "series": ("csv run_%T.csv", {"a": csv}),
        "missing": ("auto a", {}), "none": ("auto", {}), "npz-mass": ("npz a", {"a": seed_tables.npz(**six, mass=seed_tables.npy([-1.0], shape="()"))}), "npz-unit": ("csv a", {"a": "x,px [mc]\n1,2\n"}), "empty": ("auto a", {"a": ""}),
        "csv-nothing": ("csv a", {"a": ""}), "csv-comments": ("csv a", {"a": "# a\n# b\n"}), "csv-longnumber": ("csv a", {"a": "x,y\n1" + 400 * "0" + "e999,2\n"}), "tracewin-masses": ("tracewin a,b", {
            "a": dst + struct.pack("<d", 938.272), "b": dst + struct.pack("<d", 0.511)}), "tracewin-gzip": ("tracewin a", {"a": gzip.compress(dst, mtime=0)}), "tracewin-magic": ("tracewin a", {"a": b"\x7d\x65" + dst[2:]}),
        "gzip-damaged": ("csv a", {"a": gzip.compress(csv.encode(), mtime=0)[:14] + b"\xff\xff\xff\xff" + gzip.compress(csv.encode(), mtime=0)[18:]}), "sdds-masses": ("sdds a,b", {
            "a": seed_tables.text(), "b": seed_tables.text(names=("x", "y", "z"), rows="1 2 3\n", count="1\n")}),
    }
    bad |= {"pyorbit-momentum": ("auto a", {"a": orbit.replace("SYNC_PART_MOMENTUM", "SYNC_PART_X")}), "pyorbit-mass": ("pyorbit a", {"a": orbit.replace(" mass ", " ssam ")}), "pyorbit-row": ("pyorbit a", {"a": orbit + "1 2 3\n"}),
            "opal-count": ("auto a", {"a": "3\n" + 2 * ROW_T}), "opal-volts": ("auto a", {"a": "1\n0 1e3 0 1e3 0 1e9\n"}), "opal-word": ("opal a", {"a": "1\n0 1 0 1 0 x\n"}), "opal-none": ("opal a", {"a": "1 2 3 4 5 6\n"})}
    return ok, bad


NRRD = "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nencoding: raw\nendian: little\nspacings: 1 1 1\ndata file: {}\n\n"
MHD = "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementType = MET_SHORT\nElementDataFile = {}\n"


def volumes():
    data = bytes(range(24))
    ok = {
        "nrrd": ("auto v.nhdr", {"v.nhdr": NRRD.format("v.raw"), "v.raw": data}), "nrrd-list": ("auto v.nhdr", {"v.nhdr": NRRD.format("LIST 2\na\nb\n")[:-2], "a": data[:12], "b": data[12:]}),
        "nrrd-pattern": ("auto v.nhdr", {"v.nhdr": NRRD.format("s%d.raw 1 2 1 2"), "s1.raw": data[:12], "s2.raw": data[12:]}), "nrrd-gzip": ("nrrd v.nhdr", {
            "v.nhdr": NRRD.format("v.gz").replace("raw\nendian", "gzip\nendian"), "v.gz": gzip.compress(data, mtime=0)}), "metaimage": ("auto v.mhd", {"v.mhd": MHD.format("v.raw"), "v.raw": data}),
        "metaimage-list": ("auto v.mhd", {"v.mhd": MHD.format("LIST\na\nb"), "a": data[:12], "b": data[12:]}), "metaimage-pattern": ("auto v.mhd", {"v.mhd": MHD.format("s%d.raw 1 2 1"), "s1.raw": data[:12], "s2.raw": data[12:]}),
    }
    bad = {
        "nrrd": ("auto v.nhdr", {"v.nhdr": NRRD.format("v.raw")}), "nrrd-short": ("auto v.nhdr", {"v.nhdr": NRRD.format("v.raw"), "v.raw": data[:9]}), "nrrd-outside": ("auto v.nhdr", {"v.nhdr": NRRD.format("../v.raw")}),
        "nrrd-root": ("auto v.nhdr", {"v.nhdr": NRRD.format("/etc/passwd")}), "metaimage": ("auto v.mhd", {"v.mhd": MHD.format("v.raw"), "v.raw": data[:9]}), "metaimage-outside": ("auto v.mhd", {"v.mhd": MHD.format("../../v.raw")}),
        "metaimage-listcut": ("auto v.mhd", {"v.mhd": MHD.format("LIST\na"), "a": data[:12]}), "vti": ("vti v", {"v": "<VTKFile"}), "volume-missing": ("auto v", {}), "volume-format": ("jpeg v", {"v": "x"}),
    }
    return ok, bad


# ------------------------------------------------------------------------------------------- pictures

def pictures():
    ok = {f"tif-{kind}": ("auto .", [f"s{i}.tif 3 2 1 {kind}" for i in (1, 2)]) for kind in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float", "double", "half")}
    ok |= {
        "png": ("auto .", ["s1.png 3 2 1 uint8", "s10.png 3 2 1 uint8", "s2.png 3 2 1 uint8"][:2] + ["note.txt hello"]), "png-colour": ("pictures .", [f"s{i}.png 3 2 3 uint8" for i in (1, 2)]),
        "png-alpha": ("auto s*.png", [f"s{i}.png 3 2 4 uint16 alpha" for i in (1, 2, 3)]), "tif-pages": ("auto a.tif", ["a.tif 3 2 1 uint16 pages=4"]), "tif-tiled": ("auto .", [f"s{i}.tif 40 20 1 uint8 tiled" for i in (1, 2)]),
        "tif-bits": ("auto .", [f"s{i}.tif 30 20 1 uint16 bits=12" for i in (1, 2)]), "tif-names": ("auto ?.tif", ["a.tif 3 2 1 uint8", "b.tif 3 2 1 uint8"]), "tif-steps": ("auto .", [f"s{i:03d}.tif 3 2 1 float" for i in (4, 6, 8)]),
        "png-tall": ("auto .", [f"s{i}b.png 1 4096 1 uint8" for i in (9, 10)]), "png-bit": ("auto .", [f"s{i}.png 9 2 1 uint8 bits=1" for i in (1, 2)]), "mixed": ("auto .", ["a1.png 3 2 1 uint8", "b1.tif 3 2 1 uint8"]),
    }
    bad = {
        "single": ("auto a.png", ["a.png 3 2 1 uint8"]), "none": ("auto .", ["a.txt x"]), "pattern": ("auto x*.png", ["a.png 3 2 1 uint8"]), "missing": ("auto .", [f"s{i}.png 3 2 1 uint8" for i in (1, 2, 4)]),
        "sizes": ("auto .", ["s1.png 3 2 1 uint8", "s2.png 2 3 1 uint8"]), "types": ("auto .", ["s1.png 3 2 1 uint8", "s2.png 3 2 1 uint16"]), "channels": ("auto .", ["s1.tif 3 2 1 uint8", "s2.tif 3 2 2 uint8"]),
        "cut": ("auto .", ["s1.png 30 20 1 uint8", "s2.png 30 20 1 uint8 cut=40"]), "cut-tif": ("auto .", ["s1.tif 30 20 1 uint8", "s2.tif 30 20 1 uint8 cut=400"]), "cut-first": ("auto .", ["s1.png 3 2 1 uint8 cut=60", "s2.png 3 2 1 uint8"]),
        "empty": ("pictures .", ["s1.png 3 2 1 uint8 cut=9999", "s2.png 3 2 1 uint8"]), "text": ("pictures a", ["a hello"]), "texts": ("auto a?", ["a1 hello", "a2 hello"]),
        "two": ("auto .", [f"s{i}.tif 3 2 2 float" for i in (1, 2)]), "pages": ("auto a.tif", ["a.tif 30 20 1 uint8 pages=3 cut=700"]), "nothing": ("auto nothing", ["a.png 1 1 1 uint8"]),
    }
    for prefix, some in (("ok-", ok), ("bad-", bad)):
        for name, (head, each) in some.items():
            yield "pictures", prefix + name, head + "\n" + "".join(line + "\n" for line in each)


# ------------------------------------------------------------------------------------------------ PLY

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d", "int8": "b", "uint16": "H", "float64": "d"}


def ply(kind="float", order="<", index="int", count="uchar", form=None, faces=FACES, name="vertex_indices", element="face", more="", extra=()):
    """With a property and a list beside what is read, so that both are passed over."""
    words = form or ("binary_little_endian" if order == "<" else "binary_big_endian")
    text = (f"ply\nformat {words} 1.0\ncomment a\nobj_info b\n{more}element vertex 4\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\nproperty {kind} w\n"
            f"element {element} {len(faces)}\nproperty list {count} {index} {name}\nproperty list {count} {kind} weights\nelement edge 1\nproperty int a\nend_header\n")
    if words == "ascii":
        return text + "".join(f"{x} {y} {z} 7\n" for x, y, z in CORNERS) + "".join(f"{len(f)} {' '.join(map(str, f))} 1 5\n" for f in faces) + "3\n"
    data = text.encode() + b"".join(struct.pack(f"{order}4{TYPES[kind]}", *corner, 7) for corner in CORNERS)
    for face in faces:
        data += struct.pack(f"{order}{TYPES[count]}{len(face)}{TYPES[index]}{TYPES[count]}{TYPES[kind]}", len(face), *face, 1, 5)
    return data + struct.pack(order + "i", 3)


def meshes():
    ok = {f"{kind}-{order == '<' and 'little' or 'big'}": ply(kind, order) for kind in TYPES for order in "<>"}
    ok |= {f"index-{kind}": ply(index=kind) for kind in TYPES if kind not in ("float", "double", "float64")} | {f"count-{kind}": ply(count=kind) for kind in ("char", "short", "uint")}
    ok |= {"ascii": ply(form="ascii"), "name": ply(name="vertex_index"), "strips": ply(faces=[(0, 1, 2, 3, -1, 1, 2, 3)], element="tristrips"), "strips-text": ply(faces=[(0, 1, 2, 3, -1, 1, 2, 3)], element="tristrips", form="ascii"),
           "quads": ply(faces=[(0, 1, 2, 3)]), "lines": ply(faces=[(0, 1), (0, 1, 2)]), "crlf": ply(form="ascii").replace("\n", "\r\n")}
    text = ply(form="ascii")
    bad = {
        "format": ply(form="xml 1.0").__class__() if False else text.replace("ascii", "xml"), "header": text[:120], "listtype": text.replace("list uchar", "list float"), "before": text.replace("element vertex", "element vertices"),
        "fraction": ply(index="float"), "cloud": ply(element="cloud"), "negative": ply(faces=[(0, 1, -5)]), "listlong": ply(count="uint").replace(struct.pack("<I3i", 3, *FACES[0]), struct.pack("<I3i", 1 << 31, *FACES[0])),
        "cut": ply()[:-30], "textcut": text[:-20], "textlist": text.replace("3 0 2 1", "-3 0 2 1"), "no-x": text.replace(" x\n", " u\n"), "property": text.replace("property int a", "property"), "element": text.replace("element edge 1", "element edge"),
        "word": text.replace("comment a", "commend a"), "magic": text.replace("ply\n", "plx\n", 1), "nolist": text.replace("property list uchar int vertex_indices\n", ""),
    }
    spoilt = "v 0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e30 0 0\nv 9 9 9\nv 1 1e-5 0\nf 1 3 4\nf 2 3 4\nf 1 2 3\nf 1 3 5\nf 1 3 7\n"
    for prefix, some in (("ok-ply-", ok), ("bad-ply-", bad)):
        for name, data in some.items():
            yield "mesh", prefix + name, b"ply\n" + (data if isinstance(data, bytes) else data.encode())
    yield "mesh", "ok-auto-spoilt", "auto\n" + spoilt
    yield "mesh", "ok-auto-gzip-obj", b"auto\n" + gzip.compress(spoilt.encode(), mtime=0)
    yield "mesh", "ok-auto-ply-big", b"auto\n" + ply("double", ">")
    yield "mesh", "bad-auto-flat", "auto\nv 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"
    yield "mesh", "bad-auto-faceless", "auto\nv 0 0 0\nv 1 0 0\nv 2 0 0\n"
    yield "mesh", "bad-auto-gzip-bomb", b"auto\n" + gzip.compress(b"v 0 0 0\n" * (1 << 18), mtime=0)
    yield "mesh", "bad-off-plane", "off\nOFF4\n1 0 0\n0 0 0 0\n"
    yield "mesh", "bad-off-dimension", "off\nnOFF\n2\n1 0 0\n0 0\n"
    yield "mesh", "bad-stl-facet", "stl\nsolid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n"
    yield "mesh", "bad-stl-short", "stl\nshort"


def seeds():
    yield from meshes()
    yield from pictures()
    for what, (ok, bad) in (("particles", tables()), ("volume", volumes())):
        for prefix, some in (("ok-", ok), ("bad-", bad)):
            for name, (head, each) in some.items():
                yield "files", f"{prefix}{name}", f"{what} {head}\n".encode() + pack(each)
