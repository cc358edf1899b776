"""Visual -> `<visual>` and its OBJ and MTL files; the mesh of a collider -> OBJ file without material."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from lxml import etree

from casa_assets.export.mjcf import material as mjcf_material
from casa_assets.export.mjcf.visual import FOLDER, MeshUse, mesh_uses, obj_text
from casa_assets.export.urdf import material, number
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.pose import Pose


@dataclass(frozen=True)
class Meshes:
    """Mesh files of an asset.

    Attributes:
        of: name of a visual or collider -> path of its OBJ file, relative to the URDF.
        entries: path -> bytes of every OBJ, MTL and PNG file.
    """

    of: dict[str, str]
    entries: dict[str, bytes]


def add(
    link: etree._Element, visual: Visual, look: Material, path: str, urdf_from_link: Pose, prefix: str = ""
) -> None:
    """`<visual>` below `<link>`; its name begins with `prefix`."""
    element = etree.SubElement(link, "visual", {"name": prefix + visual.name})
    number.add_origin(element, urdf_from_link)
    add_mesh(element, path)
    material.add(element, look)


def add_mesh(element: etree._Element, path: str) -> None:
    """`<geometry>` with a mesh in metres."""
    etree.SubElement(etree.SubElement(element, "geometry"), "mesh", {"filename": path})


def gather_meshes(asset: Asset) -> Meshes:
    """Files of every visual and of every collider that is a mesh; equal ones share a file."""
    looks = {item.id: item for item in asset.materials}
    shown = {visual.name: looks[visual.material] for link in asset.links for visual in link.visuals}
    of: dict[str, str] = {}
    by_content: dict[str, str] = {}
    entries = {f"{FOLDER}/{image.file_name}": image.png for image in mjcf_material.textures(asset).values()}
    for name, mesh, use in mesh_uses(asset):
        data = obj_text(mesh, bare=use is MeshUse.HULL)
        if name in shown:
            look = shown[name]
            entries[f"{FOLDER}/{material.file_name(look)}"] = material.mtl_text(look)
            data = f"mtllib {material.file_name(look)}\nusemtl {look.id}\n".encode("ascii") + data
        content = hashlib.sha256(data).hexdigest()
        of[name] = by_content.setdefault(content, f"{FOLDER}/{name}_{content[:12]}.obj")
        entries[of[name]] = data
    return Meshes(of, entries)
