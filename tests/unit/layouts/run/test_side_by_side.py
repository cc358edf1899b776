"""A batch of scenes in processes of its own."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from casa_assets.errors import CasaError
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.scene_folders import run_recipes


def dies(recipe: SceneRecipe) -> SceneResult:
    """As when memory runs out."""
    os.kill(os.getpid(), signal.SIGKILL)
    return SceneResult(recipe)


def message(recipe: SceneRecipe) -> SceneResult:
    return SceneResult(recipe, message="as told")


def test_a_process_that_the_system_ends_is_told(tmp_path: Path) -> None:
    with pytest.raises(CasaError, match=r"--jobs"):
        list(run_recipes(dies, [SceneRecipe("galley", "rustic")], tmp_path, 1))


def test_all_recipes_come_back(tmp_path: Path) -> None:
    recipes = [SceneRecipe(plan, "rustic") for plan in ("galley", "l_small", "u_small")]
    done = list(run_recipes(message, recipes, tmp_path, 2))
    assert sorted(d.recipe.scene_id for d in done) == sorted(r.scene_id for r in recipes)
    assert {d.message for d in done} == {"as told"}
