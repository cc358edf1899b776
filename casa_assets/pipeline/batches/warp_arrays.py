"""Memory of arrays of Warp."""

from __future__ import annotations

from typing import Any

import warp as wp


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
