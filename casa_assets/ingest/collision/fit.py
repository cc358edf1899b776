"""Measure how well collision shapes fit a mesh and a vessel's opening, and put boxes under hulls with a flat foot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from scipy import ndimage

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.ingest.collision.plane_splits import ErrorBound
from casa_assets.ingest.draft import PlacedShape
from casa_assets.mesh.planar import outline_of
from casa_assets.mesh.solid import solids
from casa_assets.mesh.solid.deviation import (
    Deviation,
    ReferenceSurface,
    deviation,
    distances_outside_hulls,
    inside_share,
    reference_surface,
    surface_samples,
)
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.voxels import NO_ROOMS, OpenRooms, closed_shares, fillable_volume, voxelise
from casa_assets.model.asset.parts import Box, Hull, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record

# All numbers below are choices. Points sampled on the mesh.
SAMPLES = 4000
# Largest distance of shapes from the surface for 95 % of it (at least P95_M), and for all of it; shares of its length.
P95_M = 0.002
P95_RATIO = 0.015
WORST_RATIO = 0.05
# Voxels along the longest side of the grid in which the opening of a vessel is found. A smaller share of the hull than
# MIN_OPENING_SHARE is no opening, and at most MAX_OPENING_POINTS voxels of it are tested.
OPENING_CELLS = 64
MIN_OPENING_SHARE = 0.03
MAX_OPENING_POINTS = 4000
# Voxels along the longest side of the grid that shows which parts of the surface can be touched: gaps narrower than a
# voxel count as closed. A voxel is about as wide as P95_RATIO.
REACH_CELLS = 66
# Largest share of an opening that shapes may fill, and of an open room that they may fill or close off. The check of
# the finished asset grants a room more.
MAX_FILLED_SHARE, MAX_CLOSED_SHARE = 0.15, 0.2
# Share of the bounds of the checks on bounding boxes and rooms that is used up at most: these look at files.
SOUND_SHARE = 0.9
# Height of the box, metres, and at most as a share of that of the thing. Hulls begin in its middle.
FOOT_M, FOOT_RATIO = 0.001, 0.03
# What is so little above the lowest point, as a share of the height of the foot, stands on the floor too.
LEVEL_SHARE = 0.5
# A foot is flat if its outline takes at least this share of the box around the thing, seen from above; and one, not
# several legs, if matter with its hollows fills this share of the outline.
MIN_OUTLINE_SHARE, MIN_FILLED_SHARE = 0.08, 0.8
# Boxes are tried at this many angles over a quarter turn.
ANGLES = 12


class CollideParams(Record):
    """Limits of the stage, by their names in registry/limits.yaml.

    `hull_count`: most shapes. `hull_vertices`: most vertices of a hull. `primitive_volume_ratio`: smallest share of a
    primitive that the hull has to fill. `hull_volume_ratio`: smallest share of the hull that the mesh has to fill for
    one shape. `collider_error_m`: distance from the shapes up to which the mesh counts as covered.
    `collider_bounds_m`, `collider_bounds_ratio`: how far the boxes around shapes and mesh may be apart: metres, and
    where that is more a share of the longest side (AST009). `room_closed`: largest share of an open room that shapes
    may fill or close off (AST018).
    """

    hull_count: int = 32
    hull_vertices: int = 64
    primitive_volume_ratio: float = 0.95
    hull_volume_ratio: float = 0.95
    collider_error_m: float = 0.004
    collider_bounds_m: float = 0.004
    collider_bounds_ratio: float = 0.02
    room_closed: float = 0.35

    def box_bound(self, longest: float) -> float:
        """How far the bounding box of the shapes may be from that of a mesh of this longest side, metres."""
        return max(self.collider_bounds_m, self.collider_bounds_ratio * longest)


@dataclass(frozen=True)
class FitReference:
    """Reference that the collision shapes of a mesh are measured against.

    `solid`: proxy of the mesh. `surface`: of that solid. `samples`: (N, 3) points on the mesh itself, metres. `box`:
    (2, 3) lower and upper corner of the mesh. `opening_points`: (M, 3) points in the opening of a vessel; empty if it
    has no opening. `bound`: largest error that shapes may have. `rooms`: open rooms of the mesh. `kept_rooms`: indices
    of those that shapes have to leave open.
    """

    solid: solids.Solid
    surface: ReferenceSurface
    samples: Floats
    box: Floats
    opening_points: Floats
    bound: ErrorBound
    rooms: OpenRooms = NO_ROOMS
    kept_rooms: Sequence[int] = ()


@dataclass(frozen=True)
class FitErrors:
    """Errors of collision shapes: deviations, share of the opening left open, and the largest error over its bound.

    `bare_share`: share of the mesh that lies farther outside of the shapes than the limit `error_m`, 0..1.
    `open_share`: share of the opening that is left open; None if the mesh has no opening. `closed_share`: largest share
    of an open room that is filled or closed off; 0 if the mesh has no open room. `is_sound`: the checks on bounding
    boxes and on open rooms will accept the shapes. `normalized_error`: largest error over its bound, 1 is enough.
    """

    deviation: Deviation
    bare_share: float
    open_share: float | None
    closed_share: float
    is_sound: bool
    normalized_error: float

    @property
    def rank(self) -> tuple[bool, float]:
        """Smaller is better: first what the checks accept, then the least error."""
        return not self.is_sound, self.normalized_error


def fit_reference(
    points: Floats,
    faces: Ints,
    solid: solids.Solid,
    is_open: bool,
    rooms: OpenRooms = NO_ROOMS,
    kept_rooms: Sequence[int] = (),
) -> FitReference:
    """Prepare what shapes of a mesh, welded, metres, z up, are measured against; `is_open`: its openings are meant."""
    surface = _touchable(reference_surface(*solids.surface_of(solid)), points, faces, not is_open)
    bound = ErrorBound(max(P95_M, P95_RATIO * surface.longest), WORST_RATIO * surface.longest)
    opening_points = np.zeros((0, 3))
    if is_open:  # the volume that would hold water
        grid = voxelise(points, faces, OPENING_CELLS)
        is_filled = fillable_volume(grid.solid)
        if float(is_filled.sum()) * grid.cell**3 >= MIN_OPENING_SHARE * solids.hull_volume(points):
            places: Floats = grid.origin + np.argwhere(is_filled) * grid.cell
            opening_points = places[:: max(1, len(places) // MAX_OPENING_POINTS)]
    used = points[np.unique(faces)]
    box = np.stack([used.min(axis=0), used.max(axis=0)])
    samples = surface_samples(points, faces, SAMPLES)
    return FitReference(solid, surface, samples, box, opening_points, bound, rooms, kept_rooms)


def _touchable(surface: ReferenceSurface, points: Floats, faces: Ints, is_full: bool) -> ReferenceSurface:
    """The surface without probes in slits and sealed cavities, which nothing can touch."""
    grid = voxelise(points, faces, REACH_CELLS, bridge=is_full)
    outside = ndimage.binary_dilation(~grid.solid, np.ones((3, 3, 3), dtype=bool))
    is_reached = outside[grid.cubes_at(surface.probes)]
    return replace(surface, probes=surface.probes[is_reached]) if is_reached.any() else surface


def measure_fit(clouds: Sequence[Floats], reference: FitReference, limits: CollideParams) -> FitErrors:
    """Measure how well convex shapes approximate a mesh. Raises DegenerateShape: no clouds, or one without a volume."""
    outside = distances_outside_hulls(reference.samples, clouds).round(6)
    off, bound = deviation(clouds, reference.surface, outside), reference.bound
    ratios = [error / most for error, most in zip(astuple(off), (bound.p95, bound.worst) * 3, strict=True)]
    open_share = None if not len(reference.opening_points) else 1 - inside_share(reference.opening_points, clouds)
    box_share = box_gap(np.concatenate(list(clouds)), reference.box) / limits.box_bound(reference.surface.longest)
    closed_share = 0.0
    if reference.kept_rooms:
        hulls = [solids.convex_hull(cloud) for cloud in clouds]
        starts = np.cumsum([0, *(len(points) for points, _ in hulls)])
        faces = np.concatenate([faces + start for (_, faces), start in zip(hulls, starts, strict=False)])
        shares = closed_shares(reference.rooms, np.concatenate([points for points, _ in hulls]), faces)
        closed_share = max(shares[k] for k in reference.kept_rooms)
    ratios += [box_share, closed_share / MAX_CLOSED_SHARE]
    if open_share is not None:
        ratios.append((1 - open_share) / MAX_FILLED_SHARE)
    return FitErrors(
        off,
        float((outside > limits.collider_error_m).mean()),
        open_share,
        closed_share,
        max(box_share, closed_share / limits.room_closed) <= SOUND_SHARE,
        round(max(ratios), 6),
    )


def box_gap(points: Floats, box: Floats) -> float:
    """Largest distance between a side of the bounding box of (N, 3) points and that of a (2, 3) box, metres."""
    return float(np.abs(np.stack([points.min(axis=0), points.max(axis=0)]) - box).max().round(6))


def describe_fit(clouds: Sequence[Floats], reference: FitReference, errors: FitErrors) -> str:
    """The errors of the chosen shapes in words, for the report."""
    united = solids.union([solids.convex_hull(cloud) for cloud in clouds])
    volume, overlap = 0.0, 0.0
    if united is not None:
        volume, overlap = signed_volume(*united), solids.intersection_volume(united, solids.surface_of(reference.solid))
    solid_volume = float(reference.solid.volume())
    mm = [1000 * v for v in astuple(errors.deviation)]
    iou = overlap / (volume + solid_volume - overlap)
    words = [
        f"volume {volume / solid_volume:.2f} of the solid, overlap {iou:.2f}",
        f"95 % (all) of the shapes within {mm[0]:.2g} ({mm[1]:.2g}) mm of it",
        f"of the mesh within {mm[2]:.2g} ({mm[3]:.2g}) mm of them, no deeper in them than {mm[4]:.2g} ({mm[5]:.2g}) mm",
    ]
    if errors.open_share is not None:
        words.append(f"{errors.open_share:.0%} of the opening is open")
    if reference.kept_rooms:
        words.append(f"at most {errors.closed_share:.0%} of an open room is closed")
    return ", ".join(words)


def on_flat_foot(shapes: Sequence[PlacedShape], solid: solids.Solid | None) -> tuple[PlacedShape, ...]:
    """Shapes with a box added under hulls that rest on a flat foot, or the same shapes if no such box fits.

    MuJoCo 3.3 occasionally finds only a single corner of a hull in contact with a plane, so that the object rocks and
    creeps. A box rests on its four corners in every version. Shapes: metres, z up, resting on their lowest point.
    `solid`: that they approximate; None if it fills its hull.
    """
    bounds = np.array([shape_bounds(s.shape, s.pose) for s in shapes])
    lowest, size = float(bounds[:, 0, 2].min()), np.ptp(bounds.reshape(-1, 3), axis=0)
    height = min(FOOT_M, FOOT_RATIO * float(size[2]))
    standing = [k for k, b in enumerate(bounds) if b[0, 2] <= lowest + LEVEL_SHARE * height]
    hulls = {k: s for k in standing if isinstance(s := shapes[k].shape, Hull)}
    if len(hulls) < len(standing):
        return tuple(shapes)  # primitives stand by themselves
    points = np.concatenate([shapes[k].pose.apply(hull.mesh.vertices) for k, hull in hulls.items()])
    foot = points[points[:, 2] <= lowest + LEVEL_SHARE * height, :2]
    filled_m2 = np.inf
    if solid is not None:  # its section just above the foot, with hollows filled
        filled_m2 = sum(a for a in map(_area, solids.section_contours(solid, lowest + height)) if a > 0)
    box = _box_within(foot, float(size[0] * size[1]), filled_m2, lowest, height)
    if box is None:
        return tuple(shapes)
    raised = [_raised(s, lowest + height / 2) if k in hulls else s for k, s in enumerate(shapes)]
    whole = [s for s in raised if s is not None]
    return (*whole, box) if len(whole) == len(shapes) else tuple(shapes)


def _area(polygon: Floats) -> float:
    """Area of an (N, 2) polygon, above 0 where it runs against the clock."""
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _box_within(foot: Floats, around_m2: float, filled_m2: float, lowest: float, height: float) -> PlacedShape | None:
    """The largest of some rotated boxes about the middle of a foot, (N, 2) points on the floor, within its outline.

    Return None if the outline is too small, if too little of it is filled, or if the box covers too little of it.
    `around_m2`: of the bounding box, from above. `filled_m2`: of the matter just above the foot. Metres.
    """
    outline = outline_of(foot)
    area = _area(outline) if len(outline) > 2 else 0.0
    if area <= 0 or area < MIN_OUTLINE_SHARE * around_m2 or filled_m2 < MIN_FILLED_SHARE * area:
        return None
    edges = np.roll(outline, -1, axis=0) - outline
    outward = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    best: tuple[float, Floats, Floats, float] | None = None
    for angle in np.arange(ANGLES) * np.pi / 2 / ANGLES:
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        local = outline @ turn
        middle, half = turn @ ((local.min(axis=0) + local.max(axis=0)) / 2), np.ptp(local, axis=0) / 2
        corners = (np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)]) * half) @ turn.T
        reach = (corners @ outward.T).max(axis=0)
        room = ((outline - middle) * outward).sum(axis=1)
        share = float((room / np.maximum(reach, 1e-12)).min())
        size = float(np.prod(2 * half)) * max(share, 0.0) ** 2
        if best is None or round(size, 12) > round(best[0], 12):
            best = size, middle, half * share, float(angle)
    assert best is not None, "angles are tried"
    size, middle, half, angle = best
    if size < MIN_OUTLINE_SHARE * area:
        return None
    return PlacedShape(
        shape=Box(size=(float(2 * half[0]), float(2 * half[1]), height)),
        pose=Pose(
            position=(float(middle[0]), float(middle[1]), lowest + height / 2),
            quaternion=(float(np.cos(angle / 2)), 0.0, 0.0, float(np.sin(angle / 2))),
        ),
    )


def _raised(placed: PlacedShape, level: float) -> PlacedShape | None:
    """A hull with all points below a level raised to it, or None if no volume is left."""
    assert isinstance(placed.shape, Hull), "hulls alone are raised"
    points = placed.pose.apply(placed.shape.mesh.vertices)
    points[:, 2] = points[:, 2].clip(level)
    try:
        vertices, faces = solids.convex_hull(points)
    except DegenerateShape:
        return None
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=vertices, faces=faces)))
