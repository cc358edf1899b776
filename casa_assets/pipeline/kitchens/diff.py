"""Compare two scenes on disk file by file and fact by fact."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from casa_assets.errors import OutputError

FILES = ("scene.xml", "scene_light.xml", "scene.usda")
# What scene.json says of who made it and not of what was made.
MADE_BY_FIELDS = frozenset({"key", "picture_key", "generator"})


def compare(first: Path, second: Path) -> list[str]:
    """One line for each difference; none where the files are the same byte for byte, but for the keys in scene.json.

    A key says which sources and tools made a scene, and nothing of what is in it: two machines with other versions
    of numpy make the same kitchen under two keys.

    Raises:
        OutputError: one of the folders holds no scene.
    """
    lines = []
    for name in FILES:
        a, b = _bytes(first / name), _bytes(second / name)
        if a != b:
            lines.append(f"{name}: {hashlib.sha256(a).hexdigest()[:12]} and {hashlib.sha256(b).hexdigest()[:12]}")
    return [*lines, *_values("", _facts(first), _facts(second))]


def made_by_same_code(first: Path, second: Path) -> bool:
    """True if the same sources, tools and version of this package made both. Raises OutputError as `compare`."""
    first_facts, second_facts = (_read(folder) for folder in (first, second))
    return all(first_facts.get(name) == second_facts.get(name) for name in MADE_BY_FIELDS)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise OutputError(str(path), f"cannot be read: {error.strerror}; name the folder of a built scene") from None


def _facts(folder: Path) -> dict[str, Any]:
    return {name: value for name, value in _read(folder).items() if name not in MADE_BY_FIELDS}


def _read(folder: Path) -> dict[str, Any]:
    try:
        facts = json.loads(_bytes(folder / "scene.json"))
    except ValueError as error:
        raise OutputError(str(folder / "scene.json"), f"is damaged: {error}") from None
    if not isinstance(facts, dict):
        raise OutputError(str(folder / "scene.json"), "is damaged: it is not a JSON object")
    return facts


def _values(pointer: str, a: Any, b: Any) -> Iterator[str]:
    """Differences of two JSON values; rows with names are matched by them."""
    if isinstance(a, list) and isinstance(b, list) and all(isinstance(r, dict) and "name" in r for r in [*a, *b]):
        a, b = {r["name"]: r for r in a}, {r["name"]: r for r in b}
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted(a.keys() | b.keys()):
            inner = f"{pointer}.{key}" if pointer else str(key)
            if key not in b:
                yield f"{inner}: only in the first"
            elif key not in a:
                yield f"{inner}: only in the second"
            else:
                yield from _values(inner, a[key], b[key])
    elif a != b:
        yield f"{pointer}: {_short(a)} and {_short(b)}"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."
