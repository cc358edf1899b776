"""Grade of a kitchen by advisory rules: seats, heights, standard sizes, worktop and wheelchair access.

Ref: NKBA Kitchen Planning Guidelines with Access Standards, 2nd edition (numbers N...); Louisiana State University
AgCenter, kitchen guidelines (L...); trade sizes (D...); 2010 ADA Standards (A...).
"""

from __future__ import annotations

import math
from collections.abc import Callable
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


def behind_seats(subject: DesignSubject) -> float | None:
    """Metres free behind the seat that has least, from its back; open sides of the room do not bound it."""
    found = [_free_behind(subject.facts, s) for s in subject.facts.with_role(Role.SEAT) if s.run]
    return min(found, default=None)


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


def seat_width(subject: DesignSubject) -> float | None:
    """Metres from seat to seat, the least."""
    seats = [s for s in subject.facts.with_role(Role.SEAT) if s.run]
    pairs = [(a.footprint, b.footprint) for a in seats for b in seats if a is not b and a.run == b.run]
    return min((math.dist(a.center, b.center) for a, b in pairs), default=None)


def knee_depth(subject: DesignSubject) -> float | None:
    """Metres that the worktop reaches out over those who sit at it, the least."""
    runs = {s.run for s in subject.facts.with_role(Role.SEAT) if s.run}
    return min((r.overhang for r in subject.facts.runs if r.id in runs), default=None)


def sink_to_dishwasher(subject: DesignSubject) -> float | None:
    """Metres between the nearest edges of dishwasher and sink."""
    facts = subject.facts
    washers, sinks = (
        [f.footprint.at(share * f.footprint.size[0], 0.0) for f in facts.with_role(role) for share in (-0.5, 0.5)]
        for role in (Role.DISHWASHER, Role.SINK)
    )
    return min((math.dist(edge, other) for edge in washers for other in sinks), default=None)


def hoods(subject: DesignSubject) -> float | None:
    """Cooktops under a hood, over all cooktops."""
    cooktops = subject.facts.with_role(*COOKTOPS)
    covered = [c for c in cooktops if any(f.role is Role.HOOD for f in over(subject.facts, c))]
    return len(covered) / len(cooktops) if cooktops else None


def microwave_high(subject: DesignSubject) -> float | None:
    """Height of the foot of the highest microwave, metres."""
    return max((f.bottom for f in subject.facts.with_role(Role.MICROWAVE)), default=None)


def microwave_low(subject: DesignSubject) -> float | None:
    """Height of the foot of the lowest microwave, metres."""
    return min((f.bottom for f in subject.facts.with_role(Role.MICROWAVE)), default=None)


def _above_worktop(subject: DesignSubject) -> list[float]:
    high = max((r.height for r in subject.facts.runs), default=0.92)
    return [f.bottom - high for f in subject.facts.with_role(Role.UPPER, Role.SHELF) if high < f.bottom < high + 0.7]


def least_over_worktop(subject: DesignSubject) -> float | None:
    """Metres between worktop and the lowest wall unit."""
    return min(_above_worktop(subject), default=None)


def most_over_worktop(subject: DesignSubject) -> float | None:
    """Metres between worktop and the highest foot of a wall unit that begins over it."""
    return max(_above_worktop(subject), default=None)


def cooktop_to_wall(subject: DesignSubject) -> float | None:
    """Metres between a cooktop and the wall at the end of its run, the least."""
    found = []
    for run in subject.facts.runs:
        for unit in (u for u in run.units if u.kind in ("range", "hob")):
            found += [unit.left] if run.left_end is RunEnd.WALL else []
            found += [run.length - unit.right] if run.right_end is RunEnd.WALL else []
    return min(found, default=None)


def height_off(subject: DesignSubject) -> float | None:
    """Metres by which worktops are off 36 inches, the most."""
    return max((abs(r.height - 0.914) for r in subject.facts.runs), default=None)


def least_depth(subject: DesignSubject) -> float | None:
    """Metres of the shallowest worktop."""
    return min((r.depth_before for r in subject.facts.runs), default=None)


# Wheelchair access ----------------------------------------------------------------------------------------------------
# Ref: 2010 ADA Standards 804, 305, 306, 308, 309; ICC A117.1 1003.12.

CLEAR = (0.762, 1.219)  # metres of free floor at each place of work, either way round
REACH = (0.381, 1.219)  # heights that a seated person reaches, metres


def pass_aisle(subject: DesignSubject) -> float | None:
    """Metres between fronts that face each other, the least; None if no fronts do."""
    return min((a.width for a in subject.facts.aisles if a.kind is AisleKind.WORK), default=None)


def u_aisle(subject: DesignSubject) -> float | None:
    """Least metres between fronts in the middle of three joined runs, or None if no three runs join."""
    facts = subject.facts
    ends = {r.id: r.next_run for r in facts.runs}
    trios = [(a, n) for a, b in ends.items() if b is not None and (n := ends.get(b)) is not None]
    found = [x.width for x in facts.aisles if any({x.first, x.second} == set(trio) for trio in trios)]
    return min(found, default=None)


def lacking_floor(subject: DesignSubject) -> float | None:
    """Sinks and appliances without that much free floor before them."""
    worked = subject.facts.with_role(Role.SINK, *APPLIANCES)
    return float(sum(not _has_floor(subject, f.name) for f in worked)) if worked else None


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


def lowest_worktop(subject: DesignSubject) -> float | None:
    """Height of the lowest worktop or table, metres."""
    heights = [r.height for r in subject.facts.runs] + [t.top for t in subject.facts.with_role(Role.TABLE)]
    return min(heights, default=None)


def sink_rim(subject: DesignSubject) -> float | None:
    """Height of the lowest sink's rim, metres."""
    heights = [r.height for f in subject.facts.with_role(Role.SINK) if (r := subject.facts.run(f.run)) is not None]
    return min(heights, default=None)


def knee_room(subject: DesignSubject) -> float | None:
    """Metres of the widest gap below a worktop."""
    gaps = [u.right - u.left for r in subject.facts.runs for u in r.units if u.kind == "gap" and u.has_worktop]
    return max(gaps, default=0.0)


def reached_grips(subject: DesignSubject) -> float | None:
    """Share of all handles, knobs and keys that a seated person reaches."""
    grips = [j.grip_point[2] for f in subject.facts.fixtures for j in f.joints if j.grip_point is not None]
    return sum(REACH[0] <= z <= REACH[1] for z in grips) / len(grips) if grips else None


def reached_shelves(subject: DesignSubject) -> float | None:
    """Share of shelves and drawers, by their area, whose floor a seated person reaches."""
    kept = (Role.CABINET, Role.DRAWERS, Role.UPPER, Role.SHELF, Role.PANTRY, Role.CORNER, Role.ISLAND, Role.SINK_BASE)
    found = [
        (v.footprint.size[0] * v.footprint.size[1], REACH[0] <= v.bottom <= REACH[1])
        for f in subject.facts.with_role(*kept)
        for v in f.regions
        if v.name not in ("main", "int")
    ]
    total = sum(area for area, _ in found)
    return sum(area for area, good in found if good) / total if total else None


def turning_circle(subject: DesignSubject) -> float | None:
    """Metres across the widest free circle on the floor."""
    floor = subject.floor
    return 2.0 * float((floor.clear * floor.room).max())


def clear_doorway(subject: DesignSubject) -> float | None:
    """Metres of the narrowest doorway."""
    return min((w.clear_width for w in subject.facts.openings if w.kind is not OpeningKind.WINDOW), default=None)


# Grade ----------------------------------------------------------------------------------------------------------------

Measure = Callable[[DesignSubject], float | None]


@dataclass(frozen=True)
class Rule:
    """An advisory rule; `most`: True if the number may be at most the limit. `measure`: None if it does not apply."""

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
    """All findings; scores are 0..100, the share of the rules that apply and are kept."""

    score: float
    access_score: float
    design: tuple[Finding, ...]
    access: tuple[Finding, ...]


def _plain(measure: Callable[[KitchenFacts], float | None]) -> Measure:
    return lambda subject: measure(subject.facts)


DESIGN: tuple[Rule, ...] = (
    Rule("N3a", "all three legs of the work triangle", 7.925, "m", True, _plain(rules.total)),
    Rule("N3b_short", "shortest leg of the work triangle", 1.219, "m", False, _plain(rules.shortest)),
    Rule("N3b_long", "longest leg of the work triangle", 2.743, "m", True, _plain(rules.longest)),
    Rule("N3c", "part of a triangle leg across an island", 0.305, "m", True, _plain(rules.cut)),
    Rule("N4", "tall units between sink, cooktop and fridge", 0, "", True, _plain(rules.tall_between)),
    Rule("N5", "way from door to door through the work triangle", 0, "m", True, _plain(rules.crossed)),
    Rule("N8", "free space behind seats", 0.813, "m", False, behind_seats),
    Rule("N9_width", "width of a seat at the worktop", 0.6, "m", False, seat_width),
    Rule("N9_knees", "knee space at the worktop", 0.381, "m", False, knee_depth),
    Rule("N10", "cooktop and fridge away from the sink", 0, "", True, _plain(rules.between_sink)),
    Rule("N11_long", "worktop on the wider side of the sink", 0.61, "m", False, _plain(rules.longer_sink_side)),
    Rule("N11_short", "worktop on the narrower side of the sink", 0.457, "m", False, _plain(rules.shorter_sink_side)),
    Rule("N12", "worktop for preparing food beside the sink", 0.914, "m", False, _plain(rules.longer_sink_side)),
    Rule("N13", "distance from dishwasher to sink", 0.914, "m", True, sink_to_dishwasher),
    Rule("N16", "worktop beside the refrigerator", 0.381, "m", False, _plain(rules.fridge_side)),
    Rule("N17_long", "worktop on the wider side of cooktops", 0.381, "m", False, _plain(rules.longer_cook_side)),
    Rule("N17_short", "worktop on the narrower side of cooktops", 0.305, "m", False, _plain(rules.shorter_cook_side)),
    Rule("N17_behind", "worktop behind a cooktop in an island", 0.229, "m", False, _plain(rules.behind_cooktop)),
    Rule("N19", "cooktops under a hood", 1, "", False, hoods),
    Rule("N21_high", "height of the highest microwave", 1.372, "m", True, microwave_high),
    Rule("N21_low", "height of the lowest microwave", 0.381, "m", False, microwave_low),
    Rule("N22", "worktop beside the microwave", 0.381, "m", False, _plain(rules.microwave_side)),
    Rule("N23", "worktop beside wall ovens", 0.381, "m", False, _plain(rules.oven_side)),
    Rule("N24", "spare worktop where landing areas are shared", 0, "m", False, _plain(rules.shared_landing)),
    Rule("N25", "total length of worktop", 4.013, "m", False, _plain(rules.total_frontage)),
    Rule("L1_least", "smallest gap between worktop and wall units", 0.381, "m", False, least_over_worktop),
    # 18 inches are 0.457 m; wall units hang at whole centimetres.
    Rule("L1_most", "largest gap between worktop and wall units", 0.462, "m", True, most_over_worktop),
    Rule("L3", "distance from cooktop to the end wall", 0.076, "m", False, cooktop_to_wall),
    Rule("D1_height", "height of worktops, difference from 36 inches", 0.025, "m", True, height_off),
    Rule("D1_depth", "depth of worktops", 0.61, "m", False, least_depth),
)
ACCESS: tuple[Rule, ...] = (
    Rule("A1", "width of aisles", 1.015, "m", False, pass_aisle),
    Rule("A2", "width of the aisle in a U", 1.525, "m", False, u_aisle),
    Rule("A3", "sinks and appliances without clear floor in front", 0, "", True, lacking_floor),
    Rule("A4", "lowest worktop", 0.865, "m", True, lowest_worktop),
    Rule("A5", "rim of the sink", 0.865, "m", True, sink_rim),
    Rule("A6", "knee space below a worktop", 0.762, "m", False, knee_room),
    Rule("A7", "share of handles in reach", 0.5, "", False, reached_grips),
    Rule("A8", "share of shelves in reach", 0.5, "", False, reached_shelves),
    Rule("A10", "turning circle", 1.525, "m", False, turning_circle),
    Rule("A11", "narrowest doorway", 0.815, "m", False, clear_doorway),
)
# What small kitchens cannot keep; not counted where a plan says that it is compact.
COMPACT = frozenset({"N3b_short", "N11_short", "N12", "N17_short", "N24", "N25"})


@lru_cache(maxsize=1)
def grade(subject: DesignSubject) -> Grade:
    """Every advisory rule and the access profile, measured once."""
    design = tuple(_find(rule, subject, subject.facts.compact and rule.id in COMPACT) for rule in DESIGN)
    profile = tuple(_find(rule, subject, False) for rule in ACCESS)
    return Grade(score=_score(design), access_score=_score(profile), design=design, access=profile)


def _find(rule: Rule, subject: DesignSubject, waived: bool) -> Finding:
    number = rule.measure(subject)
    number = None if number is None else decimals(number, 4)
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
