"""Divide the length of a row among its units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

WIDTH_STEP_M = 0.001  # metres: widths are whole millimetres


@dataclass(frozen=True)
class WidthRange:
    """Least and greatest width of a unit, metres."""

    minimum: float
    maximum: float

    @property
    def usual(self) -> float:
        """Width where the row leaves a choice."""
        return round((self.minimum + self.maximum) / 2, 3)


def share_widths(spans: Sequence[WidthRange], room: float) -> list[float] | None:
    """Widths whose sum is `room`, or the greatest where that is less; None where not even the least ones fit.

    Every unit that can give or take does so in the same proportion.
    """
    least, most = sum(s.minimum for s in spans), sum(s.maximum for s in spans)
    if least > room + WIDTH_STEP_M / 2:
        return None
    part = 1.0 if most <= room or most <= least else (room - least) / (most - least)
    widths = [round(s.minimum + part * (s.maximum - s.minimum), 3) for s in spans]
    rest = round(min(room, most) - sum(widths), 3)
    for i in sorted(range(len(spans)), key=lambda k: spans[k].minimum - spans[k].maximum):
        if rest and spans[i].maximum > spans[i].minimum:
            widths[i] = round(widths[i] + rest, 3)
            break
    return widths
