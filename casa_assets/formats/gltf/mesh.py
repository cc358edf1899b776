"""Meshes and materials of a GLB: the binary chunk, its accessors, pictures made small, one primitive a material."""

from __future__ import annotations

import hashlib
import io
import json
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.numeric import Floats, Ints
from casa_assets.formats.mjcf import shapes
from casa_assets.mesh import surface
from casa_assets.model.asset.asset import Visual
from casa_assets.model.asset.material import ColorSpace, Material, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.pose import Pose

# Binary ---------------------------------------------------------------------------------------------------------------
# Arrays and pictures -> binary chunk of a GLB, its buffer views and accessors; equal content is written once.
#
# Ref: glTF 2.0 specification, 3.6 (binary data storage) and 4.4 (GLB file format).

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
MAGIC, VERSION = 0x46546C67, 2
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
ALIGNMENT = 4
TYPE_OF_WIDTH = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


@dataclass
class Binary:
    """The binary chunk while it is being built.

    Attributes:
        data: its bytes, every part aligned.
        views, accessors: as glTF lists them.
    """

    data: bytearray = field(default_factory=bytearray)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    _view_of: dict[bytes, int] = field(default_factory=dict)
    _accessor_of: dict[tuple[int, str, int, int, bool], int] = field(default_factory=dict)

    def view(self, content: bytes, target: int | None = None) -> int:
        """Index of the buffer view of some bytes; `target`: kind of the vertex data, None for a picture."""
        key = hashlib.sha256(f"{target} ".encode() + content).digest()
        if key not in self._view_of:
            self.data += bytes(-len(self.data) % ALIGNMENT)
            row: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)}
            self.views.append(row if target is None else {**row, "target": target})
            self.data += content
            self._view_of[key] = len(self.views) - 1
        return self._view_of[key]

    def vectors(self, rows: npt.NDArray[np.float64], with_bounds: bool = False) -> int:
        """Index of the accessor of (N, 2) or (N, 3) numbers, rounded to float32; `with_bounds`: for positions."""
        values = np.ascontiguousarray(rows, dtype=np.float32) + np.float32(0.0)  # no negative zero
        row = {"componentType": FLOAT, "count": len(values), "type": TYPE_OF_WIDTH[values.shape[1]]}
        if with_bounds:
            row |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._accessor(self.view(values.astype("<f4").tobytes(), ARRAY_BUFFER), row, with_bounds)

    def indices(self, faces: npt.NDArray[np.int64]) -> int:
        """Index of the accessor of the corners of (F, 3) triangles."""
        is_small = int(faces.max()) < 65535  # the largest number of either width is kept for other purposes
        content = faces.astype("<u2" if is_small else "<u4").tobytes()
        kind = UNSIGNED_SHORT if is_small else UNSIGNED_INT
        row = {"componentType": kind, "count": int(faces.size), "type": TYPE_OF_WIDTH[1]}
        return self._accessor(self.view(content, ELEMENT_ARRAY_BUFFER), row, False)

    def _accessor(self, view: int, row: dict[str, Any], with_bounds: bool) -> int:
        key = (view, str(row["type"]), int(row["componentType"]), int(row["count"]), with_bounds)
        if key not in self._accessor_of:
            self.accessors.append({"bufferView": view, **row})
            self._accessor_of[key] = len(self.accessors) - 1
        return self._accessor_of[key]


def glb(document: dict[str, Any], binary: Binary) -> bytes:
    """Return the file of a document without buffers, views and accessors, which are taken from `binary`."""
    body = bytes(binary.data) + bytes(-len(binary.data) % ALIGNMENT)
    parts = {"buffers": [{"byteLength": len(body)}], "bufferViews": binary.views, "accessors": binary.accessors}
    parts = {} if not body else parts
    text = json.dumps({**document, **parts}, sort_keys=True, allow_nan=False, separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % ALIGNMENT)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    if body:
        chunks += struct.pack("<II", len(body), BINARY_CHUNK) + body
    return struct.pack("<III", MAGIC, VERSION, 12 + len(chunks)) + chunks


# Number ---------------------------------------------------------------------------------------------------------------
# Numbers and poses as glTF has them.


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers rounded to the same digits as in the other writers."""
    return [float(shapes.number(value)) for value in values]


def placed(pose: Pose) -> dict[str, Any]:
    """`translation` (metres) and `rotation` (x, y, z, w) of a node; empty for the identity."""
    w, x, y, z = pose.quaternion
    found: dict[str, Any] = {}
    if any(pose.position):
        found["translation"] = rounded(pose.position)
    if (x, y, z) != (0.0, 0.0, 0.0):
        found["rotation"] = rounded((x, y, z, w))
    return found


# Material -------------------------------------------------------------------------------------------------------------
# Material -> metallic-roughness material of glTF, the same model as in the record, with reduced pictures.

COLOR_QUALITY, DATA_QUALITY = 85, 90
# Ref: OpenGL: GL_LINEAR, GL_LINEAR_MIPMAP_LINEAR, GL_REPEAT.
SAMPLER = {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}
# Shares of a picture whose alpha is neither nothing nor all, above which it is see-through and not cut out.
MAX_SOFT_SHARE = 0.05
# Pictures of this process by name, colour space and size: those of all styles, of 60 kB each.
_KEPT: dict[str, tuple[bytes, str, str]] = {}
_MOST_KEPT = 512


@dataclass
class Materials:
    """Materials, textures and images as glTF lists them; equal ones are written once.

    Attributes:
        binary: receives the pictures.
        picture_px: maximum pixels along a side.
    """

    binary: Binary
    picture_px: int
    rows: list[dict[str, Any]] = field(default_factory=list)
    images: list[dict[str, Any]] = field(default_factory=list)
    _index: dict[str, int] = field(default_factory=dict)
    _image_of: dict[str, tuple[int, str]] = field(default_factory=dict)

    def index(self, material: Material) -> int:
        """Index of a material."""
        return self._add(material.digest, lambda: self._row(material))

    def plain(self, name: str, color: Sequence[float]) -> int:
        """Index of a rough material of one linear RGBA colour, seen from both sides."""
        pbr = {"baseColorFactor": rounded(color), "metallicFactor": 0.0, "roughnessFactor": 0.9}
        mode = {} if color[3] >= 1.0 else {"alphaMode": "BLEND"}
        return self._add(name, lambda: {"name": name, "pbrMetallicRoughness": pbr, "doubleSided": True, **mode})

    def document(self) -> dict[str, Any]:
        """Members of the glTF document."""
        found: dict[str, Any] = {"materials": self.rows} if self.rows else {}
        if self.images:
            textures = [{"sampler": 0, "source": i} for i in range(len(self.images))]
            found |= {"images": self.images, "textures": textures, "samplers": [SAMPLER]}
        return found

    def _add(self, key: str, make: Any) -> int:
        if key not in self._index:
            self.rows.append(make())
            self._index[key] = len(self.rows) - 1
        return self._index[key]

    def _row(self, material: Material) -> dict[str, Any]:
        pbr: dict[str, Any] = {
            "baseColorFactor": rounded(material.base_color),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        row: dict[str, Any] = {"name": material.id, "pbrMetallicRoughness": pbr}
        mode = "OPAQUE"
        if material.base_color_texture is not None:
            texture, mode = self._texture(material.base_color_texture)
            pbr["baseColorTexture"] = texture
        if material.base_color[3] < 1.0:
            mode = "BLEND"
        if material.metallic_roughness_texture is not None:
            pbr["metallicRoughnessTexture"], _ = self._texture(material.metallic_roughness_texture)
        if material.normal_texture is not None:
            row["normalTexture"], _ = self._texture(material.normal_texture)
        if material.glow:
            row["emissiveFactor"] = rounded([material.glow * c for c in material.base_color[:3]])
            if material.base_color_texture is not None:
                row["emissiveTexture"] = pbr["baseColorTexture"]
        return row if mode == "OPAQUE" else {**row, "alphaMode": mode}

    def _texture(self, texture: Texture) -> tuple[dict[str, int], str]:
        """Reference to a picture, and the alpha mode that it requires."""
        key = f"{texture.file_name} {texture.color_space.value}"
        if key not in self._image_of:
            # Kitchens of a style have the same pictures.
            place = f"{key} {self.picture_px}"
            if place not in _KEPT:
                if len(_KEPT) >= _MOST_KEPT:
                    _KEPT.clear()
                _KEPT[place] = encoded(texture, self.picture_px)
            content, kind, mode = _KEPT[place]
            view = self.binary.view(content)
            self.images.append({"bufferView": view, "mimeType": kind, "name": texture.name})
            self._image_of[key] = len(self.images) - 1, mode
        index, mode = self._image_of[key]
        return {"index": index}, mode


def encoded(texture: Texture, most_px: int) -> tuple[bytes, str, str]:
    """Encode a picture, scaled down to at most `most_px` along a side.

    Returns:
        Its bytes; `image/png` if it has alpha, else `image/jpeg`; and the glTF alpha mode that it requires.
    """
    out = io.BytesIO()
    with Image.open(io.BytesIO(texture.png)) as opened:
        image = opened.convert("RGBA" if "A" in opened.getbands() or "transparency" in opened.info else "RGB")
    if image.mode == "RGBA" and image.getchannel("A").getextrema() == (255, 255):
        image = image.convert("RGB")
    if max(image.size) > most_px:
        image.thumbnail((most_px, most_px), Image.Resampling.LANCZOS)
    if image.mode == "RGBA":
        image.save(out, "PNG", optimize=True)
        alpha = np.asarray(image.getchannel("A"))
        is_soft = float(((alpha > 8) & (alpha < 247)).mean()) > MAX_SOFT_SHARE
        return out.getvalue(), "image/png", "BLEND" if is_soft else "MASK"
    # Halved colour would smear the channels of data into each other.
    is_color = texture.color_space is ColorSpace.SRGB
    quality, sampling = (COLOR_QUALITY, "4:2:0") if is_color else (DATA_QUALITY, "4:4:4")
    image.save(out, "JPEG", quality=quality, subsampling=sampling, optimize=True)
    return out.getvalue(), "image/jpeg", "OPAQUE"


# Visual ---------------------------------------------------------------------------------------------------------------
# Visuals of a link -> meshes: one primitive for each material, so that a link is drawn in few calls.


@dataclass
class Meshes:
    """Meshes as glTF lists them; equal ones are written once, however many nodes show them."""

    binary: Binary
    materials: Materials
    rows: list[dict[str, Any]] = field(default_factory=list)
    _index: dict[str, int] = field(default_factory=dict)

    def of_visuals(self, visuals: Sequence[Visual], looks: dict[str, Material]) -> int | None:
        """Index of the mesh of some visuals of one link, or None if they have no faces."""
        primitives = []
        for material in dict.fromkeys(visual.material for visual in visuals):
            joined = _joined([visual.mesh for visual in visuals if visual.material == material])
            if joined is not None:
                primitives.append(self._primitive(*joined, self.materials.index(looks[material])))
        return self._add({"primitives": primitives}) if primitives else None

    def bare(self, points: Floats, faces: Ints, material: int) -> int:
        """Index of a mesh of one material without normals, which viewers draw faceted."""
        return self._add({"primitives": [self._primitive(points, None, None, faces, material)]})

    def _primitive(
        self, points: Floats, normals: Floats | None, uv: Floats | None, faces: Ints, material: int
    ) -> dict[str, Any]:
        attributes = {"POSITION": self.binary.vectors(points, with_bounds=True)}
        if normals is not None:
            attributes["NORMAL"] = self.binary.vectors(normals)
        if uv is not None:
            attributes["TEXCOORD_0"] = self.binary.vectors(uv)
        return {"attributes": attributes, "indices": self.binary.indices(faces), "material": material}

    def _add(self, row: dict[str, Any]) -> int:
        key = repr(row)
        if key not in self._index:
            self.rows.append(row)
            self._index[key] = len(self.rows) - 1
        return self._index[key]


def _joined(meshes: Sequence[Mesh]) -> tuple[Floats, Floats, Floats | None, Ints] | None:
    """Join meshes into points, unit normals, texture coordinates and faces, or None if there are no faces.

    Texture coordinates have v down, as in glTF, and are None if no mesh has any.
    """
    filled = [_with_normals(mesh) for mesh in meshes if len(mesh.faces)]
    if not filled:
        return None
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh, _ in filled)])
    faces = np.concatenate([m.faces.astype(np.int64) + start for (m, _), start in zip(filled, starts, strict=False)])
    uv = None
    if any(mesh.uv is not None for mesh, _ in filled):
        rows = [np.zeros((len(m.vertices), 2)) if m.uv is None else m.uv for m, _ in filled]
        uv = np.concatenate(rows) * (1.0, -1.0) + (0.0, 1.0)
    points = np.concatenate([mesh.vertices for mesh, _ in filled])
    return points, np.concatenate([normals for _, normals in filled]), uv, faces


def _with_normals(mesh: Mesh) -> tuple[Mesh, Floats]:
    """Return the mesh and (V, 3) unit normals; a mesh without normals gets separate vertices for each face."""
    if mesh.normals is None:
        normals, areas = surface.face_normals(mesh.vertices, mesh.faces.astype(np.int64))
        normals[areas == 0] = (0.0, 0.0, 1.0)
        rows = mesh.faces.reshape(-1)
        faces = np.arange(len(rows), dtype=np.int32).reshape(-1, 3)
        mesh = Mesh(vertices=mesh.vertices[rows], faces=faces, uv=None if mesh.uv is None else mesh.uv[rows])
        return mesh, np.repeat(normals, 3, axis=0)
    lengths = np.linalg.norm(mesh.normals, axis=1, keepdims=True)
    upright = np.where(lengths > 0.0, mesh.normals, (0.0, 0.0, 1.0))
    return mesh, upright / np.where(lengths > 0.0, lengths, 1.0)
