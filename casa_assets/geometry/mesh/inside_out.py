"""Find closed parts of a mesh that wind inwards."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.topology import edge_counts, face_components

# A closed component is inside out where its volume is below this share of the cube of its longest side: one that is
# flat has no inside, and rounding gives it either sign.
MIN_NEGATIVE_VOLUME = 1e-9


def inside_out_faces(points: Floats, faces: Ints) -> Mask:
    """(F,) which faces are on closed components of negative volume that are not the lining of another one.

    Args:
        points: (P, 3) welded. faces: (F, 3) over them.
    """
    if not len(faces):
        return np.zeros(0, dtype=bool)
    component = face_components(faces, len(points))
    lower, upper, volume = _bounds_and_volumes(points, faces, component)
    least = -MIN_NEGATIVE_VOLUME * (upper - lower).max(axis=1) ** 3
    inverted = np.flatnonzero(_is_closed(faces, component, len(points)) & (volume < least))
    found: Mask = np.isin(component, [k for k in inverted if not _lines_another(lower, upper, int(k))])
    return found


def _bounds_and_volumes(points: Floats, faces: Ints, component: Ints) -> tuple[Floats, Floats, Floats]:
    """(C, 3) lower and (C, 3) upper corner and (C,) signed volume of each component; volumes hold for closed ones."""
    components = int(component.max()) + 1
    corners = points[faces] - points.mean(axis=0)
    lower, upper = np.full((components, 3), np.inf), np.full((components, 3), -np.inf)
    np.minimum.at(lower, component, corners.min(axis=1))
    np.maximum.at(upper, component, corners.max(axis=1))
    tetrahedra = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volume = np.bincount(component, weights=tetrahedra, minlength=components).astype(np.float64)
    return lower, upper, volume


def _is_closed(faces: Ints, component: Ints, points: int) -> Mask:
    """(C,) whether each edge of a component is used by two faces, once each way."""
    of_point = np.zeros(points, dtype=np.int64)
    of_point[faces] = component[:, None]
    ends, uses, balance = edge_counts(faces)
    closed = np.ones(int(component.max()) + 1, dtype=bool)
    closed[of_point[ends[(uses != 2) | (balance != 0), 0]]] = False
    return closed


def _lines_another(lower: Floats, upper: Floats, component: int) -> bool:
    """True if a component lies in the bounds of a larger one: the inner wall of a hollow thing winds inwards."""
    within = (lower <= lower[component]).all(axis=1) & (upper >= upper[component]).all(axis=1)
    larger = (upper - lower).prod(axis=1) > (upper - lower)[component].prod()
    return bool((within & larger).any())
