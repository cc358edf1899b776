"""Slabs with a moulded edge: an outline whose chosen sides follow a profile."""

from __future__ import annotations

import math
from collections.abc import Sequence

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.model.record import Vec2


def slab(outline: Floats, profile: Sequence[Vec2], moulded: Sequence[bool], holes: Sequence[Floats] = ()) -> Solid:
    """A slab between two planes.

    Args:
        outline: (N, 2) simple polygon, metres, counter-clockwise; side i runs from point i to point i + 1.
        profile: (inset, z) from the lower plane to the upper one, metres; inset is measured from the outline inwards.
        moulded: for each side whether it follows the profile; the other sides are vertical.
        holes: (M, 2) outlines inside it, counter-clockwise; their rims are chamfered by a millimetre on top.
    Returns:
        A solid without collision shapes.
    """
    loop = np.asarray(outline, dtype=np.float64)
    rings = [
        np.column_stack([offset_sides(loop, [d if m else 0.0 for m in moulded]), np.full(len(loop), z)])
        for d, z in profile
    ]
    bottom, top = profile[0][1], profile[-1][1]
    rim_radius = min(0.001, 0.2 * (top - bottom))
    stacks = [rings]
    for hole in holes:
        back = np.asarray(hole, dtype=np.float64)[::-1]
        widened = offset_sides(back, [rim_radius] * len(back))
        levels = ((back, bottom), (back, top - rim_radius), (widened, top))
        stacks.append([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in levels])
    return stack_rings(stacks, 35.0)


def offset_sides(loop: Floats, by: Sequence[float]) -> Floats:
    """(N, 2) polygon whose side i is moved inwards (to the left of its run) by `by[i]` metres."""
    n = len(loop)
    run = np.roll(loop, -1, axis=0) - loop
    run /= np.linalg.norm(run, axis=1)[:, None]
    inwards = np.stack([-run[:, 1], run[:, 0]], axis=1)
    out = np.empty_like(loop)
    for i in range(n):
        a, b = inwards[i - 1], inwards[i]
        da, db = by[i - 1], by[i]
        det = a[0] * b[1] - a[1] * b[0]
        if abs(det) < 0.02:
            out[i] = loop[i] + (a * da + b * db) / 2
            continue
        x = (da * b[1] - db * a[1]) / det
        y = (db * a[0] - da * b[0]) / det
        out[i] = loop[i] + (x, y)
    return out


def stack_rings(stacks: Sequence[Sequence[Floats]], crease_deg: float) -> Solid:
    """A solid between two level planes: an outer stack of rings, and one for each hole.

    Args:
        stacks: the outer boundary, then the holes: (N, 3) rings from the lower plane to the upper one, metres,
            counter-clockwise outside and clockwise in holes. All start in one plane and end in one.
        crease_deg: as in Solid.
    Returns:
        Walls between the rings of each stack, and one cap below and one above; no collision shapes.
    """
    faces: list[Ints] = []
    bottom: list[Ints] = []
    top: list[Ints] = []
    start = 0
    for rings in stacks:
        n = len(rings[0])
        faces += ring_walls(n, len(rings), start)
        bottom.append(start + np.arange(n))
        start += n * len(rings)
        top.append(start - n + np.arange(n))
    points = np.concatenate([ring for rings in stacks for ring in rings])
    for ids, step in ((bottom, -1), (top, 1)):
        triangles = np.asarray(manifold3d.triangulate([points[i, :2] for i in ids]), dtype=np.int64)
        faces.append(np.concatenate(ids)[triangles][:, ::step])
    return Solid(points, np.concatenate(faces).astype(np.int64), crease_deg=crease_deg)


def ring_walls(size: int, count: int, start: int = 0) -> list[Ints]:
    """Faces between neighbours of `count` rings of `size` points, whose points are numbered on from `start`."""
    faces: list[Ints] = []
    for k in range(count - 1):
        a, d = (start + (k + i) * size + np.arange(size) for i in (0, 1))
        b, c = np.roll(a, -1), np.roll(d, -1)
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    return faces


def arc(cx: float, cz: float, radius: float, start_deg: float, end_deg: float, steps: int = 6) -> list[Vec2]:
    """(inset, z) points of an arc: 0 degrees looks inwards (+ inset), 90 up."""
    turns = np.linspace(math.radians(start_deg), math.radians(end_deg), steps + 1)
    return [(cx + radius * math.cos(t), cz + radius * math.sin(t)) for t in turns]
