"""Attach handles, trims and drawer boxes to panels, and select the panels that open."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.controls.controls import MAX_KEY_RATIO, Control, classify_control
from casa_assets.articulate.fronts.panel_layers import find_backing_plates, find_door_bins
from casa_assets.articulate.fronts.panels import INSIDE_TOLERANCE, Panel
from casa_assets.articulate.interior.hollow_parts import free_share_behind, roofed_share, view_from_above
from casa_assets.articulate.interior.inner_parts import group_touching, is_shelf
from casa_assets.articulate.segment.fragment_measures import (
    BACK,
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    MeasuredFragments,
    corners_from_side,
)
from casa_assets.articulate.segment.shell_segments import MIN_BOXINESS, boxiness
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.typing import Floats

# A handle stands out at least so far, in diagonals. Ref: rails of framed doors reach 0.013, handles start at 0.025.
MIN_HANDLE_PROTRUSION = 0.013
# The pull of a large thing is small by it: one that is no rail, shorter than this part of the front, stands out so far,
# and so far by its own width.
MIN_PULL_PROTRUSION, MIN_PULL_PROTRUSION_BY_WIDTH, MAX_PULL_LENGTH_SHARE = 0.006, 0.4, 0.5
# A cup pull is so much longer than high, at least.
MIN_CUP_PULL_RATIO = 1.4
# Between a handle and the front that it belongs to there is at most so much air.
MAX_HANDLE_GAP = 0.035
# What is smaller is no handle but a mark or screw, diagonals.
MIN_HANDLE_SIZE = 0.03
# A box behind a front begins at most so far behind it.
MAX_BOX_GAP = 0.02
# A box is at least this part of its front tall: a lesser one is a drawer of its own behind a door.
MIN_BOX_HEIGHT_SHARE = 0.2
# Behind a front that is higher than this by its width, only a tub is a box: shelves and bins of a fridge are many.
MAX_HEIGHT_RATIO = 1.3
# A shelf begins at most so far behind a front.
MAX_SHELF_GAP = 0.1
# The box keeps within its front by so much: walls between fronts reach a little beyond their edges.
BOX_TOLERANCE = 0.002
# A front without a handle has room behind so much of it.
MIN_HOLLOW_SHARE = 0.4
# A small panel with so many knobs or keys on it is one of controls, though a lever stands out of it like a handle.
MIN_CONTROLS, MAX_CONTROL_PANEL_SHARE = 2, 0.4
# A panel narrower than this part of the side, and without a handle, is a strip of the body.
MAX_STRIP_SHARE = 0.13


def attach_to_panels(
    pieces: MeasuredFragments, side: int, panels: list[Panel], controls: list[Control]
) -> list[Control]:
    """Give each panel its handles, trims and box; return the controls that are none of these."""
    low, high = corners_from_side(pieces, side)
    taken = {f for p in panels for f in p.members}
    rest = _pulls(panels, [c for c in controls if c.long <= MAX_KEY_RATIO or c.protrusion >= MIN_HANDLE_PROTRUSION])
    # What is neither knob nor key is a label, or a trim, of what it sits on.
    rest = [c for c in rest if classify_control(c, rest)[0] is not None or _host(panels, c.low, c.high) is None]
    taken |= {f for p in panels for g in p.grips for f in g} | {f for c in rest for f in c.fragments}
    for i in [*range(pieces.count), *range(pieces.count)]:
        if i in taken:
            continue
        panel = _host(panels, low[i], high[i])
        if panel is None:
            continue
        if high[i, 2] <= panel.high[2] + INSIDE_TOLERANCE and not _wraps(panel, low[i], high[i]):
            stands = float(panel.low[2] - low[i, 2])
            held = stands >= MIN_HANDLE_PROTRUSION and not (panel.controls and _is_mark(low[i], high[i]))
            (panel.grips.append([i]) if held else panel.trims.append(i))
            panel.attachment_depths.append(float(low[i, 2]))
            taken.add(i)
    rest = _feet(panels, rest, low, high)
    for panel in panels:
        more = find_backing_plates(pieces, side, panel, taken)
        panel.trims += more
        taken |= set(more)
        more = find_door_bins(pieces, side, panel, taken)
        panel.trims += more
        taken |= set(more)
    for panel in panels:
        panel.box = [i for i in _box(pieces, side, panel, low, high) if i not in taken]
        taken |= set(panel.box)
    return rest


def find_handle_spots(
    pieces: MeasuredFragments, side: int, panels: list[Panel], controls: list[Control]
) -> list[Floats]:
    """Return the (2,) middles in (u, v) of what protrudes from a panel like a handle."""
    low, high = corners_from_side(pieces, side)
    taken = {f for p in panels for f in p.members}
    spots = []
    for i in range(pieces.count):
        host = None if i in taken else _host(panels, low[i], high[i])
        size = high[i, :2] - low[i, :2]
        if (
            host is not None
            and float(host.low[2] - low[i, 2]) >= MIN_HANDLE_PROTRUSION
            and size.max() > 2.5 * size.min()
        ):
            spots.append((low[i, :2] + high[i, :2]) / 2)
    spots += [c.middle for c in controls if (c.long > 2.5 or c.is_round) and c.protrusion >= MIN_HANDLE_PROTRUSION]
    out: list[Floats] = []
    for spot in spots:
        if not any(np.abs(spot - o).max() < 0.03 for o in out):
            out.append(spot)
    return out


def _host(panels: list[Panel], low: Floats, high: Floats) -> Panel | None:
    """Return the smallest panel that holds the middle and most of a fragment, and touches it in depth."""
    middle = (low + high)[:2] / 2
    found = None
    for p in panels:
        over = np.minimum(high, p.high)[:2] - np.maximum(low, p.low)[:2]
        share = float(np.prod(np.maximum(over, 1e-9)) / max(float(np.prod(np.maximum((high - low)[:2], 1e-9))), 1e-18))
        inside = bool((middle >= p.low[:2]).all() and (middle <= p.high[:2]).all()) and share >= 0.7
        reach = min((float(p.low[2]), *p.attachment_depths))
        near = low[2] >= p.low[2] - 0.12 and low[2] <= p.high[2] and high[2] >= reach - MAX_HANDLE_GAP
        if inside and near and (found is None or p.width * p.height < found.width * found.height):
            found = p
    return found


def _is_mark(low: Floats, high: Floats) -> bool:
    """Return whether a fragment is so small that beside knobs it is a mark, and no handle."""
    return float((high - low)[:2].max()) < MIN_HANDLE_SIZE


def _wraps(panel: Panel, low: Floats, high: Floats) -> bool:
    """Return whether a fragment that reaches behind a deep panel is a shell around it, wider than its rectangle."""
    behind = float(high[2]) > float(panel.low[2]) + 0.35 * float(panel.high[2] - panel.low[2])
    return behind and panel.is_deep and not panel.holds(low, high, BOX_TOLERANCE)


def _pulls(panels: list[Panel], controls: list[Control]) -> list[Control]:
    """Attach pulls to their panels (one alone, or a mirrored pair) and return the other controls."""
    for panel in panels:
        own = [c for c in controls if _host([panel], c.low, c.high) is panel]
        bars = [c for c in own if c.long > 2.5 and _is_bar(c, panel)]
        bars += [c for c in own if not any(c is b for b in bars) and any(_bears(c, b) for b in bars)]
        panel.grips += [c.fragments for c in bars]
        panel.attachment_depths += [float(c.low[2]) for c in bars]
        own = [c for c in own if not any(c is b for b in bars)]
        small = [
            c for c in own if _is_pull(c, float(panel.low[2] - c.low[2])) and (_is_small(c, panel) or _is_cup(c, panel))
        ]
        mirrored = len(small) == 2 and abs(sum(float(c.middle[0]) for c in small) - panel.low[0] - panel.high[0]) < 0.02
        if not bars and ((len(own) == 1 and len(small) == 1) or (len(own) == 2 and mirrored)):
            panel.grips += [c.fragments for c in small]
            own = []
        panel.controls = len(own)
    held = {f for p in panels for g in p.grips for f in g}
    return [c for c in controls if not set(c.fragments) & held]


def _is_bar(control: Control, panel: Panel) -> bool:
    """Return whether something long on a panel is a handle: far out, or no rail and out by its own width."""
    stands = float(panel.low[2] - control.low[2])
    rail = (control.across > MAX_PULL_LENGTH_SHARE * (panel.high - panel.low)[:2]).any()
    return stands >= MIN_HANDLE_PROTRUSION or (not rail and _is_pull(control, stands))


def _is_small(control: Control, panel: Panel) -> bool:
    """Return whether a control is small compared with its panel."""
    return float(control.across.max()) <= 0.3 * min(panel.width, panel.height)


def _is_cup(control: Control, panel: Panel) -> bool:
    """Return whether something on a panel is wide for its height, as cup pulls of drawers are, and no knob."""
    within = bool((control.across <= MAX_PULL_LENGTH_SHARE * (panel.high - panel.low)[:2]).all())
    return within and not control.is_round and control.long > MIN_CUP_PULL_RATIO


def _is_pull(control: Control, stands: float) -> bool:
    """Return whether a small thing stands out far enough for fingers; knobs and bars also by their width."""
    shaped = control.is_round or control.long > 2.5
    return stands >= MIN_HANDLE_PROTRUSION or (
        shaped and stands >= max(MIN_PULL_PROTRUSION, MIN_PULL_PROTRUSION_BY_WIDTH * float(control.across.min()))
    )


def _bears(control: Control, bar: Control) -> bool:
    """Return whether a small thing touches a bar, as its feet do."""
    return bool((control.low <= bar.high + 0.003).all() and (control.high >= bar.low - 0.003).all())


def _feet(panels: list[Panel], controls: list[Control], low: Floats, high: Floats) -> list[Control]:
    """Give handles the small things that they stand on; return the other controls."""
    rest = []
    for control in controls:
        host = _host(panels, control.low, control.high)
        grips = [] if host is None else host.grips
        on = [g for g in grips if _touches(control, low[g].min(axis=0), high[g].max(axis=0))]
        if on:
            on[0] += control.fragments
        else:
            rest.append(control)
    return rest


def _touches(control: Control, low: Floats, high: Floats) -> bool:
    """Return whether a small thing touches a handle that is larger than itself."""
    meet = bool((control.low <= high + 0.003).all() and (control.high >= low - 0.003).all())
    return meet and float((high - low)[:2].max()) >= 1.5 * float(control.across.max())


def _box(pieces: MeasuredFragments, side: int, panel: Panel, low: Floats, high: Floats) -> list[int]:
    """Return fragments behind a panel that would move with it as a drawer's box; empty for none."""
    hidden = pieces.visible_area[:, [s for s in (BACK, LEFT, RIGHT, BOTTOM) if s != side]].sum(axis=1)
    aside = pieces.visible_area[:, [s for s in (BACK, LEFT, RIGHT) if s != side]].sum(axis=1)
    surface = np.maximum(pieces.area, 1e-12)
    inside: Bools = np.ones(pieces.count, dtype=bool)
    for k in (0, 1):
        inside &= (low[:, k] >= panel.low[k] - BOX_TOLERANCE) & (high[:, k] <= panel.high[k] + BOX_TOLERANCE)
    back = (low[:, 2] >= panel.low[2] - INSIDE_TOLERANCE) & (high[:, 2] > panel.high[2] + 0.01)
    close = low[:, 2] <= panel.high[2] + MAX_BOX_GAP
    inside[panel.members] = False
    inside &= ~_open_above(pieces, low, high)
    boards = _boards(low, high, inside, panel)
    inside[boards] = False
    middle = [float(low[i, 1] + high[i, 1]) / 2 for i in boards if low[i, 2] <= panel.high[2] + MAX_SHELF_GAP]
    panel.has_shelf_behind = any(0.15 * panel.height < v - panel.low[1] < 0.85 * panel.height for v in middle)
    for shown in (hidden, aside):
        free = inside & (shown <= 0.05 * surface)
        first = np.flatnonzero(free & back & close)
        if not len(first):
            continue
        reach = float(high[first, 2].max()) + INSIDE_TOLERANCE
        more = np.flatnonzero(free & (low[:, 2] >= panel.low[2]) & (high[:, 2] <= reach))
        every = sorted({*first.tolist(), *more.tolist()})
        tall = float(high[every, 1].max() - low[every, 1].min()) >= MIN_BOX_HEIGHT_SHARE * panel.height
        wide = panel.height <= MAX_HEIGHT_RATIO * panel.width
        if shown is hidden and tall and wide and view_from_above(pieces, every).is_box:
            return every
        near = set(first.tolist())
        found = [
            h
            for h in group_touching(low, high, every)
            if not near.isdisjoint(h) and _is_box(pieces, h, panel, low, high)
        ]
        if len(found) == 1:
            return found[0]
    return []


def _boards(low: Floats, high: Floats, inside: Bools, panel: Panel) -> list[int]:
    """Return level plates behind a panel that stand between walls of the body: a drawer has no room there."""
    size = high - low
    wide = (size[:, 0] >= 0.6 * panel.width) & (size[:, 1] <= 0.1 * size[:, 0]) & (size[:, 2] >= 3 * size[:, 1])
    return [i for i in np.flatnonzero(inside & wide).tolist() if is_shelf(low, high, i, ~inside)]


def _open_above(pieces: MeasuredFragments, low: Floats, high: Floats) -> Bools:
    """Mark (N,) fragments at the very top that are open above: basins, and no drawers."""
    plan = np.maximum((high - low)[:, 0] * (high - low)[:, 2], 1e-12)
    top = high[:, 1] >= float(high[:, 1].max()) - 0.05
    found: Bools = top & (pieces.visible_area[:, TOP] >= 0.5 * plan)
    return found


def _is_box(pieces: MeasuredFragments, heap: list[int], panel: Panel, low: Floats, high: Floats) -> bool:
    """Return whether a group behind a panel is a tub of most of the panel's width and a good part of its height."""
    wide = float(high[heap, 0].max() - low[heap, 0].min()) >= 0.6 * panel.width
    tall = float(high[heap, 1].max() - low[heap, 1].min()) >= MIN_BOX_HEIGHT_SHARE * panel.height
    return wide and tall and view_from_above(pieces, heap).is_tub


def box_depth(pieces: MeasuredFragments, side: int, panel: Panel) -> float:
    """Return how far the box of a panel reaches behind it, diagonals."""
    _, high = corners_from_side(pieces, side)
    return max((float(high[i, 2] - panel.high[2]) for i in panel.box), default=0.0)


def select_opening_panels(pieces: MeasuredFragments, side: int, panels: list[Panel]) -> list[tuple[Panel, float, str]]:
    """Return the panels that open, with confidence and reason."""
    low, high = corners_from_side(pieces, side)
    whole = high.max(axis=0) - low.min(axis=0)
    gripped = [p for p in panels if p.grips]
    boxed = [p for p in panels if p.box or p.high[2] - p.low[2] > 0.34 * whole[2]]
    confidence = {id(p) for p in [*gripped, *boxed]}
    boxy = boxiness(pieces.soup, pieces.depth_images) >= MIN_BOXINESS
    least = min((p.width * p.height for p in panels if id(p) in confidence), default=0.0)
    out: list[tuple[Panel, float, str]] = []
    for p in panels:
        foot = p.width * p.height
        if p.is_recessed and not p.grips:
            continue
        if p.grips and p.controls >= MIN_CONTROLS and foot < MAX_CONTROL_PANEL_SHARE * whole[0] * whole[1]:
            continue
        strip = p.height < MAX_STRIP_SHARE * whole[1] or p.width < MAX_STRIP_SHARE * whole[0]
        if p.grips and p.controls <= 3:
            out.append((p, 0.95, "has a handle"))
        elif p.grips and foot >= 0.25 * whole[0] * whole[1]:
            out.append((p, 0.9, "has a handle, and is large"))
        elif id(p) in confidence:
            out.append((p, 0.8, "has a box behind it"))
        elif (
            strip
            or (p.controls and foot < 0.4 * whole[0] * whole[1])
            or (confidence and foot < 0.6 * least)
            or (gripped and foot < 0.35 * max(q.width * q.height for q in gripped))
        ):
            continue
        elif boxy and foot >= 0.08 * whole[0] * whole[1] and _closes(pieces, side, p):
            out.append((p, 0.55, "lies on the front like a door"))
    return out


def _closes(pieces: MeasuredFragments, side: int, panel: Panel) -> bool:
    """Return whether there is a roofed cavity behind a panel."""
    room = free_share_behind(pieces, side, panel.everything, panel.low, panel.high)
    return room >= MIN_HOLLOW_SHARE and roofed_share(pieces, side, panel.low, panel.high) >= MIN_HOLLOW_SHARE
