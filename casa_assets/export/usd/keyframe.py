"""Keyframe -> variant of the root prim: link poses and joint states."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdGeom

from casa_assets.export.usd import number
from casa_assets.export.usd.joint import SCOPE
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.kitchen.scene import CLOSED_POSE

VARIANT_SET = "pose"
XFORM_OPS = ("xformOp:translate", "xformOp:orient")


def define_all(stage: Usd.Stage, root: Usd.Prim, asset: Asset) -> None:
    """Add the variant set `pose`, with `closed` selected; the layer itself has the joints at zero.

    A variant is weaker than opinions of the layer outside of it, so poses of links that move are only set in variants.
    """
    if not asset.keyframes:
        return
    variants = root.GetVariantSets().AddVariantSet(VARIANT_SET)
    poses = {CLOSED_POSE: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    moving = [link.name for link in asset.links if asset.is_moved(link.name)]
    _prepare_prims(stage, root, asset, moving)
    for name, positions in poses.items():
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            for link in moving:
                prim = stage.OverridePrim(root.GetPath().AppendChild(link))
                pose = asset.asset_from_link(link, positions)
                prim.GetAttribute(XFORM_OPS[0]).Set(number.vec3d(pose.position))
                prim.GetAttribute(XFORM_OPS[1]).Set(number.quatd(pose.quaternion))
            for joint in asset.joints:
                attribute = state_attribute(joint)
                prim = stage.OverridePrim(_path(root, joint))
                position = state_position(joint, positions.get(joint.name, 0.0))
                number.author(prim, attribute, Sdf.ValueTypeNames.Float, position, uniform=False)
    variants.SetVariantSelection(CLOSED_POSE)


def _prepare_prims(stage: Usd.Stage, root: Usd.Prim, asset: Asset, moving: list[str]) -> None:
    """Set up, outside of the variants, xform ops without values and the joint state schema."""
    for link in moving:
        xform = UsdGeom.Xformable(stage.GetPrimAtPath(root.GetPath().AppendChild(link)))
        xform.ClearXformOpOrder()
        for op in XFORM_OPS:
            xform.GetPrim().RemoveProperty(op)
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble)
        xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for joint in asset.joints:
        stage.GetPrimAtPath(_path(root, joint)).AddAppliedSchema(state_schema(joint))


def state_schema(joint: Joint) -> str:
    """Applied schema of the joint state that PhysX reads. Ref: PhysxSchema, PhysicsJointStateAPI."""
    return f"PhysicsJointStateAPI:{_axis(joint)}"


def state_attribute(joint: Joint) -> str:
    """Attribute of the position in that schema."""
    return f"state:{_axis(joint)}:physics:position"


def state_position(joint: Joint, position: float) -> float:
    """Joint position (rad or m) in the units of that schema: degrees or metres."""
    return number.degrees(position) if joint.kind is JointKind.HINGE else position


def _axis(joint: Joint) -> str:
    return "angular" if joint.kind is JointKind.HINGE else "linear"


def _path(root: Usd.Prim, joint: Joint) -> Sdf.Path:
    return root.GetPath().AppendChild(SCOPE).AppendChild(joint.name)
