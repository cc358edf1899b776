"""Find things that stand in each other in the batch form, or do not stay where they stand."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.readers.mujoco_facts import free_bodies
from casa_assets.checks.scene.batch.subject import UNREADABLE, BatchSubject, awake
from casa_assets.checks.scene.motion.rest import MM_PER_M, NO_FREE_THINGS, SETTLED_S, SIMULATED_S

MAX_LISTED = 20


@dataclass(frozen=True)
class _Settled:
    """How deep pairs of geoms were in each other, at the start or later, and how far things went, metres."""

    depths: dict[tuple[str, str], float]
    drift: dict[str, float]


def no_penetration(subject: BatchSubject, limit: float) -> Measurement:
    """BAT005: deepest penetration at the start and after 1 s with nothing asleep, metres."""
    settled = _settled(subject)
    if settled is None:
        return not_run(UNREADABLE)
    problems = [
        (f"geoms/{first}", f"is {depth * MM_PER_M:.2f} mm in {second} in the batch form")
        for (first, second), depth in sorted(settled.depths.items())
        if depth > limit
    ]
    return Measurement(max(settled.depths.values(), default=0.0), tuple(problems[:MAX_LISTED]))


def loose_things_stay_put(subject: BatchSubject, limit: float) -> Measurement:
    """BAT006: farthest that a thing that stands by its weight moves in 5 s with nothing asleep, metres."""
    settled = _settled(subject)
    if settled is None:
        return not_run(UNREADABLE)
    if not settled.drift:
        return not_applicable(NO_FREE_THINGS)
    problems = [
        (f"placements/{name}", f"moves {drift * MM_PER_M:.1f} mm in {SIMULATED_S:g} s in the batch form")
        for name, drift in settled.drift.items()
        if drift > limit
    ]
    return Measurement(max(settled.drift.values()), tuple(problems[:MAX_LISTED]))


@lru_cache(maxsize=1)
def _settled(subject: BatchSubject) -> _Settled | None:
    """Simulate the batch form for 5 s, once; None where it does not load."""
    model = subject.batch.model
    if model is None:
        return None
    with awake(model) as data:
        start, depths = data.geom_xpos.copy(), dict[tuple[str, str], float]()
        for seconds in (SETTLED_S, SIMULATED_S - SETTLED_S):
            for (first, second), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
                pair = (str(model.geom(first).name), str(model.geom(second).name))
                depths[pair] = max(depths.get(pair, 0.0), -distance)
            mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
        distances = np.where(subject.colliding, np.linalg.norm(data.geom_xpos - start, axis=1), 0.0)
    roots = model.body_rootid[model.geom_bodyid]
    drift = {str(model.body(b).name): float(distances[roots == b].max(initial=0.0)) for b in free_bodies(model)}
    return _Settled(depths, drift)
