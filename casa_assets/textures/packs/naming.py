"""Turn file names of pictures into legal, unique ids."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

_LONGEST = 64


def slug(text: str) -> str:
    """Lower case letters, digits and single underscores, starting with a letter; `picture` where nothing is left."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode("ascii").lower()
    words = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")[:_LONGEST].strip("_")
    if not words:
        return "picture"
    return words if words[0].isalpha() else f"p{words}"


def unique_ids(pack: str, names: Sequence[str]) -> tuple[str, ...]:
    """`<pack>_<name>` for each name, in order; what is there already gets the next free number."""
    taken: dict[str, None] = {}
    for name in names:
        wanted = f"{pack}_{slug(name)}"
        found, number = wanted, 2
        while found in taken:
            found, number = f"{wanted}_{number}", number + 1
        taken[found] = None
    return tuple(taken)
