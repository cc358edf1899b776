"""Poses in which things rest: on all sides of a box, not on the tip of a cone; they stay so in MuJoCo."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

import casa_assets as casa
from casa_assets.formats import mjcf
from casa_assets.model.asset.parts import Cylinder
from tests.support.asset.assets import rigid_mug, write_to
from tests.support.asset.box_assets import plain_box


def test_a_box_rests_on_its_six_sides_mostly_on_the_largest() -> None:
    found = casa.stable_poses(plain_box((0.1, 0.2, 0.3)), least=0.0)
    assert len(found) == 6
    assert sum(one.probability for one in found) == pytest.approx(1.0, abs=1e-3)
    lying = [one for one in found if abs(one.pose.rotation[2, 0]) > 0.99]  # x, the shortest side, is up or down
    assert {round(one.probability, 6) for one in lying} == {round(found[0].probability, 6)}
    for one in found:
        corners = one.pose.apply(np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.1, 0.1) for z in (0.0, 0.3)]))
        assert corners[:, 2].min() == pytest.approx(0.0, abs=1e-9)
        assert corners[:, :2].mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_round_side_of_a_can_is_a_few_poses_and_rare_ones_are_left_out() -> None:
    box = plain_box((0.06, 0.06, 0.1))
    (body,) = box.root.colliders
    can = box.replace(links=(box.root.replace(colliders=(body.replace(shape=Cylinder(radius=0.03, height=0.1)),)),))
    ends = [one for one in casa.stable_poses(can, least=0.0) if abs(one.pose.rotation[2, 2]) > 0.99]
    assert len(ends) == 2
    assert len(casa.stable_poses(can, least=0.0)) <= 2 + math.ceil(2 * math.pi / np.radians(10.0))
    assert all(one.probability >= 0.1 for one in casa.stable_poses(can, least=0.1))


def test_a_mug_stays_in_each_of_its_poses(tmp_path: Path) -> None:
    mug = rigid_mug()
    model = mujoco.MjModel.from_xml_path(str(write_to(mjcf.write(mug), tmp_path) / "scene.xml"))
    data = mujoco.MjData(model)
    poses = casa.stable_poses(mug, least=0.1)
    assert poses
    for one in poses:
        mujoco.mj_resetData(model, data)
        data.qpos[:3], data.qpos[3:7] = one.pose.position, one.pose.quaternion
        mujoco.mj_forward(model, data)
        before = data.xmat[model.body("object").id].reshape(3, 3)[2].copy()
        mujoco.mj_step(model, data, nstep=round(2.0 / model.opt.timestep))
        after = data.xmat[model.body("object").id].reshape(3, 3)[2]
        assert math.degrees(math.acos(min(1.0, float(before @ after)))) < 12.0, one
