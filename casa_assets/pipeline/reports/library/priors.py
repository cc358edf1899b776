"""Sizes and masses of a library held against the usual ones of the registry: counts along a scale, and outliers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.core.rounding import significant
from casa_assets.model.registry.category import Category, Portion, SizeRange
from casa_assets.pipeline.reports.entry import Entry

# The scale of a chart goes from a quarter of the lowest usual value to four times the highest, in so many steps of
# equal ratio; what lies beyond is counted at its ends.
BEYOND, STEPS = 4.0, 48
# An asset that was made as large as is usual at most may be larger by what float32 rounds off.
TOLERANCE = 1.001


class Quantity(StrEnum):
    """What is held against the registry: the longest side in metres, the mass in kilograms."""

    SIZE = "size"
    MASS = "mass"


@dataclass(frozen=True)
class Outlier:
    """An asset outside the usual range.

    Attributes:
        id: of the asset. value: its own. factor: how many times it is over the highest, or under the lowest usual
            value. is_over: it is over the highest.
    """

    id: str
    value: float
    factor: float
    is_over: bool


@dataclass(frozen=True)
class PriorFit:
    """The assets of one category, or of a portion of it, against its usual range.

    Attributes:
        name: of the category, such as `mug`, or `apple, half`. quantity, low, typical, high: from the registry.
        count: assets. steps: (step of the scale, how many), sorted. outliers: the farthest first.
    """

    name: str
    quantity: Quantity
    low: float
    typical: float
    high: float
    count: int
    steps: tuple[tuple[int, int], ...]
    outliers: tuple[Outlier, ...]

    @property
    def marks(self) -> tuple[float, float, float]:
        """Places of the lowest, the typical and the highest usual value on the scale, 0 to 1."""
        low, typical, high = (_share(value, self.low, self.high) for value in (self.low, self.typical, self.high))
        return low, typical, high


def fits(entries: Iterable[Entry], categories: Mapping[str, Category]) -> list[PriorFit]:
    """Every category that assets are of and the registry knows, those with most outliers first, then those with most.

    Args:
        entries: rejected ones are left out. categories: of objects and of fixtures, by id.
    """
    groups: dict[tuple[str, str], list[Entry]] = {}
    for entry in entries:
        if entry.accepted and entry.category in categories:
            groups.setdefault((entry.category, entry.portion), []).append(entry)
    found = []
    for (name, portion), members in groups.items():
        usual = categories[name].usual(Portion(portion) if portion else None)
        title = f"{name}, {portion}" if portion else name
        found.append(_fit(title, Quantity.SIZE, usual.longest_m, members, _longest))
        found.append(_fit(title, Quantity.MASS, usual.mass_kg, members, _mass))
    return sorted(found, key=lambda fit: (-len(fit.outliers), -fit.count, fit.name, fit.quantity))


def outlying(found: Iterable[PriorFit], quantity: Quantity) -> list[str]:
    """Ids of all outliers of a quantity, sorted."""
    return sorted(outlier.id for fit in found if fit.quantity is quantity for outlier in fit.outliers)


def _fit(
    name: str, quantity: Quantity, usual: SizeRange, members: list[Entry], value_of: Callable[[Entry], float]
) -> PriorFit:
    values = [(member.id, value_of(member)) for member in members]
    steps = Counter(_step(value, usual.low, usual.high) for _, value in values)
    outliers = [
        Outlier(member, significant(value, 6), significant(factor, 6), value > usual.high)
        for member, value in values
        if value > 0 and (factor := max(value / usual.high, usual.low / value)) > TOLERANCE
    ]
    outliers.sort(key=lambda one: (-one.factor, one.id))
    return PriorFit(
        name,
        quantity,
        usual.low,
        usual.typical,
        usual.high,
        len(values),
        tuple(sorted(steps.items())),
        tuple(outliers),
    )


def _step(value: float, low: float, high: float) -> int:
    return min(STEPS - 1, max(0, int(_share(value, low, high) * STEPS))) if value > 0 else 0


def _share(value: float, low: float, high: float) -> float:
    """Place on the scale: 0 at a quarter of the lowest, 1 at four times the highest; logarithmic."""
    return math.log(value * BEYOND / low) / math.log(high * BEYOND * BEYOND / low)


def _longest(entry: Entry) -> float:
    return max(entry.summary.extents) if entry.summary else 0.0


def _mass(entry: Entry) -> float:
    return entry.summary.mass if entry.summary else 0.0
