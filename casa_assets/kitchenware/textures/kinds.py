"""Kinds of procedural texture, by name."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures import covering, floors, food, fronts, label, laid, stone, wall_panels

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
