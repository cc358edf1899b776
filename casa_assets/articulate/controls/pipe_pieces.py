"""Pieces of a faucet as straight pipes: their axes, and which of them touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.segment.fragments import MeasuredFragments
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.surface import connected_groups

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
        rows = sorted(among)
        pairs = [(rows.index(i), rows.index(j)) for i, j in self.touch if i in rows and j in rows]
        label = connected_groups(len(rows), *np.array(pairs, dtype=np.int64).reshape(-1, 2).T).tolist()
        return [[r for r, k in zip(rows, label, strict=True) if k == n] for n in dict.fromkeys(label)]

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
