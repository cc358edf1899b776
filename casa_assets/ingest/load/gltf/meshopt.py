"""Buffer views compressed by meshoptimizer -> their bytes. Ref: EXT_meshopt_compression, KHR_meshopt_compression."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import meshoptimizer
import numpy as np
import numpy.typing as npt

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.tree import JsonObject

EXTENSIONS = ("KHR_meshopt_compression", "EXT_meshopt_compression")

Bytes = npt.NDArray[np.uint8]

# Filters by name, and the strides that each is defined for; None: any multiple of 4.
_FILTERS: dict[str, tuple[Callable[..., Bytes], tuple[int, ...] | None]] = {
    "OCTAHEDRAL": (meshoptimizer.decode_filter_oct, (4, 8)),
    "QUATERNION": (meshoptimizer.decode_filter_quat, (8,)),
    "EXPONENTIAL": (meshoptimizer.decode_filter_exp, None),
}
_MAX_STRIDE = 256


def decompressed(extension: JsonObject, data: bytes, max_bytes: int) -> bytes:
    """Bytes of a view.

    Args:
        extension: the view's extension object.
        data: the compressed bytes that it names.
        max_bytes: largest size of the result that is accepted.
    Raises:
        Rejected: BAD_SCHEMA, TOO_LARGE, UNSUPPORTED_EXTENSION for a mode or filter that is not known here, TRUNCATED
            where the bytes are no such stream.
    """
    stride, count, mode = extension.count("byteStride"), extension.count("count"), extension.text("mode")
    if not 0 < stride <= _MAX_STRIDE:
        raise extension.fail("byteStride", f"1 to {_MAX_STRIDE}")
    if count * stride > max_bytes:
        message = (
            f"glTF {extension.place}: claims {count * stride} bytes, more than {max_bytes}; simplify the mesh first"
        )
        raise Rejected(codes.TOO_LARGE, message)
    if not count:
        return b""
    try:
        if mode == "ATTRIBUTES":
            return _attributes(extension, data, count, stride)
        if mode in ("TRIANGLES", "INDICES"):
            return _indices(extension, data, count, stride)
    except (RuntimeError, ValueError) as error:
        message = f"glTF {extension.place}: the compressed data is broken; fetch or export the file again"
        raise Rejected(codes.TRUNCATED, message) from error
    raise _unknown(extension, "mode", mode)


def _attributes(extension: JsonObject, data: bytes, count: int, stride: int) -> bytes:
    if stride % 4:
        raise extension.fail("byteStride", "a multiple of 4")
    out = meshoptimizer.decode_vertex_buffer(count, stride, data, dtype=np.dtype(f"V{stride}"))
    name = extension.text("filter") or "NONE"
    if name == "NONE":
        return bytes(out.tobytes())
    if name not in _FILTERS:
        raise _unknown(extension, "filter", name)
    run, strides = _FILTERS[name]
    if strides is not None and stride not in strides:
        raise extension.fail("byteStride", f"one of {strides} for the filter {name}")
    # The binding declares no argument types for filters: numbers have to be of their C types already.
    return bytes(run(out.view(np.uint8), ctypes.c_size_t(count), ctypes.c_size_t(stride)).tobytes())


def _indices(extension: JsonObject, data: bytes, count: int, stride: int) -> bytes:
    if stride not in (2, 4):
        raise extension.fail("byteStride", "2 or 4")
    if extension.text("mode") == "TRIANGLES":
        if count % 3:
            raise extension.fail("count", "a multiple of 3")
        out = meshoptimizer.decode_index_buffer(count, stride, data)
    else:
        out = meshoptimizer.decode_index_sequence(count, stride, data)
    # The binding's array has room for 4 bytes each; the decoder fills it from the front.
    return bytes(out.tobytes()[: count * stride])


def _unknown(extension: JsonObject, key: str, name: str) -> Rejected:
    message = (
        f"glTF {extension.place}: meshopt {key} {name[:20]!r} is not supported; run `gltf-transform copy` on the file"
    )
    return Rejected(codes.UNSUPPORTED_EXTENSION, message)
