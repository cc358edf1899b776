"""Measure what is free in a space: the largest box that fits, and how many small things."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.core.typing import Floats, Mask
from casa_assets.layouts.lived_in.spaces import Space, box_in_world

CELL_M = 0.01
THING_M, THING_GAP_M = 0.1, 0.02


def free_cells(space: Space) -> Mask:
    """(X, Y) which cells of `CELL_M` of a space's floor are free over its whole height, from its left front corner."""
    width, depth, _ = space.size
    counts = [max(1, math.floor(side / CELL_M + 1e-6)) for side in (width, depth)]
    x, y = (-side / 2 + (np.arange(n) + 0.5) * CELL_M for side, n in zip((width, depth), counts, strict=True))
    free = np.ones(counts, dtype=bool)
    half = CELL_M / 2 - 1e-6  # what ends where a cell begins takes none of it
    for x0, y0, x1, y1 in space.taken:
        over_x, over_y = (x + half > x0) & (x - half < x1), (y + half > y0) & (y - half < y1)
        free &= ~(over_x[:, None] & over_y[None, :])
    if space.is_round:
        free &= np.hypot(np.abs(x)[:, None] + half, np.abs(y)[None, :] + half) <= width / 2
    return free


def largest_box(space: Space) -> tuple[tuple[float, float, float], tuple[float, float]]:
    """Size of the box over the largest free rectangle of the floor, and its middle in the frame of the space, metres.

    The height is that of the space. The size is zero if nothing is free.
    """
    free = free_cells(space)
    best, found = 0, (0, 0, 0, 0)
    runs = np.zeros(free.shape[1], dtype=int)
    for i, row in enumerate(free):
        runs = np.where(row, runs + 1, 0)
        area, (start, end, length) = _largest_under([*runs.tolist(), 0])
        if area > best:
            best, found = area, (i + 1 - length, start, i + 1, end)
    i0, j0, i1, j1 = found
    width, depth, height = space.size
    size = ((i1 - i0) * CELL_M, (j1 - j0) * CELL_M, height if best else 0.0)
    return size, ((i0 + i1) / 2 * CELL_M - width / 2, (j0 + j1) / 2 * CELL_M - depth / 2)


def _largest_under(heights: list[int]) -> tuple[int, tuple[int, int, int]]:
    """Area of the largest rectangle under a histogram that ends in 0, and its first column, the one after, its height.

    Columns that may still grow to the right are kept on a stack, each with where it begins, the lowest first.
    """
    best, found = 0, (0, 0, 0)
    growing: list[tuple[int, int]] = []
    for j, height in enumerate(heights):
        start = j
        while growing and growing[-1][1] >= height:
            start, tall = growing.pop()
            if tall * (j - start) > best:
                best, found = tall * (j - start), (start, j, tall)
        growing.append((start, height))
    return best, found


def count_of_things(space: Space) -> int:
    """Number of 10 cm cubes that fit on its floor in rows, 2 cm apart; 0 if it is lower than a cube, 1 for a site."""
    if space.size[2] < THING_M:
        return 0
    if space.is_site:
        return 1
    free = free_cells(space)
    side, pitch = round(THING_M / CELL_M), round((THING_M + THING_GAP_M) / CELL_M)
    count, j = 0, 0
    while j + side <= free.shape[1]:
        i, row = 0, 0
        while i + side <= free.shape[0]:
            if free[i : i + side, j : j + side].all():
                row, i = row + 1, i + pitch
            else:
                i += 1
        count += row
        j += pitch if row else 1
    return count


def world_bounds(space: Space) -> Floats:
    """(2, 3) bounds of a space in the world, metres."""
    width, depth, height = space.size
    box = np.array([(-width / 2, -depth / 2, 0.0), (width / 2, depth / 2, height)])
    return box_in_world(space.pose, box)
