"""Round the numbers of an asset so that runs on different machines nearly always write the same bytes.

The vector unit of a processor, and even the alignment of an array in memory, changes the last bit of a product.
Rounding hides that bit and changes nothing that can be seen or measured. A value on a rounding boundary can still
differ. Rounded are poses, anchors and axes of joints, sizes of regions and shapes, vertices of colliders and of visual
meshes, normals, texture coordinates and centres of mass. Masses are not rounded; of the inertia, only entries that are
zero but for rounding errors are set to 0.
"""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.link import Link
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

LENGTH_DECIMALS = 9  # of metres, except in visual meshes; also of unit axes
# Of metres in visual meshes. These are stored as float32, which near 0.1 m is exact to about 1e-8 m.
MESH_DECIMALS = 8
QUATERNION_DECIMALS = 12
VISUAL_DECIMALS = 7  # of normals and texture coordinates
INERTIA_TOLERANCE = 1e-10  # entries below this share of the trace are set to 0


def quantize(asset: Asset) -> Asset:
    """Return the asset with its lengths, rotations, normals and texture coordinates rounded."""
    return asset.replace(
        links=tuple(_rounded_link(k) for k in asset.links),
        joints=tuple(j.replace(anchor=_rounded_vec(j.anchor), axis=_rounded_vec(j.axis)) for j in asset.joints),
        sites=tuple(s.replace(pose=_rounded_pose(s.pose)) for s in asset.sites),
        regions=tuple(r.replace(pose=_rounded_pose(r.pose), size=_rounded_vec(r.size)) for r in asset.regions),
    )


def _rounded_link(link: Link) -> Link:
    """The link with its lengths and rotations rounded and rounding errors in its inertia set to 0."""
    inertial = link.inertial
    if inertial is not None:
        threshold = INERTIA_TOLERANCE * sum(inertial.inertia[:3])
        xx, yy, zz, xy, xz, yz = (0.0 if abs(v) < threshold else v for v in inertial.inertia)
        inertial = inertial.replace(
            center_of_mass=_rounded_vec(inertial.center_of_mass), inertia=(xx, yy, zz, xy, xz, yz)
        )
    return link.replace(
        pose=_rounded_pose(link.pose),
        inertial=inertial,
        visuals=tuple(v.replace(mesh=_rounded_mesh(v.mesh)) for v in link.visuals),
        colliders=tuple(c.replace(pose=_rounded_pose(c.pose), shape=_rounded_shape(c.shape)) for c in link.colliders),
    )


def _rounded_shape(shape: Shape) -> Shape:
    """The collision shape with its lengths rounded."""
    if isinstance(shape, Box):
        return shape.replace(size=_rounded_vec(shape.size))
    if isinstance(shape, Sphere):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS))
    if isinstance(shape, Cylinder | Capsule):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS), height=round(shape.height, LENGTH_DECIMALS))
    assert isinstance(shape, Hull | MeshShape)
    vertices = np.round(shape.mesh.vertices, LENGTH_DECIMALS) + 0.0
    return shape.replace(mesh=shape.mesh.with_vertices(vertices, shape.mesh.normals))


def _rounded_mesh(mesh: Mesh) -> Mesh:
    """The visual mesh with vertices, texture coordinates and normals rounded to float32."""
    return Mesh(
        vertices=_rounded_float32(mesh.vertices, MESH_DECIMALS),
        faces=mesh.faces,
        uv=None if mesh.uv is None else _rounded_float32(mesh.uv, VISUAL_DECIMALS),
        normals=None if mesh.normals is None else _rounded_float32(mesh.normals, VISUAL_DECIMALS),
    )


def _rounded_float32(values: Floats, places: int) -> Floats:
    """Round to decimals, then to the nearest float32; adding 0 turns -0.0 into 0.0."""
    return (np.round(values, places) + 0.0).astype(np.float32).astype(np.float64)


def _rounded_vec(values: Vec3) -> Vec3:
    """Three numbers rounded to LENGTH_DECIMALS; adding 0 turns -0.0 into 0.0."""
    x, y, z = (round(v, LENGTH_DECIMALS) + 0.0 for v in values)
    return (x, y, z)


def _rounded_pose(pose: Pose) -> Pose:
    """The pose with its position and its quaternion rounded."""
    w, x, y, z = (round(q, QUATERNION_DECIMALS) + 0.0 for q in pose.quaternion)
    return Pose(position=_rounded_vec(pose.position), quaternion=(w, x, y, z))
