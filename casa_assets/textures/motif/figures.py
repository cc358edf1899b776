"""Signed figures: distance inside, positive, in the units of the coordinates; and inks from them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.floating[Any]]


def disc(u: Array, v: Array, cu: float, cv: float, radius: float) -> Array:
    """A circle."""
    return np.asarray(radius - np.hypot(u - cu, v - cv))


def ring(u: Array, v: Array, cu: float, cv: float, radius: float, width: float) -> Array:
    """A line around a circle."""
    return np.asarray(width / 2 - np.abs(np.hypot(u - cu, v - cv) - radius))


def square(u: Array, v: Array, half: float) -> Array:
    """An upright square."""
    return np.asarray(half - np.maximum(np.abs(u), np.abs(v)))


def diamond(u: Array, v: Array, half: float) -> Array:
    """A square on a corner; `half` is from its middle to a corner."""
    return np.asarray((half - np.abs(u) - np.abs(v)) / np.sqrt(2.0))


def lens(u: Array, v: Array, cu: float, cv: float, turn: float, length: float, width: float) -> Array:
    """A petal between two arcs, `length` from tip to tip along `turn` (radians)."""
    a = np.cos(turn) * (u - cu) + np.sin(turn) * (v - cv)
    b = np.abs(np.cos(turn) * (v - cv) - np.sin(turn) * (u - cu))
    radius = (length**2 + width**2) / (4.0 * width)
    return np.asarray(radius - np.hypot(a, b + radius - width / 2))


def polar(u: Array, v: Array, folds: int) -> tuple[Array, Array]:
    """Radius, and angle from the middle of the nearest of `folds` equal sectors, radians."""
    bearing, sector = np.arctan2(v, u), 2.0 * np.pi / folds
    return np.hypot(u, v), np.asarray(np.mod(bearing + sector / 2, sector) - sector / 2)


def star(u: Array, v: Array, points: int, outer: float, inner: float, turn: float = 0.0) -> Array:
    """A star of straight edges between an outer and an inner radius."""
    c, s = np.cos(turn), np.sin(turn)
    far, bearing = polar(c * u + s * v, c * v - s * u, points)
    x, y = far * np.cos(bearing), np.abs(far * np.sin(bearing))
    tip = np.array([outer, 0.0])
    notch = inner * np.array([np.cos(np.pi / points), np.sin(np.pi / points)])
    edge = notch - tip
    normal = np.array([edge[1], -edge[0]]) / np.hypot(*edge)
    return np.asarray((tip[0] - x) * normal[0] + (tip[1] - y) * normal[1])


def flower(u: Array, v: Array, petals: int, radius: float, depth: float, turn: float = 0.0) -> Array:
    """A rosette whose rim swings `petals` times by `depth` of the radius."""
    far, bearing = np.hypot(u, v), np.arctan2(v, u) - turn
    rim = radius * (1.0 - depth + depth * np.abs(np.cos(bearing * petals / 2.0)))
    return np.asarray(0.9 * (rim - far))


def folded(u: Array, v: Array) -> tuple[Array, Array]:
    """Both coordinates folded into one eighth: 0 <= second <= first."""
    a, b = np.abs(u), np.abs(v)
    return np.maximum(a, b), np.minimum(a, b)


def ink(depth: Array, soft: float) -> Array:
    """0..1, what a figure covers, its edge as wide as `soft`."""
    return np.asarray(np.clip(depth / max(soft, 1e-6) + 0.5, 0.0, 1.0))
