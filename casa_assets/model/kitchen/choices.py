"""Words that people choose by: joints of a kitchen, and surfaces with textures. Light: the command line offers them."""

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


class Surface(StrEnum):
    """The four surfaces of a kitchen whose textures are chosen independently."""

    WALL = "wall"
    FLOOR = "floor"
    COUNTER = "counter"
    CABINET = "cabinet"
