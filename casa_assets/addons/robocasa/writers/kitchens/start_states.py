"""Start states of a scene, converted to the joint names and body frames of RoboCasa's model of the kitchen."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from casa_assets.addons.robocasa.writers.kitchens.description import Placed, is_free
from casa_assets.core.numeric import Floats
from casa_assets.model.kitchen.scene import FREE_JOINT, Scene, StartStates, StateJoint
from casa_assets.model.pose import Pose

# robosuite numbers the joints that a model is given; those of a fixture out of a file keep their names.
FREE_SUFFIX = "joint0"


def translated(states: StartStates, scene: Scene, fixtures: Collection[Placed]) -> StartStates:
    """Convert the states to a model of RoboCasa; joints that it does not have are left out.

    Appliances that are loose in the scene are fixed in RoboCasa, at their pose in the scene.

    Args:
        scene: scene of the states.
        fixtures: result of `fixtures_of`.
    """
    columns: list[tuple[str, Floats]] = []
    for item in fixtures:
        whole = {joint.child: joint.name for joint in scene.asset_of[item.placement.name].joints}
        links = {name: link for link, name in item.part.links.items()}
        for joint in item.centered.joints:
            values = _values(states, f"{item.placement.name}__{whole[links[joint.child]]}")
            if values is not None:
                columns.append((f"{item.name}_{joint.name}", values))
    for item in fixtures:
        values = _values(states, f"{item.placement.name}__{FREE_JOINT}") if is_free(item) else None
        if values is None:
            continue
        asset_from_root = scene.asset_of[item.placement.name].root.pose
        # Into the frames that fixtures have in RoboCasa.
        root_from_fixture = asset_from_root.inverse() @ item.placement.pose.inverse() @ item.pose
        rows = []
        for x, y, z, *quaternion in values.tolist():
            turn = np.array(quaternion) / np.linalg.norm(quaternion)
            pose = Pose(position=(x, y, z), quaternion=turn.tolist()) @ root_from_fixture
            rows.append((*pose.position, *pose.quaternion))
        columns.append((f"{item.name}_{FREE_SUFFIX}", np.array(rows)))
    joints, address = [], 0
    for name, values in columns:
        joints.append(StateJoint.model_validate({"name": name, "address": address, "width": values.shape[1]}))
        address += values.shape[1]
    return states.replace(joints=tuple(joints), qpos=np.concatenate([values for _, values in columns], axis=1))


def _values(states: StartStates, name: str) -> Floats | None:
    """(states, width) numbers of a joint of the scene, or None if the states do not have it."""
    found = next((joint for joint in states.joints if joint.name == name), None)
    return None if found is None else states.qpos[:, found.address : found.address + found.width].astype(np.float64)
