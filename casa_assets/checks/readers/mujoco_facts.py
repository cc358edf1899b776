"""MJCF file -> compiled model with every warning; compiled model -> the table of facts that formats are compared by."""

from __future__ import annotations

import hashlib
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, Literal

import mujoco
import numpy as np

from casa_assets.checks.readers.facts import (
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
    bounds_around,
    canonical,
    four,
    own_name,
    pose_facts,
    rotations_of,
    short_name,
    tensor_entries,
    three,
)
from casa_assets.core.numeric import Floats, linear_from_srgb
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

# Load -----------------------------------------------------------------------------------------------------------------
# MJCF file -> compiled model with every warning, compiled once however many checks ask.

# Models kept at once: an asset's model and its scene, for a few assets.
KEPT = 8


@dataclass(frozen=True)
class Loaded:
    """Outcome of compiling a file.

    Attributes:
        model: compiled; shared by all callers, so copy before changing it. None if the file does not compile.
        error: MuJoCo's message, empty if it compiles.
        warnings: each once, in the order in which they came.
    """

    model: mujoco.MjModel | None
    error: str
    warnings: tuple[str, ...]


def load_mjcf(path: Path) -> Loaded:
    """Compile an MJCF file; again only if it, or a file in the `meshes` or `textures` next to it, has changed."""
    found = [path, *(f for folder in ("meshes", "textures") for f in sorted((path.parent / folder).glob("*")))]
    stats = [(f.name, f.stat()) for f in found if f.exists()]
    return _load(path, tuple((name, stat.st_mtime_ns, stat.st_size) for name, stat in stats))


@lru_cache(maxsize=KEPT)
def _load(path: Path, state: tuple[tuple[str, int, int], ...]) -> Loaded:
    return load_asset_file(path)


def load_asset_file(path: Path) -> Loaded:
    """Compiles any file that MuJoCo reads, without remembering it."""
    with all_warnings() as said:
        try:
            model, error = mujoco.MjModel.from_xml_path(str(path)), ""
        except ValueError as problem:
            model, error = None, " ".join(str(problem).split())
    return Loaded(model, error, tuple(dict.fromkeys(said)))


@contextmanager
def native_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's own warnings within the block, through its callback.

    Without a listener it prints its warnings, and writes a log into the working folder.
    """
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        yield said
    finally:
        mujoco.set_mju_user_warning(before)


@contextmanager
def all_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's own warnings and Python's, a line each, once the block has ended."""
    with native_warnings() as said, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield said
        finally:
            said[:] = [" ".join(s.split()) for s in (*said, *(str(w.message) for w in caught))]


# Model ----------------------------------------------------------------------------------------------------------------

COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
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


def facts_of_model(model: mujoco.MjModel, *, base: Base, words: ProgramTexts, scene: bool = False) -> AssetFacts:
    """Fact table of a compiled model; anything attached to the world body itself (a floor) is no part of it.

    Args:
        model: compiled; its bodies are called `object`, `door`, ... or end in `/object`, `/door`, ... A body without a
            name is only a frame around them.
        base: how the root meets the world, which cannot be read from a model without its world.
        words: texts that a compiled model does not contain.
        scene: whether the model holds many placements; then its poses are world_from_body.
    Raises:
        ValueError: a joint is neither free, hinge nor slide, or a place neither sphere, box nor cylinder.
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
        looks=_looks(model),
        poses=_poses(model, scene),
    )


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


def free_bodies(model: mujoco.MjModel) -> list[int]:
    """Bodies that float, in the order of their joints."""
    return [int(body) for body in model.jnt_bodyid[model.jnt_type == FREE_JOINT]]


def colliders_of(model: mujoco.MjModel, body: int) -> list[int]:
    """Geoms of a body that can touch anything."""
    start = int(model.body_geomadr[body])
    geoms = range(start, start + int(model.body_geomnum[body]))
    return [g for g in geoms if model.geom_contype[g] or model.geom_conaffinity[g]]


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


def _places(model: mujoco.MjModel) -> list[PlaceFacts]:
    """Sites of links and geoms called `reg_...`, without what MJCF derives from them or from colliders."""
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


def _looks(model: mujoco.MjModel) -> list[VisualFacts]:
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
        frames = zip((data.xpos[bodies] + 0.0).tolist(), canonical(data.xquat[bodies]).tolist(), strict=True)
        found[name] = pose_facts(
            name, dict(zip((name for name, _ in links), frames, strict=True)), None if scene else root
        )
    return list(found.values())


def facts(path: Path) -> AssetFacts:
    """The table of a model.xml or scene.xml: joints at zero, root at the origin.

    The unnamed body around `object` is no body of the asset. Base and words are custom texts.

    Raises:
        ValueError: the file does not compile, or does not say what its base is.
    """
    loaded = load_mjcf(path)
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
