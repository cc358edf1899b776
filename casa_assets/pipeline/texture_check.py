"""Recipes through every check of textures, two processes at a time, with the finishes kept in the store."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from casa_assets import registry
from casa_assets.model.finish import Surface
from casa_assets.model.issue import Report
from casa_assets.model.recipe import Recipe
from casa_assets.pipeline.textures import finish_of, recipe, recipes
from casa_assets.textures.check import check_pictures, check_set, pictures_of
from casa_assets.textures.distance import Look, look
from casa_assets.textures.make import make

LOOK_PX = 256
JOBS = 2


@dataclass(frozen=True)
class Checked:
    """A recipe that was checked: its report, and what it looks like beside the others."""

    recipe: Recipe
    report: Report
    look: Look


def check_one(wanted: Recipe, cache: Path) -> Checked:
    """Paint a recipe, or take it from the store at `cache`, and check it."""
    report = check_pictures(pictures_of(finish_of(wanted, cache)), registry.load().limits)
    small = make(wanted, LOOK_PX)
    seen = look(small.albedo, wanted.tile_m, small.roughness, small.height_m)
    return Checked(wanted, report, seen)


def check_recipes(wanted: Sequence[Recipe], cache: Path, jobs: int = JOBS) -> Iterator[Checked]:
    """Recipes in the order given.

    Args:
        wanted: what to check. cache: folder of the store. jobs: processes.
    """
    if jobs <= 1 or len(wanted) < 2:
        for one in wanted:
            yield check_one(one, cache)
        return
    with ProcessPoolExecutor(min(jobs, len(wanted)), mp_context=get_context("spawn")) as pool:
        yield from pool.map(check_one, wanted, [cache] * len(wanted))


def check_sets(checked: Sequence[Checked]) -> tuple[Report, ...]:
    """Report of each set of which every recipe was checked."""
    limits = registry.load().limits
    found = []
    for surface, rows in recipes().items():
        looks = {c.recipe.id: c.look for c in checked if c.recipe.surface is surface}
        if looks and len(looks) == len(rows):
            found.append(check_set(surface.value, looks, limits))
    return tuple(found)


def chosen(names: Sequence[str], surfaces: Sequence[Surface]) -> tuple[Recipe, ...]:
    """Recipes by id; of whole sets where no id is given; all where no set is given either.

    Raises:
        UnknownId: no recipe has that id.
    """
    if names:
        return tuple(recipe(name) for name in names)
    return tuple(r for s in (surfaces or tuple(Surface)) for r in recipes()[s].values())
