"""Connected components of a mesh: their shapes, which are strewn or foreign, and which way they face."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.ingest.draft import warning
from casa_assets.mesh.solid.deviation import measure_visibility, surface_samples
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import (
    component_boxes,
    edge_counts,
    face_components,
    face_normals,
    is_closed,
    signed_volume,
    winding_number,
)
from casa_assets.mesh.voxels import Grid, voxelise
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import FALLBACK, Category
from casa_assets.model.source import RawPart

# All numbers below are choices.
# A component is of similar size to the largest one if its longest side is more than this share of that one's. A handle
# that runs into the wall of a mug is smaller, so it does not count as another object.
SIMILAR_SIZE = 0.8
# With more components than this nothing is tested.
MAX_COMPONENTS = 64
# Most pairs that are tested, of those whose bounding boxes overlap.
MAX_PAIRS = 6
# With more faces than this nothing is tested.
MAX_FACES = 40_000
# The centres of about this many faces of a component are tested.
SAMPLES = 200
# Fewest of them that have to lie inside the other component, and also outside of it. If one mug is pushed half into
# another, 3 % of its surface lies inside the other's walls, which are 4 mm thick.
MIN_INSIDE = 2
# Voxels along the longest side; holes smaller than a voxel count as closed. A choice.
CELLS = 96
# Points sampled on a component. All have to lie in filled voxels for it to be sealed up, and this share of them in
# voxels that the surface does not pass through; choices.
ENCLOSED_SAMPLES, MIN_INNER_SHARE = 256, 0.8
# A mesh of more components is left as it is.
MAX_ENCLOSED = 2000
# Alpha, of 255, from which on a surface is opaque; a choice.
OPAQUE_ALPHA = 250
# Colour types with alpha. Ref: PNG specification, 11.2.1; the colour type is the tenth byte of the header's data.
PNG_TYPES_WITH_ALPHA = (4, 6)
PNG_TYPE_OFFSET = 25
# Share of the area that must be out of sight for the walls of an open surface, or of something solid, to be double.
HIDDEN_AREA_SHARE = 0.25
# Points of the surface whose visibility is measured.
VISIBILITY_SAMPLES = 30_000
# Mean wall thickness over the longest side below which a surface is walled, and the share of its hull that a walled one
# fills at most.
# Ref: generated shells measure .011 to .023, a mug .040, a generated solid shaker .19 (filling .11 to .22, and .87).
THIN_WALL_RATIO, MAX_WALLED_FILL = 0.06, 0.5
# Volume added by filling sealed cavities, as a share of the filled solid, from which on a surface is double walled.
MIN_SEALED_GROWTH = 0.25
# Sizes are longest sides of bounding boxes.
# A mesh of more components is left as it is.
MAX_FOREIGN_COMPONENTS = 5000
# A speck is smaller than this share of the largest component. It floats if its distance to the rest is larger than
# SPECK_GAP of the largest component and SPECK_GAP_OF_OWN of its own size, so that crumbs and sprinkles stay.
SPECK_SIZE = 0.05
SPECK_GAP = 0.03
SPECK_GAP_OF_OWN = 3.0
# Specks nearer to each other than this share of their size are connected, as the links of a chain are; up to this many.
LINK_GAP_SHARE = 0.25
MAX_LINKED = 1500
SURFACE_SAMPLES = 40_000
# A ground plane is at least this many times wider than the rest, and at most this thick, as a share of its size.
GROUND_WIDTH, GROUND_THICKNESS = 1.5, 1e-3
# A sky dome is at least this many times larger than all that is in it, and fills this share of its hull.
SKY_WIDTH, SKY_HULL_FILL = 5.0, 0.9
# Tolerance of cosines between faces that are parallel or perpendicular.
COSINE_TOLERANCE = 0.02
# Several flat sheets are the walls of a room if they are this many times wider than the rest.
ROOM_WIDTH = 2.5
# A backdrop is an open sheet that is bent along one line. Its normals n lie in a plane across that line: largest mean
# |n . line|, smallest second moment of the normals in that plane (.5 for a right angle of equal sides), and smallest
# length of the mean normal. The rest of the mesh lies in front of this share of the sheet.
MAX_OFF_PLANE = 0.03
MIN_BEND_MOMENT = 0.1
MIN_MEAN_NORMAL = 0.5
MIN_SHARE_BEHIND = 0.9
# A stand is a slab: at most this thick, as a share of its width, filling this share of its hull, this many times wider
# than the rest and no farther from it than this share of its size.
STAND_THICKNESS = 0.15
STAND_HULL_FILL = 0.9
STAND_WIDTH = 1.2
STAND_GAP = 0.05
# Without its stand the mesh is nearer to the usual proportions by this much, and this near; logarithms of ratios.
MIN_IMPROVEMENT, MAX_PROPORTION_ERROR = 0.2, 0.7
# Components this large and this far apart, as shares of the largest one, are separate objects; this many are tested.
APART_SIZE = 0.3
APART_GAP = 0.1
MAX_APART = 64


@dataclass(frozen=True)
class Components:
    """Components of a welded surface, by first face: (F,) `label` of faces, (N, 3) corners and (N,) sides of boxes."""

    points: Floats
    faces: Ints
    label: Ints
    lower: Floats
    upper: Floats
    longest_side: Floats

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.longest_side)

    def faces_of(self, component: int) -> Ints:
        """(K, 3) faces of one component."""
        return np.asarray(self.faces[self.label == component])

    def surface_of(self, component: int) -> tuple[Floats, Ints]:
        """(P, 3) points and (F, 3) faces of one component alone."""
        used, local = np.unique(self.faces_of(component), return_inverse=True)
        return self.points[used], local.reshape(-1, 3)

    def extents_of(self, rows: Mask | Ints) -> Floats:
        """(3,) sides of the box around some components, by a mask or by their numbers; zero for no components."""
        lower, upper = self.lower[rows], self.upper[rows]
        return upper.max(axis=0) - lower.min(axis=0) if len(lower) else np.zeros(3)


def split_components(vertices: Floats, faces: Ints, place: Ints) -> Components:
    """Split some (F, 3) faces of a surface into components; `place`: (V,) welded point of each vertex."""
    ids = place[faces]
    points = np.zeros((int(place.max()) + 1, 3))
    points[ids.ravel()] = vertices[faces.ravel()]
    label = face_components(ids, len(points))
    lower, upper = component_boxes(points[ids], label)
    return Components(points, ids, label, lower, upper, (upper - lower).max(axis=1))


def box_gaps(lower: Floats, upper: Floats) -> Floats:
    """(N, N) distance between every two of N boxes, 0 where they meet."""
    gaps = np.maximum(0, np.maximum(lower[:, None] - upper[None], lower[None] - upper[:, None]))
    return np.asarray(np.linalg.norm(gaps, axis=2))


def intersecting_components(points: Floats, faces: Ints) -> list[Issue]:
    """One warning (MSH050) if components of similar size intersect, else an empty list; `points`: (V, 3), welded."""
    if not 0 < len(faces) <= MAX_FACES:
        return []
    components = split_components(points, faces, np.arange(len(points)))
    if not 1 < components.count <= MAX_COMPONENTS:
        return []
    lower, upper, longest_side = components.lower, components.upper, components.longest_side
    similar_sized = [int(k) for k in np.flatnonzero(longest_side > SIMILAR_SIZE * longest_side.max())]
    overlapping = [
        (a, b) for a, b in combinations(similar_sized, 2) if (lower[a] < upper[b]).all() and (lower[b] < upper[a]).all()
    ]
    for a, b in overlapping[:MAX_PAIRS]:
        first, second = components.faces_of(a), components.faces_of(b)
        if _is_partly_inside(points, first, second) or _is_partly_inside(points, second, first):
            message = "pieces of like size run through each other; give each a file of its own, or unite them"
            return [warning("MSH050", "pieces", message)]
    return []


def _is_partly_inside(points: Floats, faces: Ints, container: Ints) -> bool:
    """True if some of the faces lie inside a closed component, the container, and others outside of it."""
    if not is_closed(container):
        return False
    samples = points[faces[:: max(1, len(faces) // SAMPLES)]].mean(axis=1)
    inside = sum(abs(winding_number(points, container, spot)) > 0.5 for spot in samples)
    return MIN_INSIDE <= inside <= len(samples) - MIN_INSIDE


def enclosed_parts(components: Components, see_through: Mask) -> tuple[Mask, list[Issue]]:
    """(N,) True for components sealed up in others, of faces that cannot be seen through (F,), and notes on them.

    The inner wall of a sealed cavity stays, with a note, since it shows how thick the outer wall is.
    """
    is_sealed = np.zeros(components.count, dtype=bool)
    glass = np.zeros(components.count, dtype=bool)
    glass[components.label[see_through]] = True
    if components.count == 1 or components.count > MAX_ENCLOSED:
        return is_sealed, []
    within = np.zeros(components.count, dtype=bool)  # whose box lies within that of a larger one
    lower, upper = components.lower, components.upper
    for outer in np.argsort(-components.longest_side, kind="stable")[:64]:
        within |= (lower[outer] < lower).all(axis=1) & (upper < upper[outer]).all(axis=1)
    within &= ~glass
    cavities, candidates = list[int](), list[int]()
    for k in map(int, np.flatnonzero(within)):
        points, faces = components.surface_of(k)
        # A closed wall that faces inwards.
        is_cavity = is_closed(faces) and signed_volume(points, faces) < 0
        (cavities if is_cavity else candidates).append(k)
    message = f"{len(cavities)} closed walls inside look inwards: sealed rooms, which collision shapes fill"
    notes = [warning("MSH043", "rooms", message)] if cavities else []
    is_wall = ~glass
    is_wall[candidates] = False
    wall_faces = components.faces[is_wall[components.label]]
    if not candidates or not len(wall_faces):
        return is_sealed, notes
    used, local = np.unique(wall_faces, return_inverse=True)
    grid = voxelise(components.points[used], local.reshape(-1, 3), CELLS)
    for component in candidates:
        is_sealed[component] = _is_sealed(*components.surface_of(component), grid)
    if is_sealed.any():
        count = int(is_sealed.sum())
        message = f"{count} pieces that are sealed up in others were taken away: nobody sees or touches them"
        notes.append(warning("MSH042", "pieces", message))
    return is_sealed, notes


def is_transparent(part: RawPart) -> bool:
    """True for a part that can be seen through somewhere."""
    picture = part.material.base_color_texture
    painted = picture is not None and picture.png[PNG_TYPE_OFFSET] in PNG_TYPES_WITH_ALPHA
    colors = part.mesh.colors
    tinted = colors is not None and len(colors) > 0 and int(colors[:, 3].min()) < OPAQUE_ALPHA
    return painted or tinted or part.material.base_color[3] * 255 < OPAQUE_ALPHA


def _is_sealed(points: Floats, faces: Ints, grid: Grid) -> bool:
    """True if all of a component lies in filled voxels, and most of it in inner ones."""
    samples = np.concatenate([points, surface_samples(points, faces, ENCLOSED_SAMPLES)])
    cell = np.round((samples - grid.origin) / grid.cell).astype(int)
    if (cell < 0).any() or (cell >= grid.solid.shape).any():
        return False
    index = tuple(cell.T)
    return bool(grid.solid[index].all() and (grid.solid & ~grid.skin)[index].mean() >= MIN_INNER_SHARE)


class SurfaceKind(StrEnum):
    """Kind of surface that a solid represents."""

    SOLID = "solid"
    WALLED = "walled"
    DOUBLE = "double walled"
    SHEET = "open sheet"


@dataclass(frozen=True)
class Solidity:
    """Measured kind of a surface, as `collide` calls it.

    `hull_fill`: its volume over that of its hull. `wall_ratio`: twice its volume over its area and longest side.
    `visible_share`: of its area, from outside. `sealed_share`: volume of sealed cavities over the volume with them.
    `is_closed`: it bounds a volume, though it may touch itself; else its volume is that of a voxel grid.
    """

    kind: SurfaceKind
    hull_fill: float
    wall_ratio: float
    visible_share: float
    sealed_share: float
    is_closed: bool

    @property
    def message(self) -> str:
        """The numbers in words."""
        words = f"fills {self.hull_fill:.0%} of its hull, walls {self.wall_ratio:.3f} of its length"
        words = f"{words}, {self.visible_share:.0%} is seen"
        sealed = f", sealed rooms would add {self.sealed_share:.0%}" if self.sealed_share > 0.005 else ""
        return f"{words}{sealed}" + ("" if self.is_closed else "; it is open, the volume is that of a grid")

    @property
    def confidence(self) -> float:
        """Confidence, 0..1: less where the surface is open, or a number is near its limit."""
        near = abs(np.log(max(self.wall_ratio, 1e-6) / THIN_WALL_RATIO)) < 0.25 and self.kind is not SurfaceKind.DOUBLE
        return (0.9 if self.is_closed else 0.6) - (0.2 if near else 0.0)


def solidity(points: Floats, faces: Ints, is_full: bool = False) -> Solidity:
    """Measure a surface, welded, outward where it is closed; `is_full`: solid all through, inner walls are faults."""
    used, local = np.unique(faces, return_inverse=True)
    points, faces = points[used], local.reshape(-1, 3)
    hull = max(hull_volume(points), 1e-300)
    area, longest = float(face_normals(points, faces)[1].sum()), float(np.ptp(points, axis=0).max())
    visibility = measure_visibility(points, faces, VISIBILITY_SAMPLES)
    visible_share = float((visibility.front | visibility.back).mean())
    # Of the components that face outwards, and of those that face inwards: the walls of sealed cavities.
    corners = points[faces] - points.mean(axis=0)
    cones = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volumes = np.bincount(face_components(faces, len(points)), weights=cones)
    outer_volume, cavity_volume = float(volumes[volumes > 0].sum()), float(-volumes[volumes < 0].sum())
    is_closed = bool((edge_counts(faces)[2] == 0).all()) and outer_volume > cavity_volume
    volume = outer_volume - cavity_volume if is_closed else voxelise(points, faces).volume
    sealed_share = cavity_volume / outer_volume if is_closed else 0.0
    hull_fill, wall_ratio = min(1.0, volume / hull), 2 * volume / (area * longest)
    has_thin_walls = wall_ratio < THIN_WALL_RATIO
    has_hidden_walls = has_thin_walls and visible_share < 1 - HIDDEN_AREA_SHARE
    # The inner wall of a closed vessel is out of sight too, but is meant.
    if sealed_share > MIN_SEALED_GROWTH or (has_hidden_walls and (is_full or not is_closed)):
        kind = SurfaceKind.DOUBLE
    elif not is_closed:
        kind = SurfaceKind.SHEET if has_thin_walls else SurfaceKind.SOLID
    else:
        kind = SurfaceKind.WALLED if hull_fill < MAX_WALLED_FILL and has_thin_walls else SurfaceKind.SOLID
    return Solidity(kind, hull_fill, wall_ratio, visible_share, sealed_share, is_closed)


def foreign_parts(components: Components, category: Category | None) -> tuple[Mask, list[Issue]]:
    """(N,) True for components that do not belong to the object, and notes on them.

    The usual proportions of the category distinguish a pedestal from a foot; without one, pedestals stay.
    """
    is_foreign = np.zeros(components.count, dtype=bool)
    if components.count == 1 or components.count > MAX_FOREIGN_COMPONENTS:
        return is_foreign, []
    notes: list[Issue] = []
    for kind, message, rows in (
        ("ground", "a wide flat sheet under or behind the object was taken away", _ground_planes(components)),
        ("backdrop", "a bent sheet behind the object was taken away", _backdrop(components)),
    ):
        if (rows & ~is_foreign).any():
            is_foreign |= rows
            notes.append(warning("MSH012", kind, message))
    sky = _sky(components, is_foreign)
    if sky is not None:
        is_foreign[sky] = True
        notes.append(warning("MSH012", "sky", "a shell far around the object was taken away"))
    stand = None if category is None or category.id == FALLBACK else _stand(components, is_foreign, category)
    if stand is not None:
        is_foreign[stand] = True
        notes.append(warning("MSH012", "stand", "a slab that the object stands on was taken away"))
    specks = _specks(components, is_foreign)
    if specks.any():
        message = f"{int(specks.sum())} stray pieces that touch nothing were taken away"
        notes.append(warning("MSH013", "floaters", message))
    return is_foreign | specks, notes


def separate_objects(components: Components, is_foreign: Mask) -> list[Issue]:
    """A note if large components form groups that are apart from each other."""
    if is_foreign.all():
        return []
    largest = float(components.longest_side[~is_foreign].max())
    large = np.flatnonzero(~is_foreign & (components.longest_side > APART_SIZE * largest))
    if not 1 < len(large) <= MAX_APART:
        return []
    near = box_gaps(components.lower[large], components.upper[large]) <= APART_GAP * largest
    groups = int(connected_components(near, directed=False)[0])
    message = f"{groups} groups of pieces stand apart from each other; give each object a file of its own"
    return [warning("MSH024", "pieces", message)] if groups > 1 else []


def _ground_planes(components: Components) -> Mask:
    """(N,) flat sheets that are much wider than all that is not flat; several, which might be boards, even wider."""
    flat = (components.upper - components.lower).min(axis=1) <= GROUND_THICKNESS * components.longest_side
    width = float(components.extents_of(~flat).max())
    wide: Mask = flat & (components.longest_side > GROUND_WIDTH * width) & (width > 0)
    return wide if wide.sum() == 1 else wide & (components.longest_side > ROOM_WIDTH * width)


def _backdrop(components: Components) -> Mask:
    """(N,) the largest component if it is an open sheet, bent along a line and much wider than the rest in front."""
    out = np.zeros(components.count, dtype=bool)
    component = int(np.argmax(components.longest_side))
    others = np.arange(components.count) != component
    faces = components.faces_of(component)
    longest, rest = components.longest_side[component], components.extents_of(others).max()
    if longest <= GROUND_WIDTH * rest or is_closed(faces):
        return out
    normals, areas = face_normals(components.points, faces)
    share = areas / areas.sum()
    spread, axes = np.linalg.eigh(np.einsum("n,ni,nj->ij", share, normals, normals))
    is_bent = spread[1] > MIN_BEND_MOMENT and float(share @ np.abs(normals @ axes[:, 0])) < MAX_OFF_PLANE
    is_corner = longest > ROOM_WIDTH * rest and _is_corner(normals, share)
    # The normals of a tube cancel each other out, so their mean is short.
    mean_normal_length = float(np.linalg.norm(share @ normals))
    center_of_others = (components.lower[others].min(axis=0) + components.upper[others].max(axis=0)) / 2
    height = np.einsum("ij,ij->i", center_of_others - components.points[faces].mean(axis=1), normals)
    share_ahead = float(share[height > 0].sum())
    out[component] = (
        (is_bent or is_corner)
        and mean_normal_length > MIN_MEAN_NORMAL
        and max(share_ahead, 1 - share_ahead) > MIN_SHARE_BEHIND
    )
    return out


def _is_corner(normals: Floats, share: Floats) -> bool:
    """True if nearly all of the area, (F,) shares with (F, 3) normals, is a floor and two perpendicular walls."""
    first = normals[int(np.argmax(share))]
    is_perpendicular = np.abs(normals @ first) < COSINE_TOLERANCE
    if not is_perpendicular.any():
        return False
    second = normals[int(np.argmax(np.where(is_perpendicular, share, -1)))]
    axes = np.stack([first, second, np.cross(first, second)], axis=1)
    is_along_axis = np.abs(normals @ axes) > 1 - COSINE_TOLERANCE
    is_on_planes = float(share @ is_along_axis.any(axis=1)) > MIN_SHARE_BEHIND
    return is_on_planes and bool((share @ is_along_axis > MIN_BEND_MOMENT).all())


def _sky(components: Components, is_foreign: Mask) -> int | None:
    """The component that is a convex shell far around all others and faces inwards; None if there is no such shell."""
    for component in np.argsort(-components.longest_side, kind="stable")[:3]:
        others = ~is_foreign & (np.arange(components.count) != component)
        if is_foreign[component] or not others.any():
            continue
        encloses_others = (components.lower[component] < components.lower[others]).all() and (
            components.upper[others] < components.upper[component]
        ).all()
        if encloses_others and components.extents_of(others).max() * SKY_WIDTH < components.longest_side[component]:
            points, faces = components.surface_of(int(component))
            # Negative: a dome faces inwards, while a fruit around its seeds faces outwards. A vessel fills less.
            if -signed_volume(points, faces) > SKY_HULL_FILL * hull_volume(points) > 0:
                return int(component)
    return None


def _stand(components: Components, is_foreign: Mask, category: Category) -> int | None:
    """The slab below all others without which the object has the proportions of its category, if there is one."""
    usual = np.sort(np.array(category.shape))
    for component in np.flatnonzero(~is_foreign):
        others = ~is_foreign & (np.arange(components.count) != component)
        if not others.any() or not _is_under(components, int(component), others):
            continue
        # Sorted proportions, so that the pose does not matter: the largest logarithm of the ratio to the usual ones.
        errors = []
        for sides in (components.extents_of(~is_foreign), components.extents_of(others)):
            proportions = np.sort(sides) / max(float(sides.max()), 1e-300)
            errors.append(float(np.abs(np.log(np.maximum(proportions, 1e-9) / usual)).max()))
        if errors[1] > MAX_PROPORTION_ERROR or errors[1] > errors[0] - MIN_IMPROVEMENT:
            continue
        points, faces = components.surface_of(int(component))
        if abs(signed_volume(points, faces)) >= STAND_HULL_FILL * hull_volume(points) > 0:  # a slab
            return int(component)
    return None


def _is_under(components: Components, component: int, others: Mask) -> bool:
    """True if a component is flat, wider than all others, and these are all on one side of it."""
    lower, upper = components.lower[component], components.upper[component]
    normal_axis = int(np.argmin(upper - lower))
    plane_axes = [k for k in range(3) if k != normal_axis]
    sides, other_sides = upper - lower, components.extents_of(others)
    if (
        sides[normal_axis] > STAND_THICKNESS * sides[plane_axes].min()
        or (sides[plane_axes] < STAND_WIDTH * other_sides[plane_axes]).any()
    ):
        return False
    gap = STAND_GAP * float(other_sides.max())
    above = components.lower[others][:, normal_axis].min() - upper[normal_axis]
    below = lower[normal_axis] - components.upper[others][:, normal_axis].max()
    return bool(abs(above) <= gap or abs(below) <= gap)


def _specks(components: Components, is_foreign: Mask) -> Mask:
    """(N,) small components that touch nothing and are not linked to others that do."""
    is_speck = np.zeros(components.count, dtype=bool)
    if is_foreign.all():
        return is_speck
    largest = float(components.longest_side[~is_foreign].max())
    small = ~is_foreign & (components.longest_side < SPECK_SIZE * largest)
    large = ~is_foreign & ~small
    if not small.any():
        return is_speck
    faces = components.faces[large[components.label]]
    used, local = np.unique(faces, return_inverse=True)
    samples = surface_samples(components.points[used], local.reshape(-1, 3), SURFACE_SAMPLES)
    index, face_is_small = np.flatnonzero(small), small[components.label]
    distance = cKDTree(np.concatenate([components.points[used], samples])).query(
        components.points[components.faces[face_is_small]].reshape(-1, 3)
    )[0]
    gap = np.full(components.count, np.inf)
    np.minimum.at(gap, components.label[face_is_small], distance.reshape(-1, 3).min(axis=1))
    floating = gap[index] > np.maximum(SPECK_GAP * largest, SPECK_GAP_OF_OWN * components.longest_side[index])
    if len(index) <= MAX_LINKED and not floating.all() and floating.any():
        sizes = np.minimum(components.longest_side[index][:, None], components.longest_side[index][None])
        cluster = connected_components(
            box_gaps(components.lower[index], components.upper[index]) <= LINK_GAP_SHARE * sizes, directed=False
        )[1]
        is_held = np.zeros(int(cluster.max()) + 1, dtype=bool)
        is_held[cluster[~floating]] = True
        floating &= ~is_held[cluster]
    is_speck[index[floating]] = True
    return is_speck
