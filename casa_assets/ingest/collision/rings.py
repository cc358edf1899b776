"""Collision shapes of round vessels: walls measured around an upright axis, as rings of convex pieces."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.solids import (
    Solid,
    connected_parts,
    revolve_profile,
    section_contours,
    split_by_plane,
    surface_of,
)
from casa_assets.mesh.surface import face_normals

# A face belongs to a turned surface where its normal misses the axis by less than this sine.
AXIS_MISS_SINE = 0.17
ROUNDS = 12
ROWS = 60
RAYS = 96
# A row is open, or solid, where this share of its rays says so; a choice.
OPEN_RAY_SHARE = 0.6
# A ring has at least this many sectors; a choice.
MIN_SECTORS = 6
# All numbers below are choices.
# A vessel is round if the radii at one height differ by less than this share.
ROUND_SPREAD = 0.05
# Percentile of the outer radii at one height that is the radius of the body without handles.
OUTLINE_PERCENTILE = 85
# Errors are tried in steps, each this many times the one before.
ERROR_GROWTH, MAX_STEPS = 1.2, 14
# Parts below this share of the volume are crumbs of the cut.
MIN_PART_SHARE = 1e-4
# Parts that are kept for each handle.
PARTS_PER_HANDLE = 6
# Shares of the error that go to chords around the axis; two minus that goes to those along it.
CHORD_ERROR_SHARES = (1.0, 0.6, 1.4)
# Distance that the inner wall is set back, as a share of the error, and at most as a share of its thickness.
SETBACK_SHARE, MAX_SETBACK_SHARE = 0.8, 0.6


@dataclass(frozen=True)
class WallProfile:
    """Walls of a solid around an upright axis, at ROWS heights and RAYS angles.

    `center`: (2,) x and y of the axis, metres. `heights`: (H,) metres, ascending. `step`: between two, metres. `inner`:
    (H, A) radius at which matter begins, 0 if the axis is in it, nan if there is no matter. `outer`: (H, A) radius at
    which the first stretch of matter ends.
    """

    center: Floats
    heights: Floats
    step: float
    inner: Floats
    outer: Floats


def upright_axis(points: Floats, faces: Ints) -> tuple[Floats, float]:
    """(2,) x and y of the axis that most normals point at, and the share of the upright area whose normals do.

    Ref: normals of a surface of revolution meet its axis; least squares, iterated with weights that leave out handles.
    """
    normals, areas = face_normals(points, faces)
    flat = normals[:, :2]
    length = np.linalg.norm(flat, axis=1)
    weight = areas * length
    keep = length > 0.1
    flat, weight = flat[keep] / length[keep, None], weight[keep]
    middle = points[faces[keep]].mean(axis=1)[:, :2]
    across = np.stack([-flat[:, 1], flat[:, 0]], axis=1)
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    if not len(flat):
        return (low + high) / 2, 0.0
    trust = np.ones(len(flat))
    center = (low + high) / 2
    for _ in range(ROUNDS):
        pull = (weight * trust)[:, None] * across
        matrix = np.array([[(pull[:, i] * across[:, j]).sum() for j in range(2)] for i in range(2)])
        right = (pull * (across * middle).sum(axis=1)[:, None]).sum(axis=0)
        determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] ** 2
        if determinant <= 1e-9 * (matrix[0, 0] + matrix[1, 1]) ** 2:
            return (low + high) / 2, 0.0
        center = np.array(
            [matrix[1, 1] * right[0] - matrix[0, 1] * right[1], matrix[0, 0] * right[1] - matrix[0, 1] * right[0]]
        ) / float(determinant)
        gap = center - middle
        miss = np.abs((gap * across).sum(axis=1)) / np.maximum(np.linalg.norm(gap, axis=1), 1e-12)
        trust = 1 / (1 + (miss / AXIS_MISS_SINE) ** 2) ** 2
    share = float(weight[miss < AXIS_MISS_SINE].sum() / weight.sum())
    return center.round(7), share


def wall_profile(solid: Solid, center: Floats) -> WallProfile:
    """Measure the radii at which matter begins and first ends around an axis through the (2,) center, metres."""
    box = solid.bounding_box()
    step = (box[5] - box[2]) / ROWS
    heights = box[2] + (np.arange(ROWS) + 0.5) * step
    rows = [_row(section_contours(solid, height), center) for height in heights]
    return WallProfile(center, heights, step, np.array([r[0] for r in rows]), np.array([r[1] for r in rows]))


def _row(polygons: list[Floats], center: Floats) -> tuple[Floats, Floats]:
    """(A,) where matter begins and where it first ends along each ray."""
    inner, outer = np.full(RAYS, np.nan), np.full(RAYS, np.nan)
    if not polygons:
        return inner, outer
    start = np.concatenate(polygons) - center
    end = np.concatenate([np.roll(p, -1, axis=0) for p in polygons]) - center
    # Half a step off the axes, where the corners of many meshes lie.
    angles = (np.arange(RAYS) + 0.5) * 2 * np.pi / RAYS
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    left = start[:, :1] * ray[:, 1] - start[:, 1:] * ray[:, 0]
    right = end[:, :1] * ray[:, 1] - end[:, 1:] * ray[:, 0]
    crosses = (left > 0) != (right > 0)
    share = left / np.where(crosses, left - right, 1.0)
    along = start @ ray.T + share * ((end - start) @ ray.T)
    crosses &= along > 0
    count = crosses.sum(axis=0)
    ordered = np.sort(np.where(crosses, along, np.inf), axis=0).round(9)
    first = ordered[0]
    second = ordered[1] if len(ordered) > 1 else np.full(RAYS, np.inf)
    within = count % 2 == 1
    inner = np.where(count == 0, np.nan, np.where(within, 0.0, first))
    outer = np.where(count == 0, np.nan, np.where(within, first, second))
    return inner, np.where(np.isinf(outer), np.nan, outer)


def radius_spread(radii: Floats) -> float:
    """Spread of the radii of a row: distance of their quartiles over the median; 1 where there are few."""
    known = radii[np.isfinite(radii)]
    if len(known) < RAYS // 2:
        return 1.0
    low, middle, high = np.percentile(known, [25, 50, 75])
    return float((high - low) / middle) if middle > 0 else 1.0


@dataclass(frozen=True)
class Slab:
    """Rows from `first` to before `last` that become one ring of `sectors` (1: one part that is not cut)."""

    first: int
    last: int
    sectors: int


@dataclass(frozen=True)
class SlabCosts:
    """Errors of merging the rows from i to before j into one slab: (H, H + 1) arrays, metres.

    `bend`: distance of the walls from their chords. `filled_height`: height of the opening that a hull would fill.
    `hollow_below`: height of the hollow below the floor that a hull would fill. `has_floor`: the axis is in the solid.
    `radius`: largest radius of the inner wall, times the sine of its steepness; 0 if there is no wall.
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
        sides = [radii[:, :: RAYS // 12].copy() for radii in (inner, -outer)]
    # Radii that are not known are interpolated between their neighbours.
    for column in (column for side in sides for column in side.T):
        known = np.flatnonzero(np.isfinite(column))
        if len(known):
            column[:] = np.interp(np.arange(count), known, column[known])
    is_below_floor = np.arange(count) < int(np.argmax(is_solid)) if is_solid.any() else np.zeros(count, dtype=bool)
    rise = np.hypot(profile.step, np.gradient(inner_radius)) if count > 1 else np.full(count, profile.step)
    felt_radius = inner_radius * profile.step / rise
    bends = np.zeros((len(sides), count, count + 1))
    filled_height, hollow_below, radius = np.zeros((3, count, count + 1))
    has_floor = np.zeros((count, count + 1), dtype=bool)
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


def median_radius(row: Floats) -> float:
    """Median of the finite radii; nan if there are no finite radii."""
    known = row[np.isfinite(row)]
    return float(np.median(known)) if len(known) else np.nan


def choose_slabs(
    costs: SlabCosts, chord: float, bend: float, sector_count: int | None, foot_height_m: float
) -> list[Slab] | None:
    """Choose slabs, bottom to top, with the fewest parts that keep the walls within the errors; None if no choice does.

    `chord`, `bend`: errors around the axis and along it, metres. `sector_count`: None for a round wall.
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
    return np.asarray(np.where(costs.bend <= bend, np.where(costs.has_floor, one_part, ring), np.inf))


def _bend(radii: Floats, step: float) -> float:
    """Distance of a wall of (H, A) radii from the chords between its lowest and highest points, metres."""
    if len(radii) < 3:
        return 0.0
    share = np.linspace(0, 1, len(radii))[:, None]
    gaps = (radii - radii[:1] * (1 - share) - radii[-1:] * share).max(axis=0)
    rise = step * max(len(radii) - 1, 1)
    gaps = gaps * (rise / np.hypot(rise, radii[-1] - radii[0]))  # across the chord
    known = np.sort(gaps[np.isfinite(gaps)])
    return float(known[(3 * len(known)) // 4]) if len(known) else 0.0


@dataclass(frozen=True)
class CutVessel:
    """An open vessel, cut: floors, each one part; nearly convex sectors of walls; handles and spouts; in words."""

    floors: tuple[Solid, ...]
    wall_parts: tuple[Solid, ...]
    handles: tuple[Solid, ...]
    message: str


def cut_vessel(
    solid: Solid, min_error_m: float, hollow_error_m: float, foot_height_m: float, max_parts: int
) -> CutVessel | None:
    """A vessel as a floor, rings of sectors and handles; None if no such cut stays within `max_parts` parts.

    `solid`: metres, z up, simplified. `min_error_m`: smallest error of a hull that is tried. `hollow_error_m`: error up
    to which a hollow below the floor stays hollow; with larger ones it may be filled. `foot_height_m`: largest height
    of that hollow. `max_parts`: of floor and walls.
    """
    center, round_share = upright_axis(*surface_of(solid))
    profile = wall_profile(solid, center)
    is_round = float(np.median([radius_spread(row) for row in profile.outer])) < ROUND_SPREAD
    costs = slab_costs(profile, is_round)
    for step in range(MAX_STEPS):
        error = min_error_m * ERROR_GROWTH**step
        fill_height_m = min(error, foot_height_m) if error <= hollow_error_m else foot_height_m
        plans = [
            _plan(profile, costs, error * chord_share, error * (2 - chord_share), is_round, fill_height_m)
            for chord_share in CHORD_ERROR_SHARES
        ]
        feasible = [plan for plan in plans if plan is not None and plan.count <= max_parts]
        if not feasible:
            continue
        plan = min(feasible, key=lambda p: p.count)
        body, handles = _without_handles(solid, profile, error / 2) if is_round else (solid, [])
        if plan.count <= max_parts - min(PARTS_PER_HANDLE * len(handles), max_parts // 3):
            if is_round:
                body = _widened(body, profile, SETBACK_SHARE * error)
            floors, wall_parts = _floors_and_sectors(body, profile, plan)
            message = f"{round_share:.0%} of the wall turns about one axis"
            if not is_round:
                floors, wall_parts = [], [*floors, *wall_parts]
                message = "walls that are not round"
            message = f"{message}: {plan.message}, {1000 * error:.2g} mm off"
            return CutVessel(tuple(floors), tuple(wall_parts), tuple(handles), message)
    return None


@dataclass(frozen=True)
class RingPlan:
    """Plan of a cut: the slabs, and the rays at which walls that are not round are cut (None for round ones)."""

    slabs: tuple[Slab, ...]
    cut_rays: tuple[int, ...] | None

    @property
    def count(self) -> int:
        """Number of parts."""
        return sum(slab.sectors for slab in self.slabs)

    @property
    def message(self) -> str:
        """The plan in words."""
        rings = sum(slab.sectors > 1 for slab in self.slabs)
        most = max(slab.sectors for slab in self.slabs)
        return f"{len(self.slabs) - rings} floors, {rings} rings of up to {most} sectors"


def _plan(
    profile: WallProfile, costs: SlabCosts, chord: float, bend: float, is_round: bool, foot_height_m: float
) -> RingPlan | None:
    cut_rays = None if is_round else tuple(_fewest_cut_rays(profile, chord))
    slabs = choose_slabs(costs, chord, bend, None if cut_rays is None else len(cut_rays), foot_height_m)
    return None if slabs is None else RingPlan(tuple(slabs), cut_rays)


def _without_handles(solid: Solid, walls: WallProfile, gap: float) -> tuple[Solid, list[Solid]]:
    """Body within its revolved outline, and the parts outside of it: handles, knobs, spouts."""
    radius = np.array(
        [float(np.nanpercentile(r, OUTLINE_PERCENTILE)) if np.isfinite(r).any() else np.nan for r in walls.outer]
    )
    is_known = np.isfinite(radius) & (np.isfinite(walls.outer).mean(axis=1) > OPEN_RAY_SHARE)
    if not is_known.any():
        return solid, []
    radius = np.interp(walls.heights, walls.heights[is_known], radius[is_known])
    # The largest radius of three neighbours keeps the outline outside of slopes.
    padded = np.pad(radius, 1, mode="edge")
    outline_radius = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:]) + gap
    bottom, above_top = walls.heights[0] - walls.step, walls.heights[-1] + walls.step
    top = float(walls.heights[is_known][-1] + 1.5 * walls.step)
    heights = np.concatenate([[bottom], walls.heights, [above_top]])
    outline_radius = np.concatenate([outline_radius[:1], outline_radius, outline_radius[-1:]])
    below = heights <= top
    profile = np.concatenate(
        [
            [[0.0, heights[below][0]]],
            np.stack([outline_radius[below], heights[below]], axis=1),
            [[outline_radius[below][-1], top], [0.0, top]],
        ]
    )
    least = MIN_PART_SHARE * float(solid.volume())
    handles = []
    for part in connected_parts(solid - _revolved(profile, walls), 10 * least):
        box = np.array(part.bounding_box())
        if float((box[3:] - box[:3]).max()) > 4 * gap:
            handles.append(part)
    if not handles:
        return solid, []
    body = solid
    for handle in handles:
        body = body - handle
    # Slivers that are left of a handle would make the hull of the wall reach out to them.
    return manifold3d.Manifold.compose(connected_parts(body, least)), handles


def _revolved(profile: Floats, walls: WallProfile) -> Solid:
    """Solid of revolution about the axis of walls, of an (N, 2) polygon of radius and height."""
    return revolve_profile(profile, RAYS).translate((float(walls.center[0]), float(walls.center[1]), 0.0))


def _fewest_cut_rays(profile: WallProfile, error: float) -> list[int]:
    """Fewest rays to cut a wall that is not round, so that every chord stays within the error of the inner wall."""
    has_opening = (profile.inner > 0).mean(axis=1) >= OPEN_RAY_SHARE
    rows = np.flatnonzero(has_opening)
    if not len(rows):
        return []
    picked = rows[np.linspace(0, len(rows) - 1, min(5, len(rows))).round().astype(int)]
    angles = (np.arange(RAYS) + 0.5) * 2 * np.pi / RAYS
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    radii = profile.inner[picked]
    radii = np.where(np.isfinite(radii) & (radii > 0), radii, np.nan)
    radii = np.where(np.isfinite(radii), radii, np.nanmedian(radii, axis=1, keepdims=True))
    points = radii[:, :, None] * ray
    reach = [_longest_chord(points, start, error) for start in range(RAYS)]
    best: list[int] = []
    for start in range(RAYS):
        cuts, ray_index = [start], start
        while (ray_index := ray_index + reach[ray_index % RAYS]) < start + RAYS:
            cuts.append(ray_index % RAYS)
        if not best or len(cuts) < len(best):
            best = cuts
    return sorted(best)


def _longest_chord(points: Floats, start: int, error: float) -> int:
    """Most rays that a chord from ray `start` may span with the inner wall nowhere farther from it than `error`."""
    farthest = 1
    for count in range(2, RAYS // 4 + 1):
        index = (start + np.arange(count + 1)) % RAYS
        stretch = points[:, index]
        chord = stretch[:, -1] - stretch[:, 0]
        outward = np.stack([chord[:, 1], -chord[:, 0]], axis=1)
        outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
        excess = np.einsum("rki,ri->rk", stretch - stretch[:, :1], outward)
        if float(excess.max().round(7)) > error:
            break
        farthest = count
    return farthest


def _widened(solid: Solid, walls: WallProfile, gap: float) -> Solid:
    """The body with its inner wall set back by a gap, which centres the error of the chords on that wall."""
    open_rows = np.flatnonzero((walls.inner > 0).mean(axis=1) >= OPEN_RAY_SHARE)
    if not len(open_rows):
        return solid
    inner = np.array([median_radius(walls.inner[k]) for k in open_rows])
    outer = np.array([median_radius(walls.outer[k]) for k in open_rows])
    # Only the uninterrupted open rows at the top, from the floor to the rim.
    start = len(open_rows) - 1
    while start > 0 and open_rows[start - 1] == open_rows[start] - 1:
        start -= 1
    inner, outer, open_rows = inner[start:], outer[start:], open_rows[start:]
    if len(open_rows) < 2 or not np.isfinite(inner).all() or not np.isfinite(outer).all():
        return solid
    radius = inner + np.minimum(gap, MAX_SETBACK_SHARE * (outer - inner))
    heights = walls.heights[open_rows]
    # It starts a little within the floor, so that no film of the floor is left in the rings above.
    bottom, above_top = heights[0] - 0.6 * walls.step, heights[-1] + walls.step
    profile = np.concatenate(
        [
            [[0.0, bottom], [radius[0], bottom]],
            np.stack([radius, heights], axis=1),
            [[radius[-1], above_top], [0.0, above_top]],
        ]
    )
    widened = solid - _revolved(profile, walls)
    return widened if widened.volume() > 0 else solid


def _floors_and_sectors(solid: Solid, profile: WallProfile, plan: RingPlan) -> tuple[list[Solid], list[Solid]]:
    up = np.array([0.0, 0.0, 1.0])
    floors: list[Solid] = []
    wall_parts: list[Solid] = []
    rest = solid
    for slab in plan.slabs:
        layer = rest
        if slab is not plan.slabs[-1]:
            rest, layer = split_by_plane(rest, up, float(profile.heights[slab.last - 1] + profile.step / 2))
        if slab.sectors == 1:
            floors.append(layer)
        elif plan.cut_rays is None:
            wall_parts += _wedges(layer, profile.center, np.arange(slab.sectors) * 2 * np.pi / slab.sectors)
        else:
            wall_parts += _wedges(layer, profile.center, (np.array(plan.cut_rays) + 0.5) * 2 * np.pi / RAYS)
    min_volume_m3 = MIN_PART_SHARE / 10 * float(solid.volume())
    floors, wall_parts = ([s for s in found if s.volume() > min_volume_m3] for found in (floors, wall_parts))
    return floors, wall_parts


def _wedges(layer: Solid, center: Floats, edges: Floats) -> list[Solid]:
    """The layer cut by half planes at (N,) ascending angles, radians, at most half a turn apart, about the axis."""
    out = []
    for k in range(len(edges)):
        begin, end = edges[k], edges[(k + 1) % len(edges)]
        left = np.array([-np.sin(begin), np.cos(begin), 0.0])
        right = np.array([np.sin(end), -np.cos(end), 0.0])
        wedge = split_by_plane(layer, left, float(left[:2] @ center))[0]
        out.append(split_by_plane(wedge, right, float(right[:2] @ center))[0])
    return out
