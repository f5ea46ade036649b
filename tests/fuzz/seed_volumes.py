# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeds of the corpus volume: what readers of NRRD, VTI and MetaImage refuse, each by one wrong word."""
import base64
import struct
import zlib

NRRD = ("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nencoding: raw\nspace: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,3)\n"
        "space origin: (1,2,3)\n\n")
DATA = bytes(range(12))
BLOCK = bytes(range(0, 24))


def nrrds():
    swaps = {
        "end": ("(1,2,3)\n\n", "(1,2,3)\n"), "line": ("encoding: raw", "encoding raw"), "encoding": ("raw", "bzip2"), "endian": ("type: uchar", "type: short\nendian: middle"), "axes": ("sizes: 3 2 2", "sizes: 3 2"),
        "directions": ("(0,1,0) (0,0,3)", "(0,1,0)"), "direction": ("(0,0,3)", "(0,0,x)"), "spacings": ("space directions: (1,0,0) (0,1,0) (0,0,3)\nspace origin: (1,2,3)", "spacings: 1 1"),
        "mins": ("space directions: (1,0,0) (0,1,0) (0,0,3)\nspace origin: (1,2,3)", "axis mins: 1 1"), "vectors": ("dimension: 3\nsizes: 3 2 2", "dimension: 4\nsizes: 3 2 2 1\nkinds: vector domain domain domain"),
        "plane": ("dimension: 3\nsizes: 3 2 2", "dimension: 2\nsizes: 6 2"), "five": ("dimension: 3", "dimension: 99"), "type": ("uchar", "block"), "size": ("3 2 2", "3 2.5 2"), "origin": ("(1,2,3)", "(1,2)"),
        "flat": ("(0,1,0) (0,0,3)", "(0,1,0) (0,2,0)"), "skip": ("encoding: raw", "encoding: gzip\nbyte skip: -1"), "lineskip": ("encoding: raw", "encoding: raw\nline skip: -4"),
    }
    for name, (old, new) in swaps.items():
        yield f"bad-nrrd-word-{name}", b"nrrd\n" + NRRD.replace(old, new).encode() + DATA
    yield "ok-nrrd-none", b"nrrd\n" + NRRD.replace("dimension: 3\nsizes: 3 2 2", "dimension: 4\nsizes: 1 3 2 2").replace("directions: ", "directions: none ").encode() + DATA
    yield "ok-nrrd-skip-end", b"nrrd\n" + NRRD.replace("raw", "raw\nbyte skip: -1").encode() + b"head" + DATA


def vti(content, encoding="base64", kind="Int16", form='format="appended" offset="0"', attributes="", compressor=' compressor="vtkZLibDataCompressor"', order="LittleEndian"):
    head = (f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="{order}"{compressor}{attributes}>\n<ImageData WholeExtent="0 2 0 1 0 1" '
            'Origin="1 2 3" Spacing="1 1 2">\n<Piece Extent="0 2 0 1 0 1">\n<PointData Scalars="a">\n'
            f'<DataArray type="{kind}" Name="a" {form}/>\n</PointData>\n</Piece>\n</ImageData>\n')
    return b"vti\n" + head.encode() + f'<AppendedData encoding="{encoding}">_'.encode() + content + b"</AppendedData></VTKFile>\n"


def blocks(parts, size=12, last=0, lie=None):
    packed = [zlib.compress(part) for part in parts]
    header = struct.pack(f"<{3 + len(parts)}I", len(parts), size, last, *(lie or map(len, packed)))
    return base64.b64encode(header) + base64.b64encode(b"".join(packed))


def vtis():
    halves = [BLOCK[:12], BLOCK[12:]]
    whole = blocks(halves)
    plain = base64.b64encode(struct.pack("<I", 24) + BLOCK)
    yield "ok-vti-halves", vti(whole)
    yield "ok-vti-last", vti(blocks([BLOCK[:16], BLOCK[16:]], 16, 8))
    yield "ok-vti-wide", vti(base64.b64encode(struct.pack("<Q", 24) + BLOCK), compressor="", attributes=' header_type="UInt64"')
    yield "ok-vti-big", vti(base64.b64encode(struct.pack(">I", 24) + BLOCK), compressor="", order="BigEndian")
    bad = {
        "less": vti(blocks([BLOCK[:12], BLOCK[12:20]])), "more": vti(blocks([BLOCK[:12], BLOCK[12:] + b"x"])), "fit": vti(blocks(halves, lie=(1 << 30, 9))), "bomb": vti(blocks(halves, size=1 << 30)),
        "said": vti(blocks(halves[:1])), "digit": vti(whole[:40] + b"*" + whole[41:]), "digits": vti(plain[:-3], compressor=""), "order": vti(whole, order="Middle"), "header": vti(whole, attributes=' header_type="UInt8"'),
        "compressor": vti(whole, compressor=' compressor="vtkLZ4DataCompressor"'), "vectors": vti(whole, form='NumberOfComponents="3" format="appended" offset="0"'), "format": vti(whole, form='format="xml"'),
        "encoding": vti(whole, encoding="hex"), "underscore": vti(whole).replace(b">_", b"> "), "nothing": vti(whole).replace(b'<AppendedData encoding="base64">_' + whole + b"</AppendedData>", b""),
        "plain": vti(plain.replace(plain[:8], base64.b64encode(struct.pack("<I", 20) + BLOCK)[:8]), compressor=""), "type": vti(whole, kind="String"),
        "extent": vti(whole).replace(b'WholeExtent="0 2', b'WholeExtent="2 0'), "spacing": vti(whole).replace(b"1 1 2", b"1 0 2"), "tag": vti(whole).replace(b"</Piece>", b"</Pieces>"), "kind": vti(whole).replace(b'"ImageData"', b'"PolyData"'),
    }
    for name, data in bad.items():
        yield "bad-vti-word-" + name, data


def metaimages():
    head = "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
    swaps = {"dims": ("NDims = 3", "NDims = 2"), "sizes": ("3 2 2", "3 2"), "size": ("3 2 2", "3 2 x"), "type": ("MET_UCHAR", "MET_LONG_DOUBLE"), "line": ("NDims = 3", "NDims"), "spacing": ("NDims = 3", "NDims = 3\nElementSpacing = 1 1"),
             "flat": ("NDims = 3", "NDims = 3\nTransformMatrix = 1 0 0 1 0 0 0 0 1"), "number": ("NDims = 3", "NDims = 3\nOffset = 1 1 x"), "many": ("LOCAL", "s%d.raw 1 9999999 1"), "pattern": ("LOCAL", "s%s.raw 1 2 1")}
    for name, (old, new) in swaps.items():
        yield "bad-metaimage-word-" + name, b"metaimage\n" + head.replace(old, new).encode() + DATA


def seeds():
    for make in (nrrds, vtis, metaimages):
        for name, data in make():
            yield "volume", name, data
