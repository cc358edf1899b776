"""Small mesh files built in code: GLB bytes, pictures, and the way from bytes on disk to a RawModel."""

from __future__ import annotations

import base64
import io
import json
import struct
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from casa_assets.errors import Rejected
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.ingest.things import load
from casa_assets.model.source import Bundle, RawModel
from tests.support.mesh.meshes import some

LIMITS = {"input_bytes": 1e7, "input_faces": 1e5, "input_texture_px": 512, "input_texture_pixels": 200_000.0}

# Four colours, one per quarter, seen as on a screen: row 0 is the upper one.
QUARTERS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 0]]], dtype=np.uint8)
TRIANGLE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
# Names of the extension that compresses buffer views by meshopt.
MESHOPT_NAMES = ["EXT_meshopt_compression", "KHR_meshopt_compression"]
OBJ_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
# Two KTX 2 pictures of 8 by 8 pixels, one quarter each red, green, blue and yellow, made by Basis Universal 2.10.
UASTC = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAAAAAAAaAAAACwAAACUAAAALAAAAAAAAAAAAAAAAAAAAAAAAADAAA"
    "AAAAAAAEAAAAAAAAAAQAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFz"
    "aXMgVW5pdmVyc2FsIDIuMTAAAAQAAAB/fwAA9x8A4B96AAAAAAAAAAAAABfgH+AfAg8AAAAAAAAAAAAXAOD/HwLgAQAAAAAAAAAA9/8f4B98Dw"
    "AAAAAAAAAAAA=="
)
ETC1S = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAAiQAAAAAAAABBAQ"
    "AAAAAAAAIAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFz"
    "aXMgVW5pdmVyc2FsIDIuMTAAAAQAAgArAAAACQAAAC0AAAAAAAAAAAAAAAAAAAACAAAAAAAAAAAAAAAgwEQAAAAAAADiRAQwEQAAAAAAgCQgAE"
    "wACAAAAAAgBgATAAAAAAAACIgkrKqqqlJVVVUFAMFEAAAAAAAA8l+NAJgBAAAAAABAwggwIUAAAAAABJFTCgAmAAAAAAAAEEAAEAY="
)


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """PNG of (H, W), (H, W, 3) or (H, W, 4) uint8 pixels."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "PNG")
    return out.getvalue()


def glb_bytes(document: dict[str, object], binary: bytes = b"") -> bytes:
    """A GLB of a JSON document and a binary chunk."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        binary += b"\0" * (-len(binary) % 4)
        body += struct.pack("<II", len(binary), 0x004E4942) + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


class Gltf:
    """A glTF under construction: one node with one mesh with one primitive; every part of `document` may be changed."""

    def __init__(self, points: Sequence[Sequence[float]] = TRIANGLE, indices: Sequence[int] = (0, 1, 2)) -> None:
        self.binary = b""
        self.views: list[dict[str, object]] = []
        self.accessors: list[dict[str, object]] = []
        self.attributes: dict[str, int] = {"POSITION": self.add(np.array(points, dtype="<f4"), "VEC3")}
        self.primitive: dict[str, object] = {
            "attributes": self.attributes,
            "indices": self.add(np.array(indices, dtype="<u2"), "SCALAR"),
        }
        self.node: dict[str, object] = {"mesh": 0, "name": "thing"}
        self.document: dict[str, object] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [self.node],
            "meshes": [{"primitives": [self.primitive]}],
        }

    def view(self, data: bytes) -> int:
        """Add bytes; the number of their buffer view."""
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.views) - 1

    def add(self, array: npt.NDArray[np.generic], shape: str, **extra: object) -> int:
        """Add an array; the number of its accessor."""
        kind = {"<f4": 5126, "<u2": 5123, "<u4": 5125, "|u1": 5121, "|i1": 5120, "<i2": 5122}[array.dtype.str]
        view = self.view(array.tobytes())
        self.accessors.append({"bufferView": view, "componentType": kind, "count": len(array), "type": shape, **extra})
        return len(self.accessors) - 1

    def paint(self, picture: bytes, **material: object) -> None:
        """Give the primitive a base colour picture and texture coordinates (0,0), (1,0), (0,1)."""
        if "TEXCOORD_0" not in self.attributes:
            self.attributes["TEXCOORD_0"] = self.add(np.array([[0, 0], [1, 0], [0, 1]], dtype="<f4"), "VEC2")
        self.document["images"] = [{"bufferView": self.view(picture), "mimeType": "image/png"}]
        self.document["textures"] = [{"source": 0}]
        pbr = {"baseColorTexture": {"index": 0}}
        self.document["materials"] = [{"name": "paint", "pbrMetallicRoughness": pbr, **material}]
        self.primitive["material"] = 0

    def text(self, uri: str) -> bytes:
        """The finished file as text, with its buffer at an address."""
        buffers = [{"byteLength": len(self.binary), "uri": uri}]
        parts = {"bufferViews": self.views, "accessors": self.accessors, "buffers": buffers}
        return json.dumps({**self.document, **parts}).encode()

    def glb(self) -> bytes:
        parts = {"bufferViews": self.views, "accessors": self.accessors, "buffers": [{"byteLength": len(self.binary)}]}
        return glb_bytes({**parts, **self.document}, self.binary)


def packed_view(data: bytes, stride: int, mode: str, count: int, **extra: object) -> dict[str, object]:
    """An extension object, of which `data` is left to be placed."""
    place = {"buffer": 0, "byteOffset": 0, "byteLength": len(data), "byteStride": stride}
    return {**place, "mode": mode, "count": count, **extra}


def squeezed(columns: Sequence[tuple[bytes, int, str, int]], name: str) -> Gltf:
    """A mesh whose positions and indices are compressed, with a fallback buffer that holds nothing.

    `columns`: data, stride, mode and count of the positions, then of the indices. `name`: the extension.
    """
    made = Gltf([(0.0, 0.0, 0.0)] * columns[0][3], [0] * columns[1][3])
    made.binary = b""
    for view, (data, stride, mode, count) in zip(list(made.views), columns, strict=True):
        start = len(made.binary)
        made.binary += data + b"\0" * (-len(data) % 4)
        view |= {"buffer": 1, "byteOffset": 0, "byteLength": count * stride}
        view["extensions"] = {name: packed_view(data, stride, mode, count) | {"byteOffset": start}}
    made.document["extensionsRequired"] = [name]
    fallback = {"byteLength": 10**9, "extensions": {name: {"fallback": True}}}
    made.document["buffers"] = [{"byteLength": len(made.binary)}, fallback]
    return made


def load_bytes(name: str, data: bytes | str, **files: bytes) -> RawModel:
    """RawModel of a file that refers to `files` by these names."""
    raw = data.encode() if isinstance(data, str) else data
    return load(Bundle(main=name, files={name: raw, **files}), LIMITS)


def refusal(name: str, data: bytes | str, **files: bytes) -> str:
    """Code that a file is refused with."""
    with pytest.raises(Rejected) as caught:
        load_bytes(name, data, **files)
    assert caught.value.message
    return caught.value.code


def inputs_of(path: Path, others: Counter[str] | None = None) -> tuple[list[Found], list[Refused]]:
    """What is found under a path, and what is refused."""
    every = list(discover([path], others))
    return [one for one in every if isinstance(one, Found)], [one for one in every if isinstance(one, Refused)]


def load_path(path: Path) -> RawModel:
    """RawModel of a file on disk, found, collected and read as the pipeline does it."""
    (found,) = list(discover([path]))
    assert isinstance(found, Found), found
    return load(collect(found, LIMITS), LIMITS)


def codes_of(model: RawModel) -> set[str]:
    return {note.code for note in model.notes}


def texel(model: RawModel, part: int, vertex: int) -> tuple[int, ...]:
    """Colour of the base picture at a vertex of a part; our uv count from the lower left."""
    one = model.parts[part]
    with Image.open(io.BytesIO(some(one.material.base_color_texture).png)) as image:
        pixels = np.asarray(image)
    u, v = np.clip(some(one.mesh.uv)[vertex], 0.01, 0.99)
    row, column = int((1 - v) * pixels.shape[0]), int(u * pixels.shape[1])
    return tuple(int(c) for c in pixels[row, column])
