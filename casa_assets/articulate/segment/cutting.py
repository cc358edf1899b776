"""Cut triangles along bounded planes, and close the holes that this leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import manifold3d
import numpy as np

from casa_assets.articulate.plan import PartKind, PartPlan
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.surface import directed_edges
from casa_assets.model.asset.parts import Mesh

# An edge is not cut nearer to its ends than this share of its length, which would leave slivers.
MIN_END_SHARE = 1e-4
# Planes reach this far beyond their limits, diagonals, so that two that meet leave no edge between them uncut.
PLANE_OVERLAP = 1e-6
# Parts that are closed with a board; other parts cut from a shell are closed where they were cut off.
BOARD_KINDS = frozenset({PartKind.DOOR, PartKind.DRAWER, PartKind.LID})
# A board has a back of its own if its faces that look back are this share of its front; the body behind it stays open.
MIN_BACK_SHARE = 0.15
# Borders deeper than this behind the back of a board belong to its box, diagonals.
MAX_BORDER_DEPTH = 0.05


@dataclass(frozen=True)
class CutPlane:
    """A bounded cutting plane: the rectangle on which one of (right, up, depth) of a side has a given value.

    Attributes:
        side: of SIDES. axis: 0, 1 or 2 of its (right, up, depth). at: the value there.
        lower, upper: (3,) limits in (right, up, depth); those along `axis` do not count.
    """

    side: int
    axis: int
    at: float
    lower: Floats
    upper: Floats


@dataclass(frozen=True)
class CutTriangles:
    """Triangles after cutting.

    Attributes:
        new_points: for each plane that cut: (a, b, share) of its new points, each `a + share * (b - a)`; they are
            numbered on from the last point.
        faces: (F', 3). parent: (F',) triangle of which each is a part, ascending.
    """

    new_points: tuple[tuple[Ints, Ints, Floats], ...]
    faces: Ints
    parent: Ints

    def interpolate(self, values: Floats) -> Floats:
        """Return (P', k) values at the old and the new points, from (P, k) values at the old ones."""
        out = values
        for a, b, share in self.new_points:
            out = np.concatenate([out, out[a] + share[:, None] * (out[b] - out[a])])
        return out

    def interpolate_mesh(self, mesh: Mesh, faces: Ints) -> Mesh:
        """Return a mesh with other faces over its old and the new points, every vertex attribute interpolated."""
        normals, colors = mesh.normals, mesh.colors
        if normals is not None:
            normals = self.interpolate(normals)
            normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        return Mesh(
            vertices=self.interpolate(mesh.vertices),
            faces=faces.astype(np.int32),
            uv=None if mesh.uv is None else self.interpolate(mesh.uv),
            normals=normals,
            colors=None if colors is None else np.rint(self.interpolate(colors.astype(np.float64))).astype(np.uint8),
        )


def cut_triangles(points: Floats, faces: Ints, planes: Sequence[CutPlane]) -> CutTriangles:
    """Cut triangles wherever an edge meets a plane; triangles that share an edge share the new point.

    Args:
        points: (P, 3) in the frame. faces: (F, 3).
    """
    made: list[tuple[Ints, Ints, Floats]] = []
    parent = np.arange(len(faces))
    for plane in planes:
        found = _cut(points, faces, plane)
        if found is None:
            continue
        (a, b, share), faces, kept = found
        points = np.concatenate([points, points[a] + share[:, None] * (points[b] - points[a])])
        parent = parent[kept]
        made.append((a, b, share))
    order = np.argsort(parent, kind="stable")
    return CutTriangles(tuple(made), faces[order], parent[order])


def _cut(points: Floats, faces: Ints, plane: CutPlane) -> tuple[tuple[Ints, Ints, Floats], Ints, Ints] | None:
    """Return new points, triangles, and the parent of each triangle; None if the plane cuts nothing.

    New points are given by the ends (a, b) of the edges that they lie on, and their share of the way from a to b.
    """
    axes = SIDES[plane.side]
    level = points @ axes[plane.axis] - plane.at
    over = level[faces] > 0
    near = np.flatnonzero(over.any(axis=1) & ~over.all(axis=1))
    ends = np.sort(directed_edges(faces[near]), axis=1)
    ends, place = np.unique(ends, axis=0, return_inverse=True)
    a, b = ends[:, 0], ends[:, 1]
    fall = level[b] - level[a]
    share = np.where(np.abs(fall) > 1e-15, -level[a] / np.where(fall == 0, 1.0, fall), -1.0)
    at = (points[a] + share[:, None] * (points[b] - points[a])) @ axes.T
    others = [i for i in range(3) if i != plane.axis]
    inside = ((at >= plane.lower - PLANE_OVERLAP) & (at <= plane.upper + PLANE_OVERLAP))[:, others].all(axis=1)
    good = inside & (share > MIN_END_SHARE) & (share < 1 - MIN_END_SHARE)
    if not good.any():
        return None
    number = np.full(len(ends), -1, dtype=np.int64)
    number[good] = len(points) + np.arange(int(good.sum()))
    middle = number[place.reshape(3, -1).T]
    fresh, kept = _pieces(faces[near], middle)
    rest = np.ones(len(faces), dtype=bool)
    rest[near] = False
    whole = np.flatnonzero(rest)
    return ((a[good], b[good], share[good]), np.concatenate([faces[whole], fresh]), np.concatenate([whole, near[kept]]))


def _pieces(faces: Ints, middle: Ints) -> tuple[Ints, Ints]:
    """Split triangles at the points on their edges (-1 for none; at most two have one); also return their parents."""
    count = (middle >= 0).sum(axis=1)
    none = np.flatnonzero(count == 0)
    one = np.flatnonzero(count == 1)
    two = np.flatnonzero(count == 2)
    p, m = _turned(faces[one], middle[one], np.argmax(middle[one] >= 0, axis=1) if len(one) else one)
    single = [np.stack([p[:, 0], m[:, 0], p[:, 2]], axis=1), np.stack([m[:, 0], p[:, 1], p[:, 2]], axis=1)]
    # Turn those with two so that the edge without a point comes last: the corner between the cut edges is the second.
    bare = (np.argmin(middle[two], axis=1) + 1) % 3 if len(two) else two
    q, n = _turned(faces[two], middle[two], bare)
    double = [
        np.stack([n[:, 0], q[:, 1], n[:, 1]], axis=1),
        np.stack([q[:, 0], n[:, 0], n[:, 1]], axis=1),
        np.stack([q[:, 0], n[:, 1], q[:, 2]], axis=1),
    ]
    return np.concatenate([faces[none], *single, *double]), np.concatenate([none, one, one, two, two, two])


def _turned(faces: Ints, middle: Ints, first: Ints) -> tuple[Ints, Ints]:
    """Renumber corners and edge points from another first corner; edge i runs from corner i to the next."""
    order = (np.asarray(first)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(faces, order, axis=1), np.take_along_axis(middle, order, axis=1)


@dataclass(frozen=True)
class CapFaces:
    """Faces that close cuts.

    Attributes:
        points: (P, 3) in the frame. faces: (F, 3) over them. owner: (F,) place of the part in the list, -1 the body.
    """

    points: Floats
    faces: Ints
    owner: Ints


def close_cuts(mesh: WeldedMesh, owner: Ints, parts: Sequence[PartPlan], backs: Mapping[int, float]) -> CapFaces:
    """Make the faces that close every part against what it was cut from.

    Args:
        mesh: cut, in the frame. owner: (F,) part of each face, -1 the body.
        backs: depth of the back of each board, seen from the front, by its place in `parts`.
    """
    edges, own_part, other_part = _border_edges(mesh, owner)
    depth = mesh.points @ SIDES[FRONT][2]
    points: list[Floats] = []
    faces: list[Ints] = []
    owners: list[Ints] = []
    for i, part in enumerate(parts):
        board = i in backs
        rows = np.flatnonzero(own_part == i)
        rows = rows[
            [(other_part[r] < 0 or parts[other_part[r]].kind in BOARD_KINDS) if board else True for r in rows.tolist()]
        ]
        if board:
            rows = rows[(depth[edges[rows]] <= backs[i] + MAX_BORDER_DEPTH).all(axis=1)]
        elif part.kind in BOARD_KINDS:
            continue
        normal = SIDES[FRONT][2] if board else _inward_direction(part)
        level = float(max(backs[i], depth[edges[rows]].max(initial=backs[i]))) if board else None
        shape, walls = _cap_border(mesh.points, edges[rows], normal, level)
        if not len(shape[1]):
            continue
        far = int(np.bincount(other_part[rows] + 1).argmax()) - 1
        own = owner == i
        facing = mesh.normals @ SIDES[FRONT][2]
        front_area = float(mesh.areas[own & (facing < -0.8)].sum())
        open_back = board and float(mesh.areas[own & (facing > 0.8)].sum()) >= MIN_BACK_SHARE * front_area
        against = shape[1][:walls] if open_back else shape[1]
        start = sum(len(p) for p in points)
        points.append(shape[0])
        faces += [shape[1] + start, against[:, ::-1] + start]
        owners += [np.full(len(shape[1]), i), np.full(len(against), -1 if board else far)]
    if not points:
        return CapFaces(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64))
    return CapFaces(np.concatenate(points), np.concatenate(faces), np.concatenate(owners).astype(np.int64))


def _border_edges(mesh: WeldedMesh, owner: Ints) -> tuple[Ints, Ints, Ints]:
    """Return edges between faces of two owners, both ways: (E, 2) points, the owner, the other owner."""
    alive = np.flatnonzero((mesh.areas > 0) & (mesh.duplicate_of == np.arange(len(mesh.faces))))
    corners = mesh.faces[alive]
    directed = directed_edges(corners)
    part_of = np.tile(owner[alive], 3)
    ends = np.sort(directed, axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    same = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    first = np.flatnonzero(same)
    alone = np.ones(len(first), dtype=bool)
    alone[1:] &= np.diff(first) > 1
    alone[:-1] &= np.diff(first) > 1
    a, b = order[first[alone]], order[first[alone] + 1]
    differ = part_of[a] != part_of[b]
    a, b = a[differ], b[differ]
    return (
        np.concatenate([directed[a], directed[b]]),
        np.concatenate([part_of[a], part_of[b]]),
        np.concatenate([part_of[b], part_of[a]]),
    )


def _inward_direction(part: PartPlan) -> Floats:
    """Return the direction from a small part into what carries it: that of the front or of the top."""
    axis = np.abs(np.array(part.joint.axis))
    return np.asarray(SIDES[TOP if axis[2] > 0.7 else FRONT][2])


def _cap_border(points: Floats, edges: Ints, normal: Floats, level: float | None) -> tuple[tuple[Floats, Ints], int]:
    """Return points and faces that close a border, walls first, and the number of wall faces.

    Args:
        edges: (E, 2) as the part's faces have them. normal: the way in which the faces look.
        level: how deep along it the border is drawn before it is filled, None to fill it where it is.
    """
    nothing = (np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)), 0
    loops = _chain_loops(edges)
    if not loops:
        return nothing
    rim = points[np.concatenate(loops)]
    drawn = rim if level is None else rim + np.outer(np.maximum(level - rim @ normal, 0.0), normal)
    right = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.5 else [0.0, 1.0, 0.0])
    plane = np.stack([right, np.cross(normal, right)], axis=1)
    sizes = [len(loop) for loop in loops]
    starts = np.cumsum([0, *sizes])
    rings = [(drawn @ plane)[a:b] for a, b in pairwise(starts.tolist())]
    ways = [(x * np.roll(y, -1) - y * np.roll(x, -1)).sum() for x, y in (ring.T for ring in rings)]
    if sum(float(way) for way in ways) <= 0:  # twice the area, of rings that run clockwise negative
        return nothing
    fill = np.asarray(manifold3d.triangulate(rings), dtype=np.int64).reshape(-1, 3)
    if level is None:
        return (rim, fill), 0
    count = len(rim)
    following = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in pairwise(starts.tolist())])
    ring = np.arange(count)
    walls = np.concatenate(
        [
            np.stack([ring, following, following + count], axis=1),
            np.stack([ring, following + count, ring + count], axis=1),
        ]
    )
    return (np.concatenate([rim, drawn]), np.concatenate([walls, fill + count])), len(walls)


def _chain_loops(edges: Ints) -> list[Ints]:
    """Chain border edges into closed rings of points, wound as the faces that close them need."""
    after: dict[int, list[int]] = {}
    for a, b in edges.tolist():
        after.setdefault(b, []).append(a)
    out = []
    for start in sorted(after):
        while after.get(start):
            ring = [start]
            while after.get(ring[-1]):
                following = after[ring[-1]].pop()
                if following == start:
                    break
                ring.append(following)
            else:
                continue
            if len(ring) >= 3:
                out.append(np.array(ring, dtype=np.int64))
    return out
