"""What the small assets of the tests are made of: substances, masses, labels and where they come from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from casa_assets.model.asset.asset import (
    Collider,
    Inertial,
    Joint,
    JointKind,
    JointValue,
    Keyframe,
    Labels,
    Link,
    Provenance,
    Visual,
)
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.parts import Box, Shape
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3
from casa_assets.model.registry.category import Certainty, QCode
from tests.support.mesh.meshes import box_mesh

CERAMIC = Substance(id="ceramic", density=2400.0, static_friction=0.6, dynamic_friction=0.45)
STEEL = Substance(id="steel", density=7800.0, static_friction=0.6, dynamic_friction=0.4, torsional_friction=0.004)
ROLLING = {"torsional_friction": 0.006, "rolling_friction": 5e-4}
FRUIT = Substance(id="fruit", density=900.0, static_friction=0.7, dynamic_friction=0.6, **ROLLING)
CARDBOARD = Substance(id="cardboard", density=300.0, static_friction=0.5, dynamic_friction=0.4)

HERE: Vec3 = (0.0, 0.0, 0.0)
X: Vec3 = (1.0, 0.0, 0.0)
Y: Vec3 = (0.0, 1.0, 0.0)
Z: Vec3 = (0.0, 0.0, 1.0)

PROVENANCE = Provenance(
    source="generated", path="tests", sha256="0" * 64, title="Test", author="Casa", licence="CC0-1.0"
)


def box_inertial(mass: float, size: Vec3, center: Vec3) -> Inertial:
    """Inertia of a solid box of full `size`, metres, kg."""
    x, y, z = (s * s for s in size)
    k = mass / 12
    return Inertial(mass=mass, center_of_mass=center, inertia=(k * (y + z), k * (x + z), k * (x + y), 0.0, 0.0, 0.0))


def box_collider(name: str, size: Vec3, at: Vec3, substance: str = "cardboard", label: str | None = None) -> Collider:
    """A box of full `size` around a point of its link, metres."""
    return Collider(name=name, shape=Box(size=size), substance=substance, pose=Pose(position=at), label=label)


def formed(name: str, shape: Shape, substance: str, at: Vec3 = HERE, label: str | None = None) -> Collider:
    """A collision shape at a point of its link."""
    return Collider(name=name, shape=shape, substance=substance, pose=Pose(position=at), label=label)


def seen(name: str, material: str, size: Vec3, at: Vec3 = HERE, label: str | None = None) -> Visual:
    """A visible box of full `size` around a point of its link, metres."""
    return Visual(name=name, mesh=box_mesh(size, at), material=material, label=label)


def link(
    name: str, mass: tuple[float, Vec3, Vec3], looks: Iterable[Visual], shapes: Iterable[Collider], **fields: Any
) -> Link:
    """A link with the inertia of a solid box (its mass, full size and middle), on `object` unless it is that itself."""
    fields = {"parent": None if name == "object" else "object", **fields}
    return Link(name=name, inertial=box_inertial(*mass), visuals=tuple(looks), colliders=tuple(shapes), **fields)


def hinge(name: str, child: str, axis: Vec3, span: Vec2, **fields: Any) -> Joint:
    """A hinge with that range, rad."""
    return Joint(name=name, child=child, kind=JointKind.HINGE, axis=axis, range=span, **fields)


def slide(name: str, child: str, axis: Vec3, span: Vec2, **fields: Any) -> Joint:
    """A slide with that range, metres."""
    return Joint(name=name, child=child, kind=JointKind.SLIDE, axis=axis, range=span, **fields)


def keyframe(name: str, **values: float) -> Keyframe:
    """A pose with that name, by joints, rad or m."""
    return Keyframe(name=name, joints=tuple(JointValue(joint=joint, value=at) for joint, at in values.items()))


def labels(name: str, classes: tuple[str, ...], qcode: str) -> Labels:
    """Labels with a certain Q-code."""
    return Labels(category=name, classes=classes, qcode=QCode(id=qcode, label=name, certainty=Certainty.CERTAIN))


def named(name: str, qcode: str, *classes: str) -> dict[str, Any]:
    """The fields of an asset that say what it is, with the classes above its category, and where it comes from."""
    return {"id": f"{name}_0123456789", "labels": labels(name, (name, *classes), qcode), "provenance": PROVENANCE}
