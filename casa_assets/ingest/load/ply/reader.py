"""PLY bundle -> RawModel: one part, with vertex colours or texture coordinates where it has them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.image import Images, ImageUse
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.ply.table import Table, check_lengths, read_header, read_tables
from casa_assets.ingest.load.raw_parts import ReadPart, check_face_count, raw_model
from casa_assets.ingest.load.triangulate import triangulate
from casa_assets.model.asset.material import Material
from casa_assets.model.ingest.source import Bundle, RawModel

# Names that writers use for texture coordinates of vertices.
_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texcoord_u", "texcoord_v"))
_COLOR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))


def read_ply(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a PLY; the format declares neither unit nor up axis.

    Raises:
        Rejected: BAD_HEADER, TRUNCATED, LENGTH_MISMATCH, BAD_NUMBER, OUT_OF_BOUNDS, NO_FACES, NO_GEOMETRY, NON_FINITE.
    """
    name = printable(bundle.main)
    data = bundle.files[bundle.main].lstrip(b" \t\r\n")
    header = read_header(data, name)
    check_lengths(data, header, name)
    for element in header.elements:
        if element.name == "face":
            check_face_count(element.count, limits, name)
        elif element.name == "vertex":
            check_face_count(element.count // 3, limits, name)
    tables = read_tables(data, header, name)
    vertex = tables.get("vertex")
    if vertex is None or not {"x", "y", "z"} <= vertex.scalars.keys():
        raise Rejected(codes.NO_GEOMETRY, f"{name}: the PLY has no vertices with x, y, z; export it again")
    vertices = _columns(vertex, ("x", "y", "z"))
    check_face_count(_triangle_count(tables.get("face")), limits, name)
    corners, polygons, fanned = _faces(tables.get("face"), vertices, name, notes)
    check_face_count(len(corners), limits, name)
    if fanned:
        notes.add(codes.POLYGON_FAN, "face", f"{fanned} concave or crossed faces were cut as fans")
    part = ReadPart("part", vertices, corners, _material(bundle, header.textures, limits, notes))
    if {"nx", "ny", "nz"} <= vertex.scalars.keys():
        part.normals = _columns(vertex, ("nx", "ny", "nz"))
    part.colors = _colors(vertex, notes)
    part.uv = _vertex_uv(vertex)
    if part.uv is None and len(corners):
        _spread_corner_uv(part, tables["face"], polygons, notes)
    return raw_model([part], notes, name, Format.PLY)


def _columns(table: Table, names: tuple[str, ...]) -> Floats:
    return np.column_stack([table.scalars[n].astype(np.float64) for n in names])


def _corner_column(face: Table | None) -> str | None:
    """Name of the list that holds the corners of faces."""
    return next((n for n in ("vertex_indices", "vertex_index") if face and n in face.lists), None)


def _triangle_count(face: Table | None) -> int:
    """Number of triangles of the faces, before any is made."""
    column = _corner_column(face)
    return 0 if face is None or column is None else int(np.maximum(face.lists[column][1] - 2, 0).sum())


def _faces(face: Table | None, vertices: Floats, name: str, notes: Notes) -> tuple[Ints, Ints, int]:
    """(T, 3) vertices, (T, 4) face and its three corner numbers, and the count of faces cut as fans."""
    none = np.zeros((0, 3), dtype=np.int64), np.zeros((0, 4), dtype=np.int64), 0
    column = _corner_column(face)
    if face is None or column is None:
        return none
    flat, lengths = face.lists[column][0].astype(np.int64), face.lists[column][1]
    if len(flat) and not 0 <= int(flat.min()) <= int(flat.max()) < len(vertices):
        message = f"{name}: a face names vertex {int(flat.max())} of {len(vertices)}; export the file again"
        raise Rejected(codes.OUT_OF_BOUNDS, message)
    starts = np.concatenate((np.zeros(1, dtype=np.int64), np.cumsum(lengths)[:-1])) if len(lengths) else lengths
    found: list[tuple[Ints, Ints]] = []
    fanned = 0
    for corners in np.unique(lengths).tolist():
        rows = np.flatnonzero(lengths == corners)
        if corners < 3:
            notes.add(codes.FACE_DROPPED, "face", f"{len(rows)} faces with fewer than three corners were dropped")
            continue
        index = flat[starts[rows][:, None] + np.arange(corners)]
        local, polygon, count = triangulate(vertices[index])
        fanned += count
        found.append((index[polygon[:, None], local], np.column_stack((rows[polygon], local))))
    if not found:
        return none
    tri, origin = np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])
    sort = np.argsort(origin[:, 0], kind="stable")
    return tri[sort], origin[sort], fanned


def _vertex_uv(vertex: Table) -> Floats | None:
    for pair in _UV_NAMES:
        if set(pair) <= vertex.scalars.keys():
            return _columns(vertex, pair)
    return None


def _spread_corner_uv(part: ReadPart, face: Table, origin: Ints, notes: Notes) -> None:
    """MeshLab keeps texture coordinates per corner: corners with the same vertex and uv become one vertex."""
    if "texcoord" not in face.lists:
        return
    flat, lengths = face.lists["texcoord"]
    starts = np.concatenate((np.zeros(1, dtype=np.int64), np.cumsum(lengths)[:-1]))
    needed = 2 * (int(origin[:, 1:].max()) + 1)
    if int(lengths.min()) < needed and (lengths[origin[:, 0]] < 2 * (origin[:, 1:].max(axis=1) + 1)).any():
        notes.add(codes.BAD_UV, "face/texcoord", "some faces have no texture coordinates; all are left out")
        return
    place = (starts[origin[:, :1]] + 2 * origin[:, 1:]).reshape(-1)
    uv = np.column_stack((flat[place], flat[place + 1])).astype(np.float64)
    corner = part.faces.reshape(-1)
    rows = np.column_stack((corner.astype(np.float64), uv))
    _, first, faces = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    keep = corner[first]
    part.vertices, part.uv, part.faces = part.vertices[keep], uv[first], faces.reshape(-1, 3).astype(np.int64)
    part.normals = None if part.normals is None else part.normals[keep]
    part.colors = None if part.colors is None else part.colors[keep]


def _colors(vertex: Table, notes: Notes) -> npt.NDArray[np.uint8] | None:
    """(V, 4) sRGB bytes: integer columns are 0..255, float columns 0..1."""
    names = next((n for n in _COLOR_NAMES if set(n) <= vertex.scalars.keys()), None)
    if names is None:
        return None
    scale = 1.0 if vertex.scalars[names[0]].dtype.kind in "iu" else 255.0
    values = _columns(vertex, names) * scale
    if not np.isfinite(values).all():
        notes.add(codes.BAD_COLOR, "vertex", "vertex colours hold NaN; left out")
        return None
    out = np.full((len(values), 4), 255, dtype=np.uint8)
    out[:, :3] = np.rint(np.clip(values, 0.0, 255.0)).astype(np.uint8)
    return out


def _material(bundle: Bundle, textures: list[str], limits: Mapping[str, float], notes: Notes) -> Material:
    """White where a picture or vertex colours give the colour; the picture is the first `comment TextureFile`."""
    if len(textures) > 1:
        notes.add(codes.FEATURE_IGNORED, "header", f"{len(textures)} texture files; only the first is used")
    texture = None
    if textures and textures[0] in bundle.files:
        texture = Images(limits, notes).texture(textures[0], bundle.files[textures[0]], "color", ImageUse())
    if texture is None:
        return Material(id="material")
    return Material(id="material", base_color=(1.0, 1.0, 1.0, 1.0), base_color_texture=texture)
