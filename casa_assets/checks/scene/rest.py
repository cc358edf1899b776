"""Find scenes that do not load, begin in collision, move by themselves or cost too much; let objects come to rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.motion.simulation import collision_spec, reset_to_start, simulation_warnings
from casa_assets.checks.readers.mujoco_facts import free_bodies
from casa_assets.checks.scene.subject import SceneSubject, all_pairs
from casa_assets.core.numeric import Floats, Mask
from casa_assets.model.asset.asset import JointKind
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import FREE_JOINT
from casa_assets.model.pose import Pose

SETTLED_S, SIMULATED_S = 1.0, 5.0
MM_PER_M = 1000.0
# Reasons why a check does not apply.
NO_JOINTS, NO_FREE_THINGS = "nothing in it has a joint", "nothing in it stands by its weight alone"
# A short range counts as one of which the limit is a millimetre or half a degree: stops are soft, light keys yield.
STILL = {JointKind.SLIDE: 0.001, JointKind.HINGE: 0.0087}
# A scene that explodes has one fault, not a thousand.
MAX_LISTED = 20
Depths = Mapping[tuple[str, str], float]  # names of two geoms -> how deep they are in each other, metres
MEGABYTE = 1e6


@dataclass(frozen=True)
class IdleRun:
    """State of a scene after 5 s in which nobody touched it: contacts of named geoms, and qpos.

    `drift`: name of a free placement -> how far any of its shapes has gone, metres. `warnings`: of the simulator.
    """

    at_start: Depths
    settled: Depths
    start: Floats
    end: Floats
    drift: dict[str, float]
    warnings: list[str]

    @property
    def depths(self) -> Depths:
        """The deeper contact of each two geoms at the start and after 1 s, by their names."""
        pairs = sorted({*self.at_start, *self.settled})
        return {pair: max(self.at_start.get(pair, 0.0), self.settled.get(pair, 0.0)) for pair in pairs}


def scene_loads_without_warnings(subject: SceneSubject) -> check.Measurement:
    """SCN001: number of errors and warnings while MuJoCo reads the file and simulates 5 s."""
    error, warnings = subject.loaded.error, subject.loaded.warnings
    messages = [error] if error else [*warnings, *(f"simulating it: {w}" for w in idle_run(subject).warnings)]
    return check.count((subject.mjcf.name, message) for message in messages)


def no_penetration_at_start(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN002: deepest penetration as the scene begins, metres."""
    when = "as the scene begins; move one of them, or shrink its shape"
    return deepest(idle_run(subject).at_start, limit, when)


def no_penetration_after_settling(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN003: deepest penetration after 1 s, metres."""
    when = f"after {SETTLED_S:g} s; it is pressed there by weight or a spring"
    return deepest(idle_run(subject).settled, limit, when)


def joints_stay_put(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN004: largest share of its range that a joint moves in 5 s."""
    if not subject.joints:
        return check.not_applicable(NO_JOINTS)
    run, shares = idle_run(subject), {}
    for joint in subject.joints.values():
        low, high = joint.joint.range
        moved = abs(float(run.end[joint.address] - run.start[joint.address]))
        shares[f"joints/{joint.name}"] = moved / max(high - low, STILL[joint.joint.kind] / limit)
    message = f"drifts by {{:.1%}} of its range in {SIMULATED_S:g} s; see what touches it, or its friction and spring"
    return check.all_at_most(shares, limit, message, NO_JOINTS)


def loose_things_stay_put(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN011: largest distance that a free-standing object moves in 5 s, metres."""
    drift = idle_run(subject).drift
    return farthest(drift, limit, "; set it down where it stands firmly")


@lru_cache(maxsize=1)
def idle_run(subject: SceneSubject) -> IdleRun:
    """The scene left alone, once; contacts are those of all pairs, near misses too, the deepest first."""
    return left_alone(subject.model, lambda data: penetrations(subject, data))


def left_alone(
    model: mujoco.MjModel, contacts: Callable[[mujoco.MjData], Depths] | None = None, counted: Mask | None = None
) -> IdleRun:
    """Simulate a form of a scene for 5 s as it begins. `contacts`: how deep shapes are in each other; None: as found.

    `counted`: (ngeom,) shapes whose ways count.
    """
    measured = contacts or contact_depths
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_forward(model, data)
    at_start, start, before = measured(data), data.qpos.copy(), data.geom_xpos.copy()
    mujoco.mj_step(model, data, nstep=round(SETTLED_S / model.opt.timestep))
    settled = measured(data)
    mujoco.mj_step(model, data, nstep=round((SIMULATED_S - SETTLED_S) / model.opt.timestep))
    ways, roots = np.linalg.norm(data.geom_xpos - before, axis=1), model.body_rootid[model.geom_bodyid]
    if counted is not None:
        ways = np.where(counted, ways, 0.0)
    drift = {str(model.body(b).name): float(ways[roots == b].max(initial=0.0)) for b in free_bodies(model)}
    return IdleRun(at_start, settled, start, data.qpos.copy(), drift, simulation_warnings(data))


def contact_depths(data: mujoco.MjData) -> Depths:
    """Deepest contact of each two geoms that touch, metres."""
    depths: dict[tuple[str, str], float] = {}
    for (first, second), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
        pair = (str(data.model.geom(first).name), str(data.model.geom(second).name))
        depths[pair] = max(depths.get(pair, 0.0), -distance)
    return depths


def penetrations(subject: SceneSubject, data: mujoco.MjData) -> Depths:
    """Contacts of all pairs of geoms in the present state, near misses too, the deepest first; `data` is only read."""
    model, posed = subject.model, mujoco.MjData(subject.model)
    posed.qpos[:] = data.qpos
    with all_pairs(model):
        mujoco.mj_kinematics(model, posed)
        mujoco.mj_collision(model, posed)
    depths: dict[tuple[int, int], float] = {}
    for pair, distance in zip(posed.contact.geom.tolist(), posed.contact.dist.tolist(), strict=True):
        key = (min(pair), max(pair))
        depths[key] = max(depths.get(key, -1.0), -distance)
    ordered = sorted(depths.items(), key=lambda item: (-item[1], item[0]))
    return {(subject.geom_name(first), subject.geom_name(second)): depth for (first, second), depth in ordered}


def deepest(depths: Depths, limit: float, where: str) -> check.Measurement:
    """The deepest of some penetrations, metres; `where`: end of the messages."""
    deep = ((*pair, depth * MM_PER_M) for pair, depth in depths.items() if depth > limit)
    problems = [(f"geoms/{first}", f"is {depth:.2f} mm in {second} {where}") for first, second, depth in deep]
    return check.Measurement(max(depths.values(), default=0.0), tuple(problems[:MAX_LISTED]))


def farthest(drift: Mapping[str, float], limit: float, advice: str, listed: int | None = None) -> check.Measurement:
    """The farthest that a free-standing thing moved in 5 s, metres; not applicable if there are none.

    `drift`: by placement. `advice`: end of the messages, of which `listed` are given at most.
    """
    far = ((name, distance * MM_PER_M) for name, distance in drift.items() if distance > limit)
    problems = [(f"placements/{name}", f"moves {way:.1f} mm in {SIMULATED_S:g} s{advice}") for name, way in far]
    return check.largest(drift.values(), problems[:listed], NO_FREE_THINGS)


@dataclass(frozen=True)
class Rest:
    """Where an object came to rest: world_from_root, tilt of its upright axis (rad), how far its shapes moved (m).

    `depth`: deepest contact at the start and at the end, near misses not counted, metres.
    """

    pose: Pose
    moved: float
    tilt: float
    depth: float


def come_to_rest(files: Files, names: Sequence[str], seconds: float) -> dict[str, Rest]:
    """Simulate a scene, in memory, that nobody touches; `names`: free placements. ValueError: MuJoCo cannot read it."""
    model = collision_spec(files, "scene.xml").compile()
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_forward(model, data)
    bodies = [model.body(name).id for name in names]
    before, axes = data.geom_xpos.copy(), data.xmat[bodies].reshape(-1, 3, 3)[:, :, 2].copy()
    depth = _depths(model, data)
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    mujoco.mj_forward(model, data)
    depth = np.maximum(depth, _depths(model, data))
    ways, roots = np.linalg.norm(data.geom_xpos - before, axis=1), model.body_rootid[model.geom_bodyid]
    found = {}
    for number, (name, body) in enumerate(zip(names, bodies, strict=True)):
        start = model.jnt_qposadr[model.joint(f"{name}__{FREE_JOINT}").id]
        x, y, z, *turn = (float(v) for v in data.qpos[start : start + 7])
        upright = data.xmat[body].reshape(3, 3)[:, 2]
        found[name] = Rest(
            pose=Pose(position=(x, y, z), quaternion=(turn[0], turn[1], turn[2], turn[3])),
            moved=float(ways[roots == body].max(initial=0.0)),
            tilt=float(np.arccos(np.clip(upright @ axes[number], -1.0, 1.0))),
            depth=float(depth[body]),
        )
    return found


def _depths(model: mujoco.MjModel, data: mujoco.MjData) -> Floats:
    """(nbody,) deepest contact of each body, metres; 0 where it touches nothing."""
    depths = np.zeros(model.nbody)
    bodies = model.body_rootid[model.geom_bodyid[data.contact.geom]]
    for pair, distance in zip(bodies, data.contact.dist, strict=True):
        np.maximum.at(depths, pair, -distance)
    return depths


@dataclass(frozen=True)
class MeasuredSpeed:
    """Milliseconds to compile a scene, and steps of one core per second with nothing touched, on this machine."""

    load_ms: float
    steps_per_s: float
    timestep_s: float

    @property
    def pace(self) -> float:
        """Seconds that are simulated in a second."""
        return self.steps_per_s * self.timestep_s


def body_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN010: number of bodies of the model."""
    return _bounded_count(subject.model.nbody, limit, "bodies; merge links that never move against each other")


def collider_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN012: number of collision shapes."""
    return _bounded_count(subject.model.ngeom, limit, "shapes that are touched; merge some, or leave a thing out")


def degrees_of_freedom_are_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN013: degrees of freedom of the kitchen, without those of objects that were put into it."""
    added = [place.name for place in subject.scene.objects]
    bodies = subject.model.body_rootid[subject.model.dof_bodyid]
    own = subject.model.nv - int(np.isin(bodies, [subject.model.body(name).id for name in added]).sum())
    return _bounded_count(own, limit, "degrees of freedom; fix what nobody has to move")


def hull_vertex_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN014: vertices of all collision hulls, counted for each time that a hull occurs in the scene."""
    model = subject.model
    hulls = model.geom_dataid[model.geom_type == mujoco.mjtGeom.mjGEOM_MESH]
    return _bounded_count(int(np.sum(model.mesh_vertnum[hulls])), limit, "vertices of hulls; use boxes and cylinders")


def texture_memory_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN015: megabytes of all pictures, decoded, without mipmaps."""
    model = subject.loaded.model
    if model is None:
        return check.not_run("MuJoCo cannot read scene.xml")
    return _bounded_count(model.ntexdata / MEGABYTE, limit, "MB of pictures; share them, or make them smaller")


def contact_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN016: pairs of shapes in contact at the start and after 1 s, the larger number."""
    most = max(len(depths) for depths in (idle_run(subject).at_start, idle_run(subject).settled))
    return _bounded_count(most, limit, "pairs in contact at rest; set things down on fewer feet")


def load_time_is_bounded(speed: MeasuredSpeed, limit: float) -> check.Measurement:
    """SCN026: milliseconds to compile the whole scene with its pictures."""
    return _bounded_count(speed.load_ms, limit, "ms to load; fewer vertices and smaller pictures load faster")


def simulation_is_fast_enough(speed: MeasuredSpeed, limit: float) -> check.Measurement:
    """SCN027: simulated seconds per second on one core, at rest."""
    message = f"simulates {speed.pace:.2f} s in a second; fewer shapes in contact, fewer joints"
    return check.at_least(speed.pace, limit, "scene", message)


def scene_sizes(subject: SceneSubject) -> dict[str, float]:
    """Sizes of a scene by name: counts, and megabytes of decoded pictures. It has to load."""
    whole, bare = subject.loaded.model, subject.model
    assert whole is not None
    hulls = bare.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    return {
        "bodies": whole.nbody,
        "geoms": whole.ngeom,
        "colliders": bare.ngeom,
        "hulls": int(hulls.sum()),
        "meshes": whole.nmesh,
        "joints": len(subject.joints),
        "nv": whole.nv,
        "textures": whole.ntex,
        "texture_mb": round(whole.ntexdata / MEGABYTE, 3),
    }


def _bounded_count(number: float, limit: float, noun: str) -> check.Measurement:
    return check.at_most(float(number), limit, "scene", f"has {number:,.0f} {noun}")
