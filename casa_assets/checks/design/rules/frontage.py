"""Measure the free worktop beside appliances, along the fronts of a run."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from casa_assets.model.kitchen.floor import Fixture, KitchenFacts, PlacedRun, Role, RunEnd
from casa_assets.model.record import Vec2

COOKTOPS = (Role.RANGE, Role.HOB)
# Panels and strips between an appliance and its worktop, metres.
STRIP = 0.13


def along(facts: KitchenFacts, fixture: Fixture) -> tuple[PlacedRun, float, float] | None:
    """The run of a fixture, and where it begins and ends along that; None where it stands in no run."""
    run = facts.run(fixture.run)
    if run is None:
        return None
    u = run.to_local(fixture.footprint.center)[0]
    half = fixture.footprint.size[0] / 2
    return run, u - half, u + half


def beside(facts: KitchenFacts, run: PlacedRun, left: float, right: float) -> Vec2:
    """Metres of uninterrupted worktop to the left and to the right of a stretch of a run, up to inside corners."""
    before = after = 0.0
    for a, b in run.frontages:
        if a < left + 0.01 and b > left - STRIP:
            before = max(0.0, min(left, b) - a) + (_to_corner(facts, run) if _first(run, a) else 0.0)
        if b > right - 0.01 and a < right + STRIP:
            after = max(0.0, b - max(right, a)) + (_past_corner(facts, run) if _last(run, b) else 0.0)
    return before, after


def _first(run: PlacedRun, at: float) -> bool:
    return run.left_end is RunEnd.CORNER and abs(at - run.corner_left) < 0.01


def _last(run: PlacedRun, at: float) -> bool:
    return run.right_end is RunEnd.CORNER and abs(at - (run.length - run.corner_right)) < 0.01


def _to_corner(facts: KitchenFacts, run: PlacedRun) -> float:
    """Frontage between the first unit and the corner where the edges of two worktops meet."""
    before = next((r for r in facts.runs if r.next_run == run.id), None)
    return max(0.0, run.corner_left - (before.depth_before if before else 0.0))


def _past_corner(facts: KitchenFacts, run: PlacedRun) -> float:
    after = facts.run(run.next_run) if run.next_run else None
    return max(0.0, run.corner_right - (after.depth_before if after else 0.0))


def landings(facts: KitchenFacts, *roles: Role) -> Iterator[tuple[Fixture, Vec2]]:
    """Fixtures of these roles with the worktop to their left and right."""
    for fixture in facts.with_role(*roles):
        place = along(facts, fixture)
        if place is not None:
            yield fixture, beside(facts, *place)


def unit_landings(facts: KitchenFacts, kind: str) -> Iterator[tuple[PlacedRun, Vec2]]:
    """Units of a kind with the worktop to their left and right."""
    for run in facts.runs:
        for unit in run.units:
            if unit.kind == kind:
                yield run, beside(facts, run, unit.left, unit.right)


def across(facts: KitchenFacts, run: PlacedRun, most: float) -> bool:
    """True if a worktop lies within reach at the other side of the aisle before a run."""
    return any(a.width <= most for a in facts.aisles if run.id in (a.first, a.second) and a.kind.value == "work")


def longer_sink_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop at the better side of the sink that has most."""
    return max((max(sides) for _, sides in landings(facts, Role.SINK)), default=None)


def shorter_sink_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop at the other side of that sink."""
    best = max((sides for _, sides in landings(facts, Role.SINK)), key=max, default=None)
    return None if best is None else min(best)


def prep_area(facts: KitchenFacts) -> float | None:
    """Metres of the widest uninterrupted worktop that begins at a sink."""
    return longer_sink_side(facts)


def longer_cook_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop at the better side of the cooktop that has least."""
    return min((max(sides) for _, sides in landings(facts, *COOKTOPS)), default=None)


def shorter_cook_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop at the other side of the cooktop that has least."""
    return min((min(sides) for _, sides in landings(facts, *COOKTOPS)), default=None)


def behind_cooktop(facts: KitchenFacts) -> float | None:
    """Metres of worktop behind cooktops in islands; None where there is none."""
    found = []
    for fixture in facts.with_role(*COOKTOPS):
        run = facts.run(fixture.run)
        if run is not None and not run.at_wall:
            _, v = run.to_local(fixture.footprint.at(0.0, -fixture.footprint.size[1]))
            found.append(v + run.depth_behind)
    return min(found, default=None)


def fridge_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop on the side to which a refrigerator opens; with two doors, on the better side."""
    found = []
    for run, (left, right) in unit_landings(facts, "fridge"):
        if across(facts, run, 1.219):
            left = right = max(left, right, 0.381)
        fridge = next((f for f in facts.with_role(Role.FRIDGE) if f.run == run.id), None)
        grips = (
            [f.grip_point for f in fridge.joints if f.grip_point and f.swept_area and not f.swept_area.sweeps_front]
            if fridge
            else []
        )
        sides = [fridge.footprint.to_local((g[0], g[1]))[0] for g in grips] if fridge else []
        one_sided = bool(sides) and (min(sides) > 0.1 or max(sides) < -0.1)
        found.append((right if min(sides) > 0 else left) if one_sided else max(left, right))
    return min(found, default=None)


def oven_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop beside wall ovens, or across from them."""
    found = []
    for run, sides in unit_landings(facts, "oven"):
        found.append(max(*sides, 0.381 if across(facts, run, 1.219) else 0.0))
    return min(found, default=None)


def microwave_side(facts: KitchenFacts) -> float | None:
    """Metres of worktop beside, below or next to the microwave that has least of it."""
    found = []
    for fixture in facts.with_role(Role.MICROWAVE):
        place = along(facts, fixture)
        if place is None:
            continue
        run, left, right = place
        below = any(a < right and b > left for a, b in run.frontages)
        # Before one that stands on a worktop there is none of use, under one that hangs there is all of it.
        sides = beside(facts, run, left, right)
        found.append(max(*sides, fixture.footprint.size[0] if below and fixture.bottom > 1.2 else 0.0))
    return min(found, default=None)


def total_frontage(facts: KitchenFacts) -> float | None:
    """Metres of worktop edge in the whole kitchen, sinks and hobs not counted."""
    total = sum(b - a for run in facts.runs for a, b in run.frontages)
    taken = sum(f.footprint.size[0] for f in facts.with_role(Role.SINK, Role.HOB))
    return total - taken if facts.runs else None


# What NKBA asks for beside each, metres, the least that serves.
LANDING = {"sink": 0.61, "range": 0.381, "hob": 0.381, "fridge": 0.381, "oven": 0.381}


def shared_landing(facts: KitchenFacts) -> float | None:
    """Metres by which worktop between two places of work exceeds the longer landing and 0.305 m; the least."""
    found = []
    for run in facts.runs:
        centres = [u for u in run.units if u.kind in LANDING]
        for one, other in itertools.pairwise(centres):
            between = [u for u in run.units if one.right - 0.01 <= u.left and u.right <= other.left + 0.01]
            if between and all(u.has_worktop for u in between):
                found.append(other.left - one.right - max(LANDING[one.kind], LANDING[other.kind]) - 0.305)
    return min(found, default=None)
