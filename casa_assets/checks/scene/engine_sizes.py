"""Batch form -> sizes of the buffers that a GPU engine needs for it, found by simulating what happens in a kitchen."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, at_most
from casa_assets.checks.motion.joints import hand_effort
from casa_assets.checks.motion.simulation import open_end, reset_to_start
from casa_assets.checks.readers.mujoco_facts import all_warnings
from casa_assets.checks.scene.light_forms import BATCH_FILE, REST_S, BatchSubject, candidate_pairs
from casa_assets.core.numeric import Floats, Ints
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.kitchen.scene import EngineSizes, Placement
from casa_assets.model.pose import Pose

# Seconds that each fixture is pulled at all its handles while things fall, and without them; steps between two counts
# of pairs.
TRIAL_S, IN_USE_S, PAIR_STEPS = 10.0, 3.0, 50
SLEEP_STEPS = 15  # steps within which what is at rest falls asleep
MARGIN = 1.5  # engines get this many times what is found, which is never exceeded in the trials
# Ten things are dropped in front of the fixture, from here above its grips, and this far apart, metres.
DROPPED, DROP_M, SPACING_M = 10, 0.4, 0.14
# A stand-in of a mobile robot waits so far in front of the grips, metres: a base that drives, and an arm of six joints.
ROBOT_AT_M, BASE_HALF_M, LINK_M, ARM_JOINTS = 0.85, (0.22, 0.18, 0.15), 0.18, 6
# Its joints are driven by torques and forces that swing once in SWING_S, N*m and N.
SWING_S, ARM_NM, DRIVE_N = 2.5, 12.0, 40.0
# So many of its joints drive it along the floor.
DRIVEN = 2
ROBOT, THING = "robot_stand_in", "dropped_thing"


# Pairs of shapes that engines collide by a general convex routine and not by a formula. Ref: mujoco_warp 4.0.
_BOX, _CYLINDER, _CAPSULE = (
    int(kind) for kind in (mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE)
)
CONVEX_PAIRS = frozenset(
    tuple(sorted(pair)) for pair in ((_BOX, _BOX), (_CYLINDER, _BOX), (_CYLINDER, _CYLINDER), (_CAPSULE, _CYLINDER))
)


@dataclass
class _Most:
    contacts: int = 0
    rows: int = 0
    convex: int = 0
    awake: int = 0
    memory: int = 0

    def count(self, data: mujoco.MjData) -> None:
        """Take in the present state."""
        self.contacts, self.rows = max(self.contacts, int(data.ncon)), max(self.rows, int(data.nefc))
        self.awake = max(self.awake, int(data.nv_awake))
        self.memory = max(self.memory, int(data.nbuffer) + int(data.maxuse_arena))


def engine_sizes(subject: BatchSubject) -> EngineSizes:
    """Simulate each fixture in use and count contacts, constraint rows, convex pairs and degrees of freedom awake.

    For each fixture, once everything sleeps: 20 N at the grips of all its joints at once for 10 s, while ten things
    fall in front of it and a simplified mobile robot moves there. Then without the things, for 3 s, to count the
    degrees of freedom that are awake in use. Raises ValueError: MuJoCo cannot read the batch form.
    """
    if subject.batch.model is None:
        raise ValueError(subject.batch.error)
    stressed, in_use = _Most(), _Most()
    assets = subject.form.scene.asset_of
    forms = zip(subject.form.scene.placements, subject.form.forms, strict=True)
    fixtures = ((place, form.joints) for place, form in forms if form.base is Base.FIXED and form.joints)
    pulled = [_Used(place, assets[place.name], frozenset(joint.name for joint in joints)) for place, joints in fixtures]
    # MuJoCo warns where the stand-in touches what should sleep at the start.
    with all_warnings():
        model = subject.batch.model
        data = mujoco.MjData(model)
        reset_to_start(model, data)
        mujoco.mj_step(model, data, nstep=round(REST_S / model.opt.timestep))
        at_rest = {str(model.joint(number).name): data.joint(number).qpos.copy() for number in range(model.njnt)}
        for used in pulled:
            _simulate(subject, at_rest, used, stressed, with_things=True)
            _simulate(subject, at_rest, used, in_use, with_things=False)
    most = {"nconmax": stressed.contacts, "njmax": stressed.rows, "nccdmax": stressed.convex, "nvmax": stressed.awake}
    return EngineSizes(
        **{name: 8 * math.ceil(max(number, 1) * MARGIN / 8) for name, number in most.items()},
        contacts=stressed.contacts,
        rows=stressed.rows,
        convex_pairs=stressed.convex,
        awake=stressed.awake,
        awake_in_use=in_use.awake,
        fixtures=len(pulled),
        mujoco_bytes=stressed.memory,
    )


class _Used(NamedTuple):
    """A fixture that is used, and the names of its joints that are not locked."""

    place: Placement
    asset: Asset
    joints: frozenset[str]


def _stand(used: _Used) -> tuple[Floats, Floats]:
    """Where hands are at a fixture, and the way out of it into the room; (3,) and (3,), world frame, metres."""
    place, asset, _ = used
    grips = {joint.grip for joint in asset.joints}
    held = ((link.name, c.pose) for link in asset.links for c in link.colliders if c.name in grips)
    found = [(place.pose @ asset.asset_from_link(link) @ pose).position for link, pose in held]
    middle = np.mean(found, axis=0) if found else np.add(place.pose.position, (0.0, 0.0, 0.9))
    # A fixture faces -y.
    return np.asarray(middle, dtype=np.float64), place.pose.rotation @ np.array([0.0, -1.0, 0.0])


def _simulate(
    subject: BatchSubject, at_rest: Mapping[str, Floats], used: _Used, most: _Most, with_things: bool
) -> None:
    """Use one fixture in a kitchen whose joints are `at_rest`, and asleep; `most` takes in the numbers."""
    stand = _stand(used)
    spec = mujoco.MjSpec.from_file(str(subject.root / BATCH_FILE))
    _add_robot(spec, *stand)
    if with_things:
        _add_things(spec, *stand)
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, positions in at_rest.items():
        first = int(model.joint(name).qposadr[0])
        data.qpos[first : first + len(positions)] = positions
    mujoco.mj_step(model, data, nstep=SLEEP_STEPS)
    for joint in used.asset.joints:
        if joint.name in used.joints:
            dof = int(model.jnt_dofadr[model.joint(f"{used.place.name}__{joint.name}").id])
            data.qfrc_applied[dof] = math.copysign(hand_effort(used.asset, joint), open_end(joint))
    names = [str(model.joint(number).name) for number in range(model.njnt)]
    robot = [int(model.jnt_dofadr[number]) for number, name in enumerate(names) if name.startswith(ROBOT)]
    convex = _convex_pairs(model)
    for step in range(round((TRIAL_S if with_things else IN_USE_S) / model.opt.timestep)):
        swing = math.sin(2 * math.pi * step * model.opt.timestep / SWING_S)
        for number, dof in enumerate(robot):
            strength = DRIVE_N if number < DRIVEN else ARM_NM
            data.qfrc_applied[dof] = strength * (swing if number % 2 else -swing)
        mujoco.mj_step(model, data)
        most.count(data)
        if step % PAIR_STEPS == 0:
            most.convex = max(most.convex, _near(model, data, convex))


def _add_robot(spec: mujoco.MjSpec, grip: Floats, out: Floats) -> None:
    """A base that slides and turns, and an arm, in front of a grip."""
    at = grip + ROBOT_AT_M * out
    yaw = Pose.from_matrix(np.column_stack([-out, np.cross([0.0, 0.0, 1.0], -out), [0.0, 0.0, 1.0]]))
    body = spec.worldbody.add_body(name=ROBOT, pos=[at[0], at[1], BASE_HALF_M[2] + 0.02], quat=yaw.quaternion)
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    for name, kind, axis in (("x", slide, (1, 0, 0)), ("y", slide, (0, 1, 0)), ("yaw", hinge, (0, 0, 1))):
        body.add_joint(name=f"{ROBOT}_{name}", type=kind, axis=axis, damping=[60.0, 0.0, 0.0])
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=BASE_HALF_M, mass=40.0)
    column = grip[2] - BASE_HALF_M[2] - 0.02
    link = body.add_body(pos=[0.1, 0.0, max(column, BASE_HALF_M[2])])
    for number in range(ARM_JOINTS):
        axis = (0, 0, 1) if number % 2 == 0 else (0, 1, 0)
        link.add_joint(name=f"{ROBOT}_{number}", type=hinge, axis=axis, damping=[3.0, 0.0, 0.0], range=[-1.2, 1.2])
        link.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0.02, 0, 0, LINK_M - 0.02, 0, 0], size=[0.03, 0, 0], mass=1.0
        )
        link = link.add_body(pos=[LINK_M, 0.0, 0.0])
    link.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.04, 0.06, 0.02], mass=0.3)


def _add_things(spec: mujoco.MjSpec, grip: Floats, out: Floats) -> None:
    """Ten boxes, cylinders and balls above the edge of a fixture, half of them over it and half in front of it."""
    across = np.cross([0.0, 0.0, 1.0], out)
    kinds = (mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_SPHERE)
    for number in range(DROPPED):
        row, column = divmod(number, DROPPED // 2)
        at = grip + (0.15 - 0.3 * row) * out + SPACING_M * (column - 2) * across + [0.0, 0.0, DROP_M]
        body = spec.worldbody.add_body(name=f"{THING}_{number}", pos=at)
        body.add_freejoint(name=f"{THING}_{number}_free")
        body.add_geom(type=kinds[number % 3], size=[0.04, 0.05, 0.03], mass=0.3)


def _convex_pairs(model: mujoco.MjModel) -> Ints:
    """(P, 2) pairs of geoms that a general convex routine has to look at."""
    pairs = np.argwhere(candidate_pairs(model))
    kinds = np.sort(model.geom_type[pairs], axis=1).tolist()
    return pairs[[tuple(pair) in CONVEX_PAIRS for pair in kinds]]


def _near(model: mujoco.MjModel, data: mujoco.MjData, pairs: Ints) -> int:
    turns, (first, second) = data.geom_xmat.reshape(-1, 3, 3), pairs.T
    half = np.abs(turns) @ model.geom_aabb[:, 3:, None]
    middle = data.geom_xpos + np.einsum("gij,gj->gi", turns, model.geom_aabb[:, :3])
    reach = half[first, :, 0] + half[second, :, 0]
    return int((~(np.abs(middle[first] - middle[second]) > reach).any(axis=1)).sum())


def few_are_awake_in_use(sizes: EngineSizes, limit: float) -> Measurement:
    """BAT010: degrees of freedom that are awake with a robot and one fixture in use."""
    message = f"{sizes.awake_in_use} degrees of freedom are awake; look for what leans on what is opened"
    return at_most(float(sizes.awake_in_use), limit, BATCH_FILE, message)
