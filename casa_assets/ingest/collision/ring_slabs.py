"""Choose the horizontal slabs of a vessel, floor to rim, with as few wall sectors as an error allows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.revolution import RAYS, WallProfile

# A wall starts where this share of the rays finds no matter at the axis.
OPEN_RAY_SHARE = 0.6
FEWEST_SECTORS = 6


@dataclass(frozen=True)
class Slab:
    """Rows from `first` to before `last` that are cut alike, in `sectors` (1: not at all)."""

    first: int
    last: int
    sectors: int


@dataclass(frozen=True)
class SlabCosts:
    """Errors of merging the rows from i to before j into one slab, by (i, j); metres.

    Attributes:
        bend: how far the walls recede from chords. filled: of the opening, in height.
        under: of what is hollow below the floor. full: the axis is in matter.
        radius: of the inner wall at its widest, as a wall that is so steep feels it; 0 where there is none.
    """

    bend: Floats
    filled: Floats
    under: Floats
    full: npt.NDArray[np.bool_]
    radius: Floats


def slab_costs(seen: WallProfile, is_round: bool) -> SlabCosts:
    """Measure the error of every stretch of rows; the middle radius decides for round walls, else every eighth ray."""
    count = len(seen.heights)
    hollow = (seen.inner > 0).mean(axis=1) >= OPEN_RAY_SHARE
    full = (seen.inner == 0).mean(axis=1) >= OPEN_RAY_SHARE
    inner = np.where(hollow[:, None] & (seen.inner > 0), seen.inner, np.nan)
    outer = np.where((hollow | full)[:, None], seen.outer, np.nan)
    widest = np.nan_to_num(np.array([median_radius(row) for row in inner]))
    if is_round:
        sides = [np.array([[median_radius(row)] for row in radii]) for radii in (inner, -outer)]
    else:
        sides = [radii[:, :: RAYS // 12] for radii in (inner, -outer)]
    sides = [np.stack([_bridged(column) for column in side.T], axis=1) for side in sides]
    below = np.arange(count) < int(np.argmax(full)) if full.any() else np.zeros(count, dtype=bool)
    rise = np.hypot(seen.step, np.gradient(widest)) if count > 1 else np.full(count, seen.step)
    felt = widest * seen.step / rise
    bends, filled = np.zeros((len(sides), count, count + 1)), np.zeros((count, count + 1))
    under = np.zeros((count, count + 1))
    has_full, radius = np.zeros((count, count + 1), dtype=bool), np.zeros((count, count + 1))
    for first in range(count):
        for last in range(first + 1, count + 1):
            rows = slice(first, last)
            has_full[first, last] = full[rows].any()
            # What is hollow under the floor may be filled sooner: nothing is ever put there.
            filled[first, last] = float((hollow & ~below)[rows].sum()) * seen.step
            under[first, last] = float((hollow & below)[rows].sum()) * seen.step
            radius[first, last] = 0.0 if below[rows].all() else felt[rows].max()
            bends[:, first, last] = [_bend(radii[rows], seen.step) for radii in sides]
    bends = _widest(bends)
    bend = np.where(has_full, bends[1], bends.max(axis=0))
    return SlabCosts(bend.round(9), filled.round(9), under.round(9), has_full, radius.round(9))


def _widest(bends: Floats) -> Floats:
    """The worst of all chords within each stretch of rows: a hull has one from every height to every other."""
    out = bends.copy()
    count = out.shape[1]
    for length in range(2, count + 1):
        first = np.arange(count - length + 1)
        last = first + length
        shorter = np.maximum(out[:, first, last - 1], out[:, np.minimum(first + 1, count - 1), last])
        out[:, first, last] = np.maximum(out[:, first, last], shorter)
    return out


def _bridged(column: Floats) -> Floats:
    """Heights without a radius get one between those of their neighbours; all nan where none has one."""
    known = np.flatnonzero(np.isfinite(column))
    if not len(known):
        return column
    return np.interp(np.arange(len(column)), known, column[known])


def median_radius(row: Floats) -> float:
    """Median of the radii that are known, nan where none is."""
    known = row[np.isfinite(row)]
    return float(np.median(known)) if len(known) else np.nan


def choose_slabs(of: SlabCosts, chord: float, bend: float, turns: int | None, foot: float) -> list[Slab] | None:
    """Choose slabs, bottom to top, with as few parts as keep the walls within the errors; None where none do.

    Args:
        chord: error around the axis, metres. bend: error along it, metres.
        turns: sectors of a wall that is not round. foot: height below the floor that may be filled, metres.
    """
    count = len(of.bend)
    sectors = _sectors(of, chord, bend, turns, foot)
    cost = np.full(count + 1, np.inf)
    cost[0] = 0.0
    before = np.zeros(count + 1, dtype=int)
    for last in range(1, count + 1):
        # Of two ways with as many parts the one with fewer slabs.
        total = cost[:last] + sectors[:last, last] + 1e-3
        before[last] = int(np.argmin(total))
        cost[last] = total[before[last]]
    if not np.isfinite(cost[count]):
        return None
    out, last = [], count
    while last > 0:
        first = int(before[last])
        out.append(Slab(first, last, int(sectors[first, last])))
        last = first
    return out[::-1]


def _sectors(of: SlabCosts, chord: float, bend: float, turns: int | None, foot: float) -> Floats:
    """(H, H + 1) into how many sectors the rows from i to before j have to be cut; infinite where they bend or fill."""
    half = np.arccos(1 - chord / np.maximum(of.radius, chord))
    ring = np.maximum(FEWEST_SECTORS, np.ceil((np.pi / half).round(6)))
    ring = np.where(of.radius > chord, ring if turns is None else float(max(turns, 3)), 1.0)
    ring = np.where((of.radius == 0) & (of.under > 0), float(FEWEST_SECTORS), ring)
    whole = np.where((of.filled <= max(chord, bend)) & (of.under <= foot), 1.0, np.inf)
    fits: Floats = np.where(of.bend <= bend, np.where(of.full, whole, ring), np.inf)
    return fits


def _bend(radii: Floats, step: float) -> float:
    """Distance that a wall, (H, A) radii, recedes from the chords between its lowest and highest points; metres."""
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
