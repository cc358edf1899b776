"""Laying of a surface as recipes give it: a pattern and sizes in metres become a map of pieces."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.textures.canvas import Canvas
from casa_assets.textures.laying import patterns
from casa_assets.textures.laying.pieces import PieceMap, PlacedOutline, raster


class LayingPattern(StrEnum):
    """Shapes and bonds."""

    RUNNING = "running"
    PLANKS = "planks"
    BASKET = "basket"
    HERRINGBONE = "herringbone"
    CHEVRON = "chevron"
    ASHLAR = "ashlar"
    PANEL = "panel"
    HEXAGON = "hexagon"
    PENNY = "penny"
    PICKET = "picket"
    DIAMOND = "diamond"
    SCALE = "scale"
    LANTERN = "lantern"
    OCTAGON = "octagon"
    STAR = "star"
    CUBE = "cube"
    FIELDSTONE = "fieldstone"
    LEDGE = "ledge"


class Laying(Record):
    """A pattern and its sizes. The picture has to hold whole repeats: another size is an error, not a stretch."""

    pattern: LayingPattern = Field(description="shape and bond")
    width_m: float = Field(gt=0.005, le=2, description="of a piece across its length, joint included")
    length_m: float = Field(0.1, gt=0.005, le=3, description="of a piece along its length, joint included")
    bond: float = Field(0.0, ge=0, lt=1, description="running bond: shift of each row by a length; 0: stacked")
    upright: bool = Field(False, description="the length of pieces is vertical (running bond, planks)")
    diagonal: bool = Field(False, description="the whole pattern is turned by 45 degrees (herringbone)")
    width_count: int = Field(1, ge=1, le=8, description="planks: number of widths that are mixed")
    ends_m: float = Field(0.0, ge=0, le=0.03, description="planks: by how much joints at ends are narrower")


def lay(laying: Laying, canvas: Canvas, rng: np.random.Generator) -> PieceMap:
    """Compute for every pixel its piece and its position on it.

    Raises:
        ValueError: the picture holds no whole number of repeats.
    """
    width, length = laying.width_m, laying.length_m
    if laying.pattern is LayingPattern.FIELDSTONE:
        return patterns.fieldstone(canvas, length, width, rng)
    if laying.pattern is LayingPattern.LEDGE:
        return patterns.ledges(canvas, width, length, rng)
    return raster(_places(laying, canvas.tile_m, rng), canvas)


def _places(laying: Laying, tile_m: tuple[float, float], rng: np.random.Generator) -> list[PlacedOutline]:
    width, length = laying.width_m, laying.length_m
    match laying.pattern:
        case LayingPattern.RUNNING:
            return patterns.running(tile_m, width, length, laying.bond, laying.upright)
        case LayingPattern.PLANKS:
            return patterns.planks(tile_m, width, length, laying.width_count, laying.upright, laying.ends_m, rng)
        case LayingPattern.BASKET:
            return patterns.basket(tile_m, width, length)
        case LayingPattern.HERRINGBONE:
            return patterns.herringbone(tile_m, width, length, laying.diagonal)
        case LayingPattern.CHEVRON:
            return patterns.chevron(tile_m, width, length)
        case LayingPattern.ASHLAR:
            return patterns.ashlar(tile_m, width, rng)
        case LayingPattern.PANEL:
            return patterns.panel(tile_m, width, length)
        case LayingPattern.PICKET:
            return patterns.pickets(tile_m, width, length)
        case LayingPattern.DIAMOND:
            return patterns.diamonds(tile_m, width, length)
        case LayingPattern.LANTERN:
            return patterns.lanterns(tile_m, width, length)
        case _:
            return _BY_WIDTH[laying.pattern](tile_m, width)


_BY_WIDTH = {
    LayingPattern.HEXAGON: patterns.hexagons,
    LayingPattern.PENNY: patterns.pennies,
    LayingPattern.SCALE: patterns.scales,
    LayingPattern.OCTAGON: patterns.octagons,
    LayingPattern.STAR: patterns.stars,
    LayingPattern.CUBE: patterns.cubes,
}
