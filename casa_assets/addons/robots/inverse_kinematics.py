"""Grips at handles, and postures of a robot that hold them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mink
import mujoco
import numpy as np

from casa_assets.addons.robots.workspace import BASE_JOINTS, Workspace, tip_name
from casa_assets.core.numeric import Floats, about_axis
from casa_assets.model.kitchen.robot import Robot
from casa_assets.model.record import Vec3

# Grips ----------------------------------------------------------------------------------------------------------------

BAR_RATIO = 1.5  # a thing this many times as long as wide is held across its length
BAR_ANGLES_DEG = (0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0)  # at which a hand comes, about the bar
KNOB_ANGLES_DEG = (0.0, 90.0, 180.0, -90.0, 45.0, -45.0, 135.0, -135.0)  # of the fingers about a knob or key
TILTS_DEG = (0.0, 25.0, -25.0)  # at which a hand comes to a knob or key, out of its axis
EDGE_TILTS_DEG = (0.0, 25.0, -25.0, 45.0, -45.0)  # at which a hand comes to the edge of a plate
SHIFTED_FROM_M = 0.06  # half length from which a bar is also held off its middle
EDGE_DEPTH_M = 0.015  # to which fingers take a plate at its edge
# How far the point between the fingers goes into what is held, at most to its middle: tips reach 1 cm beyond it, and
# what is behind a handle may be near.
TAKEN_M = 0.004
UP = np.array((0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Grip:
    """A held part as a box in the world: half lengths (m) along columns of `axes`; `front`: out of the fixture."""

    centre: Floats
    axes: Floats
    half: Floats
    front: Floats


@dataclass(frozen=True)
class Grasp:
    """Where the point between the fingers, or the tip that presses, is put, and (3, 3) how the hand is turned.

    Columns: the direction in which fingers close, the one across, the one in which the hand comes. `width`: of the
    thing between the fingers, m; 0 for what is pressed. `pivots`: the hand may turn about the direction across, along a
    bar.
    """

    position: Floats
    rotation: Floats
    width: float = 0.0
    pivots: bool = False


def pinches(grip: Grip, opening: float, turning: Floats | None) -> list[Grasp]:
    """Ways of holding a part between fingers `opening` m apart, the most natural first; none if it is too thick.

    `turning`: (3,) axis about which a knob turns, None if the part is not a knob.
    """
    small, middle, long = np.argsort(grip.half, kind="stable")
    if turning is None and grip.half[long] > BAR_RATIO * grip.half[middle] and 2 * grip.half[middle] < opening:
        return list(_across(grip, grip.axes[:, long], float(grip.half[long])))
    if turning is None and 2 * grip.half[middle] >= opening > 2 * grip.half[small]:
        return list(_at_edge(grip, grip.axes[:, small]))
    return list(_around(grip, opening, turning))


def presses(grip: Grip, motion: Floats) -> list[Grasp]:
    """Ways of pressing a key with a fingertip; `motion`: (3,) unit vector along which the key goes in."""
    at = grip.centre - motion * _reach(grip, motion)
    side = _perpendicular(motion, UP)
    found = []
    for tilt in (0.0, *TILTS_DEG[1:], 50.0, -50.0):
        for axis in (side, np.cross(motion, side))[: 1 if tilt == 0.0 else 2]:
            come = _turned(motion, axis, tilt)
            across = _perpendicular(come, UP)
            for angle in KNOB_ANGLES_DEG:
                found.append(Grasp(at, _frame(come, _turned(across, come, angle))))
    return found


def _across(grip: Grip, bar: Floats, half: float) -> Iterator[Grasp]:
    """Fingers on both sides of a bar."""
    base = -grip.front - (-grip.front @ bar) * bar
    if np.linalg.norm(base) < 0.5:
        base = -UP - (-UP @ bar) * bar
    base /= np.linalg.norm(base)
    shifts = (0.0, half / 2, -half / 2) if half > SHIFTED_FROM_M else (0.0,)
    for shift in shifts:
        for angle in BAR_ANGLES_DEG:
            come = _turned(base, bar, angle)
            for sign in (1.0, -1.0):
                close = sign * np.cross(bar, come)
                at = _taken(grip, come) + shift * bar
                yield Grasp(at, _frame(come, close), 2 * _reach(grip, close), pivots=True)


def _at_edge(grip: Grip, thin: Floats) -> Iterator[Grasp]:
    """Fingers above and below the front edge of a plate."""
    come = -grip.front - (-grip.front @ thin) * thin
    if np.linalg.norm(come) < 0.5:
        return
    come /= np.linalg.norm(come)
    edge = grip.centre - come * (_reach(grip, come) - EDGE_DEPTH_M)
    along, thick = np.cross(thin, come), _reach(grip, thin)
    half = _reach(grip, along)
    for shift in (0.0, half / 2, -half / 2, 0.85 * half, -0.85 * half):
        for tilt in EDGE_TILTS_DEG:
            turned = _turned(come, along, tilt)
            for sign in (1.0, -1.0):
                yield Grasp(edge + shift * along, _frame(turned, sign * np.cross(along, turned)), 2 * thick)


def _around(grip: Grip, opening: float, turning: Floats | None) -> Iterator[Grasp]:
    """Fingers around a knob, or around what is short."""
    # What turns about an upright axis, as on a hob, is taken from above.
    axis = -grip.front if turning is None else turning * (-1.0 if turning @ (grip.front + UP) > 0.0 else 1.0)
    side = _perpendicular(axis, UP)
    for tilt in TILTS_DEG:
        for about in (side, np.cross(axis, side))[: 1 if tilt == 0.0 else 2]:
            come = _turned(axis, about, tilt)
            first = _perpendicular(come, UP)
            for angle in KNOB_ANGLES_DEG:
                close = _turned(first, come, angle)
                width = 2 * float(np.sort(grip.half)[1])
                if width < opening:
                    yield Grasp(_taken(grip, come), _frame(come, close), width)


def _taken(grip: Grip, come: Floats) -> Floats:
    """Where the point between the fingers of a hand is that comes to a grip, shape (3,)."""
    at: Floats = grip.centre - come * max(0.0, _reach(grip, come) - TAKEN_M)
    return at


def _reach(grip: Grip, direction: Floats) -> float:
    """Distance from the centre to the surface of the box along the axis nearest to a direction."""
    return float(grip.half[int(np.argmax(np.abs(direction @ grip.axes)))])


def _turned(vector: Floats, axis: Floats, angle_deg: float) -> Floats:
    turned: Floats = about_axis(axis, math.radians(angle_deg)) @ vector
    return turned


def _perpendicular(direction: Floats, wish: Floats) -> Floats:
    """Unit vector at right angles to a direction, level where that is possible."""
    found = np.cross(wish, direction)
    if np.linalg.norm(found) < 1e-6:
        found = np.cross((1.0, 0.0, 0.0), direction)
    unit: Floats = found / np.linalg.norm(found)
    return unit


def _frame(come: Floats, close: Floats) -> Floats:
    """Rotation whose x closes and whose z comes."""
    x = close - (close @ come) * come
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(come, x), come], axis=1)


# Inverse kinematics ---------------------------------------------------------------------------------------------------
# Bring a hand to a place, joints within their ranges, the robot clear of all else.

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


# Seeds ----------------------------------------------------------------------------------------------------------------
# Postures to begin inverse kinematics with: drawn once for a robot, chosen by how near a hand then is to a grasp.

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
    """Rotation about the upright axis."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
