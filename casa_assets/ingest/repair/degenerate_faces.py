"""Find degenerate and duplicate faces."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import edge_counts

# A face is degenerate if its area is below the square of this share of the longest side; a choice.
MIN_HEIGHT = 1e-7
# Reversed twins are dropped if without them this share of the edges has exactly two faces; a choice.
MOSTLY_CLOSED_SHARE = 0.98


def valid_faces(vertices: Floats, faces: Ints, place: Ints) -> Mask:
    """(F,) True for faces to keep: with an area, each once; of faces and reversed twins one where that closes the mesh.

    Args:
        vertices: (V, 3). faces: (F, 3). place: (V,) the welded point of each vertex.
    """
    ids = place[faces]
    _, area = face_normals(vertices, faces)
    extent = float(np.ptp(vertices, axis=0).max()) or 1.0
    keep = (
        (area > (extent * MIN_HEIGHT) ** 2)
        & (ids[:, 0] != ids[:, 1])
        & (ids[:, 1] != ids[:, 2])
        & (ids[:, 2] != ids[:, 0])
    )
    start = np.argmin(ids, axis=1)
    rotated = np.stack([ids[np.arange(len(ids)), (start + k) % 3] for k in range(3)], axis=1)
    keep &= _first_of_each(rotated, keep)
    is_first_unordered = _first_of_each(np.sort(ids, axis=1), keep)
    without_twins = keep & is_first_unordered
    kept: Mask = without_twins if without_twins.sum() < keep.sum() and _mostly_closed(ids[without_twins]) else keep
    return kept


def _first_of_each(keys: Ints, mask: Mask) -> Mask:
    index = np.flatnonzero(mask)
    is_first = np.zeros(len(keys), dtype=bool)
    if len(index):
        _, first = np.unique(keys[index], axis=0, return_index=True)
        is_first[index[first]] = True
    return is_first


def _mostly_closed(ids: Ints) -> bool:
    _, uses, _ = edge_counts(ids)
    return bool((uses == 2).mean() > MOSTLY_CLOSED_SHARE)
