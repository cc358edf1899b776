"""Stage `clean`: drop faulty and foreign faces, close small gaps, turn surfaces outwards."""

from __future__ import annotations

import numpy as np

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.errors import Rejected
from casa_assets.ingest.components import (
    enclosed_parts,
    foreign_parts,
    intersecting_components,
    is_transparent,
    separate_objects,
    solidity,
    split_components,
)
from casa_assets.ingest.draft import Draft, Surface, keep_faces, submesh, warning
from casa_assets.ingest.gaps import close_cracks, close_holes, close_missing_sides, split_t_junctions
from casa_assets.mesh.solid.deviation import measure_visibility
from casa_assets.mesh.surface import (
    backward_share,
    closed_components,
    component_boxes,
    consistent_winding,
    edge_counts,
    face_components,
    face_normals,
    faces_with,
    is_closed,
    manifold_patches,
    winding_number,
)
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill
from casa_assets.model.source import RawModel, RawPart

# Share of a mesh's area whose normals may look backwards; smoothing over sharp edges turns up to 0.6 %.
MAX_BACKWARD_SHARE = 0.01
# Normals within half a degree of the plane of their face count as backwards: rounding moves them to either side.
LEAST_COSINE = 0.01
# A face is degenerate if its area is below the square of this share of the longest side; a choice.
MIN_HEIGHT = 1e-7
# Reversed twins are dropped if without them this share of the edges has exactly two faces; a choice.
MOSTLY_CLOSED_SHARE = 0.98
# Meshes with a larger share, or number, of nonmanifold edges are built that way and are left as they are; choices.
MAX_NONMANIFOLD_SHARE, MAX_NONMANIFOLD_EDGES = 0.005, 400
# Cutting out faces may expose further nonmanifold edges, which are cut out in turn.
MAX_ROUNDS = 3
# A patch of more faces than these is meant: a leaf, a strap, a label that stands off.
MAX_FIN_FACES = 2
# Components that are tested for lying within one another, the largest first; a choice.
MAX_NESTED = 64
# An open component is too flat to have an outside if the volume of the cones to its centre, over area and length, is
# below this: leaves of a fruit measure .02 to .03, a single-walled bowl .1.
MIN_CURVATURE = 0.035
# An open patch is turned if this many times more of its samples show only their back than only their front, and they
# are at least this share of all and at least this many; choices.
BACK_TO_FRONT_RATIO = 4.0
MIN_BACK_SHARE = 0.3
MIN_BACK_SAMPLES = 8


def clean(model: RawModel, category: Category | None = None) -> Draft:
    """Repair what can be repaired without changing the looks; a sound mesh stays as it is.

    The proportions of the category distinguish a pedestal from a foot; its build says whether the inside is solid.
    Raises Rejected: no faces are left (MSH001), or the remaining surface is flat (MSH002).
    """
    draft = Draft(
        parts=model.parts, metres_per_unit=model.metres_per_unit, up=model.up, format=model.format, notes=model.notes
    )
    if not len(draft.surface.faces):
        raise Rejected("MSH001", "there are no faces; export a surface, not points or lines")
    draft = _without_bad_faces(draft, category)
    draft = split_t_junctions(draft)
    draft = _wound_outward(draft)
    draft = _without_wrong_normals(draft)
    draft = cut_nonmanifold_faces(draft)
    cloud = draft.surface.vertices
    if len(cloud) < 4:
        spread = np.linalg.svd(cloud - cloud.mean(axis=0), compute_uv=False)
    else:
        spread = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(cloud.T))[::-1], 0))
    if spread[0] <= 0 or spread[-1] < 1e-4 * spread[0]:
        raise Rejected("MSH002", "all faces lie in one plane or on one line; a thing that is handled needs a thickness")
    is_full = category is not None and category.build in (MatterFill.SOLID, MatterFill.FILLED)
    if category is not None and is_full and category.id != FALLBACK:
        draft = close_missing_sides(draft)
    return _measured(draft, is_full)


def _without_bad_faces(draft: Draft, category: Category | None) -> Draft:
    """Leave out degenerate and duplicate faces and what is no part of the object; close cracks in the rest."""
    surface = draft.surface
    unused = np.ones(len(surface.vertices), dtype=bool)
    unused[surface.faces.ravel()] = False
    if unused.any():  # moved to one that is used: they must not coarsen the welding grid
        used = surface.vertices[surface.faces[0, 0]]
        surface = Surface(np.where(unused[:, None], used, surface.vertices), surface.faces)
    keep = valid_faces(surface.vertices, surface.faces, surface.point_of_vertex)
    notes = []
    if not keep.all():
        message = f"{int((~keep).sum())} of {len(keep)} faces were degenerate or doubled and were dropped"
        notes.append(warning("MSH010", "faces", message))
    keep, found = _without_extras(surface, keep, category)
    notes += found
    if not keep.any():
        raise Rejected("MSH001", "no face with an area is left; the file holds only points, lines or slivers")
    vertices, found = close_cracks(surface, keep)
    parts = _parts(draft, vertices, surface.faces, keep, np.zeros(len(keep), dtype=bool))
    return draft.replace(parts=parts, notes=draft.noted(*notes, *found))


def _wound_outward(draft: Draft) -> Draft:
    """The parts wound outwards, without what is sealed up in others."""
    surface = draft.surface
    faces, turned = orient_outward(surface)
    notes = []
    if turned.any():
        message = f"{int(turned.sum())} faces ({turned.mean():.0%}) were turned to face outwards"
        notes.append(warning("MSH011", "winding", message))
    components = split_components(surface.vertices, faces, surface.point_of_vertex)
    see_through = np.repeat([is_transparent(p) for p in draft.parts], [len(p.mesh.faces) for p in draft.parts])
    sealed, more = enclosed_parts(components, see_through)
    parts = _parts(draft, surface.vertices, faces, ~sealed[components.label], turned)
    return draft.replace(parts=parts, notes=draft.noted(*notes, *more))


def _without_wrong_normals(draft: Draft) -> Draft:
    """The parts, wound outwards, without normals that contradict the faces; those are computed again later."""
    wrong = [
        mesh.normals is not None
        and backward_share(mesh.vertices, mesh.faces, mesh.normals, LEAST_COSINE) > MAX_BACKWARD_SHARE
        for mesh in (part.mesh for part in draft.parts)
    ]
    if not any(wrong):
        return draft
    parts = tuple(
        part.replace(mesh=part.mesh.with_vertices(part.mesh.vertices, None)) if is_wrong else part
        for part, is_wrong in zip(draft.parts, wrong, strict=True)
    )
    message = f"normals of {sum(wrong)} of {len(wrong)} meshes looked against their faces and are computed anew"
    return draft.replace(parts=parts, notes=draft.noted(warning("MSH025", "normals", message)))


def _measured(draft: Draft, full: bool) -> Draft:
    points, faces = draft.surface.points, draft.surface.welded_faces
    found = solidity(points, faces, full)
    guesses = draft.guessed("solidity", found.kind.value, found.confidence, found.message)
    _, uses, _ = edge_counts(faces)
    unsound = []
    if (uses == 1).any():
        message = f"{int((uses == 1).sum())} edges have a face on one side only; the mesh is not watertight"
        unsound.append(warning("MSH022", "edges", message))
    if (uses > 2).any():
        message = f"{int((uses > 2).sum())} edges are shared by more than two faces; the mesh is no manifold"
        unsound.append(warning("MSH023", "edges", message))
    notes = draft.noted(*unsound, *intersecting_components(points, faces))
    return draft.replace(guesses=guesses, notes=notes)


def _without_extras(surface: Surface, keep: Mask, category: Category | None) -> tuple[Mask, list[Issue]]:
    """Leave out what is no part of the object, with notes on that and on several objects in one file."""
    index = np.flatnonzero(keep)
    if not len(index):
        return keep, []
    components = split_components(surface.vertices, surface.faces[index], surface.point_of_vertex)
    extra, notes = foreign_parts(components, category)
    out = keep.copy()
    out[index[extra[components.label]]] = False
    rest = np.flatnonzero(out)
    fins, fin_notes = sheet_fins(surface.welded_faces[rest])
    out[rest[fins]] = False
    return out, notes + separate_objects(components, extra) + fin_notes


def _parts(draft: Draft, vertices: Floats, faces: Ints, keep: Mask, turned: Mask) -> tuple[RawPart, ...]:
    """The parts with the (F,) faces to keep and the vertices that these use; `turned`: (F,) normals to be dropped."""
    out, start, offset = [], 0, 0
    for part in draft.parts:
        face_count, vertex_count = len(part.mesh.faces), len(part.mesh.vertices)
        span = slice(start, start + face_count)
        part_faces = faces[span][keep[span]] - offset
        if len(part_faces):
            has_turned = bool(turned[span][keep[span]].any())
            mesh = part.mesh.with_vertices(vertices[offset : offset + vertex_count], part.mesh.normals)
            out.append(part.replace(mesh=submesh(mesh, part_faces, keep_normals=not has_turned)))
        start += face_count
        offset += vertex_count
    return tuple(out)


def valid_faces(vertices: Floats, faces: Ints, place: Ints) -> Mask:
    """(F,) faces with an area, each once; of reversed twins one where that closes the mesh; place: (V,) of weld."""
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
        remaining = remaining.replace(parts=keep_faces(remaining.parts, ~bad))
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
    return np.asarray(np.any(ends[ids], axis=1))


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
    subject = f"{int(is_fin.sum())} faces that stood off a closed surface like fins were"
    if is_fin.sum() == 1:
        subject = "1 face that stood off a closed surface like a fin was"
    return is_fin, [warning("MSH046", "faces", f"{subject} taken away")]


def orient_outward(surface: Surface) -> tuple[Ints, Mask]:
    """(F, 3) faces, each component wound outwards unless it is the inner wall of another; (F,) which were turned."""
    ids, turned = consistent_winding(surface.welded_faces)
    points = np.zeros((int(ids.max()) + 1, 3))
    points[surface.welded_faces.ravel()] = surface.vertices[surface.faces.ravel()]
    label = face_components(ids, len(points))
    is_open = ~closed_components(ids, label, len(points))[label]
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

    `ids`: (F, 3) faces, wound one way. `label`: (F,) component of each. `was_turned`: (F,) turned for that. `is_open`:
    (F,) faces of components that bound no volume.
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
    """(F,) faces of open patches, joined over edges of exactly two faces, that show their back to the outside."""
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
    return np.asarray(shows_back[patch] & is_open & ~is_flat[label])
