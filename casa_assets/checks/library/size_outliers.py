"""Find assets that are far larger or smaller than others of their category."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.checks.check import Measurement, largest

# With fewer assets of a category nobody can tell which one is odd.
MIN_ASSETS = 5
# The least scatter of the sizes of a category, as a ratio: mugs of a set differ by as much.
MIN_SCATTER = 1.1
# Standard deviation of a normal distribution over its median absolute deviation.
SIGMA_PER_MAD = 1.4826


@dataclass(frozen=True)
class LibrarySizes:
    """Sizes of the assets of a library, by category.

    Attributes:
        rows: (id, category, longest side in metres) of each.
    """

    rows: tuple[tuple[str, str, float], ...]


def sizes_fit_their_category(sizes: LibrarySizes, limit: float) -> Measurement:
    """LIB004: robust deviations of the oddest longest side from the median of its category.

    Ref: Iglewicz and Hoaglin 1993, the modified z score, here of logarithms; they call outliers what is beyond 3.5.
    """
    by_category: dict[str, list[tuple[str, float]]] = {}
    for name, category, longest in sizes.rows:
        by_category.setdefault(category, []).append((name, longest))
    deviations: list[float] = []
    problems = []
    for category, members in sorted(by_category.items()):
        if len(members) < MIN_ASSETS:
            continue
        logs = np.log([longest for _, longest in members])
        middle = float(np.median(logs))
        scatter = max(SIGMA_PER_MAD * float(np.median(np.abs(logs - middle))), float(np.log(MIN_SCATTER)))
        for (name, longest), deviation in zip(members, np.abs(logs - middle) / scatter, strict=True):
            deviations.append(float(deviation))
            if deviation > limit:
                message = f"is {longest:.3g} m long, and {np.exp(middle):.3g} m is usual for a {category} here"
                problems.append((name, f"{message}; look at its unit and its category"))
    return largest(deviations, problems, f"no category has {MIN_ASSETS} assets to compare")
