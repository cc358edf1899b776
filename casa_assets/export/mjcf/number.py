"""Numbers -> text: nine significant digits, which hold a float32 exactly, and no minus before zero."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from casa_assets.core.color import srgb_from_linear
from casa_assets.model.pose import Pose

# Enough to read a float32 back exactly. Ref: IEEE 754-2008, 5.12.2.
FORMAT = "%.9g"


def number(value: float) -> str:
    """Text of one number."""
    text = FORMAT % value
    return "0" if text == "-0" else text


def numbers(values: Iterable[float]) -> str:
    """Text of several numbers, one space between them."""
    return " ".join(number(float(v)) for v in values)


def srgb(color: Sequence[float]) -> str:
    """Text of a linear RGB or RGBA colour as display values; alpha stays as it is."""
    return numbers((*(srgb_from_linear(c) for c in color[:3]), *color[3:]))


def place(pose: Pose) -> dict[str, str]:
    """Attributes `pos` and, unless there is no rotation, `quat` of parent_from_element."""
    attributes = {"pos": numbers(pose.position)}
    if any(pose.quaternion[1:]):
        attributes["quat"] = numbers(pose.quaternion)
    return attributes


def rows(prefix: str, array: npt.NDArray[np.float64]) -> str:
    """(N, K) values rounded to float32, one line each: `v 0.1 0.2 0.3`."""
    single = array.astype(np.float32).astype(np.float64) + 0.0  # + 0.0 turns -0.0 into 0.0
    line = " ".join([prefix, *[FORMAT] * array.shape[1]]) + "\n"
    return (line * len(array)) % tuple(single.ravel().tolist())
