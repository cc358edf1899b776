"""Arrays of Warp: their memory, and rows of them written on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from casa_assets.core.typing import Floats, Ints


def bytes_of(*owners: Any) -> int:
    """Memory of the arrays that objects hold as attributes, and the objects that they hold in turn, bytes."""
    total, left, seen = 0, list(owners), set[int]()
    while left:
        value = left.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, wp.array):
            total += int(value.capacity)
        elif type(value).__module__.partition(".")[0] in ("mujoco_warp", "newton"):
            left.extend(vars(value).values())
    return total


def assign_rows(array: Any, rows: Any, values: Floats | Ints) -> None:
    """Write into some rows of an array on its device, from their first column on; other rows do not travel.

    Args:
        array: (N, M), of numbers or vectors. rows: (K,) warp array of ints. values: (K, up to M).
    """
    columns = wp.array(np.arange(values.shape[1]), dtype=int, device=array.device)
    found = wp.array(values, dtype=array.dtype, device=array.device)
    wp.copy(wp.indexedarray(array, [rows, columns]), found)
