"""Keyframe -> variant of the root prim: the bodies stand where the joints put them."""

from __future__ import annotations

import math

from pxr import Sdf, Usd, UsdGeom

from casa_assets.export.usd import number
from casa_assets.export.usd.joint import SCOPE
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.pose import Pose

SET = "pose"
DEFAULT = "closed"


def define_all(stage: Usd.Stage, root: Usd.Prim, asset: Asset) -> None:
    """The variant set `pose`, `closed` selected; the layer's own opinions are those of joints at zero.

    A variant is weaker than what the layer says outside of it, so the poses of links that move are said only inside.
    """
    if not asset.keyframes:
        return
    variants = root.GetVariantSets().AddVariantSet(SET)
    named = {key.name: {at.joint: at.value for at in key.joints} for key in asset.keyframes}
    named = {DEFAULT: named.get(DEFAULT, {}), **named}
    moving = [k.name for k in asset.links if is_moved(asset, k.name)]
    _make_room(stage, root, asset, moving)
    for key, values in named.items():
        variants.AddVariant(key)
        variants.SetVariantSelection(key)
        with variants.GetVariantEditContext():
            for name in moving:
                prim = stage.OverridePrim(root.GetPath().AppendChild(name))
                pose = asset_from_link(asset, name, values)
                prim.GetAttribute("xformOp:translate").Set(number.vec3d(pose.position))
                prim.GetAttribute("xformOp:orient").Set(number.quatd(pose.quaternion))
            for joint in asset.joints:
                _stand(stage.OverridePrim(_path(root, joint)), joint, values.get(joint.name, 0.0))
    variants.SetVariantSelection(DEFAULT)


def _make_room(stage: Usd.Stage, root: Usd.Prim, asset: Asset, moving: list[str]) -> None:
    """Outside of the variants: the ops to which each of them gives values, and that joints have a position."""
    for name in moving:
        xform = UsdGeom.Xformable(stage.GetPrimAtPath(root.GetPath().AppendChild(name)))
        xform.ClearXformOpOrder()
        for op in ("xformOp:translate", "xformOp:orient"):
            xform.GetPrim().RemoveProperty(op)
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble)
        xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for joint in asset.joints:
        stage.GetPrimAtPath(_path(root, joint)).AddAppliedSchema(f"PhysicsJointStateAPI:{state_axis(joint)}")


def _stand(prim: Usd.Prim, joint: Joint, value: float) -> None:
    """Set the joint state that PhysX reads: degrees or metres. Ref: PhysxSchema, PhysicsJointStateAPI."""
    position = number.degrees(value) if joint.kind is JointKind.HINGE else value
    number.author(
        prim, f"state:{state_axis(joint)}:physics:position", Sdf.ValueTypeNames.Float, position, uniform=False
    )


def state_axis(joint: Joint) -> str:
    """Name in UsdPhysics of the axis that a joint moves along or about."""
    return "angular" if joint.kind is JointKind.HINGE else "linear"


def _path(root: Usd.Prim, joint: Joint) -> Sdf.Path:
    return root.GetPath().AppendChild(SCOPE).AppendChild(joint.name)


def asset_from_link(asset: Asset, name: str, values: dict[str, float]) -> Pose:
    """Pose of a link in the asset frame with the joints at `values` (rad, m); those not named are at zero."""
    link = asset.link(name)
    if link.parent is None:
        return link.pose
    joint = asset.joint_of(name)
    moved = Pose() if joint is None else joint_motion(joint, values.get(joint.name, 0.0))
    return asset_from_link(asset, link.parent, values) @ link.pose @ moved


def joint_motion(joint: Joint, value: float) -> Pose:
    """Pose of the child at `value` in its own frame at zero."""
    x, y, z = joint.axis
    if joint.kind is JointKind.SLIDE:
        return Pose(position=(x * value, y * value, z * value))
    # Not numpy's: its sine depends on the processor.
    c, s = math.cos(value / 2), math.sin(value / 2)
    spin = Pose(quaternion=(c, s * x, s * y, s * z))
    at = Pose(position=joint.anchor)
    return at @ spin @ at.inverse()


def is_moved(asset: Asset, name: str) -> bool:
    """True if a link is moved by any joint, its own or one that carries it."""
    link = asset.link(name)
    if asset.joint_of(name) is not None:
        return True
    return link.parent is not None and is_moved(asset, link.parent)
