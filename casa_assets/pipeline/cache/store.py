"""Store results by content key on disk; deleting the folder costs time and nothing else."""

from __future__ import annotations

import os
import zlib
from pathlib import Path


class Store:
    """A folder of results; any number of processes may read and write it at once.

    Args:
        root: made where it is missing.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    def get(self, key: str) -> bytes | None:
        """The bytes put under a key (64 hex digits), or None where there are none or they are damaged."""
        try:
            return zlib.decompress(self._path(key).read_bytes())
        except (FileNotFoundError, zlib.error):
            return None

    def put(self, key: str, data: bytes) -> None:
        """Keep bytes under a key; a reader sees all of them or none."""
        path = self._path(key)
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh = path.with_name(f".{path.name}.{os.getpid()}")
        fresh.write_bytes(zlib.compress(data, level=1))
        fresh.replace(path)

    def sweep(self) -> None:
        """Remove what killed writers left half-written. Only while no other process writes."""
        for left in self.root.glob("*/.*"):
            left.unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.root / key[:2] / key
