"""Scale a whole asset evenly, and find the height of the face that it works at."""

from __future__ import annotations

import numpy as np

from casa_assets.core.numeric import Floats, seven_digits, significant
from casa_assets.model.asset.asset import Asset, Joint, JointKind, Link
from casa_assets.model.asset.behavior import Behavior, Condition
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Mesh, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3

# A face is level where its normal leans by less than the angle of this cosine; faces of one height are within a step.
LEVEL_COSINE, LEVEL_STEP_M = 0.98, 0.01
# A thing works at a face in its upper part: a lower one is a plinth, a shelf or a rack.
UPPER_SHARE = 0.6


def scaled(asset: Asset, factor: float, mass: float) -> Asset:
    """An asset scaled evenly with its pictures, of a mass in kg; a hand needs as much force to move its parts."""
    heavier = mass / asset.mass
    kinds = {joint.name: joint.kind for joint in asset.joints}
    return asset.replace(
        links=tuple(_link(link, factor, heavier) for link in asset.links),
        joints=tuple(_joint(joint, factor, heavier) for joint in asset.joints),
        sites=tuple(
            site.replace(
                pose=_pose(site.pose, factor),
                radius=_length(site.radius, factor),
                size=None if site.size is None else _vector(site.size, factor),
            )
            for site in asset.sites
        ),
        regions=tuple(r.replace(pose=_pose(r.pose, factor), size=_vector(r.size, factor)) for r in asset.regions),
        keyframes=tuple(
            key.replace(
                joints=tuple(
                    at if kinds[at.joint] is JointKind.HINGE else at.replace(value=_length(at.value, factor))
                    for at in key.joints
                )
            )
            for key in asset.keyframes
        ),
        behavior=None if asset.behavior is None else _behavior(asset.behavior, kinds, factor),
    )


def level_of(asset: Asset) -> float:
    """Height of the largest level face in the upper part of an asset, joints at zero, above its lowest point, metres.

    For a range this is its cooktop, even if it has a higher back panel. The height of the asset if it has no such face.
    """
    low, high = (float(z) for z in asset.bounds[:, 2])
    heights, areas = [], []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            corners = pose.apply(visual.mesh.vertices)[visual.mesh.faces]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            area = np.linalg.norm(normals, axis=1)
            is_level = normals[:, 2] > LEVEL_COSINE * np.maximum(area, 1e-15)
            middle = corners[:, :, 2].mean(axis=1)
            is_upper = middle > low + UPPER_SHARE * (high - low)
            heights.append(middle[is_level & is_upper])
            areas.append(area[is_level & is_upper])
    height, area = np.concatenate(heights), np.concatenate(areas)
    if not len(height):
        return high - low
    steps = np.floor((height - low) / LEVEL_STEP_M + 0.5).astype(np.int64)
    largest = steps == int(np.bincount(steps, weights=area).argmax())
    return float(np.average(height[largest], weights=area[largest])) - low


def _link(link: Link, factor: float, heavier: float) -> Link:
    own = link.inertial
    return link.replace(
        pose=_pose(link.pose, factor),
        inertial=own.replace(
            mass=seven_digits(own.mass * heavier),
            center_of_mass=_vector(own.center_of_mass, factor),
            inertia=tuple(seven_digits(value * heavier * factor**2) for value in own.inertia),
        ),
        visuals=tuple(visual.replace(mesh=_mesh(visual.mesh, factor)) for visual in link.visuals),
        colliders=tuple(c.replace(shape=_shape(c.shape, factor), pose=_pose(c.pose, factor)) for c in link.colliders),
    )


def _shape(shape: Shape, factor: float) -> Shape:
    if isinstance(shape, Box):
        return shape.replace(size=_vector(shape.size, factor))
    if isinstance(shape, Sphere):
        return shape.replace(radius=_length(shape.radius, factor))
    if isinstance(shape, Cylinder | Capsule):
        return shape.replace(radius=_length(shape.radius, factor), height=_length(shape.height, factor))
    assert isinstance(shape, Hull | MeshShape)
    return shape.replace(mesh=_mesh(shape.mesh, factor))


def _joint(joint: Joint, factor: float, heavier: float) -> Joint:
    """A joint whose part feels to a hand as it did: as much force at the handle, which is as much farther away."""
    drive = joint.drive
    if joint.kind is JointKind.SLIDE:
        if drive is not None:
            # A spring pushes as hard over a way that is as much longer.
            target = _length(drive.target, factor)
            drive = drive.replace(stiffness=significant(drive.stiffness / factor, 3), target=target)
        return joint.replace(
            anchor=_vector(joint.anchor, factor),
            range=_span(joint.range, factor),
            armature=significant(joint.armature * heavier, 3),
            drive=drive,
        )
    if drive is not None:
        # A spring of a hinge carries the weight of its part, at an arm that is as much longer.
        stiffness, damping = (significant(v * heavier * factor, 3) for v in (drive.stiffness, drive.damping))
        drive = drive.replace(stiffness=stiffness, damping=damping)
    return joint.replace(
        anchor=_vector(joint.anchor, factor),
        damping=significant(joint.damping * factor, 3),
        frictionloss=significant(joint.frictionloss * factor, 3),
        armature=significant(joint.armature * heavier * factor**2, 3),
        drive=drive,
    )


def _behavior(behavior: Behavior, kinds: dict[str, JointKind], factor: float) -> Behavior:
    def measured(condition: Condition) -> Condition:
        if condition.joint is None or condition.interval is None or kinds[condition.joint] is JointKind.HINGE:
            return condition
        return condition.replace(interval=_span(condition.interval, factor))

    return behavior.replace(rules=tuple(rule.replace(when=tuple(map(measured, rule.when))) for rule in behavior.rules))


def _mesh(mesh: Mesh, factor: float) -> Mesh:
    """A scaled mesh, in the single precision of files."""
    vertices: Floats = (mesh.vertices * factor).astype(np.float32).astype(np.float64)
    return mesh.with_vertices(vertices, mesh.normals)


def _pose(pose: Pose, factor: float) -> Pose:
    return pose.replace(position=_vector(pose.position, factor))


def _vector(vector: Vec3, factor: float) -> Vec3:
    x, y, z = vector
    return (_length(x, factor), _length(y, factor), _length(z, factor))


def _span(span: Vec2, factor: float) -> Vec2:
    return (_length(span[0], factor), _length(span[1], factor))


def _length(value: float, factor: float) -> float:
    return seven_digits(value * factor)
