"""Sample random kitchens: plan, its lengths, style and finishes; those that fail a check are rejected."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from casa_assets.core.sampling import rng_for
from casa_assets.pipeline.kitchens.resolve import SceneRecipe, draw_surfaces
from casa_assets.pipeline.kitchens.scene_folders import SceneResult
from casa_assets.registry.kitchens import plan_names, style_names

REJECTED = "rejected.json"
MAX_SEED = 1_000_000  # seeds of kitchens are drawn below this, so that ids stay short


def draw_recipes(count: int, seed: int) -> list[SceneRecipe]:
    """Draw recipes of kitchens at random; a longer list begins with a shorter one, and equal recipes count once."""
    plans, styles = plan_names(), style_names()
    found: dict[str, SceneRecipe] = {}
    for i in range(count):
        rng = rng_for(seed, f"scenes/draw/{i}")
        plan, style = plans[int(rng.integers(len(plans)))], styles[int(rng.integers(len(styles)))]
        own = int(rng.integers(MAX_SEED))
        recipe = SceneRecipe(plan, style, own, draw_surfaces(own))
        found.setdefault(recipe.scene_id, recipe)
    return list(found.values())


def write_rejected(out: Path, seed: int, wanted: Sequence[SceneRecipe], done: Sequence[SceneResult]) -> Path:
    """Put what was drawn, how much of it passed, and why the rest did not, into rejected.json; returns its path.

    Args:
        out: folder of the scenes. seed: of the draws. wanted: all draws. done: what became of those that were tried.
    """
    results = {d.recipe.scene_id: d for d in done}
    tried = [results[r.scene_id] for r in wanted if r.scene_id in results]
    passed = sum(d.passed for d in tried)
    data = {
        "seed": seed,
        "drawn": len(wanted),
        "tried": len(tried),
        "passed": passed,
        "pass_rate": round(passed / len(tried), 4) if tried else None,
        "rejected": [_reason(d) for d in tried if not d.passed],
    }
    path = out / REJECTED
    path.write_text(json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def _reason(done: SceneResult) -> dict[str, Any]:
    recipe = done.recipe
    return {
        "id": recipe.scene_id,
        "plan": recipe.plan,
        "style": recipe.style,
        "seed": recipe.seed,
        "surfaces": {surface.value: name for surface, name in recipe.surfaces},
        "message": done.message,
        "issues": [{"code": i.code, "pointer": i.pointer, "message": i.message} for i in done.problems],
    }
