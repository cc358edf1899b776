"""The builder of assets, and the solids that it is given."""

from __future__ import annotations

from casa_assets.asset import blocks
from casa_assets.asset.asset_builder import ROOT, AssetBuilder, BehaviorBuilder, combine_masses, negated
from casa_assets.asset.blocks import ball, board, box, intersect, lathe, rod, subtract, union
from casa_assets.asset.solid import Placed, Solid, anchor_uv, axis_turn, box_shape, concatenate, hull_around
from casa_assets.asset.sweep import (
    arc,
    basin,
    circle,
    inset,
    inset_rings,
    loft,
    mitred_frame,
    offset_sides,
    prism,
    rectangle,
    ring_walls,
    room_moulding,
    round_corners,
    slab,
    straight_moulding,
    tube,
)

__all__ = [
    "anchor_uv",
    "arc",
    "AssetBuilder",
    "axis_turn",
    "ball",
    "basin",
    "BehaviorBuilder",
    "blocks",
    "board",
    "box",
    "box_shape",
    "circle",
    "combine_masses",
    "concatenate",
    "hull_around",
    "inset",
    "inset_rings",
    "intersect",
    "lathe",
    "loft",
    "mitred_frame",
    "negated",
    "offset_sides",
    "Placed",
    "prism",
    "rectangle",
    "ring_walls",
    "rod",
    "room_moulding",
    "ROOT",
    "round_corners",
    "slab",
    "Solid",
    "straight_moulding",
    "subtract",
    "tube",
    "union",
]
