"""What slides or turns behind a door: racks, trays and turntables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.articulate.panels import Panel
from casa_assets.articulate.pieces import SIDES, Pieces, face_on
from casa_assets.articulate.plan import Edge
from casa_assets.articulate.soup import Floats

# A rack takes at least this part of the width of its door and is at most this part of its height tall.
LEAST_WIDTH, MOST_HEIGHT = 0.45, 0.5
# Less of it than this part of its surface is seen from outside.
SEEN = 0.02


@dataclass(frozen=True)
class Tray:
    """Something flat behind a door; `round` ones turn."""

    fragments: tuple[int, ...]
    round: bool
    confidence: float
    because: str


def find_trays(pieces: Pieces, side: int, door: Panel, edge: Edge | None, taken: Sequence[int]) -> list[Tray]:
    """Racks behind a door that folds down, and the turntable behind one that swings."""
    low, high = face_on(pieces, side)
    size = high - low
    hidden = pieces.seen.sum(axis=1) <= SEEN * np.maximum(pieces.area, 1e-12)
    free = np.ones(pieces.count, dtype=bool)
    free[list(taken)] = False
    within = (low[:, :2] >= door.low[:2] - 0.03).all(axis=1) & (high[:, :2] <= door.high[:2] + 0.03).all(axis=1)
    behind = low[:, 2] >= door.high[2] - 0.12
    small = size[:, 1] <= MOST_HEIGHT * door.height
    rows = np.flatnonzero(hidden & free & within & behind & small).tolist()
    found = []
    for group in _heaps(low, high, rows):
        across = high[group].max(axis=0) - low[group].min(axis=0)
        if across[0] < LEAST_WIDTH * door.width or across[2] < 0.25 * door.width:
            continue
        if across[1] > 0.6 * min(across[0], across[2]):
            continue
        disc = abs(float(across[0] - across[2])) < 0.03 * float(across[0]) and _is_disc(pieces, side, group)
        if disc and edge is not Edge.BOTTOM:
            found.append(Tray(tuple(group), True, 0.7, "a disc behind a door"))
        elif not disc and edge is Edge.BOTTOM:
            found.append(Tray(tuple(group), False, 0.6, "a level rack behind a door that folds down"))
    return found


def _heaps(low: Floats, high: Floats, rows: list[int], gap: float = 0.004) -> list[list[int]]:
    """Groups of pieces whose boxes touch, each ascending."""
    if not rows:
        return []
    a, b = low[rows], high[rows]
    meet = ((a[:, None] <= b[None] + gap) & (a[None] <= b[:, None] + gap)).all(axis=2)
    _, label = connected_components(coo_matrix(meet), directed=False)
    return [[r for r, k in zip(rows, label.tolist(), strict=True) if k == n] for n in range(int(label.max()) + 1)]


def _is_disc(pieces: Pieces, side: int, group: Sequence[int]) -> bool:
    """Whether the outline seen from above is a circle: its corners are empty."""
    points = pieces.points_of(group) @ SIDES[side][[0, 2]].T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.ptp(points, axis=0).max()) / 2
    return bool(np.linalg.norm(points - middle, axis=1).max() <= 1.06 * radius)
