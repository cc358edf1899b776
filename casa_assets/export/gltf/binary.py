"""Arrays and pictures -> binary chunk of a GLB, its buffer views and accessors; equal content is written once.

Ref: glTF 2.0 specification, 3.6 (binary data storage) and 4.4 (GLB file format).
"""

from __future__ import annotations

import hashlib
import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

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
