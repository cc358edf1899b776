"""Find members whose sides are not those of their category (OBJ001)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.check import Measurement, at_most, largest
from casa_assets.checks.objects.member import ObjectMember

SIDES = ("shortest", "middle", "longest")


def sides_fit_category(member: ObjectMember, limit: float) -> Measurement:
    """OBJ001: factor between a side and the nearer end of its usual range, the worst of three sides; below 1 inside it.

    Sides are matched in order of length, since many things rest in more than one way. Of a portion only the longest is
    known.
    """
    category, portion = member.category, member.asset.labels.portion
    sides = np.sort(np.ptp(member.asset.bounds, axis=0))
    if portion in category.portions:
        span = category.usual(portion).longest_m
        message = f"{category.called(portion)} is {100 * span.low:.3g} to {100 * span.high:.3g} cm long"
        return at_most(span.beyond(float(sides[-1])), limit, "bounds", message)
    ranges = category.extents
    lows, highs = (np.sort([getattr(side, end) for side in ranges]) for end in ("low", "high"))
    factors, problems = [], []
    for name, side, low, high in zip(SIDES, sides.tolist(), lows.tolist(), highs.tolist(), strict=True):
        factor = max(low / side, side / high)
        factors.append(factor)
        if factor > limit:
            usual = f"{100 * low:.3g} to {100 * high:.3g} cm are usual for a {category.id}"
            problems.append(("bounds", f"its {name} side is {100 * side:.3g} cm; {usual}; change the numbers it is of"))
    return largest(factors, problems, "it has no sides")
