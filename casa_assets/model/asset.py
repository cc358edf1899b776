"""One simulation-ready thing: links, joints, sites, regions, states, labels, provenance.

A rigid apple is an Asset with one link; a microwave is an Asset with joints. There is no subclass.
Frame of an asset: z up, x right, y back (a fixture faces -y), origin at the centre of its footprint on the ground.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, field_validator, model_validator

from casa_assets.model.material import Material, Positive, Substance
from casa_assets.model.mesh import Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.provenance import Labels, Provenance
from casa_assets.model.record import Id, Record, Vec2, Vec3
from casa_assets.model.shape import Shape

NotNegative = Annotated[float, Field(ge=0.0)]


class Inertial(Record):
    """Mass properties of a link.

    Attributes:
        mass: kg, > 0.
        center_of_mass: metres, link frame.
        inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass, link axes, kg*m^2.
    """

    mass: Positive
    center_of_mass: Vec3
    inertia: tuple[float, float, float, float, float, float]

    @property
    def tensor(self) -> npt.NDArray[np.float64]:
        """(3, 3) inertia about the centre of mass, link axes, kg*m^2."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    @model_validator(mode="after")
    def _physical(self) -> Self:
        a, b, c = np.linalg.eigvalsh(self.tensor)
        if a <= 0 or a + b < c * (1 - 1e-9):
            raise ValueError(f"principal inertia ({a:.3g}, {b:.3g}, {c:.3g}) is not that of any body")
        return self


class Visual(Record):
    """A rendered mesh in link frame; `material` is an id in Asset.materials."""

    name: Id
    mesh: Mesh
    material: Id


class Collider(Record):
    """A collision shape at `pose` (link_from_shape); `substance` is an id in Asset.substances."""

    name: Id
    shape: Shape
    substance: Id
    pose: Pose = Pose()


class Link(Record):
    """A rigid body.

    Attributes:
        name: unique; the root link is called `object`.
        parent: name of the link that carries it, None for the root.
        pose: parent_from_link with every joint at zero.
        inertial: explicit, for every link.
        visuals, colliders: what is seen and what is touched.
    """

    name: Id
    parent: Id | None = None
    pose: Pose = Pose()
    inertial: Inertial
    visuals: tuple[Visual, ...] = ()
    colliders: tuple[Collider, ...] = ()


class JointKind(StrEnum):
    """Hinge (rad) or slide (m)."""

    HINGE = "hinge"
    SLIDE = "slide"


class Drive(Record):
    """A spring to a target: stiffness and damping in N/m, N*s/m or N*m/rad, N*m*s/rad; target in m or rad."""

    stiffness: NotNegative
    damping: NotNegative
    target: float = 0.0


class Joint(Record):
    """How a link moves against its parent. Zero is closed.

    Attributes:
        name: unique.
        child: link that moves.
        kind: hinge or slide.
        axis: unit vector, child frame.
        anchor: a point on the axis, metres, child frame.
        range: (low, high), rad or m; low < high.
        damping: N*m*s/rad or N*s/m. frictionloss: N*m or N. armature: kg*m^2 or kg.
        drive: spring to a target, or None.
    """

    name: Id
    child: Id
    kind: JointKind
    axis: Vec3
    anchor: Vec3 = (0.0, 0.0, 0.0)
    range: Vec2
    damping: NotNegative = 0.0
    frictionloss: NotNegative = 0.0
    armature: NotNegative = 0.0
    drive: Drive | None = None

    @field_validator("axis")
    @classmethod
    def _unit(cls, axis: Vec3) -> Vec3:
        norm = float(np.linalg.norm(axis))
        if norm < 1e-9:
            raise ValueError("axis has no direction")
        if abs(norm - 1.0) <= 1e-12:
            return axis
        return (axis[0] / norm, axis[1] / norm, axis[2] / norm)

    @field_validator("range")
    @classmethod
    def _ordered(cls, span: Vec2) -> Vec2:
        if not span[0] < span[1]:
            raise ValueError(f"range {span} must rise")
        return span


class Site(Record):
    """A named point in a link: where a mug goes, where water leaves. `radius` is for display, metres."""

    name: Id
    link: Id = "object"
    pose: Pose = Pose()
    radius: Positive = 0.005


class Region(Record):
    """A named volume in a link: an interior, a shelf, the bounding box. Box (full size) or cylinder about z."""

    name: Id
    link: Id = "object"
    pose: Pose = Pose()
    kind: Literal["box", "cylinder"] = "box"
    size: Vec3

    @field_validator("size")
    @classmethod
    def _positive(cls, size: Vec3) -> Vec3:
        if min(size) <= 0:
            raise ValueError(f"region size {size} must be positive")
        return size


class State(Record):
    """A named interval of a joint, as fractions of its way from closed (0) to open (1): `open` is (0.9, 1)."""

    name: Id
    joint: Id
    value: Id
    interval: Vec2


class Exclusion(Record):
    """Two links that never collide with each other."""

    first: Id
    second: Id


class Base(StrEnum):
    """How the root link meets the world: free to move, or welded where it is placed."""

    FREE = "free"
    FIXED = "fixed"


class Asset(Record):
    """A thing that both writers can write without deciding anything.

    Attributes:
        id: `<category>_<10 hex digits>`; the same id is the same bytes.
        links: parents before children; the first is the root and is called `object`.
        materials: looks, referenced by visuals. substances: matter, referenced by colliders.
    """

    id: Id
    base: Base = Base.FREE
    links: Annotated[tuple[Link, ...], Field(min_length=1)]
    joints: tuple[Joint, ...] = ()
    sites: tuple[Site, ...] = ()
    regions: tuple[Region, ...] = ()
    states: tuple[State, ...] = ()
    exclusions: tuple[Exclusion, ...] = ()
    materials: tuple[Material, ...] = ()
    substances: Annotated[tuple[Substance, ...], Field(min_length=1)]
    labels: Labels
    provenance: Provenance

    @model_validator(mode="after")
    def _whole(self) -> Self:
        seen: list[str] = []
        for i, link in enumerate(self.links):
            if (i == 0) != (link.parent is None) or (i == 0 and link.name != "object"):
                raise ValueError("the first link, and it alone, is the root and is called 'object'")
            if link.parent is not None and link.parent not in seen:
                raise ValueError(f"link {link.name!r}: parent {link.parent!r} must come before it")
            seen.append(link.name)
        visuals = [v.name for k in self.links for v in k.visuals]
        colliders = [c.name for k in self.links for c in k.colliders]
        _distinct("link", seen)
        _distinct("joint", [j.name for j in self.joints])
        _distinct("moved link", [j.child for j in self.joints])
        _distinct("visual or collider", visuals + colliders)
        _distinct("site or region", [s.name for s in self.sites] + [r.name for r in self.regions])
        _distinct("material", [m.id for m in self.materials])
        _distinct("substance", [s.id for s in self.substances])
        _known("link", [j.child for j in self.joints], seen[1:])
        _known("link", [s.link for s in self.sites] + [r.link for r in self.regions], seen)
        _known("link", [name for e in self.exclusions for name in (e.first, e.second)], seen)
        _known("joint", [s.joint for s in self.states], [j.name for j in self.joints])
        _known("material", [v.material for k in self.links for v in k.visuals], [m.id for m in self.materials])
        _known("substance", [c.substance for k in self.links for c in k.colliders], [s.id for s in self.substances])
        return self

    @property
    def root(self) -> Link:
        """The link that carries all others."""
        return self.links[0]

    def link(self, name: str) -> Link:
        """The link of that name. Raises KeyError."""
        return {k.name: k for k in self.links}[name]

    def joint_of(self, link: str) -> Joint | None:
        """The joint that moves a link, or None where it is the root or rigidly attached."""
        return {j.child: j for j in self.joints}.get(link)

    def asset_from_link(self, name: str) -> Pose:
        """Pose of a link in the asset frame, every joint at zero."""
        link = self.link(name)
        return link.pose if link.parent is None else self.asset_from_link(link.parent) @ link.pose

    def substance(self, name: str) -> Substance:
        """The substance of that id. Raises KeyError."""
        return {s.id: s for s in self.substances}[name]

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return sum(k.inertial.mass for k in self.links)

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) corners of everything that is seen, asset frame, joints at zero, metres."""
        points = [self.asset_from_link(k.name).apply(v.mesh.vertices) for k in self.links for v in k.visuals]
        cloud = np.concatenate(points)
        return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def _distinct(kind: str, names: list[str]) -> None:
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ValueError(f"{kind} {twice[0]!r} occurs twice")


def _known(kind: str, wanted: list[str], known: list[str]) -> None:
    missing = sorted(set(wanted) - set(known))
    if missing:
        raise ValueError(f"no {kind} {missing[0]!r}; there are {sorted(known)}")
