"""A plan whose lengths are all in centimetres or millimetres: every one of them is written in metres at once.

Mended one by one, those that are small enough to pass for metres would stay: a filler of 5 would be one of 5 m.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from casa_assets.model.registry.document import KeyPath
from casa_assets.pipeline.plans.fault import Fault, Mend, replaced

# Keys of lengths; `at` of a thing on a worktop is a share of its unit.
LENGTHS = (
    "length", "height", "width", "depth", "sill", "at", "start", "end", "aisle", "shift", "overhang", "from_wall",
    "knee", "back", "low", "high", "default", "closet",
)  # fmt: skip
SHARES = ("worktop_items", "at")
# Units: how many metres one is, and the least length of a wall that is written in it.
UNITS = {"millimetres": (0.001, 900.0), "centimetres": (0.01, 90.0)}
LEAST_SMALL = 2.5  # a length under this is in metres: 2.5 cm or mm are no length of a kitchen


def other_unit(plan: Mapping[str, Any]) -> Fault | None:
    """The fault of a plan whose lengths are all in another unit; None where some are in metres."""
    found = [(at, value) for at, value in _lengths(plan, ()) if value != 0]
    walls = [value for at, value in found if at[0] == "walls" and at[-1] == "length"]
    if not walls or any(abs(value) < LEAST_SMALL for _, value in found):
        return None
    for name, (metres, least) in UNITS.items():
        if min(walls) >= least:
            edits = tuple(replaced(at, round(value * metres, 4)) for at, value in found)
            return Fault(("walls",), "lengths in metres", name, Mend("Write all lengths in metres.", edits))
    return None


def _lengths(value: Any, at: KeyPath) -> Iterator[tuple[KeyPath, float]]:
    """Pointer and value of each number that is a length."""
    rows = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in rows:
        yield from _lengths(inner, (*at, key))
    if isinstance(value, int | float) and not isinstance(value, bool) and _is_length(at):
        yield at, value


def _is_length(at: KeyPath) -> bool:
    keys = [step for step in at if isinstance(step, str)]
    if not keys or (keys[0], keys[-1]) == SHARES:
        return False
    in_unit = keys[0] == "runs" and len(keys) == 4 and keys[2] in ("base", "upper")
    return keys[0] == "parameters" or keys[-1] in LENGTHS or in_unit
