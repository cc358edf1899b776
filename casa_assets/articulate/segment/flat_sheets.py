"""Find flat sheets with holes in a mesh, and split it where an object protrudes from such a hole or goes into it.

Programs in which faces are pushed and pulled leave a knob or a door as a part of the body: the flat face that it was
pulled out of has a hole, and its walls begin at the rim of that hole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.segment.welded_mesh import Bools, WeldedMesh
from casa_assets.core.typing import Ints
from casa_assets.geometry.mesh.topology import connected_groups

# Neighbouring faces are one flat sheet up to this angle: cosine of 1 degree.
FLAT_COS = 0.99985


@dataclass(frozen=True)
class FlatSheets:
    """The flat sheets of a mesh: faces that share edges and one plane.

    Attributes:
        sheet: (F,) number of the sheet of each face. has_hole: (F,) by number, whether its outline is several loops.
        edges: (E,) keys of all edges, ascending. rims: keys of sheet and edge of all loops but the longest of a sheet.
    """

    sheet: Ints
    has_hole: Bools
    edges: Ints
    rims: Ints

    def rim_keys(self, faces: Ints, edge: Ints) -> Ints:
        """Return the (N,) keys of the sheets of some faces and of an edge of each."""
        return _rim_keys(self.sheet[faces], edge, self.edges)


def split_at_holes(mesh: WeldedMesh, sheets: FlatSheets) -> Ints:
    """Return the (F,) number of what is connected without crossing the rim of a hole of a flat sheet."""
    left, right = mesh.solid_neighbors
    edge = _shared_edges(mesh, left, right)
    cut = np.isin(sheets.rim_keys(left, edge), sheets.rims) | np.isin(sheets.rim_keys(right, edge), sheets.rims)
    return connected_groups(len(mesh.faces), left[~cut], right[~cut])[mesh.duplicate_of]


def find_flat_sheets(mesh: WeldedMesh) -> FlatSheets:
    """Return the flat sheets of a mesh, and the rims of their holes."""
    left, right = mesh.solid_neighbors
    flat = (mesh.normals[left] * mesh.normals[right]).sum(axis=1) >= FLAT_COS
    sheet = connected_groups(len(mesh.faces), left[flat], right[flat])
    alive = np.flatnonzero((mesh.duplicate_of == np.arange(len(mesh.faces))) & (mesh.areas > 0.0))
    faces, count = mesh.faces[alive], len(mesh.points)
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
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
    """Return the (N,) keys of sheets and edges."""
    found: Ints = sheet * len(edges) + np.searchsorted(edges, edge)
    return found


def _shared_edges(mesh: WeldedMesh, left: Ints, right: Ints) -> Ints:
    """Return the (N,) key of the edge that each pair of faces shares."""
    a, b = mesh.faces[left], mesh.faces[right]
    lone = np.argmin((a[:, :, None] == b[:, None, :]).any(axis=2), axis=1)
    rows = np.arange(len(a))
    ends = np.sort(np.column_stack([a[rows, (lone + 1) % 3], a[rows, (lone + 2) % 3]]), axis=1)
    found: Ints = ends[:, 0] * len(mesh.points) + ends[:, 1]
    return found
