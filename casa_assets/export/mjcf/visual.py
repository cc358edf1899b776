"""Visual -> geom that is only drawn, without mass and contacts; mesh -> OBJ file and `<mesh>` element."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import MAX_HULL_VERTICES, Hull, MeshShape

FOLDER = "meshes"


class MeshUse(StrEnum):
    """Purpose of a mesh; the value is MuJoCo's `inertia` of the mesh."""

    HULL = "convex"  # exact for a closed convex mesh
    SURFACE = "shell"  # asks for no volume: open, flat and inside-out meshes load too


@dataclass(frozen=True)
class MeshFile:
    """A `<mesh>` and the file behind it.

    Attributes:
        name: unique per content, since consumers merge the assets of many models by name.
        path: relative to model.xml.
        data: OBJ text.
        use: hull or surface.
    """

    name: str
    path: str
    data: bytes
    use: MeshUse


@dataclass(frozen=True)
class Meshes:
    """The mesh files of an asset, in the order of first use; `of` maps a visual's or collider's name to its mesh."""

    files: tuple[MeshFile, ...]
    of: dict[str, MeshFile]


def add(body: etree._Element, visual: Visual, file: MeshFile, material: str, group: int, prefix: str = "") -> None:
    """`<geom>` below `<body>`; `material`: name of a `<material>`; `prefix`: prefix of the geom's name."""
    attributes = {
        "name": prefix + visual.name,
        "type": "mesh",
        "mesh": file.name,
        "material": material,
        "group": str(group),
        "contype": "0",
        "conaffinity": "0",
        "mass": "0",
    }
    etree.SubElement(body, "geom", attributes)


def gather_meshes(asset: Asset) -> Meshes:
    """Mesh files of every visual and of every collider that is a mesh."""
    paths: dict[str, str] = {}
    known: dict[tuple[str, MeshUse], MeshFile] = {}
    of: dict[str, MeshFile] = {}
    for name, mesh, use in mesh_uses(asset):
        data = obj_text(mesh, bare=use is MeshUse.HULL)
        content = hashlib.sha256(data).hexdigest()
        path = paths.setdefault(content, f"{FOLDER}/{name}_{content[:12]}.obj")
        of[name] = known.setdefault((content, use), MeshFile(f"{name}_{content[:12]}", path, data, use))
    return Meshes(tuple(known.values()), of)


def mesh_uses(asset: Asset) -> list[tuple[str, Mesh, MeshUse]]:
    """(name of the visual or collider, its mesh, its use) of every visual and collider that is a mesh."""
    items: list[tuple[str, Mesh, MeshUse]] = []
    for link in asset.links:
        items += [(v.name, v.mesh, MeshUse.SURFACE) for v in link.visuals]
        for c in link.colliders:
            if isinstance(c.shape, Hull | MeshShape):
                use = MeshUse.HULL if isinstance(c.shape, Hull) else MeshUse.SURFACE
                items.append((c.name, c.shape.mesh, use))
    return items


def add_mesh(assets: etree._Element, file: MeshFile, folder: str = "") -> None:
    """`<mesh>` below `<asset>`; `folder`: path from the document to the mesh files, empty if they are next to it."""
    path = f"{folder}/{file.path}" if folder else file.path
    attributes = {"name": file.name, "file": path, "inertia": file.use.value}
    if file.use is MeshUse.HULL:
        attributes["maxhullvert"] = str(MAX_HULL_VERTICES)
    etree.SubElement(assets, "mesh", attributes)


def obj_text(mesh: Mesh, bare: bool = False) -> bytes:
    """OBJ text with values rounded to float32; one index is used for position, texture coordinate and normal.

    Args:
        mesh: triangles, metres.
        bare: leave out texture coordinates and normals.
    """
    uv, normals = (None, None) if bare else (mesh.uv, mesh.normals)
    text = number.rows("v", mesh.vertices)
    if uv is not None:
        text += number.rows("vt", uv)
    if normals is not None:
        text += number.rows("vn", normals)
    corner = "%d" + ("/%d" if uv is not None else "/" if normals is not None else "")
    corner += "/%d" if normals is not None else ""
    line = "f " + " ".join([corner] * 3) + "\n"
    index = np.repeat(mesh.faces.ravel() + 1, corner.count("%d"))
    text += (line * len(mesh.faces)) % tuple(index.tolist())
    return text.encode("ascii")
