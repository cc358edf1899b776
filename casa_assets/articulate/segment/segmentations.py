"""List the ways in which a mesh may fall into fragments; each is followed to a plan before one is chosen."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.plan import Articulation, Frame, PartKind
from casa_assets.articulate.segment.cutting import CapFaces, CutPlane, close_cuts, cut_triangles
from casa_assets.articulate.segment.fragments import WeldedMesh, corners_of_labels, weld_by_edges, weld_model
from casa_assets.articulate.segment.orthographic import FRONT, SIDES
from casa_assets.articulate.segment.shell_segments import Fragmentation, shell_cut_planes, shell_zones
from casa_assets.core.numeric import Ints, Mask
from casa_assets.mesh.surface import connected_groups, directed_edges, merge_rows
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel, RawPart

# Programs in which faces are pushed and pulled leave a knob or a door as a part of the body: the flat face that it was
# pulled out of has a hole, and its walls begin at the rim of that hole.
# Neighbouring faces are one flat sheet up to this angle: cosine of 1 degree.
FLAT_COS = 0.99985
_BOARDS = frozenset({PartKind.DOOR, PartKind.DRAWER})
# No single rule fits all makers: some export each part as a separate piece that shares positions with the body, so
# that welding by position joins door and body; others split one board into many pieces, and welding puts it together
# again.
# A file of more pieces than this, or of pieces with fewer faces than this in the mean, is split at every crease: its
# pieces say nothing about its parts.
MAX_PIECES, MIN_FACES_PER_PIECE = 1500, 3.0
# Pieces of a fragment are told apart only where it spans this share of the object along two axes.
LARGE_EXTENT_SHARE = 0.6
# Pieces whose longest side is at most this share of the diagonal join those of their kind that they share edges with:
# they are facets of knobs, posts and bars of handles. Ref: knobs and buttons are at most 0.121 long (controls.py).
SMALL_PIECE = 0.14
# Neighbouring faces whose normals are further apart than this meet in a crease: cosine of 37 degrees.
CREASE_COS = 0.8
# Fewest and most nodes that may be the parts of an object.
MIN_NODES, MAX_NODES = 3, 300


@dataclass(frozen=True)
class FlatSheets:
    """The flat sheets of a mesh: faces that share edges and one plane.

    Attributes:
        sheet: (F,) number of the sheet of each face. has_hole: (F,) by number, whether its outline is several loops.
        edges: (E,) keys of all edges, ascending. rims: keys of sheet and edge of all loops but the longest of a sheet.
    """

    sheet: Ints
    has_hole: Mask
    edges: Ints
    rims: Ints


def split_at_holes(mesh: WeldedMesh, sheets: FlatSheets) -> Ints:
    """Return the (F,) number of what is connected without crossing the rim of a hole of a flat sheet."""
    left, right = mesh.solid_neighbors
    ends_left, ends_right = mesh.faces[left], mesh.faces[right]
    lone = np.argmin((ends_left[:, :, None] == ends_right[:, None, :]).any(axis=2), axis=1)
    rows = np.arange(len(ends_left))
    ends = np.sort(np.column_stack([ends_left[rows, (lone + 1) % 3], ends_left[rows, (lone + 2) % 3]]), axis=1)
    edge = np.asarray(ends[:, 0] * len(mesh.points) + ends[:, 1])
    keys = (_rim_keys(sheets.sheet[faces], edge, sheets.edges) for faces in (left, right))
    cut = np.logical_or(*(np.isin(key, sheets.rims) for key in keys))
    return connected_groups(len(mesh.faces), left[~cut], right[~cut])[mesh.duplicate_of]


def find_flat_sheets(mesh: WeldedMesh) -> FlatSheets:
    """Return the flat sheets of a mesh, and the rims of their holes."""
    left, right = mesh.solid_neighbors
    flat = (mesh.normals[left] * mesh.normals[right]).sum(axis=1) >= FLAT_COS
    sheet = connected_groups(len(mesh.faces), left[flat], right[flat])
    alive = np.flatnonzero((mesh.duplicate_of == np.arange(len(mesh.faces))) & (mesh.areas > 0.0))
    faces, count = mesh.faces[alive], len(mesh.points)
    ends = np.sort(directed_edges(faces), axis=1)
    edge, owner = ends[:, 0] * count + ends[:, 1], np.tile(sheet[alive], 3)
    edges = np.unique(edge)
    keys, first, times = np.unique(_rim_keys(owner, edge, edges), return_index=True, return_counts=True)
    keys, first = keys[times == 1], first[times == 1]
    ends, owner = ends[first], owner[first]
    # A point that two sheets share belongs to the outline of each.
    nodes, place = np.unique(np.concatenate([owner, owner]) * count + ends.T.reshape(-1), return_inverse=True)
    a, b = place.reshape(2, -1)
    loop_of_node = connected_groups(len(nodes), a, b)
    loop = loop_of_node[a]
    sheet_of_loop = np.zeros(len(nodes), dtype=np.int64)
    sheet_of_loop[loop] = owner
    length = np.bincount(loop, np.linalg.norm(mesh.points[ends[:, 0]] - mesh.points[ends[:, 1]], axis=1), len(nodes))
    longest = np.zeros(len(mesh.faces))
    np.maximum.at(longest, sheet_of_loop, length)
    is_inner = (length > 0.0) & (length < longest[sheet_of_loop])
    has_hole = np.zeros(len(mesh.faces), dtype=bool)
    has_hole[sheet_of_loop[is_inner]] = True
    return FlatSheets(sheet, has_hole, edges, keys[is_inner[loop]])


def _rim_keys(sheet: Ints, edge: Ints, edges: Ints) -> Ints:
    return sheet * len(edges) + np.searchsorted(edges, edge)


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
    share = np.zeros((len(shell.fronts) + len(shell.front.blobs) + len(shell.top.blobs), int(owner.max()) + 2))
    in_zone = zone >= 0
    np.add.at(share, (zone[in_zone], owner[in_zone] + 1), placed.areas[in_zone])
    # The part that has most of the area of each zone, -1 for the body.
    part_of = np.argmax(share, axis=1) - 1
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


class Segmentation(StrEnum):
    """Way in which a mesh is split into fragments."""

    CREASES = "welded, cut at concave creases"
    HOLES = "welded, cut at holes of flat sheets"
    WELDED = "welded"
    PIECES = "pieces"
    LARGE_SPLIT = "pieces of large fragments"
    COLOURLESS = "welded across materials"
    NODES = "nodes"


def segmentations(mesh: WeldedMesh) -> dict[Segmentation, Ints]:
    """Return the (F,) fragment labels of each different way to split a mesh, the way that fits most meshes first.

    Labels are numbered by first face; faces without area have -1.
    """
    welded = mesh.fragment_labels
    alive = welded >= 0
    if not alive.any():
        return {Segmentation.WELDED: welded}
    candidates: dict[Segmentation, Ints] = {}
    sheets = find_flat_sheets(mesh)
    colours = mesh.material_index[mesh.duplicate_of]
    split = joined_small_pieces(mesh, _split_at_creases(mesh), sheets)
    candidates[Segmentation.CREASES] = _numbered(alive, split, colours)
    if sheets.has_hole.any():
        split = joined_small_pieces(mesh, split_at_holes(mesh, sheets), sheets)
        candidates[Segmentation.HOLES] = _numbered(alive, split, colours)
    candidates[Segmentation.WELDED] = welded
    pieces = mesh.piece_index[mesh.duplicate_of]
    count = len(np.unique(pieces[alive]))
    if 1 < count <= MAX_PIECES and alive.sum() >= MIN_FACES_PER_PIECE * count:
        pieces = joined_small_pieces(mesh, pieces, sheets)
        candidates[Segmentation.PIECES] = _numbered(alive, pieces, colours)
        lower, upper = corners_of_labels(mesh, welded)
        wide = (upper - lower) >= LARGE_EXTENT_SHARE * np.ptp(mesh.points, axis=0)
        large = wide.sum(axis=1) >= 2
        split = np.where(large[np.maximum(welded, 0)], pieces + 1, 0)
        candidates[Segmentation.LARGE_SPLIT] = _numbered(alive, welded, split)
    if len(np.unique(mesh.material_index[alive])) > 1:
        candidates[Segmentation.COLOURLESS] = weld_by_edges(mesh, by_material=False)
    if MIN_NODES <= len(np.unique(mesh.node_index[alive])) <= MAX_NODES:
        candidates[Segmentation.NODES] = _numbered(alive, mesh.node_index[mesh.duplicate_of])
    found: dict[Segmentation, Ints] = {}
    for way, labels in candidates.items():
        others = [welded] if way is not Segmentation.WELDED else []
        if not any(np.array_equal(labels, other) for other in [*others, *found.values()]):
            found[way] = labels
    return found


def _split_at_creases(mesh: WeldedMesh) -> Ints:
    """Return the (F,) number of what is connected without crossing a concave crease, as parts meet what bears them."""
    left, right = mesh.solid_neighbors
    middle = mesh.points[mesh.faces].mean(axis=1)
    bent = (mesh.normals[left] * mesh.normals[right]).sum(axis=1) < CREASE_COS
    inwards = np.where(_wind_inwards(mesh), -1.0, 1.0)[left]
    concave = inwards * ((middle[right] - middle[left]) * mesh.normals[left]).sum(axis=1) > 0.0
    whole = ~(bent & concave)
    return connected_groups(len(mesh.faces), left[whole], right[whole])[mesh.duplicate_of]


def _wind_inwards(mesh: WeldedMesh) -> Mask:
    """Mark the (F,) faces of welded fragments whose volume about their middle is negative."""
    label = np.maximum(mesh.fragment_labels, 0)
    # The two copies of a face that is there twice would cancel each other.
    counts = (mesh.fragment_labels >= 0) & (mesh.duplicate_of == np.arange(len(label)))
    count = np.maximum(np.bincount(label), 1)[:, None]
    corners = mesh.points[mesh.faces]
    middle = np.stack([np.bincount(label, corners.mean(axis=1)[:, k]) for k in range(3)], axis=1) / count
    corners = corners - middle[label][:, None]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return np.bincount(label, np.where(counts, volume, 0.0))[label] < 0.0


def joined_small_pieces(mesh: WeldedMesh, pieces: Ints, sheets: FlatSheets) -> Ints:
    """Return the (F,) pieces with those joined that are small, share an edge, and are small together.

    A piece that is a sheet with a hole is part of the body, and joins nothing.
    """
    # Pieces of faces that are written twice leave numbers that no face has.
    pieces = np.unique(pieces, return_inverse=True)[1].reshape(-1)
    lower, upper = corners_of_labels(mesh, pieces)
    small = (upper - lower).max(axis=1) <= SMALL_PIECE * mesh.diagonal
    left, right = (pieces[faces] for faces in mesh.solid_neighbors)
    is_more = np.zeros(len(small), dtype=bool)  # than a sheet with a hole
    is_more[pieces[~sheets.has_hole[sheets.sheet] & (mesh.areas > 0.0)]] = True
    small &= is_more
    both = small[left] & small[right] & (left != right)
    count = len(small)
    joined = connected_groups(count, left[both], right[both])
    lower, upper = corners_of_labels(mesh, joined[pieces])
    together = (upper - lower).max(axis=1) <= SMALL_PIECE * mesh.diagonal
    return np.where(together[joined], joined, joined.max(initial=0) + 1 + np.arange(count))[pieces]


def _numbered(alive: Mask, *keys: Ints) -> Ints:
    """Return (F,) labels of faces that agree in all keys, numbered by first face; -1 for faces without area."""
    labels = np.full(len(alive), -1, dtype=np.int64)
    _, labels[alive] = merge_rows(np.column_stack(keys)[alive].astype(np.float64))
    return labels
