"""Find joints that a hand of 20 N does not open in the batch form as far as it has to."""

from __future__ import annotations

import math

import mujoco

from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.motion.hand_force import CHUNK_STEPS, PUSH_S, hand_effort
from casa_assets.checks.motion.motion_model import open_before, open_end
from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.scene.batch.subject import UNREADABLE, BatchSubject
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.model.asset.asset import Asset, Base, Joint


def joints_open_by_hand(subject: BatchSubject, limit: float) -> Measurement:
    """BAT009: least share of its range that a joint of a fixture covers within 2 s under 20 N at its grip."""
    model = subject.batch.model
    if model is None:
        return not_run(UNREADABLE)
    locked = {(ref.placement, ref.joint) for ref in subject.form.locked}
    shares, problems = list[float](), list[tuple[str, str]]()
    assets = subject.form.scene.asset_of
    for place in subject.form.scene.placements:
        asset = assets[place.name]
        for joint in asset.joints:
            if asset.base is not Base.FIXED or place.resting is not None or (place.name, joint.name) in locked:
                continue
            share = _share(model, place.name, asset, joint, limit)
            shares.append(share)
            if share < limit:
                message = f"goes {share:.0%} of its way under {PULL_N:g} N in {PUSH_S:g} s in the batch form"
                problems.append((f"joints/{place.name}__{joint.name}", message))
    if not shares:
        return not_applicable("all joints of its fixtures are locked")
    return Measurement(min(shares), tuple(problems))


def _share(model: mujoco.MjModel, place: str, asset: Asset, joint: Joint, enough: float) -> float:
    """Share of its range that a joint covers, no more than just over `enough`."""
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    for name, position in {**open_before(asset, joint), joint.name: 0.0}.items():
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{place}__{name}")
        if number >= 0:
            data.qpos[model.jnt_qposadr[number]] = position
    number = model.joint(f"{place}__{joint.name}").id
    goal = open_end(joint)
    data.qfrc_applied[model.jnt_dofadr[number]] = math.copysign(hand_effort(asset, joint), goal)
    share = 0.0
    for _ in range(round(PUSH_S / model.opt.timestep / CHUNK_STEPS)):
        mujoco.mj_step(model, data, nstep=CHUNK_STEPS)
        share = max(share, float(data.qpos[model.jnt_qposadr[number]]) / goal)
        if share >= enough:
            break
    return share
