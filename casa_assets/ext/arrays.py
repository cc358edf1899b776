"""Functions on arrays: numbers, colours, outlines, surfaces."""

from __future__ import annotations

from casa_assets.core.numeric import (
    Floats,
    Ints,
    Mask,
    about_axis,
    decimals,
    linear_from_srgb_array,
    rng_for,
    significant,
    srgb_from_linear,
)
from casa_assets.mesh.planar import counter_clockwise, outline_of, signed_area
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import face_normals, signed_volume, solid_moments

__all__ = [
    "about_axis",
    "convex_hull",
    "counter_clockwise",
    "decimals",
    "face_normals",
    "Floats",
    "Ints",
    "linear_from_srgb_array",
    "Mask",
    "outline_of",
    "rng_for",
    "signed_area",
    "signed_volume",
    "significant",
    "solid_moments",
    "srgb_from_linear",
]
