"""Measures one kitchen in MuJoCo, whoever made it: load, steps per second with things dropped in, joints that clash.

    python measure.py FILE [--loose 10] [--bare] [--pace | --sweep objects.json]

Needs mujoco and numpy alone, so it runs in any environment, and both sides are judged by the same lines. Prints one
JSON object. FILE is an MJCF or a URDF. --bare takes things out that the scene itself has loose. --pace skips the sweep,
--sweep skips all else: its file lists names that those of bodies begin with; bodies with the same one are one object.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np

STEP_S, SETTLE_STEPS, ROUNDS, ROUND_STEPS = 0.002, 500, 20, 100
# Half the size of what is dropped, its mass, and how far above its place it begins.
HALF_M, MASS_KG, DROP_M = 0.03, 0.1, 0.05
# A place is flat for so far from its middle, and as far from the next; worktops lie between these heights, metres.
FLAT_M, APART_M, WORKTOP_M, EYE_M = 0.06, 0.2, (0.6, 1.05), 1.35
# Deeper than this beyond what is there at rest is a clash; a sweep has so many poses. Ref: a 5 mm rule is common.
CLASH_M, POSES = 0.005, 41
FREE = mujoco.mjtJoint.mjJNT_FREE
SLEEP = getattr(mujoco.mjtEnableBit, "mjENBL_SLEEP", None)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--loose", type=int, default=10)
    parser.add_argument("--bare", action="store_true")
    parser.add_argument("--pace", action="store_true")
    parser.add_argument("--sweep")
    options = parser.parse_args()
    if options.sweep:
        names = json.loads(Path(options.sweep).read_text(encoding="utf-8"))
        print(json.dumps(clashes(mujoco.MjModel.from_xml_path(options.file), names)))
        return
    begin = time.perf_counter()
    model = mujoco.MjModel.from_xml_path(options.file)
    load_s = time.perf_counter() - begin
    first = start(model)
    spec = mujoco.MjSpec.from_file(options.file)
    spec, dropped = with_loose(spec, model, first, options.loose, options.bare)
    found = {
        "mujoco": mujoco.__version__,
        "load_s": load_s,
        "bodies": model.nbody - 1,
        "joints": int(np.sum(model.jnt_type != FREE)),
        "geoms": int(np.sum((model.geom_contype | model.geom_conaffinity) != 0)),
        "own_loose": int(np.sum(model.jnt_type == FREE)) * (not options.bare),
        "dropped": dropped,
        "awake": pace(spec, model, first, False),
        "asleep": pace(spec, model, first, True) if SLEEP is not None else None,
        "stirred": pace(spec, model, first, True, stir) if SLEEP is not None else None,
    }
    if not options.pace:
        found["clashes"] = clashes(model, [])
    print(json.dumps(found))


def start(model: mujoco.MjModel) -> mujoco.MjData:
    """The scene as it begins: its first keyframe, where there is one."""
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return data


def places(model: mujoco.MjModel, data: mujoco.MjData, count: int) -> list[np.ndarray]:
    """Flat free spots seen from above: half of them on worktops, the others on the floor (on worktops without one)."""
    rng = np.random.default_rng(0)
    low, high = data.geom_xpos.min(axis=0), data.geom_xpos.max(axis=0)
    feet = FLAT_M * np.array([(0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)])
    tops: list[np.ndarray] = []
    floor: list[np.ndarray] = []
    for x, y in rng.uniform(low[:2], high[:2], (8000, 2)):
        heights = [height(model, data, x + dx, y + dy) for dx, dy in feet]
        spot = np.array((x, y, heights[0]))
        near = any(np.hypot(*(spot - other)[:2]) < APART_M for other in tops + floor)
        if near or max(heights) - min(heights) > 1e-4:
            continue
        if WORKTOP_M[0] < spot[2] < WORKTOP_M[1]:
            tops.append(spot)
        elif abs(spot[2]) < 0.02:
            floor.append(spot)
    half = min(len(tops), count // 2 if len(floor) >= count - count // 2 else count)
    return tops[:half] + floor[: count - half]


def height(model: mujoco.MjModel, data: mujoco.MjData, x: float, y: float) -> float:
    """Of the first thing that is touched below the eye, metres; far below where there is nothing."""
    begin, hit = np.array([x, y, EYE_M]), np.zeros(1, dtype=np.int32)
    while True:
        way = mujoco.mj_ray(model, data, begin, np.array([0.0, 0.0, -1.0]), None, 1, -1, hit)
        if way < 0:
            return -9.0
        if model.geom_contype[hit[0]] or model.geom_conaffinity[hit[0]]:
            return float(begin[2] - way)
        begin = begin - [0.0, 0.0, way + 1e-6]


def with_loose(
    spec: mujoco.MjSpec, model: mujoco.MjModel, first: mujoco.MjData, count: int, bare: bool
) -> tuple[mujoco.MjSpec, int]:
    """The scene with boxes and balls above free spots, which are put into its spec, and how many there are."""
    for key in list(spec.keys):
        spec.delete(key)
    if bare:
        for joint in [j for j in spec.joints if j.type == FREE]:
            spec.delete(joint.parent)
    spots = places(model, first, count)
    up = np.array([0.0, 0.0, HALF_M + DROP_M])
    for i, spot in enumerate(spots):
        body = spec.worldbody.add_body(name=f"dropped_{i}", pos=spot + up)
        body.add_freejoint()
        if i % 2:
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[HALF_M] * 3, mass=MASS_KG)
        else:
            # Only rolling friction stops a ball.
            rough = {"condim": 6, "friction": [0.6, 0.005, 0.002]}
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[HALF_M, 0, 0], mass=MASS_KG, **rough)
    return spec, len(spots)


def pace(
    spec: mujoco.MjSpec,
    plain: mujoco.MjModel,
    first: mujoco.MjData,
    asleep: bool,
    push: Callable[[mujoco.MjModel, mujoco.MjData], None] | None = None,
) -> dict[str, float]:
    """Steps per second of one core after a second in which things settle; the fastest of some rounds.

    Seconds are those of the process, and others at work on the machine can only add to them. `push` says what forces
    act meanwhile.
    """
    model = spec.compile()
    model.opt.timestep = STEP_S
    if SLEEP is not None:
        flags = int(model.opt.enableflags)
        model.opt.enableflags = flags | int(SLEEP) if asleep else flags & ~int(SLEEP)
    data = mujoco.MjData(model)
    for i in range(model.njnt):
        name = model.joint(i).name
        if name and mujoco.mj_name2id(plain, mujoco.mjtObj.mjOBJ_JOINT, name) >= 0:
            model_at, plain_at = model.joint(name).qposadr[0], plain.joint(name).qposadr[0]
            width = len(model.joint(name).qpos0)
            data.qpos[model_at : model_at + width] = first.qpos[plain_at : plain_at + width]
    mujoco.mj_step(model, data, nstep=SETTLE_STEPS)
    if push is not None:
        push(model, data)
    rounds = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        mujoco.mj_step(model, data, nstep=ROUND_STEPS)
        rounds.append((time.process_time() - begin) / ROUND_STEPS)
    one = min(rounds)
    moving = np.linalg.norm(data.qvel, ord=np.inf) if model.nv else 0.0
    return {
        "steps_per_s": 1 / one,
        "real_time": STEP_S / one,
        "contacts": int(data.ncon),
        "rows": int(data.nefc),
        "fastest": float(moving),
        "warnings": int(sum(w.number for w in data.warning)),
        "trees_awake": int(getattr(data, "ntree_awake", model.ntree)),
    }


def stir(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Keeps three things moving as a robot at work would: what was dropped last, and the two heaviest doors or drawers.

    MuJoCo lets nothing sleep that a force acts on.
    """
    last = [body for body in range(model.nbody) if model.body(body).name.startswith("dropped_")][-1:]
    data.xfrc_applied[last, 0] = 0.01
    joints = np.flatnonzero((model.jnt_type != FREE) & (model.jnt_limited == 1))
    heaviest = joints[np.argsort(model.body_mass[model.jnt_bodyid[joints]])][-2:]
    data.qfrc_applied[model.jnt_dofadr[heaviest]] = 0.01


def clashes(model: mujoco.MjModel, objects: list[str]) -> dict[str, int | list[str]]:
    """Joints that run into another object on their way, each moved alone while all else is at zero.

    An object is all that hangs below one body of the world, or whose names begin alike; what touches within one does
    not count.
    """
    data = mujoco.MjData(model)
    owners = [owner(model, body, objects) for body in range(model.nbody)]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_collision(model, data)
    at_rest = deepest(model, data, owners)
    hit, tried = [], 0
    for joint in np.flatnonzero((model.jnt_type != FREE) & (model.jnt_limited == 1)):
        moved = below(model, int(model.jnt_bodyid[joint]))
        tried += 1
        data.qpos[:] = model.qpos0
        for value in np.linspace(*model.jnt_range[joint], POSES):
            data.qpos[model.jnt_qposadr[joint]] = value
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            met = deepest(model, data, owners, moved)
            if any(depth - max(0.0, at_rest.get(pair, 0.0)) > CLASH_M for pair, depth in met.items()):
                hit.append(model.joint(joint).name)
                break
    return {"joints": tried, "clash": len(hit), "names": hit}


def below(model: mujoco.MjModel, top: int) -> np.ndarray:
    """(nbody,) which bodies hang below one, itself included."""
    found = np.zeros(model.nbody, dtype=bool)
    found[top] = True
    for body in range(top + 1, model.nbody):
        found[body] = found[model.body_parentid[body]]
    return found


def deepest(
    model: mujoco.MjModel, data: mujoco.MjData, owners: list[str], moved: np.ndarray | None = None
) -> dict[tuple[int, int], float]:
    """Pair of geoms of different objects -> depth, metres; only pairs of which one is moved, where that is given."""
    found: dict[tuple[int, int], float] = {}
    for (one, other), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
        bodies = int(model.geom_bodyid[one]), int(model.geom_bodyid[other])
        counts = moved is None or moved[bodies[0]] != moved[bodies[1]]
        if counts and owners[bodies[0]] != owners[bodies[1]]:
            pair = (min(one, other), max(one, other))
            found[pair] = max(found.get(pair, 0.0), -distance)
    return found


def owner(model: mujoco.MjModel, body: int, objects: list[str]) -> str:
    """The object that a body belongs to: the longest name that its own begins with, else the name of its root."""
    name = model.body(body).name
    known = max((o for o in objects if name == o or name.startswith(f"{o}_")), key=len, default="")
    return known or (name if objects else model.body(int(model.body_rootid[body])).name)


if __name__ == "__main__":
    main()
