"""Put a robot together from its MJCF files: base, arm and gripper as one MjSpec."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from lxml import etree

from casa_assets.core.typing import Floats
from casa_assets.errors import CasaError
from casa_assets.model.kitchen.robot import Arm, Hand, Legs, Robot

ROOT = "robot"  # body that stands on the parking place, and turns and slides there
BASE_JOINTS = ("base_forward", "base_side", "base_yaw")
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TRUNK = "trunk"  # body and joint that legs lift, where they bend
GROUND_GAP_M = 0.002  # between the floor and the lowest point of the robot


def tip_name(arm: Arm, press: bool) -> str:
    """Name of the site between the fingers of an arm: x is where they close, z where the hand moves to."""
    return f"{arm.name}_{'press' if press else 'grasp'}"


def assemble(robot: Robot, models: Path) -> Any:
    """One MjSpec of a robot on the floor of its world, at the origin, facing along x.

    Only the three joints of its base and those of its home, legs and fingers are kept; the others are fixed at their
    positions. Geoms that are only visual are kept until the spec is compiled with `discardvisual`.

    Args:
        models: folder that holds the robot's files.
    Raises:
        CasaError: a file is missing or does not hold what the robot's description names.
    """
    spec = _stand(robot, models)
    for arm in robot.arms:
        body = spec.body(arm.body)
        if body is None:
            raise CasaError(f"robot {robot.id}: there is no body '{arm.body}' for its arm '{arm.name}'")
        for press in (False, True):
            hand = arm.press if press else arm.grasp
            body.add_site(name=tip_name(arm, press), pos=hand.point, quat=_frame(hand))
    _fix_joints(robot, spec)
    return spec


def finger_joints(robot: Robot) -> dict[str, float]:
    """Joints of all fingers -> where they are while the hands are open."""
    return {name: value for arm in robot.arms for name, value in arm.grasp.fingers.items()}


def leg_joints(robot: Robot) -> tuple[str, ...]:
    """Joints of legs that bend with the height of the trunk, and with nothing else."""
    return tuple(robot.legs.angles) if robot.legs else ()


def leg_angles(legs: Legs, heights: Floats) -> tuple[Floats, Floats]:
    """Angles of all joints of legs at heights of the trunk, and by how much they turn for each metre.

    Args:
        heights: of the joint `TRUNK`, any shape.
    Returns:
        Both with one axis more than the heights, along the joints.
    """
    cosine = np.clip(math.cos(legs.lean[0]) + heights / legs.length, -1.0, math.cos(legs.lean[0]))
    lean = np.arccos(cosine)[..., None]
    zero, turn = np.array(tuple(legs.angles.values())).T
    return zero + lean * turn, -turn / (legs.length * np.sin(lean))


def home_posture(robot: Robot, model: Any) -> Floats:
    """Positions of all joints of a model of `assemble` at rest, shape (nq,)."""
    q = np.zeros(model.nq)
    for name, value in _joints_at_rest(robot).items():
        q[model.joint(name).qposadr[0]] = value
    return q


def _joints_at_rest(robot: Robot) -> dict[str, float]:
    """All joints that move, and where they are at rest; those of the base, at zero, are left out."""
    legs = {}
    if robot.legs:
        if TRUNK not in robot.home:
            raise CasaError(f"robot {robot.id}: it has legs that bend, and its home does not name '{TRUNK}'")
        angles, _ = leg_angles(robot.legs, np.array(robot.home[TRUNK]))
        legs = dict(zip(robot.legs.angles, angles.tolist(), strict=True))
    return {**robot.home, **legs, **finger_joints(robot)}


def _stand(robot: Robot, models: Path) -> Any:
    """The robot's parts on three joints that move it over the floor."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    root = spec.worldbody.add_body(name=ROOT, mass=1.0, inertia=(1.0, 1.0, 1.0), explicitinertial=True)
    for name, axis in zip(BASE_JOINTS, AXES, strict=True):
        kind = mujoco.mjtJoint.mjJNT_HINGE if name == BASE_JOINTS[2] else mujoco.mjtJoint.mjJNT_SLIDE
        root.add_joint(name=name, type=kind, axis=axis, range=(-1.0, 1.0), limited=True)
    lifted = _lifted(root, robot.legs) if robot.legs else root
    for part in robot.parts:
        child = _read(robot, models / part.file)
        carrier = spec.body(part.onto) if part.onto else lifted
        if carrier is None:
            raise CasaError(f"robot {robot.id}: part '{part.name}' goes onto '{part.onto}', which no earlier part has")
        at = (0.0, 0.0, 0.0) if part.onto else (-robot.centre[0], -robot.centre[1], 0.0)
        spec.attach(child, prefix=f"{part.name}_", frame=carrier.add_frame(pos=at))
    return spec


def _lifted(root: Any, legs: Legs) -> Any:
    """A body that rises and sinks with the trunk of a robot whose legs bend; zero is where they lean least."""
    trunk = root.add_body(name=TRUNK, mass=1.0, inertia=(1.0, 1.0, 1.0), explicitinertial=True)
    lowest = legs.length * (math.cos(legs.lean[1]) - math.cos(legs.lean[0]))
    trunk.add_joint(
        name=TRUNK, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(0.0, 0.0, 1.0), range=(lowest, 0.0), limited=True
    )
    return trunk


def _read(robot: Robot, path: Path) -> Any:
    """A part at the origin, without actuators, sensors, cameras and the like, and without free joints and floors."""
    if not path.is_file():
        raise CasaError(f"{path}: robot {robot.id} needs this file, and it is not there; name the folder of the robots")
    try:
        spec = mujoco.MjSpec.from_string(_without_doubles(path))
    except (ValueError, etree.XMLSyntaxError) as error:
        raise CasaError(f"{path}: MuJoCo does not read this part of robot {robot.id}: {error}") from error
    spec.compiler.degree = False
    for group in (
        spec.actuators,
        spec.sensors,
        spec.tendons,
        spec.equalities,
        spec.keys,
        spec.cameras,
        spec.lights,
        spec.sites,
    ):
        for element in list(group):
            spec.delete(element)
    for joint in list(spec.joints):
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            spec.delete(joint)
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            spec.delete(geom)
    _forget_options(spec)
    for mesh in spec.meshes:
        mesh.file = str((path.parent / spec.meshdir / mesh.file).resolve())
    for body in spec.worldbody.bodies:
        body.pos = (0.0, 0.0, 0.0)
    return spec


def _without_doubles(path: Path) -> str:
    """Text of an MJCF file with each mesh named once: where robosuite's files name one twice, the first counts."""
    tree = etree.parse(str(path), etree.XMLParser(remove_comments=True, resolve_entities=False, no_network=True))
    seen: set[str] = set()
    for mesh in tree.findall(".//asset/mesh"):
        if mesh.get("name", mesh.get("file")) in seen:
            parent = mesh.getparent()
            assert parent is not None
            parent.remove(mesh)
        seen.add(mesh.get("name", mesh.get("file", "")))
    return etree.tostring(tree, encoding="unicode")


def _forget_options(spec: Any) -> None:
    """Options as MuJoCo has them by default: only the kitchen's count."""
    usual = mujoco.MjSpec().option
    for name in ("integrator", "cone", "impratio", "gravity", "timestep", "solver", "iterations", "enableflags"):
        setattr(spec.option, name, getattr(usual, name))


def _fix_joints(robot: Robot, spec: Any) -> None:
    """Delete every joint that does not move, its body turned to where it stays, and set the robot on the floor."""
    spec.compiler.discardvisual = True
    model = spec.compile()
    spec.compiler.discardvisual = False
    data = mujoco.MjData(model)
    names = {model.joint(i).name for i in range(model.njnt)}
    moving = _joints_at_rest(robot)
    for name in [*moving, *robot.fixed]:
        if name not in names:
            raise CasaError(f"robot {robot.id}: it has no joint '{name}'; it has {', '.join(sorted(names))}")
    data.qpos[:] = 0.0
    for name, value in {**moving, **robot.fixed}.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_kinematics(model, data)
    for joint in list(spec.joints):
        if joint.name in moving or joint.name in BASE_JOINTS:
            continue
        body = joint.parent
        at, above = model.body(body.name).id, model.body(model.body(body.name).parentid[0]).id
        turned, back = np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(back, data.xquat[above])
        mujoco.mju_mulQuat(turned, back, data.xquat[at])
        body.quat = turned
        body.pos = data.xmat[above].reshape(3, 3).T @ (data.xpos[at] - data.xpos[above])
        body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        spec.delete(joint)
    spec.body(ROOT).pos = (0.0, 0.0, GROUND_GAP_M - _lowest(model, data))


def _lowest(model: Any, data: Any) -> float:
    """Height of the lowest corner of the boxes around the geoms that touch something."""
    low = np.inf
    for i in range(model.ngeom):
        if model.geom_contype[i] or model.geom_conaffinity[i]:
            turn = data.geom_xmat[i].reshape(3, 3)
            centre = data.geom_xpos[i] + turn @ model.geom_aabb[i, :3]
            low = min(low, float(centre[2] - np.abs(turn[2]) @ model.geom_aabb[i, 3:]))
    return low


def _frame(hand: Hand) -> Floats:
    """Quaternion of the frame whose x is where fingers close and whose z is where the hand moves to."""
    z = np.array(hand.approach) / np.linalg.norm(hand.approach)
    x = np.array(hand.closing) - (np.array(hand.closing) @ z) * z
    x /= np.linalg.norm(x)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.stack([x, np.cross(z, x), z], axis=1).ravel())
    return quat
