"""Turn any text into an Id, which is legal in MJCF, in USD and as a file name."""

from __future__ import annotations

import re
import unicodedata

MAX_CHARACTERS = 60


def identifier(text: str, fallback: str) -> str:
    """`text` as an Id; starts with `fallback` where nothing usable is left or it would start with a digit."""
    ascii_text = unicodedata.normalize("NFKD", text[:400]).encode("ascii", "ignore").decode("ascii")
    parted = re.sub(r"([a-z0-9])([A-Z][a-z])", r"\1_\2", ascii_text)
    words = re.sub(r"[^a-z0-9]+", "_", parted.lower()).strip("_")
    if not words:
        return fallback
    if words[0].isdigit():
        words = f"{fallback}_{words}"
    return words[:MAX_CHARACTERS].rstrip("_")


class UniqueNames:
    """Hands out Ids, each once."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._next: dict[str, int] = {}

    def unique(self, text: str, fallback: str) -> str:
        """`text` as an Id that was not handed out before: `lid`, `lid_2`, `lid_3`."""
        stem = identifier(text, fallback)
        name = stem
        while name in self._taken:
            number = self._next.get(stem, 2)
            self._next[stem] = number + 1
            name = f"{stem}_{number}"
        self._taken.add(name)
        return name
