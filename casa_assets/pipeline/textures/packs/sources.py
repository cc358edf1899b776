"""The files that a pack is made of: those under a folder; every read is bounded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from casa_assets.textures.packs.limits import MAX_FILE_BYTES
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error


@dataclass(frozen=True)
class SourceFile:
    """A file of a source.

    Attributes:
        path: POSIX, relative to the folder. read: its bytes. Raises Rejected.
    """

    path: str
    read: Callable[[], bytes]

    @property
    def suffix(self) -> str:
        """In lower case, with its dot."""
        return Path(self.path).suffix.lower()


def list_files(folder: Path) -> tuple[SourceFile, ...]:
    """Every file under a folder that is not hidden, sorted by path."""
    found = [SourceFile(path.relative_to(folder).as_posix(), partial(_bytes, path, folder)) for path in _files(folder)]
    return tuple(sorted(found, key=lambda file: file.path))


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
