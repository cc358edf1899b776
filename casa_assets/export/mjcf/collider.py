"""Collider -> geom that touches; its mass is in the body's `<inertial>`."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.export.mjcf.mesh import Meshes
from casa_assets.model.asset.asset import Collider
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Shape, Sphere

# Ref: robosuite, geoms of group 0 collide.
GROUP = 0
# Ref: mujoco_menagerie, geoms of group 3 collide; the viewer hides them until key 3 is pressed.
VIEWER_GROUP = 3
COLOR = "0.2 0.6 0.9 0.4"

# Sliding and spinning friction: with sliding alone (3) a ball that spins never stops. Ref: robosuite's objects.
FACETED = 4
# A sphere has no face to rest on; only rolling friction stops it, and only 6 turns that on.
ROUND = 6


def add(
    body: etree._Element, collider: Collider, substance: Substance, meshes: Meshes, group: int, prefix: str = ""
) -> etree._Element:
    """`<geom>` below `<body>`; its name begins with `prefix`."""
    attributes = {"name": prefix + collider.name, **_form(collider, meshes), **number.place(collider.pose)}
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
    """MuJoCo's `friction`: sliding, torsional (m), rolling (m). It has one sliding coefficient, that of motion."""
    return number.numbers((substance.dynamic_friction, substance.torsional_friction, substance.rolling_friction))


def contact_dimensions(shape: Shape) -> int:
    """MuJoCo's `condim` of a shape."""
    return ROUND if isinstance(shape, Sphere) else FACETED


def _form(collider: Collider, meshes: Meshes) -> dict[str, str]:
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
