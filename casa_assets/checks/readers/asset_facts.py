"""Asset -> fact table, from the model itself: what both formats have to say."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.facts import BodyFacts, Facts, JointFacts
from casa_assets.geometry.extent import link_bounds
from casa_assets.model.asset import Asset, Joint, Link
from casa_assets.model.record import Vec3


def facts(asset: Asset) -> Facts:
    """The table of an asset: joints at zero, root at the origin."""
    bodies = sorted((_body(asset, link) for link in asset.links), key=lambda body: body.name)
    pairs = {(min(e.first, e.second), max(e.first, e.second)) for e in asset.exclusions}
    return Facts(base=asset.base, bodies=tuple(bodies), exclusions=tuple(sorted(pairs)), classes=asset.labels.classes)


def _body(asset: Asset, link: Link) -> BodyFacts:
    pose = asset.root.pose.inverse() @ asset.asset_from_link(link.name)
    bounds = link_bounds(link)
    corners = np.zeros((2, 3)) if bounds is None else bounds
    return BodyFacts(
        name=link.name,
        parent=link.parent or "",
        position=pose.position,
        quaternion=pose.quaternion,
        mass=link.inertial.mass,
        center_of_mass=link.inertial.center_of_mass,
        inertia=link.inertial.inertia,
        colliders=len(link.colliders),
        lower=_three(corners[0]),
        upper=_three(corners[1]),
        frictions=tuple(sorted({_friction(asset, c.substance) for c in link.colliders})),
        joint=_joint(asset.joint_of(link.name)),
    )


def _friction(asset: Asset, substance: str) -> Vec3:
    """MuJoCo has one sliding coefficient, that of motion."""
    matter = asset.substance(substance)
    return matter.dynamic_friction, matter.torsional_friction, matter.rolling_friction


def _joint(joint: Joint | None) -> JointFacts | None:
    if joint is None:
        return None
    return JointFacts(name=joint.name, kind=joint.kind, axis=joint.axis, anchor=joint.anchor, range=joint.range)


def _three(values: np.ndarray) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z
