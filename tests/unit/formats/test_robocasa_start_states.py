"""Start states in RoboCasa's terms: names of joints, frames of what is loose, how an environment is reset to them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from casa_assets.addons.robocasa.run import classes
from casa_assets.addons.robocasa.writers import casa_kitchens
from casa_assets.addons.robocasa.writers.kitchens import description
from casa_assets.addons.robocasa.writers.kitchens.start_states import translated
from casa_assets.layouts.run.state_file import write_states
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.scene import Placement, Scene, StartStates
from casa_assets.model.pose import Pose
from tests.support.asset.family_members import preset
from tests.support.kitchen.rooms import at, block
from tests.support.kitchen.scenes import QUARTER

NAME, NUMBER = "test_room", 1_000_000_007
DRAWER, DIAL = "stack_1__drawer1_slidejoint", "kettle__lid_joint"
MOVED = Pose(position=(0.3, 0.4, 1.2), quaternion=(0.6, 0.0, 0.8, 0.0))


@cache
def scene() -> Scene:
    """A stack of drawers, a loose box whose frame is at its foot, and a loose kettle, which RoboCasa fixes."""
    unit, kettle = preset("drawer_stack", "navy_cups_four"), preset("kettle", "gooseneck_steel")
    box = block("box", (0.1, 0.06, 0.08), Base.FREE)
    return Scene(
        id=NAME,
        assets=(unit, box, kettle),
        placements=(
            Placement(name="stack_1", asset=unit.id, pose=Pose(position=(1.0, 2.0, 0.0), quaternion=QUARTER)),
            Placement(name="box", asset=box.id, pose=at(0.1, 0.2, 0.9)),
            Placement(name="kettle", asset=kettle.id, pose=at(0.5, 0.2, 0.9)),
        ),
    )


def states() -> StartStates:
    """Two: the second has a drawer open and the box elsewhere."""
    names = [*(f"stack_1__drawer{k}_slidejoint" for k in range(4)), "box__free", "kettle__free"]
    joints, address = [], 0
    for name in names:
        width = 7 if name.endswith("__free") else 1
        joints.append({"name": name, "address": address, "width": width})
        address += width
    rows = np.zeros((2, address))
    rows[:, 4:11] = (0.1, 0.2, 0.9, 1.0, 0.0, 0.0, 0.0)
    rows[:, 11:18] = (0.5, 0.2, 0.9, 1.0, 0.0, 0.0, 0.0)
    rows[1, 1] = 0.25
    rows[1, 4:11] = (*MOVED.position, *MOVED.quaternion)
    return StartStates.model_validate(
        {
            "key": "k",
            "scene": NAME,
            "scene_xml": "0" * 64,
            "mujoco": "4.0.0",
            "seed": 0,
            "limits": (0.001, 0.005),
            "envelope": [],
            "joints": joints,
            "notes": [{"placed": {}, "parked": "box"}] * 2,
            "qpos": rows,
            "base": [[1.0, 2.0, 0.0], [0.5, -1.0, 2.5]],
            "depth": [0.0] * 2,
            "motion": [0.0] * 2,
        }
    )


@cache
def in_robocasa() -> StartStates:
    return translated(states(), scene(), description.fixtures_of(scene(), classes()))


def test_joints_are_called_as_in_the_model_and_keep_their_numbers() -> None:
    found = {joint.name: in_robocasa().qpos[:, joint.address].tolist() for joint in in_robocasa().joints}
    assert found["unit_1_drawer1_slidejoint"] == [0.0, 0.25]
    assert found["unit_1_drawer0_slidejoint"] == [0.0, 0.0]
    assert not any("kettle" in name and "joint0" in name for name in found), "RoboCasa fixes it"


def test_what_is_loose_is_where_its_fixture_would_be() -> None:
    (joint,) = (joint for joint in in_robocasa().joints if joint.width == 7)
    assert joint.name == "box_joint0"
    placements = tuple(p.replace(pose=MOVED) if p.name == "box" else p for p in scene().placements)
    for row, where in enumerate((scene(), scene().replace(placements=placements))):
        wanted = next(item.pose for item in description.fixtures_of(where, classes()) if item.name == "box")
        found = in_robocasa().qpos[row, joint.address : joint.address + 7]
        assert found.tolist() == pytest.approx([*wanted.position, *wanted.quaternion], abs=1e-6)


class Model:
    """What robosuite adds to an MjModel, as far as it is used."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def joint_id2name(self, number: int) -> str:
        return str(self._model.joint(number).name)

    def joint_name2id(self, name: str) -> int:
        return int(self._model.joint(name).id)


class Data:
    """The same for an MjData."""

    def __init__(self, data: mujoco.MjData) -> None:
        self.qpos, self.qvel, self.body_xpos, self.body_xmat = data.qpos, data.qvel, data.xpos, data.xmat


def environment() -> Any:
    """A model with the joints of the states behind those of a base that turns about a point behind its frame."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody>
        <body name="root" pos="10 10 0" euler="0 0 90"><body name="base">
          <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
          <joint name="mobilebase0_joint_mobile_forward" type="slide" axis="1 0 0" pos="-0.21 0 0"/>
          <joint name="mobilebase0_joint_mobile_side" type="slide" axis="0 1 0" pos="-0.21 0 0"/>
          <joint name="mobilebase0_joint_mobile_yaw" axis="0 0 1" pos="-0.21 0 0"/>
          <site name="axis" pos="-0.21 0 0"/></body></body>
        <body name="box"><freejoint name="box_joint0"/><geom size="0.1"/></body>"""
        + "".join(
            f'<body><joint name="unit_1_drawer{k}_slidejoint" type="slide"/><geom size="0.1"/></body>' for k in range(4)
        )
        + "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    sim = SimpleNamespace(model=Model(model), data=Data(data), forward=lambda: mujoco.mj_kinematics(model, data))
    return SimpleNamespace(sim=sim, layout_id=NUMBER, raw=(model, data))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A kitchen that is registered, with its start states."""
    place = tmp_path / NAME
    place.mkdir()
    rows = [
        {"name": "box", "lid_of": "", "position": [0.1, 0.2, 0.94], "quaternion": [1, 0, 0, 0], "is_standing": False}
    ]
    (place / "kitchen.json").write_text(json.dumps({"fixtures": rows}), encoding="ascii")
    monkeypatch.setitem(casa_kitchens._kitchens, NUMBER, place)
    monkeypatch.setitem(casa_kitchens._numbers, NAME, NUMBER)
    write_states(place, in_robocasa())
    yield place
    casa_kitchens.begin_with(None)
    casa_kitchens._states.clear()


def test_a_reset_puts_everything_where_it_was_and_parks_the_base(folder: Path) -> None:
    env = environment()
    _, data = env.raw
    data.qvel[:] = 1.0
    casa_kitchens.reset_to(env, 1)
    assert data.joint("unit_1_drawer1_slidejoint").qpos[0] == pytest.approx(0.25)
    assert data.joint("box_joint0").qpos[:2].tolist() != [0.0, 0.0]
    assert data.body("base").xpos[:2].tolist() == pytest.approx([0.5, -1.0])
    ahead = data.body("base").xmat.reshape(3, 3)[:2, 0]
    assert ahead.tolist() == pytest.approx([np.cos(2.5), np.sin(2.5)])
    assert not data.qvel.any()
    casa_kitchens.reset_to(env, 0, parks=False)
    assert data.joint("unit_1_drawer1_slidejoint").qpos[0] == 0.0
    assert data.body("base").xpos[:2].tolist() == pytest.approx([0.5, -1.0])
    with pytest.raises(IndexError):
        casa_kitchens.reset_to(env, 2)


def test_fixtures_begin_where_a_state_has_them(folder: Path) -> None:
    rows = json.loads((folder / "kitchen.json").read_text())["fixtures"]
    rng = np.random.default_rng(0)
    assert casa_kitchens._begun(rows, folder, rng) == rows
    casa_kitchens.begin_with(1)
    (row,) = casa_kitchens._begun(rows, folder, rng)
    assert row["is_standing"]
    assert row["position"][0] == pytest.approx(MOVED.position[0] + 0.04 * 0.96, abs=1e-3)
    casa_kitchens.begin_with("random")
    assert len({tuple(casa_kitchens._begun(rows, folder, rng)[0]["position"]) for _ in range(20)}) == 2
    casa_kitchens.begin_with(None)
    assert casa_kitchens._begun(rows, folder, rng) == rows
