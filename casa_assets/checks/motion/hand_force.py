"""Find joints that a hand of 20 N cannot move, that do not return, or that drift (KIN001 to KIN006)."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.motion.motion_model import (
    STEP_S,
    MotionModel,
    lever,
    motion_model_of,
    open_before,
    open_end,
    why_no_motion_model,
)
from casa_assets.checks.package.package import Package
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Sphere

# Nobody turns harder than this: the cap of 20 N*m on what 20 N do at a long lever.
MOST_NM = 20.0
LEAST_LEVER_M = 0.005  # fingers are no finer
LONGEST_S = 2.0
CHUNK = 20  # steps between two looks
REST_S = 5.0
STILL_M, STILL_RAD = 0.001, math.radians(0.5)
# Turned at their rim: the lever is the radius, wherever the middle of the grip is.
KNOBS = frozenset({"knob", "seat", "roll"})
SPRUNG = frozenset({"button", "lever", "key", "knob"})


def joints_open_by_hand(package: Package, limit: float | None) -> Measurement:
    """KIN001: least share of a joint's range covered under 20 N in 2 s, both ways, with contacts.

    A joint that does not go so far when nothing touches is the business of `joints_open_by_hand_without_contacts`.
    """
    return _reached(package, limit, contact=True)


def joints_open_by_hand_without_contacts(package: Package, limit: float | None) -> Measurement:
    """KIN002: least share of a joint's range covered under 20 N in 2 s, both ways, without contacts."""
    return _reached(package, limit, contact=False)


def starting_force_is_moderate(package: Package, limit: float | None, least_n: float) -> Measurement:
    """KIN003: force at the grip that starts each closed joint, `least_n` to `limit`; the largest, N.

    Doors and drawers are meant to take 5 N and more, so that they stay shut; a key or a roll may be lighter.
    """
    assert limit is not None
    ready, asset = motion_model_of(package), package.asset
    if ready is None:
        return why_no_motion_model(package)
    problems, worst = [], 0.0
    data = mujoco.MjData(ready.free)
    for joint in asset.joints:
        force = starting_force(ready, data, asset, joint)
        worst = max(worst, force)
        if force > limit:
            problems.append((f"joints/{joint.name}", f"needs {force:.1f} N at its grip to start; ease its friction"))
        elif force <= 0:
            problems.append((f"joints/{joint.name}", f"opens by itself: {-force:.1f} N would hold it shut"))
        elif force < least_n:
            problems.append((f"joints/{joint.name}", f"starts at {force:.2g} N; give it friction or a spring"))
    return Measurement(worst, tuple(problems))


def keys_spring_back(package: Package, limit: float | None) -> Measurement:
    """KIN004: worst share of its stroke that a pressed key is away from rest 2 s after release."""
    assert limit is not None
    ready, asset = motion_model_of(package), package.asset
    if ready is None:
        return why_no_motion_model(package)
    problems, worst = [], None
    data = mujoco.MjData(ready.model)
    for joint in asset.joints:
        if not _is_sprung(asset, joint):
            continue
        _stand(ready, ready.model, data, {**open_before(asset, joint), joint.name: open_end(joint)})
        mujoco.mj_step(ready.model, data, nstep=int(LONGEST_S / STEP_S))
        # A light key that is held against its stop stands a little beyond it: what counts is what it keeps.
        left = (
            max(0.0, float(data.qpos[ready.address[joint.name]]) / open_end(joint)) * abs(open_end(joint)) / _way(joint)
        )
        worst = left if worst is None else max(worst, left)
        if left > limit:
            problems.append((f"joints/{joint.name}", f"keeps {left:.0%} of its stroke when it is let go"))
    return not_applicable("it has no key that springs back") if worst is None else Measurement(worst, tuple(problems))


def joints_stay_put(package: Package, limit: float | None) -> Measurement:
    """KIN006: worst share of its range that a joint drifts in 5 s, closed and in each named pose.

    A short range counts as one of which `limit` is 1 mm or half a degree: stops are soft, and a light key yields.
    """
    assert limit is not None
    ready, asset = motion_model_of(package), package.asset
    if ready is None:
        return why_no_motion_model(package)
    problems, worst = [], 0.0
    data = mujoco.MjData(ready.model)
    poses: dict[str, dict[str, float]] = {"rest": {}}
    poses |= {k.name: {at.joint: at.value for at in k.joints} for k in asset.keyframes}
    for name, pose in poses.items():
        if name != "rest" and not pose:
            continue
        _stand(ready, ready.model, data, pose)
        start = data.qpos.copy()
        mujoco.mj_step(ready.model, data, nstep=int(REST_S / STEP_S))
        for joint in asset.joints:
            if pose.get(joint.name) and _is_sprung(asset, joint):
                continue  # it is meant to go back
            at = ready.address[joint.name]
            still = STILL_RAD if joint.kind is JointKind.HINGE else STILL_M
            share = abs(float(data.qpos[at] - start[at])) / max(_way(joint), still / limit)
            worst = max(worst, share)
            if share > limit:
                problems.append((f"joints/{joint.name}", f"drifts by {share:.1%} of its range in 5 s ({name})"))
    return Measurement(worst, tuple(problems))


def hand_effort(asset: Asset, joint: Joint) -> float:
    """Generalized force of a 20 N hand at a joint: N along a slide; N*m at a hinge, at right angles to the lever.

    A knob is turned by two fingers that share the 20 N, each at the rim: 20 N at its radius.
    """
    arm = lever(asset, joint)
    if joint.kind is JointKind.SLIDE:
        return PULL_N
    if _label(asset, joint) in KNOBS:
        arm = max(arm, _radius(asset, joint))
    return min(PULL_N * max(arm, LEAST_LEVER_M), MOST_NM)


def _reached(package: Package, limit: float | None, contact: bool) -> Measurement:
    assert limit is not None
    ready, asset = motion_model_of(package), package.asset
    if ready is None:
        return why_no_motion_model(package)
    problems, least = [], 1.0
    model = ready.model if contact else ready.free
    data = mujoco.MjData(model)
    for joint in asset.joints:
        for opening in (True, False):
            if not opening and _is_sprung(asset, joint):
                continue
            share = _push(ready, model, data, asset, joint, opening, limit)
            if contact and share < limit and _is_stiff(ready, asset, joint, opening, limit):
                continue
            least = min(least, share)
            if share < limit:
                way = "open" if opening else "shut"
                why = "make room for it" if contact else "ease its friction, damping or spring"
                message = f"goes {share:.0%} of its way {way} under {PULL_N:g} N in {LONGEST_S:g} s; {why}"
                problems.append((f"joints/{joint.name}", message))
    return Measurement(least, tuple(problems))


def _is_stiff(ready: MotionModel, asset: Asset, joint: Joint, opening: bool, limit: float) -> bool:
    """True if a joint stops short even when nothing touches."""
    data = mujoco.MjData(ready.free)
    return _push(ready, ready.free, data, asset, joint, opening, limit) < limit


def _push(
    ready: MotionModel,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    asset: Asset,
    joint: Joint,
    opening: bool,
    enough: float,
) -> float:
    """Share of its range that a joint covers under a steady push from one end, all others left alone."""
    low, high = joint.range
    end = open_end(joint)
    other = low if end == high else high
    start, goal = (other, end) if opening else (end, other)
    _stand(ready, model, data, {**open_before(asset, joint), joint.name: start})
    data.qfrc_applied[ready.dof[joint.name]] = math.copysign(hand_effort(asset, joint), goal - start)
    at = ready.address[joint.name]
    best = 0.0
    for _ in range(int(LONGEST_S / STEP_S / CHUNK)):
        mujoco.mj_step(model, data, nstep=CHUNK)
        best = max(best, (float(data.qpos[at]) - start) / (goal - start))
        if best >= enough:
            break
    return best


def starting_force(ready: MotionModel, data: mujoco.MjData, asset: Asset, joint: Joint) -> float:
    """Force at the grip that just starts a closed joint to open, N; negative where it opens by itself."""
    _stand(ready, ready.free, data, open_before(asset, joint))
    mujoco.mj_forward(ready.free, data)
    dof = ready.dof[joint.name]
    sign = math.copysign(1.0, open_end(joint))
    helps = sign * float(data.qfrc_passive[dof] - data.qfrc_bias[dof])
    effort = joint.frictionloss - helps
    arm = 1.0 if joint.kind is JointKind.SLIDE else hand_effort(asset, joint) / PULL_N
    return effort / arm


def _stand(ready: MotionModel, model: mujoco.MjModel, data: mujoco.MjData, pose: dict[str, float]) -> None:
    mujoco.mj_resetData(model, data)
    for name, value in pose.items():
        data.qpos[ready.address[name]] = value


def _way(joint: Joint) -> float:
    return joint.range[1] - joint.range[0]


def _label(asset: Asset, joint: Joint) -> str:
    found = [c.label or "" for k in asset.links for c in k.colliders if c.name == joint.grip]
    return found[0] if found else ""


def _is_sprung(asset: Asset, joint: Joint) -> bool:
    """A key that goes back by itself: a spring, under a finger."""
    return joint.drive is not None and _label(asset, joint) in SPRUNG


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
