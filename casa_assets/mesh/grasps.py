"""Antipodal grasps of an object, and the choice of those that a hand takes: body, rim and handle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from casa_assets.core.numeric import Floats, Ints, seven_digits
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.parts import Grasp, GraspFeature, Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category, FrontRule, MatterFill

# Points on the surface, and of how many of them it is tried whether a finger can lie there.
SAMPLES, TRIES = 10_000, 250
# A finger: how thick and how broad it is, how far it reaches past the middle of its pad, and how far behind it the palm
# begins; the palm's depth and half its length along the closing direction; metres.
# Ref: Franka hand, pads of 18 mm on fingers of about 10 by 20 mm, 45 mm free before the palm.
FINGER_THICKNESS_M, FINGER_WIDTH_M, FINGER_TIP_M, PALM_DISTANCE_M = 0.010, 0.020, 0.006, 0.045
PALM_DEPTH_M, PALM_HALF_LENGTH_M = 0.020, 0.070
# How far what touches may stand out under a finger, and the thinnest that fingers hold, metres.
MAX_BUMP_M, MIN_WIDTH_M = 0.0015, 0.0008
# Cosine between the two surfaces' normals: within the friction of rubber. Ref: friction 0.5 holds within 26 degrees.
MAX_NORMAL_COSINE = -0.9
# Directions round the closing one from which the hand may come; none from more than a little below level.
APPROACHES, MIN_APPROACH_HEIGHT = 8, -0.1
# All numbers below are choices.
# Largest thickness of a rim, and largest distance from the top, metres.
RIM_THICKNESS_M, RIM_DEPTH_M = 0.015, 0.035
# A rim is grasped from above: smallest cosine between the approach and straight down, and largest sine between the
# closing direction and the horizontal.
MIN_DOWNWARD_COSINE, MAX_CLOSING_SINE = 0.7, 0.5
# Largest thickness of a handle, metres.
HANDLE_THICKNESS_M = 0.05
# Horizontal distance from the centre of mass, as a share of the longer horizontal side, up to which a grasp is of the
# body, and from which on a thin grasp of a vessel is of its handle.
BODY_REACH_SHARE, HANDLE_DISTANCE_SHARE = 0.25, 0.45
# Smallest width of a grasp of the body of a vessel, as a share of its shorter horizontal side.
MIN_BODY_WIDTH_SHARE = 0.5
# Side of the finger pads that a grasp is shown with, metres; a choice.
PAD_M = 0.02


@dataclass(frozen=True)
class AntipodalGrasp:
    """Two fingers closed on a surface, m; unit vectors from one to the other, and along which the hand comes."""

    center: Floats
    closing: Floats
    approach: Floats
    width: float


@dataclass(frozen=True)
class _Cloud:
    samples: Floats
    normals: Floats
    tree: cKDTree
    near: float
    floor: float


def antipodal_grasps(points: Floats, faces: Ints, opening: float) -> list[AntipodalGrasp]:
    """Antipodal grasps of (P, 3) points, m, z up, and (F, 3) outward faces, with the lowest point on the floor."""
    samples, face = samples_with_faces(points, faces, SAMPLES)
    normals, areas = face_normals(points, faces)
    near = max(0.002, 1.2 * float(np.sqrt(areas.sum() / SAMPLES)))
    cloud = _Cloud(samples, normals[face], cKDTree(samples), near, float(samples[:, 2].min()))
    found = []
    for i in range(SAMPLES // TRIES // 2, SAMPLES, SAMPLES // TRIES):
        start, normal = cloud.samples[i], cloud.normals[i]
        for width in _widths(cloud, start, normal, opening):
            pinch = _free_way(cloud, start - normal * width / 2, normal, width)
            if pinch is not None:
                found.append(pinch)
    return found


def _widths(cloud: _Cloud, start: Floats, normal: Floats, opening: float) -> list[float]:
    """Distances to the surfaces opposite a point: the nearest and the farthest."""
    rows = np.array(cloud.tree.query_ball_point(start - normal * opening / 2, opening / 2 + cloud.near), dtype=np.int64)
    if not len(rows):
        return []
    off = cloud.samples[rows] - start
    depth = -(off @ normal)
    aside = np.linalg.norm(off + depth[:, None] * normal, axis=1)
    opposed = (
        (cloud.normals[rows] @ normal < MAX_NORMAL_COSINE)
        & (aside < cloud.near)
        & (depth > MIN_WIDTH_M)
        & (depth <= opening)
    )
    depths = depth[opposed]
    if not len(depths):
        return []
    near, far = float(depths.min()), float(depths.max())
    return [near] if far - near < 2 * cloud.near else [near, far]


def _free_way(cloud: _Cloud, center: Floats, closing: Floats, width: float) -> AntipodalGrasp | None:
    """Return the grasp with the steepest approach from above in which neither fingers nor palm collide, or None."""
    reach = float(np.hypot(PALM_DISTANCE_M + PALM_DEPTH_M, max(PALM_HALF_LENGTH_M, width / 2 + FINGER_THICKNESS_M)))
    rows = cloud.tree.query_ball_point(center, reach)
    off = cloud.samples[rows] - center
    for away in _ways(closing):
        broad = _cross(closing, away)
        x, y, z = np.abs(off @ closing), np.abs(off @ broad), off @ away
        inner = width / 2 + MAX_BUMP_M
        finger = (
            (x > inner)
            & (x < inner + FINGER_THICKNESS_M)
            & (y < FINGER_WIDTH_M / 2)
            & (z > -FINGER_TIP_M)
            & (z < PALM_DISTANCE_M)
        )
        palm = (
            (x < PALM_HALF_LENGTH_M)
            & (y < FINGER_WIDTH_M)
            & (z >= PALM_DISTANCE_M)
            & (z < PALM_DISTANCE_M + PALM_DEPTH_M)
        )
        if (finger | palm).any():
            continue
        below = (
            (inner + FINGER_THICKNESS_M) * abs(closing[2])
            + FINGER_WIDTH_M / 2 * abs(broad[2])
            + max(FINGER_TIP_M * away[2], -PALM_DISTANCE_M * away[2])
        )
        hand = (
            PALM_HALF_LENGTH_M * abs(closing[2])
            + FINGER_WIDTH_M * abs(broad[2])
            - (PALM_DISTANCE_M + PALM_DEPTH_M) * min(0.0, float(away[2]))
        )
        if center[2] - max(below, hand - PALM_DISTANCE_M * max(0.0, float(away[2]))) >= cloud.floor - 1e-6:
            return AntipodalGrasp(center, closing, -away, width)
    return None


def _ways(closing: Floats) -> list[Floats]:
    """Unit vectors at right angles to the closing direction, from the thing to the hand, the steepest first."""
    up = np.array([0.0, 0.0, 1.0])
    first = up - closing * closing[2]
    if np.linalg.norm(first) < 0.2:  # fingers close from above and below: any level way is as good
        first = np.array([1.0, 0.0, 0.0]) - closing * closing[0]
    first /= np.linalg.norm(first)
    second = _cross(closing, first)
    angles = 2 * np.pi * np.arange(APPROACHES) / APPROACHES
    ways = [np.cos(a) * first + np.sin(a) * second for a in angles]
    return sorted((w for w in ways if w[2] >= MIN_APPROACH_HEIGHT), key=lambda w: -round(float(w[2]), 6))


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross product of two (3,) vectors, to the same bits as `numpy.cross`, in a tenth of its time."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def choose_grasps(
    points: Floats, faces: Ints, center_of_mass: Vec3, category: Category, opening_m: float
) -> tuple[Grasp, ...]:
    """The best grasp of each possible kind, none of what is fixed; points: metres, z up, at rest; faces: outward."""
    if category.fixed:
        return ()
    center = np.array(center_of_mass)
    sides, top = np.ptp(points, axis=0), float(points[:, 2].max())
    best: dict[GraspFeature, tuple[float, AntipodalGrasp]] = {}
    for candidate in antipodal_grasps(points, faces, opening_m):
        offset = (candidate.center - center)[:2] / float(sides[:2].max())
        aside = float(np.linalg.norm(offset))
        feature = _feature_of(candidate, aside, top, category)
        is_too_narrow = (
            feature is GraspFeature.BODY
            and category.build is MatterFill.VESSEL
            and candidate.width < MIN_BODY_WIDTH_SHARE * sides[:2].min()
        )
        if feature is None or is_too_narrow:
            continue
        score = _score(candidate, feature, offset)
        if feature not in best or score > best[feature][0]:
            best[feature] = (score, candidate)
    if category.front is not FrontRule.HANDLE and len(best) > 1:
        best.pop(GraspFeature.HANDLE, None)
    return tuple(
        Grasp(
            feature=feature,
            center=_rounded(one.center),
            closing=_rounded(one.closing),
            approach=_rounded(one.approach),
            width=round(one.width, 5),
        )
        for feature, one in ((feature, best[feature][1]) for feature in GraspFeature if feature in best)
    )


def grasp_site(grasp: Grasp, shift: Floats) -> Site:
    """A box site, moved by (3,) `shift`, metres: x along the closing direction, long as the opening, z the approach."""
    closing, approach = np.array(grasp.closing), np.array(grasp.approach)
    rotation = Rotation.from_matrix(np.stack([closing, np.cross(approach, closing), approach], axis=1))
    x, y, z, w = (seven_digits(float(v)) for v in rotation.as_quat(canonical=True))
    px, py, pz = (seven_digits(float(v)) for v in np.array(grasp.center) + shift)
    pose = Pose(position=(px, py, pz), quaternion=(w, x, y, z))
    size = (seven_digits(grasp.width), PAD_M, PAD_M)
    return Site(name=f"grasp_{grasp.feature.value}", pose=pose, kind="box", size=size)


def _feature_of(candidate: AntipodalGrasp, aside: float, top: float, category: Category) -> GraspFeature | None:
    """Part that a grasp holds, None for a wall below the rim; `aside`: over the longer side, `top`: height, metres."""
    if category.build is MatterFill.VESSEL and candidate.width <= RIM_THICKNESS_M:
        is_at_top = candidate.center[2] >= top - RIM_DEPTH_M and -candidate.approach[2] >= MIN_DOWNWARD_COSINE
        if (
            is_at_top
            and abs(candidate.closing[2]) < MAX_CLOSING_SINE
            and (category.front is not FrontRule.HANDLE or aside < HANDLE_DISTANCE_SHARE)
        ):
            return GraspFeature.RIM
        return GraspFeature.HANDLE if category.front is FrontRule.HANDLE and aside >= HANDLE_DISTANCE_SHARE else None
    if aside <= BODY_REACH_SHARE:
        return GraspFeature.BODY
    return GraspFeature.HANDLE if candidate.width <= HANDLE_THICKNESS_M else None


def _score(candidate: AntipodalGrasp, feature: GraspFeature, offset: Floats) -> float:
    """Score of a grasp: from above; a body near its centre, a rim at its highest, a handle far out towards +x."""
    steep, aside = -float(candidate.approach[2]), float(np.linalg.norm(offset))
    if feature is GraspFeature.BODY:
        return 0.5 * steep - 2 * aside
    return 0.5 * steep + (
        aside + float(offset[0]) if feature is GraspFeature.HANDLE else 10 * float(candidate.center[2])
    )


def _rounded(vector: Floats) -> tuple[float, float, float]:
    """Six decimals: samples are no more precise, and machines agree on them."""
    x, y, z = (round(float(v), 6) for v in vector)
    return (x, y, z)
