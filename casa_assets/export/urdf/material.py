"""Material -> MTL file beside the meshes, and `<material>` where a plain colour is all of it.

A `<material>` takes the place of what a mesh file says of its look, and a `<texture>` in it is read by few programs. So
a visual with a picture has none: the MTL file names the picture. It lies beside the MTL file, since trimesh leaves out
pictures of other folders.
"""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.material import Material


def file_name(material: Material) -> str:
    """`<id>_<digest>.mtl`: the same material twice is one file."""
    return f"{material.id}_{material.digest[:12]}.mtl"


def add(visual: etree._Element, material: Material) -> None:
    """`<material>` below `<visual>`, where the material has no picture; its name is unique per content."""
    if material.base_color_texture is None:
        element = etree.SubElement(visual, "material", {"name": file_name(material).removesuffix(".mtl")})
        etree.SubElement(element, "color", {"rgba": number.srgb(material.base_color)})


def mtl_text(material: Material) -> bytes:
    """MTL text: colour and light given off as display values, opacity, roughness and metallic, and the picture."""
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
