"""Stage `collide`: try kinds of collision shapes, cheap ones first, and take the first that is close enough."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest.collision.decompose import Budget, DecompositionFailed, decompose
from casa_assets.ingest.collision.fit import (
    SAMPLES,
    SOUND_SHARE,
    CollideParams,
    FitErrors,
    FitReference,
    box_gap,
    describe_fit,
    fit_reference,
    measure_fit,
    on_flat_foot,
)
from casa_assets.ingest.collision.plane_splits import (
    ErrorBound,
    merge_within_bound,
    normalized_error,
    split_to_bound,
    split_to_volume,
)
from casa_assets.ingest.collision.rings import cut_vessel
from casa_assets.ingest.collision.solid_proxy import (
    SolidProxy,
    any_nested,
    connected_parts,
    measure_part,
    solid_proxy,
    thickness,
    without_windows,
)
from casa_assets.ingest.draft import Draft, PlacedShape, placed_hull, warning
from casa_assets.mesh.solid import solids
from casa_assets.mesh.solid.deviation import protrusion, surface_samples
from casa_assets.mesh.solid.primitive import best_primitive, shape_bounds, tessellate
from casa_assets.mesh.surface import face_components, solid_moments
from casa_assets.mesh.voxels import NO_ROOMS, OpenRooms, open_rooms
from casa_assets.model.asset.parts import Box, Cylinder, Hull
from casa_assets.model.issue import REVIEW_CODE, Issue
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# Largest share of the surface that may stick out of the shapes; below the limit of the check of the finished mesh.
MAX_BARE_SHARE = 0.04
Decomposer = Callable[[str, Floats, Ints, Budget], list[Floats]]
# All numbers below are choices.
# Faces that CoACD is given; more of them hardly change the hulls and take much longer.
COACD_FACES = 2000
# With more faces than this after that, as lattices have, it takes minutes and is not tried.
MAX_COACD_FACES = 4000
# Faces that cutting by planes is given at most, as far as simplification reaches that.
CUT_FACES = 2500
# Share of the error bound that strategies aim at, and share that reducing the vertices of a hull may add.
AIM_SHARE, REDUCE_SHARE = 0.8, 0.15
# Share of the thickness of a wall that the chord of a sector may cut off.
CHORD_SHARE = 0.4
# One hull or primitive is tried for meshes that fill at least this share of their hull.
ONE_HULL_FILL = 0.8
# One shape is taken for something solid with a stalk if its largest error is at most this many times the bound, and for
# something without a resting pose if it fills so much of its hull.
STALK_ERROR, ROLLING_FILL = 2.0, 0.88
# Volume by which hulls may be wrong, beyond a solid and short of it, as a share of its volume, before it is cut further
# than the error bound asks for; and the number of parts at which that ends.
EXCESS_SHARE, MAX_FINE_PARTS = 0.04, 24
# Smallest share of a primitive that the hull has to fill: of one primitive for everything that is within the bound, of
# one for packed goods (a can with its rims is a cylinder, a carton a box), and of one for a part.
PRIMITIVE_FILL = 0.85
PACKED_PRIMITIVE_FILL = 0.89
PART_PRIMITIVE_FILL = 0.92
# More than any primitive reaches: only hulls are made.
NO_PRIMITIVE = 2.0
# Cosine between straight down and the outward normal of the side that a box rests on.
RESTING_SIDE_COSINE = 0.9
# Windows are closed, and a general decomposition is tried, where the best normalized error so far is larger than this.
WINDOWS_FROM_ERROR = 2.5
COACD_FROM_ERROR = 2.5
VHACD_FROM_ERROR = 3.0
# Height of a hollow below the floor that may be filled, as a share of the longest side.
FOOT_SHARE = 0.04
# Error of the walls, over the bound, from which on that hollow may be filled. Shifting a wall outwards halves it.
MAX_SHIFT_ERROR = 1.6
# Hulls thinner than this, metres, are dropped.
SPLINTER_M = 1e-5


class Candidate(NamedTuple):
    """Collision shapes of one strategy, with its name and their error; a normalized error of 1 is the bound."""

    shapes: tuple[PlacedShape, ...]
    name: str
    errors: FitErrors


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Choose collision shapes: the first strategy whose error is within the bound, else the one with the least error.

    Vessels keep their opening; solid and filled things are closed where the mesh, metres, z up, is not. The decomposer
    runs CoACD or V-HACD out of process. Raises Rejected: no shape with a volume can be made (MSH004).
    """
    points, faces = draft.surface.points, draft.surface.welded_faces
    rooms = _open_rooms(points, faces)
    is_full, is_packed = _is_full(category, rooms), category.build is MatterFill.FILLED
    rests_any_way = _is_known(category) and category.upright is RestingPose.ANY
    kept_rooms = rooms.kept(with_gaps=not is_full)
    whole = measure_part(points, faces, close_gaps=is_full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    notes: list[Issue] = []
    reason = f"the mesh fills {whole.hull_fill:.0%} of its hull"
    is_one_shape = is_full and whole.hull_fill >= params.hull_volume_ratio and not kept_rooms
    proxy = None if is_one_shape else solid_proxy(points, faces, is_full)
    task, best = None, None
    if proxy is not None:
        reference = fit_reference(points, faces, proxy.solid, not is_full, rooms, kept_rooms)
        fill = whole.hull_fill
        task = CollisionTask(
            points, faces, is_full, fill, rests_any_way, is_packed, proxy, reference, params, decomposer
        )
        best = _best(task, notes)
    shapes: tuple[PlacedShape, ...]
    if is_one_shape:
        samples = surface_samples(points, faces, SAMPLES)
        shapes = (whole_shape(whole.points, whole.hull_fill, is_packed, params, samples),)
        name, confidence = "one shape: the mesh fills its hull", 1.0
    elif task is not None and best is not None:
        shapes, name, confidence = best.shapes, best.name, 1 / (1 + max(0.0, best.errors.normalized_error - 1))
        if best.errors.closed_share > SOUND_SHARE * params.room_closed:
            notes.append(_closed_room_note(best.errors.closed_share, best.name, params))
        reason += f"; {task.proxy.message}; {describe_fit(clouds_of(shapes), task.reference, best.errors)}"
    else:
        message = "no decomposition covers the surface; one hull closes every opening"
        notes.append(warning("MSH020", "collision", message))
        shapes, name, confidence = (one_shape(whole.points, params),), "one hull", 0.5
        if kept_rooms:
            notes.append(_closed_room_note(1.0, name, params))
    guesses = draft.guessed("collision", name, confidence, reason)
    return draft.replace(colliders=shapes, guesses=guesses, notes=draft.noted(*notes))


def _closed_room_note(closed_share: float, name: str, params: CollideParams) -> Issue:
    """The question to a person where no shapes within the limits keep an open room open."""
    message = f"no {params.hull_count} shapes keep its open rooms: the best close {closed_share:.0%} of one ({name})"
    advice = "what is put in there is pushed out. Accept or reject it in review.csv"
    return warning(REVIEW_CODE, "collision", f"{message}; {advice}")


def _best(task: CollisionTask, notes: list[Issue]) -> Candidate | None:
    """The result of the best strategy, or None if no result covers the surface."""
    best: Candidate | None = None
    for strategy, good_enough in STRATEGIES:
        if best is not None and best.errors.is_sound and best.errors.normalized_error <= good_enough:
            break
        try:
            shapes, name = strategy(task)
            if not 0 < len(shapes) <= task.params.hull_count:
                continue
            found = _candidate(shapes, name, task)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        except DegenerateShape:
            continue
        if found.errors.bare_share <= MAX_BARE_SHARE and (best is None or found.errors.rank < best.errors.rank):
            best = found
    return best


def _candidate(shapes: Sequence[PlacedShape], name: str, task: CollisionTask) -> Candidate:
    """Shapes with their error, on a flat foot where that is as near: under a tube it would be a bottom."""
    plain = Candidate(tuple(shapes), name, measure_fit(clouds_of(tuple(shapes)), task.reference, task.params))
    if len(shapes) > task.part_count or task.rests_any_way:
        return plain
    standing = on_flat_foot(shapes, task.proxy.solid)
    if standing == plain.shapes:
        return plain
    footed = Candidate(standing, name, measure_fit(clouds_of(standing), task.reference, task.params))
    worst = max(1.0, plain.errors.normalized_error)
    is_near = footed.errors.normalized_error <= worst and footed.errors.is_sound >= plain.errors.is_sound
    return footed if is_near else plain


def _open_rooms(points: Floats, faces: Ints) -> OpenRooms:
    """The open rooms of a surface, or no rooms if it spans no volume."""
    used, compact = np.unique(faces, return_inverse=True)
    try:
        return open_rooms(points[used], compact.reshape(-1, 3))
    except DegenerateShape:
        return NO_ROOMS


def _is_full(category: Category, rooms: OpenRooms) -> bool:
    """True if holes in the surface are damage: something solid or filled, and no room that closing them would fill.

    Where only the backs of faces look into a room it is a gap in the surface of something that is known to be full. Of
    what is of no known kind that cannot be said.
    """
    is_usually_full = category.build in (MatterFill.SOLID, MatterFill.FILLED)
    return is_usually_full and not rooms.encloses(with_gaps=not _is_known(category))


def _is_known(category: Category) -> bool:
    """True unless it is the class above all others, which says nothing of how a thing is filled or rests."""
    return category.id != category.parent


@dataclass(frozen=True)
class CollisionTask:
    """Input of a strategy.

    `points`, `faces`: (P, 3) welded, metres, and (F, 3). `is_full`: solid all through, so that holes in the surface are
    closed. `hull_fill`: share of its hull, 0..1. `rests_any_way`: it has no preferred resting pose. `is_packed`: goods
    in a can, a box and the like. `proxy`: solid of the surface. `reference`: what shapes are measured against.
    `params`: limits. `decomposer`: runs CoACD or V-HACD out of process.
    """

    points: Floats
    faces: Ints
    is_full: bool
    hull_fill: float
    rests_any_way: bool
    is_packed: bool
    proxy: SolidProxy
    reference: FitReference
    params: CollideParams
    decomposer: Decomposer

    @property
    def part_count(self) -> int:
        """Most shapes of a strategy: one is left for a box under them."""
        return self.params.hull_count - 1

    @property
    def budget(self) -> Budget:
        """Limits of a convex decomposition."""
        return Budget(hulls=self.part_count, hull_vertices=self.params.hull_vertices)

    @property
    def aim(self) -> ErrorBound:
        """Error bound that cuts aim at, somewhat below the one that they are judged by."""
        return ErrorBound(AIM_SHARE * self.reference.bound.p95, AIM_SHARE * self.reference.bound.worst)

    @property
    def slack(self) -> float:
        """Distance that reducing vertices may move a hull, metres."""
        return REDUCE_SHARE * self.reference.bound.p95

    def reduced(self, cloud: Floats) -> Floats:
        """The vertices, (N, 3), of the hull around a cloud that a collision shape has."""
        return solids.hull_within_tolerance(cloud, self.params.hull_vertices, self.slack)


def _by_one(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """One primitive or hull around everything, where it lies close enough."""
    if task.hull_fill < ONE_HULL_FILL:
        return [], ""
    hull, _ = solids.convex_hull(task.points)
    primitive = best_primitive(hull)
    if primitive is not None and primitive.ratio >= PRIMITIVE_FILL:
        placed = PlacedShape(shape=primitive.shape, pose=primitive.pose)
        if measure_fit(clouds_of((placed,)), task.reference, task.params).normalized_error <= 1:
            return [placed], f"one {primitive.shape.kind}"
        # A can is one cylinder and a carton one box, whatever rims and lids they have.
        if task.is_packed and primitive.ratio >= PACKED_PRIMITIVE_FILL and isinstance(primitive.shape, Box | Cylinder):
            whole = whole_shape(hull, task.hull_fill, True, task.params, task.reference.samples)
            return [whole], f"one {whole.shape.kind}, rims and lids aside"
    points, faces = _hull_of(hull, task.hull_fill, task.params)
    errors = measure_fit([points], task.reference, task.params)
    if errors.normalized_error <= 1:
        return [placed_hull(points, faces)], "one hull"
    deviation, bound = errors.deviation, task.reference.bound
    # What has no resting pose rolls, and one shape rolls better than parts with edges.
    can_roll = task.rests_any_way and task.hull_fill >= ROLLING_FILL
    has_stalk = deviation.added_p95 <= bound.p95 and deviation.added_worst <= STALK_ERROR * bound.worst
    if not task.is_full or not (can_roll or has_stalk):
        return [], ""
    return [whole_shape(hull, task.hull_fill, task.is_packed, task.params, task.reference.samples)], "one shape"


def _by_parts(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """One shape for each connected part; empty if there is only one part, or if parts are not convex or are nested."""
    pieces = connected_parts(task.points, task.faces, task.params.hull_count)
    if len(pieces) < 2 or any(p.hull_fill < task.params.hull_volume_ratio for p in pieces) or any_nested(pieces):
        return [], ""
    return [one_shape(p.points, task.params) for p in pieces], "one shape for each piece"


def _by_rings(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """A vessel as floor, rings of sectors and handles; empty if there is no opening, or no such cut."""
    return _rings(task) if len(task.reference.opening_points) else ([], "")


def _by_rings_of_tube(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """The same of a vessel without a bottom, which holds no water: what holds some was tried before."""
    is_tube = bool(task.reference.kept_rooms) and task.reference.rooms.encloses(with_gaps=True)
    return _rings(task) if is_tube and not len(task.reference.opening_points) else ([], "")


def _rings(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    bound, surface = task.reference.bound, task.reference.surface
    min_error_m = min(CHORD_SHARE * task.proxy.mean_wall_m, AIM_SHARE * bound.p95)
    solid = solids.simplify_solid(task.proxy.solid, task.slack / 2)
    foot_height_m = FOOT_SHARE * surface.longest
    vessel = cut_vessel(solid, min_error_m, MAX_SHIFT_ERROR * bound.p95, foot_height_m, task.part_count)
    if vessel is None:
        return [], ""
    max_wall_parts = task.part_count - len(vessel.floors)
    pieces = split_to_bound([*vessel.wall_parts, *vessel.handles], surface, bound, max_wall_parts)
    floors = [task.reduced(solids.hull_points([p])) for p in vessel.floors]
    walls = [_shifted_wall_hull(piece, task) for piece in pieces]
    return _primitives_or_hulls([*floors, *walls], task), vessel.message


def _shifted_wall_hull(piece: solids.Solid, task: CollisionTask) -> Floats:
    """The hull around a part of a wall, shifted horizontally outwards where it fills much of the hollow side."""
    cloud = task.reduced(solids.hull_points([piece]))
    excess = protrusion(cloud, task.reference.surface)
    error = float(np.percentile(excess, 95)) if len(excess) else 0.0
    if error <= task.aim.p95:
        return cloud
    # What the hull adds lies on the hollow side, so the centre of mass of the part lies outwards from that of the hull.
    shift_direction = solid_moments(*solids.surface_of(piece))[1] - solid_moments(*solids.convex_hull(cloud))[1]
    length = float(np.hypot(shift_direction[0], shift_direction[1]))
    if length <= 0:
        return cloud
    # Limited, so that contacts stay close to the visible wall.
    shift = min(error / 2, max(task.params.collider_error_m, task.aim.p95))
    moved: Floats = cloud + np.array([shift_direction[0], shift_direction[1], 0.0]) / length * shift
    before, after = (normalized_error(c, task.reference.surface, task.aim) for c in (cloud, moved))
    return moved if after < before else cloud


def _by_cuts(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    solid = solids.simplify_solid(task.proxy.solid, task.slack / 16, CUT_FACES, 2 * task.slack)
    pieces = split_to_bound([solid], task.reference.surface, task.aim, task.part_count)
    excess_m3 = EXCESS_SHARE * float(solid.volume())
    pieces = split_to_volume(pieces, excess_m3, max(MAX_FINE_PARTS, len(pieces)), task.aim.p95, task.reduced)
    groups = merge_within_bound(
        pieces, task.reference.surface, task.aim, task.reference.opening_points, excess_m3, task.reduced
    )
    return _hulls(groups, task), "cut by planes where hulls would stick out"


def _by_closed_windows(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """The walls of a basket or a colander: a lattice cut as if its windows were closed; empty if it has no windows."""
    proxy = None if task.is_full else without_windows(task.points, task.faces)
    if proxy is None:
        return [], ""
    rooms, kept = task.reference.rooms, task.reference.kept_rooms
    points, faces = solids.surface_of(proxy.solid)
    closed = replace(task, proxy=proxy, reference=fit_reference(points, faces, proxy.solid, True, rooms, kept))
    shapes, message = _rings(closed)
    if not shapes:
        shapes, message = _by_cuts(closed)
    return shapes, f"windows closed; {message}"


def _by_coacd(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """CoACD of a closed manifold; empty if it has too many connected components, since each gets a hull."""
    solid = solids.simplified_solid(*solids.surface_of(task.proxy.solid), COACD_FACES)
    if solid is None or len(solid[1]) > MAX_COACD_FACES:
        return [], ""
    if len(np.unique(face_components(solid[1], len(solid[0])))) > task.params.hull_count:
        return [], ""
    # CoACD's surface error is about half the threshold times the longest side.
    threshold = min(max(2 * task.params.collider_error_m / task.reference.surface.longest, 0.03), 0.2)
    clouds = task.decomposer("coacd", *solid, replace(task.budget, threshold=threshold))
    return _primitives_or_hulls(clouds, task), "decomposed by CoACD"


def _by_vhacd(task: CollisionTask) -> tuple[list[PlacedShape], str]:
    """V-HACD of the triangles themselves, in case the solid proxy lacks some of them."""
    clouds = task.decomposer("vhacd", task.points, task.faces, task.budget)
    return _primitives_or_hulls(clouds, task), "decomposed by V-HACD"


# Each strategy, and the normalized error of the best result so far up to which it is not tried.
STRATEGIES: tuple[tuple[Callable[[CollisionTask], tuple[list[PlacedShape], str]], float], ...] = (
    (_by_one, 0.0),
    (_by_parts, np.inf),
    (_by_rings, 1.0),
    (_by_cuts, 1.0),
    (_by_rings_of_tube, 1.0),
    (_by_closed_windows, WINDOWS_FROM_ERROR),
    (_by_coacd, COACD_FROM_ERROR),
    (_by_vhacd, VHACD_FROM_ERROR),
)


def _hulls(groups: list[list[solids.Solid]], task: CollisionTask) -> list[PlacedShape]:
    """A hull of few vertices, or the primitive that it is, around each group of solids."""
    volumes_m3 = [sum(float(solid.volume()) for solid in group) for group in groups]
    clouds = [task.reduced(solids.hull_points(group)) for group in groups]
    grown = [solids.hull_with_volume(c, v, task.reference.box) for c, v in zip(clouds, volumes_m3, strict=True)]
    return _primitives_or_hulls(grown, task)


def clouds_of(shapes: tuple[PlacedShape, ...]) -> list[Floats]:
    """Vertices of each shape, metres."""
    return [tessellate(s.shape, s.pose)[0] for s in shapes]


def _primitives_or_hulls(clouds: list[Floats], task: CollisionTask) -> list[PlacedShape]:
    """Around each cloud with a volume the primitive if it fits as well as the hull, else the hull."""
    shapes = []
    for cloud in clouds:
        if thickness(cloud) <= SPLINTER_M:
            continue
        try:
            placed = one_shape(cloud, task.params.replace(primitive_volume_ratio=PART_PRIMITIVE_FILL))
        except DegenerateShape:
            continue
        if not isinstance(placed.shape, Hull):
            [grown] = clouds_of((placed,))
            error, of_hull = (normalized_error(c, task.reference.surface, task.aim) for c in (grown, cloud))
            if error > max(1.0, of_hull):
                placed = one_shape(cloud, task.params.replace(primitive_volume_ratio=NO_PRIMITIVE))
        shapes.append(placed)
    return shapes


def whole_shape(cloud: Floats, fill: float, is_packed: bool, params: CollideParams, samples: Floats) -> PlacedShape:
    """The one shape around everything; packed goods get a box whose sides lie between its bulges and its edges.

    `fill`: share of the hull that is matter, 0..1. `samples`: (N, 3) points spread over the surface, metres.
    """
    min_ratio = (
        min(params.primitive_volume_ratio, PACKED_PRIMITIVE_FILL) if is_packed else params.primitive_volume_ratio
    )
    placed = one_shape(cloud, params.replace(primitive_volume_ratio=min_ratio))
    if is_packed and isinstance(placed.shape, Box):
        placed = _with_sides_moved_in(placed, placed.shape, samples)
    # The corners of a box reach beyond rounded ones, and moved sides stay short of bulges: then a hull fits better.
    box = np.array([cloud.min(axis=0), cloud.max(axis=0)])
    bound = SOUND_SHARE * params.box_bound(float(np.ptp(box, axis=0).max()))
    corners = shape_bounds(placed.shape, placed.pose)
    if not isinstance(placed.shape, Hull) and box_gap(corners, box) <= bound:
        return placed
    return placed_hull(*_hull_of(cloud, fill, params))


def _hull_of(cloud: Floats, fill: float, params: CollideParams) -> tuple[Floats, Ints]:
    """The hull of few vertices around a cloud, with as much volume as there is matter in the whole hull."""
    points = solids.small_hull(cloud, params.hull_vertices)[0]
    box = np.array([cloud.min(axis=0), cloud.max(axis=0)])
    return solids.convex_hull(solids.hull_with_volume(points, fill * solids.hull_volume(cloud), box))


def _with_sides_moved_in(placed: PlacedShape, box: Box, samples: Floats) -> PlacedShape:
    """A box with its sides moved in by half the gap to the surface; the side that it rests on stays."""
    local = (samples - np.array(placed.pose.position)) @ placed.pose.rotation
    half_size = np.array(box.size) / 2
    # To the sides ahead, then to those behind.
    gap_to_side = np.concatenate([half_size - local, half_size + local], axis=1)
    nearest_side = np.argmin(gap_to_side.round(9), axis=1)
    inwards = np.zeros(6)
    for k in range(6):
        outward_z = float(placed.pose.rotation[2, k % 3]) * (1 if k < 3 else -1)
        if (nearest_side == k).any() and outward_z > -RESTING_SIDE_COSINE:
            inwards[k] = float(np.percentile(gap_to_side[nearest_side == k, k], 90)) / 2
    size = np.array(box.size) - inwards[:3] - inwards[3:]
    center = np.array(placed.pose.position) + placed.pose.rotation @ ((inwards[3:] - inwards[:3]) / 2)
    shape = Box(size=(float(size[0]), float(size[1]), float(size[2])))
    at = (float(center[0]), float(center[1]), float(center[2]))
    return PlacedShape(shape=shape, pose=placed.pose.replace(position=at))


def one_shape(cloud: Floats, params: CollideParams) -> PlacedShape:
    """The primitive around a cloud where it fits tightly, else its hull of few vertices."""
    hull, _ = solids.convex_hull(cloud)
    primitive = best_primitive(hull) if params.primitive_volume_ratio <= 1 else None
    if primitive is not None and primitive.ratio >= params.primitive_volume_ratio:
        return PlacedShape(shape=primitive.shape, pose=primitive.pose)
    return placed_hull(*solids.small_hull(hull, params.hull_vertices))
