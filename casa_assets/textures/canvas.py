"""Canvas of a periodic texture, measured in metres; the layers painted on it; noise that repeats; kinds of surfaces."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import Field
from scipy import ndimage

from casa_assets.core.numeric import rng_for, srgb_from_hex
from casa_assets.model.asset.material import PrintedLine
from casa_assets.model.record import Vec2
from casa_assets.model.registry.rows import TextureRecipe

NoiseMap = npt.NDArray[np.float32]
Size = tuple[int, int]


def gradient(size_px: Size, cells: Size, rng: np.random.Generator) -> NoiseMap:
    """(H, W) Perlin noise, about -0.7..0.7. Ref: K. Perlin, Improving Noise, 2002."""
    (height, width), (rows, columns) = size_px, cells
    turn = rng.uniform(0.0, 2.0 * np.pi, (rows, columns))
    slope_x, slope_y = np.cos(turn).astype(np.float32), np.sin(turn).astype(np.float32)
    y, x = _places(height, rows), _places(width, columns)
    row, column = np.floor(y).astype(np.int64), np.floor(x).astype(np.int64)
    fy, fx = (y - row).astype(np.float32)[:, None], (x - column).astype(np.float32)[None, :]
    u, v = _fade(fx), _fade(fy)

    def corner(down: int, right: int) -> NoiseMap:
        # What all pixels in a row of cells have in common is computed once, and whole rows are copied.
        across, cell = (column + right) % columns, (row + down) % rows
        along = (slope_x.take(across, axis=1) * (fx - right)).take(cell, axis=0)
        along += slope_y.take(across, axis=1).take(cell, axis=0) * (fy - down)
        return along

    upper = corner(0, 0) * (1 - u) + corner(0, 1) * u
    return np.asarray(upper * (1 - v) + (corner(1, 0) * (1 - u) + corner(1, 1) * u) * v, dtype=np.float32)


def fbm(size_px: Size, cells: Size, rng: np.random.Generator, octaves: int) -> NoiseMap:
    """(H, W) sum of octaves of gradient noise, about -1..1."""
    total = np.zeros(size_px, dtype=np.float32)
    for weight, noise in _octaves(size_px, cells, rng, octaves):
        total += np.float32(weight) * noise
    return total


def ridged(size_px: Size, cells: Size, rng: np.random.Generator, octaves: int) -> NoiseMap:
    """(H, W) in 0..1: sharp crests where the noise crosses zero, as veins have them."""
    total, weights = np.zeros(size_px, dtype=np.float32), 0.0
    for weight, noise in _octaves(size_px, cells, rng, octaves):
        total += np.float32(weight) * (1 - np.clip(np.abs(noise) * 2, 0, 1))
        weights += weight
    return np.asarray(total / np.float32(max(weights, 1e-6)), dtype=np.float32)


def _octaves(size_px: Size, cells: Size, rng: np.random.Generator, count: int) -> Iterator[tuple[float, NoiseMap]]:
    """Octaves of gradient noise with their weights; those finer than two pixels are drawn but left out."""
    for k in range(count):
        finer = (cells[0] << k, cells[1] << k)
        lane = np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))
        if 2 * finer[0] <= size_px[0] and 2 * finer[1] <= size_px[1]:
            yield 0.5**k, gradient(size_px, finer, lane)


def worley(
    size_px: Size, cells: Size, rng: np.random.Generator, jitter: float = 0.9
) -> tuple[NoiseMap, NoiseMap, npt.NDArray[np.int32]]:
    """Distance to the nearest and to the second nearest point, in cells, and the number of the nearest.

    One point in each cell, moved from its middle by up to half of `jitter`.
    Ref: S. Worley, A Cellular Texture Basis Function, 1996.
    """
    (height, width), (rows, columns) = size_px, cells
    off_y = (0.5 + jitter * (rng.random((rows, columns)) - 0.5)).astype(np.float32)
    off_x = (0.5 + jitter * (rng.random((rows, columns)) - 0.5)).astype(np.float32)
    y, x = _places(height, rows), _places(width, columns)
    row, column = np.floor(y).astype(np.int64), np.floor(x).astype(np.int64)
    fy, fx = (y - row).astype(np.float32)[:, None], (x - column).astype(np.float32)[None, :]
    nearest, second = np.full((2, *size_px), 9.0, dtype=np.float32)
    owner = np.zeros(size_px, dtype=np.int32)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            r, c = (row + down) % rows, (column + right) % columns
            at = np.ix_(r, c)
            gap = (fy - down - off_y[at]) ** 2 + (fx - right - off_x[at]) ** 2
            closer = gap < nearest
            second = np.where(closer, nearest, np.minimum(second, gap))
            number = (r[:, None] * columns + c[None, :]).astype(np.int32)
            owner = np.where(closer, number, owner)
            nearest = np.where(closer, gap, nearest)
    return np.sqrt(nearest), np.sqrt(second), owner


def blur(image: NoiseMap, sigma_px: float) -> NoiseMap:
    """Gaussian blur round the torus, channel by channel."""
    sigma = (sigma_px, sigma_px, 0.0)[: image.ndim]
    return np.asarray(ndimage.gaussian_filter(image, sigma, mode="wrap"), dtype=np.float32)


def _places(size: int, cells: int) -> npt.NDArray[np.float64]:
    return (np.arange(size) + 0.5) / size * cells


def _fade(t: NoiseMap) -> NoiseMap:
    return np.asarray(t * t * t * (t * (t * 6 - 15) + 10), dtype=np.float32)


Map = npt.NDArray[np.floating[Any]]
Share = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True)
class Canvas:
    """A rectangle of (H, W) pixels, row 0 above, and (width, height) metres that repeats in both directions."""

    size_px: tuple[int, int]
    tile_m: Vec2

    @property
    def pixel_m(self) -> float:
        """Mean side of a pixel, metres."""
        return float(self.tile_m[0] / self.size_px[1] + self.tile_m[1] / self.size_px[0]) / 2

    @property
    def pixel_width_m(self) -> float:
        """Width of a pixel, metres."""
        return self.tile_m[0] / self.size_px[1]

    @property
    def transposed(self) -> Canvas:
        """The canvas with x and y swapped."""
        return Canvas(self.size_px[::-1], self.tile_m[::-1])

    def axes(self) -> tuple[Map, Map]:
        """(1, W) and (H, 1) middles of the pixels: metres from the left and from the upper edge."""
        height, width = self.size_px
        x = (np.arange(width, dtype=np.float32)[None, :] + 0.5) * np.float32(self.tile_m[0] / width)
        y = (np.arange(height, dtype=np.float32)[:, None] + 0.5) * np.float32(self.tile_m[1] / height)
        return x, y

    def cells(self, along_m: float, across_m: float) -> tuple[int, int]:
        """Noise cells (rows, columns) of about this height and width, one at least."""
        return max(1, round(self.tile_m[1] / along_m)), max(1, round(self.tile_m[0] / across_m))

    def noise(self, along_m: float, across_m: float, rng: np.random.Generator, octaves: int = 1) -> Map:
        """(H, W) periodic noise of mean 0 and deviation 1 with features of this height and width."""
        cells = self.cells(along_m, across_m)
        if octaves == 1:
            return standardize(gradient(self.size_px, cells, rng))
        return standardize(fbm(self.size_px, cells, rng, octaves))

    def resolved(self, along_m: float, across_m: float) -> float:
        """0..1, the contrast that features of this height and width keep: less than 1 where a pixel is larger."""
        along, across = along_m * self.size_px[0] / self.tile_m[1], across_m * self.size_px[1] / self.tile_m[0]
        return min(1.0, along) * min(1.0, across)

    def shifted(self, image: Map, dx_m: Map, dy_m: Map | float = 0.0) -> Map:
        """`image` looked up at (x + dx, y + dy), bilinear, around the edges."""
        height, width = self.size_px
        rows = np.arange(height, dtype=np.float32)[:, None] + np.float32(height / self.tile_m[1]) * dy_m
        columns = np.arange(width, dtype=np.float32)[None, :] + np.float32(width / self.tile_m[0]) * dx_m
        rows, columns = np.broadcast_arrays(rows, columns)
        return np.asarray(ndimage.map_coordinates(image, [rows, columns], order=1, mode="grid-wrap"), dtype=np.float32)

    def groove_distance(self, pitch_m: float) -> Map:
        """(1, W) metres to the nearest of upright lines `pitch_m` apart, fitted to the width of the picture."""
        pitch = self.tile_m[0] / max(1, round(self.tile_m[0] / pitch_m))
        return np.asarray(np.abs(np.mod(self.axes()[0] / pitch + 0.5, 1.0) - 0.5) * pitch, dtype=np.float32)


@dataclass(frozen=True)
class Layers:
    """One painted picture; row 0 is its upper edge.

    Attributes:
        albedo: (H, W, 3) float32, sRGB 0..1.
        height_m: (H, W) float32, metres above a plane, out of the surface.
        roughness: (H, W) float32, 0..1.
        metallic: 0..1, of the whole surface.
    """

    albedo: Map
    height_m: Map
    roughness: Map
    metallic: float = 0.0

    @classmethod
    def of(cls, albedo: Map, height_m: Map, roughness: Map, metallic: float = 0.0) -> Layers:
        """Layers with colours and roughness kept within bounds, in single precision."""
        return cls(
            np.clip(albedo, 0.0, 1.0).astype(np.float32),
            height_m.astype(np.float32),
            np.clip(roughness, 0.04, 1.0).astype(np.float32),
            metallic,
        )

    @property
    def transposed(self) -> Layers:
        """The picture with x and y swapped."""
        return Layers(
            np.ascontiguousarray(self.albedo.swapaxes(0, 1)),
            np.ascontiguousarray(self.height_m.T),
            np.ascontiguousarray(self.roughness.T),
            self.metallic,
        )


def rgb(color: str) -> Map:
    """(3,) sRGB 0..1 of `#rrggbb`."""
    return np.array(srgb_from_hex(color), dtype=np.float32)


def rgb_table(colors: Iterable[str]) -> Map:
    """(N, 3) sRGB 0..1 of N colours `#rrggbb`."""
    return np.stack([rgb(color) for color in colors])


def blend(image: Map, color: Map, share: Map) -> Map:
    """(H, W, 3) colours moved to others, (3,) or of each pixel, by a (H, W) share: 0 keeps `image`, 1 gives `color`."""
    return np.asarray(image + (color - image) * share[..., None])


def standardize(image: Map) -> Map:
    """The image shifted and scaled to mean 0 and deviation 1."""
    return np.asarray((image - image.mean()) / max(float(image.std()), 1e-6), dtype=np.float32)


def smoothstep(low: float | Map, high: float | Map, value: Map) -> Map:
    """0 at `low` and below, 1 at `high` and above, smooth between."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), dtype=np.float32)


def periodic_curve(at: Map, length: float, step: float, rng: np.random.Generator) -> Map:
    """Smooth periodic function of one coordinate, about -1..1, with a bend every `step` of its `length`."""
    count = max(2, round(length / step))
    knots = rng.uniform(-1.0, 1.0, count).astype(np.float32)
    where = np.mod(at / np.float32(length), 1.0) * count - 0.5
    return np.asarray(ndimage.map_coordinates(knots, [where], order=3, mode="grid-wrap"), dtype=np.float32)


def line_coverage(off_m: Map, width_m: float, pixel_m: float) -> Map:
    """Share of each pixel that a line covers `off_m` metres from its middle, so that thin lines are paler, not lost."""
    near = np.maximum(-width_m / 2.0, off_m - pixel_m / 2.0)
    far = np.minimum(width_m / 2.0, off_m + pixel_m / 2.0)
    return np.asarray(np.clip(far - near, 0.0, None) / pixel_m, dtype=np.float32)


def stratified(count: int, rng: np.random.Generator) -> Map:
    """(count,) values in even steps from -1 to 1 in random order: no draw comes out higher than another on average."""
    return np.asarray(rng.permutation(np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1)))


SIZE_PX = 1024  # of the longer side of a picture


@dataclass(frozen=True)
class TextureKind:
    """Kind of texture: its name, the type of its parameters, and its painter.

    Attributes:
        name: as recipes call it.
        params: Record type of what a recipe may set.
        paint: (params, canvas, rng) -> Layers. The picture repeats without a seam in both directions, and depends on
            the numbers and the generator alone: another size in pixels shows the same design.
        printed_lines: (params, size of the picture) -> its lines of letters, which a check tries to read.
    """

    name: str
    params: Any
    paint: Callable[[Any, Canvas, np.random.Generator], Layers]
    printed_lines: Callable[[Any, Size], Sequence[PrintedLine]] | None = None


def paint(kind: TextureKind, recipe: TextureRecipe, size_px: int = SIZE_PX) -> Layers:
    """Paint a recipe of a kind; the longer side has `size_px` pixels."""
    width, height = recipe.tile_m
    longest = max(width, height)
    size = (max(8, round(size_px * height / longest)), max(8, round(size_px * width / longest)))
    params = kind.params.from_json(recipe.params)
    return kind.paint(params, Canvas(size, recipe.tile_m), rng_for(recipe.seed, f"textures/{recipe.kind}"))
