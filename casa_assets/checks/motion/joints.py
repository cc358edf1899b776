"""Find joints that a hand cannot move, that do not return, stop short or run into something (KIN001 to KIN010)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.check import (
    Package,
)
from casa_assets.checks.motion import simulation
from casa_assets.checks.readers import mujoco_facts
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.core.numeric import Mask
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Sphere
from casa_assets.model.issue import Files

# Nobody turns harder than this: the cap of 20 N*m on what 20 N do at a long lever.
MAX_TORQUE_NM = 20.0
MIN_LEVER_M = 0.005  # fingers are no finer
PUSH_S = 2.0
CHUNK_STEPS = 20  # steps between two looks at the position
DRIFT_S = 5.0
STILL_M, STILL_RAD = 0.001, math.radians(0.5)  # drift that is granted to a short range, by kind of joint
# Labels of grips that are turned at their rim: the lever is the radius, wherever the middle of the grip is.
KNOB_LABELS = frozenset({"knob", "seat", "roll"})
SPRUNG_LABELS = frozenset({"button", "lever", "key", "knob"})
# A contact counts where it is this much deeper than that of the same two shapes at rest. Our choice: what soft contacts
# forgive.
EXTRA_DEPTH_M = 0.001
FULL_SHARE = 0.95  # share of its range that counts as all of it, as reach_share in registry/limits.yaml
POSES = 48  # poses of a sweep: enough for a corner of a door of 0.6 m to go 20 mm between two
# Step while another part stands open: only the two moved parts can meet in a new way. They are large, so that steps may
# be wider than `sweep.STEP_M`.
PAIR_STEP_M = 0.025


def joints_open_by_hand(package: Package, limit: float) -> check.Measurement:
    """KIN001: least share of a joint's range covered under 20 N in 2 s, both ways, with contacts.

    A joint that does not go so far without contacts either is reported by `joints_open_by_hand_without_contacts`.
    """
    return _least_reach(package, limit, contact=True)


def joints_open_by_hand_without_contacts(package: Package, limit: float) -> check.Measurement:
    """KIN002: least share of a joint's range covered under 20 N in 2 s, both ways, without contacts."""
    return _least_reach(package, limit, contact=False)


def starting_force_is_moderate(package: Package, limit: float, min_force_n: float) -> check.Measurement:
    """KIN003: force at the grip that starts each closed joint, `min_force_n` to `limit`; the largest, N.

    Doors and drawers are meant to take 5 N and more, so that they stay shut; a key or a roll may be lighter.
    """
    motion = simulation.motion_model_of(package)
    problems, worst = [], 0.0
    data = mujoco.MjData(motion.contactless)
    for joint in package.asset.joints:
        force = starting_force(motion, data, package.asset, joint)
        worst = max(worst, force)
        if force > limit:
            problems.append((f"joints/{joint.name}", f"needs {force:.1f} N at its grip to start; ease its friction"))
        elif force <= 0:
            problems.append((f"joints/{joint.name}", f"opens by itself: {-force:.1f} N would hold it shut"))
        elif force < min_force_n:
            problems.append((f"joints/{joint.name}", f"starts at {force:.2g} N; give it friction or a spring"))
    return check.Measurement(worst, tuple(problems))


def keys_spring_back(package: Package, limit: float) -> check.Measurement:
    """KIN004: worst share of its stroke that a pressed key is away from rest 2 s after release."""
    motion, asset = simulation.motion_model_of(package), package.asset
    shares = {}
    data = mujoco.MjData(motion.model)
    for joint in asset.joints:
        if not _is_sprung(asset, joint):
            continue
        end = simulation.open_end(joint)
        simulation.set_joints(motion.model, data, {**simulation.open_before(asset, joint), joint.name: end})
        mujoco.mj_step(motion.model, data, nstep=int(PUSH_S / simulation.STEP_S))
        # A light key that is held against its stop stands a little beyond it, which does not count as away from rest.
        away = max(0.0, float(data.qpos[motion.address[joint.name]]) / end) * abs(end)
        shares[f"joints/{joint.name}"] = away / (joint.range[1] - joint.range[0])
    message = "keeps {:.0%} of its stroke when it is let go"
    return check.all_at_most(shares, limit, message, "it has no key that springs back")


def joints_rest_in_range(package: Package, limit: float) -> check.Measurement:
    """KIN010: how far a joint is outside its range once it has been left alone for 2 s, closed; rad or m."""
    motion, asset = simulation.motion_model_of(package), package.asset
    data = mujoco.MjData(motion.model)
    simulation.set_joints(motion.model, data, {})
    mujoco.mj_step(motion.model, data, nstep=int(PUSH_S / simulation.STEP_S))
    beyond = {}
    for joint in asset.joints:
        at, (low, high) = float(data.qpos[motion.address[joint.name]]), joint.range
        beyond[f"joints/{joint.name}"] = max(low - at, at - high, 0.0)
    message = "stands {:.2g} rad or m outside its range; stiffen its limit"
    return check.all_at_most(beyond, limit, message, check.NO_JOINTS)


def joints_stay_put(package: Package, limit: float) -> check.Measurement:
    """KIN006: worst share of its range that a joint drifts in 5 s, closed and in each named pose.

    A short range counts as one of which `limit` is 1 mm or half a degree: stops are soft, and a light key yields.
    """
    motion, asset = simulation.motion_model_of(package), package.asset
    rows, data = [], mujoco.MjData(motion.model)
    poses: dict[str, dict[str, float]] = {"rest": {}}
    poses |= {key.name: {at.joint: at.value for at in key.joints} for key in asset.keyframes if key.joints}
    for name, pose in poses.items():
        simulation.set_joints(motion.model, data, pose)
        start = data.qpos.copy()
        mujoco.mj_step(motion.model, data, nstep=int(DRIFT_S / simulation.STEP_S))
        for joint in asset.joints:
            if pose.get(joint.name) and _is_sprung(asset, joint):
                continue  # it is meant to go back
            address = motion.address[joint.name]
            still = STILL_RAD if joint.kind is JointKind.HINGE else STILL_M
            span = max(joint.range[1] - joint.range[0], still / limit)
            share = abs(float(data.qpos[address] - start[address])) / span
            rows.append((f"joints/{joint.name}", share, f"drifts by {share:.1%} of its range in 5 s ({name})"))
    return check.worst_above(rows, limit)


def hand_effort(asset: Asset, joint: Joint) -> float:
    """Generalized force of a 20 N hand at a joint: N along a slide; N*m at a hinge, at right angles to the lever.

    A knob is turned by two fingers that share the 20 N, each at the rim: 20 N at its radius.
    """
    if joint.kind is JointKind.SLIDE:
        return PULL_N
    arm = simulation.lever_arm(asset, joint)
    if _grip_label(asset, joint) in KNOB_LABELS:
        arm = max(arm, _radius(asset, joint))
    return min(PULL_N * max(arm, MIN_LEVER_M), MAX_TORQUE_NM)


def _least_reach(package: Package, limit: float, contact: bool) -> check.Measurement:
    motion, asset = simulation.motion_model_of(package), package.asset
    problems, least = [], 1.0
    data = mujoco.MjData(motion.model if contact else motion.contactless)
    for joint in asset.joints:
        for opening in (True, False):
            if not opening and _is_sprung(asset, joint):
                continue
            share = _reach(motion, data, asset, joint, opening, limit)
            if contact and share < limit:
                without_contacts = mujoco.MjData(motion.contactless)
                if _reach(motion, without_contacts, asset, joint, opening, limit) < limit:
                    continue
            least = min(least, share)
            if share < limit:
                way = "open" if opening else "shut"
                advice = "make room for it" if contact else "ease its friction, damping or spring"
                message = f"goes {share:.0%} of its way {way} under {PULL_N:g} N in {PUSH_S:g} s; {advice}"
                problems.append((f"joints/{joint.name}", message))
    return check.Measurement(least, tuple(problems))


def _reach(
    motion: simulation.MotionModel, data: mujoco.MjData, asset: Asset, joint: Joint, opening: bool, enough: float
) -> float:
    """Share of its range that a joint covers, up to `enough`, under a steady push from one end, others left alone."""
    low, high = joint.range
    end = simulation.open_end(joint)
    closed = low if end == high else high
    start, goal = (closed, end) if opening else (end, closed)
    simulation.set_joints(data.model, data, {**simulation.open_before(asset, joint), joint.name: start})
    data.qfrc_applied[motion.dof[joint.name]] = math.copysign(hand_effort(asset, joint), goal - start)
    return push(data, motion.address[joint.name], start, goal, enough)


def push(data: mujoco.MjData, address: int, start: float, goal: float, enough: float) -> float:
    """Simulate a force for 2 s, or until a joint at `address` in qpos has covered `enough`; the share of its way."""
    best = 0.0
    for _ in range(round(PUSH_S / data.model.opt.timestep / CHUNK_STEPS)):
        mujoco.mj_step(data.model, data, nstep=CHUNK_STEPS)
        best = max(best, (float(data.qpos[address]) - start) / (goal - start))
        if best >= enough:
            break
    return best


def starting_force(motion: simulation.MotionModel, data: mujoco.MjData, asset: Asset, joint: Joint) -> float:
    """Force at the grip that just starts a closed joint to open, N; negative where it opens by itself."""
    simulation.set_joints(motion.contactless, data, simulation.open_before(asset, joint))
    mujoco.mj_forward(motion.contactless, data)
    dof = motion.dof[joint.name]
    sign = math.copysign(1.0, simulation.open_end(joint))
    opening_force = sign * float(data.qfrc_passive[dof] - data.qfrc_bias[dof])
    arm = 1.0 if joint.kind is JointKind.SLIDE else hand_effort(asset, joint) / PULL_N
    return (joint.frictionloss - opening_force) / arm


def _grip_label(asset: Asset, joint: Joint) -> str:
    """Label of the collider that a hand takes of a joint; empty where it has none."""
    return next((c.label or "" for k in asset.links for c in k.colliders if c.name == joint.grip), "")


def _is_sprung(asset: Asset, joint: Joint) -> bool:
    """True if a joint is a key that goes back by itself when a finger lets it go."""
    return joint.drive is not None and _grip_label(asset, joint) in SPRUNG_LABELS


def _radius(asset: Asset, joint: Joint) -> float:
    """Distance that a knob's shapes reach from its axis, metres."""
    axis, reach = np.array(joint.axis), 0.0
    for collider in asset.link(joint.child).colliders:
        shape = collider.shape
        if isinstance(shape, Cylinder | Capsule | Sphere):
            reach = max(reach, shape.radius)
        elif isinstance(shape, Box):
            reach = max(reach, sorted(shape.size)[1] / 2)
        else:
            points = collider.pose.apply(shape.mesh.vertices) - np.array(joint.anchor)
            reach = max(reach, float(np.linalg.norm(points - np.outer(points @ axis, axis), axis=1).max()))
    return reach


@dataclass(frozen=True)
class JointTravel:
    """Travel of one joint: share of its range before a contact is over 1 mm deeper than at rest, and with which body.

    `pushed_share`: share of its range to which 20 N take it in 2 s, with the model as the file is written.
    """

    joint: str
    free_share: float
    blocked_by: str
    pushed_share: float

    @property
    def is_full(self) -> bool:
        """True if it goes all of its range, touching nothing."""
        return self.free_share >= 1.0 and self.pushed_share >= FULL_SHARE

    @property
    def message(self) -> str:
        """How far it goes, in words that follow its name."""
        if self.free_share < 1.0:
            return f"goes {self.free_share:.0%} of its range, then runs into {self.blocked_by}"
        return f"goes {self.pushed_share:.0%} of its range under 20 N"


def joints_reach_full_range(package: Package, limit: float) -> check.Measurement:
    """KIN009: share of the joints of a mesh that move over their full range under 20 N without collision."""
    asset = package.asset
    if not asset.joints or check.is_from_family(asset):
        built = "it was built from numbers, and KIN001 holds it to more"
        return check.not_applicable(built if asset.joints else check.NO_JOINTS)
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return check.not_run(check.NO_COMPILE)
    travels = joint_travels(asset, package.mjcf)
    share = sum(t.is_full for t in travels) / len(travels)
    short = [t for t in travels if not t.is_full] if share < limit else []
    return check.Measurement(share, tuple((f"joints/{t.joint}", t.message) for t in short))


def joint_travels(asset: Asset, model: Path | Files, pushed: bool = True) -> tuple[JointTravel, ...]:
    """Travel of every joint of an asset, in its order. Raises ValueError: MuJoCo cannot read the file.

    `pushed`: also move each by force; else `pushed_share` is as `free_share`.
    """
    spec = simulation.motion_spec(model)
    as_written = spec.compile()
    for pair in list(spec.excludes):
        spec.delete(pair)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    all_pairs = spec.compile()
    travels = []
    for joint in asset.joints:
        free, blocked_by = _free_share(all_pairs, asset, joint)
        share = free
        if pushed:
            data, end = mujoco.MjData(as_written), simulation.open_end(joint)
            simulation.set_joints(as_written, data, simulation.open_before(asset, joint))
            number = int(as_written.joint(joint.name).id)
            data.qfrc_applied[as_written.jnt_dofadr[number]] = math.copysign(hand_effort(asset, joint), end)
            share = push(data, int(as_written.jnt_qposadr[number]), 0.0, end, FULL_SHARE)
        travels.append(JointTravel(joint.name, free, blocked_by, share))
    return tuple(travels)


def _free_share(model: mujoco.MjModel, asset: Asset, joint: Joint) -> tuple[float, str]:
    """Share of the range before the first contact that is not there at rest, and the name of the other body."""
    data = mujoco.MjData(model)
    joint_id = int(model.joint(joint.name).id)
    moved = simulation.moved_by(model, joint_id)
    simulation.set_joints(model, data, simulation.open_before(asset, joint))
    at_rest = _depths(model, data, moved)
    end = simulation.open_end(joint)
    for i in range(1, POSES + 1):
        data.qpos[model.jnt_qposadr[joint_id]] = end * i / POSES
        for pair, depth in sorted(_depths(model, data, moved).items()):
            if depth > at_rest.get(pair, 0.0) + EXTRA_DEPTH_M:
                other = next(g for g in pair if not moved[model.geom_bodyid[g]])
                return (i - 1) / POSES, str(model.body(int(model.geom_bodyid[other])).name)
    return 1.0, ""


def _depths(model: mujoco.MjModel, data: mujoco.MjData, moved: Mask) -> dict[tuple[int, int], float]:
    """Depth of each penetrating pair of a moved and another geom, metres, > 0."""
    simulation.find_contacts(model, data)
    geoms, distances = data.contact.geom, data.contact.dist
    bodies = model.geom_bodyid[geoms]
    counted = (moved[bodies[:, 0]] != moved[bodies[:, 1]]) & (distances < 0) & (bodies > 0).all(axis=1)
    depths: dict[tuple[int, int], float] = {}
    for row in np.flatnonzero(counted):
        pair = (int(geoms[row, 0]), int(geoms[row, 1]))
        depths[pair] = max(depths.get(pair, 0.0), -float(distances[row]))
    return depths


def moving_parts_keep_clear(package: Package, limit: float) -> check.Measurement:
    """KIN005: deepest contact of a part over any joint's range, alone and with each other joint open; metres."""
    motion = simulation.motion_model_of(package)
    rows = []
    for joint in package.asset.joints:
        contact, open_joint = _deepest_contact(motion, package.asset, joint)
        while_open = f" while {open_joint} stands open" if open_joint else ""
        sinks = f"{contact.geom1} sinks {contact.depth:.4f} m into {contact.geom2}{while_open}"
        rows.append((f"joints/{joint.name}", contact.depth, f"{sinks}; make room between them"))
    return check.worst_above(rows, limit)


def _deepest_contact(motion: simulation.MotionModel, asset: Asset, joint: Joint) -> tuple[simulation.Penetration, str]:
    """The deepest contact over all sweeps of a joint, and the other joint that was open in it, or an empty name."""
    model, joint_id = motion.with_margins, int(motion.model.joint(joint.name).id)
    data = mujoco.MjData(model)
    positions = simulation.open_before(asset, joint)
    simulation.set_joints(model, data, positions)
    moved, everything = simulation.moved_by(model, joint_id), np.ones(model.nbody, dtype=bool)
    alone = simulation.sweep(model, data, joint_id, everything)
    worst, open_joint = alone.worst, ""
    for other in asset.joints:
        before = simulation.open_before(asset, other)
        # What needs this joint open cannot be out while it moves.
        if other.name == joint.name or other.name in positions or joint.name in before:
            continue
        moved_by_other = simulation.moved_by(model, int(motion.model.joint(other.name).id))
        simulation.set_joints(model, data, {**positions, **before, other.name: simulation.open_end(other)})
        # What carries this joint along takes it away from the rest.
        if moved_by_other[model.jnt_bodyid[joint_id]]:
            continue
        # A part that it carries, such as a latch, changes its outline, so that it is swept against everything.
        carried = bool(moved[moved_by_other].any())
        if not carried:
            mujoco.mj_kinematics(model, data)
            geoms = np.flatnonzero(moved_by_other[model.geom_bodyid])
            lower, upper = simulation.box_around(simulation.geom_boxes(model, data, geoms))
            if (lower > alone.bounds[1]).any() or (upper < alone.bounds[0]).any():
                continue
        contact = simulation.sweep(model, data, joint_id, everything if carried else moved_by_other, PAIR_STEP_M).worst
        if contact.depth > worst.depth:
            worst, open_joint = contact, other.name
    return worst, open_joint
