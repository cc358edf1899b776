"""Plates on a wall, for outlets and switches."""

from __future__ import annotations

from casa_assets.families.kit.asset_builder import ROOT, Bench
from casa_assets.families.kit.solids.blocks import rod
from casa_assets.families.kit.solids.solid import Solid, box_shape, turn
from casa_assets.families.kit.solids.sweep import prism, rectangle

HALF_TURN = 1.5707963267948966
THICK = 0.006


def standing(solid: Solid) -> Solid:
    """What was pulled up along z now grows out of a wall, towards -y; its x stays, its y becomes z."""
    return solid.posed(turn("x", HALF_TURN))


def plate(bench: Bench, width: float, height: float, radius: float, finish: str, screws: bool = True) -> None:
    """A plate with eased edges about x = 0, z = 0, its back on the wall y = 0; touched as a box."""
    body = standing(prism(rectangle(width, height, radius, 5), THICK, 0.0025))
    body = Solid(
        body.points,
        body.faces,
        (box_shape((-width / 2, -THICK, -height / 2), (width / 2, 0.0, height / 2)),),
        crease_deg=50.0,
    )
    bench.add(ROOT, body, finish, label="plate", name="plate", density="hard_plastic")
    if screws and height > 0.1:
        for z in (-0.0485, 0.0485):
            head = rod(0.0032, 0.0012, 0.0004, "y").at(0.0, -THICK - 0.0003, z)
            bench.add(ROOT, head, "stainless_polished", label="screw", touch=False)
