"""Fragments of a one-piece shell that segmentation has already found to be fronts, with their probabilities."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class KnownFronts:
    """Fragments that are fronts.

    Attributes:
        chances: the probability that each is a front, if a forest decided it. boxes: the fragment behind each that is
            the box of a drawer.
    """

    chances: Mapping[int, float]
    boxes: Mapping[int, int]

    def chance_of(self, fragments: Iterable[int]) -> float | None:
        """Return the highest probability of some fragments, None if none of them is known."""
        return max((self.chances[f] for f in fragments if f in self.chances), default=None)


NO_FRONTS = KnownFronts({}, {})
