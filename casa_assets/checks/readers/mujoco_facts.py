"""Compiled MuJoCo model -> fact table, whichever format the model was loaded from."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.package.facts import (
    CLOSED,
    OUTER,
    AssetFacts,
    BodyFacts,
    JointFacts,
    PlaceFacts,
    PoseFacts,
    ProgramTexts,
)
from casa_assets.checks.readers.mujoco_looks import linear, looks
from casa_assets.checks.readers.rotations import canonical, rotations_of
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

Array = npt.NDArray[np.float64]

KINDS = {
    int(mujoco.mjtJoint.mjJNT_HINGE): JointKind.HINGE,
    int(mujoco.mjtJoint.mjJNT_SLIDE): JointKind.SLIDE,
}
FREE_JOINT = int(mujoco.mjtJoint.mjJNT_FREE)
PLACES: dict[int, Literal["sphere", "box", "cylinder"]] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
}
# What robocasa calls a region. Ref: robocasa v1.0, models/fixtures.
REGION = "reg_"
# Sites that MJCF repeats a region by, for robocasa v0.2.
CORNER = re.compile(r"(ext|int)_p[0xyz]")
# The prim that holds the placements of a scene (no asset is called so), and the root link of an asset.
WORLD, ROOT_BODY = "World", "object"


def facts_of_model(model: mujoco.MjModel, *, base: Base, words: ProgramTexts, scene: bool = False) -> AssetFacts:
    """Fact table of a compiled model; what hangs on the world body itself (a floor) is no part of it.

    Args:
        model: compiled; its bodies are called `object`, `door`, ... or end in `/object`, `/door`, ... A body without a
            name is only a frame around them.
        base: how the root meets the world, which a model without its world does not tell.
        words: what a compiled model does not carry.
        scene: whether the model holds many placements; then its poses are world_from_body.
    Raises:
        ValueError: a joint is neither free, hinge nor slide.
    """
    at_rest, turns = _rest_poses(model), rotations_of(model.geom_quat)
    bodies = [_body(model, b, at_rest[b], turns) for b in range(model.nbody) if _is_link(model, b)]
    bodies.sort(key=lambda body: body.name)
    return AssetFacts(
        base=base,
        bodies=tuple(bodies),
        exclusions=_exclusions(model),
        places=places(model),
        looks=looks(model),
        poses=poses(model, scene),
        words=words,
    )


def places(model: mujoco.MjModel) -> tuple[PlaceFacts, ...]:
    """Sites of links and geoms called `reg_...`, sorted by name; without what MJCF derives from them or from colliders.

    Raises:
        ValueError: one is neither sphere, box nor cylinder.
    """
    found = []
    for i in range(model.nsite):
        site = model.site(i)
        name = short_name(site.name)
        if _is_link(model, int(site.bodyid[0])) and not CORNER.fullmatch(own_name(name)):
            found.append(_place(model, name, site, linear(tuple(float(n) for n in site.rgba))))
    for i in range(model.ngeom):
        geom = model.geom(i)
        own = own_name(geom.name)
        if own.startswith(REGION) and _is_link(model, int(geom.bodyid[0])):
            name = geom.name.removesuffix(own) + own.removeprefix(REGION)
            found.append(_place(model, name, geom, None))
    return tuple(sorted((p for p in found if own_name(p.name) != OUTER), key=lambda place: place.name))


def poses(model: mujoco.MjModel, scene: bool = False) -> tuple[PoseFacts, ...]:
    """Poses of the bodies at each keyframe, and at zero as `closed`; none where there are no keyframes."""
    if not model.nkey:
        return ()
    links = sorted((short_name(model.body(b).name), b) for b in range(model.nbody) if _is_link(model, b))
    bodies = [b for _, b in links]
    tops = [name for name, b in links if not _is_link(model, int(model.body_parentid[b]))]
    data = mujoco.MjData(model)
    found = {}
    for key in range(-1, model.nkey):
        if key < 0:
            mujoco.mj_resetData(model, data)
        else:
            mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_kinematics(model, data)
        positions, quaternions = data.xpos[bodies] + 0.0, canonical(data.xquat[bodies])
        world_from = {
            name: (three(at), four(turn))
            for (name, _), at, turn in zip(links, positions.tolist(), quaternions.tolist(), strict=True)
        }
        name = CLOSED if key < 0 else model.key(key).name
        found[name] = pose_facts(name, world_from, None if scene else tops[0])
    return tuple(found[name] for name in sorted(found))


def pose_facts(name: str, world_from: Mapping[str, tuple[Vec3, Vec4]], root: str | None) -> PoseFacts:
    """Facts of a named pose.

    Args:
        world_from: name of a body -> its position and quaternion as `Pose` has it. root: the body in whose frame they
            are told; None: in that of the world.
    """
    stand = {body: world_from[body] for body in sorted(world_from)}
    if root is not None:
        poses = {body: Pose(position=at, quaternion=turn) for body, (at, turn) in stand.items()}
        seen = [poses[root].inverse() @ pose for pose in poses.values()]
        stand = {body: (pose.position, pose.quaternion) for body, pose in zip(poses, seen, strict=True)}
    return PoseFacts(
        name=name,
        bodies=tuple(stand),
        positions=tuple(at for at, _ in stand.values()),
        quaternions=tuple(turn for _, turn in stand.values()),
    )


def free_bodies(model: mujoco.MjModel) -> list[int]:
    """Bodies that float, in the order of their joints."""
    return [int(body) for body in model.jnt_bodyid[model.jnt_type == FREE_JOINT]]


def short_name(name: str) -> str:
    """`/mug_0123456789/object` -> `object`: names that come from USD are prim paths.

    In a scene they are called as in MJCF: `/World/cup/object` -> `cup`, `/World/cup/object/sites/fill` -> `cup__fill`.
    """
    parts = name.split("/")
    if len(parts) < 4 or parts[1] != WORLD:
        return parts[-1]
    return parts[2] if parts[3:] == [ROOT_BODY] else f"{parts[2]}__{parts[-1]}"


def own_name(name: str) -> str:
    """`cup__fill` -> `fill`: a name within its placement."""
    return name.rsplit("__", 1)[-1]


def shape_bounds(model: mujoco.MjModel, geom: int, rotation: Array) -> Array:
    """(2, 3) corners of the box around a geom, body frame, metres; exact for every kind of shape.

    Args:
        rotation: (3, 3) body_from_geom.
    """
    kind, size, centre = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom], model.geom_pos[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        points = model.mesh_vert[start : start + count].astype(np.float64) @ rotation.T + centre
        return np.array([points.min(axis=0), points.max(axis=0)])
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        half = np.abs(rotation) @ size
    elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        half = np.full(3, size[0])
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        half = np.abs(rotation[:, 2]) * size[1] + size[0]
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        half = np.abs(rotation[:, 2]) * size[1] + size[0] * np.sqrt(np.clip(1 - rotation[:, 2] ** 2, 0, 1))
    else:
        raise ValueError(f"geom {model.geom(geom).name!r} is a {kind.name}, which no asset has")
    return np.array([centre - half, centre + half])


def colliders_of(model: mujoco.MjModel, body: int) -> list[int]:
    """Geoms of a body that can touch anything."""
    start = int(model.body_geomadr[body])
    return [g for g in range(start, start + int(model.body_geomnum[body])) if collides(model, g)]


def bounds_around(boxes: Sequence[Array]) -> tuple[Vec3, Vec3]:
    """Lower and upper corner of the box around (2, 3) boxes; zeros where there is none."""
    if not boxes:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return three(np.min([box[0] for box in boxes], axis=0)), three(np.max([box[1] for box in boxes], axis=0))


def _rest_poses(model: mujoco.MjModel) -> list[Pose]:
    """World pose of each body at qpos0, the root at the origin; parents have lower indices."""
    poses = [Pose()]
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        local = Pose(position=three(model.body_pos[body]), quaternion=four(model.body_quat[body]))
        poses.append(poses[parent] @ local if _is_link(model, parent) else Pose())
    return poses


def _is_link(model: mujoco.MjModel, body: int) -> bool:
    """True if a body is a link, not the world and not a nameless frame."""
    return body != 0 and bool(model.body(body).name)


def _body(model: mujoco.MjModel, body: int, pose: Pose, turns: Array) -> BodyFacts:
    """`pose`: of the body at rest. `turns`: (ngeom, 3, 3) body_from_geom."""
    parent = int(model.body_parentid[body])
    principal = Pose(quaternion=four(model.body_iquat[body])).rotation
    tensor = principal @ np.diag(model.body_inertia[body]) @ principal.T
    geoms = colliders_of(model, body)
    lower, upper = bounds_around([shape_bounds(model, g, turns[g]) for g in geoms])
    return BodyFacts(
        name=short_name(model.body(body).name),
        parent=short_name(model.body(parent).name) if _is_link(model, parent) else "",
        position=pose.position,
        quaternion=pose.quaternion,
        mass=float(model.body_mass[body]),
        center_of_mass=three(model.body_ipos[body]),
        inertia=tensor_entries(tensor),
        colliders=len(geoms),
        lower=lower,
        upper=upper,
        frictions=tuple(sorted({three(model.geom_friction[g]) for g in geoms})),
        joint=_joint(model, body),
    )


def tensor_entries(tensor: Array) -> tuple[float, float, float, float, float, float]:
    """(xx, yy, zz, xy, xz, yz) of a symmetric (3, 3) tensor."""
    t = tensor
    return float(t[0, 0]), float(t[1, 1]), float(t[2, 2]), float(t[0, 1]), float(t[0, 2]), float(t[1, 2])


def _joint(model: mujoco.MjModel, body: int) -> JointFacts | None:
    start = int(model.body_jntadr[body])
    for joint in range(start, start + int(model.body_jntnum[body])):
        kind = int(model.jnt_type[joint])
        if kind == FREE_JOINT:
            continue
        if kind not in KINDS:
            raise ValueError(f"joint {model.joint(joint).name!r} is neither hinge nor slide")
        low, high = (float(n) for n in model.jnt_range[joint])
        return JointFacts(
            name=short_name(model.joint(joint).name),
            kind=KINDS[kind],
            axis=three(model.jnt_axis[joint]),
            anchor=three(model.jnt_pos[joint]),
            range=(low, high),
            resistance=resistance(model, joint),
        )
    return None


def resistance(model: mujoco.MjModel, joint: int) -> tuple[float, float, float, float, float]:
    """(stiffness, where that spring rests, damping, frictionloss, armature) of a joint, SI."""
    dof, position = int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
    return (
        float(model.jnt_stiffness[joint]),
        float(model.qpos_spring[position]),
        float(model.dof_damping[dof]),
        float(model.dof_frictionloss[dof]),
        float(model.dof_armature[dof]),
    )


def _place(model: mujoco.MjModel, name: str, item: Any, color: Vec4 | None) -> PlaceFacts:
    """A site or geom of a model; `item` is the view of it."""
    kind = PLACES.get(int(item.type[0]))
    if kind is None:
        raise ValueError(f"place {name!r} is neither sphere, box nor cylinder")
    a, b, c = (2 * float(n) for n in item.size)
    # MuJoCo keeps radius, or radius and half height, in the first cells.
    size = {"sphere": (a, a, a), "box": (a, b, c), "cylinder": (a, a, b)}[kind]
    return PlaceFacts(
        name=name,
        body=short_name(model.body(int(item.bodyid[0])).name),
        kind=kind,
        position=three(item.pos),
        quaternion=four(item.quat),
        size=size,
        color=color,
    )


def collides(model: mujoco.MjModel, geom: int) -> bool:
    """True if a geom can touch anything."""
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def _exclusions(model: mujoco.MjModel) -> tuple[tuple[str, str], ...]:
    pairs = []
    for signature in model.exclude_signature:
        # Ref: mjModel.exclude_signature is (body1 << 16) + body2.
        names = [short_name(model.body(int(b)).name) for b in (signature >> 16, signature & 0xFFFF)]
        pairs.append((min(names), max(names)))
    return tuple(sorted(set(pairs)))


def three(values: Sequence[float] | Array) -> Vec3:
    """Three numbers as floats of Python."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def four(values: Sequence[float] | Array) -> Vec4:
    """Four numbers as floats of Python."""
    w, x, y, z = (float(v) for v in values)
    return w, x, y, z
