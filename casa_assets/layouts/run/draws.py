"""Draw recipes of kitchens at random (plan, lengths, style, finishes), and find the traits by which they differ."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from casa_assets.core.numeric import rng_for
from casa_assets.layouts.run.diversity import Choices, Diversity, Traits, diversity_of
from casa_assets.layouts.run.mix import kinds_of_fronts, models_of_roles
from casa_assets.layouts.run.recipe import SceneRecipe, all_recipes
from casa_assets.layouts.run.resolve import draw_surfaces, resolve
from casa_assets.model.kitchen.choices import Surface
from casa_assets.registry.kitchens import plan_names, style_names
from casa_assets.textures.run.recipes import available_finishes


def traits_of(recipe: SceneRecipe) -> Traits:
    """Traits of the kitchen of a recipe, which need not be built. Raises as `resolve` does."""
    kitchen = resolve(recipe)
    style = kitchen.style
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    base = style.cabinets.base
    return Traits(
        id=recipe.scene_id,
        plan=recipe.plan,
        style=recipe.style,
        lengths={
            name: (kitchen.parameters[name] - p.low) / (p.high - p.low) if p.high > p.low else 0.0
            for name, p in kitchen.plan.parameters.items()
        },
        floor_m2=(x1 - x0) * (y1 - y0),
        surfaces={
            Surface.WALL.value: style.room.wall,
            Surface.FLOOR.value: style.room.floor,
            Surface.COUNTER.value: style.counter.face,
            Surface.CABINET.value: base.face or "",
        },
        fronts=f"{base.front}, {base.handle}",
        fixtures={item.role: item.choice.preset for item in kitchen.items if item.role in style.models},
    )


def diversity_of_recipes(recipes: Iterable[SceneRecipe]) -> Diversity:
    """How diverse the kitchens of some recipes are, which need not be built. Raises as `resolve` does."""
    return diversity_of([traits_of(recipe) for recipe in recipes], choices())


def diversity_of_reference() -> Diversity:
    """How diverse every plan in every style is, each as it is: what random kitchens are compared with."""
    return diversity_of_recipes(all_recipes())


def choices() -> Choices:
    """How many values the traits can have, with the plans, styles and textures in use."""
    models, finishes = models_of_roles(), available_finishes().surfaces
    return Choices(
        plans=len(plan_names()),
        styles=len(style_names()),
        fronts=len(kinds_of_fronts()),
        surfaces={surface.value: len(finishes[surface]) for surface in Surface},
        fixtures={role: len(names) for role, names in models.items()},
    )


MAX_SEED = 1_000_000  # seeds of kitchens are drawn below this, so that ids stay short


def draw_recipes(count: int, seed: int, objects: int = 0) -> list[SceneRecipe]:
    """Draw `count` different recipes. With the same seed, a longer list begins with the shorter one.

    Every draw has a separate random stream, so that it does not depend on which process works on it.

    Args:
        objects: number of loose objects in each; which ones, and their places, are drawn with the lengths of its plan.
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
