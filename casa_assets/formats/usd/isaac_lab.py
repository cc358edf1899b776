"""Scene -> isaac_lab.py, which describes the moving parts of scene.usda and their dynamics for Isaac Lab.

It was not run with Isaac Lab: a test compiles the file and compares its numbers with the scene. Its names and units are
those of Isaac Lab 2.3 with Isaac Sim 5: quaternions (w, x, y, z), dry friction of a joint as an effort.

Ref: Isaac Lab, isaaclab.assets.ArticulationCfg, isaaclab.actuators.ImplicitActuatorCfg.
"""

from __future__ import annotations

import json
import keyword
from collections.abc import Iterator
from importlib.resources import files
from string import Template

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
# The head of the file, up to the kitchen's own fixtures.
HEAD = "isaac_lab_head.txt"


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
    head = Template(files("casa_assets.formats.usd").joinpath(HEAD).read_text(encoding="utf-8"))
    springs = _table({name: row for name, row in rests.items() if row})
    lines = [head.substitute(id=scene.id, usd=usd, pose=START_POSE, rests=springs)]
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
