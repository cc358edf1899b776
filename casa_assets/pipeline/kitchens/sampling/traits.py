"""Read what is drawn of a kitchen, by which kitchens are compared, off its recipe."""

from __future__ import annotations

from collections.abc import Iterable

from casa_assets.model.kitchen.surface import Surface
from casa_assets.pipeline.families.finishes import available_finishes
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.resolve import resolve
from casa_assets.pipeline.kitchens.sampling.diversity import Choices, Diversity, Traits, diversity_of
from casa_assets.pipeline.kitchens.sampling.mix import kinds_of_fronts, models_of_roles
from casa_assets.pipeline.kitchens.scene_ids import all_recipes
from casa_assets.registry.kitchens import plan_names, style_names


def traits_of(recipe: SceneRecipe) -> Traits:
    """Traits of the kitchen of a recipe, which need not be built. Raises as `resolve` does."""
    kitchen = resolve(recipe)
    bounds, style = kitchen.plan.parameters, kitchen.style
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    base = style.cabinets.base
    return Traits(
        id=recipe.scene_id,
        plan=recipe.plan,
        style=recipe.style,
        lengths={
            name: (kitchen.parameters[name] - p.low) / (p.high - p.low) if p.high > p.low else 0.0
            for name, p in bounds.items()
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
