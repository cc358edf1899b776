"""Panels and what belongs to them: handles, trims, boxes behind; and which of them open."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.controls import Control
from casa_assets.articulate.hollow import from_above
from casa_assets.articulate.panels import SLACK, Panel
from casa_assets.articulate.pieces import BACK, BOTTOM, LEFT, RIGHT, Pieces, face_on
from casa_assets.articulate.soup import Floats

# A handle stands out at least so far, in diagonals. Ref: rails of framed doors reach 0.013, handles start at 0.025.
HANDLE_STANDS = 0.013
# A box behind a front begins at most so far behind it.
BOX_GAP = 0.02
# The box keeps within its front by so much: walls between fronts reach a little beyond their edges.
TIGHT = 0.002
# What hangs on the back of a door is so shallow, and keeps so far from its edges.
SHALLOW, INSET = 0.14, 0.008
# A panel narrower than this part of the side, and without a handle, is a strip of the body.
STRIP = 0.13


def dress(pieces: Pieces, side: int, panels: list[Panel], controls: list[Control]) -> list[Control]:
    """Give each panel its handles, trims and box; returns the controls that are none of these."""
    low, high = face_on(pieces, side)
    taken = {f for p in panels for f in p.members}
    rest = _pulls(panels, controls)
    taken |= {f for p in panels for g in p.grips for f in g} | {f for c in rest for f in c.fragments}
    for i in [*range(pieces.count), *range(pieces.count)]:
        if i in taken:
            continue
        panel = _host(panels, low[i], high[i])
        if panel is None:
            continue
        if high[i, 2] <= panel.high[2] + SLACK:
            stands = float(panel.low[2] - low[i, 2])
            (panel.grips.append([i]) if stands >= HANDLE_STANDS else panel.trims.append(i))
            panel.fore.append(float(low[i, 2]))
            taken.add(i)
    for panel in panels:
        more = _hung(pieces, side, panel, taken, low, high)
        panel.trims += more
        taken |= set(more)
    for panel in panels:
        panel.box = [i for i in _box(pieces, side, panel, low, high) if i not in taken]
        taken |= set(panel.box)
    return rest


def handle_spots(pieces: Pieces, side: int, panels: list[Panel], controls: list[Control]) -> list[Floats]:
    """(2,) middles in (u, v) of what stands out from some panel like a handle."""
    low, high = face_on(pieces, side)
    taken = {f for p in panels for f in p.members}
    spots = []
    for i in range(pieces.count):
        host = None if i in taken else _host(panels, low[i], high[i])
        size = high[i, :2] - low[i, :2]
        if host is not None and float(host.low[2] - low[i, 2]) >= HANDLE_STANDS and size.max() > 2.5 * size.min():
            spots.append((low[i, :2] + high[i, :2]) / 2)
    spots += [c.middle for c in controls if c.long > 2.5 and c.stands >= HANDLE_STANDS]
    out: list[Floats] = []
    for spot in spots:
        if not any(np.abs(spot - o).max() < 0.03 for o in out):
            out.append(spot)
    return out


def _host(panels: list[Panel], low: Floats, high: Floats) -> Panel | None:
    """The panel that a piece lies on: the smallest that holds its middle and most of it, and touches its depth."""
    middle = (low + high)[:2] / 2
    found = None
    for p in panels:
        over = np.minimum(high, p.high)[:2] - np.maximum(low, p.low)[:2]
        share = float(np.prod(np.maximum(over, 1e-9)) / max(float(np.prod(np.maximum((high - low)[:2], 1e-9))), 1e-18))
        inside = bool((middle >= p.low[:2]).all() and (middle <= p.high[:2]).all()) and share >= 0.7
        reach = min((float(p.low[2]), *p.fore))
        near = low[2] >= p.low[2] - 0.12 and low[2] <= p.high[2] and high[2] >= reach - 0.02
        if inside and near and (found is None or p.width * p.height < found.width * found.height):
            found = p
    return found


def _pulls(panels: list[Panel], controls: list[Control]) -> list[Control]:
    """Take from the controls those that are pulls of a panel: alone on it, or a pair in mirrored places."""
    for panel in panels:
        own = [c for c in controls if _host([panel], c.low, c.high) is panel]
        bars = [c for c in own if c.long > 2.5 and panel.low[2] - c.low[2] >= HANDLE_STANDS]
        panel.grips += [c.fragments for c in bars]
        panel.fore += [float(c.low[2]) for c in bars]
        own = [c for c in own if not any(c is b for b in bars)]
        small = [
            c
            for c in own
            if panel.low[2] - c.low[2] >= HANDLE_STANDS
            and float(c.across.max()) <= 0.3 * min(panel.width, panel.height)
        ]
        mirrored = len(small) == 2 and abs(sum(float(c.middle[0]) for c in small) - panel.low[0] - panel.high[0]) < 0.02
        if not bars and ((len(own) == 1 and len(small) == 1) or (len(own) == 2 and mirrored)):
            panel.grips += [c.fragments for c in small]
            own = []
        panel.controls = len(own)
    held = {f for p in panels for g in p.grips for f in g}
    return [c for c in controls if not set(c.fragments) & held]


def _box(pieces: Pieces, side: int, panel: Panel, low: Floats, high: Floats) -> list[int]:
    """Pieces behind a panel that would go with it as a drawer's box: within its rectangle, from it backwards."""
    hidden = pieces.seen[:, [s for s in (BACK, LEFT, RIGHT, BOTTOM) if s != side]].sum(axis=1)
    surface = np.maximum(pieces.area, 1e-12)
    inside = (low[:, :2] >= panel.low[:2] - TIGHT).all(axis=1) & (high[:, :2] <= panel.high[:2] + TIGHT).all(axis=1)
    behind = (low[:, 2] >= panel.low[2] - SLACK) & (high[:, 2] > panel.high[2] + 0.01)
    close = low[:, 2] <= panel.high[2] + BOX_GAP
    first = np.flatnonzero(inside & behind & close & (hidden <= 0.05 * surface))
    if not len(first):
        return []
    reach = float(high[first, 2].max()) + SLACK
    more = np.flatnonzero(inside & (low[:, 2] >= panel.low[2]) & (high[:, 2] <= reach) & (hidden <= 0.05 * surface))
    found = sorted({*first.tolist(), *more.tolist()})
    return found if from_above(pieces, found).is_box else []


def _hung(pieces: Pieces, side: int, panel: Panel, taken: set[int], low: Floats, high: Floats) -> list[int]:
    """What hangs on the back of a panel: shallow, hidden, away from its edges, and in touch with it."""
    size = high - low
    hidden = pieces.seen.sum(axis=1) <= 0.02 * np.maximum(pieces.area, 1e-12)
    inset = (low[:, :2] >= panel.low[:2] + INSET).all(axis=1) & (high[:, :2] <= panel.high[:2] - INSET).all(axis=1)
    whole = float(high[:, 2].max() - low[:, 2].min())
    fits = inset & hidden & (low[:, 2] >= panel.low[2]) & (size[:, 2] <= SHALLOW * whole)
    found: list[int] = []
    edge = float(panel.high[2])
    rows = [i for i in np.flatnonzero(fits).tolist() if i not in taken]
    while True:
        hosts = [(panel.low, np.append(panel.high[:2], edge)), *((low[i], high[i]) for i in found)]
        more = [
            i
            for i in rows
            if i not in found
            and high[i, 2] <= edge + SHALLOW * whole
            and any((low[i] <= b + 0.003).all() and (high[i] >= a - 0.003).all() for a, b in hosts)
        ]
        if not more:
            return sorted(found)
        found += more


def box_depth(pieces: Pieces, side: int, panel: Panel) -> float:
    """How far the box of a panel reaches behind it."""
    _, high = face_on(pieces, side)
    return max((float(high[i, 2] - panel.high[2]) for i in panel.box), default=0.0)


def which_open(panels: list[Panel], whole: Floats) -> list[tuple[Panel, float, str]]:
    """Panels that open, with confidence and reason.

    Args:
        whole: (3,) extents of the thing in (u, v, w).
    """
    gripped = [p for p in panels if p.grips]
    boxed = [p for p in panels if p.box or p.high[2] - p.low[2] > 0.34 * whole[2]]
    sure = {id(p) for p in [*gripped, *boxed]}
    least = min((p.width * p.height for p in panels if id(p) in sure), default=0.0)
    out: list[tuple[Panel, float, str]] = []
    for p in panels:
        foot = p.width * p.height
        strip = p.height < STRIP * whole[1] or p.width < STRIP * whole[0]
        if p.grips and p.controls <= 3:
            out.append((p, 0.95, "has a handle"))
        elif p.grips and foot >= 0.25 * whole[0] * whole[1]:
            out.append((p, 0.9, "has a handle, and is large"))
        elif id(p) in sure:
            out.append((p, 0.8, "has a box behind it"))
        elif (
            strip
            or (p.controls and foot < 0.4 * whole[0] * whole[1])
            or (sure and foot < 0.6 * least)
            or (gripped and foot < 0.35 * max(q.width * q.height for q in gripped))
        ):
            continue
        elif foot >= 0.08 * whole[0] * whole[1]:
            out.append((p, 0.55, "lies on the front like a door"))
    return out
