"""Divide the length of a row among its units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

WIDTH_STEP_M = 0.001  # widths are whole millimetres


@dataclass(frozen=True)
class WidthRange:
    """Least and greatest width of a unit, metres."""

    minimum: float
    maximum: float

    @property
    def usual(self) -> float:
        """Width where the row leaves a choice."""
        return round((self.minimum + self.maximum) / 2, 3)


def share_widths(spans: Sequence[WidthRange], available: float) -> list[float] | None:
    """Widths whose sum is `available`, or the maximum widths if their sum is less; None if the minimum does not fit.

    Every unit takes the same share of its range.
    """
    minimum, maximum = sum(s.minimum for s in spans), sum(s.maximum for s in spans)
    if minimum > available + WIDTH_STEP_M / 2:
        return None
    share = 1.0 if maximum <= available or maximum <= minimum else (available - minimum) / (maximum - minimum)
    widths = [round(s.minimum + share * (s.maximum - s.minimum), 3) for s in spans]
    rest = round(min(available, maximum) - sum(widths), 3)
    for i in sorted(range(len(spans)), key=lambda k: spans[k].minimum - spans[k].maximum):
        if rest and spans[i].maximum > spans[i].minimum:
            widths[i] = round(widths[i] + rest, 3)
            break
    return widths
