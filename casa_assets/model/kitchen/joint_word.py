"""The words by which one chooses joints of a kitchen."""

from __future__ import annotations

from enum import StrEnum


class JointWord(StrEnum):
    """Kind of part that a joint moves, as a hand uses it."""

    DOORS = "doors"
    DRAWERS = "drawers"
    RACKS = "racks"
    KNOBS = "knobs"
    BUTTONS = "buttons"
    LEVERS = "levers"
    LIDS = "lids"
