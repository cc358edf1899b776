"""Pose of a placement -> what a scene says of the bodies and joints of the asset that it refers to."""

from __future__ import annotations

from pxr import Sdf

from casa_assets.export.usd import keyframe, number
from casa_assets.export.usd.joint import BASE_TO_WORLD, SCOPE
from casa_assets.model.asset.asset import Asset, JointKind
from casa_assets.model.pose import Pose

START, CLOSED, OPEN = "start", keyframe.DEFAULT, "open"
OPS = ("xformOp:translate", "xformOp:orient")


def variant(asset: Asset, pose: str) -> str | None:
    """The asset's own variant that comes nearest to a pose of the scene; None where it has no variants."""
    if not asset.keyframes:
        return None
    return pose if pose in {key.name for key in asset.keyframes} and pose != START else CLOSED


def values(asset: Asset, pose: str) -> dict[str, float]:
    """Joints of a pose of the asset, rad or m; those not named are at zero."""
    return {at.joint: at.value for key in asset.keyframes if key.name == pose for at in key.joints}


def stand(layer: Sdf.Layer, root: Sdf.Path, asset: Asset, joints: dict[str, float]) -> None:
    """Bodies and joints below the spec at `root` where `joints` (rad, m) put them; those not named are at zero."""
    for link in asset.links:
        if keyframe.is_moved(asset, link.name):
            spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(link.name))
            pose = keyframe.asset_from_link(asset, link.name, joints)
            kinds, made = Sdf.ValueTypeNames, (number.vec3d(pose.position), number.quatd(pose.quaternion))
            for op, kind, value in zip(OPS, (kinds.Double3, kinds.Quatd), made, strict=True):
                Sdf.AttributeSpec(spec, op, kind).default = value
            # Said again: an asset without poses of its own has no op for what is identity there.
            order = Sdf.AttributeSpec(spec, "xformOpOrder", kinds.TokenArray, Sdf.VariabilityUniform)
            order.default = list(OPS)
    for joint in asset.joints:
        freedom = keyframe.state_axis(joint)
        spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(SCOPE).AppendChild(joint.name))
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[f"PhysicsJointStateAPI:{freedom}"]))
        value = joints.get(joint.name, 0.0)
        position = number.degrees(value) if joint.kind is JointKind.HINGE else value
        Sdf.AttributeSpec(spec, f"state:{freedom}:physics:position", Sdf.ValueTypeNames.Float).default = position


def anchor(layer: Sdf.Layer, root: Sdf.Path, world: Sdf.Path, world_from_base: Pose) -> None:
    """The joint that holds a fixed base, from the world of the scene to the base of the copy at `root`.

    By itself the asset holds its base by its own root prim. Once that is no longer the default prim of the stage,
    MuJoCo does not take it for the world, and lets the base float.
    """
    spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(SCOPE).AppendChild(BASE_TO_WORLD))
    Sdf.RelationshipSpec(spec, "physics:body0", custom=False).targetPathList.explicitItems = [world]
    kinds = Sdf.ValueTypeNames
    position, turned = number.vec3f(world_from_base.position), number.quatf(world_from_base.quaternion)
    Sdf.AttributeSpec(spec, "physics:localPos0", kinds.Point3f).default = position
    Sdf.AttributeSpec(spec, "physics:localRot0", kinds.Quatf).default = turned
