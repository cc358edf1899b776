"""Kinds of procedural texture by name, and the layers that a recipe paints with one."""

from __future__ import annotations

from casa_assets.errors import UnknownId
from casa_assets.ext.arrays import rng_for
from casa_assets.ext.records import TextureRecipe
from casa_assets.ext.textures import Canvas, Layers, TextureKind
from casa_assets.kitchenware.textures import covering, floors, food, fronts, label, laid, stone, wall_panels

SIZE_PX = 1024
WALLS = (
    covering.PLASTER,
    covering.PRINTED,
    covering.FOLIAGE,
    covering.WOVEN,
    wall_panels.CERAMIC,
    wall_panels.CLAY,
    wall_panels.BOARDS,
    wall_panels.STONEWORK,
    wall_panels.CONCRETE,
    wall_panels.TIN,
)
FLOORS = (
    *(floors.TIMBER, floors.END_GRAIN),
    *(floors.MARBLE, floors.LAYERED, floors.GRANITE, floors.CHIPS, floors.ENCAUSTIC),
    floors.RESILIENT,
)
COUNTERS = (
    *(stone.GRANITE, stone.VEINED, stone.BANDED, stone.MADE),
    *(laid.STAVES, laid.END_GRAIN, laid.METAL, laid.TILED, laid.GLAZED, laid.PRINTED),
)
FRONTS = (fronts.VENEER, fronts.PAINTED, fronts.PRESSED)
OBJECTS = (food.SKIN, label.LABEL, food.SECTION)
KINDS: dict[str, TextureKind] = {kind.name: kind for kind in (*WALLS, *FLOORS, *COUNTERS, *FRONTS, *OBJECTS)}


def kind_of(name: str) -> TextureKind:
    """The kind of that name. Raises UnknownId with the nearest names."""
    if name not in KINDS:
        raise UnknownId("kind of texture", name, KINDS)
    return KINDS[name]


def make(recipe: TextureRecipe, size_px: int = SIZE_PX) -> Layers:
    """Paint a recipe; the longer side has `size_px` pixels. Raises UnknownId for an unknown kind."""
    return paint(kind_of(recipe.kind), recipe, size_px)


def paint(kind: TextureKind, recipe: TextureRecipe, size_px: int = SIZE_PX) -> Layers:
    """Paint a recipe with a kind that is already looked up."""
    width, height = recipe.tile_m
    longest = max(width, height)
    size = (max(8, round(size_px * height / longest)), max(8, round(size_px * width / longest)))
    params = kind.params.from_json(recipe.params)
    return kind.paint(params, Canvas(size, recipe.tile_m), rng_for(recipe.seed, f"textures/{recipe.kind}"))
