"""What the kitchen of a plan would fail its checks by: leaves that clash, narrow aisles, appliances in corners.

The limits are those of registry/limits.yaml, the sizes those of `layouts.plan.swings`. A kitchen of which nothing is
told here should pass.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.geometry.outline import penetration_depth
from casa_assets.layouts.order.furnish import worktop_width
from casa_assets.layouts.order.placed_runs import placed_run
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.order.worktops import WORKTOP_BREAKS
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.aisles import find_aisles
from casa_assets.layouts.plan.room import WallHole
from casa_assets.layouts.plan.runs import UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.plan.swings import Leaf, Part, door_width_clear, fronts_of, leaves_of
from casa_assets.model.kitchen.floor import AisleKind, RoomWall, RunEnd
from casa_assets.model.kitchen.furnishing import WorktopItem
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.units import COOKERS, BaseKind, BaseUnit, UpperKind
from casa_assets.model.record import Vec2
from casa_assets.pipeline.plans.clashes import SILL_BESIDE_M, SILL_M, SILL_UNDER_M
from casa_assets.pipeline.plans.sizes import PresetSizes
from casa_assets.projects import read_once
from casa_assets.registry.load import load_limits
from casa_assets.registry.roles import load_roles

NEAR_CORNER = (
    BaseKind.RANGE, BaseKind.HOB, BaseKind.DISHWASHER, BaseKind.OVEN, BaseKind.MICROWAVE, BaseKind.FRIDGE,
)  # fmt: skip
TOUCH_M = 0.002
PLAY_M = 0.002  # by which leaves as they are built are smaller than they are taken to be here
# Of a worktop over those who sit at it: with less a stool stands in what is below. The usual one is that of the plans.
LEAST_OVERHANG_M, USUAL_OVERHANG_M = 0.25, 0.3
LANDING_PLAY_M = 0.05  # by which things may be narrower than they are taken to be
LEAST_LANDING_M = 0.3  # of worktop beside a sink or a cooker: for less RoboCasa finds no place to set things down on
# Of free worktop in one piece near a microwave or a sink, for the same reason, and how far from it.
LEAST_BY_MICROWAVE_M, LEAST_BY_SINK_M, SET_DOWN_REACH_M = 0.19, 0.1, 0.6
# Deeper in a wall lies what is behind it, round a corner. Height of tables and chairs.
MOST_IN_WALL_M, TABLE_M = 0.11, 0.9


class ProblemKind(StrEnum):
    """Kind of a problem, by what it is a matter of."""

    OVERLAP = "overlap"
    LANDING = "landing"
    WALL = "wall"
    THING = "thing"
    SEATS = "seats"
    TASKS = "tasks"
    SWING = "swing"
    CORNER = "corner"
    AISLE = "aisle"
    DOORWAY = "doorway"
    WINDOW = "window"
    ITEM = "item"
    HOOD = "hood"


@dataclass(frozen=True)
class Problem:
    """Something that a check would find.

    Attributes:
        kind: of it. about: the unit, opening or run that it is told of. owners: all units, openings or runs of it.
        expected, got: as a fault says it. excess: by how much it misses what is expected, metres.
    """

    kind: ProblemKind
    about: str
    owners: frozenset[str]
    expected: str
    got: str
    excess: float


@read_once
def limits() -> Mapping[str, float]:
    """Values of the limits of checks, those of the project in use laid over the others. Raises RegistryError."""
    return {key: limit.value for key, limit in load_limits().items()}


def problems_of(kitchen: KitchenRequest) -> list[Problem]:
    """All problems, those first whose mends change most."""
    models = models_of(kitchen)
    found = [
        *_tasks(kitchen),
        *_aisles(kitchen, models),
        *_overlaps(kitchen),
        *_seats(kitchen),
        *_doorways(kitchen),
        *_windows(kitchen),
        *_items(kitchen, models),
        *_idle_hoods(kitchen),
    ]
    leaves = leaves_of(kitchen.slots, kitchen.holes, models)
    found += [*_landings(kitchen, models), *_corners(kitchen)]
    found += [*_at_walls(kitchen, leaves), *_at_things(kitchen, leaves, models)]
    return [*found, *_swings(leaves)]


def models_of(kitchen: KitchenRequest) -> StyleModels:
    """The models of a kitchen."""
    return StyleModels(kitchen.style, PresetSizes(), load_roles(), kitchen.plan.height)


def _tasks(kitchen: KitchenRequest) -> Iterator[Problem]:
    """What `all_tasks` asks for (TSK001) that the plan has none of; it may have that key from the one it is like."""
    plan = kitchen.plan
    if not plan.all_tasks:
        return
    slots = [s for row in kitchen.slots.values() for s in row]
    doors = [s.width for s in slots if s.is_upper and s.kind in (UpperKind.DOORS, UpperKind.GLASS)]
    kinds = {s.kind for s in slots}
    items = {item.id for item in plan.worktop_items}
    has = {
        "a wall cabinet with two doors": any(width > standard_sizes.WIDEST_SINGLE_DOOR for width in doors),
        "a sink": BaseKind.SINK in kinds,
        "a cooker": bool(kinds & set(COOKERS)),
        "drawers": bool(kinds & {BaseKind.DRAWERS, BaseKind.ISLAND}),
        "a microwave": bool(kinds & {BaseKind.MICROWAVE, UpperKind.MICROWAVE}) or "microwave" in items,
        "a coffee machine": "coffee_machine" in items,
    }
    lacking = [name for name, is_there in has.items() if not is_there]
    if lacking:
        expected = "all that the tasks of RoboCasa need, since the plan says `all_tasks: true`"
        got = f"no {', no '.join(name.removeprefix('a ') for name in lacking)}"
        yield Problem(ProblemKind.TASKS, "all_tasks", frozenset(lacking), expected, got, float(len(lacking)))


def _overlaps(kitchen: KitchenRequest) -> Iterator[Problem]:
    """Wall units that hang where something tall stands, or where those of another run hang."""
    slots = [s for row in kitchen.slots.values() for s in row if s.kind not in (BaseKind.GAP, UpperKind.GAP)]
    uppers = [s for s in slots if s.is_upper]
    for upper in uppers:
        for other in slots:
            if other.is_upper and (other.line is upper.line or uppers.index(other) < uppers.index(upper)):
                continue
            if min(upper.top, other.top) - max(upper.bottom, other.bottom) < TOUCH_M:
                continue
            depth = penetration_depth(_outline(upper), _outline(other))
            if depth > TOUCH_M:
                owners = frozenset((upper.name, other.name))
                expected = f"a place for {upper.name} apart from {other.name}"
                yield Problem(ProblemKind.OVERLAP, upper.name, owners, expected, f"{depth:.2f} m in it", depth)


def _outline(slot: UnitSlot) -> tuple[Vec2, ...]:
    """Corners of a unit, seen from above, metres."""
    back, front = -slot.recess, slot.depth - slot.recess
    stands_free = isinstance(slot.unit, BaseUnit) and slot.kind is BaseKind.FRIDGE and not slot.unit.housing
    air = standard_sizes.FRIDGE_SIDE if stands_free else 0.0
    left, right = slot.left + air, slot.right - air
    ends = ((left, back), (right, back), (right, front), (left, front))
    return tuple(slot.line.frame.at(u, v)[:2] for u, v in ends)


def _seats(kitchen: KitchenRequest) -> Iterator[Problem]:
    """Stools where the worktop does not reach out over those who sit."""
    for seats in kitchen.plan.seats:
        overhang = kitchen.lines[seats.run].run.overhang
        if overhang < LEAST_OVERHANG_M:
            expected = f"a worktop of {seats.run} that reaches at least {LEAST_OVERHANG_M:g} m over those who sit there"
            got = f"an overhang of {overhang:g} m"
            yield Problem(
                ProblemKind.SEATS, seats.run, frozenset((seats.run,)), expected, got, LEAST_OVERHANG_M - overhang
            )


def has_worktop(slot: UnitSlot) -> bool:
    """True if a unit carries a worktop without a hole, on which things can stand."""
    is_low = not slot.is_upper and slot.top <= standard_sizes.WORKTOP_HEIGHT
    return is_low and slot.kind not in (*WORKTOP_BREAKS, BaseKind.SINK, BaseKind.HOB)


def _items(kitchen: KitchenRequest, models: StyleModels) -> Iterator[Problem]:
    """Things on a cooker, in a sink or in a refrigerator; and those that find no room beside each other."""
    row_of: dict[str, list[WorktopItem]] = {}
    for item in kitchen.plan.worktop_items:
        slot = kitchen.slot(item.on)
        row_of.setdefault(item.on, []).append(item)
        if not has_worktop(slot):
            expected = f"a unit with a worktop, on which {item.id} can stand"
            yield Problem(ProblemKind.ITEM, item.id, frozenset((item.id, item.on)), expected, f"{item.on!r}", 1.0)
    for name, items in row_of.items():
        slot = kitchen.slot(name)
        if not has_worktop(slot):
            continue
        row, k = _place_in_row(kitchen, slot)
        room = slot.width + _worktop(row[k + 1 :], {})
        widths = {item.id: worktop_width(models, item) for item in items}
        least = sum(widths.values())
        if least > room + LANDING_PLAY_M:
            largest = max(widths, key=lambda i: (widths[i], i))
            expected = f"at least {least:.2f} m of worktop from the left end of {name} on, for {', '.join(widths)}"
            owners = frozenset((name, *widths))
            yield Problem(ProblemKind.ITEM, largest, owners, expected, f"{room:.2f} m", round(least - room, 4))


def _idle_hoods(kitchen: KitchenRequest) -> Iterator[Problem]:
    """Hoods with no cooker under them."""
    for row in kitchen.slots.values():
        cookers = [s.middle for s in row if s.kind in COOKERS]
        for slot in row:
            if slot.kind is UpperKind.HOOD and not any(slot.left < at < slot.right for at in cookers):
                owners = frozenset((slot.name,))
                yield Problem(ProblemKind.HOOD, slot.name, owners, f"a cooker under {slot.name}", "none", 1.0)


def _landings(kitchen: KitchenRequest, models: StyleModels) -> Iterator[Problem]:
    """Sinks and cookers with no worktop beside them on which things can be set down."""
    taken: dict[str, float] = {}
    for item in kitchen.plan.worktop_items:
        taken[item.on] = taken.get(item.on, 0.0) + worktop_width(models, item)
    for line in kitchen.lines.values():
        row = [s for s in kitchen.slots[line.id] if not s.is_upper]
        for k, slot in enumerate(row):
            if slot.kind not in (BaseKind.SINK, *COOKERS):
                continue
            sides = (row[:k][::-1], row[k + 1 :])
            widest = max(_worktop(side, {}) for side in sides)
            free = max(_worktop(side, taken) for side in sides)
            if slot.kind in COOKERS and widest >= LEAST_LANDING_M > free + LANDING_PLAY_M:
                items = {i.id for i in kitchen.plan.worktop_items} & _on_worktops(kitchen, sides)
                expected = f"at least {LEAST_LANDING_M:g} m of free worktop beside {slot.name}"
                got, less = f"{free:.2f} m beside {', '.join(sorted(items))}", LEAST_LANDING_M - free
                yield Problem(ProblemKind.LANDING, slot.name, frozenset((slot.name, *items)), expected, got, less)
            if widest < LEAST_LANDING_M:
                expected = f"at least {LEAST_LANDING_M:g} m of worktop beside {slot.name}"
                owners = frozenset((slot.name,))
                got, less = f"{widest:.2f} m", LEAST_LANDING_M - widest
                yield Problem(ProblemKind.LANDING, slot.name, owners, expected, got, less)
    yield from _crowded(kitchen, models)


def _crowded(kitchen: KitchenRequest, models: StyleModels) -> Iterator[Problem]:
    """Microwaves and sinks with no free worktop near them to set down what goes in and comes out."""
    for item in kitchen.plan.worktop_items:
        slot = kitchen.slot(item.on)
        if models.role_of(item) == "microwave" and has_worktop(slot):
            row, k = _place_in_row(kitchen, slot)
            top = [*[*_under_worktop(row[:k][::-1])][::-1], slot, *_under_worktop(row[k + 1 :])]
            middle = next(i.spot.u for i in kitchen.items if i.name == item.id)
            reach = worktop_width(models, item) / 2 + SET_DOWN_REACH_M
            free, beside = _largest_free(kitchen, models, top, (middle - reach, middle + reach))
            yield from _too_crowded(item.id, free, LEAST_BY_MICROWAVE_M, beside)
    for slot in (s for row in kitchen.slots.values() for s in row if s.kind is BaseKind.SINK):
        row, k = _place_in_row(kitchen, slot)
        sides = (
            ([*_under_worktop(row[:k][::-1])][::-1], (slot.left - SET_DOWN_REACH_M, slot.left)),
            ([*_under_worktop(row[k + 1 :])], (slot.right, slot.right + SET_DOWN_REACH_M)),
        )
        found = [_largest_free(kitchen, models, top, span) for top, span in sides if top]
        beside = frozenset(name for _, names in found for name in names)
        if beside:
            yield from _too_crowded(slot.name, max(free for free, _ in found), LEAST_BY_SINK_M, beside)


def _too_crowded(about: str, free: float, least: float, beside: frozenset[str]) -> Iterator[Problem]:
    """The problem of something that has less free worktop than it needs, for the things that stand there."""
    if free < least:
        expected = f"at least {least:g} m of free worktop, in one piece, beside {about}"
        got, less = f"{max(free, 0.0):.2f} m", round(least - free, 4)
        yield Problem(ProblemKind.LANDING, about, beside | {about}, expected, got, less)


def _place_in_row(kitchen: KitchenRequest, slot: UnitSlot) -> tuple[list[UnitSlot], int]:
    """The floor units of the run of one, from left to right, and its number among them."""
    row = sorted((s for s in kitchen.slots[slot.line.id] if not s.is_upper), key=lambda s: s.left)
    return row, row.index(slot)


def _largest_free(
    kitchen: KitchenRequest, models: StyleModels, top: Sequence[UnitSlot], span: tuple[float, float]
) -> tuple[float, frozenset[str]]:
    """Longest free piece of a worktop between two places along its run, metres, and the things that stand on it.

    Args:
        top: units under it, from left to right. span: from where to where.
    """
    places = {item.name: item.spot.u for item in kitchen.items}
    on = [i for i in kitchen.plan.worktop_items if i.on in {s.name for s in top}]
    halves = {i.id: worktop_width(models, i) / 2 for i in on}
    free, start = 0.0, top[0].left
    for at, half in (*sorted((places[name], half) for name, half in halves.items()), (top[-1].right, 0.0)):
        free = max(free, min(at - half, span[1]) - max(start, span[0]))
        start = max(start, at + half)
    return free, frozenset(halves)


def _under_worktop(row: Iterable[UnitSlot]) -> Iterator[UnitSlot]:
    """Units from one on that carry a worktop, up to what is tall or let into it."""
    return itertools.takewhile(has_worktop, row)


def _worktop(row: Iterable[UnitSlot], taken: Mapping[str, float]) -> float:
    """Metres of worktop over units from one on, less what things take up there. `taken`: by unit, metres."""
    return round(sum(slot.width - taken.get(slot.name, 0.0) for slot in _under_worktop(row)), 4)


def _on_worktops(kitchen: KitchenRequest, rows: Iterable[Iterable[UnitSlot]]) -> set[str]:
    """Things that stand on the worktops over some rows of units."""
    names = {slot.name for row in rows for slot in _under_worktop(row)}
    return {item.id for item in kitchen.plan.worktop_items if item.on in names}


def _at_walls(kitchen: KitchenRequest, leaves: Iterable[Leaf]) -> Iterator[Problem]:
    """Leaves that run into a wall of the room beside them."""
    own = {h.opening.id: h.wall.id for h in kitchen.holes}
    for leaf in leaves:
        for wall in kitchen.room.walls:
            if wall.open or own.get(leaf.owner) == wall.id:
                continue
            points = [wall.frame.to_local(*p) for part in leaf.way for p in part.outline]
            depth = max((-v for u, v in points if 0.0 < u < wall.length), default=0.0)
            if MOST_IN_WALL_M > depth > limits()["scene_clash_m"]:
                expected = f"room to open {leaf.owner} beside the wall {wall.id}"
                owners, got = frozenset((leaf.owner, wall.id)), f"it runs {depth:.3f} m into it"
                yield Problem(ProblemKind.WALL, leaf.owner, owners, expected, got, depth)


def _inscribed(square: Sequence[Vec2]) -> tuple[Vec2, ...]:
    """Twelve points of the circle in a square, in the order of its corners, metres."""
    (x, y), radius = np.mean(square, axis=0).tolist(), math.dist(square[0], square[1]) / 2
    turns = [math.tau * k / 12 for k in range(12)]
    return tuple((x + radius * math.cos(turn), y + radius * math.sin(turn)) for turn in turns)


def _sill(hole: WallHole) -> Part:
    """The sill of a window."""
    ends = (hole.left - SILL_BESIDE_M, hole.right + SILL_BESIDE_M)
    outline = tuple(
        hole.wall.frame.at(u, v)[:2] for u, v in zip((*ends, *ends[::-1]), (0.0, 0.0, SILL_M, SILL_M), strict=True)
    )
    return Part(outline, hole.bottom - SILL_UNDER_M, hole.bottom)


def _at_things(kitchen: KitchenRequest, leaves: Sequence[Leaf], models: StyleModels) -> Iterator[Problem]:
    """Leaves that run into units of another run, into columns, sills of windows, or tables with their chairs."""
    lines = {s.name: s.line.id for row in kitchen.slots.values() for s in row}
    things = [
        (s.name, Part(_outline(s), s.bottom, s.top))
        for row in kitchen.slots.values()
        for s in row
        if s.kind not in (BaseKind.GAP, UpperKind.GAP)
    ]
    things += [(placed.column.id, Part(placed.outline, 0.0, kitchen.room.height)) for placed in kitchen.room.columns]
    is_round = bool(kitchen.tables) and bool(models.for_role("table").params.get("is_round"))
    things += [
        (n, Part(_inscribed(t.outline) if is_round else t.outline, 0.0, TABLE_M)) for n, t in kitchen.tables.items()
    ]
    things += [(h.opening.id, _sill(h)) for h in kitchen.holes if h.opening.kind is OpeningKind.WINDOW]
    told: set[frozenset[str]] = set()
    for leaf in leaves:
        for name, thing in things:
            owners = frozenset((leaf.owner, name))
            if leaf.owner == name or (leaf.run and leaf.run == lines.get(name)) or owners in told:
                continue
            depth = leaf.depth_in_thing(thing)
            if depth > limits()["scene_clash_m"] + PLAY_M:
                told.add(owners)
                expected, got = f"room to open {leaf.owner} before {name}", f"it runs {depth:.2f} m into it"
                yield Problem(ProblemKind.THING, leaf.owner, owners, expected, got, depth)


def _swings(leaves: Sequence[Leaf]) -> Iterator[Problem]:
    """Leaves that run into others that are open: of two runs, or of a run and a door of the room.

    Those of one run keep to their own widths.
    """
    told: set[frozenset[str]] = set()
    for one, other in itertools.combinations(leaves, 2):
        owners = frozenset((one.owner, other.owner))
        is_one_row = one.run == other.run and bool(one.run) and one.keeps_width and other.keeps_width
        if len(owners) < 2 or is_one_row or owners in told:
            continue
        depth, moved, still = max((a.depth_in(b), a.owner, b.owner) for a, b in ((one, other), (other, one)))
        crossing = one.crossing(other) if _are_kept_apart(one, other) else -1.0
        if depth > limits()["scene_clash_m"] + PLAY_M:
            expected = f"room to open {moved} while {still} is open"
            got = f"they overlap by {depth:.2f} m"
        elif crossing > limits()["swing_m"] + PLAY_M:
            moved, depth = one.owner, crossing
            expected = f"ways of {one.owner} and {other.owner} apart from each other"
            got = f"they cross by {depth:.2f} m"
        else:
            continue
        told.add(owners)
        yield Problem(ProblemKind.SWING, moved, owners, expected, got, depth)


def _are_kept_apart(one: Leaf, other: Leaf) -> bool:
    """True of two appliances, and of one and a door of the room, whose ways may not even cross (NKBA guideline 2)."""
    return (one.of_appliance or not one.run) and (other.of_appliance or not other.run)


def _corners(kitchen: KitchenRequest) -> Iterator[Problem]:
    """Appliances that are too near to an inside corner, and dishwashers before which nobody can stand."""
    for line in kitchen.lines.values():
        for slot in kitchen.slots[line.id]:
            if slot.kind not in NEAR_CORNER:
                continue
            for end, away in ((line.left, slot.left), (line.right, line.length - slot.right)):
                if end.kind is not RunEnd.CORNER:
                    continue
                far = round(away - standard_sizes.WORKTOP_DEPTH, 4)
                key = "dishwasher_m" if slot.kind is BaseKind.DISHWASHER else "corner_m"
                if far < limits()[key] - 1e-6:
                    expected = f"at least {limits()[key]:g} m between {slot.name} and the inside corner"
                    owners = frozenset((slot.name,))
                    yield Problem(ProblemKind.CORNER, slot.name, owners, expected, f"{far:.2f} m", limits()[key] - far)


def _aisles(kitchen: KitchenRequest, models: StyleModels) -> Iterator[Problem]:
    """Aisles that are too narrow to work or to walk in."""
    fronts = fronts_of(kitchen.slots, models)
    runs = [placed_run(line, kitchen.slots[name], fronts) for name, line in kitchen.lines.items()]
    walls = [
        RoomWall(id=w.id, start=w.frame.at(0.0, 0.0)[:2], end=w.frame.at(w.length, 0.0)[:2], is_open=w.open)
        for w in kitchen.room.walls
    ]
    columns = {c.column.id: c.outline for c in kitchen.room.columns}
    work = limits()["compact_aisle_m" if kitchen.plan.compact else "work_aisle_m"]
    for aisle in find_aisles(runs, walls, kitchen.room.outline, columns):
        least = work if aisle.kind is AisleKind.WORK else limits()["walkway_m"]
        if aisle.width < least:
            owners = frozenset((aisle.first, aisle.second))
            about = next(name for name in (aisle.second, aisle.first) if name in kitchen.lines)
            expected = f"an aisle of at least {least:g} m between {aisle.first} and {aisle.second}"
            yield Problem(ProblemKind.AISLE, about, owners, expected, f"{aisle.width:.2f} m", least - aisle.width)


def _doorways(kitchen: KitchenRequest) -> Iterator[Problem]:
    """Doors and passages that are too narrow to walk through."""
    least = limits()["doorway_m"]
    for hole in kitchen.holes:
        clear = door_width_clear(hole)
        if not hole.is_window and not hole.is_niche and clear < least:
            name = hole.opening.id
            expected = f"a door or passage that leaves {least:g} m clear"
            yield Problem(
                ProblemKind.DOORWAY, name, frozenset((name,)), expected, f"{clear:.2f} m", round(least - clear, 4)
            )


def _windows(kitchen: KitchenRequest) -> Iterator[Problem]:
    """Windows over a cooker, which may open."""
    cookers = [s for row in kitchen.slots.values() for s in row if s.kind in COOKERS and s.line.at_wall]
    for hole in kitchen.holes:
        for slot in cookers:
            if hole.opening.kind is not OpeningKind.WINDOW or slot.line.run.on != hole.wall.id:
                continue
            ends = [hole.wall.frame.to_local(*slot.line.frame.at(u, 0.0)[:2])[0] for u in (slot.left, slot.right)]
            shared = round(min(ends[1], hole.right) - max(ends[0], hole.left), 4)
            if shared > 0.0:
                owners = frozenset((hole.opening.id,))
                expected = f"no window over {slot.name}"
                yield Problem(ProblemKind.WINDOW, hole.opening.id, owners, expected, f"{shared:.2f} m of one", shared)
