"""A resolved scene: assets and their placements. Nothing is left to look up, to draw at random or to default."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Self

import numpy as np
from pydantic import Field, StringConstraints, field_validator, model_validator

from casa_assets.model.asset.asset import Asset, JointValue
from casa_assets.model.asset.material import Positive, Unit
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, MixedCaseId, Record, Vec3

# `<plan>__<style>`, and more parts for what differs from them.
SceneId = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9]*(_{1,2}[a-z0-9]+)*$", max_length=160)]
# What writers call the joint of a free base and the body that holds the others; nothing else is called so.
FREE_JOINT, WORLD = "free", "world"
# Named poses that every scene has: as it begins, everything closed, and open what has such a keyframe.
START_POSE, CLOSED_POSE, OPEN_POSE = "start", "closed", "open"


# Label of the faces of walls that look out of the room. Viewers leave them and the ceiling out, to look in.
OUTER_FACE = "wall_outside"


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
        name: unique in the scene.
        asset: id in Scene.assets.
        pose: world_from_asset.
        joints: starting positions, rad or m; joints that are not named start at zero.
        layer: group that it belongs to.
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
        castshadow: whether it casts shadows.
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
    color: Vec3 = (1.0, 1.0, 1.0)
    castshadow: bool = True
    attenuation: Vec3 = (1.0, 0.0, 0.0)
    radius: Positive = 0.05
    cone_deg: Annotated[float, Field(gt=0, le=90)] = 45.0
    softness: Unit = 0.5

    @model_validator(mode="after")
    def _shines(self) -> Self:
        if min(self.color) < 0 or min(self.attenuation) < 0 or max(self.attenuation) == 0:
            raise ValueError(
                f"light {self.name!r}: colour and attenuation are not negative, one of the latter positive"
            )
        if float(np.linalg.norm(self.direction)) < 1e-9:
            raise ValueError(f"light {self.name!r} has no direction")
        return self


class Sky(Record):
    """Background seen through windows and beyond open walls: linear RGB, 0..1, from overhead to the horizon."""

    zenith: Vec3 = (0.36, 0.55, 0.8)
    horizon: Vec3 = (0.85, 0.88, 0.9)

    @field_validator("zenith", "horizon")
    @classmethod
    def _legal(cls, color: Vec3) -> Vec3:
        if not all(0.0 <= c <= 1.0 for c in color):
            raise ValueError(f"colour {color} is outside 0..1")
        return color


class PlacedLink(Record):
    """A link of a placement."""

    placement: Id
    link: Id


class Scene(Record):
    """Everything in a room. World frame: z up, metres.

    Attributes:
        id: valid scene name.
        assets: each asset once, however often it is placed.
        placements: copies of the assets, each with its pose.
        cameras: cameras in the room.
        lights: lights in the room.
        ambient: linear RGB, >= 0, of light that comes evenly from all sides; 1 alone makes a white surface white.
        sky: None if nothing is visible beyond the room.
        gravity: m/s^2.
        exclusions: pairs of links, of two placements or of one, that never collide with each other, in addition to
            those that an asset itself excludes.
    """

    id: SceneId
    assets: tuple[Asset, ...]
    placements: tuple[Placement, ...]
    cameras: tuple[Camera, ...] = ()
    lights: tuple[Light, ...] = ()
    ambient: Vec3 = (0.3, 0.3, 0.3)
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
        if min(self.ambient) < 0:
            raise ValueError(f"ambient light {self.ambient} must not be negative")
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

    Attributes:
        scene: the full scene.
        light_assets: light forms of its assets, in the same order, under the same ids.
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


# Between the name of a collider and the number of a further primitive that stands for it.
_PART = "_more_"


def _check_joints(place: Placement, asset: Asset) -> None:
    joints = {j.name: j for j in asset.joints}
    if FREE_JOINT in joints:
        raise ValueError(f"asset {asset.id!r}: a joint called {FREE_JOINT!r} would be taken for that of its base")
    for at in place.joints:
        if at.joint not in joints:
            raise ValueError(f"placement {place.name!r}: no joint {at.joint!r} in {place.asset!r}")
        low, high = joints[at.joint].range
        if not low <= at.value <= high:
            raise ValueError(f"placement {place.name!r}: {at.joint} = {at.value} is outside {low}..{high}")
