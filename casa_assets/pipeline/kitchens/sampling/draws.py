"""Draw recipes of kitchens at random: plan, its lengths, style, finishes, and what is mixed in of other styles."""

from __future__ import annotations

from dataclasses import replace

from casa_assets.core.sampling import rng_for
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.resolve import draw_surfaces
from casa_assets.registry.kitchens import plan_names, style_names

MAX_SEED = 1_000_000  # seeds of kitchens are drawn below this, so that ids stay short


def draw_recipes(count: int, seed: int, objects: int = 0) -> list[SceneRecipe]:
    """Draw so many different recipes; a longer list begins with a shorter one.

    Every draw has a lane of its own, so that it does not depend on who works on which.

    Args:
        objects: number of loose objects in each; which ones, and where, is drawn with the lengths of its plan.
    """
    plans, styles = plan_names(), style_names()
    found: dict[str, SceneRecipe] = {}
    number = 0
    while len(found) < count:
        rng = rng_for(seed, f"scenes/draw/{number}")
        number += 1
        plan, style = plans[int(rng.integers(len(plans)))], styles[int(rng.integers(len(styles)))]
        own = int(rng.integers(MAX_SEED))
        recipe = SceneRecipe(plan, style, own, draw_surfaces(own), mixed=True)
        if objects:
            recipe = replace(recipe, objects=objects, objects_seed=own)
        found.setdefault(recipe.scene_id, recipe)  # one that was drawn before is drawn again, and counts once
    return list(found.values())
