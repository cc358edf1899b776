"""Fit convex collision shapes to the triangles of one link: a hull where it fits, else boxes of voxels."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from casa_assets.articulate.plan import round7, to_vec3
from casa_assets.articulate.segment.orthographic import outline_area, render_depth
from casa_assets.core.numeric import Floats, Ints, Mask
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
