"""Let a state settle, and measure what happens to it when nobody touches it."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks.motion.simulation import simulation_warnings
from casa_assets.checks.start_states.stage import Stage
from casa_assets.core.typing import Floats

WATCHED_S, LOOK_S = 2.0, 0.1
SETTLE_S = 4.0  # what still moves after that is given up
STILL_M = 0.00005  # farthest that any corner goes in `LOOK_S` while a state counts as at rest


@dataclass(frozen=True)
class Watched:
    """Behaviour of a state in 2 s of simulation.

    Attributes:
        depth: deepest contact at the start and at every look, m; at the start of all pairs, else as simulated.
        motion: largest distance that any corner of a shape moved, m. warnings: of the simulator.
    """

    depth: float
    motion: float
    warnings: tuple[str, ...]


def settle(stage: Stage, qpos: Floats) -> Floats | None:
    """A state in which nothing moves any more, rounded to float32; None if it does not come to rest in 4 s."""
    model, data = stage.model, stage.data
    stage.show(qpos)
    steps, last = round(LOOK_S / model.opt.timestep), stage.corners()
    for _ in range(round(SETTLE_S / LOOK_S)):
        mujoco.mj_step(model, data, nstep=steps)
        now = stage.corners()
        if float(np.linalg.norm(now - last, axis=1).max(initial=0.0)) < STILL_M:
            rounded: Floats = data.qpos.astype(np.float32).astype(np.float64)
            return rounded
        last = now
    return None


def watch(stage: Stage, qpos: Floats) -> Watched:
    """Begin with a state at rest and look on for 2 s."""
    model, data = stage.model, stage.data
    depth = stage.depth_of_all_pairs(qpos)
    stage.show(qpos)
    before, motion = stage.corners(), 0.0
    steps = round(LOOK_S / model.opt.timestep)
    for _ in range(round(WATCHED_S / LOOK_S)):
        mujoco.mj_step(model, data, nstep=steps)
        depth = max(depth, stage.depth())
        motion = max(motion, float(np.linalg.norm(stage.corners() - before, axis=1).max(initial=0.0)))
    return Watched(depth, motion, tuple(simulation_warnings(data)))
