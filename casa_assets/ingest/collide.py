"""Collision shapes, the cheap and exact ones first: one primitive or hull, one per piece, then decomposition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.geometry.coverage import gaps, surface_samples
from casa_assets.geometry.hull import convex_hull, hull_volume, small_hull
from casa_assets.geometry.primitive import best_primitive
from casa_assets.geometry.solid import closed_solid, simplified_solid
from casa_assets.geometry.tessellate import surface
from casa_assets.geometry.topology import weld
from casa_assets.geometry.voxel import boundary, voxelise
from casa_assets.ingest.decompose import Budget, DecompositionFailed, decompose
from casa_assets.ingest.draft import Draft, Placed, warning
from casa_assets.ingest.pieces import Piece, any_nested, measured, split, thickness
from casa_assets.model.category import Build, Category
from casa_assets.model.issue import Issue
from casa_assets.model.mesh import Mesh
from casa_assets.model.record import Record
from casa_assets.model.shape import Hull

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Decomposer = Callable[[str, Floats, Ints, Budget], list[Floats]]

# Faces that the decomposition sees; more change the hulls hardly and the time a lot.
COACD_FACES = 2000
# Points on the surface that the cover is judged by; the share that may be bare at best, and at worst.
SAMPLES = 4000
BARE_GOOD = 0.01
BARE_BAD = 0.04  # a little below the limit of the check, which samples the finished mesh
# Cubes along the longest side where a broken surface is made solid.
SOLID_CELLS = 80
# V-HACD uses all the hulls that it is given: fewer are tried first, and taken where they hold hardly more.
SOLID_HULLS = (4, 8, 16)
SOLID_EXCESS = 1.1
SOLID_VOXELS = 120_000  # the grid holds no more detail, and V-HACD's time grows with them
# A hull thinner than this, metres, is a splinter that no contact feels.
SPLINTER_M = 1e-5


class CollideParams(Record):
    """Limits of the stage: most hulls and vertices, least volume ratios, surface error in metres."""

    hull_count: int = 32
    hull_vertices: int = 64
    primitive_ratio: float = 0.95
    hull_ratio: float = 0.95
    error_m: float = 0.004


@dataclass(frozen=True)
class Task:
    """What a way of making shapes works on.

    Attributes:
        points, faces: (P, 3) welded, metres, and (F, 3).
        full: matter all through, so that holes in the surface are closed.
        params: limits. decomposer: runs CoACD or V-HACD out of process.
    """

    points: Floats
    faces: Ints
    full: bool
    params: CollideParams
    decomposer: Decomposer

    @property
    def budget(self) -> Budget:
        """What a decomposition may make of it."""
        return Budget(hulls=self.params.hull_count, hull_vertices=self.params.hull_vertices)


@dataclass(frozen=True)
class Cover:
    """Shapes, how they were made, and the share of the surface that they leave bare (0..1)."""

    shapes: tuple[Placed, ...]
    how: str
    bare: float


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Shapes that stand in for the surface in contacts.

    The cheap and exact ways come first; the first that leaves hardly any of the surface bare is taken.

    Args:
        draft: metres, z up.
        category: vessels keep their opening; solid and filled things are closed where the mesh is not.
        decomposer: runs CoACD or V-HACD out of process.
    Raises:
        Rejected: no shape with a volume can be made (MSH004).
    """
    vertices, faces = draft.soup()
    points, place = weld(vertices)
    full = category.build in (Build.SOLID, Build.FILLED)
    task = Task(points, place[faces], full, params, decomposer)
    whole = measured(task.points, task.faces, bridge=full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    notes: list[Issue] = []
    if whole.fill >= params.hull_ratio:
        best = Cover((_shape(whole.points, params),), "one shape: the mesh fills its hull", 0.0)
    else:
        best = _best(task, whole, notes)
    because = f"the mesh fills {whole.fill:.0%} of its hull; {best.bare:.1%} of it is bare"
    return draft.replace(
        colliders=best.shapes,
        guesses=draft.guessed("collision", best.how, 1 - min(1.0, 5 * best.bare), because),
        notes=draft.noted(*notes),
    )


def _best(task: Task, whole: Piece, notes: list[Issue]) -> Cover:
    """The first way that covers well, else the one that covers best, else one hull around everything."""
    samples = surface_samples(task.points, task.faces, SAMPLES)
    reach = max(task.params.error_m, 0.02 * float(np.ptp(task.points, axis=0).max()))
    best: Cover | None = None
    # V-HACD may leave the inside of a thing that is full hollow; the grid does not.
    broken = (_by_solid, _by_vhacd) if task.full else (_by_vhacd, _by_solid)
    for way in (_by_pieces, _by_coacd, *broken):
        try:
            shapes = way(task)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        if not shapes or len(shapes) > task.params.hull_count:
            continue
        clouds = [surface(s.shape, s.pose)[0] for s in shapes]
        bare = float((gaps(samples, clouds) > reach).mean())
        if best is None or bare < best.bare:
            best = Cover(tuple(shapes), WORDS[way.__name__], bare)
        if bare <= BARE_GOOD:
            break
    if best is None or best.bare > BARE_BAD:
        notes.append(
            warning("MSH020", "collision", "no decomposition covers the surface; one hull closes every opening")
        )
        return Cover((_shape(whole.points, task.params),), "one hull", 0.0)
    return best


def _by_pieces(task: Task) -> list[Placed]:
    """One shape for each convex piece, and CoACD for the others where they are manifolds; empty where they are not."""
    params = task.params
    pieces = split(task.points, task.faces, params.hull_count)
    convex = [p for p in pieces if p.fill >= params.hull_ratio]
    rest = [p for p in pieces if p.fill < params.hull_ratio]
    if len(pieces) < 2 or len(convex) + 4 * len(rest) > params.hull_count:
        return []
    if any(closed_solid(p.points, p.faces) is None for p in rest) or any_nested(pieces):
        return []
    shapes = [_shape(p.points, params) for p in convex]
    room = params.hull_count - len(shapes)
    total = sum(p.hull_volume for p in rest)
    for piece in rest:
        share = max(4, int((room - 4 * len(rest)) * piece.hull_volume / total))
        smaller = params.replace(hull_count=share)
        shapes += _by_coacd(replace(task, points=piece.points, faces=piece.faces, params=smaller))
    return shapes


def _by_coacd(task: Task) -> list[Placed]:
    """CoACD of a closed manifold; empty where the mesh is none."""
    solid = simplified_solid(task.points, task.faces, COACD_FACES)
    if solid is None:
        return []
    # CoACD's surface error is about half the threshold times the longest side.
    longest = float(np.ptp(task.points, axis=0).max())
    threshold = min(max(2 * task.params.error_m / longest, 0.03), 0.2)
    return _shapes(task.decomposer("coacd", *solid, replace(task.budget, threshold=threshold)), task.params)


def _by_vhacd(task: Task) -> list[Placed]:
    """V-HACD of the triangles as they are."""
    return _shapes(task.decomposer("vhacd", task.points, task.faces, task.budget), task.params)


def _by_solid(task: Task) -> list[Placed]:
    """V-HACD of the solid that the surface encloses on a grid, which closes gaps between open pieces."""
    grid = voxelise(task.points, task.faces, SOLID_CELLS, bridge=task.full)
    corners, faces = boundary(grid)
    # Cubes stick out by half a cell; the ground and the sides of the box must not.
    low, high = task.points.min(axis=0), task.points.max(axis=0)
    clouds: list[Floats] = []
    for count in (*(n for n in SOLID_HULLS if n < task.params.hull_count), task.params.hull_count):
        found = task.decomposer("vhacd", corners, faces, replace(task.budget, voxels=SOLID_VOXELS, hulls=count))
        clouds = [np.clip(cloud, low, high) for cloud in found]
        if sum(hull_volume(cloud) for cloud in clouds) <= SOLID_EXCESS * int(grid.solid.sum()) * grid.cell**3:
            break
    return _shapes(clouds, task.params)


WORDS = {
    "_by_pieces": "one shape for each piece, CoACD for the hollow ones",
    "_by_coacd": "decomposed by CoACD",
    "_by_vhacd": "decomposed by V-HACD",
    "_by_solid": "made solid on a grid and decomposed by V-HACD",
}


def _shapes(clouds: list[Floats], params: CollideParams) -> list[Placed]:
    whole = [cloud for cloud in clouds if thickness(cloud) > SPLINTER_M]
    return [s for s in (_shape_or_none(cloud, params) for cloud in whole) if s is not None]


def _shape_or_none(cloud: Floats, params: CollideParams) -> Placed | None:
    try:
        return _shape(cloud, params)
    except DegenerateShape:
        return None


def _shape(cloud: Floats, params: CollideParams) -> Placed:
    """The primitive around a cloud where it fits tightly, else its hull of few vertices."""
    shell, _ = convex_hull(cloud)
    fit = best_primitive(shell)
    if fit is not None and fit.ratio >= params.primitive_ratio:
        return Placed(shape=fit.shape, pose=fit.pose)
    points, faces = small_hull(shell, params.hull_vertices)
    return Placed(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))
