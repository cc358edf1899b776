"""A kind of surface (`subway`, `veneer`): its parameters, and how it is painted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from casa_assets.model.record import Vec2
from casa_assets.model.registry.texture_recipe import TextureRecipe
from casa_assets.textures.layers import Layers, Map

__all__ = ["Canvas", "TextureKind", "TextureRecipe"]


@dataclass(frozen=True)
class Canvas:
    """Canvas: pixels and size in metres of the texture to be painted.

    Attributes:
        size_px: (H, W). tile_m: (width, height) of the picture in metres.
    """

    size_px: tuple[int, int]
    tile_m: Vec2

    @property
    def x(self) -> Map:
        """(1, W) middles of the pixels, metres from the left edge."""
        width = self.size_px[1]
        return ((np.arange(width, dtype=np.float32) + 0.5) * np.float32(self.tile_m[0] / width))[None, :]

    @property
    def y(self) -> Map:
        """(H, 1) middles of the pixels, metres from the upper edge."""
        height = self.size_px[0]
        return ((np.arange(height, dtype=np.float32) + 0.5) * np.float32(self.tile_m[1] / height))[:, None]

    @property
    def pixel_m(self) -> float:
        """Mean side of a pixel, metres."""
        return float(self.tile_m[0] / self.size_px[1] + self.tile_m[1] / self.size_px[0]) / 2

    def cells(self, size_m: float, height_m: float | None = None) -> tuple[int, int]:
        """Noise cells (rows, columns) of about this width (and height), one at least."""
        tall = height_m or size_m
        return max(1, round(self.tile_m[1] / tall)), max(1, round(self.tile_m[0] / size_m))


@dataclass(frozen=True)
class TextureKind:
    """Kind of texture: its name, the type of its parameters, and its painter.

    Attributes:
        name: as recipes call it.
        params: Record type of what a recipe may set.
        paint: (params, canvas, rng) -> Layers. The picture repeats without a seam in both directions, and hangs on the
            numbers and the generator alone: another size in pixels shows the same design.
    """

    name: str
    params: Any
    paint: Callable[[Any, Canvas, np.random.Generator], Layers]
