"""Mutations of mesh files: of bytes, of text, and of the JSON inside a GLB; every draw comes from one Random."""

from __future__ import annotations

import io
import json
import re
import struct
import zipfile
from collections.abc import Callable, Mapping
from copy import deepcopy
from random import Random
from typing import Any

WHOLE = (0, 1, 2, 3, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0xFFFF, 0x10000, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1)
REAL = (0.0, -0.0, 1.0, -1.0, 1e-45, 1e-30, 1e30, 3.4e38, float("inf"), float("-inf"), float("nan"))
NUMBERS = ("0", "-0", "-1", "1", "1e999", "-1e999", "1e-320", "nan", "inf", "99999999999999999999", "2147483648",
           "0x10", "1,5", "1.2.3", "", "+", "--1", "4294967296", "-2147483649", "1e5", "0.000000001")  # fmt: skip
WORDS: Mapping[str, tuple[bytes, ...]] = {
    "obj": (b"mtllib ../../x.mtl", b"mtllib /dev/zero", b"usemtl \x00", b"call x", b"f 1//1 2//2", b"f -1 -2 -3", b"o ",
        b"f 1/1/1 2/2/2 3/3/3 4/4/4", b"vp 1 2", b"g a b c", b"\\\n", b"v 1 2 3 4 5 6 7 8", b"l 1 2", b"s off",
        b"curv 0 1 1 2", b"f 1 1 1", b"vt 0", b"\xff\xfe", b"# " + b"x" * 5000),
    "mtl": (b"newmtl ", b"map_Kd -s 1 1 1 x.png", b"map_Kd /dev/zero", b"d nan", b"Kd 1e999 -1 x", b"map_Kd -o"),
    "ply": (b"element vertex 4294967295", b"element face -1", b"property list uchar int vertex_indices", b"end_header",
        b"property float x", b"format binary_big_endian 1.0", b"format ascii 1.0", b"comment TextureFile ../x.png",
        b"property list double double q", b"element x 99999999999999999999"),
    "stl": (b"solid", b"endsolid", b"facet normal nan 0 0", b"vertex 1 2", b"vertex 1e999 0 0", b"outer loop"),
    "dae": (b"<!DOCTYPE x [<!ENTITY a 'b'>]>", b"&a;", b"<p>", b"</p>", b"<node>" * 600, b"<![CDATA[", b"\x00",
        b'<input semantic="VERTEX" source="#v" offset="99999999"/>', b'url="#s"', b'count="-1"', b'stride="0"',
        b"<xi:include/>", b'encoding="utf-7"', b"<polylist>", b"<vcount>99999999 3</vcount>", b'offset="0"'),
    "glb": (b"glTF", b"JSON", b"BIN\0", b"\x00\x00\x00\x00", b'"uri":"../x"', b'"uri":"data:,"', b"[[[[[[[["),
    "usda": (b"references = @/etc/passwd@", b"(references = </thing>)", b"@../../x.usda@",
        b"payload = @http://x/y.usda@", b"def Mesh \"box\" {", b"int[] holeIndices = [0, 99]",
        b"subLayers = [@a.usda@]", b"clips = {", b"None", b"inf", b"variantSet \"v\" = {", b"instanceable = true",
        b"[]", b"(((((", b"inherits = </thing/box>", b"}", b"{"),
    "usdc": (b"PXR-USDC", b"\xff" * 8, b"\x00" * 8, b"TOKENS\0", b"SPECS\0"),
    "fbx": (b"Objects:  {", b"}", b"a: 0,1,-3", b'C: "OO",11,11', b'C: "OO",10,10', b'C: "OO",0,11', b"*4294967295 {",
        b"\"\"", b"PolygonVertexIndex: *3 { a: 0,1,99 }", b'Content: , "////"', b'RelativeFilename: "../../x.png"',
        b"\x00"),
    "x3d": (b"<!DOCTYPE x [<!ENTITY a 'b'>]>", b"&a;", b"<Transform USE='place'/>", b"<Shape USE='thing'/>",
        b"<Group>" * 600, b"coordIndex='0 1 2 99 -1'", b"<Inline url='\"http://x\"'/>", b"<Script>", b"</Shape>",
        b"<Box size='nan 1 1'/>", b"rotation='0 0 0 nan'", b"scale='0 0 0'", b"<LOD>", b"<Switch whichChoice='99'>",
        b"<IndexedTriangleStripSet index='-1 0'/>"),
    "wrl": (b"USE place", b"USE thing", b"DEF thing", b"children [" * 400, b"Transform { children [", b"]", b"}", b"\"",
        b"NULL", b"PROTO x [ ] { }", b"ROUTE a.b TO c.d", b"Script { url \"javascript: x\" }",
        b"Inline { url \"http://x\" }", b"#"),
    "3ds": (b"\x4d\x4d\xff\xff\xff\xff", b"\x00\x41\x06\x00\x00\x00", b"\x10\x41\x08\x00\x00\x00\xff\xff", b"\x00" * 6),
    "zip": (b"PK\x01\x02", b"PK\x03\x04", b"PK\x05\x06", b"../", b"PK\x06\x07"),
    "blend": (b"ENDB", b"DNA1", b"\xff" * 8),
}  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, 2, 5, 7, 255, 5120, 5121, 5123, 5125, 5126, 2**31, 2**32, 2**63, 10**30, 0.5, -0.5, 1e308,
    1e999, "", "x", "VEC3", "MAT4", "SCALAR", "../../x.bin", "file:///x", "data:application/octet-stream;base64,AAAA",
    "\x00", "\ud800", [], {}, [0], [0, 0], [1e308] * 3, [0] * 16, {"x": {}}, [[[[[[]]]]]],
)  # fmt: skip


def mutate(data: bytes, suffix: str, rng: Random, others: tuple[bytes, ...] = ()) -> bytes:
    """The bytes of a file with one to eight faults.

    `suffix`: of its format, without the dot. `others`: files that pieces may be taken from.
    """
    out = bytearray(data)
    if suffix == "glb" and rng.random() < 0.6:
        out = bytearray(_json_mutated(data, rng))
        if rng.random() < 0.7:
            return bytes(out)
    if suffix in ("usdz", "zip") and rng.random() < 0.6:
        return _member_mutated(data, rng)
    is_text = suffix in ("obj", "mtl", "dae", "usda", "x3d", "wrl")
    is_text |= suffix in ("ply", "stl", "fbx") and b"\0" not in data
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5, 8))):
        rng.choice((*_BYTES, *(_TEXT * 2 if is_text else ())))(out, suffix, rng)
        if others and rng.random() < 0.05:
            _splice(out, rng.choice(others), rng)
    return bytes(out)


Change = Callable[[bytearray, str, Random], None]


def _place(out: bytearray, rng: Random, length: int = 1) -> int:
    return rng.randrange(max(1, len(out) - length + 1))


def _byte(out: bytearray, _: str, rng: Random) -> None:
    """A bit flipped, or a byte exchanged."""
    if out:
        at = _place(out, rng)
        values = (0, 1, 0x20, 0x7F, 0x80, 0xFE, 0xFF, 0x0A)
        out[at] = rng.choice(values) if rng.random() < 0.5 else out[at] ^ 1 << rng.randrange(8)


def _whole(out: bytearray, _: str, rng: Random) -> None:
    width, code = rng.choice(((1, "B"), (2, "H"), (4, "I")))
    if len(out) >= width:
        at = _place(out, rng, width) // rng.choice((1, width)) * width % max(1, len(out) - width + 1)
        out[at : at + width] = struct.pack(f"<{code}", rng.choice(WHOLE) & (2 ** (8 * width) - 1))


def _real(out: bytearray, _: str, rng: Random) -> None:
    if len(out) >= 4:
        at = _place(out, rng, 4) // 4 * 4
        out[at : at + 4] = struct.pack("<f", rng.choice(REAL))


def _piece(out: bytearray, suffix: str, rng: Random) -> None:
    """A piece cut out, repeated or put in, or the end cut off."""
    at, kind = _place(out, rng), rng.randrange(4)
    if kind == 0:
        del out[at : at + rng.choice((1, 2, 4, 12, 50, 100, 1000, 100_000))]
    elif kind == 1:
        out[at:at] = bytes(out[at : at + rng.choice((1, 4, 12, 50, 200))]) * rng.choice((1, 2, 16, 300))
    elif kind == 2:
        out[at:at] = rng.choice((*WORDS.get(suffix, WORDS["zip"]), rng.randbytes(rng.choice((1, 4, 16, 64)))))
    else:
        del out[at:]


def _number(out: bytearray, _: str, rng: Random) -> None:
    found = list(re.finditer(rb"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?", out))
    if found:
        spot = rng.choice(found)
        out[spot.start() : spot.end()] = rng.choice(NUMBERS).encode()


def _line(out: bytearray, suffix: str, rng: Random) -> None:
    lines = bytes(out).split(b"\n")
    at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(5)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 2:
        lines[at:at] = [lines[other]] * rng.choice((1, 10, 1000))
    elif kind == 3:
        lines[at:at] = [rng.choice(WORDS.get(suffix, WORDS["zip"]))]
    else:
        lines[at] = lines[at] + b" " + lines[other]
    out[:] = b"\n".join(lines)


def _tag(out: bytearray, _: str, rng: Random) -> None:
    found = list(re.finditer(rb"<[^<>]{1,200}>|\"[^\"]{0,60}\"", out))
    if found:
        one, two = rng.choice(found), rng.choice(found)
        out[one.start() : one.end()] = two.group() if rng.random() < 0.7 else b""


def _splice(out: bytearray, other: bytes, rng: Random) -> None:
    start = rng.randrange(max(1, len(other)))
    out[_place(out, rng) :] = other[start : start + rng.choice((16, 200, 5000))]


_BYTES: tuple[Change, ...] = (*(_byte, _whole, _real) * 2, *(_piece,) * 4)
_TEXT: tuple[Change, ...] = (_number, _number, _line, _tag)


def _json_mutated(data: bytes, rng: Random) -> bytes:
    """A GLB with one to four values of its JSON changed, its lengths right again."""
    size = struct.unpack_from("<I", data, 12)[0]
    document, rest = json.loads(data[20 : 20 + size]), data[20 + size :]
    for _ in range(rng.choice((1, 1, 2, 4))):
        holders = [h for h in _holders(document) if h]
        if not holders:
            break
        holder = rng.choice(holders)
        key = rng.choice(sorted(holder) if isinstance(holder, dict) else range(len(holder)))
        kind = rng.random()
        if kind < 0.2:
            del holder[key]
        elif kind < 0.3 and isinstance(holder, list):
            holder.extend([holder[key]] * rng.choice((1, 50, 2000)))
        elif kind < 0.45 and isinstance(holder[key], int | float):
            holder[key] = rng.choice((holder[key] + 1, -holder[key], holder[key] * 1000, holder[key] * 1e30))
        else:
            holder[key] = deepcopy(rng.choice(VALUES))
    text = json.dumps(document).encode("utf-8", "surrogatepass")
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + rest
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def _member_mutated(data: bytes, rng: Random) -> bytes:
    """A zip with one of its members mutated, whole again."""
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        members = {info.filename: packed.read(info) for info in packed.infolist()}
    victim = rng.choice(sorted(members))
    members[victim] = mutate(members[victim], victim.rpartition(".")[2].lower(), rng)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as packed:
        for name, content in members.items():
            packed.writestr(zipfile.ZipInfo(name), content)
    return out.getvalue()


def _holders(value: Any) -> list[Any]:
    """All objects and arrays of a document, itself first."""
    found, at = [value], 0
    while at < len(found):
        one = found[at]
        inner = one.values() if isinstance(one, dict) else one
        found.extend(v for v in inner if isinstance(v, dict | list))
        at += 1
    return found
