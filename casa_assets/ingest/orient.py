"""Stage `orient`: which way is up and to the front; the mesh is turned and put on the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull

from casa_assets.core.numeric import Floats
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest import up_axis
from casa_assets.ingest.draft import Draft
from casa_assets.model.registry.category import FALLBACK, Category, FrontRule, MatterFill, RestingPose
from casa_assets.model.source import NO_OVERRIDE, UserOverride

# Smallest confidence in a pose if the category rests in any pose.
MIN_CONFIDENCE_ANY_POSE = 0.9
# How many times more probable than the axis that the file states another way up has to be, beyond its prior; a choice.
OVERRULE_ODDS = 1.5
# Cosine of the angle (15 degrees) up to which two ways up are one; which of them is taken is the file's word, unless
# another one is this many times as probable by itself; choices.
SAME_COSINE, TILT_ODDS = 0.966, 3.0
# Candidates whose score without rain is so far behind the best one are dropped, nats; rain decides for vessels.
HOPELESS_NATS, HOPELESS_NATS_VESSEL = 8.0, 16.0
# Smaller turns are not made, so that meshes which lie along their axes stay as they are. A choice, as all numbers here.
MIN_TURN_RAD = np.radians(3.0)
# Distance from the axis, over the radius of the body, from which on a point belongs to a handle.
HANDLE_REACH, SECTORS = 1.15, 36
# An outline that fills this share of its bounding rectangle is rectangular.
RECTANGLE_FILL = 0.87
# Smallest ratio between the sides of the box around something round.
ROUND_SIDE_RATIO = 0.85
# The direction of a handle is that of a side of the outline if they differ by less than this.
SNAP_ANGLE_RAD = np.radians(20.0)
# Prior of the side that the face is on: -y, +x, +y, -x. glTF defines +z as the front, our -y; others nothing.
STATED_FACE = (0.80, 0.06, 0.08, 0.06)
SILENT_FACE = (0.46, 0.18, 0.18, 0.18)


def orient(
    draft: Draft,
    category: Category,
    generated: bool = False,
    override: UserOverride = NO_OVERRIDE,
    failed_ups: Sequence[str] = (),
) -> Draft:
    """Turn the parts, in file axes, so that z is up and the front points where the category has it.

    `generated`: from a text-to-3D generator; these write y up whatever the format. `override`: `up` and `turn_deg`
    count here. `failed_ups`: ways up, named as in guesses, in which the object was built and fell over or did not fit.
    """
    try:
        cloud = up_axis.sample_surface(draft.surface.vertices, draft.surface.faces)
    except DegenerateShape as error:
        raise Rejected("MSH002", "all faces lie in one plane or on one line; a thing needs a thickness") from error
    declared = "dae" if draft.format == "dae" and draft.up in ("y", "z") else "declared"
    prior_key = f"{declared}_{draft.up}" if draft.up else ("generated" if generated else draft.format)
    stated = f"the file states {draft.up} up" if draft.up else f"{draft.format} states no up axis"
    if override.up is not None:
        name, rotation, confidence = override.up.value, up_axis.UP_ROTATIONS[override.up.value], 1.0
        reason = "a person decided"
    else:
        points = draft.surface.vertices
        name, rotation, confidence = _best_candidate(points, cloud, category, prior_key, draft.up, failed_ups)
        reason = f"{stated}; weighed with the usual shape, room and balance of a {category.id}"
        if category.upright is RestingPose.ANY and category.id != FALLBACK:
            confidence = max(confidence, MIN_CONFIDENCE_ANY_POSE)
            reason = f"{stated}; a {category.id} rests in any pose"
        if category.id == FALLBACK:
            reason = f"{stated}; weighed with its room and foot, since nobody knows what it is"
        if failed_ups:
            reason += f"; with {' and '.join(failed_ups)} up it failed"
    front = _front(cloud.samples @ rotation.T, category, draft, name, override)
    rotation = _about_z(front.angle) @ rotation
    parts = []
    for part in draft.parts:
        normals = None if part.mesh.normals is None else part.mesh.normals @ rotation.T
        parts.append(part.replace(mesh=part.mesh.with_vertices(part.mesh.vertices @ rotation.T, normals)))
    out = draft.replace(parts=tuple(parts), up="z")
    out = out.replace(guesses=out.guessed("up_axis", _up_in_words(name, rotation), confidence, reason))
    return out.replace(guesses=out.guessed("front", front.value, front.confidence, front.reason))


def _up_in_words(name: str, rotation: Floats) -> str:
    """A way up for a guess: the axis, or a direction in the axes of the file if it is not along an axis."""
    return name if name in up_axis.UP_ROTATIONS else " ".join(f"{v:.3f}" for v in rotation[2])


def _best_candidate(
    points: Floats,
    cloud: up_axis.SurfaceSample,
    category: Category,
    prior_key: str,
    stated_up: str | None,
    failed_ups: Sequence[str],
) -> tuple[str, Floats, float]:
    """Name, rotation and confidence, 0..1, of the best candidate: the stated one unless another is far likelier."""
    options = [one for one in up_axis.candidates(cloud) if _up_in_words(*one) not in failed_ups]
    names, rotations = [name for name, _ in options], [rotation for _, rotation in options]
    prior = up_axis.priors(prior_key, names) + up_axis.origin_evidence(points, names)

    log = prior + np.array([up_axis.pose_score(up_axis.stance(cloud, r, with_rain=False), category) for r in rotations])
    if category.upright is not RestingPose.ANY or category.id == FALLBACK:
        margin = HOPELESS_NATS_VESSEL if category.build is MatterFill.VESSEL else HOPELESS_NATS
        kept = np.flatnonzero(log > log.max() - margin)
        stances = [up_axis.stance(cloud, rotations[k], with_rain=True) for k in kept]
        log = np.full(len(options), -np.inf)
        scores = np.array([up_axis.pose_score(s, category) for s in stances])
        log[kept] = prior[kept] + scores / up_axis.doubts(stances, category)
        log[kept] += [up_axis.balance_score(s, category) for s in stances]
    share = np.exp(log - log.max())
    share /= share.sum()
    # A slight tilt leaves no doubt about the resting pose; a banana rests equally well on either side.
    ups = np.array([rotation[2] for rotation in rotations])
    lies_on_either_side = category.upright is RestingPose.LIES and category.build is MatterFill.SOLID
    is_same = (np.abs(ups @ ups.T) if lies_on_either_side else ups @ ups.T) > SAME_COSINE
    together = is_same @ share
    group = is_same[int(np.argmax(together))]
    best = int(np.argmax(np.where(group, share, -1.0)))
    stated = names.index(stated_up) if stated_up in names else best
    if is_same[best, stated]:
        best = best if share[best] > TILT_ODDS * share[stated] else stated
    elif together[best] <= OVERRULE_ODDS * together[stated]:
        # Between these two alone: a third way up is no reason to doubt the file.
        return names[stated], rotations[stated], float(together[stated] / (together[stated] + together[best]))
    return names[best], rotations[best], float(min(together[best], 1.0))


def _front(samples: Floats, category: Category, draft: Draft, name: str, override: UserOverride) -> Facing:
    """The turn to the front of (N, 3) samples in the chosen pose; else a pose off the axes is straightened."""
    if override.turn_deg is not None:
        turned = f"turned by {override.turn_deg:g} degrees"
        return Facing(float(np.radians(override.turn_deg)), turned, 1.0, "a person decided")
    front = facing(samples, category, draft.up is not None and draft.format in ("glb", "gltf"))
    if front.angle == 0 and name not in up_axis.UP_ROTATIONS:
        return replace(front, angle=straightened(samples))
    return front


def _about_z(angle: float) -> Floats:
    """(3, 3) turn about z; quarter turns are exact."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    quarters = angle / (np.pi / 2)
    if abs(quarters - round(quarters)) < 1e-9:
        c, s = float(round(c)), float(round(s))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]], dtype=np.float64)


@dataclass(frozen=True)
class Facing:
    """A turn about z, radians, with what was found, the confidence, 0..1, and the reason."""

    angle: float
    value: str
    confidence: float
    reason: str


def facing(samples: Floats, category: Category, is_front_stated: bool) -> Facing:
    """Find the turn about z that brings the front of evenly spread points, z up, where the category has it."""
    if category.front is FrontRule.LENGTH:
        angle, long, wide = up_axis.smallest_rectangle(samples[:, :2])
        ratio = long / max(wide, 1e-9)
        confidence = float(np.clip(0.4 + 1.2 * np.log(ratio), 0.3, 0.98))
        turn = _smallest_turn(-angle, np.pi)
        return Facing(turn, "length along x", confidence, f"{ratio:.2g} times as long as wide")
    if category.front is FrontRule.HANDLE:
        return _handle(samples)
    if category.front is FrontRule.FACE:
        return _face(samples, category, is_front_stated)
    return Facing(0.0, "any", 1.0, f"a {category.id} has no front")


def _smallest_turn(angle: float, period: float) -> float:
    """Smallest turn equal to an angle modulo a period; 0 below MIN_TURN_RAD."""
    turn = (angle + period / 2) % period - period / 2
    return 0.0 if abs(turn) < MIN_TURN_RAD else turn


def straightened(samples: Floats) -> float:
    """Smallest turn about z that lays the outline along x and y; 0 if the box around it gets no smaller."""
    angle, a, b = up_axis.smallest_rectangle(samples[:, :2])
    area_as_is = float(np.ptp(samples[:, 0]) * np.ptp(samples[:, 1]))
    return _smallest_turn(-angle, np.pi / 2) if a * b < 0.92 * area_as_is else 0.0


def _body_circle(samples: Floats) -> tuple[Floats, float]:
    """Centre of the body in plan, and its radius, without its handle."""
    height = max(float(np.ptp(samples[:, 2])), 1e-9)
    level = (samples[:, 2] - samples[:, 2].min()) / height
    # Scans of flat objects are tilted a little.
    foot_points = samples[level < max(up_axis.FOOT_SHARE, 0.06, 0.035 / height)][:, :2]
    lower, upper = foot_points.min(axis=0), foot_points.max(axis=0)
    middle = (lower + upper) / 2
    a, b = sorted(np.maximum(upper - lower, 1e-9))
    width = float(np.ptp(samples[:, :2], axis=0).min())
    # A round foot that is wide enough is the body's own; else the circle that the lower half of what is seen lies on.
    is_round_foot = a > ROUND_SIDE_RATIO * b and a > 0.4 * width
    for _ in range(0 if is_round_foot else 6):
        low_points = samples[level < 0.6][:, :2] - middle
        reach = np.linalg.norm(low_points, axis=1)
        radius = float(np.quantile(reach, 0.7))
        near = reach < 1.12 * radius
        body = low_points[near]
        middle = middle + (body.min(axis=0) + body.max(axis=0)) / 2 * 0.7
    spread = np.linalg.norm(samples[:, :2] - middle, axis=1)
    angle = np.arctan2(*(samples[:, :2] - middle).T[::-1])
    sector = np.floor((angle + np.pi) / (2 * np.pi) * SECTORS).astype(int) % SECTORS
    outer = np.zeros(SECTORS)
    np.maximum.at(outer, sector, spread)
    return middle, float(np.median(outer[outer > 0]))


def _handle(samples: Floats) -> Facing:
    """The turn that brings to +x the direction in which most surface lies outside of the body."""
    middle, radius = _body_circle(samples)
    offset = samples[:, :2] - middle
    distance = np.linalg.norm(offset, axis=1)
    is_outside = distance > HANDLE_REACH * radius
    if is_outside.sum() < 0.004 * len(samples):
        return Facing(0.0, "no handle", 0.4, "nothing sticks out of the body")
    angle = np.arctan2(offset[is_outside, 1], offset[is_outside, 0])
    weight = distance[is_outside] / radius - 1
    directions = np.arange(-np.pi, np.pi, np.pi / 90)
    score = np.maximum(np.cos(angle[None] - directions[:, None]), 0) ** 8 @ weight
    first = int(np.argmax(score))
    is_near = np.cos(angle - directions[first]) > 0.5
    mean = np.arctan2((weight * np.sin(angle))[is_near].sum(), (weight * np.cos(angle))[is_near].sum())
    is_far = np.abs((directions - directions[first] + np.pi) % (2 * np.pi) - np.pi) > np.pi / 3
    runner_up = float(score[is_far].max()) / float(score[first])
    share_outside = float(is_outside.mean())
    # Two opposite handles are equal, and a spout may be larger than the handle.
    confidence = float(np.clip(0.95 - 0.9 * runner_up, 0.4, 0.95)) if share_outside > 0.02 else 0.55
    message = f"{share_outside:.0%} of the surface sticks out of the body, the next side {runner_up:.0%} as much"
    period = np.pi if runner_up > 0.85 else 2 * np.pi
    turn = _smallest_turn(-_snapped_to_outline(samples, float(mean)), period)
    return Facing(turn, "handle to x", confidence, message)


def _snapped_to_outline(samples: Floats, direction: float) -> float:
    """A direction in plan, or that of the next side of the outline, so that rectangular pots lie along x and y."""
    side_angle, long, wide = up_axis.smallest_rectangle(samples[:, :2])
    angle_to_side = (direction - side_angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
    # The corners of a rectangular body reach out of the circle that it is measured by, so its direction is not used.
    is_square = float(ConvexHull(samples[:, :2]).volume) > RECTANGLE_FILL * long * wide
    return direction - angle_to_side if is_square or abs(angle_to_side) < SNAP_ANGLE_RAD else direction


def _face(samples: Floats, category: Category, is_front_stated: bool) -> Facing:
    """The turn that brings the face to -y: by the format, the usual width over depth and the relief of each side."""
    straightening = straightened(samples)
    c, s = np.cos(straightening), np.sin(straightening)
    plan = samples[:, :2] @ np.array([[c, s], [-s, c]])
    x, y = np.ptp(plan, axis=0)
    usual_log_ratio = np.log(category.extents[0].typical / category.extents[1].typical)
    log_ratio = float(np.log(max(x, 1e-9) / max(y, 1e-9)))
    detail = _relief(np.column_stack([plan, samples[:, 2]]))
    odds = np.log(np.array(STATED_FACE if is_front_stated else SILENT_FACE))
    for k in range(4):
        log_ratio_of_side = log_ratio if k % 2 == 0 else -log_ratio
        odds[k] += -0.5 * ((log_ratio_of_side - usual_log_ratio) / 0.35) ** 2 + 1.5 * detail[k]
    best = int(np.argmax(odds))
    weights = np.exp(odds - odds[best])
    confidence = float(1 / weights.sum())
    sides = ("-y", "+x", "+y", "-x")
    stated = "the format says -y" if is_front_stated else "the format says nothing"
    message = f"{stated}; width over depth and detail speak as well"
    # A quarter turn clockwise brings a face at +x to -y.
    return Facing(straightening - best * np.pi / 2, f"face was at {sides[best]}", confidence, message)


def _relief(samples: Floats) -> Floats:
    """(4,) log of the mean relief seen from -y, +x, +y and -x, relative to the mean of the sides."""
    details = []
    for axis, sign in ((1, -1.0), (0, 1.0), (1, 1.0), (0, -1.0)):
        depth_of_point = sign * samples[:, axis]
        across = samples[:, [1 - axis, 2]]
        lower, extent = across.min(axis=0), np.maximum(np.ptp(across, axis=0), 1e-9)
        cells = np.minimum(((across - lower) / extent * 32).astype(int), 31)
        depth_map = np.full((32, 32), -np.inf)
        np.maximum.at(depth_map, (cells[:, 0], cells[:, 1]), depth_of_point)
        depths = depth_map[np.isfinite(depth_map)]
        plane = np.median(depths)
        details.append(float(np.mean(np.clip(np.abs(depths - plane) - 0.01, 0, 0.05))) + 0.002)
    logs = np.log(np.array(details))
    return np.asarray(logs - logs.mean())
