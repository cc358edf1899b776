"""Find doors, drawers and lids of a scene that run into something, or that no hand opens."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import lru_cache

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, not_applicable, worst_above, worst_below
from casa_assets.checks.motion.joints import CHUNK_STEPS, PUSH_S, hand_effort
from casa_assets.checks.motion.simulation import (
    altered,
    box_around,
    box_corners,
    boxes_at,
    geom_boxes,
    open_end,
    reset_to_start,
)
from casa_assets.checks.scene.rest import NO_JOINTS
from casa_assets.checks.scene.subject import SceneJoint, SceneSubject, all_pairs, boxes_meet
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.core.numeric import Floats, Mask
from casa_assets.model.asset.asset import JointKind

# How far the point that moves fastest goes between two poses. A corner that swings 1 mm deep past an edge on an arm of
# 20 mm is in it for 12 mm of its way, on one of 0.6 m for 69 mm.
STEP_M = 0.004
MIN_POSES, MAX_POSES = 12, 600
MM_PER_M = 1000.0
# A joint opens both ways where it goes more than this share of its range to either side of zero.
BOTH_WAYS_SHARE = 0.05
Pair = tuple[int, int]
# Joints whose parts come nearer to each other than this on their paths are not pulled at the same time.
MIN_SEPARATION_M = 0.005


@dataclass(frozen=True)
class SweptPath:
    """Path of what a joint moves while all else is shut: its (N,) positions, and (N, 2, 3) boxes around it, metres.

    `before`: positions of the joints that have to be open, by name in the model: rad or m.
    """

    positions: Floats
    boxes: Floats
    bounds: Floats
    before: Mapping[str, float]


@dataclass(frozen=True)
class Clash:
    """Contact of what a joint moves with something else, from a share of its range on; metres deeper than at rest.

    `moved`, `other`: geoms at the deepest. `open_joint`: joint that is open meanwhile, or empty.
    """

    share: float
    depth: float
    moved: int
    other: int
    open_joint: str = ""

    @property
    def pair(self) -> Pair:
        """The two geoms, the lower number first."""
        return min(self.moved, self.other), max(self.moved, self.other)


def joints_open_without_collision(subject: SceneSubject, limit: float) -> Measurement:
    """SCN005: deepest clash over any joint's range, alone and next to each open neighbour; metres beyond rest."""
    if not subject.operated:
        return not_applicable(NO_JOINTS)
    sweeper, paths = JointSweeper(subject, limit), paths_of(subject)
    rows = []
    for joint in subject.operated.values():
        for clash in _clashes(sweeper, joint, paths):
            while_open = f" while {clash.open_joint} stands open" if clash.open_joint else ""
            moved, other = subject.geom_name(clash.moved), subject.geom_name(clash.other)
            way = f"from {clash.share:.0%} of its way {moved} runs up to {clash.depth * MM_PER_M:.1f} mm"
            rows.append((f"joints/{joint.name}", clash.depth, f"{way} into {other}{while_open}"))
    return worst_above(rows, limit)


@lru_cache(maxsize=1)
def paths_of(subject: SceneSubject) -> dict[str, SweptPath]:
    """The paths of all operated joints of a scene, by name, followed once; they are only read."""
    sweeper = JointSweeper(subject, 0.0)
    return {name: sweeper.path(joint) for name, joint in subject.operated.items()}


def _clashes(sweeper: JointSweeper, joint: SceneJoint, paths: Mapping[str, SweptPath]) -> Iterator[Clash]:
    """The worst clash with each thing while all else is shut, and then next to each neighbour that is open."""
    path = paths[joint.name]
    alone = sweeper.clashes(joint, path, dict(path.before), None)
    yield from alone
    reported = {clash.pair for clash in alone if clash.depth > sweeper.limit}
    others = sweeper.subject.operated
    near = boxes_meet(path.bounds, np.array([paths[name].bounds for name in others]))
    for other in (other for other, meets in zip(others.values(), near.tolist(), strict=True) if meets):
        other_path = paths[other.name]
        if other.name == joint.name or other.name in path.before or joint.name in other_path.before:
            continue
        low, high = other.joint.range
        least = BOTH_WAYS_SHARE * (high - low)
        both_ways = low < -least and high > least
        for end in (low, high) if both_ways else (open_end(other.joint),):
            positions = {**other_path.before, **path.before, other.name: end}
            for clash in sweeper.clashes_beside(joint, path, other, positions):
                if clash.pair not in reported:
                    yield clash


class JointSweeper:
    """Sweeps joints of a scene; the model's contact filters are restored after each sweep."""

    def __init__(self, subject: SceneSubject, limit: float) -> None:
        self.subject, self.limit = subject, limit
        self.model = subject.model
        self.data = mujoco.MjData(self.model)
        self.set_joints({})
        with all_pairs(self.model):
            mujoco.mj_collision(self.model, self.data)
        self.depths_at_rest = dict(self._depths())

    def path(self, joint: SceneJoint) -> SweptPath:
        """Path of what a joint moves, from shut to open."""
        self.set_joints(joint.before)
        low, high = joint.joint.range
        start, end = (low, high) if open_end(joint.joint) == high else (high, low)
        steps = int(np.clip(np.ceil((high - low) * self._reach(joint) / STEP_M), MIN_POSES, MAX_POSES))
        return self._follow(joint, np.linspace(start, end, steps + 1), joint.before)

    def _follow(self, joint: SceneJoint, positions: Floats, before: Mapping[str, float]) -> SweptPath:
        """The boxes around the parts that a joint moves, at each position, with all other joints as they are."""
        places = np.empty((len(positions), len(joint.geoms), 3))
        turns = np.empty((len(positions), len(joint.geoms), 9))
        for i, position in enumerate(positions):
            self.data.qpos[joint.address] = position
            self.subject.contents.pose(self.data)
            places[i], turns[i] = self.data.geom_xpos[joint.geoms], self.data.geom_xmat[joint.geoms]
        boxes = box_around(boxes_at(self.model, joint.geoms, places, turns))
        return SweptPath(positions, boxes, box_around(boxes), before)

    def clashes(
        self, joint: SceneJoint, path: SweptPath, positions: dict[str, float], against: Mask | None
    ) -> list[Clash]:
        """The worst clash with each other placement on the path of what a joint moves, with joints at `positions`.

        `against`: (ngeom,) what counts; all that is not moved where None.
        """
        self.set_joints(positions)
        boxes = geom_boxes(self.model, self.data, np.arange(self.model.ngeom))
        moved = joint.moved[self.model.geom_bodyid]
        against = ~moved if against is None else against & ~moved
        against &= boxes_meet(boxes, path.bounds, STEP_M)
        worst: dict[str, Clash] = {}
        if not against.any():
            return []
        poses = boxes_meet(path.boxes[:, None], boxes[against][None], STEP_M).any(axis=1)
        with all_pairs(self.model), only_pairs(self.model, moved, against):
            for i in np.flatnonzero(poses):
                self.data.qpos[joint.address] = path.positions[i]
                self.subject.contents.pose(self.data)
                mujoco.mj_collision(self.model, self.data)
                if self.data.ncon:
                    self._record(worst, moved, float(i) / (len(path.positions) - 1))
        return list(worst.values())

    def clashes_beside(
        self, joint: SceneJoint, path: SweptPath, other: SceneJoint, positions: dict[str, float]
    ) -> list[Clash]:
        """The clashes of the parts that a joint moves while another joint is open."""
        bodies = self.model.jnt_bodyid
        if other.moved[bodies[joint.id]] or joint.moved[bodies[other.id]]:
            # One carries the other, so that what is moved has another outline or another path now.
            self.set_joints(positions)
            clashes = self.clashes(joint, self._follow(joint, path.positions, path.before), positions, None)
        else:
            clashes = self.clashes(joint, path, positions, other.moved[self.model.geom_bodyid])
        return [replace(clash, open_joint=other.name) for clash in clashes]

    def _record(self, worst: dict[str, Clash], moved: Mask, share: float) -> None:
        """Note the present contacts that are deeper than at rest."""
        for (geom1, geom2), depth in self._depths():
            mover, other = (geom1, geom2) if moved[geom1] else (geom2, geom1)
            beyond = depth - max(0.0, self.depths_at_rest.get((geom1, geom2), 0.0))
            if beyond <= 0.0:
                continue
            placement = self.subject.placement_of[other]
            known = worst.get(placement)
            begins = share if known is None or known.depth <= self.limit else known.share
            if known is None or beyond > known.depth:
                worst[placement] = Clash(begins, beyond, mover, other)

    def _depths(self) -> Iterator[tuple[Pair, float]]:
        """Ordered pair of geoms and depth of each contact, metres; negative where they are apart."""
        contact = self.data.contact
        for (geom1, geom2), distance in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            yield (min(geom1, geom2), max(geom1, geom2)), -distance

    def set_joints(self, positions: Mapping[str, float]) -> None:
        """Shut all joints but these: rad or m, by name in the model."""
        self.data.qpos[:] = self.model.qpos0
        for name, position in positions.items():
            self.data.qpos[self.subject.joints[name].address] = position
        self.subject.contents.pose(self.data)

    def _reach(self, joint: SceneJoint) -> float:
        """Distance of what a hinge moves from its axis, metres; 1 for a slide."""
        if joint.joint.kind is JointKind.SLIDE or not len(joint.geoms):
            return 1.0
        arm = box_corners(geom_boxes(self.model, self.data, joint.geoms)) - self.data.xanchor[joint.id]
        axis = self.data.xaxis[joint.id]
        return float(np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1).max())


def only_pairs(model: mujoco.MjModel, moved: Mask, against: Mask) -> AbstractContextManager[None]:
    """While it is entered, only moved geoms collide, and only with those that they are swept against."""
    bodies = [np.isin(np.arange(model.nbody), model.geom_bodyid[geoms]) for geoms in (moved, against)]
    return altered(
        model, geom_contype=moved, geom_conaffinity=against, body_contype=bodies[0], body_conaffinity=bodies[1]
    )


@dataclass(frozen=True)
class Pull:
    """A joint that is pulled from one position to another, and the (2, 3) box of all the space that it needs."""

    joint: SceneJoint
    start: float
    goal: float
    bounds: Floats


def joints_open_by_hand(subject: SceneSubject, limit: float) -> Measurement:
    """SCN006: least share of its range that a joint covers within 2 s under 20 N at its grip.

    Joints whose parts move apart from each other are pulled at the same time.
    """
    if not subject.operated:
        return not_applicable(NO_JOINTS)
    rows, reached = [], pull_all(subject, limit)
    for name in subject.operated:
        share, blocked_by = reached[name]
        advice = f"it meets {blocked_by}" if blocked_by else "ease its friction, damping or spring"
        message = f"goes {share:.0%} of its way under {PULL_N:g} N in {PUSH_S:g} s; {advice}"
        rows.append((f"joints/{name}", min(share, 1.0), message))
    return worst_below(rows, limit, NO_JOINTS)


def pull_all(subject: SceneSubject, enough: float) -> dict[str, tuple[float, str]]:
    """Name of a joint -> share of its range that it covers (no more than just over `enough`), and what stopped it."""
    sweeper = JointSweeper(subject, 0.0)
    rounds: list[list[Pull]] = []
    for joint in subject.operated.values():
        path = paths_of(subject)[joint.name]
        # What has to stand open for it takes room as well.
        sweeper.set_joints(joint.before)
        geoms = [subject.joints[name].geoms for name in joint.before]
        boxes = [path.bounds, *(box_around(geom_boxes(sweeper.model, sweeper.data, found)) for found in geoms)]
        pull = Pull(joint, float(path.positions[0]), float(path.positions[-1]), box_around(np.array(boxes)))
        joined = next((r for r in rounds if all(_are_independent(subject, pull, other) for other in r)), None)
        if joined is None:
            rounds.append([pull])
        else:
            joined.append(pull)
    reached: dict[str, tuple[float, str]] = {}
    options = subject.model.opt
    # MuJoCo lets sleep what is at rest and not pulled, which takes less than half of the time. How far parts go was the
    # same to the last digit with and without, on 255 joints of three kitchens.
    asleep = options.enableflags | int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    with all_pairs(subject.model), altered(options, enableflags=asleep):
        for pulls in rounds:
            reached |= _simulate(subject, pulls, enough)
    return reached


def _are_independent(subject: SceneSubject, pull: Pull, other: Pull) -> bool:
    """True if two joints can be pulled at the same time without a part of one touching or moving that of the other."""
    model, first, second = subject.model, pull.joint, other.joint
    if first.placement == second.placement and (first.before or second.before):
        return False
    bodies = [model.jnt_bodyid[first.id], model.jnt_bodyid[second.id]]
    roots = {int(model.body_weldid[model.body_rootid[body]]) for body in bodies}
    if len(roots) == 1 and roots != {0}:
        return False  # both are parts of one thing that may tip over
    carried = first.moved[bodies[1]] or second.moved[bodies[0]]
    return not carried and not bool(boxes_meet(pull.bounds, other.bounds, MIN_SEPARATION_M).any())


def _simulate(subject: SceneSubject, pulls: list[Pull], enough: float) -> Mapping[str, tuple[float, str]]:
    """Pull several joints at once, all else as the scene begins, until each has come far enough or the time is up."""
    model = subject.model
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    for joint in subject.joints.values():
        data.qpos[joint.address] = 0.0
    for pull in pulls:
        for name, position in {**pull.joint.before, pull.joint.name: pull.start}.items():
            data.qpos[subject.joints[name].address] = position
        effort = hand_effort(pull.joint.asset, pull.joint.joint)
        data.qfrc_applied[pull.joint.dof] = math.copysign(effort, pull.goal - pull.start)
    shares = np.zeros(len(pulls))
    start, goal = np.array([pull.start for pull in pulls]), np.array([pull.goal for pull in pulls])
    addresses = [pull.joint.address for pull in pulls]
    for _ in range(round(PUSH_S / model.opt.timestep / CHUNK_STEPS)):
        mujoco.mj_step(model, data, nstep=CHUNK_STEPS)
        shares = np.maximum(shares, (data.qpos[addresses] - start) / (goal - start))
        if shares.min() >= enough:
            break
    return {
        pull.joint.name: (float(share), _blocked_by(subject, data, pull.joint) if share < enough else "")
        for pull, share in zip(pulls, shares, strict=True)
    }


def _blocked_by(subject: SceneSubject, data: mujoco.MjData, joint: SceneJoint) -> str:
    """Geom of another placement that what a joint moves touches deepest; empty where it touches none."""
    moved = joint.moved[subject.model.geom_bodyid]
    for i in np.argsort(data.contact.dist):
        geom1, geom2 = (int(g) for g in data.contact.geom[i])
        if moved[geom1] != moved[geom2]:
            other = geom2 if moved[geom1] else geom1
            if subject.placement_of[other] != joint.placement.name:
                return subject.geom_name(other)
    return ""
