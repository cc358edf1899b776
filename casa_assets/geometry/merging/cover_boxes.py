"""Boxes in a room -> fewer boxes that close the same space off."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.merging.reachable_space import ROUNDING_M, TOLERANCE_M, ReachableSpace

# Orders in which a box grows along the axes: each axis comes first once.
ORDERS = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


class CoveringBox(NamedTuple):
    """A box: its (2, 3) corners in metres, and the indices of the boxes that it replaces, the largest first."""

    corners: Floats
    covered: tuple[int, ...]


def cover_boxes(space: ReachableSpace) -> list[CoveringBox]:
    """Replace the boxes of a space by fewer; none sticks out by more than TOLERANCE_M into reachable space.

    Each box grows through solid or closed space as far as the faces of others. Then the grown box that holds most of
    the boxes not yet covered is taken, until all are covered. Boxes that nothing can touch are left out.
    """
    boxes = space.boxes
    exposed = np.array([space.is_exposed(lower, upper) for lower, upper in boxes], dtype=bool)
    grown = np.concatenate([boxes, *([_grown(space, box, order) for box in boxes] for order in ORDERS)])
    # (G, N) which of the boxes each of the grown holds.
    sticks_out = np.maximum(grown[:, None, 0] - boxes[None, :, 0], boxes[None, :, 1] - grown[:, None, 1]).max(axis=2)
    inside = np.asarray(sticks_out <= TOLERANCE_M, dtype=bool)
    volumes = np.prod(boxes[:, 1] - boxes[:, 0], axis=1)
    left, found = exposed.copy(), list[CoveringBox]()
    while left.any():
        counts = (inside & left).sum(axis=1)
        best = int(np.argmax(counts))
        held: Ints = np.flatnonzero(inside[best] & left)
        corners = np.array([boxes[held, 0].min(axis=0), boxes[held, 1].max(axis=0)])
        found.append(CoveringBox(corners, tuple(int(i) for i in held[np.argsort(-volumes[held], kind="stable")])))
        left[held] = False
    return found


def _grown(space: ReachableSpace, box: Floats, order: tuple[int, int, int]) -> Floats:
    """A box as large as it gets along each axis in turn, up to faces of others and without taking room."""
    grown = box.copy()
    for axis in order:
        others = [other for other in range(3) if other != axis]
        beside = (space.boxes[:, 0, others] < grown[1, others] - ROUNDING_M).all(axis=1)
        beside &= (space.boxes[:, 1, others] > grown[0, others] + ROUNDING_M).all(axis=1)
        for side, sign in ((1, 1.0), (0, -1.0)):
            faces = np.unique(sign * space.boxes[beside, side, axis])
            for face in sign * faces[faces > sign * grown[side, axis] + ROUNDING_M]:
                slab = grown.copy()
                slab[1 - side, axis], slab[side, axis] = grown[side, axis], face
                if space.takes_room(slab[0], slab[1]):
                    break
                grown[side, axis] = face
    return grown
