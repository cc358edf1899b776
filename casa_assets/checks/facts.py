"""The table of facts that MJCF and USD are both reduced to. Equal tables are what parity means."""

from __future__ import annotations

from casa_assets.model.asset import Base, JointKind
from casa_assets.model.record import Record, Vec2, Vec3, Vec4


class JointFacts(Record):
    """How a body moves against its parent; axis and anchor in the body frame, range in rad or m."""

    name: str
    kind: JointKind
    axis: Vec3
    anchor: Vec3
    range: Vec2


class BodyFacts(Record):
    """One body.

    Attributes:
        name: as in the asset; `object` for the root.
        parent: name, or empty for the root.
        position, quaternion: world_from_body with every joint at zero and the root at the origin.
        mass: kg. center_of_mass: metres, body frame.
        inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass, body axes, kg*m^2.
        colliders: how many collision geoms.
        lower, upper: corners of all collision geoms, body frame, metres; zero where there are none.
        frictions: distinct (sliding, torsional, rolling) of its colliders, sorted.
        joint: None where it is the root or rigidly attached.
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


class Facts(Record):
    """What one format says about an asset.

    Attributes:
        base: free or fixed to the world.
        bodies: sorted by name.
        exclusions: (first, second) names, each pair sorted, pairs sorted.
        classes: semantic labels from the category upwards.
    """

    base: Base
    bodies: tuple[BodyFacts, ...]
    exclusions: tuple[tuple[str, str], ...]
    classes: tuple[str, ...]
