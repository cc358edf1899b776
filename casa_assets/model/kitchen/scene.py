"""A resolved scene (assets and their places), its light and batch forms, its named poses and its start states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Annotated, Any, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, StringConstraints, model_validator

from casa_assets.model.asset.asset import Asset, Base, Collider, JointValue
from casa_assets.model.asset.material import Positive, Unit
from casa_assets.model.asset.parts import NotNegative, joint_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import ArrayOf, Id, MixedCaseId, Record, Sha256, Vec3

# `<plan>__<style>`, and more parts for what differs from them.
SceneId = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9]*(_{1,2}[a-z0-9]+)*$", max_length=160)]
# What writers call the joint of a free base and the body that holds the others; nothing else is called so.
FREE_JOINT, WORLD = "free", "world"
# Named poses that every scene has: as it begins, everything closed, and open what has such a keyframe.
START_POSE, CLOSED_POSE, OPEN_POSE = "start", "closed", "open"
# Label of the faces of walls that look out of the room. Viewers leave them and the ceiling out, to look in.
OUTER_FACE = "wall_outside"
# Between the name of a collider and the number of a further primitive in its place.
_PART = "_more_"
# Pixels along the longer side of a picture: about 5 mm of a floor, and cameras of policies have some hundred.
PICTURE_PX = 256
FREE_WIDTH = 7  # numbers in qpos of a free joint: x, y, z, quaternion (w, x, y, z)
ARRAYS = ("qpos", "base", "depth", "motion")  # of start states
Brightness = tuple[NotNegative, NotNegative, NotNegative]
Rows = Annotated[npt.NDArray[np.float32], ArrayOf("float32", (-1, -1))]
Bases = Annotated[npt.NDArray[np.float32], ArrayOf("float32", (-1, 3))]
Numbers = Annotated[npt.NDArray[np.float32], ArrayOf("float32", (-1,))]


class Layer(StrEnum):
    """Group that a placement belongs to. Room and ceiling can be hidden, to look in from outside."""

    THINGS = "things"
    ROOM = "room"
    CEILING = "ceiling"


class Resting(Record):
    """The support of an object: a link of another placement, and the name of the region or site there."""

    placement: Id
    link: Id
    region: MixedCaseId


class Placement(Record):
    """One copy of an asset.

    Attributes:
        pose: world_from_asset. joints: starting positions, rad or m; joints that are not named start at zero.
        resting: support of an object that was put into the kitchen; the object moves along if its drawer opens.
    """

    name: Id
    asset: Id
    pose: Pose = Pose()
    joints: tuple[JointValue, ...] = ()
    layer: Layer = Layer.THINGS
    resting: Resting | None = None


class Camera(Record):
    """A pinhole camera looking along its -z, y up; `fov_y_deg` is the vertical field of view in degrees."""

    name: Id
    pose: Pose
    fov_y_deg: Annotated[float, Field(gt=0, lt=180)] = 45.0


class LightKind(StrEnum):
    """Along one direction from everywhere (the sun), from a point to all sides (a bulb), or from a point in a cone."""

    DIRECTIONAL = "directional"
    POINT = "point"
    SPOT = "spot"


class Light(Record):
    """A light at `position` shining along `direction`, world frame, metres.

    Attributes:
        direction: need not have length one; a point light shines to all sides regardless.
        color: linear RGB, >= 0: brightness of a white surface that faces the light, before attenuation; 1 is white.
        attenuation: (a, b, c): brightness is multiplied by 1 / (a + b d + c d^2) at d metres. Not for directional
            lights.
        radius: radius of the bulb, metres: the larger, the softer the shadows.
        cone_deg: angle between the axis of a spot and the edge of its light, degrees.
        softness: 0..1, how early a spot fades towards that edge.
    """

    name: Id
    kind: LightKind = LightKind.DIRECTIONAL
    position: Vec3
    direction: Vec3
    color: Brightness = (1.0, 1.0, 1.0)
    castshadow: bool = True
    attenuation: Brightness = (1.0, 0.0, 0.0)
    radius: Positive = 0.05
    cone_deg: Annotated[float, Field(gt=0, le=90)] = 45.0
    softness: Unit = 0.5

    @model_validator(mode="after")
    def _shines(self) -> Self:
        if max(self.attenuation) == 0:
            raise ValueError(f"light {self.name!r}: one number of its attenuation is positive")
        if float(np.linalg.norm(self.direction)) < 1e-9:
            raise ValueError(f"light {self.name!r} has no direction")
        return self


class Sky(Record):
    """Background seen through windows and beyond open walls: linear RGB, 0..1, from overhead to the horizon."""

    zenith: tuple[Unit, Unit, Unit] = (0.36, 0.55, 0.8)
    horizon: tuple[Unit, Unit, Unit] = (0.85, 0.88, 0.9)


class PlacedLink(Record):
    """A link of a placement."""

    placement: Id
    link: Id


class Scene(Record):
    """Everything in a room. World frame: z up, metres.

    Attributes:
        assets: each asset once, however often it is placed.
        ambient: linear RGB, >= 0, of light that comes evenly from all sides; 1 alone makes a white surface white.
        sky: None if nothing is visible beyond the room. gravity: m/s^2.
        exclusions: pairs of links, of two placements or of one, that never collide with each other, in addition to
            those that an asset itself excludes.
    """

    id: SceneId
    assets: tuple[Asset, ...]
    placements: tuple[Placement, ...]
    cameras: tuple[Camera, ...] = ()
    lights: tuple[Light, ...] = ()
    ambient: Brightness = (0.3, 0.3, 0.3)
    sky: Sky | None = Sky()
    gravity: Vec3 = (0.0, 0.0, -9.81)
    exclusions: tuple[tuple[PlacedLink, PlacedLink], ...] = ()

    @property
    def objects(self) -> tuple[Placement, ...]:
        """Objects that were put into the kitchen and are not part of its plan and style: plates, food, tools."""
        return tuple(place for place in self.placements if place.resting is not None)

    @property
    def asset_of(self) -> dict[str, Asset]:
        """Name of a placement -> its asset, in the order of the placements."""
        assets = {asset.id: asset for asset in self.assets}
        return {place.name: assets[place.asset] for place in self.placements}

    @model_validator(mode="after")
    def _whole(self) -> Self:
        assets = {a.id: a for a in self.assets}
        names = [n.name for group in (self.placements, self.cameras, self.lights) for n in group]
        if len(assets) != len(self.assets) or len(set(names)) != len(names):
            raise ValueError("ids of assets and names of placements, cameras and lights must be distinct")
        if WORLD in names:
            raise ValueError(f"nothing in a scene is called {WORLD!r}")
        for place in self.placements:
            if place.asset not in assets:
                raise ValueError(f"placement {place.name!r}: no asset {place.asset!r}")
            _check_joints(place, assets[place.asset])
        links = {place.name: {link.name for link in assets[place.asset].links} for place in self.placements}
        for place in self.objects:
            rest = place.resting
            if rest is not None and rest.link not in links.get(rest.placement, ()):
                raise ValueError(f"placement {place.name!r} rests on {rest.placement}/{rest.link}, which is not there")
        return self


class LightScene(Record):
    """A scene with the light form of each of its assets: boxes, cylinders and spheres that replace its colliders.

    `light_assets` are in the order of the assets, under the same ids.
    """

    scene: Scene
    light_assets: tuple[Asset, ...]

    @staticmethod
    def part_name(collider: str, number: int) -> str:
        """Name of an additional primitive that represents a collider, counted from 1."""
        return f"{collider}{_PART}{number}"

    @staticmethod
    def collider_of(name: str) -> str:
        """Name of the collider that a primitive of a light form represents."""
        head, sign, tail = name.rpartition(_PART)
        return head if sign and tail.isdigit() else name

    @model_validator(mode="after")
    def _same_assets(self) -> Self:
        if [a.id for a in self.scene.assets] != [a.id for a in self.light_assets]:
            raise ValueError("a light scene has the light form of each asset, in the same order")
        return self


def _check_joints(place: Placement, asset: Asset) -> None:
    ranges = {j.name: j.range for j in asset.joints}
    if FREE_JOINT in ranges:
        raise ValueError(f"asset {asset.id!r}: a joint called {FREE_JOINT!r} would be taken for that of its base")
    for at in place.joints:
        if at.joint not in ranges:
            raise ValueError(f"placement {place.name!r}: no joint {at.joint!r} in {place.asset!r}")
        low, high = ranges[at.joint]
        if not low <= at.value <= high:
            raise ValueError(f"placement {place.name!r}: {at.joint} = {at.value} is outside {low}..{high}")


class WorldCollider(Record):
    """A primitive that never moves and replaces colliders of one or more placements.

    Attributes:
        placement: that has the largest of these colliders.
        collider: named like that one, with its pose in the world frame; its substance is one of that placement's asset.
        is_overhead: so high that only a robot can touch it.
    """

    placement: Id
    collider: Collider
    is_overhead: bool = False


class PlacedJoint(Record):
    """A joint of a placement."""

    placement: Id
    joint: Id


class EngineSizes(Record):
    """Buffer sizes that a GPU engine needs for one world of a batch form, and the measurements that they are based on.

    Attributes:
        nconmax: number of contacts to allocate, 1.5 times `contacts`; mujoco_warp's `make_data` has arguments of this
            name and of the next three.
        njmax: number of constraint rows to allocate. nccdmax: number of convex pairs to allocate.
        nvmax: number of awake degrees of freedom to allocate. contacts: maximum number at once in the trials.
        rows: maximum number of constraint rows in the trials.
        awake: maximum number of awake degrees of freedom in the trials.
        convex_pairs: pairs of shapes that need the general convex algorithm, such as a cylinder and a box.
        awake_in_use: awake degrees of freedom with a placeholder robot and one fixture in use, and no object
            dropped.
        fixtures: number of fixtures that were used in the trials, one after the other.
        mujoco_bytes: memory of an MjData in MuJoCo itself: its buffer, and the largest part of its arena that was used.
    """

    nconmax: int
    njmax: int
    nccdmax: int
    nvmax: int
    contacts: int
    rows: int
    convex_pairs: int
    awake: int
    awake_in_use: int
    fixtures: int
    mujoco_bytes: int


class BatchScene(Record):
    """A scene with fewer primitives and fewer joints, and without contacts that are impossible.

    Attributes:
        forms: the batch form of the asset of each placement, in the order of the placements. Parts that never move have
            no colliders in them. Locked joints are left out; the parts that they moved stay in the start pose.
        world: the colliders of everything that never moves.
        meeting: sets of links of two or more fixtures that could touch each other; no other links of fixtures ever do.
        filled: names of loose objects that are solid here but hollow in the scene, and of fixtures whose door bins are
            filled.
    """

    scene: Scene
    forms: tuple[Asset, ...]
    world: tuple[WorldCollider, ...]
    meeting: tuple[tuple[PlacedLink, ...], ...] = ()
    locked: tuple[PlacedJoint, ...] = ()
    filled: tuple[Id, ...] = ()

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if [form.id for form in self.forms] != [place.asset for place in self.scene.placements]:
            raise ValueError("a batch form has a form of the asset of each placement, in their order")
        names = {place.name for place in self.scene.placements}
        if any(item.placement not in names for item in self.world):
            raise ValueError("each collider of the world belongs to a placement")
        return self

    @property
    def collider_count(self) -> int:
        """Number of its primitives."""
        return len(self.world) + sum(len(link.colliders) for form in self.forms for link in form.links)

    @property
    def pair_count(self) -> int:
        """Number of pairs of primitives that an engine has to check for contacts.

        These are pairs of a loose object with anything that is not overhead, and pairs of fixture parts that can meet.
        """
        things = [sum(len(link.colliders) for link in form.links) for form in self.forms if form.base is Base.FREE]
        fixed = sum(len(link.colliders) for form in self.forms for link in form.links) - sum(things)
        low = sum(not item.is_overhead for item in self.world)
        counts = {
            (place.name, link.name): len(link.colliders)
            for place, form in zip(self.scene.placements, self.forms, strict=True)
            for link in form.links
        }
        meeting = (_pairs_of([counts[ref.placement, ref.link] for ref in group]) for group in self.meeting)
        return sum(things) * (low + fixed) + _pairs_of(things) + sum(meeting)


def _pairs_of(counts: Sequence[int]) -> int:
    return (sum(counts) ** 2 - sum(count**2 for count in counts)) // 2


def own_pose(place: Placement, name: str) -> str:
    """Named pose that the asset of a placement has in a named pose of the scene.

    An object stays closed in the open pose of the kitchen: lids of jars in a cupboard stay on.
    """
    return CLOSED_POSE if place.resting is not None and name == OPEN_POSE else name


def key_positions(place: Placement, asset: Asset) -> dict[str, dict[str, float]]:
    """Name of each scene pose -> joint positions of a placement, rad or m; joints that are not named are at zero."""
    keyframes = {key.name: joint_positions(key.joints) for key in asset.keyframes}
    closed = keyframes.get(CLOSED_POSE, {})
    return {
        START_POSE: joint_positions(place.joints),
        CLOSED_POSE: closed,
        OPEN_POSE: keyframes.get(own_pose(place, OPEN_POSE), closed),
    }


def carried_pose(
    place: Placement, placements: Mapping[str, Placement], assets: Mapping[str, Asset], name: str
) -> Pose | None:
    """Return world_from_asset of an object in a named pose, or None if it is in its start pose.

    `place`: placement of the object; one without a support stays in place. `placements`, `assets`: of the scene, by
    name of the placement.
    """
    rest = place.resting
    if rest is None:
        return None
    holder, asset = placements[rest.placement], assets[rest.placement]
    positions = key_positions(holder, asset)
    if not asset.is_moved(rest.link) or positions[name] == positions[START_POSE]:
        return None
    at_start, now = (asset.asset_from_link(rest.link, positions[key]) for key in (START_POSE, name))
    return holder.pose @ now @ at_start.inverse() @ holder.pose.inverse() @ place.pose


class StateJoint(Record):
    """A joint of the kitchen, by its name in scene.xml, and where its numbers are in a row; a free joint has 7."""

    name: str
    address: Annotated[int, Field(ge=0)]
    width: Literal[1, 7]


class StateNotes(Record):
    """Notes on one state, in addition to its numbers.

    Attributes:
        placed: loose object that was put somewhere -> its place as `<fixture>/<region>`.
        parked: fixture in front of which the robot is. opened: joints that are not in their rest position.
    """

    placed: dict[str, str]
    parked: str
    opened: tuple[str, ...] = ()


class StartStates(Record):
    """Start states of one scene. Metres, radians, quaternions (w, x, y, z), world frame.

    Attributes:
        key: digest of everything that they were made from. scene_xml: digest of the bytes of its scene.xml.
        mujoco: version with which they were settled. limits: greatest depth and motion (m) of each state.
        envelope: boxes that are kept free for the robot at its parking place: lower and upper corner of each, in the
            frame of the middle of its base, x ahead (m).
        joints: in the order of qpos. qpos: (states, nq).
        base: (states, 3) x, y and yaw of the middle of the robot's base.
        depth: (states,) deepest contact at the start and in the 2 s after it, m.
        motion: (states,) greatest distance that any part moves in these 2 s, m.
        refused: reason -> number of draws that were rejected for it.
    """

    format: Literal[1] = 1
    key: str
    scene: SceneId
    scene_xml: Sha256
    mujoco: str
    seed: Annotated[int, Field(ge=0)]
    limits: tuple[float, float]
    envelope: tuple[tuple[Vec3, Vec3], ...]
    joints: tuple[StateJoint, ...]
    notes: tuple[StateNotes, ...]
    qpos: Rows
    base: Bases
    depth: Numbers
    motion: Numbers
    refused: dict[str, int] = Field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.notes)

    @property
    def header(self) -> dict[str, Any]:
        """Everything except the arrays, as JSON data."""
        return self.model_dump(mode="json", exclude=set(ARRAYS))

    @model_validator(mode="after")
    def _fits(self) -> Self:
        counts = {name: len(getattr(self, name)) for name in (*ARRAYS, "notes")}
        if len(set(counts.values())) != 1:
            raise ValueError(f"as many rows are expected of each: {counts}")
        ends = [0, *(joint.address + joint.width for joint in self.joints)]
        if [joint.address for joint in self.joints] != ends[:-1] or self.qpos.shape[1] != ends[-1]:
            raise ValueError(f"joints follow each other and fill a row of {self.qpos.shape[1]} numbers")
        return self
