"""The surfaces of a kitchen that are covered with pictures. Light to import: the command line offers the names."""

from __future__ import annotations

from enum import StrEnum


class Surface(StrEnum):
    """The four surfaces of a kitchen whose pictures are chosen independently."""

    WALL = "wall"
    FLOOR = "floor"
    COUNTER = "counter"
    CABINET = "cabinet"
