"""Choose the horizontal slabs of a vessel, floor to rim, with as few wall sectors as an error allows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.revolution import RAYS, WallProfile

# A row is open, or solid, where this share of its rays says so; a choice.
OPEN_RAY_SHARE = 0.6
# A ring has at least this many sectors; a choice.
MIN_SECTORS = 6


@dataclass(frozen=True)
class Slab:
    """Rows from `first` to before `last` that become one ring of `sectors` (1: one part that is not cut)."""

    first: int
    last: int
    sectors: int


@dataclass(frozen=True)
class SlabCosts:
    """Errors of merging the rows from i to before j into one slab: (H, H + 1) arrays, metres.

    Attributes:
        bend: distance of the walls from their chords. filled_height: height of the opening that a hull would fill.
        hollow_below: height of the hollow below the floor that a hull would fill. has_floor: the axis is in the solid.
        radius: largest radius of the inner wall, times the sine of its steepness; 0 if there is no wall.
    """

    bend: Floats
    filled_height: Floats
    hollow_below: Floats
    has_floor: npt.NDArray[np.bool_]
    radius: Floats


def slab_costs(profile: WallProfile, is_round: bool) -> SlabCosts:
    """Measure the errors of every stretch of rows: by the median radius for round walls, else by every eighth ray."""
    count = len(profile.heights)
    is_open = (profile.inner > 0).mean(axis=1) >= OPEN_RAY_SHARE
    is_solid = (profile.inner == 0).mean(axis=1) >= OPEN_RAY_SHARE
    inner = np.where(is_open[:, None] & (profile.inner > 0), profile.inner, np.nan)
    outer = np.where((is_open | is_solid)[:, None], profile.outer, np.nan)
    inner_radius = np.nan_to_num(np.array([median_radius(row) for row in inner]))
    if is_round:
        sides = [np.array([[median_radius(row)] for row in radii]) for radii in (inner, -outer)]
    else:
        sides = [radii[:, :: RAYS // 12] for radii in (inner, -outer)]
    sides = [np.stack([_interpolated(column) for column in side.T], axis=1) for side in sides]
    is_below_floor = np.arange(count) < int(np.argmax(is_solid)) if is_solid.any() else np.zeros(count, dtype=bool)
    rise = np.hypot(profile.step, np.gradient(inner_radius)) if count > 1 else np.full(count, profile.step)
    felt_radius = inner_radius * profile.step / rise
    bends, filled_height = np.zeros((len(sides), count, count + 1)), np.zeros((count, count + 1))
    hollow_below = np.zeros((count, count + 1))
    has_floor, radius = np.zeros((count, count + 1), dtype=bool), np.zeros((count, count + 1))
    for first in range(count):
        for last in range(first + 1, count + 1):
            rows = slice(first, last)
            has_floor[first, last] = is_solid[rows].any()
            # The hollow below the floor is counted apart: it may be filled, since nothing is ever put there.
            filled_height[first, last] = float((is_open & ~is_below_floor)[rows].sum()) * profile.step
            hollow_below[first, last] = float((is_open & is_below_floor)[rows].sum()) * profile.step
            radius[first, last] = 0.0 if is_below_floor[rows].all() else felt_radius[rows].max()
            bends[:, first, last] = [_bend(radii[rows], profile.step) for radii in sides]
    bends = _largest_within(bends)
    bend = np.where(has_floor, bends[1], bends.max(axis=0))
    return SlabCosts(bend.round(9), filled_height.round(9), hollow_below.round(9), has_floor, radius.round(9))


def _largest_within(bends: Floats) -> Floats:
    """For each stretch of rows the largest error of all stretches within it, since a hull spans any two heights."""
    out = bends.copy()
    count = out.shape[1]
    for length in range(2, count + 1):
        first = np.arange(count - length + 1)
        last = first + length
        shorter = np.maximum(out[:, first, last - 1], out[:, np.minimum(first + 1, count - 1), last])
        out[:, first, last] = np.maximum(out[:, first, last], shorter)
    return out


def _interpolated(column: Floats) -> Floats:
    """The column with missing (nan) radii interpolated between their neighbours; all nan if no radius is known."""
    known = np.flatnonzero(np.isfinite(column))
    if not len(known):
        return column
    return np.interp(np.arange(len(column)), known, column[known])


def median_radius(row: Floats) -> float:
    """Median of the finite radii; nan if there are no finite radii."""
    known = row[np.isfinite(row)]
    return float(np.median(known)) if len(known) else np.nan


def choose_slabs(
    costs: SlabCosts, chord: float, bend: float, sector_count: int | None, foot_height_m: float
) -> list[Slab] | None:
    """Choose slabs, bottom to top, with the fewest parts that keep the walls within the errors; None if no choice does.

    Args:
        chord: error around the axis, metres. bend: error along it, metres.
        sector_count: sectors of a wall that is not round; None for a round one.
        foot_height_m: height of the hollow below the floor that may be filled.
    """
    count = len(costs.bend)
    sectors = _sectors(costs, chord, bend, sector_count, foot_height_m)
    cost = np.full(count + 1, np.inf)
    cost[0] = 0.0
    previous = np.zeros(count + 1, dtype=int)
    for last in range(1, count + 1):
        # The small constant prefers fewer slabs where the number of parts is the same.
        total = cost[:last] + sectors[:last, last] + 1e-3
        previous[last] = int(np.argmin(total))
        cost[last] = total[previous[last]]
    if not np.isfinite(cost[count]):
        return None
    slabs, last = [], count
    while last > 0:
        first = int(previous[last])
        slabs.append(Slab(first, last, int(sectors[first, last])))
        last = first
    return slabs[::-1]


def _sectors(costs: SlabCosts, chord: float, bend: float, sector_count: int | None, foot_height_m: float) -> Floats:
    """(H, H + 1) sectors that the rows from i to before j need as one slab; infinite where its error is too large."""
    half_angle = np.arccos(1 - chord / np.maximum(costs.radius, chord))
    ring = np.maximum(MIN_SECTORS, np.ceil((np.pi / half_angle).round(6)))
    ring = np.where(costs.radius > chord, ring if sector_count is None else float(max(sector_count, 3)), 1.0)
    ring = np.where((costs.radius == 0) & (costs.hollow_below > 0), float(MIN_SECTORS), ring)
    one_part = np.where((costs.filled_height <= max(chord, bend)) & (costs.hollow_below <= foot_height_m), 1.0, np.inf)
    fits: Floats = np.where(costs.bend <= bend, np.where(costs.has_floor, one_part, ring), np.inf)
    return fits


def _bend(radii: Floats, step: float) -> float:
    """Distance of a wall of (H, A) radii from the chords between its lowest and highest points, metres."""
    if len(radii) < 3:
        return 0.0
    share = np.linspace(0, 1, len(radii))[:, None]
    gaps = (radii - radii[:1] * (1 - share) - radii[-1:] * share).max(axis=0)
    gaps = gaps * _steepness(radii, step)
    known = np.sort(gaps[np.isfinite(gaps)])
    return float(known[(3 * len(known)) // 4]) if len(known) else 0.0


def _steepness(radii: Floats, step: float) -> Floats:
    """(A,) sine of the angle between the chord from the lowest to the highest point of a wall and the ground."""
    rise = step * max(len(radii) - 1, 1)
    found: Floats = rise / np.hypot(rise, radii[-1] - radii[0])
    return found
