"""Find differences in motion between the light form of a scene and the full one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.scene.formats.files import SceneFiles
from casa_assets.checks.scene.motion.rest import FAST, MM, REST_S, SETTLED_S
from casa_assets.checks.scene.subject import reset
from casa_assets.core.typing import Mask

Fault = tuple[str, str]
# What of a joint, and of a body that moves, is the same in both; each is an array with a row per joint, dof or body.
OF_JOINTS = ("jnt_type", "jnt_range", "jnt_axis", "jnt_pos", "jnt_stiffness")
OF_DOFS = ("dof_damping", "dof_frictionloss", "dof_armature")
OF_BODIES = ("body_mass", "body_inertia", "body_ipos")
LISTED = 20
UNLOADED = "MuJoCo cannot read scene_light.xml"


def mechanism_is_the_same(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN021: differences in joints, bodies and poses between the light form and the full one."""
    assert limit is None
    full, light = files.kitchen.loaded.model, files.lightened
    name = files.light.name
    if full is None:
        return not_run("MuJoCo cannot read scene.xml, which the light form is held against")
    if light.model is None:
        return Measurement(1.0, ((name, light.error),))
    problems = [(name, f"MuJoCo warns: {warning}") for warning in light.warnings]
    meshes, pictures = int(light.model.nmesh), int((light.model.mat_texid >= 0).sum())
    if meshes:
        problems.append((name, f"has {meshes} meshes; use boxes, cylinders and spheres"))
    if pictures:
        problems.append((name, f"has {pictures} materials with pictures; use plain colours"))
    problems += _differences(full, light.model)
    return Measurement(float(len(problems)), tuple(problems[:LISTED]))


def no_penetration_after_settling(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN022: deepest penetration in the light form at the start and after 1 s, metres."""
    assert limit is not None
    stood = settled_scene(files)
    if stood is None:
        return not_run(UNLOADED)
    message = "is {:.2f} mm in {} in the light form; see the shapes that stand for it there"
    problems = [
        (f"geoms/{one}", message.format(depth * MM, other))
        for (one, other), depth in sorted(stood.depths.items())
        if depth > limit
    ]
    return Measurement(max(stood.depths.values(), default=0.0), tuple(problems[:LISTED]))


def loose_things_stay_put(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN028: farthest that something that stands by its weight moves in 5 s in the light form, metres."""
    assert limit is not None
    stood = settled_scene(files)
    if stood is None:
        return not_run(UNLOADED)
    if not stood.moved:
        return not_applicable(FAST)
    message = "moves {:.1f} mm in {:g} s in the light form; the shapes that stand for it there do not stand"
    problems = [
        (f"placements/{name}", message.format(way * MM, REST_S)) for name, way in stood.moved.items() if way > limit
    ]
    return Measurement(max(stood.moved.values()), tuple(problems[:LISTED]))


@dataclass(frozen=True)
class SettledScene:
    """State of a light form after it was left alone.

    Attributes:
        depths: names of two geoms -> how deep they are in each other at the start or after 1 s, metres.
        moved: name of a body that stands by its weight -> how far any of its shapes has gone in 5 s, metres.
    """

    depths: dict[tuple[str, str], float]
    moved: dict[str, float]


@lru_cache(maxsize=1)
def settled_scene(files: SceneFiles) -> SettledScene | None:
    """Simulate the light form for 5 s, once; None where it does not load."""
    model = files.lightened.model
    if model is None:
        return None
    data = mujoco.MjData(model)
    reset(model, data)
    mujoco.mj_forward(model, data)
    free = [int(model.jnt_bodyid[j]) for j in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)]
    before, depths = data.geom_xpos.copy(), dict[tuple[str, str], float]()
    for seconds in (SETTLED_S, REST_S - SETTLED_S):
        for (one, other), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
            pair = (str(model.geom(one).name), str(model.geom(other).name))
            depths[pair] = max(depths.get(pair, 0.0), -distance)
        mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    ways = np.linalg.norm(data.geom_xpos - before, axis=1)
    roots = model.body_rootid[model.geom_bodyid]
    return SettledScene(depths, {str(model.body(b).name): float(ways[roots == b].max(initial=0.0)) for b in free})


def _differences(full: mujoco.MjModel, light: mujoco.MjModel) -> Iterator[Fault]:
    """Names of joints, bodies that move and poses that only one has, and numbers of them that differ."""
    kinds = (
        (mujoco.mjtObj.mjOBJ_JOINT, "joints", full.njnt, light.njnt),
        (mujoco.mjtObj.mjOBJ_KEY, "keys", full.nkey, light.nkey),
    )
    for kind, word, ours, theirs in kinds:
        one, other = _names(full, kind, ours), _names(light, kind, theirs)
        if one != other:
            odd = [n for n in [*one, *other] if (n in one) != (n in other)]
            yield word, f"are others, or in another order, than in the full form: {', '.join(odd[:5])}"
            return
    bodies = [[int(b) for b in np.flatnonzero(_moves(m))] for m in (full, light)]
    named = [[m.body(b).name for b in found] for m, found in zip((full, light), bodies, strict=True)]
    if named[0] != named[1]:
        yield "bodies", f"{len(named[0])} move in the full form, {len(named[1])} in the light one"
        return
    for field in (*OF_JOINTS, *OF_DOFS, "key_qpos"):
        yield from _differs(field, getattr(full, field), getattr(light, field))
    for field in OF_BODIES:
        yield from _differs(field, getattr(full, field)[bodies[0]], getattr(light, field)[bodies[1]])


def _differs(field: str, ours: np.ndarray, theirs: np.ndarray) -> Iterator[Fault]:
    off = ~np.isclose(ours, theirs, rtol=1e-6, atol=1e-9)
    if off.any():
        yield field, f"differs in {int(off.sum())} numbers, by at most {np.abs(ours - theirs)[off].max():.3g}"


def _moves(model: mujoco.MjModel) -> Mask:
    moves: Mask = model.body_weldid != 0
    return moves


def _names(model: mujoco.MjModel, kind: mujoco.mjtObj, count: int) -> list[str]:
    return [str(mujoco.mj_id2name(model, kind, i)) for i in range(count)]
