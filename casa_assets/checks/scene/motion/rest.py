"""Find scenes that do not load cleanly, begin in collision, or move when nobody touches them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.scene.subject import AllPairs, SceneSubject, reset
from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import JointKind

SETTLED_S, REST_S = 1.0, 5.0
MM = 1000.0
# Why a check is not asked of a scene, as reports say it.
STIFF, FAST = "nothing in it has a joint", "nothing in it stands by its weight alone"
# A short range counts as one of which the limit is a millimetre or half a degree: stops are soft, light keys yield.
STILL = {JointKind.SLIDE: 0.001, JointKind.HINGE: 0.0087}
# At most so many of one kind are listed: a scene that explodes has one fault, not a thousand.
LISTED = 20


@dataclass(frozen=True)
class Penetration:
    """Two geoms in each other: their names and the depth, metres."""

    one: str
    other: str
    depth: float


@dataclass(frozen=True)
class IdleRun:
    """State of a scene after 5 s in which nobody touched it.

    Attributes:
        begins, settled: contacts at the start and after 1 s, those of such pairs among them, the deepest first.
        start, end: qpos at the start and after 5 s.
        moved: name of a free placement -> how far any of its shapes has gone in 5 s, metres.
        troubles: what the simulator complained of.
    """

    begins: tuple[Penetration, ...]
    settled: tuple[Penetration, ...]
    start: Floats
    end: Floats
    moved: dict[str, float]
    troubles: tuple[str, ...]


def scene_loads_without_warnings(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN001: number of errors and warnings while MuJoCo reads the file and simulates 5 s."""
    assert limit is None
    said = [subject.loaded.error] if subject.loaded.error else list(subject.loaded.warnings)
    if not subject.loaded.error:
        said += idle_run(subject).troubles
    return Measurement(float(len(said)), tuple((subject.mjcf.name, text) for text in said))


def no_penetration_at_start(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN002: deepest penetration as the scene begins, metres."""
    return _deep(idle_run(subject).begins, limit, "as the scene begins; move one of them, or shrink its shape")


def no_penetration_after_settling(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN003: deepest penetration after 1 s, metres."""
    return _deep(idle_run(subject).settled, limit, f"after {SETTLED_S:g} s; it is pressed there by weight or a spring")


def joints_stay_put(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN004: largest share of its range that a joint moves in 5 s."""
    assert limit is not None
    if not subject.parts:
        return not_applicable(STIFF)
    stood, worst, problems = idle_run(subject), 0.0, []
    for part in subject.parts:
        way = max(part.joint.range[1] - part.joint.range[0], STILL[part.joint.kind] / limit)
        share = abs(float(stood.end[part.address] - stood.start[part.address])) / way
        worst = max(worst, share)
        if share > limit:
            message = (
                f"drifts by {share:.1%} of its range in {REST_S:g} s; see what touches it, or its friction and spring"
            )
            problems.append((_pointer(part.name), message))
    return Measurement(worst, tuple(problems))


def loose_things_stay_put(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN011: farthest that something that stands by its weight moves in 5 s, metres."""
    assert limit is not None
    moved = idle_run(subject).moved
    if not moved:
        return not_applicable(FAST)
    problems = [
        (f"placements/{name}", f"moves {far * MM:.1f} mm in {REST_S:g} s; set it down where it stands firmly")
        for name, far in moved.items()
        if far > limit
    ]
    return Measurement(max(moved.values()), tuple(problems))


@lru_cache(maxsize=1)
def idle_run(subject: SceneSubject) -> IdleRun:
    """Simulate the scene untouched for 5 s, once."""
    model, data = subject.model, mujoco.MjData(subject.model)
    reset(model, data)
    mujoco.mj_forward(model, data)
    begins, start = tuple(penetrations(subject, data)), data.qpos.copy()
    free = {p.name: subject.geoms_of[p.name] for p in subject.free}
    before = {name: data.geom_xpos[geoms].copy() for name, geoms in free.items()}
    mujoco.mj_step(model, data, nstep=round(SETTLED_S / model.opt.timestep))
    settled = tuple(penetrations(subject, data))
    mujoco.mj_step(model, data, nstep=round((REST_S - SETTLED_S) / model.opt.timestep))
    moved = {n: float(np.linalg.norm(data.geom_xpos[g] - before[n], axis=1).max(initial=0)) for n, g in free.items()}
    kinds = {int(k): k.name.removeprefix("mjWARN_").lower() for k in mujoco.mjtWarning.__members__.values()}
    troubles = tuple(f"simulating it: {kinds[i]} x {w.number}" for i, w in enumerate(data.warning) if w.number)
    return IdleRun(begins, settled, start, data.qpos.copy(), moved, troubles)


def penetrations(subject: SceneSubject, data: mujoco.MjData) -> Iterator[Penetration]:
    """Penetrating pairs of geoms in the present state, the deepest first; `data` is only read."""
    seen = mujoco.MjData(subject.model)
    seen.qpos[:] = data.qpos
    with AllPairs(subject.model):
        mujoco.mj_kinematics(subject.model, seen)
        mujoco.mj_collision(subject.model, seen)
    deepest: dict[tuple[int, int], float] = {}
    for pair, distance in zip(seen.contact.geom.tolist(), seen.contact.dist.tolist(), strict=True):
        key = (min(pair), max(pair))
        deepest[key] = max(deepest.get(key, -1.0), -distance)
    for (one, other), depth in sorted(deepest.items(), key=lambda item: (-item[1], item[0])):
        yield Penetration(subject.message(one), subject.message(other), depth)


def _deep(found: tuple[Penetration, ...], limit: float | None, when: str) -> Measurement:
    assert limit is not None
    deep = [t for t in found if t.depth > limit]
    problems = [(f"geoms/{t.one}", f"is {t.depth * MM:.2f} mm in {t.other} {when}") for t in deep[:LISTED]]
    return Measurement(max((t.depth for t in found), default=0.0), tuple(problems))


def _pointer(joint: str) -> str:
    return f"joints/{joint}"
