"""Style that all cabinets of a kitchen share: front, handle and finishes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.parts.fronts.fronts import FrontKind
from casa_assets.families.parts.hardware.handles import HandleKind


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
