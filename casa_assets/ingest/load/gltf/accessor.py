"""glTF accessors -> numpy arrays; every offset, stride and count is checked against the bytes that are there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.container import data_uri
from casa_assets.ingest.load.gltf.meshopt import EXTENSIONS, decompressed
from casa_assets.ingest.load.gltf.tree import JsonObject

# componentType -> dtype. Ref: glTF 2.0, 3.6.2.2
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

Raw = npt.NDArray[np.generic]


class Accessors:
    """Reads accessors of one document, each once."""

    def __init__(
        self, document: JsonObject, binary: bytes | None, files: Mapping[str, bytes], limits: Mapping[str, float]
    ) -> None:
        self._document, self._binary, self._files = document, binary, files
        self._max_elements = int(3 * limits["input_faces"])
        self._max_bytes = int(limits["input_bytes"])
        self._unpacked: dict[str, bytes] = {}
        self._buffers: dict[int, bytes] = {}
        self._arrays: dict[int, Raw] = {}
        self._floats: dict[int, npt.NDArray[np.float64]] = {}

    def count(self, index: int) -> int:
        """Number of elements of an accessor, as it claims."""
        return self._document.pick(index, "accessors").count("count")

    def integers(self, index: int) -> npt.NDArray[np.int64]:
        """(count,) whole numbers of a scalar accessor."""
        array = self._array(index)
        if array.dtype.kind not in "iu" or array.shape[1] != 1:
            raise Rejected(codes.BAD_SCHEMA, f"glTF accessors/{index}: indices must be whole scalars; export it again")
        return array[:, 0].astype(np.int64)

    def floats(self, index: int, widths: tuple[int, ...]) -> npt.NDArray[np.float64]:
        """(count, width) float64, normalised integers mapped to 0..1 or -1..1; width must be one of `widths`."""
        if index not in self._floats:
            array = self._array(index)
            scale = 1.0
            if array.dtype.kind in "iu" and self._document.pick(index, "accessors").flag("normalized"):
                scale = float(2 ** (8 * array.dtype.itemsize - (array.dtype.kind == "i")) - 1)
            values = array.astype(np.float64) / scale
            self._floats[index] = np.maximum(values, -1.0) if scale != 1.0 else values
        values = self._floats[index]
        if values.shape[1] not in widths:
            message = f"glTF accessors/{index}: {values.shape[1]} components where {widths} fit; export the file again"
            raise Rejected(codes.BAD_SCHEMA, message)
        return values

    def is_stored(self, index: int) -> bool:
        """True where the bytes of an accessor lie in a buffer view, or were handed over."""
        return index in self._arrays or self._document.pick(index, "accessors").has("bufferView")

    def check_count(self, index: int) -> None:
        """Raises Rejected TOO_LARGE where an accessor claims more elements than any input may have."""
        accessor = self._document.pick(index, "accessors")
        self._check_element_count(accessor.count("count"), accessor)

    def supply(self, index: int, array: Raw) -> None:
        """Hand over the (count, width) elements of an accessor that is compressed by means of its own.

        Raises:
            Rejected: LENGTH_MISMATCH where the accessor claims another shape.
        """
        accessor = self._document.pick(index, "accessors")
        shape = (accessor.count("count"), self._layout(accessor)[1])
        if array.shape != shape:
            message = f"glTF {accessor.place}: claims {shape} numbers, {array.shape} are packed; export the file again"
            raise Rejected(codes.LENGTH_MISMATCH, message)
        self._arrays[index] = array

    def view_bytes(self, index: int) -> bytes:
        """Bytes of a buffer view (an embedded image)."""
        view = self._document.pick(index, "bufferViews")
        data, start, length = self._span(view)
        return data[start : start + length]

    def _array(self, index: int) -> Raw:
        if index not in self._arrays:
            self._arrays[index] = self._read(self._document.pick(index, "accessors"))
        return self._arrays[index]

    def _read(self, accessor: JsonObject) -> Raw:
        dtype, width = self._layout(accessor)
        count = accessor.count("count")
        if not accessor.has("bufferView"):
            self._check_element_count(count, accessor)
            array: Raw = np.zeros((count, width), dtype=dtype)
        else:
            array = self._strided(accessor, accessor.count("bufferView"), count, dtype, width)
        if accessor.has("sparse"):
            array = self._sparse(array, accessor.child("sparse"), dtype, width)
        return array

    def _layout(self, accessor: JsonObject) -> tuple[np.dtype[np.generic], int]:
        component, shape = accessor.count("componentType"), accessor.text("type")
        if component not in _COMPONENTS or shape not in _WIDTHS:
            message = f"glTF {accessor.place}: componentType {component} with type {shape[:12]!r} cannot be read here"
            raise Rejected(codes.BAD_SCHEMA, message)
        return np.dtype(_COMPONENTS[component]), _WIDTHS[shape]

    def _check_element_count(self, count: int, accessor: JsonObject) -> None:
        if count > self._max_elements:
            message = (
                f"glTF {accessor.place}: {count} elements, more than {self._max_elements}; simplify the mesh first"
            )
            raise Rejected(codes.TOO_LARGE, message)

    def _strided(self, owner: JsonObject, view_index: int, count: int, dtype: np.dtype[np.generic], width: int) -> Raw:
        view = self._document.pick(view_index, "bufferViews")
        data, start, length = self._span(view)
        element = dtype.itemsize * width
        stride = view.count("byteStride", 0) or element
        offset = owner.count("byteOffset", 0)
        if stride < element:
            raise view.fail("byteStride", f"at least {element}")
        if count and offset + stride * (count - 1) + element > length:
            message = (
                f"glTF {owner.place}: {count} elements need more than the {length} bytes of bufferViews/{view_index}"
            )
            raise Rejected(codes.OUT_OF_BOUNDS, message + "; fetch or export the file again")
        self._check_element_count(count, owner)
        if not count:
            return np.zeros((0, width), dtype=dtype)
        return np.ndarray((count, width), dtype, data, start + offset, (stride, dtype.itemsize))

    def _sparse(self, array: Raw, sparse: JsonObject, dtype: np.dtype[np.generic], width: int) -> Raw:
        count = sparse.count("count")
        places, values = sparse.child("indices"), sparse.child("values")
        component = _COMPONENTS.get(places.count("componentType"), "")
        if component not in ("<u1", "<u2", "<u4"):
            raise places.fail("componentType", "an unsigned type")
        where = self._strided(places, places.count("bufferView"), count, np.dtype(component), 1)[:, 0].astype(np.int64)
        if count and int(where.max()) >= len(array):
            raise Rejected(codes.OUT_OF_BOUNDS, f"glTF {sparse.place}: an index is past the accessor; export it again")
        out = array.copy()
        out[where] = self._strided(values, values.count("bufferView"), count, dtype, width)
        return out

    def _span(self, view: JsonObject) -> tuple[bytes, int, int]:
        """Buffer, start and length of a view."""
        packed = [e for e in EXTENSIONS if view.child("extensions").has(e)]
        if packed:
            data = self._unpack(view.child("extensions").child(packed[0]))
            if view.count("byteLength") > len(data):
                message = (
                    f"glTF {view.place}: says {view.count('byteLength')} bytes, {len(data)} are packed; export it again"
                )
                raise Rejected(codes.LENGTH_MISMATCH, message)
            return data, 0, view.count("byteLength")
        return self._cut(view)

    def _unpack(self, extension: JsonObject) -> bytes:
        if extension.place not in self._unpacked:
            data, start, length = self._cut(extension)
            self._unpacked[extension.place] = decompressed(extension, data[start : start + length], self._max_bytes)
        return self._unpacked[extension.place]

    def _cut(self, view: JsonObject) -> tuple[bytes, int, int]:
        """Buffer, start and length of what a view, or its compressed form, names."""
        data = self._buffer(view.count("buffer"))
        start, length = view.count("byteOffset", 0), view.count("byteLength")
        if start + length > len(data):
            message = (
                f"glTF {view.place}: ends at byte {start + length} of a buffer of {len(data)}; fetch the file again"
            )
            raise Rejected(codes.OUT_OF_BOUNDS, message)
        return data, start, length

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            buffer = self._document.pick(index, "buffers")
            data = self._buffer_bytes(index, buffer)
            wanted = buffer.count("byteLength")
            if len(data) < wanted:
                message = f"glTF {buffer.place}: says {wanted} bytes, there are {len(data)}; fetch the file again"
                raise Rejected(codes.LENGTH_MISMATCH, message)
            self._buffers[index] = data
        return self._buffers[index]

    def _buffer_bytes(self, index: int, buffer: JsonObject) -> bytes:
        uri = buffer.text("uri")
        if uri.startswith("data:"):
            return data_uri(uri, buffer.place)
        if uri:
            if uri not in self._files:
                raise Rejected(codes.MISSING_FILE, f"glTF {buffer.place}: the file {uri[:80]!r} is missing; add it")
            return self._files[uri]
        if index == 0 and self._binary is not None:
            return self._binary
        message = f"glTF {buffer.place}: has neither a file nor a binary chunk; export it again"
        raise Rejected(codes.MISSING_FILE, message)
