"""Where two fingers can close on a surface: opposite points with room for both fingers and for the hand behind them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.solid.coverage import placed_samples

# Points on the surface, and of how many of them it is tried whether a finger can lie there.
SAMPLES, TRIES = 10_000, 250
# A finger: how thick and how broad it is, how far it reaches past the middle of its pad, and how far behind it the palm
# begins; the palm's depth and half its length along the closing direction; metres.
# Ref: Franka hand, pads of 18 mm on fingers of about 10 by 20 mm, 45 mm free before the palm.
THICK, BROAD, TIP, FREE = 0.010, 0.020, 0.006, 0.045
PALM, PALM_HALF = 0.020, 0.070
# How far what touches may stand out under a finger, and the thinnest that fingers hold, metres.
PLAY, THINNEST = 0.0015, 0.0008
# Cosine between the two surfaces' normals: within the friction of rubber. Ref: friction 0.5 holds within 26 degrees.
OPPOSED = -0.9
# Directions round the closing one from which the hand may come; none from more than a little below level.
WAYS = 8
FROM_BELOW = -0.1


@dataclass(frozen=True)
class Pinch:
    """Two fingers on a surface.

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


def pinches(points: Floats, faces: Ints, opening: float) -> list[Pinch]:
    """Ways for two fingers to close on a thing that stands on a floor below its lowest point.

    Args:
        points: (P, 3) metres, z up. faces: (F, 3) facing outwards.
        opening: the widest that the fingers go, metres.
    """
    samples, face = placed_samples(points, faces, SAMPLES)
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
    """How far off the surfaces lie that look the other way behind a point: the nearest, and the farthest."""
    rows = np.array(cloud.tree.query_ball_point(start - normal * opening / 2, opening / 2 + cloud.near), dtype=np.int64)
    if not len(rows):
        return []
    off = cloud.samples[rows] - start
    depth = -(off @ normal)
    aside = np.linalg.norm(off + depth[:, None] * normal, axis=1)
    opposed = (cloud.normals[rows] @ normal < OPPOSED) & (aside < cloud.near) & (depth > THINNEST) & (depth <= opening)
    depths = depth[opposed]
    if not len(depths):
        return []
    near, far = float(depths.min()), float(depths.max())
    return [near] if far - near < 2 * cloud.near else [near, far]


def _free_way(cloud: _Cloud, center: Floats, closing: Floats, width: float) -> Pinch | None:
    """The steepest way from above on which neither fingers nor palm meet anything; None where there is none."""
    reach = float(np.hypot(FREE + PALM, max(PALM_HALF, width / 2 + THICK)))
    rows = cloud.tree.query_ball_point(center, reach)
    off = cloud.samples[rows] - center
    for away in _ways(closing):
        broad = np.cross(closing, away)
        x, y, z = np.abs(off @ closing), np.abs(off @ broad), off @ away
        inner = width / 2 + PLAY
        finger = (x > inner) & (x < inner + THICK) & (y < BROAD / 2) & (z > -TIP) & (z < FREE)
        palm = (x < PALM_HALF) & (y < BROAD) & (z >= FREE) & (z < FREE + PALM)
        if (finger | palm).any():
            continue
        below = (inner + THICK) * abs(closing[2]) + BROAD / 2 * abs(broad[2]) + max(TIP * away[2], -FREE * away[2])
        hand = PALM_HALF * abs(closing[2]) + BROAD * abs(broad[2]) - (FREE + PALM) * min(0.0, float(away[2]))
        if center[2] - max(below, hand - FREE * max(0.0, float(away[2]))) >= cloud.floor - 1e-6:
            return Pinch(center, closing, -away, width)
    return None


def _ways(closing: Floats) -> list[Floats]:
    """Unit vectors at right angles to the closing direction, from the thing to the hand, the steepest first."""
    up = np.array([0.0, 0.0, 1.0])
    first = up - closing * closing[2]
    if np.linalg.norm(first) < 0.2:  # fingers close from above and below: any level way is as good
        first = np.array([1.0, 0.0, 0.0]) - closing * closing[0]
    first /= np.linalg.norm(first)
    second = np.cross(closing, first)
    angles = 2 * np.pi * np.arange(WAYS) / WAYS
    ways = [np.cos(a) * first + np.sin(a) * second for a in angles]
    return sorted((w for w in ways if w[2] >= FROM_BELOW), key=lambda w: -round(float(w[2]), 6))
