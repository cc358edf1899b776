"""Looks that belong together: what the presets of all cabinets are made in."""

from __future__ import annotations

from casa_assets.families.parts.fronts import FrontKind as F
from casa_assets.families.parts.fronts_look import Look
from casa_assets.families.parts.handles import HandleKind as H


def look(front: F, handle: H, face: str, metal: str, length: float = 0.16, inside: str = "melamine_white") -> Look:
    """A look in one line."""
    return Look(front=front, handle=handle, face=face, metal=metal, length=length, inside=inside)


WHITE_SHAKER = look(F.SHAKER, H.BAR, "paint_pure_white", "stainless_brushed")
NAVY_CUPS = look(F.SHAKER, H.CUP, "paint_navy", "brass_brushed")
OAK_GROOVE = look(F.SLAB, H.FINGER_GROOVE, "oak_natural", "aluminium_black", inside="melamine_oak")
GRAPHITE_EDGE = look(F.SLAB, H.EDGE_PULL, "supermatt_graphite", "aluminium_black", inside="melamine_grey")
WALNUT_RAISED = look(F.RAISED, H.KNOB, "walnut_natural", "brass_aged")
SAGE_BEADBOARD = look(F.BEADBOARD, H.KNOB, "paint_sage", "nickel_satin")
COTTAGE = look(F.V_GROOVE, H.RING, "chalk_ivory_worn", "bronze_dark")
GREEN_SLIM = look(F.SLIM_SHAKER, H.BOXED, "paint_forest", "brass_brushed", 0.224)
CLAY_FLUTED = look(F.FLUTED, H.TEE, "paint_plaster_pink", "brass_brushed")
BLUE_LOUVRED = look(F.LOUVRED, H.BOW, "paint_dusty_blue", "chrome", 0.128)
BIRCH_LEATHER = look(F.SLAB, H.LEATHER, "birch_rotary", "black_matt")
CHERRY_ARCHED = look(F.ARCHED, H.STRAP, "cherry", "brass_aged", 0.15)
BLACK_GLASS = look(F.GLASS_CLEAR, H.EDGE_PULL, "oak_fumed_black", "black_matt", 0.2, "melamine_oak")
GREY_FROSTED = look(F.GLASS_FROSTED, H.BOXED, "paint_dove_grey", "stainless_brushed", 0.192)
CREAM_DIVIDED = look(F.GLASS_DIVIDED, H.KNOB, "paint_linen_cream", "brass_aged", inside="melamine_oak")
NAVY_DIVIDED = look(F.GLASS_DIVIDED, H.BAR, "paint_navy", "brass_brushed", 0.128)
CHARCOAL_SHAKER = look(F.SHAKER, H.BOXED, "paint_charcoal", "black_matt", 0.192, "melamine_grey")
GLOSS_WHITE = look(F.SLAB, H.EDGE_PULL, "lacquer_white_gloss", "stainless_brushed", 0.3)
TEAK_SLAB = look(F.SLAB, H.BAR, "teak", "black_matt", 0.32)
PINE_BEADBOARD = look(F.BEADBOARD, H.KNOB, "pine_knotty", "bronze_dark", inside="melamine_oak")
