"""Guess the length unit of a mesh whose file does not state one, by the usual size of kitchen objects."""

from __future__ import annotations

import math
from collections.abc import Mapping

from casa_assets.model.registry.category import SizeRange

UNITS: Mapping[str, float] = {"metre": 1.0, "centimetre": 0.01, "millimetre": 0.001, "inch": 0.0254}
# Longest sides of kitchen appliances and cabinets, from a kettle to a tall fridge, metres.
ANY_APPLIANCE_M = SizeRange(low=0.15, typical=0.75, high=2.6)


def metres_per_unit(longest: float, stated: float | None, span: SizeRange | None) -> tuple[float, float, str]:
    """Return the metres in a unit, the confidence 0..1, and the reason.

    Args:
        longest: longest side, units. stated: by the file. span: of the longest side of its kind, where that is known.
    """
    usual = span or ANY_APPLIANCE_M
    if stated is not None and usual.low / 1.3 <= longest * stated <= usual.high * 1.3:
        return stated, 0.95, f"the file's unit gives {longest * stated:.3g} m"
    fits = {
        n: abs(math.log(longest * u / usual.typical))
        for n, u in UNITS.items()
        if usual.low <= longest * u <= usual.high
    }
    normalised = any(abs(longest - n) < 2e-3 for n in (1.0, 2.0))
    if fits and not (normalised and span is not None and "metre" not in fits):
        name = min(fits, key=lambda n: (fits[n], n))
        return UNITS[name], 0.8, f"read as {name}s it is {longest * UNITS[name]:.3g} m long"
    return usual.typical / longest, 0.3, f"no unit fits {longest:.4g}; set to {usual.typical:g} m"
