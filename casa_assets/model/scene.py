"""A resolved scene: assets and where they stand. Nothing is left to look up, draw or default."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.asset import Asset, JointValue
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, Record, Vec3


class Placement(Record):
    """One copy of an asset.

    Attributes:
        name: unique in the scene.
        asset: id in Scene.assets.
        pose: world_from_asset.
        joints: starting positions; joints that are not named start at zero.
    """

    name: Id
    asset: Id
    pose: Pose = Pose()
    joints: tuple[JointValue, ...] = ()


class Camera(Record):
    """A pinhole camera looking along its -z, y up; `fov_y_deg` is the vertical field of view in degrees."""

    name: Id
    pose: Pose
    fov_y_deg: Annotated[float, Field(gt=0, lt=180)] = 45.0


class Light(Record):
    """A light at `position` shining along `direction`; `color` is linear RGB, >= 0."""

    name: Id
    position: Vec3
    direction: Vec3
    color: Vec3 = (1.0, 1.0, 1.0)


class Scene(Record):
    """Everything in a room. World frame: z up, metres.

    Attributes:
        id: legal name.
        assets: each asset once, however often it is placed.
        placements, cameras, lights: what stands where.
        gravity: m/s^2.
    """

    id: Id
    assets: tuple[Asset, ...]
    placements: tuple[Placement, ...]
    cameras: tuple[Camera, ...] = ()
    lights: tuple[Light, ...] = ()
    gravity: Vec3 = (0.0, 0.0, -9.81)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        assets = {a.id: a for a in self.assets}
        names = [n.name for group in (self.placements, self.cameras, self.lights) for n in group]
        if len(assets) != len(self.assets) or len(set(names)) != len(names):
            raise ValueError("ids of assets and names of placements, cameras and lights must be distinct")
        for place in self.placements:
            if place.asset not in assets:
                raise ValueError(f"placement {place.name!r}: no asset {place.asset!r}")
            joints = {j.name: j for j in assets[place.asset].joints}
            for at in place.joints:
                if at.joint not in joints:
                    raise ValueError(f"placement {place.name!r}: no joint {at.joint!r} in {place.asset!r}")
                low, high = joints[at.joint].range
                if not low <= at.value <= high:
                    raise ValueError(f"placement {place.name!r}: {at.joint} = {at.value} is outside {low}..{high}")
        return self
