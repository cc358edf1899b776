"""Outlines of rooms: rectilinear polygons, seen from above."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids import cells
from casa_assets.geometry.planar import counter_clockwise, signed_area
from casa_assets.model.record import Vec2, Vec3

Outline = tuple[Vec2, ...]
MIN_SIDE = 0.1  # metres
LENGTH_TOLERANCE = 1e-6


class LayDirection(StrEnum):
    """Direction that boards, and the height of any picture, run along."""

    X = "x"
    Y = "y"

    @property
    def vector(self) -> Vec3:
        """The direction as a unit vector."""
        return (1.0, 0.0, 0.0) if self is LayDirection.X else (0.0, 1.0, 0.0)


def outline_cells(outline: Outline) -> cells.Cells:
    """The cells within a room's outline.

    Args:
        outline: (x, y) corners in order, either way round, metres.
    Raises:
        ValueError: a side runs aslant or is too short, or sides meet or cross elsewhere than at the corners.
    """
    points = np.array(outline, dtype=np.float64)
    if len(points) < 4:
        raise ValueError(f"an outline has four corners at least, not {len(points)}")
    run = np.roll(points, -1, axis=0) - points
    for k, (x, y) in enumerate(run):
        if min(abs(x), abs(y)) > LENGTH_TOLERANCE:
            raise ValueError(f"side {k} of the outline runs aslant: {x:g} by {y:g} m")
        if max(abs(x), abs(y)) < MIN_SIDE:
            raise ValueError(f"side {k} of the outline is shorter than {MIN_SIDE:g} m")
    grid = cells.cells_inside(outline)
    perimeter = float(np.abs(run).sum())
    if (
        abs(grid.area - abs(signed_area(points))) > LENGTH_TOLERANCE * perimeter
        or abs(grid.perimeter - perimeter) > 1e-5
        or grid.touches_at_a_point
    ):
        raise ValueError("sides of the outline cross or touch each other")
    return grid


def outline_loop(outline: Outline) -> Floats:
    """(N, 2) corners, counter-clockwise, none within a straight side. Metres."""
    points: Floats = np.round(np.array(outline, dtype=np.float64), cells.LINE_DECIMALS).astype(np.float64)
    points = counter_clockwise(points)
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(points[np.abs(turns) > LENGTH_TOLERANCE])


def interior_spans(grid: cells.Cells, lower: float, upper: float) -> list[Vec2]:
    """(from, to) along u of what is inside over the whole breadth low..high of v, metres."""
    rows = (grid.vs[:-1] < upper - LENGTH_TOLERANCE) & (grid.vs[1:] > lower + LENGTH_TOLERANCE)
    inside_all = grid.solid[:, rows].all(axis=1)
    steps = np.diff(np.concatenate([[0], inside_all.astype(np.int64), [0]]))
    begins, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    return [(float(grid.us[a]), float(grid.us[b])) for a, b in zip(begins, ends, strict=True)]
