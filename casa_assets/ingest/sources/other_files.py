"""Classify files that are not meshes by name: counted, or refused if they hold a mesh in a format that is not read."""

from __future__ import annotations

import posixpath
from collections.abc import Mapping, Set

from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import (
    PACKED_SUFFIXES,
    SECOND_CHOICE,
    SUFFIXES,
    UNREAD_SUFFIXES,
    suffix_of,
)
from casa_assets.ingest.sources.containers.archive import archive_suffix
from casa_assets.ingest.sources.found import Refused

HIDDEN = "hidden files"
# What a file is by its suffix; all others are called other files.
_KINDS: Mapping[str, str] = {
    "pictures": ".png .jpg .jpeg .webp .bmp .tga .tif .tiff .gif .exr .hdr .dds .ktx .ktx2 .basis .psd .xcf .svg .ico",
    "materials": ".mtl .material .mat .mdl .mtlx",
    "buffers": ".bin .buf .npy .npz",
    "texts": ".txt .md .rst .html .htm .pdf .doc .docx .rtf .license .licence",
    "tables and settings": ".json .jsonl .csv .tsv .xml .yaml .yml .toml .ini .cfg .sqlite .parquet .meta .import",
    "robots and worlds": ".urdf .xacro .sdf .srdf .world",
    "programs": ".py .js .ts .cpp .c .h .hpp .cs .java .sh .bat .lua .glsl .frag .vert .shader",
    "sounds and films": ".wav .mp3 .ogg .flac .mp4 .mov .avi .webm .mkv",
}
_KIND_OF = {suffix: kind for kind, suffixes in _KINDS.items() for suffix in suffixes.split()}
TWINS = "other forms of a mesh beside it"


def kind_of_other(name: str, names: Set[str]) -> str:
    """Kind of a file that is not an input; empty if it is an input, or holds a mesh that is not read.

    A mesh in a format of second choice (a modeller's own file, a format that programs read in different ways) is not an
    input if a file of first choice has the same name, as both hold the same object.

    Args:
        name: of the file. names: of all files of the folder, in lower case.
    """
    lower = name.lower()
    stem, suffix = posixpath.splitext(lower)
    stem = lower[: -len(archive_suffix(name))] if archive_suffix(name) else stem
    has_twin = any(stem + readable in names for readable in SUFFIXES - SECOND_CHOICE)
    if archive_suffix(name) == ".tar.gz":
        return ""
    if suffix in PACKED_SUFFIXES and suffix_of(stem) not in SUFFIXES | UNREAD_SUFFIXES.keys():
        return "packed files"  # a single file that is packed, such as an index or a table
    if suffix in SECOND_CHOICE | UNREAD_SUFFIXES.keys():
        return TWINS if has_twin else ""
    if suffix in SUFFIXES or archive_suffix(name):
        return ""
    return _KIND_OF.get(suffix, "other files")


def unread(path: str) -> Refused | None:
    """The refusal of a mesh in a format that is not read; None if it is read."""
    suffix = suffix_of(path)
    if suffix not in UNREAD_SUFFIXES:
        return None
    name = posixpath.basename(path)
    message = f"{name}: this is {UNREAD_SUFFIXES[suffix]}, not a mesh that is read"
    return Refused(path, codes.WRONG_TYPE, message)
