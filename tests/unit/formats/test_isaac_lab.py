"""The configuration for Isaac Lab, which is not installed: its source compiles, and its numbers are the scene's."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from casa_assets.formats.usd import isaac_lab
from casa_assets.formats.usd.kitchen import write
from casa_assets.model.asset.parts import joint_positions
from tests.support.kitchen.scenes import corner, put


class Config(SimpleNamespace):
    """Keeps what a configuration of Isaac Lab is made with; so do those inside of it."""

    InitialStateCfg = SimpleNamespace


@pytest.fixture
def members(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """Members of the file that the scene gives, run with stand-ins for Isaac Lab that keep their arguments."""
    stand_ins: dict[str, dict[str, Any]] = {
        "torch": {},
        "isaaclab": {},
        "isaaclab.sim": {"UsdFileCfg": Config},
        "isaaclab.actuators": {"ImplicitActuatorCfg": Config},
        "isaaclab.assets": dict.fromkeys(("ArticulationCfg", "AssetBaseCfg", "RigidObjectCfg"), Config),
        "isaaclab.scene": {"InteractiveSceneCfg": object},
        "isaaclab.utils": {"configclass": lambda kind: kind},
    }
    for name, content in stand_ins.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
        if "." in name:
            setattr(sys.modules["isaaclab"], name.split(".")[1], module)
    path = put(write(corner()), tmp_path, corner()) / isaac_lab.FILE
    found: dict[str, Any] = {"__file__": str(path), "__name__": "isaac_lab"}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), found)
    return found


def test_its_numbers_are_those_of_the_record(members: dict[str, Any]) -> None:
    scene, kitchen = corner(), members["KitchenSceneCfg"]
    for place in scene.placements:
        asset = scene.asset_of[place.name]
        if not asset.joints:
            continue
        fixture = getattr(kitchen, place.name)
        world_from_base = place.pose @ asset.root.pose
        assert fixture.init_state.pos == pytest.approx(world_from_base.position, abs=1e-11)
        assert fixture.init_state.rot == pytest.approx(world_from_base.quaternion, abs=1e-11)
        starts, (motor,) = joint_positions(place.joints), fixture.actuators.values()
        assert motor.joint_names_expr == [joint.name for joint in asset.joints]
        for joint in asset.joints:
            assert fixture.init_state.joint_pos[joint.name] == starts.get(joint.name, 0.0)
            assert motor.friction[joint.name] == motor.dynamic_friction[joint.name] == joint.frictionloss
            assert (motor.viscous_friction[joint.name], motor.armature[joint.name]) == (joint.damping, joint.armature)
            spring = (joint.drive.stiffness, joint.drive.damping) if joint.drive else (0.0, 0.0)
            assert (motor.stiffness[joint.name], motor.damping[joint.name]) == spring
            rests = members["SPRING_RESTS"].get(place.name, {})
            assert rests.get(joint.name) == (joint.drive.target if joint.drive else None)
