"""The files that a pack is made of: those under a folder, and those in its zips; every read is bounded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from casa_assets.errors import Rejected
from casa_assets.ingest.sources.containers.archive import Archive
from casa_assets.ingest.sources.places import DiskFolder
from casa_assets.textures.packs.entry import RejectedPicture
from casa_assets.textures.packs.limits import MAX_FILE_BYTES
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error, rejection_row

ZIP = ".zip"


@dataclass(frozen=True)
class SourceFile:
    """A file of a source.

    Attributes:
        path: POSIX, relative to the folder; of a member of a zip that of the zip, a slash, and its own.
        read: its bytes. Raises Rejected.
    """

    path: str
    read: Callable[[], bytes]

    @property
    def suffix(self) -> str:
        """In lower case, with its dot."""
        return Path(self.path).suffix.lower()


@dataclass(frozen=True)
class SourceFiles:
    """The files of a source, sorted by path, and the zips that cannot be read."""

    files: tuple[SourceFile, ...]
    refused: tuple[RejectedPicture, ...] = ()


def list_files(source: Path) -> SourceFiles:
    """Every file under a folder, and the members of the zips among them; or the members of one zip."""
    if not source.is_dir():
        paths, folder = [source], source.parent
    else:
        paths, folder = list(_files(source)), source
    found: list[SourceFile] = []
    refused: list[RejectedPicture] = []
    for path in paths:
        name = path.relative_to(folder).as_posix()
        if path.suffix.lower() != ZIP:
            found.append(SourceFile(name, partial(_bytes, path, folder)))
            continue
        try:
            found += _members(path, folder, "" if path == source else f"{name}/")
        except Rejected as error:
            refused.append(rejection_row(name, rejection_error(PictureRejection.BAD_ARCHIVE, _sentence(error))))
    return SourceFiles(tuple(sorted(found, key=lambda file: file.path)), tuple(refused))


def _members(path: Path, folder: Path, prefix: str) -> Iterator[SourceFile]:
    """Members of a zip that are not hidden. Raises Rejected where it cannot be read, or is a danger."""
    root = folder.resolve()
    archive = Archive(path.relative_to(folder).as_posix(), DiskFolder(root))
    for member in archive.members():
        if not any(part.startswith((".", "__MACOSX")) for part in Path(member.path).parts):
            yield SourceFile(prefix + member.path, partial(_member_bytes, archive, member.path, member.size))


def _member_bytes(archive: Archive, path: str, size: int) -> bytes:
    if size > MAX_FILE_BYTES:
        raise rejection_error(PictureRejection.TOO_LARGE, f"has over {MAX_FILE_BYTES // 2**20} MiB")
    try:
        return archive.read(path, MAX_FILE_BYTES)
    except Rejected as error:
        raise rejection_error(PictureRejection.UNREADABLE, _sentence(error)) from None


def _sentence(error: Rejected) -> str:
    return error.message.partition(";")[0]


def _files(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if not hidden and (path.is_symlink() or not path.is_dir()):
            yield path


def _bytes(path: Path, folder: Path) -> bytes:
    try:
        if not path.resolve(strict=True).is_relative_to(folder.resolve()):
            raise rejection_error(PictureRejection.UNREADABLE, "is a link that leaves the folder")
        if not path.is_file():
            raise rejection_error(PictureRejection.UNREADABLE, "is no regular file")
        if path.stat().st_size > MAX_FILE_BYTES:
            raise rejection_error(PictureRejection.TOO_LARGE, f"has over {MAX_FILE_BYTES // 2**20} MiB")
        return path.read_bytes()
    except (OSError, RuntimeError) as error:  # RuntimeError: links in a circle
        raise rejection_error(PictureRejection.UNREADABLE, f"cannot be read: {error}") from None
