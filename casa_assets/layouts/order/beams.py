"""Order ceiling beams, and find places for lamps between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from casa_assets.layouts.plan.room import Room
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import Style
from casa_assets.model.kitchen.units import UpperKind
from casa_assets.model.record import Vec2

BEAM_SPACING_M = 1.1  # metres from beam to beam
MIN_COUNT, MAX_COUNT = 3, 8
MAX_COUNT_CHANGE = 2  # more or fewer than usual, which look as good
BEAM_HALF_WIDTH_M = 0.12  # with a gap
BEAM_HEIGHT_M, OVER_UNITS_M = 0.16, 0.08  # as the family of ceilings has it; of a cornice, with a gap
HOOD_DEPTH_M = 0.55
CHIMNEY_WIDTH_M = 0.5  # of most hoods, with a gap; only it reaches the ceiling


@dataclass(frozen=True)
class BeamGrid:
    """Beams of one room, evenly apart.

    Attributes:
        along_x: whether they run along the room's x axis, else along y.
        start, end: of the room across the beams, metres. count: of beams.
    """

    along_x: bool
    start: float
    end: float
    count: int

    def between(self, x: float, y: float) -> Vec2:
        """The point nearest to x, y that lies in the middle between two beams."""
        pitch = (self.end - self.start) / self.count
        at = y if self.along_x else x
        gap = min(max(round((at - self.start) / pitch), 1), self.count - 1)
        snapped = self.start + gap * pitch
        return (x, snapped) if self.along_x else (snapped, y)

    def crosses(self, low: float, high: float) -> bool:
        """True if a beam comes between two places across the beams, or nearly."""
        pitch = (self.end - self.start) / self.count
        middles = [self.start + (k + 0.5) * pitch for k in range(self.count)]
        return any(low - BEAM_HALF_WIDTH_M < m < high + BEAM_HALF_WIDTH_M for m in middles)


def beams_of(
    plan: Plan, style: Style, room: Room, lines: Mapping[str, RunLine], slots: Mapping[str, Sequence[UnitSlot]]
) -> BeamGrid | None:
    """The beams of a style that has some, clear of the hoods and the columns that reach the ceiling.

    If the plan has a row of lamps, the beams run along it, so that it hangs between two of them. None if the style has
    no beams, or the ceiling is so low that they would reach down to cabinets.
    """
    highest = max((s.top for row in slots.values() for s in row if s.kind is not UpperKind.HOOD), default=0.0)
    if style.room.beams is None or room.height - BEAM_HEIGHT_M < highest + OVER_UNITS_M - 1e-6:
        return None
    (x0, y0), (x1, y1) = room.level_bounds()
    rows = [lines[lamps.over] for lamps in plan.lamps if lamps.over is not None and lamps.over in lines]
    directions = (rows[0].frame.quarter_turns % 2 == 0,) if rows and rows[0].frame.is_aligned else (False, True)
    usual, every = (
        [w for along_x in directions for w in _grids(along_x, *((y0, y1) if along_x else (x0, x1)), off)]
        for off in (MAX_COUNT_CHANGE, MAX_COUNT)
    )
    for grids, reach in ((usual, None), (every, None), (every, CHIMNEY_WIDTH_M)):
        clear = (
            w
            for w in grids
            if not any(w.crosses(*h) for h in (*_hoods(slots, w.along_x, reach), *_columns(room, w.along_x)))
        )
        found = next(clear, None)
        if found is not None:
            return found
    return usual[0]


def _grids(along_x: bool, low: float, high: float, off: int) -> list[BeamGrid]:
    """Beams across a room, the usual number of them first, then up to `off` more or fewer."""
    usual = min(max(round((high - low) / BEAM_SPACING_M), MIN_COUNT), MAX_COUNT)
    counts = sorted(range(MIN_COUNT, MAX_COUNT + 1), key=lambda n: (abs(n - usual), n))
    return [BeamGrid(along_x, low, high, n) for n in counts if abs(n - usual) <= off]


def _hoods(slots: Mapping[str, Sequence[UnitSlot]], along_x: bool, wide: float | None) -> Iterator[Vec2]:
    """From where to where hoods reach across the beams, metres; of each no more than the middle that is so wide."""
    axis = 1 if along_x else 0
    for slot in (s for row in slots.values() for s in row if s.kind is UpperKind.HOOD):
        middle, half = (slot.left + slot.right) / 2, (slot.right - slot.left) / 2
        half = half if wide is None else min(half, wide / 2)
        ends = [slot.line.frame.at(u, v)[axis] for u in (middle - half, middle + half) for v in (0.0, HOOD_DEPTH_M)]
        yield min(ends), max(ends)


def _columns(room: Room, along_x: bool) -> Iterator[Vec2]:
    """From where to where columns reach across the beams, metres."""
    for placed in room.columns:
        ends = [corner[1 if along_x else 0] for corner in placed.outline]
        yield min(ends), max(ends)
