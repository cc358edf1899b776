"""Materials and images of a glTF -> Material, with the texture coordinates that they want."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.numeric import Floats
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf_document import (
    Accessors,
    JsonObject,
    data_uri,
)
from casa_assets.ingest.load.materials import Images, ImageUse
from casa_assets.ingest.load.notes import Notes
from casa_assets.ingest.load.text import UniqueNames
from casa_assets.model.asset.material import ColorSpace, Material, Texture

_BLACK = 0.02


@dataclass(frozen=True)
class Mapping2D:
    """Texture coordinate set of a picture and its transform (KHR_texture_transform).

    Attributes:
        uv_set: n of TEXCOORD_n.
        offset, scale: in glTF texture space (origin at the upper left).
        rotation: rad, counter-clockwise.
    """

    uv_set: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    rotation: float = 0.0

    def apply(self, uv: Floats) -> Floats:
        """(V, 2) glTF texture coordinates -> ours, origin at the lower left; turned as three.js and Blender do."""
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        u, v = uv[:, 0] * self.scale[0], uv[:, 1] * self.scale[1]
        moved_u = c * u + s * v + self.offset[0]
        moved_v = -s * u + c * v + self.offset[1]
        return np.column_stack((moved_u, 1.0 - moved_v))


@dataclass(frozen=True)
class Surface:
    """A material and the mapping of its pictures (None if they have no mapping)."""

    material: Material
    mapping: Mapping2D | None = None


@dataclass
class Surfaces:
    """Reads each material of one document once."""

    document: JsonObject
    accessors: Accessors
    files: Mapping[str, bytes]
    images: Images
    notes: Notes
    names: UniqueNames = field(default_factory=UniqueNames)
    _read: dict[int | None, Surface] = field(default_factory=dict)

    def surface(self, index: int | None) -> Surface:
        """Surface of material `index`; the glTF default where None."""
        if index not in self._read:
            if index is None:
                # Ref: glTF 2.0, 3.9.6: the default material is white; here rough and not metallic
                material = Material(id=self.names.unique("default", "material"), base_color=(1.0, 1.0, 1.0, 1.0))
                self._read[index] = Surface(material)
            else:
                self._read[index] = self._surface(self.document.pick(index, "materials"))
        return self._read[index]

    def _surface(self, node: JsonObject) -> Surface:
        pbr = node.child("pbrMetallicRoughness")
        old = node.child("extensions").child("KHR_materials_pbrSpecularGlossiness")
        if old.value:
            color_node, color = old.child("diffuseTexture"), old.numbers("diffuseFactor", (1.0, 1.0, 1.0, 1.0))
            metallic, roughness = 0.0, 1.0 - old.number("glossinessFactor", 1.0)
            rough_node = JsonObject({}, old.place)
        else:
            color_node, color = pbr.child("baseColorTexture"), pbr.numbers("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
            metallic, roughness = pbr.number("metallicFactor", 1.0), pbr.number("roughnessFactor", 1.0)
            rough_node = pbr.child("metallicRoughnessTexture")
        if not pbr.value and not old.value:
            metallic, roughness = 0.0, 0.9
        color_node, color = self._emissive(node, color_node, color)
        alpha, color = self._alpha(node, color)
        name = node.text("name") or "material"
        base_picture = self._picture(color_node, f"{name}_color", ImageUse(ColorSpace.SRGB, alpha))
        rough_picture = self._picture(rough_node, f"{name}_rough", ImageUse(ColorSpace.RAW, "drop"))
        normal_picture = self._picture(node.child("normalTexture"), f"{name}_normal", ImageUse(ColorSpace.RAW, "drop"))
        mapping, base, rough, normal = self._one_mapping(node.place, base_picture, rough_picture, normal_picture)
        return Surface(
            Material(
                id=self.names.unique(name, "material"),
                base_color=_unit4(color),
                metallic=_unit(metallic),
                roughness=_unit(roughness),
                base_color_texture=base,
                metallic_roughness_texture=rough,
                normal_texture=normal,
            ),
            mapping,
        )

    def _emissive(
        self, node: JsonObject, picture: JsonObject, color: tuple[float, ...]
    ) -> tuple[JsonObject, tuple[float, ...]]:
        """A black surface whose picture glows is an unlit export: the picture is its colour."""
        glow = node.numbers("emissiveFactor", (0.0, 0.0, 0.0))
        is_black = max(color[:3]) <= _BLACK
        if not is_black or max(glow) <= _BLACK or (picture.value and not node.has("emissiveTexture")):
            return picture, color
        self.notes.add(codes.EMISSIVE_AS_BASE, node.place, "black surface that glows: its glow is its colour")
        return node.child("emissiveTexture"), (*glow, color[3])

    def _alpha(self, node: JsonObject, color: tuple[float, ...]) -> tuple[str | float, tuple[float, ...]]:
        mode = node.text("alphaMode") or "OPAQUE"
        if mode == "OPAQUE":
            return "drop", (*color[:3], 1.0)
        if color[3] <= 0.0:
            self.notes.add(codes.FULLY_TRANSPARENT, node.place, "alpha 0 would hide it; made opaque")
            return "drop", (*color[:3], 1.0)
        if mode == "MASK":
            return min(1.0, node.number("alphaCutoff", 0.5) / color[3]), (*color[:3], 1.0)
        return "keep", color

    def _picture(self, node: JsonObject, name: str, look: ImageUse) -> tuple[Texture, Mapping2D] | None:
        if not node.has("index"):
            return None
        texture = self.document.pick(node.count("index"), "textures")
        sources = self._sources(texture)
        if not sources:
            self.notes.add(codes.IMAGE_UNREADABLE, texture.place, "a texture without a readable image; left out")
        for source in sources:
            image = self.document.pick(source, "images")
            data = self._image_bytes(image)
            made = data and self.images.texture(f"image {source}", data, image.text("name") or name, look)
            if made:
                return made, _mapping(node)
        return None

    def _sources(self, texture: JsonObject) -> list[int]:
        """Images of a texture, best first: those of an extension, then the one for programs that do not know it."""
        extensions = texture.child("extensions")
        nodes = (extensions.child("EXT_texture_webp"), extensions.child("KHR_texture_basisu"), texture)
        return [node.count("source") for node in nodes if node.has("source")]

    def _image_bytes(self, image: JsonObject) -> bytes | None:
        if image.has("bufferView"):
            try:
                return self.accessors.view_bytes(image.count("bufferView"))
            except Rejected as error:
                self.notes.add(codes.IMAGE_UNREADABLE, image.place, f"embedded image left out: {error.message}")
                return None
        uri = image.text("uri")
        if uri.startswith("data:"):
            try:
                return data_uri(uri, image.place)
            except Rejected as error:
                self.notes.add(codes.IMAGE_UNREADABLE, image.place, f"embedded image left out: {error.message}")
                return None
        return self.files.get(uri)

    def _one_mapping(
        self, place: str, *pictures: tuple[Texture, Mapping2D] | None
    ) -> tuple[Mapping2D | None, Texture | None, Texture | None, Texture | None]:
        """The leading picture's mapping; pictures laid out otherwise are left out with a note."""
        lead = next((p[1] for p in pictures if p is not None), None)
        kept: list[Texture | None] = []
        for picture in pictures:
            fits = picture is not None and picture[1] == lead
            if picture is not None and not fits:
                self.notes.add(codes.UV_SET_MIXED, place, f"{picture[0].name} uses other texture coordinates; left out")
            kept.append(picture[0] if picture is not None and fits else None)
        return lead, kept[0], kept[1], kept[2]


def _mapping(node: JsonObject) -> Mapping2D:
    moved = node.child("extensions").child("KHR_texture_transform")
    offset, scale = moved.numbers("offset", (0.0, 0.0)), moved.numbers("scale", (1.0, 1.0))
    return Mapping2D(
        uv_set=moved.count("texCoord", node.count("texCoord", 0)),
        offset=(offset[0], offset[1]),
        scale=(scale[0], scale[1]),
        rotation=moved.number("rotation", 0.0),
    )


def _unit(value: float) -> float:
    return min(1.0, max(0.0, value))


def _unit4(color: tuple[float, ...]) -> tuple[float, float, float, float]:
    r, g, b, a = (_unit(c) for c in color)
    return (r, g, b, a)
