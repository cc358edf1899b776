"""Gaskets: the dark magnetic seal between a door and what it shuts."""

from __future__ import annotations

from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import prism, rectangle
from casa_assets.model.record import Vec2


def gasket_frame(lower: Vec2, upper: Vec2, y0: float, y1: float, strip_width: float = 0.014) -> Solid:
    """A frame of rubber between two planes.

    Args:
        lower, upper: outer corners in x and z, metres. y0, y1: planes between which it lies. strip_width: of its strip.
    Returns:
        A solid without collider.
    """
    w, h = upper[0] - lower[0], upper[1] - lower[1]
    outer, inner = rectangle(w, h, 0.01, 2), rectangle(w - 2 * strip_width, h - 2 * strip_width, 0.004, 2)
    ring = prism(outer, y1 - y0, min(0.0008, 0.2 * (y1 - y0)), (inner,))
    # Pulled along z, then laid so that z becomes -y: the plane y1 is its foot.
    upright = ring.rotated("x", 1.5707963267948966)
    return upright.translated((lower[0] + upper[0]) / 2, y1, (lower[1] + upper[1]) / 2).without_colliders()
