"""Wavefront OBJ bundle -> RawModel: one part per object and material."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.image import Images
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.raw_parts import ReadPart, check_face_count, merged_corners, raw_model
from casa_assets.ingest.load.text import normalize_text
from casa_assets.ingest.load.triangulate import triangulate
from casa_assets.ingest.load.wavefront.materials import Materials, MtlEntry, parse_mtl
from casa_assets.ingest.load.wavefront.parser import ObjLines, corner_indices, numbers, read_lines
from casa_assets.model.asset.material import Material
from casa_assets.model.ingest.source import Bundle, RawModel


@dataclass(frozen=True)
class _Triangles:
    """Corners of all triangles in file order, 0-based; -1 where a corner has none.

    Attributes:
        v, vt, vn: (T, 3).
        group: (T,) number of (object, material).
    """

    v: Ints
    vt: Ints
    vn: Ints
    group: Ints


def read_obj(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an OBJ; the format declares neither unit nor up axis.

    Raises:
        Rejected: ENCODING, BAD_NUMBER, NO_FACES, OUT_OF_BOUNDS (every face), TOO_LARGE, NON_FINITE, NO_GEOMETRY.
    """
    name = printable(bundle.main)
    lines = read_lines(normalize_text(bundle.files[bundle.main], name), notes)
    if not lines.v and not lines.face_count:
        raise Rejected(codes.EMPTY_FILE, f"{name}: holds neither vertices nor faces; fetch or export it again")
    check_face_count(sum(len(b.text) * (b.corners - 2) for b in lines.faces.values()), limits, name)
    vertices = numbers(lines.v, 3, 7, "v")
    uvs = numbers(lines.vt, 1, 2, "vt")
    normals = numbers(lines.vn, 3, 3, "vn")
    triangles = _triangles(lines, vertices[:, :3], (len(uvs), len(normals)), name, notes)
    check_face_count(len(triangles.v), limits, name)
    if not len(triangles.v):
        bare = ReadPart("part", vertices[:, :3], np.zeros((0, 3), dtype=np.int64), Material(id="none"))
        return raw_model([bare], notes, name, Format.OBJ)
    materials = _materials(bundle, lines, limits, notes)
    colors = _colors(vertices, notes)
    parts = []
    for number, (object_name, material) in enumerate(lines.groups):
        rows = np.flatnonzero(triangles.group == number)
        if len(rows):
            part = _read_part(triangles, rows, vertices[:, :3], uvs, normals, colors)
            part.name, part.material = object_name or material or "part", materials[material]
            part.nodes = (object_name,) if object_name else ()
            parts.append(part)
    return raw_model(parts, notes, name, Format.OBJ)


def _triangles(lines: ObjLines, vertices: Floats, others: tuple[int, int], name: str, notes: Notes) -> _Triangles:
    sizes = (len(vertices), *others)
    found: list[tuple[Ints, Ints, Ints]] = []
    bad = lines.bad_faces
    fanned = 0
    for bucket in lines.faces.values():
        raw = corner_indices(bucket)
        corners = np.full((*raw.shape[:2], 3), -1, dtype=np.int64)
        columns = {"v": (0,), "vt": (0, 1), "vn": (0, 2), "vtn": (0, 1, 2)}[bucket.form]
        seen = np.array(bucket.seen, dtype=np.int64).reshape(-1, 3)
        for k, column in enumerate(columns):
            index = raw[:, :, k]
            corners[:, :, column] = np.where(index < 0, index + seen[:, None, column] if len(seen) else -1, index - 1)
            outside = (corners[:, :, column] < 0) | (corners[:, :, column] >= sizes[column])
            corners[:, :, column][outside] = -1
        good = (corners[:, :, 0] >= 0).all(axis=1)
        bad += int((~good).sum())
        corners = corners[good]
        local, polygon, count = triangulate(vertices[corners[:, :, 0]])
        fanned += count
        tri = corners[polygon[:, None], local]
        order = np.array(bucket.order, dtype=np.int64)[good][polygon]
        group = np.array(bucket.group, dtype=np.int64)[good][polygon]
        found.append((tri, order, group))
    return _gathered(found, bad, fanned, name, notes)


def _gathered(found: list[tuple[Ints, Ints, Ints]], bad: int, fanned: int, name: str, notes: Notes) -> _Triangles:
    count = sum(len(order) for _, order, _ in found)
    if bad and not count:
        message = f"{name}: all {bad} faces name vertices that do not exist; export it again"
        raise Rejected(codes.OUT_OF_BOUNDS, message)
    if bad:
        message = f"{bad} faces with fewer than three corners or missing vertices were dropped"
        notes.add(codes.FACE_DROPPED, "f", message)
    if fanned:
        message = f"{fanned} concave or crossed faces were cut as fans; triangulate them first"
        notes.add(codes.POLYGON_FAN, "f", message)
    if not count:
        none = np.zeros((0, 3), dtype=np.int64)
        return _Triangles(none, none, none, np.zeros(0, dtype=np.int64))
    tri, order, group = (np.concatenate([f[i] for f in found]) for i in range(3))
    sort = np.argsort(order, kind="stable")
    tri = tri[sort]
    return _Triangles(tri[:, :, 0], tri[:, :, 1], tri[:, :, 2], group[sort])


def _read_part(
    triangles: _Triangles,
    rows: Ints,
    vertices: Floats,
    uvs: Floats,
    normals: Floats,
    colors: npt.NDArray[np.uint8] | None,
) -> ReadPart:
    """Corners with the same (v, vt, vn) become one vertex."""
    v, vt, vn = (a[rows].reshape(-1) for a in (triangles.v, triangles.vt, triangles.vn))
    has_uv, has_normals = bool((vt >= 0).any()), bool((vn >= 0).all())
    first, faces = merged_corners([v, *([vt] if has_uv else []), *([vn] if has_normals else [])])
    rough_uv = None
    if has_uv:
        rough_uv = np.where((vt[first] >= 0)[:, None], uvs[vt[first]], 0.0)
    return ReadPart(
        name="",
        vertices=vertices[v[first]],
        faces=faces,
        material=Material(id="none"),
        uv=rough_uv,
        normals=normals[vn[first]] if has_normals else None,
        colors=None if colors is None else colors[v[first]],
    )


def _colors(vertices: Floats, notes: Notes) -> npt.NDArray[np.uint8] | None:
    """(V, 4) sRGB bytes of `v x y z r g b [a]`, in 0..1 or 0..255; None where lines have no colours."""
    if not len(vertices) or np.isnan(vertices[:, 5]).all():
        return None
    rgb = vertices[:, 3:6]
    if not np.isfinite(rgb).all():
        notes.add(codes.BAD_COLOR, "v", "some vertex colours are missing or NaN; all are left out")
        return None
    scale = 255.0 if float(rgb.max()) <= 1.0 else 1.0
    out = np.full((len(rgb), 4), 255, dtype=np.uint8)
    out[:, :3] = np.rint(np.clip(rgb * scale, 0.0, 255.0)).astype(np.uint8)
    return out


def _materials(bundle: Bundle, lines: ObjLines, limits: Mapping[str, float], notes: Notes) -> dict[str, Material]:
    """Material of every name that a group uses."""
    entries: dict[str, MtlEntry] = {}
    for file in _libraries(bundle, lines):
        try:
            entries.update(parse_mtl(bundle.files[file], printable(file), notes))
        except Rejected as error:
            notes.add(codes.MATERIAL_MISSING, file, f"material file left out: {error.message}")
    by_case = {name.lower(): entry for name, entry in entries.items()}
    made = Materials(bundle.files, Images(limits, notes), notes)
    out: dict[str, Material] = {}
    for _, name in lines.groups:
        if name in out:
            continue
        entry = entries.get(name) or by_case.get(name.lower())
        if entry is None and not name and len(entries) == 1:
            entry = next(iter(entries.values()))
        if entry is None and name:
            notes.add(
                codes.MATERIAL_MISSING,
                name,
                f"material {printable(name, 40)!r} is not described; a grey one is used",
            )
        out[name] = made.material(name or "material", entry or MtlEntry())
    return out


def _libraries(bundle: Bundle, lines: ObjLines) -> list[str]:
    """Keys of the bundle that hold this OBJ's materials."""
    out = []
    for library in lines.libraries:
        for file in (library, *library.split()):
            if file in bundle.files and file != bundle.main and file not in out:
                out.append(file)
                if file == library:
                    break
    return out or sorted(f for f in bundle.files if f.lower().endswith(".mtl") and f != bundle.main)
