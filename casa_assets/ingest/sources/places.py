"""Where files lie: a folder on the disk or on a store, or an archive in one. All are read by the same calls."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Protocol

from casa_assets.ingest.sources.bounded_reads import check_file, is_inside, read_file
from casa_assets.ingest.sources.stores.address import StoreRoot


class Place(Protocol):
    """Files by their POSIX path from a root that none may leave."""

    def read(self, path: str, max_bytes: float) -> bytes:
        """Bytes of a file. Raises Rejected as bounded_reads.read_file."""
        ...

    def has(self, path: str) -> bool:
        """True if a file or folder exists there."""
        ...

    def is_inside(self, folder: str) -> bool:
        """True where a folder, links followed, does not leave the root."""
        ...

    def listing(self, folder: str) -> list[str]:
        """Names in a folder, sorted; empty if it cannot be read."""
        ...


@dataclass(frozen=True)
class Entry:
    """An entry of a folder; a link is neither a folder nor a file."""

    name: str
    is_folder: bool
    is_file: bool


class Folder(Place, Protocol):
    """A place that inputs are looked for in."""

    def scan(self, folder: str) -> list[Entry]:
        """Entries of a folder, sorted by the bytes of their names. Raises OSError, Rejected."""
        ...

    def check(self, path: str) -> None:
        """Check that a file may be read, without opening it. Raises Rejected as bounded_reads.check_file."""
        ...

    def open(self, path: str, block: int) -> IO[bytes]:
        """A file that was checked, to seek in.

        Args:
            block: bytes that are fetched at once from a store.
        Raises:
            OSError, Rejected: also from its methods.
        """
        ...

    def identity(self, path: str) -> str:
        """Text that is the same for all paths to one file."""
        ...


@dataclass(frozen=True)
class DiskFolder:
    """A folder on the disk.

    Attributes:
        root: absolute.
        looked_at: takes up the paths of all files and folders that are looked at, missing ones too.
    """

    root: Path
    looked_at: set[str] | None = None

    def read(self, path: str, max_bytes: float) -> bytes:
        """See Place."""
        return read_file(self._look(path), self.root, max_bytes)

    def has(self, path: str) -> bool:
        """See Place."""
        return os.path.lexists(self._look(path))

    def is_inside(self, folder: str) -> bool:
        """See Place."""
        return is_inside(self._at(folder), self.root)

    def listing(self, folder: str) -> list[str]:
        """See Place."""
        try:
            return sorted(os.listdir(self._look(folder)))  # noqa: PTH208
        except OSError:
            return []

    def scan(self, folder: str) -> list[Entry]:
        """See Folder."""
        entries = sorted(os.scandir(self._at(folder)), key=lambda e: os.fsencode(e.name))
        return [Entry(e.name, e.is_dir(follow_symlinks=False), e.is_file(follow_symlinks=False)) for e in entries]

    def check(self, path: str) -> None:
        """See Folder."""
        check_file(self._at(path), self.root)

    def open(self, path: str, block: int) -> IO[bytes]:
        """See Folder."""
        del block  # the disk needs no more than its own
        return open(self._at(path), "rb")  # noqa: PTH123

    def identity(self, path: str) -> str:
        """See Folder."""
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


def folder_of(root: Path | StoreRoot, looked_at: set[str] | None = None) -> Folder:
    """The folder that a root names; see DiskFolder for `looked_at`."""
    if isinstance(root, Path):
        return DiskFolder(root, looked_at)
    from casa_assets.ingest.sources.stores.folder import StoreFolder

    return StoreFolder(root, looked_at)
