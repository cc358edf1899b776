"""Fit convex collision shapes to a link's triangles, and cut them back where a moving part passes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
from scipy import ndimage

from casa_assets.articulate.plan import round7, to_vec3
from casa_assets.articulate.segment.orthographic import outline_area, render_depth
from casa_assets.core.numeric import Floats, Ints, Mask, about_axis
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.solid.solids import hull_planes, hull_volume, small_hull
from casa_assets.mesh.voxels import Grid, voxelise
from casa_assets.model.asset.parts import Box, Hull, Mesh, Shape
from casa_assets.model.pose import Pose

# A surface that fills at least this share of its hull becomes the hull, of its box, a box.
MIN_HULL_FILL, MIN_BOX_FILL = 0.8, 0.985
# A surface that fills less than this share of its hull is open. One that is flatter than this ratio is judged by its
# largest hole instead, as a share of its rectangle, in an image of HOLE_PX: a hull of a grate closes nothing.
MAX_OPEN_FILL, MAX_FLAT_RATIO, MIN_HOLE_SHARE, HOLE_PX = 0.5, 0.06, 0.3, 48
# A plate without holes or notches fills at least this share of the hull of its outline.
MIN_OUTLINE_FILL = 0.95
# Voxels along the longest side: the finest grid that needs few enough shapes is taken.
VOXEL_COUNTS = (28, 18, 12, 8)
# Coarser ones, for what still needs too many: where the shapes that there is room for end this share of the longest
# side short of the surface. Ref: nine tenths of collider_bounds_ratio in registry/limits.yaml.
COARSE_VOXEL_COUNTS, MAX_SHORTFALL_SHARE = (5, 3), 0.018
MIN_THICKNESS_M = 0.002
# Part of that thickness by which rounding may fall short of it.
ROUNDING_SHARE = 0.01
SAMPLES = 6000
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
# Link and shape that would be cut, then link and shape that run into it.
Pair = tuple[int, int, int, int]
# Overlaps up to the first are left alone; those up to the second, or that share of the diagonal of all links, are cut.
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
MAX_SHORTFALL_M, MAX_CUT_SHORTFALL_SHARE = 0.0036, 0.018
# Visible surface this near to the side of an empty box bounds it, if that side has at least this share of the surface.
BOUND_TOLERANCE_M, MIN_SIDE_SHARE = 0.0005, 0.15
# Visible surface farther inside a box than this share of its size lies in it, and does not bound it.
INNER_MARGIN_SHARE = 0.25


def convex_clouds(points: Floats, faces: Ints, max_count: int) -> list[Floats]:
    """Return convex point clouds that cover a surface and leave its cavities open, the largest first.

    Args:
        points: (P, 3) metres. faces: (F, 3) over them. max_count: how many at most.
    Returns:
        (N, 3) points of each, metres, in the frame of `points`; each spans a volume.
    """
    used, local = np.unique(faces, return_inverse=True)
    cloud, triangles = points[used], local.reshape(-1, 3)
    extent = np.ptp(cloud, axis=0)
    is_thin = bool(extent.min() < MIN_THICKNESS_M)
    flat = int(np.argmin(extent))
    # A flat surface without a large hole in its largest side: a box fits it.
    is_board = _projected_area(cloud, triangles) >= MIN_HULL_FILL * float(np.prod(np.delete(extent, flat)))
    lower, upper = _thick_bounds(cloud)
    if is_thin and (max_count == 1 or is_board):
        return [box_cloud(lower, upper)]
    outline_size = MIN_OUTLINE_FILL * outline_area(np.delete(cloud, flat, axis=1)) if is_thin else 0.0
    if 0.0 < outline_size <= _projected_area(cloud, triangles):  # a convex plate, such as a disc
        outline = np.concatenate([cloud, cloud])
        outline[: len(cloud), flat], outline[len(cloud) :, flat] = lower[flat], upper[flat]
        return [_hull_or_box(outline)]
    finest = voxelise(cloud, triangles, cells=VOXEL_COUNTS[0])
    if max_count == 1 or (not is_thin and finest.volume >= MIN_HULL_FILL * hull_volume(cloud)):
        return [_hull_or_box(cloud)]
    samples = np.concatenate([cloud, surface_samples(cloud, triangles, SAMPLES)])
    found: list[Floats] = []
    for cells in (*VOXEL_COUNTS, *COARSE_VOXEL_COUNTS):
        if cells in COARSE_VOXEL_COUNTS and not _falls_short(found, cloud):
            break
        grid = finest if cells == VOXEL_COUNTS[0] else voxelise(cloud, triangles, cells=cells)
        found, left = _boxes_of_voxels(grid, samples, max_count)
        if not left:
            break
    return [_hull_or_box(cloud)] if _falls_short(found, cloud) else found


def _falls_short(shapes: list[Floats], cloud: Floats) -> bool:
    """Return whether the box around some shapes falls short of the box around a cloud, or there are no shapes."""
    if not shapes:
        return True
    gaps = np.min([s.min(axis=0) for s in shapes], axis=0) - cloud.min(axis=0)
    gaps = np.maximum(gaps, cloud.max(axis=0) - np.max([s.max(axis=0) for s in shapes], axis=0))
    return bool(gaps.max() > MAX_SHORTFALL_SHARE * np.ptp(cloud, axis=0).max())


def hull_closes_opening(points: Floats, faces: Ints) -> bool:
    """Return whether one hull around a surface would close an opening of it, as of a gasket, a frame or a tub.

    Args:
        points: (P, 3) metres. faces: (F, 3) over them.
    """
    used, local = np.unique(faces, return_inverse=True)
    cloud, triangles = points[used], local.reshape(-1, 3)
    if _is_flat(cloud):
        return is_frame(points, faces)
    grid = voxelise(cloud, triangles, cells=VOXEL_COUNTS[1])
    return bool((grid.skin | grid.solid).sum() * grid.cell**3 < MAX_OPEN_FILL * hull_volume(cloud))


def is_frame(points: Floats, faces: Ints) -> bool:
    """Return whether a surface is flat and has a large hole."""
    used, local = np.unique(faces, return_inverse=True)
    cloud = points[used]
    if not _is_flat(cloud):
        return False
    axes = np.roll(np.eye(3), 2 - int(np.argmin(np.ptp(cloud, axis=0))), axis=0)
    # The largest connected free part of its rectangle is a hole.
    free, _ = ndimage.label(render_depth(cloud, local.reshape(-1, 3), axes, HOLE_PX).face < 0)
    return float(np.bincount(free.reshape(-1))[1:].max(initial=0) / free.size) >= MIN_HOLE_SHARE


def _is_flat(cloud: Floats) -> bool:
    extent = np.ptp(cloud, axis=0)
    return bool(extent.min() < MAX_FLAT_RATIO * extent.max())


def fit_shape(cloud: Floats) -> tuple[Shape, Pose]:
    """Return the shape of a convex cloud and its pose: a box where the cloud nearly fills it, else a hull."""
    lower, upper = cloud.min(axis=0), cloud.max(axis=0)
    size = np.maximum(upper - lower, MIN_THICKNESS_M)
    middle = (lower + upper) / 2
    pose = Pose(position=to_vec3(round7(v) for v in middle))
    box = Box(size=to_vec3(round7(v) for v in size))
    if hull_volume(cloud) >= MIN_BOX_FILL * float(np.prod(size)):
        return box, pose
    try:
        thick = with_thickness(cloud - np.array(pose.position))
        points, faces = small_hull(thick.astype(np.float32).astype(np.float64))
    except DegenerateShape:
        return box, pose
    return Hull(mesh=Mesh(vertices=points, faces=faces)), pose


def with_thickness(cloud: Floats) -> Floats:
    """Return a convex cloud that is at least MIN_THICKNESS_M wide in every direction.

    A sheet that is tilted against all axes has a bounding box as thick as any solid's, but a hull without a volume,
    which MuJoCo refuses to load. It becomes a plate of that thickness, with the sheet in its middle.
    """
    for _ in range(3):  # a sheet is thin in one direction, a straight rod in two, a point in three
        # Qhull is asked only for what is no sheet: of one it gives a hull that rounding alone made.
        normals = np.linalg.svd(cloud - cloud.mean(axis=0))[2][-1:]
        if float(np.ptp(cloud @ normals[0])) >= MIN_THICKNESS_M:
            normals = hull_planes(cloud)[:, :3]
        reach = cloud @ normals.T
        width = np.ptp(reach, axis=0)
        thinnest = int(np.argmin(width))
        if width[thinnest] >= MIN_THICKNESS_M * (1.0 - ROUNDING_SHARE):
            break
        normal, middle = normals[thinnest], (reach[:, thinnest].min() + reach[:, thinnest].max()) / 2
        flat = cloud - np.outer(reach[:, thinnest] - middle, normal)
        cloud = np.concatenate([flat - normal * MIN_THICKNESS_M / 2, flat + normal * MIN_THICKNESS_M / 2])
    return cloud


def snap_to_box(cloud: Floats) -> Floats:
    """Return the corners of the bounding box where a convex cloud nearly fills it, else the cloud."""
    lower, upper = cloud.min(axis=0), cloud.max(axis=0)
    return box_cloud(lower, upper) if hull_volume(cloud) >= MIN_BOX_FILL * float(np.prod(upper - lower)) else cloud


def box_cloud(lower: Floats, upper: Floats) -> Floats:
    """Return the (8, 3) corners of a box."""
    return lower + _CORNERS * (upper - lower)


def _projected_area(cloud: Floats, triangles: Ints) -> float:
    """Return the area of a flat surface as seen face-on: of a sheet, or of one side of a plate."""
    a, b, c = (cloud[triangles[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)[:, int(np.argmin(np.ptp(cloud, axis=0)))] / 2
    return max(float(facing[facing > 0].sum()), float(-facing[facing < 0].sum()))


def _thick_bounds(cloud: Floats) -> tuple[Floats, Floats]:
    """Return the box around a flat surface, at least as thick as contacts need."""
    lower, upper = cloud.min(axis=0), cloud.max(axis=0)
    middle, half = (lower + upper) / 2, np.maximum(upper - lower, MIN_THICKNESS_M) / 2
    return middle - half, middle + half


def _hull_or_box(cloud: Floats) -> Floats:
    """Return the outermost points of a cloud, or a box around it where it has no volume."""
    try:
        return small_hull(cloud)[0]
    except DegenerateShape:
        return box_cloud(*_thick_bounds(cloud))


def _boxes_of_voxels(grid: Grid, samples: Floats, max_count: int) -> tuple[list[Floats], bool]:
    """Gather voxels into boxes, the largest first, each shrunk to its contents; also return whether voxels are left."""
    remaining = grid.skin | grid.solid
    inner = grid.solid & ~grid.skin
    at = np.round((samples - grid.origin) / grid.cell).astype(np.int64)
    out: list[Floats] = []
    while remaining.any() and len(out) < max_count:
        a, b = _largest_box(remaining)
        window = tuple(slice(int(p), int(q)) for p, q in zip(a, b, strict=True))
        remaining[window] = False
        inside = samples[((at >= a) & (at < b)).all(axis=1)]
        if inner[window].any():
            filled = np.argwhere(inner[window])
            lower = grid.origin + (filled.min(axis=0) + a - 0.5) * grid.cell
            upper = grid.origin + (filled.max(axis=0) + a + 0.5) * grid.cell
            inside = np.concatenate([inside, box_cloud(lower, upper)])
        if len(inside) < 4:
            continue
        lower, upper = _thick_bounds(inside)
        is_flat = np.ptp(inside, axis=0).min() < MIN_THICKNESS_M
        fills = hull_volume(inside) >= 0.85 * float(np.prod(upper - lower))
        out.append(box_cloud(lower, upper) if fills or is_flat else _hull_or_box(inside))
    return out, bool(remaining.any())


def _largest_box(solid: Mask) -> tuple[Ints, Ints]:
    """Return a large box of full cells: grown from seed cells along the axes in several orders, the best of them."""
    cells = np.argwhere(solid)
    best: tuple[int, Ints, Ints] = (0, cells[0], cells[0] + 1)
    for seed in cells[np.linspace(0, len(cells) - 1, 12).astype(int)]:
        for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            a, b = seed.copy(), seed + 1
            for axis in order:
                _extend_box(solid, a, b, axis)
            volume = int(np.prod(b - a))
            if volume > best[0]:
                best = (volume, a, b)
    return best[1], best[2]


def _extend_box(solid: Mask, a: Ints, b: Ints, axis: int) -> None:
    """Extend a box both ways along an axis while all new cells are full; in place."""
    for step in (-1, 1):
        while True:
            at = a[axis] - 1 if step < 0 else b[axis]
            if not 0 <= at < solid.shape[axis]:
                break
            window = [slice(int(p), int(q)) for p, q in zip(a, b, strict=True)]
            window[axis] = slice(int(at), int(at) + 1)
            if not solid[tuple(window)].all():
                break
            if step < 0:
                a[axis] -= 1
            else:
                b[axis] += 1


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
    slack = max(MAX_SHORTFALL_M, MAX_CUT_SHORTFALL_SHARE * float(np.ptp(seen, axis=0).max()))
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
