"""The floor as a grid, and the places where a robot's base parks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from casa_assets.core.numeric import Floats, Mask, decimals
from casa_assets.mesh.outline import Outline, contains_point
from casa_assets.mesh.planar import distance
from casa_assets.model.kitchen.floor import (
    Corners,
    Fixture,
    FixtureJoint,
    KitchenFacts,
    ParkingPlace,
    ParkingSide,
    PlacedRun,
    Role,
    RoomWall,
)
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
# Ref: RoboCasa (robocasa/utils/env_utils.py) parks 0.20 m before fixtures and 0.30 m before housings and fridges.
GAP_M, TALL_GAP_M = 0.20, 0.30
TALL_UNIT_M = 1.5  # height from which a unit on the floor is a tall one
STEP_M = 0.05  # between the places that are tried to the left and right
ASIDE_M = 0.3  # that the base may stand beside the width of a fixture
LEAF_GAP_M = 0.04  # between the base and the side of an open leaf
PARKED_ROLES = (
    *(Role.SINK, Role.RANGE, Role.HOB, Role.OVEN, Role.MICROWAVE, Role.HOOD, Role.FRIDGE, Role.DISHWASHER),
    *(Role.COFFEE_MACHINE, Role.TOASTER, Role.CABINET, Role.DRAWERS, Role.SINK_BASE, Role.CORNER, Role.ISLAND),
    *(Role.PANTRY, Role.HOUSING, Role.UPPER, Role.SHELF),
)


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
            rows, columns = self._window(outline, 0.0)
            inside = distance(outline, self._points(rows, columns)) <= 0.0
            self.solid[rows, columns] |= inside.reshape(self.solid[rows, columns].shape)
        self.clear = ndimage.distance_transform_edt(~self.solid) * CELL_M
        self.free: Mask = self.room & (self.clear > BASE_RADIUS_M)
        self.entries = np.zeros(self.shape, dtype=bool)
        # Just inside of each doorway and of each open side.
        lines = [(w.start, w.end) for w in facts.walls if w.is_open]
        lines += [(w.start, w.end) for w in facts.openings if w.kind is not OpeningKind.WINDOW and w.leads_out]
        for start, end in lines:
            self.entries |= self._inside_of(start, end) & self.free
        self.reached: Mask = self.connected(self.free)

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
        """Free cells for the base with one more obstacle on the floor."""
        free = self.free.copy()
        rows, columns = self._window(outline, BASE_RADIUS_M)
        near = distance(outline, self._points(rows, columns)) <= BASE_RADIUS_M
        free[rows, columns] &= ~near.reshape(free[rows, columns].shape)
        return free

    def connected(self, free: Mask) -> Mask:
        """Part of the free floor that the base reaches from where it enters."""
        numbers, _ = ndimage.label(free)
        begins = np.unique(numbers[self.entries & free])
        return np.asarray(np.isin(numbers, begins[begins > 0]))

    def holds(self, mask: Mask, point: Vec2) -> bool:
        """True if a mask is set at a point; False outside of the grid."""
        column, row = ((point[k] - float(self.low[k])) / CELL_M for k in (0, 1))
        return 0 <= row < self.shape[0] and 0 <= column < self.shape[1] and bool(mask[int(row), int(column)])

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

    def _inside_of(self, start: Vec2, end: Vec2) -> Mask:
        every = self._points(slice(0, self.shape[0]), slice(0, self.shape[1]))
        return np.asarray((distance(np.array([start, end]), every) <= ENTRY_DEPTH_M).reshape(self.shape))


def obstacles(facts: KitchenFacts) -> Iterator[Outline]:
    """Outlines of all that the base cannot pass: walls, rows of units with their worktops, fixtures on the floor."""
    passed = [w for w in facts.openings if w.kind is OpeningKind.PASSAGE]
    for wall in facts.walls:
        if not wall.is_open:
            yield from _wall(facts.outline, wall, [(w.start, w.end) for w in passed if w.wall == wall.id])
    for row in facts.runs:
        yield from row_parts(row)
    for fixture in facts.fixtures:
        if stands(fixture):
            yield fixture.footprint.corners


def stands(fixture: Fixture) -> bool:
    """True if a fixture is on the floor in the way of a base."""
    return fixture.role not in NO_OBSTACLES and fixture.bottom < HANGING_M and fixture.top > DRIVEN_OVER_M


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
        back = -row.depth_behind
        yield row.at(left, front), row.at(right, front), row.at(right, back), row.at(left, back)


def _inside(outline: Corners, xs: Floats, ys: Floats) -> Mask:
    """Cells that lie in an outline, which need not be convex."""
    x, y = xs[None, :], ys[:, None]
    odd = np.zeros((len(ys), len(xs)), dtype=bool)
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        if ay != by:
            odd ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return odd


@dataclass(frozen=True)
class ParkingPlaces:
    """Places by fixture while all is shut, and by (fixture, joint) while that leaf is open; None: out of reach."""

    shut: dict[str, ParkingPlace | None]
    open: dict[tuple[str, str], ParkingPlace | None]

    @property
    def every(self) -> tuple[ParkingPlace, ...]:
        """All places that there are, by fixture."""
        places = [*self.shut.values(), *self.open.values()]
        return tuple(p for p in places if p is not None)


def find_parking(facts: KitchenFacts, floor: FloorMap) -> ParkingPlaces:
    """Places for all fixtures that a robot works at."""
    shut: dict[str, ParkingPlace | None] = {}
    opened: dict[tuple[str, str], ParkingPlace | None] = {}
    for fixture in facts.with_role(*PARKED_ROLES):
        edge = front_of(facts, fixture) + (TALL_GAP_M if is_tall(facts, fixture) else GAP_M)
        shut[fixture.name] = _first(_in_front(fixture, edge), floor, floor.reached)
        for joint in fixture.joints:
            if joint.swept_area is None or joint.behind is not None:
                continue
            if joint.swept_area.bottom > OVERHEAD_M:
                place = shut[fixture.name]
                opened[fixture.name, joint.name] = place and place.replace(open_joint=joint.name)
                continue
            reached = floor.connected(floor.beside(joint.swept_area.open_outline))
            found = _first(_around(fixture, joint, edge), floor, reached)
            opened[fixture.name, joint.name] = found and found.replace(open_joint=joint.name)
    return ParkingPlaces(shut, opened)


def is_tall(facts: KitchenFacts, fixture: Fixture) -> bool:
    """True if a fixture is a unit that is higher than worktops, or is in one."""
    run = facts.run(fixture.run)
    high = max((u.height for u in run.units if u.name == fixture.unit), default=0.0) if run else 0.0
    on_floor = fixture.bottom < HANGING_M and fixture.top > TALL_UNIT_M
    return fixture.role in (Role.FRIDGE, Role.PANTRY) or high > TALL_UNIT_M or on_floor


def front_of(facts: KitchenFacts, fixture: Fixture) -> float:
    """Distance before a fixture's own front at which the base has to stop: the edge of a worktop, say."""
    run = facts.run(fixture.run)
    if run is None:
        return 0.0
    u, v = run.to_local(fixture.footprint.at(0.0, 0.0))
    half = 0.45 * fixture.footprint.size[0]
    below = [n.front for n in run.units if n.left < u + half and n.right > u - half and n.kind != "gap"]
    return max([*below, v] if below else [run.depth_before, v]) - v


def _in_front(fixture: Fixture, edge: float) -> Iterator[ParkingPlace]:
    """Places where the base's rim is at `edge` metres before a fixture's front, the middle one first."""
    reach = fixture.footprint.size[0] / 2 + ASIDE_M
    for k in range(int(reach / STEP_M) + 1):
        for aside in (k * STEP_M, -k * STEP_M)[: 1 if k == 0 else 2]:
            yield _place(fixture, aside, edge + BASE_RADIUS_M, ParkingSide.FRONT)


def _place(
    fixture: Fixture, aside: float, before: float, stance: ParkingSide, look: Vec2 | None = None
) -> ParkingPlace:
    at = fixture.footprint.at(aside, before)
    x, y = fixture.footprint.front_axis
    # Radians to the left of the x axis.
    yaw = math.atan2(-y, -x) if look is None else math.atan2(look[1] - at[1], look[0] - at[0])
    return ParkingPlace(
        fixture=fixture.name,
        position=(round(at[0], 4), round(at[1], 4)),
        yaw=decimals(yaw, 4),
        side=stance,
        offset=round(aside, 4),
    )


def _around(fixture: Fixture, joint: FixtureJoint, edge: float) -> Iterator[ParkingPlace]:
    """Places in front of a fixture, then next to the open leaf, then behind it."""
    assert joint.swept_area is not None
    if not joint.swept_area.sweeps_front:
        yield from _in_front(fixture, edge)
    points = [fixture.footprint.to_local(p) for p in joint.swept_area.open_outline]
    left, right = min(p[0] for p in points), max(p[0] for p in points)
    out = max(p[1] for p in points)
    look = fixture.footprint.at((left + right) / 2, 0.0)
    for k in range(5):
        more = BASE_RADIUS_M + LEAF_GAP_M + k * STEP_M
        for aside, stance in ((right + more, ParkingSide.RIGHT), (left - more, ParkingSide.LEFT)):
            yield _place(fixture, aside, edge + BASE_RADIUS_M, stance, look)
    for k in range(5):
        before = max(out + GAP_M / 2, edge) + BASE_RADIUS_M + k * STEP_M
        yield _place(fixture, (left + right) / 2, before, ParkingSide.BEHIND)


def _first(places: Iterator[ParkingPlace], floor: FloorMap, reached: Mask) -> ParkingPlace | None:
    return next((p for p in places if floor.holds(reached, p.position)), None)
