"""Outlines of rooms, seen from above: polygons whose sides run along x and y, or some of them aslant."""

from __future__ import annotations

from enum import StrEnum

import manifold3d
import numpy as np

from casa_assets.ext.arrays import Floats, Ints, counter_clockwise, signed_area
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import Placed, blocks, box_shape, hull_around

Outline = tuple[Vec2, ...]
MIN_SIDE = 0.1  # metres
LENGTH_TOLERANCE = 1e-6


class LayDirection(StrEnum):
    """Direction that boards, and the height of any picture, run along."""

    X = "x"
    Y = "y"

    @property
    def vector(self) -> Vec3:
        """The direction as a unit vector."""
        return (1.0, 0.0, 0.0) if self is LayDirection.X else (0.0, 1.0, 0.0)


def outline_cells(outline: Outline) -> blocks.Cells:
    """The cells within a room's outline.

    outline: (x, y) corners in order, either way round, metres. Raises ValueError: a side runs aslant or is too short,
    or sides meet or cross elsewhere than at the corners.
    """
    points = np.array(outline, dtype=np.float64)
    if len(points) < 4:
        raise ValueError(f"an outline has four corners at least, not {len(points)}")
    run = np.roll(points, -1, axis=0) - points
    for k, (x, y) in enumerate(run):
        if min(abs(x), abs(y)) > LENGTH_TOLERANCE:
            raise ValueError(f"side {k} of the outline runs aslant: {x:g} by {y:g} m")
        if max(abs(x), abs(y)) < MIN_SIDE:
            raise ValueError(f"side {k} of the outline is shorter than {MIN_SIDE:g} m")
    grid = blocks.cells_inside(outline)
    perimeter = float(np.abs(run).sum())
    if (
        abs(grid.area - abs(signed_area(points))) > LENGTH_TOLERANCE * perimeter
        or abs(grid.perimeter - perimeter) > 1e-5
        or grid.touches_at_a_point
    ):
        raise ValueError("sides of the outline cross or touch each other")
    return grid


def is_rectilinear(outline: Outline) -> bool:
    """True if every side of an outline runs along x or y."""
    points = np.array(outline, dtype=np.float64)
    return bool((np.abs(np.roll(points, -1, axis=0) - points).min(axis=1) <= LENGTH_TOLERANCE).all())


def check_outline(outline: Outline) -> None:
    """Raise ValueError if an outline cannot be that of a room: a side is too short, or sides meet or cross."""
    if is_rectilinear(outline):
        outline_cells(outline)
        return
    loop = counter_clockwise(np.array(outline, dtype=np.float64))
    short = np.flatnonzero(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1) < MIN_SIDE)
    if len(short):
        raise ValueError(f"side {short[0]} of the outline is shorter than {MIN_SIDE:g} m")
    whole = manifold3d.CrossSection([loop], manifold3d.FillRule.NonZero)
    if abs(whole.area() - signed_area(loop)) > 1e-6 or whole.num_contour() != 1:
        raise ValueError("sides of the outline cross or touch each other")


def room_slab(outline: Outline, lower: float, upper: float) -> tuple[blocks.Shell, tuple[Placed, ...]]:
    """A horizontal slab over a whole room between two heights, metres. Raises ValueError as `check_outline` does.

    Returns: its surface, whose `side` distinguishes lower face, upper face and rim, and convex pieces that fill it.
    """
    if is_rectilinear(outline):
        grid = outline_cells(outline)
        shapes = tuple(box_shape((*lo, lower), (*hi, upper)) for lo, hi in blocks.rectangles(grid))
        return blocks.cell_shell(grid, lower, upper), shapes
    check_outline(outline)
    loop = outline_loop(outline)
    n = len(loop)
    triangles = np.asarray(manifold3d.triangulate([loop]), dtype=np.int64)
    points = np.concatenate([np.column_stack([loop, np.full(n, z)]) for z in (lower, upper)])
    ring = np.arange(n)
    after = np.roll(ring, -1)
    rim = np.concatenate([np.stack([ring, after, after + n], axis=1), np.stack([ring, after + n, ring + n], axis=1)])
    faces: Ints = np.concatenate([triangles[:, ::-1], triangles + n, rim])
    counts = [len(triangles), len(triangles), len(rim)]
    side = np.repeat([blocks.FRONT_FACES, blocks.BACK_FACES, blocks.RIM_FACES], counts)
    shell = blocks.Shell(points, faces, side, np.zeros((len(faces), 2), dtype=np.int64))
    pieces = convex_pieces(loop, triangles)
    hulls = [hull_around(np.concatenate([points[piece], points[[k + n for k in piece]]])) for piece in pieces]
    return shell, tuple(shape for hull in hulls for shape in hull.shapes)


def convex_pieces(loop: Floats, triangles: Ints) -> list[list[int]]:
    """Few convex polygons that fill a triangulated one: triangles, joined across a side where they stay convex.

    Ref: Hertel and Mehlhorn, Fast triangulation of simple polygons (1983).

    loop: (N, 2) corners, counter-clockwise. triangles: (T, 3) numbers of corners, counter-clockwise. Returns: numbers
    of the corners of each piece, counter-clockwise.
    """
    pieces = [list(map(int, t)) for t in triangles]
    joined = True
    while joined:
        joined = False
        for i in range(len(pieces)):
            for k in range(i + 1, len(pieces)):
                union = _union(pieces[i], pieces[k])
                if union is not None and _is_convex(loop[union]):
                    pieces[i], joined = union, True
                    del pieces[k]
                    break
            if joined:
                break
    return pieces


def _union(one: list[int], other: list[int]) -> list[int] | None:
    """Two counter-clockwise polygons joined across the side that they share, or None if they share no side."""
    for i, a in enumerate(one):
        b = one[(i + 1) % len(one)]
        if a in other and b in other and other[(other.index(b) + 1) % len(other)] == a:
            k = other.index(a)
            return [*one[: i + 1], *(other[(k + j) % len(other)] for j in range(1, len(other) - 1)), *one[i + 1 :]]
    return None


def _is_convex(points: Floats) -> bool:
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    return bool((before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > -LENGTH_TOLERANCE).all())


def outline_loop(outline: Outline) -> Floats:
    """(N, 2) corners, counter-clockwise, none within a straight side. Metres."""
    points: Floats = np.round(np.array(outline, dtype=np.float64), blocks.LINE_DECIMALS).astype(np.float64)
    points = counter_clockwise(points)
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    return np.asarray(points[np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) > LENGTH_TOLERANCE])


def interior_spans(grid: blocks.Cells, lower: float, upper: float) -> list[Vec2]:
    """(from, to) along u of what is inside over the whole breadth low..high of v, metres."""
    rows = (grid.vs[:-1] < upper - LENGTH_TOLERANCE) & (grid.vs[1:] > lower + LENGTH_TOLERANCE)
    steps = np.diff(np.concatenate([[0], grid.solid[:, rows].all(axis=1).astype(np.int64), [0]]))
    begins, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    return [(float(grid.us[a]), float(grid.us[b])) for a, b in zip(begins, ends, strict=True)]


def spans_inside(outline: Outline, direction: LayDirection, lower: float, upper: float) -> list[Vec2]:
    """(from, to) along a direction of what is inside an outline over a whole breadth across it, metres."""
    if is_rectilinear(outline):
        grid = outline_cells(outline)
        along = grid if direction is LayDirection.X else blocks.Cells(grid.vs, grid.us, grid.solid.T)
        return interior_spans(along, lower, upper)
    points = outline_loop(outline)[:, :: 1 if direction is LayDirection.X else -1]
    # Between two levels at which the outline has no corner its sides are straight.
    inner = points[(points[:, 1] > lower) & (points[:, 1] < upper), 1]
    spans = [(-np.inf, np.inf)]
    for level in (lower + LENGTH_TOLERANCE, *sorted(inner + LENGTH_TOLERANCE), upper - LENGTH_TOLERANCE):
        ends = np.roll(points, -1, axis=0)
        cross = (points[:, 1] > level) != (ends[:, 1] > level)
        a, b = points[cross], ends[cross]
        crossed = sorted((a[:, 0] + (level - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])).tolist())
        spans = [
            (max(a, c), min(b, d))
            for a, b in spans
            for c, d in zip(crossed[::2], crossed[1::2], strict=True)
            if min(b, d) - max(a, c) > LENGTH_TOLERANCE
        ]
    return [(float(a), float(b)) for a, b in spans]
