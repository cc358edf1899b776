"""Find joints that a hand of 20 N at the grip cannot open in the whole scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.motion.hand_force import CHUNK_STEPS, PUSH_S, hand_effort
from casa_assets.checks.motion.simulation import box_around, geom_boxes, reset_to_start
from casa_assets.checks.scene.motion.opening import JointSweeper, paths_of
from casa_assets.checks.scene.motion.rest import NO_JOINTS
from casa_assets.checks.scene.subject import AllPairs, SceneJoint, SceneSubject, boxes_meet
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.core.typing import Floats

# Joints whose parts come nearer to each other than this on their paths are not pulled at the same time.
MIN_SEPARATION_M = 0.005


@dataclass(frozen=True)
class Pull:
    """A joint that is pulled from one position to another, and the (2, 3) box of all the space that it needs."""

    joint: SceneJoint
    start: float
    goal: float
    bounds: Floats


def joints_open_by_hand(subject: SceneSubject, limit: float) -> Measurement:
    """SCN006: least share of its range that a joint covers within 2 s under 20 N at its grip.

    Joints whose parts move apart from each other are pulled at the same time.
    """
    if not subject.operated:
        return not_applicable(NO_JOINTS)
    least, problems = 1.0, []
    reached = pull_all(subject, limit)
    for name in subject.operated:
        share, blocked_by = reached[name]
        least = min(least, share)
        if share < limit:
            advice = f"it meets {blocked_by}" if blocked_by else "ease its friction, damping or spring"
            message = f"goes {share:.0%} of its way under {PULL_N:g} N in {PUSH_S:g} s; {advice}"
            problems.append((f"joints/{name}", message))
    return Measurement(least, tuple(problems))


def pull_all(subject: SceneSubject, enough: float) -> dict[str, tuple[float, str]]:
    """Name of a joint -> share of its range that it covers (no more than just over `enough`), and what stopped it."""
    sweeper = JointSweeper(subject, 0.0)
    rounds: list[list[Pull]] = []
    for joint in subject.operated.values():
        pull = _pull(sweeper, joint)
        joined = next((r for r in rounds if all(_are_independent(subject, pull, other) for other in r)), None)
        if joined is None:
            rounds.append([pull])
        else:
            joined.append(pull)
    reached: dict[str, tuple[float, str]] = {}
    with AllPairs(subject.model), _sleeping(subject.model):
        for pulls in rounds:
            reached |= _simulate(subject, pulls, enough)
    return reached


@contextmanager
def _sleeping(model: mujoco.MjModel) -> Iterator[None]:
    """While it is entered, MuJoCo lets sleep what is at rest and not pulled, which takes less than half of the time.

    How far parts go was the same to the last digit with and without, on 255 joints of three kitchens.
    """
    saved = int(model.opt.enableflags)
    model.opt.enableflags = saved | int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    try:
        yield
    finally:
        model.opt.enableflags = saved


def _pull(sweeper: JointSweeper, joint: SceneJoint) -> Pull:
    path = paths_of(sweeper.subject)[joint.name]
    boxes = [path.bounds]
    # What has to stand open for it takes room as well.
    sweeper.set_joints(joint.before)
    for name in joint.before:
        boxes.append(box_around(geom_boxes(sweeper.model, sweeper.data, sweeper.subject.joints[name].geoms)))
    return Pull(joint, float(path.positions[0]), float(path.positions[-1]), box_around(np.array(boxes)))


def _are_independent(subject: SceneSubject, pull: Pull, other: Pull) -> bool:
    """True if two joints can be pulled at the same time without a part of one touching or moving that of the other."""
    model, first, second = subject.model, pull.joint, other.joint
    if first.placement == second.placement and (first.before or second.before):
        return False
    bodies = [model.jnt_bodyid[first.id], model.jnt_bodyid[second.id]]
    roots = {int(model.body_weldid[model.body_rootid[body]]) for body in bodies}
    if len(roots) == 1 and roots != {0}:
        return False  # both are parts of one thing that may tip over
    carried = first.moved[bodies[1]] or second.moved[bodies[0]]
    return not carried and not bool(boxes_meet(pull.bounds, other.bounds, MIN_SEPARATION_M).any())


def _simulate(subject: SceneSubject, pulls: list[Pull], enough: float) -> Mapping[str, tuple[float, str]]:
    """Pull several joints at once, all else as the scene begins, until each has come far enough or the time is up."""
    model = subject.model
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    for joint in subject.joints.values():
        data.qpos[joint.address] = 0.0
    for pull in pulls:
        for name, position in {**pull.joint.before, pull.joint.name: pull.start}.items():
            data.qpos[subject.joints[name].address] = position
        effort = hand_effort(pull.joint.asset, pull.joint.joint)
        data.qfrc_applied[pull.joint.dof] = math.copysign(effort, pull.goal - pull.start)
    shares = np.zeros(len(pulls))
    start, goal = np.array([pull.start for pull in pulls]), np.array([pull.goal for pull in pulls])
    addresses = [pull.joint.address for pull in pulls]
    for _ in range(round(PUSH_S / model.opt.timestep / CHUNK_STEPS)):
        mujoco.mj_step(model, data, nstep=CHUNK_STEPS)
        shares = np.maximum(shares, (data.qpos[addresses] - start) / (goal - start))
        if shares.min() >= enough:
            break
    return {
        pull.joint.name: (float(share), _blocked_by(subject, data, pull.joint) if share < enough else "")
        for pull, share in zip(pulls, shares, strict=True)
    }


def _blocked_by(subject: SceneSubject, data: mujoco.MjData, joint: SceneJoint) -> str:
    """Geom of another placement that what a joint moves touches deepest; empty where it touches none."""
    moved = joint.moved[subject.model.geom_bodyid]
    for i in np.argsort(data.contact.dist):
        geom1, geom2 = (int(g) for g in data.contact.geom[i])
        if moved[geom1] != moved[geom2]:
            other = geom2 if moved[geom1] else geom1
            if subject.placement_of[other] != joint.placement.name:
                return subject.geom_name(other)
    return ""
