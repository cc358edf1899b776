"""Bring a hand to a place, joints within their ranges, the robot clear of all else."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mink
import mujoco
import numpy as np

from casa_assets.addons.robots.grips import Grasp
from casa_assets.addons.robots.workspace import BASE_JOINTS, Workspace, tip_name
from casa_assets.ext.arrays import Floats
from casa_assets.ext.kitchens import Robot
from casa_assets.ext.records import Vec3

SOLVER = "daqp"
POSITION_M, ANGLE_RAD = 0.005, math.radians(3.0)  # to which a hand has to get; a finger comes with 6 mm to spare
STEP = 0.25  # largest change of a joint in one iteration, rad or m
KEPT_M = 0.001  # distance that is kept from all else
GAIN = 0.7  # share of the room to what is near that one iteration may use up
HOME_COST, BASE_COST = 1e-2, 1e-1  # of leaving the posture at rest, and the parking place, beside 1 of missing the goal
PIVOT_COST = 1e-2  # of turning about a bar that is held
STALLED = 12  # iterations without a nearer approach, after which no more are made
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
class Bounds:
    """Ends of the joints' ranges, shape (nq,) each."""

    low: Floats
    high: Floats


class _KeepClear(mink.Limit):
    def __init__(self, workspace: Workspace) -> None:
        self.workspace = workspace

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """Rows of G dq <= h, one per pair that is near."""
        del dt
        near = self.workspace.near(configuration.q)
        if not near:
            return mink.Constraint()
        model, data = configuration.model, configuration.data
        rows, bound = np.zeros((len(near), model.nv)), np.zeros(len(near))
        jacobian = np.zeros((3, model.nv))
        for k, pair in enumerate(near):
            for body, sign in zip(pair.bodies, (1.0, -1.0), strict=True):
                if body is not None:
                    mujoco.mj_jac(model, data, jacobian, None, pair.point, body)
                    rows[k] += sign * (pair.normal @ jacobian)
            bound[k] = GAIN * (pair.distance - KEPT_M)
        moved = np.abs(rows).max(axis=1) > 1e-9
        return mink.Constraint(rows[moved], bound[moved])


class _LegsFollow(mink.Task):
    """Legs bend with the height of the trunk; after each step they are set to where they have to be."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(cost=np.ones(len(workspace.legs)), gain=1.0)
        self.workspace = workspace

    def compute_error(self, configuration: mink.Configuration) -> Floats:
        """Zero for each joint of the legs."""
        return np.zeros(len(self.workspace.legs))

    def compute_jacobian(self, configuration: mink.Configuration) -> Floats:
        """One row for each joint of the legs."""
        return self.workspace.legs_follow(configuration.q)


class Solver:
    """Inverse kinematics of one robot in one kitchen."""

    def __init__(self, workspace: Workspace, base_dofs: int) -> None:
        self.workspace = workspace
        model = workspace.alone
        self._configuration = mink.Configuration(model)
        self._ranges = mink.ConfigurationLimit(model)
        self._clear = _KeepClear(workspace)
        cost = np.full(model.nv, HOME_COST)
        cost[:base_dofs] = BASE_COST
        cost[workspace.legs] = 0.0
        self._legs = [_LegsFollow(workspace)] if workspace.legs else None
        self._led = np.delete(np.arange(model.nv), workspace.legs)
        self._rest = mink.PostureTask(model, cost=cost)

    def solve(
        self, tip: str, grasp: Grasp, start: Floats, bounds: Bounds, iterations: int, clear: bool = True
    ) -> Floats | None:
        """A posture (nq,) with the tip at the grasp and without collisions, from `start`; None if none was found.

        `clear`: False if the robot may touch and pass through everything.
        """
        costs = (1.0, PIVOT_COST if grasp.pivots else 1.0, 1.0)
        task = mink.FrameTask(tip, "site", position_cost=4.0, orientation_cost=costs, lm_damping=1e-3)
        rotation = mink.SO3.from_matrix(grasp.rotation)
        task.set_target(mink.SE3.from_rotation_and_translation(rotation, grasp.position))
        self._rest.set_target(start)
        self._ranges.lower[:], self._ranges.upper[:] = bounds.low, bounds.high
        configuration = self._configuration
        configuration.update(self.workspace.with_legs(np.clip(start, bounds.low, bounds.high)))
        weights = np.array((1.0, 1.0, 1.0, 0.3, 0.0 if grasp.pivots else 0.3, 0.3))
        best, waited = np.inf, 0
        for _ in range(iterations):
            error = task.compute_error(configuration) * (weights > 0.0)
            there = np.linalg.norm(error[:3]) < POSITION_M and np.linalg.norm(error[3:]) < ANGLE_RAD
            if there and (not clear or self.workspace.is_free(configuration.q)):
                return np.asarray(configuration.q.copy())
            size = float(np.linalg.norm(error * weights))
            best, waited = (size, 0) if size < 0.98 * best else (best, waited + 1)
            if waited > STALLED:
                return None
            step = self._step(task, clear)
            step *= min(1.0, STEP / max(1e-9, float(np.abs(step[self._led]).max())))
            configuration.update(self.workspace.with_legs(configuration.integrate(step, 1.0)))
        return None

    def _step(self, task: mink.FrameTask, clear: bool) -> Floats:
        """Change of all joints; where the robot cannot get clear of what it overlaps, as if that were not there."""
        for limits in ([self._ranges, self._clear], [self._ranges])[0 if clear else 1 :]:
            options = {"damping": 1e-5, "limits": limits, "constraints": self._legs}
            try:
                return np.asarray(mink.solve_ik(self._configuration, [task, self._rest], 1.0, SOLVER, **options))
            except mink.NoSolutionFound:
                continue
        return np.zeros(self.workspace.alone.nv)


@dataclass(frozen=True)
class Seed:
    """A posture to begin with for an arm and its tip; the lower its score, the nearer the goal, m."""

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
        """Postures near any of some grasps of arms (by number), the nearest first; two for each grasp at most.

        The workspace is at `place` already: x, y, yaw of the base's zero. `bounds`: ranges of the joints, the base's
        first.
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
            turned = _level(-turn) @ wanted
            if grasp.pivots:
                cosine = drawn.rotations[:, :, 1] @ turned[:, 1]
            else:
                cosine = (np.einsum("nij,ij->n", drawn.rotations, turned) - 1.0) / 2.0
            angles = np.arccos(np.clip(cosine, -1.0, 1.0))
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
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
