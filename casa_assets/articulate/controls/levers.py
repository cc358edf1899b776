"""Find levers that run in a slot among the controls, with the direction and length of the slot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.controls.controls import Control
from casa_assets.articulate.segment.fragment_measures import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.typing import Floats, Ints

# Depth of a slot against both sides, widest gap between the lever and its slot, and length of a slot; diagonals.
MIN_SLOT_DEPTH, MAX_SLOT_START_GAP, MIN_SLOT_LENGTH = 0.008, 0.02, 0.06
# A painted slot lies at most this far before its surroundings, diagonals.
PAINTED_SLOT_TOLERANCE = 0.001
# Least protrusion of a lever, diagonals.
MIN_PROTRUSION = 0.01
# Longest stretch of a slot that something beside it hides, diagonals.
MAX_SLOT_BREAK = 0.06
# Width to height of a level bar, and its travel by its height above the floor.
MIN_BAR_RATIO, BAR_TRAVEL_SHARE = 1.8, 0.5
# Distance from the middle of a slot at which its sides are sampled, in widths of the lever.
BESIDE_WIDTHS = 0.75


@dataclass(frozen=True)
class Lever:
    """A control that slides in a slot.

    Attributes:
        control: the thing. way: (3,) unit direction in (u, v, w) along which it goes. length: of the slot on that side.
    """

    control: Control
    way: Floats
    length: float


def find_levers(
    measured: MeasuredFragments, side: int, controls: Sequence[Control]
) -> tuple[list[Lever], list[Control]]:
    """Separate controls that run in a slot from the others."""
    near = float(corners_from_side(measured, side)[0][:, 2].min())
    levers: list[Lever] = []
    rest: list[Control] = []
    for control in controls:
        flush = control.protrusion < MIN_PROTRUSION
        found = None if control.is_round or flush else _longest(measured, side, control, near)
        if found is None:
            rest.append(control)
        else:
            levers.append(found)
    return levers, rest


def find_bar_levers(
    measured: MeasuredFragments, side: int, controls: Sequence[Control]
) -> tuple[list[Lever], list[Control]]:
    """Separate level bars, which lower the bread of a toaster though no slot is drawn for them, from other controls."""
    floor = float(corners_from_side(measured, side)[0][:, 1].min())
    levers: list[Lever] = []
    rest: list[Control] = []
    for control in controls:
        wide = float(control.across[0]) >= MIN_BAR_RATIO * float(control.across[1])
        room = float(control.lower[1]) - floor
        if control.is_round or not wide or control.protrusion < MIN_PROTRUSION or room < MIN_SLOT_LENGTH:
            rest.append(control)
        else:
            levers.append(Lever(control, np.array([0.0, -1.0, 0.0]), BAR_TRAVEL_SHARE * room))
    return levers, rest


def _longest(measured: MeasuredFragments, side: int, control: Control, near: float) -> Lever | None:
    """Return the lever with the longest slot of the four directions from a control, or None."""
    best: Lever | None = None
    for along, sign in ((1, -1.0), (1, 1.0), (0, -1.0), (0, 1.0)):
        found = _slot(measured, side, control, along, sign, near)
        if found is not None and (best is None or found.length > best.length + 1e-6):
            best = found
    return best


def _slot(
    measured: MeasuredFragments, side: int, control: Control, along: int, sign: float, near: float
) -> Lever | None:
    """Return the slot that leads away from a control in one direction, or None.

    Args:
        along: 0 for right, 1 for up. sign: of the way. near: depth of what is nearest in the picture.
    """
    image = measured.depth_images[side]
    across = 1 - along
    wide = float(control.across[across])
    start = float((control.upper if sign > 0 else control.lower)[along])
    steps = np.arange(1, int(0.7 / image.pixel)) * image.pixel
    lines, marks = [], []
    for shift in (0.0, -BESIDE_WIDTHS * wide, BESIDE_WIDTHS * wide):
        line = np.empty((len(steps), 2))
        line[:, along] = start + sign * steps
        line[:, across] = control.middle[across] + shift
        row, column = image.rows_columns(line)
        lines.append(image.depth[row, column])
        marks.append(np.where(image.face[row, column] >= 0, measured.label[image.face[row, column]], -1))
    inside = np.isfinite(lines[1]) & np.isfinite(lines[2])
    left, right = np.where(inside, lines[1], 0.0), np.where(inside, lines[2], 0.0)
    beside = np.maximum(left, right)
    deep = (
        inside
        & (np.abs(left - right) < MIN_SLOT_DEPTH)
        & ((lines[0] > beside + MIN_SLOT_DEPTH) | (_marked(marks) & (lines[0] > beside - PAINTED_SLOT_TOLERANCE)))
    )
    last = _run(deep, image.pixel)
    if last * image.pixel < max(MIN_SLOT_LENGTH, 1.2 * float(control.across[along])) or not _ends(deep, inside, last):
        return None
    slope = _slope(beside[:last]) / image.pixel
    way = np.zeros(3)
    way[along], way[2] = sign, slope
    return Lever(control, way / np.linalg.norm(way), last * image.pixel)


def _slope(depth: Floats) -> float:
    """Return how much a surface falls back from one step to the next.

    Measured between its first and its last third, for a shell of cubes goes down in stairs.
    """
    third = max(1, len(depth) // 3)
    steps = len(depth) - third
    return float(np.median(depth[-third:]) - np.median(depth[:third])) / max(steps, 1)


def _marked(marks: list[Ints]) -> Bools:
    """Mark the steps of a line at which one fragment lies between two sides of another, like a painted slot.

    Args:
        marks: fragments along the line itself, and along lines to its left and right.
    """
    middle, left, right = marks
    found: Bools = (middle >= 0) & (left == right) & (middle != left)
    strip = middle[found][0] if found.any() else -1
    same: Bools = found & (middle == strip)
    return same


def _run(deep: Bools, pixel: float) -> int:
    """Return the number of steps that a slot goes on from its start, which may lie a little way off."""
    rows = np.flatnonzero(deep)
    if not len(rows) or rows[0] * pixel > MAX_SLOT_START_GAP:
        return 0
    breaks = np.flatnonzero(np.diff(rows) * pixel > MAX_SLOT_BREAK)
    return int(rows[breaks[0]] if len(breaks) else rows[-1]) + 1


def _ends(deep: Bools, inside: Bools, last: int) -> bool:
    """Return whether the surface goes on beyond the end of a slot: a gap between fronts runs to the border."""
    beyond = slice(last + 2, last + 6)
    return bool(inside[beyond].all() and len(inside[beyond]) == 4 and not deep[beyond].any())
