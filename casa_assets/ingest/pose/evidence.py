"""Score resting poses by outline, capacity, area of the foot and balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, grey_closing
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.typing import Floats
from casa_assets.ingest.pose.surface_sample import SurfaceSample, smallest_rectangle
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill, RestingPose

# Cells along the longest side of the height map that is filled with rain; a choice.
CELLS = 36
# What the score is divided by, so that a way up is right as often as it is told to be. For things that lie, that are
# full or hollow they were fitted on the meshes of ./dev bench ingest_pose, where scores overstate. A vessel
# that holds nothing any way up has lost its best evidence.
DOUBTS_LIES, DOUBTS_VESSEL, DOUBTS_CLOSED_VESSEL, DOUBTS_OTHER = 1.5, 1.2, 2.0, 1.2
DOUBTS = {MatterFill.FILLED: 2.0, MatterFill.HOLLOW: 1.5}
# Log likelihood of a pose of something that stands, in which it would fall or has a foot of less than this share of
# its outline: of 74 such meshes of ./dev bench ingest_pose none lies so in its file, while wrong ways up do in
# a third.
FALLING_NATS, LEAST_FOOT = -4.0, 0.05
# A vessel whose share of room, as `pose_score` counts it, is below this is a closed one; a choice.
CLOSED_SHARE = 0.5
# What room and foot say of a thing that nobody could name; fitted on the meshes of ./dev bench ingest_pose as
# if they had no names: 90 of 98 are upright then.
ROOM_NATS, FOOT_NATS = 1.5, 1.4
# Points closer to the ground than this share of the height, or of the longest side, belong to the foot; choices.
FOOT_SHARE, MIN_FOOT_SHARE = 0.025, 0.01


@dataclass(frozen=True)
class Stance:
    """Measures of a resting pose; lengths relative to the longest side.

    Attributes:
        extents: sides of the smallest rectangle around the outline in plan, and height.
        rain_volume, rain_volume_inverted: volume that rain would fill, upright and upside down, over that of the hull.
        foot_area, crown_area: area that touches the ground, upright and upside down, over that of the outline.
        is_stable: the centre of mass of the hull is above the foot.
        center_below_middle: 0.5 - height of that centre over the whole height.
        taper: log of the radius of the lowest quarter over that of the highest.
    """

    extents: Floats
    rain_volume: float
    rain_volume_inverted: float
    foot_area: float
    crown_area: float
    is_stable: bool
    center_below_middle: float
    taper: float


def stance(cloud: SurfaceSample, rotation: Floats, with_rain: bool) -> Stance:
    """Measure one resting pose.

    Args:
        rotation: asset_from_file. with_rain: measure the rain volumes too, which takes the longest.
    """
    samples, hull_points = cloud.rotated(rotation)
    lower, upper = hull_points.min(axis=0), hull_points.max(axis=0)
    height = max(float(upper[2] - lower[2]), 1e-9)
    _, long, wide = smallest_rectangle(hull_points[:, :2])
    level = (samples[:, 2] - lower[2]) / height
    outline_area = _outline(hull_points[:, :2])
    points = np.concatenate([hull_points, samples[::4]])
    foot_area = _area(points, lower[2], height)
    crown_area = _area(points * [1, 1, -1], -upper[2], height)
    return Stance(
        extents=np.array([long, wide, height]),
        rain_volume=rain_volume(samples) / cloud.hull_volume if with_rain else 0.0,
        rain_volume_inverted=rain_volume(samples * [1, 1, -1]) / cloud.hull_volume if with_rain else 0.0,
        foot_area=foot_area[0] / outline_area,
        crown_area=crown_area[0] / outline_area,
        is_stable=foot_area[1],
        center_below_middle=0.5 + float(lower[2]) / height,
        taper=float(np.log(_radius(samples[level < 0.25]) / _radius(samples[level > 0.75]))),
    )


def _outline(points: Floats) -> float:
    try:
        return max(float(ConvexHull(points).volume), 1e-9)
    except QhullError:
        return 1e-9


def _radius(points: Floats) -> float:
    """Half the width between the outer tenths, as a geometric mean over both directions."""
    if len(points) < 8:
        return 0.02
    lower, upper = np.quantile(points[:, :2], [0.1, 0.9], axis=0)
    x, y = np.maximum(upper - lower, 0.02) / 2
    return float(np.sqrt(x * y))


def _area(points: Floats, ground: float, height: float) -> tuple[float, bool]:
    """Area of the outline of what is close to the ground, and whether it is below the origin."""
    near = points[points[:, 2] < ground + max(FOOT_SHARE * height, MIN_FOOT_SHARE)][:, :2]
    try:
        hull = ConvexHull(near)
    except (QhullError, ValueError):
        return 0.0, bool(len(near) and np.linalg.norm(near, axis=1).min() < 0.02)
    slack = 0.02
    return float(hull.volume), bool((hull.equations[:, 2] < slack).all())


def rain_volume(points: Floats) -> float:
    """Volume that rain falling on (N, 3) points of a surface would leave standing, z up; ignores overhangs.

    Ref: filling of pits in maps of heights, Planchon and Darboux 2001.
    """
    lower = points[:, :2].min(axis=0)
    cell = float(np.ptp(points[:, :2], axis=0).max()) / CELLS
    cell_index = np.floor((points[:, :2] - lower) / max(cell, 1e-12)).astype(int) + 2
    shape = cell_index.max(axis=0) + 3
    ground = float(points[:, 2].min())
    top = np.full(shape, -np.inf)
    np.maximum.at(top, (cell_index[:, 0], cell_index[:, 1]), points[:, 2])
    is_hit = np.isfinite(top)
    is_open = ~binary_closing(is_hit, np.ones((3, 3), dtype=bool))
    # Few samples fall on steep walls, so pits and gaps of one or two cells are closed; wider gaps stay open.
    top[~is_hit] = ground
    top = np.where(is_open, ground, grey_closing(top, size=(3, 3)))
    level = np.where(is_open, ground, float(points[:, 2].max()))
    for _ in range(4 * CELLS):
        lowest_neighbour = np.full_like(level, np.inf)
        lowest_neighbour[1:] = np.minimum(lowest_neighbour[1:], level[:-1])
        lowest_neighbour[:-1] = np.minimum(lowest_neighbour[:-1], level[1:])
        lowest_neighbour[:, 1:] = np.minimum(lowest_neighbour[:, 1:], level[:, :-1])
        lowest_neighbour[:, :-1] = np.minimum(lowest_neighbour[:, :-1], level[:, 1:])
        new_level = np.where(is_open, ground, np.maximum(top, np.minimum(level, lowest_neighbour)))
        if np.array_equal(new_level, level):
            break
        level = new_level
    return float((level - top).sum()) * cell * cell


def pose_score(pose: Stance, category: Category) -> float:
    """Log likelihood of a resting pose for the category, up to a constant; the weights are choices."""
    upright_share, inverted_share = _share(pose.rain_volume), _share(pose.rain_volume_inverted)
    capacity_score = upright_share - inverted_share
    if category.id == FALLBACK:
        return ROOM_NATS * capacity_score + FOOT_NATS * float(np.log(np.clip(pose.foot_area, 0.01, 1.0)))
    if category.upright is RestingPose.ANY:
        return 0.0 if pose.is_stable else -0.5
    total = outline_score(pose.extents, category)
    foot_over_crown = float(np.clip(np.log((pose.foot_area + 0.03) / (pose.crown_area + 0.03)), -1.5, 1.5))
    foot_score = float(np.log(np.clip(pose.foot_area, 0.01, 1.0)))
    taper = float(np.clip(pose.taper, -1.2, 1.2))
    if category.upright is RestingPose.LIES:  # bent and pointed objects may tip a little until they rest
        total -= 0.0 if pose.is_stable else 0.7
        capacity_score *= 5.0 if category.build is MatterFill.VESSEL else 3.0
        return total + capacity_score + 0.8 * foot_over_crown + 3.0 * pose.center_below_middle + 1.3 * foot_score
    total -= 0.0 if pose.is_stable else 2.0
    if category.build is MatterFill.VESSEL:  # one without an opening has its lid on
        closed_share = 1 - max(upright_share, inverted_share)
        neck = min(max(taper, -0.6), 0.6)
        return (
            total
            + 6.0 * capacity_score
            + 1.3 * foot_score
            + closed_share * (1.5 * neck + 4.0 * pose.center_below_middle + 0.5 * foot_over_crown)
        )
    if category.build is MatterFill.FILLED:  # cans and bottles have a dent below
        dent = float(np.clip((pose.rain_volume_inverted - pose.rain_volume) / 0.02, -1, 1))
        return (
            total + 3.5 * taper + 6.0 * pose.center_below_middle + 0.8 * foot_over_crown + 1.0 * foot_score + 1.0 * dent
        )
    if category.build is MatterFill.HOLLOW:
        return (
            total
            + 1.2 * taper
            + 4.0 * pose.center_below_middle
            + 0.5 * foot_over_crown
            + 1.0 * foot_score
            + 0.8 * capacity_score
        )
    return (
        total
        + 0.5 * taper
        + 4.0 * pose.center_below_middle
        + 1.0 * foot_over_crown
        + 1.0 * foot_score
        + 1.0 * capacity_score
    )


def balance_score(pose: Stance, category: Category) -> float:
    """Log likelihood that an object that rests upright was modelled in a pose in which it would fall.

    It is not divided by `doubts`.
    """
    stands = category.upright is RestingPose.STANDS and category.id != FALLBACK
    return FALLING_NATS if stands and (not pose.is_stable or pose.foot_area < LEAST_FOOT) else 0.0


def doubts(stances: Sequence[Stance], category: Category) -> float:
    """The divisor of `pose_score` for these poses of one object, before it is converted to a probability."""
    if category.id == FALLBACK:
        return 1.0
    if category.upright is RestingPose.LIES and category.build is not MatterFill.VESSEL:
        return DOUBTS_LIES
    if category.build is MatterFill.VESSEL:
        most = max(max(pose.rain_volume, pose.rain_volume_inverted) for pose in stances)
        is_closed = category.upright is not RestingPose.LIES and _share(most) < CLOSED_SHARE
        return DOUBTS_CLOSED_VESSEL if is_closed else DOUBTS_VESSEL
    return DOUBTS.get(category.build, DOUBTS_OTHER)


def _share(room: float) -> float:
    """Evidence, 0..1, of a rain volume: half of the hull is the most, and small volumes count most."""
    return float(np.sqrt(min(room / 0.5, 1.0)))


def outline_score(extents: Floats, category: Category) -> float:
    """Score of the proportions of a mesh against the usual ones: 0 at best, -6 at worst.

    Objects that lie may be flatter than usual (a slice of a loaf) and should not be taller than wide.
    """
    usual = np.array([side.typical for side in category.extents])
    spread = np.array([np.log(side.high / side.low) for side in category.extents]) / 4
    mesh_sides = np.maximum(np.array([*sorted(extents[:2]), extents[2]]), 0.004)
    order = np.argsort(usual[:2], kind="stable")
    usual_sides, usual_spread = np.array([*usual[order], usual[2]]), np.array([*spread[order], spread[2]])
    sigma = np.clip(usual_spread, 0.2, 0.4)
    is_lying = category.upright is RestingPose.LIES
    log_error = np.log(mesh_sides / usual_sides)
    weight = 1 / sigma**2 * np.array([1, 1, 0 if is_lying else 1])
    log_error = log_error - (weight * log_error).sum() / weight.sum()
    if is_lying:
        log_error[2] = max(log_error[2], 0.0) / 2
    fit = -0.5 * float((log_error**2 / sigma**2).sum())
    too_tall = 4.0 * max(0.0, float(np.log(mesh_sides[2] / mesh_sides[0]))) if is_lying else 0.0
    return max(-6.0, fit - too_tall)
