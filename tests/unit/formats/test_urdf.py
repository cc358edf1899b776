"""URDF means what the asset means, and MuJoCo, which reads it too, agrees."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest
from lxml import etree

from casa_assets.checks.package.parity import asset_differences
from casa_assets.checks.readers import urdf_facts
from casa_assets.checks.readers.facts import asset_facts
from casa_assets.core.numeric import about_axis
from casa_assets.formats import urdf
from casa_assets.formats.urdf import roll_pitch_yaw
from casa_assets.model.asset.asset import Asset
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, drawer_unit, rigid_mug, write_to

ASSETS = [*EVERY, grill]


def put(asset: Asset, folder: Path) -> Path:
    """Path of its URDF in a folder."""
    return write_to(urdf.write(asset), folder) / f"{asset.id}.urdf"


@pytest.mark.parametrize("build", ASSETS)
def test_what_is_read_back_is_the_asset(build: Callable[[], Asset], tmp_path: Path) -> None:
    assert asset_differences(put(build(), tmp_path), build()) == []


@pytest.mark.parametrize("build", ASSETS)
def test_mujoco_reads_the_same_masses_joints_and_places(build: Callable[[], Asset], tmp_path: Path) -> None:
    asset = build()
    spec = mujoco.MjSpec.from_file(str(put(asset, tmp_path)))
    for mesh in spec.meshes:
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # flat prints have no volume
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for body in urdf_facts.on_joint_axes(asset_facts(asset)).bodies:
        index = model.body(body.name).id
        assert model.body_mass[index] == pytest.approx(body.mass, rel=1e-6)
        assert data.xpos[index] == pytest.approx(body.position, abs=1e-6)
        if body.joint is not None:
            joint = model.joint(body.joint.name)
            assert joint.range == pytest.approx(body.joint.range, abs=1e-6)
            assert joint.axis == pytest.approx(body.joint.axis, abs=1e-6)
            assert joint.damping[0] == pytest.approx(body.joint.resistance[2])
            assert joint.frictionloss[0] == pytest.approx(body.joint.resistance[3])


def test_a_capsule_is_a_cylinder_with_round_ends() -> None:
    asset = rigid_mug()
    root = etree.fromstring(urdf.write(asset).entries[f"{asset.id}.urdf"])
    shapes = {shape.get("name"): shape.find("geometry")[0].tag for shape in root.iter("collision")}
    assert {tag for name, tag in shapes.items() if name.startswith("grip")} <= {"cylinder", "sphere", "mesh"}
    for name in [name for name in shapes if name.endswith("__end0")]:
        base = name.removesuffix("__end0")
        assert (shapes[base], shapes[name], shapes[f"{base}__end1"]) == ("cylinder", "sphere", "sphere")


def test_what_urdf_cannot_say_is_beside_it() -> None:
    asset = drawer_unit()
    aside = json.loads(urdf.write(asset).entries[f"{asset.id}.json"])
    driven = next(joint for joint in asset.joints if joint.drive is not None)
    assert driven.drive is not None
    assert aside["joints"][driven.name]["spring"] == {
        "stiffness": driven.drive.stiffness,
        "rest": driven.drive.target,
    }
    assert {item["name"] for item in aside["regions"]} == {region.name for region in asset.regions}


def test_roll_pitch_and_yaw_turn_as_the_pose_does(subtests: pytest.Subtests) -> None:
    for pitch in [0.0, 0.4, math.pi / 2, -math.pi / 2, math.pi / 2 - 1e-7]:
        with subtests.test(pitch=pitch):
            x, y, z = np.eye(3)
            matrix = about_axis(z, 0.7) @ about_axis(y, pitch) @ about_axis(x, -1.1)
            turns = [
                about_axis(axis, angle)
                for axis, angle in zip(np.eye(3), roll_pitch_yaw(Pose.from_matrix(matrix)), strict=True)
            ]
            assert turns[2] @ turns[1] @ turns[0] == pytest.approx(matrix, abs=1e-7)
