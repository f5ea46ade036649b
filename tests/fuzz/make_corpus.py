#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the seeds of the corpora, but those of table and volume that are written by hand.

    make_corpus.py [--build build/release]

The datasets are made by mote-prep of data that stand here. What a fuzzer found is put beside the seeds by hand and is
not touched. The files are committed: this is run when a format changes.
"""
import argparse
import gzip
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"
sys.path.insert(0, str(ROOT / "client" / "python"))

from mote.messages import new  # noqa: E402

import seed_dicom  # noqa: E402
import seed_files  # noqa: E402
import seed_hdf5  # noqa: E402
import seed_tables  # noqa: E402
import seed_volumes  # noqa: E402

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def put(corpus, name, data):
    folder = CORPUS / corpus
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())


# ------------------------------------------------------------------------------------------------- meshes


def obj(indices="{} {} {}"):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
        "f " + indices.format(*(i + 1 for i in face)) + "\n" for face in FACES)


def off(head="OFF"):
    return f"{head}\n4 4 6\n" + "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
        f"3 {a} {b} {c}\n" for a, b, c in FACES)


def ply_text(faces="".join(f"3 {a} {b} {c}\n" for a, b, c in FACES), count=4, head="ascii"):
    return (f"ply\nformat {head} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {count}\nproperty list uchar int vertex_indices\nend_header\n" +
            "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + faces)


def ply_binary(order="<", count=4):
    name = "little" if order == "<" else "big"
    head = ply_text(faces="", count=count, head=f"binary_{name}_endian").split("end_header\n")[0] + "end_header\n"
    body = b"".join(struct.pack(order + "3f", *corner) for corner in CORNERS)
    return head.encode() + body + b"".join(struct.pack(order + "B3i", 3, *face) for face in FACES)


def stl_text():
    text = "solid x\n"
    for face in FACES:
        text += "facet normal 0 0 0\nouter loop\n"
        text += "".join("vertex {} {} {}\n".format(*CORNERS[i]) for i in face) + "endloop\nendfacet\n"
    return text + "endsolid\n"


def stl_binary(count=4):
    data = b" " * 80 + struct.pack("<I", count)
    for face in FACES:
        data += struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *CORNERS[i]) for i in face) + b"\0\0"
    return data


def make_meshes():
    ok = {"obj": obj(), "obj-negative": "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "f -4 -3 -2 -1\n",
          "obj-parts": "g a\n" + obj("{0}/1/1 {1}//2 {2}") + "usemtl b\nf 1 2 \\\n3\n", "off": off(), "off-colour": off("COFF"),
          "ply": ply_text(), "stl": stl_text()}
    for name, text in ok.items():
        put("mesh", "ok-" + name, name.split("-")[0] + "\n" + text)
    put("mesh", "ok-ply-little", b"ply\n" + ply_binary())
    put("mesh", "ok-ply-big", b"ply\n" + ply_binary(">"))
    put("mesh", "ok-stl-binary", b"stl\n" + stl_binary())
    put("mesh", "ok-auto-obj", "auto\n" + obj())
    put("mesh", "ok-auto-gzip", b"auto\n" + gzip.compress(ply_text().encode(), mtime=0))
    bad = {"obj-index": obj().replace("f 1", "f 9"), "obj-zero": obj().replace("f 1", "f 0"),
           "obj-number": obj().replace("v 1 0 0", "v 1 x 0"), "obj-huge": obj() + "f 99999999999999999999 1 2\n",
           "off-cut": off()[:40], "off-counts": off().replace("4 4 6", "4 4000000000 6"), "off-index": off().replace("3 0", "3 7"),
           "ply-cut": ply_text()[:150], "ply-count": ply_text().replace("vertex 4", "vertex 4000000000"),
           "ply-type": ply_text().replace("float x", "quad x"), "ply-index": ply_text(faces="3 0 1 9\n", count=1),
           "stl-number": stl_text().replace("vertex 1 0 0", "vertex 1 x 0"), "auto-noise": "\x01\x02\x03 no mesh", "auto-empty": ""}
    for name, text in bad.items():
        put("mesh", "bad-" + name, name.split("-")[0] + "\n" + text)
    put("mesh", "bad-ply-binary-count", b"ply\n" + ply_binary(count=1 << 31))
    put("mesh", "bad-stl-binary-count", b"stl\n" + stl_binary(count=1 << 31))
    put("mesh", "bad-auto-gzip-cut", b"auto\n" + gzip.compress(obj().encode(), mtime=0)[:40])


# -------------------------------------------------------------------------------------------------- scene

LAYER = {"dataset": "data/beam", "particles": {}}
VIEW = {"width": 320, "height": 240, "layers": [LAYER]}
CAMERA = {"eye": [3, 1, 1], "target": [0, 0, 0]}
JOB = {"output": "data/a.mote", "particles": {"inputs": ["data/run.h5"], "axes": ["x", "px", "y"]}}
LASSO = {"camera": CAMERA, "aspect": 1.5, "points": [[0.1, 0.1], [0.9, 0.1], [0.5, 0.8]]}


def make_scenes():
    ok = {
        "view": VIEW, "view-camera": {**VIEW, "camera": CAMERA, "background": [1, 1, 1]},
        "view-annotations": {**VIEW, "annotations": {"axes": True, "labels": True}},
        "view-kinds": {"width": 64, "height": 64, "layers": [{"dataset": "d/v", "hybrid": {}}, {"dataset": "d/m", "mesh": {}},
                                                            {"dataset": "d/s", "stipple": {}}]},
        "view-select": {**VIEW, "layers": [{**LAYER, "select": {"ranges": [{"column": "x", "min": 0}]}}]},
        "script": {"views": [VIEW, {**VIEW, "camera": CAMERA}]},
        "script-keyframes": {"fps": 10, "keyframes": [{"seconds": 0, "view": {**VIEW, "camera": CAMERA}},
                                                      {"seconds": 1, "view": {**VIEW, "camera": {**CAMERA, "eye": [1, 3, 1]}}}]},
        "script-moves": {"fps": 10, "view": {**VIEW, "camera": CAMERA}, "moves": [{"seconds": 1, "turn": {"degrees": 90}}]},
        "selection": {"ranges": [{"column": "x", "min": -1, "max": 1}]},
        "selection-tree": {"all": [{"any": [{"ids": [1, 2, 3]}, {"not": {"density": {"min": 0.5}}}]}, {"lasso": LASSO}]},
        "selection-empty": {"any": [{"ids": []}, {"not": {"ranges": []}}, {"all": [{}, {"ids": [1]}]}]},
        "job": JOB, "job-volume": {"output": "data/v.mote", "volume": {"inputs": ["data/v.nrrd"], "low": 8}},
        "job-mesh": {"output": "data/m.mote", "mesh": {"input": "data/m.obj"}},
        "job-film": {"film": {"script": {"views": [VIEW]}, "video": "mp4"}},
    }
    bad = {
        "view-empty": {}, "view-size": {**VIEW, "width": 1 << 31}, "view-step": {**VIEW, "layers": [{**LAYER, "step": -1}]},
        "view-camera": {**VIEW, "camera": {"eye": [0, 0, 0], "target": [0, 0, 0]}},
        "view-transform": {**VIEW, "layers": [{**LAYER, "transform": [0] * 16}]}, "view-field": {**VIEW, "colour": 1},
        "view-layers": {**VIEW, "layers": [LAYER] * 9}, "script-empty": {}, "script-both": {"views": [VIEW], "keyframes": []},
        "script-fps": {"fps": -1, "views": [VIEW]}, "script-time": {"keyframes": [{"seconds": "NaN", "view": VIEW}]},
        "selection-deep": None, "selection-polygon": {"polygon": {"columns": ["x", "y"], "points": [[0, 0]]}},
        "job-empty": {}, "job-axes": {**JOB, "particles": {"inputs": ["data/run.h5"], "axes": ["x", "x", "y"]}},
        "job-inputs": {**JOB, "particles": {"axes": ["x", "px", "y"]}}, "manifest-empty": {}, "manifest-kind": {"kind": "magic"},
    }
    deep = {"ids": [1]}
    for _ in range(40):
        deep = {"all": [deep]}
    bad["selection-deep"] = deep
    bad["script-both"] = {"views": [VIEW], "keyframes": [{"seconds": 0, "view": VIEW}, {"seconds": 1, "view": VIEW}]}
    for prefix, inputs in (("ok-", ok), ("bad-", bad)):
        for name, value in inputs.items():
            put("scene", prefix + name, name.split("-")[0] + "\n" + json.dumps(value))
    put("scene", "bad-view-cut", "view\n" + json.dumps(VIEW)[:-2])
    put("scene", "bad-view-infinite", "view\n" + json.dumps(VIEW)[:-1] + ', "background": [1e999, 0, 0]}')


# --------------------------------------------------------------------------------------------------- wire

GREETING = struct.pack("<4sHH", b"MOTE", 1, 3)


def frame(message, payload=b""):
    data = message if isinstance(message, bytes) else message.SerializeToString()
    return struct.pack("<II", len(data), len(payload)) + data + payload


def client(kind, **fields):
    message = new("ClientMessage")
    message.request = 1
    body = getattr(message, kind)
    body.SetInParent()
    for name, value in fields.items():
        setattr(body, name, value)
    return message


def make_streams():
    hello = frame(client("hello", token="00" * 32, client="a seed", minor=3))
    view = client("set_view", view_id=1, final_only=True)
    view.set_view.view.width = view.set_view.view.height = 64
    view.set_view.view.layers.add(dataset="data/beam").particles.SetInParent()
    job = client("submit_job")
    job.submit_job.job.output = "data/a.mote"
    job.submit_job.job.particles.inputs.append("data/run.h5")
    query = client("query", dataset="data/beam")
    query.query.select.ids.extend([1, 2, 3])
    more = {"greeting": b"", "hello": hello, "view": hello + frame(view), "job": hello + frame(job),
            "query": hello + frame(query), "ping": hello + frame(client("ping", sent_ns=5)) + frame(client("list_datasets")),
            "upload": hello + frame(client("upload", name="a.npz", size=3, data=b"abc")), "empty": hello + frame(b"")}
    for name, data in more.items():
        put("wire", "ok-client-" + name, b"client\n" + GREETING + data)
    picture = new("ServerMessage")
    picture.frame.view_id, picture.frame.width, picture.frame.height = 1, 3, 2
    for name, pixel, size in (("srgb", 1, 3), ("half", 2, 6)):
        picture.frame.format = pixel
        put("wire", "ok-server-" + name, b"server\n" + GREETING + frame(picture, bytes(range(6 * size))))
    welcome = new("ServerMessage")
    welcome.welcome.server, welcome.welcome.frame_credits = "mote", 2
    put("wire", "ok-server-welcome", b"server\n" + GREETING + frame(welcome))
    huge = struct.pack("<II", 0x7FFFFFFF, 0)
    bad = {"client-magic": b"HTTP/1.1", "client-major": struct.pack("<4sHH", b"MOTE", 2, 0), "client-short": GREETING[:5],
           "client-header": GREETING + hello[:6], "client-cut": GREETING + hello[:20], "client-huge": GREETING + hello + huge,
           "client-hello": GREETING + struct.pack("<II", 5000, 0) + bytes(5000), "client-noise": GREETING + frame(b"\xff" * 20),
           "client-payload": GREETING + struct.pack("<II", 0, 4) + b"abcd", "client-deep": GREETING + hello + frame(
               b"\x62\x7f" * 3 + b"\x1a\x7e" * 100), "client-text": GREETING + frame(b"\x12\x04\x0a\x02\xff\xfe"),
           "server-huge": GREETING + struct.pack("<II", 0, 0xFFFFFFFF), "server-payload": GREETING + frame(picture, bytes(9))[:-3]}
    for name, data in bad.items():
        put("wire", "bad-" + name, name.split("-")[0].encode() + b"\n" + data)


# ------------------------------------------------------------------------------------------------- tables


def numbered(method=zipfile.ZIP_STORED):
    names = ("x", "px", "y", "py", "z", "pz")
    return seed_tables.npz(method, **{name: seed_tables.npy([number, number + 1.5]) for number, name in enumerate(names)})


def astra():
    rows = [(0, 0, 1, 0, 0, 1e6, 0, -1e-3, 1, 5), (1e-3, 2e-3, 1e-4, 10, 20, 30, 1e-3, -1e-3, 1, 5)]
    return "".join(" ".join(map(str, row)) + "\n" for row in rows)


def dst():
    data = b"\x7d\x64" + struct.pack("<idd", 2, 1.0, 352.2) + b"\0"
    data += b"".join(struct.pack("<6d", 0.1 * i, 1e-3, 0.2, 2e-3, 0.0, 3.0) for i in range(2))
    return data + struct.pack("<d", 938.272)


def make_tables():
    whole = numbered()
    put("table", "ok-npz", b"npz\n" + whole)
    put("table", "ok-npz-deflated", b"npz\n" + numbered(zipfile.ZIP_DEFLATED))
    put("table", "ok-auto-npz", b"auto\n" + whole)
    put("table", "bad-npz-cut", b"npz\n" + whole[:-40])
    put("table", "bad-npz-noise", b"npz\nPK\x03\x04 no archive")
    put("table", "bad-npz-size", b"npz\n" + whole.replace(b"(2,)", b"(9,)"))
    put("table", "ok-astra", "astra\n" + astra())
    put("table", "bad-astra-column", "astra\n" + astra().replace("1000000.0", "x"))
    put("table", "bad-astra-row", "astra\n" + astra()[:40])
    put("table", "ok-tracewin", b"tracewin\n" + dst())
    put("table", "bad-tracewin-cut", b"tracewin\n" + dst()[:-30])
    put("table", "bad-tracewin-count", b"tracewin\n" + dst().replace(struct.pack("<i", 2), struct.pack("<i", 1 << 30), 1))


# ------------------------------------------------------------------------------------------------ datasets


def pack(folder):
    """The files of a dataset, one after the other."""
    data = b""
    for path in sorted(folder.iterdir()):
        content = path.read_bytes()
        data += f"{path.name} {len(content)}\n".encode() + content
    return data


def png(side=4):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(16 * (x + y) for x in range(side)) for y in range(side))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def make_datasets(prep):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "run.csv").write_text("x [m],px [eV/c],y [m],id\n" + "".join(
            f"{0.1 * i},{i},{0.2 * i * i},{i}\n" for i in range(12)), encoding="utf-8")
        (folder / "v.raw").write_bytes(bytes((x * y + 40 * (z % 2)) % 256 for z in range(12) for y in range(10) for x in range(9)))
        (folder / "t.obj").write_text(obj(), encoding="utf-8")
        (folder / "p.obj").write_text("g a\n" + obj() + "g b\nv 3 3 3\nf 1 2 5\n", encoding="utf-8")
        (folder / "g.png").write_bytes(png())
        volume = ["v.raw", "--dimensions", "9", "10", "12", "--low", "4", "--threshold", "0.02"]
        commands = {
            "particles": ["particles", "run.csv", "--axes", "x,px,y", "--volume-level", "1", "--columns", "none"],
            "columns": ["particles", "run.csv", "--axes", "x,px,y", "--volume-level", "1"],
            "residual": ["volume", *volume],
            "both": ["volume", *volume, "--representation", "both", "--point-bytes", "6", "--value-bits", "16"],
            "octree": ["particles", "run.csv", "--axes", "x,px,y", "--volume-level", "1", "--leaf-capacity", "2", "--columns", "px,id"],
            "points": ["volume", *volume, "--representation", "points"], "places": ["volume", *volume, "--representation", "points", "--point-bytes", "9"],
            "mesh": ["mesh", "t.obj"], "parts": ["mesh", "p.obj"], "image": ["image", "g.png"],
            "hierarchy": ["stipple", "plane", "--points", "20"], "surface": ["stipple", "t.obj", "--points", "20"],
        }
        for kind, words in commands.items():
            subprocess.run([prep, *words, "--threads", "1", "--quiet", "--out", f"{kind}.mote"], cwd=folder, check=True)
            data = pack(folder / f"{kind}.mote")
            put("dataset", "ok-" + kind, data)
            make_damage(kind, folder / f"{kind}.mote")


def make_damage(kind, dataset):
    """Wrong content under hashes that are right, as the input makes them anew."""
    manifest = json.loads((dataset / "manifest.json").read_text(encoding="utf-8"))
    whole = (dataset / "manifest.json").read_bytes()
    if kind in ("particles", "mesh", "hierarchy", "residual"):
        (dataset / "manifest.json").write_text(json.dumps({**manifest, "kind": "image"}), encoding="utf-8")
        put("dataset", f"bad-{kind}-kind", pack(dataset))
        (dataset / "manifest.json").write_bytes(whole)
    digests = [path for path in sorted(dataset.glob("*.digest")) if path.name != "manifest.digest"]
    if not digests:
        return
    arrays = digests[-1]
    text = arrays.read_text(encoding="utf-8")
    digest = json.loads(text)
    digest["arrays"][0]["offset"] = str((1 << 64) - 8)
    arrays.write_text(json.dumps(digest), encoding="utf-8")
    put("dataset", f"bad-{kind}-offset", pack(dataset))
    arrays.write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    options = parser.parse_args()
    make_meshes()
    make_scenes()
    make_streams()
    make_tables()
    for module in (seed_dicom, seed_files, seed_hdf5, seed_tables, seed_volumes):
        for corpus, name, data in module.seeds():
            put(corpus, name, data)
    make_datasets((options.build / "bin" / "mote-prep").resolve())


if __name__ == "__main__":
    main()
