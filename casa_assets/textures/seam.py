"""Measure how visible the border of a repeated picture is, and remove it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

Picture = npt.NDArray[np.float32]

# One step of an 8-bit picture: below it no border can be seen, whatever stands inside.
_STEP = 1.0 / 255.0
# Columns that the border is held against: the strongest of this share, for a joint may lie on the border as it may
# lie inside.
_STRONGEST = 0.01
_BAND = 0.04  # of the side: width of the strips whose mean tone is compared
_OVERLAP = 0.13  # of the side: room for the path of a repair, so that it finds a joint to follow
_SHORTEST = 0.6  # of the side: what a repair leaves at least
_LINES = 2.0  # weight of lines against tones


@dataclass(frozen=True)
class Seam:
    """Steps across the border over steps inside: 1 is a border like any other place, 3 is plainly seen."""

    x: float  # across the left and right edge
    y: float  # across the upper and lower edge

    @property
    def worst(self) -> float:
        """The larger of both."""
        return max(self.x, self.y)


def seam(picture: npt.NDArray[np.floating]) -> Seam:
    """Measure both borders of a picture that will be repeated.

    Args:
        picture: (H, W) or (H, W, C), 0..1, at least 16 px a side.
    """
    image = np.asarray(picture, dtype=np.float32)
    image = image[..., None] if image.ndim == 2 else image
    return Seam(x=_across(image), y=_across(image.swapaxes(0, 1)))


def jump(picture: npt.NDArray[np.floating]) -> Seam:
    """Steps across both borders over the usual step inside.

    Stricter than `seam`: a joint that lies on the border counts as well. For pictures of which it is not known that
    they were made to repeat.

    Args:
        picture: (H, W, C), 0..1.
    """
    image = np.asarray(picture, dtype=np.float32)
    found = []
    for view in (image, image.swapaxes(0, 1)):
        steps = np.abs(np.diff(view, axis=1, append=view[:, :1])).mean(axis=(0, 2))
        found.append(float(steps[-1] / max(float(np.median(steps[:-1])), _STEP)))
    return Seam(x=found[0], y=found[1])


def repair(picture: npt.NDArray[np.floating], shown: int | None = None) -> Picture:
    """Make a picture tile: even out its light, cut it where the ends match best, blend both ends.

    Args:
        picture: (H, W, C), 0..1.
        shown: number of its channels, the first ones, that are seen: they decide where it is cut, and theirs is the
            light. The others are maps of the same surface, which are cut alike. None: all are seen.
    Returns:
        (h, w, C) float32 0..1 with h, w between 0.6 and 1 of H, W; it tiles in both directions.
    """
    image = np.asarray(picture, dtype=np.float32)
    seen = image.shape[2] if shown is None else shown
    image = np.concatenate([_without_drift(image[..., :seen]), image[..., seen:]], axis=2)
    image = _closed(image, seen, ring=False)
    return np.clip(_closed(image.swapaxes(0, 1), seen, ring=True).swapaxes(0, 1), 0.0, 1.0)


def smooth_part(picture: Picture) -> Picture:
    """The smooth image whose removal makes a picture periodic.

    Ref: L. Moisan, Periodic plus Smooth Image Decomposition, J. Math. Imaging Vis. 39 (2011).

    Args:
        picture: (H, W, C).
    Returns:
        (H, W, C) float32 of mean 0; `picture` minus it has no jump at its border.
    """
    height, width = picture.shape[:2]
    jump = np.zeros_like(picture, dtype=np.float64)
    jump[0] += picture[0] - picture[-1]
    jump[-1] -= picture[0] - picture[-1]
    jump[:, 0] += picture[:, 0] - picture[:, -1]
    jump[:, -1] -= picture[:, 0] - picture[:, -1]
    rows = 2.0 * np.cos(2.0 * np.pi * np.arange(height) / height)
    cols = 2.0 * np.cos(2.0 * np.pi * np.arange(width) / width)
    laplacian = 4.0 - rows[:, None] - cols[None, :]
    laplacian[0, 0] = 1.0
    spectrum = np.fft.fft2(jump, axes=(0, 1)) / laplacian[..., None]
    spectrum[0, 0] = 0.0
    return np.real(np.fft.ifft2(spectrum, axes=(0, 1))).astype(np.float32)


def _across(image: Picture) -> float:
    """Score of the edge between the last and the first column, fine and broad."""
    width = image.shape[1]
    steps = np.abs(np.diff(image, axis=1, append=image[:, :1])).mean(axis=(0, 2))
    strongest = np.sort(steps[:-1])[-max(3, round(_STRONGEST * len(steps[:-1]))) :].mean()
    fine = steps[-1] / max(float(strongest), _STEP)
    # A drift of light shows no step from pixel to pixel, but the tones of the two ends are far apart.
    band = max(2, round(_BAND * width))
    count = width // band
    means = image[:, : count * band].reshape(image.shape[0], count, band, -1).mean(axis=(0, 2))
    inner = np.abs(np.diff(means, axis=0)).mean(axis=1)
    ends = np.abs(image[:, :band].mean(axis=(0, 1)) - image[:, -band:].mean(axis=(0, 1))).mean()
    broad = ends / max(float(inner.max()), 2.0 * _STEP)
    # One of two dozen such steps may well be the largest without being a fault.
    return float(max(fine, broad / 1.3))


def _without_drift(image: Picture) -> Picture:
    """Even out what is as wide as the picture: vignettes and light from one side."""
    coarse = image[:: max(1, image.shape[0] // 64), :: max(1, image.shape[1] // 64)]
    sigma = 0.2 * min(coarse.shape[:2])
    coarse = ndimage.gaussian_filter(coarse, (sigma, sigma, 0.0), mode="nearest")
    scale = (image.shape[0] / coarse.shape[0], image.shape[1] / coarse.shape[1], 1.0)
    light = ndimage.zoom(coarse, scale, order=1, mode="nearest", grid_mode=True)
    evened = image - 0.7 * (light - light.mean(axis=(0, 1)))
    broad = ndimage.gaussian_filter(evened, (4.0, 4.0, 0.0), mode="nearest")
    return np.asarray(np.clip(evened - smooth_part(broad), 0.0, 1.0), dtype=np.float32)


def _closed(image: Picture, seen: int, ring: bool) -> Picture:
    """Cut columns away at both ends so that they fit, and let the ends overlap along the least visible path.

    Args:
        image: (H, W, C). seen: number of the channels that decide.
        ring: the rows are already periodic, so the path has to end where it began.
    """
    width = image.shape[1]
    overlap = max(4, round(_OVERLAP * width))
    start, length = _best_cut(image[..., :seen], overlap)
    kept = image[:, start : start + length].copy()
    over = image[:, start + length : start + length + overlap]
    path = _path(((over - kept[:, :overlap])[..., :seen] ** 2).sum(axis=2), ring)
    feather = max(2.0, overlap / 20.0)
    share = np.clip((np.arange(overlap)[None, :] - path[:, None]) / feather + 0.5, 0.0, 1.0)
    # The first column has to go on from the last one, and the last of the overlap into the picture.
    ramp = np.arange(overlap) / (overlap - 1.0)
    share = np.clip(share, np.maximum(0.0, 4.0 * ramp - 3.0), np.minimum(1.0, 4.0 * ramp))[..., None]
    kept[:, :overlap] = share * kept[:, :overlap] + (1.0 - share) * over
    return kept.astype(np.float32)


def _best_cut(image: Picture, overlap: int) -> tuple[int, int]:
    """First column and number of columns whose ends look most alike, looked for on a coarse grid."""
    width = image.shape[1]
    # Lines that do not meet are seen before tones that differ: they count for more.
    lines = np.abs(np.diff(image, axis=0, append=image[:1])) + np.abs(np.diff(image, axis=1, append=image[:, :1]))
    lines = ndimage.maximum_filter(lines, (3, 3, 1), mode="nearest")
    # Columns are compared as they are, rows may be thinned: a joint that moves by a pixel is seen.
    rows = np.concatenate([image, _LINES * lines], axis=2)[:: max(1, image.shape[0] // 128)]
    hop = max(1, width // 128)
    shortest = round(_SHORTEST * width)
    best = (np.inf, 0, width - overlap)
    for start in range(0, width - overlap - shortest + 1, 2 * hop):
        left = rows[:, start : start + overlap]
        for length in range(shortest, width - overlap - start + 1, hop):
            right = rows[:, start + length : start + length + overlap]
            cost = float(np.abs(left[:, ::hop] - right[:, ::hop]).mean()) * (1.0 + 0.1 * (width - length) / width)
            if cost < best[0]:
                best = (cost, start, length)
    return best[1], best[2]


def _path(cost: npt.NDArray[np.float32], ring: bool) -> npt.NDArray[np.intp]:
    """Column of the cheapest cut from the first row to the last, one column a row at most.

    Ref: A. Efros, W. Freeman, Image Quilting for Texture Synthesis and Transfer, SIGGRAPH 2001.
    """
    path = _cheapest(cost)
    if not ring:
        return path
    middle = int(path[len(path) // 2])
    fenced = cost.copy()
    columns = np.arange(cost.shape[1])
    for row in (0, -1):
        fenced[row] = np.where(columns == middle, fenced[row], np.float32(1e6))
    return _cheapest(fenced)


def _cheapest(cost: npt.NDArray[np.float32]) -> npt.NDArray[np.intp]:
    rows, columns = cost.shape
    total = cost.astype(np.float64)
    for row in range(1, rows):
        above = np.pad(total[row - 1], 1, constant_values=np.inf)
        total[row] += np.minimum(np.minimum(above[:-2], above[1:-1]), above[2:])
    path = np.empty(rows, dtype=np.intp)
    path[-1] = int(np.argmin(total[-1]))
    for row in range(rows - 2, -1, -1):
        low = max(0, int(path[row + 1]) - 1)
        high = min(columns, int(path[row + 1]) + 2)
        path[row] = low + int(np.argmin(total[row, low:high]))
    return path
