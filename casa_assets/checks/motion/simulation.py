"""Prepare, set and measure MuJoCo models: what several checks of motion share."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.issue import Files

# Key of a scene as it begins.
START = "start"


def collision_spec(mjcf: Path | Files, name: str = "model.xml") -> mujoco.MjSpec:
    """Specification of an MJCF file without visuals and pictures, which take time to compile and touch nothing.

    Args:
        mjcf: a file on disk, or a package in memory. name: of the file in the package.
    Raises:
        ValueError: MuJoCo cannot read the file.
    """
    if isinstance(mjcf, Files):
        assets = {path: data for path, data in mjcf.entries.items() if path != name}
        spec = mujoco.MjSpec.from_string(mjcf.entries[name].decode(), assets=assets)
    else:
        spec = mujoco.MjSpec.from_file(str(mjcf))
    for geom in list(spec.geoms):
        if geom.contype == 0 and geom.conaffinity == 0:
            spec.delete(geom)
    for image in [*spec.materials, *spec.textures]:
        spec.delete(image)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
    return spec


def set_joints(model: mujoco.MjModel, data: mujoco.MjData, positions: Mapping[str, float]) -> None:
    """Reset a simulation with these joints at these positions, rad or m, and all others at their reference."""
    mujoco.mj_resetData(model, data)
    for name, value in positions.items():
        data.qpos[model.jnt_qposadr[model.joint(name).id]] = value


def reset_to_start(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Reset a simulation to its key `start`, or to the reference where it has none."""
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, START)
    if key >= 0:
        mujoco.mj_resetDataKeyframe(model, data, key)
    else:
        mujoco.mj_resetData(model, data)


@contextmanager
def altered(owner: mujoco.MjModel | mujoco.MjOption, **values: object) -> Iterator[None]:
    """While it is entered, these fields of a model, or of its options, hold these values."""
    saved = {name: copy.copy(getattr(owner, name)) for name in values}
    try:
        for name, value in values.items():
            setattr(owner, name, value)
        yield
    finally:
        for name, value in saved.items():
            setattr(owner, name, value)


def find_contacts(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute poses and contacts of the present joint positions, without dynamics."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)


def simulation_warnings(data: mujoco.MjData) -> list[str]:
    """Warnings of the simulator, such as `badqacc x 2`."""
    kinds = {int(k): k.name.removeprefix("mjWARN_").lower() for k in mujoco.mjtWarning.__members__.values()}
    return [f"{kinds[i]} x {w.number}" for i, w in enumerate(data.warning) if w.number]


def subtree(model: mujoco.MjModel, body: int) -> Mask:
    """(nbody,) a body and all that it carries."""
    carried = np.zeros(model.nbody, dtype=bool)
    carried[body] = True
    for other in range(body + 1, model.nbody):
        carried[other] |= carried[model.body_parentid[other]]
    return carried


def geom_boxes(model: mujoco.MjModel, data: mujoco.MjData, geoms: Ints) -> Floats:
    """(N, 2, 3) corners of the boxes around geoms at their present poses, world frame, metres."""
    return boxes_at(model, geoms, data.geom_xpos[geoms], data.geom_xmat[geoms])


def boxes_at(model: mujoco.MjModel, geoms: Ints, positions: Floats, rotations: Floats) -> Floats:
    """(..., N, 2, 3) corners of the boxes around geoms in poses that they have or had, world frame, metres.

    Args:
        positions, rotations: (..., N, 3) and (..., N, 9), as `geom_xpos` and `geom_xmat` of MjData have them.
    """
    turns = rotations.reshape(*positions.shape[:-1], 3, 3)
    centers = positions + np.einsum("...nij,nj->...ni", turns, model.geom_aabb[geoms, :3])
    half = np.einsum("...nij,nj->...ni", np.abs(turns), model.geom_aabb[geoms, 3:])
    return np.stack([centers - half, centers + half], axis=-2)


def vertices_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Floats:
    """(N, 3) vertices of a mesh or box, or corners of the box around another geom, world frame, metres."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        local = model.mesh_vert[start : start + count].astype(np.float64)
    elif model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX:
        local = box_corners(np.array([[-model.geom_size[geom], model.geom_size[geom]]]))
    else:
        return box_corners(geom_boxes(model, data, np.array([geom])))
    world: Floats = local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return world


def turned_vertices_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Floats:
    """Like `vertices_of`, but of a round geom the corners of the box along its own axes: closer where it is turned."""
    kind, (a, b, _) = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom]
    half = {
        mujoco.mjtGeom.mjGEOM_SPHERE: (a, a, a),
        mujoco.mjtGeom.mjGEOM_CYLINDER: (a, a, b),
        mujoco.mjtGeom.mjGEOM_CAPSULE: (a, a, a + b),
    }.get(kind)
    if half is None:
        return vertices_of(model, data, geom)
    local = box_corners(np.array([[np.negative(half), half]]))
    world: Floats = local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return world


def box_corners(boxes: Floats) -> Floats:
    """(8 N, 3) corners of (N, 2, 3) boxes."""
    grid = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
    return np.concatenate([np.where(grid, box[1], box[0]) for box in boxes])


def box_around(boxes: Floats) -> Floats:
    """(..., 2, 3) corners of the box around (..., N, 2, 3) boxes; of none it is empty."""
    lower, upper = boxes[..., 0, :].min(axis=-2, initial=np.inf), boxes[..., 1, :].max(axis=-2, initial=-np.inf)
    return np.stack([lower, upper], axis=-2)


def tilt_deg(rotation: Floats) -> float:
    """Angle between the z axis and where a (3, 3) rotation takes it, degrees."""
    return math.degrees(math.acos(min(1.0, max(-1.0, float(rotation[2, 2])))))
