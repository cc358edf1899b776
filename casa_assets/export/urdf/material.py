"""Material -> MTL file next to the meshes, and `<material>` if it has a plain colour only.

A `<material>` overrides the material in a mesh file, and few programs read a `<texture>` in it. So a visual with a
picture has no `<material>`: the MTL file names the picture. The picture is in the folder of the MTL file, since trimesh
ignores pictures in other folders.
"""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.material import Material


def file_name(material: Material) -> str:
    """`<id>_<digest>.mtl`: the same material twice is one file."""
    return f"{material.id}_{material.digest[:12]}.mtl"


def add(visual: etree._Element, material: Material) -> None:
    """`<material>` below `<visual>`, unless the material has a picture; its name is unique per content."""
    if material.base_color_texture is None:
        element = etree.SubElement(visual, "material", {"name": file_name(material).removesuffix(".mtl")})
        etree.SubElement(element, "color", {"rgba": number.srgb(material.base_color)})


def mtl_text(material: Material) -> bytes:
    """MTL text: colour and emitted light as display values, opacity, roughness and metallic, and the picture."""
    lines = [
        f"newmtl {material.id}",
        f"Kd {number.srgb(material.base_color[:3])}",
        f"Ke {number.srgb([material.glow * c for c in material.base_color[:3]])}",
        f"d {number.number(material.base_color[3])}",
        f"Pr {number.number(material.roughness)}",
        f"Pm {number.number(material.metallic)}",
    ]
    if material.base_color_texture is not None:
        lines.append(f"map_Kd {material.base_color_texture.file_name}")
    return ("\n".join(lines) + "\n").encode("ascii")
