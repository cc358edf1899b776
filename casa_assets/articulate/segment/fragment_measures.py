"""Measure each fragment of a mesh: bounding box, surface area, and the area that is visible from each of six sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.segment.raster import DepthImage, render_depth
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.typing import Floats, Ints

# Axes of the six sides in the order front, back, left, right, top, bottom: rows are right, up, and the viewing
# direction.
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
PIXELS = 512


@dataclass(frozen=True)
class MeasuredFragments:
    """All fragments of a mesh with their measures, in the frame of the object (diagonal 1).

    Attributes:
        label: (F,) fragment of each face, -1 for none.
        lower, upper: (N, 3) corners of each. area: (N,) surface.
        visible_area: (N, 6) area of its picture from each of SIDES. depth_images: those pictures, of faces.
    """

    mesh: WeldedMesh
    label: Ints
    lower: Floats
    upper: Floats
    area: Floats
    visible_area: Floats
    depth_images: tuple[DepthImage, ...]

    @property
    def count(self) -> int:
        """Return the number of fragments."""
        return len(self.area)

    def faces_of(self, fragments: Sequence[int]) -> Ints:
        """Return the ascending indices of the faces of some fragments."""
        mask = np.zeros(self.count + 1, dtype=bool)
        mask[list(fragments)] = True
        return np.flatnonzero(mask[self.label] & (self.label >= 0))

    def box(self, fragments: Sequence[int]) -> tuple[Floats, Floats]:
        """Return the (3,) lower and upper corner of the box around some fragments."""
        rows = list(fragments)
        return self.lower[rows].min(axis=0), self.upper[rows].max(axis=0)

    def points_of(self, fragments: Sequence[int]) -> Floats:
        """Return the (P, 3) points that some fragments use."""
        found: Floats = self.mesh.points[np.unique(self.mesh.faces[self.faces_of(fragments)])]
        return found


def corners_of_labels(mesh: WeldedMesh, label: Ints) -> tuple[Floats, Floats]:
    """Return the (N, 3) lower and upper corners of the faces of each label.

    Args:
        label: (F,) label of each face, -1 for none. A label that no face has gets corners of inf and -inf.
    """
    count = int(label.max(initial=-1)) + 1
    alive = label >= 0
    corners = mesh.points[mesh.faces[alive]]
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(lower, label[alive], corners.min(axis=1))
    np.maximum.at(upper, label[alive], corners.max(axis=1))
    return lower, upper


def render_sides(mesh: WeldedMesh, pixels: int = PIXELS) -> tuple[DepthImage, ...]:
    """Render a mesh that is in the frame from each of SIDES."""
    return tuple(render_depth(mesh.points, mesh.faces, axes, pixels) for axes in SIDES)


def measure_fragments(
    mesh: WeldedMesh, label: Ints, pixels: int = PIXELS, images: tuple[DepthImage, ...] | None = None
) -> MeasuredFragments:
    """Measure the fragments of a mesh that is in the frame, from rendered depth images of six sides.

    Args:
        label: (F,) fragment of each face. images: those of `render_sides`, None to render them.
    """
    lower, upper = corners_of_labels(mesh, label)
    count = len(lower)
    alive = np.flatnonzero(label >= 0)
    area = np.bincount(label[alive], mesh.areas[alive], count).astype(np.float64)
    images = render_sides(mesh, pixels) if images is None else images
    seen = np.zeros((count, len(SIDES)))
    for i, image in enumerate(images):
        visible = label[image.face[image.face >= 0]]
        seen[:, i] = np.bincount(visible[visible >= 0], minlength=count) * image.pixel**2
    return MeasuredFragments(mesh, label, lower, upper, area, seen, images)


def corners_from_side(measured: MeasuredFragments, side: int) -> tuple[Floats, Floats]:
    """Return the (N, 3) lower and upper corners of fragments in the axes of a side: right, up, depth."""
    axes = SIDES[side]
    a, b = measured.lower @ axes.T, measured.upper @ axes.T
    return np.minimum(a, b), np.maximum(a, b)
