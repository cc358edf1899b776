"""Beams under a ceiling, and lamps between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets.layouts.room import Room
from casa_assets.layouts.runs import Line
from casa_assets.model.plan import Plan
from casa_assets.model.record import Vec2
from casa_assets.model.style import Style

APART = 1.1  # metres from beam to beam
FEWEST, MOST = 3, 8


@dataclass(frozen=True)
class Beamwork:
    """Beams of one room, evenly apart.

    Attributes:
        along_x: whether they run along the room's x axis, else along y.
        low, high: of the room across them, metres. count: of beams.
    """

    along_x: bool
    low: float
    high: float
    count: int

    def between(self, x: float, y: float) -> Vec2:
        """The point nearest to x, y that lies in the middle between two beams."""
        pitch = (self.high - self.low) / self.count
        at = y if self.along_x else x
        gap = min(max(round((at - self.low) / pitch), 1), self.count - 1)
        snapped = self.low + gap * pitch
        return (x, snapped) if self.along_x else (snapped, y)


def beams_of(plan: Plan, style: Style, room: Room, lines: Mapping[str, Line]) -> Beamwork | None:
    """The beams of a style that has some; along a row of lamps where the plan has one, so that it hangs between two."""
    if style.shell.beams is None:
        return None
    (x0, y0), (x1, y1) = room.bounds()
    rows = [lines[lamps.over] for lamps in plan.lamps if lamps.over is not None and lamps.over in lines]
    along_x = bool(rows) and rows[0].frame.quarter % 2 == 0
    low, high = (y0, y1) if along_x else (x0, x1)
    return Beamwork(along_x, low, high, min(max(round((high - low) / APART), FEWEST), MOST))
