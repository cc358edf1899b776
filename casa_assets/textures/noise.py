"""Noise on a torus: every picture repeats without a seam. Cells are (rows, columns); unequal ones stretch it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

Map = npt.NDArray[np.float32]
Size = tuple[int, int]


def gradient(size_px: Size, cells: Size, rng: np.random.Generator) -> Map:
    """(H, W) Perlin noise, about -0.7..0.7. Ref: K. Perlin, Improving Noise, 2002."""
    (height, width), (rows, columns) = size_px, cells
    turn = rng.uniform(0.0, 2.0 * np.pi, (rows, columns))
    slope_x, slope_y = np.cos(turn).astype(np.float32), np.sin(turn).astype(np.float32)
    y, x = _places(height, rows), _places(width, columns)
    row, column = np.floor(y).astype(np.int64), np.floor(x).astype(np.int64)
    fy, fx = (y - row).astype(np.float32)[:, None], (x - column).astype(np.float32)[None, :]
    u, v = _fade(fx), _fade(fy)

    def corner(down: int, right: int) -> Map:
        # What all pixels in a row of cells have in common is computed once, and whole rows are copied.
        across, cell = (column + right) % columns, (row + down) % rows
        along = (slope_x.take(across, axis=1) * (fx - right)).take(cell, axis=0)
        along += slope_y.take(across, axis=1).take(cell, axis=0) * (fy - down)
        return along

    upper = corner(0, 0) * (1 - u) + corner(0, 1) * u
    lower = corner(1, 0) * (1 - u) + corner(1, 1) * u
    return np.asarray(upper * (1 - v) + lower * v, dtype=np.float32)


def fbm(size_px: Size, cells: Size, rng: np.random.Generator, octaves: int = 5, gain: float = 0.5) -> Map:
    """(H, W) sum of octaves of gradient noise, about -1..1. Octaves finer than two pixels are drawn but left out."""
    total = np.zeros(size_px, dtype=np.float32)
    for k in range(octaves):
        finer = (cells[0] << k, cells[1] << k)
        lane = np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))
        if 2 * finer[0] > size_px[0] or 2 * finer[1] > size_px[1]:
            continue
        total += np.float32(gain**k) * gradient(size_px, finer, lane)
    return total


def ridged(size_px: Size, cells: Size, rng: np.random.Generator, octaves: int = 4, gain: float = 0.5) -> Map:
    """(H, W) in 0..1: sharp crests where the noise crosses zero, as veins have them."""
    total, weight = np.zeros(size_px, dtype=np.float32), 0.0
    for k in range(octaves):
        finer = (cells[0] << k, cells[1] << k)
        lane = np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))
        if 2 * finer[0] > size_px[0] or 2 * finer[1] > size_px[1]:
            continue
        total += np.float32(gain**k) * (1 - np.clip(np.abs(gradient(size_px, finer, lane)) * 2, 0, 1))
        weight += gain**k
    return np.asarray(total / np.float32(max(weight, 1e-6)), dtype=np.float32)


def worley(
    size_px: Size, cells: Size, rng: np.random.Generator, jitter: float = 0.9
) -> tuple[Map, Map, npt.NDArray[np.int32]]:
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
    nearest = np.full(size_px, 9.0, dtype=np.float32)
    second = np.full(size_px, 9.0, dtype=np.float32)
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


def blur(image: Map, sigma_px: float) -> Map:
    """Gaussian blur round the torus, channel by channel."""
    sigma = (sigma_px, sigma_px, 0.0)[: image.ndim]
    return np.asarray(ndimage.gaussian_filter(image, sigma, mode="wrap"), dtype=np.float32)


def _places(size: int, cells: int) -> npt.NDArray[np.float64]:
    return (np.arange(size) + 0.5) / size * cells


def _fade(t: Map) -> Map:
    return np.asarray(t * t * t * (t * (t * 6 - 15) + 10), dtype=np.float32)
