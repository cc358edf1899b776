"""Boxes in a room -> the space that something can get into from the room, and fewer boxes that close it off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Shape, Sphere
from casa_assets.model.pose import Pose

# Reachable space ------------------------------------------------------------------------------------------------------
# Boxes in a room -> the space between them that something can get into from the room.

# A gap twice as wide as this counts as closed: neither a finger nor a thing that a kitchen holds gets in, metres.
CLOSED_GAP_HALF_M = 0.006
# What is merged may stick out of what it stands for by so much, metres.
TOLERANCE_M = 0.0025
# Besides the faces of boxes, lines of the grid lie this far apart, metres: shapes that stand askew have no such faces.
LINE_STEP_M = 0.1
# Free room around all boxes, metres.
BORDER_M = 0.1
# Lines closer than this are one, metres.
SAME_LINE_M = 1e-3
# Numbers on either side that are equal but for rounding, metres.
ROUNDING_M = 1e-6


class ReachableSpace:
    """The space of a room that can be reached from given points, on a grid along the faces of the obstacles.

    Gaps of up to 12 mm count as closed. Moving parts are not obstacles: the inside of a cupboard with a door is
    reachable. `boxes`: (N, 2, 3) lower and upper corners of the obstacles, metres, world frame.
    """

    def __init__(self, boxes: Floats, seeds: Floats, askew: Sequence[tuple[Shape, Pose]] = ()) -> None:
        """Find the space among (N, 2, 3) corners of axis-aligned boxes, N > 0, metres, and other shapes, in the world.

        `seeds`: (M, 3) points from which it is reached; those inside of boxes are passed over.
        """
        self.boxes = boxes
        closed = boxes + np.array([[-CLOSED_GAP_HALF_M] * 3, [CLOSED_GAP_HALF_M] * 3])
        self._lines = [_lines(closed[:, :, axis]) for axis in range(3)]
        self._centers = [(lines[1:] + lines[:-1]) / 2 for lines in self._lines]
        solid = np.zeros([len(centers) for centers in self._centers], dtype=bool)
        for lower, upper in closed:
            solid[self._cells(lower, upper)] = True
        for shape, pose in askew:
            self._mark(solid, shape, pose)
        self._reached = self._flooded(solid, seeds)

    def touches(self, lower: Floats, upper: Floats, margin: float) -> bool:
        """True where a box, `margin` metres larger on each side, holds reachable space.

        A margin of CLOSED_GAP_HALF_M and more asks whether anything can touch it; that less TOLERANCE_M asks whether it
        would take away space from what could be there.
        """
        ranges = []
        for axis in range(3):
            lines = self._lines[axis]
            first = int(np.searchsorted(lines, lower[axis] - margin + SAME_LINE_M, side="right")) - 1
            last = int(np.searchsorted(lines, upper[axis] + margin - SAME_LINE_M, side="left"))
            first, last = max(first, 0), min(last, len(lines) - 1)
            if first >= last:
                return False
            ranges.append(slice(first, last))
        return bool(self._reached[tuple(ranges)].any())

    def takes_room(self, lower: Floats, upper: Floats) -> bool:
        """True where a box, (3,) and (3,) its corners, would take away space that something can get into."""
        return self.touches(lower, upper, CLOSED_GAP_HALF_M - TOLERANCE_M)

    def is_exposed(self, lower: Floats, upper: Floats) -> bool:
        """True where something can get at a box, (3,) and (3,) its corners, metres."""
        return self.touches(lower, upper, CLOSED_GAP_HALF_M + TOLERANCE_M)

    def _cells(self, lower: Floats, upper: Floats) -> tuple[slice, slice, slice]:
        """Cells whose centres lie within a box."""
        spans = [
            slice(int(np.searchsorted(centers, low)), int(np.searchsorted(centers, high)))
            for centers, low, high in zip(self._centers, lower, upper, strict=True)
        ]
        return spans[0], spans[1], spans[2]

    def _mark(self, solid: Mask, shape: Shape, pose: Pose) -> None:
        """Mark the cells whose centres lie in a shape, with half a gap around it."""
        reach = _radius(shape) + CLOSED_GAP_HALF_M
        center = np.array(pose.position)
        cells = self._cells(center - reach, center + reach)
        grids = np.meshgrid(*(c[s] for c, s in zip(self._centers, cells, strict=True)), indexing="ij")
        points = pose.inverse().apply(np.stack([g.ravel() for g in grids], axis=1))
        solid[cells] |= is_inside(shape, points, CLOSED_GAP_HALF_M).reshape(grids[0].shape)

    def _flooded(self, solid: Mask, seeds: Floats) -> Mask:
        """The free cells that hang together with a seed; all free ones where every seed is inside of something."""
        labels, _ = ndimage.label(~solid)
        found: set[int] = set()
        for point in seeds:
            index: Ints = np.array(
                [np.searchsorted(lines, value) - 1 for lines, value in zip(self._lines, point, strict=True)]
            )
            if (index >= 0).all() and (index < np.array(labels.shape)).all():
                found.add(int(labels[tuple(index)]))
        wanted = np.zeros(int(labels.max()) + 1, dtype=bool)
        wanted[sorted(found - {0}) or slice(1, None)] = True
        reached: Mask = wanted[labels]
        return reached


def is_inside(shape: Shape, points: Floats, margin: float = 0.0) -> Mask:
    """(N,) whether points of the frame of a primitive lie in it or at most `margin` metres from its faces.

    Raises ValueError: the shape is no primitive.
    """
    if isinstance(shape, Box):
        beside = np.abs(points) - np.array(shape.size) / 2
        return np.asarray(beside.max(axis=1) <= margin, dtype=bool)
    if isinstance(shape, Sphere):
        return np.asarray(np.linalg.norm(points, axis=1) <= shape.radius + margin, dtype=bool)
    if isinstance(shape, Cylinder):
        round_ = np.hypot(points[:, 0], points[:, 1]) <= shape.radius + margin
        return np.asarray(round_ & (np.abs(points[:, 2]) <= shape.height / 2 + margin), dtype=bool)
    if isinstance(shape, Capsule):
        beyond = points - np.clip(points, [0, 0, -shape.height / 2], [0, 0, shape.height / 2])
        return np.asarray(np.linalg.norm(beyond, axis=1) <= shape.radius + margin, dtype=bool)
    raise ValueError(f"a {shape.kind} is no primitive")


def _radius(shape: Shape) -> float:
    """Radius of a ball around the origin that holds a primitive, metres."""
    if isinstance(shape, Box):
        return float(np.linalg.norm(shape.size)) / 2
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Cylinder):
        return float(np.hypot(shape.radius, shape.height / 2))
    if isinstance(shape, Capsule):
        return shape.radius + shape.height / 2
    raise ValueError(f"a {shape.kind} is no primitive")


def _lines(faces: Floats) -> Floats:
    """Lines of the grid along one axis: the faces of all boxes, those between, and the border."""
    low, high = float(faces.min()) - BORDER_M, float(faces.max()) + BORDER_M
    between = np.arange(low, high, LINE_STEP_M)
    every = np.unique(np.concatenate([faces.ravel(), between, [high]]))
    is_new = np.concatenate([[True], np.diff(every) > SAME_LINE_M])
    return np.asarray(every[is_new], dtype=np.float64)


# Cover boxes ----------------------------------------------------------------------------------------------------------
# Boxes in a room -> fewer boxes that close the same space off.

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
