"""Where the files of one input lie: a folder on the disk, or an archive in it. Both are read by the same calls."""

from __future__ import annotations

import os
import posixpath
from typing import Protocol

from casa_assets.ingest.sources.archive import Archive
from casa_assets.ingest.sources.bounded_reads import is_inside, read_file
from casa_assets.ingest.sources.found import Found


class Place(Protocol):
    """Files by their POSIX path from a root that none may leave."""

    def read(self, path: str, max_bytes: float) -> bytes:
        """Bytes of a file. Raises Rejected as bounded_reads.read_file."""
        ...

    def has(self, path: str) -> bool:
        """True where something stands there."""
        ...

    def is_inside(self, folder: str) -> bool:
        """True where a folder, links followed, does not leave the root."""
        ...

    def listing(self, folder: str) -> list[str]:
        """Names in a folder, sorted; none where it cannot be read."""
        ...


def place_of(found: Found, looked_at: set[str] | None = None) -> Place:
    """Where an input and its companions lie.

    Args:
        looked_at: takes up the paths of all files and folders that are looked at from now on, missing ones too.
    Raises:
        Rejected: as Archive.members.
    """
    seen = set() if looked_at is None else looked_at
    if found.archive:
        seen.add(str(found.root / found.archive))
        return _ArchivePlace(found)
    return _DiskPlace(found, seen)


class _DiskPlace:
    def __init__(self, found: Found, looked_at: set[str]) -> None:
        self._root, self._looked_at = found.root, looked_at

    def read(self, path: str, max_bytes: float) -> bytes:
        self._looked_at.add(str(self._root / path))
        return read_file(str(self._root / path), self._root, max_bytes)

    def has(self, path: str) -> bool:
        self._looked_at.add(str(self._root / path))
        return os.path.lexists(self._root / path)

    def is_inside(self, folder: str) -> bool:
        return is_inside(str(self._root / folder), self._root)

    def listing(self, folder: str) -> list[str]:
        self._looked_at.add(str(self._root / folder))
        try:
            return sorted(p.name for p in (self._root / folder).iterdir())
        except OSError:
            return []


class _ArchivePlace:
    def __init__(self, found: Found) -> None:
        self._archive = Archive(str(found.root / found.archive), found.root)
        self._names: dict[str, set[str]] = {}
        for member in self._archive.members():
            folder, name = posixpath.split(member.path)
            self._names.setdefault(folder, set()).add(name)

    def read(self, path: str, max_bytes: float) -> bytes:
        return self._archive.read(path, max_bytes)

    def has(self, path: str) -> bool:
        folder, name = posixpath.split(path)
        return name in self._names.get(folder, ())

    def is_inside(self, folder: str) -> bool:
        return True  # members are names in a list: there are no links among them

    def listing(self, folder: str) -> list[str]:
        return sorted(self._names.get(folder, ()))
