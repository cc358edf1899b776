"""Archives (zip, tar) in a folder: their members, bounded in number and size; no link among them is followed.

Meshes in an archive are inputs named `archive.zip!member`. A JSON member of a tar that has the name of a mesh
describes it, as in a shard of WebDataset: files of one key belong together, `0001.glb` and `0001.json`. A key is the
path up to the first dot of the file's name, as the `webdataset` package reads it.
"""

from __future__ import annotations

import gzip
import io
import posixpath
import re
import stat
import struct
import tarfile
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import IO

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import PACKED_FAULTS
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources.places import (
    ARCHIVE_SUFFIXES,
    HIDDEN,
    Folder,
    Found,
    Package,
    Place,
    Refused,
    archive_suffix,
    kind_of_other,
    packed_place,
    unique_hints,
    unread,
    utf8_escaped,
)
from casa_assets.ingest.sources.rows import (
    as_object,
    check_types,
    check_unique,
    parse_json,
    remarks,
    safe_id,
    source_of,
)
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Source, SourceKind

# What an archive may hold; choices. A zip's list of members is read whole, so its size is bounded too. Shards of
# WebDataset, which are tars, have several members for each sample.
MAX_MEMBERS = {"zip": 20_000, "tar": 100_000}
MAX_LIST_BYTES = 4 << 20
MAX_BYTES = 4 << 30
# What a tar says of its own members, one JSON for each mesh; choices. Those of Objaverse have 10 kB.
MAX_TEXT_BYTES = 1 << 20
MAX_TEXTS_BYTES = 64 << 20
# Bytes that are fetched at once from a store: where all of an archive is read through, and where one member is.
STREAM_BLOCK = 4 << 20
SEEK_BLOCK = 256 << 10
# Deflate packs 1032 to one at most, and meshes ten to one; small files of blanks come near it.
MAX_RATIO = 200
SMALL_BYTES = 1 << 20
_FAULTS = (*PACKED_FAULTS, tarfile.TarError)


def _plain(path: str) -> str:
    return posixpath.normpath(path.replace("\\", "/"))


@dataclass(frozen=True)
class Member:
    """A regular file in an archive.

    `path`: in the archive, POSIX. `size`: as the archive claims it. `at`: byte of a tar at which its header begins,
    unpacked; -1 of a zip. `packed`: bytes that it takes in the archive; of a tar, those of all.
    """

    path: str
    size: int
    at: int = -1
    packed: int = 0


class _Bounded:
    """A stream that ends in an error where it unpacks to too much, and gives out no long headers."""

    def __init__(self, stream: IO[bytes] | gzip.GzipFile, packed_size: int) -> None:
        self._stream, self.packed_size = stream, packed_size
        self._most = min(MAX_BYTES, max(SMALL_BYTES, MAX_RATIO * packed_size))

    def read(self, size: int) -> bytes:
        if not 0 <= size <= MAX_LIST_BYTES:
            raise tarfile.ReadError(f"a header of {size} bytes")
        return self.content(size)

    def content(self, size: int) -> bytes:
        if self._stream.tell() + size > self._most:
            raise tarfile.ReadError(f"it unpacks to over {MAX_RATIO} times its size")
        return self._stream.read(size)

    def seek(self, place: int) -> int:
        if place > self._most:
            raise tarfile.ReadError(f"it unpacks to over {MAX_RATIO} times its size")
        return self._stream.seek(place)

    def tell(self) -> int:
        return self._stream.tell()


@dataclass(frozen=True)
class Archive:
    """An archive in a folder; `path`: of the file there, POSIX."""

    path: str
    folder: Folder

    def members(self, texts: dict[str, bytes] | None = None) -> tuple[Member, ...]:
        """Regular files in it, sorted by path; of several of one path the first. Raises Rejected.

        `texts`: takes up the JSON members of a tar by their paths, as it is read through: of each at most one byte more
        than MAX_TEXT_BYTES, of all together MAX_TEXTS_BYTES; None: none is read.
        """
        self.folder.check(self.path)
        found: dict[str, Member] = {}
        total, most = 0, MAX_MEMBERS["zip" if self._is_zip else "tar"]
        try:
            for count, one in enumerate(self._entries(texts), start=1):
                total += one.size
                if count > most or total > MAX_BYTES:
                    raise self._refused(codes.TOO_LARGE, f"holds more than {most} files or {MAX_BYTES} bytes")
                if one.size > SMALL_BYTES and one.size > MAX_RATIO * one.packed:
                    raise self._refused(codes.TOO_LARGE, f"unpacks to over {MAX_RATIO} times its size")
                if one.path.startswith(("/", "../")) or one.path == ".." or re.match(r"[A-Za-z]:", one.path):
                    raise self._refused(codes.PATH_TRAVERSAL, "has members that leave the folder it is unpacked into")
                found.setdefault(one.path, one)
        except _FAULTS as error:
            why = printable(str(error), 80) or type(error).__name__
            raise self._refused(codes.BAD_ARCHIVE, f"cannot be read ({why})") from error
        return tuple(found[path] for path in sorted(found))

    def read(self, path: str, max_bytes: float, at: int = -1) -> bytes:
        """Bytes of a member.

        `at`: where a tar has it, see Member; where another member or none begins there the tar is searched. Raises
        Rejected: MISSING_FILE, TOO_LARGE before anything is unpacked, BAD_ARCHIVE.
        """
        self.folder.check(self.path)
        try:
            data = self._content(path, int(max_bytes) + 1, at) if at > 0 and not self._is_zip else None
            data = self._content(path, int(max_bytes) + 1) if data is None else data
        except _FAULTS as error:
            why = printable(str(error), 80) or type(error).__name__
            raise self._refused(codes.BAD_ARCHIVE, f"cannot be unpacked ({why})") from error
        if data is None:
            raise Rejected(codes.MISSING_FILE, f"{printable(path, 80)}: there is no such file in the archive; add it")
        if len(data) > max_bytes:
            name, most = printable(posixpath.basename(path)), max(0, int(max_bytes))
            raise Rejected(codes.TOO_LARGE, f"{name}: more than the {most} bytes left of --max-size; simplify it first")
        return data

    def _entries(self, texts: dict[str, bytes] | None) -> Iterator[Member]:
        if self._is_zip:
            with self._zip() as packed:
                for info in packed.infolist():
                    if not info.is_dir() and not stat.S_ISLNK(info.external_attr >> 16):
                        yield Member(_plain(info.filename), info.file_size, packed=info.compress_size)
            return
        left = MAX_TEXTS_BYTES
        with self._tar(STREAM_BLOCK) as (packed_tar, bounded):
            for one in packed_tar:
                if one.isfile() and not one.issparse():
                    member = Member(_plain(one.name), one.size, one.offset, bounded.packed_size)
                    yield member
                    if texts is not None and member.path.lower().endswith(".json") and member.path not in texts:
                        bounded.seek(one.offset_data)
                        texts[member.path] = bounded.content(min(one.size, MAX_TEXT_BYTES + 1, left))
                        left -= len(texts[member.path])
                packed_tar.members = []  # type: ignore[attr-defined]  # the library keeps all that it has seen

    def _content(self, path: str, most: int, at: int = 0) -> bytes | None:
        """At most `most` bytes of a member, or None; `at`: byte of a tar at which the only header to look at begins."""
        if self._is_zip:
            with self._zip() as packed:
                for info in packed.infolist():
                    is_link = stat.S_ISLNK(info.external_attr >> 16)
                    if _plain(info.filename) == path and not info.is_dir() and not is_link:
                        with packed.open(info) as stream:
                            return stream.read(min(info.file_size, most))
            return None
        with self._tar(SEEK_BLOCK if at else STREAM_BLOCK, at) as (packed_tar, bounded):
            for one in packed_tar:
                if one.isfile() and not one.issparse() and _plain(one.name) == path:
                    bounded.seek(one.offset_data)
                    return bounded.content(min(one.size, most))
                if at:
                    break
        return None

    @property
    def _is_zip(self) -> bool:
        return ARCHIVE_SUFFIXES.get(archive_suffix(self.path)) == "zip"

    @contextmanager
    def _zip(self) -> Iterator[zipfile.ZipFile]:
        with self.folder.open(self.path, SEEK_BLOCK) as stream:
            self._check_list(stream)
            with zipfile.ZipFile(stream) as packed:
                yield packed

    @contextmanager
    def _tar(self, block: int, at: int = 0) -> Iterator[tuple[tarfile.TarFile, _Bounded]]:
        """The tar from a byte on, and what it is read from; nothing else than gzip unpacks it."""
        with self.folder.open(self.path, block) as raw:
            whole = raw.seek(0, io.SEEK_END)
            raw.seek(0)
            is_packed = raw.read(2) == b"\x1f\x8b"
            raw.seek(0)
            unpacked = gzip.GzipFile(fileobj=raw) if is_packed else raw
            bounded = _Bounded(unpacked, whole)
            bounded.seek(at)
            with tarfile.open(fileobj=bounded, mode="r:") as packed_tar:  # type: ignore[call-overload]
                yield packed_tar, bounded

    def _check_list(self, stream: IO[bytes]) -> None:
        """Look at the record at the end of a zip, before its list of members is read whole."""
        size = stream.seek(0, io.SEEK_END)
        stream.seek(max(0, size - 65_600))
        tail = stream.read(65_600)
        at = tail.rfind(b"PK\x05\x06")
        if at < 0 or at + 22 > len(tail):
            raise zipfile.BadZipFile("it has no list of its members")
        listed, count = struct.unpack_from("<I", tail, at + 12)[0], struct.unpack_from("<H", tail, at + 10)[0]
        if tail[max(0, at - 20) :][:4] == b"PK\x06\x07" or listed > MAX_LIST_BYTES or count > MAX_MEMBERS["zip"]:
            raise self._refused(codes.TOO_LARGE, f"lists more than {MAX_MEMBERS['zip']} members")

    def _refused(self, code: str, why: str) -> Rejected:
        name = printable(posixpath.basename(self.path))
        return Rejected(code, f"{name}: an archive that {why}; unpack what you need of it and name that folder")


def members_of(folder: Folder, path: str, main: str, at: int) -> Place:
    """The members of an archive in a folder; that called `main` begins at a byte of a tar, -1: it is searched."""
    archive = Archive(path, folder)

    def read(member: str, max_bytes: float) -> bytes:
        return archive.read(member, max_bytes, at if member == main else -1)

    return packed_place(read, lambda: (member.path for member in archive.members()))


def _described(
    found: Found, package: Package, name: str, texts: Mapping[str, bytes], is_full: bool, ids: dict[str, str]
) -> Found | Refused:
    """A mesh of a tar with the description in its JSON; unchanged if it has none; refused if the JSON is wrong.

    `name`: of the tar. `texts`: content of its JSON members by their paths, see Archive; `is_full`: at their limit.
    """
    folder, base = posixpath.split(found.main)
    # under its name, or under its key
    names = posixpath.splitext(base)[0], base.partition(".")[0]
    path = next((p for p in (posixpath.join(folder, f"{n}.json") for n in names) if p in texts), None)
    if path is None:
        return found
    place = f"{printable(name)}!{printable(path, 80)}"
    text = texts[path]
    try:
        if len(text) > MAX_TEXT_BYTES or (is_full and not text.rstrip().endswith((b"}", b"]"))):
            message = f"{place}: over {MAX_TEXT_BYTES} bytes, or over {MAX_TEXTS_BYTES} with the others; shorten it"
            raise Rejected(codes.TOO_LARGE, message)
        row = as_object(parse_json(text.decode("utf-8-sig", "replace"), place), place)
        value = row.get("uid", row.get("id"))  # without one the key distinguishes samples
        uid = "" if value is None else safe_id(str(value) if type(value) is int else value, place)
        check_unique(uid, place, ids)
        check_types(row, place)
    except Rejected as error:
        return package.refuse(name, error)
    if uid:
        ids[uid] = place
    source = source_of(row, found.source.path, uid, found.source.hints)
    return replace(found, source=source, notes=remarks(place, row))


def archived(package: Package, name: str, others: Counter[str]) -> Iterator[Found | Refused]:
    """Inputs in one archive of a folder; refused as a whole where it is broken, too large, or leaves its folder."""
    try:
        package.check_utf8(name)
        texts: dict[str, bytes] = {}
        members = Archive(name, package.files).members(texts)
    except Rejected as error:
        yield package.refuse(name, error)
        return
    ids, is_full = dict[str, str](), sum(map(len, texts.values())) >= MAX_TEXTS_BYTES
    in_folder: dict[str, set[str]] = {}
    for member in members:
        folder, base = posixpath.split(member.path)
        in_folder.setdefault(folder, set()).add(base.lower())
    for member in members:
        folders, base = member.path.split("/")[:-1], posixpath.basename(member.path)
        place = utf8_escaped(f"{package.prefix}{name}!{member.path}")
        if any(part.startswith(".") or part == "__MACOSX" for part in (*folders, base)):
            others[HIDDEN] += 1
        elif kind := kind_of_other(base, in_folder[posixpath.dirname(member.path)]):
            others[kind] += 1
        elif archive_suffix(base):
            message = f"{utf8_escaped(base)}: an archive within an archive; unpack the outer one and name the folder"
            yield Refused(place, codes.BAD_ARCHIVE, message)
        elif (refused := unread(place)) is not None:
            yield refused
        else:
            around = [*folders[::-1], name[: -len(archive_suffix(name))]]
            outer = package.prefix.rstrip("/").split("/")[::-1]
            hints = unique_hints([posixpath.splitext(base)[0]], around, outer, [package.root.name])
            source = Source(kind=SourceKind.FOLDER, path=place, hints=hints)
            found = Found(package.root, member.path, source, archive=name, at=member.at)
            yield _described(found, package, name, texts, is_full, ids)
