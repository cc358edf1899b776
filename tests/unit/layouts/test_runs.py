"""How runs share walls: widths, corners, peninsulas; and what the author of a plan is told where they do not fit."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest

from casa_assets.errors import RegistryError
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import CornerPart
from casa_assets.layouts.plan.standard_sizes import WidthRange, share_widths
from casa_assets.layouts.run.resolve import params_of
from tests.support.kitchen.plan_geometry import floor_row, kitchen_of

PLAN = """\
title: Tiny
parameters:
  width: [3.6, 3.0, 5.0]
walls:
  back: {heading: right, length: width}
  right: {heading: front, length: 3.0}
  front: {heading: left, open: true}
  left: {heading: back}
runs:
  main:
    on: back
    base:
      - drawers: [0.4, 0.8]
      - sink
      - doors: [0.4, 0.8]
  side:
    on: right
    length: 1.9
    base:
      - doors: 0.45
      - drawers: [0.4, 0.9]
corners:
  - {runs: [main, side]}
"""


def test_widths_share_a_room() -> None:
    narrow = [WidthRange(0.4, 0.5)] * 2
    three = [WidthRange(0.4, 0.8), WidthRange(0.6, 0.6), WidthRange(0.3, 0.7)]
    assert share_widths(three, 1.7) == pytest.approx([0.6, 0.6, 0.5])
    assert share_widths(narrow, 3.0) == pytest.approx([0.5, 0.5]), "what nothing wants is left"
    assert share_widths(narrow, 0.79) is None, "not even the least fits"
    assert share_widths([], 1.0) == []


@pytest.mark.parametrize("hob", range(5))
@pytest.mark.parametrize("length", [3.6, 4.5, 5.4, 8.6])
def test_no_slab_is_longer_than_is_sold_and_all_can_be_made(hob: int, length: float, tmp_path: Path) -> None:
    """Worktops of one run between two walls, by the length of the wall and where the hob stands."""
    units = [f"      - doors: [0.4, {1.2 * length / 4.5:.2f}]\n"] * 4
    units.insert(hob, "      - hob\n")
    head, walls = (
        PLAN.replace("length: width", f"length: {length}").split("runs:\n")[0],
        "runs:\n  main:\n    on: back\n",
    )
    kitchen = kitchen_of(f"{head}{walls}    base:\n{''.join(units)}", tmp_path)
    made = [(i.spot.u, params_of(i.choice).model_dump()["width"]) for i in kitchen.items if i.role == "counter"]
    tops = sorted((at - width / 2, at + width / 2) for at, width in made)
    assert all(high - low <= 4.0 for low, high in tops)
    assert tops[0][0] == pytest.approx(0.0)
    assert tops[-1][1] == pytest.approx(length)
    for one, other in itertools.pairwise(tops):
        assert one[1] == pytest.approx(other[0], abs=1e-4)


def test_units_meet_without_gaps_in_a_blind_cabinet_and_a_strip(tmp_path: Path) -> None:
    kitchen = kitchen_of(PLAN, tmp_path)
    for line in kitchen.lines.values():
        row = floor_row(kitchen, line)
        for one, other in itertools.pairwise(row):
            assert one.right == pytest.approx(other.left, abs=1e-4)
    blind = kitchen.slot("main_right_corner")
    assert blind.kind is CornerPart.BLIND
    assert blind.right == kitchen.lines["main"].length
    assert blind.width == pytest.approx(standard_sizes.CORNER_CLEARANCE + standard_sizes.CORNER_DOOR)
    strip = kitchen.slot("side_left_filler")
    assert (strip.left, strip.right) == (standard_sizes.BASE_DEPTH, standard_sizes.CORNER_CLEARANCE)
    assert kitchen.slot("side_doors").hinge == "right"


BAR = "  bar: {joins: {run: side, end: right}, length: 1.9, overhang: 0.3, base: [{drawers: [0.4, 0.9]}, panel]}\n"
PENINSULA = PLAN.replace("      - drawers: [0.4, 0.9]\n", "").replace("- doors: 0.45", "- doors: [0.4, 0.45]")
PENINSULA = PENINSULA.replace("    length: 1.9\n", "    length: 1.85\n")
PENINSULA = PENINSULA.replace("corners:\n", f"{BAR}corners:\n  - {{runs: [side, bar], owner: bar}}\n")


@pytest.mark.parametrize(("owner", "begin"), [("bar", 0.0), ("side", standard_sizes.WORKTOP_DEPTH)])
def test_tops_of_a_peninsula_butt_over_the_cabinet_in_the_corner(owner: str, begin: float, tmp_path: Path) -> None:
    """The worktop over the corner is that of the run whose cabinet fills it; the other begins at its edge."""
    text = PENINSULA.replace("owner: bar}", f"owner: {owner}}}")
    if owner == "side":
        text = text.replace("length: 1.85\n", f"length: {1.85 + standard_sizes.CORNER_DOOR}\n")
    kitchen = kitchen_of(text, tmp_path)
    bar, side = kitchen.lines["bar"], kitchen.lines["side"]
    (top,) = [w for w in kitchen.items if w.run == "bar" and w.role == "counter"]
    assert top.spot.u - top.choice.params["width"] / 2 == pytest.approx(begin)
    along = [w for w in kitchen.items if w.run == "side" and w.name.startswith("side_top")]
    end = max(w.spot.u + w.choice.params["width"] / 2 for w in along)
    behind = bar.run.overhang + standard_sizes.END_PANEL
    assert end == pytest.approx(side.length + (behind if begin else -standard_sizes.WORKTOP_DEPTH))
    assert top.spot.v == pytest.approx(-bar.run.overhang - standard_sizes.END_PANEL)
    assert top.choice.params["depth"] == pytest.approx(standard_sizes.WORKTOP_DEPTH + 0.32)


DOOR = "openings:\n  door: {kind: door, wall: left, at: 0.2, width: 0.9, height: 2.04}\n"
LEFT, RIGHT = "left: {heading: back}", "right: {heading: front, length: 3.0}"
SIDE = "    length: 1.9\n"
# A wrong plan, what is on the line that is told, where in the plan that is, and what is said.
MISFITS = {
    "unknown key": (PLAN.replace(SIDE, "    lenght: 1.9\n"), "lenght", ".*", "got .*lenght"),
    "two units of a name": (PLAN.replace("0.45", "{width: 0.45, id: main_doors}"), "", ".*", "main_doors"),
    "dangling wall": (PLAN.replace("on: right", "on: rihgt"), "rihgt", "runs.side.on", "got .*rihgt"),
    "dangling parameter": (PLAN.replace(SIDE, "    length: wdith\n"), "wdith", ".*", "expected .*width.*, got"),
    "dangling corner": (PLAN.replace("[main, side]", "[main, sied]"), "", "corners.*", "got .*sied"),
    "run longer than its wall": (PLAN.replace("length: 1.9", "length: 3.9"), "3.9", "runs.side.length", ""),
    "walls that do not close": (
        PLAN.replace(LEFT, f"{LEFT[:-1]}, length: 2.5}}"),
        "",
        ".*",
        "expected .*lead back.*, got",
    ),
    "two walls without length": (PLAN.replace(RIGHT, "right: {heading: front}"), "", "walls.left", ""),
    "opening that leaves its wall": (PLAN + DOOR, "  door:", ".*", ""),
}


@pytest.mark.parametrize("what", MISFITS)
def test_an_error_names_the_place_of_what_is_wrong(what: str, tmp_path: Path) -> None:
    text, marker, pointer, said = MISFITS[what]
    with pytest.raises(RegistryError) as raised:
        kitchen_of(text, tmp_path)
    error = raised.value
    assert error.file == "tiny.yaml"
    assert not marker or marker in text.splitlines()[error.line - 1]
    assert re.fullmatch(pointer, error.pointer)
    assert re.search(said, f"expected {error.expected}, got {error.got}")
