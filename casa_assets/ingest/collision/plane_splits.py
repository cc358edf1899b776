"""Split a solid by planes until the hulls of the parts fit, and merge neighbours that can share one hull."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.solid.cutting import (
    Solid,
    connected_parts,
    hull_points,
    split_by_plane,
    surface_of,
    volume_of_hull,
)
from casa_assets.geometry.solid.deviation import ReferenceSurface, burial_depths, protrusion
from casa_assets.geometry.solid.hull import hull_planes
from casa_assets.geometry.solid.split_planes import Plane, concave_edge_planes, edge_graph, split_hull_volume

# Places along each axis where a cut is tried.
OFFSETS = 7
# Planes of faces along hollow edges that are tried, planes that are cut along until one does, shares of the spacing by
# which the best one is moved.
HOLLOW_PLANES = 8
TRIED_PLANES = 4
OFFSET_REFINEMENTS = (0.5, 0.25)
# Spreads along two axes that differ by less than this share of the largest are the same.
DISTINCT_SPREAD_SHARE = 0.02
# Parts smaller than this share of the whole are crumbs that cutting left.
MIN_PART_SHARE = 1e-5
# More parts than these that do not hang together are a heap.
MAX_LOOSE_PARTS = 8
# Pairs of parts that are tried as one, the most promising first.
MOST_TRIES = 60


@dataclass(frozen=True)
class ErrorBound:
    """Bound on how far hulls reach beyond a solid, metres: for 95 % of their surface, and for all of it."""

    p95: float
    worst: float


@dataclass(frozen=True)
class Part:
    """A part of a solid: volume of its hull, m^3, and how much worse than allowed the hull fits, 1 or less is well."""

    solid: Solid
    hull: float
    normalized_error: float

    @property
    def weight(self) -> float:
        """Priority of being cut next: 0 where the hull fits, else larger for worse and larger parts."""
        return self.normalized_error * max(self.hull, 0.0) ** (1 / 3) if self.normalized_error > 1 else 0.0


def split_to_bound(solids: Sequence[Solid], of: ReferenceSurface, bound: ErrorBound, most: int) -> list[Solid]:
    """Split solids until the hulls of the parts lie within a bound, or there are `most` of them.

    The part that fits worst is cut next: into what does not hang together, or else along the plane that leaves the
    least room between the hulls and the solid.

    Args:
        of: the surface that the hulls are held against, of these solids or of one that they are parts of.
    """
    least = MIN_PART_SHARE * sum(float(s.volume()) for s in solids)
    done = [_part(s, of, bound) for s in solids]
    while len(done) < most:
        worst = max(range(len(done)), key=lambda i: (round(done[i].weight, 9), -i))
        if done[worst].normalized_error <= 1:
            break
        pieces = _cut(done[worst].solid, least, most - len(done) + 1, bound.p95)
        if len(pieces) < 2:
            done[worst] = Part(done[worst].solid, done[worst].hull, 0.0)  # cutting does not help
            continue
        done[worst : worst + 1] = [_part(p, of, bound) for p in pieces]
    return [part.solid for part in done]


def _part(solid: Solid, of: ReferenceSurface, bound: ErrorBound) -> Part:
    return Part(solid, volume_of_hull([solid]), normalized_error(hull_points([solid]), of, bound))


def normalized_error(cloud: Floats, of: ReferenceSurface, bound: ErrorBound) -> float:
    """Error of the hull of a cloud over its bound: how far it reaches beyond a solid, or buries its surface."""
    try:
        errors = [e for e in (protrusion(cloud, of), burial_depths(cloud, of)) if len(e)]
    except DegenerateShape:
        return 0.0
    strains = [max(float(np.percentile(e, 95)) / bound.p95, float(e.max()) / bound.worst) for e in errors]
    return max(strains, default=0.0)


def _cut(solid: Solid, least: float, room: int, thin: float) -> list[Solid]:
    """Connected parts of a solid, else the parts on both sides of the best plane; at most `room`, or the solid."""
    loose = connected_parts(solid, least)
    if 2 <= len(loose) <= room:
        return loose
    for plane in _best_planes(solid, room, thin):
        both = [half for half in split_by_plane(solid, plane.normal, plane.offset) if half.volume() > least]
        # Of a heap of pieces the halves stay heaps.
        found = both if len(loose) > MAX_LOOSE_PARTS else [p for half in both for p in connected_parts(half, least)]
        if 2 <= len(found) <= room:
            return found
    return [solid]


def _best_planes(solid: Solid, room: int, thin: float) -> list[Plane]:
    """Planes that leave the least room between the hulls of the parts and the solid, the best first.

    Args:
        thin: no slice is thinner, metres.
    """
    points, faces = surface_of(solid)
    of, whole = edge_graph(points, faces), volume_of_hull([solid])

    def gain(plane: Plane) -> float:
        along = points @ plane.normal - plane.offset
        if min(float(along.max()), -float(along.min())) < thin:
            return -np.inf
        size, count = split_hull_volume(of, plane)
        # Parts are few: what takes more of them has to gain more.
        return round((whole - size) / whole / max(count - 1, 1) ** 0.5, 6) if count <= room else -np.inf

    spaced = _planes(points)
    steps = [step for _, step in spaced] + [0.0] * HOLLOW_PLANES
    planes = [plane for plane, _ in spaced] + concave_edge_planes(points, faces, HOLLOW_PLANES)
    gains = [gain(plane) for plane in planes]
    order = sorted(range(len(planes)), key=lambda k: (-gains[k], k))[:TRIED_PLANES]
    first = planes[order[0]]
    found, best = first, gains[order[0]]
    for share in OFFSET_REFINEMENTS:
        for side in (-1, 1):
            near = Plane(found.normal, found.offset + side * share * steps[order[0]])
            if steps[order[0]] > 0 and (value := gain(near)) > best:
                found, best = near, value
    return [found, *(planes[k] for k in order)] if np.isfinite(best) else []


def _planes(points: Floats) -> list[tuple[Plane, float]]:
    """Planes across the axes of the frame and of the points, evenly spaced between their ends, and that spacing."""
    spread, axes = np.linalg.eigh(np.cov(points.T))
    normals = [np.eye(3)[k] for k in range(3)]
    for k in range(3):
        # Where two directions are as wide, their axes are an accident of the arithmetic.
        if min(abs(spread[k] - spread[j]) for j in range(3) if j != k) < DISTINCT_SPREAD_SHARE * spread[2]:
            continue
        axis = axes[:, k] * np.sign(axes[np.argmax(np.abs(axes[:, k]).round(6)), k])
        if max(float(np.abs(axis @ n)) for n in normals[:3]) < 0.995:
            normals.append(axis.round(6))
    planes = []
    for normal in normals:
        along = points @ normal
        low, step = float(along.min()), float(np.ptp(along)) / (OFFSETS + 1)
        planes += [(Plane(normal, low + (k + 1) * step), step) for k in range(OFFSETS)]
    return planes


def merge_within_bound(
    groups: Sequence[Solid], of: ReferenceSurface, bound: ErrorBound, room: Floats
) -> list[list[Solid]]:
    """Group solids that get one hull each: neighbours together where that keeps within the bound.

    Args:
        room: (N, 3) places that no joining may fill, those of the opening of a vessel.
    """
    sets = {k: [solid] for k, solid in enumerate(groups)}
    sizes = {k: volume_of_hull(one) for k, one in sets.items()}
    boxes = {k: _box(one) for k, one in sets.items()}
    whole = sum(sizes.values())
    costs: dict[tuple[int, int], float] = {}
    tried = 0
    fresh = list(sets)
    while True:
        for i, j in ((i, j) for i in sets for j in sets if i < j and (i in fresh or j in fresh)):
            if (np.maximum(boxes[i][0], boxes[j][0]) <= np.minimum(boxes[i][1], boxes[j][1]) + of.spacing).all():
                costs[i, j] = round((volume_of_hull(sets[i] + sets[j]) - sizes[i] - sizes[j]) / whole, 9)
        fresh = []
        while costs and tried < MOST_TRIES:
            i, j = min(costs, key=lambda pair: (costs[pair], pair))
            del costs[i, j]
            tried += 1
            cloud = hull_points(sets[i] + sets[j])
            if normalized_error(cloud, of, bound) <= 1 and not _fills(cloud, room):
                new = max(sets) + 1
                sets[new] = sets.pop(i) + sets.pop(j)
                sizes[new], boxes[new] = volume_of_hull(sets[new]), _box(sets[new])
                costs = {pair: cost for pair, cost in costs.items() if not {i, j} & {*pair}}
                fresh = [new]
                break
        if not fresh:
            return list(sets.values())


def _box(solids: Sequence[Solid]) -> tuple[Floats, Floats]:
    boxes = np.array([solid.bounding_box() for solid in solids])
    return boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)


def _fills(cloud: Floats, room: Floats) -> bool:
    """More than a tenth of some places lie within the hull of a cloud."""
    if not len(room):
        return False
    planes = hull_planes(cloud)
    return bool(((room @ planes[:, :3].T + planes[:, 3]).round(9) < 0).all(axis=1).mean() > 0.1)
