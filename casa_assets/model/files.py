"""Files to be written: relative POSIX paths to bytes. Writers return them, only runs put them on disk."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Self

from pydantic import Field, field_validator

from casa_assets.model.record import Record


class Files(Record):
    """An immutable set of files.

    Attributes:
        entries: path -> content; paths are relative, POSIX, ASCII, without `..`, and differ by more than case.
    """

    entries: dict[str, bytes] = Field(default_factory=dict)

    @field_validator("entries")
    @classmethod
    def _safe(cls, entries: dict[str, bytes]) -> dict[str, bytes]:
        seen: dict[str, str] = {}
        for path in entries:
            pure = PurePosixPath(path)
            if not path or pure.is_absolute() or ".." in pure.parts or str(pure) != path or "\\" in path or path == ".":
                raise ValueError(f"{path!r} is not a plain relative path")
            if not path.isascii() or not path.isprintable() or any(c in path for c in '<>:"|?* '):
                raise ValueError(f"{path!r} would not be legal on every file system")
            twin = seen.setdefault(path.lower(), path)
            if twin != path:
                raise ValueError(f"{path!r} and {twin!r} differ only in case")
        return dict(sorted(entries.items()))

    @classmethod
    def of(cls, entries: Mapping[str, bytes]) -> Self:
        """Files from a mapping."""
        return cls(entries=dict(entries))

    def __or__(self, other: Files) -> Files:
        """Union. Raises ValueError if both have a path with different bytes."""
        clash = [p for p in self.entries.keys() & other.entries.keys() if self.entries[p] != other.entries[p]]
        if clash:
            raise ValueError(f"two contents for {sorted(clash)[0]!r}")
        return Files(entries={**self.entries, **other.entries})

    def under(self, folder: str) -> Files:
        """Copy with `folder/` in front of each path."""
        return Files(entries={f"{folder}/{path}": data for path, data in self.entries.items()})

    def sums(self) -> dict[str, str]:
        """Path to sha256 of the content, sorted by path."""
        return {path: hashlib.sha256(data).hexdigest() for path, data in self.entries.items()}
