"""Material -> `<texture>` and `<material>`.

MuJoCo's own renderer draws one colour image per material. Maps of roughness and normals would have to be `<layer>`
elements, which MuJoCo does not accept together with the `texture` attribute, the only one that robosuite knows. So only
the colour image is written, metallic and roughness are one number each for the whole surface; only USD has the maps.
"""

from __future__ import annotations

import io

from lxml import etree
from PIL import Image, ImageStat

from casa_assets.export.mjcf import number
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material, Texture

FOLDER = "textures"
# MuJoCo multiplies shininess by this to get the exponent of the highlight. Ref: MuJoCo XML reference, asset/material.
FULL_EXPONENT = 128.0


def names(asset: Asset) -> dict[str, str]:
    """Material id -> name in the document, unique per content: consumers merge materials of many models by name."""
    return {m.id: f"{m.id}_{m.digest[:12]}" for m in asset.materials}


def textures(asset: Asset) -> dict[str, Texture]:
    """Path relative to model.xml -> colour image, in the order of first use."""
    images = [m.base_color_texture for m in asset.materials]
    return {path(image): image for image in images if image is not None}


def add_all(assets: etree._Element, asset: Asset) -> None:
    """Every `<texture>`, then every `<material>`, below `<asset>`."""
    for path, image in textures(asset).items():
        add_texture(assets, image, path)
    for material, name in zip(asset.materials, names(asset).values(), strict=True):
        add(assets, material, name)


def add_texture(assets: etree._Element, image: Texture, path: str) -> None:
    """`<texture>` of an image whose file is at `path`, relative to the document."""
    etree.SubElement(assets, "texture", {"name": _stem(image), "type": "2d", "file": path})


def add(assets: etree._Element, material: Material, name: str) -> None:
    """`<material>` named `name`, with a reference to the texture of its colour image."""
    etree.SubElement(assets, "material", _attributes(material, name))


def _attributes(material: Material, name: str) -> dict[str, str]:
    metallic, roughness = _mean_metallic_roughness(material)
    attributes = {"name": name}
    if material.base_color_texture is not None:
        attributes |= {"texture": _stem(material.base_color_texture), "texuniform": "false"}
    attributes |= {
        "rgba": number.srgb(material.base_color),
        "specular": number.number(_specular(metallic, roughness)),
        "shininess": number.number(_shininess(roughness)),
        "metallic": number.number(metallic),
        "roughness": number.number(roughness),
    }
    if material.glow:
        attributes["emission"] = number.number(material.glow)
    return attributes


def _mean_metallic_roughness(material: Material) -> tuple[float, float]:
    """Metallic and roughness of the whole surface: the factors times the mean of their map, three digits."""
    metallic, roughness = material.metallic, material.roughness
    if material.metallic_roughness_texture is not None:
        with Image.open(io.BytesIO(material.metallic_roughness_texture.png)) as image:
            _, green, blue = ImageStat.Stat(image.convert("RGB")).mean
        metallic, roughness = metallic * blue / 255, roughness * green / 255
    return round(metallic, 3), round(roughness, 3)


def _specular(metallic: float, roughness: float) -> float:
    """Strength of the highlight, 0..1: zero on rough surfaces, full on polished metal. Chosen by eye."""
    return (1.0 - roughness) * (0.4 + 0.6 * metallic)


def _shininess(roughness: float) -> float:
    """Width of the highlight, 0..1, from the Blinn-Phong exponent 2 / a^2 - 2 with a = roughness^2.

    Ref: Walter et al. 2007, Microfacet models for refraction; the exponent is capped at MuJoCo's largest.
    """
    alpha = max(roughness, 0.05) ** 2
    return min(1.0, (2.0 / alpha**2 - 2.0) / FULL_EXPONENT)


def path(image: Texture) -> str:
    """Path of an image, relative to model.xml or to the folder that scenes share."""
    return f"{FOLDER}/{image.file_name}"


def _stem(image: Texture) -> str:
    return image.file_name.removesuffix(".png")
