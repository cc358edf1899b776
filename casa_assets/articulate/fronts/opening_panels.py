"""Find the panels that open: with handles, tiled, beside controls, and round ones."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from casa_assets.articulate.controls.classify import ControlClassifier
from casa_assets.articulate.controls.controls import MAX_KEY_RATIO, Control, has_round_outline
from casa_assets.articulate.fronts.panels import INSIDE_TOLERANCE, Panel
from casa_assets.articulate.interior.inner_parts import (
    GROUPING_GAPS,
    find_backing_plates,
    find_door_bins,
    group_touching,
    is_shelf,
)
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side, view_from_above
from casa_assets.articulate.segment.orthographic import BACK, BOTTOM, FRONT, LEFT, RIGHT, SIDES, TOP, render_depth
from casa_assets.articulate.segment.shell_segments import MIN_BOXINESS, NO_FRONTS, KnownFronts, boxiness
from casa_assets.core.numeric import Floats, Mask

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
# A small thing alone on a panel is its pull, unless it is a knob or a key with this confidence.
MIN_SURE_CONTROL = 0.85
# Least protrusion of a handle, diagonals. Ref: rails of framed doors reach 0.013, handles start at 0.025.
MIN_HANDLE_PROTRUSION = 0.013
# A pull of a large object is relatively small: least protrusion, the same by its width, and its length at most as a
# share of its front, which rails exceed.
MIN_PULL_PROTRUSION, MIN_PULL_PROTRUSION_BY_WIDTH, MAX_PULL_LENGTH_SHARE = 0.006, 0.4, 0.5
# Width to height of a cup pull.
MIN_CUP_PULL_RATIO = 1.4
# Widest gap between a handle and its front, diagonals.
MAX_HANDLE_GAP = 0.035
# Smaller protrusions are marks or screws, diagonals.
MIN_HANDLE_SIZE = 0.03
# Widest gap between a front and the box behind it, diagonals.
MAX_BOX_GAP = 0.02
# How far a seal reaches behind its front at most, diagonals.
MAX_SEAL_DEPTH = 0.004
# Height of a box as a share of its front: a lower one is a drawer of its own behind a door.
MIN_BOX_HEIGHT_SHARE = 0.2
# A box drawn as a block: width and height by its front, how far it is sunk by its depth, and its closed share.
MIN_BLOCK_WIDTH_SHARE, MIN_BLOCK_HEIGHT_SHARE, MAX_BLOCK_SUNK_SHARE, MIN_BLOCK_FILL = 0.55, 0.35, 0.1, 0.8
# Greatest share of a board of a box that is visible from outside, and least depth of a box by the width of its front.
MAX_VISIBLE_SHARE, MIN_BOX_DEPTH_SHARE = 0.05, 0.25
# A box is a basin where whoever looks down on the worktop sees into it over this share of its plan.
MIN_BASIN_SHARE = 0.5
# Height to width of a front above which only a tub is a box: fridges have many shelves and bins.
MAX_HEIGHT_RATIO = 1.3
# Widest gap between a front and a shelf behind it, diagonals.
MAX_SHELF_GAP = 0.1
# Distance that a box keeps within its front, diagonals: walls between fronts reach beyond their edges.
BOX_TOLERANCE = 0.002
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
# Pixels along the longer side of the pictures of boxes, and least depth of the room behind a front, diagonals.
BOX_PIXELS, MIN_ROOM_DEPTH = 96, 0.05


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


def attach_to_panels(
    measured: MeasuredFragments, panels: list[Panel], controls: list[Control], classify: ControlClassifier
) -> list[Control]:
    """Give each panel its handles, trims and box; return the remaining controls."""
    lower, upper = corners_from_side(measured, FRONT)
    taken = {f for p in panels for f in p.members}
    far_out = [c for c in controls if c.long <= MAX_KEY_RATIO or c.protrusion >= MIN_HANDLE_PROTRUSION]
    sure = {id(c) for c in far_out if classify(c, far_out)[1] >= MIN_SURE_CONTROL}
    rest = _pulls(panels, far_out, sure)
    # What is neither knob nor key is a label, or a trim, of what it sits on.
    rest = [c for c in rest if classify(c, rest)[0] is not None or _host(panels, c.lower, c.upper) is None]
    _count_controls(panels, rest)
    taken |= {f for p in panels for g in p.grips for f in g} | {f for c in rest for f in c.fragments}
    for i in [*range(measured.count), *range(measured.count)]:
        if i in taken:
            continue
        panel = _host(panels, lower[i], upper[i])
        if panel is None:
            continue
        if upper[i, 2] <= panel.upper[2] + INSIDE_TOLERANCE and not _wraps(panel, lower[i], upper[i]):
            protrusion = float(panel.lower[2] - lower[i, 2])
            is_grip = protrusion >= MIN_HANDLE_PROTRUSION and not (
                panel.controls and float((upper[i] - lower[i])[:2].max()) < MIN_HANDLE_SIZE
            )
            (panel.grips.append([i]) if is_grip else panel.trims.append(i))
            panel.attachment_depths.append(float(lower[i, 2]))
            taken.add(i)
    rest = _feet(panels, rest, lower, upper)
    _count_controls(panels, rest)
    for panel in panels:
        found = find_backing_plates(measured, panel, taken)
        panel.trims += found
        taken |= set(found)
        found = find_door_bins(measured, panel, taken)
        panel.trims += found
        taken |= set(found)
    for panel in panels:
        panel.box = _box(measured, panel, lower, upper, taken)
        taken |= set(panel.box)
    return rest


def find_handle_spots(measured: MeasuredFragments, panels: list[Panel], controls: list[Control]) -> list[Floats]:
    """Return the (2,) middles in (u, v) of what protrudes from a panel like a handle."""
    lower, upper = corners_from_side(measured, FRONT)
    taken = {f for p in panels for f in p.members}
    spots = []
    for i in range(measured.count):
        host = None if i in taken else _host(panels, lower[i], upper[i])
        size = upper[i, :2] - lower[i, :2]
        if (
            host is not None
            and float(host.lower[2] - lower[i, 2]) >= MIN_HANDLE_PROTRUSION
            and size.max() > 2.5 * size.min()
        ):
            spots.append((lower[i, :2] + upper[i, :2]) / 2)
    spots += [c.middle for c in controls if (c.long > 2.5 or c.is_round) and c.protrusion >= MIN_PULL_PROTRUSION]
    out: list[Floats] = []
    for spot in spots:
        if not any(np.abs(spot - o).max() < 0.03 for o in out):
            out.append(spot)
    return out


def _host(panels: list[Panel], lower: Floats, upper: Floats) -> Panel | None:
    """Return the smallest panel that holds the middle and most of a fragment, and touches it in depth."""
    middle = (lower + upper)[:2] / 2
    found = None
    for p in panels:
        over = np.minimum(upper, p.upper)[:2] - np.maximum(lower, p.lower)[:2]
        area = max(float(np.prod(np.maximum((upper - lower)[:2], 1e-9))), 1e-18)
        share = float(np.prod(np.maximum(over, 1e-9)) / area)
        inside = bool((middle >= p.lower[:2]).all() and (middle <= p.upper[:2]).all()) and share >= 0.7
        reach = min((float(p.lower[2]), *p.attachment_depths))
        near = lower[2] >= p.lower[2] - 0.12 and lower[2] <= p.upper[2] and upper[2] >= reach - MAX_HANDLE_GAP
        if inside and near and (found is None or p.width * p.height < found.width * found.height):
            found = p
    return found


def _wraps(panel: Panel, lower: Floats, upper: Floats) -> bool:
    """Return whether a fragment that reaches behind a deep panel is a shell around it, wider than its rectangle."""
    behind = float(upper[2]) > float(panel.lower[2]) + 0.35 * float(panel.upper[2] - panel.lower[2])
    return behind and panel.is_deep and not panel.holds(lower, upper, BOX_TOLERANCE)


def _pulls(panels: list[Panel], controls: list[Control], sure: Collection[int]) -> list[Control]:
    """Attach pulls to their panels (one alone, or a mirrored pair) and return the other controls.

    Args:
        sure: `id` of the controls that are surely knobs or keys, and so no pulls.
    """
    for panel in panels:
        on_panel = [c for c in controls if _host([panel], c.lower, c.upper) is panel]
        bars = [c for c in on_panel if c.long > 2.5 and _is_bar(c, panel)]
        bars += [
            c for c in on_panel if not any(c is b for b in bars) and any(_touches(c, b.lower, b.upper) for b in bars)
        ]
        panel.grips += [c.fragments for c in bars]
        panel.attachment_depths += [float(c.lower[2]) for c in bars]
        on_panel = [c for c in on_panel if not any(c is b for b in bars)]
        small = [
            c
            for c in on_panel
            if id(c) not in sure
            and _is_pull(c, float(panel.lower[2] - c.lower[2]))
            and (float(c.across.max()) <= 0.3 * min(panel.width, panel.height) or _is_cup(c, panel))
        ]
        mirrored = (
            len(small) == 2 and abs(sum(float(c.middle[0]) for c in small) - panel.lower[0] - panel.upper[0]) < 0.02
        )
        if not bars and ((len(on_panel) == 1 and len(small) == 1) or (len(on_panel) == 2 and mirrored)):
            panel.grips += [c.fragments for c in small]
    gripped = {f for p in panels for g in p.grips for f in g}
    return [c for c in controls if not set(c.fragments) & gripped]


def _is_bar(control: Control, panel: Panel) -> bool:
    """Return whether something long on a panel is a handle: far out, or no rail and out by its own width."""
    protrusion = float(panel.lower[2] - control.lower[2])
    rail = (control.across > MAX_PULL_LENGTH_SHARE * (panel.upper - panel.lower)[:2]).any()
    return protrusion >= MIN_HANDLE_PROTRUSION or (not rail and _is_pull(control, protrusion))


def _is_cup(control: Control, panel: Panel) -> bool:
    """Return whether something on a panel is wide for its height, as cup pulls of drawers are, and no knob."""
    within = bool((control.across <= MAX_PULL_LENGTH_SHARE * (panel.upper - panel.lower)[:2]).all())
    return within and not control.is_round and control.long > MIN_CUP_PULL_RATIO


def _is_pull(control: Control, protrusion: float) -> bool:
    """Return whether a small object protrudes far enough for fingers; knobs and bars also by their width."""
    shaped = control.is_round or control.long > 2.5
    return protrusion >= MIN_HANDLE_PROTRUSION or (
        shaped and protrusion >= max(MIN_PULL_PROTRUSION, MIN_PULL_PROTRUSION_BY_WIDTH * float(control.across.min()))
    )


def _count_controls(panels: list[Panel], controls: list[Control]) -> None:
    """Note on each panel how many of some knobs and keys it carries."""
    hosts = [_host(panels, c.lower, c.upper) for c in controls]
    for panel in panels:
        panel.controls = sum(host is panel for host in hosts)


def _feet(panels: list[Panel], controls: list[Control], lower: Floats, upper: Floats) -> list[Control]:
    """Add to handles the small objects that they rest on; return the other controls."""
    rest = []
    for control in controls:
        host = _host(panels, control.lower, control.upper)
        grips = [] if host is None else host.grips
        boxes = [(g, lower[g].min(axis=0), upper[g].max(axis=0)) for g in grips]
        large = [b for b in boxes if float((b[2] - b[1])[:2].max()) >= 1.5 * float(control.across.max())]
        on = next((g for g, low, high in large if _touches(control, low, high)), None)
        if on is not None:
            on += control.fragments
        else:
            rest.append(control)
    return rest


def _touches(control: Control, lower: Floats, upper: Floats) -> bool:
    """Return whether a small thing touches a box, as feet do their bar."""
    return bool((control.lower <= upper + 0.003).all() and (control.upper >= lower - 0.003).all())


def _box(measured: MeasuredFragments, panel: Panel, lower: Floats, upper: Floats, taken: Collection[int]) -> list[int]:
    """Return fragments behind a panel that would move with it as a drawer's box; empty for none."""
    hidden = measured.visible_area[:, [BACK, LEFT, RIGHT, BOTTOM]].sum(axis=1)
    aside = measured.visible_area[:, [BACK, LEFT, RIGHT]].sum(axis=1)
    surface = np.maximum(measured.area, 1e-12)
    inside: Mask = np.ones(measured.count, dtype=bool)
    for k in (0, 1):
        inside &= (lower[:, k] >= panel.lower[k] - BOX_TOLERANCE) & (upper[:, k] <= panel.upper[k] + BOX_TOLERANCE)
    back = (lower[:, 2] >= panel.lower[2] - INSIDE_TOLERANCE) & (upper[:, 2] > panel.upper[2] + 0.01)
    close = lower[:, 2] <= panel.upper[2] + MAX_BOX_GAP
    inside[[*panel.members, *taken]] = False
    inside &= ~_open_above(measured, lower, upper)
    # Level plates that span between walls of the body leave no room for a drawer.
    size = upper - lower
    wide = (size[:, 0] >= 0.6 * panel.width) & (size[:, 1] <= 0.1 * size[:, 0]) & (size[:, 2] >= 3 * size[:, 1])
    boards = [i for i in np.flatnonzero(inside & wide).tolist() if is_shelf(lower, upper, i, ~inside)]
    inside[boards] = False
    middle = [float(lower[i, 1] + upper[i, 1]) / 2 for i in boards if lower[i, 2] <= panel.upper[2] + MAX_SHELF_GAP]
    panel.has_shelf_behind = any(0.15 * panel.height < v - panel.lower[1] < 0.85 * panel.height for v in middle)
    for visible in (hidden, aside):
        free = inside & (visible <= 0.05 * surface)
        first = np.flatnonzero(free & back & close)
        if not len(first):
            continue
        reach = float(upper[first, 2].max()) + INSIDE_TOLERANCE
        more = np.flatnonzero(free & (lower[:, 2] >= panel.lower[2]) & (upper[:, 2] <= reach))
        every = sorted({*first.tolist(), *more.tolist()})
        tall = float(upper[every, 1].max() - lower[every, 1].min()) >= MIN_BOX_HEIGHT_SHARE * panel.height
        low = panel.height <= MAX_HEIGHT_RATIO * panel.width
        if visible is hidden and tall and low and view_from_above(measured, every).is_box:
            return every
        near = set(first.tolist())
        # A seal on the back of a front touches the box and the body at once.
        every = [i for i in every if upper[i, 2] > panel.upper[2] + MAX_SEAL_DEPTH]
        for gap in GROUPING_GAPS:
            found = [
                h
                for h in group_touching(lower, upper, every, gap)
                if not near.isdisjoint(h) and _is_box(measured, h, panel, lower, upper)
            ]
            if len(found) == 1:
                return found[0]
    blocks = inside & back & close & (hidden <= 0.05 * surface)
    return [i for i in np.flatnonzero(blocks).tolist() if _is_block(measured, i, panel, lower, upper)][:1]


def find_box_boards(measured: MeasuredFragments, panel: Panel, taken: Collection[int]) -> list[int]:
    """Return the hidden boards behind the front of a drawer that have its outline together; empty for none.

    They are its box where that is drawn as a block of which each side is a fragment. The lining of the body ends
    farther inside.
    """
    lower, upper = corners_from_side(measured, FRONT)
    unseen = [BACK, LEFT, RIGHT, BOTTOM]
    inside = measured.visible_area[:, unseen].sum(axis=1) <= MAX_VISIBLE_SHARE * np.maximum(measured.area, 1e-12)
    for k in (0, 1):
        inside &= (lower[:, k] >= panel.lower[k] - BOX_TOLERANCE) & (upper[:, k] <= panel.upper[k] + BOX_TOLERANCE)
    inside &= (lower[:, 2] >= panel.lower[2]) & ~_open_above(measured, lower, upper)
    inside[[*panel.everything, *taken]] = False
    rows = np.flatnonzero(inside)
    if not len(rows):
        return []
    a, b = lower[rows].min(axis=0), upper[rows].max(axis=0)
    ends = np.abs([a[:2] - panel.lower[:2], b[:2] - panel.upper[:2]]).max()
    is_deep = float((b - a)[2]) >= MIN_BOX_DEPTH_SHARE * panel.width
    return rows.tolist() if float(ends) <= INSIDE_TOLERANCE and is_deep else []


def _is_block(measured: MeasuredFragments, i: int, panel: Panel, lower: Floats, upper: Floats) -> bool:
    """Return whether a hidden fragment behind a panel is a drawer's box drawn as a block: closed towards the front.

    The lining of an oven or a cabinet is open there.
    """
    size = (upper - lower)[i]
    if size[0] < MIN_BLOCK_WIDTH_SHARE * panel.width or size[1] < MIN_BLOCK_HEIGHT_SHARE * panel.height:
        return False
    image = measured.render_alone([i], FRONT, BOX_PIXELS)
    return float((image.depth <= MAX_BLOCK_SUNK_SHARE * float(size[2])).mean()) >= MIN_BLOCK_FILL


def _open_above(measured: MeasuredFragments, lower: Floats, upper: Floats) -> Mask:
    """Mark (N,) fragments at the very top that are open above: basins, and no drawers."""
    plan = np.maximum((upper - lower)[:, 0] * (upper - lower)[:, 2], 1e-12)
    top = upper[:, 1] >= float(upper[:, 1].max()) - 0.05
    return top & (measured.visible_area[:, TOP] >= 0.5 * plan)


def _is_box(measured: MeasuredFragments, group: list[int], panel: Panel, lower: Floats, upper: Floats) -> bool:
    """Return whether a group behind a panel is a tub of most of the panel's width and a good part of its height."""
    wide = float(upper[group, 0].max() - lower[group, 0].min()) >= 0.6 * panel.width
    tall = float(upper[group, 1].max() - lower[group, 1].min()) >= MIN_BOX_HEIGHT_SHARE * panel.height
    return wide and tall and view_from_above(measured, group).is_tub


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
