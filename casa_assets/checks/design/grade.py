"""Grade of a kitchen by advisory rules: seats, heights, standard sizes, worktop and wheelchair access.

Ref: NKBA Kitchen Planning Guidelines with Access Standards, 2nd edition (numbers N...); Louisiana State University
AgCenter, kitchen guidelines (L...); trade sizes (D...); 2010 ADA Standards (A...).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.design import rules
from casa_assets.checks.design.floor_map import BASE_RADIUS_M, CELL_M, GAP_M, obstacles
from casa_assets.checks.design.rules import COOKTOPS, over
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.core.numeric import decimals
from casa_assets.mesh.planar import length_inside
from casa_assets.model.kitchen.floor import APPLIANCES, AisleKind, Fixture, Footprint, KitchenFacts, Role, RunEnd
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Record

FAR = 3.0  # metres behind a seat that are looked at
# Ref: 2010 ADA Standards 804, 305, 306, 308, 309; ICC A117.1 1003.12.
CLEAR = (0.762, 1.219)  # metres of free floor at each place of work, either way round
REACH = (0.381, 1.219)  # heights that a seated person reaches, metres
Measure = Callable[[DesignSubject], Sequence[float]]
# fmt: on
# What small kitchens cannot keep; not counted where a plan says that it is compact.
COMPACT = frozenset({"N3b_short", "N11_short", "N12", "N17_short", "N24", "N25"})


def _seats(facts: KitchenFacts) -> list[Fixture]:
    return [seat for seat in facts.with_role(Role.SEAT) if seat.run]


def _seat_widths(subject: DesignSubject) -> list[float]:
    seats = _seats(subject.facts)
    pairs = [(a.footprint, b.footprint) for a in seats for b in seats if a is not b and a.run == b.run]
    return [math.dist(a.center, b.center) for a, b in pairs]


def _sink_to_dishwasher(subject: DesignSubject) -> list[float]:
    """Metres between the nearest edges of dishwasher and sink."""
    washers, sinks = (
        [
            f.footprint.at(share * f.footprint.size[0], 0.0)
            for f in subject.facts.with_role(role)
            for share in (-0.5, 0.5)
        ]
        for role in (Role.DISHWASHER, Role.SINK)
    )
    gap = min((math.dist(edge, other) for edge in washers for other in sinks), default=None)
    return [] if gap is None else [gap]


def _hooded(subject: DesignSubject) -> list[float]:
    """Share of cooktops that are under a hood."""
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
    """Sinks and appliances without `CLEAR` floor before them."""
    worked = subject.facts.with_role(Role.SINK, *APPLIANCES)
    return [float(sum(not _has_floor(subject, f.name) for f in worked))] if worked else []


def _knee_room(subject: DesignSubject) -> list[float]:
    """Metres of the widest gap below a worktop."""
    gaps = [u.right - u.left for r in subject.facts.runs for u in r.units if u.kind == "gap" and u.has_worktop]
    return [max(gaps, default=0.0)]


def _lowest(heights: list[float]) -> list[float]:
    return [min(heights)] if heights else []


def _free_behind(facts: KitchenFacts, seat: Fixture) -> float:
    """Metres from the back edge of a seat to the nearest obstacle behind it."""
    run = facts.run(seat.run)
    assert run is not None
    # Seats look at the run's back: behind them is away from it.
    u, v = run.to_local(seat.footprint.center)
    start = -v + seat.footprint.size[1] / 2
    free = FAR
    for outline in obstacles(facts.replace(fixtures=())):
        step = 0.05
        for k in range(math.ceil(free / step - 1e-9)):
            a, b = run.at(u, -(start + k * step)), run.at(u, -(start + (k + 1) * step))
            if length_inside(outline, a, b) > 0:
                free = k * step
                break
    return free


def _above_worktop(subject: DesignSubject) -> list[float]:
    high = max((r.height for r in subject.facts.runs), default=0.92)
    return [f.bottom - high for f in subject.facts.with_role(Role.UPPER, Role.SHELF) if high < f.bottom < high + 0.7]


def _has_floor(subject: DesignSubject, name: str) -> bool:
    place = subject.parking.shut.get(name)
    if place is None:
        return False
    fixture = next(f for f in subject.facts.fixtures if f.name == name)
    _, before = fixture.footprint.to_local(place.position)
    start = before - BASE_RADIUS_M - GAP_M
    for wide, deep in (CLEAR, CLEAR[::-1]):
        middle, size = fixture.footprint.at(0.0, start + deep / 2 + CELL_M), (wide - CELL_M, deep - CELL_M)
        if not _is_taken(subject, Footprint(center=middle, size=size, yaw=fixture.footprint.yaw)):
            return True
    return False


def _is_taken(subject: DesignSubject, foot: Footprint) -> bool:
    floor = subject.floor
    w, d = foot.size
    for i in range(int(w / CELL_M) + 1):
        for k in range(int(d / CELL_M) + 1):
            if floor.holds(floor.solid, foot.at(-w / 2 + i * CELL_M, -k * CELL_M)):
                return True
    return False


def _reached_grips(subject: DesignSubject) -> list[float]:
    """Share of all handles, knobs and keys that a seated person reaches."""
    grips = [j.grip_point[2] for f in subject.facts.fixtures for j in f.joints if j.grip_point is not None]
    return [sum(REACH[0] <= z <= REACH[1] for z in grips) / len(grips)] if grips else []


def _reached_shelves(subject: DesignSubject) -> list[float]:
    """Share of shelves and drawers, by their area, whose floor a seated person reaches."""
    kept = (Role.CABINET, Role.DRAWERS, Role.UPPER, Role.SHELF, Role.PANTRY, Role.CORNER, Role.ISLAND, Role.SINK_BASE)
    found = [
        (v.footprint.size[0] * v.footprint.size[1], REACH[0] <= v.bottom <= REACH[1])
        for f in subject.facts.with_role(*kept)
        for v in f.regions
        if v.name not in ("main", "int")
    ]
    total = sum(area for area, _ in found)
    return [sum(area for area, good in found if good) / total] if total else []


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


def _plain(measure: Callable[[KitchenFacts], float | None]) -> Measure:
    """A measure of facts that is one number, or None where the rule does not apply."""
    return lambda subject: [] if (number := measure(subject.facts)) is None else [number]


# fmt: off
DESIGN: tuple[Rule, ...] = (
    Rule("N3a", "all three legs of the work triangle", 7.925, "m", True, _plain(rules.total)),
    Rule("N3b_short", "shortest leg of the work triangle", 1.219, "m", False,
         lambda s: [math.dist(*leg) for leg in rules.legs(s.facts)]),
    Rule("N3b_long", "longest leg of the work triangle", 2.743, "m", True,
         lambda s: [math.dist(*leg) for leg in rules.legs(s.facts)]),
    Rule("N3c", "part of a triangle leg across an island", 0.305, "m", True, _plain(rules.cut)),
    Rule("N4", "tall units between sink, cooktop and fridge", 0, "", True, _plain(rules.tall_between)),
    Rule("N5", "way from door to door through the work triangle", 0, "m", True, _plain(rules.crossed)),
    Rule("N8", "free space behind seats", 0.813, "m", False,
         lambda s: [_free_behind(s.facts, seat) for seat in _seats(s.facts)]),
    Rule("N9_width", "width of a seat at the worktop", 0.6, "m", False, _seat_widths),
    Rule("N9_knees", "knee space at the worktop", 0.381, "m", False,
         lambda s: [r.overhang for r in s.facts.runs if r.id in {seat.run for seat in _seats(s.facts)}]),
    Rule("N10", "cooktop and fridge away from the sink", 0, "", True, _plain(rules.between_sink)),
    Rule("N11_long", "worktop on the wider side of the sink", 0.61, "m", False, _plain(rules.longer_sink_side)),
    Rule("N11_short", "worktop on the narrower side of the sink", 0.457, "m", False, _plain(rules.shorter_sink_side)),
    Rule("N12", "worktop for preparing food beside the sink", 0.914, "m", False, _plain(rules.longer_sink_side)),
    Rule("N13", "distance from dishwasher to sink", 0.914, "m", True, _sink_to_dishwasher),
    Rule("N16", "worktop beside the refrigerator", 0.381, "m", False, _plain(rules.fridge_side)),
    Rule("N17_long", "worktop on the wider side of cooktops", 0.381, "m", False,
         lambda s: [max(sides) for _, sides in rules.landings(s.facts, *COOKTOPS)]),
    Rule("N17_short", "worktop on the narrower side of cooktops", 0.305, "m", False,
         lambda s: [min(sides) for _, sides in rules.landings(s.facts, *COOKTOPS)]),
    Rule("N17_behind", "worktop behind a cooktop in an island", 0.229, "m", False, _plain(rules.behind_cooktop)),
    Rule("N19", "cooktops under a hood", 1, "", False, _hooded),
    Rule("N21_high", "height of the highest microwave", 1.372, "m", True,
         lambda s: [f.bottom for f in s.facts.with_role(Role.MICROWAVE)]),
    Rule("N21_low", "height of the lowest microwave", 0.381, "m", False,
         lambda s: [f.bottom for f in s.facts.with_role(Role.MICROWAVE)]),
    Rule("N22", "worktop beside the microwave", 0.381, "m", False, _plain(rules.microwave_side)),
    Rule("N23", "worktop beside wall ovens", 0.381, "m", False, _plain(rules.oven_side)),
    Rule("N24", "spare worktop where landing areas are shared", 0, "m", False, _plain(rules.shared_landing)),
    Rule("N25", "total length of worktop", 4.013, "m", False, _plain(rules.total_frontage)),
    Rule("L1_least", "smallest gap between worktop and wall units", 0.381, "m", False, _above_worktop),
    # 18 inches are 0.457 m; wall units hang at whole centimetres.
    Rule("L1_most", "largest gap between worktop and wall units", 0.462, "m", True, _above_worktop),
    Rule("L3", "distance from cooktop to the end wall", 0.076, "m", False, _cooktop_to_wall),
    Rule("D1_height", "height of worktops, difference from 36 inches", 0.025, "m", True,
         lambda s: [abs(r.height - 0.914) for r in s.facts.runs]),
    Rule("D1_depth", "depth of worktops", 0.61, "m", False, lambda s: [r.depth_before for r in s.facts.runs]),
)
# fmt: on
ACCESS: tuple[Rule, ...] = (
    Rule(
        "A1",
        "width of aisles",
        1.015,
        "m",
        False,
        lambda s: [a.width for a in s.facts.aisles if a.kind is AisleKind.WORK],
    ),
    Rule("A2", "width of the aisle in a U", 1.525, "m", False, _aisles_in_a_u),
    Rule("A3", "sinks and appliances without clear floor in front", 0, "", True, _lacking_floor),
    Rule(
        "A4",
        "lowest worktop",
        0.865,
        "m",
        True,
        lambda s: _lowest([r.height for r in s.facts.runs] + [t.top for t in s.facts.with_role(Role.TABLE)]),
    ),
    Rule(
        "A5",
        "rim of the sink",
        0.865,
        "m",
        True,
        lambda s: _lowest([run.height for f in s.facts.with_role(Role.SINK) if (run := s.facts.run(f.run))]),
    ),
    Rule("A6", "knee space below a worktop", 0.762, "m", False, _knee_room),
    Rule("A7", "share of handles in reach", 0.5, "", False, _reached_grips),
    Rule("A8", "share of shelves in reach", 0.5, "", False, _reached_shelves),
    Rule("A10", "turning circle", 1.525, "m", False, lambda s: [2.0 * float((s.floor.clear * s.floor.room).max())]),
    Rule(
        "A11",
        "narrowest doorway",
        0.815,
        "m",
        False,
        lambda s: [w.clear_width for w in s.facts.openings if w.kind is not OpeningKind.WINDOW],
    ),
)


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
    return Finding(
        rule=rule.id,
        title=rule.title,
        number=number,
        limit=rule.limit,
        unit=rule.unit,
        most=rule.most,
        passed=passed,
        waived=waived and passed is False,
    )


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
