"""Store results by content key on disk; deleting the folder costs time and nothing else."""

from __future__ import annotations

import os
import time
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

from casa_assets.cache.cache_key import digest_of, last_change_ns, state_of_everything
from casa_assets.core.system import cache_dir, keep_json, kept_json, process_name
from casa_assets.projects import STARTED_NS

# Store ----------------------------------------------------------------------------------------------------------------

# Part of its bound that a store is brought down to, so that not every new file makes it look for old ones.
TRIMMED_SHARE = 0.75
# A half-written file of that age was left by a process that was killed.
ABANDONED_S = 24 * 3600.0


class Store:
    """A folder of results; any number of processes may read and write it at once.

    Args:
        root: made if it is missing.
        is_optional: what cannot be written is not kept, without an error, and what cannot be read counts as missing.
    """

    def __init__(self, root: Path, is_optional: bool = False) -> None:
        self.root = root
        self._ignored: tuple[type[OSError], ...] = (OSError,) if is_optional else ()
        self._absent: tuple[type[Exception], ...] = (FileNotFoundError, zlib.error, *self._ignored)

    def get(self, key: str) -> bytes | None:
        """Return the bytes stored under a key (64 hex digits), or None if they are missing or damaged."""
        path = self._path(key)
        try:
            data = zlib.decompress(path.read_bytes())
        except self._absent:
            return None
        with suppress(OSError):  # the folder may only be read, or another process has just removed the file
            os.utime(path)  # when it was last used, for `trim`: file systems are often mounted without access times
        return data

    def put(self, key: str, data: bytes) -> None:
        """Keep bytes under a key; a reader sees all of them or none."""
        path = self._path(key)
        fresh = path.with_name(f".{path.name}.{process_name()}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            fresh.write_bytes(zlib.compress(data, level=1))
            fresh.replace(path)
        except self._ignored:
            with suppress(OSError):  # half of it may be there
                fresh.unlink()

    def trim(self, max_bytes: int) -> None:
        """Remove the files that were used longest ago, if all of them together take more than `max_bytes`.

        Safe while others read and write: a process that misses a file makes it again. Half-written files that a killed
        process left a day ago or earlier are removed too.
        """
        files: list[tuple[int, int, Path]] = []
        for path in self.root.glob("*/*"):
            with suppress(FileNotFoundError):
                found = path.stat()
                if not path.name.startswith("."):
                    files.append((found.st_mtime_ns, found.st_size, path))
                elif time.time() - found.st_mtime > ABANDONED_S:
                    path.unlink()
        total = sum(size for _, size, _ in files)
        if total <= max_bytes:
            return
        for _, size, path in sorted(files):
            if total <= TRIMMED_SHARE * max_bytes:
                return
            with suppress(FileNotFoundError, *self._ignored):
                path.unlink()
            total -= size

    def sweep(self) -> None:
        """Remove what killed writers left half-written. Only while no other process writes."""
        for path in self.root.glob("*/.*"):
            path.unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.root / key[:2] / key


# Remembered -----------------------------------------------------------------------------------------------------------
# Remember small values that follow from the program, its registry and the project alone, until any of these changes.
#
# They are found again without loading what they were made by. Deleting the folder costs time and nothing else.

KEPT_IN = "remembered"  # folder of the cache


def recall(*of: str) -> Any:
    """Return the remembered value, or None if there is no value or it may be outdated because something has changed."""
    return kept_json(_place(of))


def remember(value: Any, *of: str) -> None:
    """Remember a value that JSON can hold. Where the cache cannot be written to, nothing is remembered.

    Nor is it if a file has changed since this process started: the value may come from what was read before.
    """
    if last_change_ns() <= STARTED_NS:
        keep_json(_place(of), value)


def _place(of: tuple[str, ...]) -> Path:
    return cache_dir() / KEPT_IN / digest_of(state_of_everything(), of)
