"""Assets of a scene -> its meshes, images and materials, each once, in a folder that scenes share."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from lxml import etree

from casa_assets.export.mjcf import material, visual
from casa_assets.export.mjcf.visual import Meshes, MeshFile, MeshUse
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material, Texture

# Hexadecimal digits of a mesh's name: of a million meshes two share one with a probability of 1e-13.
HASH_DIGITS = 24
# The folder that scenes share, in the paths that the writer returns.
FOLDER = "assets"


@dataclass(frozen=True)
class SceneResources:
    """Meshes, images and materials that the assets of a scene share.

    Attributes:
        meshes: asset id -> its meshes; their paths are relative to the shared folder.
        textures: path relative to the shared folder -> image.
        materials: name in the document -> material.
    """

    meshes: dict[str, Meshes]
    textures: dict[str, Texture]
    materials: dict[str, Material]

    @property
    def mesh_files(self) -> tuple[MeshFile, ...]:
        """Every `<mesh>` once, in the order of first use."""
        return tuple({file.name: file for meshes in self.meshes.values() for file in meshes.files}.values())

    @property
    def entries(self) -> dict[str, bytes]:
        """`assets/...` -> content."""
        found = {f"{FOLDER}/{file.path}": file.data for file in self.mesh_files}
        return found | {f"{FOLDER}/{path}": image.png for path, image in self.textures.items()}


def gather(assets: Sequence[Asset]) -> SceneResources:
    """Collect meshes, images and materials of assets; meshes are named by content, so equal ones share a file."""
    textures: dict[str, Texture] = {}
    materials: dict[str, Material] = {}
    for asset in assets:
        textures |= material.textures(asset)
        materials |= {material_name(asset.id, item.id): item for item in asset.materials}
    return SceneResources({asset.id: _meshes(asset) for asset in assets}, textures, materials)


def material_name(asset: str, item: str) -> str:
    """Name of a material in the document of a scene."""
    return f"{asset}__{item}"


def add_all(assets: etree._Element, resources: SceneResources, folder: str) -> None:
    """Every `<texture>`, `<material>` and `<mesh>` below `<asset>`; `folder`: path from the document to the files."""
    for path, image in resources.textures.items():
        material.add_texture(assets, image, f"{folder}/{path}")
    for name, item in resources.materials.items():
        material.add(assets, item, name)
    for file in resources.mesh_files:
        visual.add_mesh(assets, file, folder)


def _meshes(asset: Asset) -> Meshes:
    of: dict[str, MeshFile] = {}
    for name, mesh, use in visual.mesh_uses(asset):
        data = visual.obj_text(mesh, bare=use is MeshUse.HULL)
        content = hashlib.sha256(data).hexdigest()[:HASH_DIGITS]
        # A surface without normals may have the very file of a hull; MuJoCo takes the two for different meshes.
        mesh_name = content if use is MeshUse.SURFACE else f"{content}__{use.value}"
        of[name] = MeshFile(mesh_name, f"{visual.FOLDER}/{content}.obj", data, use)
    return Meshes(tuple({file.name: file for file in of.values()}.values()), of)
