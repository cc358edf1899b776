"""The surfaces of a kitchen that are textured. Cheap to import, since the command line offers their names."""

from __future__ import annotations

from enum import StrEnum


class Surface(StrEnum):
    """The four surfaces of a kitchen whose textures are chosen independently."""

    WALL = "wall"
    FLOOR = "floor"
    COUNTER = "counter"
    CABINET = "cabinet"
