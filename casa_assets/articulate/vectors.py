"""Convert arrays to the tuples of three numbers that records hold, rounded where they are written to files."""

from __future__ import annotations

from collections.abc import Iterable

from casa_assets.core.rounding import significant
from casa_assets.model.record import Vec3


def to_vec3(values: Iterable[float]) -> Vec3:
    """Return three numbers, unrounded."""
    x, y, z = (float(v) for v in values)
    return (x, y, z)


def round7(value: float) -> float:
    """Round a number to seven significant digits."""
    return significant(float(value), 7)


def round7_vec3(values: Iterable[float]) -> Vec3:
    """Return three numbers rounded to seven significant digits; what is nearer to zero than 1e-9 becomes zero."""
    x, y, z = (round7(v) if abs(v) > 1e-9 else 0.0 for v in values)
    return (x, y, z)


def round_mm(value: float) -> float:
    """Round metres to a tenth of a millimetre."""
    return round(float(value), 4)


def round_mm_vec3(values: Iterable[float]) -> Vec3:
    """Round a point or a size, metres, to tenths of a millimetre."""
    x, y, z = (round_mm(v) for v in values)
    return (x, y, z)
