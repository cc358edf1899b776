"""Find the faces of a link that its maker modelled twice, once for each side, and those that are copies of another.

Two faces over the same three points fight for each pixel in renderers that draw backs, and shade each other's vertices.
Both sides stay, since it is not known for every sheet which of them is visible; the second is drawn a hair off the
first, towards the side that it faces, so that each hides the other from its own side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.topology import merge_rows

Bools = npt.NDArray[np.bool_]

# Distance between the two sides of a sheet, metres: more than the depth of an image resolves at the length of a room,
# less than is seen. A choice.
SHEET_GAP_M = 0.0002


@dataclass(frozen=True)
class DrawnFaces:
    """Faces of a link that are drawn; what is in neither is a copy of another face.

    Attributes:
        front: (F,) drawn where they are. second: (F,) second sides of sheets, drawn SHEET_GAP_M along their normals.
    """

    front: Bools
    second: Bools


def drawn_faces(faces: Ints) -> DrawnFaces:
    """Return which faces of a link are drawn, of those on the same three points the first of each side.

    Args:
        faces: (F, 3) welded, of the link alone, all with some area.
    """
    rows = np.arange(len(faces))
    none = np.zeros(len(faces), dtype=bool)
    if not len(faces):
        return DrawnFaces(none, none.copy())
    _, triangle = merge_rows(np.sort(faces, axis=1).astype(np.float64))
    start = np.argmin(faces, axis=1)
    turns_left = faces[rows, (start + 1) % 3] < faces[rows, (start + 2) % 3]
    is_first = _is_first(triangle)
    return DrawnFaces(is_first, _is_first(2 * triangle + turns_left) & ~is_first)


def corner_directions(faces: Ints, normals: Floats) -> Floats:
    """Return (F, 3, 3) how far each corner goes so that all faces at it move by 1 along their normals, and stay joined.

    At sharp edges it goes no farther than twice that.

    Args:
        faces: (F, 3). normals: (F, 3) unit.
    """
    used, corner = np.unique(faces, return_inverse=True)
    corner = corner.reshape(-1)
    mean = np.zeros((len(used), 3))
    np.add.at(mean, corner, np.repeat(normals, 3, axis=0))
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12)
    least = np.ones(len(used))
    np.minimum.at(least, corner, np.einsum("ij,ij->i", mean[corner], np.repeat(normals, 3, axis=0)))
    found: Floats = (mean / np.maximum(least, 0.5)[:, None])[corner].reshape(-1, 3, 3)
    return found


def _is_first(group: Ints) -> Bools:
    """Return whether each row is the first of its group."""
    _, first = np.unique(group, return_index=True)
    found = np.zeros(len(group), dtype=bool)
    found[first] = True
    return found
