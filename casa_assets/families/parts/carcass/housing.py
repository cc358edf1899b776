"""Tall and hanging cabinets round a niche for an appliance."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.families.family import Params
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.parts.carcass.carcass import Carcass, finished_faces
from casa_assets.families.parts.carcass.cells import CabinetCell, CabinetCellKind, build_column, finish_cabinet
from casa_assets.families.parts.fronts.doors import HandleHeight, HingeSide
from casa_assets.families.parts.fronts.drawers import min_front_height
from casa_assets.families.parts.fronts.look import CabinetLook

MIN_CELL_HEIGHT = 0.14  # metres, anything over or under a niche


class NicheNeighbour(StrEnum):
    """Cell over or under a niche."""

    DOOR = "door"
    DOORS = "doors"
    DRAWER = "drawer"
    DRAWERS = "drawers"
    OPEN = "open"


class Housing(Params):
    """Parameters of a cabinet with a niche; lengths in metres.

    Attributes:
        width, depth, height: outside, with fronts and plinth. plinth: its height; 0 where it hangs.
        niche_from: height of the niche's floor above the cabinet's foot; where it is 0 the niche has no floor.
        niche: clear height of the niche.
        under, over: what fills the rest.
        hinge: side of single doors. left_end, right_end: sides that are finished like the fronts.
        look: front, handle, finishes.
    """

    width: Annotated[float, Field(ge=0.45, le=1.3)] = 0.6
    depth: Annotated[float, Field(ge=0.3, le=0.95)] = 0.6
    height: Annotated[float, Field(ge=0.5, le=2.7)] = 2.26
    plinth: Annotated[float, Field(ge=0.0, le=0.2)] = 0.1
    niche_from: Annotated[float, Field(ge=0.0, le=1.8)] = 0.7
    niche: Annotated[float, Field(ge=0.3, le=2.1)] = 0.6
    under: NicheNeighbour = NicheNeighbour.DRAWERS
    over: NicheNeighbour = NicheNeighbour.DOORS
    hinge: HingeSide = HingeSide.LEFT
    left_end: bool = True
    right_end: bool = True
    look: CabinetLook = CabinetLook()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.height - self.niche_from - self.niche < MIN_CELL_HEIGHT:
            raise ValueError(f"a niche of {self.niche} m from {self.niche_from} m leaves nothing over it")
        if self.niche_from and self.niche_from - self.plinth < MIN_CELL_HEIGHT:
            raise ValueError("a niche stands on the floor, or high enough for something under it")
        if self.niche_from == 0 and self.plinth:
            raise ValueError("a cabinet whose niche stands on the floor has no plinth")
        parts = ((self.under, self.niche_from - self.plinth), (self.over, self.height - self.niche_from - self.niche))
        drawers = [
            height for neighbour, height in parts if neighbour in (NicheNeighbour.DRAWER, NicheNeighbour.DRAWERS)
        ]
        if any(0 < height < min_front_height(self.look) + 0.02 for height in drawers):
            raise ValueError("too low for a drawer")
        return self


def build_housing(builder: AssetBuilder, p: Housing, panelled: bool = False) -> None:
    """Build the asset: fronts at y = 0, left side at x = 0, floor at z = 0.

    Args:
        panelled: the inside is finished like the fronts.
    """
    look = p.look.replace(inside=p.look.face) if panelled else p.look
    faces = finished_faces(p.left_end, p.right_end, "top")
    on_floor = p.niche_from == 0
    open_back = p.niche_from + p.niche if on_floor else 0.0
    body = Carcass(
        p.width, p.depth, p.height, p.plinth, look, open_bottom=on_floor, finished_faces=faces, back_from=open_back
    )
    top = p.niche_from + p.niche
    cells = [] if on_floor else _cells(p.under, p.niche_from - p.plinth, p.hinge, HandleHeight.HIGH, "lower_", look)
    if on_floor:
        # What stands in the niche stands on a thin board, which keeps drips off the floor of the room.
        floor = board((body.left, body.front, 0.0), (body.right, p.depth, body.floor), 0.001)
        builder.add(ROOT, floor, look.inside, label="floor", density="board")
    cells.append(CabinetCell(CabinetCellKind.NICHE, p.niche, name="int"))
    cells += _cells(p.over, p.height - top, p.hinge, HandleHeight.LOW, "upper_", look)
    build_column(builder, body, tuple(cells))
    finish_cabinet(builder, p.width, p.depth, p.height)


def _cells(
    neighbour: NicheNeighbour, height: float, hinge: HingeSide, reach: HandleHeight, prefix: str, look: CabinetLook
) -> list[CabinetCell]:
    if neighbour is NicheNeighbour.DRAWER or (
        neighbour is NicheNeighbour.DRAWERS and height < 2 * min_front_height(look) + 0.02
    ):
        return [CabinetCell(CabinetCellKind.DRAWER, height, name=f"{prefix}drawer")]
    if neighbour is NicheNeighbour.DRAWERS:
        return [CabinetCell(CabinetCellKind.DRAWER, height / 2, name=f"{prefix}drawer{i}") for i in range(2)]
    kind = {
        NicheNeighbour.DOOR: CabinetCellKind.DOOR,
        NicheNeighbour.DOORS: CabinetCellKind.DOORS,
        NicheNeighbour.OPEN: CabinetCellKind.OPEN,
    }[neighbour]
    return [CabinetCell(kind, height, None, hinge, reach, "" if kind is CabinetCellKind.OPEN else prefix)]
