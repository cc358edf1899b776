"""Seven-segment figures on a display, and signs printed next to keys; all face the front (-y)."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.blocks import box, lathe
from casa_assets.families.kit.solids.solid import Solid, concatenate
from casa_assets.families.kit.solids.sweep import prism

# Bars of each figure: top, upper left, upper right, middle, lower left, lower right, bottom.
SEGMENTS = {
    "0": "1110111",
    "1": "0010010",
    "2": "1011101",
    "3": "1011011",
    "4": "0111010",
    "5": "1101011",
    "6": "1101111",
    "7": "1010010",
    "8": "1111111",
    "9": "1111011",
    "-": "0001000",
}
FIGURE_WIDTH = 0.52  # width of a figure over its height
FIGURE_PITCH = 0.74  # from one figure to the next, over their height
COLON_WIDTH = 0.36  # width of a colon, over the height
INK_THICKNESS = 0.0004  # metres: thickness of what is printed or glows; its back stands free of what is behind it


class KeySign(StrEnum):
    """Sign that is printed on a key."""

    PLUS = "plus"
    MINUS = "minus"
    PLAY = "play"
    STOP = "stop"
    LAMP = "lamp"
    POWER = "power"
    BARS = "bars"


def seven_segment_text(text: str, height: float) -> Solid:
    """A line of figures about the origin, its back in the plane y = 0.

    Args:
        text: of figures, `-` and `:`. height: of a figure, metres.
    Raises:
        KeyError: a character that seven bars do not show.
    """
    t = 0.13 * height
    length = sum(COLON_WIDTH if c == ":" else FIGURE_PITCH for c in text) - (FIGURE_PITCH - FIGURE_WIDTH)
    x = -length * height / 2
    parts: list[Solid] = []
    for c in text:
        if c == ":":
            at = x + (COLON_WIDTH - (FIGURE_PITCH - FIGURE_WIDTH)) * height / 2
            parts += [_ink(t, t, at, sign * 0.2 * height) for sign in (-1, 1)]
            x += COLON_WIDTH * height
            continue
        parts += _figure(SEGMENTS[c], x, height, t)
        x += FIGURE_PITCH * height
    return concatenate(parts)


def _figure(bars: str, x: float, h: float, t: float) -> list[Solid]:
    w = FIGURE_WIDTH * h
    width, height = w - 1.3 * t, h / 2 - 1.15 * t
    lower, upper = -h / 4, h / 4
    places = (
        (width, t, x + w / 2, h / 2 - t / 2),
        (t, height, x + t / 2, upper),
        (t, height, x + w - t / 2, upper),
        (width, t, x + w / 2, 0.0),
        (t, height, x + t / 2, lower),
        (t, height, x + w - t / 2, lower),
        (width, t, x + w / 2, -h / 2 + t / 2),
    )
    return [_ink(*place) for on, place in zip(bars, places, strict=True) if on == "1"]


def key_symbol(kind: KeySign, size: float) -> Solid:
    """A sign about the origin, its back in the plane y = 0, as wide as `size`, metres."""
    t = 0.16 * size
    if kind is KeySign.PLUS:
        return concatenate(
            [_ink(size, t, 0.0, 0.0), _ink(t, 0.42 * size, 0.0, 0.29 * size), _ink(t, 0.42 * size, 0.0, -0.29 * size)]
        )
    if kind is KeySign.MINUS:
        return _ink(size, t, 0.0, 0.0)
    if kind is KeySign.STOP:
        return _ink(0.8 * size, 0.8 * size, 0.0, 0.0)
    if kind is KeySign.BARS:
        return concatenate([_ink(size, t, 0.0, z * size) for z in (-0.32, 0.0, 0.32)])
    if kind is KeySign.PLAY:
        half = size / 2
        wedge = prism(_points((-0.8 * half, -half), (half, 0.0), (-0.8 * half, half)), INK_THICKNESS, 0.0)
        return wedge.rotated("x", math.pi / 2).without_colliders()
    ring = lathe(
        [(0.5 * size - t, 0.0), (0.5 * size, 0.0), (0.5 * size, INK_THICKNESS), (0.5 * size - t, INK_THICKNESS)],
        20,
        closed=True,
    )
    ring = ring.rotated("x", math.pi / 2)
    inner = _ink(t, 0.5 * size, 0.0, 0.0) if kind is KeySign.POWER else _ink(0.3 * size, 0.3 * size, 0.0, 0.0)
    return concatenate([ring, inner])


def _points(*corners: tuple[float, float]) -> Floats:
    return np.array(corners)


def _ink(width: float, height: float, x: float, z: float) -> Solid:
    return box((width, INK_THICKNESS, height), (x, -INK_THICKNESS / 2, z), 0.0).without_colliders()
