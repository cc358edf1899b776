"""Main file -> the names of other files that it refers to, as written there."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.ingest.load.collada.guarded_xml import kids, open_dae
from casa_assets.ingest.load.collada.materials import image_file
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.gltf.container import open_document
from casa_assets.ingest.load.ply.table import read_header
from casa_assets.ingest.load.text import decode, plain
from casa_assets.ingest.load.wavefront.materials import MAPS, map_file, statements

# A hostile file may name thousands; no honest one does.
MOST_REFERENCES = 500


class Role(StrEnum):
    """Role of a referenced file: buffers are required, pictures and materials may be missing."""

    BUFFER = "buffer"
    MATERIAL = "material"
    IMAGE = "image"


@dataclass(frozen=True)
class Reference:
    """A name as written in the file, and what it is for."""

    name: str
    role: Role


def references(found: Format, data: bytes, name: str) -> list[Reference]:
    """References of a main file, each once, in file order.

    Raises:
        Rejected: where the file is so broken that they cannot be told.
    """
    if found in (Format.GLB, Format.GLTF):
        names = _of_gltf(data, name)
    elif found is Format.OBJ:
        names = _of_obj(data, name)
    elif found is Format.DAE:
        root = open_dae(data, name).root
        images = [i for library in kids(root, "library_images") for i in kids(library, "image")]
        names = [Reference(image_file(i), Role.IMAGE) for i in images]
    elif found is Format.PLY:
        header = read_header(data.lstrip(b" \t\r\n"), name)
        names = [Reference(t, Role.IMAGE) for t in header.textures]
    else:
        names = []
    return list(dict.fromkeys(r for r in names if r.name and not r.name.startswith("data:")))[:MOST_REFERENCES]


def of_mtl(data: bytes, name: str) -> list[Reference]:
    """Pictures of an MTL file that a reader here can use, each once."""
    found = [map_file(rest) for key, rest in statements(data, name) if key in MAPS]
    return [Reference(f, Role.IMAGE) for f in dict.fromkeys(found) if f][:MOST_REFERENCES]


def _of_gltf(data: bytes, name: str) -> list[Reference]:
    document, _ = open_document(data, name)
    buffers = [Reference(b.text("uri"), Role.BUFFER) for b in document.items("buffers")]
    return buffers + [Reference(i.text("uri"), Role.IMAGE) for i in document.items("images")]


def _of_obj(data: bytes, name: str) -> list[Reference]:
    text = plain(data, name)
    found = re.findall(rb"^[ \t]*mtllib[ \t]+([^\n]+)", text, re.MULTILINE)
    return [Reference(decode(f).strip(), Role.MATERIAL) for f in found]
