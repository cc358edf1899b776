"""GLB or glTF bytes -> its JSON and its binary chunk, lengths checked before anything is believed."""

from __future__ import annotations

import base64
import binascii
import struct
from urllib.parse import unquote_to_bytes

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.meshopt import EXTENSIONS
from casa_assets.ingest.load.gltf.tree import JsonObject, parse

_JSON, _BIN = 0x4E4F534A, 0x004E4942
# What may be required and still be read rightly, or ignored without harm to shape and colour.
READABLE = frozenset(
    {
        "KHR_texture_transform",
        "KHR_mesh_quantization",
        "KHR_draco_mesh_compression",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "KHR_lights_punctual",
        "EXT_mesh_gpu_instancing",
        *EXTENSIONS,
    }
)

# What is read in full; others that a file uses are told.
TAKEN_OVER = READABLE - {"KHR_lights_punctual"} | {"KHR_materials_pbrSpecularGlossiness"}


def dropped_extensions(document: JsonObject) -> list[str]:
    """Extensions that a file uses and that are not taken over, in their order."""
    used = [name for name in document.array("extensionsUsed") if isinstance(name, str)]
    return [name for name in dict.fromkeys(used) if name not in TAKEN_OVER]


def open_document(data: bytes, name: str) -> tuple[JsonObject, bytes | None]:
    """The document and the GLB's binary chunk (None in a .gltf).

    Raises:
        Rejected: TRUNCATED, LENGTH_MISMATCH, UNSUPPORTED_VERSION, BAD_JSON, UNSUPPORTED_EXTENSION.
    """
    if data.startswith(b"glTF"):
        text, binary = _chunks(data, name)
    else:
        text, binary = data, None
    document = JsonObject(parse(text, name), "")
    version = document.child("asset").value.get("version", "2.0")
    if not isinstance(version, str) or not version.startswith("2"):
        raise Rejected(codes.UNSUPPORTED_VERSION, f"{name}: glTF version {str(version)[:8]!r}; only 2.x can be read")
    _check_extensions(document, name)
    return document, binary


def _check_extensions(document: JsonObject, name: str) -> None:
    for wanted in document.array("extensionsRequired"):
        readable = isinstance(wanted, str) and (wanted in READABLE or wanted.startswith("KHR_materials_"))
        if not readable:
            message = f"{name}: requires the glTF extension {str(wanted)[:60]!r}, not supported; export without it"
            raise Rejected(codes.UNSUPPORTED_EXTENSION, message)


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
            raise _overrun(kind, end, length, len(data), name)
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


def _overrun(kind: int, end: int, length: int, size: int, name: str) -> Rejected:
    message = f"{name}: a chunk ends at byte {end}, the file at {size} (header: {length}); fetch it again"
    is_cut = kind == _BIN or end <= length
    return Rejected(codes.TRUNCATED if is_cut else codes.LENGTH_MISMATCH, message)


def data_uri(uri: str, where: str) -> bytes:
    """Bytes of a `data:` URI.

    Raises:
        Rejected: BAD_SCHEMA where it cannot be decoded.
    """
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
