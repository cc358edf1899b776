"""Nodes of VRML 2.0 and X3D, as both spellings are read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.typing import Floats, Ints

# Scenes are a dozen deep. Text is read by functions that call each other, four for a level, and Python ends at 1000.
DEEPEST = 150


@dataclass(eq=False)
class Node:
    """A node of the scene.

    Attributes:
        kind: such as `IndexedFaceSet`.
        name: that others use it by (DEF), or empty.
        fields: name -> text of its value, numbers and strings as written.
        nodes: name of the field -> nodes in it; of X3D, whose fields may go unnamed, all under `children`.
    """

    kind: str
    name: str = ""
    fields: dict[str, str] = field(default_factory=dict)
    nodes: dict[str, list[Node]] = field(default_factory=dict)

    def all(self) -> Iterator[Node]:
        """Nodes in any field, in order."""
        for found in self.nodes.values():
            yield from found

    def first(self, *kinds: str) -> Node | None:
        """First node of one of these kinds in any field, or None."""
        return next((node for node in self.all() if node.kind in kinds), None)

    def flag(self, name: str, default: bool) -> bool:
        """Truth value; the default where it is not written."""
        return self.fields.get(name, str(default)).strip().lower() == "true"

    def floats(self, name: str) -> Floats:
        """(N,) numbers; what is not a number becomes NaN."""
        words = self.fields.get(name, "").replace(",", " ").split()
        try:
            return np.array(words, dtype=np.float64)
        except ValueError:
            return np.array([_number(word) for word in words])

    def integers(self, name: str) -> Ints:
        """(N,) whole numbers; what is none becomes -2, which names no point."""
        values = self.floats(name)
        is_whole = np.isfinite(values) & (np.abs(values) < 2**31)
        return np.where(is_whole, np.where(is_whole, values, 0.0), -2.0).astype(np.int64)

    def vector(self, name: str, default: tuple[float, ...]) -> Floats:
        """Numbers, as many as the default has, or the default."""
        values = self.floats(name)
        return values if len(values) == len(default) and np.isfinite(values).all() else np.array(default)

    def number(self, name: str, default: float) -> float:
        """One number, or the default."""
        return float(self.vector(name, (default,))[0])

    def texts(self, name: str) -> list[str]:
        """Strings of a list of strings, quoted or bare."""
        text = self.fields.get(name, "").strip()
        if '"' not in text:
            return [text] if text else []
        return [word for word in text.split('"')[1::2] if word]


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return float("nan")
