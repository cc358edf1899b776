"""Open boxes with rounded corners, and loops and rows of wire: what racks and baskets are made of."""

from __future__ import annotations

import numpy as np

from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.kit.solids.loft import inset_rings, loft
from casa_assets.families.kit.solids.solid import Solid, concatenate
from casa_assets.families.kit.solids.sweep import circle, rectangle, tube
from casa_assets.model.record import Vec3

WIRE_SIDES = 6  # of a wire


def open_tub(width: float, depth: float, height: float, wall: float, radius: float, floor: float = 0.0) -> Solid:
    """An open box about x = 0, y = 0 from z = 0 up, its corners rounded; its colliders are a floor and four walls.

    Args:
        width, depth, height: outside, metres. wall: its thickness. radius: of the upright corners.
        floor: thickness of the bottom; 0 for that of the walls.
    """
    base = floor or wall
    edge_radius = min(0.004, 0.3 * height)
    outline = rectangle(width, depth, radius, 5)
    steps = [(edge_radius, 0.0), (0.0, edge_radius), (0.0, height - 0.001), (0.3 * wall, height), (0.7 * wall, height)]
    body = loft(inset_rings(outline, [*steps, (wall, height - 0.001), (wall, base)]), 45.0)
    w, d = width / 2, depth / 2
    boards = (
        board((-w, -d, 0.0), (w, d, base), 0.0),
        board((-w, -d, base), (w, -d + wall, height), 0.0),
        board((-w, d - wall, base), (w, d, height), 0.0),
        board((-w, -d + wall, base), (-w + wall, d - wall, height), 0.0),
        board((w - wall, -d + wall, base), (w, d - wall, height), 0.0),
    )
    return body.with_colliders_of(*boards)


def wire_loop(width: float, depth: float, z: float, radius: float, corner: float) -> Solid:
    """A level ring of wire about x = 0, y = 0: `width` by `depth` over the middle of the wire; without collider."""
    w, d = width / 2, depth / 2
    path = [(0.0, -d, z), (w, -d, z), (w, d, z), (-w, d, z), (-w, -d, z), (0.0, -d, z)]
    return tube(path, circle(radius, 8), corner).without_colliders()


def wire(path: list[Vec3], radius: float, bend: float = 0.0) -> Solid:
    """A wire along corner points, bent round with a radius, metres; without collider."""
    return tube(path, circle(radius, WIRE_SIDES), bend).without_colliders()


def wire_grid(width: float, depth: float, z: float, radius: float, across: int, along: int) -> Solid:
    """Crossed wires about x = 0, y = 0: `across` run from front to back, `along` from left to right just below them."""
    w, d = width / 2, depth / 2
    out = [wire([(float(x), -d, z), (float(x), d, z)], radius) for x in np.linspace(-w, w, across)]
    out += [
        wire([(-w, float(y), z - 1.6 * radius), (w, float(y), z - 1.6 * radius)], radius) for y in _spread(d, along)
    ]
    return concatenate(out)


def _spread(half: float, count: int) -> list[float]:
    """`count` places within -half .. half, evenly, none of them at the ends."""
    return [float(v) for v in np.linspace(-half, half, count + 2)[1:-1]]
