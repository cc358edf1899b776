"""Fronts of doors and drawers: a style, a kind and a size become boards, panels and panes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import (
    ACROSS,
    UPRIGHT,
    AssetBuilder,
    Placed,
    Solid,
    board,
    box,
    box_shape,
    loft,
    mitred_frame,
    offset_sides,
    prism,
    subtract,
)
from casa_assets.kitchenware.parts.handles import HandleKind

PANEL_TONGUE = 0.005  # metres by which a panel sits in the groove of its frame
GLAZING_BAR_WIDTH = 0.018  # width of glazing bars

FRONT_THICKNESS = 0.02  # metres; fronts are 19 to 22 mm
FRONT_EDGE_RADIUS = 0.0012
GROOVE_LIP = 0.007  # metres, thickness of the lip in front of a finger groove
GROOVE_DEPTH = 0.03  # metres that a finger groove reaches in from the edge

FrontKind = StrEnum(
    "FrontKind",
    "SLAB SHAKER SLIM_SHAKER RAISED ARCHED BEADBOARD V_GROOVE FLUTED LOUVRED GLASS_CLEAR GLASS_FROSTED GLASS_DIVIDED",
)

# An edge of a front, seen from before it.
FrontEdge = StrEnum("FrontEdge", "TOP BOTTOM LEFT RIGHT")

GLAZED_KINDS = (FrontKind.GLASS_CLEAR, FrontKind.GLASS_FROSTED, FrontKind.GLASS_DIVIDED)
# What a drawer has where the doors beside it are made so.
DRAWER_KINDS = {
    FrontKind.ARCHED: FrontKind.RAISED, FrontKind.BEADBOARD: FrontKind.SHAKER, FrontKind.LOUVRED: FrontKind.SHAKER,
    FrontKind.GLASS_CLEAR: FrontKind.SLIM_SHAKER, FrontKind.GLASS_FROSTED: FrontKind.SLIM_SHAKER,
    FrontKind.GLASS_DIVIDED: FrontKind.SHAKER,
}  # fmt: skip
# Width of stiles: as joiners cut them; a frame of thin metal or wood round a large pane.
STILE_WIDTHS = {
    FrontKind.SLIM_SHAKER: 0.02, FrontKind.GLASS_CLEAR: 0.045, FrontKind.GLASS_FROSTED: 0.045, FrontKind.ARCHED: 0.062,
}  # fmt: skip
STILE_WIDTH = 0.06

GLASS_THICKNESS = 0.004  # metres
SASH_BAR_WIDTH = 0.02


# Panels ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FrameOpening:
    """A hole in a frame, front's frame, metres; where `rise` is not 0 its top is an arc that rises by that much."""

    x0: float
    z0: float
    x1: float
    z1: float
    rise: float = 0.0

    @property
    def width(self) -> float:
        """Metres."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """Metres, in its middle."""
        return self.z1 - self.z0

    def outline(self, grown: float = 0.0) -> Floats:
        """(N, 2) points x, z, counter-clockwise, moved outwards by metres."""
        top = arc(self.x0, self.x1, self.z1, self.rise)[::-1] if self.rise else [(self.x1, self.z1), (self.x0, self.z1)]
        loop = np.array([(self.x0, self.z0), (self.x1, self.z0), *top])
        return offset_sides(loop, [-grown] * len(loop)) if grown else loop


def arc(x0: float, x1: float, top: float, rise: float, steps: int = 14) -> list[Vec2]:
    """(x, z) points of a circle's arc from left to right that is highest, at `top`, in the middle."""
    half = (x1 - x0) / 2
    radius = (half * half + rise * rise) / (2 * rise)
    reach = math.asin(half / radius)
    turns = np.linspace(-reach, reach, steps + 1)
    middle = (x0 + x1) / 2
    return [(float(middle + radius * math.sin(a)), float(top - radius * (1 - math.cos(a)))) for a in turns]


def flat_panel(o: FrameOpening, recess: float) -> Solid:
    """A flat panel behind the face by `recess`."""
    e = PANEL_TONGUE
    return board((o.x0 - e, recess, o.z0 - e), (o.x1 + e, recess + 0.008, o.z1 + e), 0.0)


def raised_panel(o: FrameOpening, t: float) -> Solid:
    """A panel whose middle field is raised above bevelled edges."""
    outline = o.outline(PANEL_TONGUE)
    bevel = min(0.038, 0.28 * min(o.width, o.height))
    steps = [
        (0.0, t - 0.004), (0.0, 0.0115), (PANEL_TONGUE + 0.006, 0.011), (PANEL_TONGUE + bevel, 0.0045),
        (PANEL_TONGUE + bevel + 0.0004, 0.0028), (PANEL_TONGUE + bevel + 0.0016, 0.002),
    ]  # fmt: skip
    rings = []
    for inset, y in steps:
        loop = offset_sides(outline, [inset] * len(outline)) if inset else outline
        rings.append(np.column_stack([loop[:, 0], np.full(len(loop), y), loop[:, 1]]))
    return loft(rings, 20.0)


def frame_moulding(o: FrameOpening) -> list[Solid]:
    """The moulding round the inside of a frame; none along an arc."""
    if o.rise:
        return []
    turns = np.linspace(0.0, math.pi / 2, 5)
    round_ = [(-0.0085 * math.sin(a), -0.0015 - 0.008 * (1 - math.cos(a))) for a in turns]
    profile = np.array([(0.002, -0.013), (0.002, -0.0015), *round_, (-0.0085, -0.013)])
    middle = ((o.x0 + o.x1) / 2, (o.z0 + o.z1) / 2)
    return [mitred_frame(o.width, o.height, profile).translated(middle[0], 0.0, middle[1])]


def beaded_panel(o: FrameOpening) -> Solid:
    """Narrow boards with a bead at each joint."""
    x0, x1 = o.x0 - PANEL_TONGUE, o.x1 + PANEL_TONGUE
    width = x1 - x0
    count = max(2, round(width / 0.045))
    pitch = width / count
    line: list[Vec2] = [(0.0, 0.0)]
    for k in range(1, count):
        x = k * pitch
        bead = [(x + 0.0032 - 0.0032 * math.cos(a), 0.0018 - 0.0018 * math.sin(a)) for a in np.linspace(0, math.pi, 5)]
        line += [(x - 0.0022, 0.0), (x - 0.0008, 0.0028), (x, 0.0024), *bead[1:-1], (x + 0.0064, 0.0024)]
        line += [(x + 0.0072, 0.0028), (x + 0.0086, 0.0)]
    line.append((width, 0.0))
    solid = prism(np.concatenate([np.array(line), [(width, 0.006), (0.0, 0.006)]]), o.height + 2 * PANEL_TONGUE, 0.0)
    return solid.translated(x0, 0.008, o.z0 - PANEL_TONGUE)


def v_groove_line(width: float, pitch: float, half: float, depth: float) -> Floats:
    """(N, 2) front line x, y of a board with V grooves, from left to right."""
    count = max(2, round(width / pitch))
    line: list[Vec2] = [(0.0, 0.001), (0.001, 0.0)]
    for k in range(1, count):
        x = width * k / count
        line += [(x - half, 0.0), (x, depth), (x + half, 0.0)]
    return np.array([*line, (width - 0.001, 0.0), (width, 0.001)])


def reeded_line(width: float, pitch: float, depth: float) -> Floats:
    """(N, 2) front line x, y of a row of half-round reeds, from left to right."""
    count = max(3, round(width / pitch))
    step = width / count
    line = [(0.0, depth)]
    for k in range(count):
        for a in np.linspace(0.0, math.pi, 7)[1:-1]:
            line.append((step * (k + (1 - math.cos(a)) / 2), depth * (1 - math.sin(a))))
        line.append((step * (k + 1), depth))
    return np.array(line)


def louvres(o: FrameOpening, t: float) -> list[Solid]:
    """Louvres that slope down to the front and hide what is behind them."""
    tilt = math.radians(52)
    length = (t - 0.005) / math.cos(tilt)
    count = max(2, math.ceil(o.height / (0.92 * length * math.sin(tilt))))
    pitch = o.height / count
    slat = box((o.width + 0.006, length, 0.005), (0.0, 0.0, 0.0), 0.002).rotated("x", tilt)
    middle = (o.x0 + o.x1) / 2
    return [slat.translated(middle, t / 2, o.z0 + (k + 0.5) * pitch) for k in range(count)]


def glazing_beads(o: FrameOpening, t: float) -> list[Solid]:
    """Thin beads that hold a pane from before it."""
    y0, y1, width = 0.0035, t / 2 - 0.0024, 0.005
    out = [board((x, y0, o.z0), (x + width, y1, o.z1), 0.0008) for x in (o.x0, o.x1 - width)]
    inner = (o.x0 + width, o.x1 - width)
    return out + [board((inner[0], y0, z), (inner[1], y1, z + width), 0.0008) for z in (o.z0, o.z1 - width)]


def muntins(o: FrameOpening, t: float) -> list[tuple[Solid, Vec3]]:
    """Bars that divide a pane, before and behind it, with their grain."""
    columns = max(1, round(o.width / 0.2))
    rows = max(2, round(o.height / 0.24))
    out: list[tuple[Solid, Vec3]] = []
    for k in range(1, columns):
        x = o.x0 + o.width * k / columns
        out.append(
            (
                board((x - GLAZING_BAR_WIDTH / 2, 0.002, o.z0), (x + GLAZING_BAR_WIDTH / 2, t - 0.002, o.z1), 0.003),
                UPRIGHT,
            )
        )
    for k in range(1, rows):
        z = o.z0 + o.height * k / rows
        out.append(
            (
                board((o.x0, 0.0024, z - GLAZING_BAR_WIDTH / 2), (o.x1, t - 0.0024, z + GLAZING_BAR_WIDTH / 2), 0.003),
                ACROSS,
            )
        )
    return out


def arched_rail(x0: float, x1: float, z: float, rise: float, top: float, t: float) -> Solid:
    """The upper rail of a frame above an arch: its sides reach down to z, the crown of the arch is at z + rise."""
    outline = np.array([*arc(x0, x1, z + rise, rise), (x1, top), (x0, top)])
    return prism(outline, t, 0.0008).rotated("x", math.pi / 2).translated(0.0, t, 0.0)


# Fronts ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FrontPart:
    """A board or a pane of a front.

    solid: the front's lower left corner is the origin, its face lies in y = 0 and looks to -y. Metres. pane: whether it
    is glass. grain: direction of its grain.
    """

    solid: Solid
    pane: bool = False
    grain: Vec3 = UPRIGHT


def front_parts(
    kind: FrontKind,
    width: float,
    height: float,
    thickness: float = FRONT_THICKNESS,
    drawer: bool = False,
    groove: FrontEdge | None = None,
) -> tuple[FrontPart, ...]:
    """The parts of a front, without colliders: give it one box.

    kind: how it is made; small fronts that leave no room for a panel are slabs. width, height, thickness: metres.
    drawer: lies across: glass and louvres become panels, and the grain of a slab runs across. groove: the edge that is
    hollowed from behind, so that fingers can take hold of the lip. Returns: boards and panes; x from 0 to width, y from
    0 (face) to thick, z from 0 to height.
    """
    kind = DRAWER_KINDS.get(kind, kind) if drawer else kind
    stile, rail = frame_widths(kind, width, height, drawer)
    opening_size = min(width - 2 * stile, height - 2 * rail)
    if kind in (FrontKind.SLAB, FrontKind.V_GROOVE, FrontKind.FLUTED) or opening_size < 0.03:
        parts = _plain(kind, width, height, thickness, drawer)
    else:
        out = [
            FrontPart(board((x, 0.0, 0.0), (x + stile, thickness, height), FRONT_EDGE_RADIUS))
            for x in (0.0, width - stile)
        ]
        rise = min(0.055, 0.2 * (width - 2 * stile)) if kind is FrontKind.ARCHED else 0.0
        splits = _splits(kind, height, rail, rise)
        last = len(splits) - 1
        for k, z in enumerate(splits):
            if rise and k == last:
                solid = arched_rail(stile, width - stile, z, rise, height, thickness)
            else:
                solid = board((stile, 0.0, z), (width - stile, thickness, z + rail), FRONT_EDGE_RADIUS)
            out.append(FrontPart(solid, grain=ACROSS))
        for k in range(last):
            arch = rise if k == last - 1 else 0.0
            out += _filled(
                kind, FrameOpening(stile, splits[k] + rail, width - stile, splits[k + 1] + arch, arch), thickness
            )
        parts = tuple(out)
    return parts if groove is None else tuple(_grooved(part, width, height, thickness, groove) for part in parts)


def frame_widths(kind: FrontKind, width: float, height: float, drawer: bool = False) -> Vec2:
    """Width of the stiles and of the rails of a front, metres, where it has a frame."""
    kind = DRAWER_KINDS.get(kind, kind) if drawer else kind
    usual = STILE_WIDTHS.get(kind, STILE_WIDTH)
    return min(usual, 0.24 * width), min(usual, 0.3 * height if drawer else 0.2 * height)


def has_frame(kind: FrontKind) -> bool:
    """True where a front of the kind has stiles wide enough to carry a handle."""
    return kind not in (FrontKind.SLAB, FrontKind.V_GROOVE, FrontKind.FLUTED, FrontKind.SLIM_SHAKER)


def add_front(
    builder: AssetBuilder,
    link: str,
    parts: tuple[FrontPart, ...],
    size: Vec3,
    finish: str,
    glass: str,
    *,
    label: str = "door",
    name: str | None = None,
    at: Vec3 = (0.0, 0.0, 0.0),
    groove: FrontEdge | None = None,
    grip: str | None = None,
) -> None:
    """Put a front on a link, with one box as collider; one with a groove as a box and the lip before the groove.

    parts: of `front`. size: its width, thickness, height, metres. finish, glass: of boards and panes. name: of its
    collider; its mesh is `<name>_visual`. at: of its lower left front corner, link frame. groove: as it was given to
    `front`. grip: name of the lip's collider.
    """
    for part in parts:
        solid = part.solid.translated(*at)
        if part.pane:
            builder.draw(link, solid, glass, "glass", density="glass")
        else:
            builder.draw(link, solid, finish, label, name, part.grain, density="board")
    lower, upper = [0.0, 0.0, 0.0], list(size)
    if groove in (FrontEdge.TOP, FrontEdge.RIGHT):
        upper[2 if groove is FrontEdge.TOP else 0] -= GROOVE_DEPTH
    elif groove is not None:
        lower[2 if groove is FrontEdge.BOTTOM else 0] += GROOVE_DEPTH
    full_box = board((lower[0], lower[1], lower[2]), (upper[0], upper[1], upper[2]), 0.0)
    builder.add_collider(link, full_box.translated(*at), finish, label, name)
    if groove is not None:
        lip_box = full_box.with_shapes(lip(size[0], size[2], groove))
        builder.add_collider(link, lip_box.translated(*at), finish, "handle", grip)


def glass_of(kind: FrontKind) -> str:
    """Finish of the panes of a kind."""
    return "glass_frosted" if kind is FrontKind.GLASS_FROSTED else "glass_clear"


def face_depth(parts: tuple[FrontPart, ...], points: Sequence[Vec2]) -> float:
    """Largest depth of the wood behind the face at points x, z of a front, metres."""
    corners = np.concatenate([p.solid.points[p.solid.faces] for p in parts if not p.pane])
    depths = [_hit(corners, x, z) for x, z in points]
    return max([y for y in depths if y is not None], default=0.0)


def _hit(corners: np.ndarray, x: float, z: float) -> float | None:
    """Least y at which a line along y through x, z meets (F, 3, 3) triangles."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ux, uz, vx, vz = b[:, 0] - a[:, 0], b[:, 2] - a[:, 2], c[:, 0] - a[:, 0], c[:, 2] - a[:, 2]
    det = ux * vz - uz * vx
    safe = np.where(np.abs(det) < 1e-12, np.inf, det)
    s = ((x - a[:, 0]) * vz - (z - a[:, 2]) * vx) / safe
    t = (ux * (z - a[:, 2]) - uz * (x - a[:, 0])) / safe
    inside = (np.abs(det) > 1e-12) & (s >= 0) & (t >= 0) & (s + t <= 1)
    return float((a[:, 1] + s * (b[:, 1] - a[:, 1]) + t * (c[:, 1] - a[:, 1]))[inside].min()) if inside.any() else None


def lip(width: float, height: float, groove: FrontEdge) -> Placed:
    """The lip that a hand takes of a grooved front, as a collision box in the front's frame."""
    lower = {
        FrontEdge.TOP: (0.0, 0.0, height - GROOVE_DEPTH), FrontEdge.BOTTOM: (0.0, 0.0, 0.0),
        FrontEdge.LEFT: (0.0, 0.0, 0.0), FrontEdge.RIGHT: (width - GROOVE_DEPTH, 0.0, 0.0),
    }[groove]  # fmt: skip
    across, up = (width, GROOVE_DEPTH) if (groove in (FrontEdge.TOP, FrontEdge.BOTTOM)) else (GROOVE_DEPTH, height)
    return box_shape(lower, (lower[0] + across, GROOVE_LIP, lower[2] + up))


def _plain(kind: FrontKind, w: float, h: float, t: float, drawer: bool) -> tuple[FrontPart, ...]:
    if kind is FrontKind.V_GROOVE:
        line = v_groove_line(w, 0.1, 0.003, 0.003)
    elif kind is FrontKind.FLUTED:
        line = reeded_line(w, 0.024, 0.0045)
    else:
        return (FrontPart(board((0.0, 0.0, 0.0), (w, t, h), FRONT_EDGE_RADIUS), grain=(ACROSS if drawer else UPRIGHT)),)
    return (FrontPart(prism(np.concatenate([line, [(w, t), (0.0, t)]]), h, 0.0)),)


def _splits(kind: FrontKind, h: float, rail: float, rise: float) -> list[float]:
    top = h - rail - rise
    if kind in (FrontKind.SLIM_SHAKER, FrontKind.GLASS_CLEAR, FrontKind.GLASS_FROSTED) or h < 1.25:
        return [0.0, top]
    return [0.0, 0.42 * h - rail / 2, top]


def _filled(kind: FrontKind, opening: FrameOpening, t: float) -> list[FrontPart]:
    if kind in GLAZED_KINDS:
        bars = muntins(opening, t) if kind is FrontKind.GLASS_DIVIDED else []
        stops = [FrontPart(s) for s in glazing_beads(opening, t)]
        e, o = PANEL_TONGUE, opening
        pane = board((o.x0 - e, t / 2 - 0.002, o.z0 - e), (o.x1 + e, t / 2 + 0.002, o.z1 + e), 0.0)
        return [FrontPart(pane, pane=True), *stops, *(FrontPart(s, grain=g) for s, g in bars)]
    if kind is FrontKind.LOUVRED:
        return [FrontPart(s, grain=ACROSS) for s in louvres(opening, t)]
    if kind is FrontKind.BEADBOARD:
        return [FrontPart(beaded_panel(opening))]
    if kind is FrontKind.RAISED or kind is FrontKind.ARCHED:
        return [FrontPart(raised_panel(opening, t)), *(FrontPart(s) for s in frame_moulding(opening))]
    return [FrontPart(flat_panel(opening, 0.006 if kind is FrontKind.SLIM_SHAKER else 0.008))]


def _grooved(part: FrontPart, w: float, h: float, t: float, edge: FrontEdge) -> FrontPart:
    margin = 0.05
    lower, upper = [-margin, GROOVE_LIP, -margin], [w + margin, t + margin, h + margin]
    axis, at_end = (
        (2, edge is FrontEdge.TOP) if edge in (FrontEdge.TOP, FrontEdge.BOTTOM) else (0, edge is FrontEdge.RIGHT)
    )
    if at_end:
        lower[axis] = (h if axis == 2 else w) - GROOVE_DEPTH
    else:
        upper[axis] = GROOVE_DEPTH
    bounds = part.solid.bounds
    if (bounds[1] <= np.array(lower)).any() or (bounds[0] >= np.array(upper)).any() or part.pane:
        return part
    tool = board((lower[0], lower[1], lower[2]), (upper[0], upper[1], upper[2]), 0.004, 3)
    return replace(part, solid=subtract(part.solid, tool))


class CabinetLook(Params):
    """Style that all cabinets of a kitchen share: front, handle and finishes."""

    front: FrontKind = Field(FrontKind.SHAKER, description="kind of door and drawer front")
    handle: HandleKind = Field(HandleKind.BAR, description="kind of handle")
    length: float = Field(0.16, ge=0.06, le=1.2, description="of bars and straps, m")
    face: FinishId = Field("painted_white", description="finish of fronts and of what is seen of the sides")
    inside: FinishId = Field("melamine_white", description="finish of carcass and shelves")
    tray: FinishId = Field("beech_plain", description="finish of drawer boxes")
    metal: FinishId = Field("stainless_brushed", description="finish of handles")


# Glazing --------------------------------------------------------------------------------------------------------------


def add_sash(
    builder: AssetBuilder,
    link: str,
    size: Vec3,
    *,
    stile: float,
    grid: tuple[int, int],
    finish: str,
    glass: str,
    name: str,
    label: str = "window",
    at: Vec3 = (0.0, 0.0, 0.0),
) -> None:
    """Put a sash on a link: its lower left front corner at `at`, with one box as collider.

    size: width, depth (towards +y), height, metres. stile: width of the frame's boards. grid: columns and rows of
    panes. name: of its collider and of its mesh.
    """
    w, d, h = size
    e = 0.002
    for solid in [board((0, 0, 0), (stile, d, h), e), board((w - stile, 0, 0), (w, d, h), e)]:
        builder.draw(link, solid.translated(*at), finish, label)
    for z in (0.0, h - stile):
        rail = board((stile - 5e-4, 2e-4, z), (w - stile + 5e-4, d - 2e-4, z + stile), e)
        builder.draw(link, rail.translated(*at), finish, label, grain=ACROSS)
    pane = board(
        (stile - 0.004, d / 2 - GLASS_THICKNESS / 2, stile - 0.004),
        (w - stile + 0.004, d / 2 + GLASS_THICKNESS / 2, h - stile + 0.004),
        0.0,
    )
    builder.draw(link, pane.translated(*at), glass, "glass")
    columns, rows = grid
    y0, y1 = d / 2 - 0.011, d / 2 + 0.011
    for k in range(1, columns):
        x = stile + (w - 2 * stile) * k / columns
        bar = board((x - SASH_BAR_WIDTH / 2, y0, stile - 5e-4), (x + SASH_BAR_WIDTH / 2, y1, h - stile + 5e-4), e)
        builder.draw(link, bar.translated(*at), finish, label)
    for k in range(1, rows):
        z = stile + (h - 2 * stile) * k / rows
        bar = board(
            (stile - 5e-4, y0 + 4e-4, z - SASH_BAR_WIDTH / 2), (w - stile + 5e-4, y1 - 4e-4, z + SASH_BAR_WIDTH / 2), e
        )
        builder.draw(link, bar.translated(*at), finish, label, grain=ACROSS)
    builder.add_collider(link, board((0, 0, 0), (w, d, h), 0.0).translated(*at), finish, label, name)
