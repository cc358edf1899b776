"""Sample surfaces; measure the error of convex shapes against them, and which faces are seen from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # which loads its parts when they are first used

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.solids import convex_hull, hull_planes
from casa_assets.mesh.surface import face_normals

SURFACE_SAMPLES = 20_000
HULL_SAMPLES = 400  # on each shape
PROBES = 5000
# What lies so little beyond another shape, as a part of the longest side, is the joint between two.
JOINT_SHARE = 0.004
# The normal of the nearest sample gives the distance where that sample is not farther aside than this many spacings.
MAX_ASIDE_SPACINGS, VOTERS = 3.0, 9
# Points that are strewn, pixels along the longest side, and directions from which the pictures are taken besides those
# along the axes: this many points fall into a pixel that next to no gap shows what lies behind.
SAMPLES = 60_000
PIXELS = 40
DIRECTIONS = 24
# Cosine to the line of sight below which a face is seen too much from its edge to say which side is seen.
GRAZING_COSINE = 0.2
# How much deeper than the nearest point of its pixel a point may lie and still be seen, in pixels.
DEPTH_TOLERANCE_PX = 1.0


def surface_samples(points: Floats, faces: Ints, count: int) -> Floats:
    """(count, 3) points spread evenly over the area, the same for the same surface."""
    return samples_with_faces(points, faces, count)[0]


def samples_with_faces(points: Floats, faces: Ints, count: int) -> tuple[Floats, Ints]:
    """(count, 3) points spread evenly over the area, the same for the same surface, and the face of each.

    Ref: systematic sampling of the cumulative area, and the R2 sequence (Roberts 2018) within the triangles.
    """
    face, u, v = barycentric_samples(points, faces, count)
    a, b, c = (points[faces[face, k]] for k in range(3))
    samples: Floats = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return samples, face


def barycentric_samples(points: Floats, faces: Ints, count: int) -> tuple[Ints, Floats, Floats]:
    """(count,) faces of the samples, and their weights of the second and of the third corner."""
    ends = np.cumsum(face_normals(points, faces)[1])
    at = (np.arange(count) + 0.5) / count * ends[-1]
    face = np.minimum(np.searchsorted(ends, at), len(faces) - 1)
    step = np.arange(1, count + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])
    u, v = (step % 1.0).T
    beyond = u + v > 1
    return face.astype(np.int64), np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)


def distances_outside_hulls(samples: Floats, clouds: Sequence[Floats]) -> Floats:
    """(N,) distance of each of (N, 3) samples from the nearest hull, 0 within one; metres. Raises DegenerateShape.

    Measured to the planes of the faces: exact over faces, a little short over edges and corners.
    """
    nearest = np.full(len(samples), np.inf)
    for cloud in clouds:
        planes = hull_planes(cloud)
        for start in range(0, len(samples), 4096):
            rows = slice(start, start + 4096)
            outside = (samples[rows] @ planes[:, :3].T + planes[:, 3]).max(axis=1)
            nearest[rows] = np.minimum(nearest[rows], np.maximum(outside, 0.0))
    return nearest


def inside_share(points: Floats, clouds: Sequence[Floats]) -> float:
    """Share of some points, (N, 3), that lie in the hull of one of the clouds."""
    is_inside = np.zeros(len(points), dtype=bool)
    for cloud in clouds:
        planes = hull_planes(cloud)
        is_inside |= ((points @ planes[:, :3].T + planes[:, 3]).round(9) < 0).all(axis=1)
    return float(is_inside.mean())


@dataclass(frozen=True)
class ReferenceSurface:
    """A closed surface, sampled, that distances are measured to.

    `samples`, `normals`: (N, 3) points spread over it and where they face. `spacing`: between two of them, metres.
    `longest`: side of the box around it, metres. `probes`: (M, 3) fewer, of what can be touched and buried.
    """

    samples: Floats
    normals: Floats
    tree: scipy.spatial.cKDTree
    spacing: float
    longest: float
    probes: Floats


def reference_surface(points: Floats, faces: Ints, count: int = SURFACE_SAMPLES) -> ReferenceSurface:
    """Sample a closed outward surface, (P, 3) points and (F, 3) faces, for distances to it."""
    normals, areas = face_normals(points, faces)
    samples, face = samples_with_faces(points, faces, count)
    spacing = float(np.sqrt(areas.sum() / count))
    longest = float(np.ptp(points, axis=0).max())
    return ReferenceSurface(
        samples, normals[face], scipy.spatial.cKDTree(samples), spacing, longest, samples[:: max(1, count // PROBES)]
    )


def signed_distances(queries: Floats, of: ReferenceSurface) -> Floats:
    """(N,) signed distance of each query from the surface, below 0 within it; rounded to a micrometre."""
    far, nearest = of.tree.query(queries)
    level = np.einsum("ij,ij->i", queries - of.samples[nearest], of.normals[nearest])
    aside = np.sqrt(np.maximum(far**2 - level**2, 0.0))
    found: Floats = np.where(aside < MAX_ASIDE_SPACINGS * of.spacing, level, np.where(level > 0, far, -far))
    # One sample says little of what is far from it: where it lies aside, the nearest ones vote for the side.
    unsure = np.flatnonzero((aside >= MAX_ASIDE_SPACINGS * of.spacing) & (level > 0))
    if len(unsure):
        _, voters = of.tree.query(queries[unsure], k=min(VOTERS, len(of.samples)))
        votes = np.einsum("ikj,ikj->ik", queries[unsure][:, None] - of.samples[voters], of.normals[voters])
        found[unsure] = np.where(votes.sum(axis=1) > 0, far[unsure], -far[unsure])
    return found.round(6)


def distances_outside(queries: Floats, of: ReferenceSurface) -> Floats:
    """(N,) distance of each query outside the surface, 0 within it; rounded to a micrometre."""
    return np.maximum(signed_distances(queries, of), 0.0)


def depths_within(queries: Floats, planes: Floats) -> Floats:
    """(N,) depth of each query within a convex shape, below 0 outside; rounded to a micrometre."""
    out = np.full(len(queries), -1.0)
    for start in range(0, len(queries), 4096):
        rows = slice(start, start + 4096)
        out[rows] = -(queries[rows] @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    return out.round(6)


def burial_depths(cloud: Floats, of: ReferenceSurface) -> Floats:
    """(N,) depth at which one shape buries the probes that it touches, metres. Raises DegenerateShape: no volume."""
    planes = hull_planes(cloud)
    near = ((of.probes >= cloud.min(axis=0)) & (of.probes <= cloud.max(axis=0))).all(axis=1)
    found = depths_within(of.probes[near], planes)
    return np.maximum(found[found > -of.spacing], 0.0)


def protrusion(cloud: Floats, of: ReferenceSurface) -> Floats:
    """(N,) how far the surface of one shape is outside the solid, where it is no face that cutting has made.

    Raises DegenerateShape: the cloud spans no volume.
    """
    points, faces = convex_hull(cloud)
    found = signed_distances(samples_with_faces(points, faces, HULL_SAMPLES)[0], of)
    return np.maximum(found[found > -JOINT_SHARE * of.longest], 0.0)


def excess(cloud: Floats, of: ReferenceSurface, others: Sequence[Floats] = ()) -> tuple[Floats, float]:
    """(N,) how far the surface of one shape lies outside the solid, at points evenly spread over it; its area, m^2.

    `others`: planes of other shapes; parts inside of these are no outer surface. Raises DegenerateShape: no volume.
    """
    points, faces = convex_hull(cloud)
    normals, areas = face_normals(points, faces)
    samples, face = samples_with_faces(points, faces, HULL_SAMPLES)
    free = np.ones(len(samples), dtype=bool)
    probes = samples + JOINT_SHARE * of.longest * normals[face]
    for planes in others:
        free &= ~((probes @ planes[:, :3].T + planes[:, 3]).round(9) <= 0).all(axis=1)
    return distances_outside(samples[free], of), float(areas.sum()) * float(free.mean())


@dataclass(frozen=True)
class Deviation:
    """Errors of shapes, metres: of what they add, by area and at worst, of what they leave bare, of what they bury."""

    added_p95: float
    added_worst: float
    bare_p95: float
    bare_worst: float
    buried_p95: float
    buried_worst: float


def deviation(clouds: Sequence[Floats], of: ReferenceSurface, bare: Floats) -> Deviation:
    """Measure how shapes differ from a solid; `bare`: (N,) how far samples of the mesh lie outside the shapes.

    Raises DegenerateShape: a cloud spans no volume, or there are no clouds.
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
    sunk = np.max([np.maximum(depths_within(of.probes, p), 0.0) for p in planes], axis=0)
    missed = float(np.percentile(bare, 95)), float(bare.max())
    return Deviation(
        p95, float(values.max(initial=0.0)), *missed, float(np.percentile(sunk, 95)), float(sunk.max(initial=0.0))
    )


@dataclass(frozen=True)
class Visibility:
    """Result of rendering a surface from all around.

    `samples`: (N, 3) points evenly over the area. `face`: (N,) the face of each. `front`, `back`: (N,) seen from its
    front, or with its back where no front lies as near, from some direction. `behind`: (D,) share of the silhouette
    that shows backs of faces, by direction. `away`: (D, 3) unit vectors, from the viewer to the thing.
    """

    samples: Floats
    face: Ints
    front: Mask
    back: Mask
    behind: Floats
    away: Floats


def measure_visibility(points: Floats, faces: Ints, count: int = SAMPLES) -> Visibility:
    """Measure how much of the faces, whose fronts are counterclockwise, is visible from outside, at `count` points."""
    samples, face = samples_with_faces(points, faces, count)
    normals = face_normals(points, faces)[0][face]
    cell = float(np.ptp(samples, axis=0).max()) / PIXELS
    front, back = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    away = np.concatenate([fibonacci_directions(DIRECTIONS), np.eye(3), -np.eye(3)])
    behind = np.zeros(len(away))
    for i, sight in enumerate(away):
        pixel, depth = _project(samples, sight, cell)
        nearest = np.full(int(pixel.max()) + 1, np.inf)
        np.minimum.at(nearest, pixel, depth)
        seen = depth <= nearest[pixel] + DEPTH_TOLERANCE_PX * cell
        facing = -(normals @ sight)
        ahead = np.zeros(len(nearest), dtype=bool)
        ahead[pixel[seen & (facing > 0)]] = True
        bare = seen & (facing < -GRAZING_COSINE) & ~ahead[pixel]
        front |= seen & (facing > GRAZING_COSINE)
        back |= bare
        showing = np.zeros(len(nearest), dtype=bool)
        showing[pixel[bare]] = True
        behind[i] = showing.sum() / np.isfinite(nearest).sum()
    return Visibility(samples, face, front, back, behind, away)


def fibonacci_directions(count: int) -> Floats:
    """(count, 3) unit vectors all around, evenly spread. Ref: Gonzalez 2010, the Fibonacci lattice."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def _project(samples: Floats, sight: Floats, cell: float) -> tuple[Ints, Floats]:
    """Pixel of each point, counted in one row, and its depth along the line of sight."""
    beside = np.cross(sight, np.eye(3)[int(np.argmin(np.abs(sight)))])
    beside /= np.linalg.norm(beside)
    plane = samples @ np.stack([beside, np.cross(sight, beside)], axis=1)
    at = np.floor((plane - plane.min(axis=0)) / max(cell, 1e-300)).astype(np.int64)
    width = int(at[:, 0].max()) + 1
    return at[:, 1] * width + at[:, 0], samples @ sight
