"""A robot, and a kitchen with a robot in it, as MuJoCo models."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from lxml import etree

from casa_assets import CasaError
from casa_assets.ext.arrays import Floats
from casa_assets.ext.kitchens import Arm, Hand, Legs, Robot

ROOT = "robot"  # body that stands on the parking place, and turns and slides there
BASE_JOINTS = ("base_forward", "base_side", "base_yaw")
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TRUNK = "trunk"  # body and joint that legs lift, where they bend
GROUND_GAP_M = 0.002  # between the floor and the lowest point of the robot
PREFIX = "robot__"
NEAR_M = 0.02  # distance from which the robot is kept from coming nearer
DRIVEN_OVER_M = 0.03  # what is lower, such as a rug, does not stop a base
KITCHEN, GROUND, ITSELF = 2, 4, 8  # bits that say what a geom of the robot can touch
SAMPLES = 200  # random postures, to find which links of a robot overlap by the way they are drawn
OFTEN = 0.5  # share of them in which such links overlap
HANDLE_LABEL = "__label__handle"  # ends the names of texts that list the geoms of handles
TOUCHING_M = 0.002  # gap up to which two geoms of a handle are taken together


def tip_name(arm: Arm, press: bool) -> str:
    """Name of the site between the fingers of an arm: x is where they close, z where the hand moves to."""
    return f"{arm.name}_{'press' if press else 'grasp'}"


def assemble(robot: Robot, models: Path) -> Any:
    """One MjSpec of a robot on the floor of its world, at the origin, facing along x.

    Only the three joints of its base and those of its home, legs and fingers are kept; the others are fixed at their
    positions. Geoms that are only visual are kept until the spec is compiled with `discardvisual`. Raises CasaError: a
    file is missing or does not hold what the robot's description names.
    """
    spec = _stand(robot, models)
    for arm in robot.arms:
        body = spec.body(arm.body)
        if body is None:
            raise CasaError(f"robot {robot.id}: there is no body '{arm.body}' for its arm '{arm.name}'")
        for press in (False, True):
            hand = arm.press if press else arm.grasp
            body.add_site(name=tip_name(arm, press), pos=hand.point, quat=_frame(hand))
    _fix_joints(robot, spec)
    return spec


def finger_joints(robot: Robot) -> dict[str, float]:
    """Joints of all fingers -> where they are while the hands are open."""
    return {name: value for arm in robot.arms for name, value in arm.grasp.fingers.items()}


def leg_joints(robot: Robot) -> tuple[str, ...]:
    """Joints of legs that bend with the height of the trunk, and with nothing else."""
    return tuple(robot.legs.angles) if robot.legs else ()


def leg_angles(legs: Legs, heights: Floats) -> tuple[Floats, Floats]:
    """Angles of leg joints at heights (any shape) of the joint `TRUNK`, and their turn per metre; joints are last."""
    cosine = np.clip(math.cos(legs.lean[0]) + heights / legs.length, -1.0, math.cos(legs.lean[0]))
    lean = np.arccos(cosine)[..., None]
    zero, turn = np.array(tuple(legs.angles.values())).T
    return zero + lean * turn, -turn / (legs.length * np.sin(lean))


def home_posture(robot: Robot, model: Any) -> Floats:
    """Positions of all joints of a model of `assemble` at rest, shape (nq,)."""
    q = np.zeros(model.nq)
    for name, value in _joints_at_rest(robot).items():
        q[model.joint(name).qposadr[0]] = value
    return q


def _joints_at_rest(robot: Robot) -> dict[str, float]:
    """All joints that move, and where they are at rest; those of the base, at zero, are left out."""
    legs = {}
    if robot.legs:
        if TRUNK not in robot.home:
            raise CasaError(f"robot {robot.id}: it has legs that bend, and its home does not name '{TRUNK}'")
        angles, _ = leg_angles(robot.legs, np.array(robot.home[TRUNK]))
        legs = dict(zip(robot.legs.angles, angles.tolist(), strict=True))
    return {**robot.home, **legs, **finger_joints(robot)}


def _stand(robot: Robot, models: Path) -> Any:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    root = spec.worldbody.add_body(name=ROOT, mass=1.0, inertia=(1.0, 1.0, 1.0), explicitinertial=True)
    for name, axis in zip(BASE_JOINTS, AXES, strict=True):
        kind = mujoco.mjtJoint.mjJNT_HINGE if name == BASE_JOINTS[2] else mujoco.mjtJoint.mjJNT_SLIDE
        root.add_joint(name=name, type=kind, axis=axis, range=(-1.0, 1.0), limited=True)
    lifted = root
    if (legs := robot.legs) is not None:
        # It rises and sinks with the trunk; zero is where the legs lean least.
        lifted = root.add_body(name=TRUNK, mass=1.0, inertia=(1.0, 1.0, 1.0), explicitinertial=True)
        lowest = legs.length * (math.cos(legs.lean[1]) - math.cos(legs.lean[0]))
        kind = mujoco.mjtJoint.mjJNT_SLIDE
        lifted.add_joint(name=TRUNK, type=kind, axis=(0.0, 0.0, 1.0), range=(lowest, 0.0), limited=True)
    for part in robot.parts:
        child = _read(robot, models / part.file)
        carrier = spec.body(part.onto) if part.onto else lifted
        if carrier is None:
            raise CasaError(f"robot {robot.id}: part '{part.name}' goes onto '{part.onto}', which no earlier part has")
        at = (0.0, 0.0, 0.0) if part.onto else (-robot.centre[0], -robot.centre[1], 0.0)
        spec.attach(child, prefix=f"{part.name}_", frame=carrier.add_frame(pos=at))
    return spec


def _read(robot: Robot, path: Path) -> Any:
    """A part at the origin, without actuators, sensors, cameras and the like, and without free joints and floors."""
    if not path.is_file():
        raise CasaError(f"{path}: robot {robot.id} needs this file, and it is not there; name the folder of the robots")
    try:
        spec = mujoco.MjSpec.from_string(_without_doubles(path))
    except (ValueError, etree.XMLSyntaxError) as error:
        raise CasaError(f"{path}: MuJoCo does not read this part of robot {robot.id}: {error}") from error
    spec.compiler.degree = False
    for group in ("actuators", "sensors", "tendons", "equalities", "keys", "cameras", "lights", "sites"):
        for element in list(getattr(spec, group)):
            spec.delete(element)
    for joint in list(spec.joints):
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            spec.delete(joint)
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            spec.delete(geom)
    # Options as MuJoCo has them by default: only the kitchen's count.
    usual = mujoco.MjSpec().option
    for name in ("integrator", "cone", "impratio", "gravity", "timestep", "solver", "iterations", "enableflags"):
        setattr(spec.option, name, getattr(usual, name))
    for mesh in spec.meshes:
        mesh.file = str((path.parent / spec.meshdir / mesh.file).resolve())
    for body in spec.worldbody.bodies:
        body.pos = (0.0, 0.0, 0.0)
    return spec


def _without_doubles(path: Path) -> str:
    """Text of an MJCF file with each mesh named once: where robosuite's files name one twice, the first counts."""
    tree = etree.parse(str(path), etree.XMLParser(remove_comments=True, resolve_entities=False, no_network=True))
    seen: set[str] = set()
    for mesh in tree.findall(".//asset/mesh"):
        if mesh.get("name", mesh.get("file")) in seen:
            parent = mesh.getparent()
            assert parent is not None
            parent.remove(mesh)
        seen.add(mesh.get("name", mesh.get("file", "")))
    return etree.tostring(tree, encoding="unicode")


def _fix_joints(robot: Robot, spec: Any) -> None:
    """Delete every joint that does not move, its body turned to where it stays, and set the robot on the floor."""
    spec.compiler.discardvisual = True
    model = spec.compile()
    spec.compiler.discardvisual = False
    data = mujoco.MjData(model)
    names = {model.joint(i).name for i in range(model.njnt)}
    moving = _joints_at_rest(robot)
    for name in [*moving, *robot.fixed]:
        if name not in names:
            raise CasaError(f"robot {robot.id}: it has no joint '{name}'; it has {', '.join(sorted(names))}")
    data.qpos[:] = 0.0
    for name, value in {**moving, **robot.fixed}.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_kinematics(model, data)
    for joint in list(spec.joints):
        if joint.name in moving or joint.name in BASE_JOINTS:
            continue
        body = joint.parent
        at, above = model.body(body.name).id, model.body(model.body(body.name).parentid[0]).id
        turned, back = np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(back, data.xquat[above])
        mujoco.mju_mulQuat(turned, back, data.xquat[at])
        body.quat = turned
        body.pos = data.xmat[above].reshape(3, 3).T @ (data.xpos[at] - data.xpos[above])
        body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        spec.delete(joint)
    spec.body(ROOT).pos = (0.0, 0.0, GROUND_GAP_M - _lowest(model, data))


def _lowest(model: Any, data: Any) -> float:
    """Height of the lowest corner of the boxes around the geoms that touch something."""
    low = np.inf
    for i in range(model.ngeom):
        if model.geom_contype[i] or model.geom_conaffinity[i]:
            turn = data.geom_xmat[i].reshape(3, 3)
            centre = data.geom_xpos[i] + turn @ model.geom_aabb[i, :3]
            low = min(low, float(centre[2] - np.abs(turn[2]) @ model.geom_aabb[i, 3:]))
    return low


def _frame(hand: Hand) -> Floats:
    """Quaternion of the frame whose x is where fingers close and whose z is where the hand moves to."""
    z = np.array(hand.approach) / np.linalg.norm(hand.approach)
    x = np.array(hand.closing) - (np.array(hand.closing) @ z) * z
    x /= np.linalg.norm(x)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.stack([x, np.cross(z, x), z], axis=1).ravel())
    return quat


@dataclass(frozen=True)
class Nearness:
    """Two geoms near each other: distance (m, < 0 where they overlap), point between, normal from first to second.

    `bodies`: of the robot alone; None for what is the kitchen's.
    """

    distance: float
    point: Floats
    normal: Floats
    bodies: tuple[int | None, int | None]


class Workspace:
    """A kitchen with a robot in it; `alone` is the robot without the kitchen, with the joints of `assemble`.

    `home`: its posture at rest, (nq,) of `alone`. `hinges`: numbers of its hinges, but for fingers and legs. `legs`: of
    the joints of legs, which follow the height of its trunk.
    """

    def __init__(self, kitchen: Path, robot: Robot, models: Path) -> None:
        """Load scene.xml, and the robot from a folder of models. CasaError: a file is missing or cannot be read."""
        try:
            spec = mujoco.MjSpec.from_file(str(kitchen))
        except ValueError as error:
            raise CasaError(f"{kitchen}: MuJoCo does not read it: {error}") from error
        spec.compiler.discardvisual = True
        labelled = [text.data.split() for text in spec.texts if text.name.endswith(HANDLE_LABEL)]
        self.handles = frozenset(name for names in labelled for name in names)
        alone = assemble(robot, models)
        alone.compiler.discardvisual = True
        self.alone: Any = alone.compile()
        spec.attach(assemble(robot, models), prefix=PREFIX, frame=spec.worldbody.add_frame())
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        self.home = home_posture(robot, self.alone)
        self.legs = [self.alone.joint(name).id for name in leg_joints(robot)]
        self._legs = robot.legs
        others = {*finger_joints(robot), *BASE_JOINTS, *leg_joints(robot)}
        turning = [i for i in range(self.alone.njnt) if self.alone.jnt_type[i] == mujoco.mjtJoint.mjJNT_HINGE]
        self.hinges = [i for i in turning if self.alone.joint(i).name not in others]
        self._root = self.model.body(PREFIX + ROOT).id
        self._height = float(self.model.body_pos[self._root][2])
        names = [self.alone.joint(i).name for i in range(self.alone.njnt)]
        self._address = np.array([int(self.model.joint(PREFIX + n).qposadr[0]) for n in names])
        # Some bodies of hands have no name; all are in the same order in both models.
        # The same holds of geoms: `_first` is the first of the robot.
        self._body = {self._root + i - self.alone.body(ROOT).id: i for i in range(1, self.alone.nbody)}
        self._first = next(i for i in range(self.model.ngeom) if int(self.model.geom_bodyid[i]) in self._body)
        self._held: frozenset[tuple[int, int]] = frozenset()
        self._fingers = {arm.name: self._geoms_of(robot, arm.touching) for arm in robot.arms}
        self._set_bits()
        self._alone_data: Any = mujoco.MjData(self.alone)
        self._drawn_over = self._overlaps_as_drawn()
        mujoco.mj_resetData(self.model, self.data)

    def number(self, joint: str) -> int:
        """Number of a joint of the robot in its postures."""
        return int(self.alone.joint(joint).qposadr[0])

    def with_legs(self, q: Floats) -> Floats:
        """Postures of shape (..., nq) with their legs bent as the height of the trunk asks."""
        if self._legs is None:
            return q
        bent = q.copy()
        bent[..., self.legs], _ = leg_angles(self._legs, q[..., self.number(TRUNK)])
        return bent

    def legs_follow(self, q: Floats) -> Floats:
        """Rows of A dq = 0, shape (n, nq), that hold while legs bend with the trunk; none without such legs."""
        rows = np.zeros((len(self.legs), len(q)))
        if self._legs is not None:
            rows[np.arange(len(rows)), self.legs] = 1.0
            trunk = self.number(TRUNK)
            rows[:, trunk] = -leg_angles(self._legs, q[trunk])[1]
        return rows

    def place(self, x: float, y: float, yaw: float) -> None:
        """Put the zero of the base's joints somewhere, m and radians."""
        for model, root in ((self.model, self._root), (self.alone, self.alone.body(ROOT).id)):
            model.body_pos[root] = (x, y, self._height)
            model.body_quat[root] = (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2))

    def open(self, joints: Mapping[str, float]) -> None:
        """Set joints of the kitchen, and all others to where they rest."""
        self.data.qpos[:] = self.model.qpos0
        for name, value in joints.items():
            self.data.qpos[self.model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(self.model, self.data)

    def hold(self, arm: str, geoms: Iterable[str]) -> None:
        """Let the fingers of an arm touch geoms of the kitchen."""
        held = [self.model.geom(name).id for name in geoms]
        self._held = frozenset((f, g) for f in self._fingers[arm] for g in held)

    def near(self, q: Floats) -> list[Nearness]:
        """All pairs of geoms that are nearer than `NEAR_M`, the robot in a posture of shape (nq,) of `alone`."""
        self.data.qpos[self._address] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)
        found = []
        contact = self.data.contact
        for k in range(self.data.ncon):
            first, second = (int(g) for g in contact.geom[k])
            pair = (first, second)
            if pair in self._held or pair[::-1] in self._held or pair in self._drawn_over:
                continue
            one, other = (self._body.get(int(self.model.geom_bodyid[g])) for g in pair)
            near = Nearness(float(contact.dist[k]), contact.pos[k].copy(), contact.frame[k, :3].copy(), (one, other))
            found.append(near)
        return found

    def is_free(self, q: Floats) -> bool:
        """True if the robot touches nothing but what its fingers hold."""
        return all(near.distance > 0.0 for near in self.near(q))

    def is_clear_of_itself(self, q: Floats) -> bool:
        """True if no part of the robot touches another; the kitchen is left out."""
        pairs = ((a + self._first, b + self._first) for a, b, depth in self._on_itself(q) if depth < 0.0)
        return all(pair in self._drawn_over for pair in pairs)

    def overlap(self, q: Floats) -> float:
        """How deep the robot is in anything, summed over what it touches, m."""
        return sum(max(0.0, -near.distance) for near in self.near(q))

    def _on_itself(self, q: Floats) -> list[tuple[int, int, float]]:
        """Pairs of geoms of `alone` that are near each other, and their distance, m."""
        self._alone_data.qpos[:] = q
        mujoco.mj_kinematics(self.alone, self._alone_data)
        mujoco.mj_collision(self.alone, self._alone_data)
        contact = self._alone_data.contact
        return [(int(a), int(b), float(d)) for (a, b), d in zip(contact.geom, contact.dist, strict=True)]

    def _geoms_of(self, robot: Robot, names: tuple[str, ...]) -> tuple[int, ...]:
        found = []
        for i in range(self.model.ngeom):
            body = self.model.body(self.model.geom_bodyid[i]).name
            mesh = self.model.geom_dataid[i]
            shown = self.model.mesh(mesh).name if mesh >= 0 else ""
            if {body.removeprefix(PREFIX), shown.removeprefix(PREFIX)} & set(names):
                found.append(i)
        if not found:
            raise CasaError(f"robot {robot.id}: it has no finger called {', '.join(names)}")
        return tuple(found)

    def _set_bits(self) -> None:
        """Let the robot touch the kitchen and itself, its base not the ground, and the kitchen not itself."""
        model = self.model
        mujoco.mj_kinematics(model, self.data)
        standing = self._standing()
        for i in range(model.ngeom):
            touches, body = model.geom_contype[i] or model.geom_conaffinity[i], model.geom_bodyid[i]
            if not touches:
                continue
            if int(body) in self._body:
                ground = 0 if int(body) in standing else GROUND
                model.geom_contype[i], model.geom_conaffinity[i] = KITCHEN | ground | ITSELF, ITSELF
                model.geom_margin[i] = NEAR_M
            else:
                turn = self.data.geom_xmat[i].reshape(3, 3)
                high = self.data.geom_xpos[i] + turn @ model.geom_aabb[i, :3]
                top = high[2] + np.abs(turn[2]) @ model.geom_aabb[i, 3:]
                low = model.geom_type[i] == mujoco.mjtGeom.mjGEOM_PLANE or top < DRIVEN_OVER_M
                model.geom_contype[i], model.geom_conaffinity[i] = 0, GROUND if low else KITCHEN
                model.geom_margin[i] = 0.0
        robots = slice(self._first, self._first + self.alone.ngeom)
        self.alone.geom_contype[:] = model.geom_contype[robots]
        self.alone.geom_conaffinity[:] = model.geom_conaffinity[robots]
        self.alone.geom_margin[:] = model.geom_margin[robots]

    def _standing(self) -> set[int]:
        """Bodies that are on the ground: the base, and those attached to the first joints of legs."""
        model = self.model
        standing = {b for b in self._body if int(model.body_weldid[b]) == self._root}
        standing |= {int(model.joint(PREFIX + self.alone.joint(i).name).bodyid[0]) for i in self.legs}
        for body in sorted(self._body):  # a body comes after the one that carries it
            if int(model.body_parentid[body]) in standing and not model.body_jntnum[body]:
                standing.add(body)
        return standing

    def _overlaps_as_drawn(self) -> frozenset[tuple[int, int]]:
        """Pairs of the robot's own geoms that overlap at rest or mostly: hulls of links reach into their neighbours."""
        rng = np.random.default_rng(0)
        low, high = self.alone.jnt_range[:, 0], self.alone.jnt_range[:, 1]
        counts: dict[tuple[int, int], int] = {}
        for k in range(SAMPLES):
            q = self.home if k == 0 else self.with_legs(rng.uniform(low, high))
            depth = NEAR_M / 2 if k == 0 else 0.0
            for pair in {(a + self._first, b + self._first) for a, b, d in self._on_itself(q) if d < depth}:
                counts[pair] = counts.get(pair, 0) + (SAMPLES if k == 0 else 1)
        return frozenset(pair for pair, n in counts.items() if n > OFTEN * SAMPLES)


def handle_of(model: Any, handles: frozenset[str], grip: str) -> list[str]:
    """A geom that is gripped, and those of `handles` that touch it: the posts of a bar, the dome of a cup."""
    first = model.geom(grip)
    found = [grip]
    if grip not in handles:
        return found
    low, high = _corners(model, first.id)
    for i in range(model.ngeom):
        name = model.geom(i).name
        if name == grip or name not in handles or model.geom_bodyid[i] != first.bodyid[0]:
            continue
        other_low, other_high = _corners(model, i)
        if (other_low < high + TOUCHING_M).all() and (other_high > low - TOUCHING_M).all():
            found.append(name)
    return found


def _corners(model: Any, geom: int) -> tuple[Floats, Floats]:
    """Least and largest corner of a geom in the frame of its body, shape (3,) each."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, model.geom_quat[geom])
    box, turn = model.geom_aabb[geom], matrix.reshape(3, 3)
    centre, half = model.geom_pos[geom] + turn @ box[:3], np.abs(turn) @ box[3:]
    return centre - half, centre + half
