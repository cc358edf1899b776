"""Evidence for the seams around fronts in the relief of a side: grooves, steps, bends and outlines along lines.

A seam of a closed shell may be shallower than a cell of the grid that the shell was made on. It is long and straight,
so its mean over the whole line is distinct even if no single pixel of it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from casa_assets.articulate.segment.creases import BACKGROUND_DEPTH, SideRelief, dilate
from casa_assets.articulate.segment.fragment_measures import SIDES
from casa_assets.articulate.segment.welded_mesh import Bools, WeldedMesh
from casa_assets.core.typing import Floats, Ints

# Pixels on each side of a line over which its depth and its normals are averaged, and those left out next to it.
BAND, GAP = 5, 3
# Noise below which a line is compared with these instead: depth, diagonals, and the sine of a bend.
MIN_GROOVE_NOISE, MIN_BEND_NOISE = 0.00015, 0.01
# A signal of so many times the noise speaks as loud as can be.
LOUD = 6.0
# Depth beyond which what lies behind a line is not the same side of the object, diagonals.
OUTLINE_STEP = 0.02
# Greatest difference of depth that is told apart, diagonals.
MAX_STEP = 0.05
# Lengths over which the loudest stretch of a line is looked for, shares of the longer side of the picture.
STRETCHES = (0.1, 0.25, 0.6)
# Lines nearer to each other than this are one, diagonals.
SAME_LINE = 0.006
# Lines that are quieter than this are not looked at, and how many are at most, in each direction.
MIN_LOUDNESS, MAX_LINES = 0.35, 24

_T = TypeVar("_T", bound=np.generic)

# What is known of a line between two others, the last axis of `LineTable.values`.
LINE_MEASURES = ("edge", "groove", "bend", "outline_before", "outline_after", "step", "visible")


@dataclass(frozen=True)
class LineTable:
    """Evidence for each line of one direction, between every two lines of the other.

    Attributes:
        at: (N,) ascending pixel borders of the lines. values: (N, M, M, 7) of LINE_MEASURES, means over the stretch
            between two of the M lines across; the third index must be greater than the second.
    """

    at: Ints
    values: Floats


@dataclass(frozen=True)
class SeamMaps:
    """Per-pixel evidence for lines along the rows of a picture.

    Attributes:
        maps: (7, H + 1, W) by LINE_MEASURES, of the border above each row; zero where nothing is visible.
    """

    maps: npt.NDArray[np.float32]


def seam_maps(mesh: WeldedMesh, relief: SideRelief, side: int, upright: bool) -> SeamMaps:
    """Measure the evidence for level lines, or for upright ones in the transposed picture."""
    image = relief.image
    seen = relief.depth < BACKGROUND_DEPTH / 2
    free = seen & ~dilate(relief.blob >= 0, 2)
    tilt = mesh.normals[np.maximum(image.face, 0)] @ (SIDES[side][0] if upright else -SIDES[side][1])
    edges = relief.across if upright else relief.along
    depth = relief.base
    if upright:
        seen, free, tilt, edges, depth = seen.T, free.T, tilt.T, edges.T, depth.T
    return SeamMaps(_maps(depth, tilt, edges, seen, free))


def _maps(depth: Floats, tilt: Floats, edges: Bools, seen: Bools, free: Bools) -> npt.NDArray[np.float32]:
    """Return the maps of SeamMaps; `tilt` is the component of the normals down the picture."""
    height = depth.shape[0]
    pad = BAND + GAP + 1
    far = np.pad(np.where(seen, depth, BACKGROUND_DEPTH), ((pad, pad), (0, 0)), constant_values=BACKGROUND_DEPTH)
    is_free = np.pad(free, ((pad, pad), (0, 0)))
    is_seen = np.pad(seen, ((pad, pad), (0, 0)))
    normal = np.pad(np.where(free, tilt, 0.0), ((pad, pad), (0, 0)))

    def rows(values: npt.NDArray[_T], first: int) -> npt.NDArray[_T]:
        """Return (H + 1, W): for each border the row that is `first` below it (-1 is the one above)."""
        found: npt.NDArray[_T] = values[pad + first : pad + first + height + 1]
        return found

    above, below = -GAP - BAND // 2, GAP + BAND // 2 - 1
    a, b = rows(far, above), rows(far, below)
    middle = np.maximum(rows(far, -1), rows(far, 0))
    speaks = rows(is_free, above) & rows(is_free, below) & rows(is_free, -1) & rows(is_free, 0)
    groove = np.where(speaks, middle - np.maximum(a, b), 0.0)
    sums = np.cumsum(np.pad(normal, ((1, 0), (0, 0))), axis=0)
    mean_above = (sums[pad : pad + height + 1] - sums[pad - BAND : pad - BAND + height + 1]) / BAND
    mean_below = (sums[pad + BAND : pad + BAND + height + 1] - sums[pad : pad + height + 1]) / BAND
    # Down the picture, the normals of a groove turn from downwards to upwards.
    bend = np.where(speaks, mean_above - mean_below, 0.0)
    first, last = rows(is_seen, above), rows(is_seen, below)
    before = last & ~(first & (a < b + OUTLINE_STEP))
    after = first & ~(last & (b < a + OUTLINE_STEP))
    step = np.where(speaks, np.clip(a - b, -MAX_STEP, MAX_STEP) / MAX_STEP, 0.0)
    step = np.where(before, 1.0, np.where(after, -1.0, step))
    strong = np.pad(edges, ((1, 0), (0, 0))) & (speaks | before | after)
    visible = speaks | before | after
    quiet = speaks & (np.abs(groove) < OUTLINE_STEP)
    layers = [
        strong,
        np.where(speaks, np.clip(groove / _loud(groove[quiet], MIN_GROOVE_NOISE), -1.0, 1.0), 0.0),
        np.where(speaks, np.clip(bend / _loud(bend[quiet], MIN_BEND_NOISE), -1.0, 1.0), 0.0),
        before,
        after,
        step,
        visible,
    ]
    return np.stack([m.astype(np.float32) for m in layers])


def _loud(values: Floats, least: float) -> float:
    """Return the signal that counts in full, by the noise of a sample of it."""
    noise = float(np.median(np.abs(values - np.median(values)))) if len(values) else 0.0
    return LOUD * max(noise * 1.5, least)


def find_lines(maps: SeamMaps, pixel: float, more: list[int]) -> Ints:
    """Return the pixel borders of lines that any stretch speaks for, and of those that are given, ascending."""
    edge, groove, bend, before, after = maps.maps[:5]
    loud = np.maximum.reduce([edge, groove, bend, before, after])
    longest = max(loud.shape)
    heard = maximum_filter1d(loud, 3, axis=0)
    score = np.zeros(len(loud))
    for share in STRETCHES:
        size = max(8, round(share * longest))
        if size <= loud.shape[1]:
            score = np.maximum(score, uniform_filter1d(heard, size, axis=1, mode="constant").max(axis=1) * share**0.25)
    near = max(2, round(SAME_LINE / pixel))
    kept = sorted(set(more))
    for at in np.argsort(-score, kind="stable").tolist():
        if score[at] >= MIN_LOUDNESS and len(kept) < MAX_LINES and all(abs(at - k) > near for k in kept):
            kept.append(int(at))
    return np.array(sorted(kept), dtype=np.int64)


def line_table(maps: SeamMaps, at: Ints, across: Ints, pixel: float) -> LineTable:
    """Measure each line between every two lines across it; a line may lie slightly off its place.

    Args:
        at: (N,) borders of the lines. across: (M,) borders of those across.
    """
    waver = max(1, round(SAME_LINE / pixel / 3))
    height = maps.maps.shape[1]
    best: Floats | None = None
    for shift in range(-waver, waver + 1):
        rows = np.clip(at + shift, 0, height - 1)
        sums = np.cumsum(np.pad(maps.maps[:, rows].astype(np.float64), ((0, 0), (0, 0), (1, 0))), axis=2)[:, :, across]
        total = sums[:, :, None, :] - sums[:, :, :, None]
        visible = np.maximum(total[6], 1.0)
        length = np.maximum((across[None, :] - across[:, None]).astype(np.float64), 1.0)
        means = np.moveaxis(np.concatenate([total[:6] / visible, total[6:] / length]), 0, -1)
        if best is None:
            best = means
        else:
            best[..., :5] = np.maximum(best[..., :5], means[..., :5])
            louder = np.abs(means[..., 5]) > np.abs(best[..., 5])
            best[..., 5] = np.where(louder, means[..., 5], best[..., 5])
            best[..., 6] = np.maximum(best[..., 6], means[..., 6])
    assert best is not None
    return LineTable(at, best)
