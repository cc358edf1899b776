"""Clean raw parts: drop broken, duplicate, stray and hidden faces, close small tears, wind surfaces outwards."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.errors import Rejected
from casa_assets.geometry.mesh.topology import edge_counts, weld
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.repair.components import pieces_of
from casa_assets.ingest.repair.cracks import close_cracks
from casa_assets.ingest.repair.degenerate_faces import valid_faces
from casa_assets.ingest.repair.enclosed_parts import clear_parts, enclosed_parts
from casa_assets.ingest.repair.foreign_parts import foreign_parts, separate_objects
from casa_assets.ingest.repair.intersecting_parts import intersecting_parts
from casa_assets.ingest.repair.nonmanifold import cut_nonmanifold_faces
from casa_assets.ingest.repair.sheet_fins import sheet_fins
from casa_assets.ingest.repair.solidity import solidity
from casa_assets.ingest.repair.t_junctions import split_t_junctions
from casa_assets.ingest.repair.winding import orient_outward
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel, RawPart
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import Category, MatterFill


def clean(model: RawModel, category: Category | None = None) -> Draft:
    """Repair what can be repaired without changing what the thing looks like; a sound mesh stays as it is.

    Args:
        category: whose proportions tell the stand under a thing from its foot, and whose build whether it is full; None
            where that is not known.
    Raises:
        Rejected: nothing is left (MSH001), or what is left is flat (MSH002).
    """
    draft = Draft(
        parts=model.parts,
        metres_per_unit=model.metres_per_unit,
        up=model.up,
        format=model.format,
        notes=model.notes,
    )
    vertices, faces = draft.soup()
    if not len(faces):
        raise Rejected("MSH001", "there are no faces; export a surface, not points or lines")
    unused = np.ones(len(vertices), dtype=bool)
    unused[faces.ravel()] = False
    vertices[unused] = vertices[faces[0, 0]]  # where they lie must not coarsen the grid that vertices are welded on
    _, place = weld(vertices)
    keep = valid_faces(vertices, faces, place)
    notes = [_dropped(int((~keep).sum()), len(keep), "degenerate or doubled")] if not keep.all() else []
    keep, found = _without_extras(vertices, faces, place, keep, category)
    notes += found
    if not keep.any():
        raise Rejected("MSH001", "no face with an area is left; the file holds only points, lines or slivers")
    vertices, _, found = close_cracks(vertices, faces, place, keep)
    notes += found
    parts, found = split_t_junctions(_parts(draft, vertices, faces, keep, np.zeros(len(faces), dtype=bool)))
    notes += found
    parts, found = _turned(draft.replace(parts=parts))
    notes += found
    parts, found = cut_nonmanifold_faces(parts)
    notes += found
    full = category is not None and category.build in (MatterFill.SOLID, MatterFill.FILLED)
    return _measured(draft, parts, notes, full)


def _turned(draft: Draft) -> tuple[tuple[RawPart, ...], list[Issue]]:
    """The parts wound outwards, without what is sealed up in others."""
    vertices, faces = draft.soup()
    _, place = weld(vertices)
    keep = np.ones(len(faces), dtype=bool)
    faces, turned = orient_outward(vertices, place[faces], faces, keep)
    notes = []
    if turned.any():
        message = f"{int(turned.sum())} faces ({turned.mean():.0%}) were turned to face outwards"
        notes.append(warning("MSH011", "winding", message))
    keep, found = _without_hidden(draft, vertices, faces, place, keep)
    return _parts(draft, vertices, faces, keep, turned), notes + found


def _measured(draft: Draft, parts: tuple[RawPart, ...], notes: list[Issue], full: bool) -> Draft:
    """The draft of the mended parts, with what is left to say of them."""
    _refuse_flat(parts)
    out = draft.replace(parts=parts)
    vertices, faces = out.soup()
    points, place = weld(vertices)
    ids = place[faces]
    what = solidity(points, ids, full)
    guesses = out.guessed("solidity", what.kind.value, what.confidence, what.message)
    return out.replace(guesses=guesses, notes=out.noted(*notes, *_unsound(ids), *intersecting_parts(points, ids)))


def _unsound(ids: Ints) -> list[Issue]:
    """Remarks on faults that cannot be mended without inventing surface."""
    _, uses, _ = edge_counts(ids)
    notes = []
    if (uses == 1).any():
        message = f"{int((uses == 1).sum())} edges have a face on one side only; the mesh is not watertight"
        notes.append(warning("MSH022", "edges", message))
    if (uses > 2).any():
        message = f"{int((uses > 2).sum())} edges are shared by more than two faces; the mesh is no manifold"
        notes.append(warning("MSH023", "edges", message))
    return notes


def _dropped(count: int, total: int, kind: str) -> Issue:
    return warning("MSH010", "faces", f"{count} of {total} faces were {kind} and were dropped")


def _without_extras(
    vertices: Floats, faces: Ints, place: Ints, keep: Mask, category: Category | None
) -> tuple[Mask, list[Issue]]:
    """Leave out what is no part of the thing, and remark on several things in one file."""
    index = np.flatnonzero(keep)
    if not len(index):
        return keep, []
    found = pieces_of(vertices, faces[index], place)
    extra, notes = foreign_parts(found, category)
    out = keep.copy()
    out[index[extra[found.label]]] = False
    rest = np.flatnonzero(out)
    stray, told = sheet_fins(place[faces[rest]])
    out[rest[stray]] = False
    return out, notes + separate_objects(found, extra) + told


def _without_hidden(draft: Draft, vertices: Floats, faces: Ints, place: Ints, keep: Mask) -> tuple[Mask, list[Issue]]:
    """Leave out the pieces that are sealed up in others."""
    index = np.flatnonzero(keep)
    found = pieces_of(vertices, faces[index], place)
    clear = np.repeat(clear_parts(draft.parts), [len(p.mesh.faces) for p in draft.parts])
    sealed, notes = enclosed_parts(found, clear[index])
    out = keep.copy()
    out[index[sealed[found.label]]] = False
    return out, notes


def _parts(draft: Draft, vertices: Floats, faces: Ints, keep: Mask, turned: Mask) -> tuple[RawPart, ...]:
    """The parts with the faces that stay and the vertices that they use, where those now are."""
    out, start, offset = [], 0, 0
    for part in draft.parts:
        count, size = len(part.mesh.faces), len(part.mesh.vertices)
        rows = slice(start, start + count)
        own = faces[rows][keep[rows]] - offset
        if len(own):
            fresh = bool(turned[rows][keep[rows]].any())
            mesh = part.mesh.with_vertices(vertices[offset : offset + size], part.mesh.normals)
            out.append(part.replace(mesh=_compact(mesh, own, drop_normals=fresh)))
        start += count
        offset += size
    return tuple(out)


def _compact(mesh: Mesh, faces: Ints, drop_normals: bool) -> Mesh:
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[faces.ravel()] = True
    place = np.cumsum(used) - 1
    return Mesh(
        vertices=mesh.vertices[used],
        faces=place[faces],
        uv=None if mesh.uv is None else mesh.uv[used],
        normals=None if mesh.normals is None or drop_normals else mesh.normals[used],
        colors=None if mesh.colors is None else mesh.colors[used],
    )


def _refuse_flat(parts: tuple[RawPart, ...]) -> None:
    cloud = np.concatenate([p.mesh.vertices for p in parts])
    spread = np.linalg.svd(cloud - cloud.mean(axis=0), compute_uv=False) if len(cloud) < 4 else None
    if spread is None:
        covariance = np.cov(cloud.T)
        spread = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance)[::-1], 0))
    if spread[0] <= 0 or spread[-1] < 1e-4 * spread[0]:
        raise Rejected("MSH002", "all faces lie in one plane or on one line; a thing that is handled needs a thickness")
