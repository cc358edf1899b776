"""Conversion from display values (sRGB) to linear light and back.

There are separate functions for one channel and for arrays: numpy's power differs from Python's in the last bit, and
colours that were written before must keep their digits. Ref: IEC 61966-2-1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


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
