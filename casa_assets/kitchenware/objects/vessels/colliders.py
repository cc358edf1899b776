"""Collision shapes of open things: a floor and rings of slabs, so that what is put in stays in."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np

from casa_assets.ext.arrays import Floats
from casa_assets.ext.solids import Placed, box, hull_around, rod
from casa_assets.kitchenware.objects.vessels.surface import Plan, Profile, thinned

# Slabs are at least as thick as this, metres.
THICK = 0.003
# A ring has eight slabs; twelve from one radius on, six up to another, metres.
WIDE, SMALL = 0.18, 0.075
# Corners of a rectangle that are rounder than this get a slab of their own, metres.
ROUND_CORNER = 0.03
# Slabs bulge as the wall does where straight ones would end so far from it, metres.
BULGE = 0.008
# How far a bead on the rim may stand over the slabs, metres.
OVER = 0.0035


def open_shapes(
    profile: Profile, plan: Plan, floor: float, low: float, room: int, bead: float = 0.0
) -> tuple[Placed, ...]:
    """The shapes of an open vessel.

    Args:
        floor: height of the inside's floor. low: height of the top of a stem, where the wall begins. room: most shapes.
        bead: radius of a wire round the rim, metres.
    """
    outside = profile.outside
    solid = [*outside[outside[:, 1] < floor], (profile.radius(floor), floor)]
    shapes = closed_shapes(np.array(solid), plan, 0.05 * plan.half_x)
    ways = _ways(plan)
    levels = max(1, (room - len(shapes) - (plan.lip > 0)) // len(ways))
    start = low + max(0.0035, 0.25 * (floor - low))
    wall = outside[outside[:, 1] > start + 1e-5]
    wall = np.concatenate([[[profile.radius(start), start]], wall])
    line = _levels(wall, plan, min(levels, 3))
    thickness = max(THICK, float(np.linalg.norm(profile.inside[-1] - outside[-1])))
    inner = line + thickness * _inwards(line)
    inner[:, 0] = np.maximum(inner[:, 0], 0.02 * plan.half_x)
    bulging = wall if _error(wall, line) > BULGE else wall[:0]
    over = max(0.0, bead - OVER)
    line[-1] += over  # outwards and upwards
    inner[-1, 1] += over
    for lower, upper in pairwise(range(len(line))):
        sides = [(float(r), float(z)) for ring in (line, inner) for r, z in (ring[lower], ring[upper])]
        sides += [(float(r), float(z)) for r, z in bulging if line[lower, 1] < z < line[upper, 1]]
        rings = [_polygon(plan, r, z, ways) for r, z in sides]
        for i in range(len(ways)):
            j = (i + 1) % len(ways)
            corners = np.array([ring[k] for ring in rings for k in (i, j)])
            shapes += hull_around(corners).shapes
    if plan.lip > 0:
        shapes += _lip(profile, plan, thickness)
    return tuple(shapes)


def _levels(wall: Floats, plan: Plan, most: int) -> Floats:
    """The (N, 2) corners of the line that follows a wall's profile best with few pieces."""
    marks = thinned(wall, 0.0008)
    tolerance = max(0.0035, 0.035 * plan.half_x)
    best = marks[[0, -1]]
    for inner in range(most):
        choices = [marks[[0, *chosen, -1]] for chosen in combinations(range(1, len(marks) - 1), inner)]
        errors = [_error(marks, line) for line in choices]
        best = choices[int(np.argmin(errors))] if choices else best
        if not choices or min(errors) < tolerance:
            break
    return best


def _error(points: Floats, line: Floats) -> float:
    """The largest distance of some points from a line."""
    found = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        share = np.clip((points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(points - a - share[:, None] * (b - a), axis=1))
    return float(found.max())


def _lip(profile: Profile, plan: Plan, thickness: float) -> tuple[Placed, ...]:
    """A wedge in the lip of a jug, between its wall without and with the lip."""
    angle = np.arange(plan.around) * 2 * np.pi / plan.around
    near = np.abs(angle - np.pi) < 1.25 * plan.lip_width
    low = plan.lip_from + 0.35 * (1 - plan.lip_from)
    points = []
    for z in (low * plan.height, plan.height):
        r = profile.radius(z)
        inner = replace(plan, lip=0.0).ring(r - thickness, z)[near]
        points += [plan.ring(r, z)[near], inner]
    return hull_around(np.concatenate(points)).shapes


def closed_shapes(line: Floats, plan: Plan, slack: float) -> list[Placed]:
    """The shapes of a solid body that a profile line bounds, (N, 2) radius and height: cylinders, boxes and hulls."""
    shapes: list[Placed] = []
    found = thinned(line, slack)
    low = float(found[0, 1])
    if len(found) > 1 and found[0, 0] > 1.02 * plan.half_x * 0.02:
        # It stands on a plain disc or box, whatever else it is made of.
        high = min(low + 0.003, float(found[-1, 1]))
        shapes += _block(plan, float(found[0, 0]), low, max(high, low + 0.001))
    for (r0, z0), (r1, z1) in pairwise(found):
        if z1 - z0 < 0.001:
            continue
        if abs(r1 - r0) < 0.06 * max(r0, r1):
            shapes += _block(plan, float(r0 + r1) / 2, float(z0), float(z1))
            continue
        lift = min(0.0015, 0.3 * float(z1 - z0))
        rings = [plan.ring(float(r), float(z) + raised)[::2] for r, z, raised in ((r0, z0, lift), (r1, z1, 0.0))]
        shapes += hull_around(np.concatenate(rings)).shapes
    return shapes


def _block(plan: Plan, radius: float, low: float, high: float) -> tuple[Placed, ...]:
    """A cylinder or a box between two heights."""
    middle, tall = (low + high) / 2, high - low
    half_y = max(plan.half_y - (plan.half_x - radius), 0.1 * radius)
    if plan.corner is None and abs(half_y - radius) < 1e-6:
        return rod(radius, tall, 0.0).translated(z=middle).shapes
    if plan.corner is not None:
        return box((2 * radius, 2 * half_y, tall), (0.0, 0.0, middle), 0.0).shapes
    rings = [plan.ring(radius, z)[::2] for z in (low, high)]
    return hull_around(np.concatenate(rings)).shapes


def _ways(plan: Plan) -> Floats:
    """Directions of the corners of a ring of slabs: angles of an ellipse, or of a rectangle numbers of its corners."""
    if plan.corner is not None:
        return np.arange(8 if plan.corner > ROUND_CORNER else 4, dtype=np.float64)
    count = 12 if plan.half_x > WIDE else 6 if plan.half_x < SMALL else 8
    # A quarter of a step on: then the polygon is as wide in x as in y, to all four sides.
    return (np.arange(count) + 0.25) * 2 * np.pi / count


def _polygon(plan: Plan, radius: float, z: float, ways: Floats) -> Floats:
    """(N, 3) corners of a ring of slabs, half way between the polygon inside the outline and the one about it."""
    if plan.corner is not None:
        inset = plan.half_x - radius
        x, y = max(radius, 1e-4), max(plan.half_y - inset, 1e-4)
        c = max(plan.corner - inset, 0.0) if len(ways) == 8 else 0.0
        cut = min(0.45 * c, 0.8 * x, 0.8 * y)
        corners = [(x, y - cut), (x - cut, y), (-x + cut, y), (-x, y - cut)]
        corners += [(-x, -y + cut), (-x + cut, -y), (x - cut, -y), (x, -y + cut)]
        flat = np.array(corners if len(ways) == 8 else corners[::2])
        return np.column_stack([flat, np.full(len(flat), z)])
    ring = replace(plan, lip=0.0, lip_rise=0.0, flutes=0, facets=0).ring(float(radius), float(z))
    angle = np.arange(plan.around) * 2 * np.pi / plan.around
    wide = 1 + 0.5 * (1 / math.cos(math.pi / len(ways)) - 1)
    if plan.facets:
        wide *= 0.3 + 0.7 * math.cos(math.pi / plan.facets)
    parts = [np.interp(ways, angle, ring[:, k], period=2 * np.pi) for k in range(3)]
    return np.stack([parts[0] * wide, parts[1] * wide, parts[2]], axis=1)


def _inwards(line: Floats) -> Floats:
    """(N, 2) unit normals of a profile line that point to its inside."""
    way = np.gradient(line, axis=0) if len(line) > 2 else np.repeat(np.diff(line, axis=0), 2, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-9)[:, None]
    return np.stack([-way[:, 1], way[:, 0]], axis=1)
