"""Material -> metallic-roughness material of glTF, the same model as in the record, with reduced pictures."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from PIL import Image

from casa_assets.export.gltf.binary import Binary
from casa_assets.export.gltf.number import rounded
from casa_assets.model.asset.material import ColorSpace, Material, Texture

COLOR_QUALITY, DATA_QUALITY = 85, 90
# Ref: OpenGL: GL_LINEAR, GL_LINEAR_MIPMAP_LINEAR, GL_REPEAT.
SAMPLER = {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}
# Shares of a picture whose alpha is neither nothing nor all, above which it is see-through and not cut out.
MAX_SOFT_SHARE = 0.05
# Pictures of this process by name, colour space and size: those of all styles, of 60 kB each.
_KEPT: dict[str, tuple[bytes, str, str]] = {}
_MOST_KEPT = 512


@dataclass
class Materials:
    """Materials, textures and images as glTF lists them; equal ones are written once.

    Attributes:
        binary: receives the pictures.
        picture_px: maximum pixels along a side.
    """

    binary: Binary
    picture_px: int
    rows: list[dict[str, Any]] = field(default_factory=list)
    images: list[dict[str, Any]] = field(default_factory=list)
    _index: dict[str, int] = field(default_factory=dict)
    _image_of: dict[str, tuple[int, str]] = field(default_factory=dict)

    def index(self, material: Material) -> int:
        """Index of a material."""
        return self._add(material.digest, lambda: self._row(material))

    def plain(self, name: str, color: Sequence[float]) -> int:
        """Index of a rough material of one linear RGBA colour, seen from both sides."""
        pbr = {"baseColorFactor": rounded(color), "metallicFactor": 0.0, "roughnessFactor": 0.9}
        mode = {} if color[3] >= 1.0 else {"alphaMode": "BLEND"}
        return self._add(name, lambda: {"name": name, "pbrMetallicRoughness": pbr, "doubleSided": True, **mode})

    def document(self) -> dict[str, Any]:
        """Members of the glTF document."""
        found: dict[str, Any] = {"materials": self.rows} if self.rows else {}
        if self.images:
            textures = [{"sampler": 0, "source": i} for i in range(len(self.images))]
            found |= {"images": self.images, "textures": textures, "samplers": [SAMPLER]}
        return found

    def _add(self, key: str, make: Any) -> int:
        if key not in self._index:
            self.rows.append(make())
            self._index[key] = len(self.rows) - 1
        return self._index[key]

    def _row(self, material: Material) -> dict[str, Any]:
        pbr: dict[str, Any] = {
            "baseColorFactor": rounded(material.base_color),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        row: dict[str, Any] = {"name": material.id, "pbrMetallicRoughness": pbr}
        mode = "OPAQUE"
        if material.base_color_texture is not None:
            texture, mode = self._texture(material.base_color_texture)
            pbr["baseColorTexture"] = texture
        if material.base_color[3] < 1.0:
            mode = "BLEND"
        if material.metallic_roughness_texture is not None:
            pbr["metallicRoughnessTexture"], _ = self._texture(material.metallic_roughness_texture)
        if material.normal_texture is not None:
            row["normalTexture"], _ = self._texture(material.normal_texture)
        if material.glow:
            row["emissiveFactor"] = rounded([material.glow * c for c in material.base_color[:3]])
            if material.base_color_texture is not None:
                row["emissiveTexture"] = pbr["baseColorTexture"]
        return row if mode == "OPAQUE" else {**row, "alphaMode": mode}

    def _texture(self, texture: Texture) -> tuple[dict[str, int], str]:
        """Reference to a picture, and the alpha mode that it requires."""
        key = f"{texture.file_name} {texture.color_space.value}"
        if key not in self._image_of:
            content, kind, mode = self._encoded(key, texture)
            view = self.binary.view(content)
            self.images.append({"bufferView": view, "mimeType": kind, "name": texture.name})
            self._image_of[key] = len(self.images) - 1, mode
        index, mode = self._image_of[key]
        return {"index": index}, mode

    def _encoded(self, key: str, texture: Texture) -> tuple[bytes, str, str]:
        """As `encoded`, cached: kitchens of a style have the same pictures."""
        place = f"{key} {self.picture_px}"
        if place not in _KEPT:
            if len(_KEPT) >= _MOST_KEPT:
                _KEPT.clear()
            _KEPT[place] = encoded(texture, self.picture_px)
        return _KEPT[place]


def encoded(texture: Texture, most_px: int) -> tuple[bytes, str, str]:
    """Encode a picture, scaled down to at most `most_px` along a side.

    Returns:
        Its bytes; `image/png` if it has alpha, else `image/jpeg`; and the glTF alpha mode that it requires.
    """
    out = io.BytesIO()
    with Image.open(io.BytesIO(texture.png)) as opened:
        image = opened.convert("RGBA" if "A" in opened.getbands() or "transparency" in opened.info else "RGB")
    if image.mode == "RGBA" and image.getchannel("A").getextrema() == (255, 255):
        image = image.convert("RGB")
    if max(image.size) > most_px:
        image.thumbnail((most_px, most_px), Image.Resampling.LANCZOS)
    if image.mode == "RGBA":
        image.save(out, "PNG", optimize=True)
        alpha = np.asarray(image.getchannel("A"))
        is_soft = float(((alpha > 8) & (alpha < 247)).mean()) > MAX_SOFT_SHARE
        return out.getvalue(), "image/png", "BLEND" if is_soft else "MASK"
    # Halved colour would smear the channels of data into each other.
    is_color = texture.color_space is ColorSpace.SRGB
    quality, sampling = (COLOR_QUALITY, "4:2:0") if is_color else (DATA_QUALITY, "4:4:4")
    image.save(out, "JPEG", quality=quality, subsampling=sampling, optimize=True)
    return out.getvalue(), "image/jpeg", "OPAQUE"
