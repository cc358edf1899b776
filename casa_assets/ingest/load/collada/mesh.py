"""COLLADA <mesh> -> triangles with their index columns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.collada.guarded_xml import (
    Document,
    Element,
    children,
    count_of,
    find_path,
    floats_of,
    integers_of,
    local_name,
)
from casa_assets.ingest.load.notes import Notes
from casa_assets.ingest.load.raw_parts import merged_corners
from casa_assets.ingest.load.triangulate import triangulate

SURFACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")


@dataclass(frozen=True)
class Primitive:
    """Triangles of one primitive, node frame not yet applied.

    Attributes:
        symbol: material symbol, to be bound by the instance.
        vertices: (V, 3); faces: (F, 3).
        normals: (V, 3) or None; colors: (V, 4) uint8 or None.
        uvs: TEXCOORD set number -> (V, 2), origin at the lower left.
    """

    symbol: str
    vertices: Floats
    faces: Ints
    normals: Floats | None
    colors: npt.NDArray[np.uint8] | None
    uvs: Mapping[int, Floats]


@dataclass(frozen=True)
class _Input:
    semantic: str
    table: Floats
    offset: int
    number: int


def primitives_of(
    document: Document, mesh: Element, notes: Notes, check_count: Callable[[int], None]
) -> list[Primitive]:
    """Every surface primitive of a <mesh>.

    Args:
        check_count: is given the number of triangles so far before more are made, and raises where they are too many.
    Raises:
        Rejected: OUT_OF_BOUNDS where an index is past its source; what `check_count` raises.
    """
    out, count = [], 0
    for primitive in children(mesh, *SURFACES):
        count += _triangle_count(primitive)
        check_count(count)
        read = _piece(document, primitive, notes)
        if read is not None:
            out.append(read)
    return out


def vertex_count(document: Document, mesh: Element) -> int:
    """Number of positions of a <mesh>, whether a face uses them or not."""
    place = next((i for i in children(find_path(mesh, "vertices"), "input") if i.get("semantic") == "POSITION"), None)
    return 0 if place is None else len(_table(document.target(place.get("source"))))


def _triangle_count(primitive: Element) -> int:
    """Most triangles that a primitive can come to, from its own numbers."""
    kind = local_name(primitive)
    if kind == "polylist":
        return int(np.maximum(integers_of(find_path(primitive, "vcount")) - 2, 0).sum())
    stride = (
        max(count_of(i, "offset", 0) for i in children(primitive, "input")) + 1
        if find_path(primitive, "input") is not None
        else 1
    )
    corners = [len(integers_of(p)) // stride for p in children(primitive, "p")]
    return sum(corners) // 3 if kind == "triangles" else sum(max(0, n - 2) for n in corners)


def _piece(document: Document, primitive: Element, notes: Notes) -> Primitive | None:
    inputs = _inputs(document, primitive)
    if not any(i.semantic == "POSITION" for i in inputs):
        return None
    stride = max(count_of(i, "offset", 0) for i in children(primitive, "input")) + 1
    corners, lengths = _corners(primitive, stride, notes)
    if not len(lengths):
        return None
    _check(inputs, corners, primitive)
    position = next(i for i in inputs if i.semantic == "POSITION")
    picks = _triangles(position.table[corners[:, position.offset]], lengths, notes)
    if not len(picks):
        return None
    return _assembled(primitive.get("material", ""), inputs, corners[picks.reshape(-1)])


def _assembled(symbol: str, inputs: list[_Input], corners: Ints) -> Primitive:
    offsets = sorted({i.offset for i in inputs})
    first, faces = merged_corners([corners[:, o] for o in offsets])
    rows = corners[first]
    normals: Floats | None = None
    colors: npt.NDArray[np.uint8] | None = None
    uvs: dict[int, Floats] = {}
    vertices = np.zeros((0, 3))
    for one in inputs:
        values = one.table[rows[:, one.offset]]
        if one.semantic == "POSITION":
            vertices = values
        elif one.semantic == "NORMAL" and values.shape[1] >= 3:
            normals = values[:, :3]
        elif one.semantic == "TEXCOORD" and values.shape[1] >= 2:
            uvs.setdefault(one.number, values[:, :2])
        elif one.semantic == "COLOR" and values.shape[1] >= 3 and np.isfinite(values).all():
            colors = np.full((len(rows), 4), 255, dtype=np.uint8)
            width = min(4, values.shape[1])
            colors[:, :width] = np.rint(np.clip(values[:, :width], 0.0, 1.0) * 255.0).astype(np.uint8)
    return Primitive(symbol, vertices[:, :3], faces, normals, colors, uvs)


def _inputs(document: Document, primitive: Element) -> list[_Input]:
    """Inputs of a primitive; VERTEX is replaced by what its <vertices> holds."""
    out: list[_Input] = []
    for one in children(primitive, "input"):
        offset, number = count_of(one, "offset", 0), count_of(one, "set", 0)
        target = document.target(one.get("source"))
        if one.get("semantic") == "VERTEX":
            for inner in children(target, "input"):
                table = _table(document.target(inner.get("source")))
                out.append(_Input(inner.get("semantic", ""), table, offset, count_of(inner, "set", 0)))
        else:
            out.append(_Input(one.get("semantic", ""), _table(target), offset, number))
    wide = {"POSITION": 3, "NORMAL": 3, "TEXCOORD": 1, "COLOR": 3}
    return [i for i in out if i.semantic in wide and len(i.table) and i.table.shape[1] >= wide[i.semantic]]


def _table(source: Element | None) -> Floats:
    """(N, stride) rows of a <source>; none where it is missing or empty."""
    if source is None:
        return np.zeros((0, 3))
    flat = floats_of(find_path(source, "float_array"))
    accessor = find_path(source, "technique_common", "accessor")
    stride = max(1, count_of(accessor, "stride", 1)) if accessor is not None else 3
    start = count_of(accessor, "offset", 0) if accessor is not None else 0
    rows = flat[start:]
    return rows[: len(rows) // stride * stride].reshape(-1, stride)


def _corners(primitive: Element, stride: int, notes: Notes) -> tuple[Ints, Ints]:
    """(C, stride) index rows of all corners, and the number of corners of each polygon."""
    kind = local_name(primitive)
    lists = [integers_of(p) for p in children(primitive, "p")]
    if kind == "polygons":
        holed = [integers_of(find_path(h, "p")) for h in children(primitive, "ph")]
        if holed:
            notes.add(codes.FEATURE_IGNORED, "polygons", "holes in polygons are filled")
        lists += holed
    rows = [flat[: len(flat) // stride * stride].reshape(-1, stride) for flat in lists]
    if not rows:
        return np.zeros((0, stride), dtype=np.int64), np.zeros(0, dtype=np.int64)
    if kind == "tristrips":
        rows = [r[_strip(len(r))] for r in rows]
    elif kind == "trifans":
        rows = [r[_fan(len(r))] for r in rows]
    whole = np.concatenate(rows)
    if kind == "polygons":
        return whole, np.array([len(r) for r in rows], dtype=np.int64)
    if kind == "polylist":
        lengths = integers_of(find_path(primitive, "vcount"))
        fits = (lengths >= 0) & (np.cumsum(lengths) <= len(whole))
        if not fits.all():
            notes.add(
                codes.FACE_DROPPED,
                "polylist",
                f"{int((~fits).sum())} polygons past the index list were dropped",
            )
            lengths = lengths[: int(np.argmin(fits))]
        return whole[: int(lengths.sum())], lengths
    return whole[: len(whole) // 3 * 3], np.full(len(whole) // 3, 3, dtype=np.int64)


def _strip(count: int) -> Ints:
    i = np.arange(max(0, count - 2))
    odd = i % 2
    return np.column_stack((i + odd, i + 1 - odd, i + 2)).reshape(-1)


def _fan(count: int) -> Ints:
    i = np.arange(max(0, count - 2))
    return np.column_stack((np.zeros_like(i), i + 1, i + 2)).reshape(-1)


def _check(inputs: list[_Input], corners: Ints, primitive: Element) -> None:
    for one in inputs:
        column = corners[:, one.offset]
        if len(column) and not 0 <= int(column.min()) <= int(column.max()) < len(one.table):
            message = (
                f"COLLADA <{local_name(primitive)}>: index {int(column.max())} of {len(one.table)} in {one.semantic}"
            )
            raise Rejected(codes.OUT_OF_BOUNDS, message + "; export the file again")


def _triangles(points: Floats, lengths: Ints, notes: Notes) -> Ints:
    """(T, 3) corner rows of all polygons."""
    starts = np.cumsum(lengths) - lengths
    found: list[tuple[Ints, Ints]] = []
    for corners in np.unique(lengths):
        which = np.flatnonzero(lengths == corners)
        if corners < 3:
            notes.add(
                codes.FACE_DROPPED,
                "polygons",
                f"{len(which)} faces with fewer than three corners were dropped",
            )
            continue
        index = starts[which][:, None] + np.arange(corners)
        local, polygon, fanned = triangulate(points[index][:, :, :3])
        if fanned:
            notes.add(codes.POLYGON_FAN, "polygons", f"{fanned} concave or crossed faces were cut as fans")
        found.append((index[polygon[:, None], local], which[polygon]))
    if not found:
        return np.zeros((0, 3), dtype=np.int64)
    order = np.argsort(np.concatenate([f[1] for f in found]), kind="stable")
    return np.concatenate([f[0] for f in found])[order]
