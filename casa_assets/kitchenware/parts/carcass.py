"""Carcasses of boards of real thickness, edges of worktops, and a column of cells in one carcass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

from pydantic import Field, model_validator

from casa_assets.ext.families import Params
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ACROSS, ALONG, ROOT, UPRIGHT, AssetBuilder, Solid, arc, board
from casa_assets.kitchenware.parts import fronts
from casa_assets.kitchenware.parts.doors import CabinetDoor, HandleHeight, HingeSide, hang_door
from casa_assets.kitchenware.parts.drawers import add_drawer, min_front_height
from casa_assets.kitchenware.parts.fronts import FRONT_THICKNESS, CabinetLook
from casa_assets.kitchenware.parts.handles import HandleKind

CounterEdge = StrEnum("CounterEdge", "SQUARE EASED BEVEL HALF_BULLNOSE BULLNOSE OGEE DUPONT")

BOARD_THICKNESS = 0.018  # metres, boards of a carcass
EDGE_BAND = 0.0012  # edge banding
FACING_THICKNESS = 0.003  # of it, the outer layer that is finished like the fronts
BACK_THICKNESS = 0.004
RAIL_HEIGHT = 0.09  # height of the rails of an open top
FRONT_GAP = 0.003  # between fronts
FRONT_OFFSET = 0.0022  # between the back of a front and the carcass: bumpers and hinges
NICHE_FLOOR = 0.006  # of the board under what stands in a niche on the floor
CHANNEL_DEPTH = 0.032  # from the carcass's edge to the web of the channel behind fronts with a finger groove
PLINTH_SETBACK = 0.07
MAX_DOOR_WIDTH, MIN_PAIR_WIDTH = 0.62, 0.45  # metres; of a door, and of a cabinet with two

# A channel of sheet metal behind fronts with a finger groove: how far the front stays below, and how high it is.
CHANNEL_REVEAL, CHANNEL_HEIGHT = 0.028, 0.062
CHANNEL_SHEET = 0.0025

CabinetCellKind = StrEnum("CabinetCellKind", "DOOR DOORS DRAWER FALSE OPEN NICHE VOID")

MIN_CELL_HEIGHT = 0.14  # metres, anything over or under a niche

NicheNeighbour = StrEnum("NicheNeighbour", "DOOR DOORS DRAWER DRAWERS OPEN")


def profile(edge: CounterEdge, thickness: float) -> list[Vec2]:
    """(inset, z) points from z = -thickness up to z = 0, metres; the edge reaches inset 0."""
    t = thickness
    e = 0.0015
    lower_edge: list[Vec2] = [(e, -t), (0.0, -t + e)]
    if edge is CounterEdge.SQUARE:
        return [(0.0008, -t), (0.0, -t + 0.0008), (0.0, -0.0008), (0.0008, 0.0)]
    if edge is CounterEdge.EASED:
        return [*lower_edge, *arc(0.004, -0.004, 0.004, 180, 90, 3)]
    if edge is CounterEdge.BEVEL:
        b = min(0.012, 0.4 * t)
        return [*lower_edge, (0.0, -b), (b, 0.0)]
    if edge is CounterEdge.HALF_BULLNOSE:
        r = min(0.018, 0.6 * t)
        return [*lower_edge, *arc(r, -r, r, 180, 90, 7)]
    if edge is CounterEdge.BULLNOSE:
        return arc(t / 2, -t / 2, t / 2, 270, 90, 14)
    if edge is CounterEdge.OGEE:
        w, z0, z1 = min(0.012, 0.45 * t), -0.72 * t, -0.0025
        wave = [(w / 2 * (1 - math.cos(math.pi * k / 8)), z0 + (z1 - z0) * k / 8) for k in range(9)]
        return [*lower_edge, *wave, (w + 0.0012, -0.0005), (w + 0.002, 0.0)]
    r = min(0.01, 0.35 * t)
    return [*lower_edge, (0.0, -r - 0.004), (0.003, -r - 0.004 + 1e-4), *arc(0.003 + r, -r, r, 180, 90, 6)]


# Carcass --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Carcass:
    """A box of boards, open in front. Metres; the fronts' faces are at y = 0, the floor at z = 0.

    width, depth, height: outside, with fronts and plinth. plinth: height of the plinth, 0 for no plinth. look:
    finishes. has_fronts: whether doors or drawers are in front of it; otherwise its own edges are at y = 0. open_top:
    two rails instead of the top board, for a sink. open_bottom: no bottom board, for a niche on the floor.
    finished_faces: outer faces that are finished like the fronts, of left, right, bottom, top, back. x: of the outer
    face of the left side. back_from: height at which the back begins. rail_drop: how much lower the front rail of an
    open top is, for a basin whose front is visible. has_plinth: whether it has a separate plinth.
    """

    width: float
    depth: float
    height: float
    plinth: float
    look: CabinetLook
    has_fronts: bool = True
    open_top: bool = False
    open_bottom: bool = False
    finished_faces: tuple[str, ...] = ("left", "right")
    x: float = 0.0
    back_from: float = 0.0
    rail_drop: float = 0.0
    has_plinth: bool = True

    @property
    def front(self) -> float:
        """y of the carcass's front edges."""
        return FRONT_THICKNESS + FRONT_OFFSET if self.has_fronts else 0.0

    @property
    def left(self) -> float:
        """x of the inner face of the left side."""
        return self.x + BOARD_THICKNESS

    @property
    def right(self) -> float:
        """x of the inner face of the right side."""
        return self.x + self.width - BOARD_THICKNESS

    @property
    def back(self) -> float:
        """y of the inner face of the back."""
        return self.depth - (FACING_THICKNESS + BOARD_THICKNESS if "back" in self.finished_faces else BACK_THICKNESS)

    @property
    def floor(self) -> float:
        """z of the upper face of the bottom."""
        return NICHE_FLOOR if self.open_bottom else self.plinth + BOARD_THICKNESS

    @property
    def ceiling(self) -> float:
        """z of the lower face of the top."""
        return self.height - BOARD_THICKNESS


def finished_faces(left: bool, right: bool, *others: str) -> tuple[str, ...]:
    """Names of the outer faces that are finished like the fronts, for `Carcass.finished_faces`."""
    return (*(["left"] if left else []), *(["right"] if right else []), *others)


def build_carcass(builder: AssetBuilder, c: Carcass) -> None:
    """Add the boards of a carcass to the root link."""
    z0 = (0.0 if c.open_bottom else c.plinth) + (FACING_THICKNESS if "bottom" in c.finished_faces else 0.0)
    z1 = c.height - (FACING_THICKNESS if "top" in c.finished_faces else 0.0)
    for name, x0, x1, outer in (("left", c.x, c.left, False), ("right", c.right, c.x + c.width, True)):
        layered(builder, c, (x0, c.front, z0), (x1, c.depth, z1), 0, outer, name in c.finished_faces)
    _levels(builder, c)
    _back(builder, c)
    if c.plinth > 0 and c.has_plinth and not c.open_bottom:
        y = c.front + PLINTH_SETBACK
        x0, x1 = c.x + 0.001, c.x + c.width - 0.001
        kick = board((x0, y, 0.0), (x1, y + 0.016, c.plinth), 0.001)
        builder.add(ROOT, kick, c.look.face, "toe_kick", grain=ACROSS, density="board")
        for x in (x0, x1 - 0.016):
            strip = board((x, y + 0.016, 0.0), (x + 0.016, c.depth - 0.001, c.plinth), 0.001)
            _put(builder, strip, c.look.face, "toe_kick", ALONG)


def _put(builder: AssetBuilder, solid: Solid, finish: str, label: str, grain: Vec3) -> None:
    builder.add(ROOT, solid, finish, label, grain=grain, density="board")


def layered(
    builder: AssetBuilder, c: Carcass, lower: Vec3, upper: Vec3, axis: int, outer: bool, finished: bool
) -> None:
    """A board whose outer layer may be finished like the fronts.

    lower, upper: corners, metres. axis: across its thickness, 0 to 2. outer: whether that layer is at the upper end.
    finished: whether the board has it.
    """
    grain = ACROSS if axis == 2 else UPRIGHT
    full_board = board(lower, upper)
    if axis != 1:  # the edge towards the front is banded like the fronts
        band = board(lower, (upper[0], lower[1] + EDGE_BAND, upper[2]), 0.0004)
        builder.draw(ROOT, band, c.look.face, "carcass", grain=grain, density="board")
        lower = (lower[0], lower[1] + EDGE_BAND, lower[2])
    inner_low, inner_high, skin_low, skin_high = list(lower), list(upper), list(lower), list(upper)
    if finished:
        at = upper[axis] - FACING_THICKNESS if outer else lower[axis] + FACING_THICKNESS
        (inner_high if outer else inner_low)[axis] = at
        (skin_low if outer else skin_high)[axis] = at
        skin = board(_corner(skin_low), _corner(skin_high), 0.0004)
        builder.draw(ROOT, skin, c.look.face, "carcass", grain=grain, density="board")
    inner = board(_corner(inner_low), _corner(inner_high), 0.0004)
    builder.add(ROOT, inner.with_colliders_of(full_board), c.look.inside, "carcass", grain=grain, density="board")


def _corner(values: list[float]) -> Vec3:
    return values[0], values[1], values[2]


def _levels(builder: AssetBuilder, c: Carcass) -> None:
    x0, x1, y1 = c.left, c.right, c.back
    for name, z in (("bottom", c.plinth), ("top", c.height - FACING_THICKNESS)):
        if name in c.finished_faces:
            panel = board((c.x, c.front, z), (c.x + c.width, c.depth, z + FACING_THICKNESS), 0.0004)
            _put(builder, panel, c.look.face, "carcass", ACROSS)
    if not c.open_bottom:
        bottom_z = c.plinth + (FACING_THICKNESS if "bottom" in c.finished_faces else 0.0)
        layered(builder, c, (x0, c.front, bottom_z), (x1, y1, c.floor), 2, False, False)
    if not c.open_top:
        top_z = c.height - (FACING_THICKNESS if "top" in c.finished_faces else 0.0)
        layered(builder, c, (x0, c.front, c.ceiling), (x1, y1, top_z), 2, True, False)
        return
    # The rail stands behind the channel into which fingers reach over the fronts.
    y0 = c.front + (CHANNEL_DEPTH + 0.004 if c.look.handle is HandleKind.FINGER_GROOVE else 0.0)
    z = c.height - c.rail_drop
    _put(builder, board((x0, y0, z - RAIL_HEIGHT), (x1, y0 + BOARD_THICKNESS, z)), c.look.inside, "carcass", ACROSS)
    stay = board((x0, y1 - BOARD_THICKNESS, c.height - RAIL_HEIGHT), (x1, y1, c.height))
    _put(builder, stay, c.look.inside, "carcass", ACROSS)


def _back(builder: AssetBuilder, c: Carcass) -> None:
    z = max(c.plinth, c.back_from)
    top = c.height - (FACING_THICKNESS if "top" in c.finished_faces else 0.0)
    z += FACING_THICKNESS if "bottom" in c.finished_faces and z == c.plinth else 0.0
    lower, upper = (c.left, c.back, z), (c.right, c.depth, top)
    if "back" in c.finished_faces:
        layered(builder, c, lower, upper, 1, True, True)
        return
    _put(builder, board(lower, upper, 0.0), c.look.inside, "carcass", UPRIGHT)


def add_shelves(builder: AssetBuilder, c: Carcass, bottom: float, top: float, count: int, first: int) -> int:
    """Shelves in the room between two heights, with a region over each level.

    bottom, top: clear room, metres. count: of shelves, which divide it evenly. first: number of the lowest level.
    Returns: the number of the next level.
    """
    y0 = c.front + (0.025 if c.has_fronts else 0.0)
    gap = 0.0005  # a shelf lies loose between the sides
    clear = (top - bottom - count * BOARD_THICKNESS) / (count + 1)
    z = bottom
    for k in range(count + 1):
        builder.region(f"level{first + k}", (c.left, c.front, z), (c.right, c.back, z + clear))
        z += clear
        if k < count:
            shelf = board((c.left + gap, y0, z), (c.right - gap, c.back - gap, z + BOARD_THICKNESS))
            builder.add(ROOT, shelf, c.look.inside, "shelf", grain=ACROSS, density="board")
            z += BOARD_THICKNESS
    return first + count + 1


def shelves_for(height: float) -> int:
    """Number of shelves for a clear height in metres. Ref: RoboCasa v1.0, cabinets: levels by height."""
    return next((n for n, top in ((1, 0.6), (2, 0.8), (3, 1.5), (4, 2.0)) if height <= top), 5) - 1


def check_doors(doors: int, width: float) -> None:
    """Raise ValueError where one or two doors do not suit a cabinet of a width in metres."""
    if doors == 1 and width > MAX_DOOR_WIDTH:
        raise ValueError(f"a door of {width} m is too wide; take two")
    if doors == 2 and width < MIN_PAIR_WIDTH:
        raise ValueError(f"two doors need {MIN_PAIR_WIDTH} m, not {width} m")


def check_shelves(clear_height: float, count: int | None) -> None:
    """Raise ValueError if `count` shelves leave less than 0.1 m between them in a clear height in metres."""
    if count and (clear_height - count * BOARD_THICKNESS) / (count + 1) < 0.1:
        raise ValueError(f"{count} shelves in {clear_height:.3f} m leave less than 0.1 m each")


# Cells ----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class CabinetCell:
    """One part of a column, bottom up.

    kind: what it holds. height: of its share of the front, metres; the shares add up to the front's height. shelves:
    how many, None by height. hinge: side of a single door. handle_height: of doors. name: of a drawer (`drawer`,
    `drawer0`) or prefix of doors (``, `upper_`) or region of a niche.
    """

    kind: CabinetCellKind
    height: float
    shelves: int | None = None
    hinge: HingeSide = HingeSide.LEFT
    handle_height: HandleHeight = HandleHeight.HIGH
    name: str = ""


def build_column(builder: AssetBuilder, c: Carcass, cells: Sequence[CabinetCell], level: int = 0) -> int:
    """Add a carcass and its cells, bottom up; `level`: number of its lowest shelf region. Returns that of the next."""
    build_carcass(builder, c)
    z = c.plinth
    for k, cell in enumerate(cells):
        top = z + cell.height
        span = _clear_span(builder, c, cells, k, z, top)
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
            name = cell.name
            names = ("drawer", "slidejoint", "int") if solo else (name, f"{name}_slidejoint", f"{name}_int")
            at, size = (c.x + FRONT_GAP / 2, front[0]), (c.width - FRONT_GAP, front[1] - front[0])
            room = (c.left, c.front, max(span[0], front[0])), (c.right, c.back, span[1])
            add_drawer(builder, c.look, names, at, size, room)
        elif cell.kind is CabinetCellKind.NICHE:
            builder.region(cell.name or "int", (c.left, c.front, span[0]), (c.right, c.back, span[1]))
        elif cell.kind is CabinetCellKind.FALSE:
            _false_front(builder, c, cell, front, top)
        z = top
    return level


def build_cabinet(builder: AssetBuilder, c: Carcass, cells: Sequence[CabinetCell]) -> None:
    """Add a column of cells, bottom up, that is all of a cabinet, with its states, keyframes and region."""
    build_column(builder, c, cells)
    finish_cabinet(builder, c.width, c.depth, c.height)


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


def _clear_span(builder: AssetBuilder, c: Carcass, cells: Sequence[CabinetCell], k: int, z: float, top: float) -> Vec2:
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
    front_z0, front_z1 = front
    w, h = c.width - FRONT_GAP, front_z1 - front_z0
    parts = fronts.front_parts(c.look.front, w, h, FRONT_THICKNESS, drawer=True)
    at: Vec3 = (c.x + FRONT_GAP / 2, 0.0, front_z0)
    face, size = c.look.face, (w, FRONT_THICKNESS, h)
    fronts.add_front(builder, ROOT, parts, size, face, "", label="panel", name="false_front", at=at)
    upper = top - CHANNEL_HEIGHT - 0.004 if _grooved(c, cell) else front_z1 - 0.01
    for x in (c.left, c.right - 0.03):
        block = board((x, FRONT_THICKNESS, front_z0 + 0.01), (x + 0.03, c.front + 0.03, upper), 0.0)
        builder.draw(ROOT, block, c.look.inside, "carcass", density="board")


# Housing --------------------------------------------------------------------------------------------------------------


class Housing(Params):
    """Tall and hanging cabinets round a niche for an appliance."""

    width: float = Field(0.6, ge=0.45, le=1.3, description="outside, m")
    depth: float = Field(0.6, ge=0.3, le=0.95, description="outside, with fronts, m")
    height: float = Field(2.26, ge=0.5, le=2.7, description="outside, with the plinth, m")
    plinth: float = Field(0.1, ge=0.0, le=0.2, description="height of the plinth, m; 0 where it hangs")
    niche_from: float = Field(0.7, ge=0.0, le=1.8, description="height of the niche's floor, m; at 0 it has none")
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
        kinds = (NicheNeighbour.DRAWER, NicheNeighbour.DRAWERS)
        drawers = [height for neighbour, height in parts if neighbour in kinds]
        if any(0 < height < min_front_height(self.look) + 0.02 for height in drawers):
            raise ValueError("too low for a drawer")
        return self


def build_housing(builder: AssetBuilder, p: Housing, panelled: bool = False) -> None:
    """Build the asset: fronts at y = 0, left side x = 0, floor z = 0; `panelled`: inside finished like the fronts."""
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
    build_cabinet(builder, body, cells)


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
