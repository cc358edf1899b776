"""Collider -> `<collision>`; URDF has no capsule, so it becomes a cylinder with a sphere at each end."""

from __future__ import annotations

from collections.abc import Iterator

from lxml import etree

from casa_assets.export.mjcf.number import number as text
from casa_assets.export.mjcf.number import numbers
from casa_assets.export.urdf import number
from casa_assets.export.urdf.visual import Meshes, add_mesh
from casa_assets.model.asset.asset import Collider
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Sphere
from casa_assets.model.pose import Pose

# Between the name of a capsule and the number of the sphere at one of its ends; no name of ours holds it.
END_MARK = "__end"


def add_all(link: etree._Element, collider: Collider, meshes: Meshes, urdf_from_link: Pose, prefix: str = "") -> None:
    """Every `<collision>` of a collider below `<link>`; their names begin with `prefix`."""
    for name, shape, pose in _elements(collider):
        element = etree.SubElement(link, "collision", {"name": prefix + name})
        number.add_origin(element, urdf_from_link @ pose)
        if isinstance(shape, Box | Sphere | Cylinder):
            etree.SubElement(etree.SubElement(element, "geometry"), shape.kind, _size(shape))
        else:
            add_mesh(element, meshes.of[collider.name])


def _elements(collider: Collider) -> Iterator[tuple[str, Box | Sphere | Cylinder | None, Pose]]:
    """Yield (name, primitive or None for a mesh, link_from_shape) of each element that represents a collider."""
    shape, pose = collider.shape, collider.pose
    if isinstance(shape, Capsule):
        yield collider.name, Cylinder(radius=shape.radius, height=shape.height), pose
        for end, z in enumerate((-shape.height / 2, shape.height / 2)):
            yield f"{collider.name}{END_MARK}{end}", Sphere(radius=shape.radius), pose @ Pose(position=(0.0, 0.0, z))
    else:
        yield collider.name, shape if isinstance(shape, Box | Sphere | Cylinder) else None, pose


def _size(shape: Box | Sphere | Cylinder) -> dict[str, str]:
    if isinstance(shape, Box):
        return {"size": numbers(shape.size)}
    if isinstance(shape, Sphere):
        return {"radius": text(shape.radius)}
    return {"radius": text(shape.radius), "length": text(shape.height)}
