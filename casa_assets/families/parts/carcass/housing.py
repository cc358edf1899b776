"""Tall and hanging cabinets round a niche for an appliance."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.families.family import Params, Supplies
from casa_assets.families.kit.assemble import assemble
from casa_assets.families.kit.asset_builder import ROOT, Bench
from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.parts.carcass.carcass import Carcass
from casa_assets.families.parts.carcass.cells import Cell, CellKind, build_column, finish
from casa_assets.families.parts.fronts.doors import Reach, Side
from casa_assets.families.parts.fronts.drawers import least_height
from casa_assets.families.parts.fronts.look import Look
from casa_assets.model.asset.asset import Asset

LEAST = 0.14  # metres, anything over or under a niche


class Fill(StrEnum):
    """What is over or under a niche."""

    DOOR = "door"
    DOORS = "doors"
    DRAWER = "drawer"
    DRAWERS = "drawers"
    OPEN = "open"


class Housing(Params):
    """A cabinet with a niche. Metres.

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
    under: Fill = Fill.DRAWERS
    over: Fill = Fill.DOORS
    hinge: Side = Side.LEFT
    left_end: bool = True
    right_end: bool = True
    look: Look = Look()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.height - self.niche_from - self.niche < LEAST:
            raise ValueError(f"a niche of {self.niche} m from {self.niche_from} m leaves nothing over it")
        if self.niche_from and self.niche_from - self.plinth < LEAST:
            raise ValueError("a niche stands on the floor, or high enough for something under it")
        if self.niche_from == 0 and self.plinth:
            raise ValueError("a cabinet whose niche stands on the floor has no plinth")
        parts = ((self.under, self.niche_from - self.plinth), (self.over, self.height - self.niche_from - self.niche))
        drawers = [room for fill, room in parts if fill in (Fill.DRAWER, Fill.DRAWERS)]
        if any(0 < room < least_height(self.look) + 0.02 for room in drawers):
            raise ValueError("too low for a drawer")
        return self


def build_housing(family: str, p: Housing, supplies: Supplies, panelled: bool = False) -> Asset:
    """The front stands in y = 0, the left side in x = 0, on the floor; `panelled` ones are finished like the fronts."""
    bench = Bench(supplies)
    bench.contract = "housing_cabinet"
    look = p.look.replace(inside=p.look.face) if panelled else p.look
    ends = (("left", p.left_end), ("right", p.right_end), ("top", True))
    skinned = tuple(name for name, seen in ends if seen)
    on_floor = p.niche_from == 0
    open_back = p.niche_from + p.niche if on_floor else 0.0
    body = Carcass(
        p.width, p.depth, p.height, p.plinth, look, open_bottom=on_floor, skinned=skinned, back_from=open_back
    )
    top = p.niche_from + p.niche
    cells = [] if on_floor else _cells(p.under, p.niche_from - p.plinth, p.hinge, Reach.HIGH, "lower_", look)
    if on_floor:
        # What stands in the niche stands on a thin board, which keeps drips off the floor of the room.
        sheet = board((body.left, body.front, 0.0), (body.right, p.depth, body.floor), 0.001)
        bench.add(ROOT, sheet, look.inside, label="floor", density="board")
    cells.append(Cell(CellKind.NICHE, p.niche, name="int"))
    cells += _cells(p.over, p.height - top, p.hinge, Reach.LOW, "upper_", look)
    build_column(bench, body, tuple(cells))
    finish(bench, p.width, p.depth, p.height)
    return assemble(bench, family, p)


def _cells(fill: Fill, height: float, hinge: Side, reach: Reach, prefix: str, look: Look) -> list[Cell]:
    if fill is Fill.DRAWER or (fill is Fill.DRAWERS and height < 2 * least_height(look) + 0.02):
        return [Cell(CellKind.DRAWER, height, name=f"{prefix}drawer")]
    if fill is Fill.DRAWERS:
        return [Cell(CellKind.DRAWER, height / 2, name=f"{prefix}drawer{i}") for i in range(2)]
    kind = {Fill.DOOR: CellKind.DOOR, Fill.DOORS: CellKind.DOORS, Fill.OPEN: CellKind.OPEN}[fill]
    return [Cell(kind, height, None, hinge, reach, "" if kind is CellKind.OPEN else prefix)]
