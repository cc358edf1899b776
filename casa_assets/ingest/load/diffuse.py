"""Materials of formats that say a colour and a picture, as FBX, USD, 3DS and X3D do -> Material."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.image import Images, ImageUse
from casa_assets.ingest.load.names import UniqueNames
from casa_assets.ingest.load.notes import Notes
from casa_assets.model.asset.material import ColorSpace, Material


@dataclass(frozen=True)
class Look:
    """Look of a surface, as a file says it.

    Attributes:
        name: of the material.
        color: linear RGB, 0..1, beside a picture its tint.
        opacity: 0..1.
        metallic, roughness: 0..1.
        picture: key and bytes of the colour picture, or None.
    """

    name: str
    color: tuple[float, float, float] = (0.8, 0.8, 0.8)
    opacity: float = 1.0
    metallic: float = 0.0
    roughness: float = 0.6
    picture: tuple[str, bytes] | None = None


class Materials:
    """Makes a Material of each look once."""

    def __init__(self, limits: Mapping[str, float], notes: Notes) -> None:
        self._images, self._notes = Images(limits, notes), notes
        self._names = UniqueNames()
        self._made: dict[object, Material] = {}

    def material(self, key: object, look: Look) -> Material:
        """The material of a look; `key` tells the looks of one file apart."""
        if key not in self._made:
            self._made[key] = self._make(look)
        return self._made[key]

    def knows(self, key: object) -> Material | None:
        """The material that was made under a key, or None."""
        return self._made.get(key)

    def _make(self, look: Look) -> Material:
        opacity = _unit(look.opacity, 1.0)
        if opacity <= 0.0:
            self._notes.add(codes.FULLY_TRANSPARENT, look.name, "alpha 0 would hide it; made opaque")
            opacity = 1.0
        texture = None
        if look.picture is not None:
            use = ImageUse(ColorSpace.SRGB, "keep" if opacity < 1.0 else 0.5)
            texture = self._images.texture(*look.picture, f"{look.name}_color", use)
        r, g, b = (_unit(c, 0.8) for c in look.color)
        return Material(
            id=self._names.unique(look.name, "material"),
            base_color=(r, g, b, opacity),
            metallic=_unit(look.metallic, 0.0),
            roughness=_unit(look.roughness, 0.6),
            base_color_texture=texture,
        )


def _unit(value: float, default: float) -> float:
    """A number brought into 0..1; the default where it is none."""
    return min(1.0, max(0.0, value)) if math.isfinite(value) else default
