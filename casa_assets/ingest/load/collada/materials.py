"""COLLADA materials and effects -> Material."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.collada.guarded_xml import (
    Document,
    Element,
    children,
    find_path,
    floats_of,
    local_name,
    text_of,
)
from casa_assets.ingest.load.image import Images, ImageUse, linear_from_srgb
from casa_assets.ingest.load.names import UniqueNames
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.model.asset.material import ColorSpace, Material, Texture

_SHADERS = ("phong", "lambert", "blinn", "constant")
_BLACK = 0.02


@dataclass(frozen=True)
class Surface:
    """A material and the texture coordinates symbol of its picture (empty where it has none)."""

    material: Material
    texcoord: str = ""


@dataclass
class Surfaces:
    """Reads each material of one document once."""

    document: Document
    files: Mapping[str, bytes]
    images: Images
    notes: Notes
    names: UniqueNames = field(default_factory=UniqueNames)
    _read: dict[str, Surface] = field(default_factory=dict)

    def surface(self, url: str | None) -> Surface:
        """Surface of the material that `#id` names; a grey one where there is none."""
        key = url or ""
        if key not in self._read:
            node = self.document.target(url)
            if node is None:
                if key:
                    message = f"material {printable(key, 40)!r} is not described; a grey one is used"
                    self.notes.add(codes.MATERIAL_MISSING, key, message)
                self._read[key] = Surface(Material(id=self.names.unique(key.removeprefix("#"), "material")))
            else:
                self._read[key] = self._surface(node)
        return self._read[key]

    def _surface(self, node: Element) -> Surface:
        name = node.get("name") or node.get("id") or "material"
        instance = find_path(node, "instance_effect")
        effect = self.document.target(instance.get("url") if instance is not None else None)
        profile = find_path(effect, "profile_COMMON")
        shader = next(children(find_path(profile, "technique"), *_SHADERS), None)
        if profile is None or shader is None:
            self.notes.add(codes.MATERIAL_MISSING, name, "a material without a common effect; a grey one is used")
            return Surface(Material(id=self.names.unique(name, "material")))
        slot = self._color_slot(shader)
        file, texcoord = self._file(profile, find_path(slot, "texture"))
        transparent = find_path(shader, "transparent")
        look = ImageUse(ColorSpace.SRGB, "keep" if find_path(transparent, "texture") is not None else "drop")
        texture = self._texture(file, f"{name}_color", look)
        color = (1.0, 1.0, 1.0) if texture is not None else self._rgb(slot, name)
        material = Material(
            id=self.names.unique(name, "material"),
            base_color=(*color, self._alpha(shader, transparent, name)),
            roughness=self._roughness(shader, name),
            base_color_texture=texture,
        )
        return Surface(material, texcoord if texture is not None else "")

    def _color_slot(self, shader: Element) -> Element | None:
        """Diffuse, or what glows where the diffuse colour is black (unlit exports)."""
        diffuse, emission = find_path(shader, "diffuse"), find_path(shader, "emission")
        if find_path(diffuse, "texture") is not None or emission is None:
            return diffuse
        glow = floats_of(find_path(emission, "color"))[:3]
        glows = find_path(emission, "texture") is not None or (len(glow) == 3 and bool((glow > _BLACK).any()))
        plain = floats_of(find_path(diffuse, "color"))[:3]
        if glows and (diffuse is None or (len(plain) == 3 and bool((plain <= _BLACK).all()))):
            self.notes.add(
                codes.EMISSIVE_AS_BASE, local_name(shader), "black surface that glows: its glow is its colour"
            )
            return emission
        return diffuse

    def _rgb(self, slot: Element | None, name: str) -> tuple[float, float, float]:
        values = floats_of(find_path(slot, "color"))
        if len(values) < 3 or not np.isfinite(values[:3]).all():
            if find_path(slot, "color") is not None:
                self.notes.add(codes.BAD_VALUE, f"{name}/diffuse", "the colour is not three numbers; grey is used")
            return (0.8, 0.8, 0.8)
        r, g, b = (linear_from_srgb(float(v)) for v in values[:3])
        return (r, g, b)

    def _alpha(self, shader: Element, transparent: Element | None, name: str) -> float:
        """Opacity in (0, 1]. Ref: COLLADA 1.4.1, "Determining Transparency (Opacity) in COLLADA"."""
        if transparent is None:
            return 1.0
        amount = floats_of(find_path(shader, "transparency", "float"))
        share = float(amount[0]) if len(amount) and np.isfinite(amount[0]) else 1.0
        color = floats_of(find_path(transparent, "color"))
        alpha = 1.0
        if len(color) == 4 and np.isfinite(color).all():
            if transparent.get("opaque", "A_ONE") == "RGB_ZERO":
                alpha = 1.0 - share * float(color[:3].mean())
            else:
                alpha = share * float(color[3])
        if alpha <= 0.0:
            self.notes.add(codes.FULLY_TRANSPARENT, name, "transparency would hide it; made opaque")
            return 1.0
        return min(1.0, alpha)

    def _roughness(self, shader: Element, name: str) -> float:
        """0..1 guessed from the Phong exponent. Ref: Blinn-Phong, exponent = 2 / roughness^4 - 2."""
        values = floats_of(find_path(shader, "shininess", "float"))
        if not len(values):
            return 0.6
        if not np.isfinite(values[0]) or values[0] < 0:
            self.notes.add(codes.BAD_VALUE, f"{name}/shininess", "shininess is not a number >= 0; ignored")
            return 0.6
        # many exporters write 0..1 where an exponent is meant; those say nothing
        exponent = float(values[0])
        return 0.6 if exponent <= 1.0 else float(min(0.9, max(0.2, (2.0 / (exponent + 2.0)) ** 0.25)))

    def _texture(self, file: str, name: str, look: ImageUse) -> Texture | None:
        data = self.files.get(file) if file else None
        return None if data is None else self.images.texture(file, data, name, look)

    def _file(self, profile: Element, texture: Element | None) -> tuple[str, str]:
        """File name as written, and the texture coordinates symbol."""
        if texture is None:
            return "", ""
        params = {p.get("sid", ""): p for p in children(profile, "newparam")}
        params.update({p.get("sid", ""): p for p in children(find_path(profile, "technique"), "newparam")})
        key = texture.get("texture", "")
        sampler = find_path(params.get(key), "sampler2D")
        if sampler is not None:
            direct = find_path(sampler, "instance_image")
            if direct is not None:
                key = direct.get("url", "").removeprefix("#")
            else:
                surface = find_path(params.get(text_of(find_path(sampler, "source"))), "surface", "init_from")
                key = text_of(surface)
        return image_file(self.document.target(key)), texture.get("texcoord", "")


def image_file(image: Element | None) -> str:
    """File name of an <image>, as written; empty where there is none."""
    place = find_path(image, "init_from")
    inner = find_path(place, "ref")
    return text_of(inner if inner is not None else place)
