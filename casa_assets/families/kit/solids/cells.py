"""Slabs of upright rectangles: a wall with openings, a floor round a corner; a grid of cells of which some are solid.

All faces share the grid's points, so that no edge ends within another one and no crack shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.model.record import Vec2

Rectangle = tuple[Vec2, Vec2]

# Lengths are rounded to a micrometre, so that sums that should be equal make one line of the grid.
LINE_DECIMALS = 6
FRONT_FACES, BACK_FACES, RIM_FACES = 0, 1, 2


@dataclass(frozen=True)
class Cells:
    """A grid in a plane. us: (M + 1,) and vs: (N + 1,) lines, metres, rising. solid: (M, N) which cells are there."""

    us: Floats
    vs: Floats
    solid: Mask

    @property
    def area(self) -> float:
        """Area of all solid cells, m^2."""
        return float((np.outer(np.diff(self.us), np.diff(self.vs)) * self.solid).sum())

    @property
    def perimeter(self) -> float:
        """Length of the borders between solid cells and what is not solid, metres."""
        padded = np.pad(self.solid, 1).astype(np.int64)
        across = np.abs(np.diff(padded, axis=0))[:, 1:-1]
        along = np.abs(np.diff(padded, axis=1))[1:-1]
        return float((across * np.diff(self.vs)).sum() + (along.T * np.diff(self.us)).sum())

    @property
    def touches_at_a_point(self) -> bool:
        """True where two solid cells meet only at a corner, which would make the slab non-manifold."""
        s = self.solid
        a, b, c, d = s[:-1, :-1], s[1:, :-1], s[:-1, 1:], s[1:, 1:]
        return bool(((a & d & ~b & ~c) | (b & c & ~a & ~d)).any())


def with_holes(lower: Vec2, upper: Vec2, holes: Sequence[Rectangle], us: Sequence[float], vs: Sequence[float]) -> Cells:
    """A rectangle without those in `holes`; `us` and `vs` are more lines that the grid shall have. Metres."""
    u = _lines([lower[0], upper[0], *us, *(p[0] for hole in holes for p in hole)], lower[0], upper[0])
    v = _lines([lower[1], upper[1], *vs, *(p[1] for hole in holes for p in hole)], lower[1], upper[1])
    mid_u, mid_v = (u[:-1] + u[1:]) / 2, (v[:-1] + v[1:]) / 2
    solid = np.ones((len(mid_u), len(mid_v)), dtype=bool)
    for a, b in holes:
        solid &= ~np.outer((mid_u > a[0]) & (mid_u < b[0]), (mid_v > a[1]) & (mid_v < b[1]))
    return Cells(u, v, solid)


def cells_inside(outline: Sequence[Vec2]) -> Cells:
    """The inside of a polygon whose sides run along u and v, either way round. Metres."""
    points = np.round(np.array(outline, dtype=np.float64), LINE_DECIMALS)
    u, v = (np.unique(points[:, k]).astype(np.float64) for k in (0, 1))
    mid_u, mid_v = (u[:-1] + u[1:]) / 2, (v[:-1] + v[1:]) / 2
    solid = np.zeros((len(mid_u), len(mid_v)), dtype=bool)
    for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
        if a[0] == b[0]:  # a ray towards -u crosses it
            lower, upper = sorted((a[1], b[1]))
            solid ^= np.outer(mid_u > a[0], (mid_v > lower) & (mid_v < upper))
    return Cells(u, v, solid)


def rectangles(cells: Cells) -> list[Rectangle]:
    """Few rectangles that fill the solid cells without overlap: lower and upper corners, metres.

    Borders of holes are run on until they meet another border, upright or level, whichever makes fewer pieces: at most
    three for each hole and one more. Ref: vertical decomposition, de Berg et al., Computational Geometry, chapter 6.
    """
    upright = _strips(cells)
    level = [((b, a), (d, c)) for (a, b), (c, d) in _strips(Cells(cells.vs, cells.us, cells.solid.T))]
    return upright if len(upright) <= len(level) else level


def _strips(cells: Cells) -> list[Rectangle]:
    """Pieces as high as they can be, joined sideways where neighbours have the same ends."""
    finished: list[Rectangle] = []
    growing: dict[tuple[int, int], int] = {}
    for i, column in enumerate(cells.solid):
        steps = np.diff(np.concatenate([[0], column.astype(np.int64), [0]]))
        runs = list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))
        finished += [_corners(cells, begin, i, run) for run, begin in growing.items() if run not in runs]
        growing = {run: growing.get(run, i) for run in runs}
    finished += [_corners(cells, begin, len(cells.solid), run) for run, begin in growing.items()]
    return sorted(finished)


def _corners(cells: Cells, begin: int, end: int, run: tuple[int, int]) -> Rectangle:
    u, v = cells.us, cells.vs
    return (float(u[begin]), float(v[run[0]])), (float(u[end]), float(v[run[1]]))


@dataclass(frozen=True)
class Shell:
    """The surface of a slab of cells.

    Attributes:
        points: (P, 3) u, v, w in metres. faces: (F, 3), outwards.
        side: (F,) FRONT_FACES (at the lower w), BACK_FACES or RIM_FACES. cell: (F, 2) the cell of each face.
    """

    points: Floats
    faces: Ints
    side: Ints
    cell: Ints

    def solid(self, mask: Mask | None = None) -> Solid:
        """All faces, or some: then the surface is open, to be drawn but not weighed."""
        faces = self.faces if mask is None else self.faces[mask]
        used, index = np.unique(faces, return_inverse=True)
        return Solid(self.points[used], index.reshape(-1, 3).astype(np.int64), crease_deg=35.0)

    def upright(self) -> Shell:
        """The surface as an upright wall: u along x, v along z, w along y."""
        return Shell(self.points[:, [0, 2, 1]], self.faces[:, ::-1], self.side, self.cell)


def cell_shell(cells: Cells, lower: float, upper: float) -> Shell:
    """The surface of the solid cells between w = low and w = high, metres."""
    m, n = len(cells.us), len(cells.vs)
    u, v = np.meshgrid(cells.us, cells.vs, indexing="ij")
    layer = np.stack([u.ravel(), v.ravel()], axis=1)
    points = np.concatenate([np.column_stack([layer, np.full(m * n, w)]) for w in (lower, upper)])
    padded = np.pad(cells.solid, 1)
    faces: list[tuple[int, int, int]] = []
    side: list[int] = []
    cell: list[tuple[int, int]] = []
    for i, j in np.argwhere(cells.solid).tolist():
        ring = (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1)
        a, b, c, d = ring
        top = m * n
        faces += [(a, c, b), (a, d, c), (a + top, b + top, c + top), (a + top, c + top, d + top)]
        side += [FRONT_FACES, FRONT_FACES, BACK_FACES, BACK_FACES]
        beside = (padded[i + 1, j], padded[i + 2, j + 1], padded[i + 1, j + 2], padded[i, j + 1])
        for k, filled in enumerate(beside):
            if not filled:
                p, q = ring[k], ring[(k + 1) % 4]
                faces += [(p, q, q + top), (p, q + top, p + top)]
                side += [RIM_FACES, RIM_FACES]
        cell += [(i, j)] * (len(faces) - len(cell))
    return Shell(points, np.array(faces, dtype=np.int64), np.array(side), np.array(cell))


def _lines(values: Sequence[float], lower: float, upper: float) -> Floats:
    lines = np.unique(np.round(np.array(values, dtype=np.float64), LINE_DECIMALS))
    return np.asarray(
        lines[(lines >= round(lower, LINE_DECIMALS)) & (lines <= round(upper, LINE_DECIMALS))], dtype=np.float64
    )
