"""Find fixed things that overlap; MuJoCo makes no contacts between them, so they are measured."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.checks.motion.simulation import geom_boxes
from casa_assets.checks.scene.subject import SceneSubject, boxes_meet

MM_PER_M = 1000.0
# Categories of two things of which one may stand in the other -> how deep, metres, and why.
ALLOWED: dict[tuple[str, str], tuple[float, str]] = {}


def fixed_things_do_not_overlap(subject: SceneSubject, limit: float) -> Measurement:
    """SCN007: deepest overlap of fixed shapes of two things, metres; allowed ones are left out.

    SCN002 reports overlaps of what moves.
    """
    worst: dict[tuple[str, str], tuple[float, int, int]] = {}
    for geom1, geom2, depth in overlapping_pairs(subject, limit):
        names = (subject.placement_of[geom1], subject.placement_of[geom2])
        if depth > worst.get(names, (0.0, 0, 0))[0]:
            worst[names] = (depth, geom1, geom2)
    problems, deepest = [], 0.0
    for names, (depth, geom1, geom2) in worst.items():
        if depth <= max(limit, allowance(subject, *names)):
            continue
        deepest = max(deepest, depth)
        overlap = f"{subject.geom_name(geom1)} is {depth * MM_PER_M:.1f} mm in {subject.geom_name(geom2)}"
        problems.append((f"placements/{names[0]}", f"{overlap}; move one, or make it smaller"))
    return Measurement(deepest, tuple(problems))


def allowance(subject: SceneSubject, placement1: str, placement2: str) -> float:
    """Depth by which two placements may overlap, metres."""
    categories = (subject.category(placement1), subject.category(placement2))
    return max(ALLOWED.get(categories, (0.0, ""))[0], ALLOWED.get(categories[::-1], (0.0, ""))[0])


def overlapping_pairs(subject: SceneSubject, limit: float) -> Iterator[tuple[int, int, float]]:
    """Fixed geoms of two placements, and how deep they are in each other where that is more than `limit`, metres."""
    model, data = subject.model, subject.data
    geoms = np.flatnonzero(subject.is_fixed)
    boxes = geom_boxes(model, data, geoms)
    # Shapes are never deeper in each other than their boxes are.
    candidates = np.triu(boxes_meet(boxes[:, None], boxes[None], -limit), 1)
    for i, k in np.argwhere(candidates):
        geom1, geom2 = int(geoms[i]), int(geoms[k])
        if subject.placement_of[geom1] == subject.placement_of[geom2]:
            continue
        depth = -mujoco.mj_geomDistance(model, data, geom1, geom2, limit, None)
        if depth > limit:
            yield geom1, geom2, float(depth)
