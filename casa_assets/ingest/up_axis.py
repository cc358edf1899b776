"""List candidate up directions and score the resting poses: outline, capacity, area of the foot, balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, grey_closing
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import solid_moments
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill, RestingPose

# Samples on a surface.
SAMPLES = 16000
# asset_from_file rotations by the file axis that becomes z. The first two are the usual conversions,
# so that a glTF front (+z) becomes the asset front (-y).
UP_ROTATIONS: dict[str, Floats] = {
    "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float64),
    "z": np.eye(3),
    "x": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=np.float64),
    "minus_y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=np.float64),
    "minus_z": np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]], dtype=np.float64),
    "minus_x": np.array([[0, 1, 0], [0, 0, -1], [-1, 0, 0]], dtype=np.float64),
}
# Prior of each up axis by what the file states; estimates. The rest is shared by the other axes and directions. glTF
# defines y as up, and most exporters obey; OBJ, PLY and STL leave it open. Upside down comes from a wrong sign in a
# converter. No prior is so strong that the shape could not outweigh it.
UP_PRIOR: dict[str, dict[str, float]] = {
    "declared_y": {"y": 0.88, "z": 0.043, "minus_y": 0.03},
    "declared_z": {"z": 0.88, "y": 0.04, "minus_z": 0.03},
    # COLLADA's default is y up, which exporters leave as it is; others write the tag without turning the mesh.
    "dae_y": {"y": 0.69, "z": 0.16, "minus_y": 0.05},
    "dae_z": {"z": 0.72, "y": 0.13, "minus_z": 0.05},
    "declared_x": {"x": 0.86, "y": 0.035, "z": 0.035, "minus_x": 0.03},
    "obj": {"y": 0.44, "z": 0.40, "minus_y": 0.03, "minus_z": 0.03},
    "stl": {"z": 0.73, "y": 0.12, "minus_z": 0.05},
    "ply": {"z": 0.57, "y": 0.27, "minus_z": 0.04, "minus_y": 0.03},
    "generated": {"y": 0.70, "z": 0.15, "minus_y": 0.05},
    "unknown": {"y": 0.44, "z": 0.39, "minus_y": 0.03, "minus_z": 0.03},
}
# Directions closer than this count as equal; a choice.
SAME_DIRECTION_RAD = np.radians(6.0)
# Sides of the hull that are tried as feet, the largest first; a choice.
MAX_FEET = 6
# Prior of a direction that is no axis, relative to that of an axis that is not listed: modellers work along axes, while
# scans lie in any direction. An estimate.
OFF_AXIS_PRIOR = 0.4
# Modellers put the origin on the floor under a thing: of 109 meshes of ./dev bench ingest_pose 46 have it at
# the height of their lowest point, to this share of the longest side; along other axes, or at the top, hardly any have.
ORIGIN_SLACK, NATS_ON_ORIGIN = 0.01, 4.0
# A mesh that lies around its origin does so along most axes, which way up it may be.
MIDDLE_SLACK, NATS_AROUND_ORIGIN = 0.02, -0.7
# Cells along the longest side of the height map that is filled with rain; a choice.
CELLS = 36
# What the score is divided by, so that a way up is right as often as the score says. For things that lie, that are
# full or hollow they were fitted on the meshes of ./dev bench ingest_pose, where scores overstate. A vessel
# that holds nothing any way up has lost its best evidence.
DOUBTS_LIES, DOUBTS_VESSEL, DOUBTS_CLOSED_VESSEL, DOUBTS_OTHER = 1.5, 1.2, 2.0, 1.2
DOUBTS = {MatterFill.FILLED: 2.0, MatterFill.HOLLOW: 1.5}
# Log likelihood of a pose of something that stands, in which it would fall or has a foot of less than this share of
# its outline: of 74 such meshes of ./dev bench ingest_pose none lies so in its file, a third of wrong ways up do.
FALLING_NATS, LEAST_FOOT = -4.0, 0.05
# A vessel whose share of room, as `pose_score` counts it, is below this is a closed one; a choice.
CLOSED_SHARE = 0.5
# What room and foot say of a thing that nobody could name; fitted on the meshes of ./dev bench ingest_pose as
# if they had no names: 90 of 98 are upright then.
ROOM_NATS, FOOT_NATS = 1.5, 1.4
# Points closer to the ground than this share of the height, or of the longest side, belong to the foot; choices.
FOOT_SHARE, MIN_FOOT_SHARE = 0.025, 0.01


@dataclass(frozen=True)
class SurfaceSample:
    """Samples and hull of a surface in file axes, scaled to a longest side of 1; origin at the hull's centre of mass.

    `samples`: (N, 3) points spread evenly over the surface. `hull_points`, `hull_faces`: (M, 3) and (F, 3), wound so
    that the normals point outward. `hull_volume`: in the scaled units, cubed.
    """

    samples: Floats
    hull_points: Floats
    hull_faces: Ints
    hull_volume: float


def sample_surface(points: Floats, faces: Ints) -> SurfaceSample:
    """Sample a surface of finite points and compute its hull. Raises DegenerateShape: the points span no volume."""
    longest = float(np.ptp(points, axis=0).max())
    if not np.isfinite(longest) or longest <= 0:
        raise DegenerateShape("the points have no extent")
    unit_points = (points - points.mean(axis=0)) / longest
    hull_points, hull_faces = convex_hull(unit_points)
    volume, center, _ = solid_moments(hull_points, hull_faces)
    samples = samples_with_faces(unit_points, faces, SAMPLES)[0]
    # Volumes are divided by that of the hull, so it is kept above zero.
    return SurfaceSample(samples - center, hull_points - center, hull_faces, max(volume, 1e-9))


def smallest_rectangle(points: Floats) -> tuple[float, float, float]:
    """Smallest rectangle around (N, 2) points: angle of its long side (0 <= radians < pi), long side, short side."""
    try:
        outline = points[ConvexHull(points).vertices]
    except QhullError:
        outline = points
    edges = np.roll(outline, -1, axis=0) - outline
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 6))
    along = outline @ np.stack([np.cos(angles), np.sin(angles)])
    across = outline @ np.stack([-np.sin(angles), np.cos(angles)])
    long, wide = np.ptp(along, axis=0), np.ptp(across, axis=0)
    area = long * wide
    best = int(np.flatnonzero(area <= area.min() * (1 + 1e-6))[0])
    angle, a, b = float(angles[best]), float(long[best]), float(wide[best])
    if b > a * (1 + 1e-6):
        return (angle + np.pi / 2) % np.pi, b, a
    return angle % np.pi, a, b


def origin_evidence(points: Floats, names: list[str]) -> Floats:
    """Log likelihood of each named candidate by where the file's origin lies among the (N, 3) points in its axes."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    longest = float((upper - lower).max())
    out = np.zeros(len(names))
    for row, name in enumerate(names):
        if name not in UP_ROTATIONS:
            continue
        up = UP_ROTATIONS[name][2]
        bottom, top = sorted((float(lower @ up), float(upper @ up)))
        if abs(bottom) <= ORIGIN_SLACK * longest:
            out[row] = NATS_ON_ORIGIN
        elif abs(bottom + top) <= MIDDLE_SLACK * (top - bottom):
            out[row] = NATS_AROUND_ORIGIN
    return out


def priors(key: str, names: list[str]) -> Floats:
    """Log prior of each candidate, by its name."""
    known = UP_PRIOR.get(key, UP_PRIOR["unknown"])
    other = (1 - sum(known.values())) / (len(UP_ROTATIONS) - len(known))
    shares = [known.get(n, other if n in UP_ROTATIONS else other * OFF_AXIS_PRIOR) for n in names]
    return np.asarray(np.log(np.array(shares)))


def candidates(cloud: SurfaceSample) -> list[tuple[str, Floats]]:
    """Names and asset_from_file rotations; the six axes first, in the order of UP_ROTATIONS."""
    out = list(UP_ROTATIONS.items())
    directions = [rotation[2] for rotation in UP_ROTATIONS.values()]
    further = [("foot", up) for up in _hull_sides(cloud)]
    _, axes = np.linalg.eigh(np.cov(cloud.samples.T))
    further += [("along", sign * axis) for axis in axes.T for sign in (1.0, -1.0)]
    for prefix, up in further:
        if all(np.arccos(np.clip(up @ other, -1, 1)) > SAME_DIRECTION_RAD for other in directions):
            directions.append(up)
            out.append((f"{prefix}_{sum(n.startswith(prefix) for n, _ in out)}", rotation_to_z(up)))
    return out


def _hull_sides(cloud: SurfaceSample) -> list[Floats]:
    """Up directions in which the hull rests on one of its larger sides, or has it on top, largest side first.

    Both, because the largest side of a bowl's hull is its rim.
    """
    corners = cloud.hull_points[cloud.hull_faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    keep = area > 1e-12
    normals, area = cross[keep] / area[keep, None], area[keep]
    sides: list[tuple[float, Floats]] = []
    is_left = np.ones(len(area), dtype=bool)
    for first in np.argsort(-area, kind="stable"):
        if not is_left[first]:
            continue
        is_same_side = is_left & (normals @ normals[first] > np.cos(SAME_DIRECTION_RAD / 2))
        is_left &= ~is_same_side
        mean = (normals[is_same_side] * area[is_same_side, None]).sum(axis=0)
        sides.append((float(area[is_same_side].sum()), -mean / np.linalg.norm(mean)))
        if len(sides) >= 4 * MAX_FEET:
            break
    sides.sort(key=lambda side: -side[0])
    return [way for _, up in sides[:MAX_FEET] for way in (up, -up)]


def rotation_to_z(up: Floats) -> Floats:
    """(3, 3) rotation that brings a unit direction to z by the shortest way from the axis of the file next to it."""
    name = max(UP_ROTATIONS, key=lambda n: float(UP_ROTATIONS[n][2] @ up))
    base = UP_ROTATIONS[name]
    a, b = base @ up, np.array([0.0, 0.0, 1.0])
    axis, cosine = np.cross(a, b), float(a @ b)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.asarray((np.eye(3) + cross + cross @ cross / (1 + cosine)) @ base)


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
    """Measure one resting pose, `rotation` is asset_from_file; the rain volumes take the longest."""
    samples, hull_points = cloud.samples @ rotation.T, cloud.hull_points @ rotation.T
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
        lid = 1.5 * neck + 4.0 * pose.center_below_middle + 0.5 * foot_over_crown
        return total + 6.0 * capacity_score + 1.3 * foot_score + closed_share * lid
    middle = pose.center_below_middle
    if category.build is MatterFill.FILLED:  # cans and bottles have a dent below
        dent = float(np.clip((pose.rain_volume_inverted - pose.rain_volume) / 0.02, -1, 1))
        return total + 3.5 * taper + 6.0 * middle + 0.8 * foot_over_crown + 1.0 * foot_score + 1.0 * dent
    if category.build is MatterFill.HOLLOW:
        return total + 1.2 * taper + 4.0 * middle + 0.5 * foot_over_crown + 1.0 * foot_score + 0.8 * capacity_score
    return total + 0.5 * taper + 4.0 * middle + 1.0 * foot_over_crown + 1.0 * foot_score + 1.0 * capacity_score


def balance_score(pose: Stance, category: Category) -> float:
    """Log likelihood that an upright object was modelled in a pose in which it would fall; not divided by `doubts`."""
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
