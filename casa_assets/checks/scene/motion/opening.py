"""Find joints that run into something over their range, alone or with each neighbour open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.scene.subject import (
    AllPairs,
    ScenePart,
    SceneSubject,
    around,
    boxes,
    corners,
    meet,
)
from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.model.asset.asset import JointKind

# How far the point that moves fastest goes between two poses. A corner that swings 1 mm deep past an edge on an arm of
# 20 mm is in it for 12 mm of its way, on one of 0.6 m for 69 mm.
STEP_M = 0.004
LEAST_POSES, MOST_POSES = 12, 600
MM = 1000.0
Pair = tuple[int, int]


@dataclass(frozen=True)
class JointSweep:
    """Path of a joint's parts while all else is shut.

    Attributes:
        values: (N,) rad or m, from its start to its far end. boxes: (N, 2, 3) around its parts at each, metres.
        bounds: (2, 3) around them all.
        home: setting of the joints that have to stand open, by name in the model.
    """

    values: Floats
    boxes: Floats
    bounds: Floats
    home: Mapping[str, float]


@dataclass(frozen=True)
class Clash:
    """Contact of a joint's parts with something else.

    Attributes:
        share: of the joint's range at which it begins. depth: the deepest on the way, metres, beyond that at rest.
        one, other: geoms at the deepest. beside: joint that stands open meanwhile, or nothing.
    """

    share: float
    depth: float
    one: int
    other: int
    beside: str = ""


def joints_open_without_collision(subject: SceneSubject, limit: float | None) -> Measurement:
    """No part runs into anything by more than `limit` over its joint's range, alone and beside each open neighbour.

    Metres of the worst, beyond what is there while all is shut.
    """
    assert limit is not None
    if not subject.parts:
        return not_applicable("nothing in it has a joint")
    tester = SweepTester(subject, limit)
    ways = {part.name: tester.way(part) for part in subject.parts}
    worst, problems = 0.0, []
    for part in subject.parts:
        for clash in _clashes(tester, part, ways):
            worst = max(worst, clash.depth)
            if clash.depth > limit:
                problems.append((f"joints/{part.name}", _says(subject, clash)))
    return Measurement(worst, tuple(problems))


def _says(subject: SceneSubject, clash: Clash) -> str:
    beside = f" while {clash.beside} stands open" if clash.beside else ""
    one, other = subject.message(clash.one), subject.message(clash.other)
    return f"from {clash.share:.0%} of its way {one} runs up to {clash.depth * MM:.1f} mm into {other}{beside}"


def _clashes(tester: SweepTester, part: ScenePart, ways: Mapping[str, JointSweep]) -> Iterator[Clash]:
    """The worst clash with each thing that is met, alone, and then of each neighbour that is open."""
    way = ways[part.name]
    met = tester.sweep(part, way, dict(way.home), None)
    yield from met
    known = {subject_pair(clash) for clash in met if clash.depth > tester.limit}
    for other in tester.subject.parts:
        if other.name == part.name or other.name in way.home or part.name in ways[other.name].home:
            continue
        if not meet(way.bounds, ways[other.name].bounds):
            continue
        for end in _ends(other):
            setting = {**ways[other.name].home, **way.home, other.name: end}
            for clash in tester.beside(part, way, other, setting):
                # What is met with everything shut is said once.
                if subject_pair(clash) not in known:
                    yield clash


def subject_pair(clash: Clash) -> Pair:
    """The two geoms of a clash in order."""
    return (min(clash.one, clash.other), max(clash.one, clash.other))


def _ends(part: ScenePart) -> list[float]:
    """Open positions of a joint: both ends where it goes both ways."""
    low, high = part.joint.range
    return [low, high] if low < -0.05 * (high - low) and high > 0.05 * (high - low) else [part.far]


class SweepTester:
    """Sweeps joints of a scene; the model's contact filters are put back after each sweep."""

    def __init__(self, subject: SceneSubject, limit: float) -> None:
        self.subject, self.limit = subject, limit
        self.model = subject.model
        self.data = mujoco.MjData(self.model)
        self.stand({})
        with AllPairs(self.model):
            mujoco.mj_collision(self.model, self.data)
        self.shut = boxes(self.model, self.data, np.arange(self.model.ngeom))
        self.at_rest = dict(self._depths())

    def way(self, part: ScenePart) -> JointSweep:
        """Path of a joint's parts from shut to open."""
        self.stand(part.before)
        low, high = part.joint.range
        start, end = (low, high) if part.far == high else (high, low)
        steps = int(np.clip(np.ceil((high - low) * self._reach(part) / STEP_M), LEAST_POSES, MOST_POSES))
        values = np.linspace(start, end, steps + 1)
        passed = np.empty((len(values), 2, 3))
        for i, value in enumerate(values):
            self.data.qpos[part.address] = value
            mujoco.mj_kinematics(self.model, self.data)
            passed[i] = around(boxes(self.model, self.data, part.geoms))
        return JointSweep(values, passed, around(passed), part.before)

    def sweep(self, part: ScenePart, way: JointSweep, setting: dict[str, float], against: Mask | None) -> list[Clash]:
        """Contacts of a joint's parts on their path.

        Args:
            setting: joints that are not at zero. against: (ngeom,) what counts, all that is not moved where None.
        """
        self.stand(setting)
        here = boxes(self.model, self.data, np.arange(self.model.ngeom))
        moved = part.moved[self.model.geom_bodyid]
        against = ~moved if against is None else against & ~moved
        against &= meet(here, way.bounds, STEP_M)
        found: dict[str, Clash] = {}
        if not against.any():
            return []
        poses = meet(way.boxes[:, None], here[against][None], STEP_M).any(axis=1)
        with AllPairs(self.model), OnlyPairs(self.model, moved, against):
            for i in np.flatnonzero(poses):
                self.data.qpos[part.address] = way.values[i]
                mujoco.mj_kinematics(self.model, self.data)
                mujoco.mj_collision(self.model, self.data)
                if self.data.ncon:
                    self._note(found, moved, float(i) / (len(way.values) - 1))
        return list(found.values())

    def beside(self, part: ScenePart, way: JointSweep, other: ScenePart, setting: dict[str, float]) -> list[Clash]:
        """Contacts of a joint's parts while another joint stands open."""
        carried = bool(
            other.moved[self.model.jnt_bodyid[part.number]] or part.moved[self.model.jnt_bodyid[other.number]]
        )
        if carried:
            # One carries the other: its own outline or its way is another now.
            self.stand(setting)
            way = self._way_in(part, way, setting)
            met = self.sweep(part, way, setting, None)
        else:
            met = self.sweep(part, way, setting, other.moved[self.model.geom_bodyid])
        return [Clash(c.share, c.depth, c.one, c.other, other.name) for c in met]

    def _way_in(self, part: ScenePart, way: JointSweep, setting: dict[str, float]) -> JointSweep:
        self.stand(setting)
        passed = np.empty_like(way.boxes)
        for i, value in enumerate(way.values):
            self.data.qpos[part.address] = value
            mujoco.mj_kinematics(self.model, self.data)
            passed[i] = around(boxes(self.model, self.data, part.geoms))
        return JointSweep(way.values, passed, around(passed), way.home)

    def _note(self, found: dict[str, Clash], moved: Mask, share: float) -> None:
        for (one, other), depth in self._depths():
            if not moved[one]:
                one, other = other, one
            beyond = depth - max(0.0, self.at_rest.get((min(one, other), max(one, other)), 0.0))
            if beyond <= 0.0:
                continue
            key = self.subject.owner[other]
            known = found.get(key)
            begins = share if known is None or known.depth <= self.limit else known.share
            if known is None or beyond > known.depth:
                found[key] = Clash(begins, beyond, one, other)

    def _depths(self) -> Iterator[tuple[Pair, float]]:
        contact = self.data.contact
        for (one, other), distance in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            yield (min(one, other), max(one, other)), -distance

    def stand(self, setting: Mapping[str, float]) -> None:
        """Everything shut but the joints of a setting: rad or m, by name in the model."""
        self.data.qpos[:] = self.model.qpos0
        for name, value in setting.items():
            self.data.qpos[self.subject.part_of[name].address] = value
        mujoco.mj_kinematics(self.model, self.data)

    def _reach(self, part: ScenePart) -> float:
        """Distance of a hinge's parts from its axis, metres; 1 for a slide."""
        if part.joint.kind is JointKind.SLIDE or not len(part.geoms):
            return 1.0
        points = corners(boxes(self.model, self.data, part.geoms))
        arm = points - self.data.xanchor[part.number]
        axis = self.data.xaxis[part.number]
        return float(np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1).max())


class OnlyPairs:
    """While it is entered, only moved geoms can meet those that they are tried against."""

    def __init__(self, model: mujoco.MjModel, moved: Mask, against: Mask) -> None:
        self.model = model
        self.fields = ("geom_contype", "geom_conaffinity", "body_contype", "body_conaffinity")
        self.kept = [getattr(model, field).copy() for field in self.fields]
        bodies = [bodies_of(model, np.flatnonzero(mask)) for mask in (moved, against)]
        self.wanted = [moved, against, *bodies]

    def __enter__(self) -> None:
        for field, wanted in zip(self.fields, self.wanted, strict=True):
            getattr(self.model, field)[:] = wanted

    def __exit__(self, *_: object) -> None:
        for field, kept in zip(self.fields, self.kept, strict=True):
            getattr(self.model, field)[:] = kept


def bodies_of(model: mujoco.MjModel, geoms: Ints) -> Mask:
    """(nbody,) which bodies have one of these geoms."""
    found = np.zeros(model.nbody, dtype=bool)
    found[model.geom_bodyid[geoms]] = True
    return found
