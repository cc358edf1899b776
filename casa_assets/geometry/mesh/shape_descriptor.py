"""Shape descriptors that pose, scale, vertex order and triangulation do not change, and the distance between two."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.rounding import decimals, significant
from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.mesh.measure import shell_moments
from casa_assets.model.asset.signature import CENTER_SHARES, PAIR_SHARES, ShapeDescriptor

# Places on a surface whose distances to each other are measured: a million pairs.
SURFACE_SAMPLES = 1500


def shape_descriptor(points: Floats, faces: Ints) -> ShapeDescriptor:
    """Shape descriptor of a surface.

    Ref: distances between random pairs of places, the D2 of Osada et al. 2002.

    Args:
        points: (P, 3) metres. faces: (F, 3).
    Raises:
        DegenerateShape: the surface has no area.
    """
    # Here and below, since a run without new shapes does without SciPy, which loads slowly.
    from scipy.spatial.distance import pdist

    from casa_assets.geometry.solid.coverage import surface_samples

    center, radius, axes, _ = principal_spread(points, faces)
    places = (surface_samples(points, faces, SURFACE_SAMPLES) - center) / radius
    x, y, z = (_short(float(side)) for side in axes / radius)
    return ShapeDescriptor(
        radius=significant(radius, 6),
        pair_distances=tuple(_short(v) for v in quantile_means(pdist(places), PAIR_SHARES)),
        center_distances=tuple(_short(v) for v in quantile_means(np.linalg.norm(places, axis=1), CENTER_SHARES)),
        axis_spread=(x, y, z),
    )


def principal_spread(points: Floats, faces: Ints) -> tuple[Floats, float, Floats, Floats]:
    """Centre, radius and principal axes of a surface, weighted by area.

    Returns:
        (3,) centre of area, m; root mean square distance from it, m; (3,) the same along the principal axes, the widest
        first, m; (3, 3) these axes as columns, right-handed.
    Raises:
        DegenerateShape: the surface has no area.
    """
    corners = points[faces]
    if (
        not len(faces)
        or not np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).sum()
    ):
        raise DegenerateShape("a surface without an area has no form")
    area, center, inertia = shell_moments(points, faces)
    covariance = (np.trace(inertia) / 2 * np.eye(3) - inertia) / area
    values, vectors = np.linalg.eigh(covariance)
    sides, frame = np.sqrt(np.maximum(values[::-1], 0.0)), vectors[:, ::-1]
    if np.linalg.det(frame) < 0:
        frame = frame * np.array([1.0, 1.0, -1.0])
    return center, float(np.sqrt(np.maximum(values, 0.0).sum())), sides, frame


def quantile_means(values: Floats, count: int) -> list[float]:
    """Means of `count` equal shares of the values, ascending.

    The distance between two such lists is about that of Wasserstein, which one value more or less hardly moves.
    """
    return [float(part.mean()) for part in np.array_split(np.sort(values), count)]


def descriptor_distance(one: ShapeDescriptor, other: ShapeDescriptor) -> float:
    """Distance between two shape descriptors, relative to the radius; copies stay below some hundredths."""
    pairs = np.abs(np.subtract(one.pair_distances, other.pair_distances)).mean()
    reach = np.abs(np.subtract(one.center_distances, other.center_distances)).mean()
    axes = np.abs(np.subtract(one.axis_spread, other.axis_spread)).max()
    return float(max(pairs, reach, axes))


def descriptor_distances(ones: Sequence[ShapeDescriptor], others: Sequence[ShapeDescriptor]) -> Floats:
    """(N, M) distances of N shape descriptors to M others, each as `descriptor_distance` has it."""
    from scipy.spatial.distance import cdist

    def table(field: str, metric: str) -> Floats:
        one, other = (np.array([getattr(d, field) for d in group], dtype=np.float64) for group in (ones, others))
        return np.asarray(cdist(one, other, metric), dtype=np.float64)

    pairs = table("pair_distances", "cityblock") / PAIR_SHARES
    reach = table("center_distances", "cityblock") / CENTER_SHARES
    return np.maximum(np.maximum(pairs, reach), table("axis_spread", "chebyshev"))


def _short(value: float) -> float:
    """Four digits: more would be noise of the places that were picked."""
    return decimals(value, 4)
