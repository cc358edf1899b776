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
# A component is of similar size to the largest one if its longest side is more than this share of that one's. A handle
# that runs into the wall of a mug is smaller, so it does not count as another object.
SIMILAR_SIZE = 0.8
# With more components than this nothing is tested.
MAX_COMPONENTS = 64
# Most pairs that are tested, of those whose bounding boxes overlap.
MAX_PAIRS = 6
# With more faces than this nothing is tested.
MAX_FACES = 40_000
# The centres of about this many faces of a component are tested.
SAMPLES = 200
# Fewest of them that have to lie inside the other component, and also outside of it. If one mug is pushed half into
# another, 3 % of its surface lies inside the other's walls, which are 4 mm thick.
MIN_INSIDE = 2


def intersecting_components(points: Floats, faces: Ints) -> list[Issue]:
    """One warning (MSH050) if components of similar size intersect, else an empty list.

    Args:
        points: (V, 3), welded. faces: (F, 3).
    """
    if not 0 < len(faces) <= MAX_FACES:
        return []
    component = face_components(faces, len(points))
    count = int(component.max()) + 1
    if not 1 < count <= MAX_COMPONENTS:
        return []
    lower, upper = component_boxes(points[faces], component)
    longest_side = (upper - lower).max(axis=1)
    similar_sized = [int(k) for k in np.flatnonzero(longest_side > SIMILAR_SIZE * longest_side.max())]
    overlapping = [
        (a, b) for a, b in combinations(similar_sized, 2) if (lower[a] < upper[b]).all() and (lower[b] < upper[a]).all()
    ]
    for a, b in overlapping[:MAX_PAIRS]:
        first, second = faces[component == a], faces[component == b]
        if _is_partly_inside(points, first, second) or _is_partly_inside(points, second, first):
            message = "pieces of like size run through each other; give each a file of its own, or unite them"
            return [warning("MSH050", "pieces", message)]
    return []


def _is_partly_inside(points: Floats, faces: Ints, container: Ints) -> bool:
    """True if some of the faces lie inside a closed component, the container, and others outside of it."""
    if not is_closed(container):
        return False
    samples = points[faces[:: max(1, len(faces) // SAMPLES)]].mean(axis=1)
    inside = sum(abs(winding_number(points, container, spot)) > 0.5 for spot in samples)
    return MIN_INSIDE <= inside <= len(samples) - MIN_INSIDE
