"""Collider -> geom that touches; its mass is in the body's `<inertial>`."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.export.mjcf.visual import Meshes
from casa_assets.export.mujoco_values import contact_dimensions
from casa_assets.model.asset.asset import Collider
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Sphere

COLOR = "0.2 0.6 0.9 0.4"


def add(
    body: etree._Element, collider: Collider, substance: Substance, meshes: Meshes, group: int, prefix: str = ""
) -> etree._Element:
    """`<geom>` below `<body>`; its name begins with `prefix`."""
    attributes = {"name": prefix + collider.name, **_shape(collider, meshes), **number.place(collider.pose)}
    attributes |= {
        "group": str(group),
        "contype": "1",
        "conaffinity": "1",
        "condim": str(contact_dimensions(collider.shape)),
        "friction": friction(substance),
        # All mass is in <inertial>. A consumer that ignores that finds a body without mass and says so, where a density
        # would silently give it the weight of hulls that overlap.
        "mass": "0",
        "rgba": COLOR,
    }
    return etree.SubElement(body, "geom", attributes)


def friction(substance: Substance) -> str:
    """MuJoCo's `friction`: sliding, torsional (m), rolling (m). Its one sliding coefficient is the dynamic one."""
    return number.numbers((substance.dynamic_friction, substance.torsional_friction, substance.rolling_friction))


def _shape(collider: Collider, meshes: Meshes) -> dict[str, str]:
    shape = collider.shape
    if isinstance(shape, Box):
        return {"type": "box", "size": number.numbers(s / 2 for s in shape.size)}
    if isinstance(shape, Sphere):
        # Three times: robocasa's loader scales sizes by axis and refuses a single number; MuJoCo reads the first.
        return {"type": "sphere", "size": number.numbers([shape.radius] * 3)}
    if isinstance(shape, Cylinder | Capsule):
        return {"type": shape.kind, "size": number.numbers((shape.radius, shape.height / 2))}
    # MuJoCo collides any mesh as its convex hull. A hull is that already; a static mesh (MeshShape) becomes it.
    return {"type": "mesh", "mesh": meshes.of[collider.name].name}
