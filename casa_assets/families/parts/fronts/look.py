"""Style that all cabinets of a kitchen share: front, handle and finishes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.families.family import AvailableFinishes, FinishId, Params, between, pick
from casa_assets.families.parts.fronts.fronts import FrontKind
from casa_assets.families.parts.hardware.handles import HandleKind
from casa_assets.model.registry.finish import Surface

HANDLE_FINISHES = (
    "stainless_brushed",
    "nickel_satin",
    "chrome",
    "brass_brushed",
    "brass_aged",
    "bronze_dark",
    "black_matt",
    "copper",
    "gunmetal",
)
INSIDE_FINISHES = ("melamine_white", "melamine_grey", "melamine_oak")
# Handles that are pulled by an edge need a front whose edge is plain.
PLAIN_EDGED = (FrontKind.SLAB, FrontKind.SLIM_SHAKER, FrontKind.SHAKER)


class CabinetLook(Params):
    """Front, handle and finishes of a cabinet.

    Attributes:
        front: kind of door and drawer front. handle: kind of handle. length: of bars and straps, metres.
        face: finish of fronts and of what is seen of the sides. inside: of carcass and shelves. tray: of drawer boxes.
        metal: of handles.
    """

    front: FrontKind = FrontKind.SHAKER
    handle: HandleKind = HandleKind.BAR
    length: Annotated[float, Field(ge=0.06, le=1.2)] = 0.16
    face: FinishId = "painted_white"
    inside: FinishId = "melamine_white"
    tray: FinishId = "beech_plain"
    metal: FinishId = "stainless_brushed"


def draw_cabinet_look(rng: np.random.Generator, available: AvailableFinishes) -> CabinetLook:
    """A look as kitchens have it."""
    kind = pick(rng, tuple(FrontKind))
    handles = tuple(HandleKind) if kind in PLAIN_EDGED else tuple(HandleKind)[:-2]
    return CabinetLook(
        front=kind,
        handle=pick(rng, handles),
        length=between(rng, 0.1, 0.32, 0.032),
        face=available.draw(rng, Surface.CABINET),
        inside=pick(rng, INSIDE_FINISHES),
        tray=pick(rng, ("beech_plain", "melamine_white", "bamboo_plain", "white_matt")),
        metal=pick(rng, HANDLE_FINISHES),
    )
