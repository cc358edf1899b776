"""Array types, rounding, rotation matrices, sRGB, and seeded random generators: the same numbers on every machine."""

from __future__ import annotations

import hashlib
import math
from typing import Any

import numpy as np
import numpy.typing as npt

# Coordinates and measures.
Floats = npt.NDArray[np.float64]
# The same of pictures, where half the memory is half the time.
Singles = npt.NDArray[np.float32]
# Indices and counts.
Ints = npt.NDArray[np.int64]
# True where something holds.
Mask = npt.NDArray[np.bool_]


def significant(value: float, digits: int) -> float:
    """`value` rounded to `digits` significant digits."""
    return float(f"{value:.{digits}g}")


def seven_digits(value: float) -> float:
    """`value` rounded to seven significant digits, which both formats can represent; 0 below 1e-9."""
    return significant(value, 7) if abs(value) > 1e-9 else 0.0


def decimals(value: float, places: int) -> float:
    """`value` rounded to `places` decimals, as Python or numpy rounds its type; -0.0 becomes 0.0."""
    return round(value, places) + 0.0


def about_axis(axis: Floats, angle: float) -> Floats:
    """(3, 3) right-handed rotation about a (3,) unit axis, angle in rad. Ref: Rodrigues' rotation formula.

    Not scipy's Rotation: its last bits differ, and asset files must stay identical.
    """
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    found: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return found


# Conversion from display values (sRGB) to linear light and back.
#
# There are separate functions for one channel and for arrays: numpy's power differs from Python's in the last bit, and
# colours that were written before must keep their digits. Ref: IEC 61966-2-1.


def srgb_from_hex(color: str) -> tuple[float, float, float]:
    """Display values in 0..1 of `#rrggbb`."""
    red, green, blue = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def linear_from_srgb(value: float) -> float:
    """One channel, display value in 0..1 -> linear light in 0..1."""
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(value: float) -> float:
    """One channel, linear light in 0..1 -> display value in 0..1."""
    return 12.92 * value if value <= 0.0031308 else float(1.055 * value ** (1 / 2.4) - 0.055)


def linear_from_srgb_array(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Display values in 0..1, any shape and precision -> linear light, the same shape and precision."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def srgb_from_linear_array(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Linear light from 0 on, any shape and precision -> display values, the same shape and precision."""
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 0) ** (1 / 2.4) - 0.055)


def rng_for(seed: int, lane: str) -> np.random.Generator:
    """The generator of one lane, such as `families/microwave/3`: one more draw for the walls does not move the cups."""
    digest = hashlib.sha256(lane.encode("utf-8")).digest()
    words = [int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4)]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *words])))
