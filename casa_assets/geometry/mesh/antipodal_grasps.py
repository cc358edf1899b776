"""Find antipodal grasps: opposite surface points with room for both fingers and for the hand behind them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.solid.coverage import samples_with_faces

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
APPROACHES = 8
MIN_APPROACH_HEIGHT = -0.1


@dataclass(frozen=True)
class AntipodalGrasp:
    """Two fingers closed on a surface.

    Attributes:
        center: (3,) middle between them, metres. closing: (3,) unit vector from one to the other.
        approach: (3,) unit vector along which the hand comes. width: between the fingers, metres.
    """

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
    """Antipodal grasps of an object on a floor at the height of its lowest point.

    Args:
        points: (P, 3) metres, z up. faces: (F, 3) facing outwards.
        opening: maximum opening of the fingers, metres.
    """
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
