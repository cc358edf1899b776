"""Asset -> fact table, from the model itself: what both formats have to say."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.package.facts import (
    CLOSED,
    OUTER,
    AssetFacts,
    BodyFacts,
    JointFacts,
    PlaceFacts,
    PoseFacts,
    ProgramTexts,
    StateFacts,
    VisualFacts,
)
from casa_assets.checks.readers.mujoco_facts import bounds_around, pose_facts, three
from casa_assets.core.numeric import about_axis
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Collider, Joint, JointKind, Link, Region, Site, Visual
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.pose import Pose


def facts(asset: Asset) -> AssetFacts:
    """The table of an asset: joints at zero, root at the origin."""
    named = {CLOSED: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    return AssetFacts(
        base=asset.base,
        exclusions=[(pair.first, pair.second) for pair in asset.exclusions],
        words=_words(asset),
        bodies=[_body(asset, link) for link in asset.links],
        places=[place for place in (*map(_place, asset.sites), *map(_place, asset.regions)) if place.name != OUTER],
        looks=_looks(asset),
        poses=[_link_poses(asset, name, named[name]) for name in named] if asset.keyframes else (),
    )


def _body(asset: Asset, link: Link) -> BodyFacts:
    pose = asset.root.pose.inverse() @ asset.asset_from_link(link.name)
    bounds = link_bounds(link)
    lower, upper = bounds_around([] if bounds is None else [bounds])
    matters = [asset.substance(collider.substance) for collider in link.colliders]
    return BodyFacts(
        name=link.name,
        parent=link.parent or "",
        colliders=len(link.colliders),
        position=pose.position,
        center_of_mass=link.inertial.center_of_mass,
        lower=lower,
        upper=upper,
        quaternion=pose.quaternion,
        mass=link.inertial.mass,
        inertia=link.inertial.inertia,
        # MuJoCo has one coefficient for sliding, that of motion.
        frictions={(m.dynamic_friction, m.torsional_friction, m.rolling_friction) for m in matters},
        joint=_joint(asset.joint_of(link.name)),
    )


def _joint(joint: Joint | None) -> JointFacts | None:
    if joint is None:
        return None
    stiffness, rest, damping = (0.0, 0.0, joint.damping)
    if joint.drive is not None:
        stiffness, rest, damping = joint.drive.stiffness, joint.drive.target, joint.damping + joint.drive.damping
    return JointFacts(
        name=joint.name,
        kind=joint.kind,
        axis=joint.axis,
        anchor=joint.anchor,
        range=joint.range,
        resistance=(stiffness, rest, damping, joint.frictionloss, joint.armature),
    )


def _place(item: Site | Region) -> PlaceFacts:
    # A cylinder is as wide as its size along x.
    x, y, z = item.size if item.size is not None else (2 * item.radius,) * 3 if isinstance(item, Site) else (0.0,) * 3
    return PlaceFacts(
        name=item.name,
        body=item.link,
        kind=item.kind,
        position=item.pose.position,
        quaternion=item.pose.quaternion,
        size=(x, x, z) if item.kind == "cylinder" else (x, y, z),
        color=item.color if isinstance(item, Site) else None,
    )


def _looks(asset: Asset) -> list[VisualFacts]:
    by_id = {material.id: material for material in asset.materials}
    found = []
    for visual in (v for link in asset.links for v in link.visuals):
        material = by_id[visual.material]
        light = tuple(material.glow * channel for channel in material.base_color[:3])
        picture = material.base_color_texture
        file = picture.file_name if picture is not None else ""
        found.append(VisualFacts(name=visual.name, color=material.base_color, light=light, picture=file))
    return found


def _link_poses(asset: Asset, name: str, values: dict[str, float]) -> PoseFacts:
    """Forward kinematics, parents before children, by other formulas than those that the writers use."""
    root_from: dict[str, Pose] = {}
    for link in asset.links:
        if link.parent is None:
            root_from[link.name] = Pose()
            continue
        joint = asset.joint_of(link.name)
        moved = Pose() if joint is None else _joint_pose(joint, values.get(joint.name, 0.0))
        root_from[link.name] = root_from[link.parent] @ link.pose @ moved
    return pose_facts(name, root_from)


def _joint_pose(joint: Joint, value: float) -> Pose:
    """Pose of the child in its own frame at zero. Ref: p - R p for a turn about the point p."""
    axis = np.array(joint.axis)
    if joint.kind is JointKind.SLIDE:
        return Pose(position=three(axis * value))
    matrix = np.eye(4)
    matrix[:3, :3] = about_axis(axis, value)
    anchor = np.array(joint.anchor)
    matrix[:3, 3] = anchor - matrix[:3, :3] @ anchor
    return Pose.from_matrix(matrix)


def _words(asset: Asset) -> ProgramTexts:
    shapes: list[Collider | Visual] = []
    for link in asset.links:
        shapes += (*link.visuals, *link.colliders)
    return ProgramTexts(
        classes=asset.labels.classes,
        portion=asset.labels.portion or "",
        labels=[(shape.name, shape.label) for shape in shapes if shape.label is not None],
        grips=[(joint.name, joint.grip) for joint in asset.joints if joint.grip is not None],
        behind=[(joint.name, joint.behind) for joint in asset.joints if joint.behind is not None],
        contract=asset.contract or "",
        behavior=asset.behavior.digest if asset.behavior is not None else "",
        states=[StateFacts(name=s.name, joint=s.joint, value=s.value, interval=s.interval) for s in asset.states],
    )
