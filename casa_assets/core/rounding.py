"""Round numbers so that two machines write the same digits; none comes out as negative zero."""

from __future__ import annotations


def significant(value: float, digits: int) -> float:
    """`value` rounded to `digits` significant digits."""
    return float(f"{value:.{digits}g}")


def seven_digits(value: float) -> float:
    """`value` rounded to seven significant digits, which both formats can represent; 0 below 1e-9."""
    return significant(value, 7) if abs(value) > 1e-9 else 0.0


def decimals(value: float, places: int) -> float:
    """`value` rounded to `places` decimals, as Python or numpy rounds its type; -0.0 becomes 0.0."""
    return round(value, places) + 0.0
