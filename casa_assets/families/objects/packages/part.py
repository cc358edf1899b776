"""A part of a package: a solid, its finish, what it is called, what it weighs."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.families.kit.solids.solid import Solid


@dataclass(frozen=True)
class Part:
    """A part.

    Attributes:
        solid: before the package is laid down: it stands on z = 0, its front looks to -y.
        finish: id of a finish. label: what part it is.
        density: kg/m^3; 0 weighs nothing. collider: it has a collision shape of its own.
        swings: it is on the link of the lid.
    """

    solid: Solid
    finish: str
    label: str
    density: float = 0.0
    collider: bool = False
    swings: bool = False
