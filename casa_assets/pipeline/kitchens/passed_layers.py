"""Layers of assets that passed SimReady's rules, remembered in the cache by their content."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

FOLDER = "simready"


class PassedLayers:
    """Digests of layers that passed, an empty file for each in a folder of the cache."""

    def __init__(self, cache: Path) -> None:
        self.folder = cache / FOLDER

    def has(self, digest: str) -> bool:
        """True if a layer of that digest passed."""
        return (self.folder / digest[:2] / digest).is_file()

    def add(self, digests: Collection[str]) -> None:
        """Remember layers that passed."""
        for digest in digests:
            path = self.folder / digest[:2] / digest
            with suppress(OSError):  # a cache that cannot be written to: the layer is looked at again
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
