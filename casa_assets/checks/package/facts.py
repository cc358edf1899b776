"""Table of facts that the files of an asset are reduced to, and the comparison of two tables cell by cell."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator

from casa_assets.checks.check import Measurement, Problem
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.record import Record, Vec2, Vec3, Vec4

# Facts ----------------------------------------------------------------------------------------------------------------
# Equal tables mean parity. Cells are compared in the order of the fields.

# The outer volume that MJCF holds also of an asset that names none: the bounds of colliders that are compared anyway.
OUTER = "bbox"
# The pose that every asset with named poses has, said or not: all joints at zero.
CLOSED = "closed"


def _sorted(rows: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(sorted(rows, key=lambda row: getattr(row, "name", row)))


# A table sorts its rows, records by name.
Sorted = BeforeValidator(_sorted)
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


# Comparison -----------------------------------------------------------------------------------------------------------

# Cells in metres; a range is one where the joint slides.
LENGTHS = frozenset({"position", "center_of_mass", "lower", "upper", "anchor", "size"})
# Tables whose cells are named as if they were those of the table that holds them.
INNER = ("words", "things")


class Difference(NamedTuple):
    """One cell of two tables.

    Attributes:
        size: by how much it differs; None if it is not a number.
        is_length: its size is in metres.
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


def agree(expected: AssetFacts, actual: AssetFacts, tolerance: float) -> Measurement:
    """The largest difference, and a problem for each that exceeds the tolerance."""
    return measured(differences(expected, actual), tolerance)


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
            yield from _rows(pointer, one, other)
        elif np.shape(one) != np.shape(other) or np.asarray(one).dtype.kind != "f":
            yield from text(pointer, one, other)
        else:
            yield _numbers(pointer, name, one, other, expected)


def _rows(at: str, expected: Sequence[Any], actual: Sequence[Any]) -> Iterator[Difference]:
    """The names of the rows of a table, then the cells of those that both have."""
    by_name = {row.name: row for row in actual}
    yield from text(at, sorted(row.name for row in expected), sorted(by_name))
    for row in expected:
        if row.name in by_name:
            yield from differences(row, by_name[row.name], f"{at}/{row.name}/")


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
