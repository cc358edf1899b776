"""Voronoi cells of jittered seeds on a torus: crystals, chips, dimples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.textures.canvas import Canvas, Map

Ids = npt.NDArray[np.intp]


@dataclass(frozen=True)
class CrystalCells:
    """Nearest seed of every pixel, each array (H, W).

    Attributes:
        count: number of cells.
        id: 0..count-1, of the nearest seed.
        near_m, second_m: metres to the nearest and to the second nearest seed.
        dx_m, dy_m: metres from the nearest seed to the pixel.
        size_m: side of a cell if all were squares.
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
        """(H, W) about the metres to the border of the cell."""
        return (self.second_m - self.near_m) / np.float32(2.0)

    def draw(self, rng: np.random.Generator) -> Map:
        """(H, W) one uniform number 0..1 for each cell."""
        return rng.uniform(0.0, 1.0, self.count).astype(np.float32)[self.id]


def crystal_cells(
    canvas: Canvas, size_m: float, rng: np.random.Generator, stretch: float = 1.0, bend_m: float = 0.0
) -> CrystalCells:
    """Assign every pixel of the sheet to the nearest jittered seed, periodically.

    Args:
        sheet: pixels and metres.
        size_m: usual size of a cell along y.
        rng: draws the seeds.
        stretch: how much longer cells are along x.
        bend_m: how far borders are bent, metres.
    """
    rows, columns = canvas.cells(size_m, size_m * stretch)
    tall, wide = canvas.tile_m[1] / rows, canvas.tile_m[0] / columns
    seed_y, seed_x = rng.uniform(0.08, 0.92, (2, rows, columns)).astype(np.float32)
    x, y = canvas.axes()
    if bend_m > 0:
        x = x + bend_m * canvas.noise(size_m * 0.7, size_m * 0.7 * stretch, rng)
        y = y + bend_m * canvas.noise(size_m * 0.7, size_m * 0.7 * stretch, rng)
    x, y = np.broadcast_arrays(x / np.float32(wide), y / np.float32(tall))
    column, row = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    near = np.full(canvas.size_px, np.inf, dtype=np.float32)
    second, best_x, best_y = near.copy(), near.copy(), near.copy()
    ids = np.zeros(canvas.size_px, dtype=np.intp)
    for step in range(9):
        r, c = row + step // 3 - 1, column + step % 3 - 1
        id_ = np.mod(r, rows) * columns + np.mod(c, columns)
        dx = x - c - seed_x.ravel()[id_]
        dy = y - r - seed_y.ravel()[id_]
        far = dx * dx + dy * dy
        closer = far < near
        second = np.where(closer, near, np.minimum(second, far))
        near, ids = np.where(closer, far, near), np.where(closer, id_, ids)
        best_x, best_y = np.where(closer, dx, best_x), np.where(closer, dy, best_y)
    scale = np.float32(tall)
    return CrystalCells(
        count=rows * columns,
        id=ids,
        near_m=np.sqrt(near) * scale,
        second_m=np.sqrt(second) * scale,
        dx_m=best_x * np.float32(wide),
        dy_m=best_y * scale,
        size_m=tall,
    )
