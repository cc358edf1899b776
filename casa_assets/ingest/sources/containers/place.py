"""Where the files of one input lie: in a folder, in an archive, or in a table."""

from __future__ import annotations

import posixpath
from functools import cached_property

from casa_assets.ingest.sources.containers.archive import Archive
from casa_assets.ingest.sources.containers.table import TablePlace, is_table
from casa_assets.ingest.sources.found import Found
from casa_assets.ingest.sources.places import Folder, Place, folder_of


def place_of(found: Found, looked_at: set[str] | None = None) -> Place:
    """Where an input and its companions lie.

    Args:
        looked_at: takes up the paths of all files and folders that are looked at from now on, missing ones too.
    """
    folder = folder_of(found.root, looked_at)
    if not found.archive:
        return folder
    if looked_at is not None:
        looked_at.add(str(found.root / found.archive))
    if is_table(found.archive):
        return TablePlace(folder, found.archive, found.main, found.at)
    return _ArchivePlace(found, folder)


class _ArchivePlace:
    def __init__(self, found: Found, folder: Folder) -> None:
        self._archive = Archive(found.archive, folder)
        self._main, self._at = found.main, found.at

    def read(self, path: str, max_bytes: float) -> bytes:
        return self._archive.read(path, max_bytes, self._at if path == self._main else -1)

    def has(self, path: str) -> bool:
        folder, name = posixpath.split(path)
        return name in self._names.get(folder, ())

    def is_inside(self, folder: str) -> bool:
        return True  # members are names in a list: there are no links among them

    def listing(self, folder: str) -> list[str]:
        return sorted(self._names.get(folder, ()))

    @cached_property
    def _names(self) -> dict[str, set[str]]:
        """Names in each folder; listed only for meshes that refer to other files, as most do not."""
        names: dict[str, set[str]] = {}
        for member in self._archive.members():
            folder, name = posixpath.split(member.path)
            names.setdefault(folder, set()).add(name)
        return names
