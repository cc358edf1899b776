"""Stones that nature shaped: fieldstone from a jittered net, ledges of split strips."""

from __future__ import annotations

import numpy as np

from casa_assets.textures import noise
from casa_assets.textures.canvas import Canvas
from casa_assets.textures.laying.pieces import PieceMap, PlacedOutline, box, raster, whole


def fieldstone(canvas: Canvas, width: float, height: float, rng: np.random.Generator) -> PieceMap:
    """Irregular round stones of about this size, metres; `inside_m` is the distance to the border between two."""
    rows, columns = canvas.cells(height, width)
    rows += rows % 2
    off = 0.78 * (rng.random((2, rows, columns)) - 0.5)
    size = rng.uniform(0.75, 1.25, (rows, columns)).astype(np.float32)
    bend = np.float32(0.05 * min(width, height))
    x, y = canvas.axes()
    x = x + bend * canvas.noise(0.5 * height, 0.5 * width, rng)
    y = y + bend * canvas.noise(0.5 * height, 0.5 * width, rng)
    wide, tall = canvas.tile_m[0] / columns, canvas.tile_m[1] / rows
    row, column = np.floor(y / tall).astype(np.int64), np.floor(x / wide).astype(np.int64)
    first = np.full(canvas.size_px, 9.0, dtype=np.float32)
    second, owner = first.copy(), np.zeros(canvas.size_px, dtype=np.int32)
    us, vs = np.zeros_like(first), np.zeros_like(first)
    for down in (-2, -1, 0, 1, 2):
        for right in (-2, -1, 0, 1, 2):
            r, c = row + down, column + right
            at = (r % rows, c % columns)
            dx = x - ((c + 0.5 + off[0][at] + 0.5 * (r % 2)) * wide).astype(np.float32)
            dy = y - ((r + 0.5 + off[1][at]) * tall).astype(np.float32)
            gap = np.sqrt((dx / wide) ** 2 + (dy / tall) ** 2) / size[at]
            closer = gap < first
            second = np.where(closer, first, np.minimum(second, gap))
            owner = np.where(closer, (at[0] * columns + at[1]).astype(np.int32), owner)
            us, vs = np.where(closer, dx, us), np.where(closer, dy, vs)
            first = np.where(closer, gap, first)
    count = rows * columns
    number = np.arange(count)
    inside = 0.5 * (second - first) * np.float32(min(wide, tall))
    return PieceMap(
        owner=owner,
        inside_m=noise.blur(inside.astype(np.float32), 0.0015 / canvas.pixel_m),
        u_m=us.astype(np.float32),
        v_m=vs.astype(np.float32),
        turn=np.zeros(count),
        sort=number % 3,
        x_m=((number % columns) + 0.5) * wide,
        y_m=((number // columns) + 0.5) * tall,
        half_m=np.broadcast_to(np.array([wide / 2, tall / 2]), (count, 2)),
    )


def ledges(canvas: Canvas, width: float, length: float, rng: np.random.Generator) -> PieceMap:
    """Strips of split stone in courses of a third to one `width`, about `length` long, metres."""
    wide, tall = canvas.tile_m
    units, unit = whole(tall, width / 3)
    heights: list[int] = []
    while sum(heights) < units:
        heights.append(min(int(rng.choice((1, 2, 2, 3))), units - sum(heights)))
    places: list[PlacedOutline] = []
    top = 0.0
    for height in heights:
        count = max(2, round(wide / (length * rng.uniform(0.75, 1.25))))
        parts = rng.uniform(0.45, 1.55, count)
        ends = (rng.random() + np.concatenate([[0.0], np.cumsum(parts / parts.sum())])) * wide
        for n in range(count):
            half_v, half_u = (ends[n + 1] - ends[n]) / 2, height * unit / 2
            x, y = (ends[n] + half_v) % wide, top + half_u
            places.append(PlacedOutline(x, y, np.pi / 2, half_u, half_v, box(half_u, half_v), height))
        top += height * unit
    return raster(places, canvas)
