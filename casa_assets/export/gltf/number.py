"""Numbers and poses as glTF has them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from casa_assets.export.mjcf import number
from casa_assets.model.pose import Pose


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers rounded to the same digits as in the other writers."""
    return [float(number.number(value)) for value in values]


def placed(pose: Pose) -> dict[str, Any]:
    """`translation` (metres) and `rotation` (x, y, z, w) of a node; empty for the identity."""
    w, x, y, z = pose.quaternion
    found: dict[str, Any] = {}
    if any(pose.position):
        found["translation"] = rounded(pose.position)
    if (x, y, z) != (0.0, 0.0, 0.0):
        found["rotation"] = rounded((x, y, z, w))
    return found
