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
from casa_assets.checks.readers.mujoco_facts import three
from casa_assets.core.numeric import about_axis
from casa_assets.geometry.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Joint, JointKind, Link, Region, Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3


def facts(asset: Asset) -> AssetFacts:
    """The table of an asset: joints at zero, root at the origin."""
    bodies = sorted((_body(asset, link) for link in asset.links), key=lambda body: body.name)
    pairs = {(min(e.first, e.second), max(e.first, e.second)) for e in asset.exclusions}
    places = [*map(_place, asset.sites), *map(_place, asset.regions)]
    return AssetFacts(
        base=asset.base,
        bodies=tuple(bodies),
        exclusions=tuple(sorted(pairs)),
        places=tuple(sorted((p for p in places if p.name != OUTER), key=lambda place: place.name)),
        looks=_looks(asset),
        poses=_poses(asset),
        words=_words(asset),
    )


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
        lower=three(corners[0]),
        upper=three(corners[1]),
        frictions=tuple(sorted({_friction(asset, c.substance) for c in link.colliders})),
        joint=_joint(asset.joint_of(link.name)),
    )


def _friction(asset: Asset, substance: str) -> Vec3:
    """(sliding, torsional, rolling); MuJoCo has one coefficient for sliding, that of motion."""
    matter = asset.substance(substance)
    return matter.dynamic_friction, matter.torsional_friction, matter.rolling_friction


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
    site = isinstance(item, Site)
    size = item.size if item.size is not None else (2 * item.radius,) * 3 if site else (0.0,) * 3
    # A cylinder is as wide as its size along x.
    x, y, z = size
    return PlaceFacts(
        name=item.name,
        body=item.link,
        kind=item.kind,
        position=item.pose.position,
        quaternion=item.pose.quaternion,
        size=(x, x, z) if item.kind == "cylinder" else (x, y, z),
        color=item.color if isinstance(item, Site) else None,
    )


def _looks(asset: Asset) -> tuple[VisualFacts, ...]:
    by_id = {material.id: material for material in asset.materials}
    found = []
    for visual in (v for link in asset.links for v in link.visuals):
        material = by_id[visual.material]
        red, green, blue, _ = material.base_color
        picture = material.base_color_texture
        found.append(
            VisualFacts(
                name=visual.name,
                color=material.base_color,
                light=(material.glow * red, material.glow * green, material.glow * blue),
                picture=picture.file_name if picture is not None else "",
            )
        )
    return tuple(sorted(found, key=lambda look: look.name))


def _poses(asset: Asset) -> tuple[PoseFacts, ...]:
    if not asset.keyframes:
        return ()
    named = {CLOSED: {}, **{key.name: {at.joint: at.value for at in key.joints} for key in asset.keyframes}}
    return tuple(_link_poses(asset, name, named[name]) for name in sorted(named))


def _link_poses(asset: Asset, name: str, values: dict[str, float]) -> PoseFacts:
    """Forward kinematics, parents before children."""
    root_from: dict[str, Pose] = {}
    for link in asset.links:
        if link.parent is None:
            root_from[link.name] = Pose()
            continue
        joint = asset.joint_of(link.name)
        moved = Pose() if joint is None else _joint_pose(joint, values.get(joint.name, 0.0))
        root_from[link.name] = root_from[link.parent] @ link.pose @ moved
    order = sorted(root_from)
    return PoseFacts(
        name=name,
        bodies=tuple(order),
        positions=tuple(root_from[link].position for link in order),
        quaternions=tuple(root_from[link].quaternion for link in order),
    )


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
    shapes = [(seen.name, seen.label) for link in asset.links for seen in link.visuals]
    shapes += [(touched.name, touched.label) for link in asset.links for touched in link.colliders]
    states = [StateFacts(name=s.name, joint=s.joint, value=s.value, interval=s.interval) for s in asset.states]
    return ProgramTexts(
        classes=asset.labels.classes,
        portion=asset.labels.portion or "",
        labels=tuple(sorted((name, label) for name, label in shapes if label is not None)),
        grips=tuple(sorted((j.name, j.grip) for j in asset.joints if j.grip is not None)),
        behind=tuple(sorted((j.name, j.behind) for j in asset.joints if j.behind is not None)),
        states=tuple(sorted(states, key=lambda state: state.name)),
        contract=asset.contract or "",
        behavior=asset.behavior.digest if asset.behavior is not None else "",
    )
