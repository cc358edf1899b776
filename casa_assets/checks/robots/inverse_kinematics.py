"""Inverse kinematics with mink: bring a hand to a place, joints within their ranges, the robot clear of all else."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mink
import mujoco
import numpy as np

from casa_assets.checks.robots.grips import Grasp
from casa_assets.checks.robots.workspace import Workspace
from casa_assets.core.typing import Floats

SOLVER = "daqp"
POSITION_M, ANGLE_RAD = 0.005, math.radians(3.0)  # to which a hand has to get; a finger comes with 6 mm to spare
STEP = 0.25  # largest change of a joint in one iteration, rad or m
KEPT_M = 0.001  # distance that is kept from all else
GAIN = 0.7  # share of the room to what is near that one iteration may use up
HOME_COST, BASE_COST = 1e-2, 1e-1  # of leaving the posture at rest, and the parking place, beside 1 of missing the goal
PIVOT_COST = 1e-2  # of turning about a bar that is held
STALLED = 12  # iterations without a nearer approach, after which no more are made


@dataclass(frozen=True)
class Bounds:
    """Ends of the joints' ranges, shape (nq,) each."""

    low: Floats
    high: Floats


class _KeepClear(mink.Limit):
    """Limit that keeps the robot at least `KEPT_M` away from everything near it."""

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
        """A posture of shape (nq,) with the hand at the grasp and without collisions; None if none was found.

        Args:
            tip: site between the fingers. start: posture to begin with. clear: False if the robot may touch and pass
                through everything.
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
                found: Floats = configuration.q.copy()
                return found
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
            try:
                step: Floats = mink.solve_ik(
                    self._configuration,
                    [task, self._rest],
                    1.0,
                    SOLVER,
                    damping=1e-5,
                    limits=limits,
                    constraints=self._legs,
                )
            except mink.NoSolutionFound:
                continue
            return step
        return np.zeros(self.workspace.alone.nv)
