"""Reduce a compiled MuJoCo model, and the MJCF of an asset, to the table of facts that formats are compared by."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any, Literal

import mujoco
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
from casa_assets.checks.readers import mujoco_load
from casa_assets.core.numeric import Floats, linear_from_srgb
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

# Rotations ------------------------------------------------------------------------------------------------------------
# Rotations of many things at once, with the same digits as `Pose` has of one.
#
# A kitchen has some thousand bodies and shapes, and a record of each costs more time than all that is computed of it.

# As `Pose` has it: unit quaternions are left alone.
OFF_UNIT = 1e-12


def canonical(quaternions: Floats) -> Floats:
    """(N, 4) quaternions (w, x, y, z) of length 1, w >= 0; where w is 0 the first that is not 0 is positive."""
    found = np.array(quaternions, dtype=np.float64).reshape(-1, 4)
    for row in np.flatnonzero(np.abs(np.linalg.norm(found, axis=1) - 1.0) > OFF_UNIT):
        found[row] /= np.linalg.norm(found[row])
    first = found[np.arange(len(found)), np.argmax(found != 0.0, axis=1)]
    found[first < 0.0] *= -1.0
    unsigned: Floats = found + 0.0  # turns -0.0 into 0.0
    return unsigned


def rotations_of(quaternions: Floats) -> Floats:
    """(N, 3, 3) rotation matrices of (N, 4) quaternions (w, x, y, z)."""
    w, x, y, z = canonical(quaternions).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    found: Floats = np.moveaxis(np.array(rows), 2, 0)
    return np.ascontiguousarray(found)


def quaternions_of(rotations: Floats) -> Floats:
    """(N, 4) quaternions (w, x, y, z) of (N, 3, 3) rotation matrices, w >= 0.

    Raises:
        ValueError: one is not a rotation.
    """
    r = rotations
    skew = np.abs(r @ r.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if skew > 1e-6 or (np.linalg.det(r) < 0).any():
        raise ValueError("matrix is not a proper rotation")
    # Ref: Shepperd 1978, the branch with the largest divisor.
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    branch = np.argmax(np.stack([trace, r[:, 0, 0], r[:, 1, 1], r[:, 2, 2]], axis=1), axis=1)
    v = np.stack([1 + trace, r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    for i in (1, 2, 3):
        at = np.flatnonzero(branch == i)
        a, b, c = i - 1, i % 3, (i + 1) % 3
        m = r[at]
        v[at, 0] = m[:, c, b] - m[:, b, c]
        v[at, 1 + a] = 1 + m[:, a, a] - m[:, b, b] - m[:, c, c]
        v[at, 1 + b] = m[:, b, a] + m[:, a, b]
        v[at, 1 + c] = m[:, c, a] + m[:, a, c]
    # Of each row by itself: a sum over an axis may differ from it in the last digit.
    lengths = np.array([np.linalg.norm(row) for row in v]).reshape(-1, 1)
    return canonical(v / lengths)


# Mujoco looks ---------------------------------------------------------------------------------------------------------
# Compiled MuJoCo model -> what its visuals look like.

COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


def looks(model: mujoco.MjModel) -> list[VisualFacts]:
    """Named geoms that have a material and touch nothing; what hangs on the world is left out."""
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    seen = np.flatnonzero(~collides & (model.geom_matid >= 0) & (model.geom_bodyid != 0)).tolist()
    surfaces = cache(lambda material: _surface(model, material))
    named = [(model.geom(geom).name, surfaces(int(model.geom_matid[geom]))) for geom in seen]
    return [
        VisualFacts(name=name, color=color, light=light, picture=picture)
        for name, (color, light, picture) in named
        if name
    ]


def _surface(model: mujoco.MjModel, material: int) -> tuple[Vec4, Vec3, str]:
    """Colour, light that it gives off and picture of a material, as `VisualFacts` has them."""
    color = linear(model.mat_rgba[material])
    glow = float(model.mat_emission[material])
    light = (glow * color[0], glow * color[1], glow * color[2])
    texture = int(model.mat_texid[material][COLOR])
    picture = "" if texture < 0 else _string(bytes(model.paths), int(model.tex_pathadr[texture]))
    return color, light, PurePosixPath(picture).name


def linear(rgba: Floats) -> Vec4:
    """Display colour -> linear, alpha as it is."""
    red, green, blue, alpha = (float(n) for n in rgba)
    return linear_from_srgb(red), linear_from_srgb(green), linear_from_srgb(blue), alpha


# Mujoco facts ---------------------------------------------------------------------------------------------------------
# Compiled MuJoCo model -> fact table, whichever format the model was loaded from.

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
    """Fact table of a compiled model; anything attached to the world body itself (a floor) is no part of it.

    Args:
        model: compiled; its bodies are called `object`, `door`, ... or end in `/object`, `/door`, ... A body without a
            name is only a frame around them.
        base: how the root meets the world, which cannot be read from a model without its world.
        words: texts that a compiled model does not contain.
        scene: whether the model holds many placements; then its poses are world_from_body.
    Raises:
        ValueError: a joint is neither free, hinge nor slide.
    """
    # World pose of each body at qpos0, the root at the origin; parents have lower indices.
    at_rest, turns = [Pose()], rotations_of(model.geom_quat)
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        local = Pose(position=three(model.body_pos[body]), quaternion=four(model.body_quat[body]))
        at_rest.append(at_rest[parent] @ local if _is_link(model, parent) else Pose())
    # Ref: mjModel.exclude_signature is (body1 << 16) + body2.
    pairs = [(int(signature) >> 16, int(signature) & 0xFFFF) for signature in model.exclude_signature]
    return AssetFacts(
        base=base,
        exclusions=[(short_name(model.body(a).name), short_name(model.body(b).name)) for a, b in pairs],
        words=words,
        bodies=[_body(model, b, at_rest[b], turns) for b in range(model.nbody) if _is_link(model, b)],
        places=_places(model),
        looks=looks(model),
        poses=_poses(model, scene),
    )


def _places(model: mujoco.MjModel) -> list[PlaceFacts]:
    """Sites of links and geoms called `reg_...`, without what MJCF derives from them or from colliders.

    Raises:
        ValueError: one is neither sphere, box nor cylinder.
    """
    found = []
    for site in map(model.site, range(model.nsite)):
        name = short_name(site.name)
        if _is_link(model, int(site.bodyid[0])) and not CORNER.fullmatch(own_name(name)):
            found.append(_place(model, name, site, linear(site.rgba)))
    for geom in map(model.geom, range(model.ngeom)):
        own = own_name(geom.name)
        if own.startswith(REGION) and _is_link(model, int(geom.bodyid[0])):
            name = geom.name.removesuffix(own) + own.removeprefix(REGION)
            found.append(_place(model, name, geom, None))
    return [place for place in found if own_name(place.name) != OUTER]


def _poses(model: mujoco.MjModel, scene: bool) -> list[PoseFacts]:
    """Poses of the bodies at each keyframe, and at zero as `closed`; empty if there are no keyframes."""
    if not model.nkey:
        return []
    links = sorted((short_name(model.body(b).name), b) for b in range(model.nbody) if _is_link(model, b))
    bodies = [b for _, b in links]
    root = next(name for name, b in links if not _is_link(model, int(model.body_parentid[b])))
    data = mujoco.MjData(model)
    found = {}
    for key in range(-1, model.nkey):
        if key < 0:
            mujoco.mj_resetData(model, data)
        else:
            mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_kinematics(model, data)
        name = CLOSED if key < 0 else model.key(key).name
        poses = zip((data.xpos[bodies] + 0.0).tolist(), canonical(data.xquat[bodies]).tolist(), strict=True)
        world_from = dict(zip((name for name, _ in links), poses, strict=True))
        found[name] = pose_facts_of_many(name, world_from, None if scene else root)
    return list(found.values())


def pose_facts(name: str, poses: Mapping[str, Pose]) -> PoseFacts:
    """Facts of a named pose. `poses`: name of a body -> root_from_body."""
    return pose_facts_of_many(name, {body: (pose.position, pose.quaternion) for body, pose in poses.items()}, None)


def pose_facts_of_many(
    name: str, world_from: Mapping[str, tuple[Sequence[float], Sequence[float]]], root: str | None
) -> PoseFacts:
    """Facts of a named pose.

    Args:
        world_from: name of a body -> its position and quaternion as `Pose` has it.
        root: the body in whose frame they are returned; None: the world frame.
    """
    if root is not None:
        poses = {body: Pose(position=at, quaternion=turn) for body, (at, turn) in world_from.items()}
        root_from_world = poses[root].inverse()
        return pose_facts(name, {body: root_from_world @ pose for body, pose in poses.items()})
    bodies = sorted(world_from)
    positions, quaternions = ([world_from[body][i] for body in bodies] for i in (0, 1))
    return PoseFacts(name=name, bodies=bodies, positions=positions, quaternions=quaternions)


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


def shape_bounds(model: mujoco.MjModel, geom: int, rotation: Floats) -> Floats:
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
    geoms = range(start, start + int(model.body_geomnum[body]))
    return [g for g in geoms if model.geom_contype[g] or model.geom_conaffinity[g]]


def bounds_around(boxes: Sequence[Floats]) -> tuple[Vec3, Vec3]:
    """Lower and upper corner of the box around (2, 3) boxes; zeros if there are no boxes."""
    if not boxes:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return three(np.min([box[0] for box in boxes], axis=0)), three(np.max([box[1] for box in boxes], axis=0))


def _is_link(model: mujoco.MjModel, body: int) -> bool:
    """True if a body is a link, not the world and not a nameless frame."""
    return body != 0 and bool(model.body(body).name)


def _body(model: mujoco.MjModel, body: int, pose: Pose, turns: Floats) -> BodyFacts:
    """`pose`: of the body at rest. `turns`: (ngeom, 3, 3) body_from_geom."""
    parent = int(model.body_parentid[body])
    principal = Pose(quaternion=four(model.body_iquat[body])).rotation
    geoms = colliders_of(model, body)
    lower, upper = bounds_around([shape_bounds(model, g, turns[g]) for g in geoms])
    return BodyFacts(
        name=short_name(model.body(body).name),
        parent=short_name(model.body(parent).name) if _is_link(model, parent) else "",
        colliders=len(geoms),
        position=pose.position,
        center_of_mass=three(model.body_ipos[body]),
        lower=lower,
        upper=upper,
        quaternion=pose.quaternion,
        mass=float(model.body_mass[body]),
        inertia=tensor_entries(principal @ np.diag(model.body_inertia[body]) @ principal.T),
        frictions={three(model.geom_friction[g]) for g in geoms},
        joint=_joint(model, body),
    )


def tensor_entries(tensor: Floats) -> tuple[float, float, float, float, float, float]:
    """(xx, yy, zz, xy, xz, yz) of a symmetric (3, 3) tensor."""
    xx, yy, zz, xy, xz, yz = (float(tensor[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return xx, yy, zz, xy, xz, yz


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


def three(values: Sequence[float] | Floats) -> Vec3:
    """Three numbers as floats of Python."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def four(values: Sequence[float] | Floats) -> Vec4:
    """Four numbers as floats of Python."""
    w, x, y, z = (float(v) for v in values)
    return w, x, y, z


# Mjcf facts -----------------------------------------------------------------------------------------------------------
# MJCF file -> fact table, by way of the model that MuJoCo compiles from it.


def facts(path: Path) -> AssetFacts:
    """The table of a model.xml or scene.xml: joints at zero, root at the origin.

    The unnamed body around `object` is no body of the asset. Base and words are custom texts.

    Raises:
        ValueError: the file does not compile, or does not say what its base is.
    """
    loaded = mujoco_load.load_mjcf(path)
    if loaded.model is None:
        raise ValueError(f"{path.name} does not compile: {loaded.error}")
    model = loaded.model
    said = texts(model)
    geoms, joints = {model.geom(i).name for i in range(model.ngeom)}, {model.joint(i).name for i in range(model.njnt)}
    table = facts_of_model(model, base=Base(said.get("base", "")), words=words(said, geoms, joints))
    frames = {b.name: Pose(position=b.position, quaternion=b.quaternion) for b in table.bodies}
    roots = [body.name for body in table.bodies if not body.parent]
    if len(roots) != 1:
        raise ValueError(f"{path.name} has {len(roots)} root bodies, not one")
    root_from_world = frames[roots[0]].inverse()
    seen = {name: root_from_world @ frame for name, frame in frames.items()}
    bodies = [b.replace(position=seen[b.name].position, quaternion=seen[b.name].quaternion) for b in table.bodies]
    return table.replace(bodies=bodies)


def words(texts: dict[str, str], geoms: set[str], joints: set[str]) -> ProgramTexts:
    """Words of the texts; of geoms and joints those that there are."""

    def after(prefix: str) -> list[tuple[str, str]]:
        return [(name.removeprefix(prefix), data) for name, data in texts.items() if name.startswith(prefix)]

    states = [(name, *data.split()) for name, data in after("state__")]
    return ProgramTexts(
        classes=texts.get("class", "").split(),
        portion=texts.get("portion", ""),
        labels=[(name, label) for label, names in after("label__") for name in names.split() if name in geoms],
        grips=[(joint, name) for joint, name in after("grip__") if joint in joints and name in geoms],
        behind=[(joint, name) for joint, name in after("behind__") if joint in joints and name in joints],
        contract=texts.get("contract", ""),
        behavior=hashlib.sha256(texts["behavior"].encode()).hexdigest() if "behavior" in texts else "",
        states=[
            StateFacts(name=name, joint=joint, value=value, interval=(float(low), float(high)))
            for name, joint, value, low, high in states
        ],
    )


def texts(model: mujoco.MjModel) -> dict[str, str]:
    """Custom texts by name."""
    data, names = bytes(model.text_data), bytes(model.names)
    starts = zip(model.name_textadr, model.text_adr, strict=True)
    return {_string(names, int(name)): _string(data, int(text)) for name, text in starts}


def _string(data: bytes, start: int) -> str:
    """The text that ends at the next zero byte."""
    return data[start : data.index(0, start)].decode()
