"""Fit a cavity that has to be built: within its front, before the back of the object, inside its skin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.interior.cavity_views import CavityProbe, border_points
from casa_assets.articulate.plan import Cavity, InteriorKind
from casa_assets.articulate.segment.rays import sample_grid
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.articulate.vectors import to_vec3
from casa_assets.core.typing import Floats
from casa_assets.model.record import Vec3

# Lines across a front, each way, to find its open part; a row that is open to this share of the most open one is no
# frame.
FINE_LINES_PER_SIDE, OPEN_BORDER_SHARE = 24, 0.7
# Narrowest frame, diagonals.
MIN_FRAME_WIDTH = 0.006
# Distance of built walls from the skin, diagonals, and the share by which a cavity shrinks while it pierces the skin.
SKIN_DISTANCE, SHRINK_SHARE, MAX_SHRINKS = 0.004, 0.06, 8
# A cavity has contents if this share of the lines meets something.
MIN_CONTENTS_SHARE = 0.25
# A rectangular front covers this share of a line inside its border (inset by a share of its size); a round one is
# shrunk by the last share on every side until it does.
MIN_BORDER_COVERAGE, BORDER_INSET_SHARE, ROUND_SHRINK_SHARE = 0.85, 0.02, 0.03
# Margin of the boxes in which the body has nothing to be, within a panel, diagonals.
PANEL_MARGIN = 0.001
# Lines to each side of a cavity, each way.
LINES_PER_SIDE = 5
# A line whose last surface is nearer than this share of the median left through a hole of the skin.
HOLE_DISTANCE_SHARE = 0.45


def fit_cavity(
    probe: CavityProbe,
    part_ids: Sequence[int],
    panel_box: tuple[Floats, Floats],
    mouth: float,
    back: float,
    wall: float,
    interior: InteriorKind,
    is_closed: bool,
) -> Cavity:
    """Return the largest cavity behind a front.

    Args:
        part_ids: places of its parts. panel_box: their corners without handles.
        mouth, back: depths between which the body lies. wall: thickness of what is built round it.
        is_closed: the body is solid there, or closed off: it is cut open.
    """
    lower, upper = _shrink_to_covered(probe, part_ids, *panel_box)
    lower[1], upper[1] = mouth, back - max(wall, SKIN_DISTANCE)
    lower[[0, 2]] += wall
    upper[[0, 2]] -= wall
    if not is_closed:
        lower, upper = _shrink_to_frame(probe, part_ids, panel_box, mouth, lower, upper)
    outer_low, outer_high = _shrink_to_skin(probe, part_ids, lower - wall, upper + wall)
    # The front of what is built lies in the mouth.
    outer_low[1] = mouth
    inner_low, inner_high = (
        np.maximum(lower, outer_low + _min_wall(wall)),
        np.minimum(upper, outer_high - _min_wall(wall)),
    )
    inner_low[1] = mouth
    cut = None
    if is_closed:
        half = 0.5 * np.minimum(inner_low - outer_low, outer_high - inner_high)
        start = np.array([inner_low[0] - half[0], float(panel_box[0][1]), inner_low[2] - half[2]])
        cut = (to_vec3(start), to_vec3(inner_high + half))
    return Cavity(
        parts=(),
        interior=interior,
        lower=to_vec3(inner_low),
        upper=to_vec3(inner_high),
        wall=wall,
        outer=(to_vec3(outer_low), to_vec3(outer_high)),
        built=True,
        cut=cut,
        fronts=_panel_boxes(probe, part_ids, mouth) if is_closed else (),
        furnish=is_closed or not _has_contents(probe, part_ids, inner_low, inner_high),
    )


def _shrink_to_covered(
    probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Return the corners of a front, shrunk where it is round until the front covers the border of what is left."""
    lower, upper = lower.copy(), upper.copy()
    for _ in range(MAX_SHRINKS):
        spots = border_points(lower[[0, 2]], upper[[0, 2]], BORDER_INSET_SHARE * float((upper - lower)[[0, 2]].min()))
        covered = np.isfinite(probe.cast_through_panels(1, spots, part_ids).first())
        if float(covered.mean()) >= MIN_BORDER_COVERAGE and _corners_covered(covered, spots):
            return lower, upper
        lower[[0, 2]], upper[[0, 2]] = (
            lower[[0, 2]] + ROUND_SHRINK_SHARE * (upper - lower)[[0, 2]],
            upper[[0, 2]] - ROUND_SHRINK_SHARE * (upper - lower)[[0, 2]],
        )
    return np.array(lower), np.array(upper)


def _corners_covered(covered: Bools, spots: Floats) -> bool:
    """Return whether the points nearest to the four corners are covered."""
    lower, upper = spots.min(axis=0), spots.max(axis=0)
    away = [np.abs(spots - (x, y)).sum(axis=1) for x in (lower[0], upper[0]) for y in (lower[1], upper[1])]
    return all(bool(covered[np.round(d, 9) <= round(float(d.min()), 9)].all()) for d in away)


def _panel_boxes(probe: CavityProbe, part_ids: Sequence[int], mouth: float) -> tuple[tuple[Vec3, Vec3], ...]:
    """Return boxes of panels that are rectangles, at a small distance from the body around and behind them."""
    out = []
    for part in part_ids:
        lower, upper = probe.panel_box_of(part)
        a, b = _shrink_to_covered(probe, (part,), lower, upper)
        end = min(mouth, probe.panel_back_depth((part,), lower, upper)) - PANEL_MARGIN
        if (a == lower).all() and (b == upper).all() and end > lower[1] + PANEL_MARGIN:
            shift = np.array([PANEL_MARGIN, -PANEL_MARGIN, PANEL_MARGIN])
            out.append((to_vec3(lower + shift), to_vec3([upper[0] - PANEL_MARGIN, end, upper[2] - PANEL_MARGIN])))
    return tuple(out)


def _min_wall(wall: float) -> Floats:
    """Return the least thickness of a wall, each way."""
    return np.full(3, 0.3 * wall)


def _shrink_to_frame(
    probe: CavityProbe,
    part_ids: Sequence[int],
    panel_box: tuple[Floats, Floats],
    mouth: float,
    lower: Floats,
    upper: Floats,
) -> tuple[Floats, Floats]:
    """Shrink a cavity to the frame that a hollow object has around its opening."""
    a, b = panel_box[0][[0, 2]], panel_box[1][[0, 2]]
    lines = probe.cast_lines(1, sample_grid(a, b, FINE_LINES_PER_SIDE), part_ids)
    depth = lines.select(lines.at > float(panel_box[0][1])).first().reshape(FINE_LINES_PER_SIDE, FINE_LINES_PER_SIDE)
    is_open: Bools = depth > mouth + 0.05
    step = (b - a) / FINE_LINES_PER_SIDE
    lower, upper = lower.copy(), upper.copy()
    for axis, k in ((0, 0), (2, 1)):
        share = is_open.mean(axis=1 - k)
        rows = np.flatnonzero(share >= OPEN_BORDER_SHARE * share.max(initial=0.0))
        if not len(rows) or share.max() < 0.3:
            continue
        start, stop = float(a[k] + rows[0] * step[k]), float(b[k] - (FINE_LINES_PER_SIDE - 1 - rows[-1]) * step[k])
        if start - float(a[k]) > MIN_FRAME_WIDTH:
            lower[axis] = max(lower[axis], start) if start - float(a[k]) > 2 * step[k] else lower[axis]
        if float(b[k]) - stop > MIN_FRAME_WIDTH:
            upper[axis] = min(upper[axis], stop) if float(b[k]) - stop > 2 * step[k] else upper[axis]
    return lower, upper


def _shrink_to_skin(probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Shrink a box until the skin of the object lies around all of it, as seen from its middle."""
    body = probe.points[probe.faces[probe.owner == -1]].reshape(-1, 3)
    if len(body):
        lower = np.maximum(lower, body.min(axis=0) + SKIN_DISTANCE)
        upper = np.minimum(upper, body.max(axis=0) - SKIN_DISTANCE)
    for _ in range(MAX_SHRINKS):
        moved = False
        for axis in (0, 1, 2):
            for sign in (-1.0, 1.0) if axis != 1 else (1.0,):
                end = _reach_inside_skin(probe, part_ids, lower, upper, axis, sign)
                if sign > 0 and end < upper[axis] - 1e-6:
                    upper[axis], moved = max(end, upper[axis] - SHRINK_SHARE * (upper[axis] - lower[axis])), True
                if sign < 0 and end > lower[axis] + 1e-6:
                    lower[axis], moved = min(end, lower[axis] + SHRINK_SHARE * (upper[axis] - lower[axis])), True
        if not moved:
            break
    return lower, upper


def _reach_inside_skin(
    probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats, axis: int, sign: float
) -> float:
    """Return how far a box may go to a side before it pierces the skin at one of its edges there."""
    a, b = (k for k in range(3) if k != axis)
    share = np.linspace(0.004, 0.996, LINES_PER_SIDE)
    x, y = (lower[k] + share * (upper[k] - lower[k]) for k in (a, b))
    lines = probe.cast_lines(axis, np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2), part_ids)
    # The farthest surface on each line is the skin; a line that leaves through a hole says nothing.
    far = lines.last() if sign > 0 else lines.first()
    distance = np.where(np.isfinite(far), (far - (lower[axis] + upper[axis]) / 2) * sign, -1.0)
    if not (distance > 0).any():
        return float(upper[axis] if sign > 0 else lower[axis])
    seen = distance >= HOLE_DISTANCE_SHARE * float(np.median(distance[distance > 0]))
    nearest = float((far[seen] * sign).min()) * sign
    return nearest - sign * SKIN_DISTANCE


def _has_contents(probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats) -> bool:
    """Return whether something lies in a hollow cavity already: shelves, racks, pipes."""
    inset = 0.1 * (upper - lower)
    a, b = lower + inset, upper - inset
    for axis in (2, 0):
        p, q = (k for k in range(3) if k != axis)
        lines = probe.cast_lines(axis, sample_grid(a[[p, q]], b[[p, q]], LINES_PER_SIDE), part_ids)
        inside = lines.select((lines.at > a[axis]) & (lines.at < b[axis]))
        if float(np.isfinite(inside.first()).mean()) >= MIN_CONTENTS_SHARE:
            return True
    return False
