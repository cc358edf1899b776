"""Archives (zip, tar) in a folder: their members, bounded in number and size; no link among them is followed."""

from __future__ import annotations

import gzip
import io
import posixpath
import re
import stat
import struct
import tarfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.sources.bounded_reads import check_file

# By suffix: how it is read, and nothing else is. Others may need memory that no limit here would stop.
SUFFIXES = {".zip": "zip", ".zae": "zip", ".kmz": "zip", ".tar": "tar", ".tgz": "tar", ".tar.gz": "tar"}
# What an archive may hold; choices. A zip's list of members is read whole, so its size is bounded too.
MAX_MEMBERS = 20_000
MAX_LIST_BYTES = 4 << 20
MAX_BYTES = 4 << 30
# Deflate packs 1032 to one at most, and meshes ten to one; small files of blanks come near it.
MAX_RATIO = 200
SMALL_BYTES = 1 << 20
_FAULTS = (
    zipfile.BadZipFile,
    tarfile.TarError,
    gzip.BadGzipFile,
    zlib.error,
    struct.error,
    OSError,
    EOFError,
    ValueError,
    RuntimeError,
    NotImplementedError,
    KeyError,
    IndexError,
    OverflowError,
    UnicodeError,
)


def archive_suffix(name: str) -> str:
    """Suffix of an archive that is read, in lower case, `.tar.gz` among them; empty where it is none."""
    lower = name.lower()
    return next((s for s in (".tar.gz", *SUFFIXES) if lower.endswith(s) and lower != s), "")


def _plain(path: str) -> str:
    return posixpath.normpath(path.replace("\\", "/"))


@dataclass(frozen=True)
class Member:
    """A regular file in an archive: its path there, POSIX, and its size as the archive claims it."""

    path: str
    size: int


class _Bounded:
    """A stream that ends in an error past so many bytes, and gives out no headers of more than a few."""

    def __init__(self, stream: IO[bytes] | gzip.GzipFile, most: int) -> None:
        self._stream, self._most = stream, most

    def read(self, size: int) -> bytes:
        """As of a file."""
        if not 0 <= size <= MAX_LIST_BYTES:
            raise tarfile.ReadError(f"a header of {size} bytes")
        return self.content(size)

    def content(self, size: int) -> bytes:
        """As `read`, of any size."""
        if self._stream.tell() + size > self._most:
            raise tarfile.ReadError(f"it unpacks to over {MAX_RATIO} times its size")
        return self._stream.read(size)

    def seek(self, place: int) -> int:
        """As of a file."""
        if place > self._most:
            raise tarfile.ReadError(f"it unpacks to over {MAX_RATIO} times its size")
        return self._stream.seek(place)

    def tell(self) -> int:
        """As of a file."""
        return self._stream.tell()


@dataclass(frozen=True)
class Archive:
    """An archive on disk.

    Attributes:
        path: of the file. root: folder that it may not lie outside of.
    """

    path: str
    root: Path

    def members(self) -> tuple[Member, ...]:
        """Regular files in it, sorted by path; of several of one path the first.

        Raises:
            Rejected: BAD_ARCHIVE, TOO_LARGE, PATH_TRAVERSAL, and what files are refused for.
        """
        check_file(self.path, self.root)
        found: dict[str, int] = {}
        total = 0
        try:
            for count, (path, size, packed) in enumerate(self._entries(), start=1):
                total += size
                if count > MAX_MEMBERS or total > MAX_BYTES:
                    raise self._refused(codes.TOO_LARGE, f"holds more than {MAX_MEMBERS} files or {MAX_BYTES} bytes")
                if size > SMALL_BYTES and size > MAX_RATIO * packed:
                    raise self._refused(codes.TOO_LARGE, f"unpacks to over {MAX_RATIO} times its size")
                plain = _plain(path)
                if plain.startswith(("/", "../")) or plain == ".." or re.match(r"[A-Za-z]:", plain):
                    raise self._refused(codes.PATH_TRAVERSAL, "has members that leave the folder it is unpacked into")
                found.setdefault(plain, size)
        except _FAULTS as error:
            why = printable(str(error), 80) or type(error).__name__
            raise self._refused(codes.BAD_ARCHIVE, f"cannot be read ({why})") from error
        return tuple(Member(path, found[path]) for path in sorted(found))

    def read(self, path: str, max_bytes: float) -> bytes:
        """Bytes of a member.

        Raises:
            Rejected: MISSING_FILE, TOO_LARGE before anything is unpacked, BAD_ARCHIVE.
        """
        try:
            data = self._content(path, int(max_bytes) + 1)
        except _FAULTS as error:
            why = printable(str(error), 80) or type(error).__name__
            raise self._refused(codes.BAD_ARCHIVE, f"cannot be unpacked ({why})") from error
        if data is None:
            raise Rejected(codes.MISSING_FILE, f"{printable(path, 80)}: there is no such file in the archive; add it")
        if len(data) > max_bytes:
            name, most = printable(posixpath.basename(path)), max(0, int(max_bytes))
            raise Rejected(codes.TOO_LARGE, f"{name}: more than the {most} bytes left of --max-size; simplify it first")
        return data

    def _entries(self) -> Iterator[tuple[str, int, int]]:
        """Path, size and packed size of every regular file."""
        if self._is_zip:
            self._check_list()
            with zipfile.ZipFile(self.path) as packed:
                for info in packed.infolist():
                    if not info.is_dir() and not stat.S_ISLNK(info.external_attr >> 16):
                        yield info.filename, info.file_size, info.compress_size
            return
        whole = Path(self.path).stat().st_size
        with self._tar() as (packed_tar, _):
            for one in packed_tar:
                if one.isfile() and not one.issparse():
                    yield one.name, one.size, whole
                packed_tar.members = []  # type: ignore[attr-defined]  # the library keeps all that it has seen

    def _content(self, path: str, most: int) -> bytes | None:
        """Bytes of a member, at most so many; None where there is none."""
        if self._is_zip:
            self._check_list()
            with zipfile.ZipFile(self.path) as packed:
                for info in packed.infolist():
                    is_link = stat.S_ISLNK(info.external_attr >> 16)
                    if _plain(info.filename) == path and not info.is_dir() and not is_link:
                        with packed.open(info) as stream:
                            return stream.read(min(info.file_size, most))
            return None
        with self._tar() as (packed_tar, bounded):
            for one in packed_tar:
                if one.isfile() and not one.issparse() and _plain(one.name) == path:
                    bounded.seek(one.offset_data)
                    return bounded.content(min(one.size, most))
        return None

    @property
    def _is_zip(self) -> bool:
        return SUFFIXES.get(archive_suffix(self.path)) == "zip"

    @contextmanager
    def _tar(self) -> Iterator[tuple[tarfile.TarFile, _Bounded]]:
        """The tar, and what it is read from; nothing else than gzip unpacks it."""
        with Path(self.path).open("rb") as raw:
            whole = raw.seek(0, io.SEEK_END)
            raw.seek(0)
            is_packed = raw.read(2) == b"\x1f\x8b"
            raw.seek(0)
            unpacked = gzip.GzipFile(fileobj=raw) if is_packed else raw
            bounded = _Bounded(unpacked, min(MAX_BYTES, max(SMALL_BYTES, MAX_RATIO * whole)))
            with tarfile.open(fileobj=bounded, mode="r:") as packed_tar:  # type: ignore[call-overload]
                yield packed_tar, bounded

    def _check_list(self) -> None:
        """Look at the record at the end of a zip, before its list of members is read whole."""
        with Path(self.path).open("rb") as stream:
            size = stream.seek(0, io.SEEK_END)
            stream.seek(max(0, size - 65_600))
            tail = stream.read()
        at = tail.rfind(b"PK\x05\x06")
        if at < 0 or at + 22 > len(tail):
            raise zipfile.BadZipFile("it has no list of its members")
        listed, count = struct.unpack_from("<I", tail, at + 12)[0], struct.unpack_from("<H", tail, at + 10)[0]
        if tail[max(0, at - 20) :][:4] == b"PK\x06\x07" or listed > MAX_LIST_BYTES or count > MAX_MEMBERS:
            raise self._refused(codes.TOO_LARGE, f"lists more than {MAX_MEMBERS} members")

    def _refused(self, code: str, why: str) -> Rejected:
        name = printable(posixpath.basename(self.path))
        return Rejected(code, f"{name}: an archive that {why}; unpack what you need of it and name that folder")
