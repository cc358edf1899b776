"""Wavefront OBJ text -> tables of numbers and buckets of faces; one pass, numbers parsed by numpy."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.text import decode

# Statements that run or include something. Ref: Wavefront OBJ specification, "general statements"
_DIRECTIVES = frozenset({b"call", b"csh", b"shadow_obj", b"trace_obj", b"ctech", b"stech"})
MAX_GROUPS_AS_OBJECTS = 64
_WHOLE = re.compile(rb"[+-]?\d{1,15}")


@dataclass
class FaceBucket:
    """Faces with the same number of corners, written in the same form.

    Attributes:
        corners: n of each face.
        form: `v`, `vt`, `vn` or `vtn`: which indices each corner has.
        text: `1/2/3 4/5/6 ...` of each face.
        order: place of each face among all.
        group: number of (object, material) of each face.
        seen: count of v, vt, vn read before each face, only where an index is negative.
    """

    corners: int
    form: str
    text: list[bytes] = field(default_factory=list)
    order: list[int] = field(default_factory=list)
    group: list[int] = field(default_factory=list)
    seen: list[tuple[int, int, int]] = field(default_factory=list)


@dataclass
class ObjLines:
    """All statements of an OBJ that matter.

    Attributes:
        v, vt, vn: the numbers of each line, as text.
        faces: buckets by (corners, form, whether negative).
        groups: (object, material) in order of first use.
        libraries: mtllib arguments as written.
        bad_faces: lines that name no triangle.
        primitives: count of `l` and `p` lines.
    """

    v: list[bytes] = field(default_factory=list)
    vt: list[bytes] = field(default_factory=list)
    vn: list[bytes] = field(default_factory=list)
    faces: dict[tuple[int, str, bool], FaceBucket] = field(default_factory=dict)
    groups: list[tuple[str, str]] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    bad_faces: int = 0
    face_count: int = 0


def read_lines(data: bytes, notes: Notes) -> ObjLines:
    """Sort the lines of a plain OBJ text (see text.plain)."""
    if b"\\\n" in data:
        data = data.replace(b"\\\n", b" ")
    use_groups = _groups_are_objects(data)
    out = ObjLines()
    tables = {b"v": out.v, b"vt": out.vt, b"vn": out.vn}
    known: dict[tuple[str, str], int] = {}
    thing, material, group = "", "", -1
    for line in data.split(b"\n"):
        words = line.split(None, 1)
        if len(words) < 2:
            out.bad_faces += words == [b"f"]
            continue
        key, rest = words
        table = tables.get(key)
        if table is not None:
            table.append(rest)
        elif key == b"f":
            if group < 0:
                group = known.setdefault((thing, material), len(known))
            _add_face(out, rest, group)
        elif key == b"usemtl":
            material, group = decode(rest).strip(), -1
        elif key == b"o" or (use_groups and key == b"g"):
            thing, group = decode(rest).strip(), -1
        elif key == b"mtllib":
            out.libraries.append(decode(rest).strip())
        elif key in _DIRECTIVES:
            notes.add(codes.DIRECTIVE_IGNORED, "directives", "statements that run or include something are ignored")
    out.groups = list(known)
    return out


def _groups_are_objects(data: bytes) -> bool:
    """Some exporters name their objects by `g`; others write a group for every smooth patch."""
    if data.startswith(b"o ") or b"\no " in data or b"\no\t" in data:
        return False
    names = {line for line in data.split(b"\n") if line.startswith(b"g ")} if data.count(b"\ng ") < 10_000 else set()
    return 0 < len(names) <= MAX_GROUPS_AS_OBJECTS


def _add_face(out: ObjLines, rest: bytes, group: int) -> None:
    if b"#" in rest:
        rest = rest.partition(b"#")[0]
    corners = len(rest.split())
    slashes = rest.count(b"/")
    if corners < 3:
        out.bad_faces += 1
        return
    if slashes == 0:
        form = "v"
    elif slashes == corners:
        form = "vt"
    elif slashes == 2 * corners:
        form = "vn" if rest.count(b"//") == corners else "vtn"
    else:
        form = "mixed"
    if form == "mixed" or (form == "vtn" and b"//" in rest) or b"/ " in rest or rest.rstrip().endswith(b"/"):
        # rare: only the vertex of each corner is kept
        rest, form = b" ".join(word.partition(b"/")[0] for word in rest.split()), "v"
    is_negative = b"-" in rest
    bucket = out.faces.get((corners, form, is_negative))
    if bucket is None:
        bucket = out.faces.setdefault((corners, form, is_negative), FaceBucket(corners, form))
    bucket.text.append(rest)
    bucket.order.append(out.face_count)
    bucket.group.append(group)
    if is_negative:
        bucket.seen.append((len(out.v), len(out.vt), len(out.vn)))
    out.face_count += 1


def numbers(lines: list[bytes], min_columns: int, max_columns: int, keyword: str) -> Floats:
    """(N, most) float64; columns that a line does not have are NaN.

    Raises:
        Rejected: BAD_NUMBER with the first bad line.
    """
    counts = np.fromiter((len(line.split()) for line in lines), dtype=np.int64, count=len(lines))
    flat = parsed_numbers(b" ".join(lines))
    if flat is None or len(flat) != int(counts.sum()) or (len(counts) and int(counts.min()) < min_columns):
        return _slow_numbers(lines, min_columns, max_columns, keyword)
    if len(counts) and int(counts.min()) == int(counts.max()):
        table = flat.reshape(len(lines), -1)[:, :max_columns]
        pad = max_columns - table.shape[1]
        return table if not pad else np.hstack((table, np.full((len(lines), pad), np.nan)))
    out = np.full((len(lines), max_columns), np.nan)
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])) if len(counts) else np.zeros(0, dtype=np.int64)
    for column in range(max_columns):
        rows = np.flatnonzero(counts > column)
        out[rows, column] = flat[starts[rows] + column]
    return out


def _slow_numbers(lines: list[bytes], min_columns: int, max_columns: int, keyword: str) -> Floats:
    out = np.full((len(lines), max_columns), np.nan)
    for i, line in enumerate(lines):
        words = line.partition(b"#")[0].split()[:max_columns]
        try:
            values = [float(word) for word in words]
        except ValueError as error:
            message = f"`{keyword} {printable(decode(line), 60)}` (number {i + 1} of its kind) is not a row of numbers"
            raise Rejected(codes.BAD_NUMBER, message + "; export with decimal points") from error
        if len(values) < min_columns:
            message = f"`{keyword} {printable(decode(line), 60)}`: {min_columns} numbers wanted; export it again"
            raise Rejected(codes.BAD_NUMBER, message)
        out[i, : len(values)] = values
    return out


def corner_indices(bucket: FaceBucket) -> Ints:
    """(F, n, k) indices as written, k as the form has; a face that cannot be parsed is all 0, which no vertex is."""
    kinds = len(bucket.form)
    joined = b" ".join(bucket.text).replace(b"/", b" ")
    values = parsed_numbers(joined)
    wanted = len(bucket.text) * bucket.corners * kinds
    if values is not None and len(values) == wanted:
        integers = np.clip(np.nan_to_num(values), -1e15, 1e15)
        return np.where(integers == np.floor(integers), integers, 0).astype(np.int64).reshape(-1, bucket.corners, kinds)
    out = np.zeros((len(bucket.text), bucket.corners, kinds), dtype=np.int64)
    for i, text in enumerate(bucket.text):
        words = text.replace(b"/", b" ").split()
        if len(words) == bucket.corners * kinds and all(_WHOLE.fullmatch(w) for w in words):
            out[i] = np.array([int(w) for w in words]).reshape(bucket.corners, kinds)
    return out


def parsed_numbers(text: bytes) -> Floats | None:
    """All numbers of a text, or None where something in it is not a number."""
    if not text.strip():
        return np.zeros(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text.decode("ascii"), dtype=np.float64, sep=" ")
        except (ValueError, DeprecationWarning):
            return None
