"""scene.json of a kitchen: what stands where, with names of bodies, joints and sites as scene.xml has them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.joint import JointKind
from casa_assets.model.kitchen.floor import ParkingSide
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import Layer
from casa_assets.model.kitchen.surface import Surface
from casa_assets.model.record import Record, Sha256, Vec2, Vec3, Vec4

Count = Annotated[int, Field(ge=0)]
Length = Annotated[float, Field(ge=0)]


class PoseRow(Record):
    """Place of a frame in another one.

    Attributes:
        position: metres.
        quaternion: (w, x, y, z), unit length.
    """

    position: Vec3
    quaternion: Vec4


class WallRow(Record):
    """A wall, as a line on the floor; whoever looks from `from` to `to` has the room on the right.

    Attributes:
        id: name in the plan.
        open: the plan leaves it open, so that nothing is drawn.
        start: left end, metres.
        end: right end, metres.
    """

    id: str
    open: bool
    start: Vec3 = Field(alias="from")
    end: Vec3 = Field(alias="to")


class OpeningRow(Record):
    """A door, a window, a passage or a niche in a wall.

    Attributes:
        id: name in the plan.
        kind: what it is.
        wall: id of its wall; of a window in the back of a niche, of the wall that the niche is in.
        start: lower left corner, metres.
        end: upper right corner, metres.
        closet: whether it leads to a closet, and not out.
    """

    id: str
    kind: OpeningKind
    wall: str
    start: Vec3 = Field(alias="from")
    end: Vec3 = Field(alias="to")
    closet: bool = False


class RoomRow(Record):
    """The room.

    Attributes:
        outline: corners of the floor, metres.
        bounds: lower and upper corner of the room, metres.
        walls: in the order of the plan.
        openings: doors, windows, passages and niches.
    """

    outline: tuple[Vec2, ...]
    bounds: tuple[Vec3, Vec3]
    walls: tuple[WallRow, ...]
    openings: tuple[OpeningRow, ...]


class JointRow(Record):
    """A joint of a fixture.

    Attributes:
        name: of the joint in scene.xml, `<fixture>__<joint>`.
        kind: hinge or slide.
        range: lower and upper end, radians or metres; zero is closed.
        grip: collision shape that a hand takes; null where there is none.
        behind: region that it opens; null where there is none.
    """

    name: str
    kind: JointKind
    range: Vec2
    grip: str | None
    behind: str | None


class RegionRow(PoseRow):
    """A named volume, in the world, while all joints are at zero.

    Attributes:
        link: link of the asset that it moves with.
        kind: box or cylinder.
        size: width, depth, height, metres; of a cylinder the first two are its diameter.
    """

    link: str
    kind: str
    size: Vec3


class SiteRow(Record):
    """A named place.

    Attributes:
        site: its name in scene.xml.
        kind: what it is for.
    """

    site: str
    kind: str


class FixtureRow(PoseRow):
    """A thing that is part of the kitchen: a cabinet, an appliance, a worktop, a wall; its pose is that of its frame.

    Attributes:
        name: of its body in scene.xml.
        role: what it is in this kitchen, such as `sink` or `counter`.
        unit: unit of the plan that it comes from.
        run: row of units that it stands in.
        layer: `things`, `room` (walls, floor) or `ceiling`.
        asset: id of the asset.
        family: family that builds it.
        preset: preset of that family.
        category: row of registry/categories.yaml.
        contract: file of registry/contracts/ that it meets; null where there is none.
        base: `fixed` or `free`.
        mass_kg: kilograms.
        joints: name in the asset -> joint.
        states: `<joint>.<state>` that its joints can be in.
        regions: name in the asset -> region.
        sites: name in the asset -> site.
        parts: labels of its parts.
    """

    name: str
    role: str
    unit: str
    run: str
    layer: Layer
    asset: str
    family: str
    preset: str
    category: str
    contract: str | None
    base: Base
    mass_kg: Length
    joints: dict[str, JointRow]
    states: tuple[str, ...]
    regions: dict[str, RegionRow]
    sites: dict[str, SiteRow]
    parts: tuple[str, ...]


class HolderRow(Record):
    """What an object rests in.

    Attributes:
        placement: name of the fixture.
        link: link of its asset.
        region: region of its asset.
    """

    placement: str
    link: str
    region: str


class ObjectRow(PoseRow):
    """An object that was put into a kitchen that is lived in.

    Attributes:
        name: of its body in scene.xml.
        asset: id of the asset.
        category: row of registry/categories.yaml.
        mass_kg: kilograms.
        holder: what it rests in.
    """

    name: str
    asset: str
    category: str
    mass_kg: Length
    holder: HolderRow = Field(alias="in")


class SpacePoses(Record):
    """Middle of the floor of a space; x along the front, y to the back.

    Attributes:
        world: in the frame of the kitchen.
        fixture: in the frame of the fixture, joints at zero.
    """

    world: PoseRow
    fixture: PoseRow


class FreeBox(Record):
    """The largest box that is free in a space.

    Attributes:
        size: width, depth, height, metres.
        x: of the middle of its floor, in the frame of the space, metres.
        y: the same.
    """

    size: Vec3
    x: float
    y: float


class SpaceRow(Record):
    """A space that takes objects: a shelf, a drawer, a rack, a part of a worktop, a sink, a burner.

    Attributes:
        placement: name of the fixture.
        link: link of its asset.
        region: region of its asset.
        kinds: kinds of spaces of registry/habits.yaml that it is.
        moves: it moves with a door or drawer.
        shape: of its floor.
        size: width, depth, height, metres.
        pose: where it is.
        bounds: lower and upper corner in the world, metres.
        largest_box: what fits into it.
        things: how many cubes of 10 cm stand on what is free.
        objects: categories that people put there.
    """

    placement: str
    link: str
    region: str
    kinds: tuple[str, ...]
    moves: bool
    shape: Literal["box", "cylinder"]
    size: Vec3
    pose: SpacePoses
    bounds: tuple[Vec3, Vec3]
    largest_box: FreeBox
    things: Count
    objects: tuple[str, ...]


class TextureRow(Record):
    """A picture of a texture pack.

    Attributes:
        id: of its finish.
        licence, author, generator: as its pack states them, `unknown` where nothing was said.
    """

    id: str
    licence: str
    author: str
    generator: str


class CreditRow(Record):
    """Makers of an asset of a library that stands in the kitchen, as its provenance states them.

    Attributes:
        asset: id of the asset.
        title: of the work, or the name of its file.
        licence: SPDX id, or `unknown`.
        author: empty where nobody stated one.
        uri: address of its source; empty as well.
        generator: program that made it; empty as well.
        sha256: of its source.
    """

    asset: str
    title: str
    licence: str
    author: str
    uri: str
    generator: str
    sha256: Sha256


class CameraRow(PoseRow):
    """A camera; it looks along -z of its frame, y is up.

    Attributes:
        name: in scene.xml.
        fov_y_deg: vertical field of view, degrees.
    """

    name: str
    fov_y_deg: Annotated[float, Field(gt=0, lt=180)]


class ParkingRow(Record):
    """Where the middle of a robot's base stands.

    Attributes:
        x: metres.
        y: metres.
        yaw: direction that the robot looks to, radians from the x axis to the left.
        side: side of the fixture that it stands at.
    """

    x: float
    y: float
    yaw: float
    side: ParkingSide


class ParkingRows(Record):
    """Parking places of a fixture; null where the base does not get to.

    Attributes:
        shut: with all doors closed.
        open: joint -> with that one open.
    """

    shut: ParkingRow | None
    open: dict[str, ParkingRow | None]


class TaskRow(Record):
    """Whether a kitchen affords a task of RoboCasa.

    Attributes:
        afforded: it does.
        wants: what is missing, where it does not.
        fixtures: with which it can be done.
        joints: of v0.2: that it moves.
        sites: of v0.2.
        regions: of v0.2.
        counter_m2: of v0.2: free worktop beside the fixtures, m^2.
        floor_m2: of v0.2: floor around the parking places that the base gets to, m^2.
        rate: of v0.2: share of drawn boxes for which a place was found; null where nothing is put.
    """

    afforded: bool
    wants: str = ""
    fixtures: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    sites: tuple[str, ...] = ()
    regions: tuple[str, ...] = ()
    counter_m2: Length = 0.0
    floor_m2: Length = 0.0
    rate: Annotated[float, Field(ge=0, le=1)] | None = None


class SceneFile(Record):
    """scene.json: what stands where in a kitchen. Metres, radians, quaternions (w, x, y, z), z up, frame of the world.

    Attributes:
        format: number of this format.
        id: of the scene.
        plan: floor plan.
        style: style.
        seed: that drew the lengths; null where they are those of the plan.
        parameters: lengths of the plan, metres.
        surfaces: surface -> its main texture.
        covers: surface -> all finishes that cover it.
        models: role -> model in place of the style's, `family/preset` or `library:<id>`; left out where there are none.
        textures: pictures of texture packs that it shows, and their makers; left out where there are none.
        credits: makers of the assets of libraries in it; left out where there are none.
        generator: what wrote the file.
        room: walls and openings.
        fixtures: all that is part of the kitchen.
        objects: what was put into it; left out where nothing was.
        spawn: spaces that take objects.
        cameras: in scene.xml.
        base_radius: of the robot that the parking places are for, metres.
        parking: fixture -> parking places before it.
        tasks: the 25 atomic tasks of RoboCasa v0.2.
        robocasa_v1: the 65 atomic tasks of RoboCasa v1.0.
        key: digest of all that decides the files of the scene.
        picture_key: digest of all that decides its pictures; left out where there are none.
    """

    format: Literal[1]
    id: str
    plan: str
    style: str
    seed: int | None
    parameters: dict[str, float]
    surfaces: dict[Surface, str]
    covers: dict[Surface, tuple[str, ...]]
    models: dict[str, str] = Field(default_factory=dict)
    textures: tuple[TextureRow, ...] = ()
    credits: tuple[CreditRow, ...] = ()
    generator: str
    room: RoomRow
    fixtures: tuple[FixtureRow, ...]
    objects: tuple[ObjectRow, ...] = ()
    spawn: tuple[SpaceRow, ...]
    cameras: tuple[CameraRow, ...]
    base_radius: Annotated[float, Field(gt=0)]
    parking: dict[str, ParkingRows]
    tasks: dict[str, TaskRow]
    robocasa_v1: dict[str, TaskRow]
    key: Sha256 | None = None
    picture_key: Sha256 | None = None
