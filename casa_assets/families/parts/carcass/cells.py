"""A column of cells: doors, drawers, false fronts, open shelves and niches stacked in one carcass."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from casa_assets.families.kit.asset_builder import ROOT, Bench
from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.parts.carcass.carcass import (
    ACROSS,
    CHANNEL_DEEP,
    GAP,
    RAIL,
    WALL,
    Carcass,
    layered,
    raise_carcass,
    shelve,
    shelves_for,
)
from casa_assets.families.parts.fronts import drawers, fronts
from casa_assets.families.parts.fronts.doors import Leaf, Reach, Side, hang
from casa_assets.families.parts.fronts.drawers import Drawer
from casa_assets.families.parts.fronts.fronts import THICK
from casa_assets.families.parts.hardware.handles import HandleKind
from casa_assets.model.record import Vec3

# A channel of sheet metal behind fronts with a finger groove: how far the front stays below, and how high it is.
REVEAL, CHANNEL_HIGH = 0.028, 0.062
SHEET = 0.0025


class CellKind(StrEnum):
    """What a cell of a column holds."""

    DOOR = "door"
    DOORS = "doors"
    DRAWER = "drawer"
    FALSE = "false"
    OPEN = "open"
    NICHE = "niche"
    VOID = "void"


@dataclass(frozen=True)
class Cell:
    """One part of a column, bottom up.

    Attributes:
        kind: what it holds. height: of its share of the front, metres; the shares add up to the front's height.
        shelves: how many, None by height. hinge: side of a single door. reach: where doors are taken.
        name: of a drawer (`drawer`, `drawer0`) or prefix of doors (``, `upper_`) or region of a niche.
    """

    kind: CellKind
    height: float
    shelves: int | None = None
    hinge: Side = Side.LEFT
    reach: Reach = Reach.HIGH
    name: str = ""


def build_column(bench: Bench, c: Carcass, cells: tuple[Cell, ...], level: int = 0) -> int:
    """Put a carcass and all its cells on the bench.

    Args:
        cells: bottom up. level: number of its lowest shelf region.
    Returns:
        The number of the next one.
    """
    raise_carcass(bench, c)
    z = c.plinth
    for k, cell in enumerate(cells):
        top = z + cell.height
        last = k == len(cells) - 1
        room = _room(bench, c, cells, k, z, top)
        if cell.kind in (CellKind.DOOR, CellKind.DOORS):
            _doors(bench, c, cell, z, top, last)
            count = shelves_for(room[1] - room[0]) if cell.shelves is None else cell.shelves
            level = shelve(bench, c, *room, count, level)
        elif cell.kind is CellKind.OPEN:
            level = shelve(bench, c, *room, cell.shelves or 0, level)
        elif cell.kind is CellKind.DRAWER:
            _drawer(bench, c, cell, z, top, room)
        elif cell.kind is CellKind.NICHE:
            bench.region(cell.name or "int", (c.left, c.front, room[0]), (c.right, c.back, room[1]))
        elif cell.kind is CellKind.FALSE:
            _false_front(bench, c, cell, z, top)
        z = top
    return level


def finish(bench: Bench, width: float, depth: float, height: float) -> None:
    """States, keyframes and the `main` region of a cabinet whose left front corner is the origin, metres."""
    joints = [m.name for m in bench.moved]
    if joints:
        bench.door_states(*joints)
        bench.keyframe("closed")
        bench.keyframe("open", **{j: bench.far(j) for j in joints})
    bench.region("main", (0.0, 0.0, 0.0), (width, depth, height))


def _grooved(c: Carcass, cell: Cell) -> bool:
    """Whether the front stays below a channel for the fingers."""
    by_top = cell.kind in (CellKind.DRAWER, CellKind.FALSE) or cell.reach is Reach.HIGH
    fronted = cell.kind not in (CellKind.OPEN, CellKind.NICHE, CellKind.VOID)
    return c.look.handle is HandleKind.FINGER_GROOVE and fronted and by_top


def _gaps(c: Carcass, cell: Cell, z: float, top: float, last: bool) -> tuple[float, float]:
    """Lower and upper edge of a cell's front."""
    upper = REVEAL if _grooved(c, cell) else GAP if last else GAP / 2
    return z + (GAP / 2 if z > c.plinth else 0.0), top - upper


def _room(bench: Bench, c: Carcass, cells: tuple[Cell, ...], k: int, z: float, top: float) -> tuple[float, float]:
    """Clear heights of a cell; puts the board over it, or the channel."""
    cell = cells[k]
    last = k == len(cells) - 1
    low = c.floor if k == 0 else z + (WALL / 2 if _boarded(cells[k - 1], cell) else 0.0)
    high = top
    if last:
        high = c.height - RAIL if c.open_top else c.ceiling
    elif _boarded(cell, cells[k + 1]):
        high = top - WALL / 2
        layered(bench, c, (c.left, c.front, high), (c.right, c.back, top + WALL / 2), 2, True, False)
    if _grooved(c, cell) and last and c.open_top:
        _channel(bench, c, c.height, c.height - CHANNEL_HIGH)
        high = min(high, c.height - CHANNEL_HIGH)
    elif _grooved(c, cell):
        high = min(high, top) - (CHANNEL_HIGH - (WALL if last else 0.0))
        _channel(bench, c, c.ceiling if last else top, high)
    return low, high


def _boarded(below: Cell, above: Cell) -> bool:
    """Whether a board lies between two cells: not between drawers, nor below a sink."""
    return above.kind not in (CellKind.FALSE, CellKind.VOID) and not (
        below.kind is CellKind.DRAWER and above.kind is CellKind.DRAWER
    )


def _channel(bench: Bench, c: Carcass, top: float, low: float) -> None:
    """An angle of sheet metal: a web behind the fingers, and a foot that reaches to the front."""
    y0, y1 = c.front + 0.0005, c.front + CHANNEL_DEEP
    top -= WALL / 2 + 0.0005
    web = board((c.left, y1, low), (c.right, y1 + SHEET, top), 0.0004)
    foot = board((c.left, y0, low), (c.right, y1 - 1e-4, low + SHEET), 0.0004)
    for solid, touched in ((web, True), (foot, False)):
        bench.add(ROOT, solid, c.look.metal, label="channel", grain=ACROSS, density="metal_rod", touch=touched)


def _doors(bench: Bench, c: Carcass, cell: Cell, z: float, top: float, last: bool) -> None:
    low, high = _gaps(c, cell, z, top, last)
    left, right = c.x + GAP / 2, c.x + c.width - GAP / 2
    n, r = cell.name, cell.reach
    if cell.kind is CellKind.DOOR:
        link = f"{n}door" if n else "door"
        leaves = [Leaf(link, f"{link}hinge", cell.hinge, left, low, right - left, high - low, r)]
    else:
        w = (right - left - GAP) / 2
        leaves = [
            Leaf(f"{n}leftdoor", f"{n}leftdoorhinge", Side.LEFT, left, low, w, high - low, r),
            Leaf(f"{n}rightdoor", f"{n}rightdoorhinge", Side.RIGHT, right - w, low, w, high - low, r),
        ]
    for leaf in leaves:
        hang(bench, c.look, leaf)


def _drawer(bench: Bench, c: Carcass, cell: Cell, z: float, top: float, room: tuple[float, float]) -> None:
    low, high = _gaps(c, cell, z, top, top >= c.height - 1e-6)
    solo = cell.name in ("", "drawer")
    link = "drawer" if solo else cell.name
    drawer = Drawer(
        link=link,
        joint="slidejoint" if solo else f"{link}_slidejoint",
        region="int" if solo else f"{link}_int",
        x=c.x + GAP / 2,
        z=low,
        width=c.width - GAP,
        height=high - low,
        left=c.left,
        right=c.right,
        floor=max(room[0], low),
        ceiling=room[1],
        front=c.front,
        back=c.back,
    )
    drawers.fit(bench, c.look, drawer)


def _false_front(bench: Bench, c: Carcass, cell: Cell, z: float, top: float) -> None:
    """A front that does not move, as before a sink; blocks carry it."""
    low, high = _gaps(c, cell, z, top, top >= c.height - 1e-6)
    w, h = c.width - GAP, high - low
    parts = fronts.front(c.look.front, w, h, THICK, drawer=True)
    at: Vec3 = (c.x + GAP / 2, 0.0, low)
    fronts.lay(bench, ROOT, parts, (w, THICK, h), c.look.face, "", label="panel", name="false_front", at=at)
    upper = top - CHANNEL_HIGH - 0.004 if _grooved(c, cell) else high - 0.01
    for x in (c.left, c.right - 0.03):
        block = board((x, THICK, low + 0.01), (x + 0.03, c.front + 0.03, upper), 0.0)
        bench.add(ROOT, block, c.look.inside, label="carcass", touch=False, density="board")
