"""Prepare, set, move, drop and measure MuJoCo models: what several checks of motion share."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.check import Package
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.readers.mujoco_facts import rotations_of
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.asset import Asset, Collider, Joint, JointKind
from casa_assets.model.issue import Files
from casa_assets.model.pose import Pose

START = "start"  # key of a scene as it begins
# How far the part of a joint that moves fastest goes between two poses. A corner that swings past an edge on an arm of
# 0.6 m and meets it by half a millimetre does so over 49 mm of its way. Parts of 4 mm that slide past each other meet
# over 8 mm, and are near for 14 mm.
SWEEP_STEP_M = 0.012
MIN_POSES, MAX_POSES = 12, 160
# Parts nearer than this are reported. Around the deepest of the poses at which they come nearest, poses are finer.
MARGIN_M = 0.003
FINE_POSES = 6
REFINED_PEAKS = 2
STEP_S = 0.002
CACHED_MODELS = 4
TUNNEL_M = 0.1  # deeper than this a thing that was dropped has fallen through the floor; our choice
CACHED_DROPS = 4


def collision_spec(mjcf: Path | Files, name: str = "model.xml") -> mujoco.MjSpec:
    """Specification of an MJCF file, on disk or `name` of a package, without visuals and pictures, which touch nothing.

    Raises ValueError: MuJoCo cannot read the file.
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
    """(..., N, 2, 3) corners of boxes around geoms at `geom_xpos` (..., N, 3), `geom_xmat` (..., N, 9); world, m."""
    turns = rotations.reshape(*positions.shape[:-1], 3, 3)
    centers = positions + np.einsum("...nij,nj->...ni", turns, model.geom_aabb[geoms, :3])
    half = np.einsum("...nij,nj->...ni", np.abs(turns), model.geom_aabb[geoms, 3:])
    return np.stack([centers - half, centers + half], axis=-2)


def vertices_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int, turned: bool = False) -> Floats:
    """(N, 3) vertices of a mesh or box, or corners of the box around another geom, world frame, metres.

    `turned`: of a round geom those of the box along its own axes, which is closer to it.
    """
    (a, b, c), kind = model.geom_size[geom], mujoco.mjtGeom(model.geom_type[geom])
    half = {mujoco.mjtGeom.mjGEOM_BOX: (a, b, c)}
    if turned:
        half |= {mujoco.mjtGeom.mjGEOM_SPHERE: (a, a, a), mujoco.mjtGeom.mjGEOM_CYLINDER: (a, a, b)}
        half |= {mujoco.mjtGeom.mjGEOM_CAPSULE: (a, a, a + b)}
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        local = model.mesh_vert[start : start + count].astype(np.float64)
    elif kind in half:
        local = box_corners(np.array([[np.negative(half[kind]), half[kind]]]))
    else:
        return box_corners(geom_boxes(model, data, np.array([geom])))
    return np.asarray(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])


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


@dataclass(frozen=True)
class Penetration:
    """Deepest contact of two geoms, metres (negative: their distance), and the names of them and of their bodies."""

    depth: float = -MARGIN_M
    geom1: str = ""
    geom2: str = ""
    body1: str = ""
    body2: str = ""


@dataclass(frozen=True)
class SweepResult:
    """The deepest contact of a sweep, and (2, 3) corners of the box that the moved geoms passed through, metres."""

    worst: Penetration
    bounds: Floats


def deepest_contacts(scene: Path) -> dict[str, float]:
    """Joint name -> deepest penetration between bodies of the asset, metres, over its range with all others at zero.

    Those that the file names as standing before a joint are open. Contacts that the model excludes do not count, nor do
    those with the floor. Empty where the scene does not compile.
    """
    loaded = mujoco_facts.load_mjcf(scene).model
    found = {} if loaded is None else _deepest_contacts(loaded)
    return {joint: max(0.0, contact.depth) for joint, contact in found.items()}


def contacts_of_files(mjcf: Files) -> dict[str, tuple[Penetration, float]]:
    """Joint name -> deepest contact over its range, and depth (m) of the same two bodies with all joints at zero.

    `mjcf`: a package in memory with its `scene.xml`. Raises ValueError: MuJoCo cannot read the file.
    """
    model = collision_spec(mjcf, "scene.xml").compile()
    return {joint: (contact, _depth_at_rest(model, contact)) for joint, contact in _deepest_contacts(model).items()}


def _deepest_contacts(compiled: mujoco.MjModel) -> dict[str, Penetration]:
    model, texts = with_margins(compiled), mujoco_facts.texts(compiled)
    found: dict[str, Penetration] = {}
    data = mujoco.MjData(model)
    for joint in map(int, np.flatnonzero(model.jnt_type != mujoco.mjtJoint.mjJNT_FREE)):
        mujoco.mj_resetData(model, data)
        # Joints that have to be open before it can move, as the custom texts `behind__<joint>` have it.
        opened: set[int] = set()
        before = texts.get(f"behind__{model.joint(joint).name}")
        while before is not None and (number := int(model.joint(before).id)) not in opened:
            opened.add(number)
            data.qpos[model.jnt_qposadr[number]] = max(model.jnt_range[number], key=abs)
            before = texts.get(f"behind__{before}")
        everything = np.ones(model.nbody, dtype=bool)
        found[model.joint(joint).name] = sweep(model, data, joint, everything).worst
    return found


def _depth_at_rest(model: mujoco.MjModel, contact: Penetration) -> float:
    """Depth to which the two bodies of a contact are in each other with all joints at zero, metres; 0 where apart."""
    if not contact.body1:
        return 0.0
    data = mujoco.MjData(model)
    find_contacts(model, data)
    bodies = {model.body(contact.body1).id, model.body(contact.body2).id}
    pairs = model.geom_bodyid[data.contact.geom]
    depths = [-float(d) for pair, d in zip(pairs, data.contact.dist, strict=True) if set(pair.tolist()) == bodies]
    return max([0.0, *depths])


def with_margins(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy that reports pairs of geoms which come near, too. It is for looking alone: its contacts push too early."""
    copied = copy.copy(model)
    # MuJoCo takes the larger margin of the two geoms of a pair.
    copied.geom_margin[:] = MARGIN_M
    return copied


def moved_by(model: mujoco.MjModel, joint: int) -> Mask:
    """(nbody,) which bodies a joint carries along."""
    return subtree(model, int(model.jnt_bodyid[joint]))


def sweep(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, against: Mask, step_m: float = SWEEP_STEP_M
) -> SweepResult:
    """Move one joint from end to end, with the others at their positions in `data`; it is left at an end.

    Args:
        model: as `with_margins` made it.
        against: (nbody,) bodies that the moved ones may not touch; those that move along and the world are left out.
        step_m: distance that the farthest moved point travels between two poses.
    """
    moved = moved_by(model, joint)
    against = against & ~moved
    against[0] = False
    geoms = np.flatnonzero(moved[model.geom_bodyid] & (model.geom_contype | model.geom_conaffinity).astype(bool))
    positions = _positions(model, data, joint, geoms, step_m)
    contacts, boxes = [], []
    for position in positions:
        contacts.append(_deepest_contact(model, data, joint, position, moved, against))
        boxes.append(box_around(geom_boxes(model, data, geoms)))
    depths = np.array([contact.depth for contact in contacts])
    # The poses at which parts come nearest, the nearest first; a constant gap has none.
    padded = np.concatenate([[-MARGIN_M], depths, [-MARGIN_M]])
    rises, falls = depths - padded[:-2], depths - padded[2:]
    peaks = np.flatnonzero((depths > -MARGIN_M) & (rises >= 0) & (falls >= 0) & (np.maximum(rises, falls) > 1e-6))
    for at in peaks[np.argsort(-depths[peaks], kind="stable")][:REFINED_PEAKS].tolist():
        low, high = positions[max(at - 1, 0)], positions[min(at + 1, len(positions) - 1)]
        for position in np.linspace(low, high, FINE_POSES + 2)[1:-1]:
            contacts.append(_deepest_contact(model, data, joint, position, moved, against))
    bounds = box_around(np.array(boxes)) + np.array([[-step_m], [step_m]])
    return SweepResult(max(contacts, key=lambda contact: contact.depth), bounds)


def _positions(model: mujoco.MjModel, data: mujoco.MjData, joint: int, geoms: Ints, step_m: float) -> Floats:
    """(N,) positions of a joint from end to end, rad or m."""
    low, high = model.jnt_range[joint]
    reach = 1.0
    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and len(geoms):
        mujoco.mj_kinematics(model, data)
        arm = data.geom_xpos[geoms] - data.xanchor[joint]
        radial = arm - np.outer(arm @ data.xaxis[joint], data.xaxis[joint])
        reach = float((np.linalg.norm(radial, axis=1) + model.geom_rbound[geoms]).max())
    return np.linspace(low, high, int(np.clip(np.ceil((high - low) * reach / step_m), MIN_POSES, MAX_POSES)) + 1)


def _deepest_contact(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, position: float, moved: Mask, against: Mask
) -> Penetration:
    """The deepest contact between moved bodies and those that they may not touch, at one position of the joint.

    MuJoCo widens shapes by their margin before it measures penetration. For two thin shapes that are near but do not
    touch, it then returns an arbitrary direction and a depth of centimetres: contacts found this way are measured again
    without margins.
    """
    data.qpos[model.jnt_qposadr[joint]] = position
    seeming = _deepest_counted(model, data, moved, against)
    if seeming.depth <= 0.0:
        return seeming
    with altered(model, geom_margin=0.0):
        touching = _deepest_counted(model, data, moved, against)
    return touching if touching.geom1 else replace(seeming, depth=0.0)


def _deepest_counted(model: mujoco.MjModel, data: mujoco.MjData, moved: Mask, against: Mask) -> Penetration:
    """The deepest contact between moved bodies and those that they may not touch, at the joint positions in `data`."""
    find_contacts(model, data)
    if data.ncon == 0:
        return Penetration()
    geoms = data.contact.geom
    body1, body2 = model.geom_bodyid[geoms].T
    counted = np.flatnonzero((moved[body1] & against[body2]) | (moved[body2] & against[body1]))
    if not len(counted):
        return Penetration()
    worst = counted[np.argmin(data.contact.dist[counted])]
    names = (model.geom(int(g)).name for g in geoms[worst])
    bodies = (model.body(int(model.geom_bodyid[g])).name for g in geoms[worst])
    return Penetration(-float(data.contact.dist[worst]), *names, *bodies)


@dataclass(frozen=True)
class MotionModel:
    """An asset's file compiled for motion checks; `address`, `dof`: joint name -> index in qpos and in qvel.

    In `model` parents may touch their children, and excludes are gone: the reference loader drops them, so the shapes
    themselves have to clear each other. `with_margins` also reports what comes near; it is not for stepping.
    """

    model: mujoco.MjModel
    contactless: mujoco.MjModel
    with_margins: mujoco.MjModel
    address: dict[str, int]
    dof: dict[str, int]


def motion_model_of(package: Package) -> MotionModel:
    """The models of a built package with joints. Raises Unmeasured for others."""
    if not check.is_fixture_like(package.asset):
        raise check.Unmeasured(check.not_applicable(check.NOT_BUILT))
    if not package.asset.joints:
        raise check.Unmeasured(check.not_applicable(check.NO_JOINTS))
    if mujoco_facts.load_mjcf(package.mjcf).error:
        raise check.Unmeasured(check.not_run(check.NO_COMPILE))
    return _compile(package.mjcf, package.asset.digest)


@lru_cache(maxsize=CACHED_MODELS)
def _compile(path: Path, digest: str) -> MotionModel:
    assert digest, "names the content of the file in the cache"
    spec = motion_spec(path)
    for pair in list(spec.excludes):
        spec.delete(pair)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    model = spec.compile()
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    names = [model.joint(i).name for i in range(model.njnt)]
    return MotionModel(
        model,
        contactless=spec.compile(),
        with_margins=with_margins(model),
        address={name: int(model.jnt_qposadr[i]) for i, name in enumerate(names)},
        dof={name: int(model.jnt_dofadr[i]) for i, name in enumerate(names)},
    )


def motion_spec(mjcf: Path | Files) -> mujoco.MjSpec:
    """Specification of an MJCF file without visuals, with the step and the integrator of motion checks."""
    spec = collision_spec(mjcf)
    spec.option.timestep = STEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec


def open_end(joint: Joint) -> float:
    """The end of a joint's range that is farther from zero, rad or m."""
    return max(joint.range, key=abs)


def lever_arm(asset: Asset, joint: Joint) -> float:
    """Distance from a hinge's axis to the middle of the collider that a hand takes, metres; 1 for a slide.

    Where a joint names no grip the middle of the moved link's shapes is taken.
    """
    if joint.kind is JointKind.SLIDE:
        return 1.0
    link, grip = grip_of(asset, joint)
    child = asset.link(joint.child)
    if grip is not None:
        point = dict(_rigid_group(asset, joint.child))[link].apply(_middle(grip)[None])[0]
    elif child.colliders:
        point = np.mean([_middle(c) for c in child.colliders], axis=0)
    else:
        point = np.array(child.inertial.center_of_mass)
    arm, axis = point - np.array(joint.anchor), np.array(joint.axis)
    return float(np.linalg.norm(arm - axis * float(arm @ axis)))


def grip_of(asset: Asset, joint: Joint) -> tuple[str, Collider | None]:
    """The link and the collider that a hand takes to move a joint; ("", None) if the joint moves no such collider."""
    for link, _ in _rigid_group(asset, joint.child):
        for collider in asset.link(link).colliders:
            if collider.name == joint.grip:
                return link, collider
    return "", None


def _middle(collider: Collider) -> Floats:
    """(3,) middle of a collider in the frame of its link; a hull may be far from the origin of its frame."""
    return np.asarray(shape_bounds(collider.shape, collider.pose).mean(axis=0))


def _rigid_group(asset: Asset, link: str) -> list[tuple[str, Pose]]:
    """A link and what it carries without a joint, with poses in its frame."""
    group = [(link, Pose())]
    for other in asset.links:
        if other.parent == link and asset.joint_of(other.name) is None:
            group += [(name, other.pose @ pose) for name, pose in _rigid_group(asset, other.name)]
    return group


def open_before(asset: Asset, joint: Joint) -> dict[str, float]:
    """Joints that have to be open for this one to move, and their positions: rad or m."""
    joints = {j.name: j for j in asset.joints}
    positions: dict[str, float] = {}
    before = joint.behind
    while before is not None and before not in positions:
        positions[before] = open_end(joints[before])
        before = joints[before].behind
    return positions


@dataclass(frozen=True)
class DropProtocol:
    """The drop test, from registry/limits.yaml: from `height_factor` times its height, metres, seconds.

    Ref: SimReady Foundation, FET003 base neutral simulation: from twice its height, at rest within 2 cm for 2 s in 8 s.
    `rest_m`: diameter of the ball in which its centre of mass stays while it rests, for `rest_s`.
    """

    height_factor: float
    min_height_m: float
    rest_m: float
    rest_s: float
    rate_hz: float
    duration_s: float


@dataclass(frozen=True)
class DropResult:
    """One drop: when its rest began (None: not in time), deepest penetration ever and at the end, and tilt."""

    rest_s: float | None
    deepest_m: float
    rest_m: float
    tilt_deg: float
    warnings: tuple[str, ...]


def drop_on_floor(scene: Path, protocol: DropProtocol) -> DropResult | None:
    """Drop the free body of a scene; None if the scene does not compile or has no free body."""
    model = mujoco_facts.load_mjcf(scene).model
    bodies = [] if model is None else mujoco_facts.free_bodies(model)
    return _drop(model, bodies[0], protocol) if bodies else None


@lru_cache(maxsize=CACHED_DROPS)
def _drop(shared: mujoco.MjModel, body: int, protocol: DropProtocol) -> DropResult:
    model = copy.copy(shared)
    model.opt.timestep = 1.0 / protocol.rate_hz
    data = mujoco.MjData(model)
    z = int(model.jnt_qposadr[model.body_jntadr[body]]) + 2
    data.qpos[z] += max(protocol.height_factor * _height(model, body), protocol.min_height_m)
    mujoco.mj_forward(model, data)
    before = data.xmat[body].reshape(3, 3).copy()
    path: list[Floats] = []
    deepest, window = 0.0, int(protocol.rest_s * protocol.rate_hz)
    for step in range(int(protocol.duration_s * protocol.rate_hz)):
        mujoco.mj_step(model, data)
        path.append(data.xipos[body].copy())
        deepest = max(deepest, _depth(data))
        if not np.isfinite(data.qpos).all() or (step >= window and _is_at_rest(path[-window:], protocol.rest_m)):
            break
    rest_s = None
    if len(path) > window and np.isfinite(data.qpos).all() and _is_at_rest(path[-window:], protocol.rest_m):
        rest_s = (len(path) - window) / protocol.rate_hz
    tilt = tilt_deg(data.xmat[body].reshape(3, 3) @ before.T)
    return DropResult(rest_s, deepest, _depth(data), tilt, tuple(simulation_warnings(data)))


def _is_at_rest(path: list[Floats], diameter: float) -> bool:
    """True if all points lie in a ball of that diameter, metres."""
    points = np.array(path)
    return bool(np.linalg.norm(points - points.mean(axis=0), axis=1).max() <= diameter / 2)


def _height(model: mujoco.MjModel, root: int) -> float:
    """Height of all colliders of a floating body and what it carries, joints at zero, metres."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    lowest, highest, turns = np.inf, -np.inf, rotations_of(model.geom_quat)
    for geom in np.flatnonzero(model.geom_contype):
        body = int(model.geom_bodyid[geom])
        if int(model.body_rootid[body]) != root:
            continue
        bounds, rotation = mujoco_facts.shape_bounds(model, int(geom), turns[geom]), data.xmat[body].reshape(3, 3)
        z = (data.xpos[body] + rotation @ bounds.mean(axis=0))[2]
        half = (np.abs(rotation) @ (np.ptp(bounds, axis=0) / 2))[2]
        lowest, highest = min(lowest, z - half), max(highest, z + half)
    return max(0.0, float(highest - lowest))


def _depth(data: mujoco.MjData) -> float:
    """Deepest penetration of all present contacts, metres."""
    return max(0.0, -float(data.contact.dist.min())) if data.ncon else 0.0
