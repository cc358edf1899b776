"""Find appliances in unsafe or cramped places: no standing room, under windows, near corners."""

from __future__ import annotations

import math
from collections.abc import Iterator

from casa_assets.checks.check import Measurement, least, not_applicable
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.geometry.outline import penetration_depth
from casa_assets.model.kitchen.floor import Fixture, KitchenFacts, PlacedRun, Role, RoomWall, RunEnd
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Vec2

COOKTOPS = (Role.RANGE, Role.HOB)
# Kinds of units that are appliances whose doors or cooks need room beside a corner.
APPLIANCE_UNITS = ("range", "hob", "dishwasher", "oven", "microwave", "fridge")
STANDING_DEPTH_M = 0.6  # before a dishwasher, in which the one who loads it stands
NEAR_WALL_M = 0.8  # from a wall, within which a cooktop stands at it
MIN_OVERLAP_M = 0.02  # by which something has to reach over a cooktop to be above it


def dishwashers_have_standing_room(subject: DesignSubject, limit: float) -> Measurement:
    """NKB007: least distance of a dishwasher from what stands at a right angle to it, metres."""
    # Ref: NKBA planning guideline 13: 21 inches.
    facts, gaps = subject.facts, []
    for run in facts.runs:
        for unit in (u for u in run.units if u.kind == "dishwasher"):
            gaps += [(unit.name, o.id, gap) for o in facts.runs for gap in _beside(run, unit.left, unit.right, o)]
    problems = tuple(
        (f"units/{name}", f"{gap:.3f} m to {other} at a right angle to it, {limit:g} wanted to stand in")
        for name, other, gap in gaps
        if gap < limit
    )
    return least((gap for _, _, gap in gaps), problems, "nothing stands at a right angle to a dishwasher")


def _beside(run: PlacedRun, left: float, right: float, other: PlacedRun) -> Iterator[float]:
    """Distance along a run from a unit to another run that reaches out before the fronts beside it."""
    if other.id == run.id:
        return
    (us, vs), front = _box_in(run, other), run.depth_before
    if vs[1] <= front + MIN_OVERLAP_M or vs[0] >= front + STANDING_DEPTH_M:
        return
    if us[0] >= right - 1e-3:
        yield round(us[0] - right, 4)
    elif us[1] <= left + 1e-3:
        yield round(left - us[1], 4)


def _box_in(run: PlacedRun, other: PlacedRun) -> tuple[Vec2, Vec2]:
    """Least and greatest distance along a run's line, and before it, of another run."""
    first, last = other.span
    points = [run.to_local(other.at(u, v)) for u in (first, last) for v in (-other.depth_behind, other.depth_before)]
    us, vs = [p[0] for p in points], [p[1] for p in points]
    return (min(us), max(us)), (min(vs), max(vs))


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
        gaps += [
            (cooktop.name, f.name, round(f.bottom - _cooking_height(cooktop), 4))
            for f in exposed
            if (f.role is Role.HOOD) is hoods
        ]
    problems = tuple(
        (f"fixtures/{name}", f"{other} hangs {gap:.3f} m over it, {limit:g} wanted")
        for name, other, gap in gaps
        if gap < limit
    )
    kind = "hood" if hoods else "cabinet or shelf"
    return least((gap for _, _, gap in gaps), problems, f"no {kind} hangs over a cooktop")


def _cooking_height(cooktop: Fixture) -> float:
    """Height of the surface that pans stand on; a range may have a panel behind it that is higher."""
    places = [m.position[2] for m in cooktop.sites if m.name.endswith("_place_site")]
    return min(cooktop.top, max(places, default=cooktop.top))


def over(facts: KitchenFacts, below: Fixture) -> list[Fixture]:
    """Fixtures on the wall or under the ceiling above a fixture, without lamps and worktop items."""
    hung = facts.with_role(Role.HOOD, Role.UPPER, Role.SHELF, Role.HOUSING)
    return [
        f
        for f in hung
        if f.bottom >= below.top and penetration_depth(f.footprint.corners, below.footprint.corners) > MIN_OVERLAP_M
    ]


def no_openable_window_over_cooktops(subject: DesignSubject, limit: float) -> Measurement:
    """NKB010: width of openable window over a cooktop, metres."""
    # Ref: NKBA planning guideline 20.
    windows = [w for w in subject.facts.openings if w.kind is OpeningKind.WINDOW and w.can_open]
    if not windows or not subject.facts.with_role(*COOKTOPS):
        return not_applicable("it has no cooktop" if windows else "none of its windows opens")
    worst, problems = 0.0, []
    walls = {w.id: w for w in subject.facts.walls}
    for window in windows:
        for cooktop in subject.facts.with_role(*COOKTOPS):
            shared = _length_before(walls[window.wall], window.start, window.end, cooktop)
            worst = max(worst, shared)
            if shared > limit:
                message = f"it stands under {window.id}, which opens, along {shared:.2f} m: move it, or fix the sash"
                problems.append((f"fixtures/{cooktop.name}", message))
    return Measurement(worst, tuple(problems))


def _length_before(wall: RoomWall, start: Vec2, end: Vec2, fixture: Fixture) -> float:
    """Length of a piece of wall that a fixture stands right before, metres."""
    (ax, ay), (bx, by) = wall.start, wall.end
    length = max(math.hypot(bx - ax, by - ay), 1e-9)
    cx, cy = (bx - ax) / length, (by - ay) / length

    def along(p: Vec2) -> float:
        return (p[0] - ax) * cx + (p[1] - ay) * cy

    corners = fixture.footprint.corners
    away = [(p[0] - ax) * cy - (p[1] - ay) * cx for p in corners]
    if min(away) > NEAR_WALL_M or max(away) < 0.0:
        return 0.0
    us = [along(p) for p in corners]
    low, high = sorted((along(start), along(end)))
    return max(0.0, min(max(us), high) - max(min(us), low))


def appliances_keep_off_corners(subject: DesignSubject, limit: float) -> Measurement:
    """NKB011: least distance of an appliance from an inside corner of the worktops, metres."""
    # Ref: Louisiana State University AgCenter, kitchen guidelines: 15 inches, so that handles clear drawers.
    gaps = [gap for run in subject.facts.runs for gap in _corner_distances(subject.facts, run)]
    problems = tuple(
        (f"units/{name}", f"{gap:.3f} m to the inside corner, {limit:g} wanted") for name, gap in gaps if gap < limit
    )
    return least((gap for _, gap in gaps), problems, "no appliance stands in a row with a corner")


def _corner_distances(facts: KitchenFacts, run: PlacedRun) -> Iterator[tuple[str, float]]:
    """Appliances of a run beside a corner, and how far they are from where the two worktops' edges meet."""
    before = next((r for r in facts.runs if r.next_run == run.id), None)
    after = facts.run(run.next_run) if run.next_run else None
    units = [u for u in run.units if u.kind in APPLIANCE_UNITS]
    for unit in units:
        if before is not None and run.left_end is RunEnd.CORNER:
            yield unit.name, round(unit.left - before.depth_before, 4)
        if after is not None and run.right_end is RunEnd.CORNER:
            yield unit.name, round(run.length - after.depth_before - unit.right, 4)
