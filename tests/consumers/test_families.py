"""Every family, drawn at random, and every texture: all checks pass."""

from __future__ import annotations

from pathlib import Path

from casa_assets.families.build import build_all, requests_for
from casa_assets.kitchenware.catalog import MODELS
from casa_assets.model.registry.rows import Surface
from casa_assets.textures.run.check import check_recipes, check_sets, select_recipes


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
