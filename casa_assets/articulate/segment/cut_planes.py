"""Cut triangles along bounded planes and interpolate vertex attributes at the new points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.segment.fragment_measures import SIDES
from casa_assets.core.typing import Floats, Ints
from casa_assets.model.asset.mesh import Mesh

# An edge is not cut nearer to its ends than this share of its length, which would leave slivers.
MIN_END_SHARE = 1e-4
# Planes reach this far beyond their limits, diagonals, so that two that meet leave no edge between them uncut.
PLANE_OVERLAP = 1e-6


@dataclass(frozen=True)
class CutPlane:
    """A bounded cutting plane: the rectangle on which one of (right, up, depth) of a side has a given value.

    Attributes:
        side: of SIDES. axis: 0, 1 or 2 of its (right, up, depth). at: the value there.
        lower, upper: (3,) limits in (right, up, depth); those along `axis` do not count.
    """

    side: int
    axis: int
    at: float
    lower: Floats
    upper: Floats


@dataclass(frozen=True)
class CutTriangles:
    """Triangles after cutting.

    Attributes:
        new_points: for each plane that cut: (a, b, share) of its new points, each `a + share * (b - a)`; they are
            numbered on from the last point.
        faces: (F', 3). parent: (F',) triangle of which each is a part, ascending.
    """

    new_points: tuple[tuple[Ints, Ints, Floats], ...]
    faces: Ints
    parent: Ints

    def interpolate(self, values: Floats) -> Floats:
        """Return (P', k) values at the old and the new points, from (P, k) values at the old ones."""
        out = values
        for a, b, share in self.new_points:
            out = np.concatenate([out, out[a] + share[:, None] * (out[b] - out[a])])
        return out

    def interpolate_mesh(self, mesh: Mesh, faces: Ints) -> Mesh:
        """Return a mesh with other faces over its old and the new points, every vertex attribute interpolated."""
        normals, colors = mesh.normals, mesh.colors
        if normals is not None:
            normals = self.interpolate(normals)
            normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        return Mesh(
            vertices=self.interpolate(mesh.vertices),
            faces=faces.astype(np.int32),
            uv=None if mesh.uv is None else self.interpolate(mesh.uv),
            normals=normals,
            colors=None if colors is None else np.rint(self.interpolate(colors.astype(np.float64))).astype(np.uint8),
        )


def cut_triangles(points: Floats, faces: Ints, planes: Sequence[CutPlane]) -> CutTriangles:
    """Cut triangles wherever an edge meets a plane; triangles that share an edge share the new point.

    Args:
        points: (P, 3) in the frame. faces: (F, 3).
    """
    made: list[tuple[Ints, Ints, Floats]] = []
    parent = np.arange(len(faces))
    for plane in planes:
        found = _cut(points, faces, plane)
        if found is None:
            continue
        (a, b, share), faces, kept = found
        points = np.concatenate([points, points[a] + share[:, None] * (points[b] - points[a])])
        parent = parent[kept]
        made.append((a, b, share))
    order = np.argsort(parent, kind="stable")
    return CutTriangles(tuple(made), faces[order], parent[order])


def _cut(points: Floats, faces: Ints, plane: CutPlane) -> tuple[tuple[Ints, Ints, Floats], Ints, Ints] | None:
    """Return new points, triangles, and the parent of each triangle; None if the plane cuts nothing.

    New points are given by the ends (a, b) of the edges that they lie on, and their share of the way from a to b.
    """
    axes = SIDES[plane.side]
    level = points @ axes[plane.axis] - plane.at
    over = level[faces] > 0
    near = np.flatnonzero(over.any(axis=1) & ~over.all(axis=1))
    ends = np.sort(np.concatenate([faces[near][:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    ends, place = np.unique(ends, axis=0, return_inverse=True)
    a, b = ends[:, 0], ends[:, 1]
    fall = level[b] - level[a]
    share = np.where(np.abs(fall) > 1e-15, -level[a] / np.where(fall == 0, 1.0, fall), -1.0)
    at = (points[a] + share[:, None] * (points[b] - points[a])) @ axes.T
    others = [i for i in range(3) if i != plane.axis]
    inside = ((at >= plane.lower - PLANE_OVERLAP) & (at <= plane.upper + PLANE_OVERLAP))[:, others].all(axis=1)
    good = inside & (share > MIN_END_SHARE) & (share < 1 - MIN_END_SHARE)
    if not good.any():
        return None
    number = np.full(len(ends), -1, dtype=np.int64)
    number[good] = len(points) + np.arange(int(good.sum()))
    middle = number[place.reshape(3, -1).T]
    fresh, kept = _pieces(faces[near], middle)
    rest = np.ones(len(faces), dtype=bool)
    rest[near] = False
    whole = np.flatnonzero(rest)
    return (
        (a[good], b[good], share[good]),
        np.concatenate([faces[whole], fresh]),
        np.concatenate([whole, near[kept]]),
    )


def _pieces(faces: Ints, middle: Ints) -> tuple[Ints, Ints]:
    """Split triangles at the points on their edges (-1 for none; at most two have one); also return their parents."""
    count = (middle >= 0).sum(axis=1)
    none = np.flatnonzero(count == 0)
    one = np.flatnonzero(count == 1)
    two = np.flatnonzero(count == 2)
    p, m = _turned(faces[one], middle[one], np.argmax(middle[one] >= 0, axis=1) if len(one) else one)
    single = [np.stack([p[:, 0], m[:, 0], p[:, 2]], axis=1), np.stack([m[:, 0], p[:, 1], p[:, 2]], axis=1)]
    # Turn those with two so that the edge without a point comes last: the corner between the cut edges is the second.
    bare = (np.argmin(middle[two], axis=1) + 1) % 3 if len(two) else two
    q, n = _turned(faces[two], middle[two], bare)
    double = [
        np.stack([n[:, 0], q[:, 1], n[:, 1]], axis=1),
        np.stack([q[:, 0], n[:, 0], n[:, 1]], axis=1),
        np.stack([q[:, 0], n[:, 1], q[:, 2]], axis=1),
    ]
    return np.concatenate([faces[none], *single, *double]), np.concatenate([none, one, one, two, two, two])


def _turned(faces: Ints, middle: Ints, first: Ints) -> tuple[Ints, Ints]:
    """Renumber corners and edge points from another first corner; edge i runs from corner i to the next."""
    order = (np.asarray(first)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(faces, order, axis=1), np.take_along_axis(middle, order, axis=1)
