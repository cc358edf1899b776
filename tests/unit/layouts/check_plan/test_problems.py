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


CASES = {
    "a drawer beside a corner": (ROOM + CORNER, "room to open", "at the left end of right."),
    "a dishwasher beside a corner": (
        ROOM + CORNER.replace("[{drawers: [0.4, 0.9]}, sink, dishwasher", "[dishwasher, sink"),
        "between right_dishwasher and the inside corner",
        "right",
    ),
    "a door that swings into drawers": (
        ROOM + "openings:\n  door: {kind: door, wall: right, at: 1.2, width: 0.93, height: 2.04}\n" + ONE_ROW,
        "room to open",
        "for door.",
    ),
    "a door that is too narrow": (
        ROOM + "openings:\n  door: {kind: door, wall: right, at: 3.0, width: 0.8, height: 2.04}\n" + ONE_ROW,
        "a door or passage that leaves 0.813 m clear",
        "Write `width: 0.93` for door.",
    ),
    "wall units over a refrigerator": (
        ROOM + ONE_ROW + "      - doors: [0.35, 0.9]\n      - doors: [0.35, 0.9]\n",
        "apart from main_fridge",
        "Add `- gap: {over: main_fridge}` to the wall units of main.",
    ),
    "stools at a worktop that does not reach out": (
        ROOM + ONE_ROW + ISLAND + "seats:\n  - {run: island, count: 2}\n",
        "over those who sit there",
        "Write `overhang: 0.3` for island.",
    ),
    "an aisle to work in": (
        ROOM + ONE_ROW + ISLAND.replace("1.3", "1.0"),
        "an aisle of at least 1.067 m",
        "Write `aisle:",
    ),
    "a window over a cooker": (
        ROOM
        + "openings:\n  window: {kind: window, wall: back, over: main_range, width: 0.9, height: 0.45, sill: 1.05}\n"
        + ONE_ROW,
        "a place on a wall where nothing else is",
        "for window.",
    ),
    "a sink between what is tall and a cooker": (
        ROOM
        + ONE_ROW.replace("{drawers: [0.4, 0.9]}, sink, dishwasher", "pantry, sink, range, dishwasher, {drawers: 0.6}"),
        "of worktop beside main_sink",
        "change places.",
    ),
    "a kettle on a cooker": (
        ROOM + ONE_ROW + "worktop_items:\n  kettle: {on: main_range, at: 0.3}\n",
        "a unit with a worktop, on which kettle can stand",
        "Write `on: main_doors` for kettle.",
    ),
    "a hood over nothing": (
        ROOM + ONE_ROW.replace("upper:\n", "upper:\n      - hood\n"),
        "a cooker under",
        "Take out main_upper_hood.",
    ),
    "a toaster in a sink": (
        ROOM + ONE_ROW + "worktop_items:\n  toaster: {on: main_sink, at: 0.3}\n",
        "a unit with a worktop, on which toaster can stand",
        "Write `on: main_d",
    ),
}


def test_what_would_fail_is_told_with_a_mend_that_works(subtests: pytest.Subtests) -> None:
    for case in sorted(CASES):
        with subtests.test(case=case):
            text, expected, sentence = CASES[case]
            found = checked(text)
            told = [(t.fault.expected, t.fault.mend.sentence if t.fault.mend else "") for t in found.faults]
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
    assert not [t for t in checked(text).faults if "aisle" in t.fault.expected]
    project({"limits.yaml": "work_aisle_m: {value: 1.2}\n"})
    told = [t.fault.expected for t in checked(text).faults]
    assert any("an aisle of at least 1.2 m" in expected for expected in told), told
