"""Look up which fields nested records may have at a path, for error messages."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from typing import Any, get_args

from pydantic import BaseModel


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
