"""A Panda opens a drawer of a kitchen in plain MuJoCo: no planner, no controller but position servos, no robosuite.

    MUJOCO_GL=egl python examples/open_drawer_panda.py robosuite/models/assets/robots/panda/robot.xml out/drawer.png

The arm's own MJCF is the user's: that of robosuite, with panda_gripper.xml beside it in ../../grippers. The arm stands
on a low column before the drawer. The hand goes to the bar, the fingers close, and the hand is moved back: the drawer
follows by contact and friction alone. Exits with 1 where it does not. Metres, seconds, radians.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

import casa_assets as casa

Floats = NDArray[np.float64]
DRAWER, HANDLE = "main_drawers__drawer2_slidejoint", "main_drawers__drawer2_handle"
HOME = (0.0, -0.2, 0.0, -2.1, 0.0, 3.4, 0.785)  # radians
STANDS_OFF_M, COLUMN_M = 0.7, 0.1  # of the base from the bar; its height
PULL_M, OPEN_M = 0.30, 0.25
TIP_M = 0.1  # from the gripper's body to between its fingertips
# Columns: where the fingers close (upright), across, and where the hand looks (along y, at the front).
LEVEL = np.array(((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)))
FROM_LIMITS_RAD = 0.05
COLLIDERS = 3  # group that viewers do not show


def part(path: Path) -> Any:
    """An MJCF file of robosuite without motors and sites, its colliders out of sight as those of the kitchen are."""
    spec = mujoco.MjSpec.from_file(str(path))
    for element in [*spec.actuators, *spec.sites]:
        spec.delete(element)
    for geom in spec.geoms:
        if geom.group == 0:
            geom.group = COLLIDERS
    return spec


def arm_before(kitchen: Any, bar: Floats, panda: Path) -> Any:
    """MjModel of the kitchen with an arm on a column before the bar, a gripper, and servos in the joints."""
    arm, gripper = part(panda), part(panda.parents[2] / "grippers" / "panda_gripper.xml")
    arm.body("right_hand").add_frame().attach_body(gripper.body("right_gripper"), "hand_", "")
    place = (bar[0], bar[1] - STANDS_OFF_M, COLUMN_M)
    turn = (np.cos(np.pi / 4), 0.0, 0.0, np.sin(np.pi / 4))
    kitchen.worldbody.add_frame(pos=place, quat=turn).attach_body(arm.body("base"), "arm_", "")
    kitchen.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=(0.09, COLUMN_M / 2, 0),
        pos=(place[0], place[1], COLUMN_M / 2),
        rgba=(0.25, 0.26, 0.28, 1.0),
        contype=0,
        conaffinity=0,
    )
    for joint in kitchen.joints:
        if joint.name.startswith("arm_"):
            finger = "finger" in joint.name
            joint.armature, most = 0.1, 100.0 if finger else 200.0
            servo = kitchen.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            servo.set_to_position(kp=12000.0 if finger else 4000.0, kv=100.0 if finger else 300.0)
            servo.forcerange = (-most, most)
    for body in kitchen.bodies:
        if body.name.startswith("arm_"):
            body.gravcomp = 1.0
    return kitchen.compile()


def angles_for(model: Any, start: Floats, hand: Floats) -> Floats:
    """Angles of the seven joints that have the fingertips at a point, the hand level and looking along y."""
    data = mujoco.MjData(model)
    address = [int(model.joint(f"arm_joint{k}").qposadr[0]) for k in range(1, 8)]
    columns = [int(model.joint(f"arm_joint{k}").dofadr[0]) for k in range(1, 8)]
    body = model.body("arm_hand_right_gripper").id
    limits = np.array([model.joint(f"arm_joint{k}").range for k in range(1, 8)]).T + np.array(
        [[FROM_LIMITS_RAD], [-FROM_LIMITS_RAD]]
    )
    angles, place, turn = start.copy(), np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for _ in range(200):
        data.qpos[address] = angles
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        pose = data.xmat[body].reshape(3, 3)
        tip = data.xpos[body] + TIP_M * pose[:, 2]
        error = np.concatenate((hand - tip, sum(np.cross(pose[:, k], LEVEL[:, k]) for k in range(3)) / 2))
        mujoco.mj_jac(model, data, place, turn, tip, body)
        jacobian = np.vstack((place, turn))[:, columns]
        angles += 0.5 * jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-4 * np.eye(6), error)
        angles = np.clip(angles, *limits)
    return angles


def open_drawer(model: Any, bar: Floats) -> Any:
    """MjData once the drawer has been pulled out: to the bar, fingers closed, back again."""
    data = mujoco.MjData(model)
    joints = [f"arm_joint{k}" for k in range(1, 8)]
    far, near = angles_for(model, np.array(HOME), bar - (0, 0.12, 0)), angles_for(model, np.array(HOME), bar)
    for name, angle in zip(joints, far, strict=True):
        data.joint(name).qpos = angle
    here, width = far, 0.04

    def move(to: Floats, fingers: float, seconds: float) -> None:
        nonlocal here, width
        steps = int(seconds / model.opt.timestep)
        for share in np.linspace(0.0, 1.0, steps):
            at, gap = here + share * (to - here), width + share * (fingers - width)
            for name, angle in zip(joints, at, strict=True):
                data.actuator(name).ctrl = angle
            data.actuator("arm_hand_finger_joint1").ctrl, data.actuator("arm_hand_finger_joint2").ctrl = gap, -gap
            mujoco.mj_step(model, data)
        here, width = to, fingers

    move(near, 0.04, 1.5)
    move(near, 0.0, 0.5)
    for step in np.linspace(0.0, PULL_M, 25)[1:]:
        move(angles_for(model, here, bar - (0, step, 0)), 0.0, 0.2)
    return data


def main() -> None:
    if len(sys.argv) != 3 or not Path(sys.argv[1]).is_file():
        sys.exit(f"usage: python {Path(__file__).name} FOLDER/panda/robot.xml PICTURE; the first comes with robosuite")
    panda, picture = Path(sys.argv[1]), Path(sys.argv[2])
    kitchen = casa.kitchen("l_small", "coastal").to_mjspec()
    empty = kitchen.compile()
    at = mujoco.MjData(empty)
    mujoco.mj_kinematics(empty, at)
    bar = at.geom(HANDLE).xpos.copy()
    model = arm_before(kitchen, bar, panda)
    data = open_drawer(model, bar)
    opened = float(abs(data.joint(DRAWER).qpos[0]))
    print(f"{DRAWER} is open by {opened:.3f} m")
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = bar - (0, 0.35, 0.2), 1.9, 30.0, -20.0
    picture.parent.mkdir(parents=True, exist_ok=True)
    with mujoco.Renderer(model, 480, 720) as renderer:
        renderer.update_scene(data, camera)
        Image.fromarray(renderer.render()).save(picture)
    if opened < OPEN_M:
        sys.exit(1)


if __name__ == "__main__":
    main()
