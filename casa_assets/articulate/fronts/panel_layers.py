"""Find what moves with a panel though it is hidden: the layers of a door, and bins that hang on its back."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.segment.fragment_measures import SIDES, MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.raster import render_depth

# Depth of layers and bins of a door as a share of the object, and the distance of bins from its edges, diagonals.
MAX_DEPTH_SHARE, MIN_EDGE_DISTANCE = 0.14, 0.008
# A bin that begins so far inside its panel, as a share of the panel's thickness, may be this deep, as a share of the
# object.
BIN_START_SHARE, MAX_BIN_DEPTH_SHARE = 0.25, 0.3
# Layers of a door share its outline within this, diagonals, touch, and fill this share of it, unlike frames.
OUTLINE_TOLERANCE, MIN_LAYER_FILL, MAX_LAYERS = 0.006, 0.8, 3


def find_backing_plates(measured: MeasuredFragments, side: int, panel: Panel, taken: set[int]) -> list[int]:
    """Return plates right behind a panel with its outline, as layers of a door; the panel grows by them."""
    lower, upper = corners_from_side(measured, side)
    depth = float(upper[:, 2].max() - lower[:, 2].min())
    found: list[int] = []
    for _ in range(MAX_LAYERS):
        matches = (np.abs(lower[:, :2] - panel.lower[:2]) < OUTLINE_TOLERANCE).all(axis=1)
        matches &= (np.abs(upper[:, :2] - panel.upper[:2]) < OUTLINE_TOLERANCE).all(axis=1)
        matches &= (np.abs(lower[:, 2] - panel.upper[2]) < OUTLINE_TOLERANCE) & (
            upper[:, 2] - lower[:, 2] < MAX_DEPTH_SHARE * depth
        )
        rows = [i for i in np.flatnonzero(matches).tolist() if i not in taken and i not in found]
        rows = [i for i in rows if _fills(measured, side, i) >= MIN_LAYER_FILL]
        if not rows:
            break
        found += rows
        panel.upper = np.append(panel.upper[:2], upper[rows, 2].max())
    return found


def _fills(measured: MeasuredFragments, side: int, fragment: int) -> float:
    """Return the share of its rectangle that a fragment covers, seen alone."""
    faces = measured.mesh.faces[measured.faces_of([fragment])]
    used, local = np.unique(faces, return_inverse=True)
    return float((render_depth(measured.mesh.points[used], local.reshape(-1, 3), SIDES[side], 48).face >= 0).mean())


def find_door_bins(measured: MeasuredFragments, side: int, panel: Panel, taken: set[int]) -> list[int]:
    """Return fragments that hang on the back of a panel: shallow, hidden, away from its edges, and touching it."""
    lower, upper = corners_from_side(measured, side)
    size = upper - lower
    hidden = measured.visible_area.sum(axis=1) <= 0.02 * np.maximum(measured.area, 1e-12)
    inset = (lower[:, :2] >= panel.lower[:2] + MIN_EDGE_DISTANCE).all(axis=1) & (
        upper[:, :2] <= panel.upper[:2] - MIN_EDGE_DISTANCE
    ).all(axis=1)
    depth = float(upper[:, 2].max() - lower[:, 2].min())
    # A bin that reaches into the panel hangs on it, though it is deep.
    reaches_in = lower[:, 2] <= panel.upper[2] - BIN_START_SHARE * (panel.upper[2] - panel.lower[2])
    max_depth = np.where(reaches_in, MAX_BIN_DEPTH_SHARE, MAX_DEPTH_SHARE) * depth
    hangs = inset & hidden & (lower[:, 2] >= panel.lower[2]) & (size[:, 2] <= max_depth)
    found: list[int] = []
    edge = float(panel.upper[2])
    rows = [i for i in np.flatnonzero(hangs).tolist() if i not in taken]
    while True:
        hosts = [(panel.lower, np.append(panel.upper[:2], edge)), *((lower[i], upper[i]) for i in found)]
        touching = [
            i
            for i in rows
            if i not in found
            and upper[i, 2] <= edge + max_depth[i]
            and any((lower[i] <= b + 0.003).all() and (upper[i] >= a - 0.003).all() for a, b in hosts)
        ]
        if not touching:
            return sorted(found)
        found += touching
