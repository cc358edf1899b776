"""A parsed YAML file that remembers where each value was written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets.errors import RegistryError

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """A parsed YAML file that remembers the line of every value by its path, such as `("mug", "longest_m")`."""

    file: str
    value: Any
    lines: Mapping[KeyPath, int]

    def fault(self, path: KeyPath, expected: str, got: str) -> RegistryError:
        """The error to raise about the value at `path`, or about its nearest ancestor in the file."""
        at = path = self._written(path)
        while at and at not in self.lines:
            at = at[:-1]
        return RegistryError(self.file, self.lines.get(at, 1), ".".join(map(str, path)), expected, got)

    def _written(self, path: KeyPath) -> KeyPath:
        """The path as the file has it: lists of records may be written as mappings of ids to rows."""
        out, here = [], self.value
        for step in path:
            key = list(here)[step] if isinstance(here, dict) and isinstance(step, int) and step < len(here) else step
            here = here[key] if isinstance(here, dict) and key in here else None
            out.append(key)
        return tuple(out)
