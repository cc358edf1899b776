"""Scene -> isaac_lab.py, which describes the moving parts of scene.usda and their dynamics for Isaac Lab.

It was not run with Isaac Lab: a test compiles the file and compares its numbers with the scene. Its names and units are
those of Isaac Lab 2.3 with Isaac Sim 5: quaternions (w, x, y, z), dry friction of a joint as an effort.

Ref: Isaac Lab, isaaclab.assets.ArticulationCfg, isaaclab.actuators.ImplicitActuatorCfg.
"""

from __future__ import annotations

import json
import keyword
from collections.abc import Iterator

from casa_assets.core.numeric import decimals
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import START_POSE, Placement, Scene
from casa_assets.model.pose import Pose

FILE = "isaac_lab.py"
# Members that a scene of Isaac Lab has by itself, and the one that holds all of ours.
RESERVED = frozenset(
    {
        *("kitchen", "robot", "num_envs", "env_spacing", "lazy_sensor_update", "replicate_physics"),
        *("filter_collisions", "clone_in_fabric"),
    }
)
HEAD = '''"""Kitchen {id} for Isaac Lab 2.3 with Isaac Sim 5.

Written by casa-assets from the record that scene.usda was written from. Not run with Isaac Lab: a test compiles this
file and compares its numbers with the record. Keep it beside scene.usda.

    scene = InteractiveScene(KitchenSceneCfg(num_envs=2, env_spacing=12.0))  # add a robot in a subclass
    hold_springs(scene)  # after each reset

Metres, radians, newtons, newton metres; quaternions (w, x, y, z), which Isaac Lab 3 wants as (x, y, z, w). Friction of
a joint is an effort from Isaac Sim 5 on, and a coefficient without a unit before.
"""

from pathlib import Path

import isaaclab.sim as sim_utils
import torch
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg, AssetBaseCfg, RigidObjectCfg
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass

KITCHEN = "{{ENV_REGEX_NS}}/Kitchen"
# Of each joint: where it starts; stiffness and damping of its spring; dry friction; viscous friction; armature.
COLUMNS = ("start", "stiffness", "damping", "friction", "viscous_friction", "armature")
# Where springs rest, which may be beyond the range of the joint: fixture -> joint -> rad or m.
SPRING_RESTS = {rests}


def _fixture(name, pos, rot, joints):
    """What has joints, where its base stands; it comes with the kitchen, so that nothing is spawned."""
    of = {{word: {{joint: row[i] for joint, row in joints.items()}} for i, word in enumerate(COLUMNS)}}
    return ArticulationCfg(
        prim_path=f"{{KITCHEN}}/{{name}}",
        spawn=None,
        init_state=ArticulationCfg.InitialStateCfg(pos=pos, rot=rot, joint_pos=of["start"]),
        actuators={{
            "joints": ImplicitActuatorCfg(
                joint_names_expr=list(joints),
                stiffness=of["stiffness"],
                damping=of["damping"],
                friction=of["friction"],
                dynamic_friction=of["friction"],
                viscous_friction=of["viscous_friction"],
                armature=of["armature"],
            )
        }},
    )


def _loose(name, pos, rot):
    """What is one body and can be taken away."""
    state = RigidObjectCfg.InitialStateCfg(pos=pos, rot=rot)
    return RigidObjectCfg(prim_path=f"{{KITCHEN}}/{{name}}/object", spawn=None, init_state=state)


def hold_springs(scene):
    """Aim the springs of a scene at where they rest; Isaac Lab would aim them at zero."""
    for name, rests in SPRING_RESTS.items():
        fixture = scene[name]
        joints, _ = fixture.find_joints(list(rests), preserve_order=True)
        target = torch.tensor([list(rests.values())] * scene.num_envs, device=scene.device)
        fixture.set_joint_position_target(target, joint_ids=joints)


@configclass
class KitchenSceneCfg(InteractiveSceneCfg):
    """The kitchen, and by name each fixture with joints and each thing that is loose."""

    kitchen = AssetBaseCfg(
        prim_path=KITCHEN,
        spawn=sim_utils.UsdFileCfg(
            usd_path=str(Path(__file__).resolve().parent / "{usd}"), variants={{"pose": "{pose}"}}
        ),
    )
'''


def scene_text(scene: Scene, usd: str) -> str:
    """Return the configuration as Python source; the same scene gives the same text.

    Args:
        scene: the scene of the USD.
        usd: file name of the USD.
    """
    assets = scene.asset_of
    rests = {
        attribute(place.name): {j.name: j.drive.target for j in assets[place.name].joints if j.drive is not None}
        for place in scene.placements
    }
    lines = [HEAD.format(id=scene.id, usd=usd, pose=START_POSE, rests=_table({k: v for k, v in rests.items() if v}))]
    for place in scene.placements:
        asset = assets[place.name]
        if asset.joints:
            lines += _fixture(place, asset)
        elif asset.base is Base.FREE and len(asset.links) == 1:
            pos, rot = _stands(place.pose @ asset.root.pose)
            lines.append(f'    {attribute(place.name)} = _loose("{place.name}", {pos}, {rot})\n')
    return "".join(lines)


def attribute(placement: str) -> str:
    """Name of a placement as a member of the scene in Isaac Lab."""
    return f"{placement}_" if keyword.iskeyword(placement) or placement in RESERVED else placement


def _fixture(place: Placement, asset: Asset) -> Iterator[str]:
    pos, rot = _stands(place.pose @ asset.root.pose)
    yield f'    {attribute(place.name)} = _fixture(\n        "{place.name}",\n'
    yield f"        {pos},\n        {rot},\n        joints={{\n"
    starts = joint_positions(place.joints)
    for joint in asset.joints:
        spring = (joint.drive.stiffness, joint.drive.damping) if joint.drive is not None else (0.0, 0.0)
        row = (starts.get(joint.name, 0.0), *spring, joint.frictionloss, joint.damping, joint.armature)
        yield f'            "{joint.name}": {row!r},\n'
    yield "        },\n    )\n"


def _stands(pose: Pose) -> tuple[str, str]:
    """The two arguments for the pose of a body, to twelve digits: the last ones differ between processors."""
    position, rotation = (tuple(decimals(c, 12) for c in row) for row in (pose.position, pose.quaternion))
    return f"pos={position!r}", f"rot={rotation!r}"


def _table(rows: dict[str, dict[str, float]]) -> str:
    """Source of a dictionary of dictionaries, one row for each."""
    return "{\n" + "".join(f'    "{name}": {json.dumps(row)},\n' for name, row in rows.items()) + "}" if rows else "{}"
