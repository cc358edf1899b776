"""Solid: a closed surface with its collision shapes, normals, and texture coordinates at true size."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.solids import small_hull
from casa_assets.mesh.surface import face_normals, merge_rows, solid_moments, with_normals
from casa_assets.model.asset.parts import Box, Hull, Mesh, Shape
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3

Placed = tuple[Shape, Pose]

FOOT = 0.008  # height of the box under a hull, m
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Solid:
    """A closed, outward surface. Metres, z up.

    points: (P, 3) float64. faces: (F, 3) int64. shapes: collision shapes and their poses, same frame; if empty, its
    hull is taken. uv_m: (F, 3, 2) texture coordinates of the corners in metres, or None: then each face is laid flat.
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


# Directions of faces that differ by less are laid flat together, so that a picture runs on from one to the next.
SAME_DIRECTION = 1e-3


def solid_mesh(solid: Solid, tile_m: Vec2 | None, grain: Vec3 = (0.0, 0.0, 1.0), name: str = "") -> Mesh:
    """Return the mesh of a solid.

    solid: to be drawn. tile_m: size of the picture on it that repeats, or None: then the mesh has the coordinates of a
    picture that is made for the whole of it, where the solid has some, else none. grain: direction that the picture's
    height runs along, frame of the solid. name: of the part; parts of different names show different cuts of the
    picture. Returns: vertices as float32 holds them, unit normals, uv in pictures (metres over `tile_m`).
    """
    points, faces = _single(solid.points), solid.faces
    _, areas = face_normals(points, faces)
    keep = areas > 1e-14
    faces = faces[keep]
    if tile_m is None and solid.picture_uv is None:
        return _rounded(with_normals(Mesh(vertices=points, faces=faces), solid.crease_deg))
    if tile_m is None:
        assert solid.picture_uv is not None
        return _with_uv(points, faces, solid.picture_uv[keep], solid.crease_deg)
    uv_m = solid.uv_m[keep] if solid.uv_m is not None else flat_uv(points, faces, np.array(grain))
    uv = (uv_m + uv_offset(name)) / np.array(tile_m)
    # Whole pictures may be taken off: the numbers stay small, and float32 keeps its digits.
    uv -= np.floor(uv.reshape(-1, 2).min(axis=0))
    return _with_uv(points, faces, uv, solid.crease_deg)


def _with_uv(points: Floats, faces: Ints, uv: Floats, crease_deg: float) -> Mesh:
    """The mesh whose corners have some texture coordinates; corners that agree are one vertex."""
    first, index = merge_rows(np.column_stack([faces.ravel(), np.round(uv.reshape(-1, 2), 7)]))
    mesh = Mesh(vertices=points[faces.ravel()[first]], faces=index.reshape(-1, 3), uv=uv.reshape(-1, 2)[first])
    return _rounded(with_normals(mesh, crease_deg))


def flat_uv(points: Floats, faces: Ints, grain: Floats) -> Floats:
    """(F, 3, 2) metres: each face laid flat without stretch, v along the grain where the face allows it."""
    normals, _ = face_normals(points, faces)
    # One frame for each direction, so that neighbours in a plane agree to the last digit.
    first, group = merge_rows(np.round(normals / SAME_DIRECTION).astype(np.int64).astype(np.float64))
    n = normals[first]
    along = grain - (n @ grain)[:, None] * n
    length = np.linalg.norm(along, axis=1)
    # End grain: there v points up, or back where the face itself looks up.
    fallback = np.where(np.abs(n[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    fallback = fallback - np.einsum("ij,ij->i", fallback, n)[:, None] * n
    v = np.where(length[:, None] > 0.2, along, fallback)
    v /= np.linalg.norm(v, axis=1)[:, None]
    u = np.cross(v, n)
    corners = points[faces]
    return np.stack([np.einsum("fki,fi->fk", corners, u[group]), np.einsum("fki,fi->fk", corners, v[group])], axis=2)


def uv_offset(name: str) -> Floats:
    """(2,) metres by which a part of that name shifts its picture; the same on every machine."""
    mixed = zlib.crc32(name.encode("ascii"))
    return np.array([(mixed & 0xFFFF) / 0xFFFF * 3.0, (mixed >> 16) / 0xFFFF * 3.0])


def _single(values: Floats) -> Floats:
    return values.astype(np.float32).astype(np.float64)


def _rounded(mesh: Mesh) -> Mesh:
    uv, normals = (None if values is None else _single(values) for values in (mesh.uv, mesh.normals))
    return Mesh(vertices=_single(mesh.vertices), faces=mesh.faces, uv=uv, normals=normals)


def anchor_uv(solid: Solid, name: str, corner: Vec3, along: Vec3, face: Vec3) -> Solid:
    """Return the solid with texture coordinates that start at a corner.

    name: under which the solid alone is added: `solid_mesh` shifts the picture of each name, which is taken back here.
    corner: where the picture's lower left corner lies, frame of the solid, metres. along: unit vector that the
    picture's height runs along. face: unit normal of the faces that are laid so; all others are laid flat wherever they
    are.
    """
    up, normal = np.array(along), np.array(face)
    across = np.cross(up, normal)
    uv_m = flat_uv(solid.points, solid.faces, up)
    chosen = face_normals(solid.points, solid.faces)[0] @ normal > 0.999
    corners = solid.points[solid.faces[chosen]] - np.array(corner)
    uv_m[chosen] = np.stack([corners @ across, corners @ up], axis=2)
    return replace(solid, uv_m=uv_m - uv_offset(f"{name}/0"))
