"""Joint -> revolute or prismatic `<joint>` with limits, damping and dry friction; a rigid attachment -> a fixed one."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf.number import number as text
from casa_assets.export.mjcf.number import numbers
from casa_assets.export.urdf import number
from casa_assets.model.asset.asset import Joint, JointKind
from casa_assets.model.pose import Pose

KINDS = {JointKind.HINGE: "revolute", JointKind.SLIDE: "prismatic"}
# URDF asks for the strength and the speed of a motor. Our joints have no motor, so neither bounds anything: N*m or N,
# and rad/s or m/s, far above what a hand brings about.
NO_BOUND = {"effort": "1000", "velocity": "100"}
# At the end of the name of a fixed joint; no joint of an asset is called so.
FIXED = "__fixed"


def add(
    robot: etree._Element, joint: Joint | None, parent: str, child: str, parent_from_child: Pose, prefix: str = ""
) -> None:
    """Add the `<joint>` between two links of the URDF, with its origin on the axis.

    The damping includes that of a drive, since the drive is a spring that no motor switches off; its stiffness and rest
    position cannot be written to URDF.

    Args:
        joint: None adds a fixed joint.
    """
    if joint is None:
        element = etree.SubElement(robot, "joint", {"name": child + FIXED, "type": "fixed"})
    else:
        element = etree.SubElement(robot, "joint", {"name": prefix + joint.name, "type": KINDS[joint.kind]})
    etree.SubElement(element, "parent", {"link": parent})
    etree.SubElement(element, "child", {"link": child})
    number.add_origin(element, parent_from_child)
    if joint is None:
        return
    low, high = joint.range
    damping = joint.damping + (joint.drive.damping if joint.drive else 0.0)
    etree.SubElement(element, "axis", {"xyz": numbers(joint.axis)})
    etree.SubElement(element, "limit", {"lower": text(low), "upper": text(high), **NO_BOUND})
    etree.SubElement(element, "dynamics", {"damping": text(damping), "friction": text(joint.frictionloss)})
