"""Find fixed things that overlap; MuJoCo makes no contacts between them, so they are measured."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.checks.scene.subject import SceneSubject, boxes, meet

MM = 1000.0
# Categories of two things of which one may stand in the other -> how deep, metres, and why.
ALLOWED: dict[tuple[str, str], tuple[float, str]] = {}


def fixed_things_do_not_overlap(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN007: deepest overlap of fixed shapes of two things, metres; allowed ones are left out.

    What moves is the business of the contacts at the start.
    """
    assert limit is not None
    worst: dict[tuple[str, str], tuple[float, int, int]] = {}
    for one, other, depth in deep_pairs(subject, limit):
        names = (subject.owner[one], subject.owner[other])
        if depth > worst.get(names, (0.0, 0, 0))[0]:
            worst[names] = (depth, one, other)
    problems, deepest = [], 0.0
    for names, (depth, one, other) in worst.items():
        if depth <= max(limit, allowance(subject, *names)):
            continue
        deepest = max(deepest, depth)
        message = (
            f"{subject.message(one)} is {depth * MM:.1f} mm in {subject.message(other)}; move one, or make it smaller"
        )
        problems.append((f"placements/{names[0]}", message))
    return Measurement(deepest, tuple(problems))


def allowance(subject: SceneSubject, one: str, other: str) -> float:
    """Depth that two placements may overlap, metres."""
    kinds = (subject.category(one), subject.category(other))
    return max(ALLOWED.get(kinds, (0.0, ""))[0], ALLOWED.get(kinds[::-1], (0.0, ""))[0])


def deep_pairs(subject: SceneSubject, limit: float) -> Iterator[tuple[int, int, float]]:
    """Fixed geoms of two placements, and how deep they are in each other where that is more than `limit`, metres."""
    model, data = subject.model, subject.data
    geoms = np.flatnonzero(subject.is_fixed)
    bounds = boxes(model, data, geoms)
    # Shapes are never deeper in each other than their boxes are.
    near = np.triu(meet(bounds[:, None], bounds[None], -limit), 1)
    for i, k in np.argwhere(near):
        one, other = int(geoms[i]), int(geoms[k])
        if subject.owner[one] == subject.owner[other]:
            continue
        depth = -mujoco.mj_geomDistance(model, data, one, other, limit, None)
        if depth > limit:
            yield one, other, float(depth)
