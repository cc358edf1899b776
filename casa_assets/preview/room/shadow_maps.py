"""Depth maps of what throws shadows, seen from afar along a direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Singles
from casa_assets.preview import renderer

_BEYOND_M, _NEAR_M = 0.5, 0.1  # between the eye of a map and what it sees, and where it begins to see
_STEPS = 65535


@dataclass(frozen=True)
class ShadowMap:
    """How far things reach towards a light that is far away.

    Attributes:
        right, up, towards: (3,) unit vectors, world frame; `towards` points to the light.
        corner: (2,) least coordinates along right and up, metres. pixel: width of a pixel, metres.
        heights: (S, S) greatest coordinate along `towards` in each pixel; rows go up.
        least, step: coordinate that 0 stands for, and one step, metres.
    """

    right: Singles
    up: Singles
    towards: Singles
    corner: tuple[float, float]
    pixel: float
    heights: npt.NDArray[np.uint16]
    least: float
    step: float

    def above(self, x: Singles, y: Singles) -> Singles:
        """Heights at (N,) coordinates along right and up, metres; the nearest pixel's."""
        side = len(self.heights)
        scale = np.float32(1.0 / self.pixel)
        column = ((x - np.float32(self.corner[0])) * scale).astype(np.int32)
        row = ((y - np.float32(self.corner[1])) * scale).astype(np.int32)
        np.clip(column, 0, side - 1, out=column)
        np.clip(row, 0, side - 1, out=row)
        row *= side
        row += column
        found = self.heights.ravel()[row].astype(np.float32)
        found *= np.float32(self.step)
        found += np.float32(self.least)
        return found


def draw_shadow_map(canvas: renderer.Canvas, scene: Any, towards: Floats, corners: Floats, size_px: int) -> ShadowMap:
    """Draw the map of a direction.

    Args:
        scene: MjvScene of what throws shadows, without lights.
        towards: (3,) unit vector to the light, world frame.
        corners: (8, 3) of the box round all that throws shadows, metres.
        size_px: side of the map.
    """
    side = np.cross((0.0, 0.0, 1.0), towards) if abs(towards[2]) < 0.99 else np.array([1.0, 0.0, 0.0])
    right = side / np.linalg.norm(side)
    up = np.cross(towards, right)
    x, y, z = corners @ right, corners @ up, corners @ towards
    # A pixel of margin all round, so that what lies beyond the map meets nothing at its edge.
    half = max(np.ptp(x), np.ptp(y)) / 2.0 * (1.0 + 4.0 / size_px)
    middle = ((x.min() + x.max()) / 2.0, (y.min() + y.max()) / 2.0)
    top, deep = float(z.max()) + _BEYOND_M, float(np.ptp(z)) + 2.0 * _BEYOND_M
    for eye in scene.camera:
        eye.pos, eye.forward, eye.up = middle[0] * right + middle[1] * up + top * towards, -towards, up
        eye.orthographic, eye.frustum_near, eye.frustum_far = 1, _NEAR_M, deep
        eye.frustum_center, eye.frustum_width = 0.0, half
        eye.frustum_bottom, eye.frustum_top = -half, half
    depth = canvas.draw_depth(scene, size_px, size_px)
    return ShadowMap(
        right=right.astype(np.float32),
        up=up.astype(np.float32),
        towards=towards.astype(np.float32),
        corner=(middle[0] - half, middle[1] - half),
        pixel=2.0 * half / size_px,
        # Two bytes are enough, and all maps of a scene are kept for its other cameras.
        heights=np.rint((np.float32(1.0) - depth) * np.float32(_STEPS)).astype(np.uint16),
        least=top - deep,
        step=(deep - _NEAR_M) / _STEPS,
    )
