"""Plans are checked without being built: each fault with its line and a mend, and the mends together make a plan.

Plans as language models write them (`tests.support.kitchen.plan_corpus`): each fits, has corrections that make it fit,
or is told what it lacks where. `expected.yaml` has the sentences of the corrections of each in their order, or the line
and pointer of the first fault that has no correction, behind an exclamation mark; nothing for those that fit. What is
made of a plan that was corrected is tried of a dozen that differ most; of all before a release.
`CASA_NEW_EXPECTED=1` in the environment has the table written again, to be read before it is committed.

Plans in rooms of other sizes: what comes out fits, in the room that was asked for, or is refused with a size.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets.api.schemas import schema_text
from casa_assets.cli.main import app
from casa_assets.errors import CasaError
from casa_assets.layouts.check_plan.check import DoesNotFit, PlanCheck, check_plan, edited_text, fit_plan, plan_id
from casa_assets.layouts.check_plan.edit import Edit, EditKind
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.run.resolve import params_of, preset_params
from casa_assets.model.kitchen.plan import Plan
from casa_assets.projects import data_root
from casa_assets.registry.kitchens import laid_over_like, load_plan, load_style, plan_names, style_names
from casa_assets.registry.read import parse_document, read_document
from tests.support.kitchen.plan_corpus import plans
from tests.support.program.projects import Project

pytestmark = pytest.mark.content("code", "layouts.check_plan", keep=0)

STYLE = "modern_1"
ROOM = """title: Studio
walls:
  back: {heading: right, length: 4.6}
  right: {heading: front, length: 3.0}
  front: {heading: left, length: 4.6, open: true}
  left: {heading: back, length: 3.0}
"""
ROW = """runs:
  main:
    on: back
    base: # from left to right
      - filler: [0.05, 0.12]
      - drawers: [0.4, 0.9]
      - sink
      - dishwasher
      - range
      - doors: [0.4, 0.9]
      - fridge
    upper:
      - hood: {over: main_range}
"""


def text_of(name: str) -> str:
    return (data_root() / "plans" / f"{name}.yaml").read_text(encoding="utf-8")


def checked(text: str, style: str = STYLE) -> PlanCheck:
    return check_plan(text, "studio.yaml", load_style(style)[0])


def told(found: PlanCheck) -> list[tuple[int, str, str]]:
    """Line, pointer and sentence of the mend of each fault."""
    return [(t.line, ".".join(map(str, t.pointer)), t.mend.sentence if t.mend else "") for t in found.faults]


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.certify)], ids=["one_style", "every"])
@pytest.mark.parametrize("name", plan_names())
def test_plans_of_the_package_fit_every_style(name: str, every: bool) -> None:
    """In one style each, between them in all; before a release each in all."""
    names = style_names() if every else [style_names()[plan_names().index(name) % len(style_names())]]
    assert {style: told(checked(text_of(name), style)) for style in names} == {style: [] for style in names}


def test_faults_of_several_kinds_are_told_in_one_call_with_their_lines() -> None:
    text = (ROOM + ROW).replace("dishwasher", "dishwahser").replace("length: 3.0}", "length: 3.1}", 1)
    found = checked(text)
    assert told(found) == [
        (14, "runs.main.base.3", "Write dishwasher."),
        (6, "walls.left.length", "Write `length: 3.1` for left."),
    ]
    assert found.mended
    assert checked(found.text).fits
    assert "base: # from left to right" in found.text
    assert found.text.splitlines()[:2] == text.splitlines()[:2]


def test_a_plan_like_another_states_its_mends_itself() -> None:
    found = checked("like: galley\nopenings:\n  door: {at: 9}\nheigth: 2.6\n")
    assert found.mended, told(found)
    assert found.text.startswith("like: galley\n")
    assert checked(found.text).fits
    assert checked("like: galey\n").text == "like: galley\n"


def test_the_command_prints_faults_and_writes_the_mended_plan(tmp_path: Path) -> None:
    plan, better = tmp_path / "studio.yaml", tmp_path / "better.yaml"
    plan.write_text((ROOM + ROW).replace("fridge", "frigde"), encoding="utf-8")
    run = CliRunner()
    words = ["scenes", "check-plan", str(plan)]
    said = run.invoke(app, words)
    assert said.exit_code == 1
    assert "studio.yaml:17: runs.main.base.6: expected 'fridge'" in " ".join(said.stdout.split())
    row = json.loads(run.invoke(app, [*words, "--json"]).stdout)
    assert (row["verdict"], row["mended"]) == ("faulty", True)
    assert row["faults"][0]["mend"]["edits"] == [
        {"op": "replace", "pointer": ["runs", "main", "base", 6], "old": "frigde", "new": "fridge"}
    ]
    assert run.invoke(app, [*words, "--fix"]).exit_code == 2
    assert run.invoke(app, [*words, "--fix", "--out", str(better)]).exit_code == 1
    assert run.invoke(app, ["scenes", "check-plan", str(better)]).exit_code == 0
    with pytest.raises(casa.CasaError, match="there already"):
        run.invoke(app, [*words, "--fix", "--out", str(better)], catch_exceptions=False)


LARGE = ROOM.replace("3.0", "4.6").replace("4.6, open", "4.8, open").replace("right, length: 4.6", "right, length: 4.8")
ONE_ROW = """runs:
  main:
    on: back
    base: [{drawers: [0.4, 0.9]}, sink, dishwasher, {doors: [0.4, 0.9]}, range, {drawers: [0.4, 0.9]}, fridge]
    upper:
      - hood: {over: main_range}
"""
FACING = """  island:
    faces: {run: main, aisle: 1.3}
    base: [{island: 1.8}]
"""


def test_a_ceiling_is_over_the_cornice_and_one_that_is_too_high_is_as_high_as_it_can_be() -> None:
    row = ONE_ROW + "      - doors: [0.35, 0.9]\n"
    for height, mended in ((2.3, "height: 2.34"), (3.9, "height: 3.4")):
        text = LARGE.replace("walls:", f"height: {height}\nwalls:") + row
        found = checked(text, "traditional_1")
        assert found.mended
        assert mended in found.text


def test_limits_of_a_project_hold_and_the_others_stay(project: Project) -> None:
    text = LARGE + ONE_ROW + FACING.replace("1.3", "1.15")
    assert not [t for t in checked(text).faults if "aisle" in t.expected]
    project({"limits.yaml": "work_aisle_m: {value: 1.2}\n"})
    told = [t.expected for t in checked(text).faults]
    assert any("an aisle of at least 1.2 m" in expected for expected in told), told


PLANS = plans()
# A plan that is right, one like another, faults of YAML, words, units of length, rows, corners, openings and islands.
FEW = ("ok_corner", "draft_like", "open_brace", "prose_and_fence", "feet_and_inches", "misspelt_kind")
FEW += ("no_such_wall", "row_too_long", "no_corner", "wide_door", "windows_overlap", "island_too_large")
EXPECTED = Path(__file__).parent / "expected.yaml"
MAX_CALLS = 5


def sentences(name: str) -> list[str]:
    found = check_plan(PLANS[name], f"{name}.yaml", load_style(STYLE)[0])
    if not found.mended:
        first = next(told for told in found.faults if told.mend is None)
        assert first.expected, name
        return [f"! {first.line} {'.'.join(map(str, first.pointer))}".rstrip()]
    return [t.mend.sentence for t in found.faults if t.mend]


# Those that all corrections together make fit.
EACH = [
    pytest.param(name, marks=[pytest.mark.certify] * (name not in FEW))
    for name, said in sorted(read_document(EXPECTED).value.items())
    if not any(one.startswith("!") for one in said or ())
]


def test_mends_are_those_of_the_table() -> None:
    now = {name: sentences(name) for name in PLANS}
    if os.environ.get("CASA_NEW_EXPECTED"):
        rows = "".join(f"{name}:\n" + "".join(f"  - {json.dumps(s)}\n" for s in said) for name, said in now.items())
        EXPECTED.write_text(rows, encoding="utf-8")
    assert now == {name: said or [] for name, said in read_document(EXPECTED).value.items()}
    assert all((said == []) == name.startswith("ok_") for name, said in now.items())


@pytest.mark.parametrize("name", EACH)
def test_a_program_that_makes_the_mends_gets_a_plan(name: str) -> None:
    """The loop of a program that calls `check-plan --json`: it makes the edits, asks again, and builds in the end."""
    text, style, file = PLANS[name], load_style(STYLE)[0], f"{name}.yaml"
    for _ in range(MAX_CALLS):
        found = check_plan(text, file, style)
        if found.fits:
            break
        for told in found.faults:
            facts = json.loads(json.dumps(told.facts))
            assert facts["mend"], facts
            if facts["file"] == file:
                assert 1 <= facts["line"] <= len(PLANS[name].splitlines())
            for edit in facts["mend"]["edits"]:
                change = Edit(EditKind(edit["op"]), tuple(edit["pointer"]), edit["new"])
                text = edited_text(text, file, change)
    assert found.fits, [told.facts for told in found.faults]
    # The code of the families says the same of it as the short table of their sizes.
    document = parse_document(text, file)
    value = laid_over_like(document, plan_id(file)).value if "like" in document.value else document.value
    assert request_kitchen(Plan.model_validate({**value, "id": plan_id(file)}), style, preset_params()).items
    # And they make all that it asks for, in one style each, between them in all.
    other = style_names()[list(PLANS).index(name) % len(style_names())]
    made = check_plan(PLANS[name], file, load_style(other)[0])
    for item in made.kitchen.items if made.kitchen else ():
        params_of(item.choice)  # else CasaError


@pytest.mark.parametrize("name", ["plan", "style"])
def test_plans_and_styles_of_the_package_keep_to_their_schemas(name: str) -> None:
    validator = Draft202012Validator(json.loads(schema_text(name)))
    paths = sorted((data_root() / f"{name}s").glob("*.yaml"))
    assert len(paths) >= 10
    for path in paths:
        assert [f"{e.json_path}: {e.message}" for e in validator.iter_errors(read_document(path).value)] == [], path
    assert next(validator.iter_errors({"title": "x", "like": "galley", "colour": "red"}), None) is not None
    assert next(validator.iter_errors({"title": "x"}), None) is not None


ROOMS = ((4.2, 3.1), (5.0, 4.2), (6.0, 5.0), (7.5, 6.5))
# Rooms in which a row is too short for its sink or its cooker, in which no mend lets doors open in corners and
# appliances keep off these, and in which nothing can be set down beside the microwave.
REFUSED = {
    (4.2, 3.1): ("u_dining", "wraparound"),
    (5.0, 4.2): ("u_dining", "g_small", "l_large", "one_wall_small", "wraparound"),
}
# One room of each plan that takes little time, two that are refused; the other rows are of a release.
QUICK = {
    (4.2, 3.1): ("g_small", "galley", "l_large", "l_small", "one_wall_large", "u_small"),
    (5.0, 4.2): ("l_bay", "l_large", "one_wall_small"),
    (6.0, 5.0): ("g_large", "l_columns", "pantry_island", "u_dining", "u_large"),
    (7.5, 6.5): ("attic", "double_island", "wraparound"),
}
ROWS = [
    pytest.param(name, room, id=f"{name}-{room}", marks=[pytest.mark.certify] * (name not in QUICK[room]))
    for room in ROOMS
    for name in plan_names()
]


def fitted_kitchen(text: str, name: str, room: tuple[float, float]) -> KitchenRequest:
    fitted = fit_plan(text, f"{name}.yaml", load_style(STYLE)[0], *room)
    assert fitted.changes
    found = check_plan(fitted.text, f"{name}.yaml", load_style(STYLE)[0])
    assert found.fits
    (x0, y0), (x1, y1) = found.kitchen.room.bounds()
    assert (x1 - x0, y1 - y0) == pytest.approx(room, abs=0.005)
    assert ("like:" in fitted.text) == ("like:" in text)
    return found.kitchen


@pytest.mark.parametrize(("name", "room"), ROWS)
def test_a_plan_in_a_room(name: str, room: tuple[float, float]) -> None:
    style, text = load_style(STYLE)[0], text_of(name)
    if any(wall.is_aslant for wall in load_plan(name)[0].walls):
        with pytest.raises(CasaError, match=r"its wall \w+ stands aslant"):
            fit_plan(text, f"{name}.yaml", style, *room)
        return
    if name in REFUSED.get(room, ()):
        with pytest.raises(DoesNotFit) as refused:
            fit_plan(text, f"{name}.yaml", style, *room)
        assert fit_plan(text, f"{name}.yaml", style, *refused.value.least).changes
        return
    kinds = {str(unit.kind) for unit in fitted_kitchen(text, name, room).plan.units.values()}
    assert {"sink", "fridge"} <= kinds
    assert kinds & {"range", "hob"}


def test_its_own_room_changes_nothing_and_a_plan_like_another_states_what_changes() -> None:
    fitted = fit_plan(text_of("galley"), "galley.yaml", load_style(STYLE)[0], 3.2, 5.6)
    assert (fitted.text, fitted.changes) == (text_of("galley"), ())
    fitted_kitchen("like: one_wall_small\ntitle: A shorter wall\n", "short", (5.4, 3.2))


def test_the_command(tmp_path: Path) -> None:
    plan, out = tmp_path / "galley.yaml", tmp_path / "small.yaml"
    plan.write_text(text_of("galley"), encoding="utf-8")
    run = CliRunner()
    words = ["scenes", "fit", str(plan), "--width", "3.1"]
    done = run.invoke(app, [*words, "--depth", "4.8", "--out", str(out)])
    assert done.exit_code == 0
    assert "# Write depth: [4.8, 4.8, 4.8]." in done.stdout
    assert check_plan(out.read_text(encoding="utf-8"), str(out), load_style(STYLE)[0]).fits
    plan.write_text(text_of("one_wall_small"), encoding="utf-8")
    small = run.invoke(app, ["scenes", "fit", str(plan), "--width", "5.0", "--depth", "4.2"])
    assert small.exit_code == 1
    assert "the least room for it is about" in small.stdout
