"""Find unsafe or cramped places of appliances, doorways that are too narrow, swings that cross, and narrow ways."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from casa_assets.checks.check import Measurement, all_at_least, not_applicable, worst_above, worst_below
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.mesh.outline import penetration_depth
from casa_assets.model.kitchen.floor import (
    APPLIANCES,
    AisleKind,
    Corners,
    Fixture,
    KitchenFacts,
    PlacedRun,
    Role,
    RoomWall,
    RunEnd,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Vec2

COOKTOPS = (Role.RANGE, Role.HOB)
# Kinds of units that are appliances whose doors or cooks need room beside a corner.
APPLIANCE_UNITS = ("range", "hob", "dishwasher", "oven", "microwave", "fridge")
STANDING_DEPTH_M = 0.6  # before a dishwasher, in which the one who loads it stands
NEAR_WALL_M = 0.8  # from a wall, within which a cooktop stands at it
MIN_OVERLAP_M = 0.02  # by which something has to reach over a cooktop to be above it
# Name, outline seen from above, and heights of the lower and upper end, metres.
Solid = tuple[str, Corners, float, float]
NO_AISLE = {
    AisleKind.WORK: "no two fronts face each other",
    AisleKind.WALK: "no way leads between two things, or a thing and a wall",
}


def dishwashers_have_standing_room(subject: DesignSubject, limit: float) -> Measurement:
    """NKB007: least distance of a dishwasher from a run at a right angle to it, metres."""
    # Ref: NKBA planning guideline 13: 21 inches.
    runs = subject.facts.runs
    washers = [(run, unit) for run in runs for unit in run.units if unit.kind == "dishwasher"]
    gaps = (
        (f"units/{unit.name}", gap, f"{gap:.3f} m to {other.id} at a right angle to it, {limit:g} wanted to stand in")
        for run, unit in washers
        for other in runs
        for gap in _beside(run, unit.left, unit.right, other)
    )
    return worst_below(gaps, limit, "nothing stands at a right angle to a dishwasher")


def _beside(run: PlacedRun, left: float, right: float, other: PlacedRun) -> Iterator[float]:
    """Distance along a run from a unit to another run that protrudes beyond the fronts next to the unit."""
    if other.id == run.id:
        return
    front = run.depth_before
    # Distances along the run's line, and before it, of the other run.
    points = [run.to_local(other.at(u, v)) for u in other.span for v in (-other.depth_behind, other.depth_before)]
    us, vs = zip(*points, strict=True)
    if max(vs) <= front + MIN_OVERLAP_M or min(vs) >= front + STANDING_DEPTH_M:
        return
    if min(us) >= right - 1e-3:
        yield round(min(us) - right, 4)
    elif max(us) <= left + 1e-3:
        yield round(left - max(us), 4)


def hoods_clear_cooktops(subject: DesignSubject, limit: float) -> Measurement:
    """NKB008: height of the lowest hood over its cooktop, metres."""
    # Ref: NKBA planning guideline 18: 24 inches to a protected surface.
    return _clearance(subject, limit, hoods=True)


def cabinets_clear_cooktops(subject: DesignSubject, limit: float) -> Measurement:
    """NKB009: height of the lowest cabinet or shelf over a cooktop without a hood between, metres."""
    # Ref: NKBA planning guideline 18: 30 inches to a surface that can burn.
    return _clearance(subject, limit, hoods=False)


def _clearance(subject: DesignSubject, limit: float, hoods: bool) -> Measurement:
    gaps = []
    for cooktop in subject.facts.with_role(*COOKTOPS):
        above = sorted(over(subject.facts, cooktop), key=lambda f: f.bottom)
        # What hangs above a hood is shielded by it.
        exposed = above[:1] if hoods or (above and above[0].role is Role.HOOD) else above
        # The surface for pans; a range may have a panel behind it that is higher.
        places = [m.position[2] for m in cooktop.sites if m.name.endswith("_place_site")]
        surface = min(cooktop.top, max(places, default=cooktop.top))
        for other in (f for f in exposed if (f.role is Role.HOOD) is hoods):
            gap = round(other.bottom - surface, 4)
            gaps.append((f"fixtures/{cooktop.name}", gap, f"{other.name} hangs {gap:.3f} m over it, {limit:g} wanted"))
    return worst_below(gaps, limit, f"no {'hood' if hoods else 'cabinet or shelf'} hangs over a cooktop")


def over(facts: KitchenFacts, below: Fixture) -> list[Fixture]:
    """Fixtures on the wall or under the ceiling above a fixture, without lamps and worktop items."""
    hung = facts.with_role(Role.HOOD, Role.UPPER, Role.SHELF, Role.HOUSING)
    above = (f for f in hung if f.bottom >= below.top)
    return [f for f in above if penetration_depth(f.footprint.corners, below.footprint.corners) > MIN_OVERLAP_M]


def no_openable_window_over_cooktops(subject: DesignSubject, limit: float) -> Measurement:
    """NKB010: width of openable window over a cooktop, metres."""
    # Ref: NKBA planning guideline 20.
    windows = [w for w in subject.facts.openings if w.kind is OpeningKind.WINDOW and w.can_open]
    if not windows or not subject.facts.with_role(*COOKTOPS):
        return not_applicable("it has no cooktop" if windows else "none of its windows opens")
    rows, walls = [], {w.id: w for w in subject.facts.walls}
    for window in windows:
        for cooktop in subject.facts.with_role(*COOKTOPS):
            shared = _length_before(walls[window.wall], window.start, window.end, cooktop)
            message = f"it stands under {window.id}, which opens, along {shared:.2f} m: move it, or fix the sash"
            rows.append((f"fixtures/{cooktop.name}", shared, message))
    return worst_above(rows, limit)


def _length_before(wall: RoomWall, start: Vec2, end: Vec2, fixture: Fixture) -> float:
    """Length of the part of a wall section that has a fixture directly in front of it, metres."""
    (ax, ay), (bx, by) = wall.start, wall.end
    length = max(math.hypot(bx - ax, by - ay), 1e-9)
    cx, cy = (bx - ax) / length, (by - ay) / length

    corners = fixture.footprint.corners
    away = [(p[0] - ax) * cy - (p[1] - ay) * cx for p in corners]
    if min(away) > NEAR_WALL_M or max(away) < 0.0:
        return 0.0
    *us, first, last = ((p[0] - ax) * cx + (p[1] - ay) * cy for p in (*corners, start, end))
    low, high = sorted((first, last))
    return max(0.0, min(max(us), high) - max(min(us), low))


def appliances_keep_off_corners(subject: DesignSubject, limit: float) -> Measurement:
    """NKB011: least distance of an appliance from an inside corner of the worktops, metres."""
    # Ref: Louisiana State University AgCenter, kitchen guidelines: 15 inches, so that handles clear drawers.
    gaps = (
        (f"units/{name}", gap, f"{gap:.3f} m to the inside corner, {limit:g} wanted")
        for run in subject.facts.runs
        for name, gap in _corner_distances(subject.facts, run)
    )
    return worst_below(gaps, limit, "no appliance stands in a row with a corner")


def _corner_distances(facts: KitchenFacts, run: PlacedRun) -> Iterator[tuple[str, float]]:
    """Appliances of a run that ends at a corner, and their distance from where the edges of the two worktops meet."""
    before = next((r for r in facts.runs if r.next_run == run.id), None)
    after = facts.run(run.next_run) if run.next_run else None
    units = [u for u in run.units if u.kind in APPLIANCE_UNITS]
    for unit in units:
        if before is not None and run.left_end is RunEnd.CORNER:
            yield unit.name, round(unit.left - before.depth_before, 4)
        if after is not None and run.right_end is RunEnd.CORNER:
            yield unit.name, round(run.length - after.depth_before - unit.right, 4)


def doorways_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB001: clear width of the narrowest door or passage, metres."""
    # Ref: NKBA planning guideline 1: 32 inches clear.
    ways = (opening for opening in subject.facts.openings if opening.kind is not OpeningKind.WINDOW)
    widths = {f"openings/{opening.id}": opening.clear_width for opening in ways}
    message = f"{{:.3f}} m clear with its leaf open, {limit:g} wanted: make the opening wider"
    return all_at_least(widths, limit, message, "it has no door and no passage")


def entry_doors_swing_freely(subject: DesignSubject, limit: float) -> Measurement:
    """NKB002: deepest overlap of an entry door's swing with an appliance or its door, metres."""
    # Ref: NKBA planning guideline 2.
    doors = [(o.id, o.swept_area) for o in subject.facts.openings if o.swept_area is not None]
    if not doors:
        return not_applicable("it has no door with a leaf")
    rows, fixtures = [], subject.facts.with_role(*APPLIANCES)
    solids = [*((f.name, f.footprint.corners, f.bottom, f.top) for f in fixtures), *_appliance_leaves(subject.facts)]
    for door, leaf in doors:
        for name, outline, bottom, top in solids:
            if _share_height(leaf.bottom, leaf.top, bottom, top):
                depth = penetration_depth(leaf.outline, outline)
                rows.append((f"openings/{door}", depth, f"its leaf swings {depth:.3f} m into {name}"))
    return worst_above(rows, limit)


def appliance_doors_swing_apart(subject: DesignSubject, limit: float) -> Measurement:
    """NKB003: deepest overlap of the swings of two appliances' doors, seen from above; metres."""
    # Ref: NKBA planning guideline 2.
    rows, leaves = [], list(_appliance_leaves(subject.facts))
    if len({name.partition("/")[0] for name, *_ in leaves}) < 2:
        return not_applicable("it has no two appliances that open")
    for (name, outline, bottom, top), (other, outline2, bottom2, top2) in itertools.combinations(leaves, 2):
        is_same = name.partition("/")[0] == other.partition("/")[0]
        if is_same or not _share_height(bottom, top, bottom2, top2):
            continue
        depth = penetration_depth(outline, outline2)
        rows.append((f"fixtures/{name}", depth, f"its way crosses that of {other} by {depth:.3f} m"))
    return worst_above(rows, limit)


def _appliance_leaves(facts: KitchenFacts) -> Iterator[Solid]:
    """Doors, flaps and drawers of appliances, called `<fixture>/<joint>`; not those that another one has to uncover."""
    for fixture in facts.with_role(*APPLIANCES):
        for joint in fixture.joints:
            leaf = joint.swept_area
            if leaf is not None and joint.behind is None:
                yield f"{fixture.name}/{joint.name}", leaf.outline, leaf.bottom, leaf.top


def _share_height(bottom1: float, top1: float, bottom2: float, top2: float) -> bool:
    """True if two ranges of height share more than a centimetre."""
    return min(top1, top2) - max(bottom1, bottom2) > 0.01


def work_aisles_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB004: narrowest work aisle of a kitchen that is not declared compact, metres."""
    # Ref: NKBA planning guideline 6: 42 inches for one cook.
    if subject.facts.compact:
        return not_applicable("its plan says that it is compact (NKB005)")
    return _narrowest(subject, limit, AisleKind.WORK)


def compact_work_aisles_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB005: narrowest work aisle of a kitchen that is declared compact, metres."""
    if not subject.facts.compact:
        return not_applicable("its plan does not say that it is compact (NKB004)")
    return _narrowest(subject, limit, AisleKind.WORK)


def walkways_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB006: narrowest walkway between fixtures of a kitchen and along walls, metres."""
    # Ref: NKBA planning guideline 7: 36 inches.
    return _narrowest(subject, limit, AisleKind.WALK)


def _narrowest(subject: DesignSubject, limit: float, kind: AisleKind) -> Measurement:
    aisles = (
        (f"aisles/{a.first}", a.width, f"{a.width:.3f} m between {a.first} and {a.second}, {limit:g} wanted")
        for a in subject.facts.aisles
        if a.kind is kind
    )
    return worst_below(aisles, limit, NO_AISLE[kind])
