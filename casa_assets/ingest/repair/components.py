"""Components of a surface: those that intersect, those sealed up in others, and how solid the whole is."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.ingest.collision.solid_proxy import MAX_WALLED_FILL, MIN_SEALED_GROWTH, THIN_WALL_RATIO, SurfaceKind
from casa_assets.ingest.draft import warning
from casa_assets.mesh.grid.voxels import Grid, voxelise
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import face_normals, signed_volume, winding_number
from casa_assets.mesh.topology import component_boxes, edge_counts, face_components, is_closed
from casa_assets.mesh.visibility import measure_visibility
from casa_assets.model.issue import Issue
from casa_assets.model.source import RawPart

# Components -----------------------------------------------------------------------------------------------------------
# Split a surface into connected components, with the bounding box of each.


@dataclass(frozen=True)
class Components:
    """Components of a welded surface, connected over shared points and numbered by their first face.

    `label`: (F,) component of each face. `lower`, `upper`: (N, 3) corners of the boxes; `longest_side`: (N,) of each.
    """

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
        faces: Ints = self.faces[self.label == component]
        return faces

    def surface_of(self, component: int) -> tuple[Floats, Ints]:
        """(P, 3) points and (F, 3) faces of one component alone."""
        used, local = np.unique(self.faces_of(component), return_inverse=True)
        return self.points[used], local.reshape(-1, 3)

    def extents_of(self, rows: Mask | Ints) -> Floats:
        """(3,) sides of the box around some components, by a mask or by their numbers; zero if there are none."""
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


# Intersecting components ----------------------------------------------------------------------------------------------
# Find components of similar size that intersect: two objects in one file, or volume that would count twice.

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


def intersecting_components(points: Floats, faces: Ints) -> list[Issue]:
    """One warning (MSH050) if components of similar size intersect, else an empty list; `points`: (V, 3), welded."""
    if not 0 < len(faces) <= MAX_FACES:
        return []
    component = face_components(faces, len(points))
    count = int(component.max()) + 1
    if not 1 < count <= MAX_COMPONENTS:
        return []
    lower, upper = component_boxes(points[faces], component)
    longest_side = (upper - lower).max(axis=1)
    similar_sized = [int(k) for k in np.flatnonzero(longest_side > SIMILAR_SIZE * longest_side.max())]
    overlapping = [
        (a, b) for a, b in combinations(similar_sized, 2) if (lower[a] < upper[b]).all() and (lower[b] < upper[a]).all()
    ]
    for a, b in overlapping[:MAX_PAIRS]:
        first, second = faces[component == a], faces[component == b]
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


# Enclosed parts -------------------------------------------------------------------------------------------------------
# Find components sealed up in others, which nobody sees or touches: the inner structures of generated meshes.

# Voxels along the longest side; holes smaller than a voxel count as closed. A choice.
CELLS = 96
# Points sampled on a component. All have to lie in filled voxels for it to be sealed up, and this share of them in
# voxels that the surface does not pass through; choices.
ENCLOSED_SAMPLES = 256
MIN_INNER_SHARE = 0.8
# A mesh of more components is left as it is.
MAX_ENCLOSED = 2000
# Alpha, of 255, from which on a surface is opaque; a choice.
OPAQUE_ALPHA = 250
# Colour types with alpha. Ref: PNG specification, 11.2.1; the colour type is the tenth byte of the header's data.
PNG_TYPES_WITH_ALPHA = (4, 6)
PNG_TYPE_OFFSET = 25


def enclosed_parts(components: Components, see_through: Mask) -> tuple[Mask, list[Issue]]:
    """(N,) True for components sealed up in others, of faces that cannot be seen through (F,), and notes on them.

    The inner wall of a sealed cavity stays, with a note, since it shows how thick the outer wall is.
    """
    is_sealed = np.zeros(components.count, dtype=bool)
    glass = np.zeros(components.count, dtype=bool)
    glass[components.label[see_through]] = True
    if components.count == 1 or components.count > MAX_ENCLOSED:
        return is_sealed, []
    within = _within_another(components) & ~glass
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


def _within_another(components: Components) -> Mask:
    """(N,) components whose box lies within that of a larger one."""
    is_within = np.zeros(components.count, dtype=bool)
    lower, upper = components.lower, components.upper
    for outer in np.argsort(-components.longest_side, kind="stable")[:64]:
        is_within |= (lower[outer] < lower).all(axis=1) & (upper < upper[outer]).all(axis=1)
    return is_within


def _is_sealed(points: Floats, faces: Ints, grid: Grid) -> bool:
    """True if all of a component lies in filled voxels, and most of it in inner ones."""
    samples = np.concatenate([points, surface_samples(points, faces, ENCLOSED_SAMPLES)])
    cell = np.round((samples - grid.origin) / grid.cell).astype(int)
    if (cell < 0).any() or (cell >= grid.solid.shape).any():
        return False
    index = tuple(cell.T)
    return bool(grid.solid[index].all() and (grid.solid & ~grid.skin)[index].mean() >= MIN_INNER_SHARE)


# Solidity -------------------------------------------------------------------------------------------------------------
# Measure how solid a surface is (filled, walled, sheet), for the report; `collide` uses the same limits.

# Share of the area that must be out of sight for the walls of an open surface, or of something solid, to be double; a
# choice.
HIDDEN_AREA_SHARE = 0.25
# Points of the surface whose visibility is measured.
VISIBILITY_SAMPLES = 30_000


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
    """Measure a surface, welded, any unit, outward where it is closed.

    `is_full`: known to be solid all through, so that walls inside it are faults.
    """
    used, local = np.unique(faces, return_inverse=True)
    points, faces = points[used], local.reshape(-1, 3)
    hull = max(hull_volume(points), 1e-300)
    area, longest = float(face_normals(points, faces)[1].sum()), float(np.ptp(points, axis=0).max())
    visibility = measure_visibility(points, faces, VISIBILITY_SAMPLES)
    visible_share = float((visibility.front | visibility.back).mean())
    outer_volume, cavity_volume = _volumes(points, faces)
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


def _volumes(points: Floats, faces: Ints) -> tuple[float, float]:
    """Volume of the components that face outwards, and of those that face inwards, the walls of sealed cavities."""
    label = face_components(faces, len(points))
    corners = points[faces] - points.mean(axis=0)
    cones = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volumes = np.bincount(label, weights=cones)
    return float(volumes[volumes > 0].sum()), float(-volumes[volumes < 0].sum())
