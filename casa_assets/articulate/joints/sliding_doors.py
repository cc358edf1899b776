"""Detect sliding doors: a door in a niche wider than itself, with its handle where a hinge would not want it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.joints.front_view import PanelHandle
from casa_assets.articulate.segment.fragment_measures import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.raster import DepthImage
from casa_assets.core.typing import Floats

# Beside a sliding door the niche is open for this share of its width, and this much deeper than the door, diagonals.
MIN_OPEN_SHARE, MIN_NICHE_DEPTH = 0.85, 0.02
# The rail that it slides on lies at most this far behind the door, diagonals.
FRAME_TOLERANCE = 0.006
# Distance of the handle from the edge that a hinged door would open at, by the width.
MIN_HANDLE_OFFSET = 0.3


def sliding_direction(measured: MeasuredFragments, side: int, panel: Panel, grip: PanelHandle | None) -> float | None:
    """Return 1 for a door that slides to the right, -1 to the left, None for one that does not slide.

    Args:
        grip: its handle; a door without one is not taken for a sliding one.
    """
    if grip is None:
        return None
    lower, upper = corners_from_side(measured, side)
    image, near = measured.depth_images[side], float(lower[:, 2].min())
    margin = 4 * image.pixel
    inset = 0.1 * panel.height
    frame = [
        _depths(image, (panel.lower[0], panel.upper[1]), (panel.upper[0], panel.upper[1] + margin)),
        _depths(image, (panel.lower[0], panel.lower[1] - margin), (panel.upper[0], panel.lower[1])),
    ]
    if all(float((f + near <= panel.lower[2] + FRAME_TOLERANCE).mean()) < 0.4 for f in frame):
        return None
    for sign in (1.0, -1.0):
        edge = float(panel.upper[0] if sign > 0 else panel.lower[0])
        far = edge + sign * MIN_OPEN_SHARE * panel.width
        if not float(lower[:, 0].min()) <= far <= float(upper[:, 0].max()):
            continue
        a, b = sorted((edge + sign * margin, far))
        beside = _depths(image, (a, panel.lower[1] + inset), (b, panel.upper[1] - inset))
        clear = float((np.isfinite(beside) & (beside + near > panel.upper[2] + MIN_NICHE_DEPTH)).mean())
        place = float(grip.middle[0]) if sign < 0 else 1.0 - float(grip.middle[0])
        if clear >= 0.95 and place >= MIN_HANDLE_OFFSET:
            return sign
    return None


def _depths(image: DepthImage, lower: tuple[Any, Any], upper: tuple[Any, Any]) -> npt.NDArray[np.float64]:
    """Return the depths of the pixels of a rectangle in (u, v)."""
    corners: Floats = np.array([lower, upper], dtype=np.float64)
    row, column = image.rows_columns(corners)
    return image.depth[row[1] : row[0] + 1, column[0] : column[1] + 1]
