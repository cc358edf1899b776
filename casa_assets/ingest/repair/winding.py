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
from casa_assets.ingest.repair.components import component_boxes

# Components that are tested for lying within one another, the largest first; a choice.
MAX_NESTED = 64
# An open component is too flat to have an outside if the volume of the cones to its centre, over area and length, is
# below this: leaves of a fruit measure .02 to .03, a single-walled bowl .1.
MIN_CURVATURE = 0.035
# An open patch is turned if so many times more of its samples show only their back than only their front, and they are
# at least this share of all and at least so many; choices.
BACK_TO_FRONT_RATIO = 4.0
MIN_BACK_SHARE = 0.3
MIN_BACK_SAMPLES = 8


def orient_outward(surface: Surface) -> tuple[Ints, Mask]:
    """Turn faces so that each component winds one way, and outwards unless it is the inner wall of another.

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


def _inside_out(points: Floats, ids: Ints, label: Ints, was_turned: Mask, is_open: Mask) -> Mask:
    """(N,) components that are inside out; one within another keeps its direction relative to the outer one.

    An open component that is hardly curved (a leaf, a plate) has no outside: it keeps the direction of most faces.

    Args:
        ids: (F, 3) faces, wound one way. label: (F,) component of each. was_turned: (F,) turned for that.
        is_open: (F,) faces of components that bound no volume.
    """
    corners = points[ids]
    count = int(label.max()) + 1
    lower, upper = component_boxes(corners, label)
    center = np.zeros((count, 3))
    np.add.at(center, label, corners.mean(axis=1))
    center /= np.bincount(label, minlength=count)[:, None]
    # The cones to the centre sum up to the volume of a closed component, and are positive for an open one that faces
    # away from its centre.
    local = corners - center[label][:, None]
    cone_volumes = np.einsum("ij,ij->i", local[:, 0], np.cross(local[:, 1], local[:, 2]))
    volume = np.bincount(label, weights=cone_volumes, minlength=count)
    is_inside_out: Mask = volume < -1e-9 * (upper - lower).max(axis=1) ** 3
    areas = np.bincount(label, weights=np.linalg.norm(_area_vectors(corners), axis=1) / 2, minlength=count)
    is_flat = np.zeros(count, dtype=bool)
    is_flat[label[is_open]] = True
    is_flat &= np.abs(volume) / 6 < MIN_CURVATURE * areas * (upper - lower).max(axis=1)
    is_inside_out[is_flat] = (np.bincount(label, weights=was_turned) > np.bincount(label) / 2)[is_flat]
    if count == 1:
        return is_inside_out
    large = np.argsort(-(upper - lower).prod(axis=1), kind="stable")[:MAX_NESTED]
    hosts = {
        component: [
            k for k in large[:rank] if (lower[k] <= lower[component]).all() and (upper[component] <= upper[k]).all()
        ]
        for rank, component in enumerate(large)
    }
    involved = {
        *(k for found in hosts.values() for k in found),
        *(component for component, found in hosts.items() if found),
    }
    faces_of = {k: ids[label == k] for k in involved}
    closed = {k: is_closed(faces_of[k]) for k in involved}
    for component, found in hosts.items():
        for outer in reversed(found):  # the smallest first
            if closed[outer]:
                is_reversed = (
                    abs(winding_number(points, faces_of[outer], points[faces_of[component][0]].mean(axis=0))) > 0.5
                )
            else:  # an open one is assumed to belong to the other one whose box it lies in
                is_reversed = not closed[component]
            if is_reversed:
                is_inside_out[component] = is_inside_out[outer]
                break
    return is_inside_out


def _area_vectors(corners: Floats) -> Floats:
    vectors: Floats = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return vectors


def _back_to_front(points: Floats, ids: Ints, label: Ints, is_open: Mask) -> Mask:
    """(F,) faces of open patches that show their back to the outside.

    Patches are joined over edges of exactly two faces, since only those pass a direction on.
    """
    none = np.zeros(len(ids), dtype=bool)
    if not is_open.any():
        return none
    patch = manifold_patches(ids)
    lower, upper = component_boxes(points[ids], label)
    is_flat = (upper - lower).min(axis=1) <= 1e-6 * (upper - lower).max(axis=1)
    visibility = measure_visibility(points, ids)
    patch_count = int(patch.max()) + 1
    sample_count = np.bincount(patch[visibility.face], minlength=patch_count)
    front = np.bincount(patch[visibility.face], weights=visibility.front & ~visibility.back, minlength=patch_count)
    back = np.bincount(patch[visibility.face], weights=visibility.back & ~visibility.front, minlength=patch_count)
    shows_back = (
        (back > BACK_TO_FRONT_RATIO * front) & (back >= MIN_BACK_SHARE * sample_count) & (back >= MIN_BACK_SAMPLES)
    )
    is_wrong: Mask = shows_back[patch] & is_open & ~is_flat[label]
    return is_wrong


def _is_open(ids: Ints, label: Ints) -> Mask:
    """(F,) faces of components that bound no volume."""
    edges, uses, balance = edge_counts(ids)
    is_open_edge = (uses != 2) | (balance != 0)
    if not is_open_edge.any():
        return np.zeros(len(ids), dtype=bool)
    of_point = np.zeros(int(ids.max()) + 1, dtype=np.int64)
    of_point[ids.ravel()] = np.repeat(label, 3)
    open_pieces = np.zeros(int(label.max()) + 1, dtype=bool)
    open_pieces[of_point[edges[is_open_edge, 0]]] = True
    is_open: Mask = open_pieces[label]
    return is_open
