"""Pose of a placement -> overrides of the links and joints of the asset that it refers to."""

from __future__ import annotations

from pxr import Sdf

from casa_assets.export.usd import keyframe, number
from casa_assets.export.usd.joint import BASE_TO_WORLD, SCOPE
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import CLOSED_POSE, START_POSE
from casa_assets.model.pose import Pose


def variant(asset: Asset, pose: str) -> str | None:
    """Return the asset's variant that is nearest to a pose of the scene, or None if it has no variants."""
    if not asset.keyframes:
        return None
    return pose if pose in {key.name for key in asset.keyframes} and pose != START_POSE else CLOSED_POSE


def set_pose(spec: Sdf.PrimSpec, pose: Pose) -> None:
    """Override the pose of a link in the frame of its asset."""
    translate, orient = keyframe.XFORM_OPS
    kinds = Sdf.ValueTypeNames
    Sdf.AttributeSpec(spec, translate, kinds.Double3).default = number.vec3d(pose.position)
    Sdf.AttributeSpec(spec, orient, kinds.Quatd).default = number.quatd(pose.quaternion)
    # Set again: an asset without keyframes has no op where its pose is the identity.
    order = Sdf.AttributeSpec(spec, "xformOpOrder", kinds.TokenArray, Sdf.VariabilityUniform)
    order.default = list(keyframe.XFORM_OPS)


def set_joints(layer: Sdf.Layer, root: Sdf.Path, asset: Asset, positions: dict[str, float]) -> None:
    """Override link poses and joint states below `root`; `positions` in rad or m, joints not named are at zero."""
    for link in asset.links:
        if asset.is_moved(link.name):
            spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(link.name))
            set_pose(spec, asset.asset_from_link(link.name, positions))
    for joint in asset.joints:
        spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(SCOPE).AppendChild(joint.name))
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[keyframe.state_schema(joint)]))
        position = keyframe.state_position(joint, positions.get(joint.name, 0.0))
        Sdf.AttributeSpec(spec, keyframe.state_attribute(joint), Sdf.ValueTypeNames.Float).default = position


def fix_base(layer: Sdf.Layer, root: Sdf.Path, world: Sdf.Path, world_from_base: Pose) -> None:
    """Write the joint that holds a fixed base, from the world of the scene to the base of the copy at `root`.

    An asset by itself fixes its base to its own root prim. In a scene that prim is not the default prim of the stage,
    so MuJoCo would not treat it as the world and would let the base float.
    """
    spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(SCOPE).AppendChild(BASE_TO_WORLD))
    Sdf.RelationshipSpec(spec, "physics:body0", custom=False).targetPathList.explicitItems = [world]
    kinds = Sdf.ValueTypeNames
    position, rotation = number.vec3f(world_from_base.position), number.quatf(world_from_base.quaternion)
    Sdf.AttributeSpec(spec, "physics:localPos0", kinds.Point3f).default = position
    Sdf.AttributeSpec(spec, "physics:localRot0", kinds.Quatf).default = rotation
