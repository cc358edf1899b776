"""A column of cells in one carcass (doors, drawers, shelves, niches), and cabinets round a niche for an appliance."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Self

from pydantic import Field, model_validator

from casa_assets.ext.families import Params
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, board
from casa_assets.kitchenware.parts.carcass.carcass import (
    ACROSS,
    BOARD_THICKNESS,
    CHANNEL_DEPTH,
    FRONT_GAP,
    RAIL_HEIGHT,
    Carcass,
    add_shelves,
    build_carcass,
    finished_faces,
    layered,
    shelves_for,
)
from casa_assets.kitchenware.parts.fronts import doors as drawers
from casa_assets.kitchenware.parts.fronts import fronts
from casa_assets.kitchenware.parts.fronts.doors import (
    CabinetDoor,
    CabinetDrawer,
    HandleHeight,
    HingeSide,
    hang_door,
    min_front_height,
)
from casa_assets.kitchenware.parts.fronts.fronts import FRONT_THICKNESS, CabinetLook
from casa_assets.kitchenware.parts.hardware.handles import HandleKind

# Cells ----------------------------------------------------------------------------------------------------------------
# Doors, drawers, false fronts, open shelves and niches stacked in one carcass.

# A channel of sheet metal behind fronts with a finger groove: how far the front stays below, and how high it is.
CHANNEL_REVEAL, CHANNEL_HEIGHT = 0.028, 0.062
CHANNEL_SHEET = 0.0025

# Content of a cell.
CabinetCellKind = StrEnum("CabinetCellKind", "DOOR DOORS DRAWER FALSE OPEN NICHE VOID")


@dataclass(frozen=True)
class CabinetCell:
    """One part of a column, bottom up.

    Attributes:
        kind: what it holds. height: of its share of the front, metres; the shares add up to the front's height.
        shelves: how many, None by height. hinge: side of a single door. handle_height: of doors.
        name: of a drawer (`drawer`, `drawer0`) or prefix of doors (``, `upper_`) or region of a niche.
    """

    kind: CabinetCellKind
    height: float
    shelves: int | None = None
    hinge: HingeSide = HingeSide.LEFT
    handle_height: HandleHeight = HandleHeight.HIGH
    name: str = ""


def build_column(builder: AssetBuilder, c: Carcass, cells: tuple[CabinetCell, ...], level: int = 0) -> int:
    """Add a carcass and all its cells.

    Args:
        cells: bottom up. level: number of its lowest shelf region.
    Returns:
        The number of the next one.
    """
    build_carcass(builder, c)
    z = c.plinth
    for k, cell in enumerate(cells):
        top = z + cell.height
        span = _clear_span(builder, c, cells, k, z, top)
        # Lower and upper edge of a cell's front, metres.
        upper = CHANNEL_REVEAL if _grooved(c, cell) else FRONT_GAP if (k == len(cells) - 1) else FRONT_GAP / 2
        front = z + (FRONT_GAP / 2 if z > c.plinth else 0.0), top - upper
        if cell.kind in (CabinetCellKind.DOOR, CabinetCellKind.DOORS):
            _doors(builder, c, cell, front)
            count = shelves_for(span[1] - span[0]) if cell.shelves is None else cell.shelves
            level = add_shelves(builder, c, *span, count, level)
        elif cell.kind is CabinetCellKind.OPEN:
            level = add_shelves(builder, c, *span, cell.shelves or 0, level)
        elif cell.kind is CabinetCellKind.DRAWER:
            solo = cell.name in ("", "drawer")
            link = "drawer" if solo else cell.name
            drawer = CabinetDrawer(
                link=link,
                joint="slidejoint" if solo else f"{link}_slidejoint",
                region="int" if solo else f"{link}_int",
                x=c.x + FRONT_GAP / 2,
                z=front[0],
                width=c.width - FRONT_GAP,
                height=front[1] - front[0],
                left=c.left,
                right=c.right,
                floor=max(span[0], front[0]),
                ceiling=span[1],
                front=c.front,
                back=c.back,
            )
            drawers.add_drawer(builder, c.look, drawer)
        elif cell.kind is CabinetCellKind.NICHE:
            builder.region(cell.name or "int", (c.left, c.front, span[0]), (c.right, c.back, span[1]))
        elif cell.kind is CabinetCellKind.FALSE:
            _false_front(builder, c, cell, front, top)
        z = top
    return level


def finish_cabinet(builder: AssetBuilder, width: float, depth: float, height: float) -> None:
    """States, keyframes and the `main` region of a cabinet whose left front corner is the origin, metres."""
    joints = [m.name for m in builder.joints]
    if joints:
        builder.door_states(*joints)
        builder.keyframe("closed")
        builder.keyframe("open", **{j: builder.joint_position(j) for j in joints})
    builder.region("main", (0.0, 0.0, 0.0), (width, depth, height))


def _grooved(c: Carcass, cell: CabinetCell) -> bool:
    """True where the front stays below a finger channel."""
    by_top = cell.kind in (CabinetCellKind.DRAWER, CabinetCellKind.FALSE) or cell.handle_height is HandleHeight.HIGH
    fronted = cell.kind not in (CabinetCellKind.OPEN, CabinetCellKind.NICHE, CabinetCellKind.VOID)
    return c.look.handle is HandleKind.FINGER_GROOVE and fronted and by_top


def _clear_span(
    builder: AssetBuilder, c: Carcass, cells: tuple[CabinetCell, ...], k: int, z: float, top: float
) -> Vec2:
    """Lower and upper end of the clear height of a cell, metres; adds the board or the channel above it."""
    cell = cells[k]
    last = k == len(cells) - 1
    bottom = c.floor if k == 0 else z + (BOARD_THICKNESS / 2 if _boarded(cells[k - 1], cell) else 0.0)
    ceiling = top
    if last:
        ceiling = c.height - RAIL_HEIGHT if c.open_top else c.ceiling
    elif _boarded(cell, cells[k + 1]):
        ceiling = top - BOARD_THICKNESS / 2
        layered(builder, c, (c.left, c.front, ceiling), (c.right, c.back, top + BOARD_THICKNESS / 2), 2, True, False)
    if _grooved(c, cell) and last and c.open_top:
        _channel(builder, c, c.height, c.height - CHANNEL_HEIGHT)
        ceiling = min(ceiling, c.height - CHANNEL_HEIGHT)
    elif _grooved(c, cell):
        ceiling = min(ceiling, top) - (CHANNEL_HEIGHT - (BOARD_THICKNESS if last else 0.0))
        _channel(builder, c, c.ceiling if last else top, ceiling)
    return bottom, ceiling


def _boarded(below: CabinetCell, above: CabinetCell) -> bool:
    """True where a board lies between two cells: not between drawers, nor below a sink."""
    return above.kind not in (CabinetCellKind.FALSE, CabinetCellKind.VOID) and not (
        below.kind is CabinetCellKind.DRAWER and above.kind is CabinetCellKind.DRAWER
    )


def _channel(builder: AssetBuilder, c: Carcass, top: float, bottom: float) -> None:
    """An angle of sheet metal: a web behind the fingers, and a foot that reaches to the front."""
    y0, y1 = c.front + 0.0005, c.front + CHANNEL_DEPTH
    top -= BOARD_THICKNESS / 2 + 0.0005
    web = board((c.left, y1, bottom), (c.right, y1 + CHANNEL_SHEET, top), 0.0004)
    flange = board((c.left, y0, bottom), (c.right, y1 - 1e-4, bottom + CHANNEL_SHEET), 0.0004)
    for solid, collider in ((web, True), (flange, False)):
        builder.add(ROOT, solid, c.look.metal, "channel", grain=ACROSS, density="metal_rod", collider=collider)


def _doors(builder: AssetBuilder, c: Carcass, cell: CabinetCell, front: Vec2) -> None:
    left, right = c.x + FRONT_GAP / 2, c.x + c.width - FRONT_GAP / 2
    (z, top), n, r = front, cell.name, cell.handle_height
    if cell.kind is CabinetCellKind.DOOR:
        link = f"{n}door" if n else "door"
        doors = [CabinetDoor(link, f"{link}hinge", cell.hinge, left, z, right - left, top - z, r)]
    else:
        w = (right - left - FRONT_GAP) / 2
        doors = [
            CabinetDoor(f"{n}leftdoor", f"{n}leftdoorhinge", HingeSide.LEFT, left, z, w, top - z, r),
            CabinetDoor(f"{n}rightdoor", f"{n}rightdoorhinge", HingeSide.RIGHT, right - w, z, w, top - z, r),
        ]
    for door in doors:
        hang_door(builder, c.look, door)


def _false_front(builder: AssetBuilder, c: Carcass, cell: CabinetCell, front: Vec2, top: float) -> None:
    """A front that does not move, as before a sink; blocks carry it."""
    front_z0, front_z1 = front
    w, h = c.width - FRONT_GAP, front_z1 - front_z0
    parts = fronts.front_parts(c.look.front, w, h, FRONT_THICKNESS, drawer=True)
    at: Vec3 = (c.x + FRONT_GAP / 2, 0.0, front_z0)
    fronts.add_front(
        builder, ROOT, parts, (w, FRONT_THICKNESS, h), c.look.face, "", label="panel", name="false_front", at=at
    )
    upper = top - CHANNEL_HEIGHT - 0.004 if _grooved(c, cell) else front_z1 - 0.01
    for x in (c.left, c.right - 0.03):
        block = board((x, FRONT_THICKNESS, front_z0 + 0.01), (x + 0.03, c.front + 0.03, upper), 0.0)
        builder.draw(ROOT, block, c.look.inside, "carcass", density="board")


# Housing --------------------------------------------------------------------------------------------------------------

MIN_CELL_HEIGHT = 0.14  # metres, anything over or under a niche

NicheNeighbour = StrEnum("NicheNeighbour", "DOOR DOORS DRAWER DRAWERS OPEN")


class Housing(Params):
    """Tall and hanging cabinets round a niche for an appliance."""

    width: float = Field(0.6, ge=0.45, le=1.3, description="outside, m")
    depth: float = Field(0.6, ge=0.3, le=0.95, description="outside, with fronts, m")
    height: float = Field(2.26, ge=0.5, le=2.7, description="outside, with the plinth, m")
    plinth: float = Field(0.1, ge=0.0, le=0.2, description="height of the plinth, m; 0 where it hangs")
    niche_from: float = Field(
        0.7, ge=0.0, le=1.8, description="height of the niche's floor above the cabinet's foot, m; at 0 it has no floor"
    )
    niche: float = Field(0.6, ge=0.3, le=2.1, description="clear height of the niche, m")
    under: NicheNeighbour = Field(NicheNeighbour.DRAWERS, description="filling below the niche")
    over: NicheNeighbour = Field(NicheNeighbour.DOORS, description="filling above the niche")
    hinge: HingeSide = Field(HingeSide.LEFT, description="side of single doors")
    left_end: bool = Field(True, description="the left side is finished like the fronts")
    right_end: bool = Field(True, description="the right side is finished like the fronts")
    look: CabinetLook = Field(CabinetLook(), description="fronts, handles and finishes")

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
        builder.add(ROOT, floor, look.inside, "floor", density="board")
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
