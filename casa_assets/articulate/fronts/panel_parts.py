"""Parts that belong to an opening panel: its handles and other controls, its feet, and the box of a drawer."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from casa_assets.articulate.controls.classify import ControlClassifier
from casa_assets.articulate.controls.controls import MAX_KEY_RATIO, Control
from casa_assets.articulate.fronts.panels import INSIDE_TOLERANCE, Panel
from casa_assets.articulate.interior.inner_parts import (
    GROUPING_GAPS,
    find_backing_plates,
    find_door_bins,
    group_touching,
    is_shelf,
)
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side, view_from_above
from casa_assets.articulate.segment.orthographic import BACK, BOTTOM, FRONT, LEFT, RIGHT, TOP
from casa_assets.core.numeric import Floats, Mask

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
# Height to width of a front above which only a tub is a box: fridges have many shelves and bins.
MAX_HEIGHT_RATIO = 1.3
# Widest gap between a front and a shelf behind it, diagonals.
MAX_SHELF_GAP = 0.1
# Distance that a box keeps within its front, diagonals: walls between fronts reach beyond their edges.
BOX_TOLERANCE = 0.002
# Pixels along the longer side of the pictures of boxes, and least depth of the room behind a front, diagonals.
BOX_PIXELS, MIN_ROOM_DEPTH = 96, 0.05


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
