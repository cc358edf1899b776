"""Results of discovery (inputs found and refused), kinds of other files by name, and package folders."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping, Set
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import PACKED_SUFFIXES, SECOND_CHOICE, SUFFIXES, UNREAD_SUFFIXES, suffix_of
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources.places import Folder, StoreRoot, archive_suffix, utf8_escaped
from casa_assets.ingest.sources.stores import folder_of
from casa_assets.model import rejection_codes as codes
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source


@dataclass(frozen=True)
class Found:
    """One input.

    Attributes:
        root: folder that its references may not leave (the package, or the folder that the user named): absolute, or on
            a store.
        main: main file, POSIX, relative to `root`.
        source: what its source says about it; `source.path` is relative to the folder that the user named.
        notes: warnings about what was said of it.
        archive: the archive that holds `main` and all that it refers to, POSIX, relative to `root`; empty: the disk.
            `main` is a path within it then.
        at: where in the archive `main` begins, see archive.Member; -1: to be searched. In a table: the row.
        is_model: `main` is no file of a stranger but the RawModel of a mesh that the caller has in memory, as JSON.
    """

    root: Path | StoreRoot
    main: str
    source: Source
    notes: tuple[Issue, ...] = ()
    is_model: bool = False
    archive: str = ""
    at: int = -1


@dataclass(frozen=True)
class Refused:
    """An entry that is in the place of an input and cannot be used.

    Attributes:
        path: POSIX, relative to the folder that the user named; of a manifest row, the manifest.
        code: of casa_assets.model.rejection_codes.
        message: file, line or place, reason, and what to do.
    """

    path: str
    code: str
    message: str


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

    `name`: of the file. `names`: of all files of the folder, in lower case.
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
    message = f"{posixpath.basename(path)}: this is {UNREAD_SUFFIXES[suffix]}, not a mesh that is read"
    return Refused(path, codes.WRONG_TYPE, message)


# The largest index in the wild (Objaverse 1.0 object paths) is 80 MB unpacked.
MAX_INDEX_BYTES = 128 * 1024 * 1024


@dataclass(frozen=True)
class Package:
    """A folder that says something about the meshes in it.

    Attributes:
        root: the folder: absolute, or on a store.
        prefix: the folder relative to what the user named, POSIX, empty or ending in `/`.
    """

    root: Path | StoreRoot
    prefix: str

    @cached_property
    def files(self) -> Folder:
        """The folder, to read and list."""
        return folder_of(self.root)

    def read(self, name: str) -> bytes:
        """Bytes of an index file of the package. Raises Rejected as read_file."""
        return self.files.read(name, MAX_INDEX_BYTES)

    def refuse(self, name: str, error: Rejected) -> Refused:
        """Refusal that points at a file of the package."""
        return Refused(utf8_escaped(self.prefix + name), error.code, error.message)

    def check_utf8(self, name: str) -> None:
        """Raises Rejected BAD_NAME where the path of a file is no text."""
        if utf8_escaped(self.prefix + name) != self.prefix + name:
            raise Rejected(codes.BAD_NAME, f"{utf8_escaped(name)}: the name is not UTF-8; rename the file")

    def file(self, value: object, place: str) -> str:
        """POSIX path, relative to the package, of a file that a row names; it exists and may be read.

        Raises Rejected: BAD_ROW, PATH_TRAVERSAL, MISSING_FILE, LINK_OUTSIDE, NOT_A_FILE, UNREADABLE.
        """
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            raise Rejected(codes.BAD_ROW, f"{place}: no usable file name ({printable(repr(value), 40)}); fix it")
        path = value.strip()
        if "\\" in path and not self.files.has(path):
            path = path.replace("\\", "/")
        whole = posixpath.normpath(path)
        if path.startswith("/") or re.match(r"[A-Za-z]:", path) or (whole.startswith("..") and whole[2:3] in ("", "/")):
            raise Rejected(codes.PATH_TRAVERSAL, f"{place}: {printable(path, 80)!r} leaves the package; fix it")
        try:
            self.files.check(whole)
        except Rejected as error:
            raise Rejected(error.code, f"{place}: {error.message}") from error
        except UnicodeError as error:
            raise Rejected(codes.BAD_NAME, f"{place}: a name that no file can have; fix it") from error
        return whole

    def found(self, main: str, source: Source) -> Found:
        """Found for a file of the package; the source's path is set here."""
        return Found(self.root, main, source.replace(path=self.prefix + main))
