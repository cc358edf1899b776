"""Measure the fragments of a mesh, find where they touch, and the axis of those that are turned on a lathe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.segment.orthographic import (
    SIDES,
    DepthImage,
    render_depth,
)
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.deviation import samples_with_faces

# Fragment measures ----------------------------------------------------------------------------------------------------
# Measure each fragment of a mesh: bounding box, surface area, and the area that is visible from each of six sides.

PIXELS = 512


@dataclass(frozen=True)
class MeasuredFragments:
    """All fragments of a mesh with their measures, in the frame of the object (diagonal 1).

    Attributes:
        label: (F,) fragment of each face, -1 for none.
        lower, upper: (N, 3) corners of each. area: (N,) surface.
        visible_area: (N, 6) area of its picture from each of SIDES. depth_images: those pictures, of faces.
    """

    mesh: WeldedMesh
    label: Ints
    lower: Floats
    upper: Floats
    area: Floats
    visible_area: Floats
    depth_images: tuple[DepthImage, ...]

    @property
    def count(self) -> int:
        """Return the number of fragments."""
        return len(self.area)

    def faces_of(self, fragments: Sequence[int]) -> Ints:
        """Return the ascending indices of the faces of some fragments."""
        mask = np.zeros(self.count + 1, dtype=bool)
        mask[list(fragments)] = True
        return np.flatnonzero(mask[self.label] & (self.label >= 0))

    def box(self, fragments: Sequence[int]) -> tuple[Floats, Floats]:
        """Return the (3,) lower and upper corner of the box around some fragments."""
        rows = list(fragments)
        return self.lower[rows].min(axis=0), self.upper[rows].max(axis=0)

    def render_alone(self, fragments: Sequence[int], side: int, pixels: int) -> DepthImage:
        """Render some fragments without the others, from one of SIDES."""
        used, local = np.unique(self.mesh.faces[self.faces_of(fragments)], return_inverse=True)
        return render_depth(self.mesh.points[used], local.reshape(-1, 3), SIDES[side], pixels)

    def points_of(self, fragments: Sequence[int]) -> Floats:
        """Return the (P, 3) points that some fragments use."""
        return self.mesh.points[np.unique(self.mesh.faces[self.faces_of(fragments)])]


def corners_of_labels(mesh: WeldedMesh, label: Ints) -> tuple[Floats, Floats]:
    """Return the (N, 3) lower and upper corners of the faces of each label.

    Args:
        label: (F,) label of each face, -1 for none. A label that no face has gets corners of inf and -inf.
    """
    count = int(label.max(initial=-1)) + 1
    alive = label >= 0
    corners = mesh.points[mesh.faces[alive]]
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(lower, label[alive], corners.min(axis=1))
    np.maximum.at(upper, label[alive], corners.max(axis=1))
    return lower, upper


def render_sides(mesh: WeldedMesh, pixels: int = PIXELS) -> tuple[DepthImage, ...]:
    """Render a mesh that is in the frame from each of SIDES."""
    return tuple(render_depth(mesh.points, mesh.faces, axes, pixels) for axes in SIDES)


def measure_fragments(
    mesh: WeldedMesh, label: Ints, pixels: int = PIXELS, images: tuple[DepthImage, ...] | None = None
) -> MeasuredFragments:
    """Measure the fragments of a mesh that is in the frame, from rendered depth images of six sides.

    Args:
        label: (F,) fragment of each face. images: those of `render_sides`, None to render them.
    """
    lower, upper = corners_of_labels(mesh, label)
    count = len(lower)
    alive = np.flatnonzero(label >= 0)
    area = np.bincount(label[alive], mesh.areas[alive], count).astype(np.float64)
    images = render_sides(mesh, pixels) if images is None else images
    seen = np.zeros((count, len(SIDES)))
    for i, image in enumerate(images):
        visible = label[image.face[image.face >= 0]]
        seen[:, i] = np.bincount(visible[visible >= 0], minlength=count) * image.pixel**2
    return MeasuredFragments(mesh, label, lower, upper, area, seen, images)


def corners_from_side(measured: MeasuredFragments, side: int) -> tuple[Floats, Floats]:
    """Return the (N, 3) lower and upper corners of fragments in the axes of a side: right, up, depth."""
    axes = SIDES[side]
    a, b = measured.lower @ axes.T, measured.upper @ axes.T
    return np.minimum(a, b), np.maximum(a, b)


# Contacts -------------------------------------------------------------------------------------------------------------
# Sample the fragments of a mesh, find where they touch, and the axis of those that are turned on a lathe.

# Samples of all fragments together, and the fewest and most of one.
TOTAL_SAMPLES, MIN_SAMPLES, MAX_SAMPLES = 6000, 80, 900
# Samples of two fragments that are nearer than this touch, diagonals; so do nearer ones than 1.5 times the spacing.
TOUCH_DISTANCE, TOUCH_BY_SPACING = 0.006, 1.5
# Fragments whose boxes and areas agree within this, diagonals and a share, are the two sides of one sheet.
SAME_BOX, SAME_AREA = 1e-3, 0.02
# An axis within 3 degrees of one of the frame is that one.
STRAIGHT_COS = 0.9986
# A surface is turned where its normals miss the axis by less than this sine, root mean square, of the faces that look
# at right angles to it within 60 degrees; of those there are this many samples. Ref: a regular prism of 6 sides has
# 0.29, of 8 sides 0.22, a square one 0.46.
MAX_MISS_SINE, MIN_SIDE_SINE, MIN_SIDE_SAMPLES = 0.32, 0.5, 4


@dataclass(frozen=True)
class Axis:
    """A line in the frame: (3,) a point of it and its (3,) unit direction; `radius` is what it turns, diagonals."""

    origin: Floats
    direction: Floats
    radius: float

    def distance(self, points: Floats) -> Floats:
        """Return the (N,) distances of points from the line."""
        away = points - self.origin
        return np.asarray(np.linalg.norm(away - np.outer(away @ self.direction, self.direction), axis=1))

    def along(self, points: Floats) -> Floats:
        """Return the (N,) coordinates of points along the line."""
        return (points - self.origin) @ self.direction


@dataclass(frozen=True)
class Piece:
    """A fragment, or the fragments of both sides of one sheet, with samples of its surface.

    Attributes:
        fragments: ascending. lower, upper: (3,) corners. points, normals: (S, 3) of the samples.
        spacing: between samples, diagonals.
    """

    fragments: tuple[int, ...]
    lower: Floats
    upper: Floats
    points: Floats
    normals: Floats
    area: float
    spacing: float

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree of the samples."""
        return cKDTree(self.points)

    @cached_property
    def middle(self) -> Floats:
        """Return the (3,) centre of its surface."""
        return np.asarray(self.points.mean(axis=0))

    @cached_property
    def turned(self) -> Axis | None:
        """Return the axis about which its surface is turned, or None if it is not a surface of revolution.

        The axis of a turned surface passes through its centre along a principal direction, or along an axis of the
        frame if the principal directions are ambiguous.
        """
        away = self.points - self.middle
        directions = np.concatenate([np.linalg.eigh(away.T @ away)[1].T, np.eye(3)])
        misses = [_miss(away, self.normals, d) for d in directions]
        best = int(np.argmin(np.round(misses, 6)))
        if misses[best] > MAX_MISS_SINE:
            return None
        direction = directions[best]
        largest = int(np.argmax(np.abs(direction)))
        straight = abs(float(direction[largest])) > STRAIGHT_COS
        direction = np.eye(3)[largest] if straight else direction * np.sign(direction[largest])
        radius = np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
        origin = (self.lower + self.upper) / 2 if straight else self.middle
        return Axis(origin, direction, float(np.percentile(radius, 95)))


def _miss(away: Floats, normals: Floats, direction: Floats) -> float:
    """Return the sine by which normals miss an axis through the origin, root mean square of the faces along it."""
    across = away - np.outer(away @ direction, direction)
    radius = np.linalg.norm(across, axis=1)
    level = np.sqrt(np.maximum(1 - (normals @ direction) ** 2, 0.0))
    side = (level > MIN_SIDE_SINE) & (radius > 0.1 * float(radius.max()))
    if int(side.sum()) < MIN_SIDE_SAMPLES:
        return 1.0
    sine = (np.cross(across[side], direction) * normals[side]).sum(axis=1) / (radius[side] * level[side])
    return float(np.sqrt((sine**2).mean()))


@dataclass(frozen=True)
class PieceGraph:
    """Pieces and where they touch.

    Attributes:
        touch: (C, 3) points at which piece i touches piece j, for i < j.
    """

    pieces: tuple[Piece, ...]
    touch: dict[tuple[int, int], Floats]

    def neighbours(self, piece: int) -> list[int]:
        """Return the pieces that touch one, ascending."""
        return sorted({j if i == piece else i for i, j in self.touch if piece in (i, j)})

    def between(self, some: Sequence[int], others: Sequence[int]) -> Floats:
        """Return the (C, 3) points at which some pieces touch others."""
        pairs = [(min(i, j), max(i, j)) for i in some for j in others if i != j]
        found = [self.touch[p] for p in pairs if p in self.touch]
        return np.concatenate(found) if found else np.empty((0, 3))

    def groups(self, among: Sequence[int]) -> list[list[int]]:
        """Return the groups of connected pieces among some, each ascending."""
        left, found = set(among), []
        for start in sorted(among):
            if start not in left:
                continue
            left.discard(start)
            group, todo = [start], [start]
            while todo:
                for other in self.neighbours(todo.pop()):
                    if other in left:
                        left.discard(other)
                        group.append(other)
                        todo.append(other)
            found.append(sorted(group))
        return found

    def path(self, start: int, end: int) -> list[int]:
        """Return the shortest path from one piece to another over touching pieces; empty if they are not connected."""
        came = {start: start}
        todo = [start]
        while todo and end not in came:
            fresh = []
            for piece in todo:
                for other in self.neighbours(piece):
                    if other not in came:
                        came[other] = piece
                        fresh.append(other)
            todo = fresh
        if end not in came:
            return []
        way = [end]
        while way[-1] != start:
            way.append(came[way[-1]])
        return way[::-1]

    def fragments_of(self, pieces: Sequence[int]) -> list[int]:
        """Return the ascending fragments of some pieces."""
        return sorted(f for p in pieces for f in self.pieces[p].fragments)


def piece_graph(measured: MeasuredFragments) -> PieceGraph:
    """Return the pieces of a mesh in the frame, and where they touch."""
    total = max(float(measured.area.sum()), 1e-12)
    pieces = []
    for fragments in _sheets(measured):
        area = float(measured.area[fragments[0]])
        count = int(np.clip(TOTAL_SAMPLES * area / total, MIN_SAMPLES, MAX_SAMPLES))
        rows = measured.faces_of(fragments[:1])
        points, face = samples_with_faces(measured.mesh.points, measured.mesh.faces[rows], count)
        spacing = float(np.sqrt(area / count))
        normals = measured.mesh.normals[rows[face]]
        pieces.append(Piece(tuple(fragments), *measured.box(fragments), points, normals, area, spacing))
    touch = {}
    for i, first in enumerate(pieces):
        for j in range(i + 1, len(pieces)):
            found = _touching(first, pieces[j])
            if len(found):
                touch[i, j] = found
    return PieceGraph(tuple(pieces), touch)


def _sheets(measured: MeasuredFragments) -> list[list[int]]:
    """Group fragments that are the two sides of one sheet; each group is ascending."""
    found: list[list[int]] = []
    for i in np.flatnonzero(measured.area > 0.0).tolist():
        for group in found:
            k = group[0]
            apart = max(
                float(np.abs(measured.lower[i] - measured.lower[k]).max()),
                float(np.abs(measured.upper[i] - measured.upper[k]).max()),
            )
            if apart <= SAME_BOX and abs(measured.area[i] / measured.area[k] - 1) <= SAME_AREA:
                group.append(i)
                break
        else:
            found.append([i])
    return found


def _touching(a: Piece, b: Piece) -> Floats:
    """Return the (C, 3) samples of two pieces that lie near the other."""
    reach = max(TOUCH_DISTANCE, TOUCH_BY_SPACING * min(a.spacing, b.spacing))
    if ((a.lower > b.upper + reach) | (b.lower > a.upper + reach)).any():
        return np.empty((0, 3))
    near_b = a.points[b.tree.query(a.points, distance_upper_bound=reach)[0] < reach]
    near_a = b.points[a.tree.query(b.points, distance_upper_bound=reach)[0] < reach]
    return np.concatenate([near_b, near_a])
