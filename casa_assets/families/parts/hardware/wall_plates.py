"""Plates on a wall, for outlets and switches."""

from __future__ import annotations

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import rod
from casa_assets.families.kit.solids.solid import Solid, axis_turn, box_shape
from casa_assets.families.kit.solids.sweep import prism, rectangle

HALF_TURN = 1.5707963267948966
PLATE_THICKNESS = 0.006


def upright_on_wall(solid: Solid) -> Solid:
    """Rotate a solid extruded along z so that it grows out of a wall, towards -y; its x stays, its y becomes z."""
    return solid.transformed(axis_turn("x", HALF_TURN))


def plate(builder: AssetBuilder, width: float, height: float, radius: float, finish: str, screws: bool = True) -> None:
    """A plate with rounded edges about x = 0, z = 0, its back on the wall y = 0; its collider is a box."""
    body = upright_on_wall(prism(rectangle(width, height, radius, 5), PLATE_THICKNESS, 0.0025))
    shape = box_shape((-width / 2, -PLATE_THICKNESS, -height / 2), (width / 2, 0.0, height / 2))
    builder.add(ROOT, body.with_shapes(shape), finish, label="plate", name="plate", density="hard_plastic")
    if screws and height > 0.1:
        for z in (-0.0485, 0.0485):
            head = rod(0.0032, 0.0012, 0.0004, "y").translated(0.0, -PLATE_THICKNESS - 0.0003, z)
            builder.add(ROOT, head, "stainless_polished", label="screw", collider=False)
