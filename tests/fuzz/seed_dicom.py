# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeds of the corpus volume: DICOM files, NumPy arrays and MRC maps by hand, and what is refused, each by one wrong word."""
import io
import struct
import zipfile
import zlib

EXPLICIT, DEFLATED, BIG, RLE = "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.2", "1.2.840.10008.1.2.5"
LONG = ("OB", "OW", "SQ", "UN", "OF")
PIXELS = bytes(range(24))


def element(tag, vr, value, order="<", undefined=False):
    """With its kind; texts are padded to an even length."""
    if isinstance(value, str):
        value = value.encode() + b" " * (len(value) % 2)
    if isinstance(value, int):
        value = struct.pack(order + ("H" if vr == "US" else "I"), value)
    head = struct.pack(order + "HH", tag >> 16, tag & 0xffff) + vr.encode()
    length = 0xffffffff if undefined else len(value)
    return head + (struct.pack(order + "HI", 0, length) if vr in LONG else struct.pack(order + "H", length)) + value


def sequence(tag, items, undefined=False):
    body = b""
    for each in items:
        body += struct.pack("<HHI", 0xfffe, 0xe000, 0xffffffff if undefined else len(each)) + each
        body += struct.pack("<HHI", 0xfffe, 0xe00d, 0) if undefined else b""
    return element(tag, "SQ", body + (struct.pack("<HHI", 0xfffe, 0xe0dd, 0) if undefined else b""), undefined=undefined)


def meta(syntax):
    body = element(0x00020010, "UI", syntax)
    return bytes(128) + b"DICM" + element(0x00020000, "UL", len(body)) + body


def fragments(pieces, table=b""):
    body = b"".join(struct.pack("<HHI", 0xfffe, 0xe000, len(each)) + each for each in (table, *pieces))
    return element(0x7fe00010, "OB", body + struct.pack("<HHI", 0xfffe, 0xe0dd, 0), undefined=True)


def rle(frame):
    return struct.pack("<16I", 1, 64, *[0] * 14) + bytes([len(frame) - 1]) + frame + b"\x80" * (1 - len(frame) % 2)


def head(frames=2, order="<", kind="ORIGINAL\\PRIMARY", modality="CT", uid="1.2.3", places=True):
    def put(tag, vr, value):
        return element(tag, vr, value, order)
    made = put(0x00080008, "CS", kind) + put(0x00080018, "UI", uid) + put(0x00080060, "CS", modality)
    if places:
        made += put(0x00180088, "DS", "2.5")
    made += put(0x0020000e, "UI", "1.2") + put(0x00200011, "IS", "7")
    if places:
        made += put(0x00200032, "DS", "1\\2\\3") + put(0x00200037, "DS", "1\\0\\0\\0\\1\\0")
    return made + put(0x00280002, "US", 1) + put(0x00280004, "CS", "MONOCHROME2") + put(0x00280008, "IS", str(frames))


def size(order="<", rows=3, columns=4, bits=8, stored=None, high=None, spacing="1\\1"):
    def put(tag, vr, value):
        return element(tag, vr, value, order)
    return (put(0x00280010, "US", rows) + put(0x00280011, "US", columns) + put(0x00280030, "DS", spacing) + put(0x00280100, "US", bits) +
            put(0x00280101, "US", stored or bits) + put(0x00280102, "US", high or bits - 1) + put(0x00280103, "US", 0) +
            put(0x00281052, "DS", "-5") + put(0x00281053, "DS", "2"))


def pixels(data=PIXELS, order="<"):
    return element(0x7fe00010, "OW", data, order)


def group(z):
    return sequence(0x00209113, [element(0x00200032, "DS", f"0\\0\\{z}")]) + sequence(0x00289145, [element(0x00281053, "DS", str(z + 1))])


def groups(undefined=False, count=2):
    shared = sequence(0x00209116, [element(0x00200037, "DS", "1\\0\\0\\0\\1\\0")])
    return sequence(0x52009229, [shared], undefined) + sequence(0x52009230, [group(z) for z in range(count)], undefined)


def slices(places):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for i, z in enumerate(places):
            body = head(1, uid=f"1.2.3.{i}", places=False) + element(0x00200032, "DS", f"0\\0\\{z}") + element(0x00200037, "DS", "1\\0\\0\\0\\1\\0")
            archive.writestr(zipfile.ZipInfo(f"A/I{i}"), meta(EXPLICIT) + body + size() + pixels(PIXELS[:12]))
    return packed.getvalue()


def siemens():
    """What Siemens' scanners say of a mosaic of three slices."""
    made = b"SV10\4\3\2\1" + struct.pack("<II", 2, 77)
    for name, texts in (("NumberOfImagesInMosaic", ["3"]), ("SliceNormalVector", ["0.0", "0.6", "0.8"])):
        made += struct.pack("<64si4siii", name.encode(), len(texts), b"FD", 4, len(texts), 77)
        made += b"".join(struct.pack("<4i4s", 4, 4, 77, 4, text.encode()) for text in texts)
    return made


def dicoms():
    body = head() + size()
    yield "ok-dicom-frames", meta(EXPLICIT) + body + pixels()
    yield "ok-dicom-groups", meta(EXPLICIT) + head(places=False) + size() + groups() + pixels()
    yield "ok-dicom-groups-open", meta(EXPLICIT) + head(places=False) + size() + groups(True) + pixels()
    yield "ok-dicom-big", meta(BIG) + head(order=">") + size(">", bits=16) + pixels(PIXELS * 2, ">")
    squeeze = zlib.compressobj(wbits=-15)
    yield "ok-dicom-deflated", meta(DEFLATED) + squeeze.compress(body + pixels()) + squeeze.flush()
    yield "ok-dicom-rle", meta(RLE) + body + fragments([rle(PIXELS[:12]), rle(PIXELS[12:])])
    yield "ok-dicom-bare", body + pixels()
    yield "ok-dicom-zip", slices([0, 4, 2])
    yield "ok-dicom-bit", meta(EXPLICIT) + head() + size(bits=1) + pixels(PIXELS[:4])
    mosaic = head(1, kind="ORIGINAL\\MOSAIC") + size(rows=4, columns=6)
    yield "ok-dicom-mosaic", meta(EXPLICIT) + mosaic + element(0x00291010, "OB", siemens()) + pixels()
    private = sequence(0x00290010, [sequence(0x00290011, [group(9)], True)], True)
    yield "ok-dicom-private", meta(EXPLICIT) + head() + size() + private + pixels()
    bad = {
        "single": head(1) + size() + pixels(), "frames": head(3, places=False) + size() + groups() + pixels(), "many": head(10 ** 9) + size() + pixels(), "pixels": body, "short": head(3) + size() + pixels(),
        "bits": head() + size(bits=12) + pixels(), "bit": head() + size(bits=1, stored=2) + pixels(), "stored": head() + size(stored=9) + pixels(), "mosaic": head(kind="ORIGINAL\\MOSAIC") + size() + pixels(),
        "item": head() + element(0x52009229, "SQ", b"\1\0\0\0\0\0\0\0") + size() + pixels(), "length": head() + struct.pack("<HH2sHI", 9, 1, b"UN", 0, 1 << 30) + size() + pixels(), "spacing": head() + size(spacing="0\\1") + pixels(),
        "deep": head() + b"".join(struct.pack("<HH2sHIHHI", 9, 1, b"SQ", 0, 0xffffffff, 0xfffe, 0xe000, 0xffffffff) for _ in range(80)) + pixels(), "plane": head(places=False) + element(0x00200032, "DS", "0\\0\\0") + element(0x00200037, "DS", "1\\0\\0\\1\\0\\0") + size() + pixels(),
    }
    for name, data in bad.items():
        yield "bad-dicom-" + name, meta(EXPLICIT) + data
    yield "bad-dicom-rle-few", meta(RLE) + body + fragments([rle(PIXELS[:12])])
    yield "bad-dicom-rle-end", meta(RLE) + body + fragments([rle(PIXELS[:4]), rle(PIXELS[12:])])
    yield "bad-dicom-rle-place", meta(RLE) + body + fragments([struct.pack("<16I", 1, 999, *[0] * 14) + PIXELS, rle(PIXELS[12:])])
    yield "bad-dicom-other", meta("1.2.840.10008.1.2.9") + body + pixels()
    yield "bad-dicom-missing", slices([0, 1, 2, 4])
    yield "bad-dicom-twice", slices([0, 1, 1, 2])
    yield "bad-dicom-uneven", slices([0, 1, 2, 3.4])


def npy(descr="'<i2'", fortran=False, shape="(2, 3, 4)", data=bytes(range(48))):
    text = f"{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}"
    text += " " * (63 - (len(text) + 10) % 64) + "\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text.encode() + data


def npys():
    yield "ok-npy-c", npy()
    yield "ok-npy-fortran", npy(fortran=True)
    yield "ok-npy-half", npy("'>f2'")
    yield "ok-npy-series", npy("'|u1'", True, "(2, 2, 3, 4)")
    for name, data in {"two": npy(shape="(6, 4)"), "complex": npy("'<c8'", shape="(1, 2, 3)"), "none": npy(shape="(0, 3, 4)", data=b""), "short": npy(data=bytes(47)), "huge": npy(shape="(99999, 3, 4)"),
                       "volumes": npy(shape="(0, 2, 3, 4)", data=b""), "fields": npy("[('a', '<i2')]")}.items():
        yield "bad-npy-" + name, data


def mrc(order="<", **fields):
    made = bytearray(1024)
    said = {0: (4, 3, 2), 12: (1,), 28: (4, 3, 2), 40: (4.0, 3.0, 2.0), 52: (90.0, 90.0, 90.0), 64: (1, 2, 3), 88: (1,)}
    said.update({int(at[1:]): value for at, value in fields.items()})
    for at, value in said.items():
        struct.pack_into(f"{order}{len(value)}{'f' if isinstance(value[0], float) else 'i'}", made, at, *value)
    made[208:216] = b"MAP " + (b"\x44\x44\0\0" if order == "<" else b"\x11\x11\0\0")
    return bytes(made) + bytes(range(48))


def mrcs():
    yield "ok-mrc-little", mrc()
    yield "ok-mrc-big", mrc(">", _64=(3, 1, 2))
    yield "ok-mrc-oblique", mrc(_52=(80.0, 90.0, 120.0), _16=(5, -6, 7))
    yield "ok-mrc-stack", mrc(_88=(401,), _28=(4, 3, 1))
    for name, fields in {"mode": {"_12": (3,)}, "axes": {"_64": (1, 1, 2)}, "cell": {"_52": (10.0, 10.0, 170.0)}, "extended": {"_92": (-1,)}, "size": {"_0": (4, 3, 9)}, "negative": {"_0": (4, -3, 2)},
                         "stack": {"_88": (401,), "_28": (4, 3, 7)}, "none": {"_0": (4, 3, 0)}}.items():
        yield "bad-mrc-" + name, mrc(**fields)


def seeds():
    for make, form in ((dicoms, b"dicom"), (npys, b"npy"), (mrcs, b"mrc")):
        for name, data in make():
            yield "volume", name, form + b"\n" + data
