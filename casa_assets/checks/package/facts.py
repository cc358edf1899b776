"""Fact table that MJCF and USD are both reduced to, and its comparison cell by cell."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Literal, NamedTuple, TypeVar

import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.record import Record, Vec2, Vec3, Vec4

# Facts ----------------------------------------------------------------------------------------------------------------
# Fact table that MJCF and USD are both reduced to; equal tables mean parity.

# The outer volume that MJCF holds also of an asset that names none: the bounds of colliders that are compared anyway.
OUTER = "bbox"
# The pose that every asset with named poses has, said or not: all joints at zero.
CLOSED = "closed"


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
    """One body.

    Attributes:
        name: as in the asset; `object` for the root.
        parent: name, or empty for the root.
        position, quaternion: world_from_body with every joint at zero and the root at the origin.
        mass: kg. center_of_mass: metres, body frame.
        inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass, body axes, kg*m^2.
        colliders: number of collision geoms.
        lower, upper: corners of all collision geoms, body frame, metres; zero if the body has no collision geoms.
        frictions: distinct (sliding, torsional, rolling) of its colliders, sorted.
        joint: None if it is the root or rigidly attached.
    """

    name: str
    parent: str
    position: Vec3
    quaternion: Vec4
    mass: float
    center_of_mass: Vec3
    inertia: tuple[float, float, float, float, float, float]
    colliders: int
    lower: Vec3
    upper: Vec3
    frictions: tuple[Vec3, ...]
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
    """Poses of the bodies in a named pose: root_from_body of each, sorted by name."""

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
        classes: semantic labels from the category upwards. portion: remaining portion of a thing that was cut, or
            empty.
        labels: (visual or collider, label of the part), sorted.
        grips: (joint, collider that a hand takes), sorted. behind: (joint, joint that has to be open), sorted.
        states: sorted by name.
        contract: id, empty if there is no contract.
        behavior: sha256 of the state machine's canonical JSON, empty if there is no state machine.
    """

    classes: tuple[str, ...]
    portion: str = ""
    labels: tuple[tuple[str, str], ...] = ()
    grips: tuple[tuple[str, str], ...] = ()
    behind: tuple[tuple[str, str], ...] = ()
    states: tuple[StateFacts, ...] = ()
    contract: str = ""
    behavior: str = ""


class AssetFacts(Record):
    """Facts that one format states about an asset.

    Attributes:
        base: free or fixed to the world.
        bodies: sorted by name.
        exclusions: (first, second) names, each pair sorted, pairs sorted.
        places, looks: sorted by name.
        poses: sorted by name; `closed` among them where there are any.
        words: classes, labels, states, behaviour.
    """

    base: Base
    bodies: tuple[BodyFacts, ...]
    exclusions: tuple[tuple[str, str], ...]
    places: tuple[PlaceFacts, ...] = ()
    looks: tuple[VisualFacts, ...] = ()
    poses: tuple[PoseFacts, ...] = ()
    words: ProgramTexts


# Fact differences -----------------------------------------------------------------------------------------------------
# Compare two fact tables cell by cell.

# Cells of a body that are no numbers.
TEXT_CELLS = ("parent", "colliders")
# Cells of a body in metres.
LENGTH_CELLS = ("position", "center_of_mass", "lower", "upper")
PROGRAM_TEXT_CELLS = ("classes", "portion", "labels", "grips", "behind", "contract", "behavior")
Row = TypeVar("Row", BodyFacts, PlaceFacts, VisualFacts, PoseFacts)


class Difference(NamedTuple):
    """One cell of two tables: its pointer, by how much it differs (None if it is not a number), and both values."""

    pointer: str
    size: float | None
    expected: object
    actual: object

    @property
    def message(self) -> str:
        """Message about the cell; made only for differences that are reported, since nearly all cells agree."""
        return f"is {_formatted(self.actual)}, should be {_formatted(self.expected)}"


def agree(expected: AssetFacts, actual: AssetFacts, tolerance: float) -> Measurement:
    """The largest difference, and a problem for each that exceeds the tolerance."""
    rows = list(differences(expected, actual))
    worst = max((r.size for r in rows if r.size is not None), default=0.0)
    problems = [(r.pointer, r.message) for r in rows if r.size is None or not r.size <= tolerance]
    return Measurement(worst, tuple(problems))


def differences(expected: AssetFacts, actual: AssetFacts) -> Iterator[Difference]:
    """Every cell, row by row; cells of text only where they differ."""
    for name in ("base", "exclusions"):
        yield from text(name, getattr(expected, name), getattr(actual, name))
    yield from texts(expected.words, actual.words)
    yield from _rows("bodies", expected.bodies, actual.bodies, _body)
    yield from _rows("places", expected.places, actual.places, _place)
    yield from _rows("looks", expected.looks, actual.looks, _look)
    yield from _rows("poses", expected.poses, actual.poses, _pose)


def _rows(
    table: str,
    expected: Sequence[Row],
    actual: Sequence[Row],
    compare: Callable[[str, Row, Row], Iterator[Difference]],
) -> Iterator[Difference]:
    """The names of the rows of a table, then the cells of those that both have."""
    by_name = {row.name: row for row in actual}
    yield from text(table, sorted(row.name for row in expected), sorted(by_name))
    for row in expected:
        if row.name in by_name:
            yield from compare(f"{table}/{row.name}", row, by_name[row.name])


def relative_difference(expected: np.ndarray, actual: np.ndarray) -> float:
    """The largest difference of two arrays of one shape, each relative to the larger of its two numbers."""
    scale = np.maximum(np.maximum(np.abs(expected), np.abs(actual)), 1e-12)
    return float((np.abs(expected - actual) / scale).max(initial=0.0))


def _body(at: str, expected: BodyFacts, actual: BodyFacts) -> Iterator[Difference]:
    for name in TEXT_CELLS:
        yield from text(f"{at}/{name}", getattr(expected, name), getattr(actual, name))
    for name in LENGTH_CELLS:
        yield numbers(f"{at}/{name}", getattr(expected, name), getattr(actual, name))
    yield quaternion(f"{at}/quaternion", expected.quaternion, actual.quaternion)
    yield numbers(f"{at}/mass", (expected.mass,), (actual.mass,), expected.mass)
    yield numbers(f"{at}/inertia", expected.inertia, actual.inertia, sum(expected.inertia[:3]))
    if len(expected.frictions) == len(actual.frictions):
        yield numbers(f"{at}/frictions", np.ravel(expected.frictions), np.ravel(actual.frictions))
    else:
        yield from text(f"{at}/frictions", expected.frictions, actual.frictions)
    yield from _joint(f"{at}/joint", expected.joint, actual.joint)


def _joint(at: str, expected: JointFacts | None, actual: JointFacts | None) -> Iterator[Difference]:
    if expected is None or actual is None:
        yield from text(at, expected and expected.name, actual and actual.name)
        return
    for name in ("name", "kind"):
        yield from text(f"{at}/{name}", getattr(expected, name), getattr(actual, name))
    for name in ("axis", "anchor", "range"):
        yield numbers(f"{at}/{name}", getattr(expected, name), getattr(actual, name))
    yield relative(f"{at}/resistance", np.array(expected.resistance), np.array(actual.resistance))


def _place(at: str, expected: PlaceFacts, actual: PlaceFacts) -> Iterator[Difference]:
    yield from text(f"{at}/body", expected.body, actual.body)
    yield from text(f"{at}/kind", expected.kind, actual.kind)
    yield numbers(f"{at}/position", expected.position, actual.position)
    yield quaternion(f"{at}/quaternion", expected.quaternion, actual.quaternion)
    yield numbers(f"{at}/size", expected.size, actual.size)
    if expected.color is None or actual.color is None:
        yield from text(f"{at}/color", expected.color, actual.color)
    else:
        yield numbers(f"{at}/color", expected.color, actual.color)


def _look(at: str, expected: VisualFacts, actual: VisualFacts) -> Iterator[Difference]:
    yield numbers(f"{at}/color", expected.color, actual.color)
    yield numbers(f"{at}/light", expected.light, actual.light)
    yield from text(f"{at}/picture", expected.picture, actual.picture)


def _pose(at: str, expected: PoseFacts, actual: PoseFacts) -> Iterator[Difference]:
    if expected.bodies != actual.bodies:
        yield from text(f"{at}/bodies", expected.bodies, actual.bodies)
        return
    for i, body in enumerate(expected.bodies):
        yield numbers(f"{at}/{body}/position", expected.positions[i], actual.positions[i])
        yield quaternion(f"{at}/{body}/quaternion", expected.quaternions[i], actual.quaternions[i])


def texts(expected: ProgramTexts, actual: ProgramTexts) -> Iterator[Difference]:
    """Differences of the texts that programs read."""
    for name in PROGRAM_TEXT_CELLS:
        yield from text(name, getattr(expected, name), getattr(actual, name))
    a, b = ([(s.name, s.joint, s.value) for s in table.states] for table in (expected, actual))
    yield from text("states", a, b)
    if a == b:
        for first, second in zip(expected.states, actual.states, strict=True):
            yield numbers(f"states/{first.name}/interval", first.interval, second.interval)


def text(at: str, expected: object, actual: object) -> Iterator[Difference]:
    """A cell that is no number, where it differs."""
    if expected != actual:
        yield Difference(at, None, expected, actual)


def quaternion(at: str, expected: object, actual: object) -> Difference:
    """A rotation. q and -q are one; which of them is canonical can flip where w is near zero."""
    a, b = np.asarray(expected, dtype=np.float64), np.asarray(actual, dtype=np.float64)
    return numbers(at, a, -b if float(a @ b) < 0 else b)


def numbers(at: str, expected: object, actual: object, scale: float = 1.0) -> Difference:
    """A cell of numbers: the largest difference, over `scale`."""
    a, b = np.asarray(expected, dtype=np.float64), np.asarray(actual, dtype=np.float64)
    size = float(np.abs(a - b).max(initial=0.0)) / scale
    return Difference(at, size, a, b)


def relative(at: str, expected: np.ndarray, actual: np.ndarray) -> Difference:
    """A cell of numbers: the largest difference, each relative to the larger of its two numbers."""
    size = relative_difference(expected, actual) if expected.shape == actual.shape else None
    return Difference(at, size, expected, actual)


def _formatted(values: object) -> str:
    """Text of a cell's value; rows of a table of numbers are separated by semicolons."""
    if not isinstance(values, np.ndarray):
        return str(values)
    return "; ".join(" ".join(f"{v:.6g}" for v in row) for row in np.atleast_2d(values))
