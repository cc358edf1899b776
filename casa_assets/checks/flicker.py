"""Faces of different materials in one place: a renderer shows now the one and now the other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from casa_assets.checks.check import Measured
from casa_assets.geometry.measure import face_normals
from casa_assets.model.asset import Asset

APART_M = 0.00015  # nearer than this a depth buffer cannot tell two faces of a kitchen apart
SAME_DIRECTION = 0.01  # rad
LEAST_FACE_M2 = 2e-7

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


def shows_one_face(asset: Asset, limit: float | None) -> Measured:
    """No two faces of different materials look the same way from the same place; m^2 of the largest overlap."""
    assert limit is not None
    corners, normals, owner, names, materials = _faces(asset)
    found: dict[tuple[int, int], float] = {}
    for group in _planes(corners, normals):
        if len({int(o) for o in owner[group]}) < 2:
            continue
        for a, b in _pairs(corners[group], normals[group], owner[group], materials):
            i, j = int(owner[group[a]]), int(owner[group[b]])
            area = _overlap(corners[group[a]], corners[group[b]], normals[group[a]])
            if area > 0:
                key = (min(i, j), max(i, j))
                found[key] = found.get(key, 0.0) + area
    problems = tuple(
        (names[i], f"shares {area * 1e6:.1f} mm^2 of surface with {names[j]}; set one of them back")
        for (i, j), area in sorted(found.items())
        if area > limit
    )
    return Measured(max(found.values(), default=0.0), problems)


def _faces(asset: Asset) -> tuple[Floats, Floats, Ints, list[str], list[str]]:
    """(F, 3, 3) corners in the asset frame, (F, 3) normals, (F,) visual of each; pointers and materials of visuals."""
    corners, owner, names, materials = [], [], [], []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points = pose.apply(visual.mesh.vertices)
            corners.append(points[visual.mesh.faces])
            owner.append(np.full(len(visual.mesh.faces), len(names)))
            names.append(f"links/{link.name}/visuals/{visual.name}")
            materials.append(visual.material)
    every, whose = np.concatenate(corners), np.concatenate(owner)
    flat = every.reshape(-1, 3)
    normals, area = face_normals(flat, np.arange(len(flat)).reshape(-1, 3))
    keep = area > LEAST_FACE_M2
    return every[keep], normals[keep], whose[keep], names, materials


def _planes(corners: Floats, normals: Floats) -> Iterator[Ints]:
    """Indices of faces that lie in one plane and look the same way; twice with shifted bins, so that none is missed."""
    seen: set[bytes] = set()
    for shift in (0.0, 0.5):
        direction = np.floor(normals / (4 * SAME_DIRECTION) + shift).astype(np.int64)
        distance = np.einsum("ij,ij->i", normals, corners.mean(axis=1))
        place = np.floor(distance / (4 * APART_M) + shift).astype(np.int64)
        key = np.column_stack([direction, place])
        order = np.lexsort(key.T[::-1])
        ends = np.flatnonzero((np.diff(key[order], axis=0) != 0).any(axis=1)) + 1
        for group in np.split(order, ends):
            name = np.sort(group).tobytes()
            if len(group) > 1 and name not in seen:
                seen.add(name)
                yield np.sort(group)


def _pairs(corners: Floats, normals: Floats, owner: Ints, materials: list[str]) -> Iterator[tuple[int, int]]:
    """Faces of different materials whose boxes overlap and that are near enough."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    kinds = np.unique([materials[int(o)] for o in owner], return_inverse=True)[1]
    order = np.argsort(low[:, 0], kind="stable")
    for n, i in enumerate(order):
        rest = order[n + 1 :]
        rest = rest[: int(np.searchsorted(low[rest, 0], high[i, 0]))]
        hit = (low[rest] <= high[i] + APART_M).all(axis=1) & (high[rest] >= low[i] - APART_M).all(axis=1)
        for j in rest[hit & (kinds[rest] != kinds[i])]:
            apart = abs(float(normals[i] @ (corners[j].mean(axis=0) - corners[i].mean(axis=0))))
            if apart < APART_M and float(normals[i] @ normals[j]) > 1 - SAME_DIRECTION:
                yield int(i), int(j)


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
