"""Find degenerate and duplicate faces."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import edge_counts

# A height of a face below this part of the longest side is none.
NO_HEIGHT = 1e-7
# Reversed twins go where this share of the edges is used twice without them.
MOSTLY_CLOSED_SHARE = 0.98


def valid_faces(vertices: Floats, faces: Ints, place: Ints) -> Mask:
    """(F,) True for faces with an area, each set of three points once; reversed twins go where that closes it.

    Args:
        vertices: (V, 3). faces: (F, 3). place: (V,) the welded point of each vertex.
    """
    ids = place[faces]
    _, area = face_normals(vertices, faces)
    extent = float(np.ptp(vertices, axis=0).max()) or 1.0
    keep = (
        (area > (extent * NO_HEIGHT) ** 2)
        & (ids[:, 0] != ids[:, 1])
        & (ids[:, 1] != ids[:, 2])
        & (ids[:, 2] != ids[:, 0])
    )
    start = np.argmin(ids, axis=1)
    turned = np.stack([ids[np.arange(len(ids)), (start + k) % 3] for k in range(3)], axis=1)
    keep &= _first_of_each(turned, keep)
    unturned = _first_of_each(np.sort(ids, axis=1), keep)
    single = keep & unturned
    fewer: Mask = single if single.sum() < keep.sum() and _mostly_closed(ids[single]) else keep
    return fewer


def _first_of_each(keys: Ints, among: Mask) -> Mask:
    index = np.flatnonzero(among)
    out = np.zeros(len(keys), dtype=bool)
    if len(index):
        _, first = np.unique(keys[index], axis=0, return_index=True)
        out[index[first]] = True
    return out


def _mostly_closed(ids: Ints) -> bool:
    _, uses, _ = edge_counts(ids)
    return bool((uses == 2).mean() > MOSTLY_CLOSED_SHARE)
