"""The grade of a kitchen: every advisory rule of design with what was measured, and a score.

Ref: NKBA Kitchen Planning Guidelines with Access Standards, 2nd edition (numbers N...); Louisiana State University
AgCenter, kitchen guidelines (L...); trade sizes (D...); 2010 ADA Standards (A...).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.design.rules import appliances, sizes
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.core.numeric import decimals
from casa_assets.model.kitchen.floor import KitchenFacts
from casa_assets.model.record import Record

Measure = Callable[[DesignSubject], float | None]


@dataclass(frozen=True)
class Rule:
    """An advisory rule.

    Attributes:
        id: of the guideline, with a letter if it has several numbers. title: what is measured.
        limit, unit: of the number. most: True if the number may be at most the limit, False if at least.
        measure: returns the number, None if the rule does not apply.
    """

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
    return lambda subject: measure(subject.facts)


DESIGN: tuple[Rule, ...] = (
    Rule("N3a", "all three legs of the work triangle", 7.925, "m", True, _plain(appliances.total)),
    Rule("N3b_short", "shortest leg of the work triangle", 1.219, "m", False, _plain(appliances.shortest)),
    Rule("N3b_long", "longest leg of the work triangle", 2.743, "m", True, _plain(appliances.longest)),
    Rule("N3c", "part of a triangle leg across an island", 0.305, "m", True, _plain(appliances.cut)),
    Rule("N4", "tall units between sink, cooktop and fridge", 0, "", True, _plain(appliances.tall_between)),
    Rule("N5", "way from door to door through the work triangle", 0, "m", True, _plain(appliances.crossed)),
    Rule("N8", "free space behind seats", 0.813, "m", False, sizes.behind_seats),
    Rule("N9_width", "width of a seat at the worktop", 0.6, "m", False, sizes.seat_width),
    Rule("N9_knees", "knee space at the worktop", 0.381, "m", False, sizes.knee_depth),
    Rule("N10", "cooktop and fridge away from the sink", 0, "", True, _plain(appliances.between_sink)),
    Rule("N11_long", "worktop on the wider side of the sink", 0.61, "m", False, _plain(appliances.longer_sink_side)),
    Rule(
        "N11_short", "worktop on the narrower side of the sink", 0.457, "m", False, _plain(appliances.shorter_sink_side)
    ),
    Rule("N12", "worktop for preparing food beside the sink", 0.914, "m", False, _plain(appliances.longer_sink_side)),
    Rule("N13", "distance from dishwasher to sink", 0.914, "m", True, sizes.sink_to_dishwasher),
    Rule("N16", "worktop beside the refrigerator", 0.381, "m", False, _plain(appliances.fridge_side)),
    Rule("N17_long", "worktop on the wider side of cooktops", 0.381, "m", False, _plain(appliances.longer_cook_side)),
    Rule(
        "N17_short", "worktop on the narrower side of cooktops", 0.305, "m", False, _plain(appliances.shorter_cook_side)
    ),
    Rule("N17_behind", "worktop behind a cooktop in an island", 0.229, "m", False, _plain(appliances.behind_cooktop)),
    Rule("N19", "cooktops under a hood", 1, "", False, sizes.hoods),
    Rule("N21_high", "height of the highest microwave", 1.372, "m", True, sizes.microwave_high),
    Rule("N21_low", "height of the lowest microwave", 0.381, "m", False, sizes.microwave_low),
    Rule("N22", "worktop beside the microwave", 0.381, "m", False, _plain(appliances.microwave_side)),
    Rule("N23", "worktop beside wall ovens", 0.381, "m", False, _plain(appliances.oven_side)),
    Rule("N24", "spare worktop where landing areas are shared", 0, "m", False, _plain(appliances.shared_landing)),
    Rule("N25", "total length of worktop", 4.013, "m", False, _plain(appliances.total_frontage)),
    Rule("L1_least", "smallest gap between worktop and wall units", 0.381, "m", False, sizes.least_over_worktop),
    # 18 inches are 0.457 m; wall units hang at whole centimetres.
    Rule("L1_most", "largest gap between worktop and wall units", 0.462, "m", True, sizes.most_over_worktop),
    Rule("L3", "distance from cooktop to the end wall", 0.076, "m", False, sizes.cooktop_to_wall),
    Rule("D1_height", "height of worktops, difference from 36 inches", 0.025, "m", True, sizes.height_off),
    Rule("D1_depth", "depth of worktops", 0.61, "m", False, sizes.least_depth),
)
ACCESS: tuple[Rule, ...] = (
    Rule("A1", "width of aisles", 1.015, "m", False, sizes.pass_aisle),
    Rule("A2", "width of the aisle in a U", 1.525, "m", False, sizes.u_aisle),
    Rule("A3", "sinks and appliances without clear floor in front", 0, "", True, sizes.lacking_floor),
    Rule("A4", "lowest worktop", 0.865, "m", True, sizes.lowest_worktop),
    Rule("A5", "rim of the sink", 0.865, "m", True, sizes.sink_rim),
    Rule("A6", "knee space below a worktop", 0.762, "m", False, sizes.knee_room),
    Rule("A7", "share of handles in reach", 0.5, "", False, sizes.reached_grips),
    Rule("A8", "share of shelves in reach", 0.5, "", False, sizes.reached_shelves),
    Rule("A10", "turning circle", 1.525, "m", False, sizes.turning_circle),
    Rule("A11", "narrowest doorway", 0.815, "m", False, sizes.clear_doorway),
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
