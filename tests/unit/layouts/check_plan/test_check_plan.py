"""Plans are checked without being built: each fault with its line and a mend, and the mends together make a plan."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets.cli.main import app
from casa_assets.layouts.check_plan.check import PlanCheck, check_plan
from casa_assets.model.kitchen.style import Style
from casa_assets.projects import data_root
from casa_assets.registry.kitchens import load_style, plan_names, style_names
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


def checked(text: str, style: str = STYLE) -> PlanCheck:
    return check_plan(text, "studio.yaml", load_style(style)[0])


def told(found: PlanCheck) -> list[tuple[int, str, str]]:
    """Line, pointer and sentence of the mend of each fault."""
    return [(t.line, ".".join(map(str, t.pointer)), t.mend.sentence if t.mend else "") for t in found.faults]


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.certify)], ids=["one_style", "every"])
@pytest.mark.parametrize("name", plan_names())
def test_plans_of_the_package_fit_every_style(name: str, every: bool) -> None:
    """In one style each, between them in all; before a release each in all."""
    text = (data_root() / "plans" / f"{name}.yaml").read_text(encoding="utf-8")
    names = style_names() if every else [style_names()[plan_names().index(name) % len(style_names())]]
    styles: list[Style] = [load_style(style)[0] for style in names]
    assert [told(check_plan(text, f"{name}.yaml", style)) for style in styles] == [[]] * len(styles)


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


def test_it_loads_nothing_large() -> None:
    """What takes seconds to load would take longer than the check."""
    code = (
        "import sys; from casa_assets.layouts.check_plan.check import check_plan; "
        "from casa_assets.registry.kitchens import load_style; "
        f"assert check_plan(open(sys.argv[1]).read(), sys.argv[1], load_style({STYLE!r})[0]).fits; "
        "print([m for m in ('scipy', 'mujoco', 'pxr', 'trimesh', 'casa_assets.families') if m in sys.modules])"
    )
    plan = data_root() / "plans" / "u_large.yaml"
    done = subprocess.run([sys.executable, "-c", code, str(plan)], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


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
        found = check_plan(text, "studio.yaml", load_style("traditional_1")[0])
        assert found.mended
        assert mended in found.text


def test_limits_of_a_project_hold_and_the_others_stay(project: Project) -> None:
    text = LARGE + ONE_ROW + FACING.replace("1.3", "1.15")
    assert not [t for t in checked(text).faults if "aisle" in t.expected]
    project({"limits.yaml": "work_aisle_m: {value: 1.2}\n"})
    told = [t.expected for t in checked(text).faults]
    assert any("an aisle of at least 1.2 m" in expected for expected in told), told
