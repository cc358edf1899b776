"""Periodic sheet measured in metres: noise of a given feature size, and lookups that wrap round the edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import Field
from scipy import ndimage

from casa_assets.textures import noise

Map = npt.NDArray[np.floating[Any]]
Share = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True)
class Sheet:
    """A rectangle that repeats: pixels (H, W), width and height in metres. Along is the height, across the width."""

    size_px: tuple[int, int]
    tile_m: tuple[float, float]

    def axes(self) -> tuple[Map, Map]:
        """(1, W) and (H, 1) middles of the pixels in metres."""
        height, width = self.size_px
        x = (np.arange(width, dtype=np.float32)[None, :] + 0.5) * np.float32(self.tile_m[0] / width)
        y = (np.arange(height, dtype=np.float32)[:, None] + 0.5) * np.float32(self.tile_m[1] / height)
        return x, y

    def cells(self, along_m: float, across_m: float) -> tuple[int, int]:
        """Noise cells (rows, columns) of about this size."""
        return max(1, round(self.tile_m[1] / along_m)), max(1, round(self.tile_m[0] / across_m))

    def noise(self, along_m: float, across_m: float, rng: np.random.Generator, octaves: int = 1) -> Map:
        """Periodic noise of mean 0 and deviation 1 (at full resolution) with features of this size."""
        cells = self.cells(along_m, across_m)
        if octaves == 1:
            return standard(noise.gradient(self.size_px, cells, rng))
        return standard(noise.fbm(self.size_px, cells, rng, octaves))

    def seen(self, along_m: float, across_m: float) -> float:
        """0..1, how much contrast of features of this size is left when they are smaller than a pixel."""
        return min(1.0, along_m * self.size_px[0] / self.tile_m[1]) * min(
            1.0, across_m * self.size_px[1] / self.tile_m[0]
        )

    def shifted(self, image: Map, dx_m: Map, dy_m: Map | float = 0.0) -> Map:
        """`image` looked up at (x + dx, y + dy), around the edges."""
        height, width = self.size_px
        rows = np.arange(height, dtype=np.float32)[:, None] + np.float32(height / self.tile_m[1]) * dy_m
        columns = np.arange(width, dtype=np.float32)[None, :] + np.float32(width / self.tile_m[0]) * dx_m
        rows, columns = np.broadcast_arrays(rows, columns)
        return np.asarray(ndimage.map_coordinates(image, [rows, columns], order=1, mode="grid-wrap"), dtype=np.float32)


def standard(image: npt.NDArray[np.floating]) -> Map:
    """Mean 0, deviation 1."""
    return np.asarray((image - image.mean()) / max(float(image.std()), 1e-6), dtype=np.float32)


def smoothstep(low: float, high: float, value: Map) -> Map:
    """0 at `low` and below, 1 at `high` and above, smooth between."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), dtype=np.float32)


def curve(at: Map, length: float, step: float, rng: np.random.Generator) -> Map:
    """Smooth periodic function of one coordinate, about -1..1, with a bend every `step` of its `length`."""
    count = max(2, round(length / step))
    knots = rng.uniform(-1.0, 1.0, count).astype(np.float32)
    where = np.mod(at / np.float32(length), 1.0) * count - 0.5
    return np.asarray(ndimage.map_coordinates(knots, [where], order=3, mode="grid-wrap"), dtype=np.float32)


def covered(off_m: Map, width_m: float, pixel_m: float) -> Map:
    """Share of each pixel that a line covers, so that a line thinner than a pixel is paler, not lost.

    Args:
        off_m: metres from the middle of the pixel to the middle of the line.
        width_m: of the line, metres.
        pixel_m: of a pixel across the line, metres.
    """
    near = np.maximum(-width_m / 2.0, off_m - pixel_m / 2.0)
    far = np.minimum(width_m / 2.0, off_m + pixel_m / 2.0)
    return np.asarray(np.clip(far - near, 0.0, None) / pixel_m, dtype=np.float32)
