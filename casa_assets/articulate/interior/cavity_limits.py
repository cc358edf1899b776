"""Fit a cavity that has to be built: within its front, before the back of the object, inside its skin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.interior.cavity_views import CavityProbe, border_points
from casa_assets.articulate.plan import Cavity, InteriorKind
from casa_assets.articulate.segment.rays import sample_grid
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.typing import Floats
from casa_assets.model.record import Vec3

# Lines across a front, each way, to see how much of it is open; a border that is open over so much is none.
FINE_LINES_PER_SIDE, OPEN_BORDER_SHARE = 24, 0.7
# A frame reaches at least so far inwards from the edge of its front, diagonals; else there is none.
MIN_FRAME_WIDTH = 0.006
# What is built keeps so far from the skin, diagonals, and shrinks by this part of itself while it pierces it.
SKIN_DISTANCE, SHRINK_SHARE, MAX_SHRINKS = 0.004, 0.06, 8
# Something lies in a hollow thing where so many lines meet it.
MIN_CONTENTS_SHARE = 0.25
# A front covers so much of a line that runs inside its border, by this part of its size; else it is round, and what
# can be behind it is smaller by the last part on every side, and again.
MIN_BORDER_COVERAGE, BORDER_INSET_SHARE, ROUND_SHRINK_SHARE = 0.85, 0.02, 0.03
# What lies within a leaf and is not its own keeps so far from its border, diagonals.
LEAF_MARGIN = 0.001
# Lines to each side of what is built, each way; so many of those near its corners have to meet the skin.
LINES_PER_SIDE = 5
# A line whose last surface is so much nearer than that of most left through a hole of the skin.
HOLE_DISTANCE_SHARE = 0.45


def fit_cavity(
    view: CavityProbe,
    own: Sequence[int],
    leaf: tuple[Floats, Floats],
    mouth: float,
    back: float,
    wall: float,
    filling: InteriorKind,
    closed: bool,
) -> Cavity:
    """Return the largest cavity behind a front.

    Args:
        own: places of its parts. leaf: their corners without handles.
        mouth, back: depths between which the body lies. wall: thickness of what is built round it.
        closed: the body is solid there, or closed off: it is cut open.
    """
    low, high = _covered(view, own, *leaf)
    low[1], high[1] = mouth, back - max(wall, SKIN_DISTANCE)
    low[[0, 2]] += wall
    high[[0, 2]] -= wall
    if not closed:
        low, high = _within_frame(view, own, leaf, mouth, low, high)
    outer_low, outer_high = _kept_inside(view, own, low - wall, high + wall)
    # The front of what is built lies in the mouth.
    outer_low[1] = mouth
    inner_low, inner_high = np.maximum(low, outer_low + _sheet(wall)), np.minimum(high, outer_high - _sheet(wall))
    inner_low[1] = mouth
    cut = None
    if closed:
        half = 0.5 * np.minimum(inner_low - outer_low, outer_high - inner_high)
        start = np.array([inner_low[0] - half[0], float(leaf[0][1]), inner_low[2] - half[2]])
        cut = (_vec(start), _vec(inner_high + half))
    return Cavity(
        parts=(),
        filling=filling,
        low=_vec(inner_low),
        high=_vec(inner_high),
        wall=wall,
        outer=(_vec(outer_low), _vec(outer_high)),
        built=True,
        cut=cut,
        fronts=_fronts(view, own, mouth) if closed else (),
        furnish=closed or not _has_contents(view, own, inner_low, inner_high),
    )


def _covered(view: CavityProbe, own: Sequence[int], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the corners of a front, shrunk where it is round until the front covers the border of what is left."""
    low, high = low.copy(), high.copy()
    for _ in range(MAX_SHRINKS):
        spots = border_points(low[[0, 2]], high[[0, 2]], BORDER_INSET_SHARE * float((high - low)[[0, 2]].min()))
        covered = np.isfinite(view.cast_through_leaves(1, spots, own).first())
        if float(covered.mean()) >= MIN_BORDER_COVERAGE and _corners(covered, spots):
            return low, high
        low[[0, 2]], high[[0, 2]] = (
            low[[0, 2]] + ROUND_SHRINK_SHARE * (high - low)[[0, 2]],
            high[[0, 2]] - ROUND_SHRINK_SHARE * (high - low)[[0, 2]],
        )
    return np.array(low), np.array(high)


def _corners(covered: Bools, spots: Floats) -> bool:
    """Return whether the points nearest to the four corners are covered."""
    low, high = spots.min(axis=0), spots.max(axis=0)
    away = [np.abs(spots - (x, y)).sum(axis=1) for x in (low[0], high[0]) for y in (low[1], high[1])]
    return all(bool(covered[np.round(d, 9) <= round(float(d.min()), 9)].all()) for d in away)


def _fronts(view: CavityProbe, own: Sequence[int], mouth: float) -> tuple[tuple[Vec3, Vec3], ...]:
    """Return boxes of leaves that are rectangles, at a small distance from the body around and behind them."""
    out = []
    for part in own:
        low, high = view.leaf_box(part)
        a, b = _covered(view, (part,), low, high)
        end = min(mouth, view.leaf_back((part,), low, high)) - LEAF_MARGIN
        if (a == low).all() and (b == high).all() and end > low[1] + LEAF_MARGIN:
            shift = np.array([LEAF_MARGIN, -LEAF_MARGIN, LEAF_MARGIN])
            out.append((_vec(low + shift), _vec([high[0] - LEAF_MARGIN, end, high[2] - LEAF_MARGIN])))
    return tuple(out)


def _sheet(wall: float) -> Floats:
    """Return the least thickness of a wall, each way."""
    return np.full(3, 0.3 * wall)


def _within_frame(
    view: CavityProbe, own: Sequence[int], leaf: tuple[Floats, Floats], mouth: float, low: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """Shrink a cavity to the frame that a hollow object has around its opening."""
    a, b = leaf[0][[0, 2]], leaf[1][[0, 2]]
    lines = view.cast_lines(1, sample_grid(a, b, FINE_LINES_PER_SIDE), own)
    depth = lines.select(lines.at > float(leaf[0][1])).first().reshape(FINE_LINES_PER_SIDE, FINE_LINES_PER_SIDE)
    clear: Bools = depth > mouth + 0.05
    step = (b - a) / FINE_LINES_PER_SIDE
    low, high = low.copy(), high.copy()
    for axis, k in ((0, 0), (2, 1)):
        share = clear.mean(axis=1 - k)
        rows = np.flatnonzero(share >= OPEN_BORDER_SHARE * share.max(initial=0.0))
        if not len(rows) or share.max() < 0.3:
            continue
        start, stop = float(a[k] + rows[0] * step[k]), float(b[k] - (FINE_LINES_PER_SIDE - 1 - rows[-1]) * step[k])
        if start - float(a[k]) > MIN_FRAME_WIDTH:
            low[axis] = max(low[axis], start) if start - float(a[k]) > 2 * step[k] else low[axis]
        if float(b[k]) - stop > MIN_FRAME_WIDTH:
            high[axis] = min(high[axis], stop) if float(b[k]) - stop > 2 * step[k] else high[axis]
    return low, high


def _kept_inside(view: CavityProbe, own: Sequence[int], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Shrink a box until the skin of the object lies around all of it, as seen from its middle."""
    body = view.points[view.faces[view.owner == -1]].reshape(-1, 3)
    if len(body):
        low = np.maximum(low, body.min(axis=0) + SKIN_DISTANCE)
        high = np.minimum(high, body.max(axis=0) - SKIN_DISTANCE)
    for _ in range(MAX_SHRINKS):
        moved = False
        for axis in (0, 1, 2):
            for sign in (-1.0, 1.0) if axis != 1 else (1.0,):
                end = _reach(view, own, low, high, axis, sign)
                if sign > 0 and end < high[axis] - 1e-6:
                    high[axis], moved = max(end, high[axis] - SHRINK_SHARE * (high[axis] - low[axis])), True
                if sign < 0 and end > low[axis] + 1e-6:
                    low[axis], moved = min(end, low[axis] + SHRINK_SHARE * (high[axis] - low[axis])), True
        if not moved:
            break
    return low, high


def _reach(view: CavityProbe, own: Sequence[int], low: Floats, high: Floats, axis: int, sign: float) -> float:
    """Return how far a box may go to a side before it pierces the skin at one of its edges there."""
    a, b = (k for k in range(3) if k != axis)
    share = np.linspace(0.004, 0.996, LINES_PER_SIDE)
    x, y = (low[k] + share * (high[k] - low[k]) for k in (a, b))
    lines = view.cast_lines(axis, np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2), own)
    # The farthest surface on each line is the skin; a line that leaves through a hole says nothing.
    far = lines.last() if sign > 0 else lines.first()
    away = np.where(np.isfinite(far), (far - (low[axis] + high[axis]) / 2) * sign, -1.0)
    if not (away > 0).any():
        return float(high[axis] if sign > 0 else low[axis])
    seen = away >= HOLE_DISTANCE_SHARE * float(np.median(away[away > 0]))
    least = float((far[seen] * sign).min()) * sign
    return least - sign * SKIN_DISTANCE


def _has_contents(view: CavityProbe, own: Sequence[int], low: Floats, high: Floats) -> bool:
    """Return whether something lies in a hollow cavity already: shelves, racks, pipes."""
    inset = 0.1 * (high - low)
    a, b = low + inset, high - inset
    for axis in (2, 0):
        p, q = (k for k in range(3) if k != axis)
        lines = view.cast_lines(axis, sample_grid(a[[p, q]], b[[p, q]], LINES_PER_SIDE), own)
        inside = lines.select((lines.at > a[axis]) & (lines.at < b[axis]))
        if float(np.isfinite(inside.first()).mean()) >= MIN_CONTENTS_SHARE:
            return True
    return False


def _vec(values: Floats | Sequence[float]) -> Vec3:
    """Return three numbers."""
    x, y, z = (float(v) for v in values)
    return (x, y, z)
