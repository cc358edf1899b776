"""Kinds of textures: canvas, layers, laid pieces, wood."""

from __future__ import annotations

from casa_assets.model.asset.material import PrintedLine
from casa_assets.textures import wood
from casa_assets.textures.canvas import (
    Canvas,
    Layers,
    Map,
    Share,
    TextureKind,
    blend,
    line_coverage,
    rgb,
    rgb_table,
    ridged,
    smoothstep,
    standardize,
    stratified,
    worley,
)
from casa_assets.textures.laying import Laying, LayingPattern, lay
from casa_assets.textures.pieces import (
    Array,
    Joint,
    PieceMap,
    PlacedOutline,
    Slab,
    TileEdge,
    fill,
    inlay,
    rim,
    slab_canvas,
    whole,
    window,
)
from casa_assets.textures.wood import GrainMaps, SawCut, WoodPalette, WoodSpecies, grain_maps, ring_maps

__all__ = [
    "Array",
    "blend",
    "Canvas",
    "fill",
    "grain_maps",
    "GrainMaps",
    "inlay",
    "Joint",
    "lay",
    "Layers",
    "Laying",
    "LayingPattern",
    "line_coverage",
    "Map",
    "PieceMap",
    "PlacedOutline",
    "PrintedLine",
    "rgb",
    "rgb_table",
    "ridged",
    "rim",
    "ring_maps",
    "SawCut",
    "Share",
    "Slab",
    "slab_canvas",
    "smoothstep",
    "standardize",
    "stratified",
    "TextureKind",
    "TileEdge",
    "whole",
    "window",
    "wood",
    "WoodPalette",
    "WoodSpecies",
    "worley",
]
