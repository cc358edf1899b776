"""Find assets that are far larger or smaller than others of their category."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.checks.check import Measurement, largest

# With fewer of a kind there is no telling which one is odd.
FEWEST = 5
# What the sizes of a category scatter by at least, as a ratio: mugs of a set differ by as much.
LEAST_SCATTER = 1.1
# So many mean deviations of a normal distribution are one standard deviation.
NORMAL = 1.4826


@dataclass(frozen=True)
class LibrarySizes:
    """Sizes of the assets of a library, by category.

    Attributes:
        rows: (id, category, longest side in metres) of each.
    """

    rows: tuple[tuple[str, str, float], ...]


def sizes_fit_their_category(sizes: LibrarySizes, limit: float) -> Measurement:
    """Robust deviations of the oddest longest side from the median of its category.

    Ref: Iglewicz and Hoaglin 1993, the modified z score, here of logarithms; they call outliers what is beyond 3.5.
    """
    of: dict[str, list[tuple[str, float]]] = {}
    for name, category, longest in sizes.rows:
        of.setdefault(category, []).append((name, longest))
    found: list[float] = []
    problems = []
    for category, members in sorted(of.items()):
        if len(members) < FEWEST:
            continue
        logs = np.log([longest for _, longest in members])
        middle = float(np.median(logs))
        scatter = max(NORMAL * float(np.median(np.abs(logs - middle))), float(np.log(LEAST_SCATTER)))
        for (name, longest), off in zip(members, np.abs(logs - middle) / scatter, strict=True):
            found.append(float(off))
            if off > limit:
                message = f"is {longest:.3g} m long, and {np.exp(middle):.3g} m is usual for a {category} here"
                problems.append((name, f"{message}; look at its unit and its category"))
    return largest(found, tuple(problems), f"no category has {FEWEST} assets to compare")
