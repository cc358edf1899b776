"""Gaskets: the dark magnetic seal between a door and what it shuts."""

from __future__ import annotations

from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import prism, rectangle
from casa_assets.model.record import Vec2


def gasket_frame(low: Vec2, high: Vec2, y0: float, y1: float, wide: float = 0.014) -> Solid:
    """A frame of rubber between two planes.

    Args:
        low, high: outer corners in x and z, metres. y0, y1: planes between which it lies. wide: of its strip.
    Returns:
        A solid without collider.
    """
    w, h = high[0] - low[0], high[1] - low[1]
    outer, inner = rectangle(w, h, 0.01, 2), rectangle(w - 2 * wide, h - 2 * wide, 0.004, 2)
    ring = prism(outer, y1 - y0, min(0.0008, 0.2 * (y1 - y0)), (inner,))
    # Pulled along z, then laid so that z becomes -y: the plane y1 is its foot.
    stood = ring.rotated("x", 1.5707963267948966)
    return stood.translated((low[0] + high[0]) / 2, y1, (low[1] + high[1]) / 2).without_colliders()
