"""The words by which one chooses joints of a kitchen."""

from __future__ import annotations

from enum import StrEnum


class JointWord(StrEnum):
    """What a joint moves, as a hand takes it."""

    DOORS = "doors"
    DRAWERS = "drawers"
    RACKS = "racks"
    KNOBS = "knobs"
    BUTTONS = "buttons"
    LEVERS = "levers"
    LIDS = "lids"
