"""Round the numbers of an asset so that every machine writes the same bytes.

The vector unit of a processor, and even the alignment of an array in memory, changes the last bit of a product.
Rounding to a nanometre hides that bit and changes nothing that can be seen or measured.
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

LENGTH_DECIMALS = 9  # of metres
QUATERNION_DECIMALS = 12
VISUAL_DECIMALS = 7  # of normals and texture coordinates
INERTIA_TOLERANCE = 1e-10  # entries below this share of the trace are set to 0


def quantize(asset: Asset) -> Asset:
    """Return the asset with poses, sizes, vertices, normals and texture coordinates rounded."""
    return asset.replace(
        links=tuple(_link(k) for k in asset.links),
        joints=tuple(j.replace(anchor=_vec(j.anchor), axis=_vec(j.axis)) for j in asset.joints),
        sites=tuple(s.replace(pose=_pose(s.pose)) for s in asset.sites),
        regions=tuple(r.replace(pose=_pose(r.pose), size=_vec(r.size)) for r in asset.regions),
    )


def _link(link: Link) -> Link:
    inertial = link.inertial
    if inertial is not None:
        threshold = INERTIA_TOLERANCE * sum(inertial.inertia[:3])
        xx, yy, zz, xy, xz, yz = (0.0 if abs(v) < threshold else v for v in inertial.inertia)
        inertial = inertial.replace(center_of_mass=_vec(inertial.center_of_mass), inertia=(xx, yy, zz, xy, xz, yz))
    return link.replace(
        pose=_pose(link.pose),
        inertial=inertial,
        visuals=tuple(v.replace(mesh=_mesh(v.mesh)) for v in link.visuals),
        colliders=tuple(c.replace(pose=_pose(c.pose), shape=_shape(c.shape)) for c in link.colliders),
    )


def _shape(shape: Shape) -> Shape:
    if isinstance(shape, Box):
        return shape.replace(size=_vec(shape.size))
    if isinstance(shape, Sphere):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS))
    if isinstance(shape, Cylinder | Capsule):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS), height=round(shape.height, LENGTH_DECIMALS))
    assert isinstance(shape, Hull | MeshShape)
    vertices = np.round(shape.mesh.vertices, LENGTH_DECIMALS) + 0.0
    return shape.replace(mesh=shape.mesh.with_vertices(vertices, shape.mesh.normals))


def _mesh(mesh: Mesh) -> Mesh:
    return Mesh(
        vertices=_single(mesh.vertices, LENGTH_DECIMALS - 1),
        faces=mesh.faces,
        uv=None if mesh.uv is None else _single(mesh.uv, VISUAL_DECIMALS),
        normals=None if mesh.normals is None else _single(mesh.normals, VISUAL_DECIMALS),
    )


def _single(values: Floats, places: int) -> Floats:
    """Round to decimals, then to the nearest float32; adding 0 turns -0.0 into 0.0."""
    return (np.round(values, places) + 0.0).astype(np.float32).astype(np.float64)


def _vec(values: Vec3) -> Vec3:
    x, y, z = (round(v, LENGTH_DECIMALS) + 0.0 for v in values)
    return (x, y, z)


def _pose(pose: Pose) -> Pose:
    w, x, y, z = (round(q, QUATERNION_DECIMALS) + 0.0 for q in pose.quaternion)
    return Pose(position=_vec(pose.position), quaternion=(w, x, y, z))
