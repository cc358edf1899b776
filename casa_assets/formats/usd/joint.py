"""Joint -> revolute, prismatic or fixed joint prim; labels, behaviour and contract -> semantics and attributes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, Vt

from casa_assets.formats.usd import number
from casa_assets.model.asset.asset import Asset, Base, Drive, Joint, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

# Joint ----------------------------------------------------------------------------------------------------------------

# camelCase, which no joint or link id is.
SCOPE = "physicsJoints"
BASE_TO_WORLD = "baseToWorld"

X, Y, Z = UsdGeom.Tokens.x, UsdGeom.Tokens.y, UsdGeom.Tokens.z
# USD joints move along X, Y or Z of the joint frame. Directions that need no rounding: token, child_from_joint.
EXACT_AXES: dict[Vec3, tuple[str, Vec4]] = {
    (1.0, 0.0, 0.0): (X, (1.0, 0.0, 0.0, 0.0)),
    (0.0, 1.0, 0.0): (Y, (1.0, 0.0, 0.0, 0.0)),
    (0.0, 0.0, 1.0): (Z, (1.0, 0.0, 0.0, 0.0)),
    (-1.0, 0.0, 0.0): (X, (0.0, 0.0, 0.0, 1.0)),
    (0.0, -1.0, 0.0): (Y, (0.0, 1.0, 0.0, 0.0)),
    (0.0, 0.0, -1.0): (Z, (0.0, 1.0, 0.0, 0.0)),
}


def define_joints(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Joints of the asset below `<root>/physicsJoints`; links without a joint are fixed to their parent."""
    if len(asset.links) == 1 and asset.base is Base.FREE:
        return
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(SCOPE)).GetPath()
    if asset.base is Base.FIXED:
        # To the asset's own root prim: an end without a target is at the origin of the stage, and PhysX would pull a
        # base that is placed elsewhere back to it.
        held = UsdPhysics.FixedJoint.Define(stage, scope.AppendChild(BASE_TO_WORLD))
        _attach(held, root, root.AppendChild(asset.root.name), asset.root.pose, Pose())
    for link in asset.links[1:]:
        assert link.parent is not None
        parent, child = root.AppendChild(link.parent), root.AppendChild(link.name)
        joint = asset.joint_of(link.name)
        if joint is None:
            mount = UsdPhysics.FixedJoint.Define(stage, scope.AppendChild(f"{link.name}Mount"))
            _attach(mount, parent, child, link.pose, Pose())
            continue
        is_hinge = joint.kind is JointKind.HINGE
        schema = UsdPhysics.RevoluteJoint if is_hinge else UsdPhysics.PrismaticJoint
        moving = schema.Define(stage, scope.AppendChild(joint.name))
        prim = moving.GetPrim()
        token, rotation = axis_and_rotation(joint.axis)
        moving.CreateAxisAttr(token)
        low, high = (math.degrees(n) if is_hinge else n for n in joint.range)
        moving.CreateLowerLimitAttr(low)
        moving.CreateUpperLimitAttr(high)
        _attach(moving, parent, child, link.pose, Pose(position=joint.anchor, quaternion=rotation))
        _set_dynamics(prim, joint, is_hinge)
        # Named states: fractions of the way from closed (0) to open (1).
        states = [state for state in asset.states if state.joint == joint.name]
        if states:
            named = {s.name: {"value": s.value, "from": s.interval[0], "to": s.interval[1]} for s in states}
            prim.SetCustomDataByKey("states", named)


def axis_and_rotation(axis: Vec3) -> tuple[str, Vec4]:
    """Axis token and child_from_joint rotation that turns the token's axis onto a unit vector.

    For any direction other than the six exact ones, the token is Z and the rotation is the shortest arc.
    """
    if axis in EXACT_AXES:
        return EXACT_AXES[axis]
    x, y, z = axis
    if z < -1.0 + 1e-12:  # the arc has no plane of its own; the axis is -z to rounding
        return EXACT_AXES[(0.0, 0.0, -1.0)]
    quaternion = np.array([1.0 + z, -y, x, 0.0])
    w, i, j, k = (float(n) for n in quaternion / math.sqrt(float(quaternion @ quaternion)))
    return Z, (w, i, j, k)


def _attach(
    joint: UsdPhysics.Joint, parent: Sdf.Path, child: Sdf.Path, parent_from_child: Pose, child_from_joint: Pose
) -> None:
    """Both ends of a joint."""
    joint.CreateBody0Rel().SetTargets([parent])
    joint.CreateBody1Rel().SetTargets([child])
    parent_from_joint = parent_from_child @ child_from_joint
    joint.CreateLocalPos0Attr(number.vec3f(parent_from_joint.position))
    joint.CreateLocalRot0Attr(number.quatf(parent_from_joint.quaternion))
    joint.CreateLocalPos1Attr(number.vec3f(child_from_joint.position))
    joint.CreateLocalRot1Attr(number.quatf(child_from_joint.quaternion))


def _set_dynamics(prim: Usd.Prim, joint: Joint, is_hinge: bool) -> None:
    """Friction, damping, armature and drive: a spring as PhysX and Newton read it, and one of the joint for MuJoCo."""
    per_unit = math.pi / 180 if is_hinge else 1.0
    drive = joint.drive or Drive(stiffness=0.0, damping=0.0)
    if joint.drive is not None:
        api = UsdPhysics.DriveAPI.Apply(prim, "angular" if is_hinge else "linear")
        api.CreateTypeAttr(UsdPhysics.Tokens.force)
        api.CreateStiffnessAttr(drive.stiffness * per_unit)
        api.CreateDampingAttr(drive.damping * per_unit)
        api.CreateTargetPositionAttr(drive.target / per_unit)
    newton = {
        "newton:armature": joint.armature,
        "newton:damping": (joint.damping + drive.damping) * per_unit,
        "newton:friction": joint.frictionloss,
    }
    number.apply(prim, "NewtonJointAPI", newton)
    mjc: dict[str, object] = {"mjc:solimplimit": Vt.DoubleArray(joint.limit_impedance)}
    if joint.frictionloss:
        mjc["mjc:solimpfriction"] = Vt.DoubleArray(joint.friction_impedance)
    if joint.drive is not None:
        mjc["mjc:stiffness"] = drive.stiffness
        mjc["mjc:springref"] = drive.target / per_unit
        mjc["mjc:margin"] = joint.limit_margin
    number.apply(prim, "MjcJointAPI", mjc)


# Label ----------------------------------------------------------------------------------------------------------------
# Labels -> UsdSemantics; behaviour, contract and grips -> attributes in the namespace `casa`.

# The taxonomy of the part of an asset that a visual or collider is: handle, door, shelf.
PART = "part"


def attach_label(prim: Usd.Prim, taxonomy: str, labels: Sequence[str]) -> None:
    """Set the labels of one taxonomy on a prim."""
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr(list(labels))


def attach_labels(root: Usd.Prim, asset: Asset) -> None:
    """Attach classes from the category upwards, the Wikidata item, and the portion of a cut object."""
    attach_label(root, "class", asset.labels.classes)
    attach_label(root, "wikidata_qcode", [asset.labels.qcode.id])
    if asset.labels.portion is not None:
        attach_label(root, "portion", [asset.labels.portion.value])


def define_behavior(stage: Usd.Stage, root: Usd.Prim, asset: Asset) -> None:
    """`casa:behavior` (JSON) and `casa:contract` on the root, `casa:grip` and `casa:behind` on joints."""
    if asset.contract is not None:
        _set_text(root, "contract", asset.contract)
    if asset.behavior is not None:
        _set_text(root, "behavior", asset.behavior.to_json())
    for joint in asset.joints:
        prim = stage.GetPrimAtPath(root.GetPath().AppendChild(SCOPE).AppendChild(joint.name))
        for name, value in (("grip", joint.grip), ("behind", joint.behind)):
            if value is not None:
                _set_text(prim, name, value)


def _set_text(prim: Usd.Prim, name: str, value: str) -> None:
    prim.CreateAttribute(f"casa:{name}", Sdf.ValueTypeNames.String, True, Sdf.VariabilityUniform).Set(value)
