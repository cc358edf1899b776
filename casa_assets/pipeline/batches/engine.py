"""What an engine is made of, and what it can do, whichever it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco

from casa_assets.core.typing import Floats, Ints

# Sizes of buffers for a kitchen without `batch.json`: the most of 120 kitchens, with a margin of 1.5.
COMMON_SIZES = {"nconmax": 144, "njmax": 872, "nccdmax": 144, "nvmax": 128}

# Joints of the robot in the trials that these were counted in, and those in `batch.json`.
TRIAL_ROBOT_FREEDOMS = 9

# Iterations of the solver at most, for engines in single precision: it does not get below its tolerance there and would
# go on to the last. After eight nothing changed any more in three kitchens.
ITERATIONS = 20


@dataclass(frozen=True)
class Parts:
    """What an engine is made of.

    Attributes:
        models: of the kitchens, all of one structure. texts: MJCF of each, empty where they have pictures.
        kitchen_of_world: (worlds,) which of them each world is.
        sizes: nconmax, njmax, nccdmax and nvmax of a world, as in `batch.json`.
        mounted: whether a robot stands on a mocap body, which a reset moves. ctrl: (nu,) what a reset sets it to.
        device: name of it, such as `cuda:0` or `cpu`; None: the engine's own choice.
    """

    models: Sequence[mujoco.MjModel]
    texts: Sequence[str]
    kitchen_of_world: Ints
    sizes: Mapping[str, int]
    mounted: bool
    ctrl: Floats
    device: str | None = None


class Engine(Protocol):
    """Worlds of a batch in an engine.

    Attributes:
        model, data: as the engine has them.
    """

    model: Any
    data: Any

    @property
    def control(self) -> Any:
        """What drives joints, where that is not in `data`."""

    def reset(self, worlds: Ints, qpos: Floats, asleep: Ints, mounts: Floats) -> None:
        """Put worlds into states at rest.

        Args:
            worlds: (n,) their numbers. qpos: (n, nq). asleep: (n, trees of the kitchen) as MuJoCo's `tree_asleep`.
            mounts: (n, 7) pose of the mocap body that a robot stands on: x, y, z (m), quaternion (w, x, y, z).
        """

    def step(self, count: int) -> None:
        """Step all worlds so many times."""

    @property
    def qpos(self) -> Floats:
        """(worlds, nq)."""

    @property
    def qvel(self) -> Floats:
        """(worlds, nv)."""

    @property
    def bytes_per_world(self) -> int:
        """Memory of the state of a world, without the model and without what an engine holds during a step, bytes."""
