"""Things of a kitchen that are in each other's way, found on its floor and walls before anything is built."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from casa_assets.geometry.outline import penetration_depth
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.order.room_shell import CASING_WIDTH_M
from casa_assets.layouts.order.trim import CORNICE_DEPTH_M, FLAT_PROFILE
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import WALL_THICKNESS_M, WallHole, WallLine
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import APPLIANCE_ROLES, StyleModels
from casa_assets.model.kitchen.plan import OpeningKind, PlanOpening
from casa_assets.model.kitchen.units import BaseKind, UpperKind
from casa_assets.model.record import Vec2
from casa_assets.pipeline.plans.conflicts import FROM_END_M, WINDOW_FROM_END_M
from casa_assets.pipeline.plans.fault import Fault, Mend, added, removed, replaced, value_at
from casa_assets.pipeline.plans.sizes import PresetSizes, height_bounds, width_bounds
from casa_assets.pipeline.plans.written import (
    appended,
    inserted,
    key_edit,
    row_at,
    unit_at,
    unit_edit,
    with_row,
    with_unit,
    without_key,
)
from casa_assets.registry.edit import Edit, flow_text
from casa_assets.registry.roles import load_roles

TOUCH_M = 0.01
# Ref: NKBA kitchen planning guideline 7: walkways 36 inches wide.
LEAST_AISLE_M = 0.914
CASING_PLAY_M = 0.001  # beside it
CASING_M = 0.08  # beside the hole of a door or window
# What the sill of a window stands out from the wall, reaches beyond the hole, and takes up below it.
SILL_M, SILL_BESIDE_M, SILL_UNDER_M = 0.05, 0.1, 0.05
DOOR_WIDTHS_M = (0.93, 0.83)  # a door of the second would leave too little beside its open leaf
WINDOW_WIDTHS_M = (1.2, 0.9, 0.6)
SAME_PLACE_M, APART_M = 0.05, 0.2  # of things on a wall: where one hides another, and how far it is moved
ITEM_FROM_UNIT_M = 0.08  # between units, or what is on the wall over them, and the middle of a switch
ITEM_FROM_HOLE_M = 0.14  # between an opening and the middle of a switch: its casing, and half of the switch
LEAST_DOOR_M = 1.9
LEAST_ISLAND_M = 0.92  # length of an island that is one piece of furniture: two columns of at least 0.42 m
WIDEST_LEAF_M = 1.2  # a wider one is too heavy for a hand
DOOR_HEIGHT_M = 2.04
ISLAND_BASE = "island_base"  # family
UNIT_ROLES = ("base", "upper", "hood", "sink_base", "pantry", "shelf", "filler", "housing")
SHORT_ISLAND_DOORS = [0.4, 0.6]  # width of the cabinet that lengthens a short island
WIDER_THAN_MODEL_M = 0.03  # how much wider than its appliance a place may be before a gap shows


@dataclass(frozen=True)
class Box:
    """A rectangle on the floor: least and greatest x and y, metres; `aslant`: the corners of one that stands so."""

    x0: float
    y0: float
    x1: float
    y1: float
    aslant: tuple[Vec2, ...] = ()

    @property
    def corners(self) -> tuple[Vec2, ...]:
        """Corners (x, y), in order, metres."""
        return self.aslant or ((self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1))

    def overlaps(self, other: Box) -> bool:
        """True if the two share more than an edge."""
        return self.gap(other) < -TOUCH_M

    def gap(self, other: Box) -> float:
        """Distance along the side that parts them best, metres; negative where they overlap."""
        return -penetration_depth(self.corners, other.corners)


def clash_faults(raw: Any, kitchen: KitchenRequest) -> list[Fault]:
    """All of them; where rows clash, what hangs on them is looked at when they no longer do."""
    found = [*_widths(raw, kitchen), *_sizes_of_openings(raw, kitchen), *_short_islands(raw, kitchen)]
    found = found or [*_rows(raw, kitchen)]
    found = found or [*_openings(raw, kitchen), *_behind_walls(raw, kitchen), *_entries(raw, kitchen)]
    return found or [*_hoods(raw, kitchen), *_on_walls(raw, kitchen), *_lamps_in_cabinets(raw, kitchen)]


# Widths ----------------------------------------------------------------------------------------------------------


def _widths(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Units that are narrower than their appliance, or than can be built, or wider."""
    places = {
        u.id: (r.id, row, k)
        for r in kitchen.plan.runs
        for row, units in (("base", r.base), ("upper", r.upper))
        for k, u in enumerate(units)
    }
    told: set[str] = set()
    models = _usual_widths(kitchen)
    for name, (run, row, k) in places.items():
        slot = next((s for s in kitchen.slots[run] if s.name == name), None)
        if slot is None or name not in models or slot.unit is None or slot.unit.width is None:
            continue
        least, most = models[name]
        if slot.width < least - 0.0015 or slot.width > most + WIDER_THAN_MODEL_M:
            told.add(name)
            at = unit_at(raw, run, row, k)
            mend = Mend(f"Take the width of {name} out: it follows from its model.", (without_key(raw, at, "width"),))
            yield Fault(at, f"{least:g} to {most:g} m, by the style's model", f"{slot.width:g} m", mend)
    for item in kitchen.items:
        bounds, width = width_bounds(item.choice.family), item.choice.params.get("width")
        if bounds is not None and item.choice.family == ISLAND_BASE:
            bounds = (LEAST_ISLAND_M, bounds[1])
        if bounds is None or width is None or item.unit not in places or item.unit in told:
            continue
        if not bounds[0] - 1e-6 <= width <= bounds[1] + 1e-6 and item.role in UNIT_ROLES:
            told.add(item.unit)
            yield _unbuildable(raw, kitchen, item.unit, places[item.unit], width, bounds)


def _sizes_of_openings(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Windows and doors that are larger or smaller than they can be built, and leaves that are too heavy."""
    made = {item.name: item.choice for item in kitchen.items}
    for opening in kitchen.plan.openings:
        at, choice = row_at(raw, "openings", opening.id), made.get(opening.id)
        if opening.kind is OpeningKind.DOOR and opening.width > WIDEST_LEAF_M:
            expected = f"a leaf of at most {WIDEST_LEAF_M:g} m, or a passage"
            mend = Mend("Write `kind: passage`.", tuple(without_leaf(raw, opening.id)))
            yield Fault((*at, "width"), expected, f"{opening.width:g} m", mend)
            continue
        for key, bounds in (("width", width_bounds), ("height", height_bounds)):
            span, made_of = (bounds(choice.family), choice.params.get(key)) if choice else (None, None)
            if span is not None and made_of is not None and not span[0] - 1e-6 <= made_of <= span[1] + 1e-6:
                # A leaf is smaller than its hole, by as much at each size.
                more = getattr(opening, key) - made_of
                least, most = round(span[0] + more, 4), round(span[1] + more, 4)
                fits = least if made_of < span[0] else most
                if key == "height" and opening.kind is OpeningKind.DOOR and made_of < span[0]:
                    fits = DOOR_HEIGHT_M
                mend = Mend(f"Write `{key}: {fits:g}`.", (key_edit(raw, at, key, fits),))
                expected = f"a {key} from {least:g} to {most:g} m"
                yield Fault((*at, key), expected, f"{getattr(opening, key):g} m", mend)


def _short_islands(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Islands and peninsulas that are shorter than a worktop of one piece, which gets a cabinet more."""
    for item in kitchen.items:
        bounds, width = width_bounds(item.choice.family), item.choice.params.get("width")
        if item.role != "island" or bounds is None or width is None or width >= bounds[0] - 1e-6:
            continue
        at, run = row_at(raw, "runs", item.run), kitchen.lines[item.run].run
        if all(unit.kind in (BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.SHELF, BaseKind.PANEL) for unit in run.base):
            yield Fault(
                at, f"a worktop of at least {bounds[0]:g} m", f"{width:g} m", without_run(raw, kitchen, item.run)
            )
            continue
        edits = [inserted((*at, "base", len(run.base)), {"doors": SHORT_ISLAND_DOORS})]
        edits += [removed((*at, "length"))] if run.length is not None else []
        mend = Mend(f"Add `- doors: {flow_text(SHORT_ISLAND_DOORS)}` to {item.run}.", tuple(edits))
        yield Fault(at, f"a worktop of at least {bounds[0]:g} m", f"{width:g} m", mend)


def _usual_widths(kitchen: KitchenRequest) -> dict[str, tuple[float, float]]:
    """Unit -> least and greatest width by the model of its appliance."""
    models = StyleModels(kitchen.style, PresetSizes(), load_roles(), kitchen.plan.height)
    out = {}
    for run in kitchen.plan.runs:
        for unit in run.base:
            if unit.kind in APPLIANCE_ROLES and models.for_unit(unit).choice.is_library:
                continue  # it is scaled to the width that is stated, or refused
            if unit.kind in (BaseKind.RANGE, BaseKind.DISHWASHER):
                span = standard_sizes.base_span(unit.replace(width=None), models)
                out[unit.id] = (span.minimum, span.maximum)
            elif unit.kind in (BaseKind.FRIDGE, BaseKind.OVEN, BaseKind.SINK, BaseKind.HOB):
                span = standard_sizes.base_span(unit.replace(width=None), models)
                out[unit.id] = (span.minimum, max(span.maximum, 1.2))
    return out


def _unbuildable(
    raw: Any, kitchen: KitchenRequest, name: str, place: tuple[str, str, int], width: float, bounds: tuple[float, float]
) -> Fault:
    run, row, k = place
    at = unit_at(raw, run, row, k)
    expected, got = f"a width from {bounds[0]:g} to {bounds[1]:g} m", f"{width:g} m"
    unit = next(s for s in kitchen.slots[run] if s.name == name).unit
    stated = unit.width if unit is not None else None
    if width > bounds[1] and not isinstance(stated, tuple):
        count = int(-(-width // min(bounds[1], 0.9)))
        each = round(width / count, 3)
        kind = unit.kind.value if unit is not None else ""
        edits = (
            unit_edit(raw, at, "width", each),
            *(inserted((*at[:-1], k + 1), {kind: each}) for _ in range(count - 1)),
        )
        return Fault(at, expected, got, Mend(f"Write {count} of {each:g} m.", edits))
    low = max(stated[0], bounds[0]) if isinstance(stated, tuple) else bounds[0]
    high = min(max(stated[1], low), bounds[1]) if isinstance(stated, tuple) else max(low, min(width, bounds[1]))
    value: Any = [low, high] if isinstance(stated, tuple) else low
    return Fault(at, expected, got, Mend(f"Write {flow_text(value)}.", (unit_edit(raw, at, "width", value),)))


# Rows ------------------------------------------------------------------------------------------------------------


def box_of(line: RunLine, left: float, right: float, back: float, front: float) -> Box:
    """The rectangle between two places along a run and two before it."""
    points = [line.frame.at(u, v)[:2] for u, v in ((left, back), (right, back), (right, front), (left, front))]
    xs, ys = zip(*points, strict=True)
    return Box(min(xs), min(ys), max(xs), max(ys), () if line.frame.is_aligned else tuple(points))


def row_box(kitchen: KitchenRequest, name: str) -> Box | None:
    """The rectangle of the units of a run that stand on the floor, with its overhang; None where it has none."""
    slots = [s for s in kitchen.slots[name] if not s.is_upper and s.kind is not BaseKind.GAP]
    if not slots:
        return None
    line = kitchen.lines[name]
    back = 0.0 if line.at_wall else -line.run.overhang
    return box_of(line, min(s.left for s in slots), max(s.right for s in slots), back, line.depth)


def _rows(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Runs that overlap, leave too narrow an aisle, or stand outside."""
    boxes = {name: box for name in kitchen.lines if (box := row_box(kitchen, name)) is not None}
    corners = {frozenset(c.runs) for c in kitchen.plan.corners}
    joined = {frozenset((r.id, r.joins.run)) for r in kitchen.plan.runs if r.joins}
    names = list(boxes)
    for i, name in enumerate(names):
        line = kitchen.lines[name]
        if not line.at_wall and (outside := _outside(raw, kitchen, name, boxes[name])):
            yield outside
            return
        for other in names[:i]:
            pair = frozenset((name, other))
            if pair in corners or (pair in joined and boxes[name].overlaps(boxes[other]) is False):
                continue
            gap = boxes[name].gap(boxes[other])
            both_at_wall = line.at_wall and kitchen.lines[other].at_wall
            if gap < -TOUCH_M:
                yield _overlap(raw, kitchen, name, other, boxes)
                return
            if (
                gap < LEAST_AISLE_M
                and pair not in joined
                and _face(line, kitchen.lines[other], boxes[name], boxes[other])
            ):
                yield _narrow(raw, kitchen, name, other, gap, both_at_wall)
                return


def _face(line: RunLine, other: RunLine, a: Box, b: Box) -> bool:
    """True if people walk between two runs: they lie beside each other, and one has its front there."""
    beside_x = min(a.x1, b.x1) - max(a.x0, b.x0) > 0.3
    beside_y = min(a.y1, b.y1) - max(a.y0, b.y0) > 0.3
    if not (beside_x or beside_y):
        return False
    turn = abs((line.frame.turn_deg - other.frame.turn_deg + 180.0) % 360.0 - 180.0)
    return not (line.at_wall and other.at_wall and turn < 90.0)


def _outside(raw: Any, kitchen: KitchenRequest, name: str, box: Box) -> Fault | None:
    room = kitchen.room
    (x0, y0), (x1, y1) = room.bounds()
    corners = [(x, y) for x in (box.x0 + 0.01, box.x1 - 0.01) for y in (box.y0 + 0.01, box.y1 - 0.01)]
    beyond = max(x0 - box.x0, y0 - box.y0, box.x1 - x1, box.y1 - y1)
    closed = [w for w in room.walls if not w.open]
    near = min((_to_wall(w, box) for w in closed), default=LEAST_AISLE_M)
    inside = all(room.contains(*p) for p in corners)
    is_island = kitchen.lines[name].is_island
    if inside and (not is_island or near >= LEAST_AISLE_M - 0.2):
        return None
    expected = f"a row inside the room, {LEAST_AISLE_M} m from its walls"
    got = f"{max(beyond, 0.0):.2f} m outside" if not inside else f"{near:.2f} m"
    return Fault(row_at(raw, "runs", name), expected, got, smaller_island(raw, kitchen, name))


def _to_wall(wall: WallLine, box: Box) -> float:
    """Distance of a rectangle from a wall that it lies before; large where it does not."""
    points = [wall.frame.to_local(x, y) for x in (box.x0, box.x1) for y in (box.y0, box.y1)]
    along = [u for u, _ in points]
    if max(along) < 0.05 or min(along) > wall.length - 0.05:
        return 99.0
    return min(v for _, v in points)


def smaller_island(raw: Any, kitchen: KitchenRequest, name: str) -> Mend:
    """What makes room round an island or peninsula: no overhang, a narrower aisle, the middle, less length, none."""
    run = kitchen.lines[name].run
    at = row_at(raw, "runs", name)
    if run.faces is not None:
        if run.faces.shift:
            return Mend(f"Take out 'shift' of {name}.", (removed((*at, "faces", "shift")),))
        if run.faces.aisle > 1.0:
            return Mend(f"Write `aisle: 1.0` for {name}.", (key_edit(raw, (*at, "faces"), "aisle", 1.0),))
        if run.faces.in_front_of:
            return Mend(f"Take out 'in_front_of' of {name}.", (removed((*at, "faces", "in_front_of")),))
    if run.overhang:
        edits = [removed((*at, "overhang"))]
        edits += [
            removed(("seats", k))
            for k in range(len(kitchen.plan.seats) - 1, -1, -1)
            if kitchen.plan.seats[k].run == name
        ]
        return Mend(f"Take out the overhang and the seats of {name}.", tuple(edits))
    if [u.kind for u in run.base] == [BaseKind.ISLAND] and kitchen.lines[name].length > LEAST_ISLAND_M + 0.05:
        width = round(max(kitchen.lines[name].length - 0.3, LEAST_ISLAND_M), 2)
        return Mend(f"Write `island: {width:g}`.", (unit_edit(raw, unit_at(raw, name, "base", 0), "width", width),))
    soft = [
        k
        for k, u in enumerate(run.base)
        if u.kind in (BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.SHELF, BaseKind.PANEL)
    ]
    if len(soft) > 1:
        k = soft[-1]
        edits = [removed(unit_at(raw, name, "base", k))]
        edits += [removed((*at, "length"))] if run.length is not None else []
        return Mend(f"Take out {run.base[k].id}.", tuple(edits))
    return without_run(raw, kitchen, name)


def without_run(raw: Any, kitchen: KitchenRequest, name: str) -> Mend:
    """Take a run out, with its seats, corners and lamps, and those that stand before it."""
    plan = kitchen.plan
    edits: list[Edit] = []
    for table, rows in (("seats", plan.seats), ("lamps", plan.lamps), ("corners", plan.corners)):
        for k in range(len(rows) - 1, -1, -1):
            row: Any = rows[k]
            named = row.runs if table == "corners" else (row.run if table == "seats" else row.over,)
            if name in named:
                edits.append(removed((table, k)))
    edits.append(removed(row_at(raw, "runs", name)))
    return Mend(f"Take out the run {name}: there is no room for it.", tuple(edits))


def _overlap(raw: Any, kitchen: KitchenRequest, name: str, other: str, boxes: dict[str, Box]) -> Fault:
    one, two = kitchen.lines[name], kitchen.lines[other]
    at = row_at(raw, "runs", name)
    expected, got = f"a place of its own, apart from {other}", "the two overlap"
    if not (one.at_wall and two.at_wall):
        free = name if not one.at_wall else other
        return Fault(row_at(raw, "runs", free), expected, got, smaller_island(raw, kitchen, free))
    if one.run.on == two.run.on:
        return Fault(at, expected, got, _side_by_side(raw, kitchen, one, two))
    walls = [w.id for w in kitchen.room.walls]
    i, j = walls.index(str(two.run.on)), walls.index(str(one.run.on))
    pair = [other, name] if (i + 1) % len(walls) == j else [name, other] if (j + 1) % len(walls) == i else None
    if pair is None:
        return Fault(at, expected, got, without_run(raw, kitchen, name))
    row = {"runs": pair, "base": "blind"}
    return Fault(
        ("corners",),
        f"a corner of {pair[0]} and {pair[1]}",
        "none",
        Mend(f"Add the corner {flow_text(row)}.", (appended(raw, "corners", row),)),
    )


def _side_by_side(raw: Any, kitchen: KitchenRequest, one: RunLine, two: RunLine) -> Mend:
    """Two runs at one wall: the second goes to a wall that has none; else each has the half on its side, or it goes."""
    at = row_at(raw, "runs", one.id)
    used = {run.on for run in kitchen.plan.runs}
    free = next((w.id for w in kitchen.room.walls if w.id not in used and not w.open), None)
    if free is not None:
        return Mend(f"Write `on: {free}` for {one.id}.", (key_edit(raw, at, "on", free),))
    length = next(w for w in kitchen.room.walls if w.id == one.run.on).length
    models = StyleModels(kitchen.style, PresetSizes(), load_roles(), kitchen.plan.height)
    least = [sum(standard_sizes.base_span(u, models).minimum for u in line.run.base) for line in (one, two)]
    half = round(length / 2, 2)
    if max(least) > half:
        return without_run(raw, kitchen, one.id)
    edits = (
        key_edit(raw, row_at(raw, "runs", two.id), "end", round(length - half, 2)),
        key_edit(raw, at, "start", half),
    )
    return Mend(f"Let {two.id} end, and {one.id} begin, in the middle of the wall.", edits)


def _narrow(raw: Any, kitchen: KitchenRequest, name: str, other: str, gap: float, both_at_wall: bool) -> Fault:
    expected, got = f"an aisle of at least {LEAST_AISLE_M} m", f"{gap:.2f} m between {other} and {name}"
    at = row_at(raw, "runs", name)
    if not both_at_wall:
        free = name if not kitchen.lines[name].at_wall else other
        line = kitchen.lines[free]
        faces = line.run.faces
        if faces is not None and faces.run in (name, other) and line.run.faces is not None:
            return Fault(at, expected, got, Mend("Write `aisle: 1.2`.", (key_edit(raw, (*at, "faces"), "aisle", 1.2),)))
        return Fault(row_at(raw, "runs", free), expected, got, smaller_island(raw, kitchen, free))
    mend = wider_room(raw, kitchen, kitchen.lines[name], LEAST_AISLE_M + 0.12 - gap)
    return Fault(at, expected, got, mend or without_run(raw, kitchen, name))


def wider_room(raw: Any, kitchen: KitchenRequest, line: RunLine, more: float, along: bool = False) -> Mend | None:
    """Walls across a row made longer, so that others are further from it; where they are numbers or one parameter.

    Args:
        more: metres. along: walls along the row, instead, so that it is longer.
    """
    turns = {w.id: (kitchen_turns(kitchen, w.id) - line.frame.quarter_turns) % 2 for w in kitchen.plan.walls}
    walls = [w for w in kitchen.plan.walls if turns[w.id] == (0 if along else 1)]
    names = {w.length for w in walls if w.length is not None}
    edits, said = [], []
    if len(walls) != 2 or len(names) != 1:
        return None
    (name,) = names
    if isinstance(name, str):
        p = kitchen.plan.parameters[name]
        value = [round(p.default + more + 0.005, 2), round(p.low + more + 0.005, 2), round(p.high + more + 0.005, 2)]
        return Mend(f"Write {name}: {flow_text(value)}.", (replaced(("parameters", name), value),))
    for wall in walls:
        if wall.length is not None:
            length = round(float(wall.length) + more + 0.005, 2)
            edits.append(key_edit(raw, row_at(raw, "walls", wall.id), "length", length))
            said.append(f"`length: {length:g}` for {wall.id}")
    return Mend(f"Write {' and '.join(said)}.", tuple(edits))


def kitchen_turns(kitchen: KitchenRequest, wall: str) -> int:
    """Quarter turns of a wall's frame."""
    return next(w for w in kitchen.room.walls if w.id == wall).frame.quarter_turns


# Openings --------------------------------------------------------------------------------------------------------


def stretches(
    kitchen: KitchenRequest, wall: WallLine, low: float, high: float, is_niche: bool = False
) -> list[tuple[float, float]]:
    """Stretches of a wall that units stand or hang before between two heights, metres from its left end.

    Args:
        is_niche: leave out what stands back into a niche.
    """
    out = []
    for name, line in kitchen.lines.items():
        for slot in kitchen.slots[name]:
            if slot.kind in (BaseKind.GAP, UpperKind.GAP) or slot.top <= low or slot.bottom >= high:
                continue
            if is_niche and slot.recess:
                continue
            back = 0.0 if line.at_wall else -line.run.overhang
            points = [
                wall.frame.to_local(*line.frame.at(u, v)[:2])
                for u in (slot.left, slot.right)
                for v in (back, slot.depth)
            ]
            along, before = [u for u, _ in points], [v for _, v in points]
            if min(before) < 0.05 and max(before) > 0.02 and max(along) > 0.0 and min(along) < wall.length:
                out.append((round(min(along), 4), round(max(along), 4)))
    return sorted(out)


def _openings(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    for k, hole in enumerate(kitchen.holes):
        at = row_at(raw, "openings", hole.opening.id)
        others = [h for h in kitchen.holes[:k] if h.wall.id == hole.wall.id]
        beside = next((h for h in others if h.left < hole.right + 0.05 and h.right > hole.left - 0.05), None)
        blocked = _before_opening(kitchen, hole)
        if not hole.is_window and not hole.is_niche and hole.top < LEAST_DOOR_M:
            mend = Mend(f"Write `height: {DOOR_HEIGHT_M:g}`.", (key_edit(raw, at, "height", DOOR_HEIGHT_M),))
            yield Fault(at, "a door or passage that people walk through", f"{hole.top:g} m high", mend)
        elif hole.is_window and blocked and (gap := _gap_over(raw, kitchen, hole)):
            yield Fault(at, "no wall units before the window", f"one from {blocked[0][0]:.2f} m", gap)
        elif beside is not None or blocked:
            what = beside.opening.id if beside else "units"
            got = f"{hole.left:.2f} to {hole.right:.2f} m, where {what} {'is' if beside else 'are'}"
            yield Fault(at, "a place on a wall where nothing else is", got, moved_opening(raw, kitchen, hole))


def _before_opening(kitchen: KitchenRequest, hole: WallHole) -> list[tuple[float, float]]:
    """Stretches of units before an opening, its casing or the sill of a window, metres along the wall."""
    low, casing = max(hole.bottom, 0.05), 0.0 if hole.is_niche else _casing(kitchen, hole.is_window)
    parts = [(low, hole.top + casing, -TOUCH_M if hole.is_niche else _beside_casing(kitchen, hole.top, hole.is_window))]
    if hole.is_window:
        parts.append((low - SILL_UNDER_M, low, SILL_BESIDE_M))
    return [
        s
        for bottom, top, beside in parts
        for s in stretches(kitchen, hole.wall, bottom, top, is_niche=hole.is_niche)
        if s[0] < hole.right + beside - 1e-3 and s[1] > hole.left - beside + 1e-3
    ]


def _casing(kitchen: KitchenRequest, is_window: bool) -> float:
    """Width of the casing of the style's windows, or of its doors, metres."""
    models = StyleModels(kitchen.style, PresetSizes(), load_roles(), kitchen.plan.height)
    role = "window" if is_window else "door"
    return float(models.for_role(role).params.get("casing", CASING_WIDTH_M)) if models.has(role) else CASING_WIDTH_M


def _beside_casing(kitchen: KitchenRequest, top: float, is_window: bool) -> float:
    """What is kept free beside a hole that reaches up to a height: its casing, and cornices beside that. Metres."""
    casing = _casing(kitchen, is_window)
    is_high = top + casing > standard_sizes.UPPER_TO + 2 * TOUCH_M
    has_profile = kitchen.style.cabinets.cornice not in (None, FLAT_PROFILE)
    return casing + CASING_PLAY_M + (CORNICE_DEPTH_M if is_high and has_profile else 0.0)


def _entries(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """A room that nobody gets into: all its walls are closed, and no door or passage leads in."""
    walls = kitchen.room.walls
    if any(w.open for w in walls) or any(not h.is_window and not h.is_niche for h in kitchen.holes):
        return
    width, height = DOOR_WIDTHS_M[0], DOOR_HEIGHT_M
    free = {w.id: free_middle(kitchen, w, 0.05, height, width, w.length / 2) for w in walls}
    named = {run.on for run in kitchen.plan.runs}
    mend: Mend | None = None
    for wall in sorted(walls, key=lambda w: (w.id in named, -w.length)):
        if free[wall.id] is not None:
            row = {"id": "door", "kind": "door", "wall": wall.id, "at": free[wall.id], "width": width, "height": height}
            mend = Mend(f"Add a door: `wall: {wall.id}, at: {free[wall.id]:g}`.", (with_row(raw, "openings", row),))
            break
    yield Fault(("walls",), "a door, a passage or an `open` wall, by which one gets in", "none of them", mend)


def _gap_over(raw: Any, kitchen: KitchenRequest, hole: WallHole) -> Mend | None:
    """A gap in the row of wall units over the unit that a window is over, where only these are in its way."""
    over, wall = hole.opening.over, hole.wall
    run = next((r for r in kitchen.plan.runs if any(u.id == over for u in r.base)), None)
    if run is None or not run.upper or run.on != wall.id or any(u.over == over for u in run.upper):
        return None
    if any(
        a < hole.right and b > hole.left
        for a, b in stretches(kitchen, wall, max(hole.bottom, 0.05), standard_sizes.UPPER_FROM - 0.1)
    ):
        return None
    slots = {s.name: s for s in kitchen.slots[run.id]}
    middle = slots[str(over)].middle
    beside = max(SILL_BESIDE_M, _beside_casing(kitchen, hole.top, True)) + 0.001
    reach = (hole.right - hole.left) / 2 + beside
    if any(s.kind is UpperKind.HOOD and s.left < middle + reach and s.right > middle - reach for s in slots.values()):
        return None
    before = [k for k, u in enumerate(run.upper) if u.id in slots and slots[u.id].middle < middle]
    at = (*row_at(raw, "runs", run.id), "upper", (max(before) + 1) if before else 0)
    unit = {"gap": {"over": over, "width": math.ceil(100 * 2 * reach) / 100}}
    return Mend(f"Leave a gap in the wall units of {run.id} over {over}.", (inserted(at, unit),))


def moved_opening(raw: Any, kitchen: KitchenRequest, hole: WallHole) -> Mend:
    """The nearest place that holds an opening, on its wall, then on another, narrower if need be; else it goes.

    A door that nobody could walk through if it were narrower becomes a passage first, which is as wide as its hole.
    """
    opening, at = hole.opening, row_at(raw, "openings", hole.opening.id)
    walls = [hole.wall, *(w for w in kitchen.room.walls if w.id != hole.wall.id and not w.open)]
    for kind, widths in _smaller(opening):
        for wall, width in ((wall, width) for wall in walls for width in widths):
            middle = _free_place(kitchen, wall, hole, width)
            if middle is None:
                continue
            edits = [removed((*at, "over"))] if opening.over is not None else []
            edits.append(added((*at, "at"), middle) if opening.over is not None else key_edit(raw, at, "at", middle))
            said = f"at: {middle:g}"
            if width != opening.width:
                edits.append(key_edit(raw, at, "width", width))
                said += f", width: {width:g}"
            if wall.id != hole.wall.id:
                edits.append(key_edit(raw, at, "wall", wall.id))
                said = f"wall: {wall.id}, {said}"
            if kind is not opening.kind:
                edits += without_leaf(raw, opening.id)
                said = f"kind: {kind.value}, {said}"
            return Mend(f"Write `{said}` for {opening.id}.", tuple(edits))
    return Mend(f"Take out {opening.id}: no wall has a place for it.", (removed(at),))


def _smaller(opening: PlanOpening) -> Iterator[tuple[OpeningKind, tuple[float, ...]]]:
    """Kinds and widths that an opening may have, its own first."""
    usual = {OpeningKind.DOOR: DOOR_WIDTHS_M[:1], OpeningKind.PASSAGE: DOOR_WIDTHS_M}.get(opening.kind, WINDOW_WIDTHS_M)
    yield opening.kind, (opening.width, *(w for w in usual if w < opening.width))
    if opening.kind is OpeningKind.DOOR and opening.closet is None:
        yield OpeningKind.PASSAGE, DOOR_WIDTHS_M


def without_leaf(raw: Any, name: str) -> list[Edit]:
    """The edits that make a door a passage."""
    at = row_at(raw, "openings", name)
    row = value_at(raw, at)
    edits = [key_edit(raw, at, "kind", OpeningKind.PASSAGE.value)]
    return [*edits, removed((*at, "hinge"))] if isinstance(row, dict) and "hinge" in row else edits


def _free_place(kitchen: KitchenRequest, wall: WallLine, hole: WallHole, width: float) -> float | None:
    """Middle of the free place on a wall that is nearest to where an opening is, metres from its left end."""
    wanted = (hole.left + hole.right) / 2 if wall.id == hole.wall.id else wall.length / 2
    return free_middle(kitchen, wall, max(hole.bottom, 0.05), hole.top, width, wanted, hole)


def free_middle(
    kitchen: KitchenRequest,
    wall: WallLine,
    low: float,
    high: float,
    width: float,
    wanted: float,
    besides: WallHole | None = None,
) -> float | None:
    """Middle of a free place on a wall, the nearest to one that is wanted; metres from the wall's left end.

    Args:
        low, high: heights between which it has to be free. besides: opening that is not in its own way.
    """
    taken = stretches(kitchen, wall, low if low <= 0.05 else low - SILL_UNDER_M, high + CASING_WIDTH_M)
    holes = [h for h in kitchen.holes if h.wall.id == wall.id and h is not besides]
    taken += [(h.left - CASING_M, h.right + CASING_M) for h in holes]
    best: float | None = None
    # The sill of a window reaches beyond its casing.
    from_end = FROM_END_M if low <= 0.05 else WINDOW_FROM_END_M
    start, casing = from_end, CASING_M if low <= 0.05 else SILL_BESIDE_M
    casing = max(casing, _beside_casing(kitchen, high, low > 0.05))
    for left, right in [*sorted(taken), (wall.length - from_end, wall.length)]:
        first, last = start + width / 2, left - width / 2
        # Beside units and other openings a casing has to find room too.
        first += casing if start > from_end else 0.0
        last -= casing if left < wall.length - from_end else 0.0
        if first <= last + 1e-6:
            middle = min(max(wanted, first), last)
            if best is None or abs(middle - wanted) < abs(best - wanted):
                best = middle
        start = max(start, right)
    return None if best is None else round(best, 3)


def _lamps_in_cabinets(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Rows of lamps over a run that has wall units or tall ones, in which they would hang."""
    for k, lamps in enumerate(kitchen.plan.lamps):
        line = kitchen.lines.get(lamps.over or "")
        if line is None or not line.at_wall:
            continue
        if any(
            s.top > standard_sizes.UPPER_FROM and s.kind not in (BaseKind.GAP, UpperKind.GAP)
            for s in kitchen.slots[line.id]
        ):
            expected = f"an island, a table, or a row without wall units and tall ones, to hang {lamps.item} over"
            at = ("lamps", k)
            yield Fault((*at, "over"), expected, repr(lamps.over), Mend("Take out these lamps.", (removed(at),)))


# Hoods and walls -------------------------------------------------------------------------------------------------


def _hoods(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Cookers at a wall that have no hood over them."""
    for name, line in kitchen.lines.items():
        if not line.at_wall:
            continue
        slots = kitchen.slots[name]
        hoods = [s for s in slots if s.kind in (UpperKind.HOOD, UpperKind.MICROWAVE)]
        for slot in slots:
            if slot.kind not in (BaseKind.RANGE, BaseKind.HOB) or any(h.left < slot.middle < h.right for h in hoods):
                continue
            uppers = line.run.upper
            index = sum(
                1 for u in uppers if (s := next((x for x in slots if x.name == u.id), None)) and s.middle < slot.middle
            )
            index = max(index, _behind_gaps(uppers, slots, slot))
            own = next((k for k, u in enumerate(uppers) if u.over == slot.name), None)
            if own is not None:
                at = unit_at(raw, name, "upper", own)
                edits = (replaced(at, {"hood": {"over": slot.name}}),)
            else:
                edits = (with_unit(raw, name, "upper", index, {"hood": {"over": slot.name}}),)
            mend = Mend(f"Add `- hood: {{over: {slot.name}}}` to the wall units of {name}.", edits)
            yield Fault((*row_at(raw, "runs", name), "upper"), f"a hood over {slot.name}", "none", mend)


def _behind_gaps(uppers: Sequence[Any], slots: Sequence[UnitSlot], slot: UnitSlot) -> int:
    """Index behind the last wall unit that is over something further left."""
    middles = {s.name: s.middle for s in slots}
    return max((k + 1 for k, u in enumerate(uppers) if u.over in middles and middles[u.over] < slot.middle), default=0)


def _on_walls(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Things beyond the end of their wall or the ceiling, and things on the floor outside the room or inside units."""
    plan, room = kitchen.plan, kitchen.room
    walls = {w.id: w for w in room.walls}
    for item in plan.wall_items:
        at = row_at(raw, "wall_items", item.id)
        if item.at is not None:
            u, length = plan.length(item.at, kitchen.parameters), walls[item.wall].length
            if not 0.05 <= u + item.shift <= length - 0.05:
                middle = round(min(max(u, 0.2), length - 0.2), 3)
                edits = [key_edit(raw, at, "at", middle)]
                edits += [removed((*at, "shift"))] if item.shift else []
                yield Fault(
                    at,
                    f"a place on {item.wall}, up to {length:.2f} m",
                    f"{u + item.shift:.2f} m",
                    Mend(f"Write `at: {middle:g}`.", tuple(edits)),
                )
            elif (hole := _hole_at(kitchen, item.wall, u + item.shift, item.height)) is not None:
                yield _beside(raw, kitchen, item.id, hole, u + item.shift)
        top = room.height_of(walls[item.wall])
        if item.height > top - 0.2:
            yield Fault(
                at,
                f"a height below {top:g} m",
                f"{item.height:g} m",
                Mend("Write `height: 1.8`.", (key_edit(raw, at, "height", 1.8),)),
            )
    yield from _same_places(raw, kitchen)
    boxes = [box for name in kitchen.lines if (box := row_box(kitchen, name)) is not None]
    solids = [box.corners for box in boxes] + [placed.outline for placed in room.columns]
    for name, table in kitchen.tables.items():
        deepest = max((penetration_depth(table.outline, solid) for solid in solids), default=0.0)
        outside = [p for p in table.outline if not room.contains(*p)]
        if deepest > TOUCH_M or outside:
            got = f"one {deepest:.2f} m in what stands there" if not outside else "one that reaches out of the room"
            yield _table_out(raw, kitchen, name, got)
    for floor_item in plan.floor_items:
        wall = walls[floor_item.wall]
        u, v = (plan.length(x, kitchen.parameters) for x in (floor_item.at, floor_item.from_wall))
        x, y, _ = wall.frame.at(u, v)
        around = Box(x - 0.15, y - 0.15, x + 0.15, y + 0.15)
        in_the_way = [*solids, *(t.outline for t in kitchen.tables.values())]
        if not room.contains(x, y) or any(penetration_depth(around.corners, solid) > TOUCH_M for solid in in_the_way):
            at = row_at(raw, "floor_items", floor_item.id)
            mend = Mend(f"Take out {floor_item.id}.", (removed(at),))
            yield Fault(at, "a free place on the floor", f"{x:.2f}, {y:.2f} m", mend)


def _same_places(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Things on a wall that hang at the place of another."""
    placed = {i.name: i.spot for i in kitchen.items}
    items = [i for i in kitchen.plan.wall_items if i.id in placed]
    for k, item in enumerate(items):
        spot = placed[item.id]
        x, y, z = spot.frame.at(spot.u, spot.v, spot.z)
        for other in items[:k]:
            there = placed[other.id]
            a, b, c = there.frame.at(there.u, there.v, there.z)
            if max(abs(x - a), abs(y - b), abs(z - c)) < SAME_PLACE_M:
                at = row_at(raw, "wall_items", item.id)
                shift = round(item.shift + APART_M, 2)
                mend = Mend(f"Write `shift: {shift:g}` for {item.id}.", (key_edit(raw, at, "shift", shift),))
                yield Fault(at, f"a place apart from {other.id}", "the same", mend)
                break


def _hole_at(kitchen: KitchenRequest, wall: str, u: float, height: float) -> WallHole | None:
    """The opening at a place of a wall, with the casing round it, at which nothing can hang."""
    return next(
        (
            hole
            for hole in kitchen.holes
            if hole.wall.id == wall
            and hole.left - ITEM_FROM_HOLE_M < u < hole.right + ITEM_FROM_HOLE_M
            and hole.bottom - ITEM_FROM_HOLE_M < height < hole.top + ITEM_FROM_HOLE_M
        ),
        None,
    )


def _beside(raw: Any, kitchen: KitchenRequest, name: str, hole: WallHole, u: float) -> Fault:
    """Something that hangs in an opening: at its nearer side, at the other one, or taken out."""
    item = next(i for i in kitchen.plan.wall_items if i.id == name)
    at, length, gap = row_at(raw, "wall_items", name), hole.wall.length, ITEM_FROM_HOLE_M + 0.01
    sides = sorted((round(hole.left - gap, 3), round(hole.right + gap, 3)), key=lambda side: abs(side - u))
    free = [s for s in sides if 0.1 < s < length - 0.1 and _hole_at(kitchen, item.wall, s, item.height) is None]
    rows = stretches(kitchen, hole.wall, 0.05, item.height)
    free = [s for s in free if not any(a - ITEM_FROM_UNIT_M < s < b + ITEM_FROM_UNIT_M for a, b in rows)]
    expected, got = "a place on a wall where nothing else is", f"{u:.2f} m, where {hole.opening.id} is"
    if not free:
        return Fault(at, expected, got, Mend(f"Take out {name}.", (removed(at),)))
    edits = [key_edit(raw, at, "at", free[0])]
    edits += [removed((*at, "shift"))] if item.shift else []
    return Fault(at, expected, got, Mend(f"Write `at: {free[0]:g}` for {name}.", tuple(edits)))


def _table_out(raw: Any, kitchen: KitchenRequest, name: str, got: str) -> Fault:
    """A table that has no room: with fewer chairs, else it goes, with the lamps over it."""
    at = row_at(raw, "tables", name)
    chairs = next(t.chairs for t in kitchen.plan.tables if t.id == name)
    expected = "a free place on the floor for the table and its chairs"
    if chairs > 2:
        fewer = chairs - 2
        return Fault(at, expected, got, Mend(f"Write `chairs: {fewer}`.", (key_edit(raw, at, "chairs", fewer),)))
    lamps = [k for k, lamp in enumerate(kitchen.plan.lamps) if lamp.over == name]
    edits = (*(removed(("lamps", k)) for k in reversed(lamps)), removed(at))
    return Fault(at, expected, got, Mend(f"Take out the table {name}.", edits))


def _behind_walls(raw: Any, kitchen: KitchenRequest) -> Iterator[Fault]:
    """Niches and closets that reach from behind their wall into the room, or into each other."""
    room, found = kitchen.room, list[tuple[Vec2, ...]]()
    for hole in kitchen.holes:
        opening, middle = hole.opening, (hole.left + hole.right) / 2
        width = opening.closet.width if opening.closet else hole.right - hole.left
        depth = WALL_THICKNESS_M + opening.closet.depth if opening.closet else opening.depth or 0.0
        if depth <= WALL_THICKNESS_M:
            continue
        half, deep, near = width / 2 + WALL_THICKNESS_M, depth + WALL_THICKNESS_M, WALL_THICKNESS_M + 0.001
        ends = ((-half, -near), (half, -near), (half, -deep), (-half, -deep), (0.0, -deep))
        points = tuple(hole.wall.frame.at(middle + u, v)[:2] for u, v in ends)
        is_inside = any(room.contains(*p) for p in points)
        other = any(penetration_depth(points[:4], one) > TOUCH_M for one in found)
        found.append(points[:4])
        if is_inside or other:
            at = row_at(raw, "openings", opening.id)
            got = "one that reaches into the room" if is_inside else "one that reaches into another"
            edits = (removed((*at, "closet")),) if opening.closet else (removed(at),)
            said = f"Take out the closet of {opening.id}." if opening.closet else f"Take out {opening.id}."
            yield Fault(at, "a room behind the wall, where nothing else is", got, Mend(said, edits))
