"""Runs beside yourdfpy and SAPIEN: loads URDF files and prints, as JSON, what each of the two made of them.

Arguments: URDF files. Poses and bounds are in the frame of the root link, with every joint at zero and with every joint
at the middle of its range.
"""

from __future__ import annotations

import json
import logging
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import sapien
import yourdfpy
from sapien.wrapper.urdf_loader import URDFLoader


class _Heard(logging.Handler):
    """Keeps what is logged."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


class _PhysicsLoader(URDFLoader):
    """SAPIEN's loader without what is seen: its renderer needs a graphics driver."""

    def _build_link(self, link: Any, link_builder: Any) -> None:
        link.visuals = []
        super()._build_link(link, link_builder)


def by_yourdfpy(path: Path) -> dict[str, Any]:
    """Links, joints, poses and bounds."""
    heard = _Heard()
    logging.getLogger().addHandler(heard)
    robot = yourdfpy.URDF.load(str(path), load_collision_meshes=True, build_collision_scene_graph=True)
    valid = robot.validate()
    joints = {
        name: {
            "type": joint.type,
            "axis": joint.axis.tolist(),
            "range": [joint.limit.lower, joint.limit.upper],
            "damping": float(joint.dynamics.damping),
            "friction": float(joint.dynamics.friction),
        }
        for name, joint in robot.joint_map.items()
        if joint.type != "fixed"
    }
    poses = {}
    for word, share in (("zero", None), ("middle", 0.5)):
        values = {n: 0.0 if share is None else sum(j["range"]) * share for n, j in joints.items()}
        if joints:
            robot.update_cfg(values)
        poses[word] = {
            "links": {name: robot.get_transform(name).tolist() for name in robot.link_map},
            "seen": robot.scene.bounds.tolist(),
        }
    logging.getLogger().removeHandler(heard)
    return {
        "valid": valid,
        "said": heard.lines,
        "links": {name: _body(link.inertial) for name, link in robot.link_map.items() if link.inertial},
        "joints": joints,
        "poses": poses,
        "pictures": sum(_has_picture(shape) for shape in robot.scene.geometry.values()),
    }


def _has_picture(shape: Any) -> bool:
    return getattr(getattr(shape.visual, "material", None), "image", None) is not None


def _body(inertial: Any) -> dict[str, Any]:
    turn = inertial.origin[:3, :3]
    tensor = turn @ inertial.inertia @ turn.T
    return {"mass": inertial.mass, "center": inertial.origin[:3, 3].tolist(), "inertia": tensor.tolist()}


def by_sapien(path: Path) -> dict[str, Any]:
    """Links, joints, poses, and how far the collision shapes of each link reach."""
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    loader = _PhysicsLoader()
    loader.set_scene(scene)
    articulations, actors = loader.load_multiple(str(path))
    if actors:
        (entity,) = actors
        part = entity.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
        moved = {entity.name: np.eye(4).tolist()}
        return {
            "links": {entity.name: _rigid(part)},
            "joints": {},
            "poses": {word: {"links": moved} for word in ("zero", "middle")},
        }
    (robot,) = articulations
    active = robot.active_joints
    joints = {
        joint.name: {
            "type": joint.type,
            "axis": joint.pose_in_child.to_transformation_matrix()[:3, 0].tolist(),
            "range": joint.limits[0].tolist(),
            "damping": float(joint.damping),
            "friction": float(joint.friction),
        }
        for joint in active
    }
    poses = {}
    for word, share in (("zero", 0.0), ("middle", 0.5)):
        robot.set_qpos([sum(joints[joint.name]["range"]) * share for joint in active])
        links = {link.name: link.entity.pose.to_transformation_matrix().tolist() for link in robot.links}
        poses[word] = {"links": links}
    return {"links": {link.name: _rigid(link) for link in robot.links}, "joints": joints, "poses": poses}


def _rigid(part: Any) -> dict[str, Any]:
    frame = part.cmass_local_pose.to_transformation_matrix()
    tensor = frame[:3, :3] @ np.diag(part.inertia) @ frame[:3, :3].T
    corners = [_corners(shape) for shape in part.collision_shapes]
    found = {"mass": float(part.mass), "center": frame[:3, 3].tolist(), "inertia": tensor.tolist()}
    if corners:
        low, high = np.min([c[0] for c in corners], axis=0), np.max([c[1] for c in corners], axis=0)
        found["touched"] = [low.tolist(), high.tolist()]
    return found


def _corners(shape: Any) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of a collision shape in the frame of its link."""
    frame = shape.local_pose.to_transformation_matrix()
    turn, center = frame[:3, :3], frame[:3, 3]
    if isinstance(shape, sapien.physx.PhysxCollisionShapeConvexMesh):
        points = (shape.vertices * shape.scale) @ turn.T + center
        return points.min(axis=0), points.max(axis=0)
    if isinstance(shape, sapien.physx.PhysxCollisionShapeBox):
        reach = np.abs(turn) @ shape.half_size
    elif isinstance(shape, sapien.physx.PhysxCollisionShapeSphere):
        reach = np.full(3, shape.radius)
    else:  # a cylinder lies along x
        along = np.abs(turn[:, 0])
        reach = along * shape.half_length + shape.radius * np.sqrt(np.maximum(0.0, 1.0 - along**2))
    return center - reach, center + reach


def main() -> None:
    """One JSON object: file -> program -> facts."""
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", DeprecationWarning)  # of yourdfpy's use of trimesh
        for name in sys.argv[1:]:
            found[name] = {"yourdfpy": by_yourdfpy(Path(name)), "sapien": by_sapien(Path(name))}
    print(json.dumps(found))


if __name__ == "__main__":
    main()
