"""Numbers -> surfaces: lathe, tube, slab and box. Metres, z up, counter-clockwise seen from outside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Surface:
    """Triangles over shared vertices.

    Attributes:
        vertices: (V, 3) metres, z up.
        faces: (F, 3) indices, counter-clockwise seen from outside.
        uv: (V, 2), origin at the lower left of the image.
    """

    vertices: Array
    faces: Index
    uv: Array

    def moved(self, offset: tuple[float, float, float]) -> Surface:
        """The same surface, shifted, metres."""
        return Surface(self.vertices + np.array(offset), self.faces, self.uv)

    def turned(self, matrix: Array) -> Surface:
        """The same surface under a (3, 3) matrix; a mirror keeps the outside outside."""
        faces = self.faces[:, ::-1] if np.linalg.det(matrix) < 0 else self.faces
        return Surface(self.vertices @ matrix.T, faces, self.uv)

    def inside_out(self) -> Surface:
        """The same vertices with every triangle facing the other way."""
        return Surface(self.vertices, self.faces[:, ::-1], self.uv)


def joined(*surfaces: Surface) -> Surface:
    """One surface that holds all of them, unwelded."""
    starts = np.cumsum([0, *(len(s.vertices) for s in surfaces)])
    return Surface(
        np.concatenate([s.vertices for s in surfaces]),
        np.concatenate([s.faces + start for s, start in zip(surfaces, starts, strict=False)]),
        np.concatenate([s.uv for s in surfaces]),
    )


def rounded(corners: list[tuple[float, float]], radius: float, steps: int = 4) -> Array:
    """(N, 2) polyline with its inner corners cut by arcs (quadratic curves) of about `radius` metres."""
    points = np.array(corners, dtype=np.float64)
    out = [points[0]]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        a, b = before - corner, after - corner
        cut = min(radius, 0.49 * float(np.linalg.norm(a)), 0.49 * float(np.linalg.norm(b)))
        start, end = corner + a / np.linalg.norm(a) * cut, corner + b / np.linalg.norm(b) * cut
        for t in np.linspace(0.0, 1.0, steps + 1):
            out.append((1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t**2 * end)
    return np.array([*out, points[-1]])


def wall(curve: Array, thickness: float) -> Array:
    """(N, 2) closed lathe profile of a vessel: the curve (its outside, from the axis to the rim), a rim, and back."""
    tangent = np.gradient(curve, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    tangent[0] = (1.0, 0.0)  # level on the axis
    inner = curve + thickness * np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    rim = (curve[-1] + inner[-1]) / 2 + tangent[-1] * thickness / 2
    return np.concatenate([curve, rim[None], inner[::-1]])


def lathe(profile: Array, segments: int = 48, start: float = 0.0, turn: float = 2 * np.pi) -> Surface:
    """A profile turned about the z axis.

    Args:
        profile: (P, 2) radius and height, metres; outside is to the right of the way (upwards: away from the axis).
        segments: steps of the turn.
        start, turn: first angle and angle covered, radians.
    """
    angle = start + turn * np.arange(segments + 1) / segments
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if turn == 2 * np.pi:
        ring[-1] = ring[0]  # the seam has to close exactly
    points = np.concatenate(
        [
            profile[:, None, 0:1] * ring[None],
            np.broadcast_to(profile[:, None, 1:2], (len(profile), len(angle), 1)),
        ],
        axis=2,
    )
    steps = np.linalg.norm(np.diff(profile, axis=0), axis=1)
    v = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    return sheet(points, v)


def tube(path: Array, half_sizes: Array, side: tuple[float, float, float], sides: int = 14) -> Surface:
    """A closed elliptic tube along a path that lies in a plane.

    Args:
        path: (K, 3) centre line, metres.
        half_sizes: (K, 2) half width along `side` and half width across it, metres.
        side: normal of the plane of the path.
        sides: corners of a section.
    """
    across = np.array(side) / np.linalg.norm(side)
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    other = np.cross(tangent, across)
    angle = 2 * np.pi * np.arange(sides) / sides
    sections = (
        path[:, None]
        + half_sizes[:, None, 0:1] * np.cos(angle)[None, :, None] * across
        + half_sizes[:, None, 1:2] * np.sin(angle)[None, :, None] * other[:, None]
    )
    return loft(sections)


def loft(sections: Array) -> Surface:
    """(K, S, 3) closed sections, counter-clockwise about the way from first to last, joined and capped at both ends."""
    around = np.concatenate([sections, sections[:, :1]], axis=1)
    wall = sheet(around, np.linspace(0.0, 1.0, len(sections)))
    return joined(wall, _cap(sections[0][::-1]), _cap(sections[-1]))


def slab(outer: Array, inner: Array, heights: tuple[float, float], bevel: float) -> Surface:
    """A plate with a hole, bevelled outside; uv lies flat over its bounds.

    Args:
        outer, inner: (N, 2) outlines, counter-clockwise, point n of one facing point n of the other, metres.
        heights: bottom and top, metres.
        bevel: metres.
    """
    low, high = heights
    centre = outer.mean(axis=0)
    shrunk = centre + (outer - centre) * (1 - bevel / np.linalg.norm(outer - centre, axis=1, keepdims=True))
    levels = [(inner, low), (shrunk, low), (outer, low + bevel), (outer, high - bevel), (shrunk, high), (inner, high)]
    loops = [np.column_stack([line, np.full(len(line), z)]) for line, z in [*levels, levels[0]]]
    points = np.stack(loops)
    whole = sheet(np.concatenate([points, points[:, :1]], axis=1), np.linspace(0.0, 1.0, len(points)))
    low_corner, high_corner = outer.min(axis=0), outer.max(axis=0)
    return Surface(whole.vertices, whole.faces, (whole.vertices[:, :2] - low_corner) / (high_corner - low_corner))


def quad(corner: Array, right: Array, up: Array) -> Surface:
    """A rectangle seen from right x up, its lower left at `corner`, metres."""
    vertices = np.array([corner, corner + right, corner + right + up, corner + up])
    uv = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return Surface(vertices, np.array([[0, 1, 2], [0, 2, 3]]), uv)


def sheet(points: Array, v: Array) -> Surface:
    """(R, C, 3) grid of points as triangles; columns run along u, rows along v. Triangles without area are left out."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    vertices = points.reshape(-1, 3)
    corner = vertices[faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    u = np.linspace(0.0, 1.0, columns)
    uv = np.stack(np.broadcast_arrays(u[None, :], v[:, None]), axis=-1).reshape(-1, 2)
    return Surface(vertices, faces[area > 1e-12], uv)


def _cap(outline: Array) -> Surface:
    count = len(outline)
    vertices = np.concatenate([outline, outline.mean(axis=0, keepdims=True)])
    step = np.arange(count)
    faces = np.stack([step, (step + 1) % count, np.full(count, count)], axis=1)
    return Surface(vertices, faces, np.full((count + 1, 2), 0.5))
