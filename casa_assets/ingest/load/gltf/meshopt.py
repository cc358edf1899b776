"""Buffer views compressed by meshoptimizer -> their bytes. Ref: EXT_meshopt_compression, KHR_meshopt_compression."""

from __future__ import annotations

import ctypes
import importlib
from types import ModuleType

import numpy as np

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.tree import JsonObject

EXTENSIONS = ("KHR_meshopt_compression", "EXT_meshopt_compression")

# Filters by name: the decoder's function, and the strides that each is defined for; None: any multiple of 4.
_FILTERS: dict[str, tuple[str, tuple[int, ...] | None]] = {
    "NONE": ("", None),
    "OCTAHEDRAL": ("decode_filter_oct", (4, 8)),
    "QUATERNION": ("decode_filter_quat", (8,)),
    "EXPONENTIAL": ("decode_filter_exp", None),
}
_MAX_STRIDE = 256


def decompressed(extension: JsonObject, data: bytes, max_bytes: int) -> bytes:
    """Bytes of a view.

    Args:
        extension: the view's extension object.
        data: the compressed bytes that it names.
        max_bytes: largest size of the result that is accepted.
    Raises:
        Rejected: BAD_SCHEMA, TOO_LARGE, UNSUPPORTED_EXTENSION for a mode or filter that is not known here or where
            meshoptimizer is not installed, TRUNCATED where the bytes are no such stream.
    """
    stride, count, mode = extension.count("byteStride"), extension.count("count"), extension.text("mode")
    if not 0 < stride <= _MAX_STRIDE:
        raise extension.fail("byteStride", f"1 to {_MAX_STRIDE}")
    if count * stride > max_bytes:
        message = (
            f"glTF {extension.place}: claims {count * stride} bytes, more than {max_bytes}; simplify the mesh first"
        )
        raise Rejected(codes.TOO_LARGE, message)
    if mode == "ATTRIBUTES":
        _check_attributes(extension, stride)
    elif mode in ("TRIANGLES", "INDICES"):
        _check_indices(extension, stride, count)
    else:
        raise _unknown(extension, "mode", mode)
    if not count:
        return b""
    decoder = _decoder(extension)
    try:
        if mode == "ATTRIBUTES":
            return _attributes(decoder, extension, data, count, stride)
        decode = decoder.decode_index_buffer if mode == "TRIANGLES" else decoder.decode_index_sequence
        # The binding's array has room for 4 bytes each; the decoder fills it from the front.
        return bytes(decode(count, stride, data).tobytes()[: count * stride])
    except (RuntimeError, ValueError) as error:
        message = f"glTF {extension.place}: the compressed data is broken; fetch or export the file again"
        raise Rejected(codes.TRUNCATED, message) from error


def _check_attributes(extension: JsonObject, stride: int) -> None:
    if stride % 4:
        raise extension.fail("byteStride", "a multiple of 4")
    name = extension.text("filter") or "NONE"
    if name not in _FILTERS:
        raise _unknown(extension, "filter", name)
    strides = _FILTERS[name][1]
    if strides is not None and stride not in strides:
        raise extension.fail("byteStride", f"one of {strides} for the filter {name}")


def _check_indices(extension: JsonObject, stride: int, count: int) -> None:
    if stride not in (2, 4):
        raise extension.fail("byteStride", "2 or 4")
    if extension.text("mode") == "TRIANGLES" and count % 3:
        raise extension.fail("count", "a multiple of 3")


def _decoder(extension: JsonObject) -> ModuleType:
    """The module that decodes. It has no wheels and is optional: the extra `meshopt`."""
    try:
        return importlib.import_module("meshoptimizer")
    except ImportError as error:
        message = (
            f"glTF {extension.place}: compressed by meshopt, and meshoptimizer, which decodes it, is not installed; "
            "install it by `pip install meshoptimizer`, which compiles it and needs a C++ compiler, or write the file "
            "without compression by `gltf-transform copy in.glb out.glb`"
        )
        raise Rejected(codes.UNSUPPORTED_EXTENSION, message) from error


def _attributes(decoder: ModuleType, extension: JsonObject, data: bytes, count: int, stride: int) -> bytes:
    out = decoder.decode_vertex_buffer(count, stride, data, dtype=np.dtype(f"V{stride}"))
    function, _ = _FILTERS[extension.text("filter") or "NONE"]
    if function:
        # The binding declares no argument types for filters: numbers have to be of their C types already.
        out = getattr(decoder, function)(out.view(np.uint8), ctypes.c_size_t(count), ctypes.c_size_t(stride))
    return bytes(out.tobytes())


def _unknown(extension: JsonObject, key: str, name: str) -> Rejected:
    message = (
        f"glTF {extension.place}: meshopt {key} {name[:20]!r} is not supported; run `gltf-transform copy` on the file"
    )
    return Rejected(codes.UNSUPPORTED_EXTENSION, message)
