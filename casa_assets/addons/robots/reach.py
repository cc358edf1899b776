"""Find the joints of a kitchen that a robot reaches and opens."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Any

import mujoco
import numpy as np

from casa_assets.addons.robots.grips import Grasp, Grip, pinches, presses
from casa_assets.addons.robots.inverse_kinematics import Bounds, Seed, Seeds, Solver
from casa_assets.addons.robots.workspace import BASE_JOINTS, Workspace, handle_of
from casa_assets.ext.arrays import Floats
from casa_assets.ext.kitchens import Arm, Following, JointReach, Miss, Robot
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.scene_checks import Task

# How far a base may stand from a parking place: back and ahead, to the right and left (m), turned (rad). RoboCasa draws
# it within 0.15 m; it has to stand farther back for handles that are lower than the top of the base itself.
BESIDE = ((-0.40, 0.10), (-0.15, 0.15), (-0.35, 0.35))
DRIVEN = ((-1.2, 1.2), (-1.2, 1.2), (-math.pi, math.pi))  # how far it may go along with a door
KEY_TRAVEL_M, KEY_TURN_RAD = 0.012, 0.3  # what moves less is a key
SHEET_M = 0.008  # thickness below which a grip is a part of something hollow, a cup or a ring, that is also held whole
BACK_M = (0.02, 0.04, 0.06)  # from the handle, back along the way that the hand came: there must be room
BEFORE_M, ADVANCE_M = (0.0, 0.2), 0.05  # from a handle, where a hand is brought first, and the steps from there to it
STEP_M, STEP_RAD = 0.025, 0.07  # between two places of what is being opened
KEPT_MARGIN = 0.01  # share of half its range that a hinge keeps from each end
FINGER_GAP_M = 0.006  # between a finger and what it comes to
DISTANT, NEXT = 60, 15  # iterations to a handle, and to the next place of one that is held
TRIES = 60  # ways of reaching one joint from one place
WHY_TRIES = 8  # ways of reaching, in which a joint that is not reached is tried as if nothing were in the way
FOLLOWED_TRIES = 5  # ways of holding, with which opening is tried
Room = tuple[Vec2, Vec2, Vec2]  # least and largest of ahead, to the left (m) and turned (rad)


@dataclass(frozen=True)
class _Held:
    arm: Arm
    tip: str
    place: Vec3
    grasp: Grasp
    posture: Floats
    bounds: Bounds


class Bench:
    """A robot in a kitchen, for one task after the other."""

    def __init__(self, robot: Robot, workspace: Workspace) -> None:
        self.robot = robot
        self._workspace = workspace
        self._seeds = Seeds(workspace, robot)
        self._solver = Solver(workspace, len(BASE_JOINTS))

    def work(self, task: Task) -> JointReach:
        """Try a task from its parking places with each arm."""
        best = JointReach(fixture=task.fixture, joint=task.joint, reached=False)
        for held in islice(self._reached(task), FOLLOWED_TRIES):
            for following in (Following.STANDING, Following.DRIVING):
                if following is Following.DRIVING and not self.robot.drives:
                    continue
                found = self._opened(task, held, following)
                best = max(
                    best, found, key=lambda r: (r.reached, r.followed is not Following.NO, r.share, r.margin or 0.0)
                )
                if found.followed is not Following.NO:
                    return found
        return best if best.reached else best.model_copy(update={"missed": self._why(task)})

    def _why(self, task: Task) -> Miss:
        why = Miss.THICK
        for place in task.places:
            self._begin(task, place, self.robot.arms[0])
            room = _bounds(self._workspace, BESIDE)
            for seed in self._seeds_for(task, place, room, 0.0)[:WHY_TRIES]:
                why = Miss.FAR
                bounds = self._fingers_at(room, seed.arm, seed.grasp)
                if self._solver.solve(seed.tip, seed.grasp, seed.posture, bounds, DISTANT, clear=False) is not None:
                    return Miss.BLOCKED
        return why

    def _reached(self, task: Task) -> Iterator[_Held]:
        """Postures in which a hand is at the handle and can get away from it again.

        Where none is found right there, the hand is first brought before the handle, where there is more room.
        """
        for before in BEFORE_M:
            some = False
            for place in task.places:
                for held in self._reached_from(task, place, before):
                    some = True
                    yield held
            if some:
                return

    def _reached_from(self, task: Task, place: Vec3, before: float) -> Iterator[_Held]:
        """As `_reached`, from one parking place; the hand first comes to a place so far before the handle, m."""
        workspace = self._workspace
        self._begin(task, place, self.robot.arms[0])
        room = _bounds(workspace, BESIDE)
        for seed in self._seeds_for(task, place, room, before)[:TRIES]:
            arm = self.robot.arms[seed.arm]
            self._begin(task, place, arm)
            bounds = self._fingers_at(room, seed.arm, seed.grasp)
            q = self._solver.solve(seed.tip, seed.grasp, seed.posture, bounds, DISTANT)
            for back in np.arange(before - ADVANCE_M, -1e-9, -ADVANCE_M):
                if q is not None:
                    q = self._solver.solve(seed.tip, _back(seed.grasp, back - before), q, bounds, NEXT)
            if q is None:
                continue
            grasp = _as_held(workspace, seed.tip, _back(seed.grasp, -before), q)
            if self._gets_away(seed.tip, grasp, q, bounds):
                yield _Held(arm, seed.tip, place, grasp, q, bounds)

    def _begin(self, task: Task, place: Vec3, arm: Arm) -> None:
        self._workspace.place(*place)
        self._workspace.open(_opened_to(self._workspace, task.behind))
        workspace = self._workspace
        workspace.hold(arm.name, handle_of(workspace.model, workspace.handles, task.grip))

    def _seeds_for(self, task: Task, place: Vec3, bounds: Bounds, before: float) -> list[Seed]:
        """Grasps with arms, so far before the handle (m), each with a posture to begin with, the best first."""
        workspace = self._workspace
        grip, motion = _grip(workspace, task), _motion(workspace, task)
        joint, turning = workspace.model.joint(task.joint), _knob_axis(workspace, task, grip)
        # What moves so little is pressed, not held.
        most = KEY_TURN_RAD if joint.type[0] == mujoco.mjtJoint.mjJNT_HINGE else KEY_TRAVEL_M
        press = float(np.ptp(joint.range)) <= most
        found = []
        for number, arm in enumerate(self.robot.arms):
            grasps = presses(grip, motion) if press else pinches(grip, arm.opening, turning)
            if not press and 2 * float(grip.half.min()) < SHEET_M:
                grasps += pinches(_whole(workspace, task, grip), arm.opening, turning)
            found += [(order, number, grasp) for order, grasp in enumerate(grasps)]
        found.sort(key=lambda one: one[:2])
        ordered = [(number, _back(grasp, before)) for _, number, grasp in found]
        return self._seeds.toward(ordered, press, place, bounds)

    def _fingers_at(self, bounds: Bounds, number: int, grasp: Grasp) -> Bounds:
        """Bounds with all fingers where they stay: those of one arm as it needs them, the others open."""
        low, high = bounds.low.copy(), bounds.high.copy()
        for other, arm in enumerate(self.robot.arms):
            fingers = dict(arm.grasp.fingers)
            if other == number and grasp.width == 0.0:
                fingers = arm.press.fingers
            elif other == number:
                share = min(1.0, (grasp.width + 2 * FINGER_GAP_M) / arm.opening) if arm.closed else 1.0
                closed = {**fingers, **arm.closed}
                fingers = {name: closed[name] + share * (opened - closed[name]) for name, opened in fingers.items()}
            for name, value in fingers.items():
                low[self._workspace.number(name)] = high[self._workspace.number(name)] = value
        return Bounds(low, high)

    def _gets_away(self, tip: str, grasp: Grasp, q: Floats, bounds: Bounds) -> bool:
        """True if there is room for the hand on the last bit of its way."""
        bounds, at = _standing(bounds, q), q
        for back in BACK_M:
            found = self._solver.solve(tip, _back(grasp, back), at, bounds, NEXT)
            if found is None:
                return False
            at = found
        return True

    def _opened(self, task: Task, held: _Held, following: Following) -> JointReach:
        workspace = self._workspace
        self._begin(task, held.place, held.arm)
        link = int(workspace.model.geom(task.grip).bodyid[0])
        before = _pose(workspace.data, link)
        standing = following is Following.STANDING
        bounds = _standing(held.bounds, held.posture) if standing else _with_room(held.bounds, DRIVEN)
        behind, end = _opened_to(workspace, task.behind), _end(workspace.model, task.joint)
        size = STEP_RAD if workspace.model.joint(task.joint).type[0] == mujoco.mjtJoint.mjJNT_HINGE else STEP_M
        values = np.linspace(0.0, end, max(2, math.ceil(abs(end) / size)) + 1)[1:]
        q, margin, done = held.posture, _margin(workspace, held.posture), 0
        for value in values:
            workspace.open({**behind, task.joint: float(value)})
            position, axes = _pose(workspace.data, link)
            turn, grasp = axes @ before[1].T, held.grasp
            moved = position + turn @ (grasp.position - before[0])
            grasp = replace(grasp, position=moved, rotation=turn @ grasp.rotation)
            found = self._solver.solve(held.tip, grasp, q, bounds, NEXT)
            if found is None:
                break
            q, margin, done = found, min(margin, _margin(workspace, found)), done + 1
        x, y, yaw = held.place
        forward, side, turned = (float(v) for v in held.posture[: len(BASE_JOINTS)])
        x = x + forward * math.cos(yaw) - side * math.sin(yaw)
        y = y + forward * math.sin(yaw) + side * math.cos(yaw)
        base = (round(x, 3), round(y, 3), round(yaw + turned, 3))
        return JointReach(
            fixture=task.fixture,
            joint=task.joint,
            reached=True,
            followed=following if done == len(values) else Following.NO,
            share=round(done / len(values), 3),
            margin=round(margin, 3),
            arm=held.arm.name,
            base=base,
        )


def _end(model: Any, joint: str) -> float:
    """End of a joint's range that is farther from where it rests."""
    low, high = model.joint(joint).range
    return float(high if abs(high) >= abs(low) else low)


def _opened_to(workspace: Workspace, joint: str) -> dict[str, float]:
    """Position of a joint whose door is all the way open, by its name; empty if no joint is named."""
    return {joint: _end(workspace.model, joint)} if joint else {}


def _grip(workspace: Workspace, task: Task) -> Grip:
    model, data = workspace.model, workspace.data
    geom = model.geom(task.grip).id
    turn = data.geom_xmat[geom].reshape(3, 3)
    box = model.geom_aabb[geom]
    return Grip(data.geom_xpos[geom] + turn @ box[:3], turn.copy(), box[3:].copy(), np.array(task.front))


def _whole(workspace: Workspace, task: Task, grip: Grip) -> Grip:
    """The box around all of a handle, along the axes of the geom that is named as its grip."""
    model, data = workspace.model, workspace.data
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    corners = []
    for name in handle_of(model, workspace.handles, task.grip):
        geom = model.geom(name).id
        box, turn = model.geom_aabb[geom], data.geom_xmat[geom].reshape(3, 3)
        corners.append((data.geom_xpos[geom] + (box[:3] + signs * box[3:]) @ turn.T) @ grip.axes)
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    return replace(grip, centre=grip.axes @ ((low + high) / 2), half=(high - low) / 2)


def _motion(workspace: Workspace, task: Task) -> Floats:
    """Unit vector along which the thing that is held begins to move; into the front where it turns in place."""
    model, data = workspace.model, workspace.data
    joint, geom = model.joint(task.joint).id, model.geom(task.grip).id
    sign = math.copysign(1.0, _end(model, task.joint))
    motion = sign * data.xaxis[joint]
    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE:
        motion = np.cross(motion, data.geom_xpos[geom] - data.xanchor[joint])
    size = float(np.linalg.norm(motion))
    return motion / size if size > 1e-3 else -np.array(task.front)


def _knob_axis(workspace: Workspace, task: Task, grip: Grip) -> Floats | None:
    """Axis of a knob, which turns about its own middle; None for what does not."""
    model, data = workspace.model, workspace.data
    joint = model.joint(task.joint).id
    if model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE:
        return None
    axis = data.xaxis[joint]
    arm = np.cross(axis, grip.centre - data.xanchor[joint])
    return axis.copy() if float(np.linalg.norm(arm)) < 0.01 else None


def _bounds(workspace: Workspace, room: Room) -> Bounds:
    """Ranges of all joints, the base's within some room around where it was put."""
    low, high = workspace.alone.jnt_range[:, 0].copy(), workspace.alone.jnt_range[:, 1].copy()
    hinges = workspace.hinges
    kept = KEPT_MARGIN * (high - low)[hinges] / 2
    low[hinges] += kept
    high[hinges] -= kept
    return _with_room(Bounds(low, high), room)


def _with_room(bounds: Bounds, room: Room) -> Bounds:
    low, high = bounds.low.copy(), bounds.high.copy()
    low[: len(room)], high[: len(room)] = np.array(room).T
    return Bounds(low, high)


def _standing(bounds: Bounds, q: Floats) -> Bounds:
    """Bounds that leave the base where it is."""
    return _with_room(bounds, ((q[0], q[0]), (q[1], q[1]), (q[2], q[2])))


def _margin(workspace: Workspace, q: Floats) -> float:
    """Smallest distance of a hinge, the base's left out, to an end of its range, as a share of half the range."""
    low, high = workspace.alone.jnt_range[workspace.hinges].T
    there = q[workspace.hinges]
    return max(0.0, float(np.min(np.minimum(there - low, high - there) / ((high - low) / 2))))


def _as_held(workspace: Workspace, tip: str, grasp: Grasp, q: Floats) -> Grasp:
    """The grasp as the hand has it, which may have turned about the bar."""
    if not grasp.pivots:
        return grasp
    data = mujoco.MjData(workspace.alone)
    data.qpos[:] = q
    mujoco.mj_kinematics(workspace.alone, data)
    return replace(grasp, rotation=data.site_xmat[workspace.alone.site(tip).id].reshape(3, 3).copy())


def _back(grasp: Grasp, distance: float) -> Grasp:
    """A grasp moved back by a distance in metres, against the direction in which the hand comes."""
    return replace(grasp, position=grasp.position - distance * grasp.rotation[:, 2])


def _pose(data: Any, body: int) -> tuple[Floats, Floats]:
    return data.xpos[body].copy(), data.xmat[body].reshape(3, 3).copy()
