"""Solid: a closed surface with its collision shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import solid_moments
from casa_assets.geometry.solid.hull import small_hull
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import Box, Hull, Shape
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

Placed = tuple[Shape, Pose]

FOOT = 0.008  # height of the box under a hull, m
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Solid:
    """A closed, outward surface. Metres, z up.

    Attributes:
        points: (P, 3) float64. faces: (F, 3) int64.
        shapes: collision shapes and their poses, same frame; empty where nobody has said: then its hull is taken.
        uv_m: (F, 3, 2) own texture coordinates of the corners in metres, or None: then each face is laid flat.
        picture_uv: (F, 3, 2) coordinates of the corners in a picture that is made for the whole of it, 0..1, or None.
        crease_deg: faces that meet at less are shaded as one smooth surface.
    """

    points: Floats
    faces: Ints
    shapes: tuple[Placed, ...] = ()
    uv_m: Floats | None = None
    crease_deg: float = 50.0
    picture_uv: Floats | None = None

    @property
    def bounds(self) -> Floats:
        """(2, 3) lower and upper corner, metres."""
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def volume(self) -> float:
        """m^3."""
        return solid_moments(self.points, self.faces)[0]

    def transformed(self, pose: Pose) -> Solid:
        """Transform points and collision shapes by `pose`."""
        shapes = tuple((shape, pose @ at) for shape, at in self.shapes)
        return replace(self, points=pose.apply(self.points), shapes=shapes)

    def translated(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Solid:
        """Translate by x, y, z metres."""
        return self.transformed(Pose(position=(x, y, z)))

    def rotated(self, axis: str, angle: float, about: Vec3 = (0.0, 0.0, 0.0)) -> Solid:
        """Rotate about an axis (`x`, `y`, `z`) through a point, radians, right hand."""
        center = Pose(position=about)
        return self.transformed(center @ axis_turn(axis, angle) @ center.inverse())

    def mirrored_x(self) -> Solid:
        """Its mirror image in the plane x = 0. Collision shapes are mirrored: boxes, cylinders and hulls stay such."""
        flip = np.array([-1.0, 1.0, 1.0])
        shapes = tuple(_mirrored(shape, at) for shape, at in self.shapes)
        uv_m, picture_uv = (None if uv is None else uv[:, ::-1] for uv in (self.uv_m, self.picture_uv))
        faces = self.faces[:, ::-1]
        return replace(self, points=self.points * flip, faces=faces, shapes=shapes, uv_m=uv_m, picture_uv=picture_uv)

    def oriented_outwards(self) -> Solid:
        """Return the solid, or where its faces look inwards a copy with all of them reversed."""
        if self.volume > 0:
            return self
        uv_m, picture_uv = (None if uv is None else uv[:, ::-1] for uv in (self.uv_m, self.picture_uv))
        return replace(self, faces=self.faces[:, ::-1], uv_m=uv_m, picture_uv=picture_uv)

    def without_colliders(self) -> Solid:
        """Return a copy without collision shapes."""
        return replace(self, shapes=())

    def with_shapes(self, *shapes: Placed, crease_deg: float | None = None) -> Solid:
        """Return a copy with these collision shapes, and another crease angle where one is given, degrees."""
        return replace(self, shapes=shapes, crease_deg=self.crease_deg if crease_deg is None else crease_deg)

    def with_box_collider(self) -> Solid:
        """Return a copy whose collision shape is its bounding box."""
        return self.with_shapes(box_shape(*self.bounds))

    def with_hull_collider(self) -> Solid:
        """Return a copy whose collision shape is its convex hull, of at most 64 vertices."""
        points, faces = small_hull(self.points.round(9))
        return self.with_shapes((Hull(mesh=Mesh(vertices=points, faces=faces)), Pose()))

    def with_hull_on_foot(self, half_x: float, front: float, back: float) -> Solid:
        """Return a copy whose collision shapes are its convex hull and, under it, a box as its foot.

        The foot begins at z = 0 and is FOOT high; it reaches from -half_x to half_x and from y = `front` to `back`,
        metres. The hull begins within it. A box rests on its four corners in every version of MuJoCo; version 3.3
        sometimes finds a single corner of a hull, and what rests on it rocks and drifts.
        """
        raised = self.points.copy()
        raised[:, 2] = raised[:, 2].clip(FOOT / 2)
        hull = replace(self, points=raised).with_hull_collider()
        return self.with_shapes(*hull.shapes, box_shape((-half_x, front, 0.0), (half_x, back, FOOT)))

    def with_colliders_of(self, *solids: Solid) -> Solid:
        """Return a copy with the collision shapes of other solids."""
        return self.with_shapes(*(s for solid in solids for s in solid.shapes))

    def with_crease(self, crease_deg: float) -> Solid:
        """Return a copy with another crease angle, degrees."""
        return replace(self, crease_deg=crease_deg)


def axis_turn(axis: str, angle: float) -> Pose:
    """Rotation about an axis of that name by radians."""
    half = angle / 2
    x, y, z = (float(np.sin(half) * v) for v in AXES[axis])
    return Pose(quaternion=(float(np.cos(half)), x, y, z))


def box_shape(lower: Sequence[float] | Floats, upper: Sequence[float] | Floats) -> Placed:
    """An upright box between two corners."""
    size = [float(b - a) for a, b in zip(lower, upper, strict=True)]
    center = [float(a + b) / 2 for a, b in zip(lower, upper, strict=True)]
    return Box(size=(size[0], size[1], size[2])), Pose(position=(center[0], center[1], center[2]))


def hull_around(points: Floats) -> Solid:
    """A solid without faces whose collision shape is the convex hull of (P, 3) points, metres."""
    return Solid(points, np.empty((0, 3), dtype=np.int64)).with_hull_collider()


def concatenate(solids: Sequence[Solid]) -> Solid:
    """Concatenate surfaces and shapes of several solids, without welding them."""
    starts = np.cumsum([0, *(len(s.points) for s in solids)])
    uv_m = [s.uv_m for s in solids if s.uv_m is not None]
    picture_uv = [s.picture_uv for s in solids if s.picture_uv is not None]
    return Solid(
        points=np.concatenate([s.points for s in solids]),
        faces=np.concatenate([s.faces + start for s, start in zip(solids, starts, strict=False)]),
        shapes=tuple(shape for s in solids for shape in s.shapes),
        uv_m=np.concatenate(uv_m) if len(uv_m) == len(solids) else None,
        picture_uv=np.concatenate(picture_uv) if len(picture_uv) == len(solids) else None,
        crease_deg=solids[0].crease_deg,
    )


def _mirrored(shape: Shape, at: Pose) -> Placed:
    x, y, z = at.position
    w, a, b, c = at.quaternion
    mirror = Pose(position=(-x, y, z), quaternion=(w, a, -b, -c))
    if isinstance(shape, Hull):
        mesh = Mesh(vertices=shape.mesh.vertices * np.array([-1.0, 1.0, 1.0]), faces=shape.mesh.faces[:, ::-1])
        return Hull(mesh=mesh), mirror
    return shape, mirror
