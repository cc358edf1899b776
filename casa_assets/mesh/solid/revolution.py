"""Find the upright axis of a vessel, and the inner and outer radius of its walls by height and angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.solids import Solid, section_contours
from casa_assets.mesh.surface import face_normals

# A face belongs to a turned surface where its normal misses the axis by less than this sine.
AXIS_MISS_SINE = 0.17
ROUNDS = 12
ROWS = 60
RAYS = 96


@dataclass(frozen=True)
class WallProfile:
    """Walls of a solid around an upright axis, at ROWS heights and RAYS angles.

    Attributes:
        center: (2,) x and y of the axis, metres.
        heights: (H,) metres, ascending. step: between two, metres.
        inner: (H, A) radius at which matter begins, 0 if the axis is in it, nan if there is no matter.
        outer: (H, A) radius at which the first stretch of matter ends.
    """

    center: Floats
    heights: Floats
    step: float
    inner: Floats
    outer: Floats


def upright_axis(points: Floats, faces: Ints) -> tuple[Floats, float]:
    """(2,) x and y of the axis that most normals point at, and the share of the upright area whose normals do.

    Ref: normals of a surface of revolution meet its axis; least squares, iterated with weights that leave out handles.
    """
    normals, areas = face_normals(points, faces)
    flat = normals[:, :2]
    length = np.linalg.norm(flat, axis=1)
    weight = areas * length
    keep = length > 0.1
    flat, weight = flat[keep] / length[keep, None], weight[keep]
    middle = points[faces[keep]].mean(axis=1)[:, :2]
    across = np.stack([-flat[:, 1], flat[:, 0]], axis=1)
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    if not len(flat):
        return (low + high) / 2, 0.0
    trust = np.ones(len(flat))
    center = (low + high) / 2
    for _ in range(ROUNDS):
        pull = (weight * trust)[:, None] * across
        matrix = np.array([[(pull[:, i] * across[:, j]).sum() for j in range(2)] for i in range(2)])
        right = (pull * (across * middle).sum(axis=1)[:, None]).sum(axis=0)
        determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] ** 2
        if determinant <= 1e-9 * (matrix[0, 0] + matrix[1, 1]) ** 2:
            return (low + high) / 2, 0.0
        center = np.array(
            [
                matrix[1, 1] * right[0] - matrix[0, 1] * right[1],
                matrix[0, 0] * right[1] - matrix[0, 1] * right[0],
            ]
        ) / float(determinant)
        gap = center - middle
        miss = np.abs((gap * across).sum(axis=1)) / np.maximum(np.linalg.norm(gap, axis=1), 1e-12)
        trust = 1 / (1 + (miss / AXIS_MISS_SINE) ** 2) ** 2
    share = float(weight[miss < AXIS_MISS_SINE].sum() / weight.sum())
    return center.round(7), share


def wall_profile(solid: Solid, center: Floats) -> WallProfile:
    """Measure the radii at which matter begins and first ends around an axis through the (2,) center, metres."""
    box = solid.bounding_box()
    step = (box[5] - box[2]) / ROWS
    heights = box[2] + (np.arange(ROWS) + 0.5) * step
    rows = [_row(section_contours(solid, height), center) for height in heights]
    return WallProfile(center, heights, step, np.array([r[0] for r in rows]), np.array([r[1] for r in rows]))


def _row(polygons: list[Floats], center: Floats) -> tuple[Floats, Floats]:
    """(A,) where matter begins and where it first ends along each ray."""
    inner, outer = np.full(RAYS, np.nan), np.full(RAYS, np.nan)
    if not polygons:
        return inner, outer
    start = np.concatenate(polygons) - center
    end = np.concatenate([np.roll(p, -1, axis=0) for p in polygons]) - center
    # Half a step off the axes, where the corners of many meshes lie.
    angles = (np.arange(RAYS) + 0.5) * 2 * np.pi / RAYS
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    left = start[:, :1] * ray[:, 1] - start[:, 1:] * ray[:, 0]
    right = end[:, :1] * ray[:, 1] - end[:, 1:] * ray[:, 0]
    crosses = (left > 0) != (right > 0)
    share = left / np.where(crosses, left - right, 1.0)
    along = start @ ray.T + share * ((end - start) @ ray.T)
    crosses &= along > 0
    count = crosses.sum(axis=0)
    ordered = np.sort(np.where(crosses, along, np.inf), axis=0).round(9)
    first = ordered[0]
    second = ordered[1] if len(ordered) > 1 else np.full(RAYS, np.inf)
    within = count % 2 == 1
    inner = np.where(count == 0, np.nan, np.where(within, 0.0, first))
    outer = np.where(count == 0, np.nan, np.where(within, first, second))
    return inner, np.where(np.isinf(outer), np.nan, outer)


def radius_spread(radii: Floats) -> float:
    """Spread of the radii of a row: distance of their quartiles over the median; 1 where there are few."""
    known = radii[np.isfinite(radii)]
    if len(known) < RAYS // 2:
        return 1.0
    low, middle, high = np.percentile(known, [25, 50, 75])
    return float((high - low) / middle) if middle > 0 else 1.0
