"""Faces that are broken: degenerate, duplicate, more than two at an edge, or wound the wrong way."""

from __future__ import annotations

import numpy as np

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.ingest.draft import Draft, Surface, warning
from casa_assets.ingest.repair.gaps import close_holes
from casa_assets.ingest.texture import submesh
from casa_assets.mesh.surface import face_normals, winding_number
from casa_assets.mesh.topology import (
    component_boxes,
    consistent_winding,
    edge_counts,
    face_components,
    faces_with,
    is_closed,
    manifold_patches,
)
from casa_assets.mesh.visibility import measure_visibility
from casa_assets.model.issue import Issue
from casa_assets.model.source import RawPart

# Degenerate faces -----------------------------------------------------------------------------------------------------
# Find degenerate and duplicate faces.

# A face is degenerate if its area is below the square of this share of the longest side; a choice.
MIN_HEIGHT = 1e-7
# Reversed twins are dropped if without them this share of the edges has exactly two faces; a choice.
MOSTLY_CLOSED_SHARE = 0.98


def valid_faces(vertices: Floats, faces: Ints, place: Ints) -> Mask:
    """(F,) True for faces to keep: with an area, each once; of faces and reversed twins one where that closes the mesh.

    `place`: (V,) welded point of each vertex.
    """
    ids = place[faces]
    _, area = face_normals(vertices, faces)
    extent = float(np.ptp(vertices, axis=0).max()) or 1.0
    a, b, c = ids.T
    keep: Mask = (area > (extent * MIN_HEIGHT) ** 2) & (a != b) & (b != c) & (c != a)
    start = np.argmin(ids, axis=1)
    rotated = np.stack([ids[np.arange(len(ids)), (start + k) % 3] for k in range(3)], axis=1)
    keep &= _first_of_each(rotated, keep)
    without_twins: Mask = keep & _first_of_each(np.sort(ids, axis=1), keep)
    if without_twins.sum() < keep.sum():
        _, uses, _ = edge_counts(ids[without_twins])
        if (uses == 2).mean() > MOSTLY_CLOSED_SHARE:
            return without_twins
    return keep


def _first_of_each(keys: Ints, mask: Mask) -> Mask:
    index = np.flatnonzero(mask)
    is_first = np.zeros(len(keys), dtype=bool)
    if len(index):
        _, first = np.unique(keys[index], axis=0, return_index=True)
        is_first[index[first]] = True
    return is_first


# Nonmanifold ----------------------------------------------------------------------------------------------------------
# Remove faces at edges where more than two meet: fins that stick out of a closed surface, and tangles.

# Meshes with a larger share, or number, of nonmanifold edges are built that way and are left as they are; choices.
MAX_NONMANIFOLD_SHARE = 0.005
MAX_NONMANIFOLD_EDGES = 400
# Cutting out faces may expose further nonmanifold edges, which are cut out in turn.
MAX_ROUNDS = 3
# A patch of more faces than these is meant: a leaf, a strap, a label that stands off.
MAX_FIN_FACES = 2


def cut_nonmanifold_faces(draft: Draft) -> Draft:
    """Cut out nonmanifold faces and close the holes; only holes are closed where that would not halve unsound edges."""
    closed = close_holes(draft)
    _, uses, _ = edge_counts(closed.surface.welded_faces)
    if not 0 < int((uses > 2).sum()) <= min(MAX_NONMANIFOLD_EDGES, MAX_NONMANIFOLD_SHARE * len(uses)):
        return closed
    before = int((uses != 2).sum())
    remaining, cut_corners = draft, []
    for _ in range(MAX_ROUNDS):
        bad = _touching(remaining.surface.welded_faces)
        if not bad.any():
            break
        if bad.all():
            return closed
        cut_corners.append(remaining.surface.vertices[remaining.surface.faces[bad]].reshape(-1, 3))
        remaining = remaining.replace(parts=_without(remaining.parts, bad))
    closed = close_holes(remaining, np.concatenate(cut_corners))
    after = int((edge_counts(closed.surface.welded_faces)[1] != 2).sum())
    if after * 2 > before:
        return closed
    message = f"{before} unsound edges became {after}: the faces around tangled ones were cut out and closed anew"
    return closed.replace(notes=draft.noted(warning("MSH045", "edges", message)))


def _touching(ids: Ints) -> Mask:
    """(F,) faces at the ends of nonmanifold edges, and where boundary loops touch, so that simple holes are left."""
    edges, uses, _ = edge_counts(ids)
    count = int(ids.max()) + 1
    ends: Mask = np.bincount(edges[uses == 1].ravel(), minlength=count) > 2
    ends[edges[uses > 2].ravel()] = True
    found: Mask = np.any(ends[ids], axis=1)
    return found


def _without(parts: tuple[RawPart, ...], bad: Mask) -> tuple[RawPart, ...]:
    out, start = [], 0
    for part in parts:
        rows = bad[start : start + len(part.mesh.faces)]
        start += len(part.mesh.faces)
        if not rows.all():
            mesh = submesh(part.mesh, part.mesh.faces[~rows].astype(np.int64)) if rows.any() else part.mesh
            out.append(part.replace(mesh=mesh))
    return tuple(out)


def sheet_fins(ids: Ints) -> tuple[Mask, list[Issue]]:
    """(F,) True for fins, a few faces that hang by an edge on a closed surface, and a note if any were found.

    No face counts as a fin if the rest would stay open: then a single face may be all that is left of a wall.
    """
    none = np.zeros(len(ids), dtype=bool)
    _, uses, _ = edge_counts(ids)
    if not len(ids) or not (uses > 2).any() or not (uses == 1).any():
        return none, []
    patch = manifold_patches(ids)
    small = np.bincount(patch)[patch] <= MAX_FIN_FACES
    stands, hangs = (np.isin(patch, patch[faces_with(ids, mask)]) for mask in (uses == 1, uses > 2))
    is_fin = small & stands & hangs
    if not is_fin.any() or is_fin.all() or (edge_counts(ids[~is_fin])[1] != 2).any():
        return none, []
    count = int(is_fin.sum())
    subject = f"{count} faces that stood off a closed surface like fins were"
    if count == 1:
        subject = "1 face that stood off a closed surface like a fin was"
    return is_fin, [warning("MSH046", "faces", f"{subject} taken away")]


# Winding --------------------------------------------------------------------------------------------------------------
# Wind faces one way, and outwards unless a surface is the inner wall of another.

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
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.bincount(label, weights=np.linalg.norm(cross, axis=1) / 2, minlength=count)
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
    involved = {k for component, found in hosts.items() if found for k in (component, *found)}
    faces_of = {k: ids[label == k] for k in involved}
    closed = {k: is_closed(faces_of[k]) for k in involved}
    for component, found in hosts.items():
        for outer in reversed(found):  # the smallest first
            if closed[outer]:
                middle = points[faces_of[component][0]].mean(axis=0)
                is_reversed = abs(winding_number(points, faces_of[outer], middle)) > 0.5
            else:  # an open one is assumed to belong to the other one whose box it lies in
                is_reversed = not closed[component]
            if is_reversed:
                is_inside_out[component] = is_inside_out[outer]
                break
    return is_inside_out


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
    patch_count, patch_of_sample = int(patch.max()) + 1, patch[visibility.face]
    sample_count = np.bincount(patch_of_sample, minlength=patch_count)
    front = np.bincount(patch_of_sample, weights=visibility.front & ~visibility.back, minlength=patch_count)
    back = np.bincount(patch_of_sample, weights=visibility.back & ~visibility.front, minlength=patch_count)
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
