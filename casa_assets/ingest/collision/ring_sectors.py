"""Cut an open vessel into a floor and rings of wall sectors around its axis, as few as keep the opening open."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.cutting import Solid, connected_parts, revolve_profile, split_by_plane, surface_of
from casa_assets.geometry.solid.revolution import RAYS, WallProfile, radius_spread, upright_axis, wall_profile
from casa_assets.ingest.collision.ring_slabs import (
    OPEN_RAY_SHARE,
    Slab,
    SlabCosts,
    choose_slabs,
    median_radius,
    slab_costs,
)

# Radii of one height that differ by less than this share are round.
ROUND_SPREAD = 0.05
# The outline of a body without its handles: so many of a hundred rays leave it before that.
OUTLINE_PERCENTILE = 85
# Errors that are tried, each so many times the one before.
GROWTH = 1.2
STEPS = 14
MIN_PART_SHARE = 1e-4
# Parts that are left for each handle.
PER_HANDLE = 6
# How the error is shared between chords around the axis and those along it.
CHORD_ERROR_SHARES = (1.0, 0.6, 1.4)
# By how much of the error an inner wall is set back, and how much of its thickness at most.
SETBACK_SHARE = 0.8
MAX_SETBACK_SHARE = 0.6


@dataclass(frozen=True)
class CutVessel:
    """An open vessel, cut.

    Attributes:
        floors: that are one part each. cells: parts of the walls, most of them near convex.
        rest: handles, knobs and spouts.
        message: how it was cut, in words with numbers.
    """

    floors: tuple[Solid, ...]
    cells: tuple[Solid, ...]
    rest: tuple[Solid, ...]
    message: str


def cut_vessel(solid: Solid, finest: float, fair: float, foot: float, most: int) -> CutVessel | None:
    """A vessel as a floor, rings of sectors and handles; None where no such cut stays within `most` parts.

    Args:
        solid: metres, z up, simplified.
        finest: error of a hull below which more of them are a waste, metres.
        fair: error up to which what is hollow under the floor is kept hollow, too; beyond it may be filled.
        foot: how high that hollow may be, metres. most: parts of floor and walls.
    """
    center, share = upright_axis(*surface_of(solid))
    seen = wall_profile(solid, center)
    is_round = float(np.median([radius_spread(row) for row in seen.outer])) < ROUND_SPREAD
    asked = slab_costs(seen, is_round)
    for step in range(STEPS):
        error = finest * GROWTH**step
        under = min(error, foot) if error <= fair else foot
        plans = [
            _plan(seen, asked, error * share_, error * (2 - share_), is_round, under) for share_ in CHORD_ERROR_SHARES
        ]
        known = [plan for plan in plans if plan is not None and plan.count <= most]
        if not known:
            continue
        plan = min(known, key=lambda p: p.count)
        body, handles = _without_handles(solid, seen, error / 2) if is_round else (solid, [])
        if plan.count <= most - min(PER_HANDLE * len(handles), most // 3):
            floors, cells = _cells(_eased(body, seen, SETBACK_SHARE * error) if is_round else body, seen, plan)
            if not is_round:
                floors, cells = [], [*floors, *cells]
            message = f"{share:.0%} of the wall turns about one axis" if is_round else "walls that are not round"
            return CutVessel(
                tuple(floors), tuple(cells), tuple(handles), f"{message}: {plan.message}, {1000 * error:.2g} mm off"
            )
    return None


@dataclass(frozen=True)
class RingPlan:
    """Plan of a cut: slabs, and the rays at which walls that are not round are cut."""

    slabs: tuple[Slab, ...]
    turns: tuple[int, ...] | None

    @property
    def count(self) -> int:
        """Parts that it makes."""
        return sum(slab.sectors for slab in self.slabs)

    @property
    def message(self) -> str:
        """In words with numbers."""
        rings = sum(slab.sectors > 1 for slab in self.slabs)
        most = max(slab.sectors for slab in self.slabs)
        return f"{len(self.slabs) - rings} floors, {rings} rings of up to {most} sectors"


def _plan(
    seen: WallProfile, asked: SlabCosts, chord: float, bend: float, is_round: bool, foot: float
) -> RingPlan | None:
    turns = None if is_round else tuple(_turns(seen, chord))
    found = choose_slabs(asked, chord, bend, None if turns is None else len(turns), foot)
    return None if found is None else RingPlan(tuple(found), turns)


def _without_handles(solid: Solid, seen: WallProfile, gap: float) -> tuple[Solid, list[Solid]]:
    """Body within its revolved outline, and the parts outside of it: handles, knobs, spouts."""
    radius = np.array(
        [float(np.nanpercentile(r, OUTLINE_PERCENTILE)) if np.isfinite(r).any() else np.nan for r in seen.outer]
    )
    known = np.isfinite(radius) & (np.isfinite(seen.outer).mean(axis=1) > OPEN_RAY_SHARE)
    if not known.any():
        return solid, []
    radius = np.interp(seen.heights, seen.heights[known], radius[known])
    # The widest of three neighbours: the outline follows slopes from outside.
    padded = np.pad(radius, 1, mode="edge")
    wide = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:]) + gap
    low, high = seen.heights[0] - seen.step, seen.heights[-1] + seen.step
    top = float(seen.heights[known][-1] + 1.5 * seen.step)
    heights = np.concatenate([[low], seen.heights, [high]])
    wide = np.concatenate([wide[:1], wide, wide[-1:]])
    below = heights <= top
    profile = np.concatenate(
        [
            [[0.0, heights[below][0]]],
            np.stack([wide[below], heights[below]], axis=1),
            [[wide[below][-1], top], [0.0, top]],
        ]
    )
    outline = revolve_profile(profile, RAYS).translate((float(seen.center[0]), float(seen.center[1]), 0.0))
    least = MIN_PART_SHARE * float(solid.volume())
    handles = [p for p in connected_parts(solid - outline, 10 * least) if _reach(p) > 4 * gap]
    if not handles:
        return solid, []
    body = solid
    for handle in handles:
        body = body - handle
    # What is left of a handle, be it a film or inside out, would draw the hull of the wall out to it.
    return manifold3d.Manifold.compose(connected_parts(body, least)), handles


def _reach(solid: Solid) -> float:
    box = np.array(solid.bounding_box())
    return float((box[3:] - box[:3]).max())


def _turns(seen: WallProfile, error: float) -> list[int]:
    """Rays at which a wall that is not round is cut, as few as keep every chord within the error of the inner wall."""
    hollow = (seen.inner > 0).mean(axis=1) >= OPEN_RAY_SHARE
    rows = np.flatnonzero(hollow)
    if not len(rows):
        return []
    picked = rows[np.linspace(0, len(rows) - 1, min(5, len(rows))).round().astype(int)]
    angles = (np.arange(RAYS) + 0.5) * 2 * np.pi / RAYS
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    radii = seen.inner[picked]
    radii = np.where(np.isfinite(radii) & (radii > 0), radii, np.nan)
    radii = np.where(np.isfinite(radii), radii, np.nanmedian(radii, axis=1, keepdims=True))
    places = radii[:, :, None] * ray
    reach = [_farthest(places, start, error) for start in range(RAYS)]
    best: list[int] = []
    for start in range(RAYS):
        cuts, at = [start], start
        while (at := at + reach[at % RAYS]) < start + RAYS:
            cuts.append(at % RAYS)
        if not best or len(cuts) < len(best):
            best = cuts
    return sorted(best)


def _farthest(places: Floats, start: int, error: float) -> int:
    """Most rays that a chord from `start` may span with no part of the wall farther beyond it than `error`."""
    farthest = 1
    for count in range(2, RAYS // 4 + 1):
        index = (start + np.arange(count + 1)) % RAYS
        stretch = places[:, index]
        chord = stretch[:, -1] - stretch[:, 0]
        away = np.stack([chord[:, 1], -chord[:, 0]], axis=1)
        away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
        beyond = np.einsum("rki,ri->rk", stretch - stretch[:, :1], away)
        if float(beyond.max().round(7)) > error:
            break
        farthest = count
    return farthest


def _eased(solid: Solid, seen: WallProfile, gap: float) -> Solid:
    """The body with its inner wall set back by a gap: chords lie as far before that wall as their ends behind it."""
    hollow = np.flatnonzero((seen.inner > 0).mean(axis=1) >= OPEN_RAY_SHARE)
    if not len(hollow):
        return solid
    inner = np.array([median_radius(seen.inner[k]) for k in hollow])
    outer = np.array([median_radius(seen.outer[k]) for k in hollow])
    # Only from the floor up, and never more than a part of the wall.
    start = len(hollow) - 1
    while start > 0 and hollow[start - 1] == hollow[start] - 1:
        start -= 1
    inner, outer, hollow = inner[start:], outer[start:], hollow[start:]
    if len(hollow) < 2 or not np.isfinite(inner).all() or not np.isfinite(outer).all():
        return solid
    wide = inner + np.minimum(gap, MAX_SETBACK_SHARE * (outer - inner))
    heights = seen.heights[hollow]
    # A little into the floor: no film of it may stay in the rings above.
    low, high = heights[0] - 0.6 * seen.step, heights[-1] + seen.step
    profile = np.concatenate(
        [
            [[0.0, low], [wide[0], low]],
            np.stack([wide, heights], axis=1),
            [[wide[-1], high], [0.0, high]],
        ]
    )
    core = revolve_profile(profile, RAYS).translate((float(seen.center[0]), float(seen.center[1]), 0.0))
    eased = solid - core
    return eased if eased.volume() > 0 else solid


def _cells(solid: Solid, seen: WallProfile, plan: RingPlan) -> tuple[list[Solid], list[Solid]]:
    """The slabs that are one part each, and the parts of the solid in every sector of the others."""
    up = np.array([0.0, 0.0, 1.0])
    floors: list[Solid] = []
    cells: list[Solid] = []
    rest = solid
    for slab in plan.slabs:
        layer = rest
        if slab is not plan.slabs[-1]:
            rest, layer = split_by_plane(rest, up, float(seen.heights[slab.last - 1] + seen.step / 2))
        if slab.sectors == 1:
            floors.append(layer)
        elif plan.turns is None:
            cells += _wedges(layer, seen.center, np.arange(slab.sectors) * 2 * np.pi / slab.sectors)
        else:
            cells += _wedges(layer, seen.center, (np.array(plan.turns) + 0.5) * 2 * np.pi / RAYS)
    least = MIN_PART_SHARE / 10 * float(solid.volume())
    return [f for f in floors if f.volume() > least], [cell for cell in cells if cell.volume() > least]


def _wedges(layer: Solid, center: Floats, edges: Floats) -> list[Solid]:
    """The layer between neighbouring half planes about the axis; no two of them are more than half a turn apart."""
    out = []
    for k in range(len(edges)):
        begin, end = edges[k], edges[(k + 1) % len(edges)]
        left = np.array([-np.sin(begin), np.cos(begin), 0.0])
        right = np.array([np.sin(end), -np.cos(end), 0.0])
        wedge = split_by_plane(layer, left, float(left[:2] @ center))[0]
        out.append(split_by_plane(wedge, right, float(right[:2] @ center))[0])
    return out
