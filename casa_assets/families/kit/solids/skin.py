"""Turn a solid into a mesh with normals, and texture coordinates at true size."""

from __future__ import annotations

import zlib

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.normals import with_normals
from casa_assets.geometry.mesh.topology import merge_rows
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.record import Vec2, Vec3

# Directions of faces that differ by less are laid flat together, so that a picture runs on from one to the next.
SAME_DIRECTION = 1e-3


def solid_mesh(solid: Solid, tile_m: Vec2 | None, grain: Vec3 = (0.0, 0.0, 1.0), name: str = "") -> Mesh:
    """Return the mesh of a solid.

    Args:
        solid: to be drawn.
        tile_m: size of the picture on it that repeats, or None: then the mesh has the coordinates of a picture that is
            made for the whole of it, where the solid has some, else none.
        grain: direction that the picture's height runs along, frame of the solid.
        name: of the part; parts of different names show different cuts of the picture.
    Returns:
        Vertices as float32 holds them, unit normals, uv in pictures (metres over `tile_m`).
    """
    points, faces = _single(solid.points), solid.faces
    _, areas = face_normals(points, faces)
    keep = areas > 1e-14
    faces = faces[keep]
    if tile_m is None and solid.picture_uv is None:
        return _rounded(with_normals(Mesh(vertices=points, faces=faces), solid.crease_deg))
    if tile_m is None:
        assert solid.picture_uv is not None
        return _with_uv(points, faces, solid.picture_uv[keep], solid.crease_deg)
    uv_m = solid.uv_m[keep] if solid.uv_m is not None else flat_uv(points, faces, np.array(grain))
    uv = (uv_m + uv_offset(name)) / np.array(tile_m)
    # Whole pictures may be taken off: the numbers stay small, and float32 keeps its digits.
    uv -= np.floor(uv.reshape(-1, 2).min(axis=0))
    return _with_uv(points, faces, uv, solid.crease_deg)


def _with_uv(points: Floats, faces: Ints, uv: Floats, crease_deg: float) -> Mesh:
    """The mesh whose corners have some texture coordinates; corners that agree are one vertex."""
    corners = np.column_stack([faces.ravel(), np.round(uv.reshape(-1, 2), 7)])
    first, index = merge_rows(corners)
    mesh = Mesh(vertices=points[faces.ravel()[first]], faces=index.reshape(-1, 3), uv=uv.reshape(-1, 2)[first])
    return _rounded(with_normals(mesh, crease_deg))


def flat_uv(points: Floats, faces: Ints, grain: Floats) -> Floats:
    """(F, 3, 2) metres: each face laid flat without stretch, v along the grain where the face allows it."""
    normals, _ = face_normals(points, faces)
    # One frame for each direction, so that neighbours in a plane agree to the last digit.
    key = np.round(normals / SAME_DIRECTION).astype(np.int64)
    first, group = merge_rows(key.astype(np.float64))
    n = normals[first]
    along = grain - (n @ grain)[:, None] * n
    length = np.linalg.norm(along, axis=1)
    # End grain: there v points up, or back where the face itself looks up.
    fallback = np.where(np.abs(n[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    fallback = fallback - np.einsum("ij,ij->i", fallback, n)[:, None] * n
    v = np.where(length[:, None] > 0.2, along, fallback)
    v /= np.linalg.norm(v, axis=1)[:, None]
    u = np.cross(v, n)
    corners = points[faces]
    return np.stack([np.einsum("fki,fi->fk", corners, u[group]), np.einsum("fki,fi->fk", corners, v[group])], axis=2)


def uv_offset(name: str) -> Floats:
    """(2,) metres by which a part of that name shifts its picture; the same on every machine."""
    mixed = zlib.crc32(name.encode("ascii"))
    return np.array([(mixed & 0xFFFF) / 0xFFFF * 3.0, (mixed >> 16) / 0xFFFF * 3.0])


def _single(values: Floats) -> Floats:
    return values.astype(np.float32).astype(np.float64)


def _rounded(mesh: Mesh) -> Mesh:
    normals = None if mesh.normals is None else _single(mesh.normals)
    return Mesh(
        vertices=_single(mesh.vertices),
        faces=mesh.faces,
        uv=None if mesh.uv is None else _single(mesh.uv),
        normals=normals,
    )
