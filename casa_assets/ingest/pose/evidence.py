"""Score resting poses by outline, capacity, area of the foot and balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, grey_closing
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.typing import Floats
from casa_assets.ingest.pose.cloud import SurfaceSample, plan_axes
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# Cells along the longest side of the map of heights that rain falls on.
CELLS = 36
# What is so close to the ground, as a share of the height, or at least of the longest side, is foot.
FOOT_SHARE, MIN_FOOT_SHARE = 0.025, 0.01


@dataclass(frozen=True)
class Stance:
    """Measures of a resting pose; lengths relative to the longest side.

    Attributes:
        extents: sides of the smallest rectangle around its plan, and height.
        holds, hides: room that rain would fill as it rests, and upside down, over the volume of the hull.
        foot, crown: area of what touches the ground, and would touch it upside down, over that of the outline.
        stable: the centre of the hull is above the foot. sink: 0.5 - its height over the whole height.
        taper: log of the radius of the lowest quarter over that of the highest.
    """

    extents: Floats
    holds: float
    hides: float
    foot: float
    crown: float
    stable: bool
    sink: float
    taper: float


def stance(cloud: SurfaceSample, turn: Floats, rain: bool) -> Stance:
    """Measure one resting pose.

    Args:
        turn: asset_from_file rotation. rain: `holds` and `hides` are wanted, which take the longest.
    """
    samples, shell = cloud.turned(turn)
    low, high = shell.min(axis=0), shell.max(axis=0)
    height = max(float(high[2] - low[2]), 1e-9)
    _, long, wide = plan_axes(shell[:, :2])
    level = (samples[:, 2] - low[2]) / height
    outline = _outline(shell[:, :2])
    points = np.concatenate([shell, samples[::4]])
    foot = _area(points, low[2], height)
    crown = _area(points * [1, 1, -1], -high[2], height)
    return Stance(
        extents=np.array([long, wide, height]),
        holds=rain_volume(samples) / cloud.volume if rain else 0.0,
        hides=rain_volume(samples * [1, 1, -1]) / cloud.volume if rain else 0.0,
        foot=foot[0] / outline,
        crown=crown[0] / outline,
        stable=foot[1],
        sink=0.5 + float(low[2]) / height,
        taper=float(np.log(_radius(samples[level < 0.25]) / _radius(samples[level > 0.75]))),
    )


def _outline(points: Floats) -> float:
    try:
        return max(float(ConvexHull(points).volume), 1e-9)
    except QhullError:
        return 1e-9


def _radius(points: Floats) -> float:
    """Half width of what is left without the outermost tenth on each side, geometric mean of both directions."""
    if len(points) < 8:
        return 0.02
    low, high = np.quantile(points[:, :2], [0.1, 0.9], axis=0)
    x, y = np.maximum(high - low, 0.02) / 2
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
    low = points[:, :2].min(axis=0)
    cell = float(np.ptp(points[:, :2], axis=0).max()) / CELLS
    at = np.floor((points[:, :2] - low) / max(cell, 1e-12)).astype(int) + 2
    shape = at.max(axis=0) + 3
    ground = float(points[:, 2].min())
    top = np.full(shape, -np.inf)
    np.maximum.at(top, (at[:, 0], at[:, 1]), points[:, 2])
    hit = np.isfinite(top)
    open_ = ~binary_closing(hit, np.ones((3, 3), dtype=bool))
    # Where few samples fall on a wall or a lid seen edge on, some cells see past it: pits and gaps of one or two cells
    # are closed; what is open to the ground stays so.
    top[~hit] = ground
    top = np.where(open_, ground, grey_closing(top, size=(3, 3)))
    level = np.where(open_, ground, float(points[:, 2].max()))
    for _ in range(4 * CELLS):
        around = np.full_like(level, np.inf)
        around[1:] = np.minimum(around[1:], level[:-1])
        around[:-1] = np.minimum(around[:-1], level[1:])
        around[:, 1:] = np.minimum(around[:, 1:], level[:, :-1])
        around[:, :-1] = np.minimum(around[:, :-1], level[:, 1:])
        fresh = np.where(open_, ground, np.maximum(top, np.minimum(level, around)))
        if np.array_equal(fresh, level):
            break
        level = fresh
    return float((level - top).sum()) * cell * cell


def pose_score(one: Stance, category: Category) -> float:
    """Log likelihood of resting this way for a thing of the category, up to a constant."""
    if category.upright is RestingPose.ANY or category.id == "object":
        return 0.0 if one.stable else -0.5
    total = outline_score(one.extents, category)
    above, below = _share(one.holds), _share(one.hides)
    room = above - below
    ends = float(np.clip(np.log((one.foot + 0.03) / (one.crown + 0.03)), -1.5, 1.5))
    # Nothing rests on a hundredth of its outline, however it lies along the axes of its file.
    foot = float(np.log(np.clip(one.foot, 0.01, 1.0)))
    taper = float(np.clip(one.taper, -1.2, 1.2))
    if category.upright is RestingPose.LIES:  # bent and pointed things rest on little, and tip a bit
        total -= 0.0 if one.stable else 0.7
        room *= 5.0 if category.build is MatterFill.VESSEL else 3.0
        return total + room + 0.8 * ends + 3.0 * one.sink + 1.3 * foot
    total -= 0.0 if one.stable else 2.0
    if category.build is MatterFill.VESSEL:  # where there is no room, a lid is on it
        shut = 1 - max(above, below)
        neck = min(max(taper, -0.6), 0.6)
        return total + 6.0 * room + 1.3 * foot + shut * (1.5 * neck + 4.0 * one.sink + 0.5 * ends)
    if category.build is MatterFill.FILLED:  # cans and bottles have a dent below
        dent = float(np.clip((one.hides - one.holds) / 0.02, -1, 1))
        return total + 3.5 * taper + 6.0 * one.sink + 0.8 * ends + 1.0 * foot + 1.0 * dent
    if category.build is MatterFill.HOLLOW:
        return total + 1.2 * taper + 4.0 * one.sink + 0.5 * ends + 1.0 * foot + 0.8 * room
    return total + 0.5 * taper + 4.0 * one.sink + 1.0 * ends + 1.0 * foot + 1.0 * room


def _share(room: float) -> float:
    """Room over the hull as evidence, 0..1: the first tenth says most."""
    return float(np.sqrt(min(room / 0.5, 1.0)))


def outline_score(extents: Floats, category: Category) -> float:
    """Score of three extents, at any size and heading, against the usual ones: 0 at best, -6 at worst.

    What lies may be flatter than usual (a slice of a loaf) and should not be taller than it is wide.
    """
    usual = np.array([side.typical for side in category.extents])
    spread = np.array([np.log(side.high / side.low) for side in category.extents]) / 4
    have = np.maximum(np.array([*sorted(extents[:2]), extents[2]]), 0.004)
    order = np.argsort(usual[:2], kind="stable")
    want, wide = np.array([*usual[order], usual[2]]), np.array([*spread[order], spread[2]])
    sigma = np.clip(wide, 0.2, 0.4)
    lies = category.upright is RestingPose.LIES
    miss = np.log(have / want)
    weight = 1 / sigma**2 * np.array([1, 1, 0 if lies else 1])
    miss = miss - (weight * miss).sum() / weight.sum()
    if lies:
        miss[2] = max(miss[2], 0.0) / 2
    fit = -0.5 * float((miss**2 / sigma**2).sum())
    over = 4.0 * max(0.0, float(np.log(have[2] / have[0]))) if lies else 0.0
    return max(-6.0, fit - over)
