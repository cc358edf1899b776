"""Units of rows in the many forms that people write them in."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from casa_assets.pipeline.plans.words import length_of, meant, plan_words, spelt

NAMES_OF_KIND = ("kind", "type", "unit", "item", "appliance", "cabinet", "module", "element")
MIN_NEAR = 0.7  # how near a kind has to be to a word that stands for none


def unit_as_written(unit: Any, kinds: Sequence[str], fields: Sequence[str], row: str) -> Any:
    """A unit in the form and the words of the plan language, the same where it is; None where it is no unit.

    Args:
        kinds: of the row. fields: of a unit. row: `base` or `upper`.
    """
    if isinstance(unit, str):
        return _of_text(unit, kinds, row)
    if not isinstance(unit, dict) or not unit:
        return None
    if len(unit) == 1:
        said, value = next(iter(unit.items()))
        if spelt(said) in NAMES_OF_KIND and isinstance(value, str):
            return _of_text(value, kinds, row)
        kind = _kind(said, kinds, row)
        return unit if kind == said else None if kind is None else {kind: value}
    return _of_mapping(unit, kinds, fields, row)


def _of_text(text: str, kinds: Sequence[str], row: str) -> Any:
    """`sink`, `Double Sink`, `sink 80cm`, `sink: 0.8`, `drawers (0.6 m)`."""
    if text in kinds:
        return text
    found = re.match(r"^\s*([A-Za-z][A-Za-z _-]*?)\s*[:=,(@-]*\s*(\d.*?)?\)?\s*$", text)
    if not found:
        return None
    kind, width = _kind(found[1], kinds, row), length_of(found[2]) if found[2] else None
    return None if kind is None else kind if width is None else {kind: width}


def _of_mapping(unit: Mapping[str, Any], kinds: Sequence[str], fields: Sequence[str], row: str) -> Any:
    """`{type: sink, width: 0.8}`, or a kind with nothing behind it and its fields beside it."""
    key = next((k for k in unit if spelt(k) in NAMES_OF_KIND and isinstance(unit[k], str)), None)
    if key is not None:
        kind = _kind(str(unit[key]), kinds, row)
        rest = {k: v for k, v in unit.items() if k != key}
    else:
        key = next((k for k in unit if k not in fields and _kind(k, kinds, row)), None) or next(
            (k for k in unit if _kind(k, kinds, row)), None
        )
        if key is None:
            return None
        kind, inner = _kind(key, kinds, row), unit[key]
        rest = {k: v for k, v in unit.items() if k != key}
        if isinstance(inner, dict):
            rest = {**inner, **rest}
        elif isinstance(inner, int | float | list) and not isinstance(inner, bool):
            rest = {"width": inner, **rest}
    if kind is None:
        return None
    return {kind: rest} if rest else kind


def _kind(word: str, kinds: Sequence[str], row: str) -> str | None:
    """The kind that a word means: the word itself, one it stands for, or its last part, as in `double sink`."""
    if word in kinds:
        return word
    said = spelt(word)
    if said in plan_words()["no_units"]:
        return None
    whole = meant(said, kinds, row, MIN_NEAR)
    if whole is not None:
        return whole
    parts = said.split("_")
    for part in (*reversed(parts), "_".join(parts[-2:])):
        if len(part) > 2 and (found := meant(part, kinds, row, 0.85)):
            return found
    return None
