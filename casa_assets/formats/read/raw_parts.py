"""Polygons -> triangles, and the arrays of a reader -> RawParts: finite, within bounds, without unused vertices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints, about_axis
from casa_assets.errors import Rejected
from casa_assets.formats.read.text import Notes, UniqueNames
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel, RawPart, Up

if TYPE_CHECKING:
    from casa_assets.formats.read.formats import Format

Bytes = npt.NDArray[np.uint8]

# Larger coordinates are faults of the file: in no unit is a kitchen object 1e12 long.
MAX_COORDINATE = 1e12
MAX_UV = 1e6
SHORT_NORMAL = 1e-6
# Scans have a few zero normals at slivers; if more than this share is bad, all normals are dropped.
MAX_BAD_NORMALS = 0.1
# Step of single precision, as a share of the size, from which on a surface is visibly torn; a choice.
COARSE_STEP_RATIO = 2e-3


@dataclass
class ReadPart:
    """One mesh with one material, as read.

    Attributes:
        name: as the file has it.
        vertices: (V, 3) float64, file units and axes.
        faces: (F, 3) int64, within range of `vertices`.
        material: what it looks like.
        uv: (V, 2), origin at the lower left, or None.
        normals: (V, 3), any length, or None.
        colors: (V, 4) uint8 sRGB, or None.
        nodes, copy_number: see RawPart.
    """

    name: str
    vertices: Floats
    faces: Ints
    material: Material
    uv: Floats | None = None
    normals: Floats | None = None
    colors: Bytes | None = None
    nodes: tuple[str, ...] = ()
    copy_number: int = 0


def rgba(values: Floats) -> Bytes:
    """(N, 4) bytes of (N, 3) or (N, 4) display values in 0..255; opaque where they have no alpha."""
    out = np.full((len(values), 4), 255, dtype=np.uint8)
    out[:, : values.shape[1]] = np.rint(np.clip(values, 0.0, 255.0)).astype(np.uint8)
    return out


def check_face_count(count: int, limits: Mapping[str, float], name: str) -> None:
    """Raises Rejected TOO_LARGE where a file has more triangles than `input_faces`."""
    max_faces = limits["input_faces"]
    if count > max_faces:
        message = f"{name}: {count} triangles, more than {max_faces:.0f}; simplify the mesh first or raise --max-faces"
        raise Rejected(codes.TOO_LARGE, message)


def raw_model(
    read_parts: Sequence[ReadPart],
    notes: Notes,
    name: str,
    file_format: Format,
    metres_per_unit: float | None = None,
    up: Up | None = None,
    joints: int = 0,
    instances: int = 0,
) -> RawModel:
    """Build the RawModel of all read parts that hold a usable triangle.

    Raises:
        Rejected: NO_GEOMETRY, NO_FACES, or NON_FINITE where most faces use NaN, infinite or absurd vertices.
    """
    names = UniqueNames()
    parts: list[RawPart] = []
    total = dropped = 0
    for part in read_parts:
        # all three vertices of a face are finite and near enough to be meant
        with np.errstate(invalid="ignore"):
            is_near = np.asarray((np.abs(part.vertices) < MAX_COORDINATE).all(axis=1))
        is_usable = np.asarray(is_near[part.faces].all(axis=1)) if len(part.faces) else np.zeros(0, dtype=bool)
        total += len(is_usable)
        lost = int(len(is_usable) - is_usable.sum())
        dropped += lost
        if lost:
            notes.add(codes.FACE_DROPPED, part.name, f"{lost} faces with NaN or infinite vertices were dropped")
        if is_usable.any():
            parts.append(_part(part, is_usable, names, notes))
    if dropped * 2 > total:
        message = f"{name}: {dropped} of {total} faces use NaN or infinite vertices; export it again"
        raise Rejected(codes.NON_FINITE, message)
    if not parts:
        vertices = sum(len(d.vertices) for d in read_parts)
        if vertices:
            raise Rejected(codes.NO_FACES, f"{name}: {vertices} vertices but no triangle; export a surface mesh")
        raise Rejected(codes.NO_GEOMETRY, f"{name}: holds no mesh; export the object itself")
    # lies so far from the origin that single precision is coarse, and was stored in it
    lower = np.min([part.mesh.vertices.min(axis=0) for part in parts], axis=0)
    upper = np.max([part.mesh.vertices.max(axis=0) for part in parts], axis=0)
    extent, reach = float((upper - lower).max()), float(max(np.abs(lower).max(), np.abs(upper).max()))
    step = float(np.spacing(np.float32(reach)))
    if step > COARSE_STEP_RATIO * extent > 0.0 and all(
        np.array_equal(p.mesh.vertices, p.mesh.vertices.astype(np.float32)) for p in parts
    ):
        message = (
            f"it lies {reach:.3g} units off the origin, where coordinates come in steps of {step / extent:.1%} of it"
        )
        notes.add(codes.PRECISION_LOST, "vertices", message)
    return RawModel(
        parts=tuple(parts),
        metres_per_unit=metres_per_unit,
        up=up,
        format=file_format.value,
        joints=joints,
        instances=instances,
    )


def _part(part: ReadPart, is_usable: npt.NDArray[np.bool_], names: UniqueNames, notes: Notes) -> RawPart:
    faces = part.faces if is_usable.all() else part.faces[is_usable]
    used, compact = used_vertices(faces, len(part.vertices))
    uv = None if part.uv is None else part.uv[used]
    if uv is not None:
        with np.errstate(invalid="ignore"):
            is_finite = np.asarray((np.abs(uv) < MAX_UV).all(axis=1))
        if not is_finite.all():
            message = f"{int((~is_finite).sum())} texture coordinates are NaN or absurd; set to 0"
            notes.add(codes.BAD_UV, part.name, message)
            uv = np.where(is_finite[:, None], uv, 0.0)
    normals = None
    if part.normals is not None:
        normals = _unit(part.normals[used], part.vertices[used], compact, part.name, notes)
    colors = None if part.colors is None else part.colors[used]
    mesh = Mesh(vertices=part.vertices[used], faces=compact, uv=uv, normals=normals, colors=colors)
    material = part.material
    if uv is None and material.textures:
        message = (
            f"material {material.id} has a texture but the mesh has no texture coordinates; its plain colour is used"
        )
        notes.add(codes.TEXTURE_WITHOUT_UV, part.name, message)
        material = material.replace(base_color_texture=None, metallic_roughness_texture=None, normal_texture=None)
    return RawPart(
        name=names.unique(part.name, "part"),
        mesh=mesh,
        material=material,
        nodes=part.nodes,
        copy_number=part.copy_number,
    )


def used_vertices(faces: Ints, count: int) -> tuple[Ints, Ints]:
    """Vertices that faces use, sorted, and the faces renumbered over them: (U,) and (F, 3)."""
    if faces.size * 4 < count:
        used, inverse = np.unique(faces, return_inverse=True)
        return used, inverse.reshape(faces.shape)
    mask = np.zeros(count, dtype=bool)
    mask[faces.reshape(-1)] = True
    used = np.flatnonzero(mask).astype(np.int64)
    place = np.zeros(count, dtype=np.int64)
    place[used] = np.arange(len(used))
    return used, place[faces]


def _unit(normals: Floats, vertices: Floats, faces: Ints, name: str, notes: Notes) -> Floats | None:
    """(V, 3) unit normals; a few bad ones are replaced. None if many are bad, so that all are recomputed later."""
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.linalg.norm(normals, axis=1)
        is_bad = np.asarray(~(np.isfinite(length) & (length > SHORT_NORMAL)))
    if not is_bad.any():
        return np.asarray(normals / length[:, None])
    if is_bad.mean() > MAX_BAD_NORMALS:
        notes.add(codes.BAD_NORMALS, name, f"{int(is_bad.sum())} normals are zero or NaN; all are computed anew")
        return None
    notes.add(codes.BAD_NORMALS, name, f"{int(is_bad.sum())} normals are zero or NaN; those are replaced")
    with np.errstate(invalid="ignore", over="ignore"):
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        area = np.cross(b - a, c - a)
    around = np.zeros_like(vertices)  # sums of the area vectors of the faces around each vertex
    for i in range(3):
        np.add.at(around, faces[:, i], area)
    repaired = np.where(is_bad[:, None], around, normals)
    repaired_length = np.linalg.norm(repaired, axis=1)
    is_zero = ~(np.isfinite(repaired_length) & (repaired_length > 0.0))
    repaired[is_zero], repaired_length[is_zero] = (0.0, 0.0, 1.0), 1.0
    return np.asarray(repaired / repaired_length[:, None])


def transformed(vertices: Floats, normals: Floats | None, matrix: Floats) -> tuple[Floats, Floats | None, bool]:
    """Vertices and normals moved by a (4, 4) matrix, and whether it mirrors (faces must then be turned)."""
    with np.errstate(invalid="ignore", over="ignore"):
        m = matrix[:3, :3]
        moved = vertices @ m.T + matrix[:3, 3]
        determinant = float(np.linalg.det(m))
        if normals is None or not np.isfinite(determinant) or determinant == 0.0:
            return moved, None, determinant < 0.0
        # cofactors, not the inverse: they carry normals through shear and the tiniest scales alike
        cofactors = np.array([np.cross(m[1], m[2]), np.cross(m[2], m[0]), np.cross(m[0], m[1])])
        cofactors = cofactors / np.abs(cofactors).max() * np.sign(determinant)
        return moved, normals @ cofactors.T, determinant < 0.0


def turn(axis: Floats, angle: float) -> Floats:
    """(3, 3) rotation about an axis of any length, angle in rad; identity if the length is zero, huge or not finite."""
    length = float(np.linalg.norm(axis))
    return about_axis(axis / length, angle) if 1e-12 < length < 1e12 and math.isfinite(angle) else np.eye(3)


def merged_corners(columns: Sequence[Ints]) -> tuple[Ints, Ints]:
    """Corners that agree in all index columns become one vertex.

    Args:
        columns: each (C,) int64 >= -1, C corners in threes.
    Returns:
        (U,) a corner of each vertex, and (C/3, 3) faces over them.
    """
    key = columns[0]
    for column in columns[1:]:
        pairs = key * (int(column.max()) + 2) + column + 1
        key = np.unique(pairs, return_inverse=True)[1].reshape(-1)
    _, first, faces = np.unique(key, return_index=True, return_inverse=True)
    return first, faces.reshape(-1, 3).astype(np.int64)


# Ear clipping costs the square of the corners; beyond this a fan has to do.
MAX_CLIPPED_CORNERS = 3000
# Corners looked at for all polygons of one call, some 15 s of work; honest files stay a hundred times below.
MAX_TESTS = 300_000


def triangulate(points: Floats) -> tuple[Ints, Ints, int]:
    """Triangles of many polygons with the same number of corners.

    Args:
        points: (P, n, 3) corners in order, n >= 3, any unit.
    Returns:
        (T, 3) corner numbers in 0..n-1, (T,) polygon of each triangle in order, and the count of concave polygons that
        could only be cut as a fan.
    """
    count, corners = points.shape[:2]
    if corners == 3:
        return np.tile(np.arange(3), (count, 1)), np.arange(count), 0
    if corners == 4:
        # along the diagonal 0-2, or 1-3 where that would fold the quad over
        with np.errstate(invalid="ignore", over="ignore"):
            a = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
            b = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 0])
            folds = (a * b).sum(axis=1) < 0.0
        halves = np.where(folds[:, None, None], [[0, 1, 3], [1, 2, 3]], [[0, 1, 2], [0, 2, 3]])
        return halves.reshape(-1, 3), np.repeat(np.arange(count), 2), 0
    concave = np.flatnonzero(~_is_convex(points))
    pieces = np.tile(fan(corners), (count, 1, 1))
    fanned, left = 0, MAX_TESTS
    for p in concave:
        ears, tests = _clip(points[p], left)
        left -= tests
        if ears is None:
            fanned += 1
        else:
            pieces[p] = ears
    return pieces.reshape(-1, 3), np.repeat(np.arange(count), corners - 2), fanned


def _area_vectors(points: Floats) -> Floats:
    """(P, 3) normals of polygons, twice their area long (Newell)."""
    return np.asarray(np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1))


def _is_convex(points: Floats) -> npt.NDArray[np.bool_]:
    """(P,) whether all corners of a polygon turn the same way; True if that cannot be determined."""
    with np.errstate(invalid="ignore", over="ignore"):
        local = points - points[:, :1]
        normal = _area_vectors(local)
        edge = np.roll(local, -1, axis=1) - local
        turn = np.cross(edge, np.roll(edge, -1, axis=1))
        along = (turn * normal[:, None, :]).sum(axis=2)
        slack = 1e-9 * np.abs(along).max(axis=1, keepdims=True)
        return np.asarray(~(along < -slack).any(axis=1))


def _clip(points: Floats, most_tests: int) -> tuple[Ints | None, int]:
    """(n-2, 3) triangles of one concave polygon by ear clipping, or None if it crosses itself or takes too long.

    Returns:
        The triangles, and how many corners were tested for being ears.
    """
    n = len(points)
    if n > MAX_CLIPPED_CORNERS or not np.isfinite(points).all():
        return None, 0
    points = points - points[0]
    normal = _area_vectors(points[None])[0]
    axis = int(np.argmax(np.abs(normal)))
    flat = points[:, ((1, 2), (2, 0), (0, 1))[axis]]  # in the plane of the polygon, counter-clockwise
    flat = flat if normal[axis] > 0 else flat * np.array([1.0, -1.0])
    left = list(range(n))
    triangles: list[tuple[int, int, int]] = []
    at, misses, tests = 0, 0, 0
    while len(left) > 3:
        tests += 1
        size = len(left)
        i, j, k = left[(at - 1) % size], left[at % size], left[(at + 1) % size]
        if _is_ear(flat, i, j, k, left):
            triangles.append((i, j, k))
            del left[at % size]
            at, misses = at % size, 0
        else:
            at, misses = at + 1, misses + 1
            if misses > size or tests > most_tests:
                return None, tests
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64), tests


def _is_ear(flat: Floats, i: int, j: int, k: int, left: list[int]) -> bool:
    a, b, c = flat[i], flat[j], flat[k]
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area < 0.0:
        return False
    others = flat[left]
    inside = np.ones(len(left), dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (q[0] - p[0]) * (others[:, 1] - p[1]) - (q[1] - p[1]) * (others[:, 0] - p[0]) > 0.0
    return not inside.any()


def cut_polygons(
    points: Floats, corners: Ints, counts: Ints, limits: Mapping[str, float], notes: Notes, name: str
) -> tuple[Ints, Ints]:
    """Triangles of polygons; those with fewer than three corners or with points that do not exist are dropped.

    Args:
        points: (P, 3), any unit.
        corners: (C,) point of each corner, polygon after polygon.
        counts: (N,) corners of each polygon; where they claim more corners than there are, the last ones are dropped.
    Returns:
        (T, 3) places in `corners`, and (T,) polygon of each triangle, ascending.
    Raises:
        Rejected: TOO_LARGE.
    """
    counts = np.clip(counts, 0, len(corners) + 1)
    starts = np.concatenate(([0], np.cumsum(counts)))[:-1]
    is_whole = (counts >= 3) & (starts + counts <= len(corners))
    check_face_count(int((counts[is_whole] - 2).sum()), limits, name)
    is_bad = np.concatenate(([0], np.cumsum((corners < 0) | (corners >= len(points)))))
    is_whole[is_whole] = is_bad[(starts + counts)[is_whole]] == is_bad[starts[is_whole]]
    dropped = int((~is_whole).sum())
    if dropped:
        message = f"{dropped} faces with fewer than three corners or missing vertices were dropped"
        notes.add(codes.FACE_DROPPED, name, message)
    places, owner, fanned = cut_whole(points, corners, starts, counts, is_whole)
    if fanned:
        message = f"{fanned} concave or crossed faces were cut as fans; triangulate them first"
        notes.add(codes.POLYGON_FAN, name, message)
    return places, owner


def cut_whole(
    points: Floats, corners: Ints, starts: Ints, counts: Ints, is_whole: npt.NDArray[np.bool_]
) -> tuple[Ints, Ints, int]:
    """Triangles of the polygons that are whole, in the order of the polygons.

    Args:
        starts: (N,) place of the first corner of each polygon in `corners`; the others as for `cut_polygons`.
        is_whole: (N,) whether a polygon has three corners or more, all of which exist.
    Returns:
        (T, 3) places in `corners`, (T,) polygon of each triangle, and how many could only be cut as a fan.
    """
    places: list[Ints] = [np.zeros((0, 3), dtype=np.int64)]
    owners: list[Ints] = [np.zeros(0, dtype=np.int64)]
    fanned = 0
    for size in np.unique(counts[is_whole]):
        chosen = np.flatnonzero(is_whole & (counts == size))
        at = starts[chosen][:, None] + np.arange(size)
        local, polygon, fans = triangulate(points[corners[at]])
        fanned += fans
        places.append(at[polygon[:, None], local])
        owners.append(chosen[polygon])
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(places)[order], owner[order], fanned


def strip(count: int) -> Ints:
    """(T, 3) corners of the triangles of a strip, every second one turned, so that all face the same way."""
    i = np.arange(max(0, count - 2))
    odd = i % 2
    return np.column_stack((i + odd, i + 1 - odd, i + 2))


def fan(count: int) -> Ints:
    """(T, 3) corners of the triangles around the first corner."""
    i = np.arange(max(0, count - 2))
    return np.column_stack((np.zeros_like(i), i + 1, i + 2))


def part_of_corners(
    name: str,
    points: Floats,
    corners: Ints,
    triangles: Ints,
    material: Material,
    uv: Floats | None = None,
    normals: Floats | None = None,
    colors: Bytes | None = None,
) -> ReadPart:
    """ReadPart of triangles whose texture coordinates, normals and colours are given per corner.

    Args:
        points: (P, 3). corners: (C,) point of each corner. triangles: (T, 3) places in `corners`.
        uv, normals, colors: (C, 2), (C, 3), (C, 4) uint8, or None.
    """
    picked = triangles.reshape(-1)
    extra = [values[picked] for values in (uv, normals, colors) if values is not None]
    if not len(picked) or not extra:
        return ReadPart(name, points, corners[triangles], material)
    columns = [corners[picked]]
    for values in extra:  # the same number for equal rows, by their bits, so that NaN equals itself
        rows = np.ascontiguousarray(values)
        whole = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).reshape(-1)
        columns.append(np.unique(whole, return_inverse=True)[1].reshape(-1).astype(np.int64))
    first, faces = merged_corners(columns)
    chosen = picked[first]
    return ReadPart(
        name=name,
        vertices=points[corners[chosen]],
        faces=faces,
        material=material,
        uv=None if uv is None else uv[chosen],
        normals=None if normals is None else normals[chosen],
        colors=None if colors is None else colors[chosen],
    )
