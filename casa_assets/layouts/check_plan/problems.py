"""Predict which checks the kitchen of a plan would fail, from its floor and walls, before anything is built.

The limits are those of registry/limits.yaml, the sizes those of `layouts.plan.clearances`. A kitchen without problems
here should pass.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from casa_assets.layouts.check_plan.draft import (
    CLASH_M,
    ON_FLOOR_M,
    SILL_BESIDE_M,
    SILL_M,
    SILL_UNDER_M,
    Draft,
    bounds_of,
)
from casa_assets.layouts.check_plan.edit import Fault, Mend, flow_text, insert, put
from casa_assets.layouts.order.furnish import worktop_width
from casa_assets.layouts.order.request import placed_run, placed_wall
from casa_assets.layouts.order.worktops import WORKTOP_BREAKS
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.clearances import Part, door_width_clear, find_aisles, fronts_of
from casa_assets.layouts.plan.room import WallHole
from casa_assets.layouts.plan.runs import UnitSlot
from casa_assets.layouts.plan.style_models import APPLIANCE_ROLES
from casa_assets.mesh.outline import penetration_depth
from casa_assets.model.kitchen.floor import AisleKind, RunEnd
from casa_assets.model.kitchen.plan import COOKERS, TALL, BaseKind, Run, UpperKind
from casa_assets.model.record import Vec2
from casa_assets.model.registry.document import KeyPath
from casa_assets.projects import read_once
from casa_assets.registry.load import load_limits

TOUCH_M = 0.002  # by which units may overlap
PLAY_M = 0.002  # by which leaves as they are built are smaller than they are taken to be here
NEAR_CORNER = (
    BaseKind.RANGE, BaseKind.HOB, BaseKind.DISHWASHER, BaseKind.OVEN, BaseKind.MICROWAVE, BaseKind.FRIDGE,
)  # fmt: skip
# Ref: NKBA kitchen planning guideline 7: walkways 36 inches wide.
LEAST_AISLE_M, LEAST_FROM_WALL_M = 0.914, 0.714
WIDER_THAN_MODEL_M, MOST_OF_MODEL_M = 0.03, 1.2  # a place may be so much wider than its appliance, or so wide
LEAST_ISLAND_M = 0.92  # length of an island that is one piece of furniture: two columns of at least 0.42 m
# Of a door: its usual height, the least that people walk through, the widest leaf that is not too heavy for a hand.
DOOR_HEIGHT_M, LEAST_DOOR_M, WIDEST_LEAF_M = 2.04, 1.9, 1.2
# From an opening, and from units, to the middle of a switch; half of the width of a thing on the floor.
ITEM_FROM_HOLE_M, ITEM_FROM_UNIT_M, HALF_THING_M = 0.14, 0.08, 0.15
# Of a worktop over those who sit at it: with less a stool stands in what is below. The usual one is that of the plans.
LEAST_OVERHANG_M, USUAL_OVERHANG_M = 0.25, 0.3
LANDING_PLAY_M = 0.05  # by which things may be narrower than they are taken to be
LEAST_LANDING_M = 0.3  # of worktop beside a sink or a cooker: for less RoboCasa finds no place to set things down on
# Of free worktop beside a cooker, and in one piece near a microwave or a sink, for that reason; how far from these.
LEAST_BY_COOKER_M, LEAST_BY_MICROWAVE_M, LEAST_BY_SINK_M, SET_DOWN_REACH_M = 0.25, 0.19, 0.1, 0.6
TABLE_M = 0.9  # height of tables and chairs


@dataclass(frozen=True)
class Problem:
    """A fault that a check would find.

    Attributes:
        about: the unit, opening, run or object that is reported. others: further ones that are involved.
        expected, got: as in the text of a fault. excess: by how much it misses what is expected, metres.
        mends: that may help, in addition to those that suit its owners. kind: the function that finds it.
        pointer: of the fault, if it is not that of `about`.
    """

    about: str
    expected: str
    got: str
    excess: float = 1.0
    others: Sequence[str] = ()
    mends: Sequence[Mend] = ()
    pointer: KeyPath | None = None
    kind: str = ""

    @property
    def owners(self) -> frozenset[str]:
        """All that it is a matter of."""
        return frozenset((self.about, *self.others))

    def fault(self, draft: Draft, mend: Mend | None = None) -> Fault:
        """Return the problem as a fault of the plan."""
        return Fault(self.pointer or draft.pointer(self.about), self.expected, self.got, mend)


Finder = Callable[[Draft], Iterator[Problem]]


@read_once
def limits() -> Mapping[str, float]:
    """Values of the limits of checks, those of the project in use laid over the others. Raises RegistryError."""
    return {key: limit.value for key, limit in load_limits().items()}


def problems_of(draft: Draft) -> tuple[int, list[Problem]]:
    """How many groups of problems are left, and those of the first of them that has any.

    Where rows clash, what hangs on them is looked at when they no longer do; things on worktops, which are moved most
    easily, come last.
    """
    for k, group in enumerate(GROUPS):
        found = [replace(one, kind=find.__name__) for find in group for one in find(draft)]
        if found:
            return len(GROUPS) - k, found
    return 0, []


def _widths(draft: Draft) -> Iterator[Problem]:
    """Units that are narrower or wider than their appliance, or than can be built."""
    reported: set[str] = set()
    for slot in draft.slots:
        place, unit = draft.place(slot.name), slot.unit
        span = None if unit is None or unit.width is None else _span_of_model(draft, unit)
        if span is None or place is None or span[0] - 0.0015 <= slot.width <= span[1] + WIDER_THAN_MODEL_M:
            continue
        reported.add(slot.name)
        edit = draft.without(draft.unit(*place), "width")
        mend = Mend(f"Take the width of {slot.name} out: it follows from its model.", (edit,))
        expected = f"{span[0]:g} to {span[1]:g} m, by the style's model"
        yield Problem(slot.name, expected, f"{slot.width:g} m", mends=[mend])
    for item in draft.kitchen.items:
        bounds, width = bounds_of(item.choice.family, "width"), item.choice.params.get("width")
        name, at = item.unit or "", draft.place(item.unit or "")
        if bounds is None or width is None or name in reported or (at is None and item.role != "island"):
            continue
        least = LEAST_ISLAND_M if item.choice.family == "island_base" else bounds[0]
        if not least - 1e-6 <= width <= bounds[1] + 1e-6:
            reported.add(name)
            said, usual = f"Write {flow_text([least, bounds[1]])} for {name}.", [least, bounds[1]]
            mends = [Mend(said, (draft.in_unit(draft.unit(*at), "width", usual),))] if at else []
            expected = f"a width from {least:g} to {bounds[1]:g} m"
            yield Problem(name or item.run or "", expected, f"{width:g} m", mends=mends)


def _span_of_model(draft: Draft, unit: Any) -> tuple[float, float] | None:
    """Least and greatest width of a unit by the model of its appliance, metres; None of one that has none."""
    if unit.kind not in (*COOKERS, BaseKind.DISHWASHER, BaseKind.FRIDGE, BaseKind.OVEN, BaseKind.SINK):
        return None
    if unit.kind in APPLIANCE_ROLES and draft.models.for_unit(unit).choice.is_library:
        return None  # it is scaled to the width that is stated, or refused
    span = standard_sizes.base_span(unit.replace(width=None), draft.models)
    is_slim = unit.kind in (BaseKind.RANGE, BaseKind.DISHWASHER)
    return span.minimum, span.maximum if is_slim else max(span.maximum, MOST_OF_MODEL_M)


def _sizes_of_openings(draft: Draft) -> Iterator[Problem]:
    """Windows and doors that are larger or smaller than they can be built, and leaves that are too heavy."""
    made = {item.name: item.choice for item in draft.kitchen.items}
    for opening in draft.plan.openings:
        at, choice, is_door = draft.row("openings", opening.id), made.get(opening.id), opening.kind == "door"
        if is_door and opening.width > WIDEST_LEAF_M:
            expected, got = f"a leaf of at most {WIDEST_LEAF_M:g} m, or a passage", f"{opening.width:g} m"
            yield Problem(opening.id, expected, got, mends=[passage(draft, opening.id)], pointer=(*at, "width"))
            continue
        for key in ("width", "height"):
            span, size = (bounds_of(choice.family, key), choice.params.get(key)) if choice else (None, None)
            if span is not None and size is not None and not span[0] - 1e-6 <= size <= span[1] + 1e-6:
                # A leaf is smaller than its hole, by as much at each size.
                least, most = (round(side + getattr(opening, key) - size, 4) for side in span)
                fits = DOOR_HEIGHT_M if is_door and key == "height" else least if size < span[0] else most
                expected, got = f"a {key} from {least:g} to {most:g} m", f"{getattr(opening, key):g} m"
                yield Problem(opening.id, expected, got, mends=[Mend.write(at, **{key: fits})], pointer=(*at, key))


def passage(draft: Draft, name: str) -> Mend:
    """The mend that makes a door a passage, which has no leaf."""
    return Mend.write(draft.row("openings", name), name, kind="passage")


def _rows(draft: Draft) -> Iterator[Problem]:
    """Yield runs that overlap, are outside the room or too near to a wall, or are too near to each other."""
    kitchen, rows = draft.kitchen, {n: o for n, o in draft.solids.items() if n in draft.kitchen.lines}
    corners, walls = {frozenset(c.runs) for c in draft.plan.corners}, [w.id for w in kitchen.room.walls]
    after = {wall: walls[(k + 1) % len(walls)] for k, wall in enumerate(walls)}
    joined = {frozenset((r.id, r.joins.run)) for r in draft.plan.runs if r.joins}
    for name, outline in rows.items():
        near = math.inf  # to the walls that it is in front of
        for wall in (w for w in kitchen.room.walls if not w.open):
            along, before = zip(*(wall.frame.to_local(*p) for p in outline), strict=True)
            if max(along) > 0.05 and min(along) < wall.length - 0.05:
                near = min(near, *before)
        if not all(kitchen.room.contains(*p) for p in draft.row_outline(name, CLASH_M)):
            yield Problem(name, "a row inside the room", "one that reaches out of it", max(CLASH_M, -near))
        elif kitchen.lines[name].is_island and near < LEAST_FROM_WALL_M:
            expected = f"an island at least {LEAST_FROM_WALL_M} m from the walls"
            yield Problem(name, expected, f"{near:.2f} m", LEAST_FROM_WALL_M - near)
    for other, name in itertools.combinations(rows, 2):
        one, two = kitchen.lines[name], kitchen.lines[other]
        depth, pair = penetration_depth(rows[name], rows[other]), frozenset((name, other))
        order = [[a.id, b.id] for a, b in ((one, two), (two, one)) if after.get(a.run.on or "", "") == b.run.on]
        if pair in corners:
            continue
        if depth > CLASH_M and order:
            row = {"runs": order[0], "base": "blind"}
            mend = Mend(f"Add the corner {flow_text(row)}.", (draft.with_item(("corners",), row),))
            expected = f"a corner of {' and '.join(order[0])}"
            yield Problem(name, expected, "none", depth, [other], [mend], ("corners",))
        elif depth > CLASH_M:
            yield Problem(name, f"a place of its own, apart from {other}", "the two overlap", depth, [other])
        elif -depth < LEAST_AISLE_M and pair not in joined and _face(rows[name], rows[other]):
            turn = abs((one.frame.turn_deg - two.frame.turn_deg + 180.0) % 360.0 - 180.0)
            if turn >= 90.0 or not (one.at_wall and two.at_wall):
                expected = f"an aisle of at least {LEAST_AISLE_M} m between {other} and {name}"
                yield Problem(name, expected, f"{-depth:.2f} m", LEAST_AISLE_M + depth, [other])


def _face(one: Sequence[Vec2], other: Sequence[Vec2]) -> bool:
    """Return True if two outlines face each other: their extents along x or y overlap by more than 0.3 m."""
    spans = [[(min(side), max(side)) for side in zip(*outline, strict=True)] for outline in (one, other)]
    return any(min(a[1], b[1]) - max(a[0], b[0]) > 0.3 for a, b in zip(*spans, strict=True))


def _openings(draft: Draft) -> Iterator[Problem]:
    """Doors that nobody walks through, and openings where units or other openings are."""
    holes = draft.kitchen.holes
    for k, hole in enumerate(holes):
        name, others = hole.opening.id, [h for h in holes[:k] if h.wall.id == hole.wall.id]
        beside = next((h for h in others if h.left < hole.right + 0.05 and h.right > hole.left - 0.05), None)
        if not hole.is_window and not hole.is_niche and hole.top < LEAST_DOOR_M:
            mend = Mend.write(draft.row("openings", name), height=DOOR_HEIGHT_M)
            yield Problem(name, "a door or passage that people walk through", f"{hole.top:g} m high", mends=[mend])
        elif beside is not None or _is_blocked(draft, hole):
            got = f"{hole.left:.2f} to {hole.right:.2f} m, where {f'{beside.opening.id} is' if beside else 'units are'}"
            yield Problem(name, "a place on a wall where nothing else is", got, mends=[*_gap_over(draft, hole)])


def _is_blocked(draft: Draft, hole: WallHole) -> bool:
    """Return True if units are in front of an opening, its casing or the sill of a window."""
    low, casing = max(hole.bottom, ON_FLOOR_M), 0.0 if hole.is_niche else draft.casing_of(hole.is_window)
    beside = -CLASH_M if hole.is_niche else draft.beside_casing(hole.top, hole.is_window)
    parts = [(low, hole.top + casing, beside)]
    parts += [(low - SILL_UNDER_M, low, SILL_BESIDE_M)] if hole.is_window else []
    return any(
        left < hole.right + beside - 1e-3 and right > hole.left - beside + 1e-3
        for bottom, top, beside in parts
        for left, right in draft.stretches(hole.wall, bottom, top, hole.is_niche)
    )


def _gap_over(draft: Draft, hole: WallHole) -> Iterator[Mend]:
    """A gap in the row of wall units over the unit that a window is over."""
    over = hole.opening.over
    run = next((r for r in draft.plan.runs if any(u.id == over for u in r.base)), None)
    if not hole.is_window or run is None or not run.upper or any(u.over == over for u in run.upper):
        return
    reach = (hole.right - hole.left) / 2 + max(SILL_BESIDE_M, draft.beside_casing(hole.top, True)) + 0.001
    gap = {"gap": {"over": over, "width": math.ceil(100 * 2 * reach) / 100}}
    edit = insert((*draft.row("runs", run.id), "upper", _index_over(draft, run, str(over))), gap)
    yield Mend(f"Leave a gap in the wall units of {run.id} over {over}.", (edit,))


def _index_over(draft: Draft, run: Run, name: str) -> int:
    """Number of wall units of a run that hang to the left of the middle of a unit."""
    middles = {s.name: s.middle for s in draft.slots}
    return sum(middles.get(u.id, middles.get(u.over or "", math.inf)) < middles[name] for u in run.upper)


def _entries(draft: Draft) -> Iterator[Problem]:
    """A room that nobody gets into: all its walls are closed, and no door or passage leads in."""
    walls = draft.kitchen.room.walls
    if not any(w.open for w in walls) and all(h.is_window or h.is_niche for h in draft.kitchen.holes):
        taken = {run.on for run in draft.plan.runs} | {h.wall.id for h in draft.kitchen.holes}
        mends = [Mend.write(draft.row("walls", w.id), w.id, open=True) for w in walls if w.id not in taken]
        expected = "a door, a passage or an `open` wall, by which one gets in"
        yield Problem("walls", expected, "none of them", mends=mends)


def _hoods(draft: Draft) -> Iterator[Problem]:
    """Cookers at a wall that have no hood over them, and hoods with no cooker under them."""
    hoods = [s for s in draft.slots if s.kind in (UpperKind.HOOD, UpperKind.MICROWAVE)]
    cookers = [s for s in draft.slots if s.kind in COOKERS and s.line.at_wall]
    over = {c.name: [h for h in hoods if h.line is c.line and h.left < c.middle < h.right] for c in cookers}
    for slot in (c for c in cookers if not over[c.name]):
        run, at = slot.line.run, (*draft.row("runs", slot.line.id), "upper")
        own, hood = next((k for k, u in enumerate(run.upper) if u.over == slot.name), -1), {"hood": {"over": slot.name}}
        new = draft.with_item(at, hood, _index_over(draft, run, slot.name))
        said = f"Add `- hood: {{over: {slot.name}}}` to the wall units of {run.id}."
        mends = [Mend(said, (new if own < 0 else put((*at, own), hood),))]
        idle = next((k for k, u in enumerate(run.upper) if u.kind is UpperKind.HOOD and u.over is None), None)
        if idle is not None:
            edit = draft.in_unit((*at, idle), "over", slot.name)
            mends.insert(0, Mend(f"Write `over: {slot.name}`.", (edit,)))
        yield Problem(slot.name, f"a hood over {slot.name}", "none", mends=mends, pointer=at)
    for name in (h.name for h in hoods if h.kind is UpperKind.HOOD and not any(h in hs for hs in over.values())):
        yield Problem(name, f"a cooker under {name}", "none")


def _wall_items(draft: Draft) -> Iterator[Problem]:
    """Things beyond the end of their wall, or in openings, with the casing round them."""
    walls, near = {w.id: w for w in draft.kitchen.room.walls}, ITEM_FROM_HOLE_M
    for item in (i for i in draft.plan.wall_items if i.at is not None):
        at, wall = draft.row("wall_items", item.id), walls[item.wall]
        u = draft.plan.length(item.at or 0.0, draft.plan.defaults) + item.shift
        holes = [h for h in draft.kitchen.holes if h.wall.id == wall.id and h.left - near < u < h.right + near]
        hole = next((h for h in holes if h.bottom - near < item.height < h.top + near), None)
        if not 0.05 <= u <= wall.length - 0.05:
            sides, expected = [min(max(u, 0.2), wall.length - 0.2)], f"a place on {wall.id}, up to {wall.length:.2f} m"
            got = f"{u:.2f} m"
        elif hole is not None:
            rows = draft.stretches(wall, ON_FLOOR_M, item.height)
            sides = sorted((hole.left - near - 0.01, hole.right + near + 0.01), key=lambda side: abs(side - u))
            sides = [s for s in sides if not any(a - ITEM_FROM_UNIT_M < s < b + ITEM_FROM_UNIT_M for a, b in rows)]
            expected, got = "a place on a wall where nothing else is", f"{u:.2f} m, where {hole.opening.id} is"
        else:
            continue
        rounded = [round(side - item.shift, 3) for side in sides]
        yield Problem(item.id, expected, got, mends=[Mend.write(at, item.id, at=side) for side in rounded])


def _on_the_floor(draft: Draft) -> Iterator[Problem]:
    """Yield tables with their chairs, and floor items, that are outside the room or overlap with units or columns.

    Floor items must not overlap with tables either.
    """
    kitchen, room = draft.kitchen, draft.kitchen.room
    tables, walls = {n: t.outline for n, t in kitchen.tables.items()}, {w.id: w for w in room.walls}
    for name, outline in tables.items():
        deepest = max([0.0, *(penetration_depth(outline, solid) for solid in draft.solids.values())])
        is_outside = not all(room.contains(*p) for p in outline)
        if deepest > CLASH_M or is_outside:
            got = "one that reaches out of the room" if is_outside else f"one {deepest:.2f} m in what stands there"
            expected = "a free place on the floor for the table and its chairs"
            yield Problem(name, expected, got, max(deepest, CLASH_M))
    for item in draft.plan.floor_items:
        u, v = (draft.plan.length(x, draft.plan.defaults) for x in (item.at, item.from_wall))
        x, y, _ = walls[item.wall].frame.at(u, v)
        near = [(x + a * HALF_THING_M, y + b * HALF_THING_M) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        others = (*draft.solids.values(), *tables.values())
        if not room.contains(x, y) or any(penetration_depth(near, solid) > CLASH_M for solid in others):
            yield Problem(item.id, "a free place on the floor", f"{x:.2f}, {y:.2f} m")


def _lamps(draft: Draft) -> Iterator[Problem]:
    """Rows of lamps over a run that has wall units or tall ones, in which they would hang."""
    for k, lamps in enumerate(draft.plan.lamps):
        if any(s.line.id == lamps.over and s.line.at_wall and s.top > standard_sizes.UPPER_FROM for s in draft.slots):
            expected = f"an island, a table, or a row without wall units and tall ones, to hang {lamps.item} over"
            mends = [Mend.take_out(("lamps", k), "these lamps")]
            yield Problem("lamps", expected, repr(lamps.over), mends=mends, pointer=("lamps", k, "over"))


def _tasks(draft: Draft) -> Iterator[Problem]:
    """Things that `all_tasks` asks for (TSK001) and the plan lacks; it may have that key from the one it is like."""
    kinds = {s.kind.value for s in draft.slots} | {item.id for item in draft.plan.worktop_items}
    doors = [s.width for s in draft.slots if s.is_upper and s.kind in (UpperKind.DOORS, UpperKind.GLASS)]
    needed = {"sink": ("sink",), "cooker": ("range", "hob"), "drawers": ("drawers", "island")}
    needed |= {"microwave": ("microwave",), "coffee machine": ("coffee_machine",)}
    lacking = [name for name, known in needed.items() if kinds.isdisjoint(known)]
    if max(doors, default=0.0) <= standard_sizes.WIDEST_SINGLE_DOOR:
        lacking.append("wall cabinet with two doors")
    if draft.plan.all_tasks and lacking:
        expected = "all that the tasks of RoboCasa need, since the plan says `all_tasks: true`"
        mends = [Mend.write((), all_tasks=False)]
        yield Problem("all_tasks", expected, f"no {', no '.join(lacking)}", float(len(lacking)), mends=mends)


def _aisles(draft: Draft) -> Iterator[Problem]:
    kitchen, room = draft.kitchen, draft.kitchen.room
    fronts = fronts_of(kitchen.slots, draft.models)
    runs = [placed_run(line, kitchen.slots[name], fronts) for name, line in kitchen.lines.items()]
    walls = [placed_wall(w, is_open=w.open) for w in room.walls]
    work = limits()["compact_aisle_m" if draft.plan.compact else "work_aisle_m"]
    for aisle in find_aisles(runs, walls, room.outline, {c.column.id: c.outline for c in room.columns}):
        least = work if aisle.kind is AisleKind.WORK else limits()["walkway_m"]
        if aisle.width < least:
            about, other = sorted((aisle.second, aisle.first), key=lambda name: name not in kitchen.lines)
            expected = f"an aisle of at least {least:g} m between {aisle.first} and {aisle.second}"
            yield Problem(about, expected, f"{aisle.width:.2f} m", least - aisle.width, [other])


def _overlaps(draft: Draft) -> Iterator[Problem]:
    """Yield wall units that overlap with tall units, or with wall units of another run."""
    uppers = [s for s in draft.slots if s.is_upper]
    others = [s for s in draft.slots if not s.is_upper]
    for upper, other in (*itertools.product(uppers, others), *itertools.combinations(uppers, 2)):
        shared = min(upper.top, other.top) - max(upper.bottom, other.bottom)
        depth = penetration_depth(_outline(upper), _outline(other))
        if (other.is_upper and other.line is upper.line) or min(shared, depth) < TOUCH_M:
            continue
        run, mends = upper.line.run, list[Mend]()
        if other.kind in TALL and other.line is upper.line:
            at, gap = (*draft.row("runs", run.id), "upper"), {"gap": {"over": other.name}}
            edit = draft.with_item(at, gap, _index_over(draft, run, other.name))
            mends = [Mend(f"Add `- gap: {{over: {other.name}}}` to the wall units of {run.id}.", (edit,))]
        expected = f"a place for {upper.name} apart from {other.name}"
        yield Problem(upper.name, expected, f"{depth:.2f} m in it", depth, [other.name], mends)


def _outline(slot: UnitSlot) -> tuple[Vec2, ...]:
    air = standard_sizes.FRIDGE_SIDE if slot.stands_free else 0.0
    return slot.line.frame.rectangle(slot.left + air, slot.right - air, -slot.recess, slot.depth - slot.recess)


def _seats(draft: Draft) -> Iterator[Problem]:
    """Stools where the worktop does not reach out over those who sit."""
    for k, seats in enumerate(draft.plan.seats):
        overhang = draft.kitchen.lines[seats.run].run.overhang
        if overhang < LEAST_OVERHANG_M:
            mends = [
                Mend.write(draft.row("runs", seats.run), seats.run, overhang=USUAL_OVERHANG_M),
                Mend.take_out(("seats", k), f"the seats at {seats.run}"),
            ]
            expected = f"a worktop of {seats.run} that reaches at least {LEAST_OVERHANG_M:g} m over those who sit there"
            got, less = f"an overhang of {overhang:g} m", LEAST_OVERHANG_M - overhang
            yield Problem(seats.run, expected, got, less, mends=mends)


def _doorways(draft: Draft) -> Iterator[Problem]:
    least = limits()["doorway_m"]
    for hole in draft.kitchen.holes:
        clear = door_width_clear(hole)
        if not hole.is_window and not hole.is_niche and clear < least:
            expected = f"a door or passage that leaves {least:g} m clear"
            yield Problem(hole.opening.id, expected, f"{clear:.2f} m", round(least - clear, 4))


def has_worktop(slot: UnitSlot) -> bool:
    """Return True if a unit carries a worktop without a hole, on which objects can be placed."""
    is_low = not slot.is_upper and slot.top <= standard_sizes.WORKTOP_HEIGHT
    return is_low and slot.kind not in (*WORKTOP_BREAKS, BaseKind.SINK, BaseKind.HOB)


def _sides(draft: Draft, slot: UnitSlot) -> tuple[list[UnitSlot], list[UnitSlot]]:
    """Return the neighbours of a unit that carry a worktop, left and right, each from left to right.

    Each side ends at the first unit that is tall or interrupts the worktop.
    """
    row = sorted((s for s in draft.kitchen.slots[slot.line.id] if not s.is_upper), key=lambda s: s.left)
    k = row.index(slot)
    left = list(itertools.takewhile(has_worktop, row[:k][::-1]))
    return left[::-1], list(itertools.takewhile(has_worktop, row[k + 1 :]))


def _items(draft: Draft) -> Iterator[Problem]:
    """Yield objects on a cooker, in a sink or in a refrigerator, and objects that do not fit next to each other."""
    for name in dict.fromkeys(item.on for item in draft.plan.worktop_items):
        slot, items = draft.kitchen.slot(name), [i for i in draft.plan.worktop_items if i.on == name]
        if not has_worktop(slot):
            for item in items:
                expected = f"a unit with a worktop, on which {item.id} can stand"
                yield Problem(item.id, expected, repr(name), others=[name])
            continue
        room = round(slot.width + sum(s.width for s in _sides(draft, slot)[1]), 4)
        widths = {item.id: worktop_width(draft.models, item) for item in items}
        least = sum(widths.values())
        if least > room + LANDING_PLAY_M:
            largest = max(widths, key=lambda i: (widths[i], i))
            expected = f"at least {least:.2f} m of worktop from the left end of {name} on, for {', '.join(widths)}"
            yield Problem(largest, expected, f"{room:.2f} m", round(least - room, 4), [name, *widths])


def _landings(draft: Draft) -> Iterator[Problem]:
    """Yield sinks and cookers with too little worktop next to them to set objects down."""
    for slot in (s for s in draft.slots if s.kind in (BaseKind.SINK, *COOKERS)):
        widest = max(round(sum(s.width for s in side), 4) for side in _sides(draft, slot))
        if widest < LEAST_LANDING_M:
            expected = f"at least {LEAST_LANDING_M:g} m of worktop beside {slot.name}"
            yield Problem(slot.name, expected, f"{widest:.2f} m", LEAST_LANDING_M - widest)


def _crowded(draft: Draft) -> Iterator[Problem]:
    """Sinks, cookers and microwaves with no free worktop near them to set down what goes in and comes out."""
    for slot in (s for s in draft.slots if s.kind in (BaseKind.SINK, *COOKERS)):
        is_sink = slot.kind is BaseKind.SINK
        reach, least = (SET_DOWN_REACH_M, LEAST_BY_SINK_M) if is_sink else (math.inf, LEAST_BY_COOKER_M)
        spans = ((slot.left - reach, slot.left), (slot.right, slot.right + reach))
        yield from _too_crowded(draft, slot.name, least, list(zip(_sides(draft, slot), spans, strict=True)))
    for item in draft.plan.worktop_items:
        slot = draft.kitchen.slot(item.on)
        if draft.models.role_of(item) == "microwave" and has_worktop(slot):
            left, right = _sides(draft, slot)
            middle = next(i.spot.u for i in draft.kitchen.items if i.name == item.id)
            reach = worktop_width(draft.models, item) / 2 + SET_DOWN_REACH_M
            pieces = [([*left, slot, *right], (middle - reach, middle + reach))]
            yield from _too_crowded(draft, item.id, LEAST_BY_MICROWAVE_M, pieces)


def _too_crowded(
    draft: Draft, about: str, least: float, pieces: Sequence[tuple[Sequence[UnitSlot], tuple[float, float]]]
) -> Iterator[Problem]:
    """Yield a problem if the objects on a worktop leave less of it free than `about` needs.

    `pieces`: units under a worktop, from left to right, and the range along the run in which it counts.
    """
    places, free, beside = {item.name: item.spot.u for item in draft.kitchen.items}, 0.0, list[str]()
    for top, (low, high) in (piece for piece in pieces if piece[0]):
        on = [i for i in draft.plan.worktop_items if i.on in {s.name for s in top}]
        spans, start = sorted((places[i.id], worktop_width(draft.models, i) / 2) for i in on), top[0].left
        gaps = list[float]()
        for at, half in (*spans, (top[-1].right, 0.0)):
            gaps.append(min(at - half, high) - max(start, low))
            start = max(start, at + half)
        free = max(free, max(gaps) if high - low < math.inf else sum(gaps))
        beside += [i.id for i in on]
    if beside and free < least:
        expected = f"at least {least:g} m of free worktop beside {about}"
        yield Problem(about, expected, f"{free:.2f} m", round(least - free, 4), beside)


def _corners(draft: Draft) -> Iterator[Problem]:
    """Yield appliances too near to an inside corner, and dishwashers with no room for a person in front of them."""
    for slot in (s for s in draft.slots if s.kind in NEAR_CORNER):
        line, key = slot.line, "dishwasher_m" if slot.kind is BaseKind.DISHWASHER else "corner_m"
        for end, away in ((line.left, slot.left), (line.right, line.length - slot.right)):
            far, least = round(away - standard_sizes.WORKTOP_DEPTH, 4), limits()[key]
            if end.kind is RunEnd.CORNER and far < least - 1e-6:
                expected = f"at least {least:g} m between {slot.name} and the inside corner"
                yield Problem(slot.name, expected, f"{far:.2f} m", least - far)


def _at_things(draft: Draft) -> Iterator[Problem]:
    """Leaves that run into units of another run, into columns, sills of windows, or tables with their chairs."""
    kitchen, lines = draft.kitchen, {s.name: s.line.id for s in draft.slots}
    things = [(s.name, Part(_outline(s), s.bottom, s.top)) for s in draft.slots]
    things += [(c.column.id, Part(c.outline, 0.0, kitchen.room.height)) for c in kitchen.room.columns]
    is_round = bool(kitchen.tables) and bool(draft.models.for_role("table").params.get("is_round"))
    outlines = {n: _inscribed(t.outline) if is_round else t.outline for n, t in kitchen.tables.items()}
    things += [(name, Part(outline, 0.0, TABLE_M)) for name, outline in outlines.items()]
    things += [(h.opening.id, _sill(h)) for h in kitchen.holes if h.is_window]
    reported: set[tuple[str, str]] = set()
    for leaf, (name, thing) in itertools.product(draft.leaves, things):
        if leaf.owner == name or (leaf.run and leaf.run == lines.get(name)) or (leaf.owner, name) in reported:
            continue
        depth = leaf.depth_in_thing(thing)
        if depth > limits()["scene_clash_m"] + PLAY_M:
            reported.add((leaf.owner, name))
            expected, got = f"room to open {leaf.owner} before {name}", f"it runs {depth:.2f} m into it"
            yield Problem(leaf.owner, expected, got, depth, [name])


def _inscribed(square: Sequence[Vec2]) -> tuple[Vec2, ...]:
    """Twelve points of the circle in a square, in the order of its corners, metres."""
    (x, y), radius = np.mean(square, axis=0).tolist(), math.dist(square[0], square[1]) / 2
    turns = [math.tau * k / 12 for k in range(12)]
    return tuple((x + radius * math.cos(turn), y + radius * math.sin(turn)) for turn in turns)


def _sill(hole: WallHole) -> Part:
    outline = hole.wall.frame.rectangle(hole.left - SILL_BESIDE_M, hole.right + SILL_BESIDE_M, 0.0, SILL_M)
    return Part(outline, hole.bottom - SILL_UNDER_M, hole.bottom)


def _swings(draft: Draft) -> Iterator[Problem]:
    """Leaves that run into others that are open: of two runs, or of a run and a door of the room.

    Those of one run keep to their own widths.
    """
    reported: set[frozenset[str]] = set()
    for one, other in itertools.combinations(draft.leaves, 2):
        owners = frozenset((one.owner, other.owner))
        is_one_row = one.run == other.run and bool(one.run) and one.keeps_width and other.keeps_width
        if len(owners) < 2 or is_one_row or owners in reported:
            continue
        depth, moved, still = max((a.depth_in(b), a.owner, b.owner) for a, b in ((one, other), (other, one)))
        # The ways of two appliances, and of one and a door of the room, may not even cross (NKBA guideline 2).
        are_apart = (one.of_appliance or not one.run) and (other.of_appliance or not other.run)
        if depth > limits()["scene_clash_m"] + PLAY_M:
            reported.add(owners)
            expected, got = f"room to open {moved} while {still} is open", f"they overlap by {depth:.2f} m"
            yield Problem(moved, expected, got, depth, [still])
        elif are_apart and (crossing := one.crossing(other)) > limits()["swing_m"] + PLAY_M:
            reported.add(owners)
            expected, got = f"ways of {one.owner} and {other.owner} apart", f"they cross by {crossing:.2f} m"
            yield Problem(one.owner, expected, got, crossing, [other.owner])


GROUPS: tuple[tuple[Finder, ...], ...] = (
    (_widths, _sizes_of_openings, _rows),
    (_openings, _entries),
    (_hoods, _wall_items, _on_the_floor, _lamps),
    (_aisles, _overlaps, _seats, _doorways, _landings, _corners, _at_things, _swings),
    (_items, _crowded, _tasks),
)
