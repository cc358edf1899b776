"""Find components of similar size that intersect: two objects in one file, or volume that would count twice."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import winding_number
from casa_assets.geometry.mesh.topology import face_components, is_closed
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.components import component_boxes
from casa_assets.model.issue import Issue

# All numbers below are choices.
# Smallest size of a component, as a share of the largest one, to be another object: a handle let into a mug is not.
SIMILAR_SIZE = 0.8
# With more components, or faces, nothing is tested; of the pairs whose boxes overlap so many are.
MAX_COMPONENTS = 64
MAX_PAIRS = 6
MAX_FACES = 40_000
# Samples on a component, and how many have to lie inside the other one, and outside of it. If a mug is pushed half into
# another, 3 % of its surface lies in the walls of 4 mm.
SAMPLES = 200
MIN_INSIDE = 2


def intersecting_parts(points: Floats, ids: Ints) -> list[Issue]:
    """A note if components of similar size intersect.

    Args:
        points: (V, 3), welded. ids: (F, 3).
    """
    if not 0 < len(ids) <= MAX_FACES:
        return []
    label = face_components(ids, len(points))
    count = int(label.max()) + 1
    if not 1 < count <= MAX_COMPONENTS:
        return []
    lower, upper = component_boxes(points[ids], label)
    longest_side = (upper - lower).max(axis=1)
    large = [int(k) for k in np.flatnonzero(longest_side > SIMILAR_SIZE * longest_side.max())]
    overlapping = [
        (a, b) for a, b in combinations(large, 2) if (lower[a] < upper[b]).all() and (lower[b] < upper[a]).all()
    ]
    for a, b in overlapping[:MAX_PAIRS]:
        if _intersect(points, ids[label == a], ids[label == b]) or _intersect(points, ids[label == b], ids[label == a]):
            message = "pieces of like size run through each other; give each a file of its own, or unite them"
            return [warning("MSH050", "pieces", message)]
    return []


def _intersect(points: Floats, faces: Ints, other_faces: Ints) -> bool:
    """True if some of the faces lie inside a closed component, and others outside of it."""
    if not is_closed(other_faces):
        return False
    samples = points[faces[:: max(1, len(faces) // SAMPLES)]].mean(axis=1)
    inside = sum(abs(winding_number(points, other_faces, spot)) > 0.5 for spot in samples)
    return MIN_INSIDE <= inside <= len(samples) - MIN_INSIDE
