"""Finishes of parametric families: appearance, substance, and true size of the picture."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.kitchen.surface import Surface
from casa_assets.model.record import Id, Record, Vec2

__all__ = ["Finish", "HexColor", "Plain", "Surface"]

HexColor = Annotated[str, StringConstraints(pattern=r"^#[0-9a-f]{6}$")]


class Plain(Record):
    """A finish without a picture: metal, enamel, plastic, glass, rubber. A row of registry/materials.yaml.

    Attributes:
        id: such as `brushed_steel`.
        color: sRGB, `#rrggbb`, as on a colour card.
        metallic, roughness: 0..1.
        opacity: 0..1; below 1 it is see-through.
        substance: id in registry/substances.yaml.
        glow: 0..1, share of the colour that it emits (a lamp, a display).
    """

    id: Id
    color: HexColor
    metallic: Annotated[float, Field(ge=0, le=1)] = 0.0
    roughness: Annotated[float, Field(ge=0, le=1)] = 0.5
    opacity: Annotated[float, Field(gt=0, le=1)] = 1.0
    substance: Id
    glow: Annotated[float, Field(ge=0, le=1)] = 0.0


class Finish(Record):
    """A surface, resolved.

    Attributes:
        id: id of the plain finish, texture recipe or pack picture.
        material: its appearance, with the id of the finish. Its `tile_m` is the real size of its picture; wood grain
            runs along the height (v) of the picture.
        substance: its physical material.
    """

    id: Id
    material: Material
    substance: Substance

    @property
    def tile_m(self) -> Vec2 | None:
        """Width and height in metres of one copy of the picture, or None without a picture."""
        return self.material.tile_m
