"""Grips of handles, knobs and keys: ways to hold or press them with a hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from casa_assets.ext.arrays import Floats, about_axis

BAR_RATIO = 1.5  # a thing this many times as long as wide is held across its length
BAR_ANGLES_DEG = (0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0)  # at which a hand comes, about the bar
KNOB_ANGLES_DEG = (0.0, 90.0, 180.0, -90.0, 45.0, -45.0, 135.0, -135.0)  # of the fingers about a knob or key
TILTS_DEG = (0.0, 25.0, -25.0)  # at which a hand comes to a knob or key, out of its axis
EDGE_TILTS_DEG = (0.0, 25.0, -25.0, 45.0, -45.0)  # at which a hand comes to the edge of a plate
SHIFTED_FROM_M = 0.06  # half length from which a bar is also held off its middle
EDGE_DEPTH_M = 0.015  # to which fingers take a plate at its edge
# How far the point between the fingers goes into what is held, at most to its middle: tips reach 1 cm beyond it, and
# what is behind a handle may be near.
TAKEN_M = 0.004
UP = np.array((0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Grip:
    """A held part as a box in the world: half lengths (m) along columns of `axes`; `front`: out of the fixture."""

    centre: Floats
    axes: Floats
    half: Floats
    front: Floats


@dataclass(frozen=True)
class Grasp:
    """Where the point between the fingers, or the tip that presses, is put, and (3, 3) how the hand is turned.

    Columns: the direction in which fingers close, the one across, the one in which the hand comes. `width`: of the
    thing between the fingers, m; 0 for what is pressed. `pivots`: the hand may turn about the direction across, along a
    bar.
    """

    position: Floats
    rotation: Floats
    width: float = 0.0
    pivots: bool = False


def pinches(grip: Grip, opening: float, turning: Floats | None) -> list[Grasp]:
    """Ways of holding a part between fingers `opening` m apart, the most natural first; none if it is too thick.

    `turning`: (3,) axis about which a knob turns, None if the part is not a knob.
    """
    small, middle, long = np.argsort(grip.half, kind="stable")
    if turning is None and grip.half[long] > BAR_RATIO * grip.half[middle] and 2 * grip.half[middle] < opening:
        return list(_across(grip, grip.axes[:, long], float(grip.half[long])))
    if turning is None and 2 * grip.half[middle] >= opening > 2 * grip.half[small]:
        return list(_at_edge(grip, grip.axes[:, small]))
    return list(_around(grip, opening, turning))


def presses(grip: Grip, motion: Floats) -> list[Grasp]:
    """Ways of pressing a key with a fingertip; `motion`: (3,) unit vector along which the key goes in."""
    at = grip.centre - motion * _reach(grip, motion)
    side = _perpendicular(motion, UP)
    found = []
    for tilt in (0.0, *TILTS_DEG[1:], 50.0, -50.0):
        for axis in (side, np.cross(motion, side))[: 1 if tilt == 0.0 else 2]:
            come = _turned(motion, axis, tilt)
            across = _perpendicular(come, UP)
            for angle in KNOB_ANGLES_DEG:
                found.append(Grasp(at, _frame(come, _turned(across, come, angle))))
    return found


def _across(grip: Grip, bar: Floats, half: float) -> Iterator[Grasp]:
    """Fingers on both sides of a bar."""
    base = -grip.front - (-grip.front @ bar) * bar
    if np.linalg.norm(base) < 0.5:
        base = -UP - (-UP @ bar) * bar
    base /= np.linalg.norm(base)
    shifts = (0.0, half / 2, -half / 2) if half > SHIFTED_FROM_M else (0.0,)
    for shift in shifts:
        for angle in BAR_ANGLES_DEG:
            come = _turned(base, bar, angle)
            for sign in (1.0, -1.0):
                close = sign * np.cross(bar, come)
                at = _taken(grip, come) + shift * bar
                yield Grasp(at, _frame(come, close), 2 * _reach(grip, close), pivots=True)


def _at_edge(grip: Grip, thin: Floats) -> Iterator[Grasp]:
    """Fingers above and below the front edge of a plate."""
    come = -grip.front - (-grip.front @ thin) * thin
    if np.linalg.norm(come) < 0.5:
        return
    come /= np.linalg.norm(come)
    edge = grip.centre - come * (_reach(grip, come) - EDGE_DEPTH_M)
    along, thick = np.cross(thin, come), _reach(grip, thin)
    half = _reach(grip, along)
    for shift in (0.0, half / 2, -half / 2, 0.85 * half, -0.85 * half):
        for tilt in EDGE_TILTS_DEG:
            turned = _turned(come, along, tilt)
            for sign in (1.0, -1.0):
                yield Grasp(edge + shift * along, _frame(turned, sign * np.cross(along, turned)), 2 * thick)


def _around(grip: Grip, opening: float, turning: Floats | None) -> Iterator[Grasp]:
    """Fingers around a knob, or around what is short."""
    # What turns about an upright axis, as on a hob, is taken from above.
    axis = -grip.front if turning is None else turning * (-1.0 if turning @ (grip.front + UP) > 0.0 else 1.0)
    side = _perpendicular(axis, UP)
    for tilt in TILTS_DEG:
        for about in (side, np.cross(axis, side))[: 1 if tilt == 0.0 else 2]:
            come = _turned(axis, about, tilt)
            first = _perpendicular(come, UP)
            for angle in KNOB_ANGLES_DEG:
                close = _turned(first, come, angle)
                width = 2 * float(np.sort(grip.half)[1])
                if width < opening:
                    yield Grasp(_taken(grip, come), _frame(come, close), width)


def _taken(grip: Grip, come: Floats) -> Floats:
    """Where the point between the fingers of a hand is that comes to a grip, shape (3,)."""
    return np.asarray(grip.centre - come * max(0.0, _reach(grip, come) - TAKEN_M))


def _reach(grip: Grip, direction: Floats) -> float:
    """Distance from the centre to the surface of the box along the axis nearest to a direction."""
    return float(grip.half[int(np.argmax(np.abs(direction @ grip.axes)))])


def _turned(vector: Floats, axis: Floats, angle_deg: float) -> Floats:
    return np.asarray(about_axis(axis, math.radians(angle_deg)) @ vector)


def _perpendicular(direction: Floats, wish: Floats) -> Floats:
    """Unit vector at right angles to a direction, level where that is possible."""
    found = np.cross(wish, direction)
    if np.linalg.norm(found) < 1e-6:
        found = np.cross((1.0, 0.0, 0.0), direction)
    return np.asarray(found / np.linalg.norm(found))


def _frame(come: Floats, close: Floats) -> Floats:
    x = close - (close @ come) * come
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(come, x), come], axis=1)
