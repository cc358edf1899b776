"""Parts of an asset: links with their meshes, collision shapes, sites and regions; joints, named poses and grasps."""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, field_validator, model_validator

from casa_assets.model.asset.material import Positive
from casa_assets.model.pose import Pose
from casa_assets.model.record import Colors, Faces, Id, MixedCaseId, Points, Record, Uvs, Vec2, Vec3, Vec4, Vec5

# Ref: PhysX GPU convex limit; MuJoCo maxhullvert is set to the same number.
MAX_HULL_VERTICES = 64
NotNegative = Annotated[float, Field(ge=0.0)]
Size = tuple[Positive, Positive, Positive]


class Mesh(Record):
    """Triangles over shared vertices; counter-clockwise seen from outside.

    Attributes:
        vertices: (V, 3) float64, metres once scaled, frame of the owner. faces: (F, 3) int32 indices into `vertices`.
        uv: (V, 2) float64, origin at the lower left of the image (the OBJ and USD convention), or None.
        normals: (V, 3) float64 unit normals, or None.
        colors: (V, 4) uint8 sRGB vertex colours, or None; only raw meshes carry them.
    """

    vertices: Points
    faces: Faces
    uv: Uvs | None = None
    normals: Points | None = None
    colors: Colors | None = None

    @model_validator(mode="after")
    def _agree(self) -> Self:
        count = len(self.vertices)
        for name in ("uv", "normals", "colors"):
            values = getattr(self, name)
            if values is not None and len(values) != count:
                raise ValueError(f"{name} has {len(values)} rows for {count} vertices")
        if len(self.faces) and not 0 <= int(self.faces.min()) <= int(self.faces.max()) < count:
            raise ValueError("a face names a vertex that does not exist")
        return self

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) lower and upper corner of all vertices."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def with_vertices(self, vertices: npt.NDArray[np.float64], normals: npt.NDArray[np.float64] | None = None) -> Mesh:
        """Copy with moved vertices; normals are replaced, or dropped if None."""
        return Mesh(vertices=vertices, faces=self.faces, uv=self.uv, normals=normals, colors=self.colors)


class Box(Record):
    """Box centred on the origin. `size` is the full size (x, y, z), metres."""

    kind: Literal["box"] = "box"
    size: Size


class Sphere(Record):
    """Sphere centred on the origin, radius in metres."""

    kind: Literal["sphere"] = "sphere"
    radius: Positive


class Cylinder(Record):
    """Cylinder about z, centred on the origin; radius and full height in metres."""

    kind: Literal["cylinder"] = "cylinder"
    radius: Positive
    height: Positive


class Capsule(Record):
    """Capsule about z, centred on the origin; `height` is the straight part alone, metres."""

    kind: Literal["capsule"] = "capsule"
    radius: Positive
    height: Positive


class Hull(Record):
    """Convex polyhedron: a closed, convex mesh of at most 64 vertices."""

    kind: Literal["hull"] = "hull"
    mesh: Mesh

    @field_validator("mesh")
    @classmethod
    def _small(cls, mesh: Mesh) -> Mesh:
        if not 4 <= len(mesh.vertices) <= MAX_HULL_VERTICES:
            raise ValueError(f"a hull has 4 to {MAX_HULL_VERTICES} vertices, got {len(mesh.vertices)}")
        return mesh


class MeshShape(Record):
    """Static triangle mesh, for fixtures that never move."""

    kind: Literal["mesh"] = "mesh"
    mesh: Mesh


Shape = Annotated[Box | Sphere | Cylinder | Capsule | Hull | MeshShape, Field(discriminator="kind")]


class Site(Record):
    """A named, massless place in a link without contacts: the place of a mug, a flame, a stream of water.

    Attributes:
        kind: a sphere of `radius` (metres), or a box or a cylinder about z of the full `size` (metres).
        color: linear RGBA. Runtimes show a flame or a stream by raising its alpha.
    """

    name: Id
    link: Id = "object"
    pose: Pose = Pose()
    kind: Literal["sphere", "box", "cylinder"] = "sphere"
    radius: Positive = 0.005
    size: Size | None = None
    color: Vec4 = (1.0, 0.033, 0.033, 0.6)

    @model_validator(mode="after")
    def _sized(self) -> Self:
        if (self.kind == "sphere") != (self.size is None):
            raise ValueError(f"site {self.name!r}: a sphere has a radius, a box or cylinder a size")
        return self


class Region(Record):
    """A named volume in a link: an interior, a shelf, the bounding box. Box (full size) or cylinder about z."""

    name: MixedCaseId
    link: Id = "object"
    pose: Pose = Pose()
    kind: Literal["box", "cylinder"] = "box"
    size: Size


class Inertial(Record):
    """Mass properties of a link.

    Attributes:
        mass: kg, > 0. center_of_mass: metres, link frame.
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
    """A rendered mesh in link frame.

    Attributes:
        material: id in Asset.materials.
        label: part that it shows (`handle`, `door`, `shelf`, `burner`, `button`), or None for the object itself.
    """

    name: Id
    mesh: Mesh
    material: Id
    label: Id | None = None


class Collider(Record):
    """A collision shape.

    Attributes:
        substance: id in Asset.substances. pose: link_from_shape.
        label: as for Visual. Runtimes ask for contacts by the collider's name.
    """

    name: MixedCaseId
    shape: Shape
    substance: Id
    pose: Pose = Pose()
    label: Id | None = None


class Link(Record):
    """A rigid body.

    Attributes:
        name: unique; the root link is called `object`. parent: name of the link that carries it, None for the root.
        pose: parent_from_link with every joint at zero. inertial: explicit, for every link.
        visuals, colliders: rendered meshes, and collision shapes.
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
    """Joint between a link and its parent: kind, axis, range, friction. Zero is closed.

    Attributes:
        name: unique. child: link that moves. kind: hinge or slide. axis: unit vector, child frame.
        anchor: a point on the axis, metres, child frame. range: (low, high), rad or m; low < high.
        damping: N*m*s/rad or N*s/m. frictionloss: N*m or N. armature: kg*m^2 or kg.
        friction_impedance: stiffness of dry friction as in MuJoCo: impedance at both ends, width, midpoint, power. With
            MuJoCo's default of 0.9 a light lever creeps under its own weight; with this value it does not. Ref: MuJoCo
            XML reference, solimpfriction.
        limit_impedance: stiffness of the ends of the range as in MuJoCo. With MuJoCo's default a spring presses a key
            0.8 mm out of its range of 3 mm; with this value, a few micrometres. Ref: MuJoCo XML reference, solimplimit.
        limit_margin: for joints with a drive, distance from the ends of the range at which they begin to push back, rad
            or m, so that a part that is pressed against an end comes to rest within the range. Ref: MuJoCo XML
            reference, margin.
        drive: spring to a target, or None.
        grip: collider that a hand takes hold of, on the moved link or on one that it carries rigidly; None if unknown.
        behind: joint that has to be open before this one can move: the door in front of a rack.
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
    friction_impedance: Vec5 = (0.9999, 0.9999, 0.001, 0.5, 2.0)
    limit_impedance: Vec5 = (0.9999, 0.9999, 0.001, 0.5, 2.0)
    limit_margin: NotNegative = 1e-5
    drive: Drive | None = None
    grip: MixedCaseId | None = None
    behind: Id | None = None

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

    def motion(self, position: float) -> Pose:
        """Pose of the child at a joint position (rad or m), relative to its frame at position zero."""
        x, y, z = self.axis
        if self.kind is JointKind.SLIDE:
            return Pose(position=(x * position, y * position, z * position))
        # Not numpy's functions: their last bit depends on the processor.
        c, s = math.cos(position / 2), math.sin(position / 2)
        anchor = Pose(position=self.anchor)
        return anchor @ Pose(quaternion=(c, s * x, s * y, s * z)) @ anchor.inverse()


class State(Record):
    """A named interval of a joint, as fractions of the way from closed (0) to open (1): `open` is (0.9, 1)."""

    name: Id
    joint: Id
    value: Id
    interval: Vec2


class JointValue(Record):
    """Position of one joint, rad or m."""

    joint: Id
    value: float


def joint_positions(values: Iterable[JointValue]) -> dict[str, float]:
    """Joint name -> position, rad or m."""
    return {at.joint: at.value for at in values}


class Keyframe(Record):
    """A named pose of the whole asset: `closed`, `open`, `on`. Joints that are not named are at zero."""

    name: Id
    joints: tuple[JointValue, ...] = ()


class Exclusion(Record):
    """Two links that never collide with each other."""

    first: Id
    second: Id


class GraspFeature(StrEnum):
    """Part of the object that the fingers close on."""

    BODY = "body"  # the thing itself, near its middle
    RIM = "rim"  # the wall of a vessel, from above
    HANDLE = "handle"  # what sticks out to be held


class Grasp(Record):
    """One grasp of an object as it rests, by a gripper with two parallel jaws.

    Attributes:
        center: middle between the fingers, metres. width: distance between them as they touch, metres.
        closing: unit vector along which they close. approach: unit vector of the approach, at a right angle to it.
    """

    feature: GraspFeature
    center: Vec3
    closing: Vec3
    approach: Vec3
    width: Annotated[float, Field(gt=0)]
