"""Find the panels that open: with handles, tiled, next to controls, and round ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.controls.controls import Control, has_round_outline
from casa_assets.articulate.fronts.panel_parts import BOX_PIXELS, MAX_HANDLE_GAP, MIN_ROOM_DEPTH
from casa_assets.articulate.fronts.panels import INSIDE_TOLERANCE, Panel
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP, render_depth
from casa_assets.articulate.segment.shell_segments import MIN_BOXINESS, NO_FRONTS, KnownFronts, boxiness
from casa_assets.core.numeric import Floats

# Fronts of one thing start at one depth, end in line, and lie this near to each other, diagonals.
SAME_DEPTH, IN_LINE, MAX_GAP = 0.02, 0.012, 0.04
# A front is at least this large by its equal beside it, and this wide by its length: thinner ones are boards and slats.
MIN_SIZE_BY_EQUAL, MIN_SLIMNESS = 0.35, 0.1
# A front shows this share of its rectangle, with what lies on it.
MIN_VISIBLE_SHARE = 0.5
# Controls that make a front beside them a door, its least share of the side, and its greatest.
MIN_CONTROLS_BESIDE, MIN_DOOR_SHARE, MAX_DOOR_SHARE = 2, 0.3, 0.93
# Detergent drawers lie above a round door and are at most this wide by the side.
MAX_DRAWER_WIDTH_SHARE = 0.45
# Diameter by the width and by the height of the front, distance of its middle from that of the front by the width, and
# height by width of the front. Ref: makers list loading doors of 30 to 50 cm in fronts of 60 by 85 cm.
MIN_DIAMETER_BY_WIDTH, MAX_DIAMETER_BY_WIDTH, MIN_DIAMETER_BY_HEIGHT = 0.35, 0.85, 0.22
MAX_OFFSET, MIN_TALL, MAX_TALL = 0.15, 0.8, 2.4
# Its parts start within this share of the depth of the thing, reach back at most by this share of their diameter, and
# show at least this share of their square.
MAX_START_SHARE, MAX_DEPTH_BY_DIAMETER, ROUND_MIN_VISIBLE_SHARE = 0.2, 0.6, 0.08
# Parts of one door have their middles this near to each other, by its diameter, and stay within its circle so far.
MAX_ECCENTRICITY, CIRCLE_TOLERANCE = 0.1, 1.06
# What lies deeper behind its back is the drum, diagonals.
MAX_BEHIND = 0.02
# A box is a basin where whoever looks down on the worktop sees into it over this share of its plan.
MIN_BASIN_SHARE = 0.5
# A front without a handle has free space behind at least this share of it.
MIN_HOLLOW_SHARE = 0.4
# With this many controls a panel that is smaller than this share of the front is a control panel, whatever protrudes.
MIN_CONTROLS, MAX_CONTROL_PANEL_SHARE = 2, 0.4
# The face of a remote control or a telephone: share of its side, depth of the thing by its longer side, controls on it.
MIN_KEY_PAD_SHARE, MAX_KEY_PAD_DEPTH, MIN_KEY_PAD_CONTROLS = 0.7, 0.35, 3
# A sheet that is no thicker, diagonals, and at least this share of the side wide is the face of the case itself.
MAX_FACE_DEPTH, MIN_FACE_WIDTH_SHARE = 0.002, 0.97
# Most handles of one front: a wide drawer has two.
MAX_HANDLES = 2
# Confidence of a front that only the kind of its thing makes one.
DOUBTFUL = 0.45
# A plinth or a rail: greatest height by that of the thing; how far it is set back behind a front at least, diagonals.
MAX_RAIL_HEIGHT, MIN_SETBACK = 0.16, 0.015
# A panel without a handle that is narrower than this share of the side is a strip of the body.
MAX_STRIP_SHARE = 0.13


def tiled_fronts(measured: MeasuredFragments, panels: Sequence[Panel], chosen: Sequence[Panel]) -> list[Panel]:
    """Return panels that, with those that surely open, tile a part of the side in rows or columns."""
    rest = [p for p in panels if _is_plain(measured, p) and not any(p is c for c in chosen)]
    found: list[Panel] = []
    while True:
        sure = [*chosen, *found]
        more = [p for p in rest if any(_tile(p, o) for o in (sure or rest) if o is not p)]
        if not more:
            return found
        found += more
        rest = [p for p in rest if not any(p is m for m in more)]


def door_beside_controls(
    measured: MeasuredFragments, panels: Sequence[Panel], controls: Sequence[Control]
) -> Panel | None:
    """Return the one large panel without a handle that lies next to or below controls, as doors of appliances do."""
    lower, upper = corners_from_side(measured, FRONT)
    extent = upper.max(axis=0) - lower.min(axis=0)
    beside = [c.middle for c in controls]
    found = []
    for p in panels:
        outside = sum(bool((m < p.lower[:2]).any() or (m > p.upper[:2]).any()) for m in beside)
        share = p.width * p.height / float(extent[0] * extent[1])
        if (
            _is_plain(measured, p)
            and MIN_DOOR_SHARE <= share <= MAX_DOOR_SHARE
            and outside >= max(MIN_CONTROLS_BESIDE, len(beside))
        ):
            found.append(p)
    return found[0] if len(found) == 1 else None


def detergent_drawers(
    measured: MeasuredFragments, door: Panel, panels: Sequence[Panel], controls: Sequence[Control]
) -> list[Panel]:
    """Return the panel above a round door that is the front of a drawer: small, at one side, without controls."""
    lower, upper = corners_from_side(measured, FRONT)
    low, high = lower.min(axis=0), upper.max(axis=0)
    extent, middle = high - low, float((low + high)[0]) / 2
    found = [
        p
        for p in panels
        if p is not door
        and p.controls == 0
        and float(p.lower[1]) >= float(door.upper[1]) - IN_LINE
        and p.width <= MAX_DRAWER_WIDTH_SHARE * float(extent[0])
        and not p.lower[0] <= middle <= p.upper[0]
        and not any((c.middle >= p.lower[:2]).all() and (c.middle <= p.upper[:2]).all() for c in controls)
    ]
    return found[:1] if len(found) == 1 else []


def _is_plain(measured: MeasuredFragments, panel: Panel) -> bool:
    """Return whether a panel may be a front though it has no handle: seen, no slat, and without controls."""
    visible = float(measured.visible_area[panel.everything, FRONT].sum())
    slim = min(panel.width, panel.height) < MIN_SLIMNESS * max(panel.width, panel.height)
    return (
        not panel.is_recessed
        and panel.controls == 0
        and not slim
        and visible >= MIN_VISIBLE_SHARE * panel.width * panel.height
    )


def _tile(a: Panel, b: Panel) -> bool:
    """Return whether two panels lie in one row or column, flush, near each other, and about as large."""
    areas = sorted((a.width * a.height, b.width * b.height))
    if abs(float(a.lower[2] - b.lower[2])) > SAME_DEPTH or areas[0] < MIN_SIZE_BY_EQUAL * areas[1]:
        return False
    for across, along in ((0, 1), (1, 0)):
        away = np.abs([a.lower[across] - b.lower[across], a.upper[across] - b.upper[across]]).max()
        gap = max(float(a.lower[along] - b.upper[along]), float(b.lower[along] - a.upper[along]))
        if away <= IN_LINE and -IN_LINE <= gap <= MAX_GAP:
            return True
    return False


def find_round_door(measured: MeasuredFragments) -> Panel | None:
    """Return the round door of a side, with all that lies in its circle, or None."""
    lower, upper = corners_from_side(measured, FRONT)
    size, whole_lower, whole_upper = upper - lower, lower.min(axis=0), upper.max(axis=0)
    extent = whole_upper - whole_lower
    if not MIN_TALL <= extent[1] / max(float(extent[0]), 1e-9) <= MAX_TALL:
        return None
    across = size[:, :2].max(axis=1)
    middle = (lower + upper)[:, :2] / 2
    fits = (across <= 1.2 * size[:, :2].min(axis=1)) & (across <= MAX_DIAMETER_BY_WIDTH * extent[0])
    fits &= (across >= MIN_DIAMETER_BY_WIDTH * extent[0]) & (across >= MIN_DIAMETER_BY_HEIGHT * extent[1])
    fits &= (lower[:, 2] - whole_lower[2] <= MAX_START_SHARE * extent[2]) & (
        size[:, 2] <= MAX_DEPTH_BY_DIAMETER * across
    )
    fits &= np.abs(middle[:, 0] - (whole_lower + whole_upper)[0] / 2) <= MAX_OFFSET * extent[0]
    fits &= measured.visible_area[:, FRONT] >= ROUND_MIN_VISIBLE_SHARE * across**2
    rings = [i for i in np.flatnonzero(fits).tolist() if has_round_outline(measured, FRONT, [i], size[i, :2])]
    if not rings:
        return None
    first = max(rings, key=lambda i: (round(float(across[i]), 6), -i))
    radius = float(across[first]) / 2
    shared = [i for i in rings if float(np.abs(middle[i] - middle[first]).max()) <= 2 * MAX_ECCENTRICITY * radius]
    back = float(upper[shared, 2].max()) + MAX_BEHIND
    corner = np.maximum(np.abs(lower[:, :2] - middle[first]), np.abs(upper[:, :2] - middle[first]))
    inside = (np.abs(middle - middle[first]).max(axis=1) <= radius) & (upper[:, 2] <= back)
    inside &= corner.max(axis=1) <= CIRCLE_TOLERANCE * radius
    members = [first, *(i for i in np.flatnonzero(inside).tolist() if i != first)]
    visible = float(measured.visible_area[members, FRONT].sum())
    corners = lower[shared].min(axis=0), upper[shared].max(axis=0)
    return Panel(members, *corners, visible_area=visible, is_round=True)


def fragments_around(measured: MeasuredFragments, door: Panel) -> list[int]:
    """Return the fragments whose rectangles hold a round door: the front of the body, in which it is hung."""
    lower, upper = corners_from_side(measured, FRONT)
    around = (lower[:, :2] <= door.lower[:2]).all(axis=1) & (upper[:, :2] >= door.upper[:2]).all(axis=1)
    return [i for i in np.flatnonzero(around).tolist() if i not in door.members]


def select_opening_panels(
    measured: MeasuredFragments, panels: list[Panel], controls: list[Control], known: KnownFronts = NO_FRONTS
) -> list[tuple[Panel, float, str]]:
    """Return the panels that open, with confidence and reason."""
    door = next((p for p in panels if p.is_round), None)
    if door is not None:
        return _with_round_door(measured, door, panels, controls)
    lower, upper = corners_from_side(measured, FRONT)
    whole = upper.max(axis=0) - lower.min(axis=0)
    gripped = [p for p in panels if p.grips]
    boxed = [p for p in panels if p.box or p.upper[2] - p.lower[2] > 0.34 * whole[2]]
    has_grip_or_box = {id(p) for p in [*gripped, *boxed]}
    boxy = boxiness(measured.mesh, measured.depth_images) >= MIN_BOXINESS
    least = min((p.width * p.height for p in panels if id(p) in has_grip_or_box), default=0.0)
    out: list[tuple[Panel, float, str]] = []
    for p in panels:
        foot = p.width * p.height
        chance = known.chance_of(p.members)
        if chance is not None:
            out.append((p, chance, "its edges show on the front"))
            continue
        # The false front of a sink: others have handles, its box is open on top.
        has_basin = gripped and not p.grips and p.box and share_open_to_the_top(measured, p.box) > MIN_BASIN_SHARE
        if (p.is_recessed and not p.grips) or _is_set_back(p, panels, lower, upper) or has_basin:
            continue
        if p.grips and p.controls >= MIN_CONTROLS and foot < MAX_CONTROL_PANEL_SHARE * whole[0] * whole[1]:
            continue
        if (
            not p.grips
            and p.controls >= MIN_CONTROLS
            and float(p.upper[2] - p.lower[2]) <= MAX_FACE_DEPTH
            and p.width >= MIN_FACE_WIDTH_SHARE * float(whole[0])
        ):
            continue
        strip = p.height < MAX_STRIP_SHARE * whole[1] or p.width < MAX_STRIP_SHARE * whole[0]
        if p.grips and _handle_count(p, lower, upper) > MAX_HANDLES:
            out.append((p, 0.5, "has several handles, as fronts have that are one piece"))
        elif p.grips and p.controls <= 3:
            out.append((p, 0.95, "has a handle"))
        elif p.grips and foot >= 0.25 * whole[0] * whole[1]:
            out.append((p, 0.9, "has a handle, and is large"))
        elif id(p) in has_grip_or_box:
            out.append((p, 0.8, "has a box behind it"))
        elif (
            strip
            or (p.controls and foot < 0.4 * whole[0] * whole[1])
            or (has_grip_or_box and foot < 0.6 * least)
            or (gripped and foot < 0.35 * max(q.width * q.height for q in gripped))
        ) or _is_key_pad(p, whole):
            continue
        elif boxy and foot >= 0.08 * whole[0] * whole[1] and _closes(measured, p):
            out.append((p, 0.55, "lies on the front like a door"))
    if boxy:
        out += [(p, 0.5, "one of several fronts alike") for p in tiled_fronts(measured, panels, [o[0] for o in out])]
        beside = None if out else door_beside_controls(measured, panels, controls)
        out += [] if beside is None else [(beside, DOUBTFUL, "lies beside the controls like a door")]
    return out


def _is_key_pad(panel: Panel, whole: Floats) -> bool:
    """Return whether a panel without a handle is the face of a thin thing with controls, as that of a remote control.

    Args:
        whole: (3,) width, height and depth of the thing.
    """
    covers = panel.width * panel.height >= MIN_KEY_PAD_SHARE * float(whole[0] * whole[1])
    is_thin = float(whole[2]) <= MAX_KEY_PAD_DEPTH * float(whole[:2].max())
    return covers and is_thin and panel.controls >= MIN_KEY_PAD_CONTROLS and not panel.grips


def _is_set_back(panel: Panel, panels: list[Panel], lower: Floats, upper: Floats) -> bool:
    """Return whether a panel is a low board behind the fronts around it: a plinth at the floor, a rail between two."""
    floor, height = float(lower[:, 1].min()), float(upper[:, 1].max() - lower[:, 1].min())
    if panel.height > MAX_RAIL_HEIGHT * height:
        return False
    ahead = [
        p
        for p in panels
        if min(p.upper[0], panel.upper[0]) - max(p.lower[0], panel.lower[0]) > 0.5 * min(p.width, panel.width)
        and float(panel.lower[2] - p.lower[2]) >= MIN_SETBACK
    ]
    middles = [float(p.lower[1] + p.upper[1] - panel.lower[1] - panel.upper[1]) / 2 for p in ahead]
    above, below = any(m > 0.0 for m in middles), any(m < 0.0 for m in middles)
    return above and (below or float(panel.lower[1]) <= floor + INSIDE_TOLERANCE)


def _with_round_door(
    measured: MeasuredFragments, door: Panel, panels: list[Panel], controls: list[Control]
) -> list[tuple[Panel, float, str]]:
    """Return the panels that open on a side with a round door, as `select_opening_panels` does."""
    drawers = detergent_drawers(measured, door, panels, controls)
    more = [p for p in panels if p.grips and p is not door and not any(p is d for d in drawers)]
    more = [p for p in more if not p.controls and not p.holds(door.lower, door.upper)]
    found = [(door, 0.9, "a round door"), *((p, 0.65, "beside a round door, without controls") for p in drawers)]
    return [*found, *((p, 0.8, "has a handle") for p in more)]


def _handle_count(panel: Panel, lower: Floats, upper: Floats) -> int:
    """Return how many separate handles a panel has; pieces that nearly touch are one."""
    boxes = [(lower[g, :2].min(axis=0), upper[g, :2].max(axis=0)) for g in panel.grips]
    count = 0
    while boxes:
        a, b = boxes.pop()
        count += 1
        near = [k for k in boxes if (k[0] <= b + MAX_HANDLE_GAP).all() and (k[1] >= a - MAX_HANDLE_GAP).all()]
        while near:
            boxes = [k for k in boxes if not any(k is n for n in near)]
            a = np.minimum(a, np.min([k[0] for k in near], axis=0))
            b = np.maximum(b, np.max([k[1] for k in near], axis=0))
            near = [k for k in boxes if (k[0] <= b + MAX_HANDLE_GAP).all() and (k[1] >= a - MAX_HANDLE_GAP).all()]
    return count


def _closes(measured: MeasuredFragments, panel: Panel) -> bool:
    """Return whether there is a cavity behind a panel, and something over it at the height of its top or above."""
    gone = np.zeros(len(measured.label), dtype=bool)
    gone[measured.faces_of(panel.everything)] = True
    faces = measured.mesh.faces[~gone]
    if not len(faces):
        return False
    lower, upper = panel.lower, panel.upper
    image = render_depth(measured.mesh.points, faces, SIDES[FRONT], 2 * BOX_PIXELS)
    nearest = float((measured.mesh.points[faces] @ SIDES[FRONT][2]).min())
    depth = image.window(lower[:2], upper[:2]) + nearest
    if float((np.isfinite(depth) & (depth > float(upper[2]) + MIN_ROOM_DEPTH)).mean()) < MIN_HOLLOW_SHARE:
        return False
    strip = np.array([[lower[0], lower[1], upper[2]], [upper[0], upper[1], upper[2] + MIN_ROOM_DEPTH]]) @ SIDES[FRONT]
    roof = measured.depth_images[TOP].window(*np.sort(strip @ SIDES[TOP].T, axis=0)[:, :2])
    height = float(measured.upper[:, 2].max()) - np.where(np.isfinite(roof), roof, np.inf)
    return float((height >= float(upper[1]) - 0.25 * panel.height).mean()) >= MIN_HOLLOW_SHARE


def share_open_to_the_top(measured: MeasuredFragments, fragments: Sequence[int]) -> float:
    """Return the share of the plan of some fragments that is open when the object is seen from above.

    There, nothing visible is above half of their height: neither a worktop nor the body, only objects inside them.
    """
    lower, upper = measured.box(fragments)
    corners = np.sort(np.array([lower, upper]) @ SIDES[TOP].T, axis=0)
    depth = measured.depth_images[TOP].window(*corners[:, :2])
    height = float(measured.upper[:, 2].max()) - np.where(np.isfinite(depth), depth, np.inf)
    return float((height < float(lower[2] + upper[2]) / 2).mean())
