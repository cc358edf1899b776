"""Fact table that MJCF and USD are both reduced to; equal tables mean parity."""

from __future__ import annotations

from typing import Literal

from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.record import Record, Vec2, Vec3, Vec4

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
