"""Fronts of doors and drawers: a kind and a size become boards, panels and panes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.kit.solids.boolean import subtract
from casa_assets.families.kit.solids.solid import Placed, Solid, box_shape
from casa_assets.families.kit.solids.sweep import prism
from casa_assets.families.parts.fronts import panels
from casa_assets.families.parts.fronts.panels import ACROSS, UPRIGHT, FrameOpening
from casa_assets.model.record import Vec3

FRONT_THICKNESS = 0.02  # metres; fronts are 19 to 22 mm
FRONT_EDGE_RADIUS = 0.0012
GROOVE_LIP = 0.007  # metres, thickness of the lip in front of a finger groove
GROOVE_DEPTH = 0.03  # metres that a finger groove reaches in from the edge


class FrontKind(StrEnum):
    """Construction of a front."""

    SLAB = "slab"
    SHAKER = "shaker"
    SLIM_SHAKER = "slim_shaker"
    RAISED = "raised"
    ARCHED = "arched"
    BEADBOARD = "beadboard"
    V_GROOVE = "v_groove"
    FLUTED = "fluted"
    LOUVRED = "louvred"
    GLASS_CLEAR = "glass_clear"
    GLASS_FROSTED = "glass_frosted"
    GLASS_DIVIDED = "glass_divided"


class FrontEdge(StrEnum):
    """An edge of a front, seen from before it."""

    TOP = "top"
    BOTTOM = "bottom"
    LEFT = "left"
    RIGHT = "right"


GLAZED_KINDS = (FrontKind.GLASS_CLEAR, FrontKind.GLASS_FROSTED, FrontKind.GLASS_DIVIDED)
# What a drawer has where the doors beside it are made so.
DRAWER_KINDS = {
    FrontKind.ARCHED: FrontKind.RAISED,
    FrontKind.BEADBOARD: FrontKind.SHAKER,
    FrontKind.LOUVRED: FrontKind.SHAKER,
    FrontKind.GLASS_CLEAR: FrontKind.SLIM_SHAKER,
    FrontKind.GLASS_FROSTED: FrontKind.SLIM_SHAKER,
    FrontKind.GLASS_DIVIDED: FrontKind.SHAKER,
}
# Width of stiles: as joiners cut them; a frame of thin metal or wood round a large pane.
STILE_WIDTHS = {
    FrontKind.SLIM_SHAKER: 0.02,
    FrontKind.GLASS_CLEAR: 0.045,
    FrontKind.GLASS_FROSTED: 0.045,
    FrontKind.ARCHED: 0.062,
}
STILE_WIDTH = 0.06


@dataclass(frozen=True)
class FrontPart:
    """A board or a pane of a front.

    Attributes:
        solid: the front's lower left corner is the origin, its face lies in y = 0 and looks to -y. Metres.
        pane: whether it is glass. grain: direction of its grain.
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

    Args:
        kind: how it is made; small fronts that leave no room for a panel are slabs.
        width, height, thickness: metres.
        drawer: lies across: glass and louvres become panels, and the grain of a slab runs across.
        groove: the edge that is hollowed from behind, so that fingers can take hold of the lip.
    Returns:
        Boards and panes; x from 0 to width, y from 0 (face) to thick, z from 0 to height.
    """
    kind = DRAWER_KINDS.get(kind, kind) if drawer else kind
    stile, rail = frame_widths(kind, width, height, drawer)
    opening_size = min(width - 2 * stile, height - 2 * rail)
    if kind in (FrontKind.SLAB, FrontKind.V_GROOVE, FrontKind.FLUTED) or opening_size < 0.03:
        parts = _plain(kind, width, height, thickness, drawer)
    else:
        parts = _framed(kind, width, height, thickness, stile, rail)
    return parts if groove is None else tuple(_grooved(part, width, height, thickness, groove) for part in parts)


def frame_widths(kind: FrontKind, width: float, height: float, drawer: bool = False) -> tuple[float, float]:
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

    Args:
        parts: of `front`. size: its width, thickness, height, metres.
        finish, glass: of boards and panes. name: of its collider; its mesh is `<name>_visual`.
        at: of its lower left front corner, link frame.
        groove: as it was given to `front`. grip: name of the lip's collider.
    """
    for part in parts:
        solid = part.solid.translated(*at)
        if part.pane:
            builder.add(link, solid, glass, label="glass", collider=False, density="glass")
        else:
            builder.add(link, solid, finish, label, name, part.grain, collider=False, density="board")
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


def face_depth(parts: tuple[FrontPart, ...], points: Sequence[tuple[float, float]]) -> float:
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
    y = a[:, 1] + s * (b[:, 1] - a[:, 1]) + t * (c[:, 1] - a[:, 1])
    return float(y[inside].min()) if inside.any() else None


def lip(width: float, height: float, groove: FrontEdge) -> Placed:
    """The lip that a hand takes of a grooved front, as a collision box in the front's frame."""
    lower = {
        FrontEdge.TOP: (0.0, 0.0, height - GROOVE_DEPTH),
        FrontEdge.BOTTOM: (0.0, 0.0, 0.0),
        FrontEdge.LEFT: (0.0, 0.0, 0.0),
        FrontEdge.RIGHT: (width - GROOVE_DEPTH, 0.0, 0.0),
    }[groove]
    level = groove in (FrontEdge.TOP, FrontEdge.BOTTOM)
    across, up = (width, GROOVE_DEPTH) if level else (GROOVE_DEPTH, height)
    return box_shape(lower, (lower[0] + across, GROOVE_LIP, lower[2] + up))


def _plain(kind: FrontKind, w: float, h: float, t: float, drawer: bool) -> tuple[FrontPart, ...]:
    if kind is FrontKind.V_GROOVE:
        line = panels.v_groove_line(w, 0.1, 0.003, 0.003)
    elif kind is FrontKind.FLUTED:
        line = panels.reeded_line(w, 0.024, 0.0045)
    else:
        grain = ACROSS if drawer else UPRIGHT
        return (FrontPart(board((0.0, 0.0, 0.0), (w, t, h), FRONT_EDGE_RADIUS), grain=grain),)
    outline = np.concatenate([line, [(w, t), (0.0, t)]])
    return (FrontPart(prism(outline, h, 0.0)),)


def _framed(kind: FrontKind, w: float, h: float, t: float, stile: float, rail: float) -> tuple[FrontPart, ...]:
    """Parts of a framed front: stiles of full height, with rails between them."""
    out = [FrontPart(board((x, 0.0, 0.0), (x + stile, t, h), FRONT_EDGE_RADIUS)) for x in (0.0, w - stile)]
    rise = min(0.055, 0.2 * (w - 2 * stile)) if kind is FrontKind.ARCHED else 0.0
    splits = _splits(kind, h, rail, rise)
    last = len(splits) - 1
    for k, z in enumerate(splits):
        if rise and k == last:
            solid = panels.arched_rail(stile, w - stile, z, rise, h, t)
        else:
            solid = board((stile, 0.0, z), (w - stile, t, z + rail), FRONT_EDGE_RADIUS)
        out.append(FrontPart(solid, grain=ACROSS))
    for k in range(last):
        arch = rise if k == last - 1 else 0.0
        out += _filled(kind, FrameOpening(stile, splits[k] + rail, w - stile, splits[k + 1] + arch, arch), t)
    return tuple(out)


def _splits(kind: FrontKind, h: float, rail: float, rise: float) -> list[float]:
    """Lower edges of the rails, bottom up; a tall door has one at hand height."""
    top = h - rail - rise
    if kind in (FrontKind.SLIM_SHAKER, FrontKind.GLASS_CLEAR, FrontKind.GLASS_FROSTED) or h < 1.25:
        return [0.0, top]
    return [0.0, 0.42 * h - rail / 2, top]


def _filled(kind: FrontKind, opening: FrameOpening, t: float) -> list[FrontPart]:
    if kind in GLAZED_KINDS:
        bars = panels.muntins(opening, t) if kind is FrontKind.GLASS_DIVIDED else []
        stops = [FrontPart(s) for s in panels.glazing_beads(opening, t)]
        pane = FrontPart(panels.glass_pane(opening, t / 2), pane=True)
        return [pane, *stops, *(FrontPart(s, grain=g) for s, g in bars)]
    if kind is FrontKind.LOUVRED:
        return [FrontPart(s, grain=ACROSS) for s in panels.louvres(opening, t)]
    if kind is FrontKind.BEADBOARD:
        return [FrontPart(panels.beaded_panel(opening))]
    if kind is FrontKind.RAISED or kind is FrontKind.ARCHED:
        return [FrontPart(panels.raised_panel(opening, t)), *(FrontPart(s) for s in panels.frame_moulding(opening))]
    return [FrontPart(panels.flat_panel(opening, 0.006 if kind is FrontKind.SLIM_SHAKER else 0.008))]


def _grooved(part: FrontPart, w: float, h: float, t: float, edge: FrontEdge) -> FrontPart:
    """The part without what the groove takes away behind the lip."""
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
