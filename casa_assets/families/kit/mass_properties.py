"""Mass, centre and inertia of solids, and of several of them as one rigid body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.geometry.mesh.measure import solid_moments


@dataclass(frozen=True)
class RigidMass:
    """A mass (kg) at `center` ((3,) metres, link frame) with its inertia ((3, 3) kg*m^2) about that point."""

    mass: float
    center: Floats
    inertia: Floats


def solid_mass(solid: Solid, density: float) -> RigidMass:
    """Mass properties of a closed solid of a density in kg/m^3. Raises ValueError where its volume is not positive."""
    volume, center, inertia = solid_moments(solid.points, solid.faces)
    if volume <= 0:
        raise ValueError(f"a solid of volume {volume:.3g} m^3 has no weight")
    return RigidMass(volume * density, np.array(center), np.array(inertia) * density)


def combine_masses(masses: list[RigidMass]) -> RigidMass:
    """Combine masses into one rigid body. Raises ValueError where the total is not positive."""
    mass = sum(m.mass for m in masses)
    if mass <= 0:
        raise ValueError("nothing that weighs anything")
    center: Floats = sum((m.mass * m.center for m in masses), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for m in masses:
        offset = m.center - center
        tensor += m.inertia + m.mass * (float(offset @ offset) * np.eye(3) - np.outer(offset, offset))
    return RigidMass(mass, center, tensor)
