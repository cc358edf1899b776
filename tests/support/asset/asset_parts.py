"""What the small assets of the tests are made of: substances, masses, labels and where they come from."""

from __future__ import annotations

from casa_assets.model.asset.asset import Collider, Inertial
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.parts import Box
from casa_assets.model.asset.provenance import Labels, Provenance
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Certainty, QCode

CERAMIC = Substance(id="ceramic", density=2400.0, static_friction=0.6, dynamic_friction=0.45)
STEEL = Substance(id="steel", density=7800.0, static_friction=0.6, dynamic_friction=0.4, torsional_friction=0.004)
FRUIT = Substance(
    id="fruit",
    density=900.0,
    static_friction=0.7,
    dynamic_friction=0.6,
    torsional_friction=0.006,
    rolling_friction=5e-4,
)
CARDBOARD = Substance(id="cardboard", density=300.0, static_friction=0.5, dynamic_friction=0.4)

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


def labels(name: str, classes: tuple[str, ...], qcode: str) -> Labels:
    """Labels with a certain Q-code."""
    return Labels(category=name, classes=classes, qcode=QCode(id=qcode, label=name, certainty=Certainty.CERTAIN))
