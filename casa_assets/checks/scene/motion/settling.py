"""Let the objects of a scene come to rest in a simulation, and report how far each moved and its penetration depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks.motion.simulation import collision_spec, reset_to_start
from casa_assets.core.numeric import Floats
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import FREE_JOINT
from casa_assets.model.pose import Pose


@dataclass(frozen=True)
class Rest:
    """Where an object came to rest.

    Attributes:
        pose: world_from_root at the end. moved: farthest that the middle of one of its shapes went, as the checks of
            scenes measure it, metres. tilt: turn of its upright axis, radians. depth: deepest contact at the start and
            at the end, near misses not counted, metres.
    """

    pose: Pose
    moved: float
    tilt: float
    depth: float


def come_to_rest(files: Files, names: Sequence[str], seconds: float) -> dict[str, Rest]:
    """Simulate a scene that nobody touches.

    Args:
        files: MJCF of the scene in memory. names: placements that are free. seconds: to simulate.
    Raises:
        ValueError: MuJoCo cannot read it.
    """
    model = collision_spec(files, "scene.xml").compile()
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_forward(model, data)
    bodies = [model.body(name).id for name in names]
    before, axes = data.geom_xpos.copy(), data.xmat[bodies].reshape(-1, 3, 3)[:, :, 2].copy()
    depth = _depths(model, data)
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    mujoco.mj_forward(model, data)
    depth = np.maximum(depth, _depths(model, data))
    ways, roots = np.linalg.norm(data.geom_xpos - before, axis=1), model.body_rootid[model.geom_bodyid]
    found = {}
    for number, (name, body) in enumerate(zip(names, bodies, strict=True)):
        start = model.jnt_qposadr[model.joint(f"{name}__{FREE_JOINT}").id]
        x, y, z, *turn = (float(v) for v in data.qpos[start : start + 7])
        upright = data.xmat[body].reshape(3, 3)[:, 2]
        found[name] = Rest(
            pose=Pose(position=(x, y, z), quaternion=(turn[0], turn[1], turn[2], turn[3])),
            moved=float(ways[roots == body].max(initial=0.0)),
            tilt=float(np.arccos(np.clip(upright @ axes[number], -1.0, 1.0))),
            depth=float(depth[body]),
        )
    return found


def _depths(model: mujoco.MjModel, data: mujoco.MjData) -> Floats:
    """(nbody,) deepest contact of each body, metres; 0 where it touches nothing."""
    depths = np.zeros(model.nbody)
    bodies = model.body_rootid[model.geom_bodyid[data.contact.geom]]
    for pair, distance in zip(bodies, data.contact.dist, strict=True):
        np.maximum.at(depths, pair, -distance)
    return depths
