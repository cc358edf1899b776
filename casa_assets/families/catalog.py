"""Every family by name."""

from __future__ import annotations

from typing import Any

from casa_assets.errors import UnknownId
from casa_assets.families.family import Family
from casa_assets.families.fixtures import cabinets, cold, cooking, counters, decor, room, small

GROUPS: dict[str, tuple[Family[Any], ...]] = {
    "cabinets": cabinets.FAMILIES,
    "counters": counters.FAMILIES,
    "cooking": cooking.FAMILIES,
    "cold": cold.FAMILIES,
    "small": small.FAMILIES,
    "decor": decor.FAMILIES,
    "room": room.FAMILIES,
}
FAMILIES: dict[str, Family[Any]] = {family.name: family for group in GROUPS.values() for family in group}


def family(name: str) -> Family[Any]:
    """The family of that name. Raises UnknownId with the nearest names."""
    if name not in FAMILIES:
        raise UnknownId("family", name, FAMILIES)
    return FAMILIES[name]
