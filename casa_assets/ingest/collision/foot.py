"""Stand hulls on a box: what has a flat foot then rests on four corners and does not creep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.planar import outline_of
from casa_assets.geometry.solid.bounds import shape_bounds
from casa_assets.geometry.solid.cutting import Solid, section_contours
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.ingest.draft import PlacedShape
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import Box, Hull
from casa_assets.model.pose import Pose

# All numbers below are choices.
# Height of the box, metres, and at most as a share of that of the thing. Hulls begin in its middle.
FOOT_M = 0.001
FOOT_RATIO = 0.03
# What is so little above the lowest point, as a share of the height of the foot, stands on the floor too.
LEVEL_SHARE = 0.5
# A foot is flat if its outline takes at least this share of the box around the thing, seen from above; and one, not
# several legs, if matter with its hollows fills this share of the outline.
MIN_OUTLINE_SHARE = 0.08
MIN_FILLED_SHARE = 0.8
# Boxes are tried at so many angles over a quarter turn.
ANGLES = 12


def on_flat_foot(shapes: Sequence[PlacedShape], solid: Solid | None) -> tuple[PlacedShape, ...]:
    """Shapes with a box added under hulls that rest on a flat foot, or the same shapes if no such box fits.

    MuJoCo 3.3 occasionally finds only a single corner of a hull in contact with a plane, so that the object rocks and
    creeps. A box rests on its four corners in every version.

    Args:
        shapes: metres, z up, resting on their lowest point.
        solid: the solid that they approximate; None if it fills its hull.
    """
    bounds = np.array([shape_bounds(s.shape, s.pose) for s in shapes])
    lowest, size = float(bounds[:, 0, 2].min()), np.ptp(bounds.reshape(-1, 3), axis=0)
    height = min(FOOT_M, FOOT_RATIO * float(size[2]))
    standing = [k for k, b in enumerate(bounds) if b[0, 2] <= lowest + LEVEL_SHARE * height]
    hulls = {k: s for k in standing if isinstance(s := shapes[k].shape, Hull)}
    if len(hulls) < len(standing):
        return tuple(shapes)  # primitives stand by themselves
    points = np.concatenate([shapes[k].pose.apply(hull.mesh.vertices) for k, hull in hulls.items()])
    foot = points[points[:, 2] <= lowest + LEVEL_SHARE * height, :2]
    filled_m2 = np.inf if solid is None else _filled_area(solid, lowest + height)
    box = _box_within(foot, float(size[0] * size[1]), filled_m2, lowest, height)
    if box is None:
        return tuple(shapes)
    raised = [_raised(s, lowest + height / 2) if k in hulls else s for k, s in enumerate(shapes)]
    whole = [s for s in raised if s is not None]
    return (*whole, box) if len(whole) == len(shapes) else tuple(shapes)


def _filled_area(solid: Solid, height: float) -> float:
    """Area of the section of a solid at a height with its hollows filled, m^2."""
    areas = [_area(polygon) for polygon in section_contours(solid, height)]
    return sum(a for a in areas if a > 0)


def _area(polygon: Floats) -> float:
    """Area of an (N, 2) polygon, above 0 where it runs against the clock."""
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _box_within(foot: Floats, around_m2: float, filled_m2: float, lowest: float, height: float) -> PlacedShape | None:
    """The largest of some rotated boxes about the middle of a foot, within its outline.

    Return None if the outline is too small, if too little of it is filled, or if the box covers too little of it.

    Args:
        foot: (N, 2) points on the floor. around_m2: area of the object's bounding box, seen from above.
        filled_m2: area of the matter just above the foot. lowest, height: of the foot, metres.
    """
    outline = outline_of(foot)
    area = _area(outline) if len(outline) > 2 else 0.0
    if area <= 0 or area < MIN_OUTLINE_SHARE * around_m2 or filled_m2 < MIN_FILLED_SHARE * area:
        return None
    edges = np.roll(outline, -1, axis=0) - outline
    outward = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    best: tuple[float, Floats, Floats, float] | None = None
    for angle in np.arange(ANGLES) * np.pi / 2 / ANGLES:
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        local = outline @ turn
        middle, half = turn @ ((local.min(axis=0) + local.max(axis=0)) / 2), np.ptp(local, axis=0) / 2
        corners = (np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)]) * half) @ turn.T
        reach = (corners @ outward.T).max(axis=0)
        room = ((outline - middle) * outward).sum(axis=1)
        share = float((room / np.maximum(reach, 1e-12)).min())
        size = float(np.prod(2 * half)) * max(share, 0.0) ** 2
        if best is None or round(size, 12) > round(best[0], 12):
            best = size, middle, half * share, float(angle)
    assert best is not None, "angles are tried"
    size, middle, half, angle = best
    if size < MIN_OUTLINE_SHARE * area:
        return None
    return PlacedShape(
        shape=Box(size=(float(2 * half[0]), float(2 * half[1]), height)),
        pose=Pose(
            position=(float(middle[0]), float(middle[1]), lowest + height / 2),
            quaternion=(float(np.cos(angle / 2)), 0.0, 0.0, float(np.sin(angle / 2))),
        ),
    )


def _raised(placed: PlacedShape, level: float) -> PlacedShape | None:
    """A hull with all points below a level raised to it, or None if no volume is left."""
    assert isinstance(placed.shape, Hull), "hulls alone are raised"
    points = placed.pose.apply(placed.shape.mesh.vertices)
    points[:, 2] = points[:, 2].clip(level)
    try:
        vertices, faces = convex_hull(points)
    except DegenerateShape:
        return None
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=vertices, faces=faces)))
