"""Postures to begin inverse kinematics with: drawn once for a robot, chosen by how near a hand then is to a grasp."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks.robots.assemble import BASE_JOINTS, tip_name
from casa_assets.checks.robots.grips import Grasp
from casa_assets.checks.robots.inverse_kinematics import Bounds
from casa_assets.checks.robots.workspace import Workspace
from casa_assets.core.typing import Floats
from casa_assets.model.kitchen.robot import Robot
from casa_assets.model.record import Vec3

DRAWN = 60_000  # postures
NEAR_HOME = 0.5  # share of them that is drawn around the posture at rest
SPREAD_RAD = 1.0  # standard deviation of these
LIFT_BEYOND = 0.5  # share of its range by which a lift is drawn beyond its ends, where it then stands
LAYER_M, IN_LAYER = 0.1, 900  # height of a layer, and how many postures are kept that have a hand in it
TURNS = (-1.0, 0.0, 1.0)  # shares of the room for turning at which a base is tried
M_PER_RAD = 0.25  # metres that an angle between a hand and a grasp counts as
DEPTH_WEIGHT = 2.0  # metres that a metre of overlap with the kitchen counts as
LATER_M = 0.002  # metres that each place further down the list of grasps counts as: the most natural stand first
LOOKED_AT, KEPT = 8, 2  # postures for one grasp whose overlap is looked at, and those that are kept


@dataclass(frozen=True)
class Seed:
    """A posture to begin with.

    Attributes:
        score: the lower, the nearer the goal, m. arm: its number. tip: site of its hand.
    """

    score: float
    arm: int
    tip: str
    grasp: Grasp
    posture: Floats


@dataclass(frozen=True)
class _Drawn:
    """Postures of shape (n, nq), and where a hand is in them: shape (n, 3), (n, 3, 3)."""

    postures: Floats
    positions: Floats
    rotations: Floats


class Seeds:
    """Postures of a robot at the origin, and the poses of its hands in them."""

    def __init__(self, workspace: Workspace, robot: Robot) -> None:
        """Draw them, the same each time: as many for each height of a hand, none in which the robot touches itself."""
        self._workspace = workspace
        workspace.place(0.0, 0.0, 0.0)
        model = workspace.alone
        data = mujoco.MjData(model)
        self._tips = [(k, press, tip_name(arm, press)) for k, arm in enumerate(robot.arms) for press in (False, True)]
        sites = [model.site(tip).id for _, _, tip in self._tips]
        drawn = _draw(workspace)
        positions = np.zeros((len(drawn), len(sites), 3))
        rotations = np.zeros((len(drawn), len(sites), 3, 3))
        for k, q in enumerate(drawn):
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            positions[k] = data.site_xpos[sites]
            rotations[k] = data.site_xmat[sites].reshape(-1, 3, 3)
        self._drawn = {}
        for k, (arm, press, _) in enumerate(self._tips):
            if not press:
                kept = _spread_over_heights(workspace, drawn, positions[:, k, 2])
            self._drawn[arm, press] = _Drawn(drawn[kept], positions[kept, k], rotations[kept, k])

    def toward(self, grasps: Sequence[tuple[int, Grasp]], press: bool, place: Vec3, bounds: Bounds) -> list[Seed]:
        """Postures near any of some grasps, the nearest first; two for each grasp at most.

        Args:
            grasps: number of the arm, and its grasp; the most natural first.
            press: whether it is pressed with a fingertip.
            place: x, y, yaw at which the base's joints are at zero. The workspace is placed there already.
            bounds: ranges of the joints; the first three are the base's.
        """
        found: list[Seed] = []
        for order, (arm, grasp) in enumerate(grasps):
            near = self._nearest(self._drawn[arm, press], grasp, place, bounds)
            scored = [(score + DEPTH_WEIGHT * self._workspace.overlap(q), k, q) for k, (score, q) in enumerate(near)]
            scored.sort(key=lambda one: one[:2])
            tip = next(name for number, pressing, name in self._tips if (number, pressing) == (arm, press))
            found += [Seed(score + LATER_M * order, arm, tip, grasp, q) for score, _, q in scored[:KEPT]]
        return sorted(found, key=lambda seed: seed.score)

    def _nearest(self, drawn: _Drawn, grasp: Grasp, place: Vec3, bounds: Bounds) -> list[tuple[float, Floats]]:
        """Postures with the base in its room, by distance of the hand from the grasp."""
        goal = _level(-place[2]) @ (grasp.position - np.array((place[0], place[1], 0.0)))
        wanted = _level(-place[2]) @ grasp.rotation
        n = len(BASE_JOINTS)
        low, high = bounds.low[:n], bounds.high[:n]
        found: list[tuple[float, Floats]] = []
        for share in TURNS:
            turn = float((low[2] + high[2]) / 2 + share * (high[2] - low[2]) / 2)
            there = drawn.positions @ _level(turn).T
            base = np.clip((goal - there)[:, :2], low[:2], high[:2])
            missing = goal - there
            missing[:, :2] -= base
            angles = _angles(drawn.rotations, _level(-turn) @ wanted, grasp.pivots)
            apart = np.sqrt(np.einsum("ni,ni->n", missing, missing)) + M_PER_RAD * angles
            least = np.argpartition(apart, min(LOOKED_AT, len(apart) - 1))[:LOOKED_AT]
            for k in least[np.lexsort((least, apart[least]))]:
                q = np.clip(drawn.postures[k], bounds.low, bounds.high)
                q[:n] = (*base[k], turn)
                found.append((float(apart[k]), q))
        return sorted(found, key=lambda one: one[0])[:LOOKED_AT]


def _draw(workspace: Workspace) -> Floats:
    """Postures with the base at zero, shape (DRAWN, nq): all over the ranges, and around the one at rest."""
    rng, home = np.random.default_rng(1), workspace.home
    low, high = workspace.alone.jnt_range[:, 0], workspace.alone.jnt_range[:, 1]
    drawn = rng.uniform(low, high, (DRAWN, len(home)))
    near = int(NEAR_HOME * DRAWN)
    drawn[:near] = np.clip(home + rng.normal(0.0, SPREAD_RAD, (near, len(home))), low, high)
    for k in range(workspace.alone.njnt):
        if workspace.alone.jnt_type[k] == mujoco.mjtJoint.mjJNT_SLIDE:
            more = LIFT_BEYOND * (high[k] - low[k])
            drawn[:, k] = np.clip(rng.uniform(low[k] - more, high[k] + more, DRAWN), low[k], high[k])
    drawn[0] = home
    drawn[:, : len(BASE_JOINTS)] = 0.0
    return workspace.with_legs(drawn)


def _spread_over_heights(workspace: Workspace, drawn: Floats, heights: Floats) -> list[int]:
    """Numbers of postures in which the robot does not touch itself, at most `IN_LAYER` for each layer of heights."""
    kept: list[int] = []
    layers = np.floor(heights / LAYER_M).astype(int)
    for layer in np.unique(layers[layers >= 0]):
        found = 0
        for k in np.nonzero(layers == layer)[0]:
            if found == IN_LAYER:
                break
            if workspace.is_clear_of_itself(drawn[k]):
                kept.append(int(k))
                found += 1
    return kept


def _level(angle: float) -> Floats:
    """Rotation about the upright axis."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))


def _angles(rotations: Floats, wanted: Floats, pivots: bool) -> Floats:
    """Angles between rotations of shape (n, 3, 3) and another; between their second axes where a hand may pivot."""
    cosine = rotations[:, :, 1] @ wanted[:, 1] if pivots else (np.einsum("nij,ij->n", rotations, wanted) - 1.0) / 2.0
    angles: Floats = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angles
