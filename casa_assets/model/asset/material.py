"""Materials (appearance: Material, Texture) and substances (physics: density, friction)."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, field_validator, model_validator

from casa_assets.model.record import Id, Record

Unit = Annotated[float, Field(ge=0.0, le=1.0)]
Positive = Annotated[float, Field(gt=0.0)]


class ColorSpace(StrEnum):
    """Encoding of the numbers in an image: colour (sRGB) or data (linear)."""

    SRGB = "sRGB"
    RAW = "raw"


class Texture(Record):
    """An image, PNG bytes.

    Attributes:
        name: stem of the file that it is written to (a content hash is added). png: encoded PNG, 8 bit RGB or RGBA.
        width_px, height_px: size of the image. color_space: sRGB for colours, raw for normals and roughness.
    """

    name: Id
    png: bytes
    width_px: Annotated[int, Field(ge=1, le=16384)]
    height_px: Annotated[int, Field(ge=1, le=16384)]
    color_space: ColorSpace = ColorSpace.SRGB

    @field_validator("png")
    @classmethod
    def _is_png(cls, png: bytes) -> bytes:
        if not png.startswith(b"\x89PNG\r\n\x1a\n"):
            raise ValueError("not a PNG file")
        return png

    @cached_property
    def file_name(self) -> str:
        """`<name>_<12 hex digits of the content>.png`: the same image twice is one file."""
        return f"{self.name}_{hashlib.sha256(self.png).hexdigest()[:12]}.png"


class Material(Record):
    """Metallic-roughness surface (the glTF 2.0 model).

    Attributes:
        id: unique within the asset. base_color: linear RGBA in 0..1, multiplied with the texture.
        metallic, roughness: 0..1, multiplied with the texture's channels. base_color_texture: sRGB image or None.
        metallic_roughness_texture: raw image, green roughness and blue metallic, or None.
        normal_texture: raw tangent-space normals, y up, or None.
        tile_m: width and height in metres of one copy of its images if they repeat; None if an image is made for one
            mesh, or without images. Texture coordinates of meshes are metres divided by this.
        glow: 0..1, share of the base colour that it emits (a lamp, a display).
        substance: id of the substance that it shows, used as a semantic label.
    """

    id: Id
    base_color: tuple[Unit, Unit, Unit, Unit] = (0.8, 0.8, 0.8, 1.0)
    metallic: Unit = 0.0
    roughness: Unit = 0.6
    base_color_texture: Texture | None = None
    metallic_roughness_texture: Texture | None = None
    normal_texture: Texture | None = None
    tile_m: tuple[Positive, Positive] | None = None
    glow: Unit = 0.0
    substance: Id = "unknown"

    @property
    def textures(self) -> tuple[Texture, ...]:
        """Every image of the material, in a fixed order."""
        slots = (self.base_color_texture, self.metallic_roughness_texture, self.normal_texture)
        return tuple(t for t in slots if t is not None)


class Density(Record):
    """Mean density of a part that is modelled as a solid but is not: hollow, thin, porous, or full of other objects.

    Attributes:
        id: such as `hood_body`.
        kg_m3: mean density of the modelled volume, kg/m^3; None if a substance and its share of that volume are given.
        substance: id of a substance. fill: share of the modelled volume that the substance takes, 0..1.
        why: its real contents, and the source of the number if one is known.
    """

    id: Id
    kg_m3: Positive | None = None
    substance: Id | None = None
    fill: Annotated[float, Field(gt=0, le=1)] = 1.0
    why: str

    @model_validator(mode="after")
    def _is_one_of_both(self) -> Self:
        if (self.kg_m3 is None) == (self.substance is None):
            raise ValueError("either kg_m3 or a substance")
        if self.substance is None and "fill" in self.model_fields_set:
            raise ValueError("fill is the share of a substance")
        return self


class Substance(Record):
    """Physical material: density and friction.

    Attributes:
        id: such as `ceramic`. density: kg/m^3 of the material itself.
        static_friction, dynamic_friction: Coulomb coefficients against a dry worktop, > 0.
        torsional_friction, rolling_friction: metres, as in MuJoCo's geom friction.
        metallic, roughness: appearance if a source states none.
    """

    id: Id
    density: Positive
    static_friction: Positive
    dynamic_friction: Positive
    torsional_friction: Positive = 0.005
    rolling_friction: Positive = 0.0001
    metallic: Unit = 0.0
    roughness: Unit = 0.6


@dataclass(frozen=True)
class PrintedLine:
    """A line of letters in the picture of a material.

    Attributes:
        text: as it is written.
        cover: (H, W) share of each pixel of the picture that its letters cover, 0..1; row 0 is the upper edge.
        runs_upwards: its baseline runs upwards in the picture.
    """

    text: str
    cover: npt.NDArray[np.floating[Any]]
    runs_upwards: bool
