"""Collision shapes. Each sits at its own pose in a link; sizes are full sizes in metres."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator

from casa_assets.model.asset.material import Positive
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.record import Record, Vec3

# Ref: PhysX GPU convex limit; MuJoCo maxhullvert is set to the same number.
MAX_HULL_VERTICES = 64


class Box(Record):
    """Box centred on the origin. `size` is the full size (x, y, z), metres."""

    kind: Literal["box"] = "box"
    size: Vec3

    @field_validator("size")
    @classmethod
    def _positive(cls, size: Vec3) -> Vec3:
        if min(size) <= 0:
            raise ValueError(f"box size {size} must be positive")
        return size


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
