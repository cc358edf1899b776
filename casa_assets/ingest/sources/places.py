"""Inputs of ingest and where they are: in a folder on the disk or on a store, or in an archive or a table in one.

All places are read by the same calls. Of an untrusted folder only regular files inside its root are read, bounded.
"""

from __future__ import annotations

import os
import posixpath
import re
import stat
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import IO
from urllib.parse import unquote, urlsplit

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import PACKED_SUFFIXES, SECOND_CHOICE, SUFFIXES, UNREAD_SUFFIXES, suffix_of
from casa_assets.formats.read.text import printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source

# By suffix: how an archive is read, and nothing else is. Others may need memory that no limit here would stop.
ARCHIVE_SUFFIXES = {".zip": "zip", ".zae": "zip", ".kmz": "zip", ".tar": "tar", ".tgz": "tar", ".tar.gz": "tar"}


def archive_suffix(name: str) -> str:
    """Suffix, in lower case, of an archive that is read (`.tar.gz` counts as one); empty for other names."""
    lower = name.lower()
    return next((s for s in (".tar.gz", *ARCHIVE_SUFFIXES) if lower.endswith(s) and lower != s), "")


# A table whose rows hold meshes, see table.py.
TABLE_SUFFIX = ".parquet"


def is_table(name: str) -> bool:
    """True for the name of a table."""
    return name.lower().endswith(TABLE_SUFFIX) and len(name) > len(TABLE_SUFFIX)


def utf8_escaped(path: str) -> str:
    """Escape a path for messages and records: names that are not UTF-8 become text."""
    return path if path.isascii() else path.encode("utf-8", "backslashreplace").decode("utf-8")


def is_inside(path: str, root: Path) -> bool:
    """True where the real place of `path`, links followed, lies under the real place of `root`."""
    real, base = os.path.realpath(path), os.path.realpath(root)
    return real == base or real.startswith(base.rstrip(os.sep) + os.sep)


def check_file(path: str, root: Path) -> os.stat_result:
    """Stat of a regular, readable file inside the root; it is not opened. Raises Rejected."""
    name = printable(posixpath.basename(utf8_escaped(path)))
    is_link = False
    try:
        # Not the state of what a link leads to: a link that takes the place of a file later has another inode, which
        # `read_file` notices. Path would take longer than all the rest.
        found = os.lstat(path)
        is_link = stat.S_ISLNK(found.st_mode)
        if is_link and not is_inside(path, root):
            raise Rejected(codes.LINK_OUTSIDE, f"{name}: a link that leaves its package; put the file itself there")
        if is_link:
            found = os.stat(path)  # noqa: PTH116
    except (FileNotFoundError, NotADirectoryError) as error:
        if is_link:
            raise Rejected(codes.NOT_A_FILE, f"{name}: a link to nothing; put the file itself there") from error
        raise Rejected(codes.MISSING_FILE, f"{name}: there is no such file; add it or fix the name") from error
    except OSError as error:
        message = f"{name}: cannot be looked at ({error.strerror}); put a regular file there"
        code = codes.UNREADABLE if isinstance(error, PermissionError) else codes.NOT_A_FILE
        raise Rejected(code, message) from error
    except ValueError as error:
        raise Rejected(codes.BAD_NAME, f"{name}: a name that no file can have; fix it") from error
    if (is_link or os.path.dirname(path) != str(root)) and not is_inside(path, root):  # noqa: PTH120
        raise Rejected(codes.LINK_OUTSIDE, f"{name}: behind a link that leaves its package; put the file itself there")
    if not stat.S_ISREG(found.st_mode):
        kind = "a folder" if stat.S_ISDIR(found.st_mode) else "a pipe, socket or device"
        raise Rejected(codes.NOT_A_FILE, f"{name}: {kind}, not a regular file; put the file itself there")
    if not os.access(path, os.R_OK):
        raise Rejected(codes.UNREADABLE, f"{name}: may not be read; change its permissions")
    return found


def read_file(path: str, root: Path, max_bytes: float) -> bytes:
    """Bytes of a regular file inside the root. Raises Rejected as `check_file`; TOO_LARGE before anything is read."""
    name = printable(Path(utf8_escaped(path)).name)
    checked = check_file(path, root)
    size = checked.st_size
    if size > max_bytes:
        raise too_large(name, size, max_bytes)
    try:
        # never blocks: what was a file at the check may be a pipe by now
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(handle, "rb") as stream:
            opened = os.fstat(handle)
            if not stat.S_ISREG(opened.st_mode):
                raise Rejected(codes.NOT_A_FILE, f"{name}: no longer a regular file")
            # A link that was put in its place meanwhile would lead anywhere.
            if (opened.st_dev, opened.st_ino) != (checked.st_dev, checked.st_ino):
                raise Rejected(codes.UNREADABLE, f"{name}: was exchanged while it was being opened; run again")
            return stream.read(size)
    except OSError as error:
        raise Rejected(codes.UNREADABLE, f"{name}: cannot be read ({error.strerror}); check the disk") from error


def too_large(name: str, size: int, max_bytes: float) -> Rejected:
    """Refusal of a file that is larger than an input may be."""
    message = f"{name}: {size} bytes, more than the {max(0, int(max_bytes))} left of --max-size; simplify it first"
    return Rejected(codes.TOO_LARGE, message)


_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+(?:://|::)")
_USER = re.compile(r"(?<=://)[^/@\s]*@")
_WEB = ("http://", "https://")


def is_url(text: str) -> bool:
    """True for an address such as `s3://bucket/meshes`; no path of a file that is there looks so."""
    return _URL.match(text) is not None


@dataclass(frozen=True)
class StoreRoot:
    """A folder on a store, or a file that a user named.

    `base`: URL as the user named it, with the user and password that it may contain. `query`: of a web address, with
    its `?`; it is sent with every request below it. It may be a signature. `path`: POSIX, relative to `base`.
    """

    base: str = field(repr=False)
    query: str = field(default="", repr=False)
    path: str = ""

    def __truediv__(self, path: str) -> StoreRoot:
        return replace(self, path=posixpath.normpath(posixpath.join(self.path, path))) if path else self

    def __str__(self) -> str:
        """The address, as it may be shown and written down."""
        public = hide_secrets(self.base)
        return f"{public}/{self.path}" if self.path else public

    def hide(self, text: str) -> str:
        """Text, such as that of an error, without the secrets of this address or of any other."""
        user = urlsplit(self.base).netloc.rpartition("@")[0]
        for secret in (f"{user}@" if user else "", self.query):
            text = text.replace(secret, "") if secret else text
        return hide_secrets(text)

    @property
    def is_web(self) -> bool:
        """True for http and https, whose names are quoted and whose folders are pages."""
        return self.base.startswith(_WEB)

    @property
    def name(self) -> str:
        """Last name of the path; of a bucket its own, of a web server none."""
        if self.path:
            return posixpath.basename(self.path)
        last = self.base.rpartition("/")[2]
        if self.is_web:
            return unquote(last) if urlsplit(self.base).path else ""
        return last

    @property
    def parent(self) -> StoreRoot:
        """The folder around it."""
        if self.path:
            return replace(self, path=posixpath.dirname(self.path))
        return replace(self, base=self.base.rpartition("/")[0])


def root_of(text: str) -> Path | StoreRoot:
    """Return the path or address that a user named; `file:` addresses are paths."""
    if not is_url(text):
        return Path(text)
    if text.lower().startswith("file://"):
        return Path(unquote(urlsplit(text).path))
    if text.startswith(_WEB):
        parts = urlsplit(text)
        query = f"?{parts.query}" if parts.query else ""
        return StoreRoot(f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}", query)
    return StoreRoot(text if text.endswith("://") else text.rstrip("/"))


def hide_secrets(text: str) -> str:
    """Text without the users, passwords and queries of the addresses in it."""
    text = _USER.sub("", text)
    return re.sub(r"(https?://[^\s?'\"]*)\?[^\s'\"]*", r"\1", text)


class Place(ABC):
    """Files by their POSIX path from a root that none may leave."""

    @abstractmethod
    def read(self, path: str, max_bytes: float) -> bytes:
        """Bytes of a file. Raises Rejected as read_file."""

    @abstractmethod
    def has(self, path: str) -> bool:
        """True if a file or folder exists there."""

    def is_inside(self, folder: str) -> bool:
        """True where a folder, links followed, does not leave the root; among most files there are no links."""
        return True

    @abstractmethod
    def listing(self, folder: str) -> list[str]:
        """Names in a folder, sorted; empty if it cannot be read."""


@dataclass(frozen=True)
class Entry:
    """An entry of a folder; a link is neither a folder nor a file."""

    name: str
    is_folder: bool
    is_file: bool


class Folder(Place):
    """A place that inputs are looked for in."""

    @abstractmethod
    def scan(self, folder: str) -> list[Entry]:
        """Entries of a folder, sorted by the bytes of their names. Raises OSError, Rejected."""

    @abstractmethod
    def check(self, path: str) -> None:
        """Check that a file may be read, without opening it. Raises Rejected as check_file."""

    @abstractmethod
    def open(self, path: str, block: int) -> IO[bytes]:
        """A checked file, to seek in; `block`: bytes that a store gives at once. Raises OSError, Rejected."""

    @abstractmethod
    def identity(self, path: str) -> str:
        """Text that is the same for all paths to one file."""


@dataclass(frozen=True)
class _DiskFolder(Folder):
    """A folder on the disk; `root`: absolute. `looked_at`: see `folder_of`."""

    root: Path
    looked_at: set[str] | None = None

    def read(self, path: str, max_bytes: float) -> bytes:
        return read_file(self._look(path), self.root, max_bytes)

    def has(self, path: str) -> bool:
        return os.path.lexists(self._look(path))

    def is_inside(self, folder: str) -> bool:
        return is_inside(self._at(folder), self.root)

    def listing(self, folder: str) -> list[str]:
        try:
            return sorted(os.listdir(self._look(folder)))  # noqa: PTH208
        except OSError:
            return []

    def scan(self, folder: str) -> list[Entry]:
        entries = sorted(os.scandir(self._at(folder)), key=lambda e: os.fsencode(e.name))
        return [Entry(e.name, e.is_dir(follow_symlinks=False), e.is_file(follow_symlinks=False)) for e in entries]

    def check(self, path: str) -> None:
        check_file(self._at(path), self.root)

    def open(self, path: str, block: int) -> IO[bytes]:
        return open(self._at(path), "rb")  # noqa: PTH123

    def identity(self, path: str) -> str:
        return os.path.realpath(self._at(path))

    @cached_property
    def _prefix(self) -> str:
        return str(self.root).rstrip(os.sep) + os.sep

    def _at(self, path: str) -> str:
        # Path would take longer than all the rest.
        return self._prefix + path if path else str(self.root)

    def _look(self, path: str) -> str:
        whole = self._at(path)
        if self.looked_at is not None:
            self.looked_at.add(whole)
        return whole


@dataclass(frozen=True)
class _PackedPlace(Place):
    content: Callable[[str, float], bytes]
    names: Callable[[], Iterable[str]]

    def read(self, path: str, max_bytes: float) -> bytes:
        return self.content(path, max_bytes)

    @cached_property
    def _in_folder(self) -> dict[str, set[str]]:
        found: dict[str, set[str]] = {}
        for path in self.names():
            folder, name = posixpath.split(path)
            found.setdefault(folder, set()).add(name)
        return found

    def has(self, path: str) -> bool:
        folder, name = posixpath.split(path)
        return name in self._in_folder.get(folder, ())

    def listing(self, folder: str) -> list[str]:
        return sorted(self._in_folder.get(folder, ()))


def packed_place(content: Callable[[str, float], bytes], names: Callable[[], Iterable[str]]) -> Place:
    """Members of an archive, or a row of a table, without links; `content`: as `Place.read`, `names`: all paths."""
    return _PackedPlace(content, names)


def folder_of(root: Path | StoreRoot, looked_at: set[str] | None = None) -> Folder:
    """The folder that a root names; `looked_at` takes up the paths of all that is looked at, missing files too."""
    if isinstance(root, Path):
        return _DiskFolder(root, looked_at)
    from casa_assets.ingest.sources.stores import store_folder  # most inputs are on the disk

    return store_folder(root, looked_at)


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

    `path`: POSIX, relative to the folder that the user named; of a manifest row, the manifest. `code`: of
    casa_assets.model.rejection_codes. `message`: file, line or place, reason, and what to do.
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

    `root`: the folder: absolute, or on a store. `prefix`: the folder relative to what the user named, POSIX, empty or
    ending in `/`.
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
        """POSIX path in the package of a file that a row names; it exists and may be read. Raises Rejected."""
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


# Words that may name a category, of one source.
MAX_HINTS = 40


def unique_hints(*groups: Iterable[str]) -> tuple[str, ...]:
    """All words in order, each once, without empty ones and content hashes."""
    out: dict[str, None] = {}
    for group in groups:
        for one in group:
            text = one.strip()
            if text and not re.fullmatch(r"[0-9a-f]{8,64}|\d+(-\d+)?", text):
                out[text] = None
    return tuple(out)[:MAX_HINTS]


def words_of_path(path: str) -> list[str]:
    """Stem of a POSIX path, then the folders around it from the inside out, which may name what it holds."""
    return [posixpath.splitext(posixpath.basename(path))[0], *posixpath.dirname(path).split("/")[::-1]]
