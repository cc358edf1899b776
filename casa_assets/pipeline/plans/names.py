"""Names in plans: how ids are spelt, and the known name nearest to one that is not known."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

NEAR = 0.6  # least similarity of a misspelt name, as difflib counts it


def spelt(word: str) -> str:
    """A word as ids are spelt: small letters, numbers and underscores."""
    parts = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", word.strip())
    return re.sub(r"_+", "_", re.sub(r"[^a-z0-9]+", "_", parts.lower())).strip("_")


def nearest(word: str, known: Iterable[str], least: float = NEAR) -> str | None:
    """The known name that is spelt like a word or most similar to it; None if none is similar enough."""
    names, same = list(known), spelt(word)
    if same in names:
        return same
    return next(iter(difflib.get_close_matches(same, names, n=1, cutoff=least)), None)
