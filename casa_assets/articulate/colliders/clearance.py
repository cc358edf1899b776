"""Cut collision shapes back where a moving part passes them, because shapes are coarser than the visible mesh.

Only shallow overlaps are cut: there the coarse shapes, or two coplanar faces, are the cause. A deep overlap means that
the part really runs into another, and is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from casa_assets.articulate.colliders.link_shapes import box_cloud
from casa_assets.core.numeric import Floats, about_axis
from casa_assets.mesh.solid.solids import hull_volume

# Link and shape that would be cut, then link and shape that run into it.
Pair = tuple[int, int, int, int]

# Overlaps up to MIN_OVERLAP_M are left alone; those up to MAX_CUT_DEPTH_M, or that share of the diagonal of all links,
# are cut.
MIN_OVERLAP_M, MAX_CUT_DEPTH_M, MAX_CUT_DEPTH_SHARE = 0.0001, 0.012, 0.02
# Gap left between a part and what it passes: shapes that touch would be held by friction.
CLEARANCE_M = 0.0004
# Shares of the range at which overlaps are sampled, densest near the closed pose, where parts fit most tightly.
SAMPLED_SHARES = (0.02, 0.05, 0.09, 0.14, 0.2, 0.28, 0.38, 0.5, 0.62, 0.75, 0.88, 1.0)
# Poses of one turn whose hull stands for all that a part passes which turns round and round: between two of them a
# corner leaves the hull by less than 2 % of its distance from the axis.
TURN_POSES = 16
# Smaller shapes are dropped: volume, and thickness.
MIN_SHAPE_M3, MIN_SHAPE_M = 1e-8, 0.001
# Boxes that are subtracted from one shape.
MAX_CUTS = 3
# Cuts may be this many times deeper where a link lies behind a front.
BEHIND_FRONT_CUT_FACTOR = 2.5
# An overlap this thick, by the thinner of two shapes, means that one runs through the other.
CROSSING_SHARE = 0.6
# A notch takes at most the first share of the width of a shape, and no more than the second in one direction.
MAX_NOTCH_SHARE, SHALLOW_NOTCH_SHARE = 0.5, 0.2
# A shape that stands for visible matter keeps at least this share of its volume, else it is not cut.
MIN_VOLUME_LEFT = 0.5
# The shapes of a link end no farther short of what is seen than this, or than this share of its longest side where that
# is more: nine tenths of collider_bounds_m and collider_bounds_ratio in registry/limits.yaml (AST009).
MAX_SHORTFALL_M, MAX_SHORTFALL_SHARE = 0.0036, 0.018
# Visible surface this near to the side of an empty box bounds it, if that side has at least this share of the surface.
BOUND_TOLERANCE_M, MIN_SIDE_SHARE = 0.0005, 0.15
# Visible surface farther inside a box than this share of its size lies in it, and does not bound it.
INNER_MARGIN_SHARE = 0.25


@dataclass
class LinkSolid:
    """The collision shapes of a link, in the closed pose and one common frame.

    Attributes:
        carrier: index of the link that carries it, None for the body.
        clouds: (N, 3) points of each convex shape, metres. grips: the same for handles, which are never cut.
        turns: whether it turns about `axis` through `anchor`, or slides along `axis`. max_travel: end of its range, rad
            or m.
        blocking_link: index of the link that must be open before this one moves, or None.
        skin: (N, 3) points of its visible surface, metres, or None.
        is_behind_front: it is visible only when a front is open, like a rack on its rails: deeper cuts are allowed.
        spins: it turns without end stops, so nothing may be in its way.
        is_whole: its single shape is never cut; the shapes that it meets are cut instead. A knob or a key would lose
            the surface that fingers hold.
    """

    carrier: int | None
    clouds: list[Floats]
    grips: list[Floats]
    turns: bool = False
    axis: Floats | None = None
    anchor: Floats | None = None
    max_travel: float = 0.0
    blocking_link: int | None = None
    is_behind_front: bool = False
    spins: bool = False
    is_whole: bool = False
    skin: Floats | None = None


def clear_moving_parts(solids: Sequence[LinkSolid]) -> None:
    """Cut the shapes of every link where another passes; in place."""
    points = np.concatenate([c for s in solids for c in s.clouds])
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    max_cut_depth = max(MAX_CUT_DEPTH_M, MAX_CUT_DEPTH_SHARE * diagonal)
    for i, solid in enumerate(solids):
        if solid.axis is None or not solid.clouds:
            continue
        pairs: dict[Pair, list[Floats]] = {}
        crossed: set[Pair] = set()
        _record_overlaps(solids, i, 0.0, pairs, crossed)
        at_rest = frozenset(pairs)
        for share in () if solid.spins else SAMPLED_SHARES:
            _record_overlaps(solids, i, share, pairs, crossed)
        cuts: dict[tuple[int, int], list[Floats]] = {}
        matter: set[tuple[int, int]] = set()
        max_depth = max_cut_depth * (BEHIND_FRONT_CUT_FACTOR if solid.is_behind_front else 1.0)
        for pair, boxes in sorted(pairs.items()):
            # An overlap that is shallow in one pose and deep in the next is a part on its way into another.
            shallow = all(float((b[1] - b[0]).min()) <= max_depth for b in boxes)
            is_at_rest = pair in at_rest
            is_empty = is_at_rest and pair[0] == 0 and is_empty_region(solids[0].skin, boxes)
            if is_empty or (shallow and (is_at_rest or solid.spins or pair not in crossed)):
                matter |= set() if is_empty else {pair[:2]}
                cuts.setdefault(pair[:2], []).extend(boxes)
        for (link, index), boxes in sorted(cuts.items(), reverse=True):
            min_left = MIN_VOLUME_LEFT if (link, index) in matter else 0.0
            _cut(solids[link], index, boxes, min_left)


def _cut(solid: LinkSolid, index: int, boxes: list[Floats], min_left: float) -> None:
    """Subtract boxes from one shape of a link, unless its shapes would then fall short of what is seen; in place."""
    if solid.is_whole:
        return
    clouds, cloud = solid.clouds.copy(), solid.clouds[index]
    rest = [cloud]
    for box in _merge_boxes(boxes, cloud):
        rest = [slab for c in rest for slab in subtract_box(c, box)]
    # It stays whole where less than a share of it would be left.
    if sum(hull_volume(c) for c in rest) >= min_left * hull_volume(cloud):
        clouds[index : index + 1] = rest
    if _still_fits(solid, clouds):
        solid.clouds = clouds


def _still_fits(solid: LinkSolid, clouds: list[Floats]) -> bool:
    """Return whether a link with other shapes reaches as far as what is seen of it, where it did before.

    Ref: AST009 for the box, and AST008 for the spread of mass, which lies in a sheet over what is seen.
    """
    if solid.skin is None or not len(solid.skin):
        return True
    new, old = (_bounds([*shapes, *solid.grips]) for shapes in (clouds, solid.clouds))
    seen = np.array([solid.skin.min(axis=0), solid.skin.max(axis=0)])
    slack = max(MAX_SHORTFALL_M, MAX_SHORTFALL_SHARE * float(np.ptp(seen, axis=0).max()))
    short = np.array([new[0] - np.maximum(seen[0], old[0]), np.minimum(seen[1], old[1]) - new[1]])
    half, spread = np.ptp(new, axis=0) / 2, solid.skin.std(axis=0)
    return bool((short <= slack).all() and ((half >= spread) | (np.ptp(old, axis=0) / 2 < spread)).all())


def _bounds(clouds: Sequence[Floats]) -> Floats:
    """Return the (2, 3) corners of the box around clouds; of none it is empty."""
    lower = np.min([c.min(axis=0) for c in clouds], axis=0, initial=np.inf)
    return np.array([lower, np.max([c.max(axis=0) for c in clouds], axis=0, initial=-np.inf)])


def _record_overlaps(
    solids: Sequence[LinkSolid], mover: int, share: float, pairs: dict[Pair, list[Floats]], crossed: set[Pair]
) -> None:
    """Record the overlaps of one link with the others when it is at a given share of its range."""
    moving = [k for k in range(len(solids)) if _is_carried_by(solids, k, mover)]
    poses = {k: _pose_at(solids, k, {mover: share}) for k in range(len(solids))}
    for a in moving:
        for b in range(len(solids)):
            if b in moving or not solids[a].clouds or not solids[b].clouds:
                continue
            moving_clouds = [_transform(c, poses[a]) for c in (*solids[a].clouds, *solids[a].grips)]
            axis, anchor = solids[mover].axis, solids[mover].anchor
            if solids[mover].spins and axis is not None and anchor is not None:
                # In every pose of a turn about its axis.
                turns = [about_axis(axis, 2.0 * np.pi * k / TURN_POSES) for k in range(TURN_POSES)]
                moving_clouds = [np.concatenate([(c - anchor) @ t.T + anchor for t in turns]) for c in moving_clouds]
            other_clouds = [_transform(c, poses[b]) for c in solids[b].clouds]
            for p, q in _overlapping_pairs(moving_clouds, other_clouds):
                notch = (
                    b == 0
                    and solids[mover].is_behind_front
                    and _is_notch(moving_clouds[p], other_clouds[q], solids[mover])
                )
                # The larger of the two shapes is cut: it loses the smaller share.
                is_larger = _bounding_volume(other_clouds[q]) >= _bounding_volume(moving_clouds[p])
                is_kept = solids[a].is_whole or p >= len(solids[a].clouds)
                cuts_other = notch or is_kept or (is_larger and not solids[b].is_whole)
                pair = (
                    (_inflate(moving_clouds[p]), other_clouds[q])
                    if cuts_other
                    else (moving_clouds[p], _inflate(other_clouds[q]))
                )
                shared = overlap(*pair)
                if shared is None:
                    continue
                link, index = (b, q) if cuts_other else (a, p)
                rotation, translation = poses[link]
                local = (shared - translation) @ rotation
                box = np.array([local.min(axis=0), local.max(axis=0)])
                if float((box[1] - box[0]).min()) > MIN_OVERLAP_M:
                    key = (link, index, *((a, p) if cuts_other else (b, q)))
                    if not notch and _crosses(box, moving_clouds[p], other_clouds[q], poses[link]):
                        crossed.add(key)
                    _add_box(pairs.setdefault(key, []), box)


def _is_notch(cloud: Floats, other: Floats, mover: LinkSolid) -> bool:
    """Return whether a sliding part takes no more than a corner or a stretch of an edge of a shape as it passes."""
    shared = None if mover.turns or mover.axis is None else overlap(_inflate(cloud), other)
    if shared is None or mover.axis is None:
        return False
    lower, upper = other.min(axis=0), other.max(axis=0)
    share = np.ptp(shared, axis=0) / np.maximum(upper - lower, 1e-9)
    beside = [k for k in range(3) if k != int(np.argmax(np.abs(mover.axis)))]
    edge = (shared.min(axis=0) <= lower + CLEARANCE_M) | (shared.max(axis=0) >= upper - CLEARANCE_M)
    return (
        any(share[k] <= MAX_NOTCH_SHARE and edge[k] for k in beside)
        and min(float(share[k]) for k in beside) <= SHALLOW_NOTCH_SHARE
    )


def _crosses(box: Floats, first: Floats, second: Floats, pose: tuple[Floats, Floats]) -> bool:
    """Return whether an overlap, where it is thinnest, is most of one of two shapes: a bar running into a post."""
    rotation, translation = pose
    axis = int(np.argmin(box[1] - box[0]))
    width = min(float(np.ptp((c - translation) @ rotation[:, axis])) for c in (first, second))
    return float(box[1][axis] - box[0][axis]) >= CROSSING_SHARE * width


def _add_box(boxes: list[Floats], new: Floats) -> None:
    """Add a box, or grow one that it overlaps; in place."""
    for box in boxes:
        if (box[0] <= new[1] + CLEARANCE_M).all() and (new[0] <= box[1] + CLEARANCE_M).all():
            box[0], box[1] = np.minimum(box[0], new[0]), np.maximum(box[1], new[1])
            return
    boxes.append(new)


def _is_carried_by(solids: Sequence[LinkSolid], link: int | None, by: int) -> bool:
    """Return whether a link is another link, or is carried by it."""
    while link is not None:
        if link == by:
            return True
        link = solids[link].carrier
    return False


def _pose_at(solids: Sequence[LinkSolid], link: int, shares: dict[int, float]) -> tuple[Floats, Floats]:
    """Return the (3, 3) rotation and (3,) translation of a link when some links are at given shares of their ranges."""
    for mover in list(shares):
        before = solids[mover].blocking_link
        if before is not None and before not in shares:
            shares = {**shares, before: 1.0}
    rotation, translation = np.eye(3), np.zeros(3)
    current: int | None = link
    while current is not None:
        solid = solids[current]
        if current in shares and solid.axis is not None and solid.anchor is not None:
            if solid.turns:
                local = about_axis(solid.axis, solid.max_travel * shares[current])
                local_translation = solid.anchor - local @ solid.anchor
            else:
                local, local_translation = np.eye(3), solid.axis * solid.max_travel * shares[current]
            rotation, translation = local @ rotation, local @ translation + local_translation
        current = solid.carrier
    return rotation, translation


def _inflate(cloud: Floats) -> Floats:
    """Return a cloud enlarged by CLEARANCE_M on every side."""
    middle = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
    return np.concatenate([cloud, cloud + np.sign(cloud - middle) * CLEARANCE_M])


def _bounding_volume(cloud: Floats) -> float:
    return float(np.prod(np.ptp(cloud, axis=0)))


def _transform(cloud: Floats, motion: tuple[Floats, Floats]) -> Floats:
    return cloud @ motion[0].T + motion[1]


def _overlapping_pairs(first: list[Floats], second: list[Floats]) -> list[tuple[int, int]]:
    """Return the pairs whose boxes overlap, or nearly do."""
    a, b = (np.array([[c.min(axis=0), c.max(axis=0)] for c in side]) for side in (first, second))
    overlaps = (a[:, None, 0] < b[None, :, 1] + CLEARANCE_M) & (b[None, :, 0] < a[:, None, 1] + CLEARANCE_M)
    return [(int(p), int(q)) for p, q in np.argwhere(overlaps.all(axis=2))]


def overlap(first: Floats, second: Floats, least: float = 1e-12) -> Floats | None:
    """Return the (N, 3) corners of the intersection of two convex clouds; None if its volume is less than `least`."""
    shared = manifold3d.Manifold.hull_points(first) ^ manifold3d.Manifold.hull_points(second)
    if shared.is_empty() or shared.volume() < least:
        return None
    return np.array(shared.to_mesh64().vert_properties[:, :3], dtype=np.float64)


def _merge_boxes(boxes: list[Floats], cloud: Floats) -> list[Floats]:
    """Merge boxes, those with the smallest union first, until MAX_CUTS are left and further unions are large."""
    merged = list(boxes)
    limit = 0.25 * float(np.prod(np.ptp(cloud, axis=0)))
    while len(merged) > 1:
        grown = [
            (float(np.prod(np.maximum(merged[i][1], merged[j][1]) - np.minimum(merged[i][0], merged[j][0]))), i, j)
            for i in range(len(merged))
            for j in range(i + 1, len(merged))
        ]
        volume, i, j = min(grown)
        if len(merged) <= MAX_CUTS and volume > limit:
            break
        joined = np.array([np.minimum(merged[i][0], merged[j][0]), np.maximum(merged[i][1], merged[j][1])])
        merged = [b for k, b in enumerate(merged) if k not in (i, j)] + [joined]
    return merged


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
    for negative_thickness, axis, side in order:
        if negative_thickness >= 0:
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


def is_empty_region(skin: Floats | None, boxes: Sequence[Floats]) -> bool:
    """Return whether the visible body has no surface inside any of some boxes, (2, 3) corners each.

    Surface may bound a box on one side; on two opposite sides it is a board that fills the box.

    Args:
        skin: (N, 3) points on the visible surface of the body, metres; None counts as not empty.
    """
    if skin is None:
        return False
    for lower, upper in boxes:
        near = skin[((skin > lower - BOUND_TOLERANCE_M) & (skin < upper + BOUND_TOLERANCE_M)).all(axis=1)]
        share = (near - lower) / np.maximum(upper - lower, 1e-9)
        side = np.argmin(np.concatenate([share, 1.0 - share], axis=1), axis=1)
        count = np.bincount(side, minlength=6) >= max(1.0, MIN_SIDE_SHARE * len(near))
        inner = ((share > INNER_MARGIN_SHARE) & (share < 1.0 - INNER_MARGIN_SHARE)).all(axis=1).any()
        if inner or (count[:3] & count[3:]).any():
            return False
    return True
