"""How far convex shapes reach beyond the solid that they stand in for, and how far it reaches beyond them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from casa_assets.errors import DegenerateShape
from casa_assets.geometry.coverage import placed_samples
from casa_assets.geometry.hull import convex_hull, hull_planes
from casa_assets.geometry.measure import face_normals

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SURFACE_SAMPLES = 20_000
HULL_SAMPLES = 400  # on each shape
# What lies so little beyond another shape, as a part of the longest side, is the joint between two.
JOINT = 0.004
# The normal of the nearest sample tells the distance where that sample is not farther aside than this many spacings.
ASIDE = 3.0


@dataclass(frozen=True)
class Ruler:
    """A closed surface that distances are taken to.

    Attributes:
        samples, normals: (N, 3) points spread over it and where they face. spacing: between two of them, metres.
        longest: side of the box around it, metres.
    """

    samples: Floats
    normals: Floats
    tree: cKDTree
    spacing: float
    longest: float


def ruler(points: Floats, faces: Ints, count: int = SURFACE_SAMPLES) -> Ruler:
    """Prepare a closed outward surface, (P, 3) points and (F, 3) faces, for distances to it."""
    normals, areas = face_normals(points, faces)
    samples, face = placed_samples(points, faces, count)
    spacing = float(np.sqrt(areas.sum() / count))
    return Ruler(samples, normals[face], cKDTree(samples), spacing, float(np.ptp(points, axis=0).max()))


def beyond(queries: Floats, of: Ruler) -> Floats:
    """(N,) how far each query lies outside the surface, 0 within it; rounded to a micrometre."""
    far, nearest = of.tree.query(queries)
    level = np.einsum("ij,ij->i", queries - of.samples[nearest], of.normals[nearest])
    aside = np.sqrt(np.maximum(far**2 - level**2, 0.0))
    distance = np.where(aside < ASIDE * of.spacing, level, np.where(level > 0, far, 0.0))
    return np.maximum(distance, 0.0).round(6)


def excess(cloud: Floats, of: Ruler, others: Sequence[Floats] = ()) -> tuple[Floats, float]:
    """(N,) how far the surface of one shape lies outside the solid, at points evenly spread over it; its area, m^2.

    Args:
        cloud: vertices of the shape. of: the solid.
        others: planes of other shapes; what lies in one of these is no outer surface and is left out.
    Raises:
        DegenerateShape: the cloud spans no volume.
    """
    points, faces = convex_hull(cloud)
    normals, areas = face_normals(points, faces)
    samples, face = placed_samples(points, faces, HULL_SAMPLES)
    free = np.ones(len(samples), dtype=bool)
    probes = samples + JOINT * of.longest * normals[face]
    for planes in others:
        free &= ~((probes @ planes[:, :3].T + planes[:, 3]).round(9) <= 0).all(axis=1)
    return beyond(samples[free], of), float(areas.sum()) * float(free.mean())


@dataclass(frozen=True)
class Deviation:
    """Errors of shapes, metres: of what they add, by area and at worst, and of what they leave bare."""

    added_p95: float
    added_worst: float
    bare_p95: float
    bare_worst: float


def deviation(clouds: Sequence[Floats], of: Ruler, bare: Floats) -> Deviation:
    """How shapes differ from a solid.

    Args:
        clouds: vertices of each shape. of: the solid. bare: (N,) how far samples of the mesh lie outside the shapes.
    Raises:
        DegenerateShape: a cloud spans no volume, or there are none.
    """
    if not clouds:
        raise DegenerateShape("there are no shapes")
    planes = [hull_planes(cloud) for cloud in clouds]
    rows = [excess(c, of, [p for j, p in enumerate(planes) if j != i]) for i, c in enumerate(clouds)]
    values = np.concatenate([v for v, _ in rows])
    weights = np.concatenate([np.full(len(v), a / max(len(v), 1)) for v, a in rows])
    order = np.argsort(values, kind="stable")
    reach = np.cumsum(weights[order])
    at = min(int(np.searchsorted(reach, 0.95 * reach[-1])), len(order) - 1) if len(order) else 0
    p95 = float(values[order][at]) if len(order) else 0.0
    worst = float(values.max(initial=0.0))
    return Deviation(p95, worst, float(np.percentile(bare, 95)), float(bare.max()))
