"""STL, binary or text -> RawModel; one part per `solid` of a text file."""

from __future__ import annotations

import struct
from collections.abc import Mapping

import numpy as np

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, is_binary_stl
from casa_assets.formats.read.raw_parts import ReadPart, check_face_count, raw_model
from casa_assets.formats.read.text import Notes, decode, normalize_text, numbers, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import Material
from casa_assets.model.source import Bundle, RawModel

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def references(data: bytes, name: str) -> list[Reference]:
    """None: an STL refers to no file."""
    return []


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an STL; it declares neither unit nor up axis, and its facet normals are recomputed."""
    name = printable(bundle.main)
    data = bundle.files[bundle.main]
    if data.lstrip()[:5].lower() == b"solid" and not is_binary_stl(data):
        parts = _text(normalize_text(data, name), limits, name)
    else:
        parts = [_binary(data, limits, name)]
    return raw_model(parts, notes, name, Format.STL)


def _binary(data: bytes, limits: Mapping[str, float], name: str) -> ReadPart:
    if len(data) < 84:
        raise Rejected(codes.TRUNCATED, f"{name}: {len(data)} bytes, a binary STL header has 84; fetch it again")
    claimed = int(struct.unpack_from("<I", data, 80)[0])
    present = (len(data) - 84) // 50
    if claimed > present:
        message = f"{name}: says {claimed} triangles, there are bytes for {present}; fetch it again"
        is_cut = claimed <= limits["input_faces"] and claimed <= 16 * max(present, 1)
        raise Rejected(codes.TRUNCATED if is_cut else codes.LENGTH_MISMATCH, message)
    check_face_count(claimed, limits, name)
    table = np.frombuffer(data, dtype=_TRIANGLE, count=claimed, offset=84)
    vertices = table["corners"].reshape(-1, 3).astype(np.float64)
    return ReadPart("solid", vertices, np.arange(len(vertices)).reshape(-1, 3), Material(id="material"))


def _text(data: bytes, limits: Mapping[str, float], name: str) -> list[ReadPart]:
    solids: list[tuple[str, list[bytes]]] = []
    for line in data.split(b"\n"):
        words = line.split(None, 1)
        key = words[0].lower() if words else b""
        if key == b"solid":
            solids.append((decode(words[1]).strip() if len(words) > 1 else "", []))
        elif key == b"vertex" and solids:
            solids[-1][1].append(words[1] if len(words) > 1 else b"")
    check_face_count(sum(len(rows) for _, rows in solids) // 3, limits, name)
    if not any(rows for _, rows in solids):
        raise Rejected(codes.EMPTY_FILE, f"{name}: a solid without a single facet; fetch or export it again")
    if b"endsolid" not in data.rstrip()[-400:].lower():
        raise Rejected(codes.TRUNCATED, f"{name}: the text STL has no `endsolid`; fetch it again")
    out = []
    for title, rows in solids:
        if len(rows) % 3:
            raise Rejected(codes.TRUNCATED, f"{name}: {len(rows)} vertices are not triangles; fetch it again")
        vertices = numbers(rows, 3, 3, "vertex")
        faces = np.arange(len(vertices)).reshape(-1, 3)
        out.append(ReadPart(title or "solid", vertices, faces, Material(id="material")))
    return out
