"""Tell drawer boxes, cavities and racks apart by looking down on some fragments alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.segment.fragments import FRONT, SIDES, TOP, MeasuredFragments
from casa_assets.articulate.segment.orthographic import render_depth
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.deviation import surface_samples

PIXELS = 96
# Least depth of a cavity, diagonals.
MIN_CAVITY_DEPTH = 0.05
# Walls of a tub stand within this share of the plan from its border, and rise by this share of its height.
WALL_BORDER_SHARE, MIN_WALL_RISE = 0.12, 0.15
# Points of the surface by which thin walls are told, stretches of a border that are looked at one by one, and the share
# of such a stretch of a wall that is surface: of rods it is less.
SAMPLES, WALL_BINS, MIN_WALL_FILL = 4000, 12, 0.4


@dataclass(frozen=True)
class PlanView:
    """Shares of the plan of some fragments, seen from above.

    Attributes:
        covered: where anything is. floor: where the first thing is in the lower half of their height, of all.
        lid: where it is in the upper quarter.
        walls: (3,) of the left, the right and the far border, where something rises above the floor.
    """

    covered: float
    floor: float
    lid: float
    walls: tuple[float, float, float]

    @property
    def is_box(self) -> bool:
        """Return whether it is open at the top, with a floor: a drawer."""
        return self.floor >= 0.45 and self.lid <= 0.5

    @property
    def is_tub(self) -> bool:
        """Return whether it is a box with walls on three sides: only a drawer or a bin looks like this."""
        return self.is_box and self.floor >= 0.5 and min(self.walls) >= 0.6


def view_from_above(measured: MeasuredFragments, fragments: Sequence[int]) -> PlanView:
    """Look down on some fragments alone."""
    rows = measured.faces_of(fragments)
    lower, upper = measured.box(fragments)
    image = measured.render_alone(fragments, TOP, PIXELS)
    height = max(float(upper[2] - lower[2]), 1e-9)
    share = image.depth / height
    seen = np.isfinite(share)
    total = float(share.size)
    deep, shallow = seen & (share > 0.5), seen & (share < 0.25)
    samples = surface_samples(measured.mesh.points, measured.mesh.faces[rows], SAMPLES)
    thin = _thin_walls(samples, lower, upper, float(measured.mesh.areas[rows].sum()))
    left, right, far = (max(pair) for pair in zip(_walls(share), thin, strict=True))
    return PlanView(
        float(seen.sum()) / total, float(deep.sum()) / total, float(shallow.sum()) / total, (left, right, far)
    )


def free_share_behind(measured: MeasuredFragments, fragments: Sequence[int], lower: Floats, upper: Floats) -> float:
    """Return the share of a rectangle behind which there is free space, once some fragments are removed.

    Args:
        lower, upper: (3,) corners in (u, v, w) of what those fragments are; room is what lies deeper than `upper`.
    """
    gone = np.zeros(len(measured.label), dtype=bool)
    gone[measured.faces_of(fragments)] = True
    faces = measured.mesh.faces[~gone]
    if not len(faces):
        return 0.0
    image = render_depth(measured.mesh.points, faces, SIDES[FRONT], 2 * PIXELS)
    nearest = float((measured.mesh.points[faces] @ SIDES[FRONT][2]).min())
    depth = image.window(lower[:2], upper[:2]) + nearest
    return float((np.isfinite(depth) & (depth > float(upper[2]) + MIN_CAVITY_DEPTH)).mean())


def roofed_share(measured: MeasuredFragments, lower: Floats, upper: Floats) -> float:
    """Return the share of the strip right behind a front that something covers at the height of its top or above.

    Args:
        lower, upper: (3,) corners of the front in (u, v, w) of an upright side.
    """
    strip = np.array([[lower[0], lower[1], upper[2]], [upper[0], upper[1], upper[2] + MIN_CAVITY_DEPTH]]) @ SIDES[FRONT]
    flat = np.sort(strip @ SIDES[TOP].T, axis=0)
    depth = measured.depth_images[TOP].window(*flat[:, :2])
    height = float(measured.upper[:, 2].max()) - np.where(np.isfinite(depth), depth, np.inf)
    return float((height >= float(upper[1]) - 0.25 * float(upper[1] - lower[1])).mean())


def share_open_to_the_top(measured: MeasuredFragments, fragments: Sequence[int]) -> float:
    """Return the share of the plan of some fragments that is open when the object is seen from above.

    There, nothing visible is above half of their height: neither a worktop nor the body, only objects inside them.
    """
    lower, upper = measured.box(fragments)
    corners = np.sort(np.array([lower, upper]) @ SIDES[TOP].T, axis=0)
    depth = measured.depth_images[TOP].window(*corners[:, :2])
    height = float(measured.upper[:, 2].max()) - np.where(np.isfinite(depth), depth, np.inf)
    return float((height < float(lower[2] + upper[2]) / 2).mean())


def _walls(share: Floats) -> tuple[float, float, float]:
    """Return the shares of the left, right and far border of a plan that have a wall rising above the floor."""
    rows, columns = (max(1, round(WALL_BORDER_SHARE * n)) for n in share.shape)
    seen = np.isfinite(share)
    floor = float(np.median(share[seen])) if seen.any() else 0.0
    raised = share < floor - MIN_WALL_RISE
    return (
        float(raised[:, :columns].any(axis=1).mean()),
        float(raised[:, -columns:].any(axis=1).mean()),
        float(raised[:rows].any(axis=0).mean()),
    )


def _thin_walls(samples: Floats, lower: Floats, upper: Floats, area: float) -> tuple[float, float, float]:
    """Return the same as `_walls`, from the surface along each border: sheets are not visible from above.

    Args:
        samples: (N, 3) points spread over the surface. lower, upper: (3,) corners of all. area: of the surface.
    """
    size = np.maximum(upper - lower, 1e-9)
    place = (samples - lower) / size
    raised = place[:, 2] > MIN_WALL_RISE
    each = area / max(len(samples), 1)
    found = []
    for axis, near in ((0, place[:, 0]), (0, 1.0 - place[:, 0]), (1, 1.0 - place[:, 1])):
        along = place[raised & (near < WALL_BORDER_SHARE), 1 - axis]
        held = np.histogram(along, WALL_BINS, (0.0, 1.0))[0] * each
        whole = float(size[1 - axis] * size[2]) * (1.0 - MIN_WALL_RISE) / WALL_BINS
        found.append(float((held >= MIN_WALL_FILL * whole).mean()))
    return found[0], found[1], found[2]
