# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeds of the corpus table: arrays of numpy, zip archives and SDDS in all that they may be stored as."""
import io
import struct
import zipfile
import zlib

# ------------------------------------------------------------------------------------------ .npy and .npz

CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q", "f4": "f", "f8": "d"}


def npy(values, kind="<f8", shape=None, fortran=False, version=1):
    code = CODES.get(kind[1:], "d")
    shape = (len(values),) if shape is None else shape
    head = f"{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}" if isinstance(kind, str) else kind
    head = head.ljust(117) + "\n"
    size = struct.pack("<H" if version == 1 else "<I", len(head))
    order = ">" if kind[0] == ">" else "<"
    return b"\x93NUMPY" + bytes((version, 0)) + size + head.encode() + struct.pack(f"{order}{len(values)}{code}", *values)


def npz(method=zipfile.ZIP_STORED, **arrays):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", method) as archive:
        for name, content in arrays.items():
            archive.writestr(zipfile.ZipInfo(name if "." in name else name + ".npy"), content, method)
    return data.getvalue()


def zip64(name=b"x.npy", content=None, large=True, field=None):
    """One entry whose sizes and place stand in zip64 fields, and the end in a zip64 record."""
    content = npy([1.0, 2.0]) if content is None else content
    size = struct.pack("<QQ", len(content), len(content))
    field = struct.pack("<HHHHHQQQ", 9, 2, 7, 1, 24, len(content), len(content), 0) if field is None else field
    local = struct.pack("<4sHHHHHIIIHH", b"PK\3\4", 45, 0, 0, 0, 0, zlib.crc32(content), 0xFFFFFFFF, 0xFFFFFFFF, len(name), 20)
    local += name + struct.pack("<HH", 1, 16) + size + content
    central = struct.pack("<4sHHHHHHIIIHHHHHII", b"PK\1\2", 45, 45, 0, 0, 0, 0, zlib.crc32(content), 0xFFFFFFFF, 0xFFFFFFFF, len(name), len(field),
                          0, 0, 0, 0, 0xFFFFFFFF) + name + field
    end64 = struct.pack("<4sQHHIIQQQQ", b"PK\6\6", 44, 45, 45, 0, 0, 1, 1, len(central), len(local))
    locator = struct.pack("<4sIQI", b"PK\6\7", 0, len(local) + len(central), 1)
    end = struct.pack("<4sHHHHIIH", b"PK\5\6", 0, 0, 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0)
    return local + central + (end64 + locator if large else b"") + end


def overlap(archive):
    """The second entry stands where the first one does."""
    at = archive.rindex(b"PK\1\2") + 42
    return archive[:at] + bytes(4) + archive[at + 4:]


def npy_seeds():
    six = {name: npy([number, number + 1.5]) for number, name in enumerate(("x", "px", "y", "py", "z", "pz"))}
    fields = "{'descr': [('x', '<f8'), ('px', '<f4'), ('id', '<u8')], 'fortran_order': False, 'shape': (2,), }"
    record = struct.pack("<dfQ", 1, 2, 3) * 2

    def structured(head, data=record):
        head = head.ljust(117) + "\n"
        return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head.encode() + data

    ok = {f"npz-{order == '>' and 'big' or 'little'}-{code}": npz(**{**six, "y": npy([1, 2], order + code)}) for code in CODES for order in "<>"}
    ok |= {f"npz-id-{code}": npz(**six, id=npy([1, 2], "<" + code)) for code in ("u1", "i4", "u4", "i8", "u8", "f8")}
    ok |= {
        "npz-mass": npz(**six, mass=npy([5.1e5], shape="()")), "npz-steps": npz(x=npy(range(6), shape=(3, 2)), px=npy(range(6), shape=(3, 2))),
        "npz-times": npz(x=npy(range(6), shape=(3, 2)), time=npy([1, 2, 3]), iteration=npy([2, 1, 7], "<i8")), "npz-lost": npz(**six, lost=npy([0, 1], "|u1")),
        "npz-status": npz(**six, status=npy([1, 5], "<i4"), alive=npy([1, 0], "|u1")), "npz-time": npz(**six, time=npy([3.0], shape="()")),
        "npz-vector": npz(position=npy(range(6), shape=(2, 3)), momentum=npy(range(6), shape=(2, 3))), "npz-fortran": npz(x=npy(range(6), shape=(3, 2), fortran=True)),
        "npz-vectors": npz(position=npy(range(12), shape=(2, 2, 3)), momentum=npy(range(12), shape=(2, 2, 3))), "npz-weights": npz(**six, weight=npy([1, -2])),
        "npz-times2": npz(x=npy(range(6), shape=(3, 2)), time=npy(range(6), shape=(3, 2))), "npz-iteration": npz(**six, iteration=npy([4], "<i8", "()")),
        "npz-version2": npz(x=npy([1, 2], version=2)), "npz-deflated64": npz(zipfile.ZIP_DEFLATED, x=npy(range(3000))), "npz-zip64": zip64(),
        "npz-other": npz(**six, note=npy([1], "|S8", "()"), **{"text.txt": b"hello"}), "npz-structured": npz(beam=structured(fields)),
        "npy-structured": structured(fields), "npy-N6": npy(range(12), shape=(2, 6)), "npy-N7": npy(range(14), shape=(2, 7)), "npy-N3": npy(range(6), "<f4", (2, 3)),
        "npy-steps": npy(range(12), shape=(2, 2, 3)), "npy-structured2": structured(fields.replace("(2,)", "(1, 2)")), "npy-version3": npy(range(6), shape=(2, 3), version=3),
        "npy-list": structured(fields.replace("(2,)", "[2]")),
        "npy-bool": structured(fields.replace("('id', '<u8')", "('lost', '|b1'), ('tag', '|S7')")), "npy-empty-steps": npy([], shape=(0, 6)),
    }
    whole = npz(**six)
    end = len(whole) - 22
    bad = {
        "npz-nothing": npz(**{"text.txt": b"hello"}), "npz-lengths": npz(x=npy([1, 2]), y=npy([1])), "npz-steplengths": npz(x=npy(range(6), shape=(3, 2)), y=npy(range(4), shape=(2, 2))),
        "npz-twice": npz(x=npy([1, 2]), position_x=npy([1, 2])), "npz-deep": npz(x=npy(range(8), shape=(2, 2, 2))), "npz-names": npz(a=npy([1, 2])),
        "npz-vector": npz(position=npy(range(4), shape=(2, 2))), "npz-vectordeep": npz(position=npy(range(12), shape=(1, 2, 2, 3))),
        "npz-iteration": npz(**six, iteration=npy([1.5])), "npz-iterations": npz(**six, iteration=npy([1, 2, 3])), "npz-complex": npz(x=npy([1, 2], "<c8")),
        "npz-half": npz(x=npy([1, 2], "<f2")), "npz-text": npz(x=npy([1], "|S8", "(1,)")), "npz-vectortext": npz(position=npy(range(3), "|S8", "(1, 3)")),
        "npz-split": whole[:end + 4] + b"\1\0" + whole[end + 6:], "npz-count": whole[:end + 8] + b"\7\0\7\0" + whole[end + 12:], "npz-fewer": whole[:end + 8] + b"\2\0\2\0" + whole[end + 12:],
        "npz-many": whole[:end + 8] + b"\xf0\xf0\xf0\xf0" + whole[end + 12:], "npz-place": whole[:end + 16] + b"\xf0\xf0\xf0\x70" + whole[end + 20:],
        "npz-directory": whole.replace(b"PK\1\2", b"PK\1\3", 1), "npz-method": whole.replace(b"PK\1\2" + whole[whole.index(b"PK\1\2") + 4:][:6] + b"\0\0", b"PK\1\2" + whole[whole.index(b"PK\1\2") + 4:][:6] + b"\x0c\0", 1),
        "npz-crc": whole.replace(struct.pack("<d", 1.5), struct.pack("<d", 2.5), 1), "npz-local": whole.replace(b"PK\3\4", b"PK\3\5", 1), "npz-header": npz(x=b"no array"),
        "npz-inflate": npz(zipfile.ZIP_DEFLATED, x=npy(range(3000)))[:600] + bytes(9) + npz(zipfile.ZIP_DEFLATED, x=npy(range(3000)))[609:], "npz-end64": zip64().replace(b"PK\6\6", b"PK\6\1"),
        "npz-nozip64": zip64(field=b""), "npz-shortzip64": zip64(field=struct.pack("<HHQ", 1, 8, 4)), "npz-zip64size": zip64(field=struct.pack("<HHQQQ", 1, 24, 1 << 40, 1 << 40, 0)),
        "npz-zip64bomb": zip64(field=struct.pack("<HHQQQ", 1, 24, 1 << 60, 100, 0)), "npz-zip64place": zip64(field=struct.pack("<HHQQQ", 1, 24, 100, 100, 1 << 50)),
        "npz-overlap": overlap(npz(x=npy([1, 2]), y=npy([1, 2]))), "npz-repeated": npz(x=npy([1]), X=npy([1])).replace(b"X.npy", b"x.npy"), "npz-elsewhere": zip64(large=False), "npz-split64": zip64().replace(struct.pack("<HHII", 45, 45, 0, 0), struct.pack("<HHII", 45, 45, 1, 1)),
        "npy-magic": b"\x93NUMPZ\1\0" + bytes(200), "npy-version": npy([1], version=9), "npy-keys": structured("{'descr': '<f8', 'shape': (2,), }"), "npy-order": npy([1, 2], "=f8"),
        "npy-tuple": structured(fields.replace("('px', '<f4')", "('px',)")), "npy-fieldtype": structured(fields.replace("'<f4'", "4")), "npy-nofields": structured("{'descr': [], 'fortran_order': False, 'shape': (2,), }"),
        "npy-twice": structured(fields.replace("'id'", "'x'")), "npy-deep": structured(fields.replace("(2,)", "(1, 1, 2)")), "npy-shape": npy(range(8), shape=(2, 4)), "npy-escape": structured(fields.replace("'px'", "'p\\\\x'")),
        "npy-quote": structured(fields.replace("'px', '<f4'", "'px")), "npy-gzip": b"\x1f\x8b\x08\0" + bytes(20), "npy-headershort": npy([1])[:40], "npy-number": structured(fields.replace("(2,)", "(99999999999999999999,)")),
        "npy-bigshape": npy([1], shape=(1 << 40, 1 << 40)), "npy-subarray": structured(fields.replace("'<f4')", "'<f4', (2,))")), "npy-vast": npy([1], "<f999999999"),
    }
    for prefix, seeds in (("ok-", ok), ("bad-", bad)):
        for name, data in seeds.items():
            yield prefix + name, f"{name[:3]}\n".encode() + data


# -------------------------------------------------------------------------------------------------- SDDS

KINDS = {"short": "h", "ushort": "H", "long": "i", "ulong": "I", "long64": "q", "ulong64": "Q", "float": "f", "double": "d", "character": "c"}
NAMES = ("x", "xp", "y", "yp", "t", "p")


def header(kind="double", data="mode=binary, endian=little", more="", names=NAMES, first="SDDS1\n"):
    columns = "".join(f"&column name={name}, type={kind}, &end\n" for name in names)
    return first + more + columns + f"&data {data}, &end\n"


def binary(kind="double", order="<", rows=3, major=False, parameters=b"", wide=False, **more):
    endian = "big" if order == ">" else "little"
    data = header(kind, f"mode=binary, endian={endian}" + (", column_major_order=1" if major else ""), **more).encode()
    data += (struct.pack(order + "iq", -(1 << 31), rows) if wide else struct.pack(order + "i", rows)) + parameters
    values = [[number + 1 + row for number in range(len(NAMES))] for row in range(rows)]
    flat = [row[c] for c in range(len(NAMES)) for row in values] if major else [value for row in values for value in row]
    return data + b"".join(struct.pack(order + KINDS[kind], value) if kind != "character" else b"a" for value in flat)


EXTRAS = ("&description text=\"a run ! no comment\", &end\n! a comment\n&parameter name=Charge, type=double, units=C, &end\n"
          "&parameter name=Step, type=long, fixed_value=3, &end\n&parameter name=Note, type=string, &end\n"
          "&array name=A, type=short, dimensions=2, &end\n&array name=B, type=string, &end\n")


def extras(order="<"):
    return (struct.pack(order + "d", 1e-9) + struct.pack(order + "i", 5) + b"hello" + struct.pack(order + "ii6h", 2, 3, *range(6)) +
            struct.pack(order + "i", 2) + struct.pack(order + "i", 1) + b"a" + struct.pack(order + "i", 0))


ROWS = "".join(f"{i} 1e-3 {i} 2e-3 1e-9 {100 + i}\n" for i in range(3))
TEXT_EXTRAS = "1e-9\nhello \"there\"\n2 3\n1 2 3\n4 5 6\n2\na \"b c\"\n"


def text(rows=ROWS, count="3\n", data="mode=ascii", more="", kind="double", values="", **others):
    return header(kind, data, more=more, **others) + values + count + rows


def sdds_seeds():
    ok = {f"sdds-{kind}-{'big' if order == '>' else 'little'}{'-columns' if major else ''}": binary(kind, order, major=major)
          for kind in KINDS for order in "<>" for major in (False, True) if kind != "character"}
    names = {"names": ("x", "y", "z", "px", "py", "pz", "id", "lost")}
    units = "".join(f"&column name={n}, units=\"{u}\", type=double &end\n" for n, u in (("x", "mm"), ("xp", "mrad"), ("y", "m"), ("yp", "rad"), ("p", "m$be$nc"), ("dt", "s")))
    ok |= {
        "sdds-wide": binary(wide=True), "sdds-wide-big": binary(order=">", wide=True), "sdds-pages": binary() + binary()[len(header()):], "sdds-none": binary(rows=0),
        "sdds-extras": binary(more=EXTRAS, parameters=extras()), "sdds-extras-big": binary(more=EXTRAS, order=">", parameters=extras(">")), "sdds-extras-columns": binary(more=EXTRAS, major=True, parameters=extras()),
        "sdds-unsaid": binary(order=">").replace(b", endian=big", b""), "sdds-comment": binary(order=">", first="SDDS3\n!# big-endian\n").replace(b", endian=big", b""),
        "sdds-comment-little": binary(first="SDDS3\n!# little-endian\n").replace(b", endian=little", b""),
        "sdds-ascii": text(), "sdds-ascii-extras": text(more=EXTRAS, values="! page 1\n3\n" + TEXT_EXTRAS, count="").replace("! page 1\n3\n" + TEXT_EXTRAS, TEXT_EXTRAS + "3\n"),
        "sdds-ascii-uncounted": text(data="mode=ascii, no_row_counts=1", count="") + "\n" + ROWS, "sdds-ascii-lines": text(data="mode=ascii, lines_per_row=2", rows=ROWS.replace(" 2e-3", "\n2e-3")),
        "sdds-ascii-anylines": text(data="mode=ascii, lines_per_row=0", rows=ROWS.replace(" ", "\n")), "sdds-ascii-more": text(data="mode=ascii, additional_header_lines=1", values="a line\n"),
        "sdds-ascii-pages": text() + "3\n" + ROWS + "! a comment\n0\n", "sdds-ascii-mixed": text(kind="float", rows="1 2 3 4 5 6 ! six\n", count="1\n"),
        "sdds-text-column": text(more="&column name=tag, type=string, &end\n&column name=c, type=character, &end\n", rows='"a \\" b" c 1 2 3 4 5 6\n', count="1\n"),
        "sdds-momenta": text(rows="1 2 3 4 5 6 7 0\n", count="1\n", **names), "sdds-dt": header(data="mode=ascii", names=(), more=units) + "1\n1 2 3 4 5 6\n",
        "sdds-longdouble": text(kind="longdouble"), "sdds-long-ids": text(more="&column name=particleID, type=ulong64, &end\n", rows="18446744073709551615 1 2 3 4 5 6\n", count="1\n"),
        "sdds-binary-text": binary(rows=1, names=NAMES, more="&column name=tag, type=string, &end\n", parameters=struct.pack("<i", 2) + b"ab"), "sdds-escape": text(more='&description contents="a \\"b\\" \\\\ c", &end\n'),
        "sdds-status": text(more="&column name=status, type=long, &end\n", rows="1 1 2 3 4 5 6\n", count="1\n"),
        "sdds-steps": header(data="mode=ascii", more="&parameter name=Step, type=long, &end\n") + "1\n1\n1 2 3 4 5 6\n2\n1\n1 2 3 4 5 6\n", "sdds-associate": text(more="&associate filename=a, &end\n"),
        "sdds-charge": header(data="mode=ascii", more="&parameter name=Charge, type=double, units=nC &end\n") + "1\n1\n1 2 3 4 5 6\n",
        "sdds-binary-page-texts": binary(major=True, rows=2, more="&column name=tag, type=string, &end\n", parameters=struct.pack("<i", 1) + b"a" + struct.pack("<i", 1) + b"b"),
    }
    bad = {
        "sdds-quotes": text(rows='"1" 2 3 4 5 6\n', count="1\n"), "sdds-version": text(first="SDDS9\n"), "sdds-command": text(more="column name=x\n"), "sdds-unknown": text(more="&colum name=x, &end\n"), "sdds-include": text(more="&include filename=a, &end\n"),
        "sdds-noname": text(more="&column type=double, &end\n"), "sdds-twice": text(more="&column name=x, type=double, &end\n"), "sdds-notype": text(more="&column name=a, &end\n"), "sdds-type": text(kind="quad"),
        "sdds-dimensions": text(more="&array name=a, type=long, dimensions=0, &end\n"), "sdds-dimension": text(more="&array name=a, type=long, dimensions=x, &end\n"), "sdds-mode": text(data="mode=xml"),
        "sdds-endian": text(data="mode=binary, endian=middle"), "sdds-longdouble": text(data="mode=binary", kind="longdouble"), "sdds-header": text()[:60], "sdds-fields": text(more="&column name, &end\n"),
        "sdds-nopage": header(data="mode=ascii"), "sdds-nopage-binary": header(), "sdds-rows": text(rows=ROWS[:30]), "sdds-count": text(count="x\n"), "sdds-number": text(rows=ROWS.replace("100", "abc")), "sdds-parameter": text(more=EXTRAS, values=TEXT_EXTRAS.replace("1e-9", "x")),
        "sdds-noparameter": text(more=EXTRAS, count="", rows="", values="1\n"), "sdds-array": text(more=EXTRAS, values=TEXT_EXTRAS.replace("2 3\n", "2 x\n")), "sdds-arraycut": text(more=EXTRAS, count="", rows="", values=TEXT_EXTRAS[:26]),
        "sdds-arraysize": text(more=EXTRAS, values=TEXT_EXTRAS.replace("2 3\n", "18446744073709551615 18446744073709551615\n")), "sdds-noarray": text(more=EXTRAS, count="", rows="", values="1e-9\nhello\n"), "sdds-short": text(rows="1 2 3\n4 5 6\n", count="2\n"),
        "sdds-long": text(rows="1 2 3 4 5 6 7\n", count="1\n"), "sdds-linesshort": text(data="mode=ascii, lines_per_row=2", rows="1 2\n3 4\n", count="1\n"), "sdds-linescut": text(data="mode=ascii, lines_per_row=2", rows="1 2\n", count="1\n"),
        "sdds-linesmore": text(data="mode=ascii, lines_per_row=3", rows="1 2 3 4 5 6\n", count="1\n"), "sdds-unit": text(more="&column name=z, type=double, units=furlong, &end\n"), "sdds-slope": text(names=("x", "y"), more="&column name=xp, type=double, units=furlong &end\n"),
        "sdds-same": text(more="&column name=position_x, type=double, &end\n"), "sdds-textx": text(names=("y",), more="&column name=x, type=string, &end\n"), "sdds-nocolumn": text(names=("a", "b")), "sdds-texts": binary(more=EXTRAS, parameters=extras()[:8] + struct.pack("<i", -5)),
        "sdds-arraysizes": binary(more=EXTRAS, parameters=extras()[:17] + struct.pack("<ii", -1, 3)), "sdds-arrayhuge": binary(more=EXTRAS.replace("dimensions=2", "dimensions=4"), parameters=extras()[:17] + struct.pack("<iiii", *[(1 << 31) - 1] * 4)),
        "sdds-negative": header().encode() + struct.pack("<i", -7), "sdds-wide": header().encode() + struct.pack("<iq", -(1 << 31), -1), "sdds-widehuge": header().encode() + struct.pack("<iq", -(1 << 31), (1 << 62)), "sdds-bytes": binary()[:-9],
        "sdds-bytescolumns": binary(major=True)[:-9], "sdds-widecolumns": header(data="mode=binary, column_major_order=1").encode() + struct.pack("<iq", -(1 << 31), 1 << 62), "sdds-charge": text(more="&parameter name=Charge, type=double, units=furlong &end\n", values="1\n"),
        "sdds-rowcut": text(data="mode=ascii, lines_per_row=0", rows="1 2 3", count="1\n"), "sdds-manylines": text(data="mode=ascii, lines_per_row=99999999999"), "sdds-lines": text(data="mode=ascii, additional_header_lines=9", rows="", count=""),
    }
    for prefix, seeds in (("ok-", ok), ("bad-", bad)):
        for name, data in seeds.items():
            yield prefix + name, b"sdds\n" + (data if isinstance(data, bytes) else data.encode())


def seeds():
    for make in (npy_seeds, sdds_seeds):
        for name, data in make():
            yield "table", name, data
