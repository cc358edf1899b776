"""Objects in drawers, on racks and in doors go along with them where joints are moved without dynamics."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from casa_assets.core.typing import Floats, Mask
from casa_assets.model.kitchen.scene import FREE_JOINT


class Contents:
    """Objects of a scene that rest on bodies which joints move, and how each lies on its body.

    Args:
        held: name of each object, and of the body that holds it.
        qpos: (nq,) a state in which each lies there.
    """

    def __init__(self, model: mujoco.MjModel, held: Iterable[tuple[str, str]], qpos: Floats) -> None:
        self.model = model
        # Of each object: its body, that of what holds it, and where its free joint is in qpos.
        self.rows: list[tuple[int, int, int]] = []
        for name, holder_name in held:
            holder = int(model.body(holder_name).id)
            if model.body_weldid[holder] != 0:
                address = int(model.joint(f"{name}__{FREE_JOINT}").qposadr[0])
                self.rows.append((int(model.body(name).id), holder, address))
        data = mujoco.MjData(model)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        self._relative = [self._pose_in(data, body, holder) for body, holder, _ in self.rows]

    def moved_with(self, moved: Mask) -> Mask:
        """(nbody,) the bodies that move, and the objects that rest on one of them."""
        found = moved.copy()
        for body, holder, _ in self.rows:
            if moved[holder]:
                found[body] = True
        return found

    def pose(self, data: mujoco.MjData) -> None:
        """Compute the poses of all bodies of the present joint positions, objects laid where what holds them is."""
        mujoco.mj_kinematics(self.model, data)
        if not self.rows:
            return
        position, turn = np.empty(3), np.empty(4)
        for (_, holder, address), (at, turned) in zip(self.rows, self._relative, strict=True):
            mujoco.mju_mulPose(position, turn, data.xpos[holder], data.xquat[holder], at, turned)
            data.qpos[address : address + 3], data.qpos[address + 3 : address + 7] = position, turn
        mujoco.mj_kinematics(self.model, data)

    @staticmethod
    def _pose_in(data: mujoco.MjData, body: int, holder: int) -> tuple[Floats, Floats]:
        """Position and quaternion of a body in the frame of another."""
        back, unturned = np.empty(3), np.empty(4)
        mujoco.mju_negPose(back, unturned, data.xpos[holder], data.xquat[holder])
        position, turn = np.empty(3), np.empty(4)
        mujoco.mju_mulPose(position, turn, back, unturned, data.xpos[body], data.xquat[body])
        return position, turn
