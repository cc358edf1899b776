"""Give fronts without a handle a grip: a strip of their collision shapes along the edge that opens."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np

from casa_assets.articulate.colliders.clearance import LinkSolid, subtract_box
from casa_assets.articulate.colliders.link_shapes import box_cloud
from casa_assets.articulate.plan import PartKind
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.hull import hull_volume

# Parts that are opened by their edge where they have no handle.
OPENING_KINDS = frozenset({PartKind.DOOR, PartKind.DRAWER, PartKind.LID})
# Size of the strip that fingers take, across the edge and behind it; shapes that end this near to each other end at one
# edge.
GRIP_WIDTH_M, GRIP_THICKNESS_M, EDGE_TOLERANCE_M = 0.02, 0.03, 0.01
# Smaller strips are too small to hold.
MIN_GRIP_M3 = 1e-7


def add_edge_grip(solid: LinkSolid, kind: PartKind) -> None:
    """Make the strip along the opening edge of a front without a handle its grip; in place.

    Args:
        solid: with its joint, metres, z up, the front faces -y.
    """
    if kind not in OPENING_KINDS or solid.grips or not solid.clouds or solid.axis is None or solid.anchor is None:
        return
    lower, upper = (np.array([f(c, axis=0) for c in solid.clouds]) for f in (np.min, np.max))
    edge, sign = _edge(solid, lower.min(axis=0), upper.max(axis=0))
    # Of a drawer it is the front that is taken, or a lip of it, not a side of its box.
    first = np.ones(len(lower), dtype=bool) if solid.turns else lower[:, 1] <= lower[:, 1].min() + EDGE_TOLERANCE_M
    reach = sign * (upper if sign > 0 else lower)[:, edge]
    rows = np.flatnonzero(first & (reach >= reach[first].max() - EDGE_TOLERANCE_M))
    chosen = min(rows.tolist(), key=lambda i: (-round(hull_volume(solid.clouds[i]), 9), i))
    end = sign * float(reach[chosen])
    box = np.array([lower[chosen], upper[chosen]])
    wide = min(GRIP_WIDTH_M, 0.3 * float(box[1][edge] - box[0][edge]))
    box[0 if sign > 0 else 1][edge] = end - sign * wide
    thin = _across(solid, edge)
    # The side that is seen: of a lid the upper one.
    if box[1][thin] - box[0][thin] > GRIP_THICKNESS_M:
        box[1 if thin != 2 else 0][thin] = (
            box[0][thin] + GRIP_THICKNESS_M if thin != 2 else box[1][thin] - GRIP_THICKNESS_M
        )
    strip = _shared(solid.clouds[chosen], box)
    if strip is not None:
        solid.grips = [strip]
        solid.clouds[chosen : chosen + 1] = subtract_box(solid.clouds[chosen], box) or [solid.clouds[chosen]]


def _edge(solid: LinkSolid, lower: Floats, upper: Floats) -> tuple[int, float]:
    """Return the axis and side of the edge that opens: opposite the hinge, or the upper one of what slides."""
    assert solid.axis is not None
    assert solid.anchor is not None
    if not solid.turns:
        return 2, 1.0
    away = (lower + upper) / 2 - solid.anchor
    away = away - solid.axis * float(away @ solid.axis)
    axis = int(np.argmax(np.round(np.abs(away), 6)))
    return axis, 1.0 if away[axis] > 0 else -1.0


def _across(solid: LinkSolid, edge: int) -> int:
    """Return the axis along which a front is thin: neither that of its edge nor the one that the edge runs along."""
    assert solid.axis is not None
    if not solid.turns:
        return 1
    along = int(np.argmax(np.abs(solid.axis)))
    return next(k for k in (1, 2, 0) if k not in (edge, along))


def _shared(cloud: Floats, box: Sequence[Floats] | Floats) -> Floats | None:
    """Return the (N, 3) corners of the intersection of a convex cloud and a box, None if it is too small to hold."""
    both = manifold3d.Manifold.hull_points(cloud) ^ manifold3d.Manifold.hull_points(box_cloud(box[0], box[1]))
    if both.is_empty() or both.volume() < MIN_GRIP_M3:
        return None
    return np.array(both.to_mesh64().vert_properties[:, :3], dtype=np.float64)
