"""Style of large appliances: form and finish of the fronts, the pull, and what stands below the doors."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.families.family import AvailableFinishes, FinishId, Params, between, pick
from casa_assets.families.parts.appliance.handles import AppliancePull
from casa_assets.families.parts.fronts.fronts import FrontKind
from casa_assets.model.registry.finish import Surface


class ApplianceFront(StrEnum):
    """Shape of a front."""

    FLAT = "flat"  # folded sheet with sharp edges
    SOFT = "soft"  # edges of about a centimetre
    ROUND = "round"  # edges as round as a bun: the fifties
    PANEL = "panel"  # a cabinet's front is hung on it
    GLASS = "glass"  # a pane in a frame of metal


class ApplianceKick(StrEnum):
    """Base below the doors."""

    GRILLE = "grille"
    PLINTH = "plinth"
    FEET = "feet"


class ApplianceLook(Params):
    """Front form, pull and finishes of a large appliance.

    Attributes:
        form, pull, kick. front: kind of cabinet front where the form is `panel`.
        face: of the fronts; `lower`, where given, of the lower or left one. body: of sides and back. metal: of pulls.
        trim: of shelf edges and rails inside. share: of the height of a door that its pull takes.
        badge: a plate without a name. display: a touch panel in the front.
    """

    form: ApplianceFront = ApplianceFront.FLAT
    pull: AppliancePull = AppliancePull.TUBE
    kick: ApplianceKick = ApplianceKick.GRILLE
    front: FrontKind = FrontKind.SHAKER
    face: FinishId = "stainless_brushed"
    lower: FinishId | None = None
    body: FinishId = "enamel_grey"
    metal: FinishId = "stainless_polished"
    trim: FinishId = "plastic_grey_light"
    share: Annotated[float, Field(ge=0.2, le=0.9)] = 0.5
    badge: bool = True
    display: bool = False

    @property
    def thick(self) -> float:
        """Thickness of a door, metres."""
        return {ApplianceFront.ROUND: 0.07, ApplianceFront.PANEL: 0.068}.get(self.form, 0.056)


SHEET_FINISHES = ("stainless_brushed", "stainless_black", "enamel_white", "enamel_grey", "gunmetal", "enamel_charcoal")
PASTEL_FINISHES = (
    "enamel_cream",
    "enamel_mint",
    "enamel_red",
    "enamel_pale_blue",
    "enamel_butter",
    "enamel_dusty_pink",
    "enamel_black",
    "enamel_sage",
    "enamel_navy",
)
GLASS_FINISHES = ("glass_white", "glass_black", "enamel_white", "stainless_black")
PANEL_FRONTS = (FrontKind.SLAB, FrontKind.SHAKER, FrontKind.SLIM_SHAKER, FrontKind.RAISED, FrontKind.V_GROOVE)
MODERN_PULLS = (
    AppliancePull.TUBE,
    AppliancePull.PRO,
    AppliancePull.BLADE,
    AppliancePull.BOW,
    AppliancePull.BOXED,
    AppliancePull.LEDGE,
)
# Sides of a case go with its fronts: the same enamel, or grey behind steel.
BODY_FINISHES = {
    "stainless_brushed": ("enamel_grey", "stainless_brushed", "enamel_charcoal"),
    "stainless_black": ("enamel_charcoal", "enamel_black"),
    "gunmetal": ("enamel_charcoal",),
    "glass_white": ("enamel_white",),
    "glass_black": ("enamel_black",),
}


def draw_appliance_look(rng: np.random.Generator, available: AvailableFinishes) -> ApplianceLook:
    """A look as shops have it."""
    form = pick(
        rng,
        (
            ApplianceFront.FLAT,
            ApplianceFront.FLAT,
            ApplianceFront.SOFT,
            ApplianceFront.SOFT,
            ApplianceFront.ROUND,
            ApplianceFront.PANEL,
            ApplianceFront.GLASS,
        ),
    )
    share = between(rng, 0.35, 0.8, 0.01)
    if form is ApplianceFront.PANEL:
        metal = pick(rng, ("brass_brushed", "black_matt", "stainless_brushed", "nickel_satin", "bronze_dark"))
        pull, kind, face = pick(rng, MODERN_PULLS[:-1]), pick(rng, PANEL_FRONTS), available.draw(rng, Surface.CABINET)
        return ApplianceLook(
            form=form,
            pull=pull,
            front=kind,
            face=face,
            body="enamel_charcoal",
            metal=metal,
            kick=ApplianceKick.PLINTH,
            badge=False,
            share=share,
        )
    if form is ApplianceFront.ROUND:
        face = pick(rng, PASTEL_FINISHES)
        kick = pick(rng, (ApplianceKick.FEET, ApplianceKick.GRILLE))
        pull = pick(rng, (AppliancePull.LATCH, AppliancePull.LATCH, AppliancePull.BOW))
        return ApplianceLook(form=form, pull=pull, face=face, body=face, metal="chrome", kick=kick, share=share)
    face = pick(rng, GLASS_FINISHES if form is ApplianceFront.GLASS else SHEET_FINISHES)
    return ApplianceLook(
        form=form,
        pull=pick(rng, MODERN_PULLS),
        face=face,
        body=pick(rng, BODY_FINISHES.get(face, (face,))),
        metal=pick(rng, ("stainless_polished", "stainless_brushed", "black_matt", "aluminium_anodised")),
        trim=pick(rng, ("plastic_grey_light", "chrome", "plastic_white")),
        kick=pick(rng, (ApplianceKick.GRILLE, ApplianceKick.PLINTH)),
        share=share,
        badge=bool(rng.random() < 0.6),
        display=bool(rng.random() < 0.4),
    )
