"""A periodic Voronoi map of jittered seeds, for crystals, chips and dimples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.textures.canvas import Canvas, Map

Ids = npt.NDArray[np.intp]


@dataclass(frozen=True)
class VoronoiCells:
    """Nearest seed of every pixel, each array (H, W).

    Distances to seeds are measured with the cells scaled to squares of side `size_m`: they are metres along y, and
    metres along x as well if cells are as wide as high (stretch 1).

    Attributes:
        count: number of cells.
        id: 0..count-1, of the nearest seed.
        near_m, second_m: distance to the nearest and to the second nearest seed.
        dx_m, dy_m: metres along x and y from the nearest seed to the pixel.
        size_m: height of a cell of the grid in which the seeds are placed, metres.
    """

    count: int
    id: Ids
    near_m: Map
    second_m: Map
    dx_m: Map
    dy_m: Map
    size_m: float

    @property
    def border_m(self) -> Map:
        """(H, W) approximate distance to the border of the cell, scaled as `near_m` is."""
        return (self.second_m - self.near_m) / np.float32(2.0)

    def random_per_cell(self, rng: np.random.Generator) -> Map:
        """(H, W) one uniform number 0..1 for each cell."""
        return rng.uniform(0.0, 1.0, self.count).astype(np.float32)[self.id]


def voronoi_cells(
    canvas: Canvas, size_m: float, rng: np.random.Generator, stretch: float = 1.0, bend_m: float = 0.0
) -> VoronoiCells:
    """Assign every pixel of the canvas to the nearest jittered seed, periodically.

    Args:
        canvas: pixels and metres.
        size_m: usual size of a cell along y.
        rng: draws the seeds.
        stretch: how much longer cells are along x.
        bend_m: how far borders are bent, metres.
    """
    rows, columns = canvas.cells(size_m, size_m * stretch)
    tall, wide = canvas.tile_m[1] / rows, canvas.tile_m[0] / columns
    # Seeds keep 0.08 of a cell away from its sides, so that seeds of neighbouring cells do not coincide.
    seed_y, seed_x = rng.uniform(0.08, 0.92, (2, rows, columns)).astype(np.float32)
    x, y = canvas.axes()
    if bend_m > 0:
        x = x + bend_m * canvas.noise(size_m * 0.7, size_m * 0.7 * stretch, rng)
        y = y + bend_m * canvas.noise(size_m * 0.7, size_m * 0.7 * stretch, rng)
    x, y = np.broadcast_arrays(x / np.float32(wide), y / np.float32(tall))
    column, row = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    nearest2 = np.full(canvas.size_px, np.inf, dtype=np.float32)
    second2, best_x, best_y = nearest2.copy(), nearest2.copy(), nearest2.copy()
    ids = np.zeros(canvas.size_px, dtype=np.intp)
    # Each cell of the grid has one seed; only those of the pixel's own cell and of the 8 around it are looked at.
    for step in range(9):
        r, c = row + step // 3 - 1, column + step % 3 - 1
        cell = np.mod(r, rows) * columns + np.mod(c, columns)
        dx = x - c - seed_x.ravel()[cell]
        dy = y - r - seed_y.ravel()[cell]
        distance2 = dx * dx + dy * dy
        closer = distance2 < nearest2
        second2 = np.where(closer, nearest2, np.minimum(second2, distance2))
        nearest2, ids = np.where(closer, distance2, nearest2), np.where(closer, cell, ids)
        best_x, best_y = np.where(closer, dx, best_x), np.where(closer, dy, best_y)
    scale = np.float32(tall)
    return VoronoiCells(
        count=rows * columns,
        id=ids,
        near_m=np.sqrt(nearest2) * scale,
        second_m=np.sqrt(second2) * scale,
        dx_m=best_x * np.float32(wide),
        dy_m=best_y * scale,
        size_m=tall,
    )
