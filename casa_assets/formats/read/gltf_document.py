"""GLB and glTF 2.0 -> typed JSON and arrays; lengths, offsets and counts are checked against the bytes that are there.

Ref: Khronos glTF 2.0 specification; EXT_meshopt_compression, KHR_meshopt_compression, KHR_draco_mesh_compression.
"""

from __future__ import annotations

import base64
import binascii
import ctypes
import importlib
import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import TypeVar
from urllib.parse import unquote_to_bytes

import DracoPy
import numpy as np
import numpy.typing as npt

from casa_assets.errors import Rejected
from casa_assets.formats.read.text import printable
from casa_assets.model import rejection_codes as codes

Json = Mapping[str, object]
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_DRACO = "KHR_draco_mesh_compression"
_MESHOPT = ("KHR_meshopt_compression", "EXT_meshopt_compression")
# Extensions that may be required: they are read rightly, or ignored without harm to shape and colour.
READABLE = frozenset(
    {
        *("KHR_texture_transform", "KHR_mesh_quantization", "KHR_texture_basisu", "EXT_texture_webp"),
        *("KHR_lights_punctual", "EXT_mesh_gpu_instancing", _DRACO, *_MESHOPT),
    }
)
# Extensions that are read in full; others that a file uses are noted.
TAKEN_OVER = READABLE - {"KHR_lights_punctual"} | {"KHR_materials_pbrSpecularGlossiness"}
# Filters by name: the decoder's function, and the strides that each is defined for; None: any multiple of 4.
_FILTERS: dict[str, tuple[str, tuple[int, ...] | None]] = {
    "NONE": ("", None),
    "OCTAHEDRAL": ("decode_filter_oct", (4, 8)),
    "QUATERNION": ("decode_filter_quat", (8,)),
    "EXPONENTIAL": ("decode_filter_exp", None),
}
_MAX_STRIDE = 256
# componentType -> dtype. Ref: glTF 2.0, 3.6.2.2
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
Raw = npt.NDArray[np.generic]
T = TypeVar("T", Json, list[object], str)


@dataclass(frozen=True)
class JsonObject:
    """A JSON object with its place, such as `meshes/0/primitives/2`.

    Attributes:
        value: the object.
        place: path to it in the document, for messages.
    """

    value: Json
    place: str

    def fail(self, key: str, wanted: str) -> Rejected:
        """The error to raise for a wrong value at `key`."""
        got = printable(repr(self.value.get(key)), 40)
        return Rejected(codes.BAD_SCHEMA, f"glTF {self.place}/{key}: expected {wanted}, got {got}; export it again")

    def has(self, key: str) -> bool:
        """True where the key is there and not null."""
        return self.value.get(key) is not None

    def child(self, key: str) -> JsonObject:
        """Object at `key`; an empty one if the key is missing or null."""
        return JsonObject(self._at(key, {}, "an object"), f"{self.place}/{key}")

    def items(self, key: str) -> list[JsonObject]:
        """Objects of the array at `key`; empty if it is missing."""
        out = []
        for i, value in enumerate(self.array(key)):
            if not isinstance(value, dict):
                raise self.fail(key, "an array of objects")
            out.append(JsonObject(value, f"{self.place}/{key}/{i}"))
        return out

    def array(self, key: str) -> list[object]:
        """The array at `key`; empty where it is missing."""
        return self._at(key, [], "an array")

    def text(self, key: str) -> str:
        """String at `key`; empty where it is missing."""
        return self._at(key, "", "a string").encode("utf-8", "replace").decode("utf-8")

    def _at(self, key: str, default: T, wanted: str) -> T:
        """Value at `key`, of the type of the default; the default if it is missing or null."""
        value = self.value.get(key)
        if value is None:
            return default
        if not isinstance(value, type(default)):
            raise self.fail(key, wanted)
        return value

    def count(self, key: str, default: int | None = None) -> int:
        """Whole number >= 0 at `key`. Raises where it is missing and there is no default."""
        value = self.value.get(key)
        if value is None and default is not None:
            return default
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise self.fail(key, "a whole number >= 0")
        return value

    def number(self, key: str, default: float) -> float:
        """Finite number at `key`."""
        return default if not self.has(key) else self._finite(key, self.value.get(key))

    def numbers(self, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """As many finite numbers as `default` has. Raises NON_FINITE for NaN and infinities."""
        if not self.has(key):
            return default
        values = self.array(key)
        if len(values) != len(default):
            raise self.fail(key, f"{len(default)} numbers")
        return tuple(self._finite(key, v) for v in values)

    def _finite(self, key: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.fail(key, "a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise Rejected(codes.NON_FINITE, f"glTF {self.place}/{key}: NaN or infinite; export the file again")
        return number

    def pick(self, index: int, key: str) -> JsonObject:
        """Object `index` of the array at `key`. Raises OUT_OF_BOUNDS if the array is shorter."""
        values = self.array(key)
        if not 0 <= index < len(values):
            message = f"glTF {self.place}/{key}: index {index} of {len(values)}; export the file again"
            raise Rejected(codes.OUT_OF_BOUNDS, message)
        value = values[index]
        if not isinstance(value, dict):
            raise self.fail(key, "an array of objects")
        return JsonObject(value, f"{key}/{index}")


def dropped_extensions(document: JsonObject) -> list[str]:
    """Extensions that a file uses and that are not taken over, in their order."""
    used = [name for name in document.array("extensionsUsed") if isinstance(name, str)]
    return [name for name in dict.fromkeys(used) if name not in TAKEN_OVER]


def open_document(data: bytes, name: str) -> tuple[JsonObject, bytes | None]:
    """The document and the GLB's binary chunk (None in a .gltf). Raises Rejected."""
    if data.startswith(b"glTF"):
        text, binary = _chunks(data, name)
    else:
        text, binary = data, None
    try:
        value = json.loads(text.removeprefix(b"\xef\xbb\xbf").rstrip(b"\0 \t\r\n"))
    except (ValueError, RecursionError) as error:
        message = f"{name}: the JSON cannot be read ({printable(str(error), 80)}); fetch or export the file again"
        raise Rejected(codes.BAD_JSON, message) from error
    if not isinstance(value, dict):
        raise Rejected(codes.BAD_JSON, f"{name}: the JSON is not an object; this is no glTF")
    document = JsonObject(value, "")
    version = document.child("asset").value.get("version", "2.0")
    if not isinstance(version, str) or not version.startswith("2"):
        raise Rejected(codes.UNSUPPORTED_VERSION, f"{name}: glTF version {str(version)[:8]!r}; only 2.x can be read")
    for wanted in document.array("extensionsRequired"):
        if not isinstance(wanted, str) or not (wanted in READABLE or wanted.startswith("KHR_materials_")):
            message = f"{name}: requires the glTF extension {str(wanted)[:60]!r}, not supported; export without it"
            raise Rejected(codes.UNSUPPORTED_EXTENSION, message)
    return document, binary


def _chunks(data: bytes, name: str) -> tuple[bytes, bytes | None]:
    if len(data) < 12:
        raise Rejected(codes.TRUNCATED, f"{name}: {len(data)} bytes, a GLB header has 12; fetch it again")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise Rejected(codes.UNSUPPORTED_VERSION, f"{name}: GLB version {version}; only 2 can be read")
    text: bytes | None = None
    binary: bytes | None = None
    offset = 12
    while offset + 8 <= min(len(data), length):
        size, kind = struct.unpack_from("<II", data, offset)
        end = offset + 8 + size
        if end > len(data):
            message = f"{name}: a chunk ends at byte {end}, the file at {len(data)} (header: {length}); fetch it again"
            is_cut = kind == _BIN or end <= length
            raise Rejected(codes.TRUNCATED if is_cut else codes.LENGTH_MISMATCH, message)
        if text is None and kind != _JSON:
            raise Rejected(codes.BAD_JSON, f"{name}: the first chunk of a GLB must be JSON; export it again")
        if kind == _JSON and text is None:
            text = data[offset + 8 : end]
        elif kind == _BIN and binary is None:
            binary = data[offset + 8 : end]
        offset = end
    if text is None:
        raise Rejected(codes.TRUNCATED, f"{name}: the GLB has a header but no JSON chunk; fetch it again")
    if not offset <= length <= len(data) or length - offset >= 8:
        message = f"{name}: the header says {length} bytes, the chunks end at {offset} of {len(data)}; fetch it again"
        raise Rejected(codes.LENGTH_MISMATCH, message)
    return text, binary


def data_uri(uri: str, where: str) -> bytes:
    """Bytes of a `data:` URI. Raises Rejected BAD_SCHEMA where it cannot be decoded."""
    head, comma, body = uri.partition(",")
    if not comma:
        raise Rejected(codes.BAD_SCHEMA, f"glTF {where}: a data URI without a comma; export the file again")
    raw = unquote_to_bytes(body)
    if not head.endswith(";base64"):
        return raw
    try:
        return base64.b64decode(raw, validate=True)
    except (binascii.Error, ValueError) as error:
        message = f"glTF {where}: base64 data is broken ({error}); export the file again"
        raise Rejected(codes.BAD_SCHEMA, message) from error


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
    kind = (extension.text("filter") if mode == "ATTRIBUTES" else "") or "NONE"
    if mode == "ATTRIBUTES":
        if stride % 4:
            raise extension.fail("byteStride", "a multiple of 4")
        if kind not in _FILTERS:
            raise _unknown(extension, "filter", kind)
        strides = _FILTERS[kind][1]
        if strides is not None and stride not in strides:
            raise extension.fail("byteStride", f"one of {strides} for the filter {kind}")
    elif mode in ("TRIANGLES", "INDICES"):
        if stride not in (2, 4):
            raise extension.fail("byteStride", "2 or 4")
        if mode == "TRIANGLES" and count % 3:
            raise extension.fail("count", "a multiple of 3")
    else:
        raise _unknown(extension, "mode", mode)
    if not count:
        return b""
    decoder = _decoder(extension)
    try:
        if mode == "ATTRIBUTES":
            out = decoder.decode_vertex_buffer(count, stride, data, dtype=np.dtype(f"V{stride}"))
            if function := _FILTERS[kind][0]:
                # The binding declares no argument types for filters: numbers have to be of their C types already.
                out = getattr(decoder, function)(out.view(np.uint8), ctypes.c_size_t(count), ctypes.c_size_t(stride))
            return bytes(out.tobytes())
        decode = decoder.decode_index_buffer if mode == "TRIANGLES" else decoder.decode_index_sequence
        # The binding's array has room for 4 bytes each; the decoder fills it from the front.
        return bytes(decode(count, stride, data).tobytes()[: count * stride])
    except (RuntimeError, ValueError) as error:
        message = f"glTF {extension.place}: the compressed data is broken; fetch or export the file again"
        raise Rejected(codes.TRUNCATED, message) from error


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


def _unknown(extension: JsonObject, key: str, name: str) -> Rejected:
    message = (
        f"glTF {extension.place}: meshopt {key} {name[:20]!r} is not supported; run `gltf-transform copy` on the file"
    )
    return Rejected(codes.UNSUPPORTED_EXTENSION, message)


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
            if array.dtype.kind in "iu" and self._document.pick(index, "accessors").value.get("normalized") is True:
                scale = float(2 ** (8 * array.dtype.itemsize - (array.dtype.kind == "i")) - 1)
            values = array.astype(np.float64) / scale
            self._floats[index] = np.maximum(values, -1.0) if scale != 1.0 else values
        values = self._floats[index]
        if values.shape[1] not in widths:
            message = f"glTF accessors/{index}: {values.shape[1]} components where {widths} fit; export the file again"
            raise Rejected(codes.BAD_SCHEMA, message)
        return values

    def unpack(self, primitive: JsonObject) -> None:
        """Decode a primitive that is compressed by Draco, for the accessors that it names; others are left as they are.

        Raises:
            Rejected: TRUNCATED where the bytes are no Draco mesh, LENGTH_MISMATCH where it holds other counts than the
                accessors claim, TOO_LARGE, and what buffer views are refused for.
        """
        extension, attributes = primitive.child("extensions").child(_DRACO), primitive.child("attributes")
        if not extension.value or self._is_stored(attributes.count("POSITION")):
            return
        ids = extension.child("attributes")
        if not ids.has("POSITION"):
            raise ids.fail("POSITION", "an attribute of the Draco data")
        wanted = {key: attributes.count(key) for key in ids.value if attributes.has(key)}
        # The claims are checked before anything is decoded; a mesh that holds more is refused by its own counts below.
        for index in (*wanted.values(), *([primitive.count("indices")] if primitive.has("indices") else [])):
            accessor = self._document.pick(index, "accessors")
            self._check_element_count(accessor.count("count"), accessor)
        try:
            mesh = DracoPy.decode(self.view_bytes(extension.count("bufferView")))
        except (ValueError, TypeError, RuntimeError, DracoPy.FileTypeException) as error:
            message = f"glTF {extension.place}: the Draco data is broken; fetch or export the file again"
            raise Rejected(codes.TRUNCATED, message) from error
        faces = getattr(mesh, "faces", None)
        if faces is None:
            raise Rejected(codes.NO_FACES, f"glTF {extension.place}: Draco points without faces; export a surface")
        if primitive.has("indices"):
            self._supply(primitive.count("indices"), np.asarray(faces).reshape(-1, 1))
        data = {one["unique_id"]: one["data"] for one in mesh.attributes}
        for key, index in wanted.items():
            array = data.get(ids.count(key))
            if array is None:
                raise ids.fail(key, "an attribute of the Draco data")
            self._supply(index, np.asarray(array).reshape(len(array), -1))

    def _is_stored(self, index: int) -> bool:
        return index in self._arrays or self._document.pick(index, "accessors").has("bufferView")

    def _supply(self, index: int, array: Raw) -> None:
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
        packed = [e for e in _MESHOPT if view.child("extensions").has(e)]
        if packed:
            extension = view.child("extensions").child(packed[0])
            if extension.place not in self._unpacked:
                stored, start, size = self._cut(extension)
                self._unpacked[extension.place] = decompressed(extension, stored[start : start + size], self._max_bytes)
            data = self._unpacked[extension.place]
            if view.count("byteLength") > len(data):
                message = (
                    f"glTF {view.place}: says {view.count('byteLength')} bytes, {len(data)} are packed; export it again"
                )
                raise Rejected(codes.LENGTH_MISMATCH, message)
            return data, 0, view.count("byteLength")
        return self._cut(view)

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
            uri = buffer.text("uri")
            if uri.startswith("data:"):
                data = data_uri(uri, buffer.place)
            elif uri in self._files:
                data = self._files[uri]
            elif not uri and index == 0 and self._binary is not None:
                data = self._binary
            else:
                why = f"the file {uri[:80]!r} is missing; add it" if uri else "has neither a file nor a binary chunk"
                why += "" if uri else "; export it again"
                raise Rejected(codes.MISSING_FILE, f"glTF {buffer.place}: {why}")
            wanted = buffer.count("byteLength")
            if len(data) < wanted:
                message = f"glTF {buffer.place}: says {wanted} bytes, there are {len(data)}; fetch the file again"
                raise Rejected(codes.LENGTH_MISMATCH, message)
            self._buffers[index] = data
        return self._buffers[index]
