"""Group controls that are alike and form one grid or row: a group has one type."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.articulate.controls.controls import Control
from casa_assets.core.typing import Floats, Ints

# Controls are alike where their widths, heights and protrusions differ by at most this share of the larger width.
ALIKE_TOLERANCE = 0.15
# Alike controls belong together up to this distance between their middles, in widths: burner knobs left and right of
# a display stand in one row. Off the row, keys of one pad are nearer to each other.
MAX_ROW_PITCH, MAX_PAD_PITCH = 16.0, 4.0
# Middles within this share of the size of a control are in one row, or one column.
SAME_LINE_SHARE = 0.4


@dataclass(frozen=True)
class ControlGroup:
    """Controls of one size that belong together.

    Attributes:
        members: (N,) ascending indices of controls.
        rows, columns: how many lines their middles form across and upwards.
        pitch: median distance from the middle of a control to that of its nearest neighbour, by its width; 0 of one.
        irregularity: standard deviation of these distances by their mean.
        round_share: share of members whose outline is a circle.
    """

    members: tuple[int, ...]
    rows: int
    columns: int
    pitch: float
    irregularity: float
    round_share: float


def group_controls(controls: Sequence[Control], cell: float = 0.0) -> list[ControlGroup]:
    """Return the groups of the controls of one side; every control is in one, if alone.

    Args:
        cell: edge of the cubes that the object is made of, by which sizes of alike controls may differ; 0 for others.
    """
    if not controls:
        return []
    middle = np.array([c.middle for c in controls])
    size = np.array([[*c.across, c.protrusion] for c in controls])
    width = size[:, :2].max(axis=1)
    larger = np.maximum(width[:, None], width[None])
    tolerance = np.maximum(ALIKE_TOLERANCE * larger, 1.05 * cell)
    alike = (np.abs(size[:, None] - size[None]) <= tolerance[..., None]).all(axis=2)
    away = np.abs(middle[:, None] - middle[None])
    distance = np.linalg.norm(away, axis=2)
    in_line = (away <= SAME_LINE_SHARE * np.maximum(size[:, None, :2], size[None, :, :2])).any(axis=2)
    near = distance <= np.where(in_line, MAX_ROW_PITCH, MAX_PAD_PITCH) * larger
    _, label = connected_components(coo_matrix(alike & near), directed=False)
    return [_group(np.flatnonzero(label == k), controls, middle, size) for k in range(int(label.max()) + 1)]


def _group(rows: Ints, controls: Sequence[Control], middle: Floats, size: Floats) -> ControlGroup:
    """Return the group of some controls."""
    places = middle[rows]
    reach = np.median(size[rows, :2], axis=0)
    distance = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(distance, np.inf)
    nearest = distance.min(axis=1) if len(rows) > 1 else np.zeros(1)
    return ControlGroup(
        members=tuple(rows.tolist()),
        rows=_lines(places[:, 1], SAME_LINE_SHARE * float(reach[1])),
        columns=_lines(places[:, 0], SAME_LINE_SHARE * float(reach[0])),
        pitch=float(np.median(nearest) / reach.max()),
        irregularity=float(nearest.std() / max(float(nearest.mean()), 1e-9)),
        round_share=float(np.mean([controls[i].is_round for i in rows])),
    )


def _lines(values: Floats, gap: float) -> int:
    """Return the number of heaps of values that lie further apart than `gap`."""
    return 1 + int((np.diff(np.sort(values)) > gap).sum())
