"""Data that URDF cannot represent -> JSON: springs, friction of surfaces, sites, states, labels, named poses."""

from __future__ import annotations

import json
from typing import Any

from casa_assets.export.mjcf import number
from casa_assets.export.urdf.body import link_from_urdf
from casa_assets.model.asset.asset import Asset, Joint, Region, Site
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record

SCHEMA_VERSION = 1


def json_text(data: Any) -> bytes:
    """JSON text with sorted keys."""
    return (json.dumps(data, indent=1, sort_keys=True, allow_nan=False) + "\n").encode("ascii")


def facts_beside(asset: Asset, urdf: str) -> dict[str, Any]:
    """All data of the asset that its URDF cannot represent; poses are in the frames of the URDF's links.

    Args:
        urdf: name of the URDF file.
    """
    portion = asset.labels.portion
    return {
        "schema_version": SCHEMA_VERSION,
        "id": asset.id,
        "urdf": urdf,
        "base": asset.base.value,
        "asset_from_root": pose(asset.root.pose),
        "classes": list(asset.labels.classes),
        "contract": asset.contract or "",
        **({} if portion is None else {"portion": portion.value}),
        "joints": {joint.name: _joint(joint) for joint in asset.joints},
        "colliders": _colliders(asset),
        "visuals": {v.name: {"label": v.label} for link in asset.links for v in link.visuals},
        "sites": [_site(asset, site) for site in asset.sites],
        "regions": [_place(asset, region) for region in asset.regions],
        "states": _dumped(asset.states),
        "keyframes": {key.name: joint_positions(key.joints) for key in asset.keyframes},
        "exclusions": [[pair.first, pair.second] for pair in asset.exclusions],
        "behavior": None if asset.behavior is None else asset.behavior.model_dump(mode="json"),
    }


def pose(value: Pose) -> dict[str, list[float]]:
    """Position in metres, quaternion (w, x, y, z), nine digits."""
    return {"position": rounded(value.position), "quaternion": rounded(value.quaternion)}


def rounded(values: tuple[float, ...]) -> list[float]:
    """Numbers with nine digits, as in the URDF."""
    return [float(number.number(value)) for value in values]


def _joint(joint: Joint) -> dict[str, Any]:
    """Armature, stiffness of dry friction, spring, collider that a hand takes hold of, joint that opens first."""
    spring = joint.drive and {"stiffness": joint.drive.stiffness, "rest": joint.drive.target}
    return {
        "armature": joint.armature,
        "friction_impedance": list(joint.friction_impedance),
        "spring": spring,
        "grip": joint.grip,
        "behind": joint.behind,
    }


def _colliders(asset: Asset) -> dict[str, Any]:
    found = {}
    for collider in (c for link in asset.links for c in link.colliders):
        matter = asset.substance(collider.substance)
        found[collider.name] = {
            "substance": matter.id,
            "static_friction": matter.static_friction,
            "dynamic_friction": matter.dynamic_friction,
            "torsional_friction": matter.torsional_friction,
            "rolling_friction": matter.rolling_friction,
            "label": collider.label,
        }
    return found


def _site(asset: Asset, site: Site) -> dict[str, Any]:
    size = [2 * site.radius] * 3 if site.size is None else list(site.size)
    return {**_place(asset, site), "size": size, "color": list(site.color)}


def _place(asset: Asset, item: Site | Region) -> dict[str, Any]:
    """Name, link, kind, pose in the frame of the URDF's link, and full size."""
    inside = link_from_urdf(asset, item.link).inverse() @ item.pose
    size = list(item.size) if item.size is not None else []
    return {"name": item.name, "link": item.link, "kind": item.kind, "size": size, **pose(inside)}


def _dumped(records: tuple[Record, ...]) -> list[Any]:
    return [record.model_dump(mode="json") for record in records]
