"""Clearances of a kitchen, seen from above, before anything is built: areas that leaves sweep, and widths of aisles.

The families that build doors, drawers and flaps decide how far they reach; the numbers here are upper bounds, which
tests/unit/layouts verifies. If no leaf meets another one that is open, all of a kitchen open (check SCN005).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from types import MappingProxyType

import numpy as np

from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import WallFrame, WallHole
from casa_assets.layouts.plan.runs import CornerPart, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.mesh.outline import contains_point, penetration_depth
from casa_assets.model.kitchen.floor import Aisle, AisleKind, Corners, PlacedRun, RoomWall, RunEnd
from casa_assets.model.kitchen.plan import BaseKind, BaseUnit, OpeningKind, RunSide, UpperKind
from casa_assets.model.record import Vec2

Outline = tuple[Vec2, ...]
Bounds = tuple[float, float, float, float, float, float]
STEPS = 12  # of a hinge: an arc of 0.45 m in steps of 6 cm
PLINTH_M, DOOR_M = 0.1, 0.02  # height of plinths; thickness of fronts
# How far handles stand out before a front, by kind.
HANDLES_M: Mapping[str, float] = {
    "bar": 0.045, "boxed": 0.042, "bow": 0.042, "cup": 0.031, "knob": 0.031, "ring": 0.03, "strap": 0.037, "tee": 0.041,
    "leather": 0.039, "edge_pull": 0.024, "finger_groove": 0.0,
}  # fmt: skip
MOST_HANDLE_M = max(HANDLES_M.values())  # of kinds that a plug-in adds
# Where the handle of a door lies, from its free edge, and the pull of a refrigerator's.
HANDLE_FROM_EDGE_M, FRIDGE_PULL_FROM_EDGE_M = (0.03, 0.055), (0.02, 0.12)
# That the drawer of a cabinet as deep as all others comes out, and what the back of an island takes of its depth; width
# of the handle, and its least height over the lower edge of the lowest of a few drawers.
DRAWER_M, ISLAND_BACK_M, HANDLE_WIDTH_M, HANDLE_OVER_M, FEW_DRAWERS = 0.489, 0.022, 0.34, 0.2, 3
GAP_M = 0.0015  # beside a front, half of the gap between two
# How far flaps of appliances reach before the front: of a dishwasher less than its height by so much, of an oven in the
# wall a share of its height, of a range that has a drawer, or its knobs behind, or neither.
DISHWASHER_LESS_M, OVEN_SHARE = 0.103, 0.81
RANGE_FLAP_M, RANGE_FLAP_KNOBS_BEHIND_M, RANGE_FLAP_NO_DRAWER_M = 0.49, 0.57, 0.67
RANGE_DRAWER_M = 0.395
# Heights of the lower edges of flaps: of a dishwasher or a range, of a range with a drawer, of an oven in the wall; of
# the microwave in a tall unit. What an open flap takes up below it, with its handle.
FLAP_FROM_M, RANGE_FLAP_FROM_M, OVEN_FROM_M, MICROWAVE_FROM_M = 0.11, 0.33, 0.75, 1.08
FLAP_BELOW_M, FLAP_TRAVEL, FLAP_PIECES = 0.06, 1.48, 4
RANGE_BEFORE_M = 0.06  # that the door of a range stands before its depth, with the gap behind it
# Of a refrigerator: thickness of its doors with the bins in them, what their pulls stand out, how far the drawer of a
# freezer comes out, and the gap behind it.
FRIDGE_DOOR_M, FRIDGE_PULL_M, FREEZER_DRAWER_M, FRIDGE_BEHIND_M = 0.16, 0.073, 0.56, 0.03
HUNG_MICROWAVE_M = 0.08  # that a microwave on the wall stands before the cabinets beside it
# Of a room's door: lining and gap between its leaf and the wall, on each side and above; thickness of the leaf and gap
# beside it; what a lever stands out at both faces.
DOOR_FRAME_M, ROOM_DOOR_M, LEAF_GAP_M, LEVER_M = 0.034, 0.04, 0.004, 0.06
RAY_SPACING_M = 0.05  # between the rays that are cast from a face
MIN_WIDTH_M = 0.02  # nearer faces touch
PASSAGE_BEYOND_M = 0.3  # how far beyond its ends a strip has to be free, to count as a passage


@dataclass(frozen=True)
class Part:
    """A part of a leaf at a place on its way: its convex outline (x, y) and the heights between which it is, metres."""

    outline: Outline
    bottom: float
    top: float

    @cached_property
    def bounds(self) -> Bounds:
        """Least and greatest x, y and z, metres."""
        xs, ys = zip(*self.outline, strict=True)
        return (min(xs), min(ys), self.bottom, max(xs), max(ys), self.top)

    def depth_in(self, other: Part) -> float:
        """How deep it overlaps another, seen from above, metres; negative where it does not."""
        return penetration_depth(self.outline, other.outline) if meet(self.bounds, other.bounds) else -math.inf


@dataclass(frozen=True)
class Leaf:
    """A door, a drawer or a flap.

    Attributes:
        owner: unit or opening that it belongs to. run: of that unit; empty for an opening.
        way: its parts at successive places as it opens. stands: its parts when it is open.
        shut: the handle of a wall unit when it is closed; units on the floor are further apart.
        of_appliance: whether it is a part of an appliance. keeps_width: whether it opens in front of its unit only.
    """

    owner: str
    run: str
    way: tuple[Part, ...]
    stands: tuple[Part, ...]
    of_appliance: bool = False
    keeps_width: bool = True
    shut: tuple[Part, ...] = ()

    @cached_property
    def bounds(self) -> Bounds:
        """Least and greatest x, y and z of its whole way, metres."""
        every = np.array([part.bounds for part in self.way])
        low, high = every[:, :3].min(axis=0).tolist(), every[:, 3:].max(axis=0).tolist()
        return (low[0], low[1], low[2], high[0], high[1], high[2])

    def depth_in(self, other: Leaf) -> float:
        """How deep it runs on its way into another that is open, or into the handle of a shut one, metres; else < 0."""
        if not meet(self.bounds, other.bounds):
            return -math.inf
        return max(a.depth_in(b) for a in self.way for b in (*other.stands, *other.shut))

    def depth_in_thing(self, thing: Part) -> float:
        """How deep it runs on its way into something that never moves, metres; negative where it does not."""
        return max(a.depth_in(thing) for a in self.way) if meet(self.bounds, thing.bounds) else -math.inf

    def crossing(self, other: Leaf) -> float:
        """How deep its way overlaps that of another, seen from above, metres; negative where it does not."""
        if not meet(self.bounds, other.bounds):
            return -math.inf
        flat = [[replace(part, bottom=0.0, top=1.0) for part in leaf.way] for leaf in (self, other)]
        return max(a.depth_in(b) for a in flat[0] for b in flat[1])


def meet(one: Bounds, other: Bounds) -> bool:
    """True if two boxes share more than a side."""
    return all(one[k] < other[k + 3] and other[k] < one[k + 3] for k in range(3))


def door_width_clear(hole: WallHole) -> float:
    """Width that an opening leaves to walk through, with its leaf open, metres."""
    frame = 2 * DOOR_FRAME_M + ROOM_DOOR_M + LEAF_GAP_M if hole.opening.kind is OpeningKind.DOOR else 0.0
    return round(hole.right - hole.left - frame, 4)


def fronts_of(slots: Mapping[str, Sequence[UnitSlot]], models: StyleModels) -> dict[str, float]:
    """Unit -> how far before the line of its run its appliance reaches, metres, where that may be beyond a worktop."""
    out = {}
    for slot in (s for row in slots.values() for s in row):
        if isinstance(slot.unit, BaseUnit) and slot.kind in (BaseKind.RANGE, BaseKind.FRIDGE):
            before = RANGE_BEFORE_M if slot.kind is BaseKind.RANGE else FRIDGE_BEHIND_M
            out[slot.name] = round(models.for_unit(slot.unit).length("depth") + before - slot.recess, 4)
    return out


def leaves_of(
    slots: Mapping[str, Sequence[UnitSlot]], holes: Sequence[WallHole], models: StyleModels
) -> tuple[Leaf, ...]:
    """All leaves of a kitchen: those of its units, and the doors of its room."""
    out = [leaf for row in slots.values() for slot in row for leaf in _of_slot(slot, models)]
    return (*out, *(leaf for hole in holes for leaf in _of_opening(hole)))


def _of_slot(slot: UnitSlot, models: StyleModels) -> Iterator[Leaf]:
    front = round(slot.depth - slot.recess, 4)
    place = _Place(slot, front, _handle(models))
    unit = slot.unit
    if slot.kind is CornerPart.DIAGONAL:
        yield place.diagonal(slot.bottom if slot.is_upper else PLINTH_M, slot.top)
    elif slot.is_upper:
        if slot.kind in (UpperKind.DOORS, UpperKind.GLASS, CornerPart.BLIND):
            yield from _doors(place, slot.bottom, slot.top)
        elif slot.kind is UpperKind.MICROWAVE:
            further_out = replace(place, front=round(front + HUNG_MICROWAVE_M, 4))
            yield from _doors(further_out, slot.bottom, slot.top)
    elif slot.kind is CornerPart.BLIND:
        yield from _doors(place, PLINTH_M, slot.top)
    elif slot.kind is BaseKind.DRAWERS:
        yield place.drawer(slot.left, slot.right, PLINTH_M, slot.top)
    elif slot.kind is BaseKind.ISLAND:
        yield from _island(place)
    elif slot.kind in (BaseKind.DOORS, BaseKind.SINK, BaseKind.HOB, BaseKind.PANTRY):
        widest = standard_sizes.WIDEST_SINK_DOOR if slot.kind is BaseKind.SINK else standard_sizes.WIDEST_SINGLE_DOOR
        yield from _doors(place, PLINTH_M, slot.top, widest)
        if isinstance(unit, BaseUnit) and unit.drawers and slot.kind is BaseKind.DOORS:
            yield place.drawer(slot.left, slot.right, slot.top - 0.17, slot.top)
    elif isinstance(unit, BaseUnit):
        yield from _appliance(place, unit, models)


def _handle(models: StyleModels) -> float:
    """Maximum distance by which handles of a style's cabinets protrude, metres."""
    cabinets = models.style.cabinets
    groups = [cabinets.base, *(g.filled_from(cabinets.base) for g in (cabinets.upper, cabinets.tall, cabinets.island))]
    return max(HANDLES_M.get(str(group.handle), MOST_HANDLE_M) for group in groups)


def _island(place: _Place) -> Iterator[Leaf]:
    slot = place.slot
    columns = standard_sizes.island_columns(slot.width)
    start, each = slot.left + standard_sizes.END_PANEL, (slot.width - 2 * standard_sizes.END_PANEL) / len(columns)
    for k, kind in enumerate(columns):
        left, right = start + k * each, start + (k + 1) * each
        if kind == "drawers":
            yield place.drawer(left, right, PLINTH_M, slot.top)
        else:
            yield place.hinged(left, each / 2, True, PLINTH_M, slot.top)
            yield place.hinged(right, each / 2, False, PLINTH_M, slot.top)


def _appliance(place: _Place, unit: BaseUnit, models: StyleModels) -> Iterator[Leaf]:
    """Leaves of a unit with an appliance; empty if nothing of it opens."""
    slot = place.slot
    if unit.kind is BaseKind.RANGE:
        model = models.for_unit(unit)
        behind, drawer = model.params.get("knobs_behind", False), model.params.get("drawer", True)
        reach = RANGE_FLAP_KNOBS_BEHIND_M if behind else RANGE_FLAP_M if drawer else RANGE_FLAP_NO_DRAWER_M
        before = _Place(slot, round(model.length("depth") + RANGE_BEFORE_M, 4))
        yield before.flap(reach, RANGE_FLAP_FROM_M if drawer or behind else FLAP_FROM_M)
        if drawer:
            yield before.slide(slot.left, slot.right, RANGE_DRAWER_M, 0.05, RANGE_FLAP_FROM_M)
    elif unit.kind is BaseKind.DISHWASHER:
        high = min(models.for_unit(unit).length("height"), slot.top)
        yield place.flap(high - DISHWASHER_LESS_M, FLAP_FROM_M)
    elif unit.kind is BaseKind.OVEN:
        yield place.drawer(slot.left, slot.right, PLINTH_M, OVEN_FROM_M)
        high = models.for_unit(unit).length("height")
        yield place.flap(OVEN_SHARE * high, OVEN_FROM_M)
        yield from _doors(place, OVEN_FROM_M + high, slot.top)
    elif unit.kind is BaseKind.MICROWAVE:
        yield place.hinged(slot.left, slot.width, True, PLINTH_M, MICROWAVE_FROM_M)
        yield from _doors(place, MICROWAVE_FROM_M, slot.top)
    elif unit.kind is BaseKind.FRIDGE:
        yield from _fridge(slot, unit, models)
        if unit.housing:
            yield from _doors(place, models.for_unit(unit).length("height") + 0.03, slot.top)


@dataclass(frozen=True)
class _Place:
    """The front of a unit: its slot, its distance from the line of its run, protrusion of its handles; metres."""

    slot: UnitSlot
    front: float
    handle: float = 0.0

    def box(self, left: float, right: float, near: float, far: float, bottom: float, top: float) -> Part:
        """The box between two places along the run, two distances in front of the front and two heights, metres."""
        outline = self.slot.line.frame.rectangle(left, right, self.front + near, self.front + far)
        return Part(outline, bottom, top)

    def leaf(self, way: Sequence[Part], stands: Sequence[Part]) -> Leaf:
        """A leaf of the unit."""
        return Leaf(self.slot.name, self.slot.line.id, tuple(way), tuple(stands))

    def slide(self, left: float, right: float, reach: float, bottom: float, top: float) -> Leaf:
        """A drawer without a protruding handle."""
        parts = (self.box(left, right, GAP_M, reach, bottom, top),)
        return self.leaf(parts, parts)

    def drawer(self, left: float, right: float, bottom: float, top: float) -> Leaf:
        """A drawer of a cabinet, with its handle in the middle."""
        is_deep = self.front > standard_sizes.BASE_DEPTH
        reach = DRAWER_M + (self.front - standard_sizes.BASE_DEPTH - ISLAND_BACK_M if is_deep else 0.0)
        half = min(HANDLE_WIDTH_M, right - left - 2 * GAP_M) / 2
        middle = (left + right) / 2
        count = self.slot.unit.drawers if isinstance(self.slot.unit, BaseUnit) else None
        over = HANDLE_OVER_M if (count or FEW_DRAWERS) <= FEW_DRAWERS and top - bottom > 2 * HANDLE_OVER_M else 0.0
        handle = self.box(middle - half, middle + half, reach, reach + self.handle, bottom + over, top)
        parts = (self.box(left + GAP_M, right - GAP_M, GAP_M, reach, bottom, top), handle)
        return self.leaf(parts, parts)

    def flap(self, reach: float, low: float) -> Leaf:
        """The door of a dishwasher or an oven, which turns down about its lower edge; in pieces, since it is aslant."""
        left, right = self.slot.left + 2 * GAP_M, self.slot.right - 2 * GAP_M
        way: list[Part] = []
        for angle in np.linspace(0.0, FLAP_TRAVEL, STEPS + 1)[1:]:
            out, up = reach * math.sin(angle), reach * math.cos(angle)
            for k in range(FLAP_PIECES):
                near, far = k / FLAP_PIECES, (k + 1) / FLAP_PIECES
                bottom, top = low + near * up - FLAP_BELOW_M, low + far * up + 0.01
                way.append(self.box(left, right, near * out, far * out, bottom, top))
        return replace(self.leaf(way, way[-FLAP_PIECES:]), of_appliance=True)

    def hinged(
        self,
        axis: float,
        width: float,
        is_left: bool,
        bottom: float,
        top: float,
        fridge_pull: float | None = None,
        start: float = 0.0,
    ) -> Leaf:
        """A door whose hinge is at a place along the run; `is_left`: on the left of the door.

        Args:
            fridge_pull: protrusion of the pull from the door of a refrigerator, which opens by a right angle, metres;
                None: a door of a cabinet, which opens only as far as its handle stays within its width.
            start: angle between the closed door and the front of the run, radians.
        """
        edge = HANDLE_FROM_EDGE_M if fridge_pull is None else FRIDGE_PULL_FROM_EDGE_M
        near, far = width - edge[1], width - edge[0]
        is_fridge = fridge_pull is not None
        thick, pull = (DOOR_M, self.handle) if fridge_pull is None else (FRIDGE_DOOR_M, fridge_pull)
        travel = math.pi / 2 if is_fridge else math.atan2(near, pull)
        parts = (((0.0, -thick), (width, 0.0)), ((near, 0.0), (far, pull)))
        outlines = _turned(self.slot.line.frame, axis, self.front, is_left, parts, (start, start + travel))
        way = [Part(outline, bottom, top) for outline in outlines]
        (shut, *_) = _turned(self.slot.line.frame, axis, self.front, is_left, parts[1:], (start, start))
        leaf = replace(self.leaf(way, way[-len(parts) :]), of_appliance=is_fridge)
        return replace(leaf, shut=(Part(shut, bottom, top),) if pull and self.slot.is_upper else ())

    def diagonal(self, bottom: float, top: float) -> Leaf:
        """The door of a corner cabinet with a diagonal front, which opens in front of the unit next to it."""
        slot = self.slot
        is_left = slot.corner is RunSide.RIGHT
        width = (slot.width - slot.depth) * math.sqrt(2.0) - 2 * GAP_M
        axis = slot.left if is_left else slot.right
        return replace(self.hinged(axis, width, is_left, bottom, top, start=math.pi / 4), keeps_width=False)


def _turned(
    frame: WallFrame, axis: float, front: float, is_left: bool, parts: Sequence[tuple[Vec2, Vec2]], span: Vec2
) -> tuple[Outline, ...]:
    """Outlines of the boxes of a door (along it, before it) on its way from shut to open, between two angles."""
    out: list[Outline] = []
    for angle in np.linspace(*span, STEPS + 1)[1:]:
        c, s = math.cos(angle), math.sin(angle)
        for (a0, b0), (a1, b1) in parts:
            corners = [(a * c - b * s, a * s + b * c) for a, b in ((a0, b0), (a1, b0), (a1, b1), (a0, b1))]
            out.append(tuple(frame.at(axis + (a if is_left else -a), front + b)[:2] for a, b in corners))
    return tuple(out)


def _doors(
    place: _Place, bottom: float, top: float, widest: float = standard_sizes.WIDEST_SINGLE_DOOR
) -> Iterator[Leaf]:
    slot = place.slot
    left, right = slot.left, slot.right
    if slot.kind is CornerPart.BLIND:
        upper = slot.is_upper
        blind = standard_sizes.UPPER_CORNER_CLEARANCE if upper else standard_sizes.CORNER_CLEARANCE
        left, right = (left + blind, right) if slot.corner is RunSide.LEFT else (left, right - blind)
    width = round(right - left, 4)
    if width > widest:
        yield place.hinged(left, width / 2, True, bottom, top)
        yield place.hinged(right, width / 2, False, bottom, top)
    elif slot.hinge is RunSide.RIGHT:
        yield place.hinged(right, width, False, bottom, top)
    else:
        yield place.hinged(left, width, True, bottom, top)


def _fridge(slot: UnitSlot, unit: BaseUnit, models: StyleModels) -> Iterator[Leaf]:
    model = models.for_unit(unit)
    wide, deep, high = (model.length(name) for name in ("width", "depth", "height"))
    place = _Place(slot, round(deep + FRIDGE_BEHIND_M - slot.recess, 4))
    left, right = slot.middle - wide / 2, slot.middle + wide / 2
    family = model.choice.family
    sweep = min(float(model.params.get("sweep", 0.0)), standard_sizes.MAX_DOOR_REACH)
    pull = sweep if model.choice.is_library else FRIDGE_PULL_M
    if family in ("fridge_top_freezer", "fridge_bottom_freezer"):
        is_left = not model.params.get("right", True)
        yield place.hinged(left if is_left else right, wide, is_left, PLINTH_M, high, pull)
        return
    share = 0.5 if family == "fridge_french_door" else 0.56
    yield place.hinged(left, share * wide, True, PLINTH_M, high, pull)
    yield place.hinged(right, share * wide, False, PLINTH_M, high, pull)
    if family == "fridge_french_door":
        yield place.slide(left, right, FREEZER_DRAWER_M, PLINTH_M, 0.9)


def _of_opening(hole: WallHole) -> Iterator[Leaf]:
    if hole.opening.kind is not OpeningKind.DOOR:
        return
    frame, is_left = hole.wall.frame, hole.opening.hinge is not RunSide.RIGHT
    width = hole.right - hole.left - 2 * DOOR_FRAME_M
    leaf = ((0.0, -ROOM_DOOR_M), (width, 0.0))
    parts = (leaf, ((width - 0.2, -ROOM_DOOR_M - LEVER_M), (width - 0.04, LEVER_M)))
    axis = hole.left + DOOR_FRAME_M if is_left else hole.right - DOOR_FRAME_M
    outlines = _turned(frame, axis, 0.0, is_left, parts, (0.0, math.pi / 2))
    way = tuple(Part(outline, 0.01, hole.top) for outline in outlines)
    yield Leaf(hole.opening.id, "", way, way[-len(parts) :])


class FaceKind(StrEnum):
    """Side of a run that a face belongs to."""

    FRONT = "front"
    BACK = "back"
    END = "end"
    WALL = "wall"


@dataclass(frozen=True)
class RunFace:
    """An upright face, seen from above: from `start` to `end`, free space to the right of that way."""

    kind: FaceKind
    owner: str
    start: Vec2
    end: Vec2

    @property
    def direction(self) -> np.ndarray:
        """Unit vector from its start to its end."""
        d = np.subtract(self.end, self.start)
        length = float(np.linalg.norm(d))
        return np.asarray(d / length if length else d)

    @property
    def normal(self) -> np.ndarray:
        """Unit vector into the room."""
        x, y = self.direction
        return np.array([y, -x])


def find_aisles(
    runs: Sequence[PlacedRun],
    walls: Sequence[RoomWall],
    outline: Corners,
    columns: Mapping[str, Corners] = MappingProxyType({}),
) -> tuple[Aisle, ...]:
    """Narrowest place between each two faces that look at each other; columns: clockwise from above, metres."""
    faces = [f for run in runs for f in _faces(run)]
    faces += [RunFace(FaceKind.WALL, w.id, w.start, w.end) for w in walls if not w.is_open]
    for name, corners in columns.items():
        # A face has free space to the right of its way.
        faces += [RunFace(FaceKind.WALL, name, a, b) for a, b in zip((*corners[1:], corners[0]), corners, strict=True)]
    # Each run and its bounds: left, right, front.
    bodies = [(run, *run.span, max((u.front for u in run.units), default=run.depth_before)) for run in runs]
    narrowest: dict[tuple[str, str, str], Aisle] = {}
    for face in faces:
        if face.kind is FaceKind.WALL:
            continue
        for aisle in _aisles_before(face, faces, bodies, outline):
            first, second = sorted((aisle.first, aisle.second))
            key = (aisle.kind.value, first, second)
            if key not in narrowest or aisle.width < narrowest[key].width:
                narrowest[key] = aisle.replace(first=first, second=second)
    return tuple(narrowest[key] for key in sorted(narrowest))


def _faces(run: PlacedRun) -> Iterator[RunFace]:
    """Sides of a run: fronts of its units, its back if it is away from walls, and its free ends."""
    for unit in run.units:
        if unit.kind != "gap":
            yield RunFace(FaceKind.FRONT, run.id, run.at(unit.left, unit.front), run.at(unit.right, unit.front))
    if not run.units:
        return
    first, last = run.units[0].left, run.units[-1].right
    if not run.at_wall:
        yield RunFace(FaceKind.BACK, run.id, run.at(last, -run.depth_behind), run.at(first, -run.depth_behind))
    if run.left_end is RunEnd.FREE:
        yield RunFace(FaceKind.END, run.id, run.at(first, -run.depth_behind), run.at(first, run.units[0].front))
    if run.right_end is RunEnd.FREE:
        yield RunFace(FaceKind.END, run.id, run.at(last, run.units[-1].front), run.at(last, -run.depth_behind))


def _aisles_before(
    face: RunFace, faces: Sequence[RunFace], bodies: Sequence[tuple[PlacedRun, float, float, float]], outline: Corners
) -> Iterator[Aisle]:
    """Aisles that rays from a face find: the first other face that they meet."""
    length = float(np.linalg.norm(np.subtract(face.end, face.start)))
    facing = [f for f in faces if float(f.normal @ face.normal) < -0.9 and f is not face]
    found: dict[int, list[tuple[float, float]]] = {}
    half = RAY_SPACING_M / 2
    for u in np.linspace(half, max(length - half, half), max(2, int(length / RAY_SPACING_M))):
        start = np.array(face.start) + u * face.direction
        nearest: tuple[float, int] | None = None
        for k, other in enumerate(facing):
            far = float((np.array(other.start) - start) @ face.normal)
            side = float((start + far * face.normal - np.array(other.start)) @ other.direction)
            size = float(np.linalg.norm(np.subtract(other.end, other.start)))
            if far > MIN_WIDTH_M and 0.0 <= side <= size and (nearest is None or far < nearest[0]):
                nearest = (far, k)
        if nearest is not None:
            found.setdefault(nearest[1], []).append((float(u), nearest[0]))
    for k, hits in found.items():
        other = facing[k]
        if other.owner == face.owner:
            continue
        width = min(d for _, d in hits)
        at = np.array(face.start) + np.mean([u for u, _ in hits]) * face.direction + width / 2 * face.normal
        both = {face.kind, other.kind}
        if both == {FaceKind.FRONT}:
            kind = AisleKind.WORK
        elif FaceKind.FRONT in both or _is_passage(face, hits, width, bodies, outline):
            kind = AisleKind.WALK
        else:
            continue
        middle = (round(float(at[0]), 4), round(float(at[1]), 4))
        yield Aisle(kind=kind, first=face.owner, second=other.owner, width=round(width, 4), position=middle)


def _is_passage(
    face: RunFace,
    hits: Sequence[tuple[float, float]],
    width: float,
    bodies: Sequence[tuple[PlacedRun, float, float, float]],
    outline: Corners,
) -> bool:
    """True if the strip before a face goes on at both ends."""
    for u in (hits[0][0] - PASSAGE_BEYOND_M, hits[-1][0] + PASSAGE_BEYOND_M):
        x, y = np.array(face.start) + u * face.direction + width / 2 * face.normal
        if not contains_point(outline, (float(x), float(y))):
            return False
        for run, left, right, front in bodies:
            along, before = run.to_local((float(x), float(y)))
            if left < along < right and -run.depth_behind < before < front:
                return False
    return True
