"""Rigid body of an asset: its visuals, its collision shapes and its mass."""

from __future__ import annotations

from typing import Self

import numpy as np
import numpy.typing as npt
from pydantic import model_validator

from casa_assets.model.asset.material import Positive
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import Shape
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, MixedCaseId, Record, Vec3


class Inertial(Record):
    """Mass properties of a link.

    Attributes:
        mass: kg, > 0.
        center_of_mass: metres, link frame.
        inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass, link axes, kg*m^2.
    """

    mass: Positive
    center_of_mass: Vec3
    inertia: tuple[float, float, float, float, float, float]

    @property
    def tensor(self) -> npt.NDArray[np.float64]:
        """(3, 3) inertia about the centre of mass, link axes, kg*m^2."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    @model_validator(mode="after")
    def _physical(self) -> Self:
        a, b, c = np.linalg.eigvalsh(self.tensor)
        if a <= 0 or a + b < c * (1 - 1e-9):
            raise ValueError(f"principal inertia ({a:.3g}, {b:.3g}, {c:.3g}) is not that of any body")
        return self


class Visual(Record):
    """A rendered mesh in link frame.

    Attributes:
        material: id in Asset.materials.
        label: part that it shows (`handle`, `door`, `shelf`, `burner`, `button`), or None for the object itself.
    """

    name: Id
    mesh: Mesh
    material: Id
    label: Id | None = None


class Collider(Record):
    """A collision shape.

    Attributes:
        substance: id in Asset.substances.
        pose: link_from_shape.
        label: as for Visual. Runtimes ask for contacts by the collider's name.
    """

    name: MixedCaseId
    shape: Shape
    substance: Id
    pose: Pose = Pose()
    label: Id | None = None


class Link(Record):
    """A rigid body.

    Attributes:
        name: unique; the root link is called `object`.
        parent: name of the link that carries it, None for the root.
        pose: parent_from_link with every joint at zero.
        inertial: explicit, for every link.
        visuals, colliders: rendered meshes, and collision shapes.
    """

    name: Id
    parent: Id | None = None
    pose: Pose = Pose()
    inertial: Inertial
    visuals: tuple[Visual, ...] = ()
    colliders: tuple[Collider, ...] = ()
