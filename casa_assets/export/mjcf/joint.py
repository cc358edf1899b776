"""Joint -> hinge or slide; a drive becomes a spring to its target, since an asset has no actuators."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.asset import Joint


def add(body: etree._Element, joint: Joint, prefix: str = "") -> None:
    """`<joint>` below the body that it moves; radians and metres, body frame; `prefix`: prefix of its name."""
    drive = joint.drive
    attributes = {
        "name": prefix + joint.name,
        "type": joint.kind.value,
        "pos": number.numbers(joint.anchor),
        "axis": number.numbers(joint.axis),
        # Written although autolimits would do: consumers that merge models drop <compiler>.
        "limited": "true",
        "range": number.numbers(joint.range),
        "damping": number.number(joint.damping + (drive.damping if drive else 0.0)),
        "frictionloss": number.number(joint.frictionloss),
        "armature": number.number(joint.armature),
        "solimplimit": number.numbers(joint.limit_impedance),
    }
    if joint.frictionloss:
        attributes["solimpfriction"] = number.numbers(joint.friction_impedance)
    if drive:
        attributes |= {
            "stiffness": number.number(drive.stiffness),
            "springref": number.number(drive.target),
            "margin": number.number(joint.limit_margin),
        }
    etree.SubElement(body, "joint", attributes)
