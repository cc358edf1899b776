"""Wind faces one way, and outwards unless a surface is the inner wall of another."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.measure import winding_number
from casa_assets.geometry.mesh.topology import (
    consistent_winding,
    edge_counts,
    face_components,
    is_closed,
    manifold_patches,
)
from casa_assets.geometry.mesh.visibility import measure_visibility
from casa_assets.ingest.draft import Surface

# So many pieces, the largest, are looked at for being within one another.
MOST_HOLLOW = 64
# Volume of the cones to its middle, over area and length, below which an open piece has no outside: leaves of a fruit
# measure .02 to .03, a single-walled bowl .1.
MIN_CURVATURE = 0.035
# An open patch is turned where so many times more of it shows its back alone than its front alone, and that is at
# least this share of it; of fewer points than these nothing can be said.
BACK_TO_FRONT_RATIO = 4.0
LEAST_SHARE = 0.3
LEAST_SEEN = 8


def orient_outward(surface: Surface) -> tuple[Ints, Mask]:
    """Turn faces so that each piece winds one way, and outwards unless it is the inner wall of another.

    Returns:
        (F, 3) faces over the vertices of the surface; (F,) which were turned.
    """
    ids, turned = consistent_winding(surface.welded_faces)
    points = np.zeros((int(ids.max()) + 1, 3))
    points[surface.welded_faces.ravel()] = surface.vertices[surface.faces.ravel()]
    label = face_components(ids, len(points))
    is_open = _is_open(ids, label)
    inside_out = _inside_out(points, ids, label, turned, is_open)[label]
    turned ^= inside_out
    ids = _flipped(ids, inside_out)
    turned ^= _back_to_front(points, ids, label, is_open)
    return _flipped(surface.faces, turned), turned


def _flipped(faces: Ints, rows: Mask) -> Ints:
    """A copy of the faces in which some run the other way round."""
    out = faces.copy()
    out[rows] = out[rows][:, ::-1]
    return out


def _inside_out(points: Floats, ids: Ints, label: Ints, turned_so_far: Mask, open_: Mask) -> Mask:
    """Faces (F,) of pieces to be turned; a piece within another keeps its direction against that one's.

    An open piece that is hardly curved (a leaf, a plate) has no outside: it keeps the direction that most of it had.
    """
    corners = points[ids]
    count = int(label.max()) + 1
    low, high, middle = np.full((count, 3), np.inf), np.full((count, 3), -np.inf), np.zeros((count, 3))
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    np.add.at(middle, label, corners.mean(axis=1))
    middle /= np.bincount(label, minlength=count)[:, None]
    # Cones to the piece's own middle: the volume of a closed piece, positive for an open one that faces away from it.
    local = corners - middle[label][:, None]
    cones = np.einsum("ij,ij->i", local[:, 0], np.cross(local[:, 1], local[:, 2]))
    volume = np.bincount(label, weights=cones, minlength=count)
    turned: Mask = volume < -1e-9 * (high - low).max(axis=1) ** 3
    areas = np.bincount(label, weights=np.linalg.norm(_area_vectors(corners), axis=1) / 2, minlength=count)
    hardly = np.zeros(count, dtype=bool)
    hardly[label[open_]] = True
    hardly &= np.abs(volume) / 6 < MIN_CURVATURE * areas * (high - low).max(axis=1)
    turned[hardly] = (np.bincount(label, weights=turned_so_far) > np.bincount(label) / 2)[hardly]
    if count == 1:
        return turned
    large = np.argsort(-(high - low).prod(axis=1), kind="stable")[:MOST_HOLLOW]
    hosts = {
        piece: [k for k in large[:rank] if (low[k] <= low[piece]).all() and (high[piece] <= high[k]).all()]
        for rank, piece in enumerate(large)
    }
    named = {*(k for found in hosts.values() for k in found), *(piece for piece, found in hosts.items() if found)}
    own = {k: ids[label == k] for k in named}
    closed = {k: is_closed(own[k]) for k in named}
    for piece, found in hosts.items():
        for host in reversed(found):  # the smallest first
            if closed[host]:
                within = abs(winding_number(points, own[host], points[own[piece][0]].mean(axis=0))) > 0.5
            else:  # of an open piece within the bounds of another one it is taken for granted
                within = not closed[piece]
            if within:
                turned[piece] = turned[host]
                break
    return turned


def _area_vectors(corners: Floats) -> Floats:
    vectors: Floats = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return vectors


def _back_to_front(points: Floats, ids: Ints, label: Ints, open_: Mask) -> Mask:
    """(F,) faces of open patches that plainly show their back to the outside; where all is closed there are none.

    A patch hangs together over edges of two faces: where more meet, the parity of turns says nothing about the rest.
    """
    none = np.zeros(len(ids), dtype=bool)
    if not open_.any():
        return none
    patch = manifold_patches(ids)
    corners = points[ids]
    count = int(label.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    flat = (high - low).min(axis=1) <= 1e-6 * (high - low).max(axis=1)
    found = measure_visibility(points, ids)
    size = int(patch.max()) + 1
    strewn = np.bincount(patch[found.face], minlength=size)
    front = np.bincount(patch[found.face], weights=found.front & ~found.back, minlength=size)
    back = np.bincount(patch[found.face], weights=found.back & ~found.front, minlength=size)
    turned = (back > BACK_TO_FRONT_RATIO * front) & (back >= LEAST_SHARE * strewn) & (back >= LEAST_SEEN)
    wrong: Mask = turned[patch] & open_ & ~flat[label]
    return wrong


def _is_open(ids: Ints, label: Ints) -> Mask:
    """(F,) faces of pieces that bound no volume."""
    edges, uses, balance = edge_counts(ids)
    torn = (uses != 2) | (balance != 0)
    if not torn.any():
        return np.zeros(len(ids), dtype=bool)
    of_point = np.zeros(int(ids.max()) + 1, dtype=np.int64)
    of_point[ids.ravel()] = np.repeat(label, 3)
    open_pieces = np.zeros(int(label.max()) + 1, dtype=bool)
    open_pieces[of_point[edges[torn, 0]]] = True
    found: Mask = open_pieces[label]
    return found
