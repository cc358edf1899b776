"""The format of a file, detected from its content, and its reader: a bundle of a main file and others -> RawModel."""

from __future__ import annotations

import io
import re
import struct
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import PurePosixPath
from typing import Protocol

import numpy as np

from casa_assets.errors import Rejected
from casa_assets.formats.read.raw_parts import check_face_count
from casa_assets.formats.read.text import Notes, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel

# Formats whose files are often the source, or another export, of a mesh of the same name beside them.
SECOND_CHOICE = frozenset(
    {".fbx", ".blend", ".usd", ".usda", ".usdc", ".usdz", ".x3d", ".wrl", ".vrml", ".3ds", ".off", ".xaml"}
)
# Files that hold meshes, or archives of them, in formats that are not read: suffix -> what it is and what to do.
UNREAD_SUFFIXES: Mapping[str, str] = {
    ".max": "a 3ds Max file; export it as GLB",
    ".ma": "a Maya file; export it as GLB",
    ".mb": "a Maya file; export it as GLB",
    ".c4d": "a Cinema 4D file; export it as GLB",
    ".lwo": "a LightWave file; convert it: assimp export IN.lwo OUT.glb",
    ".3dxml": "a 3DXML file; convert it to GLB",
    ".amf": "an AMF file; convert it: assimp export IN.amf OUT.glb",
    ".3dm": "a Rhino file; export it as GLB",
    ".skp": "a SketchUp file; export it as GLB",
    ".step": "a STEP file; export a mesh of it as GLB",
    ".stp": "a STEP file; export a mesh of it as GLB",
    ".iges": "an IGES file; export a mesh of it as GLB",
    ".igs": "an IGES file; export a mesh of it as GLB",
    ".abc": "an Alembic file; import it in Blender, export it as GLB",
    ".splat": "a cloud of Gaussians, not a surface; export a mesh",
    ".gz": "a gzip archive; unpack it: gunzip --keep FILE",
    ".bz2": "a bzip2 archive; unpack it: bunzip2 --keep FILE, or tar xf FILE",
    ".xz": "an xz archive; unpack it: unxz --keep FILE, or tar xf FILE",
    ".7z": "a 7z archive; unpack it: 7z x FILE",
    ".rar": "a RAR archive; unpack it: unrar x FILE",
    ".x": "a DirectX file; convert it: assimp export IN.x OUT.glb",
    ".dxf": "a DXF drawing; convert it: assimp export IN.dxf OUT.glb",
    ".ac": "an AC3D file; convert it: assimp export IN.ac OUT.glb",
    ".ase": "a 3D Studio text file; convert it: assimp export IN.ase OUT.glb",
    ".ms3d": "a MilkShape file; convert it: assimp export IN.ms3d OUT.glb",
    ".fcstd": "a FreeCAD file; export a mesh of it as GLB",
    ".sldprt": "a SolidWorks part; export a mesh of it as GLB",
    ".ztl": "a ZBrush file; export it as OBJ",
}
# Suffixes of a single packed file, whose name says what is in it: `chair.obj.gz`.
PACKED_SUFFIXES = frozenset({".gz", ".bz2", ".xz"})
# Magic numbers of things that are often saved under a mesh's name. Ref: the formats' own specifications.
_FOREIGN: tuple[tuple[bytes, str], ...] = (
    (b"\x89PNG\r\n\x1a\n", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"\x1f\x8b", "a gzip archive; unpack it"),
    (b"PK\x05\x06", "an empty zip archive"),
    (b"7z\xbc\xaf'\x1c", "a 7z archive; unpack it"),
    (b"version https://git-lfs", "a git-LFS pointer; run `git lfs pull` to fetch the file itself"),
    (b"%PDF", "a PDF document"),
    (b"Rar!", "a RAR archive; unpack it"),
)
# Errors of Python's readers on packed data that is broken.
PACKED_FAULTS = (
    *(zipfile.BadZipFile, zlib.error, struct.error, OSError, EOFError),
    *(ValueError, RuntimeError, LookupError, ArithmeticError),
)
# A hostile file may name thousands of files.
MAX_REFERENCES = 500
_OBJ_LINE = re.compile(rb"^[ \t]*(v|vn|vt|f|o|g|l|p|mtllib|usemtl|s)[ \t]+\S", re.MULTILINE)


class Format(StrEnum):
    """Formats that can be read; the values are the ids in RawModel.format. TRIMESH is a mesh in memory."""

    GLB = "glb"
    GLTF = "gltf"
    OBJ = "obj"
    PLY = "ply"
    STL = "stl"
    DAE = "dae"
    OFF = "off"
    THREE_MF = "threemf"
    XAML = "xaml"
    FBX = "fbx"
    USD = "usd"
    X3D = "x3d"
    VRML = "vrml"
    MAX_3DS = "max3ds"
    BLEND = "blend"
    TRIMESH = "trimesh"


class Role(StrEnum):
    """Role of a referenced file: buffers and layers are required, pictures and materials may be missing."""

    BUFFER = "buffer"
    MATERIAL = "material"
    IMAGE = "image"
    LAYER = "layer"


@dataclass(frozen=True)
class Reference:
    """A name as written in a file, and what it is for."""

    name: str
    role: Role


# Suffix of each format that files come in.
SUFFIX_OF: Mapping[Format, str] = {
    **{one: f".{one.value}" for one in Format if one is not Format.TRIMESH},
    Format.THREE_MF: ".3mf",
    Format.VRML: ".wrl",
    Format.MAX_3DS: ".3ds",
}
# Other suffixes of the same formats.
ALIASES: Mapping[str, Format] = {
    ".usda": Format.USD,
    ".usdc": Format.USD,
    ".usdz": Format.USD,
    ".vrml": Format.VRML,
}
SUFFIXES = frozenset(SUFFIX_OF.values()) | ALIASES.keys()
# For people: one suffix of each format.
LISTED = ", ".join(SUFFIX_OF.values())
# Magic numbers of what is read.
_MAGIC: tuple[tuple[bytes, Format], ...] = (
    (b"glTF", Format.GLB),
    (b"Kaydara FBX Binary", Format.FBX),
    (b"PXR-USDC", Format.USD),
    (b"#usda", Format.USD),
    (b"#VRML", Format.VRML),
    (b"BLENDER", Format.BLEND),
)


def suffix_of(name: str) -> str:
    """Suffix in lower case with its dot, such as `.glb`; empty if the name has no suffix."""
    return PurePosixPath(name).suffix.lower()


def sniff(data: bytes, name: str) -> Format:
    """Format of a main file. Raises Rejected."""
    if not data.strip(b" \t\r\n\0"):
        raise Rejected(codes.EMPTY_FILE, f"{name}: the file is empty ({len(data)} bytes); fetch it again")
    for magic, known in _MAGIC:
        if data.startswith(magic):
            return known
    if is_binary_stl(data):
        return Format.STL
    if data.startswith(b"PK\x03\x04"):
        return _zip(data, name)
    if suffix_of(name) == ".blend" and data.startswith((b"\x1f\x8b", b"\x28\xb5\x2f\xfd")):
        return Format.BLEND  # packed by gzip (until Blender 2.9) or Zstandard (since 3.0)
    if suffix_of(name) == ".3ds" and data.startswith(b"MM"):
        return Format.MAX_3DS
    for magic, what in _FOREIGN:
        if data.startswith(magic):
            raise Rejected(codes.WRONG_TYPE, f"{name}: this is {what}, not a mesh")
    return _sniff_text(data, name)


def _zip(data: bytes, name: str) -> Format:
    """3MF is a zip that is read. Others are never unpacked; one that would leave its folder is called what it is."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = [m.replace("\\", "/") for m in archive.namelist()]
    except PACKED_FAULTS:
        members = []  # damaged: all that is known of it are its first bytes
    if any(m.startswith("/") or m[1:2] == ":" or ".." in m.split("/") for m in members):
        message = f"{name}: a zip archive with members that leave the folder it is unpacked into; do not unpack it"
        raise Rejected(codes.PATH_TRAVERSAL, message)
    if any(m.lower().endswith("3d/3dmodel.model") for m in members):
        return Format.THREE_MF
    if members and suffix_of(members[0]) in (".usd", ".usda", ".usdc"):
        return Format.USD
    raise Rejected(codes.WRONG_TYPE, f"{name}: this is a zip archive; unpack it, not a mesh")


def _sniff_text(data: bytes, name: str) -> Format:
    # the first 4 KiB as one byte per character, whatever the encoding
    head = data[:4096].removeprefix(b"\xef\xbb\xbf")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        head = data[:8192].decode("utf-16", "replace").encode("ascii", "replace")
    start = head.lstrip()
    lower = start[:512].lower()
    if re.match(rb"ply[ \t]*[\r\n]", start):
        return Format.PLY
    if start.startswith(b"<"):
        is_named = suffix_of(name) == ".dae" and b"<html" not in lower
        if b"<COLLADA" in head or b":COLLADA" in head or is_named:
            return Format.DAE
        if b"schemas.microsoft.com/winfx/2006/xaml" in head:
            return Format.XAML
        if b"<X3D" in head:
            return Format.X3D
        what = "an HTML page (a failed download?)" if b"html" in lower else "XML, but not COLLADA"
        raise Rejected(codes.WRONG_TYPE, f"{name}: this is {what}, not a mesh; fetch it again")
    if start.startswith(b"{"):
        return Format.GLTF
    if suffix_of(name) == ".fbx" and re.search(rb"FBXHeaderExtension|; FBX \d", head):
        return Format.FBX
    if re.match(rb"C?OFF\s", start) and suffix_of(name) != ".obj":
        return Format.OFF
    if lower.startswith(b"solid") and re.search(rb"^[ \t]*(facet|endsolid)\b", data, re.MULTILINE):
        return Format.STL
    return _by_name(data, head, name)


def _by_name(data: bytes, head: bytes, name: str) -> Format:
    suffix = suffix_of(name)
    is_text = b"\0" not in head
    if is_text and suffix == ".stl" and head.lstrip()[:5].lower() == b"solid":
        return Format.STL
    if is_text and (suffix == ".obj" or _OBJ_LINE.search(data[: 1 << 20])):
        return Format.OBJ
    if suffix == ".obj" and data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return Format.OBJ
    if suffix == ".stl" and not is_text and len(data) >= 15:
        return Format.STL
    if suffix == ".glb":
        start = data[:4].decode("ascii", "backslashreplace")
        message = f"{name}: a GLB starts with 'glTF', this starts with {start!r}; fetch it again"
        raise Rejected(codes.BAD_MAGIC, message)
    if suffix in UNREAD_SUFFIXES:
        raise Rejected(codes.WRONG_TYPE, f"{name}: this is {UNREAD_SUFFIXES[suffix]}, not a mesh")
    raise Rejected(codes.WRONG_TYPE, f"{name}: the content is none of {LISTED}")


def is_binary_stl(data: bytes) -> bool:
    """A binary STL is 84 bytes and 50 per triangle, exactly: the only test that `solid` headers do not fool."""
    return len(data) >= 84 and struct.unpack_from("<I", data, 80)[0] * 50 + 84 == len(data)


# Readers --------------------------------------------------------------------------------------------------------------


class Reader(Protocol):
    """Functions that the module of a format provides."""

    def references(self, data: bytes, name: str) -> list[Reference]:
        """Other files that a file names, as written there; `name` is for messages. Raises Rejected."""

    def load(self, bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
        """The model of a bundle in file units and axes; what is left out goes into `notes`. Raises Rejected."""


def load(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """Read a bundle. Pure: no disk, no network, no clock.

    Args:
        bundle: main file and what it refers to.
        limits: input_faces, input_texture_px, input_texture_pixels, as registry/limits.yaml has them.
    Returns:
        Parts in file units and file axes; the bundle's notes come first among its notes.
    Raises:
        Rejected: with a code of casa_assets.model.rejection_codes.
    """
    name = printable(bundle.main)
    if bundle.model is not None:
        check_face_count(sum(len(p.mesh.faces) for p in bundle.model.parts), limits, name)
        return bundle.model.replace(notes=bundle.notes + bundle.model.notes)
    data = bundle.files[bundle.main]
    file_format = sniff(data, name)
    notes = Notes()
    suffix = suffix_of(bundle.main)
    if suffix != SUFFIX_OF[file_format] and ALIASES.get(suffix) is not file_format:
        notes.add(
            codes.TYPE_BY_CONTENT,
            name,
            f"{name}: read as {file_format.value.upper()} by its content, not by its name",
        )
    # hostile numbers overflow and cast badly; what comes of it is found and judged in rough.finish
    with np.errstate(all="ignore"):
        model = reader_of(file_format).load(bundle, limits, notes)
    return model.replace(notes=bundle.notes + notes.issues)


def references(file_format: Format, data: bytes, name: str) -> list[Reference]:
    """Files that a main file refers to, as written, each once, in file order. Raises Rejected where it is broken."""
    found = reader_of(file_format).references(data, name)
    return each_once(r for r in found if not r.name.startswith("data:"))


def each_once(found: Iterable[Reference]) -> list[Reference]:
    """Names of files, each once and not too many of them."""
    return list(dict.fromkeys(r for r in found if r.name))[:MAX_REFERENCES]


def reader_of(file_format: Format) -> Reader:
    """The reader of a format. They are imported when one is asked for: some need libraries that take long to import."""
    if file_format is Format.USD:
        from casa_assets.formats.read import usd

        return usd
    if file_format is Format.FBX:
        from casa_assets.formats.read import fbx

        return fbx
    if file_format in (Format.OFF, Format.THREE_MF, Format.XAML):
        from casa_assets.formats.read import from_trimesh

        return from_trimesh
    from casa_assets.formats.read import blend, collada, gltf, max3ds, obj, ply, stl, vrml

    readers: Mapping[Format, Reader] = {
        Format.GLB: gltf,
        Format.GLTF: gltf,
        Format.OBJ: obj,
        Format.PLY: ply,
        Format.STL: stl,
        Format.DAE: collada,
        Format.VRML: vrml,
        Format.X3D: vrml,
        Format.MAX_3DS: max3ds,
        Format.BLEND: blend,
    }
    return readers[file_format]


def warm() -> None:
    """Import the readers of common formats, once for all workers that are forked later."""
    reader_of(Format.GLB)
