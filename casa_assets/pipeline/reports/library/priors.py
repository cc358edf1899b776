"""Sizes and masses of a library held against the usual ones of the registry: counts along a scale, and outliers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.core.rounding import significant
from casa_assets.model.registry.category import Category, Portion, SizeRange
from casa_assets.pipeline.reports.entry import Reported

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


class Fitting:
    """Holds entries against the usual ranges one after the other; keeps counts and outliers, and no entry.

    Args:
        categories: of objects and of fixtures, by id.
    """

    def __init__(self, categories: Mapping[str, Category]) -> None:
        self._categories = categories
        self._groups: dict[tuple[str, str], tuple[_Group, _Group]] = {}

    def add(self, entry: Reported) -> None:
        """Count an entry; one that was rejected, or is of a category that the registry does not know, is left out."""
        if not entry.accepted or entry.category not in self._categories:
            return
        key = entry.category, entry.portion
        if key not in self._groups:
            name, portion = key
            usual = self._categories[name].usual(Portion(portion) if portion else None)
            title = f"{name}, {portion}" if portion else name
            self._groups[key] = (
                _Group(title, Quantity.SIZE, usual.longest_m),
                _Group(title, Quantity.MASS, usual.mass_kg),
            )
        size, mass = self._groups[key]
        size.add(entry.id, max(entry.summary.extents) if entry.summary else 0.0)
        mass.add(entry.id, entry.summary.mass if entry.summary else 0.0)

    def fits(self) -> list[PriorFit]:
        """Every category that assets are of, those with most outliers first, then those with most assets."""
        found = [group.fit() for pair in self._groups.values() for group in pair]
        return sorted(found, key=lambda fit: (-len(fit.outliers), -fit.count, fit.name, fit.quantity))


def fits(entries: Iterable[Reported], categories: Mapping[str, Category]) -> list[PriorFit]:
    """The fits of entries, see `Fitting`."""
    fitting = Fitting(categories)
    for entry in entries:
        fitting.add(entry)
    return fitting.fits()


def outlying(found: Iterable[PriorFit], quantity: Quantity) -> list[str]:
    """Ids of all outliers of a quantity, sorted."""
    return sorted(outlier.id for fit in found if fit.quantity is quantity for outlier in fit.outliers)


class _Group:
    """One quantity of the assets of one category, or of a portion of it."""

    def __init__(self, name: str, quantity: Quantity, usual: SizeRange) -> None:
        self._name, self._quantity, self._usual = name, quantity, usual
        self._steps: Counter[int] = Counter()
        self._outliers: list[Outlier] = []

    def add(self, asset_id: str, value: float) -> None:
        low, high = self._usual.low, self._usual.high
        self._steps[_step(value, low, high)] += 1
        if value > 0 and (factor := max(value / high, low / value)) > TOLERANCE:
            self._outliers.append(Outlier(asset_id, significant(value, 6), significant(factor, 6), value > high))

    def fit(self) -> PriorFit:
        usual = self._usual
        return PriorFit(
            self._name,
            self._quantity,
            usual.low,
            usual.typical,
            usual.high,
            self._steps.total(),
            tuple(sorted(self._steps.items())),
            tuple(sorted(self._outliers, key=lambda one: (-one.factor, one.id))),
        )


def _step(value: float, low: float, high: float) -> int:
    return min(STEPS - 1, max(0, int(_share(value, low, high) * STEPS))) if value > 0 else 0


def _share(value: float, low: float, high: float) -> float:
    """Place on the scale: 0 at a quarter of the lowest, 1 at four times the highest; logarithmic."""
    return math.log(value * BEYOND / low) / math.log(high * BEYOND * BEYOND / low)
