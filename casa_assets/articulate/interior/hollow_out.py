"""Cut holes into a solid body where cavities have to be, and remove what lies in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.plan import Articulation, Frame
from casa_assets.articulate.segment.cut_planes import CutPlane, cut_triangles
from casa_assets.articulate.segment.fragment_measures import FRONT
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_model
from casa_assets.core.typing import Floats, Ints
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel
from casa_assets.model.record import Vec3

Box = tuple[Vec3, Vec3]

# Cut planes reach through whatever crosses a cavity, diagonals.
PLANE_EXTENT = 10.0


def hollow_out(
    model: RawModel, placed: WeldedMesh, articulation: Articulation, holes: Sequence[Box]
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Remove all of the body that lies in some boxes of the frame.

    Args:
        model: its faces, part by part, are those of `placed`.
    """
    if not holes:
        return model, placed, articulation
    body = np.ones(len(placed.faces), dtype=bool)
    for part in articulation.parts:
        body[part.faces] = False
    parts, parents = [], []
    start = 0
    for raw in model.parts:
        count = len(raw.mesh.faces)
        mesh, parent = _carved(raw.mesh, np.flatnonzero(body[start : start + count]), articulation.frame, holes)
        if len(parent):
            parts.append(raw.replace(mesh=mesh))
            parents.append(parent + start)
        start += count
    model = model.replace(parts=tuple(parts))
    kept = np.concatenate(parents)
    hollow = weld_model(model, by_material=False).in_frame(articulation.frame)
    return model, hollow, _renumbered(articulation, kept, len(placed.faces))


def _carved(mesh: Mesh, rows: Ints, frame: Frame, holes: Sequence[Box]) -> tuple[Mesh, Ints]:
    """Return a mesh without what lies in the boxes, and the face that each of its faces was part of.

    Args:
        rows: faces that may be cut.
    """
    parent = np.arange(len(mesh.faces))
    free = np.zeros(len(mesh.faces), dtype=bool)
    free[rows] = True
    for lower, upper in ((np.array(a), np.array(b)) for a, b in holes):
        place = (mesh.vertices - np.array(frame.origin)) @ frame.rotation.T * frame.scale
        corners = place[mesh.faces]
        near = free & ((corners.min(axis=1) < upper) & (corners.max(axis=1) > lower)).all(axis=1)
        if not near.any():
            continue
        done = cut_triangles(place, mesh.faces[near].astype(np.int64), _blades(lower, upper))
        middle = done.interpolate(place)[done.faces].mean(axis=1)
        out = ~((middle > lower) & (middle < upper)).all(axis=1)
        faces = np.concatenate([mesh.faces[~near].astype(np.int64), done.faces[out]])
        mesh = done.interpolate_mesh(mesh, faces)
        cut = np.flatnonzero(near)[done.parent[out]]
        parent, free = np.concatenate([parent[~near], parent[cut]]), np.concatenate([free[~near], free[cut]])
    return mesh, parent


def _blades(lower: Floats, upper: Floats) -> list[CutPlane]:
    """Return cut planes through the sides of a box."""
    a, b = np.full(3, -PLANE_EXTENT), np.full(3, PLANE_EXTENT)
    # A cut plane on the front counts right, up and depth: x, z and y.
    return [
        CutPlane(FRONT, k, float(end[axis]), a, b) for k, axis in ((0, 0), (1, 2), (2, 1)) for end in (lower, upper)
    ]


def _renumbered(articulation: Articulation, kept: Ints, count: int) -> Articulation:
    """Return the parts over the remaining faces; `kept` is the old index of each."""
    place = np.full(count, -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    parts = tuple(p.replace(faces=place[p.faces], grip=place[p.grip]) for p in articulation.parts)
    return articulation.replace(parts=parts)
