"""Analyse one side of a one-piece shell: its depth, the steps and bends in it, and small things that protrude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, find_objects, grey_closing, grey_opening, label, maximum_filter1d

from casa_assets.articulate.segment.fragments import SIDES
from casa_assets.articulate.segment.orthographic import DepthImage, render_depth
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.numeric import Floats, Ints, Mask

# Pixels along the longer side of a relief.
PIXELS = 640
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
    image = render_depth(mesh.points, mesh.faces, SIDES[side], PIXELS)
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
    """Return a slice grown by one on both ends."""
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
