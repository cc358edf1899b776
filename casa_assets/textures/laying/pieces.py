"""Rasterize placed outlines to a map of pieces: for every pixel its piece and its position on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets.textures.canvas import Canvas, Map

Array = npt.NDArray[np.floating[Any]]
# (u, v) in metres from the middle of the piece -> metres to its nearest edge, positive inside.
Outline = Callable[[Array, Array], Array]
_MARGIN_M = 0.004  # joints are looked up a little beyond the outline


@dataclass(frozen=True)
class PlacedOutline:
    """One piece.

    Attributes:
        x, y: its middle in metres from the upper left corner, y down.
        turn: radians from the picture's axes to its own (clockwise as seen). v runs along the piece, u across.
        half_u, half_v: half of its box, metres.
        outline: its shape.
        sort: number of its shape or orientation, for colours that depend on it.
    """

    x: float
    y: float
    turn: float
    half_u: float
    half_v: float
    outline: Outline
    sort: int = 0


@dataclass(frozen=True)
class PieceMap:
    """The laid surface.

    Attributes:
        owner: (H, W) int32, number of the piece.
        inside_m: (H, W) float32 metres to the nearest edge of the piece; below 0 between pieces.
        u_m, v_m: (H, W) float32 metres from the middle of the piece, v along it.
        turn, sort, x_m, y_m: (N,) of each piece. half_m: (N, 2) half of its box across and along.
    """

    owner: npt.NDArray[np.int32]
    inside_m: Map
    u_m: Map
    v_m: Map
    turn: Array
    sort: npt.NDArray[np.int64]
    x_m: Array
    y_m: Array
    half_m: Array

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.turn)


def raster(places: Sequence[PlacedOutline], canvas: Canvas) -> PieceMap:
    """Draw all places; where two overlap, a pixel goes to the piece in which it lies deeper."""
    owner = np.zeros(canvas.size_px, dtype=np.int32)
    best = np.full(canvas.size_px, -1.0, dtype=np.float32)
    us, vs = np.zeros_like(best), np.zeros_like(best)
    for number, place in enumerate(places):
        rows, columns, dx, dy = window(place, canvas)
        cos, sin = np.float32(np.cos(place.turn)), np.float32(np.sin(place.turn))
        u, v = cos * dx + sin * dy, cos * dy - sin * dx
        inside = place.outline(u, v)
        at = np.ix_(rows, columns)
        deeper = inside > best[at]
        for target, fresh in ((best, inside), (us, u), (vs, v)):
            target[at] = np.where(deeper, fresh, target[at])
        owner[at] = np.where(deeper, number, owner[at])
    return PieceMap(
        owner=owner,
        inside_m=best,
        u_m=us,
        v_m=vs,
        turn=np.array([p.turn for p in places]),
        sort=np.array([p.sort for p in places], dtype=np.int64),
        x_m=np.array([p.x for p in places]),
        y_m=np.array([p.y for p in places]),
        half_m=np.array([(p.half_u, p.half_v) for p in places]),
    )


def window(place: PlacedOutline, canvas: Canvas) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Map, Map]:
    """Rows and columns (wrapped) around a piece, and their distances from its middle: (1, w) and (h, 1)."""
    cos, sin = abs(np.cos(place.turn)), abs(np.sin(place.turn))
    reach_x = place.half_u * cos + place.half_v * sin + _MARGIN_M
    reach_y = place.half_u * sin + place.half_v * cos + _MARGIN_M
    (height, width), (wide, tall) = canvas.size_px, canvas.tile_m

    def span(middle: float, reach: float, size: int, length: float) -> tuple[npt.NDArray[np.int64], Map]:
        pixel = length / size
        first = int(np.floor((middle - reach) / pixel - 0.5))
        last = int(np.ceil((middle + reach) / pixel - 0.5))
        if last - first >= size:  # a piece as long as the picture: once around, with its ends on the border
            first, last = int(np.ceil(middle / pixel - size / 2 - 0.5)), int(np.ceil(middle / pixel + size / 2 - 1.5))
        numbers = np.arange(first, last + 1)
        return numbers % size, ((numbers + 0.5) * pixel - middle).astype(np.float32)

    columns, dx = span(place.x, reach_x, width, wide)
    rows, dy = span(place.y, reach_y, height, tall)
    return rows, columns, dx[None, :], dy[:, None]


def box(half_u: float, half_v: float) -> Outline:
    """A rectangle."""
    return lambda u, v: np.minimum(np.float32(half_u) - np.abs(u), np.float32(half_v) - np.abs(v))


def disc(radius: float) -> Outline:
    """A circle."""
    return lambda u, v: np.float32(radius) - np.hypot(u, v)


def polygon(corners: Sequence[tuple[float, float]]) -> Outline:
    """A convex polygon of (u, v) corners in metres, in either order."""
    points = np.array(corners, dtype=np.float64)
    ahead = np.roll(points, -1, axis=0) - points
    normal = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1)[:, None]
    middle = points.mean(axis=0)
    facing = np.sign(((middle - points) * normal).sum(axis=1))
    normal = normal * facing[:, None]
    offset = (normal * points).sum(axis=1)

    def inside(u: Array, v: Array) -> Array:
        gap = np.float32(normal[0, 0]) * u + np.float32(normal[0, 1]) * v - np.float32(offset[0])
        for (a, b), c in zip(normal[1:], offset[1:], strict=True):
            gap = np.minimum(gap, np.float32(a) * u + np.float32(b) * v - np.float32(c))
        return gap

    return inside


def whole(length_m: float, module_m: float, even: bool = False) -> tuple[int, float]:
    """Number of whole modules in a length, and their true size in metres.

    Raises:
        ValueError: the length is not a whole number of modules, so that pieces would be stretched by over 2 %.
    """
    step = 2 if even else 1
    count = max(step, step * round(length_m / module_m / step))
    true = length_m / count
    if abs(true / module_m - 1.0) > 0.02:
        fits = f"{count * module_m:.4f}"
        raise ValueError(f"{length_m:g} m holds no whole number of modules of {module_m:.4f} m; {fits} m would")
    return count, true
