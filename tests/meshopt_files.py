"""glTF with buffer views compressed by meshopt; the compressed bytes are the caller's."""

from __future__ import annotations

from collections.abc import Sequence

from tests.mesh_files import Gltf

NAMES = ["EXT_meshopt_compression", "KHR_meshopt_compression"]


def packed(data: bytes, stride: int, mode: str, count: int, **extra: object) -> dict[str, object]:
    """An extension object, of which `data` is left to be placed."""
    return {
        "buffer": 0,
        "byteOffset": 0,
        "byteLength": len(data),
        "byteStride": stride,
        "mode": mode,
        "count": count,
    } | extra


def squeezed(columns: Sequence[tuple[bytes, int, str, int]], name: str) -> Gltf:
    """A mesh whose positions and indices are compressed, with a fallback buffer that holds nothing.

    Args:
        columns: data, stride, mode and count of the positions, then of the indices.
        name: the extension.
    """
    made = Gltf([(0.0, 0.0, 0.0)] * columns[0][3], [0] * columns[1][3])
    made.binary = b""
    for view, (data, stride, mode, count) in zip(list(made.views), columns, strict=True):
        start = len(made.binary)
        made.binary += data + b"\0" * (-len(data) % 4)
        view |= {"buffer": 1, "byteOffset": 0, "byteLength": count * stride}
        view["extensions"] = {name: packed(data, stride, mode, count) | {"byteOffset": start}}
    made.document["extensionsRequired"] = [name]
    made.document["buffers"] = [
        {"byteLength": len(made.binary)},
        {"byteLength": 10**9, "extensions": {name: {"fallback": True}}},
    ]
    return made
