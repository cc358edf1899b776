"""Style of large appliances: form and finish of the fronts, the pull, and the base below the doors."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.parts.appliance.handles import AppliancePull
from casa_assets.families.parts.fronts.fronts import FrontKind


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
