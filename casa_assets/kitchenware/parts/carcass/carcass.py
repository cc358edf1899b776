"""Carcasses of boards of real thickness, and edges of worktops."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, arc, board
from casa_assets.kitchenware.parts.fronts.fronts import FRONT_THICKNESS, CabinetLook
from casa_assets.kitchenware.parts.hardware.handles import HandleKind

# Counter edge ---------------------------------------------------------------------------------------------------------
# Profiles from the underside to the top.

CounterEdge = StrEnum("CounterEdge", "SQUARE EASED BEVEL HALF_BULLNOSE BULLNOSE OGEE DUPONT")


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
# Sides, bottom, top, back, plinth and shelves of boards of real thickness.

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
ACROSS: Vec3 = (1.0, 0.0, 0.0)
ALONG: Vec3 = (0.0, 1.0, 0.0)
UPRIGHT: Vec3 = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Carcass:
    """A box of boards, open in front. Metres; the fronts' faces are at y = 0, the floor at z = 0.

    Attributes:
        width, depth, height: outside, with fronts and plinth. plinth: height of the plinth, 0 for no plinth.
        look: finishes. has_fronts: whether doors or drawers are in front of it; otherwise its own edges are at y = 0.
        open_top: two rails instead of the top board, for a sink. open_bottom: no bottom board, for a niche on the
            floor.
        finished_faces: outer faces that are finished like the fronts, of left, right, bottom, top, back.
        x: of the outer face of the left side. back_from: height at which the back begins.
        rail_drop: how much lower the front rail of an open top is, for a basin whose front is visible.
        has_plinth: whether it has a separate plinth.
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
        # A recessed board in front, and the strips that carry the sides.
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

    Args:
        lower, upper: corners, metres. axis: across its thickness, 0 to 2.
        outer: whether that layer is at the upper end. finished: whether the board has it.
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
    """Add bottom and top, or the rails that replace a top."""
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
    rail = board((x0, y0, z - RAIL_HEIGHT), (x1, y0 + BOARD_THICKNESS, z))
    _put(builder, rail, c.look.inside, "carcass", ACROSS)
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

    Args:
        bottom, top: clear room, metres. count: of shelves, which divide it evenly. first: number of the lowest level.
    Returns:
        The number of the next level.
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
    levels = next((n for n, top in ((1, 0.6), (2, 0.8), (3, 1.5), (4, 2.0)) if height <= top), 5)
    return levels - 1


MAX_DOOR_WIDTH, MIN_PAIR_WIDTH = 0.62, 0.45  # metres; of a door, and of a cabinet with two


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
