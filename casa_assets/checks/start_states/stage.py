"""A kitchen in which start states are tried, and the checks of those that were written."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from lxml import etree

from casa_assets.checks.check import Measurement, count, not_applicable, not_run, worst_above
from casa_assets.checks.motion import simulation
from casa_assets.checks.scene.subject import FILE, Contents, all_pairs, body_name, boxes_meet, collision_model
from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import CasaError
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.kitchen.scene import (
    CLOSED_POSE,
    FREE_JOINT,
    FREE_WIDTH,
    OPEN_POSE,
    START_POSE,
    StartStates,
    StateJoint,
)
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

SCENE_JSON = "scene.json"
FOOTPRINT = "robot_footprint"  # a body without contacts, whose distance to things is measured
# Boxes that hold PandaOmron at rest, least and largest corner in the frame of the middle of its base, x ahead, m:
# wheels, column, arm in its home pose. What is lower than 3 cm, such as a rug, does not stop it.
ENVELOPE: tuple[tuple[Vec3, Vec3], ...] = (
    ((-0.35, -0.25, 0.03), (0.35, 0.25, 0.38)),
    ((0.03, -0.12, 0.38), (0.27, 0.12, 0.9)),
    ((0.05, -0.13, 0.9), (0.69, 0.13, 1.6)),
)
MOVABLE = (None, "accessory")  # contracts of things that are no appliances
LARGEST_M, HEAVIEST_KG = 0.45, 3.0  # of a thing that a hand puts somewhere else
WATCHED_S, LOOK_S = 2.0, 0.1
SETTLE_S = 4.0  # what still moves after that is given up
STILL_M = 0.00005  # farthest that any corner goes in `LOOK_S` while a state counts as at rest
MM_PER_M = 1000.0
NO_STATES, OTHER_SCENE = "it holds no state", "they are of another scene.xml (STA001)"


class Kind(StrEnum):
    """Sorts of places where things are put."""

    WORKTOP = "worktop"
    SHELF = "shelf"
    DRAWER = "drawer"
    FRIDGE = "fridge"


# Categories of fixtures, and how the names of their regions begin.
PLACES: dict[Kind, tuple[tuple[str, ...], tuple[str, ...]]] = {
    Kind.WORKTOP: (("counter", "table", "kitchen_cart"), ("top",)),
    Kind.SHELF: (("open_shelf", "wall_cabinet", "base_cabinet", "tall_cabinet"), ("level",)),
    Kind.DRAWER: (("drawer_stack",), ("drawer",)),
    Kind.FRIDGE: (("refrigerator",), ("fridge_shelf", "fridge_drawer")),
}


@dataclass(frozen=True)
class LooseThing:
    """Something that a hand can put elsewhere, with the address of its free joint in qpos and its colliders.

    `turned`: (4,) quaternion of its root body when upright with its front to -y. `kinds`: of the places for it.
    """

    name: str
    category: str
    address: int
    turned: Floats
    geoms: Ints
    kinds: frozenset[str]


@dataclass(frozen=True)
class Place:
    """A box, `<fixture>/<region>`, that things can be put into; `pose` of its centre with joints at zero; size in m."""

    name: str
    kind: Kind
    pose: Pose
    size: Floats
    body: int


@dataclass(frozen=True)
class Parking:
    """A parking place of the robot's base in front of a fixture: x, y (m), yaw (rad)."""

    fixture: str
    at: Floats


class Stage:
    """A scene compiled without its visuals, from the folder that `casa-assets scenes build` wrote."""

    def __init__(self, folder: Path) -> None:
        """Raises CasaError where scene.xml or scene.json is missing or cannot be read."""
        self.folder = folder
        try:
            self.digest = hashlib.sha256((folder / FILE).read_bytes()).hexdigest()
            self.facts: Mapping[str, Any] = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8"))
            self.model = collision_model(folder / FILE, _footprint())
        except FileNotFoundError as error:
            raise CasaError(f"{error.filename}: is missing; casa-assets scenes build {folder.name} writes it") from None
        except (ValueError, KeyError, TypeError, etree.XMLSyntaxError) as error:
            raise CasaError(f"{folder}: scene.xml and scene.json cannot be read: {error}; build it again") from error
        self.data = mujoco.MjData(self.model)
        self._scratch = mujoco.MjData(self.model)
        self._footprint = np.flatnonzero(self.model.geom_bodyid == self.model.body(FOOTPRINT).id)
        self._mocap = int(self.model.body(FOOTPRINT).mocapid[0])
        self._solid = np.flatnonzero((self.model.geom_contype != 0) | (self.model.geom_conaffinity != 0))
        self._moving = np.flatnonzero(self.model.body_weldid[self.model.geom_bodyid] != 0)
        self._moving = self._moving[~np.isin(self._moving, self._footprint)]

    @cached_property
    def joints(self) -> tuple[StateJoint, ...]:
        """All joints in the order of qpos."""
        model, found = self.model, []
        for i in range(model.njnt):
            width = FREE_WIDTH if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE else 1
            found.append(StateJoint(name=model.joint(i).name, address=int(model.jnt_qposadr[i]), width=width))
        return tuple(found)

    @cached_property
    def at_rest(self) -> Floats:
        """(nq,) qpos with all doors and drawers closed, and loose things where the scene has them."""
        return self._key(CLOSED_POSE)

    def _key(self, name: str) -> Floats:
        return np.array(self.model.key(name).qpos, dtype=np.float64)

    @cached_property
    def things(self) -> tuple[LooseThing, ...]:
        """Things that can be put elsewhere: loose, small, not appliances, and carrying nothing that has to stay.

        In a kitchen whose scene.json lists objects, only those are considered.
        """
        model = self.model
        self.show(self.at_rest)
        found = []
        for row, kinds in self._loose():
            name = row["name"]
            if row["mass_kg"] > HEAVIEST_KG:
                continue
            geoms = np.flatnonzero(simulation.subtree(model, int(model.body(name).id))[model.geom_bodyid])
            low, high = simulation.box_around(simulation.geom_boxes(model, self.data, geoms))
            if float((high - low).max()) > LARGEST_M:
                continue
            address = int(model.joint(f"{name}__{FREE_JOINT}").qposadr[0])
            root, back = self._key(START_POSE)[address + 3 : address + FREE_WIDTH], np.zeros(4)
            mujoco.mju_negQuat(back, np.array(row["quaternion"]))
            turned = np.zeros(4)
            mujoco.mju_mulQuat(turned, back, root)
            found.append(LooseThing(name, row["category"], address, turned, geoms, kinds))
        count = 0
        while len(found) != count:
            count, names = len(found), {thing.name for thing in found}
            found = [thing for thing in found if self.on_top.get(thing.name, set()) <= names]
        return tuple(found)

    def _loose(self) -> Iterator[tuple[Mapping[str, Any], frozenset[str]]]:
        """Rows of scene.json of loose things, and the kinds of places where each may be put.

        An object goes on to a worktop, or to another place of the kind in which it is kept.
        """
        categories = {fixture["name"]: fixture["category"] for fixture in self.facts["fixtures"]}
        objects = self.facts.get("objects", [])
        for row in objects:
            kept_in = place_kind(categories.get(row["in"]["placement"], ""), row["in"]["region"])
            yield row, frozenset({Kind.WORKTOP, kept_in or Kind.WORKTOP})
        for row in () if objects else self.facts["fixtures"]:
            if row["base"] == "free" and row["contract"] in MOVABLE:
                yield row, frozenset(Kind)

    @cached_property
    def contents(self) -> Contents:
        """The objects that lie in drawers, on racks and in doors."""
        kept_in = {row["name"]: row["in"] for row in self.facts.get("objects", [])}
        held = [(name, body_name(kept["placement"], kept["link"])) for name, kept in kept_in.items()]
        return Contents(self.model, held, self.at_rest)

    def with_contents(self, qpos: Floats) -> Floats:
        """A state in which doors and drawers were moved, with the objects that rest in them where these took them."""
        self._scratch.qpos[:] = qpos
        self.contents.pose(self._scratch)
        return np.asarray(self._scratch.qpos.copy())

    @cached_property
    def on_top(self) -> Mapping[str, set[str]]:
        """Name of a loose thing -> loose things on or in it: those that touch it and have a higher centre of mass."""
        model, data = self.model, self.data
        self.show(self.at_rest)
        names = [model.body(int(model.body_rootid[b])).name for b in model.geom_bodyid]
        found: dict[str, set[str]] = {}
        for pair in data.contact.geom.tolist():
            first, second = (int(model.body_rootid[model.geom_bodyid[g]]) for g in pair)
            if first == second or 0 in (model.body_weldid[first], model.body_weldid[second]):
                continue
            lower, upper = pair if data.xipos[first][2] < data.xipos[second][2] else pair[::-1]
            found.setdefault(names[lower], set()).add(names[upper])
        return found

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Boxes that things are put into."""
        found = []
        for fixture in self.facts["fixtures"]:
            if fixture["base"] != "fixed":
                continue
            for name, region in fixture["regions"].items():
                kind = place_kind(fixture["category"], name)
                if kind is None or region["kind"] != "box":
                    continue
                link = region["link"]
                body = body_name(fixture["name"], link)
                pose = Pose(position=tuple(region["position"]), quaternion=tuple(region["quaternion"]))
                size = np.array(region["size"], dtype=np.float64)
                found.append(Place(f"{fixture['name']}/{name}", kind, pose, size, int(self.model.body(body).id)))
        return tuple(found)

    @cached_property
    def parking(self) -> tuple[Parking, ...]:
        """Places before closed fixtures, each once."""
        found: dict[tuple[float, float, float], str] = {}
        for fixture, ways in sorted(self.facts["parking"].items()):
            at = ways["shut"]
            if at is not None:
                found.setdefault((at["x"], at["y"], at["yaw"]), fixture)
        return tuple(Parking(fixture, np.array(at)) for at, fixture in found.items())

    @cached_property
    def doors(self) -> tuple[tuple[str, int, float, float], ...]:
        """Joints of doors and drawers that open by themselves: name, address, where closed, where open."""
        opened = self._key(OPEN_POSE)
        found = []
        for fixture in self.facts["fixtures"]:
            parts = self.facts["parking"].get(fixture["name"], {"open": {}})["open"]
            for name, joint in fixture["joints"].items():
                if name in parts and joint["behind"] is None and joint["kind"] in (JointKind.HINGE, JointKind.SLIDE):
                    address = int(self.model.joint(joint["name"]).qposadr[0])
                    found.append((joint["name"], address, float(self.at_rest[address]), float(opened[address])))
        return tuple(found)

    def show(self, qpos: Floats) -> None:
        """Put a state before MuJoCo, at rest, with the contacts that the scene makes in it."""
        simulation.reset_to_start(self.model, self.data)
        self.data.qpos[:] = qpos
        self.data.qvel[:] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def depth(self) -> float:
        """Deepest contact of the present state as the simulation has it, m; zero where nothing is in anything."""
        return max(0.0, -float(self.data.contact.dist.min(initial=0.0)))

    def depth_of_all_pairs(self, qpos: Floats) -> float:
        """Deepest overlap in a state, pairs that never collide in the scene included, m."""
        with all_pairs(self.model):
            self.data.qpos[:] = qpos
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_collision(self.model, self.data)
            return self.depth()

    def corners(self) -> Floats:
        """(8 N, 3) corners of the boxes around all geoms that can move, turned with them, world frame, m."""
        model, data, geoms = self.model, self.data, self._moving
        signs = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) * 2.0 - 1.0
        local = model.geom_aabb[geoms, None, :3] + signs * model.geom_aabb[geoms, None, 3:]
        turned = np.einsum("nij,nkj->nki", data.geom_xmat[geoms].reshape(-1, 3, 3), local)
        return np.asarray((turned + data.geom_xpos[geoms, None, :]).reshape(-1, 3))

    def in_the_way(self, at: Floats) -> str | None:
        """Name of a thing that a robot with its base at x, y (m), yaw (rad) touches in the present state, or None."""
        model, data = self.model, self.data
        data.mocap_pos[self._mocap] = (at[0], at[1], 0.0)
        data.mocap_quat[self._mocap] = (math.cos(at[2] / 2), 0.0, 0.0, math.sin(at[2] / 2))
        mujoco.mj_kinematics(model, data)
        robot, boxes = (simulation.geom_boxes(model, data, geoms) for geoms in (self._footprint, self._solid))
        for part, near in zip(self._footprint.tolist(), boxes_meet(robot[:, None], boxes[None]), strict=True):
            for geom in self._solid[near].tolist():
                if mujoco.mj_geomDistance(model, data, part, geom, 0.01, None) < 0.0:
                    return str(model.body(int(model.body_rootid[model.geom_bodyid[geom]])).name)
        return None

    def box_of(self, thing: LooseThing, quaternion: Floats) -> Floats:
        """(2, 3) corners of the box around a thing whose free joint is at the origin, turned so; m."""
        self._scratch.qpos[thing.address : thing.address + FREE_WIDTH] = (0.0, 0.0, 0.0, *quaternion)
        mujoco.mj_kinematics(self.model, self._scratch)
        return self.low_and_high(thing, self._scratch)

    def carried(self, qpos: Floats, place: Place, point: Floats) -> Floats:
        """(3,) where a point of a place is in a state, given where it is while all joints are at zero; m."""
        data = self._scratch
        data.qpos[:] = self.model.qpos0
        mujoco.mj_kinematics(self.model, data)
        local = data.xmat[place.body].reshape(3, 3).T @ (point - data.xpos[place.body])
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, data)
        return np.asarray(data.xmat[place.body].reshape(3, 3) @ local + data.xpos[place.body])

    def low_and_high(self, thing: LooseThing, data: mujoco.MjData | None = None) -> Floats:
        """(2, 3) corners of the box around a thing in the present state, or that of `data`; world frame, m."""
        points = np.concatenate([simulation.vertices_of(self.model, data or self.data, int(g)) for g in thing.geoms])
        return np.array([points.min(axis=0), points.max(axis=0)])


def place_kind(category: str, region: str) -> Kind | None:
    """Kind of place that a region of a fixture is; None if nothing is put there."""
    of_region = (kind for kind, (categories, _) in PLACES.items() if category in categories)
    return next((kind for kind in of_region if region.startswith(PLACES[kind][1])), None)


def _footprint() -> etree._Element:
    """A body for the room that a robot takes, which touches nothing."""
    body = etree.Element("body", {"name": FOOTPRINT, "mocap": "true", "pos": "0 0 -9"})
    for low, high in ENVELOPE:
        middle, half = (np.array(low) + high) / 2, (np.array(high) - low) / 2
        sizes = {"pos": " ".join(map(str, middle.tolist())), "size": " ".join(map(str, half.tolist()))}
        etree.SubElement(body, "geom", {"type": "box", "contype": "0", "conaffinity": "0", **sizes})
    return body


@dataclass(frozen=True)
class Watched:
    """Deepest contact (m; at the start of all pairs) and farthest motion of a corner (m) in 2 s of simulation."""

    depth: float
    motion: float
    warnings: tuple[str, ...]


def settle(stage: Stage, qpos: Floats) -> Floats | None:
    """A state in which nothing moves any more, rounded to float32; None if it does not come to rest in 4 s."""
    model, data = stage.model, stage.data
    stage.show(qpos)
    steps, last = round(LOOK_S / model.opt.timestep), stage.corners()
    for _ in range(round(SETTLE_S / LOOK_S)):
        mujoco.mj_step(model, data, nstep=steps)
        now = stage.corners()
        if float(np.linalg.norm(now - last, axis=1).max(initial=0.0)) < STILL_M:
            return np.asarray(data.qpos.astype(np.float32).astype(np.float64))
        last = now
    return None


def watch(stage: Stage, qpos: Floats) -> Watched:
    """Begin with a state at rest and look on for 2 s."""
    model, data = stage.model, stage.data
    depth = stage.depth_of_all_pairs(qpos)
    stage.show(qpos)
    before, motion = stage.corners(), 0.0
    steps = round(LOOK_S / model.opt.timestep)
    for _ in range(round(WATCHED_S / LOOK_S)):
        mujoco.mj_step(model, data, nstep=steps)
        depth = max(depth, stage.depth())
        motion = max(motion, float(np.linalg.norm(stage.corners() - before, axis=1).max(initial=0.0)))
    return Watched(depth, motion, tuple(simulation.simulation_warnings(data)))


@dataclass(frozen=True, eq=False)
class StatesSubject:
    """Start states and the scene of the folder that holds them; a subject is equal to itself alone."""

    states: StartStates
    stage: Stage

    @cached_property
    def misfits(self) -> tuple[str, ...]:
        """In what the states are not of this scene."""
        found = []
        if self.states.scene_xml != self.stage.digest:
            found.append("were made for a scene.xml of other content")
        if self.states.joints != self.stage.joints:
            found.append("name joints or places in qpos that scene.xml does not have")
        return tuple(found)

    @cached_property
    def watched(self) -> tuple[Watched, ...]:
        """Behaviour of each state in 2 s in which nobody touches it, simulated again."""
        return tuple(watch(self.stage, row) for row in self.rows)

    @cached_property
    def rows(self) -> Floats:
        """(states, nq) as MuJoCo takes them."""
        return self.states.qpos.astype(np.float64)


def states_fit_their_scene(subject: StatesSubject) -> Measurement:
    """STA001: number of ways in which the file does not fit scene.xml."""
    return count(("start_states.npz", f"they {text}; draw them again") for text in subject.misfits)


def states_have_no_deep_contact(subject: StatesSubject, limit: float) -> Measurement:
    """STA002: deepest contact in any state at its start and in the 2 s after it, metres."""
    if subject.misfits:
        return not_run(OTHER_SCENE)
    message = "shapes are {:.2f} mm in each other; draw it again"
    depths = enumerate(seen.depth for seen in subject.watched)
    return worst_above(((f"states/{k}", m, message.format(MM_PER_M * m)) for k, m in depths), limit, NO_STATES)


def states_stay_put(subject: StatesSubject, limit: float) -> Measurement:
    """STA003: farthest that anything moves in 2 s in any state, metres."""
    if subject.misfits:
        return not_run(OTHER_SCENE)
    message = "something moves {:.1f} mm by itself; draw it again"
    ways = enumerate(seen.motion for seen in subject.watched)
    return worst_above(((f"states/{k}", m, message.format(MM_PER_M * m)) for k, m in ways), limit, NO_STATES)


def states_leave_room_for_the_robot(subject: StatesSubject, limit: float) -> Measurement:
    """STA004: number of states in which the robot, at its base pose, overlaps something."""
    if subject.misfits:
        return not_run(OTHER_SCENE)
    if not len(subject.states):
        return not_applicable(NO_STATES)
    problems = []
    for k, (row, base) in enumerate(zip(subject.rows, subject.states.base, strict=True)):
        subject.stage.show(row)
        thing = subject.stage.in_the_way(base.astype(np.float64))
        if thing is not None:
            problems.append((f"states/{k}", f"{thing} stands in the robot; draw it again"))
    return count(problems, allowed=limit)


def states_differ(subject: StatesSubject, limit: float) -> Measurement:
    """STA005: farthest that joints, things and robot differ between the two states that are most alike, m or rad."""
    if len(subject.states) < 2:
        return not_applicable("it holds fewer than two states")
    rows = np.concatenate([subject.rows, subject.states.base.astype(np.float64)], axis=1)
    least, problems = np.inf, []
    for k in range(1, len(rows)):
        apart = np.abs(rows[:k] - rows[k]).max(axis=1)
        twin = int(apart.argmin())
        least = min(least, float(apart[twin]))
        if apart[twin] < limit:
            problems.append((f"states/{k}", f"is the same as state {twin} within {apart[twin]:.3f}; draw it again"))
    return Measurement(float(least), tuple(problems))
