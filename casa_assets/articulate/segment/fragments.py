"""Weld the triangles of a file into one mesh, split it into fragments (connected pieces of surface), and measure these.

Two faces belong to one fragment when they share an edge and a material: makers often give a door, its knobs and handles
separate materials even if the mesh is one piece. If more than two faces share an edge, solids touch each other: those
faces are paired so that each pair bounds one wedge of solid, which separates touching boxes again after welding.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from casa_assets.articulate.plan import Frame
from casa_assets.articulate.segment.orthographic import SIDES, TOP, DepthImage, render_depth
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.surface import (
    component_boxes,
    connected_groups,
    directed_edges,
    face_components,
    face_normals,
    merge_rows,
    weld,
)
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel

# Vertices closer than this share of the diagonal are one point. Ref: measured, parts of clean appliance meshes lie
# farther apart, float32 exports of one point nearer.
WELD_RELATIVE = 1e-5
# Edges with more faces are faults of the mesh and join no fragments.
MAX_FACES_AT_EDGE = 12
# A piece is doubled where this share of its area has a face on either side.
MIN_DOUBLED_SHARE = 0.9
# Faces whose directions around an edge differ by less, radians, lie on each other.
SAME_ANGLE = 1e-3
# The skin of a grid of cubes: share of its triangles that are half the side of a cube, and how much their areas differ.
MIN_CUBE_SHARE, CUBE_AREA_TOLERANCE = 0.95, 0.02
# Pixels along the longer side of the pictures in which fragments are measured.
PIXELS = 512
# The same of pictures from above; walls of a tub are this near to the border of the plan, and rise by this share.
PLAN_PIXELS = 96
WALL_BORDER_SHARE = 0.12
MIN_WALL_RISE = 0.15
# Points of the surface by which thin walls are found, stretches of a border that are looked at one by one, and the
# share of such a stretch of a wall that is surface: of rods it is less.
WALL_SAMPLES = 4000
WALL_BINS = 12
MIN_WALL_FILL = 0.4


@dataclass(frozen=True)
class WeldedMesh:
    """All triangles of a file as one indexed mesh, in one frame, with what is derived from it once.

    Attributes:
        points: (P, 3) welded, any unit.
        faces: (F, 3) over the points, as many and in the order in which they came in; a triangle that welding
            collapses stays, with no area.
        normals: (F, 3) unit, zero where a face has no area. areas: (F,).
        duplicate_of: (F,) the first face with the same three points and the same side, or on either side where the
            maker doubled whole sheets; itself where it is the first.
        material_index: (F,) number of the material of each face.
        piece_index: (F,) number of the connected piece of the file that each face is part of, before welding.
        node_index: (F,) number of the node of the file that carries each face; one number where it has no nodes.
    """

    points: Floats
    faces: Ints
    normals: Floats
    areas: Floats
    duplicate_of: Ints
    material_index: Ints
    piece_index: Ints
    node_index: Ints

    @cached_property
    def fragment_labels(self) -> Ints:
        """Return the (F,) fragment of each face, as `weld_by_edges` gives it."""
        return weld_by_edges(self)

    @cached_property
    def solid_neighbors(self) -> tuple[Ints, Ints]:
        """Return the faces (N,) and (N,) of pairs that share an edge and bound one solid; the first of doubled ones."""
        index = np.flatnonzero((self.duplicate_of == np.arange(len(self.faces))) & (self.areas > 0.0))
        if not len(index):
            return index, index
        left, right = _adjacent_faces(self, index)
        return index[left], index[right]

    @cached_property
    def cell(self) -> float:
        """Return the edge of the cubes whose skin this mesh is, 0 for any other mesh; in the units of the points."""
        alive = self.areas > 0.0
        if not alive.any():
            return 0.0
        half = float(np.median(self.areas[alive]))
        is_half = np.abs(self.areas[alive] - half) <= CUBE_AREA_TOLERANCE * half
        corners = self.points[self.faces[alive]]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        is_half &= np.abs(longest - 2.0 * np.sqrt(half)) <= CUBE_AREA_TOLERANCE * longest
        return float(np.sqrt(2.0 * half)) if float(is_half.mean()) >= MIN_CUBE_SHARE else 0.0

    @property
    def diagonal(self) -> float:
        """Return the diagonal of the box around all triangles."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0

    @property
    def footprint_center(self) -> Floats:
        """Return the (3,) middle of the footprint at the lowest point, in its frame: the origin of the asset."""
        lower, upper = self.points.min(axis=0), self.points.max(axis=0)
        return np.array([(lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, lower[2]])

    def in_frame(self, frame: Frame) -> WeldedMesh:
        """Return a mesh that is in file axes and units in the frame, where its diagonal is 1."""
        return self.transformed(frame.rotation, np.array(frame.origin), frame.scale)

    def transformed(self, rotation: Floats, origin: Floats, scale: float) -> WeldedMesh:
        """Return the mesh in another frame: `scale * rotation @ (point - origin)`; the rotation is proper."""
        points = (self.points - origin) @ rotation.T * scale
        return replace(self, points=points, normals=self.normals @ rotation.T, areas=self.areas * scale**2)


def weld_triangles(
    vertices: Floats, faces: Ints, materials: Ints | None = None, nodes: Ints | None = None, joined: Ints | None = None
) -> WeldedMesh:
    """Weld triangles whose vertices nearly coincide.

    Args:
        vertices: (V, 3) finite. faces: (F, 3) within range. materials: (F,) index of each, None if all have the same.
        nodes: (F,) index of the node of each, None without nodes.
        joined: (V,) index of the vertex of the file that each vertex is a copy of; None if each is one of the file.
    """
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    points, place = weld(vertices, WELD_RELATIVE * diagonal / max(extent, 1e-300))
    ids = place[faces]
    normals, areas = face_normals(points, ids)
    collapsed = (ids[:, 0] == ids[:, 1]) | (ids[:, 1] == ids[:, 2]) | (ids[:, 2] == ids[:, 0])
    areas = np.where(collapsed, 0.0, areas)
    none = np.zeros(len(ids), dtype=np.int64)
    corners = faces if joined is None else joined[faces]
    pieces = face_components(corners, int(corners.max()) + 1 if len(corners) else 0)
    return WeldedMesh(
        points,
        ids,
        normals,
        areas,
        _without_back_sheets(ids, areas, pieces),
        none if materials is None else materials,
        pieces,
        none if nodes is None else nodes,
    )


def weld_model(model: RawModel, by_material: bool = True) -> WeldedMesh:
    """Weld all triangles of a model, part by part, in file axes and units."""
    vertices, faces, starts = joined_meshes([p.mesh for p in model.parts])
    ids = ["" if p.material is None else p.material.id for p in model.parts]
    places = [(*p.nodes, str(p.copy_number)) for p in model.parts]
    joined = [_copied_vertices(p.mesh) + s for p, s in zip(model.parts, starts, strict=True)]
    tint = _numbered(ids, faces) if by_material else None
    return weld_triangles(vertices, np.concatenate(faces), tint, _numbered(places, faces), np.concatenate(joined))


def joined_meshes(meshes: Sequence[Mesh]) -> tuple[Floats, list[Ints], Ints]:
    """Return the (P, 3) vertices of all meshes, the (F, 3) faces of each over them, and its first vertex."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes[:-1])])
    faces = [m.faces.astype(np.int64) + s for m, s in zip(meshes, starts, strict=True)]
    return np.concatenate([m.vertices for m in meshes]), faces, starts


def _numbered(words: Sequence[Hashable], faces: Sequence[Ints]) -> Ints:
    """Return the (F,) number of the word of each face, numbered by first use."""
    numbers: dict[Hashable, int] = {}
    rows = [np.full(len(f), numbers.setdefault(w, len(numbers))) for f, w in zip(faces, words, strict=True)]
    return np.concatenate(rows)


def _copied_vertices(mesh: Mesh) -> Ints:
    """Return the (V,) first vertex that each vertex is a copy of: same position, other normal or texture coordinates.

    Formats store a vertex of a sharp edge several times, once for each normal. Vertices that agree in everything are
    not copies: no writer stores those twice but for separate pieces.
    """
    count = len(mesh.vertices)
    extras = [a for a in (mesh.uv, mesh.normals) if a is not None]
    if not extras or not count:
        return np.arange(count)
    first, place = merge_rows(mesh.vertices)
    _, whole = merge_rows(np.column_stack([mesh.vertices, *extras]))
    # The rank of a vertex among those that agree in everything distinguishes the pieces at one place.
    order = np.argsort(whole, kind="stable")
    start = np.flatnonzero(np.r_[True, np.diff(whole[order]) != 0])
    rank = np.empty(count, dtype=np.int64)
    rank[order] = np.arange(count) - np.repeat(start, np.diff(np.r_[start, count]))
    single = np.bincount(place, rank > 0, len(first))[place] == 0
    return np.where(single, first[place], np.arange(count))


def weld_by_edges(mesh: WeldedMesh, by_material: bool = True) -> Ints:
    """Return the (F,) fragment of each face, numbered by first face; -1 for faces without area.

    Args:
        by_material: faces of different materials are different fragments.
    """
    index = np.flatnonzero((mesh.duplicate_of == np.arange(len(mesh.faces))) & (mesh.areas > 0.0))
    left, right = mesh.solid_neighbors
    if by_material:
        alike = mesh.material_index[left] == mesh.material_index[right]
        left, right = left[alike], right[alike]
    component = connected_groups(len(mesh.faces), left, right)
    labels = np.full(len(mesh.faces), -1, dtype=np.int64)
    _, labels[index] = merge_rows(component[index][:, None].astype(np.float64))
    return np.where(mesh.areas > 0.0, labels[mesh.duplicate_of], -1)


def _without_back_sheets(faces: Ints, areas: Floats, pieces: Ints) -> Ints:
    """Return the (F,) index of the face that represents each: one of those with the same points and the same side.

    Some programs write each face twice, once for either side. If whole pieces are doubled in this way, one face
    represents both sides. If only some faces of a piece lie on another piece, solids touch, and both remain.
    """
    same = _first_duplicates(faces)
    either = _first_duplicates(np.sort(faces, axis=1))
    doubled = np.bincount(either[same == np.arange(len(same))], minlength=len(faces))[either] > 1
    count = int(pieces.max(initial=-1)) + 1
    whole = np.bincount(pieces, areas, count)
    full = np.bincount(pieces[doubled], areas[doubled], count) >= MIN_DOUBLED_SHARE * whole
    sheet = doubled & full[pieces]
    # Both sides have to belong to doubled pieces.
    sides = np.bincount(either[doubled & ~sheet], minlength=len(faces))[either] > 0
    return np.where(sheet & ~sides, either, same)


def _first_duplicates(faces: Ints) -> Ints:
    """Return the (F,) index of the first face that has the same points in the same winding."""
    if not len(faces):
        return np.empty(0, dtype=np.int64)
    start = np.argmin(faces, axis=1)
    rows = np.arange(len(faces))
    turned = np.stack([faces[rows, (start + k) % 3] for k in range(3)], axis=1)
    first, place = merge_rows(turned)
    return first[place]


def _adjacent_faces(mesh: WeldedMesh, index: Ints) -> tuple[Ints, Ints]:
    """Return pairs of places in `index` of faces that share an edge and bound one solid."""
    faces = mesh.faces[index]
    directed = directed_edges(faces)
    owner = np.tile(np.arange(len(faces)), 3)
    forward = directed[:, 0] < directed[:, 1]
    ends = np.sort(directed, axis=1)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner, forward = ends[order], owner[order], forward[order]
    new = np.ones(len(ends), dtype=bool)
    new[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    start = np.flatnonzero(new)
    size = np.diff(np.append(start, len(ends)))
    pair = start[size == 2]
    left, right = [owner[pair]], [owner[pair + 1]]
    for at, count in zip(start[size > 2].tolist(), size[size > 2].tolist(), strict=True):
        if count <= MAX_FACES_AT_EDGE and count % 2 == 0:
            rows = slice(at, at + count)
            a, b = _wedges(mesh, index, ends[at], owner[rows], forward[rows])
            left.append(a)
            right.append(b)
    return np.concatenate(left), np.concatenate(right)


def _wedges(mesh: WeldedMesh, index: Ints, ends: Ints, owner: Ints, forward: Mask) -> tuple[Ints, Ints]:
    """Pair the faces around an edge so that each pair bounds one wedge of solid; no pairs if windings contradict."""
    none = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    a, b = mesh.points[ends[0]], mesh.points[ends[1]]
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-300)
    middle = mesh.points[mesh.faces[index[owner]]].sum(axis=1) - a - b
    away = middle - a
    away -= np.outer(away @ along, along)
    x = away[0] / max(float(np.linalg.norm(away[0])), 1e-300)
    y = np.cross(along, x)
    angle = np.arctan2(away @ y, away @ x)
    angle = np.round(np.mod(angle + SAME_ANGLE / 2, 2 * np.pi) / SAME_ANGLE)
    # Seen along the edge, an outward face that runs forward has matter at smaller angles: it ends a wedge, and a
    # backward one begins it. Of faces that lie on each other, ends come before beginnings.
    order = np.lexsort((~forward, angle))
    ahead = forward[order]
    if (ahead[1:] == ahead[:-1]).any():
        return none
    ring = owner[order]
    begin = np.flatnonzero(~ahead)
    return ring[begin], ring[(begin + 1) % len(ring)]


@dataclass(frozen=True)
class MeasuredFragments:
    """All fragments of a mesh with their measures, in the frame of the object (diagonal 1).

    Attributes:
        label: (F,) fragment of each face, -1 for none.
        lower, upper: (N, 3) corners of each. area: (N,) surface.
        visible_area: (N, 6) area of its picture from each of SIDES. depth_images: those pictures, of faces.
    """

    mesh: WeldedMesh
    label: Ints
    lower: Floats
    upper: Floats
    area: Floats
    visible_area: Floats
    depth_images: tuple[DepthImage, ...]

    @property
    def count(self) -> int:
        """Return the number of fragments."""
        return len(self.area)

    def faces_of(self, fragments: Sequence[int]) -> Ints:
        """Return the ascending indices of the faces of some fragments."""
        mask = np.zeros(self.count + 1, dtype=bool)
        mask[list(fragments)] = True
        return np.flatnonzero(mask[self.label] & (self.label >= 0))

    def box(self, fragments: Sequence[int]) -> tuple[Floats, Floats]:
        """Return the (3,) lower and upper corner of the box around some fragments."""
        rows = list(fragments)
        return self.lower[rows].min(axis=0), self.upper[rows].max(axis=0)

    def render_alone(self, fragments: Sequence[int], side: int, pixels: int) -> DepthImage:
        """Render some fragments without the others, from one of SIDES."""
        used, local = np.unique(self.mesh.faces[self.faces_of(fragments)], return_inverse=True)
        return render_depth(self.mesh.points[used], local.reshape(-1, 3), SIDES[side], pixels)

    def points_of(self, fragments: Sequence[int]) -> Floats:
        """Return the (P, 3) points that some fragments use."""
        return self.mesh.points[np.unique(self.mesh.faces[self.faces_of(fragments)])]


def corners_of_labels(mesh: WeldedMesh, label: Ints) -> tuple[Floats, Floats]:
    """Return the (N, 3) lower and upper corners of the faces of each label.

    Args:
        label: (F,) label of each face, -1 for none. A label that no face has gets corners of inf and -inf.
    """
    alive = label >= 0
    return component_boxes(mesh.points[mesh.faces[alive]], label[alive])


def render_sides(mesh: WeldedMesh, pixels: int = PIXELS) -> tuple[DepthImage, ...]:
    """Render a mesh that is in the frame from each of SIDES."""
    return tuple(render_depth(mesh.points, mesh.faces, axes, pixels) for axes in SIDES)


def measure_fragments(
    mesh: WeldedMesh, label: Ints, pixels: int = PIXELS, images: tuple[DepthImage, ...] | None = None
) -> MeasuredFragments:
    """Measure the fragments of a mesh that is in the frame, from rendered depth images of six sides.

    Args:
        label: (F,) fragment of each face. images: those of `render_sides`, None to render them.
    """
    lower, upper = corners_of_labels(mesh, label)
    count = len(lower)
    alive = np.flatnonzero(label >= 0)
    area = np.bincount(label[alive], mesh.areas[alive], count).astype(np.float64)
    images = render_sides(mesh, pixels) if images is None else images
    seen = np.zeros((count, len(SIDES)))
    for i, image in enumerate(images):
        visible = label[image.face[image.face >= 0]]
        seen[:, i] = np.bincount(visible[visible >= 0], minlength=count) * image.pixel**2
    return MeasuredFragments(mesh, label, lower, upper, area, seen, images)


def corners_from_side(measured: MeasuredFragments, side: int) -> tuple[Floats, Floats]:
    """Return the (N, 3) lower and upper corners of fragments in the axes of a side: right, up, depth."""
    axes = SIDES[side]
    a, b = measured.lower @ axes.T, measured.upper @ axes.T
    return np.minimum(a, b), np.maximum(a, b)


@dataclass(frozen=True)
class PlanView:
    """Shares of the plan of some fragments, seen from above.

    Attributes:
        covered: where anything is. floor: where the first thing is in the lower half of their height, of all.
        lid: where it is in the upper quarter.
        walls: (3,) of the left, the right and the far border, where something rises above the floor.
    """

    covered: float
    floor: float
    lid: float
    walls: tuple[float, float, float]

    @property
    def is_box(self) -> bool:
        """Return whether it is open at the top, with a floor: a drawer."""
        return self.floor >= 0.45 and self.lid <= 0.5

    @property
    def is_tub(self) -> bool:
        """Return whether it is a box with walls on three sides: only a drawer or a bin looks like this."""
        return self.is_box and self.floor >= 0.5 and min(self.walls) >= 0.6


def view_from_above(measured: MeasuredFragments, fragments: Sequence[int]) -> PlanView:
    """Look down on some fragments alone."""
    rows = measured.faces_of(fragments)
    lower, upper = measured.box(fragments)
    image = measured.render_alone(fragments, TOP, PLAN_PIXELS)
    height = max(float(upper[2] - lower[2]), 1e-9)
    share = image.depth / height
    seen = np.isfinite(share)
    total = float(share.size)
    deep, shallow = seen & (share > 0.5), seen & (share < 0.25)
    samples = surface_samples(measured.mesh.points, measured.mesh.faces[rows], WALL_SAMPLES)
    thin = _thin_walls(samples, lower, upper, float(measured.mesh.areas[rows].sum()))
    left, right, far = (max(pair) for pair in zip(_walls(share), thin, strict=True))
    return PlanView(
        float(seen.sum()) / total, float(deep.sum()) / total, float(shallow.sum()) / total, (left, right, far)
    )


def _walls(share: Floats) -> tuple[float, float, float]:
    """Return the shares of the left, right and far border of a plan that have a wall rising above the floor."""
    rows, columns = (max(1, round(WALL_BORDER_SHARE * n)) for n in share.shape)
    seen = np.isfinite(share)
    floor = float(np.median(share[seen])) if seen.any() else 0.0
    raised = share < floor - MIN_WALL_RISE
    return (
        float(raised[:, :columns].any(axis=1).mean()),
        float(raised[:, -columns:].any(axis=1).mean()),
        float(raised[:rows].any(axis=0).mean()),
    )


def _thin_walls(samples: Floats, lower: Floats, upper: Floats, area: float) -> tuple[float, float, float]:
    """Return the same as `_walls`, from the surface along each border: sheets are not visible from above.

    Args:
        samples: (N, 3) points spread over the surface. lower, upper: (3,) corners of all. area: of the surface.
    """
    size = np.maximum(upper - lower, 1e-9)
    place = (samples - lower) / size
    raised = place[:, 2] > MIN_WALL_RISE
    each = area / max(len(samples), 1)
    found = []
    for axis, near in ((0, place[:, 0]), (0, 1.0 - place[:, 0]), (1, 1.0 - place[:, 1])):
        along = place[raised & (near < WALL_BORDER_SHARE), 1 - axis]
        held = np.histogram(along, WALL_BINS, (0.0, 1.0))[0] * each
        whole = float(size[1 - axis] * size[2]) * (1.0 - MIN_WALL_RISE) / WALL_BINS
        found.append(float((held >= MIN_WALL_FILL * whole).mean()))
    return found[0], found[1], found[2]
