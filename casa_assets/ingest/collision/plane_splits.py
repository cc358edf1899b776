"""Cut a solid at planes into pieces that are nearly convex; planes are scored without cutting."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.deviation import ReferenceSurface, burial_depths, inside_share, protrusion
from casa_assets.mesh.solid.solids import (
    Solid,
    connected_parts,
    hull_points,
    hull_volume,
    split_by_plane,
    surface_of,
    volume_of_hull,
)
from casa_assets.mesh.surface import connected_groups, directed_edges, edge_counts, face_normals

# With more pieces than these on one side that side is taken as one.
MOST_PIECES = 24
# Steps in which normals and offsets (of the longest side) of faces at hollow edges are counted as one plane.
NORMAL_STEP, OFFSET_STEP = 0.05, 0.01
# An edge is hollow where its faces turn towards each other by more than this sine.
CONCAVE_SINE, MIN_PIECE_SHARE = 0.3, 1e-5
# All numbers below are choices.
# Planes that are tried across each axis.
OFFSETS = 7
# Planes through concave edges that are tried besides.
CONCAVE_PLANES = 8
# The best planes are tried in turn until one leaves parts enough.
MAX_TRIED_PLANES = 4
# Shares of the spacing by which the best plane is moved, to see whether it gets better.
OFFSET_REFINEMENTS = (0.5, 0.25)
# Variances along two principal axes that differ by less than this share of the largest count as equal.
DISTINCT_SPREAD_SHARE = 0.02
# Parts smaller than this share of the volume are crumbs of the cut and are dropped.
MIN_PART_SHARE = 1e-5
# A solid of more components than this is cut without separating the components of each half.
MAX_LOOSE_PARTS = 8
# Pairs of parts for which one common hull is tried, the cheapest first.
MAX_MERGE_TRIES = 60
# Largest share of the volume that a hull holds beyond its part which may be left once that part was cut.
MAX_LEFT_EXCESS = 0.9
# A part is cut this many times in turn before it is said that cutting does not help: the first of a ring gains nothing.
MAX_BLIND_CUTS = 2
# Where the best plane gains less than this share of the hull, one through the middle of the longest way is taken.
MIN_GAIN = 0.005
# Share of the volume by which one part more has to make hulls better, where they are near enough, or a merger may cost.
PART_WORTH = 0.004
# Share of the whole volume that a merger may always add.
FREE_MERGE_COST = 1e-3


@dataclass(frozen=True)
class Plane:
    """Places x with normal . x = offset; the normal has unit length, metres."""

    normal: Floats
    offset: float


def split_hull_volume(points: Floats, edges: Ints, plane: Plane) -> tuple[float, int]:
    """Volume of the hulls, m^3, and their number, if a plane cut a closed surface of (P, 3) points and (E, 2) edges."""
    above = points @ plane.normal - plane.offset
    side = above > 0
    if side.all() or not side.any():
        return np.inf, 1
    first, second = edges.T
    through = side[first] != side[second]
    kept = ~through
    label = connected_groups(len(above), first[kept], second[kept])
    one, other = first[through], second[through]
    share = above[one] / (above[one] - above[other])
    met = points[one] + share[:, None] * (points[other] - points[one])
    total, count = 0.0, 0
    for high in (True, False):
        ends = label[np.where(side[one] == high, one, other)]
        for piece in _pieces(points, label, side == high, met, ends, plane.normal):
            total += float(manifold3d.Manifold.hull_points(piece).volume())
            count += 1
    return total, count


def _pieces(
    points: Floats, label: Ints, here: npt.NDArray[np.bool_], met: Floats, ends: Ints, normal: Floats
) -> list[Floats]:
    """Points of each piece on one side: shells of the surface that the cut closes together are one."""
    shells = np.unique(label[here])
    if len(shells) == 1 or len(shells) > MOST_PIECES:
        return [np.concatenate([points[here], met])]
    across = np.linalg.svd(normal[None])[2][1:]
    flat = met @ across.T
    boxes = np.full((len(shells), 4), np.nan)
    for k, shell in enumerate(shells):
        mine = flat[ends == shell]
        if len(mine):
            boxes[k] = [*mine.min(axis=0), *mine.max(axis=0)]
    # A loop within another is the hole of what the cut closes.
    low, high = boxes[:, :2], boxes[:, 2:]
    within = (low[:, None] >= low[None]).all(axis=2) & (high[:, None] <= high[None]).all(axis=2)
    _, group = connected_components(coo_matrix(within), directed=False)
    out = []
    for g in range(int(group.max()) + 1):
        mine = shells[group == g]
        out.append(np.concatenate([points[here & np.isin(label, mine)], met[np.isin(ends, mine)]]))
    return out


def concave_edge_planes(points: Floats, faces: Ints, most: int) -> list[Plane]:
    """At most `most` planes of faces at concave edges, those with the longest edges first: built things part there."""
    normals, areas = face_normals(points, faces)
    directed = directed_edges(faces)
    ends = np.sort(directed, axis=1)
    order = np.lexsort(ends.T[::-1])
    pairs = order.reshape(-1, 2) if len(order) % 2 == 0 else np.zeros((0, 2), dtype=np.int64)
    pairs = pairs[(ends[pairs[:, 0]] == ends[pairs[:, 1]]).all(axis=1)]
    left, right = pairs[:, 0] % len(faces), pairs[:, 1] % len(faces)
    along = points[directed[pairs[:, 0], 1]] - points[directed[pairs[:, 0], 0]]
    turn = np.einsum("ij,ij->i", np.cross(normals[left], normals[right]), along)  # sine times length; < 0 where hollow
    length = np.linalg.norm(along, axis=1)
    hollow = turn < -CONCAVE_SINE * length
    face = np.concatenate([left[hollow], right[hollow]])
    if not len(face):
        return []
    weight = np.concatenate([-turn[hollow]] * 2)
    lying = areas[face] > 0
    face, weight = face[lying], weight[lying]
    longest = float(np.ptp(points, axis=0).max())
    # Of each normal the largest component by magnitude, the first of equals, is made positive.
    leading = np.argmax(np.abs(normals[face]).round(6), axis=1)
    side = np.where(normals[face, leading] < 0, -1.0, 1.0)
    normal = normals[face] * side[:, None]
    # A hair before the face: what is cut right along it keeps a film of it.
    offset = np.einsum("ij,ij->i", normal, points[faces[face, 0]]) + side * MIN_PIECE_SHARE * longest
    steps = np.column_stack([normal / NORMAL_STEP, offset / (OFFSET_STEP * longest)]).round().astype(np.int64)
    kinds, first, kind = np.unique(steps, axis=0, return_index=True, return_inverse=True)
    total = np.bincount(kind.ravel(), weights=weight, minlength=len(kinds)).round(9)
    best = np.lexsort([np.arange(len(kinds)), -total])[:most]
    return [Plane(normal[first[k]].round(9), round(float(offset[first[k]]), 9)) for k in best]


@dataclass(frozen=True)
class ErrorBound:
    """Bound on how far hulls reach beyond a solid, metres: for 95 % of their surface, and for all of it."""

    p95: float
    worst: float


@dataclass(frozen=True)
class Part:
    """A part of a solid, the volume of its hull, m^3, and the hull's error over its bound (1 or less fits)."""

    solid: Solid
    hull_volume: float
    normalized_error: float

    @property
    def weight(self) -> float:
        """Priority of being cut next: 0 where the hull fits, else larger for worse and larger parts."""
        return self.normalized_error * max(self.hull_volume, 0.0) ** (1 / 3) if self.normalized_error > 1 else 0.0


def split_to_bound(
    solids: Sequence[Solid], reference: ReferenceSurface, bound: ErrorBound, max_parts: int
) -> list[Solid]:
    """Split solids until the hulls of the parts lie within a bound, or there are `max_parts` of them.

    The part that fits worst is cut next: into its connected components, or else along the plane that leaves the least
    volume between the hulls and the solid. `reference`: of these solids, or of one that they are parts of.
    """
    min_volume_m3 = MIN_PART_SHARE * sum(float(s.volume()) for s in solids)
    parts = [_part(s, reference, bound) for s in solids]
    while len(parts) < max_parts:
        worst = max(range(len(parts)), key=lambda i: (round(parts[i].weight, 9), -i))
        if parts[worst].normalized_error <= 1:
            break
        pieces = _cut(parts[worst].solid, min_volume_m3, max_parts - len(parts) + 1, bound.p95)
        if len(pieces) < 2:
            parts[worst] = Part(parts[worst].solid, parts[worst].hull_volume, 0.0)  # cutting does not help
            continue
        parts[worst : worst + 1] = [_part(p, reference, bound) for p in pieces]
    return [part.solid for part in parts]


def split_to_volume(
    solids: Sequence[Solid],
    excess_m3: float,
    max_parts: int,
    min_slice_m: float,
    reduced: Callable[[Floats], Floats] = lambda cloud: cloud,
) -> list[Solid]:
    """Split solids until their hulls together are wrong by no more than `excess_m3`, or there are `max_parts`.

    Wrong is what a hull holds beyond its part, and what it lacks for having few vertices. The part whose hull is worst
    is cut next; what is near enough is cut on where that gains much, as of built things with flat sides. `min_slice_m`:
    no part is thinner across its cut. `reduced`: the vertices, (N, 3), that are left of those of a hull.
    """
    min_volume_m3 = MIN_PART_SHARE * sum(float(s.volume()) for s in solids)
    parts = list(solids)
    excess = [_hull_error(s, reduced) for s in solids]
    tried: list[Solid] = []
    left_m3 = 0.0  # of what was tried
    worth_m3 = PART_WORTH * sum(float(s.volume()) for s in solids)
    while parts and len(parts) + len(tried) < max_parts:
        worst = max(range(len(parts)), key=lambda i: (round(excess[i], 15), -i))
        is_near = sum(excess) + left_m3 <= excess_m3
        if is_near and excess[worst] <= worth_m3:
            break
        room = max_parts - len(parts) - len(tried) + 1
        pieces, found = _helpful_cut(parts[worst], excess[worst], min_volume_m3, room, min_slice_m, reduced)
        if len(pieces) < 2 or (is_near and excess[worst] - sum(found) < worth_m3 * (len(pieces) - 1)):
            tried.append(parts.pop(worst))  # cutting does not help
            left_m3 += excess.pop(worst)
            continue
        parts[worst : worst + 1] = pieces
        excess[worst : worst + 1] = found
    return [*parts, *tried]


def _helpful_cut(
    solid: Solid,
    error_m3: float,
    min_volume_m3: float,
    max_parts: int,
    min_slice_m: float,
    reduced: Callable[[Floats], Floats],
) -> tuple[list[Solid], list[float]]:
    """Parts with less error, and their errors, or the solid; the halves of a ring are cut once more to find them."""
    pieces = [solid]
    for _ in range(MAX_BLIND_CUTS):
        finer: list[Solid] = []
        for k, piece in enumerate(pieces):
            room = max_parts - len(finer) - (len(pieces) - k - 1)
            finer += _cut(piece, min_volume_m3, room, min_slice_m)
        if len(finer) == len(pieces):
            break
        pieces = finer
        errors = [_hull_error(p, reduced) for p in pieces]
        if sum(errors) <= MAX_LEFT_EXCESS * error_m3:
            return pieces, errors
    return [solid], [error_m3]


def _hull_error(solid: Solid, reduced: Callable[[Floats], Floats]) -> float:
    """Volume of the hull of a solid beyond it, and what the reduced hull lacks of that of the whole one, m^3."""
    return max(volume_of_hull([solid]) - float(solid.volume()), 0.0) + _lack(hull_points([solid]), reduced)


def _lack(cloud: Floats, reduced: Callable[[Floats], Floats]) -> float:
    few = reduced(cloud)
    return max(hull_volume(cloud) - hull_volume(few), 0.0) if len(few) < len(cloud) else 0.0


def _part(solid: Solid, reference: ReferenceSurface, bound: ErrorBound) -> Part:
    return Part(solid, volume_of_hull([solid]), normalized_error(hull_points([solid]), reference, bound))


def normalized_error(cloud: Floats, reference: ReferenceSurface, bound: ErrorBound) -> float:
    """Error of the hull of a cloud over its bound: how far it reaches beyond a solid, or buries its surface."""
    try:
        errors = [e for e in (protrusion(cloud, reference), burial_depths(cloud, reference)) if len(e)]
    except DegenerateShape:
        return 0.0
    ratios = [max(float(np.percentile(e, 95)) / bound.p95, float(e.max()) / bound.worst) for e in errors]
    return max(ratios, default=0.0)


def _cut(solid: Solid, min_volume_m3: float, max_parts: int, min_slice_m: float) -> list[Solid]:
    """Connected parts of a solid, else the parts on both sides of the best plane; at most `max_parts`, or the solid."""
    components = connected_parts(solid, min_volume_m3)
    if 2 <= len(components) <= max_parts:
        return components
    for plane in _best_planes(solid, max_parts, min_slice_m):
        parts = [half for half in split_by_plane(solid, plane.normal, plane.offset) if half.volume() > min_volume_m3]
        if len(components) <= MAX_LOOSE_PARTS:
            parts = [p for half in parts for p in connected_parts(half, min_volume_m3)]
        if 2 <= len(parts) <= max_parts:
            return parts
    return [solid]


def _best_planes(solid: Solid, max_parts: int, min_slice_m: float) -> list[Plane]:
    """Planes that leave the least volume between the hulls of the parts and the solid, the best first."""
    points, faces = surface_of(solid)
    edges, whole_volume = edge_counts(faces)[0], volume_of_hull([solid])

    def thinner_half(plane: Plane) -> float:
        along = points @ plane.normal - plane.offset
        return min(float(along.max()), -float(along.min()))

    def gain(plane: Plane) -> float:
        if thinner_half(plane) < min_slice_m:
            return -np.inf
        parts_volume, count = split_hull_volume(points, edges, plane)
        if count > max_parts:
            return -np.inf
        # The number of parts is limited, so a plane that makes more of them has to gain more.
        share = (whole_volume - parts_volume) / whole_volume
        return round(share / float(max(count - 1, 1) ** 0.5), 6)

    axis_planes = _axis_planes(points)
    steps = [step for _, step in axis_planes] + [0.0] * CONCAVE_PLANES
    planes = [plane for plane, _ in axis_planes] + concave_edge_planes(points, faces, CONCAVE_PLANES)
    gains = [gain(plane) for plane in planes]
    if max(gains, default=-np.inf) < MIN_GAIN:
        longest = float(np.ptp(points, axis=0).max())
        gains = [
            MIN_GAIN * round(thinner_half(plane) / longest, 6) if np.isfinite(g) else g
            for g, plane in zip(gains, planes, strict=True)
        ]
    order = sorted(range(len(planes)), key=lambda k: (-gains[k], k))[:MAX_TRIED_PLANES]
    best_plane, best_gain, step = planes[order[0]], gains[order[0]], steps[order[0]]
    for share in OFFSET_REFINEMENTS:
        for side in (-1, 1):
            candidate = Plane(best_plane.normal, best_plane.offset + side * share * step)
            if step > 0 and (candidate_gain := gain(candidate)) > best_gain:
                best_plane, best_gain = candidate, candidate_gain
    return [best_plane, *(planes[k] for k in order)] if np.isfinite(best_gain) else []


def _axis_planes(points: Floats) -> list[tuple[Plane, float]]:
    """Evenly spaced planes across the coordinate axes and the principal axes of the points, with their spacing."""
    spread, axes = np.linalg.eigh(np.cov(points.T))
    normals = [np.eye(3)[k] for k in range(3)]
    for k in range(3):
        # Principal axes of equal variance depend on rounding errors alone.
        if min(abs(spread[k] - spread[j]) for j in range(3) if j != k) < DISTINCT_SPREAD_SHARE * spread[2]:
            continue
        axis = axes[:, k] * np.sign(axes[np.argmax(np.abs(axes[:, k]).round(6)), k])
        if max(float(np.abs(axis @ n)) for n in normals[:3]) < 0.995:
            normals.append(axis.round(6))
    planes = []
    for normal in normals:
        along = points @ normal
        lowest, step = float(along.min()), float(np.ptp(along)) / (OFFSETS + 1)
        planes += [(Plane(normal, lowest + (k + 1) * step), step) for k in range(OFFSETS)]
    return planes


def merge_within_bound(
    solids: Sequence[Solid],
    reference: ReferenceSurface,
    bound: ErrorBound,
    opening_points: Floats,
    excess_m3: float = np.inf,
    reduced: Callable[[Floats], Floats] = lambda cloud: cloud,
) -> list[list[Solid]]:
    """Group solids that get one hull each: neighbours go together where their hull stays within the bound.

    `excess_m3`: by which all hulls together may be wrong; what they are before is always granted. `reduced`: as in
    `split_to_volume`. `opening_points`: (N, 3) in the opening of a vessel, which a common hull may not fill.
    """
    groups = {k: [solid] for k, solid in enumerate(solids)}
    sizes = {k: volume_of_hull(group) for k, group in groups.items()}
    boxes = {k: _box(group) for k, group in groups.items()}
    whole_volume = sum(sizes.values())
    lacks = {k: _lack(hull_points(group), reduced) for k, group in groups.items()}
    # What merging may still add, as a share of the whole volume.
    spent_m3 = whole_volume - sum(float(s.volume()) for s in solids) + sum(lacks.values())
    allowance = max(excess_m3 - spent_m3, 0.0) / whole_volume
    costs: dict[tuple[int, int], float] = {}
    tried = 0
    new_groups = list(groups)
    while True:
        for i, j in ((i, j) for i in groups for j in groups if i < j and (i in new_groups or j in new_groups)):
            if (np.maximum(boxes[i][0], boxes[j][0]) <= np.minimum(boxes[i][1], boxes[j][1]) + reference.spacing).all():
                costs[i, j] = round((volume_of_hull(groups[i] + groups[j]) - sizes[i] - sizes[j]) / whole_volume, 9)
        new_groups = []
        while costs and tried < MAX_MERGE_TRIES:
            i, j = min(costs, key=lambda pair: (costs[pair], pair))
            cost = costs.pop((i, j))
            if cost > max(min(allowance, PART_WORTH), FREE_MERGE_COST):
                continue
            tried += 1
            cloud = hull_points(groups[i] + groups[j])
            lack = _lack(cloud, reduced)
            cost += (lack - lacks[i] - lacks[j]) / whole_volume
            if cost > max(min(allowance, PART_WORTH), FREE_MERGE_COST):
                continue
            if normalized_error(cloud, reference, bound) > 1:
                continue
            # No common hull fills more than a tenth of an opening.
            if len(opening_points) and inside_share(opening_points, [cloud]) > 0.1:
                continue
            allowance -= max(cost, 0.0)
            merged = max(groups) + 1
            groups[merged] = groups.pop(i) + groups.pop(j)
            sizes[merged], boxes[merged] = volume_of_hull(groups[merged]), _box(groups[merged])
            lacks[merged] = lack
            costs = {pair: cost for pair, cost in costs.items() if not {i, j} & {*pair}}
            new_groups = [merged]
            break
        if not new_groups:
            return list(groups.values())


def _box(solids: Sequence[Solid]) -> tuple[Floats, Floats]:
    boxes = np.array([solid.bounding_box() for solid in solids])
    return boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)
