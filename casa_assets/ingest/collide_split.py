"""Solids cut by planes until the hulls of the parts lie close to it, and parts that may be one again joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.errors import DegenerateShape
from casa_assets.geometry.cutting import Solid, halves, hull_points, hull_size, parts, surface_of
from casa_assets.geometry.deviation import Ruler, excess
from casa_assets.geometry.hull import hull_planes

Floats = npt.NDArray[np.float64]

# Places along each axis where a cut is tried.
OFFSETS = 7
# Spreads along two axes that differ by less than this share of the largest are the same.
DISTINCT = 0.02
# Parts smaller than this share of the whole are crumbs that cutting left.
CRUMB = 1e-5
# More parts than these that do not hang together are a heap.
HEAP = 8
# Pairs of parts that are tried as one, the most promising first.
MOST_TRIES = 60


@dataclass(frozen=True)
class Bound:
    """How far hulls may reach beyond a solid, metres: 95 % of their surface, and all of it."""

    p95: float
    worst: float


@dataclass(frozen=True)
class Part:
    """A part of a solid: volume of its hull, m^3, and how much worse than allowed the hull fits, 1 or less is well."""

    solid: Solid
    hull: float
    strain: float

    @property
    def weight(self) -> float:
        """What makes a part the next to be cut: it has to fit badly, and large ones come first."""
        return self.strain * self.hull ** (1 / 3) if self.strain > 1 else 0.0


def split_up(solids: Sequence[Solid], of: Ruler, bound: Bound, most: int) -> list[Solid]:
    """Parts of solids whose hulls lie within a bound, or `most` of them (or as many as there are solids).

    The part that fits worst is cut next: into what does not hang together, or else along the plane that leaves the
    least room between the hulls and the solid.

    Args:
        of: the surface that the hulls are held against, of these solids or of one that they are parts of.
    """
    least = CRUMB * sum(float(s.volume()) for s in solids)
    done = [_part(s, of, bound) for s in solids]
    while len(done) < most:
        worst = max(range(len(done)), key=lambda i: (round(done[i].weight, 9), -i))
        if done[worst].strain <= 1:
            break
        pieces = _cut(done[worst].solid, least, most - len(done) + 1)
        if len(pieces) < 2:
            done[worst] = Part(done[worst].solid, done[worst].hull, 0.0)  # cutting does not help
            continue
        done[worst : worst + 1] = [_part(p, of, bound) for p in pieces]
    return [part.solid for part in done]


def _part(solid: Solid, of: Ruler, bound: Bound) -> Part:
    return Part(solid, hull_size([solid]), strain(hull_points([solid]), of, bound))


def strain(cloud: Floats, of: Ruler, bound: Bound) -> float:
    """How many times the bound the hull of a cloud reaches beyond a solid."""
    try:
        values, _ = excess(cloud, of)
    except DegenerateShape:
        return 0.0
    return max(float(np.percentile(values, 95)) / bound.p95, float(values.max()) / bound.worst)


def _cut(solid: Solid, least: float, room: int) -> list[Solid]:
    """What does not hang together, else the parts on both sides of the best plane; at most `room`, or the solid."""
    points, _ = surface_of(solid)
    loose = parts(solid, least)
    if 2 <= len(loose) <= room:
        return loose
    best: tuple[float, int, list[Solid]] | None = None
    for number, (normal, offset) in enumerate(_planes(points)):
        both = [half for half in halves(solid, normal, offset) if half.volume() > least]
        # Of a heap of pieces the halves stay heaps.
        found = both if len(loose) > HEAP else [p for half in both for p in parts(half, least)]
        if not 2 <= len(found) <= room:
            continue
        size = sum(hull_size([p]) for p in found)
        key = (round(size / max(hull_size([solid]), 1e-30), 6), number)
        if best is None or key < best[:2]:
            best = (*key, found)
    return [solid] if best is None else best[2]


def _planes(points: Floats) -> list[tuple[Floats, float]]:
    """Planes across the three axes of the frame and the three of the points, evenly spaced between their ends."""
    spread, axes = np.linalg.eigh(np.cov(points.T))
    normals = [np.eye(3)[k] for k in range(3)]
    for k in range(3):
        # Where two directions are as wide, their axes are an accident of the arithmetic.
        if min(abs(spread[k] - spread[j]) for j in range(3) if j != k) < DISTINCT * spread[2]:
            continue
        axis = axes[:, k] * np.sign(axes[np.argmax(np.abs(axes[:, k]).round(6)), k])
        if max(float(np.abs(axis @ n)) for n in normals[:3]) < 0.995:
            normals.append(axis.round(6))
    planes = []
    for normal in normals:
        along = points @ normal
        low, high = float(along.min()), float(along.max())
        planes += [(normal, low + (k + 1) / (OFFSETS + 1) * (high - low)) for k in range(OFFSETS)]
    return planes


def joined(groups: Sequence[Solid], of: Ruler, bound: Bound, room: Floats) -> list[list[Solid]]:
    """Solids in groups that get one hull each, neighbours together where that keeps within the bound.

    Args:
        room: (N, 3) places that no joining may fill, those of the opening of a vessel.
    """
    sets = {k: [solid] for k, solid in enumerate(groups)}
    sizes = {k: hull_size(one) for k, one in sets.items()}
    boxes = {k: _box(one) for k, one in sets.items()}
    whole = sum(sizes.values())
    costs: dict[tuple[int, int], float] = {}
    tried = 0
    fresh = list(sets)
    while True:
        for i, j in ((i, j) for i in sets for j in sets if i < j and (i in fresh or j in fresh)):
            if (np.maximum(boxes[i][0], boxes[j][0]) <= np.minimum(boxes[i][1], boxes[j][1]) + of.spacing).all():
                costs[i, j] = round((hull_size(sets[i] + sets[j]) - sizes[i] - sizes[j]) / whole, 9)
        fresh = []
        while costs and tried < MOST_TRIES:
            i, j = min(costs, key=lambda pair: (costs[pair], pair))
            del costs[i, j]
            tried += 1
            cloud = hull_points(sets[i] + sets[j])
            if strain(cloud, of, bound) <= 1 and not _fills(cloud, room):
                new = max(sets) + 1
                sets[new] = sets.pop(i) + sets.pop(j)
                sizes[new], boxes[new] = hull_size(sets[new]), _box(sets[new])
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
