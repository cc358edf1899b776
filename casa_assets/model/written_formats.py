"""JSON files that other programs read: behavior.json, batch.json and scene.json."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.asset.parts import JointKind, Keyframe, State
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.floor import ParkingSide
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import EngineSizes, Layer
from casa_assets.model.record import Record, Sha256, Vec2, Vec3, Vec4


class BehaviorFile(Record):
    """behavior.json: how a fixture reacts to hands, as data. Radians, metres, seconds.

    Attributes:
        behavior: state machine. states: named intervals of joints. keyframes: named poses.
    """

    behavior: Behavior
    states: tuple[State, ...]
    keyframes: tuple[Keyframe, ...]


class BatchFile(Record):
    """batch.json, about scene_batch.xml. Names of joints and placements are those of scene.xml.

    Attributes:
        id: of the scene. key: of the file; it changes if the scene, the options or the code that makes it change.
        joints: joints that move in it.
        locked: joints of the scene that are not in it; the parts that they move stay as the scene begins.
        filled: placements that are solid in it: objects that nothing can be put into, and doors without open bins.
        colliders: primitives that can collide. pairs: pairs of colliders that an engine has to check in every step.
        freedoms: degrees of freedom of all joints.
        engine: sizes that an engine has to allocate for one world, and the measurements that they are based on.
        report: of the checks BAT001 to BAT010.
    """

    id: str
    key: Sha256
    joints: tuple[str, ...]
    locked: tuple[str, ...]
    filled: tuple[str, ...]
    colliders: int
    pairs: int
    freedoms: int
    engine: EngineSizes
    report: Report


Count = Annotated[int, Field(ge=0)]
Length = Annotated[float, Field(ge=0)]


class PoseRow(Record):
    """Pose of a frame in another frame.

    Attributes:
        position: metres. quaternion: (w, x, y, z), unit length.
    """

    position: Vec3
    quaternion: Vec4


class WallRow(Record):
    """A wall, as a line on the floor; the room is to the right of the direction from `from` to `to`.

    Attributes:
        id: name in the plan. open: the plan leaves it open, so that nothing is drawn. start: left end, metres.
        end: right end, metres.
    """

    id: str
    open: bool
    start: Vec3 = Field(alias="from")
    end: Vec3 = Field(alias="to")


class OpeningRow(Record):
    """A door, a window, a passage or a niche in a wall.

    Attributes:
        id: name in the plan. kind: kind of opening.
        wall: id of its wall; for a window in the back of a niche, the wall of the niche.
        start: lower left corner, metres. end: upper right corner, metres.
        closet: whether it leads to a closet, and not outside.
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
        outline: corners of the floor, metres. bounds: lower and upper corner of the room, metres.
        walls: in the order of the plan. openings: doors, windows, passages and niches.
    """

    outline: tuple[Vec2, ...]
    bounds: tuple[Vec3, Vec3]
    walls: tuple[WallRow, ...]
    openings: tuple[OpeningRow, ...]


class JointRow(Record):
    """A joint of a fixture.

    Attributes:
        name: name of the joint in scene.xml, `<fixture>__<joint>`. kind: hinge or slide.
        range: lower and upper end, radians or metres; zero is closed.
        grip: collision shape that a hand takes hold of, or null if it has no grip.
        behind: name in scene.xml of the joint that has to be open before this one can move, or null.
    """

    name: str
    kind: JointKind
    range: Vec2
    grip: str | None
    behind: str | None


class RegionRow(PoseRow):
    """A named volume, in the world frame, with all joints at zero.

    Attributes:
        link: link of the asset that it moves with. kind: box or cylinder.
        size: width, depth, height, metres; for a cylinder the first two are its diameter.
    """

    link: str
    kind: str
    size: Vec3


class SiteRow(Record):
    """A named point.

    Attributes:
        site: its name in scene.xml. kind: its purpose.
    """

    site: str
    kind: str


class FixtureRow(PoseRow):
    """An object that is part of the kitchen: a cabinet, an appliance, a worktop, a wall; its pose is that of its frame.

    Attributes:
        name: name of its body in scene.xml. role: purpose in this kitchen, such as `sink` or `counter`.
        unit: unit of the plan that it comes from. run: row of units that it belongs to.
        layer: `things`, `room` (walls, floor) or `ceiling`. asset: id of the asset. family: family that builds it.
        preset: preset of that family. category: row of registry/categories.yaml.
        contract: file of registry/contracts/ that it meets, or null if it meets no contract. base: `fixed` or `free`.
        mass_kg: kilograms. joints: name in the asset -> joint. states: `<joint>.<state>` that its joints can be in.
        regions: name in the asset -> region. sites: name in the asset -> site. parts: labels of its parts.
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
    """Support of an object.

    Attributes:
        placement: name of the fixture. link: link of its asset. region: region of its asset.
    """

    placement: str
    link: str
    region: str


class ObjectRow(PoseRow):
    """An object that was put into a kitchen to make it look lived in.

    Attributes:
        name: name of its body in scene.xml. asset: id of the asset. category: row of registry/categories.yaml.
        mass_kg: kilograms. holder: its support.
    """

    name: str
    asset: str
    category: str
    mass_kg: Length
    holder: HolderRow = Field(alias="in")


class SpacePoses(Record):
    """Poses of the middle of the floor of a space; x along the front, y to the back.

    Attributes:
        world: in the frame of the kitchen. fixture: in the frame of the fixture, joints at zero.
    """

    world: PoseRow
    fixture: PoseRow


class FreeBox(Record):
    """The largest free box in a space.

    Attributes:
        size: width, depth, height, metres. x: position of the middle of its floor, in the frame of the space, metres.
        y: the same.
    """

    size: Vec3
    x: float
    y: float


class SpaceRow(Record):
    """A space that takes objects: a shelf, a drawer, a rack, a part of a worktop, a sink, a burner.

    Attributes:
        placement: name of the fixture. link: link of its asset. region: region of its asset.
        kinds: kinds of spaces of registry/habits.yaml that it belongs to. moves: it moves with a door or drawer.
        shape: shape of its floor. size: width, depth, height, metres. pose: its pose.
        bounds: lower and upper corner in the world, metres. largest_box: largest box that fits into it.
        things: number of 10 cm cubes that fit on the free floor. objects: categories that people put there.
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
        id: id of its finish. licence, author, generator: as its pack states them, `unknown` if not stated.
    """

    id: str
    licence: str
    author: str
    generator: str


class CreditRow(Record):
    """Makers of an asset of a library that is used in the kitchen, as its provenance states them.

    Attributes:
        asset: id of the asset. title: title of the work, or the name of its file. licence: SPDX id, or `unknown`.
        author: empty if not stated. uri: address of its source; empty if not stated.
        generator: program that made it; empty if not stated.
        sha256: digest of its source.
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
        name: name in scene.xml. fov_y_deg: vertical field of view, degrees.
    """

    name: str
    fov_y_deg: Annotated[float, Field(gt=0, lt=180)]


class ParkingRow(Record):
    """Position of the middle of a robot's base.

    Attributes:
        x: metres. y: metres. yaw: direction in which the robot looks, radians from the x axis to the left.
        side: side of the fixture at which it is parked.
    """

    x: float
    y: float
    yaw: float
    side: ParkingSide


class ParkingRows(Record):
    """Parking places of a fixture; null if the base cannot get there.

    Attributes:
        shut: with all doors closed. open: joint -> with that one open.
    """

    shut: ParkingRow | None
    open: dict[str, ParkingRow | None]


class TaskRow(Record):
    """Whether a kitchen affords a task of RoboCasa.

    Attributes:
        afforded: the task is possible. wants: missing part, if the task is not possible.
        fixtures: fixtures with which it can be done. joints: for v0.2, joints that it moves. sites: for v0.2.
        regions: for v0.2.
        counter_m2: for v0.2, free worktop next to the fixtures, m^2.
        floor_m2: for v0.2, floor around the parking places that the base can reach, m^2.
        rate: for v0.2, share of the sampled boxes for which a place was found; null if nothing is placed.
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
    """scene.json: the contents of a kitchen and their poses.

    Metres, radians, quaternions (w, x, y, z), z up, world frame.

    Attributes:
        format: number of this format. id: of the scene. plan: floor plan. style: style.
        seed: seed that drew the lengths; null if they are those of the plan. parameters: lengths of the plan, metres.
        surfaces: surface -> its main texture. covers: surface -> all finishes that cover it.
        models: role -> model that replaces the style's, `family/preset` or `library:<id>`; left out if empty.
        textures: pictures of texture packs that it shows, and their makers; left out if empty.
        credits: makers of the assets of libraries in it; left out if empty. generator: program that wrote the file.
        room: walls and openings. fixtures: all objects that are part of the kitchen.
        objects: objects that were put into it; left out if empty. spawn: spaces that take objects.
        cameras: cameras in scene.xml. base_radius: radius of the robot that the parking places are for, metres.
        parking: fixture -> parking places in front of it. tasks: the 25 atomic tasks of RoboCasa v0.2.
        robocasa_v1: the 65 atomic tasks of RoboCasa v1.0.
        key: digest of everything that determines the files of the scene.
        picture_key: digest of everything that determines its pictures; left out if it has no pictures.
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
