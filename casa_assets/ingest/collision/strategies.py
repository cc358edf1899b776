"""Strategies for collision shapes, cheap and exact first: one shape, one per part, rings, cuts, decomposers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.mesh.measure import solid_moments
from casa_assets.geometry.mesh.topology import face_components
from casa_assets.geometry.solid.cutting import Solid, hull_points, hull_within_tolerance, simplify_solid, surface_of
from casa_assets.geometry.solid.deviation import protrusion
from casa_assets.geometry.solid.hull import convex_hull, small_hull
from casa_assets.geometry.solid.manifold import simplified_solid
from casa_assets.geometry.solid.primitive import best_primitive
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.ingest.collision.components import any_nested, connected_parts, thickness
from casa_assets.ingest.collision.convex_decomposition import Budget
from casa_assets.ingest.collision.fit import FitReference, measure_fit
from casa_assets.ingest.collision.plane_splits import ErrorBound, merge_within_bound, normalized_error, split_to_bound
from casa_assets.ingest.collision.ring_sectors import cut_vessel
from casa_assets.ingest.collision.solid_proxy import SolidProxy
from casa_assets.ingest.draft import PlacedShape
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.shape import Box, Cylinder, Hull
from casa_assets.model.record import Record

Decomposer = Callable[[str, Floats, Ints, Budget], list[Floats]]

# Faces that the decomposition sees; more change the hulls hardly and the time a lot.
COACD_FACES = 2000
# Faces that cutting by planes works on at most, where that can be had.
CUT_FACES = 2500
# Shares of the bound that a way aims at, so that reducing vertices does not break it, and that the reducing may use.
AIM_SHARE = 0.8
REDUCE_SHARE = 0.15
# A chord of a wall may cut so much of its thickness.
CHORD_SHARE = 0.4
# What fills this share of its hull is one hull if that is within the bound; a full thing may stick out somewhere.
ONE_HULL_SHARE = 0.8
STALK = 2.0
ROLLING = 0.88
PRIMITIVE = 0.85
# A thing that is full is a primitive that its hull fills so far: a can with its rims is a cylinder, a carton a box.
WHOLE_PRIMITIVE = 0.89
# A part is the primitive that its hull fills so far, if that is within the bound.
PART_PRIMITIVE = 0.92
NO_RATIO = 2.0
# Cosine to the ground of the side that a box stands on.
LOOKS_DOWN = 0.9
# A general decomposition is tried where the best so far is so many times beyond the bound.
COACD_FROM_ERROR = 2.5
VHACD_FROM_ERROR = 3.0
# Hollow under a floor, as a part of the longest side, that may be filled.
FOOT_SHARE = 0.04
# So many times the bound may walls be off before that is done: moved outwards, they are half as far off.
MAX_SHIFT_ERROR = 1.6
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
class CollisionTask:
    """Input of a strategy.

    Attributes:
        points, faces: (P, 3) welded, metres, and (F, 3).
        full: matter all through, so that holes in the surface are closed. fill: of the hull, 0..1.
        rolls: it has no pose of its own. packed: it is goods in a can, a box and the like.
        made: the solid that the surface stands for. by: what shapes are held against.
        params: limits. decomposer: runs CoACD or V-HACD out of process.
    """

    points: Floats
    faces: Ints
    full: bool
    fill: float
    rolls: bool
    packed: bool
    made: SolidProxy
    by: FitReference
    params: CollideParams
    decomposer: Decomposer

    @property
    def budget(self) -> Budget:
        """Limits of a convex decomposition."""
        return Budget(hulls=self.params.hull_count, hull_vertices=self.params.hull_vertices)

    @property
    def aim(self) -> ErrorBound:
        """Error bound that cuts aim at, somewhat below the one that is judged."""
        return ErrorBound(AIM_SHARE * self.by.bound.p95, AIM_SHARE * self.by.bound.worst)

    @property
    def slack(self) -> float:
        """Distance that reducing vertices may move a hull, metres."""
        return REDUCE_SHARE * self.by.bound.p95


def _by_one(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """One primitive or hull around everything, where it lies close enough."""
    if task.fill < ONE_HULL_SHARE:
        return [], ""
    shell, _ = convex_hull(task.points)
    fit = best_primitive(shell)
    if fit is not None and fit.ratio >= PRIMITIVE:
        placed = PlacedShape(shape=fit.shape, pose=fit.pose)
        if measure_fit(clouds_of((placed,)), task.by, task.params.error_m).normalized_error <= 1:
            return [placed], f"one {fit.shape.kind}"
        # A can is one cylinder and a carton one box, whatever rims and lids they have.
        if task.packed and fit.ratio >= WHOLE_PRIMITIVE and isinstance(fit.shape, Box | Cylinder):
            return [
                whole_shape(shell, True, task.params, task.by.samples)
            ], f"one {fit.shape.kind}, rims and lids aside"
    points, faces = small_hull(shell, task.params.hull_vertices)
    found = measure_fit([points], task.by, task.params.error_m)
    if found.normalized_error <= 1:
        return [PlacedShape(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))], "one hull"
    off, bound = found.off, task.by.bound
    # What has no pose of its own rolls: one shape with its stalk does that better than parts with edges.
    rolls = task.rolls and task.fill >= ROLLING
    stalk = off.added_p95 <= bound.p95 and off.added_worst <= STALK * bound.worst
    near = task.full and (rolls or stalk)
    return ([whole_shape(shell, task.packed, task.params, task.by.samples)], "one shape") if near else ([], "")


def _by_pieces(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """One shape for each piece; none where one of them is not convex."""
    pieces = connected_parts(task.points, task.faces, task.params.hull_count)
    if len(pieces) < 2 or any(p.fill < task.params.hull_ratio for p in pieces) or any_nested(pieces):
        return [], ""
    return [one_shape(p.points, task.params) for p in pieces], "one shape for each piece"


def _by_rings(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """A vessel as floor, rings of sectors and handles; none where there is no opening, or no such cut."""
    if not len(task.by.room):
        return [], ""
    finest = min(CHORD_SHARE * task.made.wall, AIM_SHARE * task.by.bound.p95)
    solid = simplify_solid(task.made.solid, task.slack / 2)
    fair, foot = MAX_SHIFT_ERROR * task.by.bound.p95, FOOT_SHARE * task.by.of.longest
    vessel = cut_vessel(solid, finest, fair, foot, task.params.hull_count)
    if vessel is None:
        return [], ""
    room = task.params.hull_count - len(vessel.floors)
    pieces = [*vessel.floors, *split_to_bound([*vessel.cells, *vessel.rest], task.by.of, task.by.bound, room)]
    floors = [hull_within_tolerance(hull_points([p]), task.params.hull_vertices, task.slack) for p in vessel.floors]
    walls = [_shared_out(piece, task) for piece in pieces[len(vessel.floors) :]]
    return _shapes([*floors, *walls], task), vessel.message


def _shared_out(piece: Solid, task: CollisionTask) -> Floats:
    """The hull around a part of a wall, moved level and outwards where it fills much: as far off before as behind."""
    cloud = hull_within_tolerance(hull_points([piece]), task.params.hull_vertices, task.slack)
    beyond = protrusion(cloud, task.by.of)
    error = float(np.percentile(beyond, 95)) if len(beyond) else 0.0
    if error <= task.aim.p95:
        return cloud
    # What the hull adds lies on its hollow side.
    away = solid_moments(*surface_of(piece))[1] - solid_moments(*convex_hull(cloud))[1]
    length = float(np.hypot(away[0], away[1]))
    if length <= 0:
        return cloud
    # Never so far that a hand would feel a wall where none is seen.
    shift = min(error / 2, max(task.params.error_m, task.aim.p95))
    moved: Floats = cloud + np.array([away[0], away[1], 0.0]) / length * shift
    return (
        moved
        if normalized_error(moved, task.by.of, task.aim) < normalized_error(cloud, task.by.of, task.aim)
        else cloud
    )


def _by_cuts(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """Cut by planes where hulls would stick out most."""
    solid = simplify_solid(task.made.solid, task.slack / 2, CUT_FACES, 2 * task.slack)
    pieces = split_to_bound([solid], task.by.of, task.aim, task.params.hull_count)
    groups = merge_within_bound(pieces, task.by.of, task.aim, task.by.room)
    return _hulls(groups, task), "cut by planes where hulls would stick out"


def _by_coacd(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """CoACD of a closed manifold that hangs together enough: it gives every loose piece a hull of its own at least."""
    solid = simplified_solid(*surface_of(task.made.solid), COACD_FACES)
    if solid is None or len(np.unique(face_components(solid[1], len(solid[0])))) > task.params.hull_count:
        return [], ""
    # CoACD's surface error is about half the threshold times the longest side.
    threshold = min(max(2 * task.params.error_m / task.by.of.longest, 0.03), 0.2)
    clouds = task.decomposer("coacd", *solid, replace(task.budget, threshold=threshold))
    return _shapes(clouds, task), "decomposed by CoACD"


def _by_vhacd(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """V-HACD of the triangles as they are, in case the solid lacks some of them."""
    clouds = task.decomposer("vhacd", task.points, task.faces, task.budget)
    return _shapes(clouds, task), "decomposed by V-HACD"


# Each way, and the strain of the best so far at which it is not tried.
STRATEGIES: tuple[tuple[Callable[[CollisionTask], tuple[list[PlacedShape], str]], float], ...] = (
    (_by_one, 0.0),
    (_by_pieces, np.inf),
    (_by_rings, 1.0),
    (_by_cuts, 1.0),
    (_by_coacd, COACD_FROM_ERROR),
    (_by_vhacd, VHACD_FROM_ERROR),
)


def _hulls(groups: list[list[Solid]], task: CollisionTask) -> list[PlacedShape]:
    """A hull of few vertices, or the primitive that it is, around each group of solids."""
    clouds = [hull_within_tolerance(hull_points(group), task.params.hull_vertices, task.slack) for group in groups]
    return _shapes(clouds, task)


def clouds_of(shapes: tuple[PlacedShape, ...]) -> list[Floats]:
    """Vertices of each shape, metres."""
    return [tessellate(s.shape, s.pose)[0] for s in shapes]


def _shapes(clouds: list[Floats], task: CollisionTask) -> list[PlacedShape]:
    whole = [cloud for cloud in clouds if thickness(cloud) > SPLINTER_M]
    return [s for s in (_shape_or_none(cloud, task) for cloud in whole) if s is not None]


def _shape_or_none(cloud: Floats, task: CollisionTask) -> PlacedShape | None:
    """The primitive around a cloud where it fits as well as a hull does, else the hull; None where it has no volume."""
    try:
        found = one_shape(cloud, task.params.replace(primitive_ratio=PART_PRIMITIVE))
    except DegenerateShape:
        return None
    if isinstance(found.shape, Hull):
        return found
    [grown] = clouds_of((found,))
    if normalized_error(grown, task.by.of, task.aim) <= max(1.0, normalized_error(cloud, task.by.of, task.aim)):
        return found
    return one_shape(cloud, task.params.replace(primitive_ratio=NO_RATIO))


def whole_shape(cloud: Floats, packed: bool, params: CollideParams, samples: Floats) -> PlacedShape:
    """The one shape around everything; goods in a box get a box between its bulges and its edges.

    Args:
        samples: (N, 3) points spread over the surface, metres.
    """
    least = min(params.primitive_ratio, WHOLE_PRIMITIVE) if packed else params.primitive_ratio
    found = one_shape(cloud, params.replace(primitive_ratio=least))
    return _between(found, found.shape, samples) if packed and isinstance(found.shape, Box) else found


def _between(placed: PlacedShape, box: Box, samples: Floats) -> PlacedShape:
    """A box with its sides moved in until they are as far before the surface as behind it; it stands as it did."""
    local = (samples - np.array(placed.pose.position)) @ placed.pose.rotation
    half = np.array(box.size) / 2
    gaps = np.concatenate([half - local, half + local], axis=1)  # to the sides ahead, then to those behind
    side = np.argmin(gaps.round(9), axis=1)
    inwards = np.zeros(6)
    for k in range(6):
        up = float(placed.pose.rotation[2, k % 3]) * (1 if k < 3 else -1)
        if (side == k).any() and up > -LOOKS_DOWN:
            inwards[k] = float(np.percentile(gaps[side == k, k], 90)) / 2
    size = np.array(box.size) - inwards[:3] - inwards[3:]
    center = np.array(placed.pose.position) + placed.pose.rotation @ ((inwards[3:] - inwards[:3]) / 2)
    shape = Box(size=(float(size[0]), float(size[1]), float(size[2])))
    at = (float(center[0]), float(center[1]), float(center[2]))
    return PlacedShape(shape=shape, pose=placed.pose.replace(position=at))


def one_shape(cloud: Floats, params: CollideParams) -> PlacedShape:
    """The primitive around a cloud where it fits tightly, else its hull of few vertices."""
    shell, _ = convex_hull(cloud)
    fit = best_primitive(shell) if params.primitive_ratio <= 1 else None
    if fit is not None and fit.ratio >= params.primitive_ratio:
        return PlacedShape(shape=fit.shape, pose=fit.pose)
    points, faces = small_hull(shell, params.hull_vertices)
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))
