"""The interface for plug-ins and add-ons: records and functions for families, objects, checks, textures and formats.

    import casa_assets as casa
    from casa_assets import ext

    PLUGIN = ext.Plugin(name="tea", version="1.0", families=(...,))

The names in `__all__` are stable within a version; every other module of the package may change at any time. Each name
has one path: names for users of the package (`casa.Asset`, `casa.build`, `casa.check`) are only in `casa_assets`.
"""

from __future__ import annotations

from casa_assets.asset.kit.assemble import Family
from casa_assets.asset.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.asset.kit.solids.blocks import ball, board, box, intersect, lathe, rod, subtract, union
from casa_assets.asset.kit.solids.solid import Solid
from casa_assets.asset.kit.solids.sweep import circle, loft, prism, rectangle, tube
from casa_assets.checks.check import (
    Check,
    Measurement,
    all_at_least,
    all_at_most,
    at_least,
    at_most,
    count,
    no_fault,
    not_applicable,
)
from casa_assets.ext.plugins import Exporter, Plugin, Source
from casa_assets.families.family import FinishId, Params
from casa_assets.model.asset.asset import Base
from casa_assets.model.issue import Severity
from casa_assets.model.record import Record
from casa_assets.textures.canvas import Canvas, Layers, TextureKind, blend, rgb, smoothstep

__all__ = [
    # a plug-in, and what it may bring that is no data
    "Plugin",
    "Source",
    "Exporter",
    # families of fixtures and forms of objects
    "Family",
    "Params",
    "FinishId",
    "Record",
    "Base",
    "AssetBuilder",
    "ROOT",
    # solids
    "Solid",
    "box",
    "board",
    "rod",
    "ball",
    "lathe",
    "prism",
    "tube",
    "loft",
    "circle",
    "rectangle",
    "union",
    "subtract",
    "intersect",
    # checks
    "Check",
    "Severity",
    "Measurement",
    "no_fault",
    "not_applicable",
    "at_most",
    "at_least",
    "all_at_most",
    "all_at_least",
    "count",
    # textures
    "TextureKind",
    "Canvas",
    "Layers",
    "rgb",
    "blend",
    "smoothstep",
]
