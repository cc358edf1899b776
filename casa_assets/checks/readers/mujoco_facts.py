"""MJCF of an asset or scene -> compiled model with every warning; compiled model -> table of facts."""

from __future__ import annotations

import hashlib
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path, PurePosixPath
from typing import Any

import mujoco
import numpy as np

from casa_assets.checks.readers.facts import (
    CLOSED,
    Cells,
    Difference,
    asset_table,
    body_cells,
    four,
    joint_cells,
    look_cells,
    own_name,
    place_cells,
    relative,
    scene_table,
    seen_from,
    short_name,
    state_cells,
    tensor_entries,
    three,
    words_cells,
)
from casa_assets.core.numeric import Floats, linear_from_srgb
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4

# Models kept at once: an asset's model and its scene, for a few assets.
KEPT = 8
COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
KINDS = {int(mujoco.mjtJoint.mjJNT_HINGE): JointKind.HINGE, int(mujoco.mjtJoint.mjJNT_SLIDE): JointKind.SLIDE}
FREE_JOINT = int(mujoco.mjtJoint.mjJNT_FREE)
PLACES = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
}
# How robocasa's names of regions begin. Ref: robocasa v1.0, models/fixtures.
REGION = "reg_"
# Sites that MJCF repeats a region by, for robocasa v0.2.
CORNER = re.compile(r"(ext|int)_p[0xyz]")
# As `Pose` has it: unit quaternions are left alone.
OFF_UNIT = 1e-12
# MuJoCo's cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = 180.0
# Texts that every placement has.
ASSET, LAYER = "asset", "layer"

# Load -----------------------------------------------------------------------------------------------------------------


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
    with all_warnings() as heard:
        try:
            model, error = mujoco.MjModel.from_xml_path(str(path)), ""
        except ValueError as problem:
            model, error = None, " ".join(str(problem).split())
    return Loaded(model, error, tuple(dict.fromkeys(heard)))


@contextmanager
def native_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's own warnings within the block, through its callback.

    Without a listener it prints its warnings, and writes a log into the working folder.
    """
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        yield heard
    finally:
        mujoco.set_mju_user_warning(before)


@contextmanager
def all_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's own warnings and Python's, a line each, once the block has ended."""
    with native_warnings() as heard, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield heard
        finally:
            heard[:] = [" ".join(s.split()) for s in (*heard, *(str(w.message) for w in caught))]


# Asset ----------------------------------------------------------------------------------------------------------------


def facts(path: Path) -> Cells:
    """The table of a model.xml or scene.xml: joints at zero, root at the origin.

    The unnamed body around `object` is no body of the asset. Base and words are custom texts.

    Raises:
        ValueError: the file does not compile, or does not say what its base is.
    """
    loaded = load_mjcf(path)
    if loaded.model is None:
        raise ValueError(f"{path.name} does not compile: {loaded.error}")
    model = loaded.model
    stated = texts(model)
    geoms, joints = {model.geom(i).name for i in range(model.ngeom)}, {model.joint(i).name for i in range(model.njnt)}
    table = facts_of_model(model, base=Base(stated.get("base", "")), words=words(stated, geoms, joints))
    roots = [name for name, body in table["bodies"].items() if not body["parent"]]
    if len(roots) != 1:
        raise ValueError(f"{path.name} has {len(roots)} root bodies, not one")
    places = {n: {cell: body[cell] for cell in ("position", "quaternion")} for n, body in table["bodies"].items()}
    seen = seen_from(roots[0], places)
    return {**table, "bodies": {name: body | seen[name] for name, body in table["bodies"].items()}}


def facts_of_model(
    model: mujoco.MjModel, *, base: str = Base.FIXED, words: Cells | None = None, scene: bool = False
) -> Cells:
    """Fact table of a compiled model; anything attached to the world body itself (a floor) is no part of it.

    Args:
        model: compiled; its bodies are called `object`, `door`, ... or end in `/object`, `/door`, ... A body without a
            name is only a frame around them.
        base: how the root meets the world, which cannot be read from a model without its world.
        words: cells of texts, which a compiled model of USD or URDF does not contain.
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
    names = [short_name(model.body(body).name) for body in range(model.nbody)]
    # Ref: mjModel.exclude_signature is (body1 << 16) + body2.
    pairs = [(int(signature) >> 16, int(signature) & 0xFFFF) for signature in model.exclude_signature]
    links = [body for body in range(model.nbody) if _is_link(model, body)]
    return asset_table(
        base=base,
        words=words or {},
        exclusions=[(names[a], names[b]) for a, b in pairs],
        bodies=[(names[b], _body(model, b, at_rest[b], turns)) for b in links],
        places=_places(model, names),
        looks=_looks(model),
        poses=dict(_poses(model, {names[b]: b for b in links}, scene)).items(),
    )


def _is_link(model: mujoco.MjModel, body: int) -> bool:
    """True if a body is a link, not the world and not a nameless frame."""
    return body != 0 and bool(model.body(body).name)


def _body(model: mujoco.MjModel, body: int, pose: Pose, turns: Floats) -> Cells:
    """`pose`: of the body at rest. `turns`: (ngeom, 3, 3) body_from_geom."""
    parent = int(model.body_parentid[body])
    principal = Pose(quaternion=four(model.body_iquat[body])).rotation
    geoms = colliders_of(model, body)
    return body_cells(
        parent=short_name(model.body(parent).name) if _is_link(model, parent) else "",
        place=pose,
        mass=float(model.body_mass[body]),
        center_of_mass=three(model.body_ipos[body]),
        inertia=tensor_entries(principal @ np.diag(model.body_inertia[body]) @ principal.T),
        colliders=len(geoms),
        boxes=[shape_bounds(model, g, turns[g]) for g in geoms],
        frictions=[three(model.geom_friction[g]) for g in geoms],
        joint=_joint(model, body),
    )


def _joint(model: mujoco.MjModel, body: int) -> Cells | None:
    start = int(model.body_jntadr[body])
    for number in range(start, start + int(model.body_jntnum[body])):
        joint, kind = model.joint(number), int(model.jnt_type[number])
        if kind == FREE_JOINT:
            continue
        if kind not in KINDS:
            raise ValueError(f"joint {joint.name!r} is neither hinge nor slide")
        stiff = resistance(model, number)
        name = short_name(joint.name)
        return joint_cells(name, KINDS[kind], three(joint.axis), three(joint.pos), joint.range, stiff)
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


def _places(model: mujoco.MjModel, bodies: list[str]) -> Iterator[tuple[str, Cells]]:
    """Sites of links and geoms called `reg_...`, without what MJCF derives from them."""
    for site in map(model.site, range(model.nsite)):
        name = short_name(site.name)
        if bodies[int(site.bodyid[0])] and site.bodyid[0] and not CORNER.fullmatch(own_name(name)):
            yield name, _place(name, site, bodies, linear(site.rgba))
    for geom in map(model.geom, range(model.ngeom)):
        own = own_name(geom.name)
        if own.startswith(REGION) and bodies[int(geom.bodyid[0])] and geom.bodyid[0]:
            name = geom.name.removesuffix(own) + own.removeprefix(REGION)
            yield name, _place(name, geom, bodies, None)


def _place(name: str, item: Any, bodies: list[str], color: Vec4 | None) -> Cells:
    """A site or geom of a model; `item` is the view of it."""
    kind = PLACES.get(int(item.type[0]))
    if kind is None:
        raise ValueError(f"place {name!r} is neither sphere, box nor cylinder")
    a, b, c = (2 * float(n) for n in item.size)
    # MuJoCo keeps radius, or radius and half height, in the first cells.
    size = {"sphere": (a, a, a), "box": (a, b, c), "cylinder": (a, a, b)}[kind]
    place = {"position": three(item.pos), "quaternion": four(item.quat)}
    return place_cells(bodies[int(item.bodyid[0])], kind, place, size, color)


def _looks(model: mujoco.MjModel) -> Iterator[tuple[str, Cells]]:
    """Named geoms that have a material and touch nothing; what hangs on the world is left out."""
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    surfaces = cache(lambda material: _surface(model, material))
    for geom in np.flatnonzero(~collides & (model.geom_matid >= 0) & (model.geom_bodyid != 0)).tolist():
        if name := model.geom(geom).name:
            yield name, surfaces(int(model.geom_matid[geom]))


def _surface(model: mujoco.MjModel, material: int) -> Cells:
    """Colour, light that it gives off and picture of a material."""
    color = linear(model.mat_rgba[material])
    glow, texture = float(model.mat_emission[material]), int(model.mat_texid[material][COLOR])
    picture = "" if texture < 0 else _string(bytes(model.paths), int(model.tex_pathadr[texture]))
    return look_cells(color, [glow * channel for channel in color[:3]], PurePosixPath(picture).name)


def linear(rgba: Floats) -> Vec4:
    """Display colour -> linear, alpha as it is."""
    red, green, blue, alpha = (float(n) for n in rgba)
    return linear_from_srgb(red), linear_from_srgb(green), linear_from_srgb(blue), alpha


def _poses(model: mujoco.MjModel, links: dict[str, int], scene: bool) -> Iterator[tuple[str, Cells]]:
    """Poses of the bodies at each keyframe, and at zero as `closed`; none if there are no keyframes."""
    data, bodies = mujoco.MjData(model), list(links.values())
    root = next((name for name, b in links.items() if not _is_link(model, int(model.body_parentid[b]))), "")
    for key in range(-1, model.nkey) if model.nkey else ():
        if key < 0:
            mujoco.mj_resetData(model, data)
        else:
            mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_kinematics(model, data)
        places = zip(data.xpos[bodies] + 0.0, canonical(data.xquat[bodies]), strict=True)
        frames = {
            name: {"position": tuple(at.tolist()), "quaternion": tuple(turn.tolist())}
            for name, (at, turn) in zip(links, places, strict=True)
        }
        yield (CLOSED if key < 0 else model.key(key).name), frames if scene else seen_from(root, frames)


def words(texts: dict[str, str], geoms: set[str], joints: set[str], prefix: str = "") -> Cells:
    """Words of the texts; of geoms and joints those that there are.

    Args:
        prefix: of the names of geoms and joints of a placement, without which they are in the table.
    """

    def after(start: str) -> list[tuple[str, str]]:
        return [(name.removeprefix(start), data) for name, data in texts.items() if name.startswith(start)]

    def own(name: str, known: set[str]) -> str:
        return name.removeprefix(prefix) if name in known and name.startswith(prefix) else ""

    grips, behind = ([(j, n) for j, n in after(kind) if prefix + j in joints] for kind in ("grip__", "behind__"))
    labelled = [(own(name, geoms), label) for label, names in after("label__") for name in names.split()]
    states = [(name, *data.split()) for name, data in after("state__")]
    return words_cells(
        classes=texts.get("class", "").split(),
        portion=texts.get("portion", ""),
        labels=[(name, label) for name, label in labelled if name],
        grips=[(joint, own(name, geoms)) for joint, name in grips if own(name, geoms)],
        behind=[(joint, own(name, joints)) for joint, name in behind if own(name, joints)],
        contract=texts.get("contract", ""),
        behavior=hashlib.sha256(texts["behavior"].encode()).hexdigest() if "behavior" in texts else "",
        # A joint of another placement becomes one that there is not.
        states=[(n, state_cells(f"?{j}".removeprefix(f"?{prefix}"), value, *span)) for n, j, value, *span in states],
    )


def texts(model: mujoco.MjModel) -> dict[str, str]:
    """Custom texts by name."""
    data, names = bytes(model.text_data), bytes(model.names)
    starts = zip(model.name_textadr, model.text_adr, strict=True)
    return {_string(names, int(name)): _string(data, int(text)) for name, text in starts}


def _string(data: bytes, start: int) -> str:
    """The text that ends at the next zero byte."""
    return data[start : data.index(0, start)].decode()


# Scene ----------------------------------------------------------------------------------------------------------------


def facts_of_scene(model: mujoco.MjModel) -> Cells:
    """The table of a compiled scene.xml. Raises ValueError where it names no body for a placement."""
    cameras = [
        (c.name, {"position": three(c.pos), "quaternion": four(c.quat), "fov_y_deg": float(c.fovy[0])})
        for c in map(model.camera, range(model.ncam))
    ]
    lights = [(light.name, _light(light)) for light in map(model.light, range(model.nlight))]
    things = facts_of_model(model, scene=True)
    return scene_table(three(model.opt.gravity), _placements(model), cameras, lights, things)


def _placements(model: mujoco.MjModel) -> Iterator[tuple[str, Cells]]:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geoms, joints = {model.geom(i).name for i in range(model.ngeom)}, {model.joint(i).name for i in range(model.njnt)}
    bodies = {model.body(i).name: i for i in range(1, model.nbody)}
    free = set(free_bodies(model))
    stated: dict[str, dict[str, str]] = {}  # `cup__base` -> `cup` -> `base`
    for name, text in texts(model).items():
        placement, _, own = name.partition("__")
        if own:
            stated.setdefault(placement, {})[own] = text
    for name, own_texts in sorted(stated.items()):
        if name not in bodies:
            raise ValueError(f"there are texts of {name!r}, which is no body")
        body = bodies[name]
        cells = {
            "asset": own_texts.get(ASSET, ""),
            "layer": own_texts.get(LAYER, ""),
            "base": Base.FREE if body in free else Base.FIXED,
            "position": three(data.xpos[body]),
            "quaternion": four(data.xquat[body]),
        }
        yield name, cells | words(own_texts, geoms, joints, f"{name}__")


def _light(light: Any) -> Cells:
    """`light`: its view in the model. A point light is written as a spot whose cone holds all directions."""
    kinds, cutoff = mujoco.mjtLightType, float(light.cutoff[0])
    is_directional = light.type[0] == kinds.mjLIGHT_DIRECTIONAL
    is_cone = light.type[0] == kinds.mjLIGHT_SPOT and cutoff < ALL_SIDES_DEG
    return {
        "kind": "directional" if is_directional else "spot" if is_cone else "point",
        "castshadow": bool(light.castshadow[0]),
        "position": three(light.pos),
        "direction": three(light.dir) if is_directional or is_cone else (0.0, 0.0, 0.0),
        "tint": three(light.diffuse / max(float(light.diffuse.max()), 1e-12)),
        "cone_deg": cutoff if is_cone else 0.0,
    }


# Contact and joint parameters -----------------------------------------------------------------------------------------


def parameter_differences(expected: mujoco.MjModel, actual: mujoco.MjModel) -> list[Difference]:
    """Differences of contact and joint parameters that two models have in common."""
    one, other = _parameters(expected), _parameters(actual)
    return [relative(key, one[key], other[key]) for key in sorted(one.keys() & other.keys())]


def _parameters(model: mujoco.MjModel) -> dict[str, Floats]:
    """Contact and joint parameters of a model, by pointer.

    Of a body one row per collider, in an order that does not depend on names; of a joint one row.
    """
    table: dict[str, Floats] = {}
    # (ngeom, 14)
    plain = (model.geom_contype, model.geom_conaffinity, model.geom_condim, model.geom_priority)
    soft = (model.geom_solmix, model.geom_margin, model.geom_gap)
    contacts = np.column_stack([*plain, *soft, model.geom_solref, model.geom_solimp])
    for body in range(1, model.nbody):
        rows = sorted(contacts[colliders_of(model, body)].tolist())
        if rows:
            table[f"bodies/{short_name(model.body(body).name)}/contacts"] = np.array(rows)
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) != FREE_JOINT:
            dof = int(model.jnt_dofadr[joint])
            # How dry friction gives way: solref and solimp.
            yielding = (*model.dof_solref[dof], *model.dof_solimp[dof])
            table[f"joints/{short_name(model.joint(joint).name)}"] = np.array((*resistance(model, joint), *yielding))
    return table
