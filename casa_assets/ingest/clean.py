"""Clean raw parts: drop broken, duplicate, stray and hidden faces, close small tears, wind surfaces outwards."""

from __future__ import annotations

import numpy as np

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft, Surface, warning
from casa_assets.ingest.repair.components import (
    enclosed_parts,
    intersecting_components,
    is_transparent,
    solidity,
    split_components,
)
from casa_assets.ingest.repair.faces import cut_nonmanifold_faces, orient_outward, sheet_fins, valid_faces
from casa_assets.ingest.repair.foreign_parts import foreign_parts, separate_objects
from casa_assets.ingest.repair.gaps import close_cracks, close_missing_sides, split_t_junctions
from casa_assets.ingest.texture import submesh
from casa_assets.mesh.surface import backward_share
from casa_assets.mesh.topology import edge_counts
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill
from casa_assets.model.source import RawModel, RawPart

# Share of a mesh's area whose normals may look backwards; smoothing over sharp edges turns up to 0.6 %.
MAX_BACKWARD_SHARE = 0.01
# Normals within half a degree of the plane of their face count as backwards: rounding moves them to either side.
LEAST_COSINE = 0.01


def clean(model: RawModel, category: Category | None = None) -> Draft:
    """Repair what can be repaired without changing the looks; a sound mesh stays as it is.

    The proportions of the category distinguish a pedestal from a foot; its build tells whether the inside is solid.
    Raises Rejected: no faces are left (MSH001), or the remaining surface is flat (MSH002).
    """
    draft = Draft(
        parts=model.parts,
        metres_per_unit=model.metres_per_unit,
        up=model.up,
        format=model.format,
        notes=model.notes,
    )
    if not len(draft.surface.faces):
        raise Rejected("MSH001", "there are no faces; export a surface, not points or lines")
    draft = _without_bad_faces(draft, category)
    draft = split_t_junctions(draft)
    draft = _wound_outward(draft)
    draft = _without_wrong_normals(draft)
    draft = cut_nonmanifold_faces(draft)
    _refuse_flat(draft.surface.vertices)
    is_full = category is not None and category.build in (MatterFill.SOLID, MatterFill.FILLED)
    if category is not None and is_full and category.id != FALLBACK:
        draft = close_missing_sides(draft)
    return _measured(draft, is_full)


def _without_bad_faces(draft: Draft, category: Category | None) -> Draft:
    """Leave out degenerate and duplicate faces and what is no part of the object; close cracks in the rest."""
    surface = _without_unused(draft.surface)
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


def _without_unused(surface: Surface) -> Surface:
    """The surface with vertices that no face uses moved to one that is used: they must not coarsen the welding grid."""
    unused = np.ones(len(surface.vertices), dtype=bool)
    unused[surface.faces.ravel()] = False
    if not unused.any():
        return surface
    vertices = surface.vertices.copy()
    vertices[unused] = vertices[surface.faces[0, 0]]
    return Surface(vertices, surface.faces)


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
    """The draft with its solidity, and notes on faults that are left."""
    points, faces = draft.surface.points, draft.surface.welded_faces
    found = solidity(points, faces, full)
    guesses = draft.guessed("solidity", found.kind.value, found.confidence, found.message)
    notes = draft.noted(*_unsound(faces), *intersecting_components(points, faces))
    return draft.replace(guesses=guesses, notes=notes)


def _unsound(ids: Ints) -> list[Issue]:
    """Notes on open and nonmanifold edges that are left."""
    _, uses, _ = edge_counts(ids)
    notes = []
    if (uses == 1).any():
        message = f"{int((uses == 1).sum())} edges have a face on one side only; the mesh is not watertight"
        notes.append(warning("MSH022", "edges", message))
    if (uses > 2).any():
        message = f"{int((uses > 2).sum())} edges are shared by more than two faces; the mesh is no manifold"
        notes.append(warning("MSH023", "edges", message))
    return notes


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


def _refuse_flat(cloud: Floats) -> None:
    if len(cloud) < 4:
        spread = np.linalg.svd(cloud - cloud.mean(axis=0), compute_uv=False)
    else:
        spread = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(cloud.T))[::-1], 0))
    if spread[0] <= 0 or spread[-1] < 1e-4 * spread[0]:
        raise Rejected("MSH002", "all faces lie in one plane or on one line; a thing that is handled needs a thickness")
