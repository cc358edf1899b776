"""Measure the appearance of one side of an object, and how likely it is its front or its top."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull

from casa_assets.articulate.kinds import ControlPlacement, shape_likelihood
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import SIDES, DepthImage
from casa_assets.core.numeric import Floats, Mask

# An edge: a step in depth between neighbouring pixels, diagonals, or a bend, cosine of 25 degrees.
MIN_DEPTH_STEP, MAX_BEND_COS = 0.004, 0.906
# A feature such as a knob or handle: narrower than this in one direction, protruding this far; diagonals.
MAX_FEATURE_WIDTH, MIN_PROTRUSION, MAX_PROTRUSION = 0.13, 0.006, 0.3
MIN_FEATURE_SIZE, MIN_FEATURE_PIXELS = 0.012, 6
# The plane of a side is this quantile of its depth; a protrusion of FULL_JUT or more counts fully.
SIDE_PLANE_QUANTILE, FULL_JUT = 0.3, 0.06
# Gap under an object that stands on legs, diagonals.
MIN_LEG_LENGTH = 0.035
# Width, length and depth of slots, and diameter of burners; diagonals.
MIN_SLOT_WIDTH, MIN_SLOT_LENGTH, MIN_SLOT_DEPTH, SLOT_WINDOW = 0.015, 0.2, 0.05, 0.1
MIN_RING_SIZE, MAX_RING_SIZE = 0.09, 0.45
MAX_RINGS, MAX_RING_CANDIDATES = 6, 60
# What counts of a side, beside its share of the detail of all six.
SIDE_MEASURES: Mapping[str, Callable[[SideView], float]] = {
    "juts": lambda s: s.juts,
    "knobs": lambda s: float(np.log1p(min(sum(b.is_knob for b in s.blobs), 12))),
    "bars": lambda s: float(np.log1p(min(sum(b.is_bar for b in s.blobs), 6))),
    "panels": lambda s: s.panels,
    "stands": lambda s: s.protruding_share,
}
# Controls whose mean offset from the middle of the front, by its size, is larger than this are at its side or top; one
# offset exceeds the other by the margin.
CONTROLS_OFF_CENTRE, CONTROLS_MARGIN = 0.2, 0.05


@dataclass(frozen=True)
class SideFeature:
    """A small thing that protrudes from a side.

    Attributes:
        middle: (right, up) in the picture, each 0..1. size: (right, up) in diagonals. protrusion: how far out.
    """

    middle: tuple[float, float]
    size: tuple[float, float]
    protrusion: float

    @property
    def is_knob(self) -> bool:
        """Return whether it is compact, as knobs, buttons and feet are."""
        return max(self.size) <= 0.14 and max(self.size) < 2.5 * min(self.size)

    @property
    def is_bar(self) -> bool:
        """Return whether it is long and protrudes far, as handles do."""
        return max(self.size) >= 2.5 * min(self.size) and max(self.size) > 0.04 and self.protrusion >= 0.012


@dataclass(frozen=True)
class SideView:
    """Measures of one side, in its own depth image.

    Attributes:
        detail: share of its pixels that are edges of depth, bend, fragment or material. panels: share of its rectangle
            that thin fragments near it cover. protruding_share: of its pixels, from its median depth.
        juts: how far its nearest points protrude from its plane, 0..1, reduced by `support`, since an object may rest
            on them.
        support: hull of the nearest pixels, as a share of the rectangle. filled: share of the rectangle that is less
            than a leg's length deep.
        mirror: how similar it is to its mirror image, left to right and top to bottom, 0..1.
        blobs: small objects that protrude.
        rings: log of 1 and the number of flat discs larger than knobs. slots: deep narrow grooves, in pairs.
    """

    detail: float
    panels: float
    protruding_share: float
    juts: float
    support: float
    filled: float
    mirror: tuple[float, float]
    blobs: tuple[SideFeature, ...]
    rings: float
    slots: float


def measure_side(measured: MeasuredFragments, side: int) -> SideView:
    """Measure one side; the object has a diagonal of 1."""
    image = measured.depth_images[side]
    seen = np.isfinite(image.depth)
    lower, upper = corners_from_side(measured, side)
    far = float(upper[:, 2].max() - lower[:, 2].min())
    depth = np.where(seen, image.depth, far)
    edges = _edges(measured, image, seen, depth)
    values = np.sort(depth[seen]) if seen.any() else np.zeros(1)
    plane, middle = float(values[int(SIDE_PLANE_QUANTILE * (len(values) - 1))]), float(np.median(values))
    support = _support(seen & (depth < max(0.02 * far, 0.004)))
    visible = max(int(seen.sum()), 1)
    return SideView(
        detail=float(edges.sum() / visible),
        panels=_panels(measured, side, lower, upper),
        protruding_share=float((seen & (depth < middle - 0.008)).sum() / visible) if middle > 0.008 else 0.0,
        juts=min(plane / FULL_JUT, 1.0) * (1.0 - support),
        support=support,
        filled=float((seen & (depth < MIN_LEG_LENGTH)).mean()),
        mirror=(_similarity_to_mirror(depth, edges, 1), _similarity_to_mirror(depth, edges, 0)),
        blobs=_blobs(depth, seen, image.pixel, far),
        rings=_rings(measured, side, lower, upper),
        slots=min(_slot_count(depth, seen, image.pixel), 4) / 2.0,
    )


def _panels(measured: MeasuredFragments, side: int, lower: Floats, upper: Floats) -> float:
    """Return the share of the rectangle that thin fragments near the side cover."""
    size = upper - lower
    whole = upper.max(axis=0) - lower.min(axis=0)
    thin = (size[:, 2] < 0.2 * size[:, :2].min(axis=1)) & (lower[:, 2] - lower[:, 2].min() < 0.15 * whole[2])
    thin &= size[:, :2].max(axis=1) > 0.05
    return min(float(measured.visible_area[thin, side].sum() / max(whole[0] * whole[1], 1e-12)), 1.0)


def _edges(measured: MeasuredFragments, image: DepthImage, seen: Mask, depth: Floats) -> Mask:
    """Mark (H, W) pixels that differ from the one to the right or below in depth, direction, fragment or material."""
    normals = measured.mesh.normals[np.maximum(image.face, 0)]
    label = np.where(seen, measured.label[np.maximum(image.face, 0)], -1)
    material = np.where(seen, measured.mesh.material_index[np.maximum(image.face, 0)], -1)
    out: Mask = np.zeros(image.face.shape, dtype=bool)
    for axis in (0, 1):
        first = (slice(None), slice(None, -1)) if axis else (slice(None, -1), slice(None))
        second = (slice(None), slice(1, None)) if axis else (slice(1, None), slice(None))
        bend = np.abs((normals[first] * normals[second]).sum(axis=2)) < MAX_BEND_COS
        # Without steps of a slope that continues before or after, which is no edge.
        fall = np.diff(depth, axis=axis)
        bends = np.abs(np.diff(fall, axis=axis))
        margins = [(0, 0), (0, 0)]
        margins[axis] = (1, 1)
        bends = np.pad(bends, margins, constant_values=np.inf)
        before, after = np.delete(bends, -1, axis=axis), np.delete(bends, 0, axis=axis)
        off = np.where(bend, np.abs(np.diff(depth, axis=axis)), np.minimum(np.abs(fall), np.minimum(before, after)))
        step = off > MIN_DEPTH_STEP
        piece = (label[first] != label[second]) & (bend | step | (off > MIN_DEPTH_STEP / 8))
        # A window or a keypad may be no more than another material in the same plane.
        repaint = (material[first] != material[second]) & seen[first] & seen[second]
        out[first] |= (bend | step | piece | repaint) & (seen[first] | seen[second])
    return out


def _similarity_to_mirror(depth: Floats, edges: Mask, axis: int) -> float:
    """Return the similarity 0..1 of an image to its mirror image: of depth, and of edges within a pixel."""
    other = np.flip(depth, axis=axis)
    same = float((np.abs(depth - other) < 0.01).mean())
    thick = edges.copy()
    for k in (0, 1):
        thick |= np.roll(edges, 1, axis=k) | np.roll(edges, -1, axis=k)
    hit = float((edges & np.flip(thick, axis=axis)).sum() / max(int(edges.sum()), 1))
    return 0.5 * same + 0.5 * hit


def _support(near: Mask) -> float:
    """Return the area of the convex hull of some pixels, as a share of the image."""
    rows = np.flatnonzero(near.any(axis=1))
    if not len(rows):
        return 0.0
    # Of each row the first and the last: none between them is a corner.
    ends = np.argmax(near[rows], axis=1), near.shape[1] - np.argmax(near[rows][:, ::-1], axis=1)
    corners = np.concatenate([np.stack([rows + a, end], axis=1) for a in (0, 1) for end in ends])
    return float(ConvexHull(corners).volume / near.size)


def _blobs(depth: Floats, seen: Mask, pixel: float, far: float) -> tuple[SideFeature, ...]:
    """Find narrow regions that are nearer than the surface around them."""
    window = max(3, int(MAX_FEATURE_WIDTH / pixel) | 1)
    wide = ndimage.maximum_filter(depth, window, mode="nearest")
    wall = ndimage.minimum_filter(wide, window, mode="nearest")
    label, _ = ndimage.label(seen & (wall - depth > MIN_PROTRUSION) & (wall < far - 1e-6), structure=np.ones((3, 3)))
    height, width = depth.shape
    found = []
    for i, box in enumerate(ndimage.find_objects(label)):
        mask = label[box] == i + 1
        rows, columns = mask.shape
        if max(rows, columns) * pixel < MIN_FEATURE_SIZE or int(mask.sum()) < MIN_FEATURE_PIXELS:
            continue
        stands = float(np.percentile((wall - depth)[box][mask], 80))
        if stands <= MAX_PROTRUSION:
            middle = (box[1].start + columns / 2) / width, 1 - (box[0].start + rows / 2) / height
            found.append(SideFeature(middle, (columns * pixel, rows * pixel), stands))
    return tuple(found)


def count_slots(image: DepthImage) -> int:
    """Return the number of deep narrow grooves in a picture that end before its border, as in a toaster."""
    seen = np.isfinite(image.depth)
    deepest = float(image.depth[seen].max()) if seen.any() else 0.0
    return _slot_count(np.where(seen, image.depth, deepest), seen, image.pixel)


def _slot_count(depth: Floats, seen: Mask, pixel: float) -> int:
    """Count deep narrow grooves that end before the border, as in a toaster."""
    window = max(3, int(SLOT_WINDOW / pixel) | 1)
    narrow = ndimage.minimum_filter(depth, window, mode="nearest")
    lid = ndimage.maximum_filter(narrow, window, mode="nearest")
    label, _ = ndimage.label(seen & (depth - lid > MIN_SLOT_DEPTH))
    count = 0
    for i, box in enumerate(ndimage.find_objects(label)):
        mask = label[box] == i + 1
        short, long = sorted(s * pixel for s in mask.shape)
        # A groove that runs out at the border is the gap between a door and its body.
        closed = all(k.start > 0 and k.stop < n for k, n in zip(box, depth.shape, strict=True))
        slot = long > max(MIN_SLOT_LENGTH, 3.5 * short) and short > MIN_SLOT_WIDTH and float(mask.mean()) > 0.6
        count += closed and slot
    return int(count)


def _rings(measured: MeasuredFragments, side: int, lower: Floats, upper: Floats) -> float:
    """Return log(1 + number) of flat discs that are too large for knobs: burners."""
    size = upper - lower
    across = size[:, :2].max(axis=1)
    fits = (size[:, :2].min(axis=1) > 0.94 * across) & (across > MIN_RING_SIZE) & (across < MAX_RING_SIZE)
    fits &= (size[:, 2] < 0.3 * across) & (measured.visible_area[:, side] > 0.15 * size[:, 0] * size[:, 1])
    found: list[Floats] = []
    for i in np.flatnonzero(fits)[:MAX_RING_CANDIDATES].tolist():
        flat = measured.points_of([i]) @ SIDES[side][:2].T
        middle = (flat.min(axis=0) + flat.max(axis=0)) / 2
        is_round = float(np.linalg.norm(flat - middle, axis=1).max()) < 0.54 * float(across[i])
        if is_round and all(float(np.abs(middle - o).max()) >= 0.05 for o in found):
            found.append(middle)
    return float(np.log1p(min(len(found), MAX_RINGS)))


def frame_features(
    measured: MeasuredFragments, sides: Sequence[SideView], front: int, top: int, inside: Floats
) -> dict[str, float]:
    """Return the features, by name, of the hypothesis that these sides are the front and the top."""
    back, bottom = front ^ 1, top ^ 1
    up, out = -SIDES[top][2], -SIDES[front][2]
    across = np.cross(up, out)
    left, right = (int(np.argmax(-SIDES[:, 2] @ direction)) for direction in (-across, across))
    lower, upper = measured.lower.min(axis=0), measured.upper.max(axis=0)
    width, depth, height = (float(np.abs(a) @ (upper - lower)) for a in (across, out, up))
    front_view = sides[front]
    knobs = [_offset(b, front, across, up) for b in front_view.blobs if b.is_knob]
    bars = [_offset(b, front, across, up) for b in front_view.blobs if b.is_bar and _is_level(b, front, up)]
    top_knobs = [_offset(b, top, across, out) for b in sides[top].blobs if b.is_knob]
    total = max(sum(s.detail for s in sides), 1e-9)
    rise = ((measured.lower + measured.upper) / 2 - (lower + upper) / 2) @ up / max(height, 1e-9)
    # Left and right count together.
    places = {"front": (front,), "back": (back,), "top": (top,), "bottom": (bottom,), "sides": (left, right)}
    return {
        "front_detail": front_view.detail / total,
        "back_detail": sides[back].detail / total,
        **{
            f"{place}_{name}": float(np.mean([measure(sides[i]) for i in indices]))
            for name, measure in SIDE_MEASURES.items()
            for place, indices in places.items()
        },
        # Front and back ends less alike than the other two, mean over top, bottom, left and right.
        "symmetry": float(np.mean([-_symmetry(sides[i], i, out) for i in (top, bottom, left, right)])),
        # How much more alike the left and right ends of the front are than its top and bottom.
        "front_level": _symmetry(front_view, front, across),
        "support": sides[bottom].support,
        "shape": shape_likelihood((width, depth, height), _control_placement(knobs)),
        # Share of the surface that no side shows and that faces front or back.
        "inside_upright": float(inside @ np.abs(out)),
        # Mean height of level bars and of knobs on the front, from its middle, as a share of its height.
        "bars_high": _mean(bars),
        "knobs_high": max(_mean(knobs), 0.0),
        "top_rings": sides[top].rings,
        "top_slots": sides[top].slots,
        # Mean offset of knobs on the top towards the front, as a share of the depth.
        "knobs_near": _mean(top_knobs),
        "mass_height": float((rise * measured.area).sum() / max(float(measured.area.sum()), 1e-12)),
        "back_plain": float(sides[back].detail < 0.5 * front_view.detail),
        "bottom_legs": max(sides[bottom].support - sides[bottom].filled, 0.0),
    }


def hidden_area(measured: MeasuredFragments) -> Floats:
    """Return the (3,) share of the surface that no side shows, by the axis it faces: shelves and racks are level."""
    visible = np.zeros(len(measured.label), dtype=bool)
    for image in measured.depth_images:
        visible[image.face[image.face >= 0]] = True
    weight = np.where(visible, 0.0, measured.mesh.areas)
    aligned = np.abs(measured.mesh.normals) > 0.9
    return np.asarray((aligned * weight[:, None]).sum(axis=0) / max(float(measured.mesh.areas.sum()), 1e-12))


def _offset(blob: SideFeature, side: int, right: Floats, up: Floats) -> tuple[float, float]:
    """Return the offset of a feature from the middle of its side, in shares of the side, along two directions."""
    place = (blob.middle[0] - 0.5) * SIDES[side][0] + (blob.middle[1] - 0.5) * SIDES[side][1]
    return float(place @ right), float(place @ up)


def _is_level(blob: SideFeature, side: int, up: Floats) -> bool:
    """Return whether something on a side is wider than high."""
    along_up = abs(float(SIDES[side][1] @ up)) > 0.5
    wide, upper = blob.size if along_up else blob.size[::-1]
    return wide > upper


def _mean(places: Sequence[tuple[float, float]]) -> float:
    """Return the mean of the second coordinates, 0 for none."""
    return float(np.mean([p[1] for p in places])) if places else 0.0


def _symmetry(side: SideView, index: int, axis: Floats) -> float:
    """Return how much more alike the two ends along one direction are than those along the other."""
    first = abs(float(SIDES[index][0] @ axis)) > 0.5
    return (side.mirror[0] - side.mirror[1]) * (1.0 if first else -1.0)


def _control_placement(knobs: Sequence[tuple[float, float]]) -> ControlPlacement:
    """Return where on a front its knobs and buttons are."""
    if not knobs:
        return ControlPlacement.NONE
    x, z = np.abs(np.mean(np.array(knobs), axis=0))
    if x > max(CONTROLS_OFF_CENTRE, z + CONTROLS_MARGIN):
        return ControlPlacement.ASIDE
    return ControlPlacement.ABOVE if z > max(CONTROLS_OFF_CENTRE, x + CONTROLS_MARGIN) else ControlPlacement.NONE
