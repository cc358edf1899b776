"""Cut the model of a one-piece shell along the borders of the parts found on it, and close the cuts."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.plan import Articulation, Frame, PartKind
from casa_assets.articulate.segment.caps import CapFaces, close_cuts
from casa_assets.articulate.segment.cut_planes import CutPlane, cut_triangles
from casa_assets.articulate.segment.fragment_measures import FRONT, SIDES
from casa_assets.articulate.segment.shell_segments import (
    Fragmentation,
    FusedShell,
    shell_cut_planes,
    shell_zones,
)
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_model
from casa_assets.core.typing import Ints
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel, RawPart

_BOARDS = frozenset({PartKind.DOOR, PartKind.DRAWER})


def cut_shell_parts(
    model: RawModel, fragmentation: Fragmentation, articulation: Articulation
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Cut a model along the borders of the parts found on its shell; unchanged if there is no shell.

    Args:
        model: as read; its faces, part by part, are those of the fragmented mesh.

    Returns:
        The model with its triangles cut and the faces that close the cuts as a last part, the same as a welded mesh in
        the frame, and the parts in terms of the faces of that mesh.
    """
    placed, shell = fragmentation.mesh, fragmentation.shell
    if shell is None or not articulation.parts:
        return model, placed, articulation
    owner = articulation.face_owner(len(placed.faces))
    zone = shell_zones(shell, placed, np.arange(len(owner)))
    part_of = _parts_of_zones(placed, zone, owner, shell)
    if not len(part_of):
        return model, placed, articulation  # controls stand on the shell, and nothing is cut out of it
    planes = shell_cut_planes(shell, placed, np.flatnonzero(part_of >= 0).tolist())
    model, parent = _cut(model, articulation.frame, planes)
    mesh = weld_model(model).in_frame(articulation.frame)
    fresh = shell_zones(shell, mesh, parent)
    parted = np.bincount(parent, minlength=len(owner))[parent] > 1
    new = owner[parent]
    new = np.where(parted & (fresh >= 0), part_of[np.maximum(fresh, 0)], new)
    new = np.where(parted & (fresh < 0) & (zone[parent] >= 0), -1, new)
    nearest = float((mesh.points @ SIDES[FRONT][2]).min())
    backs = {
        int(part_of[i]): nearest + back
        for i, (_, back) in enumerate(shell.fronts)
        if part_of[i] >= 0 and articulation.parts[part_of[i]].kind in _BOARDS
    }
    closing = close_cuts(mesh, new, articulation.parts, backs)
    articulation = _over(articulation, parent, new, closing)
    if len(closing.faces):
        model = model.replace(parts=(*model.parts, _cap_part(model, articulation.frame, closing)))
        mesh = weld_model(model).in_frame(articulation.frame)
    return model, mesh, articulation


def _parts_of_zones(mesh: WeldedMesh, zone: Ints, owner: Ints, shell: FusedShell) -> Ints:
    """Return the (Z,) part that has most of the area of each zone, -1 for the body."""
    count = len(shell.fronts) + len(shell.front.blobs) + len(shell.top.blobs)
    share = np.zeros((count, int(owner.max()) + 2))
    rows = zone >= 0
    np.add.at(share, (zone[rows], owner[rows] + 1), mesh.areas[rows])
    found: Ints = np.argmax(share, axis=1) - 1
    return found


def _cut(model: RawModel, frame: Frame, planes: list[CutPlane]) -> tuple[RawModel, Ints]:
    """Cut the triangles of a model; also return the triangle that each was part of."""
    parts, parents = [], []
    start = 0
    for raw in model.parts:
        mesh = raw.mesh
        place = (mesh.vertices - np.array(frame.origin)) @ frame.rotation.T * frame.scale
        done = cut_triangles(place, mesh.faces.astype(np.int64), planes)
        parts.append(raw.replace(mesh=done.interpolate_mesh(mesh, done.faces)))
        parents.append(done.parent + start)
        start += len(mesh.faces)
    return model.replace(parts=tuple(parts)), np.concatenate(parents)


def _over(articulation: Articulation, parent: Ints, owner: Ints, closing: CapFaces) -> Articulation:
    """Return the parts over the cut faces and their closing faces, which are numbered after all others."""
    parts = []
    for i, part in enumerate(articulation.parts):
        own = np.flatnonzero(owner == i)
        held = np.isin(parent[own], part.grip)
        more = len(parent) + np.flatnonzero(closing.owner == i)
        parts.append(part.replace(faces=np.concatenate([own, more]), grip=own[held]))
    return articulation.replace(parts=tuple(parts))


def _cap_part(model: RawModel, frame: Frame, closing: CapFaces) -> RawPart:
    """Return the closing faces as a part with the material and nearest texture coordinates of its surroundings."""
    largest = max(model.parts, key=lambda p: len(p.mesh.faces))
    points = frame.to_file(closing.points)
    uv = None
    if largest.mesh.uv is not None:
        _, near = cKDTree(largest.mesh.vertices).query(points)
        uv = largest.mesh.uv[near]
    mesh = Mesh(vertices=points, faces=closing.faces.astype(np.int32), uv=uv)
    return RawPart(name="cut_faces", mesh=mesh, material=largest.material)
