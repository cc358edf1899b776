"""What is drawn and what is mended passes every check: members of families, textures, plans in all styles."""

from __future__ import annotations

from pathlib import Path

import pytest

from casa_assets.families.build import build_all, requests_for
from casa_assets.kitchenware.catalog import MODELS
from casa_assets.layouts.check_plan.check import check_plan, plan_id
from casa_assets.layouts.run import check
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.model.registry.rows import Surface
from casa_assets.registry.kitchens import load_style, style_names
from casa_assets.textures.run.check import check_recipes, check_sets, select_recipes
from tests.support.kitchen.plan_corpus import plans
from tests.support.program.projects import project_in

# Plans that are right, and plans whose rows, rooms, openings, islands and corners are corrected.
PLANS = {
    "draft_huge_room": "transitional_2",
    "draft_tiny": "transitional_1",
    "ok_corner": "coastal",
    "ok_galley": "mediterranean",
    "ok_island": "traditional_1",
    "ok_studio": "rustic",
    "aisle_too_narrow": "industrial",
    "door_beyond_wall": "modern_1",
    "island_too_large": "farmhouse",
    "no_corner": "scandinavian",
    "row_too_long": "modern_2",
    "walls_aslant_do_not_close": "traditional_2",
}

pytestmark = pytest.mark.certify


def test_every_style_is_among_them() -> None:
    assert set(PLANS.values()) == set(style_names())


@pytest.mark.parametrize("name", PLANS)
def test_a_mended_plan_is_a_kitchen_that_passes(name: str, tmp_path: Path) -> None:
    style, plan = PLANS[name], plan_id(f"{name}.yaml")
    found = check_plan(plans()[name], f"{name}.yaml", load_style(style)[0])
    assert found.mended, [f"{told.expected}, got {told.got}" for told in found.faults if told.mend is None]
    with project_in(tmp_path) as project:
        project({f"plans/{plan}.yaml": found.text})
        done = check.check_one(SceneRecipe(plan, style), tmp_path / "out", drawn=False, in_3d=False)
    assert (done.message, [f"{i.code} {i.pointer}: {i.message}" for i in done.problems]) == ("", [])


def test_random_members_of_every_family_pass(tmp_path: Path) -> None:
    wanted = requests_for([], samples=2, seed=20, presets=False)
    done = list(build_all(wanted, tmp_path, drawn=False))
    failed = [
        (d.request.title, d.message or [f"{i.code} {i.pointer}: {i.message}" for i in d.problems])
        for d in done
        if not d.passed
    ]
    assert failed == []
    assert len(done) == 2 * len(MODELS)


def test_textures_pass(tmp_path: Path) -> None:
    recipes = select_recipes([], list(Surface))
    assert len(recipes) == 400
    checked = list(check_recipes(recipes, tmp_path))
    assert len(checked) == 400
    assert [c.recipe.id for c in checked if not c.report.passed] == []
    assert [r.subject for r in check_sets(checked) if not r.passed] == []
