"""Derive the id of an asset from its producer and its input.

Two producers may be given one file: `ingest` makes a rigid asset of it, `articulate` one that opens. Both are in one
library, so the producer is part of the id and of the entry. An id is the category and a word for the input, which is
enough to find all that a producer ever made from an input, under any category:

    mug_e1b7e22aee                      ingest: the first 10 hex digits of the sha256 of the input
    microwave_articulated_a39fd0c2b1    articulate: the same after an additional word
    microwave_0c6e21fa83                a family: the first 10 hex digits of the digest of its numbers

The digits are those of the input, and not of a digest over producer and input, so that anyone can find a file's assets
by its sha256, and the split of ingested assets follows from an id (see `model.asset.provenance.split_of`).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

DIGITS = 10


class Producer(StrEnum):
    """Producers of a library's entries."""

    INGEST = "ingest"
    ARTICULATE = "articulate"
    FAMILY = "family"


# What stands before the digits in an id.
_WORDS = {Producer.ARTICULATE: "articulated_"}


@dataclass(frozen=True)
class Identity:
    """A producer and the sha256 of what it was given: at most one entry of a library has them.

    Attributes:
        sha256: of the input; of a family's member, the digest of its numbers.
    """

    producer: Producer
    sha256: str

    @property
    def suffix(self) -> str:
        """End of the id after the category: a word for the producer, and digits of the input."""
        return f"{_WORDS.get(self.producer, '')}{self.sha256[:DIGITS]}"

    def asset_id(self, category: str) -> str:
        """The id under a category."""
        return f"{category}_{self.suffix}"

    def may_own(self, asset_id: str) -> bool:
        """True if an id can be that of this producer and input, under any category."""
        category, found, end = asset_id.rpartition(f"_{self.suffix}")
        return bool(found) and not end and not any(category.endswith(f"_{w}".rstrip("_")) for w in _WORDS.values())


def suffix_of(asset_id: str) -> str:
    """Return the end of an id, which identifies producer and input, as `Identity.suffix` gives it."""
    before, _, digits = asset_id.rpartition("_")
    for word in _WORDS.values():
        if f"{before}_".endswith(f"_{word}"):
            return f"{word}{digits}"
    return digits
