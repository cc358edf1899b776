"""Checks of kitchens' facts: each code is silent on what is right, and alone in speaking where one thing is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from casa_assets.checks.design.grade import grade
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.issue import Status
from casa_assets.model.kitchen.floor import AisleKind, Fixture, Footprint, KitchenFacts, Role, SweptArea
from tests.support.asset.examples import between, check_examples
from tests.support.kitchen import reference_kitchen as made

Build = Callable[[], KitchenFacts]
ALONE = Footprint(center=(0.3, -2.4), size=(0.5, 0.3), yaw=math.pi / 2)


def swung(reach: float) -> KitchenFacts:
    """A door's leaf that comes so near the refrigerator's front, which ends at y = -0.77: 0 touches it."""
    outline = ((0.0, -2.0), (0.9, -2.0), (0.9, -0.77 + reach), (0.0, -0.77 + reach))
    leaf = SweptArea(outline=outline, open_outline=outline, bottom=0.0, top=0.05, sweeps_front=False)
    return made.kitchen().replace(openings=(made.WINDOW, made.DOOR.replace(swept_area=leaf)))


def crossing(reach: float) -> KitchenFacts:
    facts = made.kitchen()
    washer = next(f for f in facts.fixtures if f.name == "dishwasher")
    (joint,) = washer.joints
    assert joint.swept_area is not None
    # That of the range ends at y = -0.67 - 0.6.
    swept = ((2.6, -1.9), (4.4, -1.9), (4.4, -1.27 + reach), (2.6, -1.27 + reach))
    moved = joint.replace(swept_area=joint.swept_area.replace(outline=swept))
    return made.changed(facts, "dishwasher", washer.replace(joints=(moved,)))


def hung(name: str, low: float) -> KitchenFacts:
    """The hood, or a cabinet in its place, so high over the range, whose top is at 0.915 m."""
    facts = made.kitchen()
    hood = next(f for f in facts.fixtures if f.name == "hood")
    if name == "hood":
        return made.changed(facts, "hood", hood.replace(bottom=0.915 + low))
    return made.changed(facts, "hood", made.upper(2.4, 3.2, "over", low=0.915 + low).replace(joints=()))


def glazed(length: float) -> KitchenFacts:
    way = made.WINDOW.replace(wall="back", start=(3.208 - length, 0.0), end=(4.2, 0.0))
    return made.kitchen().replace(openings=(way, made.DOOR))


def tasteless(count: int) -> KitchenFacts:
    facts = made.kitchen()
    oven = next(f for f in facts.fixtures if f.name == "microwave")
    rows = tuple(r.replace(height=0.96, depth_before=0.6) for r in facts.runs[:2])
    if count > 0:
        facts = made.changed(facts.replace(runs=rows), "hood", None)
    if count > 1:
        facts = made.changed(facts, "microwave", oven.replace(bottom=1.5, top=1.79))
        facts = facts.replace(runs=tuple(r.replace(units=r.units[:4]) for r in facts.runs))
    if count > 2:
        facts = made.with_more(facts, made.upper(0.0, 0.4, "low_one", low=1.1).replace(joints=()))
        facts = made.with_unit(facts, "main", "range", 0.96, 1.8)
    return facts


def shelf(*around: Fixture) -> KitchenFacts:
    alone = Fixture(name="alone", role=Role.SHELF, category="open_shelf", footprint=ALONE, bottom=0.0, top=1.0)
    return made.with_more(made.kitchen(), alone, *around)


def crate(long: float) -> Fixture:
    return made.thing("crate", Role.ON_FLOOR, (0.9, -2.4), (0.5, long), 0.0, 0.3)


def flapped(out: float) -> KitchenFacts:
    """The shelf has a flap across the room, which comes out so far."""
    joint = made.flap(ALONE, "flap_joint", out, 0.1, 0.5)
    assert joint.swept_area is not None
    outline = made.box(ALONE, -1.6, 1.6, 0.0, out)
    facts = shelf()
    alone = next(f for f in facts.fixtures if f.name == "alone")
    moved = joint.replace(swept_area=joint.swept_area.replace(open_outline=outline, outline=outline))
    return made.changed(facts, "alone", alone.replace(joints=(moved,)))


def crowded(low: float) -> KitchenFacts:
    tops = [f for f in made.kitchen().fixtures if f.role is Role.WORKTOP]
    row: dict[str, Any] = {"role": Role.THING, "category": "board", "bottom": low, "top": low + 0.02}
    boards = [Fixture(name=f"board_{k}", footprint=top.footprint, **row) for k, top in enumerate(tops)]
    return made.with_more(made.kitchen(), *boards)


COFFEE = ["coffee_press_button", "coffee_setup_mug", "coffee_serve_mug"]
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "NKB001": between(
        lambda n: made.kitchen().replace(openings=(made.WINDOW, made.DOOR.replace(clear_width=n))), 0.814, 0.812
    ),
    "NKB002": between(swung, -0.01, 0.02),
    "NKB003": between(crossing, -0.01, 0.02),
    "NKB004": between(lambda n: made.with_aisle(made.kitchen(), AisleKind.WORK, n), 1.07, 1.06),
    "NKB005": between(lambda n: made.with_aisle(made.kitchen().replace(compact=True), AisleKind.WORK, n), 0.92, 0.91),
    "NKB006": between(lambda n: made.with_aisle(made.kitchen(), AisleKind.WALK, n), 0.92, 0.91),
    "NKB007": between(lambda gap: made.with_unit(made.kitchen(), "right", "dishwasher", 0.65 + gap, 1.95), 0.54, 0.52),
    "NKB008": (lambda: hung("hood", 0.62), lambda: hung("hood", 0.6)),
    "NKB009": (lambda: hung("cabinet", 0.77), lambda: hung("cabinet", 0.75)),
    "NKB010": between(glazed, 0.0, 0.1),
    "NKB011": between(lambda gap: made.with_unit(made.kitchen(), "main", "range", 2.45, 4.35 - gap), 0.39, 0.37),
    "NKB012": between(tasteless, 1, 3),
    "NAV001": (lambda: shelf(crate(0.2)), lambda: shelf(crate(1.6))),
    "NAV002": between(flapped, 0.4, 3.6),
    "NAV003": (
        made.kitchen,
        lambda: made.with_more(made.kitchen(), made.thing("chest", Role.ON_FLOOR, (0.5, -3.3), (0.9, 1.3), 0.0, 0.5)),
    ),
    "TSK001": (made.kitchen, lambda: made.changed(made.kitchen(), "coffee_machine", None)),
    "TSK002": between(crowded, 2.0, 0.921),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str) -> None:
    check_examples(code, *(made.judged(make()) for make in EXAMPLES[code]), parted=True)


def test_all_tasks_are_only_asked_of_plans_that_say_so() -> None:
    facts = made.changed(made.kitchen(), "coffee_machine", None)
    assert [issue.code for issue in made.judged(facts).issues] == ["TSK001"] * 3
    (row,) = (r for r in made.judged(facts.replace(all_tasks=False)).results if r.code == "TSK001")
    assert row.status is Status.NOT_APPLICABLE
    assert [t.task for t in DesignSubject(facts.replace(all_tasks=False)).tasks if t.wants] == COFFEE


def test_compact_waives_what_small_kitchens_cannot_keep() -> None:
    facts = made.kitchen()
    short = facts.replace(runs=tuple(r.replace(units=r.units[:4]) for r in facts.runs))
    plain, compact = (grade(DesignSubject(f)) for f in (short, short.replace(compact=True)))
    missed = {f.rule for f in plain.design if f.passed is False}
    assert "N25" in missed
    assert not {f.rule for f in plain.design if f.waived}
    assert "N25" in {f.rule for f in compact.design if f.waived}
    assert compact.score > plain.score


def test_grade_has_every_rule_once_with_its_number() -> None:
    found = grade(DesignSubject(made.kitchen()))
    rules = [f.rule for f in (*found.design, *found.access)]
    assert len(rules) == len(set(rules)) == 40
    numbers = {f.rule: f.number for f in (*found.design, *found.access)}
    assert numbers["N11_long"] == pytest.approx(1.35)  # from the sink to the inside corner
    assert numbers["N13"] == pytest.approx(0.05, abs=0.01)
    assert numbers["A4"] == pytest.approx(0.92)
