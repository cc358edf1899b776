"""Align one surface with another, and describe shapes so that pose, scale and triangulation do not matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # which loads its parts when they are first used

from casa_assets.core.numeric import Floats, Ints, decimals, significant
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.deviation import samples_with_faces, surface_samples
from casa_assets.mesh.surface import face_normals, shell_moments
from casa_assets.model.asset.asset import CENTER_SHARES, PAIR_SHARES, ShapeDescriptor

# Places on a surface whose distances to each other are measured: a million pairs.
SURFACE_SAMPLES = 1500
# More digits of a descriptor would be noise of the places that were picked.
DIGITS = 4
# Places that are looked up, that a first look takes, that a fit takes, and that are measured at the end.
ALIGNMENT_SAMPLES, START_SAMPLES, FIT_SAMPLES, ERROR_SAMPLES = 8000, 100, 400, 1500
# Spreads along two axes that differ by less than this share do not distinguish the axes.
EQUAL_SPREAD_SHARE = 0.12
# Turns that are tried: about one axis, and of all kinds.
TURNS_ABOUT_AXIS, TURNS_ANY_AXIS = 36, 1000
# Starts that are followed up, and steps of each.
STARTS, STEPS = 6, 30
# A place is measured to the planes of this many neighbours, where it is not farther aside than this many spacings.
NEIGHBORS, MAX_ASIDE_SPACINGS = 4, 2.0
# In fitting, places farther off than this many times the median pull no more than that.
TRIM_MEDIANS = 3.0


def shape_descriptor(points: Floats, faces: Ints) -> ShapeDescriptor:
    """Shape descriptor of a surface, (P, 3) points in metres and (F, 3) faces.

    Ref: distances between random pairs of places, the D2 of Osada et al. 2002.

    Raises DegenerateShape: the surface has no area.
    """
    center, radius, axes, _ = principal_spread(points, faces)
    places = (surface_samples(points, faces, SURFACE_SAMPLES) - center) / radius
    reach = np.linalg.norm(places, axis=1)
    x, y, z = (decimals(float(side), DIGITS) for side in axes / radius)
    return ShapeDescriptor(
        radius=significant(radius, 6),
        pair_distances=tuple(
            decimals(v, DIGITS) for v in quantile_means(scipy.spatial.distance.pdist(places), PAIR_SHARES)
        ),
        center_distances=tuple(decimals(v, DIGITS) for v in quantile_means(reach, CENTER_SHARES)),
        axis_spread=(x, y, z),
    )


def principal_spread(points: Floats, faces: Ints) -> tuple[Floats, float, Floats, Floats]:
    """Centre, radius and principal axes of a surface, weighted by area.

    Returns (3,) centre of area, m; root mean square distance from it, m; (3,) the same along the principal axes, the
    widest first, m; (3, 3) these axes as columns, right-handed. Raises DegenerateShape: the surface has no area.
    """
    if not len(faces) or not face_normals(points, faces)[1].sum():
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

    def table(field: str, metric: str) -> Floats:
        one, other = (np.array([getattr(d, field) for d in group], dtype=np.float64) for group in (ones, others))
        return np.asarray(scipy.spatial.distance.cdist(one, other, metric), dtype=np.float64)

    pairs = table("pair_distances", "cityblock") / PAIR_SHARES
    reach = table("center_distances", "cityblock") / CENTER_SHARES
    return np.maximum(np.maximum(pairs, reach), table("axis_spread", "chebyshev"))


@dataclass(frozen=True)
class SampledSurface:
    """A surface sampled for registration: centred, root mean square distance from the centre 1.

    `places`, `normals`: (SURFACE_SAMPLES, 3). `spacing`: between two places. `axes`: (3,) spread along the principal
    axes. `frame`: (3, 3) these axes as columns.
    """

    places: Floats
    normals: Floats
    tree: scipy.spatial.cKDTree
    spacing: float
    axes: Floats
    frame: Floats

    def some(self, count: int) -> Floats:
        """(count, 3) of the places, evenly picked."""
        return self.places[np.arange(count) * len(self.places) // count]


@dataclass(frozen=True)
class Alignment:
    """Rotation of a surface, and percentiles of the distances that are left both ways, relative to the radius."""

    p95: float
    p995: float
    turn: Floats


def sampled_surface(points: Floats, faces: Ints) -> SampledSurface:
    """Sample and normalise a surface; (P, 3) points, (F, 3) faces. Raises DegenerateShape where it has no area."""
    center, radius, axes, frame = principal_spread(points, faces)
    normals, areas = face_normals(points, faces)
    places, face = samples_with_faces(points, faces, ALIGNMENT_SAMPLES)
    # The places follow the order of the faces; fixed jumps through them make any part of them a fair sample.
    order = np.arange(ALIGNMENT_SAMPLES) * 4801 % ALIGNMENT_SAMPLES
    spacing = float(np.sqrt(areas.sum() / ALIGNMENT_SAMPLES)) / radius
    local = (places[order] - center) / radius
    return SampledSurface(local, normals[face[order]], scipy.spatial.cKDTree(local), spacing, axes / radius, frame)


def align(one: SampledSurface, other: SampledSurface) -> Alignment:
    """Align the first surface with the second as closely as was found; mirror images are not tried."""
    best: Alignment | None = None
    for turn in _starts(one, other):
        found, shift = _followed(one.some(FIT_SAMPLES), turn, other)
        off = _apart(one.some(ERROR_SAMPLES) @ found.T + shift, other)
        back = _apart((other.some(ERROR_SAMPLES) - shift) @ found, one)
        p95, p995 = (max(float(np.quantile(off, q)), float(np.quantile(back, q))) for q in (0.95, 0.995))
        if best is None or (p95, p995) < (best.p95, best.p995):
            best = Alignment(round(p95, 5), round(p995, 5), found)
    assert best is not None, "there are starts"
    return best


def _starts(one: SampledSurface, other: SampledSurface) -> list[Floats]:
    """Starting rotations, best first, by how near the first surface comes to the second at once."""
    turns = _candidates(one, other)
    coarse = scipy.spatial.cKDTree(other.some(1000))
    moved = np.einsum("kij,nj->kni", turns, one.some(START_SAMPLES))
    far = coarse.query(moved.reshape(-1, 3))[0].reshape(len(turns), -1)
    order = np.argsort(np.mean(far, axis=1).round(9), kind="stable")
    return [turns[i] for i in order[:STARTS]]


def _candidates(one: SampledSurface, other: SampledSurface) -> Floats:
    """(K, 3, 3) rotations that align the principal axes; turns of all kinds about axes that cannot be distinguished."""
    x, y, z = (one.axes + other.axes) / 2
    first, second = y > (1 - EQUAL_SPREAD_SHARE) * x, z > (1 - EQUAL_SPREAD_SHARE) * y
    if first and second:
        # Spread evenly over all rotations. Ref: Alexa 2022, super-Fibonacci spirals.
        share = (np.arange(TURNS_ANY_AXIS) + 0.5) / TURNS_ANY_AXIS
        inner, outer = np.sqrt(share), np.sqrt(1 - share)
        alpha = 2 * np.pi * (np.arange(TURNS_ANY_AXIS) + 0.5) / np.sqrt(2.0)
        beta = 2 * np.pi * (np.arange(TURNS_ANY_AXIS) + 0.5) / 1.533751168755204288118041
        rows = (inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta), outer * np.cos(beta))
        return np.asarray(scipy.spatial.transform.Rotation.from_quat(np.stack(rows, axis=1)).as_matrix())
    flips = [np.diag(signs) for signs in ((1.0, 1, 1), (1.0, -1, -1), (-1.0, 1, -1), (-1.0, -1, 1))]
    within = [np.eye(3)]
    if first or second:
        axis = np.array([0.0, 0.0, 1.0]) if first else np.array([1.0, 0.0, 0.0])
        angles = np.arange(TURNS_ABOUT_AXIS) * 2 * np.pi / TURNS_ABOUT_AXIS
        within = list(scipy.spatial.transform.Rotation.from_rotvec(angles[:, None] * axis).as_matrix())
    return np.array([other.frame @ flip @ turn @ one.frame.T for turn in within for flip in flips])


def _followed(places: Floats, turn: Floats, other: SampledSurface) -> tuple[Floats, Floats]:
    """Rotation and shift after fitting from a start. Ref: point to plane, Chen and Medioni 1992."""
    shift = np.zeros(3)
    for _ in range(STEPS):
        moved = places @ turn.T + shift
        far, nearest = other.tree.query(moved)
        normal = other.normals[nearest]
        level = np.einsum("ij,ij->i", other.places[nearest] - moved, normal)
        pull = np.minimum(1.0, TRIM_MEDIANS * float(np.median(far)) / np.maximum(far, 1e-9))
        rows = np.hstack([np.cross(moved, normal), normal]) * pull[:, None]
        # A round thing may slide along itself: the least step that fits is taken.
        step = np.linalg.lstsq(rows, level * pull, rcond=1e-4)[0]
        small = scipy.spatial.transform.Rotation.from_rotvec(step[:3]).as_matrix()
        turn, shift = small @ turn, small @ shift + step[3:]
        if float(np.abs(step).max()) < 1e-5:
            break
    return turn, shift


def _apart(places: Floats, of: SampledSurface) -> Floats:
    """(N,) distance of places from a surface: to the planes of its nearest places, where these are near enough."""
    far, nearest = of.tree.query(places, k=NEIGHBORS)
    way = places[:, None] - of.places[nearest]
    level = np.abs(np.einsum("nkj,nkj->nk", way, of.normals[nearest]))
    aside = np.sqrt(np.maximum(far**2 - level**2, 0.0))
    return np.asarray(np.where(aside < MAX_ASIDE_SPACINGS * of.spacing, level, far).min(axis=1))
