"""Cut the model of a one-piece shell along the borders of the parts found on it, and close the cuts."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.plan import Articulation, Frame, PartKind
from casa_assets.articulate.segment.caps import CapFaces, close_cuts
from casa_assets.articulate.segment.cut_planes import CutPlane, cut_triangles
from casa_assets.articulate.segment.fragment_measures import FRONT, SIDES
from casa_assets.articulate.segment.fragments import fragment_labels
from casa_assets.articulate.segment.shell_segments import FusedShell, find_shell, shell_cut_planes, shell_zones
from casa_assets.articulate.segment.triangle_soup import TriangleSoup, weld_triangles
from casa_assets.core.typing import Floats, Ints
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel, RawPart

_BOARDS = frozenset({PartKind.DOOR, PartKind.DRAWER})


def cut_shell_parts(
    model: RawModel, placed: TriangleSoup, found: Articulation
) -> tuple[RawModel, TriangleSoup, Articulation]:
    """Cut a model along the borders of the parts found on its shell; unchanged where there is no shell.

    Args:
        model: as read; its faces, part by part, are those of `placed`.
        placed: in the frame, diagonal 1.

    Returns:
        The model with its triangles cut and the faces that close the cuts as a last part, the same in the frame, and
        the parts over their faces.
    """
    shell = find_shell(placed, fragment_labels(placed)) if found.parts else None
    if shell is None:
        return model, placed, found
    owner = _owner(found, len(placed.faces))
    zone = shell_zones(shell, placed, np.arange(len(owner)))
    part_of = _parts_of_zones(placed, zone, owner, shell)
    if not len(part_of):
        return model, placed, found  # controls stand on the shell, and nothing is cut out of it
    blades = shell_cut_planes(shell, placed, np.flatnonzero(part_of >= 0).tolist())
    model, parent = _cut(model, found.frame, blades)
    soup = _in_frame(model, found.frame)
    fresh = shell_zones(shell, soup, parent)
    parted = np.bincount(parent, minlength=len(owner))[parent] > 1
    new = owner[parent]
    new = np.where(parted & (fresh >= 0), part_of[np.maximum(fresh, 0)], new)
    new = np.where(parted & (fresh < 0) & (zone[parent] >= 0), -1, new)
    nearest = float((soup.points @ SIDES[FRONT][2]).min())
    backs = {
        int(part_of[i]): nearest + back
        for i, (_, back) in enumerate(shell.fronts)
        if part_of[i] >= 0 and found.parts[part_of[i]].kind in _BOARDS
    }
    closing = close_cuts(soup, new, found.parts, backs)
    found = _over(found, parent, new, closing)
    if len(closing.faces):
        model = model.replace(parts=(*model.parts, _cap_part(model, found.frame, closing)))
        soup = _in_frame(model, found.frame)
    return model, soup, found


def _owner(found: Articulation, count: int) -> Ints:
    """Return the (F,) index of the part that each face belongs to, -1 for the body."""
    owner = np.full(count, -1, dtype=np.int64)
    for i, part in enumerate(found.parts):
        owner[part.faces] = i
    return owner


def _parts_of_zones(soup: TriangleSoup, zone: Ints, owner: Ints, shell: FusedShell) -> Ints:
    """Return the (Z,) part that has most of the area of each zone, -1 for the body."""
    count = len(shell.fronts) + len(shell.front.blobs) + len(shell.top.blobs)
    share = np.zeros((count, int(owner.max()) + 2))
    rows = zone >= 0
    np.add.at(share, (zone[rows], owner[rows] + 1), soup.areas[rows])
    found: Ints = np.argmax(share, axis=1) - 1
    return found


def _cut(model: RawModel, frame: Frame, blades: list[CutPlane]) -> tuple[RawModel, Ints]:
    """Cut the triangles of a model; also return the triangle that each was part of."""
    parts, parents = [], []
    start = 0
    for raw in model.parts:
        mesh = raw.mesh
        place = (mesh.vertices - np.array(frame.origin)) @ frame.rotation.T * frame.scale
        done = cut_triangles(place, mesh.faces.astype(np.int64), blades)
        normals = None if mesh.normals is None else _unit(done.interpolate(mesh.normals))
        colors = (
            None if mesh.colors is None else np.rint(done.interpolate(mesh.colors.astype(np.float64))).astype(np.uint8)
        )
        fresh = Mesh(
            vertices=done.interpolate(mesh.vertices),
            faces=done.faces.astype(np.int32),
            uv=None if mesh.uv is None else done.interpolate(mesh.uv),
            normals=normals,
            colors=colors,
        )
        parts.append(raw.replace(mesh=fresh))
        parents.append(done.parent + start)
        start += len(mesh.faces)
    return model.replace(parts=tuple(parts)), np.concatenate(parents)


def _unit(vectors: Floats) -> Floats:
    """Return vectors scaled to length 1."""
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return found


def model_soup(model: RawModel) -> TriangleSoup:
    """Return all triangles of a model as one soup, file axes."""
    starts = np.cumsum([0, *(len(p.mesh.vertices) for p in model.parts[:-1])])
    faces = [p.mesh.faces.astype(np.int64) + s for p, s in zip(model.parts, starts, strict=True)]
    numbers: dict[str, int] = {}
    looks = ["" if p.material is None else p.material.id for p in model.parts]
    tint = [np.full(len(f), numbers.setdefault(k, len(numbers))) for f, k in zip(faces, looks, strict=True)]
    return weld_triangles(
        np.concatenate([p.mesh.vertices for p in model.parts]), np.concatenate(faces), np.concatenate(tint)
    )


def _in_frame(model: RawModel, frame: Frame) -> TriangleSoup:
    """Return all triangles of a model as one soup in the frame."""
    return model_soup(model).transformed(frame.rotation, np.array(frame.origin), frame.scale)


def _over(found: Articulation, parent: Ints, owner: Ints, closing: CapFaces) -> Articulation:
    """Return the parts over the cut faces and their closing faces, which are numbered after all others."""
    parts = []
    for i, part in enumerate(found.parts):
        own = np.flatnonzero(owner == i)
        held = np.isin(parent[own], part.grip)
        more = len(parent) + np.flatnonzero(closing.owner == i)
        parts.append(part.replace(faces=np.concatenate([own, more]), grip=own[held]))
    return found.replace(parts=tuple(parts))


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
