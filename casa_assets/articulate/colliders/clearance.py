"""Cut collision shapes back where a moving part passes them, because shapes are coarser than the visible mesh.

Only shallow overlaps are cut: there the coarse shapes, or two coplanar faces, are the cause. A deep overlap means that
the part really runs into another, which no cut may hide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from casa_assets.articulate.colliders.empty_regions import is_empty_region
from casa_assets.articulate.colliders.link_shapes import box_cloud
from casa_assets.core.rotation import about_axis
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.hull import hull_volume

# Link and shape that would be cut, link and shape that asks for it.
Pair = tuple[int, int, int, int]

# Overlaps up to this deep are left alone; those up to the next (or that part of the whole) are cut; metres.
MIN_OVERLAP_M, MAX_CUT_DEPTH_M, MAX_CUT_DEPTH_SHARE = 0.0001, 0.012, 0.02
# Left between a part and what it passes: where two touch that cannot give way, friction holds them.
CLEARANCE_M = 0.0004
# Shares of the range at which a part is looked at; close to shut it matters most.
SAMPLED_SHARES = (0.02, 0.05, 0.09, 0.14, 0.2, 0.28, 0.38, 0.5, 0.62, 0.75, 0.88, 1.0)
# Shapes that are smaller than this are not worth one.
MIN_SHAPE_M3, MIN_SHAPE_M = 1e-8, 0.001
MAX_CUTS = 3
HIDDEN_CUT_FACTOR = 2.5
CROSSING_SHARE = 0.6
# A notch takes at most this part of an edge's width, and one way no more than the second.
MAX_NOTCH_SHARE, SHALLOW_NOTCH_SHARE = 0.5, 0.2
# A shape that would lose more than the rest of this is what it seems: it is not cut.
MIN_VOLUME_LEFT = 0.5


@dataclass
class LinkSolid:
    """The collision shapes of a link, in the closed pose and one common frame.

    Attributes:
        carrier: index of the link that carries it, None for the body.
        clouds: (N, 3) points of each convex shape, metres. grips: those of handles, which are never cut.
        turns: it turns about `axis` through `anchor`; else it slides along it. max_travel: end of its range, rad or m.
        behind: index of the link that stands open before this one moves, or None.
        skin: (N, 3) points of what is seen of it, metres, or None.
        hidden: it is seen only when something else is open, as racks on their rails are: deeper cuts are allowed.
    """

    carrier: int | None
    clouds: list[Floats]
    grips: list[Floats]
    turns: bool = False
    axis: Floats | None = None
    anchor: Floats | None = None
    max_travel: float = 0.0
    behind: int | None = None
    hidden: bool = False
    skin: Floats | None = None


def clear_moving_parts(solids: Sequence[LinkSolid]) -> None:
    """Cut the shapes of every link where another passes; in place."""
    points = np.concatenate([c for s in solids for c in s.clouds])
    whole = float(np.linalg.norm(np.ptp(points, axis=0)))
    deep = max(MAX_CUT_DEPTH_M, MAX_CUT_DEPTH_SHARE * whole)
    for i, solid in enumerate(solids):
        if solid.axis is None or not solid.clouds:
            continue
        pairs: dict[Pair, list[Floats]] = {}
        crossed: set[Pair] = set()
        _meet(solids, i, 0.0, pairs, crossed)
        at_rest = frozenset(pairs)
        for share in SAMPLED_SHARES:
            _meet(solids, i, share, pairs, crossed)
        cuts: dict[tuple[int, int], list[Floats]] = {}
        real: set[tuple[int, int]] = set()
        max_count = deep * (HIDDEN_CUT_FACTOR if solid.hidden else 1.0)
        for pair, boxes in sorted(pairs.items()):
            # What is shallow in one pose and deep in the next is a part on its way into another.
            shallow = all(float((b[1] - b[0]).min()) <= max_count for b in boxes)
            still = pair in at_rest
            air = still and pair[0] == 0 and is_empty_region(solids[0].skin, boxes)
            if air or (shallow and (still or pair not in crossed)):
                real |= set() if air else {pair[:2]}
                cuts.setdefault(pair[:2], []).extend(boxes)
        for (link, index), boxes in sorted(cuts.items(), reverse=True):
            least = MIN_VOLUME_LEFT if (link, index) in real else 0.0
            solids[link].clouds[index : index + 1] = _without(solids[link].clouds[index], boxes, least)


def _meet(
    solids: Sequence[LinkSolid],
    mover: int,
    share: float,
    pairs: dict[Pair, list[Floats]],
    crossed: set[Pair],
) -> None:
    """Record the overlaps while one link stands at a share of its range."""
    group = [k for k in range(len(solids)) if _carried(solids, k, mover)]
    stand = {k: _motion(solids, k, {mover: share}) for k in range(len(solids))}
    for a in group:
        for b in range(len(solids)):
            if b in group or not solids[a].clouds or not solids[b].clouds:
                continue
            ours = [_at(c, stand[a]) for c in (*solids[a].clouds, *solids[a].grips)]
            theirs = [_at(c, stand[b]) for c in solids[b].clouds]
            for p, q in _near(ours, theirs):
                notch = b == 0 and solids[mover].hidden and _is_notch(ours[p], theirs[q], solids[mover])
                # The larger shape loses the least.
                cut_theirs = notch or _bulk(theirs[q]) >= _bulk(ours[p]) or p >= len(solids[a].clouds)
                pair = (_swollen(ours[p]), theirs[q]) if cut_theirs else (ours[p], _swollen(theirs[q]))
                shared = _overlap(*pair)
                if shared is None:
                    continue
                link, index = (b, q) if cut_theirs else (a, p)
                turn, shift = stand[link]
                own = (shared - shift) @ turn
                box = np.array([own.min(axis=0), own.max(axis=0)])
                if float((box[1] - box[0]).min()) > MIN_OVERLAP_M:
                    key = (link, index, *((a, p) if cut_theirs else (b, q)))
                    if not notch and _crosses(box, ours[p], theirs[q], stand[link]):
                        crossed.add(key)
                    _note(pairs.setdefault(key, []), box)


def _is_notch(ours: Floats, theirs: Floats, mover: LinkSolid) -> bool:
    """Return whether a sliding part takes no more than a corner or a stretch of an edge of a shape as it passes."""
    shared = None if mover.turns or mover.axis is None else _overlap(_swollen(ours), theirs)
    if shared is None or mover.axis is None:
        return False
    lower, upper = theirs.min(axis=0), theirs.max(axis=0)
    share = np.ptp(shared, axis=0) / np.maximum(upper - lower, 1e-9)
    beside = [k for k in range(3) if k != int(np.argmax(np.abs(mover.axis)))]
    edge = (shared.min(axis=0) <= lower + CLEARANCE_M) | (shared.max(axis=0) >= upper - CLEARANCE_M)
    return (
        any(share[k] <= MAX_NOTCH_SHARE and edge[k] for k in beside)
        and min(float(share[k]) for k in beside) <= SHALLOW_NOTCH_SHARE
    )


def _crosses(box: Floats, one: Floats, other: Floats, stand: tuple[Floats, Floats]) -> bool:
    """Return whether an overlap, where it is thinnest, is most of one of two shapes: a bar running into a post."""
    turn, shift = stand
    thin = int(np.argmin(box[1] - box[0]))
    wide = min(float(np.ptp((c - shift) @ turn[:, thin])) for c in (one, other))
    return float(box[1][thin] - box[0][thin]) >= CROSSING_SHARE * wide


def _note(boxes: list[Floats], fresh: Floats) -> None:
    """Add a box, or grow one that it overlaps; in place."""
    for box in boxes:
        if (box[0] <= fresh[1] + CLEARANCE_M).all() and (fresh[0] <= box[1] + CLEARANCE_M).all():
            box[0], box[1] = np.minimum(box[0], fresh[0]), np.maximum(box[1], fresh[1])
            return
    boxes.append(fresh)


def _carried(solids: Sequence[LinkSolid], link: int | None, by: int) -> bool:
    """Return whether a link is another link, or is carried by it."""
    while link is not None:
        if link == by:
            return True
        link = solids[link].carrier
    return False


def _motion(solids: Sequence[LinkSolid], link: int, shares: dict[int, float]) -> tuple[Floats, Floats]:
    """Return the (3, 3) rotation and (3,) shift of a link while some links stand at shares of their ranges."""
    for mover in list(shares):
        before = solids[mover].behind
        if before is not None and before not in shares:
            shares = {**shares, before: 1.0}
    turn, shift = np.eye(3), np.zeros(3)
    at: int | None = link
    while at is not None:
        solid = solids[at]
        if at in shares and solid.axis is not None and solid.anchor is not None:
            if solid.turns:
                own = about_axis(solid.axis, solid.max_travel * shares[at])
                own_shift = solid.anchor - own @ solid.anchor
            else:
                own, own_shift = np.eye(3), solid.axis * solid.max_travel * shares[at]
            turn, shift = own @ turn, own @ shift + own_shift
        at = solid.carrier
    return turn, shift


def _swollen(cloud: Floats) -> Floats:
    """Return a cloud enlarged by the gap on every side."""
    middle = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
    found: Floats = np.concatenate([cloud, cloud + np.sign(cloud - middle) * CLEARANCE_M])
    return found


def _bulk(cloud: Floats) -> float:
    """Return the volume of the bounding box of a cloud."""
    return float(np.prod(np.ptp(cloud, axis=0)))


def _at(cloud: Floats, motion: tuple[Floats, Floats]) -> Floats:
    """Return a cloud moved by a rotation and a shift."""
    found: Floats = cloud @ motion[0].T + motion[1]
    return found


def _near(ours: list[Floats], theirs: list[Floats]) -> list[tuple[int, int]]:
    """Return the pairs whose boxes overlap, or nearly do."""
    a, b = (np.array([[c.min(axis=0), c.max(axis=0)] for c in side]) for side in (ours, theirs))
    over = (a[:, None, 0] < b[None, :, 1] + CLEARANCE_M) & (b[None, :, 0] < a[:, None, 1] + CLEARANCE_M)
    return [(int(p), int(q)) for p, q in np.argwhere(over.all(axis=2))]


def _overlap(one: Floats, other: Floats) -> Floats | None:
    """Return the (N, 3) corners of the intersection of two convex clouds, or None."""
    both = manifold3d.Manifold.hull_points(one) ^ manifold3d.Manifold.hull_points(other)
    if both.is_empty() or both.volume() < 1e-12:
        return None
    return np.array(both.to_mesh64().vert_properties[:, :3], dtype=np.float64)


def _without(cloud: Floats, boxes: list[Floats], least: float) -> list[Floats]:
    """Subtract boxes from a convex cloud; return it whole where less than a share of it would be left."""
    left = [cloud]
    for box in _merged(boxes, cloud):
        left = [piece for c in left for piece in subtract_box(c, box)]
    return left if sum(hull_volume(c) for c in left) >= least * hull_volume(cloud) else [cloud]


def _merged(boxes: list[Floats], cloud: Floats) -> list[Floats]:
    """Merge boxes until at most three are left."""
    out = list(boxes)
    limit = 0.25 * float(np.prod(np.ptp(cloud, axis=0)))
    while len(out) > 1:
        grown = [
            (float(np.prod(np.maximum(out[i][1], out[j][1]) - np.minimum(out[i][0], out[j][0]))), i, j)
            for i in range(len(out))
            for j in range(i + 1, len(out))
        ]
        least, i, j = min(grown)
        if len(out) <= MAX_CUTS and least > limit:
            break
        joined = np.array([np.minimum(out[i][0], out[j][0]), np.maximum(out[i][1], out[j][1])])
        out = [b for k, b in enumerate(out) if k not in (i, j)] + [joined]
    return out


def subtract_box(cloud: Floats, box: Floats) -> list[Floats]:
    """Subtract one box, (2, 3) corners, from a convex cloud; return up to six convex slabs."""
    lower, upper = cloud.min(axis=0), cloud.max(axis=0)
    if (box[0] >= upper).any() or (box[1] <= lower).any():
        return [cloud]
    solid = manifold3d.Manifold.hull_points(cloud)
    a, b = lower - 1e-3, upper + 1e-3
    out: list[Floats] = []
    # Thick slabs first: the side on which most is left.
    order = sorted(
        (-(box[0][k] - lower[k] if s == 0 else upper[k] - box[1][k]), k, s) for k in range(3) for s in (0, 1)
    )
    for room, axis, side in order:
        if room >= 0:
            continue
        start, stop = a.copy(), b.copy()
        if side == 0:
            stop[axis] = min(stop[axis], box[0][axis])
            a[axis] = box[0][axis]
        else:
            start[axis] = max(start[axis], box[1][axis])
            b[axis] = box[1][axis]
        if (stop <= start).any():
            continue
        slab = manifold3d.Manifold.hull_points(box_cloud(start, stop)) ^ solid
        if slab.is_empty() or slab.volume() < MIN_SHAPE_M3:
            continue
        points = np.array(slab.to_mesh64().vert_properties[:, :3], dtype=np.float64)
        if np.ptp(points, axis=0).min() >= MIN_SHAPE_M and hull_volume(points) > 0:
            out.append(points)
    return out
