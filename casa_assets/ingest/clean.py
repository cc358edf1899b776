"""Raw parts into sound ones: no broken, doubled or stray faces, every surface wound outwards."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components

from casa_assets.errors import Rejected
from casa_assets.geometry.hull import hull_volume
from casa_assets.geometry.measure import face_normals, signed_volume, winding_number
from casa_assets.geometry.topology import consistent_winding, edge_counts, face_components, is_closed, weld
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.issue import Issue
from casa_assets.model.mesh import Mesh
from casa_assets.model.source import RawModel, RawPart

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

# A stray piece is smaller than this part of the whole and farther off than half the size of the rest.
STRAY_SIZE = 0.05
STRAY_GAP = 0.5
# A ground plane is this many times wider than what stands on it, and this flat.
GROUND_WIDTH = 1.5
GROUND_FLAT = 1e-3
# A sky around the thing is this many times larger than all that is in it.
SKY_WIDTH = 5.0
SKY_CONVEX = 0.9
# Pieces this large and this far apart, as parts of the largest one's size, are objects of their own.
APART_SIZE = 0.3
APART_GAP = 0.1
# So many pieces, the largest, are looked at for being within one another, or apart.
MOST_HOLLOW = 64


def clean(model: RawModel) -> Draft:
    """Repair what can be repaired without changing what the thing looks like.

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
    keep = _sound(vertices, faces, place)
    notes = [_dropped(int((~keep).sum()), len(keep), "degenerate or doubled")] if not keep.all() else []
    keep, found = _without_extras(vertices, faces, place, keep)
    notes += found
    if not keep.any():
        raise Rejected("MSH001", "no face with an area is left; the file holds only points, lines or slivers")
    faces, turned = _outward(vertices, place[faces], faces, keep)
    if turned.any():
        share = turned.sum() / keep.sum()
        notes.append(
            warning("MSH011", "winding", f"{int(turned.sum())} faces ({share:.0%}) were turned to face outwards")
        )
    notes += _unsound(place[faces[keep]])
    parts = _parts(draft, faces, keep, turned)
    _refuse_flat(parts)
    return draft.replace(parts=parts, notes=draft.noted(*notes))


def _unsound(ids: Ints) -> list[Issue]:
    """What cannot be mended without inventing surface."""
    _, uses, _ = edge_counts(ids)
    notes = []
    if (uses == 1).any():
        says = f"{int((uses == 1).sum())} edges have a face on one side only; the mesh is not watertight"
        notes.append(warning("MSH022", "edges", says))
    if (uses > 2).any():
        says = f"{int((uses > 2).sum())} edges are shared by more than two faces; the mesh is no manifold"
        notes.append(warning("MSH023", "edges", says))
    return notes


def _dropped(count: int, total: int, kind: str) -> Issue:
    return warning("MSH010", "faces", f"{count} of {total} faces were {kind} and were dropped")


def _sound(vertices: Floats, faces: Ints, place: Ints) -> Mask:
    """Faces with an area, each set of three points once; reversed twins go only where that leaves a closed surface."""
    ids = place[faces]
    _, area = face_normals(vertices, faces)
    extent = float(np.ptp(vertices, axis=0).max()) or 1.0
    keep = (
        (area > (extent * 1e-7) ** 2) & (ids[:, 0] != ids[:, 1]) & (ids[:, 1] != ids[:, 2]) & (ids[:, 2] != ids[:, 0])
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
    return bool((uses == 2).mean() > 0.98)


def _without_extras(vertices: Floats, faces: Ints, place: Ints, keep: Mask) -> tuple[Mask, list[Issue]]:
    """Leave out ground planes, skies and pieces that float far from the rest."""
    index = np.flatnonzero(keep)
    if not len(index):
        return keep, []
    label = face_components(place[faces[index]], int(place.max()) + 1)
    count = int(label.max()) + 1
    if count == 1 or count > 5000:
        return keep, []
    corners = vertices[faces[index]]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    size = (high - low).max(axis=1)
    extra, notes = np.zeros(count, dtype=bool), []
    for piece in np.argsort(-size, kind="stable")[:3]:
        rest = ~extra & (np.arange(count) != piece)
        spread = float((high[rest].max(axis=0) - low[rest].min(axis=0)).max()) if rest.any() else 0.0
        thin = float((high[piece] - low[piece]).min())
        around = rest.any() and (low[piece] < low[rest]).all() and (high[rest] < high[piece]).all()
        if 0 < spread * GROUND_WIDTH < size[piece] and thin <= GROUND_FLAT * size[piece]:
            extra[piece] = True
            notes.append(warning("MSH012", "ground", "a wide flat sheet under the object was taken away"))
        elif around and 0 < spread * SKY_WIDTH < size[piece] and _is_sky(corners[label == piece]):
            extra[piece] = True
            notes.append(warning("MSH012", "sky", "a shell far around the object was taken away"))
    main = int(np.argmax(np.where(extra, -1, size)))
    gap = np.linalg.norm(np.maximum(0, np.maximum(low - high[main], low[main] - high)), axis=1)
    stray = ~extra & (size < STRAY_SIZE * size[main]) & (gap > STRAY_GAP * size[main])
    if stray.any():
        notes.append(
            warning("MSH013", "floaters", f"{int(stray.sum())} stray pieces far from the object were taken away")
        )
    large = np.flatnonzero(~extra & ~stray & (size > APART_SIZE * size[main]))
    groups = _groups(low[large], high[large], APART_GAP * float(size[main])) if len(large) <= MOST_HOLLOW else 1
    if groups > 1:
        says = f"{groups} groups of pieces stand apart from each other; give each object a file of its own"
        notes.append(warning("MSH024", "pieces", says))
    out = keep.copy()
    out[index[(extra | stray)[label]]] = False
    return out, notes


def _is_sky(corners: Floats) -> bool:
    """Convex and seen from within; a vessel with a crumb in it is hollow, and a fruit with seeds faces outwards."""
    points = corners.reshape(-1, 3)
    inward = -signed_volume(points, np.arange(len(points)).reshape(-1, 3))
    return inward > SKY_CONVEX * hull_volume(points) > 0


def _groups(low: Floats, high: Floats, reach: float) -> int:
    """Number of groups of boxes, neighbours being no farther apart than `reach`."""
    gap = np.maximum(0, np.maximum(low[:, None] - high[None], low[None] - high[:, None]))
    return int(connected_components(np.linalg.norm(gap, axis=2) <= reach, directed=False)[0])


def _outward(vertices: Floats, ids: Ints, faces: Ints, keep: Mask) -> tuple[Ints, Mask]:
    """Turn faces so that each piece winds one way, and outwards unless it is the inner wall of another."""
    index = np.flatnonzero(keep)
    _, turned = consistent_winding(ids[index])
    some = ids[index].copy()
    some[turned] = some[turned][:, ::-1]
    points = np.zeros((int(ids.max()) + 1, 3))
    points[ids.ravel()] = vertices[faces.ravel()]
    label = face_components(some, len(points))
    turned ^= _inside_out(points, some, label)[label]
    out = faces.copy()
    flip = np.zeros(len(faces), dtype=bool)
    flip[index[turned]] = True
    out[flip] = out[flip][:, ::-1]
    return out, flip


def _inside_out(points: Floats, ids: Ints, label: Ints) -> Mask:
    """Which pieces have to be turned; what lies within another piece keeps its direction against that one's."""
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
    # A flat piece has no inside: it stays as it is.
    turned: Mask = volume < -1e-9 * (high - low).max(axis=1) ** 3
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


def _parts(draft: Draft, faces: Ints, keep: Mask, turned: Mask) -> tuple[RawPart, ...]:
    """The parts with the faces that stay and the vertices that they use."""
    out, start, offset = [], 0, 0
    for part in draft.parts:
        count = len(part.mesh.faces)
        rows = slice(start, start + count)
        own = faces[rows][keep[rows]] - offset
        if len(own):
            fresh = bool(turned[rows][keep[rows]].any())
            out.append(part.replace(mesh=_compact(part.mesh, own, drop_normals=fresh)))
        start += count
        offset += len(part.mesh.vertices)
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
