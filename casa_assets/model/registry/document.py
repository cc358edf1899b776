"""A parsed YAML file that remembers where each value was written, and the fields that records have."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import getitem
from types import MappingProxyType
from typing import Any, get_args

from pydantic import BaseModel

from casa_assets.errors import RegistryError

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """A parsed YAML file that keeps the line of every value by its path, such as `("mug", "longest_m")`.

    Attributes:
        file: its name in messages. lines: line by path, counted from 1.
        files: for values that come from a file merged over this one, the name of that file, by path.
    """

    file: str
    value: Any
    lines: Mapping[KeyPath, int]
    files: Mapping[KeyPath, str] = field(default_factory=lambda: MappingProxyType({}))

    def overlaid(self, upper: Document) -> Document:
        """This document with another one merged over it.

        Mappings are merged key by key, at every depth; a list on the top level is appended to the list below it;
        anything else in `upper` replaces the value below. A file without a value changes nothing.
        """
        if upper.value in ({}, [], None):
            return self
        if isinstance(self.value, list) and isinstance(upper.value, list):
            count = len(self.value)
            shifted = {(int(path[0]) + count, *path[1:]): line for path, line in upper.lines.items() if path}
            joined = [*self.value, *upper.value]
            named = MappingProxyType({**self.files, **dict.fromkeys(shifted, upper.file)})
            return replace(self, value=joined, lines=MappingProxyType({**self.lines, **shifted}), files=named)
        lines, files = dict(self.lines), dict(self.files)
        value = _joined(self.value, upper.value, (), lines)
        for path, line in upper.lines.items():
            if path not in lines or not isinstance(reduce(getitem, path, upper.value), dict):
                lines[path], files[path] = line, upper.file
        return replace(self, value=value, lines=MappingProxyType(lines), files=MappingProxyType(files))

    def file_of(self, path: KeyPath) -> str:
        """Name of the file that states the value at a path, or a part of it."""
        below = (file for at, file in self.files.items() if at[: len(path)] == path)
        return self.files.get(path) or next(below, self.file)

    def fault(self, path: KeyPath, expected: str, got: str) -> RegistryError:
        """The error to raise about the value at `path`, or about its nearest ancestor in the file."""
        at = path = self._written(path)
        while at and at not in self.lines:
            at = at[:-1]
        file = self.files.get(at, self.file)
        return RegistryError(file, self.lines.get(at, 1), ".".join(map(str, path)), expected, got)

    def _written(self, path: KeyPath) -> KeyPath:
        """The path as written in the file, where lists of records may be mappings of ids to rows."""
        out, here = [], self.value
        for step in path:
            key = list(here)[step] if isinstance(here, dict) and isinstance(step, int) and step < len(here) else step
            here = here[key] if isinstance(here, dict) and key in here else None
            out.append(key)
        return tuple(out)


def _joined(lower: Any, upper: Any, at: KeyPath, lines: dict[KeyPath, int]) -> Any:
    """Merge two values; the lines of replaced values are removed from `lines`."""
    if not isinstance(lower, dict) or not isinstance(upper, dict):
        for path in [path for path in lines if len(path) > len(at) and path[: len(at)] == at]:
            del lines[path]
        return upper
    joined = dict(lower)
    for key, value in upper.items():
        joined[key] = _joined(lower[key], value, (*at, key), lines) if key in lower else value
    return joined


def fields_at(kind: type[BaseModel], path: Sequence[str | int]) -> tuple[str, ...]:
    """Field names of the record at a path, such as `("runs", 0, "base")`; empty if there is no record at the path."""
    found: list[type[BaseModel]] = [kind]
    for step in path:
        below: list[type[BaseModel]] = []
        for record in found:
            if isinstance(step, str) and step in record.model_fields:
                below += _records(record.model_fields[step].annotation)
        # An index, or the key of a mapping, leads into what the field already holds.
        found = below or found
    return tuple(dict.fromkeys(name for record in found for name in record.model_fields))


def expected_one_of(names: Sequence[str], got: str) -> str:
    """Text such as `one of a, b, c`, starting with the name nearest to the one that was written."""
    near = difflib.get_close_matches(got, names, n=1, cutoff=0.5)
    hint = f"{near[0]!r}, or another " if near else ""
    return f"{hint}one of {', '.join(names)}"


def _records(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _records(inner)
