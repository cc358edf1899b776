"""Grade of a kitchen by advisory rules: seats, heights, standard sizes, worktop and wheelchair access.

Ref: NKBA Kitchen Planning Guidelines with Access Standards, 2nd edition (numbers N...); Louisiana State University
AgCenter, kitchen guidelines (L...); trade sizes (D...); 2010 ADA Standards (A...).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.design.floor_map import BASE_RADIUS_M, CELL_M, GAP_M, obstacles
from casa_assets.checks.design.rules import COOKTOPS, over
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.core.numeric import decimals
from casa_assets.mesh.planar import length_inside, outline_of
from casa_assets.model.kitchen.floor import (
    APPLIANCES,
    AisleKind,
    Fixture,
    Footprint,
    KitchenFacts,
    PlacedRun,
    Role,
    RunEnd,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Record, Vec2

FAR = 3.0  # metres behind a seat that are looked at
# Ref: 2010 ADA Standards 804, 305, 306, 308, 309; ICC A117.1 1003.12.
CLEAR = (0.762, 1.219)  # metres of free floor at each place of work, either way round
REACH = (0.381, 1.219)  # heights that a seated person reaches, metres
Measure = Callable[[DesignSubject], Sequence[float]]
STRIP = 0.13  # panels and strips between an appliance and its worktop, metres
# What NKBA asks for beside each, metres, the least that serves.
LANDING = {"sink": 0.61, "range": 0.381, "hob": 0.381, "fridge": 0.381, "oven": 0.381}
TALL = 1.5  # metres
FULL_DEPTH = 0.5


def _seats(facts: KitchenFacts) -> list[Fixture]:
    return [seat for seat in facts.with_role(Role.SEAT) if seat.run]


def _seat_widths(subject: DesignSubject) -> list[float]:
    seats = _seats(subject.facts)
    pairs = [(a.footprint, b.footprint) for a in seats for b in seats if a is not b and a.run == b.run]
    return [math.dist(a.center, b.center) for a, b in pairs]


def _sink_to_dishwasher(subject: DesignSubject) -> list[float]:
    """Metres between the nearest edges of dishwasher and sink."""
    feet = ([f.footprint for f in subject.facts.with_role(role)] for role in (Role.DISHWASHER, Role.SINK))
    washers, sinks = ([f.at(share * f.size[0], 0.0) for f in found for share in (-0.5, 0.5)] for found in feet)
    gap = min((math.dist(edge, other) for edge in washers for other in sinks), default=None)
    return [] if gap is None else [gap]


def _hooded(subject: DesignSubject) -> list[float]:
    cooktops = subject.facts.with_role(*COOKTOPS)
    covered = [c for c in cooktops if any(f.role is Role.HOOD for f in over(subject.facts, c))]
    return [len(covered) / len(cooktops)] if cooktops else []


def _cooktop_to_wall(subject: DesignSubject) -> list[float]:
    found = []
    for run in subject.facts.runs:
        for unit in (u for u in run.units if u.kind in ("range", "hob")):
            found += [unit.left] if run.left_end is RunEnd.WALL else []
            found += [run.length - unit.right] if run.right_end is RunEnd.WALL else []
    return found


def _aisles_in_a_u(subject: DesignSubject) -> list[float]:
    """Metres between fronts in the middle of three joined runs."""
    facts = subject.facts
    ends = {r.id: r.next_run for r in facts.runs}
    trios = [(a, n) for a, b in ends.items() if b is not None and (n := ends.get(b)) is not None]
    return [x.width for x in facts.aisles if any({x.first, x.second} == set(trio) for trio in trios)]


def _lacking_floor(subject: DesignSubject) -> list[float]:
    worked = subject.facts.with_role(Role.SINK, *APPLIANCES)
    return [float(sum(not _has_floor(subject, f) for f in worked))] if worked else []


def _lowest(heights: list[float]) -> list[float]:
    return [min(heights)] if heights else []


def _free_behind(facts: KitchenFacts, seat: Fixture) -> float:
    """Metres from the back edge of a seat to the nearest obstacle behind it."""
    run = facts.run(seat.run)
    assert run is not None
    # Seats look at the run's back: behind them is away from it.
    u, v = run.to_local(seat.footprint.center)
    start = -v + seat.footprint.size[1] / 2
    free, step = FAR, 0.05
    for outline in obstacles(facts.replace(fixtures=())):
        for k in range(math.ceil(free / step - 1e-9)):
            a, b = run.at(u, -(start + k * step)), run.at(u, -(start + (k + 1) * step))
            if length_inside(outline, a, b) > 0:
                free = k * step
                break
    return free


def _above_worktop(subject: DesignSubject) -> list[float]:
    high = max((r.height for r in subject.facts.runs), default=0.92)
    return [f.bottom - high for f in subject.facts.with_role(Role.UPPER, Role.SHELF) if high < f.bottom < high + 0.7]


def _has_floor(subject: DesignSubject, fixture: Fixture) -> bool:
    """True if there is `CLEAR` floor before a fixture."""
    place = subject.parking.shut.get(fixture.name)
    if place is None:
        return False
    _, before = fixture.footprint.to_local(place.position)
    start = before - BASE_RADIUS_M - GAP_M
    for wide, deep in (CLEAR, CLEAR[::-1]):
        middle, size = fixture.footprint.at(0.0, start + deep / 2 + CELL_M), (wide - CELL_M, deep - CELL_M)
        if not _is_taken(subject, Footprint(center=middle, size=size, yaw=fixture.footprint.yaw)):
            return True
    return False


def _is_taken(subject: DesignSubject, foot: Footprint) -> bool:
    floor, (w, d) = subject.floor, foot.size
    cells = itertools.product(range(int(w / CELL_M) + 1), range(int(d / CELL_M) + 1))
    return any(floor.holds(floor.solid, foot.at(-w / 2 + i * CELL_M, -k * CELL_M)) for i, k in cells)


def _reached_grips(subject: DesignSubject) -> list[float]:
    """Share of all handles, knobs and keys that a seated person reaches."""
    grips = [j.grip_point[2] for f in subject.facts.fixtures for j in f.joints if j.grip_point is not None]
    return [sum(REACH[0] <= z <= REACH[1] for z in grips) / len(grips)] if grips else []


def _reached_shelves(subject: DesignSubject) -> list[float]:
    """Share of shelves and drawers, by their area, whose floor a seated person reaches."""
    kept = (Role.CABINET, Role.DRAWERS, Role.UPPER, Role.SHELF, Role.PANTRY, Role.CORNER, Role.ISLAND, Role.SINK_BASE)
    shelves = [v for f in subject.facts.with_role(*kept) for v in f.regions if v.name not in ("main", "int")]
    areas = [v.footprint.size[0] * v.footprint.size[1] for v in shelves]
    reached = (area for area, v in zip(areas, shelves, strict=True) if REACH[0] <= v.bottom <= REACH[1])
    return [sum(reached) / sum(areas)] if sum(areas) else []


@dataclass(frozen=True)
class Rule:
    """An advisory rule; `most`: the number may be at most the limit. Of what is measured the worst number counts."""

    id: str
    title: str
    limit: float
    unit: str
    most: bool
    measure: Measure


class Finding(Record):
    """Result of a rule; `passed` is None if it does not apply, `waived` if it fails and the plan is compact."""

    rule: str
    title: str
    number: float | None = None
    limit: float
    unit: str
    most: bool
    passed: bool | None = None
    waived: bool = False


class Grade(Record):
    """All findings.

    Attributes:
        score: 0..100, share of the rules that apply and are kept. access_score: the same of the access profile.
    """

    score: float
    access_score: float
    design: tuple[Finding, ...]
    access: tuple[Finding, ...]


def along(facts: KitchenFacts, fixture: Fixture) -> tuple[PlacedRun, float, float] | None:
    """The run of a fixture, and its start and end along the run; None if it is in no run."""
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
            before = max(0.0, min(left, b) - a)
            # Frontage between the first unit and the corner where the edges of two worktops meet.
            if run.left_end is RunEnd.CORNER and abs(a - run.corner_left) < 0.01:
                last_run = next((r for r in facts.runs if r.next_run == run.id), None)
                before += max(0.0, run.corner_left - (last_run.depth_before if last_run else 0.0))
        if b > right - 0.01 and a < right + STRIP:
            after = max(0.0, b - max(right, a))
            if run.right_end is RunEnd.CORNER and abs(b - (run.length - run.corner_right)) < 0.01:
                next_run = facts.run(run.next_run) if run.next_run else None
                after += max(0.0, run.corner_right - (next_run.depth_before if next_run else 0.0))
    return before, after


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


def sink_sides(facts: KitchenFacts) -> list[float]:
    """Metres of worktop at the narrower and the wider side of the sink that has most of it; empty without a sink."""
    return sorted(max((sides for _, sides in landings(facts, Role.SINK)), key=max, default=()))


def behind_cooktops(facts: KitchenFacts) -> list[float]:
    """Metres of worktop behind cooktops in islands."""
    found = []
    for fixture in facts.with_role(*COOKTOPS):
        run = facts.run(fixture.run)
        if run is not None and not run.at_wall:
            _, v = run.to_local(fixture.footprint.at(0.0, -fixture.footprint.size[1]))
            found.append(v + run.depth_behind)
    return found


def fridge_side(facts: KitchenFacts) -> list[float]:
    """Metres of worktop on the side to which a refrigerator opens; with two doors, on the better side."""
    found = []
    for run, (left, right) in unit_landings(facts, "fridge"):
        if across(facts, run, 1.219):
            left = right = max(left, right, 0.381)
        fridge = next((f for f in facts.with_role(Role.FRIDGE) if f.run == run.id), None)
        doors = [j for j in fridge.joints if j.swept_area and not j.swept_area.sweeps_front] if fridge else []
        grips = [j.grip_point for j in doors if j.grip_point]
        sides = [fridge.footprint.to_local((g[0], g[1]))[0] for g in grips] if fridge else []
        one_sided = bool(sides) and (min(sides) > 0.1 or max(sides) < -0.1)
        found.append((right if min(sides) > 0 else left) if one_sided else max(left, right))
    return found


def oven_side(facts: KitchenFacts) -> list[float]:
    """Metres of worktop next to wall ovens, or across from them."""
    ovens = unit_landings(facts, "oven")
    return [max(*sides, 0.381 if across(facts, run, 1.219) else 0.0) for run, sides in ovens]


def microwave_side(facts: KitchenFacts) -> list[float]:
    """Metres of worktop at the better side of microwaves, or below them."""
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
    return found


def total_frontage(facts: KitchenFacts) -> list[float]:
    """Metres of worktop edge in the whole kitchen, sinks and hobs not counted."""
    total = sum(b - a for run in facts.runs for a, b in run.frontages)
    return [total - sum(f.footprint.size[0] for f in facts.with_role(Role.SINK, Role.HOB))] if facts.runs else []


def shared_landing(facts: KitchenFacts) -> list[float]:
    """Metres by which worktop between two places of work exceeds the longer landing and 0.305 m."""
    found = []
    for run in facts.runs:
        centres = [u for u in run.units if u.kind in LANDING]
        for one, other in itertools.pairwise(centres):
            between = [u for u in run.units if one.right - 0.01 <= u.left and u.right <= other.left + 0.01]
            if between and all(u.has_worktop for u in between):
                found.append(other.left - one.right - max(LANDING[one.kind], LANDING[other.kind]) - 0.305)
    return found


def centres(facts: KitchenFacts) -> list[tuple[Fixture, Vec2]]:
    """The first sink, cooktop and refrigerator, and the middles of their fronts."""
    found = []
    for roles in ((Role.SINK,), COOKTOPS, (Role.FRIDGE,)):
        first = next(iter(facts.with_role(*roles)), None)
        if first is not None:
            found.append((first, first.footprint.at(0.0, 0.0)))
    return found


def legs(facts: KitchenFacts) -> list[tuple[Vec2, Vec2]]:
    """Straight ways between them, three where all are there."""
    points = [p for _, p in centres(facts)]
    return list(itertools.combinations(points, 2)) if len(points) == 3 else []


def leg_lengths(facts: KitchenFacts) -> list[float]:
    """Metres of each of them."""
    return [math.dist(*leg) for leg in legs(facts)]


def cut(facts: KitchenFacts) -> list[float]:
    """Metres of each leg of the work triangle that cross an island or a peninsula."""
    runs = [r for r in facts.runs if not r.at_wall and r.units]
    own = {f.run for f, _ in centres(facts)}
    crossed = []
    for run in (run for run in runs if run.id not in own):
        corners = [run.at(u, v) for u in run.span for v in (-run.depth_behind, run.depth_before)]
        crossed += [length_inside(outline_of(corners), a, b) for a, b in legs(facts)]
    return crossed


def tall_between(facts: KitchenFacts) -> list[float]:
    """Tall units of full depth between two of the three in one run."""
    if not legs(facts):
        return []
    count, own = 0, {f.unit for f, _ in centres(facts)}
    for run in facts.runs:
        us = sorted(run.to_local(p)[0] for f, p in centres(facts) if f.run == run.id)
        for a, b in itertools.pairwise(us):
            inner = [u for u in run.units if u.left > a and u.right < b and u.name not in own]
            count += sum(1 for u in inner if u.height > TALL and u.front > FULL_DEPTH)
    return [float(count)]


def crossed(facts: KitchenFacts) -> list[float]:
    """Metres of each straight way from door to door inside the triangle."""
    doors = [w for w in facts.openings if w.kind is not OpeningKind.WINDOW and w.leads_out]
    points = [p for _, p in centres(facts)]
    if len(doors) < 2 or len(points) < 3:
        return []
    middles = [((w.start[0] + w.end[0]) / 2, (w.start[1] + w.end[1]) / 2) for w in doors]
    triangle = outline_of(points)
    ways = itertools.combinations(middles, 2)
    return [length_inside(triangle, a, b) for a, b in ways] if len(triangle) == 3 else [0.0]


def between_sink(facts: KitchenFacts) -> list[float]:
    """Number of cooktop and refrigerator that are neither next to a sink nor across from it."""
    found = centres(facts)
    if len(found) < 3:
        return []
    places = {f.name: _place(facts, f, p) for f, p in found}
    sink = found[0][0]
    lost = 0
    for fixture, _ in found[1:]:
        other = next(f for f, _ in found[1:] if f is not fixture)
        chain, at = places[fixture.name]
        here, middle = places[sink.name]
        there, third = places[other.name]
        next_to = chain == here and not (there == here and min(at, middle) < third < max(at, middle))
        lost += not (next_to or _across(sink, fixture))
    return [float(lost)]


def _place(facts: KitchenFacts, fixture: Fixture, point: Vec2) -> tuple[str, float]:
    """First run of the chain of runs around corners that a fixture is in, and its position along the chain."""
    run = facts.run(fixture.run)
    if run is None:
        return "", 0.0
    at = run.to_local(point)[0]
    seen = {run.id}
    while (before := next((r for r in facts.runs if r.next_run == run.id), None)) is not None and before.id not in seen:
        seen.add(before.id)
        at += before.length
        run = before
    return run.id, at


def _across(one: Fixture, other: Fixture) -> bool:
    (ax, ay), (bx, by) = one.footprint.front_axis, other.footprint.front_axis
    aside, before = one.footprint.to_local(other.footprint.at(0.0, 0.0))
    return ax * bx + ay * by < -0.9 and before > 0 and abs(aside) < 1.2


# fmt: off
DESIGN: tuple[Rule, ...] = (
    Rule("N3a", "all three legs of the work triangle", 7.925, "m", True,
         lambda s: [sum(lengths)] if (lengths := leg_lengths(s.facts)) else []),
    Rule("N3b_short", "shortest leg of the work triangle", 1.219, "m", False, lambda s: leg_lengths(s.facts)),
    Rule("N3b_long", "longest leg of the work triangle", 2.743, "m", True, lambda s: leg_lengths(s.facts)),
    Rule("N3c", "part of a triangle leg across an island", 0.305, "m", True, lambda s: cut(s.facts)),
    Rule("N4", "tall units between sink, cooktop and fridge", 0, "", True, lambda s: tall_between(s.facts)),
    Rule("N5", "way from door to door through the work triangle", 0, "m", True, lambda s: crossed(s.facts)),
    Rule("N8", "free space behind seats", 0.813, "m", False,
         lambda s: [_free_behind(s.facts, seat) for seat in _seats(s.facts)]),
    Rule("N9_width", "width of a seat at the worktop", 0.6, "m", False, _seat_widths),
    Rule("N9_knees", "knee space at the worktop", 0.381, "m", False,
         lambda s: [r.overhang for r in s.facts.runs if r.id in {seat.run for seat in _seats(s.facts)}]),
    Rule("N10", "cooktop and fridge away from the sink", 0, "", True, lambda s: between_sink(s.facts)),
    Rule("N11_long", "worktop on the wider side of the sink", 0.61, "m", False, lambda s: sink_sides(s.facts)[1:]),
    Rule("N11_short", "worktop on the narrower side of the sink", 0.457, "m", False, lambda s: sink_sides(s.facts)[:1]),
    Rule("N12", "worktop for preparing food beside the sink", 0.914, "m", False, lambda s: sink_sides(s.facts)[1:]),
    Rule("N13", "distance from dishwasher to sink", 0.914, "m", True, _sink_to_dishwasher),
    Rule("N16", "worktop beside the refrigerator", 0.381, "m", False, lambda s: fridge_side(s.facts)),
    Rule("N17_long", "worktop on the wider side of cooktops", 0.381, "m", False,
         lambda s: [max(sides) for _, sides in landings(s.facts, *COOKTOPS)]),
    Rule("N17_short", "worktop on the narrower side of cooktops", 0.305, "m", False,
         lambda s: [min(sides) for _, sides in landings(s.facts, *COOKTOPS)]),
    Rule("N17_behind", "worktop behind a cooktop in an island", 0.229, "m", False, lambda s: behind_cooktops(s.facts)),
    Rule("N19", "cooktops under a hood", 1, "", False, _hooded),
    Rule("N21_high", "height of the highest microwave", 1.372, "m", True,
         lambda s: [f.bottom for f in s.facts.with_role(Role.MICROWAVE)]),
    Rule("N21_low", "height of the lowest microwave", 0.381, "m", False,
         lambda s: [f.bottom for f in s.facts.with_role(Role.MICROWAVE)]),
    Rule("N22", "worktop beside the microwave", 0.381, "m", False, lambda s: microwave_side(s.facts)),
    Rule("N23", "worktop beside wall ovens", 0.381, "m", False, lambda s: oven_side(s.facts)),
    Rule("N24", "spare worktop where landing areas are shared", 0, "m", False, lambda s: shared_landing(s.facts)),
    Rule("N25", "total length of worktop", 4.013, "m", False, lambda s: total_frontage(s.facts)),
    Rule("L1_least", "smallest gap between worktop and wall units", 0.381, "m", False, _above_worktop),
    # 18 inches are 0.457 m; wall units hang at whole centimetres.
    Rule("L1_most", "largest gap between worktop and wall units", 0.462, "m", True, _above_worktop),
    Rule("L3", "distance from cooktop to the end wall", 0.076, "m", False, _cooktop_to_wall),
    Rule("D1_height", "height of worktops, difference from 36 inches", 0.025, "m", True,
         lambda s: [abs(r.height - 0.914) for r in s.facts.runs]),
    Rule("D1_depth", "depth of worktops", 0.61, "m", False, lambda s: [r.depth_before for r in s.facts.runs]),
)
ACCESS: tuple[Rule, ...] = (
    Rule("A1", "width of aisles", 1.015, "m", False,
         lambda s: [a.width for a in s.facts.aisles if a.kind is AisleKind.WORK]),
    Rule("A2", "width of the aisle in a U", 1.525, "m", False, _aisles_in_a_u),
    Rule("A3", "sinks and appliances without clear floor in front", 0, "", True, _lacking_floor),
    Rule("A4", "lowest worktop", 0.865, "m", True,
         lambda s: _lowest([r.height for r in s.facts.runs] + [t.top for t in s.facts.with_role(Role.TABLE)])),
    Rule("A5", "rim of the sink", 0.865, "m", True,
         lambda s: _lowest([run.height for f in s.facts.with_role(Role.SINK) if (run := s.facts.run(f.run))])),
    Rule("A6", "knee space below a worktop", 0.762, "m", False,
         lambda s: [max((u.right - u.left for r in s.facts.runs for u in r.units if u.kind == "gap" and u.has_worktop),
                        default=0.0)]),
    Rule("A7", "share of handles in reach", 0.5, "", False, _reached_grips),
    Rule("A8", "share of shelves in reach", 0.5, "", False, _reached_shelves),
    Rule("A10", "turning circle", 1.525, "m", False, lambda s: [2.0 * float((s.floor.clear * s.floor.room).max())]),
    Rule("A11", "narrowest doorway", 0.815, "m", False,
         lambda s: [w.clear_width for w in s.facts.openings if w.kind is not OpeningKind.WINDOW]),
)
# What small kitchens cannot keep; not counted where a plan says that it is compact.
COMPACT = frozenset({"N3b_short", "N11_short", "N12", "N17_short", "N24", "N25"})
# fmt: on


@lru_cache(maxsize=1)
def grade(subject: DesignSubject) -> Grade:
    """Every advisory rule and the access profile, measured once."""
    design = tuple(_find(rule, subject, subject.facts.compact and rule.id in COMPACT) for rule in DESIGN)
    profile = tuple(_find(rule, subject, False) for rule in ACCESS)
    return Grade(score=_score(design), access_score=_score(profile), design=design, access=profile)


def _find(rule: Rule, subject: DesignSubject, waived: bool) -> Finding:
    numbers = rule.measure(subject)
    number = decimals((max if rule.most else min)(numbers), 4) if numbers else None
    passed = None if number is None else (number <= rule.limit if rule.most else number >= rule.limit)
    row: dict[str, Any] = {"title": rule.title, "limit": rule.limit, "unit": rule.unit, "most": rule.most}
    return Finding(rule=rule.id, number=number, passed=passed, waived=waived and passed is False, **row)


def _score(findings: tuple[Finding, ...]) -> float:
    counted = [f.passed for f in findings if f.passed is not None and not f.waived]
    return round(100.0 * sum(counted) / len(counted), 1) if counted else 100.0


def design_score_is_high_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB012: share of applicable advisory design rules that are kept, of 100."""
    found = grade(subject)
    if all(f.passed is None or f.waived for f in found.design):
        return not_applicable("none of the advisory rules applies to it")
    if found.score >= limit:
        return Measurement(found.score)
    missed = [f for f in found.design if f.passed is False and not f.waived]
    problems = []
    for f in missed:
        advice = f"{'at most' if f.most else 'at least'} {f.limit:g} advised"
        problems.append((f"rules/{f.rule}", f"{f.title}: {f.number:g} {f.unit}, {advice}".replace(" ,", ",")))
    return Measurement(found.score, tuple(problems))
