"""Words that people choose by: joints of a kitchen, and surfaces that are covered with pictures.

Light to import, since the command line offers them.
"""

from __future__ import annotations

from enum import StrEnum

# Joint word -----------------------------------------------------------------------------------------------------------
# The words by which one chooses joints of a kitchen.


class JointWord(StrEnum):
    """Kind of part that a joint moves, as a hand uses it."""

    DOORS = "doors"
    DRAWERS = "drawers"
    RACKS = "racks"
    KNOBS = "knobs"
    BUTTONS = "buttons"
    LEVERS = "levers"
    LIDS = "lids"


# Surface --------------------------------------------------------------------------------------------------------------
# The surfaces of a kitchen that are textured. Cheap to import, since the command line offers their names.


class Surface(StrEnum):
    """The four surfaces of a kitchen whose textures are chosen independently."""

    WALL = "wall"
    FLOOR = "floor"
    COUNTER = "counter"
    CABINET = "cabinet"
