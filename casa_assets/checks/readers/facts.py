"""Table of facts that the files of an asset are reduced to, the table of the asset itself, and their comparison."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator

from casa_assets.checks.check import Measurement, Problem
from casa_assets.core.numeric import Floats, about_axis
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import (
    Asset,
    Base,
    Collider,
    Drive,
    Joint,
    JointKind,
    Link,
    Region,
    Site,
    Visual,
)
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record, Vec2, Vec3, Vec4

# Facts ----------------------------------------------------------------------------------------------------------------
# Equal tables mean parity. Cells are compared in the order of the fields.

# The outer volume that MJCF holds also of an asset that names none: the bounds of colliders that are compared anyway.
OUTER = "bbox"
# The pose that every asset with named poses has, said or not: all joints at zero.
CLOSED = "closed"


# A table sorts its rows, records by name.
Sorted = BeforeValidator(lambda rows: tuple(sorted(rows, key=lambda row: getattr(row, "name", row))))
Pairs = Annotated[tuple[tuple[str, str], ...], Sorted]


class JointFacts(Record):
    """Joint of a body to its parent; axis and anchor in the body frame, range in rad or m.

    Attributes:
        resistance: stiffness (N*m/rad or N/m), where that spring rests (rad or m), damping, frictionloss, armature.
    """

    name: str
    kind: JointKind
    axis: Vec3
    anchor: Vec3
    range: Vec2
    resistance: tuple[float, float, float, float, float]


class BodyFacts(Record):
    """One body, called as in the asset: `object` is the root.

    Attributes:
        parent: name, or empty for the root.
        colliders: number of collision geoms.
        position, quaternion: world_from_body with every joint at zero and the root at the origin.
        center_of_mass: metres, body frame.
        lower, upper: corners of all collision geoms, body frame, metres; zero if the body has no collision geoms.
        mass: kg.
        inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass, body axes, kg*m^2.
        frictions: distinct (sliding, torsional, rolling) of its colliders.
        joint: None if it is the root or rigidly attached.
    """

    name: str
    parent: str
    colliders: int
    position: Vec3
    center_of_mass: Vec3
    lower: Vec3
    upper: Vec3
    quaternion: Vec4
    mass: float
    inertia: tuple[float, float, float, float, float, float]
    frictions: Annotated[tuple[Vec3, ...], Sorted]
    joint: JointFacts | None = None


class PlaceFacts(Record):
    """A site or a region; all but one that is called `bbox`.

    Attributes:
        position, quaternion: body_from_place.
        size: full size in metres; the diameter three times of a sphere, (diameter, diameter, height) of a cylinder.
        color: linear RGBA of a site, None of a region.
    """

    name: str
    body: str
    kind: Literal["sphere", "box", "cylinder"]
    position: Vec3
    quaternion: Vec4
    size: Vec3
    color: Vec4 | None


class VisualFacts(Record):
    """Appearance of a visual, as far as both formats hold it alike.

    Attributes:
        color: linear RGBA, by which its picture is multiplied where it has one.
        light: linear RGB that it gives off by itself, times its picture.
        picture: file name, empty where it has none.
    """

    name: str
    color: Vec4
    light: Vec3
    picture: str


class PoseFacts(Record):
    """A named pose: root_from_body, in a scene world_from_body, of each body, sorted by the names of the bodies."""

    name: str
    bodies: tuple[str, ...]
    positions: tuple[Vec3, ...]
    quaternions: tuple[Vec4, ...]


class StateFacts(Record):
    """A named interval of a joint, as fractions of its way from closed to open."""

    name: str
    joint: str
    value: str
    interval: Vec2


class ProgramTexts(Record):
    """Texts of a file for programs that read names.

    Attributes:
        classes: semantic labels from the category upwards.
        portion: remaining portion of a thing that was cut, or empty.
        labels: (visual or collider, label of the part).
        grips: (joint, collider that a hand takes).
        behind: (joint, joint that has to be open).
        contract: id, empty if there is no contract.
        behavior: sha256 of the state machine's canonical JSON, empty if there is no state machine.
    """

    classes: tuple[str, ...] = ()
    portion: str = ""
    labels: Pairs = ()
    grips: Pairs = ()
    behind: Pairs = ()
    contract: str = ""
    behavior: str = ""
    states: Annotated[tuple[StateFacts, ...], Sorted] = ()


class AssetFacts(Record):
    """Facts that one format states about an asset.

    Attributes:
        base: free or fixed to the world.
        exclusions: names of two bodies, sorted.
        poses: `closed` is among them if there are any.
    """

    base: Base
    exclusions: Annotated[Pairs, BeforeValidator(lambda pairs: {(min(pair), max(pair)) for pair in pairs})]
    words: ProgramTexts
    bodies: Annotated[tuple[BodyFacts, ...], Sorted]
    places: Annotated[tuple[PlaceFacts, ...], Sorted] = ()
    looks: Annotated[tuple[VisualFacts, ...], Sorted] = ()
    poses: Annotated[tuple[PoseFacts, ...], Sorted] = ()


# Numbers and names ----------------------------------------------------------------------------------------------------
# What readers of every format share. A kitchen has some thousand bodies and shapes, and a record of each costs more
# time than all that is computed of it: rotations are made many at once, with the same digits as `Pose` has of one.

# The prim that holds the placements of a scene (no asset is called so), and the root link of an asset.
WORLD, ROOT_BODY = "World", "object"
# As `Pose` has it: unit quaternions are left alone.
OFF_UNIT = 1e-12
# Position and quaternion (w, x, y, z).
Frame = tuple[Sequence[float], Sequence[float]]


def short_name(name: str) -> str:
    """`/mug_0123456789/object` -> `object`: names that come from USD are prim paths.

    In a scene they are called as in MJCF: `/World/cup/object` -> `cup`, `/World/cup/object/sites/fill` -> `cup__fill`.
    """
    parts = name.split("/")
    if len(parts) < 4 or parts[1] != WORLD:
        return parts[-1]
    return parts[2] if parts[3:] == [ROOT_BODY] else f"{parts[2]}__{parts[-1]}"


def own_name(name: str) -> str:
    """`cup__fill` -> `fill`: a name within its placement."""
    return name.rsplit("__", 1)[-1]


def three(values: Sequence[float] | Floats) -> Vec3:
    """Three numbers as floats of Python."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def four(values: Sequence[float] | Floats) -> Vec4:
    """Four numbers as floats of Python."""
    w, x, y, z = (float(v) for v in values)
    return w, x, y, z


def tensor_entries(tensor: Floats) -> tuple[float, float, float, float, float, float]:
    """(xx, yy, zz, xy, xz, yz) of a symmetric (3, 3) tensor."""
    xx, yy, zz, xy, xz, yz = (float(tensor[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return xx, yy, zz, xy, xz, yz


def bounds_around(boxes: Sequence[Floats]) -> tuple[Vec3, Vec3]:
    """Lower and upper corner of the box around (2, 3) boxes; zeros if there are no boxes."""
    if not boxes:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return three(np.min([box[0] for box in boxes], axis=0)), three(np.max([box[1] for box in boxes], axis=0))


def canonical(quaternions: Floats) -> Floats:
    """(N, 4) quaternions (w, x, y, z) of length 1, w >= 0; where w is 0 the first that is not 0 is positive."""
    found = np.array(quaternions, dtype=np.float64).reshape(-1, 4)
    for row in np.flatnonzero(np.abs(np.linalg.norm(found, axis=1) - 1.0) > OFF_UNIT):
        found[row] /= np.linalg.norm(found[row])
    first = found[np.arange(len(found)), np.argmax(found != 0.0, axis=1)]
    found[first < 0.0] *= -1.0
    unsigned: Floats = found + 0.0  # turns -0.0 into 0.0
    return unsigned


def rotations_of(quaternions: Floats) -> Floats:
    """(N, 3, 3) rotation matrices of (N, 4) quaternions (w, x, y, z)."""
    w, x, y, z = canonical(quaternions).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    found: Floats = np.moveaxis(np.array(rows), 2, 0)
    return np.ascontiguousarray(found)


def quaternions_of(rotations: Floats) -> Floats:
    """(N, 4) quaternions (w, x, y, z) of (N, 3, 3) rotation matrices, w >= 0. Raises ValueError: one is no rotation."""
    r = rotations
    skew = np.abs(r @ r.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if skew > 1e-6 or (np.linalg.det(r) < 0).any():
        raise ValueError("matrix is not a proper rotation")
    # Ref: Shepperd 1978, the branch with the largest divisor.
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    branch = np.argmax(np.stack([trace, r[:, 0, 0], r[:, 1, 1], r[:, 2, 2]], axis=1), axis=1)
    v = np.stack([1 + trace, r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    for i in (1, 2, 3):
        at = np.flatnonzero(branch == i)
        a, b, c = i - 1, i % 3, (i + 1) % 3
        m = r[at]
        v[at, 0] = m[:, c, b] - m[:, b, c]
        v[at, 1 + a] = 1 + m[:, a, a] - m[:, b, b] - m[:, c, c]
        v[at, 1 + b] = m[:, b, a] + m[:, a, b]
        v[at, 1 + c] = m[:, c, a] + m[:, a, c]
    # Of each row by itself: a sum over an axis may differ from it in the last digit.
    lengths = np.array([np.linalg.norm(row) for row in v]).reshape(-1, 1)
    return canonical(v / lengths)


def frames_of(poses: Mapping[str, Pose]) -> dict[str, Frame]:
    """Position and quaternion of each pose."""
    return {name: (pose.position, pose.quaternion) for name, pose in poses.items()}


def pose_facts(name: str, frames: Mapping[str, Frame], root: str | None = None) -> PoseFacts:
    """Facts of a named pose.

    Args:
        frames: by names of bodies, as `Pose` has them. root: the body in whose frame they are returned; None: as given.
    """
    if root is not None:
        poses = {body: Pose(position=at, quaternion=turn) for body, (at, turn) in frames.items()}
        root_from_world = poses[root].inverse()
        frames = frames_of({body: root_from_world @ pose for body, pose in poses.items()})
    bodies = sorted(frames)
    positions, quaternions = ([frames[body][i] for body in bodies] for i in (0, 1))
    return PoseFacts(name=name, bodies=bodies, positions=positions, quaternions=quaternions)


# Asset ----------------------------------------------------------------------------------------------------------------


def asset_facts(asset: Asset) -> AssetFacts:
    """The table of an asset: joints at zero, root at the origin."""
    named = {CLOSED: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    return AssetFacts(
        base=asset.base,
        exclusions=[(pair.first, pair.second) for pair in asset.exclusions],
        words=_words(asset),
        bodies=[_body(asset, link) for link in asset.links],
        places=[place for place in (*map(_place, asset.sites), *map(_place, asset.regions)) if place.name != OUTER],
        looks=_looks(asset),
        poses=[pose_facts(name, _frames(asset, named[name])) for name in named] if asset.keyframes else (),
    )


def _body(asset: Asset, link: Link) -> BodyFacts:
    pose = asset.root.pose.inverse() @ asset.asset_from_link(link.name)
    bounds = link_bounds(link)
    lower, upper = bounds_around([] if bounds is None else [bounds])
    matters = [asset.substance(collider.substance) for collider in link.colliders]
    return BodyFacts(
        name=link.name,
        parent=link.parent or "",
        colliders=len(link.colliders),
        position=pose.position,
        center_of_mass=link.inertial.center_of_mass,
        lower=lower,
        upper=upper,
        quaternion=pose.quaternion,
        mass=link.inertial.mass,
        inertia=link.inertial.inertia,
        # MuJoCo has one coefficient for sliding, that of motion.
        frictions={(m.dynamic_friction, m.torsional_friction, m.rolling_friction) for m in matters},
        joint=_joint(asset.joint_of(link.name)),
    )


def _joint(joint: Joint | None) -> JointFacts | None:
    if joint is None:
        return None
    drive = joint.drive or Drive(stiffness=0.0, damping=0.0)
    return JointFacts(
        name=joint.name,
        kind=joint.kind,
        axis=joint.axis,
        anchor=joint.anchor,
        range=joint.range,
        resistance=(drive.stiffness, drive.target, joint.damping + drive.damping, joint.frictionloss, joint.armature),
    )


def _place(item: Site | Region) -> PlaceFacts:
    # A cylinder is as wide as its size along x.
    x, y, z = item.size if item.size is not None else (2 * item.radius,) * 3 if isinstance(item, Site) else (0.0,) * 3
    return PlaceFacts(
        name=item.name,
        body=item.link,
        kind=item.kind,
        position=item.pose.position,
        quaternion=item.pose.quaternion,
        size=(x, x, z) if item.kind == "cylinder" else (x, y, z),
        color=item.color if isinstance(item, Site) else None,
    )


def _looks(asset: Asset) -> list[VisualFacts]:
    by_id = {material.id: material for material in asset.materials}
    found = []
    for visual in (v for link in asset.links for v in link.visuals):
        material = by_id[visual.material]
        light = tuple(material.glow * channel for channel in material.base_color[:3])
        file = material.base_color_texture.file_name if material.base_color_texture is not None else ""
        found.append(VisualFacts(name=visual.name, color=material.base_color, light=light, picture=file))
    return found


def _frames(asset: Asset, values: dict[str, float]) -> dict[str, Frame]:
    """Forward kinematics, parents before children, by other formulas than those that the writers use."""
    root_from: dict[str, Pose] = {}
    for link in asset.links:
        if link.parent is None:
            root_from[link.name] = Pose()
            continue
        joint = asset.joint_of(link.name)
        moved = Pose() if joint is None else _joint_pose(joint, values.get(joint.name, 0.0))
        root_from[link.name] = root_from[link.parent] @ link.pose @ moved
    return frames_of(root_from)


def _joint_pose(joint: Joint, value: float) -> Pose:
    """Pose of the child in its own frame at zero. Ref: p - R p for a turn about the point p."""
    axis, anchor = np.array(joint.axis), np.array(joint.anchor)
    if joint.kind is JointKind.SLIDE:
        return Pose(position=three(axis * value))
    matrix = np.eye(4)
    matrix[:3, :3] = about_axis(axis, value)
    matrix[:3, 3] = anchor - matrix[:3, :3] @ anchor
    return Pose.from_matrix(matrix)


def _words(asset: Asset) -> ProgramTexts:
    shapes: list[Collider | Visual] = []
    for link in asset.links:
        shapes += (*link.visuals, *link.colliders)
    return ProgramTexts(
        classes=asset.labels.classes,
        portion=asset.labels.portion or "",
        labels=[(shape.name, shape.label) for shape in shapes if shape.label is not None],
        grips=[(joint.name, joint.grip) for joint in asset.joints if joint.grip is not None],
        behind=[(joint.name, joint.behind) for joint in asset.joints if joint.behind is not None],
        contract=asset.contract or "",
        behavior=asset.behavior.digest if asset.behavior is not None else "",
        states=[StateFacts(name=s.name, joint=s.joint, value=s.value, interval=s.interval) for s in asset.states],
    )


# Comparison -----------------------------------------------------------------------------------------------------------

# Cells in metres; a range is one where the joint slides.
LENGTHS = frozenset({"position", "center_of_mass", "lower", "upper", "anchor", "size"})
# Tables whose cells are named as if they were those of the table that holds them.
INNER = ("words", "things")


class Difference(NamedTuple):
    """One cell of two tables.

    Attributes:
        size: by how much it differs; None if it is not a number. is_length: its size is in metres.
    """

    pointer: str
    size: float | None
    expected: object
    actual: object
    is_length: bool = False

    @property
    def problem(self) -> Problem:
        """Pointer and message; made only for differences that are reported, since nearly all cells agree."""
        return self.pointer, f"is {_formatted(self.actual)}, should be {_formatted(self.expected)}"

    def exceeds(self, tolerance: float) -> bool:
        """True if the cell differs by more than the tolerance, or is no number and differs."""
        return self.size is None or not self.size <= tolerance


def measured(cells: Iterable[Difference], tolerance: float) -> Measurement:
    """The largest of some differences, and a problem for each that exceeds the tolerance."""
    rows = list(cells)
    worst = max((r.size for r in rows if r.size is not None), default=0.0)
    return Measurement(worst, tuple(dict.fromkeys(r.problem for r in rows if r.exceeds(tolerance))))


def differences(expected: Record, actual: Record, at: str = "") -> Iterator[Difference]:
    """Every cell of two tables of one type, row by row; cells that are no numbers only where they differ.

    Args:
        at: begins all pointers; ends in a slash.
    """
    if isinstance(expected, PoseFacts) and isinstance(actual, PoseFacts):
        yield from _pose(at, expected, actual)
        return
    for name in type(expected).model_fields:
        one, other, pointer = getattr(expected, name), getattr(actual, name), f"{at}{name}"
        if isinstance(one, Record) and isinstance(other, Record):
            yield from differences(one, other, at if name in INNER else f"{pointer}/")
        elif isinstance(one, Record) or isinstance(other, Record):
            yield Difference(pointer, None, one and one.name, other and other.name)
        elif any(isinstance(rows, tuple) and rows and isinstance(rows[0], Record) for rows in (one, other)):
            by_name = {row.name: row for row in other}
            yield from text(pointer, sorted(row.name for row in one), sorted(by_name))
            for row in one:
                if row.name in by_name:
                    yield from differences(row, by_name[row.name], f"{pointer}/{row.name}/")
        elif np.shape(one) != np.shape(other) or np.asarray(one).dtype.kind != "f":
            yield from text(pointer, one, other)
        else:
            yield _numbers(pointer, name, one, other, expected)


def _pose(at: str, expected: PoseFacts, actual: PoseFacts) -> Iterator[Difference]:
    if expected.bodies != actual.bodies:
        yield from text(f"{at}bodies", expected.bodies, actual.bodies)
        return
    for i, body in enumerate(expected.bodies):
        yield _numbers(f"{at}{body}/position", "position", expected.positions[i], actual.positions[i])
        yield _numbers(f"{at}{body}/quaternion", "quaternion", expected.quaternions[i], actual.quaternions[i])


def text(at: str, expected: object, actual: object) -> Iterator[Difference]:
    """A cell that is no number, where it differs."""
    if expected != actual:
        yield Difference(at, None, expected, actual)


def _numbers(at: str, name: str, expected: Any, actual: Any, row: Record | None = None) -> Difference:
    """A cell of numbers: the largest difference; of mass and inertia over those of the whole body.

    Args:
        name: of the field. row: that has the expected numbers.
    """
    a, b = np.ravel(np.asarray(expected, dtype=np.float64)), np.ravel(np.asarray(actual, dtype=np.float64))
    if name == "resistance":
        return relative(at, a, b)
    if name == "quaternion" and float(a @ b) < 0:
        b = -b  # q and -q are one rotation; which of them is canonical can flip where w is near zero
    scale = expected if name == "mass" else sum(expected[:3]) if name == "inertia" else 1.0
    slides = name == "range" and isinstance(row, JointFacts) and row.kind is JointKind.SLIDE
    size = float(np.abs(a - b).max(initial=0.0)) / scale
    return Difference(at, size, a, b, name in LENGTHS or slides)


def relative(at: str, expected: np.ndarray, actual: np.ndarray) -> Difference:
    """A cell of numbers: the largest difference, each relative to the larger of its two numbers."""
    if expected.shape != actual.shape:
        return Difference(at, None, expected, actual)
    scale = np.maximum(np.maximum(np.abs(expected), np.abs(actual)), 1e-12)
    return Difference(at, float((np.abs(expected - actual) / scale).max(initial=0.0)), expected, actual)


def _formatted(values: object) -> str:
    """Text of a cell's value; rows of a table of numbers are separated by semicolons."""
    if not isinstance(values, np.ndarray):
        return str(values)
    return "; ".join(" ".join(f"{v:.6g}" for v in row) for row in np.atleast_2d(values))
