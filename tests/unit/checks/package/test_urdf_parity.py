"""URDF means what the asset means, and what says otherwise is told cell by cell."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.readers.urdf_facts import asset_differences
from casa_assets.checks.scene.formats import scene_differences
from casa_assets.core.numeric import about_axis
from casa_assets.formats import urdf
from casa_assets.formats.urdf import roll_pitch_yaw
from casa_assets.model.asset.asset import Asset
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, microwave, write_to
from tests.support.asset.packages import tamper
from tests.support.kitchen.scenes import corner

ASSETS = [*EVERY, grill]


def put(asset: Asset, folder: Path) -> Path:
    """Path of its URDF in a folder."""
    return write_to(urdf.write(asset), folder) / f"{asset.id}.urdf"


@pytest.mark.parametrize("build", ASSETS)
def test_what_is_read_back_is_the_asset(build: Callable[[], Asset], tmp_path: Path) -> None:
    assert asset_differences(put(build(), tmp_path), build()) == []


def test_roll_pitch_and_yaw_turn_as_the_pose_does(subtests: pytest.Subtests) -> None:
    for pitch in [0.0, 0.4, math.pi / 2, -math.pi / 2, math.pi / 2 - 1e-7]:
        with subtests.test(pitch=pitch):
            x, y, z = np.eye(3)
            matrix = about_axis(z, 0.7) @ about_axis(y, pitch) @ about_axis(x, -1.1)
            angles = zip(np.eye(3), roll_pitch_yaw(Pose.from_matrix(matrix)), strict=True)
            turns = [about_axis(axis, angle) for axis, angle in angles]
            assert turns[2] @ turns[1] @ turns[0] == pytest.approx(matrix, abs=1e-7)


# What is changed in the URDF of a microwave, and the cell that then differs.
CHANGES = [
    ('<mass value="9"/>', '<mass value="9.1"/>', "bodies/object/mass"),
    ('ixx="0.1758"', 'ixx="0.18"', "bodies/object/inertia"),
    ('<origin xyz="0 0.01 0.15"', '<origin xyz="0 0.02 0.15"', "bodies/object/center_of_mass"),
    ('<origin xyz="-0.24 -0.21 0.15"', '<origin xyz="-0.24 -0.2 0.15"', "bodies/door/position"),
    ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>', "bodies/door/joint/axis"),
    ('lower="-1.57079633"', 'lower="-1.5"', "bodies/door/joint/range"),
    ('damping="0.5"', 'damping="0.6"', "bodies/door/joint/resistance"),
    ('friction="0.3"', 'friction="0.2"', "bodies/door/joint/resistance"),
    ('type="revolute"', 'type="prismatic"', "bodies/door/joint/kind"),
    ('<box size="0.5 0.38 0.02"/>', '<box size="0.6 0.38 0.02"/>', "bodies/object/upper"),
    ('<collision name="back_0">', '<collision name="other">', "cannot be read"),
    ('<origin xyz="0 0.02 0" rpy="0 0 0"/>', '<origin xyz="0 0.03 0" rpy="0 0 0"/>', "visuals/door_main"),
    ('rgba="0.247800528', 'rgba="0.3', "cannot be read"),
    ('<link name="door">', '<link name="flap">', "cannot be read"),
]
ASIDE = [
    (["exclusions"], [], "exclusions"),
    (["joints", "microjoint", "armature"], 0.5, "bodies/door/joint/resistance"),
    (["colliders", "door_0", "dynamic_friction"], 0.1, "bodies/door/frictions"),
    (["base"], "free", "base"),
    (["states"], [], "states"),
]


def test_a_changed_urdf_or_json_is_told(subtests: pytest.Subtests, tmp_path: Path) -> None:
    for old, new, cell in CHANGES:
        with subtests.test(old=old, new=new, cell=cell):
            path = put(microwave(), tmp_path)
            tamper(path, (old, new))
            assert any(cell in f"{pointer}: {message}" for pointer, message in asset_differences(path, microwave()))
    for place, value, cell in ASIDE:
        with subtests.test(place=place, value=value, cell=cell):
            path = put(microwave(), tmp_path)
            aside = json.loads(path.with_suffix(".json").read_text())
            at = aside
            for key in place[:-1]:
                at = at[key]
            at[place[-1]] = value
            path.with_suffix(".json").write_text(json.dumps(aside))
            assert cell in [pointer for pointer, _ in asset_differences(path, microwave())]


@pytest.mark.parametrize(
    ("pattern", "new", "cell"),
    [
        (r'(<child link="oven"/>\s*<origin xyz=")1 ', r"\g<1>1.01 ", "scene.urdf/oven/position"),
        (r'(<child link="unit"/>\s*<origin xyz="[^"]*" rpy="[^"]*) [^ "]*"', r'\g<1> 0"', "scene.urdf/unit/quaternion"),
        (r'(<joint name="grill__knob_joint".*?upper=")', r"\g<1>9", "scene.urdf/grill/"),
    ],
)
def test_a_changed_scene_is_told(pattern: str, new: str, cell: str, tmp_path: Path) -> None:
    folder = write_to(urdf.write_scene(corner()), tmp_path)
    changed, count = re.subn(pattern, new, (folder / urdf.FILE).read_text(), count=1, flags=re.DOTALL)
    assert count == 1
    (folder / urdf.FILE).write_text(changed)
    assert any(pointer.startswith(cell) for pointer, _ in scene_differences(folder, corner()))


def test_a_scene_is_what_was_written_and_a_changed_list_is_told(tmp_path: Path) -> None:
    folder = write_to(urdf.write_scene(corner()), tmp_path)
    assert scene_differences(folder, corner()) == []
    listed = json.loads((folder / urdf.LIST).read_text())
    listed["placements"][0]["joints"] = {"microjoint": -0.5}
    listed["placements"][6]["position"][2] += 0.01
    del listed["placements"][-1]
    (folder / urdf.LIST).write_text(json.dumps(listed))
    pointers = [pointer for pointer, _ in scene_differences(folder, corner())]
    assert pointers == ["scene.json/placements", "scene.json/oven/joints", "scene.json/mug/position"]
