"""Cut holes into a solid body where cavities have to be, and remove what lies in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.plan import Articulation, Frame
from casa_assets.articulate.segment.cut_planes import CutPlane, cut_triangles
from casa_assets.articulate.segment.fragment_measures import FRONT
from casa_assets.articulate.segment.triangle_soup import TriangleSoup, weld_triangles
from casa_assets.core.typing import Floats, Ints
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel
from casa_assets.model.record import Vec3

Box = tuple[Vec3, Vec3]

# Blades reach through whatever crosses a room, diagonals.
PLANE_EXTENT = 10.0


def hollow_out(
    model: RawModel, placed: TriangleSoup, found: Articulation, holes: Sequence[Box]
) -> tuple[RawModel, TriangleSoup, Articulation]:
    """Remove all of the body that lies in some boxes of the frame.

    Args:
        model: its faces, part by part, are those of `placed`.
    """
    if not holes:
        return model, placed, found
    body = np.ones(len(placed.faces), dtype=bool)
    for part in found.parts:
        body[part.faces] = False
    parts, parents = [], []
    start = 0
    for raw in model.parts:
        count = len(raw.mesh.faces)
        mesh, parent = _carved(raw.mesh, np.flatnonzero(body[start : start + count]), found.frame, holes)
        if len(parent):
            parts.append(raw.replace(mesh=mesh))
            parents.append(parent + start)
        start += count
    model = model.replace(parts=tuple(parts))
    kept = np.concatenate(parents)
    return model, soup_in_frame(model, found.frame), _renumbered(found, kept, len(placed.faces))


def soup_in_frame(model: RawModel, frame: Frame) -> TriangleSoup:
    """Return all triangles of a model as one soup in the frame."""
    starts = np.cumsum([0, *(len(p.mesh.vertices) for p in model.parts[:-1])])
    faces = [p.mesh.faces.astype(np.int64) + s for p, s in zip(model.parts, starts, strict=True)]
    soup = weld_triangles(np.concatenate([p.mesh.vertices for p in model.parts]), np.concatenate(faces))
    return soup.transformed(frame.rotation, np.array(frame.origin), frame.scale)


def _carved(mesh: Mesh, rows: Ints, frame: Frame, holes: Sequence[Box]) -> tuple[Mesh, Ints]:
    """Return a mesh without what lies in the boxes, and the face that each of its faces was part of.

    Args:
        rows: faces that may be cut.
    """
    parent = np.arange(len(mesh.faces))
    free = np.zeros(len(mesh.faces), dtype=bool)
    free[rows] = True
    for low, high in ((np.array(a), np.array(b)) for a, b in holes):
        place = (mesh.vertices - np.array(frame.origin)) @ frame.rotation.T * frame.scale
        corners = place[mesh.faces]
        near = free & ((corners.min(axis=1) < high) & (corners.max(axis=1) > low)).all(axis=1)
        if not near.any():
            continue
        done = cut_triangles(place, mesh.faces[near].astype(np.int64), _blades(low, high))
        middle = done.interpolate(place)[done.faces].mean(axis=1)
        out = ~((middle > low) & (middle < high)).all(axis=1)
        normals = None if mesh.normals is None else _unit(done.interpolate(mesh.normals))
        colors = (
            None if mesh.colors is None else np.rint(done.interpolate(mesh.colors.astype(np.float64))).astype(np.uint8)
        )
        mesh = Mesh(
            vertices=done.interpolate(mesh.vertices),
            faces=np.concatenate([mesh.faces[~near].astype(np.int64), done.faces[out]]).astype(np.int32),
            uv=None if mesh.uv is None else done.interpolate(mesh.uv),
            normals=normals,
            colors=colors,
        )
        cut = np.flatnonzero(near)[done.parent[out]]
        parent, free = np.concatenate([parent[~near], parent[cut]]), np.concatenate([free[~near], free[cut]])
    return mesh, parent


def _blades(low: Floats, high: Floats) -> list[CutPlane]:
    """Return cut planes through the sides of a box."""
    a, b = np.full(3, -PLANE_EXTENT), np.full(3, PLANE_EXTENT)
    # A blade on the front counts right, up and depth: x, z and y.
    return [CutPlane(FRONT, k, float(end[axis]), a, b) for k, axis in ((0, 0), (1, 2), (2, 1)) for end in (low, high)]


def _unit(vectors: Floats) -> Floats:
    """Return vectors scaled to length 1."""
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return found


def _renumbered(found: Articulation, kept: Ints, count: int) -> Articulation:
    """Return the parts over the remaining faces; `kept` is the old index of each."""
    place = np.full(count, -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    parts = tuple(p.replace(faces=place[p.faces], grip=place[p.grip]) for p in found.parts)
    return found.replace(parts=parts)
