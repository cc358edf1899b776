"""Fact table of a scene, which both formats are reduced to."""

from __future__ import annotations

from casa_assets.checks.package.facts import AssetFacts, ProgramTexts
from casa_assets.model.asset.asset import Base
from casa_assets.model.record import Record, Vec3, Vec4


class PlacementFacts(Record):
    """One copy of an asset.

    Attributes:
        asset: id. layer: thing, room or ceiling. base: whether it floats.
        position, quaternion: world_from_root as physics finds it, every joint at zero.
        words: with the names that things have in the asset.
    """

    name: str
    asset: str
    layer: str
    base: Base
    position: Vec3
    quaternion: Vec4
    words: ProgramTexts


class CameraFacts(Record):
    """A camera: world_from_camera, looking along -z with y up, and its vertical field of view."""

    name: str
    position: Vec3
    quaternion: Vec4
    fov_y_deg: float


class LightFacts(Record):
    """A light, without its brightness, of which the formats have different notions.

    Attributes:
        kind: directional, point or spot.
        direction: unit vector along which it shines, zero where it shines to all sides.
        tint: its colour, the largest share 1.
        cone_deg: of a spot, else 0.
    """

    name: str
    kind: str
    position: Vec3
    direction: Vec3
    tint: Vec3
    castshadow: bool
    cone_deg: float


class SceneFacts(Record):
    """Facts that one format states about a scene.

    Attributes:
        gravity: m/s^2.
        placements, cameras, lights: sorted by name.
        things: bodies, exclusions, places, looks and poses of all placements under their names in the scene, `cup` and
            `cup__handle`. Bodies are in the frame of the root of their placement, poses are world_from_body. Base and
            words are empty here: they belong to placements.
    """

    gravity: Vec3
    placements: tuple[PlacementFacts, ...]
    cameras: tuple[CameraFacts, ...] = ()
    lights: tuple[LightFacts, ...] = ()
    things: AssetFacts
