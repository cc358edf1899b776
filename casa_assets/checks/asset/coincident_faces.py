"""Find coplanar faces of different materials in one place, which would flicker (VIS010)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from casa_assets.checks.asset.built import NOT_BUILT, UNSEEN, is_from_family
from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.model.asset.asset import Asset

# Nearer than this a depth buffer cannot tell two faces of a kitchen apart; what is set back by 0.2 mm is told apart.
APART_M = 0.000199
SAME_DIRECTION = 0.01  # rad
LEAST_FACE_M2 = 2e-7
# Faces are sorted into bins of four times what they may differ by, twice for direction and twice for place, so that
# faces on two sides of an edge of one bin share another. No common direction or length lies on an edge.
BIN, SHIFTS = 4, (0.137, 0.637)


def coplanar_faces_do_not_overlap(asset: Asset, limit: float | None) -> Measurement:
    """VIS010: m^2 of the largest coplanar overlap of two meshes with different looks."""
    assert limit is not None
    if not is_from_family(asset):
        return not_applicable(NOT_BUILT)
    if not any(link.visuals for link in asset.links):
        return not_applicable(UNSEEN)
    faces = _faces(asset)
    found: dict[tuple[int, int], float] = {}
    for a, b in _pairs(faces):
        area = _overlap(faces.corners[a], faces.corners[b], faces.normals[a])
        if area > 0:
            i, j = sorted((int(faces.owner[a]), int(faces.owner[b])))
            found[i, j] = found.get((i, j), 0.0) + area
    problems = tuple(
        (faces.names[i], f"shares {area * 1e6:.1f} mm^2 of surface with {faces.names[j]}; set one of them back")
        for (i, j), area in sorted(found.items())
        if area > limit
    )
    return Measurement(max(found.values(), default=0.0), problems)


@dataclass(frozen=True)
class _Faces:
    """All triangles in the asset frame.

    Attributes:
        corners: (F, 3, 3) metres. normals: (F, 3). owner: (F,) number of the visual. look: (F,) what tells it from
            others that lie in the same place: its material, or itself where a picture is on it.
        names: pointer of each visual.
    """

    corners: Floats
    normals: Floats
    owner: Ints
    look: Ints
    names: list[str]


def _faces(asset: Asset) -> _Faces:
    pictured = {m.id for m in asset.materials if m.textures}
    corners, owner, looks = [], [], []
    names: list[str] = []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points = pose.apply(visual.mesh.vertices)
            corners.append(points[visual.mesh.faces])
            owner.append(np.full(len(visual.mesh.faces), len(names)))
            names.append(f"links/{link.name}/visuals/{visual.name}")
            looks.append(f"{visual.material}/{visual.name}" if visual.material in pictured else visual.material)
    every, whose = np.concatenate(corners), np.concatenate(owner).astype(np.int64)
    flat = every.reshape(-1, 3)
    normals, area = face_normals(flat, np.arange(len(flat)).reshape(-1, 3))
    keep = area > LEAST_FACE_M2
    look = np.unique(looks, return_inverse=True)[1].astype(np.int64)[whose]
    return _Faces(every[keep], normals[keep], whose[keep], look[keep], names)


def _pairs(faces: _Faces) -> list[tuple[int, int]]:
    """Faces of different looks that lie in one plane, look the same way and whose boxes overlap, each pair once."""
    distance = np.einsum("ij,ij->i", faces.normals, faces.corners[:, 0])
    found: dict[tuple[int, int], None] = {}
    for shift in SHIFTS:
        direction = np.floor(faces.normals / (BIN * SAME_DIRECTION) + shift)
        for other in SHIFTS:
            place = np.floor(distance / (BIN * APART_M) + other)
            for group in _mixed(np.column_stack([direction, place]), faces.look):
                for pair in _meeting(faces, group):
                    found[pair] = None
    return sorted(found)


def _mixed(keys: Floats, look: Ints) -> list[Ints]:
    """Numbers of faces by equal keys, of the groups with more than one look."""
    order = np.lexsort(keys.T[::-1])
    starts = np.flatnonzero(np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)]))
    several = np.minimum.reduceat(look[order], starts) != np.maximum.reduceat(look[order], starts)
    ends = np.append(starts[1:], len(order))
    return [np.sort(order[starts[g] : ends[g]]) for g in np.flatnonzero(several)]


def _meeting(faces: _Faces, group: Ints) -> Iterator[tuple[int, int]]:
    corners, normals, look = faces.corners[group], faces.normals[group], faces.look[group]
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(low[:, 0], kind="stable")
    for n, i in enumerate(order):
        rest = order[n + 1 :]
        rest = rest[: int(np.searchsorted(low[rest, 0], high[i, 0] + APART_M))]
        rest = rest[look[rest] != look[i]]
        rest = rest[((low[rest] <= high[i] + APART_M) & (high[rest] >= low[i] - APART_M)).all(axis=1)]
        apart = np.abs((corners[rest].mean(axis=1) - corners[i].mean(axis=0)) @ normals[i])
        same = np.linalg.norm(normals[rest] - normals[i], axis=1) < SAME_DIRECTION
        for j in rest[(apart < APART_M) & same]:
            yield (int(min(group[i], group[j])), int(max(group[i], group[j])))


def _overlap(one: Floats, two: Floats, normal: Floats) -> float:
    """Area in which two triangles of a plane overlap, m^2. Ref: Sutherland and Hodgman 1974."""
    drop = int(np.argmax(np.abs(normal)))
    axes = [k for k in range(3) if k != drop]
    a, b = one[:, axes], two[:, axes]
    if _turn(a) < 0:
        a = a[::-1]
    if _turn(b) < 0:
        b = b[::-1]
    shape = list(a)
    for k in range(3):
        start, end = b[k], b[(k + 1) % 3]
        edge = end - start
        kept = []
        for p, q in zip(shape, [*shape[1:], shape[0]], strict=True):
            inside_p = edge[0] * (p[1] - start[1]) - edge[1] * (p[0] - start[0])
            inside_q = edge[0] * (q[1] - start[1]) - edge[1] * (q[0] - start[0])
            if inside_p >= 0:
                kept.append(p)
            if (inside_p >= 0) != (inside_q >= 0):
                kept.append(p + (q - p) * (inside_p / (inside_p - inside_q)))
        shape = kept
        if not shape:
            return 0.0
    return abs(_turn(np.array(shape))) / abs(float(normal[drop])) if len(shape) > 2 else 0.0


def _turn(points: Floats) -> float:
    """Signed area of a polygon in the plane."""
    x, y = points[:, 0], points[:, 1]
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2
