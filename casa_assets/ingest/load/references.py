"""Main file -> the names of other files that it refers to, as written there."""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from casa_assets.ingest.load.collada.guarded_xml import children, open_dae
from casa_assets.ingest.load.collada.materials import image_file
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.gltf.container import open_document
from casa_assets.ingest.load.max3ds import reader as max3ds
from casa_assets.ingest.load.ply.table import read_header
from casa_assets.ingest.load.text import decode, normalize_text
from casa_assets.ingest.load.vrml import reader as vrml
from casa_assets.ingest.load.wavefront.materials import MAPS, map_file, statements

# A hostile file may name thousands of files.
MAX_REFERENCES = 500


class Role(StrEnum):
    """Role of a referenced file: buffers are required, pictures and materials may be missing."""

    BUFFER = "buffer"
    MATERIAL = "material"
    IMAGE = "image"
    LAYER = "layer"


@dataclass(frozen=True)
class Reference:
    """A name as written in the file, and what it is for."""

    name: str
    role: Role


def references(file_format: Format, data: bytes, name: str) -> list[Reference]:
    """References of a main file, each once, in file order.

    Raises:
        Rejected: where the file is so broken that they cannot be told.
    """
    if file_format in (Format.GLB, Format.GLTF):
        found = _of_gltf(data, name)
    elif file_format is Format.OBJ:
        found = _of_obj(data, name)
    elif file_format is Format.DAE:
        root = open_dae(data, name).root
        images = [i for library in children(root, "library_images") for i in children(library, "image")]
        found = [Reference(image_file(i), Role.IMAGE) for i in images]
    elif file_format is Format.PLY:
        header = read_header(data.lstrip(b" \t\r\n"), name)
        found = [Reference(t, Role.IMAGE) for t in header.textures]
    elif file_format is Format.FBX:
        from casa_assets.ingest.load.fbx import reader as fbx

        found = [Reference(n, Role.IMAGE) for n in fbx.picture_names(data, name)]
    elif file_format in (Format.VRML, Format.X3D):
        found = [Reference(n, Role.IMAGE) for n in vrml.picture_names(data, name)]
    elif file_format is Format.MAX_3DS:
        found = [Reference(n, Role.IMAGE) for n in max3ds.picture_names(data, name)]
    else:
        found = []
    return list(dict.fromkeys(r for r in found if r.name and not r.name.startswith("data:")))[:MAX_REFERENCES]


def mtl_references(data: bytes, name: str) -> list[Reference]:
    """Pictures of an MTL file that a reader here can use, each once."""
    files = [map_file(rest) for key, rest in statements(data, name) if key in MAPS]
    return [Reference(f, Role.IMAGE) for f in dict.fromkeys(files) if f][:MAX_REFERENCES]


def layer_references(data: bytes, name: str) -> list[Reference]:
    """Layers and pictures that a USD layer names.

    Raises:
        Rejected: SCENE_UNREADABLE.
    """
    from casa_assets.ingest.load.usd.layers import asset_paths

    with tempfile.TemporaryDirectory(prefix="casa_usd_") as folder:
        layers, files = asset_paths(data, name, Path(folder))
    pictures = [Reference(f, Role.IMAGE) for f in files if not f.lower().endswith((".usd", ".usda", ".usdc", ".usdz"))]
    return [Reference(layer, Role.LAYER) for layer in layers] + pictures


def _of_gltf(data: bytes, name: str) -> list[Reference]:
    document, _ = open_document(data, name)
    buffers = [Reference(b.text("uri"), Role.BUFFER) for b in document.items("buffers")]
    return buffers + [Reference(i.text("uri"), Role.IMAGE) for i in document.items("images")]


def _of_obj(data: bytes, name: str) -> list[Reference]:
    text = normalize_text(data, name)
    found = re.findall(rb"^[ \t]*mtllib[ \t]+([^\n]+)", text, re.MULTILINE)
    return [Reference(decode(f).strip(), Role.MATERIAL) for f in found]
