"""What a kitchen would fail its checks by is told before it is built, with a mend after which nothing of it is left."""

from __future__ import annotations

import pytest

from casa_assets.layouts.check_plan.check import PlanCheck, check_plan
from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.problems import problems_of
from casa_assets.registry.kitchens import load_style
from casa_assets.registry.read import parse_document
from tests.support.program.projects import Project

pytestmark = pytest.mark.content("code", "layouts.check_plan", keep=0)

STYLE = "modern_1"
ROOM = """title: Studio
walls:
  back: {heading: right, length: 4.8}
  right: {heading: front, length: 4.6}
  front: {heading: left, length: 4.8, open: true}
  left: {heading: back, length: 4.6}
"""
ONE_ROW = """runs:
  main:
    on: back
    base: [{drawers: [0.4, 0.9]}, sink, dishwasher, {doors: [0.4, 0.9]}, range, {drawers: [0.4, 0.9]}, fridge]
    upper:
      - hood: {over: main_range}
"""
CORNER = """runs:
  main:
    on: back
    base: [fridge, {doors: [0.3, 0.9]}, range, {drawers: [0.4, 0.9]}]
    upper:
      - hood: {over: main_range}
  right:
    on: right
    length: 3.4
    base: [{drawers: [0.4, 0.9]}, sink, dishwasher, {doors: [0.3, 0.9]}]
corners:
  - {runs: [main, right], base: blind}
"""
ISLAND = """  island:
    faces: {run: main, aisle: 1.3}
    base: [{island: 1.8}]
"""


def checked(text: str) -> PlanCheck:
    return check_plan(text, "studio.yaml", load_style(STYLE)[0])


DOOR = "openings:\n  door: {kind: door, wall: right, at: 1.2, width: 0.93, height: 2.04}\n"
NARROW = DOOR.replace("0.93", "0.8").replace("1.2", "3.0")
PANTRY = ("{drawers: [0.4, 0.9]}, sink, dishwasher", "pantry, sink, range, dishwasher, {drawers: 0.6}")
# Texts of plans, what is expected in the place of a fault, and a part of the sentence of its mend.
CASES = [
    (ROOM + CORNER, "room to open", "at the left end of right."),
    (ROOM + DOOR + ONE_ROW, "room to open", "for door."),
    (ROOM + NARROW + ONE_ROW, "a door or passage that leaves 0.813 m clear", "Write `width: 0.93` for door."),
    (ROOM + ONE_ROW + ISLAND.replace("1.3", "1.0"), "an aisle of at least 1.067 m", "Write `aisle:"),
    (ROOM + ONE_ROW.replace(*PANTRY), "of worktop beside main_sink", "change places."),
    (
        ROOM + ONE_ROW + "worktop_items:\n  kettle: {on: main_range, at: 0.3}\n",
        "a unit with a worktop, on which kettle can stand",
        "Write `on: main_doors` for kettle.",
    ),
]


def test_what_would_fail_is_told_with_a_mend_that_works(subtests: pytest.Subtests) -> None:
    for text, expected, sentence in CASES:
        with subtests.test(expected=expected):
            found = checked(text)
            told = [(t.expected, t.mend.sentence if t.mend else "") for t in found.faults]
            assert any(expected in one and sentence in said for one, said in told), told
            assert found.mended, told
            assert found.kitchen is not None
            raw = parse_document(found.text, "studio.yaml").value
            assert problems_of(Draft.of(raw, "studio", load_style(STYLE)[0])) == (0, [])
            assert checked(found.text).fits
            # Nothing that a kitchen needs is given up.
            before = text.split("base: [", 1)[1].split("]", 1)[0]
            kinds = {str(unit.kind) for unit in found.kitchen.plan.units.values()}
            assert {kind for kind in ("sink", "range", "fridge", "dishwasher") if kind in before} <= kinds


def test_a_ceiling_is_over_the_cornice_and_one_that_is_too_high_is_as_high_as_it_can_be() -> None:
    row = ONE_ROW + "      - doors: [0.35, 0.9]\n"
    for height, mended in ((2.3, "height: 2.34"), (3.9, "height: 3.4")):
        text = ROOM.replace("walls:", f"height: {height}\nwalls:") + row
        found = check_plan(text, "studio.yaml", load_style("traditional_1")[0])
        assert found.mended
        assert mended in found.text


def test_limits_of_a_project_hold_and_the_others_stay(project: Project) -> None:
    text = ROOM + ONE_ROW + ISLAND.replace("1.3", "1.15")
    assert not [t for t in checked(text).faults if "aisle" in t.expected]
    project({"limits.yaml": "work_aisle_m: {value: 1.2}\n"})
    told = [t.expected for t in checked(text).faults]
    assert any("an aisle of at least 1.2 m" in expected for expected in told), told
