"""Make the units of a row fit their length, in the order in which a kitchen designer would give things up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from casa_assets.layouts.plan.rows import WidthRange
from casa_assets.model.kitchen.units import BaseUnit, UpperUnit

# Least widths, metres, that a unit may be narrowed to; what is not here has the width of its appliance.
LEAST = {
    "gap": 0.05, "filler": 0.03, "shelf": 0.25, "boards": 0.3, "glass": 0.3, "doors": 0.3, "drawers": 0.3,
    "pantry": 0.3, "island": 0.8,
}  # fmt: skip
# What is taken out first; of units of one kind the last in the row. Sinks, cookers and refrigerators stay, and so does
# the hood over a cooker.
GIVEN_UP = (
    "filler", "gap", "panel", "shelf", "boards", "glass", "doors", "microwave", "pantry", "drawers", "oven",
    "dishwasher",
)  # fmt: skip
# Units that may be made wider where a row is too short, and how wide.
WIDENED = {"doors": 1.1, "drawers": 1.1, "pantry": 0.9, "shelf": 0.9, "glass": 0.9}
LEAST_ADDED = 0.3


@dataclass(frozen=True)
class RowChange:
    """A change of one unit.

    Attributes:
        index: of the unit. width: the least and the greatest it has now; None: it is taken out.
    """

    index: int
    width: tuple[float, float] | None


Units = Sequence[BaseUnit | UpperUnit]


def shrunk(
    units: Units, spans: Sequence[WidthRange], available: float, keep_last: int = 1, kept: Sequence[int] = ()
) -> list[RowChange] | None:
    """Changes after which the least widths of units take no more than what is available; None where nothing does it.

    Units are narrowed first. Then they are taken out, those that matter least first.

    Args:
        keep_last: how many units have to remain. kept: units that are not taken out.
    """
    least = [s.minimum for s in spans]
    floors = [min(s.minimum, LEAST.get(str(u.kind), s.minimum)) for u, s in zip(units, spans, strict=True)]
    gone: list[int] = []
    for kind in (None, *GIVEN_UP):
        while True:
            excess = round(sum(least[k] for k in range(len(units)) if k not in gone) - available, 4)
            slack = round(sum(least[k] - floors[k] for k in range(len(units)) if k not in gone), 4)
            if excess <= slack:
                return _narrowed(units, spans, floors, gone, max(excess, 0.0))
            left = [k for k in range(len(units)) if k not in (*gone, *kept) and str(units[k].kind) == kind]
            if kind is None or not left or len(units) - len(gone) <= keep_last:
                break
            if kind in ("doors", "drawers") and _is_last_worktop(units, gone, left):
                break
            gone.append(left[-1])
    return None


def _is_last_worktop(units: Units, gone: Sequence[int], left: Sequence[int]) -> bool:
    """True if nothing else in a row of floor units would offer a worktop to set things down on."""
    if isinstance(units[0], UpperUnit):
        return False
    tops = [k for k in range(len(units)) if k not in gone and str(units[k].kind) in ("doors", "drawers", "dishwasher")]
    return len(tops) <= 1 and list(left) == tops


def _narrowed(
    units: Units, spans: Sequence[WidthRange], floors: Sequence[float], gone: Sequence[int], excess: float
) -> list[RowChange]:
    changes = [RowChange(k, None) for k in sorted(gone)]
    order = [
        k for kind in ("gap", "filler", *GIVEN_UP, "island") for k in range(len(units)) if str(units[k].kind) == kind
    ]
    for k in dict.fromkeys(order):
        room = round(spans[k].minimum - floors[k], 4)
        if k in gone or room <= 0.0 or excess <= 0.0:
            continue
        less = min(room, excess)
        excess = round(excess - less, 4)
        low = round(spans[k].minimum - less - 0.0004, 3)
        changes.append(RowChange(k, (max(low, floors[k]), max(low, spans[k].maximum))))
    return changes


def widened(units: Units, spans: Sequence[WidthRange], rest: float) -> tuple[list[RowChange], float]:
    """Changes that take up what is left of a row, and what they leave, metres."""
    changes = []
    flexible = [k for k, u in enumerate(units) if str(u.kind) in WIDENED and WIDENED[str(u.kind)] > spans[k].maximum]
    for n, k in enumerate(flexible):
        more = min(WIDENED[str(units[k].kind)] - spans[k].maximum, round(rest / (len(flexible) - n), 3))
        if more > 0.001:
            changes.append(RowChange(k, (spans[k].minimum, round(spans[k].maximum + more, 3))))
            rest = round(rest - more, 4)
    return changes, rest
