"""Find coplanar faces of different materials in one place, which would flicker (VIS010)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from casa_assets.checks.asset.applicability import NO_VISUALS, NOT_BUILT, is_from_family, visuals_of
from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.planar import counter_clockwise, signed_area
from casa_assets.model.asset.asset import Asset

# Nearer than this a depth buffer cannot tell two faces of a kitchen apart. Faces that are set back by 0.2 mm pass.
MIN_SEPARATION_M = 0.000199
SAME_DIRECTION = 0.01  # largest distance between the unit normals of coplanar faces
MIN_FACE_M2 = 2e-7
# Faces are binned by normal and by offset. A bin is four times as wide as what may differ, and each is laid out twice,
# shifted: two faces on either side of the edge of one bin then share another. The shifts are chosen so that no common
# direction or length lies on an edge.
BIN_WIDTH, BIN_SHIFTS = 4, (0.137, 0.637)


def coplanar_faces_do_not_overlap(asset: Asset, limit: float) -> Measurement:
    """VIS010: m^2 of the largest coplanar overlap of two meshes with different looks."""
    if not is_from_family(asset):
        return not_applicable(NOT_BUILT)
    if not any(link.visuals for link in asset.links):
        return not_applicable(NO_VISUALS)
    faces = _faces(asset)
    overlaps: dict[tuple[int, int], float] = {}
    for a, b in _candidate_pairs(faces):
        area = _overlap_area(faces.corners[a], faces.corners[b], faces.normals[a])
        if area > 0:
            i, j = sorted((int(faces.visual[a]), int(faces.visual[b])))
            overlaps[i, j] = overlaps.get((i, j), 0.0) + area
    problems = tuple(
        (faces.pointers[i], f"shares {area * 1e6:.1f} mm^2 of surface with {faces.pointers[j]}; set one of them back")
        for (i, j), area in sorted(overlaps.items())
        if area > limit
    )
    return Measurement(max(overlaps.values(), default=0.0), problems)


@dataclass(frozen=True)
class _Faces:
    """All triangles in the asset frame.

    Attributes:
        corners: (F, 3, 3) metres. normals: (F, 3). visual: (F,) number of the visual. look: (F,) number of its
            material, or a number unique to the visual if it has a picture: faces of one look may coincide.
        pointers: of each visual.
    """

    corners: Floats
    normals: Floats
    visual: Ints
    look: Ints
    pointers: list[str]


def _faces(asset: Asset) -> _Faces:
    textured = {m.id for m in asset.materials if m.textures}
    triangles, looks = [], []
    pointers: list[str] = []
    for pointer, link, visual in visuals_of(asset):
        points = asset.asset_from_link(link.name).apply(visual.mesh.vertices)
        triangles.append(points[visual.mesh.faces])
        pointers.append(pointer)
        looks.append(f"{visual.material}/{visual.name}" if visual.material in textured else visual.material)
    corners = np.concatenate(triangles)
    owner = np.repeat(np.arange(len(triangles)), [len(t) for t in triangles])
    points = corners.reshape(-1, 3)
    normals, area = face_normals(points, np.arange(len(points)).reshape(-1, 3))
    keep = area > MIN_FACE_M2
    look = np.unique(looks, return_inverse=True)[1].astype(np.int64)[owner]
    return _Faces(corners[keep], normals[keep], owner[keep], look[keep], pointers)


def _candidate_pairs(faces: _Faces) -> list[tuple[int, int]]:
    """Faces of different looks that lie in one plane, look the same way and whose boxes overlap, each pair once."""
    offset = np.einsum("ij,ij->i", faces.normals, faces.corners[:, 0])
    pairs: set[tuple[int, int]] = set()
    for direction_shift in BIN_SHIFTS:
        direction = np.floor(faces.normals / (BIN_WIDTH * SAME_DIRECTION) + direction_shift)
        for offset_shift in BIN_SHIFTS:
            place = np.floor(offset / (BIN_WIDTH * MIN_SEPARATION_M) + offset_shift)
            for group in _mixed_groups(np.column_stack([direction, place]), faces.look):
                pairs.update(_close_pairs(faces, group))
    return sorted(pairs)


def _mixed_groups(keys: Floats, look: Ints) -> list[Ints]:
    """Numbers of faces by equal keys, of the groups with more than one look."""
    order = np.lexsort(keys.T[::-1])
    starts = np.flatnonzero(np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)]))
    several = np.minimum.reduceat(look[order], starts) != np.maximum.reduceat(look[order], starts)
    ends = np.append(starts[1:], len(order))
    return [np.sort(order[starts[g] : ends[g]]) for g in np.flatnonzero(several)]


def _close_pairs(faces: _Faces, group: Ints) -> Iterator[tuple[int, int]]:
    """Pairs within a group; faces are sorted by their least x, so that only those that follow closely are tried."""
    corners, normals, look = faces.corners[group], faces.normals[group], faces.look[group]
    lower, upper = corners.min(axis=1), corners.max(axis=1) + MIN_SEPARATION_M
    order = np.argsort(lower[:, 0], kind="stable")
    for n, i in enumerate(order):
        rest = order[n + 1 :]
        rest = rest[: int(np.searchsorted(lower[rest, 0], upper[i, 0]))]
        rest = rest[look[rest] != look[i]]
        rest = rest[((lower[rest] <= upper[i]) & (upper[rest] >= lower[i])).all(axis=1)]
        separation = np.abs((corners[rest].mean(axis=1) - corners[i].mean(axis=0)) @ normals[i])
        parallel = np.linalg.norm(normals[rest] - normals[i], axis=1) < SAME_DIRECTION
        for j in rest[(separation < MIN_SEPARATION_M) & parallel]:
            yield (int(min(group[i], group[j])), int(max(group[i], group[j])))


def _overlap_area(first: Floats, second: Floats, normal: Floats) -> float:
    """Area in which two (3, 3) triangles of one plane overlap, m^2. Ref: Sutherland and Hodgman 1974."""
    dropped = int(np.argmax(np.abs(normal)))
    axes = [k for k in range(3) if k != dropped]
    a, b = (counter_clockwise(triangle) for triangle in (first[:, axes], second[:, axes]))
    polygon = list(a)
    for k in range(3):
        start, end = b[k], b[(k + 1) % 3]
        edge = end - start
        clipped = []
        for p, q in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
            inside_p = edge[0] * (p[1] - start[1]) - edge[1] * (p[0] - start[0])
            inside_q = edge[0] * (q[1] - start[1]) - edge[1] * (q[0] - start[0])
            if inside_p >= 0:
                clipped.append(p)
            if (inside_p >= 0) != (inside_q >= 0):
                clipped.append(p + (q - p) * (inside_p / (inside_p - inside_q)))
        polygon = clipped
        if not polygon:
            return 0.0
    return abs(signed_area(np.array(polygon))) / abs(float(normal[dropped])) if len(polygon) > 2 else 0.0
