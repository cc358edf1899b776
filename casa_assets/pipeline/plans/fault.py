"""A fault of a plan, and the mend that is offered for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from casa_assets.model.registry.document import KeyPath
from casa_assets.registry.edit import Edit, EditKind


@dataclass(frozen=True)
class Mend:
    """What would mend a fault.

    Attributes:
        sentence: for people, in the imperative.
        edits: of the plan's values, one after the other.
    """

    sentence: str
    edits: tuple[Edit, ...] = ()


@dataclass(frozen=True)
class Fault:
    """Something that is wrong with a plan.

    Attributes:
        pointer: of what is wrong, as the file has it.
        expected, got: as in a RegistryError. mend: None where nothing sensible is near.
        line: where the pointer does not say it, counted from 1; else 0.
    """

    pointer: KeyPath
    expected: str
    got: str
    mend: Mend | None
    line: int = 0


def replaced(pointer: KeyPath, value: Any) -> Edit:
    """The edit that puts a value in the place of what stands at a pointer."""
    return Edit(EditKind.REPLACE, pointer, value)


def renamed(pointer: KeyPath, name: str) -> Edit:
    """The edit that calls the last key of a pointer something else."""
    return Edit(EditKind.RENAME, pointer, name)


def removed(pointer: KeyPath) -> Edit:
    """The edit that takes a key or an item out."""
    return Edit(EditKind.REMOVE, pointer)


def added(pointer: KeyPath, value: Any) -> Edit:
    """The edit that adds a key."""
    return Edit(EditKind.ADD, pointer, value)


def value_at(value: Any, pointer: Sequence[str | int]) -> Any:
    """What stands at a pointer; None where nothing does."""
    for step in pointer:
        if isinstance(value, dict):
            value = value.get(step)
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return None
    return value
