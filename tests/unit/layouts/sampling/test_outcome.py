"""What is told of a run of draws: reasons of refusals, and what a kitchen cost."""

from __future__ import annotations

import json
from pathlib import Path

from casa_assets.layouts.run import sample
from casa_assets.layouts.run.draws import draw_recipes
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.sample import RefusalRow
from casa_assets.model.issue import Issue, Report, Severity


def report(*codes: str) -> Report:
    found = [Issue(code=code, severity=Severity.ERROR, pointer="a/b", message=f"{code} is wrong") for code in codes]
    return Report(subject="x", issues=tuple(found))


def test_refusals_are_counted_by_reason_plan_and_style() -> None:
    galley, wall = SceneRecipe("galley", "rustic", 1), SceneRecipe("one_wall_small", "rustic", 1)
    done = [
        SceneResult(galley, "somewhere"),
        SceneResult(galley, report=report("SCN005", "SCN005", "SCN009")),
        SceneResult(SceneRecipe("galley", "rustic", 2), report=report("SCN005")),
        SceneResult(wall, message="the run main is too long"),
        SceneResult(wall, message="Traceback ...\nValueError: what", is_fault=True),
    ]
    assert sample.refusals(done) == [
        RefusalRow("SCN005", "galley", "rustic", 2, "a/b SCN005 is wrong"),
        RefusalRow("SCN009", "galley", "rustic", 1, "a/b SCN009 is wrong"),
        RefusalRow("cannot be built", "one_wall_small", "rustic", 1, "the run main is too long"),
        RefusalRow("fault of the program", "one_wall_small", "rustic", 1, "ValueError: what"),
    ]
    assert sample.refusals(done[:1]) == []


def test_rejected_tells_the_reason_of_each(tmp_path: Path) -> None:
    wanted = draw_recipes(3, 0)
    done = [
        SceneResult(wanted[2], message="the run main is too long"),
        SceneResult(wanted[0], "somewhere"),
        SceneResult(wanted[1], report=report("SCN009")),
    ]
    data = json.loads(sample.write_rejected(tmp_path, 0, wanted, done).read_text(encoding="utf-8"))
    assert (data["drawn"], data["tried"], data["passed"], data["pass_rate"]) == (3, 3, 1, 0.3333)
    assert [r["id"] for r in data["rejected"]] == [wanted[1].scene_id, wanted[2].scene_id]
    assert data["rejected"][0]["issues"][0]["code"] == "SCN009"
    assert data["rejected"][1]["message"] == "the run main is too long"
    assert sorted(row["reason"] for row in data["reasons"]) == ["SCN009", "cannot be built"]


def test_cost_is_the_mean_over_those_whose_cost_is_known() -> None:
    recipe = SceneRecipe("galley", "rustic")
    done = [
        SceneResult(recipe, "a", cpu_s={"build": 1.0, "write": 2.0, "check": 6.0, "rest": 1.0}),
        SceneResult(recipe, cpu_s={"build": 3.0, "check": 8.0}),
        SceneResult(recipe, "b", kept=True),
    ]
    cost = sample.cost_of(done)
    assert (cost.kitchens, cost.total, sample.cost_of([]).total) == (2, 10.5, 0.0)
    assert cost.steps == {"build": 2.0, "write": 1.0, "draw": 0.0, "check": 7.0, "rest": 0.5}
