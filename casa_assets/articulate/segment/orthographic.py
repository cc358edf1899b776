"""Look at triangles along an axis: depth images, intersections with lines, and the relief of a side."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import binary_dilation, find_objects, grey_closing, grey_opening, label, maximum_filter1d
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.numeric import Floats, Ints, Mask

if TYPE_CHECKING:
    from casa_assets.articulate.segment.fragments import WeldedMesh

# Axes of the six sides front, back, left, right, top, bottom: rows are right, up, and the viewing direction.
SIDES = np.array(
    [
        [[1, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[0, -1, 0], [0, 0, 1], [1, 0, 0]],
        [[0, 1, 0], [0, 0, 1], [-1, 0, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, -1]],
        [[1, 0, 0], [0, -1, 0], [0, 0, 1]],
    ],
    dtype=np.float64,
)
FRONT, BACK, LEFT, RIGHT, TOP, BOTTOM = range(6)
# Pixels that are written at once: bounds memory and does not change the result.
CHUNK = 2_000_000
# Steps into which the depth of an image is quantised.
_STEPS = float(2**30)
# Faces that are intersected at once: bounds memory and does not change the result.
LINES_AT_ONCE = 20_000
# Crossings nearer to each other than this are one sheet, diagonals.
SAME_SHEET = 0.002
# Pixels along the longer side of a relief.
RELIEF_PIXELS = 640
# Sides of the squares for morphological closing, larger than any knob or handle is wide; diagonals.
WINDOWS = (0.06, 0.14)
# What is narrower and deeper than this is a slot or a hole of the shell, and no ground of what stands out; diagonals.
MAX_SLOT_WIDTH, MIN_SLOT_DEPTH = 0.025, 0.01
# Least protrusion, diagonals: less is lost in the noise of a shell.
MIN_PROTRUSION = 0.0025
LEVELS = tuple(MIN_PROTRUSION * 1.5**k for k in range(10))
MIN_PIXELS, MIN_SIZE = 12, 0.007
# Least protrusion by the noise of the surface (median absolute deviation): a scan is bumpy everywhere.
MIN_PROTRUSION_OVER_NOISE = 6.0
# Least share of the surroundings of a protrusion that is surface.
MIN_GROUND_SHARE = 0.55
# Largest knob or button; widest bar, and its least protrusion; diagonals.
MAX_SMALL_SIZE, MAX_BAR_WIDTH, MIN_BAR_PROTRUSION = 0.13, 0.075, 0.009
# An edge: a step between neighbouring pixels, diagonals, or a bend, cosine of 20 degrees.
MIN_DEPTH_STEP, MAX_BEND_COS = 0.0022, 0.94
# Depth of the background, behind everything, diagonals.
BACKGROUND_DEPTH = 2.0


def outline_area(flat: Floats) -> float:
    """Return the area of the convex hull of (P, 2) points, 0 where they lie on a line."""
    try:
        return float(ConvexHull(flat).volume)
    except QhullError:
        return 0.0


@dataclass(frozen=True)
class DepthImage:
    """An orthographic view: the nearest face at each pixel, and its depth.

    Attributes:
        face: (H, W) index of the visible face, -1 for none; row 0 is at the top.
        depth: (H, W) distance along the view from the nearest corner of the box, units of the mesh; inf for no face.
        lower: (2,) corner of the picture in (right, up). pixel: edge of a pixel, units of the mesh.
    """

    face: Ints
    depth: Floats
    lower: Floats
    pixel: float

    def rows_columns(self, flat: Floats) -> tuple[Ints, Ints]:
        """Return the row and column of (N, 2) points given in (right, up), clipped to the image."""
        height, width = self.face.shape
        column = np.floor((flat[:, 0] - self.lower[0]) / self.pixel).astype(np.int64)
        row = height - 1 - np.floor((flat[:, 1] - self.lower[1]) / self.pixel).astype(np.int64)
        return np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)

    def window(self, lower: Floats, upper: Floats) -> Floats:
        """Return the depths of the pixels of a rectangle between (2,) corners in (right, up)."""
        row, column = self.rows_columns(np.array([lower, upper]))
        return self.depth[row[1] : row[0] + 1, column[0] : column[1] + 1]


def render_depth(points: Floats, faces: Ints, axes: Floats, size_px: int) -> DepthImage:
    """Render triangles from outside, looking along `axes[2]`.

    Args:
        points: (P, 3). faces: (F, 3).
        axes: (3, 3) rows: right, up, and the direction of the view (into the scene).
        size_px: pixels along the longer side.
    """
    flat = points @ axes.T
    lower, upper = flat.min(axis=0), flat.max(axis=0)
    span = np.maximum(upper - lower, 1e-12)
    pixel = float(max(span[0], span[1])) / size_px
    width, height = (max(1, int(np.ceil(s / pixel - 1e-9))) for s in span[:2])
    grid = (flat - lower) / np.array([pixel, pixel, span[2]])
    buffer = np.full(height * width, np.iinfo(np.int64).max)
    for start, stop in _chunks(grid[:, 1], faces):
        _write(buffer, width, height, grid, faces, start, stop)
    seen = buffer != np.iinfo(np.int64).max
    face = np.where(seen, buffer & 0xFFFFFFFF, -1).reshape(height, width)[::-1]
    depth = np.where(seen, (buffer >> 32) / _STEPS * span[2], np.inf).reshape(height, width)[::-1]
    return DepthImage(face, depth, lower[:2], pixel)


def _chunks(rows: Floats, faces: Ints) -> list[tuple[int, int]]:
    """Return ranges of faces whose boxes together cover a bounded number of rows."""
    tall = np.ptp(rows[faces], axis=1) + 2
    at = np.floor(np.cumsum(tall) / (CHUNK / 40)).astype(np.int64)
    edges = np.flatnonzero(np.diff(at)) + 1
    ends = [0, *edges.tolist(), len(faces)]
    return list(pairwise(ends))


def _write(buffer: Ints, width: int, height: int, grid: Floats, faces: Ints, start: int, stop: int) -> None:
    """Rasterise a range of faces into the buffer: the pixels that each covers in each row; in place."""
    corners = grid[faces[start:stop]]
    y = corners[:, :, 1]
    first = np.clip(np.ceil(y.min(axis=1) - 0.5), 0, height).astype(np.int64)
    last = np.clip(np.floor(y.max(axis=1) - 0.5), -1, height - 1).astype(np.int64)
    tri, row = _ranges(first, last - first + 1)
    left, right = _spans(corners[tri], row + 0.5)
    begin = np.clip(np.ceil(left - 0.5), 0, width).astype(np.int64)
    count = np.clip(np.floor(right - 0.5), -1, width - 1).astype(np.int64) - begin + 1
    full = count > 0
    tri, row, begin, count = tri[full], row[full], begin[full], count[full]
    near, slope = _depth(corners, tri, begin + 0.5, row + 0.5, count)
    at = np.searchsorted(np.cumsum(count), np.arange(CHUNK, int(count.sum()), CHUNK))
    for one, two in pairwise([0, *at.tolist(), len(tri)]):
        part = slice(one, two)
        many = count[part]
        step = np.arange(int(many.sum())) - np.repeat(np.cumsum(many) - many, many)
        depth = np.repeat(near[part], many) + np.repeat(slope[part], many) * step
        key = depth.astype(np.int64) << 32 | np.repeat(tri[part] + start, many)
        np.minimum.at(buffer, np.repeat(row[part] * width + begin[part], many) + step, key)


def _ranges(first: Ints, count: Ints) -> tuple[Ints, Ints]:
    """Expand ranges into the index of each range and its values, one after the other: ((N,), (N,))."""
    count = np.maximum(count, 0)
    owner = np.repeat(np.arange(len(first)), count)
    begin = np.cumsum(count) - count
    return owner, first[owner] + np.arange(len(owner)) - begin[owner]


def _spans(corners: Floats, y: npt.NDArray[np.floating[Any]]) -> tuple[Floats, Floats]:
    """Return the (N,) coordinates at which a horizontal line enters and leaves each triangle."""
    left, right = np.full(len(y), np.inf), np.full(len(y), -np.inf)
    for i in range(3):
        a, b = corners[:, i], corners[:, (i + 1) % 3]
        rise = b[:, 1] - a[:, 1]
        crosses = (np.minimum(a[:, 1], b[:, 1]) <= y) & (y <= np.maximum(a[:, 1], b[:, 1])) & (np.abs(rise) > 1e-12)
        share = (y - a[:, 1]) / np.where(crosses, rise, 1.0)
        x = a[:, 0] + share * (b[:, 0] - a[:, 0])
        left = np.where(crosses, np.minimum(left, x), left)
        right = np.where(crosses, np.maximum(right, x), right)
    return np.where(left <= right, left, 1.0), np.where(left <= right, right, 0.0)


def _depth(
    corners: Floats, index: Ints, x: npt.NDArray[np.floating[Any]], y: npt.NDArray[np.floating[Any]], count: Ints
) -> tuple[Floats, Floats]:
    """Return the depth of each triangle's plane at its first pixel, and the increment per pixel, in depth steps.

    Depths are clipped to those of the corners; a triangle seen edge-on has the depth of its first corner.
    """
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    safe = np.where(np.abs(area) > 1e-9, area, np.inf)
    right = ((v[:, 1] * u[:, 2] - u[:, 1] * v[:, 2]) / safe)[index]
    up = ((u[:, 0] * v[:, 2] - v[:, 0] * u[:, 2]) / safe)[index]
    near = a[index, 2] + (x - a[index, 0]) * right + (y - a[index, 1]) * up
    lower, upper = (np.clip(f(corners[:, :, 2], axis=1), 0.0, 1.0)[index] for f in (np.min, np.max))
    far = np.clip(near + right * (count - 1), lower, upper)
    near = np.clip(near, lower, upper)
    return near * _STEPS, (far - near) * _STEPS / np.maximum(count - 1, 1)


@dataclass(frozen=True)
class RayCrossings:
    """Crossings of lines with triangles, line by line, sorted along their axis.

    Attributes:
        line: (N,) which line. at: (N,) coordinate along the axis, ascending for each line.
        towards: (N,) 1 where the face looks along the axis, -1 where it looks against it. face: (N,) index.
        count: how many lines there are.
    """

    line: Ints
    at: Floats
    towards: Floats
    face: Ints
    count: int

    def select(self, rows: Mask) -> RayCrossings:
        """Return some of the crossings."""
        return RayCrossings(self.line[rows], self.at[rows], self.towards[rows], self.face[rows], self.count)

    def first(self) -> Floats:
        """Return the (L,) smallest coordinate of each line, inf for none."""
        out = np.full(self.count, np.inf)
        np.minimum.at(out, self.line, self.at)
        return out

    def last(self) -> Floats:
        """Return the (L,) largest coordinate of each line, -inf for none."""
        out = np.full(self.count, -np.inf)
        np.maximum.at(out, self.line, self.at)
        return out

    def beyond(self, start: float, sign: float) -> tuple[Floats, Mask]:
        """Return the distance to the first sheet from a coordinate along the axis (1) or against it (-1).

        Returns:
            (L,) way to the first sheet, inf for none, and (L,) whether a face of it looks at who comes.
        """
        way = (self.at - start) * sign
        rows = way >= 0.0
        near = np.full(self.count, np.inf)
        np.minimum.at(near, self.line[rows], way[rows])
        meets = rows & (way <= near[self.line] + SAME_SHEET) & (self.towards * sign < 0)
        looks: Mask = np.zeros(self.count, dtype=bool)
        looks[self.line[meets]] = True
        return near, looks


def cross_rays(points: Floats, faces: Ints, axis: int, spots: Floats) -> RayCrossings:
    """Intersect triangles with lines along an axis.

    Args:
        points: (P, 3). faces: (F, 3). axis: 0, 1 or 2.
        spots: (L, 2) places of the lines: the other two coordinates, in their order.
    """
    a, b = (k for k in range(3) if k != axis)
    lines, depths, sides, owners = [], [], [], []
    for start in range(0, len(faces), LINES_AT_ONCE):
        corners = points[faces[start : start + LINES_AT_ONCE]]
        flat = corners[:, :, [a, b]]
        lower, upper = flat.min(axis=1), flat.max(axis=1)
        over = (lower[None] <= spots[:, None]).all(axis=2) & (spots[:, None] <= upper[None]).all(axis=2)
        line, face = np.nonzero(over)
        p, q, r = (flat[face, k] - spots[line] for k in range(3))
        u, v, w = _cross(q, r), _cross(r, p), _cross(p, q)
        total = u + v + w
        inside = (np.abs(total) > 1e-16) & (np.minimum(np.minimum(u, v), w) * np.sign(total) >= 0)
        line, face, total = line[inside], face[inside], total[inside]
        weight = np.stack([u[inside], v[inside], w[inside]], axis=1) / total[:, None]
        lines.append(line)
        depths.append((corners[face, :, axis] * weight).sum(axis=1))
        # Seen along y, right and up turn the other way round.
        sides.append(np.sign(total) * (-1.0 if axis == 1 else 1.0))
        owners.append(face + start)
    if not lines:
        none = np.empty(0)
        return RayCrossings(none.astype(np.int64), none, none, none.astype(np.int64), len(spots))
    line, at = np.concatenate(lines), np.concatenate(depths)
    order = np.lexsort((np.concatenate(owners), at, line))
    side, owner = np.concatenate(sides)[order], np.concatenate(owners)[order]
    return RayCrossings(line[order].astype(np.int64), at[order], side, owner.astype(np.int64), len(spots))


def _cross(p: Floats, q: Floats) -> Floats:
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]


def sample_grid(lower: Floats, upper: Floats, count: int, inset: float = 0.0) -> Floats:
    """Return (count * count, 2) points that fill a rectangle evenly; `inset` of its size stays free on every side."""
    share = inset + (1 - 2 * inset) * (np.arange(count) + 0.5013) / count
    x, y = (lower[k] + share * (upper[k] - lower[k]) for k in (0, 1))
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2)


@dataclass(frozen=True)
class Protrusion:
    """A small object that protrudes from a side, such as a knob, a button or a handle.

    Attributes:
        rows, columns: half-open ranges of its pixels. lower, upper: (2,) corners in (u, v).
        protrusion: greatest distance that it protrudes. area: of its picture.
    """

    rows: tuple[int, int]
    columns: tuple[int, int]
    lower: Floats
    upper: Floats
    protrusion: float
    area: float

    @property
    def long(self) -> float:
        """Return the ratio of the longer to the shorter side."""
        size = self.upper - self.lower
        return float(size.max() / max(float(size.min()), 1e-9))

    @property
    def middle(self) -> Floats:
        """Return the (2,) middle of its rectangle."""
        return (self.lower + self.upper) / 2


@dataclass(frozen=True)
class SideRelief:
    """Depth image of one side, with protrusions and depth edges.

    Attributes:
        image: of the side. depth: (H, W) without infinities. base: (H, W) depth with small objects taken off.
        blob: (H, W) index of the object in `blobs` that protrudes there, -1 for none.
        across, along: (H, W) edges between a pixel and the one at its right, below it.
    """

    image: DepthImage
    depth: Floats
    base: Floats
    blob: Ints
    blobs: tuple[Protrusion, ...]
    across: Mask
    along: Mask


def measure_relief(mesh: WeldedMesh, side: int) -> SideRelief:
    """Analyse a side of a mesh that is in the frame."""
    image = render_depth(mesh.points, mesh.faces, SIDES[side], RELIEF_PIXELS)
    depth = np.where(image.face >= 0, image.depth, BACKGROUND_DEPTH)
    base, ground = depth, _without_slots(depth, max(3, round(MAX_SLOT_WIDTH / image.pixel)))
    for window in WINDOWS:
        size = max(3, round(window / image.pixel))
        closed = grey_closing(np.pad(ground, size, mode="edge"), size=(size, size))
        base = np.maximum(base, closed[size:-size, size:-size])
    # Where closing reaches past the outline there is no ground to stand out of.
    base = np.where(base > BACKGROUND_DEPTH / 2, depth, base)
    blob, blobs = _blobs(image, depth, base)
    across, along = _edges(mesh, side, image, depth)
    return SideRelief(image, depth, base, blob, blobs, across, along)


def _without_slots(depth: Floats, size: int) -> Floats:
    """Return the depth with what is much farther and narrower than `size` pixels filled up to its surroundings.

    Closing would take the floor of a slot for the ground of all that lies between it and the next one.
    """
    padded = np.pad(depth, size, mode="edge")
    opened = grey_opening(padded, size=(size, size))[size:-size, size:-size]
    return np.where(opened < depth - MIN_SLOT_DEPTH, opened, depth)


def _blobs(image: DepthImage, depth: Floats, base: Floats) -> tuple[Ints, tuple[Protrusion, ...]]:
    """Find connected protruding regions; of nested ones the widest that is a small thing, not a frame or a board."""
    protrusion = base - depth
    found = np.full(depth.shape, -1, dtype=np.int64)
    blobs: list[Protrusion] = []
    seen = depth < BACKGROUND_DEPTH / 2
    noise = float(np.median(np.abs(protrusion[seen] - np.median(protrusion[seen])))) if seen.any() else 0.0
    for level in LEVELS:
        if level < MIN_PROTRUSION_OVER_NOISE * noise:
            continue
        number, _ = label((protrusion > level) & (found < 0))
        for i, (rows, columns) in enumerate(find_objects(number), start=1):
            mask = number[rows, columns] == i
            if mask.sum() < MIN_PIXELS or min(mask.shape) * image.pixel < MIN_SIZE:
                continue
            height = protrusion.shape[0]
            lower = image.lower + image.pixel * np.array([columns.start, height - rows.stop])
            upper = image.lower + image.pixel * np.array([columns.stop, height - rows.start])
            stands = float(np.percentile(protrusion[rows, columns][mask], 95))
            area = float(mask.sum()) * image.pixel**2
            blob = Protrusion((rows.start, rows.stop), (columns.start, columns.stop), lower, upper, stands, area)
            grown = dilate(np.pad(mask, 3), 3) & ~np.pad(mask, 3)
            window = np.pad(seen, 3)[rows.start : rows.stop + 6, columns.start : columns.stop + 6]
            ground_share = float(window[grown].mean())
            if ground_share < MIN_GROUND_SHARE:
                continue
            # What touches one that was found is its rim, or the rest of the frame from which it rose.
            if _is_small(blob) and not (found[_grow_slice(rows), _grow_slice(columns)] >= 0).any():
                found[rows, columns][mask] = len(blobs)
                blobs.append(blob)
    return found, tuple(blobs)


def _grow_slice(span: slice) -> slice:
    return slice(max(0, span.start - 1), span.stop + 1)


def _is_small(blob: Protrusion) -> bool:
    """Return whether a region is a knob, a button or a bar, by its size and by how much of its rectangle it fills."""
    size = blob.upper - blob.lower
    fill = blob.area / float(np.prod(size))
    if size.max() <= MAX_SMALL_SIZE:
        return fill >= 0.4
    return bool(
        size.min() <= MAX_BAR_WIDTH
        and blob.protrusion >= MIN_BAR_PROTRUSION
        and (fill >= 0.4 or size.max() <= 2 * MAX_SMALL_SIZE)
    )


def _edges(mesh: WeldedMesh, side: int, image: DepthImage, depth: Floats) -> tuple[Mask, Mask]:
    """Mark pixels that step, or bend inwards, against the one to their right, and the one below.

    Outward bends are left out: they are the facets of a bulging front, while a gap always has an inward one.
    """
    normals = mesh.normals[np.maximum(image.face, 0)]
    across, along = np.zeros(depth.shape, dtype=bool), np.zeros(depth.shape, dtype=bool)
    for found, axis, way in ((across, 1, SIDES[side][0]), (along, 0, -SIDES[side][1])):
        a = (slice(None), slice(None, -1)) if axis else (slice(None, -1), slice(None))
        b = (slice(None), slice(1, None)) if axis else (slice(1, None), slice(None))
        bend = (normals[a] * normals[b]).sum(axis=2) < MAX_BEND_COS
        inwards = (normals[b] - normals[a]) @ way < 0
        found[a] = (np.abs(depth[a] - depth[b]) > MIN_DEPTH_STEP) | (bend & inwards)
    return across, along


def dilate(mask: Mask, pixels: int) -> Mask:
    """Return a mask grown by some pixels in all directions."""
    return binary_dilation(mask, iterations=pixels) if pixels else mask


def edge_lines(relief: SideRelief, upright: bool, pixels: int) -> tuple[Mask, Mask]:
    """Return edges along one direction, each a few pixels wide, and the mask where no protrusion hides the ground.

    Returns:
        (H, W) edges and (H, W) mask; transposed for upright lines, so that a line is always a row.
    """
    edges = relief.across if upright else relief.along
    hidden = dilate(relief.blob >= 0, 2)
    axis = 1 if upright else 0
    thick: Mask = maximum_filter1d((edges & ~hidden).astype(np.uint8), 2 * pixels + 1, axis=axis).astype(bool)
    free = ~hidden
    return (thick.T, free.T) if upright else (thick, free)
