"""Occupancy grid of the floor: obstacles, positions of a robot's base, and what it can reach."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy import ndimage

from casa_assets.core.typing import Floats, Mask
from casa_assets.geometry.outline import Outline, contains_point
from casa_assets.geometry.planar import distance
from casa_assets.model.kitchen.floor import Corners, Fixture, KitchenFacts, PlacedRun, Role, RoomWall
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Vec2

CELL_M = 0.025
BASE_RADIUS_M = 0.30
OVERHEAD_M = 1.2  # an open leaf that begins higher does not stop the base
DRIVEN_OVER_M = 0.03  # what is lower is driven over: rugs, thresholds
HANGING_M = 0.3  # a fixture that begins higher hangs, and leaves the floor free
MARGIN_M = 0.5  # of grid around the room
WALL_M = 0.12  # thickness of walls
ENTRY_DEPTH_M = BASE_RADIUS_M + 0.1  # from a doorway or an open wall, at which the base enters
NO_OBSTACLES = (Role.ROOM, Role.HUNG, Role.WORKTOP)


class FloorMap:
    """The grid of a kitchen's floor; rows go along y, columns along x."""

    def __init__(self, facts: KitchenFacts) -> None:
        self.facts = facts
        points = np.array(facts.outline)
        self.low = points.min(axis=0) - MARGIN_M
        count = np.ceil((points.max(axis=0) + MARGIN_M - self.low) / CELL_M).astype(int)
        self.shape = (int(count[1]), int(count[0]))
        xs, ys = (self.low[k] + (np.arange(count[k]) + 0.5) * CELL_M for k in (0, 1))
        self.xs, self.ys = xs, ys
        self.room = _inside(facts.outline, xs, ys)
        self.solid = np.zeros(self.shape, dtype=bool)
        for outline in obstacles(facts):
            self._fill(outline)
        self.clear = ndimage.distance_transform_edt(~self.solid) * CELL_M
        self.free: Mask = self.room & (self.clear > BASE_RADIUS_M)
        self.entries = np.zeros(self.shape, dtype=bool)
        for mask in self._entries():
            self.entries |= mask & self.free
        self.reached: Mask = self.connected(self.free)

    def _fill(self, outline: Outline) -> None:
        rows, columns = self._window(outline, 0.0)
        points = self._points(rows, columns)
        self.solid[rows, columns] |= (distance(outline, points) <= 0.0).reshape(points_shape(rows, columns))

    def _window(self, outline: Outline, gap: float) -> tuple[slice, slice]:
        corners = np.asarray(outline)
        first = np.floor((corners.min(axis=0) - gap - self.low) / CELL_M).astype(int)
        last = np.ceil((corners.max(axis=0) + gap - self.low) / CELL_M).astype(int) + 1
        (x0, y0), (x1, y1) = np.maximum(first, 0), np.maximum(last, 0)
        return slice(y0, min(y1, self.shape[0])), slice(x0, min(x1, self.shape[1]))

    def _points(self, rows: slice, columns: slice) -> Floats:
        grid = np.meshgrid(self.xs[columns], self.ys[rows])
        return np.stack([grid[0].ravel(), grid[1].ravel()], axis=1)

    def beside(self, outline: Outline) -> Mask:
        """Free cells for the base while one more obstacle stands on the floor."""
        free = self.free.copy()
        rows, columns = self._window(outline, BASE_RADIUS_M)
        near = distance(outline, self._points(rows, columns)) <= BASE_RADIUS_M
        free[rows, columns] &= ~near.reshape(points_shape(rows, columns))
        return free

    def connected(self, free: Mask) -> Mask:
        """Part of the free floor that the base reaches from where it enters."""
        numbers, _ = ndimage.label(free)
        begins = np.unique(numbers[self.entries & free])
        found: Mask = np.isin(numbers, begins[begins > 0])
        return found

    def cell(self, point: Vec2) -> tuple[int, int] | None:
        """Row and column of a point, None outside of the grid."""
        column, row = ((point[k] - float(self.low[k])) / CELL_M for k in (0, 1))
        inside = 0 <= row < self.shape[0] and 0 <= column < self.shape[1]
        return (int(row), int(column)) if inside else None

    def holds(self, mask: Mask, point: Vec2) -> bool:
        """True if a mask is set at a point."""
        at = self.cell(point)
        return at is not None and bool(mask[at])

    def area(self, point: Vec2, radius: float) -> float:
        """Square metres of floor around a point that the middle of the base can get to."""
        near = (self.xs[None, :] - point[0]) ** 2 + (self.ys[:, None] - point[1]) ** 2 <= radius**2
        return float((near & self.reached).sum()) * CELL_M**2

    def leads_in(self, start: Vec2, end: Vec2) -> bool:
        """True if the base gets from a doorway to the largest piece of free floor."""
        numbers, count = ndimage.label(self.free)
        if not count:
            return False
        largest = 1 + int(np.argmax(np.bincount(numbers.ravel())[1:]))
        return bool((numbers[self._inside_of(start, end)] == largest).any())

    def _entries(self) -> Iterator[Mask]:
        """Cells just inside of each doorway and of each open side."""
        lines = [(w.start, w.end) for w in self.facts.walls if w.is_open]
        lines += [(w.start, w.end) for w in self.facts.openings if w.kind is not OpeningKind.WINDOW and w.leads_out]
        for start, end in lines:
            yield self._inside_of(start, end)

    def _inside_of(self, start: Vec2, end: Vec2) -> Mask:
        every = self._points(slice(0, self.shape[0]), slice(0, self.shape[1]))
        near: Mask = (distance(np.array([start, end]), every) <= ENTRY_DEPTH_M).reshape(self.shape)
        return near


def points_shape(rows: slice, columns: slice) -> tuple[int, int]:
    """Shape of a window of the grid."""
    return (rows.stop - rows.start, columns.stop - columns.start)


def obstacles(facts: KitchenFacts) -> Iterator[Outline]:
    """Outlines of all that the base cannot pass: walls, rows of units with their worktops, what stands on the floor."""
    for wall in facts.walls:
        if not wall.is_open:
            yield from _wall(
                facts.outline,
                wall,
                [(w.start, w.end) for w in facts.openings if _is_passed(w.kind) and w.wall == wall.id],
            )
    for row in facts.runs:
        yield from row_parts(row)
    for fixture in facts.fixtures:
        if stands(fixture):
            yield fixture.footprint.corners


def stands(fixture: Fixture) -> bool:
    """True if a fixture stands on the floor in the way of a base."""
    return fixture.role not in NO_OBSTACLES and fixture.bottom < HANGING_M and fixture.top > DRIVEN_OVER_M


def _is_passed(kind: OpeningKind) -> bool:
    return kind is OpeningKind.PASSAGE


def _wall(room: Corners, wall: RoomWall, holes: Sequence[tuple[Vec2, Vec2]]) -> Iterator[Outline]:
    """Pieces of a wall between the holes that reach down to the floor and have no leaf; they close the corners."""
    a, b = np.array(wall.start), np.array(wall.end)
    length = float(np.linalg.norm(b - a))
    along = (b - a) / max(length, 1e-9)
    out = np.array([-along[1], along[0]])
    corner = WALL_M / 2 * out
    before, after = (
        0.0 if contains_point(room, (float(p[0]), float(p[1]))) else WALL_M
        for p in (a - WALL_M / 2 * along + corner, b + WALL_M / 2 * along + corner)
    )
    marks = [-before]
    for start, end in sorted(holes, key=lambda h: float((np.array(h[0]) - a) @ along)):
        marks += [float((np.array(start) - a) @ along), float((np.array(end) - a) @ along)]
    marks.append(length + after)
    for low, high in zip(marks[::2], marks[1::2], strict=True):
        corners = [a + low * along, a + high * along, a + high * along + WALL_M * out, a + low * along + WALL_M * out]
        yield np.array(corners)


def row_parts(row: PlacedRun) -> Iterator[Corners]:
    """Units from behind to front, and what lies in corners."""
    first, last = row.span
    parts = [(u.left, u.right, u.front) for u in row.units if u.kind != "gap"]
    if row.units and first < row.units[0].left:
        parts.append((first, row.units[0].left, row.depth_before))
    if row.units and last > row.units[-1].right:
        parts.append((row.units[-1].right, last, row.depth_before))
    for left, right, front in parts:
        yield (
            row.at(left, front),
            row.at(right, front),
            row.at(right, -row.depth_behind),
            row.at(left, -row.depth_behind),
        )


def _inside(outline: Corners, xs: Floats, ys: Floats) -> Mask:
    """Cells that lie in an outline, which need not be convex."""
    x, y = xs[None, :], ys[:, None]
    odd = np.zeros((len(ys), len(xs)), dtype=bool)
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        if ay != by:
            odd ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return odd


def toward(start: Vec2, end: Vec2) -> float:
    """Direction from one point to another, radians to the left of the x axis."""
    return math.atan2(end[1] - start[1], end[0] - start[0])


def around(points: Iterable[Vec2]) -> tuple[Vec2, Vec2]:
    """Least and greatest x and y."""
    xs, ys = zip(*points, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))
