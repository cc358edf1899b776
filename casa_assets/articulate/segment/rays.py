"""Intersect axis-parallel lines with triangles and say from which side each face is met."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.typing import Floats, Ints

# Faces that are intersected at once: bounds memory and does not change the result.
CHUNK = 20_000
# Crossings nearer to each other than this are one sheet, diagonals.
SAME_SHEET = 0.002


@dataclass(frozen=True)
class RayCrossings:
    """Crossings of lines with triangles, line by line, sorted along their axis.

    Attributes:
        line: (N,) which line. at: (N,) coordinate along the axis, ascending for each line.
        towards: (N,) 1 where the face looks along the axis, -1 where it looks against it. face: (N,) index.
        count: how many lines there are.
    """

    line: Ints
    at: Floats
    towards: Floats
    face: Ints
    count: int

    def select(self, rows: Bools) -> RayCrossings:
        """Return some of the crossings."""
        return RayCrossings(self.line[rows], self.at[rows], self.towards[rows], self.face[rows], self.count)

    def first(self) -> Floats:
        """Return the (L,) smallest coordinate of each line, inf for none."""
        out = np.full(self.count, np.inf)
        np.minimum.at(out, self.line, self.at)
        return out

    def last(self) -> Floats:
        """Return the (L,) largest coordinate of each line, -inf for none."""
        out = np.full(self.count, -np.inf)
        np.maximum.at(out, self.line, self.at)
        return out

    def beyond(self, start: float, sign: float) -> tuple[Floats, Bools]:
        """Return the distance to the first sheet from a coordinate along the axis (1) or against it (-1).

        Returns:
            (L,) way to the first sheet, inf for none, and (L,) whether a face of it looks at who comes.
        """
        way = (self.at - start) * sign
        rows = way >= 0.0
        near = np.full(self.count, np.inf)
        np.minimum.at(near, self.line[rows], way[rows])
        meets = rows & (way <= near[self.line] + SAME_SHEET) & (self.towards * sign < 0)
        looks: Bools = np.zeros(self.count, dtype=bool)
        looks[self.line[meets]] = True
        return near, looks


def cross_rays(points: Floats, faces: Ints, axis: int, spots: Floats) -> RayCrossings:
    """Intersect triangles with lines along an axis.

    Args:
        points: (P, 3). faces: (F, 3). axis: 0, 1 or 2.
        spots: (L, 2) places of the lines: the other two coordinates, in their order.
    """
    a, b = (k for k in range(3) if k != axis)
    lines, depths, sides, owners = [], [], [], []
    for start in range(0, len(faces), CHUNK):
        corners = points[faces[start : start + CHUNK]]
        flat = corners[:, :, [a, b]]
        lower, upper = flat.min(axis=1), flat.max(axis=1)
        over = (lower[None] <= spots[:, None]).all(axis=2) & (spots[:, None] <= upper[None]).all(axis=2)
        line, face = np.nonzero(over)
        p, q, r = (flat[face, k] - spots[line] for k in range(3))
        u, v, w = _cross(q, r), _cross(r, p), _cross(p, q)
        total = u + v + w
        inside = (np.abs(total) > 1e-16) & (np.minimum(np.minimum(u, v), w) * np.sign(total) >= 0)
        line, face, total = line[inside], face[inside], total[inside]
        weight = np.stack([u[inside], v[inside], w[inside]], axis=1) / total[:, None]
        lines.append(line)
        depths.append((corners[face, :, axis] * weight).sum(axis=1))
        # Seen along y, right and up turn the other way round.
        sides.append(np.sign(total) * (-1.0 if axis == 1 else 1.0))
        owners.append(face + start)
    if not lines:
        none = np.empty(0)
        return RayCrossings(none.astype(np.int64), none, none, none.astype(np.int64), len(spots))
    line, at = np.concatenate(lines), np.concatenate(depths)
    order = np.lexsort((np.concatenate(owners), at, line))
    side, owner = np.concatenate(sides)[order], np.concatenate(owners)[order]
    return RayCrossings(line[order].astype(np.int64), at[order], side, owner.astype(np.int64), len(spots))


def _cross(p: Floats, q: Floats) -> Floats:
    """Return the (N,) cross products of 2D vectors."""
    found: Floats = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    return found


def sample_grid(lower: Floats, upper: Floats, count: int, inset: float = 0.0) -> Floats:
    """Return (count * count, 2) points that fill a rectangle evenly; `inset` of its size stays free on every side."""
    share = inset + (1 - 2 * inset) * (np.arange(count) + 0.5013) / count
    x, y = (lower[k] + share * (upper[k] - lower[k]) for k in (0, 1))
    found: Floats = np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2)
    return found
