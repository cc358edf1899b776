"""Find joints that a hand of 20 N at the grip cannot open in the whole scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.motion.hand_force import CHUNK, LONGEST_S, hand_effort
from casa_assets.checks.scene.motion.opening import JointSweep, SweepTester
from casa_assets.checks.scene.subject import AllPairs, ScenePart, SceneSubject, around, boxes, meet, reset
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.core.typing import Floats

# Parts that come nearer to each other than this on their ways are not pulled at the same time.
APART_M = 0.005


@dataclass(frozen=True)
class Pull:
    """A part that is pulled: from where to where, and all the space that it needs as a (2, 3) box."""

    part: ScenePart
    start: float
    goal: float
    room: Floats


def joints_open_by_hand(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN006: least share of its range that a joint covers within 2 s under 20 N at its grip.

    Parts whose ways lie apart are pulled at the same time.
    """
    assert limit is not None
    if not subject.parts:
        return not_applicable("nothing in it has a joint")
    least, problems = 1.0, []
    reached = pull_all(subject, limit)
    for part in subject.parts:
        share, met = reached[part.name]
        least = min(least, share)
        if share < limit:
            why = f"it meets {met}" if met else "ease its friction, damping or spring"
            message = f"goes {share:.0%} of its way under {PULL_N:g} N in {LONGEST_S:g} s; {why}"
            problems.append((f"joints/{part.name}", message))
    return Measurement(least, tuple(problems))


def pull_all(subject: SceneSubject, enough: float) -> dict[str, tuple[float, str]]:
    """Name of a joint -> share of its range that it covers (no more than just over `enough`), and what stopped it."""
    tester = SweepTester(subject, 0.0)
    rounds: list[list[Pull]] = []
    for part in subject.parts:
        pull = _pull(tester, part)
        home = next((r for r in rounds if all(_independent(subject, pull, other) for other in r)), None)
        if home is None:
            rounds.append([pull])
        else:
            home.append(pull)
    found: dict[str, tuple[float, str]] = {}
    with AllPairs(subject.model), _dozing(subject.model):
        for pulls in rounds:
            found |= _run(subject, pulls, enough)
    return found


@contextmanager
def _dozing(model: mujoco.MjModel) -> Iterator[None]:
    """While it lasts, MuJoCo lets sleep what is at rest and not pulled, which takes less than half of the time.

    How far parts go was the same to the last digit with and without, on 255 joints of three kitchens.
    """
    kept = int(model.opt.enableflags)
    model.opt.enableflags = kept | int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    try:
        yield
    finally:
        model.opt.enableflags = kept


def _pull(tester: SweepTester, part: ScenePart) -> Pull:
    way: JointSweep = tester.way(part)
    taken = [way.bounds]
    # What has to stand open for it takes room as well.
    tester.stand(part.before)
    for name in part.before:
        taken.append(around(boxes(tester.model, tester.data, tester.subject.part_of[name].geoms)))
    return Pull(part, float(way.values[0]), float(way.values[-1]), around(np.array(taken)))


def _independent(subject: SceneSubject, one: Pull, other: Pull) -> bool:
    model = subject.model
    if one.part.place == other.part.place and (one.part.before or other.part.before):
        return False
    roots = {int(model.body_weldid[model.body_rootid[model.jnt_bodyid[p.part.number]]]) for p in (one, other)}
    if len(roots) == 1 and roots != {0}:
        return False  # both hang on one thing that may tip
    carried = one.part.moved[model.jnt_bodyid[other.part.number]] or other.part.moved[model.jnt_bodyid[one.part.number]]
    return not carried and not bool(meet(one.room, other.room, APART_M).any())


def _run(subject: SceneSubject, pulls: list[Pull], enough: float) -> Mapping[str, tuple[float, str]]:
    """Pull several parts at once, all else as the scene begins, until each has come far enough or the time is up."""
    model = subject.model
    data = mujoco.MjData(model)
    reset(model, data)
    for part in subject.parts:
        data.qpos[part.address] = 0.0
    for pull in pulls:
        for name, value in {**pull.part.before, pull.part.name: pull.start}.items():
            data.qpos[subject.part_of[name].address] = value
    for pull in pulls:
        effort = hand_effort(pull.part.asset, pull.part.joint)
        data.qfrc_applied[pull.part.dof] = math.copysign(effort, pull.goal - pull.start)
    best = np.zeros(len(pulls))
    start, goal = (np.array([getattr(p, name) for p in pulls]) for name in ("start", "goal"))
    at = [p.part.address for p in pulls]
    for _ in range(round(LONGEST_S / model.opt.timestep / CHUNK)):
        mujoco.mj_step(model, data, nstep=CHUNK)
        best = np.maximum(best, (data.qpos[at] - start) / (goal - start))
        if best.min() >= enough:
            break
    stuck = {p.part.name: _met(subject, data, p.part) for p, share in zip(pulls, best, strict=True) if share < enough}
    return {p.part.name: (float(s), stuck.get(p.part.name, "")) for p, s in zip(pulls, best, strict=True)}


def _met(subject: SceneSubject, data: mujoco.MjData, part: ScenePart) -> str:
    """Other thing that a part touches deepest; empty where it touches none."""
    moved = part.moved[subject.model.geom_bodyid]
    for i in np.argsort(data.contact.dist):
        one, other = (int(g) for g in data.contact.geom[i])
        if moved[one] != moved[other]:
            other = other if moved[one] else one
            if subject.owner[other] != part.place.name:
                return subject.message(other)
    return ""
