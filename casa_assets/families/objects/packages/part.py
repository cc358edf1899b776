"""A part of a package: a solid, its finish, what it is called, what it weighs."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.families.kit.solids.solid import Solid


@dataclass(frozen=True)
class Part:
    """A part of a package.

    Attributes:
        solid: in the pose before the package is laid down: its bottom at z = 0, its front to -y.
        finish: id of a finish. label: what part it is.
        density: kg/m^3; 0 for no mass. collider: it has a separate collision shape.
        swings: it is on the link of the lid.
    """

    solid: Solid
    finish: str
    label: str
    density: float = 0.0
    collider: bool = False
    swings: bool = False
