"""Find pieces of like size that run through each other: two things in one file, or matter counted twice."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import winding_number
from casa_assets.geometry.mesh.topology import face_components, is_closed
from casa_assets.ingest.draft import warning
from casa_assets.model.issue import Issue

# A handle is let into a mug by its maker; what is as large as the thing itself is another thing.
LIKE_SIZE = 0.8
MOST_PIECES = 64
MOST_PAIRS = 6
MOST_FACES = 40_000
SAMPLES_PER_PIECE = 200  # of each piece; walls of 4 mm hold 3 % of a mug that was pushed half into another
LEAST_INSIDE = 2


def intersecting_parts(points: Floats, ids: Ints) -> list[Issue]:
    """Remark on pieces of like size that run through each other.

    Args:
        points: (V, 3), welded. ids: (F, 3).
    """
    if not 0 < len(ids) <= MOST_FACES:
        return []
    label = face_components(ids, len(points))
    count = int(label.max()) + 1
    if not 1 < count <= MOST_PIECES:
        return []
    corners = points[ids]
    low = np.array([corners[label == k].min(axis=(0, 1)) for k in range(count)])
    high = np.array([corners[label == k].max(axis=(0, 1)) for k in range(count)])
    size = (high - low).max(axis=1)
    large = [int(k) for k in np.flatnonzero(size > LIKE_SIZE * size.max())]
    meet = [(a, b) for a, b in combinations(large, 2) if (low[a] < high[b]).all() and (low[b] < high[a]).all()]
    for a, b in meet[:MOST_PAIRS]:
        if _cross(points, ids[label == a], ids[label == b]) or _cross(points, ids[label == b], ids[label == a]):
            message = "pieces of like size run through each other; give each a file of its own, or unite them"
            return [warning("MSH050", "pieces", message)]
    return []


def _cross(points: Floats, one: Ints, host: Ints) -> bool:
    """True where one part of a piece lies inside the other piece, and another part outside."""
    if not is_closed(host):
        return False
    spots = points[one[:: max(1, len(one) // SAMPLES_PER_PIECE)]].mean(axis=1)
    inside = sum(abs(winding_number(points, host, spot)) > 0.5 for spot in spots)
    return LEAST_INSIDE <= inside <= len(spots) - LEAST_INSIDE
