"""Round the numbers of an asset so that every machine writes the same bytes.

Vector units of processors, and even the place of an array in memory, change the last bit of a product. A nanometre is
far below anything that is seen or touched, and far above that bit.
"""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.link import Collider, Link, Visual
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

LENGTH_DECIMALS, QUATERNION_DECIMALS, VISUAL_DECIMALS = (
    9,
    12,
    7,
)  # decimals of metres and numbers, of quaternions, of normals and texture coordinates


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
        # What is a millionth of a millionth of the whole is nothing.
        least = 1e-10 * sum(inertial.inertia[:3])
        xx, yy, zz, xy, xz, yz = (0.0 if abs(v) < least else v for v in inertial.inertia)
        inertial = inertial.replace(center_of_mass=_vec(inertial.center_of_mass), inertia=(xx, yy, zz, xy, xz, yz))
    return link.replace(
        pose=_pose(link.pose),
        inertial=inertial,
        visuals=tuple(_visual(v) for v in link.visuals),
        colliders=tuple(_collider(c) for c in link.colliders),
    )


def _visual(visual: Visual) -> Visual:
    return visual.replace(mesh=_mesh(visual.mesh))


def _collider(collider: Collider) -> Collider:
    return collider.replace(pose=_pose(collider.pose), shape=_shape(collider.shape))


def _shape(shape: Shape) -> Shape:
    if isinstance(shape, Box):
        return shape.replace(size=_vec(shape.size))
    if isinstance(shape, Sphere):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS))
    if isinstance(shape, Cylinder | Capsule):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS), height=round(shape.height, LENGTH_DECIMALS))
    assert isinstance(shape, Hull | MeshShape)
    return shape.replace(
        mesh=shape.mesh.with_vertices(_array(shape.mesh.vertices, LENGTH_DECIMALS), shape.mesh.normals)
    )


def _mesh(mesh: Mesh) -> Mesh:
    return Mesh(
        vertices=_single(mesh.vertices, LENGTH_DECIMALS - 1),
        faces=mesh.faces,
        uv=None if mesh.uv is None else _single(mesh.uv, VISUAL_DECIMALS),
        normals=None if mesh.normals is None else _single(mesh.normals, VISUAL_DECIMALS),
    )


def _single(values: Floats, places: int) -> Floats:
    """Round to decimals, then to the nearest float32."""
    return _array(values, places).astype(np.float32).astype(np.float64)


def _array(values: Floats, places: int) -> Floats:
    return np.round(values, places) + 0.0


def _vec(values: Vec3) -> Vec3:
    x, y, z = (round(v, LENGTH_DECIMALS) + 0.0 for v in values)
    return (x, y, z)


def _pose(pose: Pose) -> Pose:
    w, x, y, z = (round(q, QUATERNION_DECIMALS) + 0.0 for q in pose.quaternion)
    return Pose(position=_vec(pose.position), quaternion=(w, x, y, z))
