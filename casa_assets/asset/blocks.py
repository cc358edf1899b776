"""Boxes with rounded edges, cylinders and spheres, slabs with openings, and boolean operations on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import manifold3d
import numpy as np

from casa_assets.asset.solid import Placed, Solid, axis_turn, box_shape
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.model.asset.parts import Box, Cylinder, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3

EDGE_RADIUS = 0.0015  # metres, of the edges of boards; a choice


def box(size: Vec3, at: Vec3 = (0.0, 0.0, 0.0), edge_radius: float = EDGE_RADIUS, steps: int = 1) -> Solid:
    """A box about `at`; its collider is a box.

    size: along x, y, z; all lengths are metres. edge_radius: of its edges, 0 for sharp ones. steps: facets across an
    edge; one is shaded as round, a radius over about 6 mm needs 3 or more. Raises ValueError: a size is not positive.
    """
    half = np.array(size) / 2
    if half.min() <= 0:
        raise ValueError(f"a box needs a positive size, got {size}")
    radius = min(edge_radius, 0.98 * float(half.min()))
    directions, faces = _rounded(steps if radius > 0 else 0)
    if radius > 0:
        solid = np.repeat(_SIGNS, len(directions) // 8, axis=0) * (half - radius) + directions * radius
    else:
        solid = directions * half
    return Solid(solid + np.array(at), faces, shapes=((Box(size=size), Pose(position=at)),))


def board(lower: Vec3, upper: Vec3, edge_radius: float = EDGE_RADIUS, steps: int = 1) -> Solid:
    """A box between two corners, metres; rounding as in `box`."""
    _, at = box_shape(lower, upper)
    return box((upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]), at.position, edge_radius, steps)


_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@lru_cache(maxsize=16)
def _rounded(steps: int) -> tuple[Floats, Ints]:
    """Directions of the corners' points, octant by octant, and the faces of the box that they belong to."""
    if steps == 0:
        return _SIGNS, convex_hull(_SIGNS)[1]
    weights = [(i, j, steps - i - j) for i in range(steps + 1) for j in range(steps + 1 - i)]
    octant = np.sin(np.array(weights, dtype=np.float64) / steps * math.pi / 2)
    octant /= np.linalg.norm(octant, axis=1)[:, None]
    directions = np.concatenate([octant * signs for signs in _SIGNS])
    template = np.repeat(_SIGNS, len(octant), axis=0) * 2.0 + directions
    hull, faces = convex_hull(template)
    assert len(hull) == len(template)
    return directions, faces


def lathe(profile: Sequence[Vec2], segments: int = 0, crease_deg: float = 40.0, closed: bool = False) -> Solid:
    """A surface of revolution about z, without collision shape.

    profile: (radius, z) from the lower end to the upper one, metres; an end off the axis is closed by a flat disc. A
    hollow body goes up outside and comes down inside. segments: points around; 0 chooses by radius. closed: the profile
    is a loop off the axis, counter-clockwise, and the body a ring.
    """
    outline = [(max(0.0, float(r)), float(z)) for r, z in profile]
    if outline[0][0] > 0 and not closed:
        outline.insert(0, (0.0, outline[0][1]))
    if outline[-1][0] > 0 and not closed:
        outline.append((0.0, outline[-1][1]))
    count = segments or circle_segments(max(r for r, _ in outline))
    angles = np.arange(count) * 2 * np.pi / count
    points: list[Floats] = []
    rings: list[Ints] = []
    total = 0
    for r, z in outline:
        ring = np.array([[0.0, 0.0, z]]) if r == 0 else _ring(r, z, angles)
        points.append(ring)
        rings.append(np.arange(total, total + len(ring)))
        total += len(ring)
    if closed:
        rings, outline = [*rings, rings[0]], [*outline, outline[0]]
    faces, uv_m = _stitch(rings, outline, count)
    return Solid(np.concatenate(points), faces, uv_m=uv_m, crease_deg=crease_deg)


def circle_segments(radius: float) -> int:
    """Number of segments of a circle whose chords stay within half a millimetre of it; radius in metres."""
    if radius <= 0.0006:
        return 8
    need = math.pi / math.acos(1 - 0.0004 / max(radius, 0.001)) if radius > 0.0004 else 8
    return int(min(64, max(12, 4 * math.ceil(need / 4))))


def _ring(r: float, z: float, angles: Floats) -> Floats:
    return np.stack([r * np.cos(angles), r * np.sin(angles), np.full(len(angles), z)], axis=1)


def _stitch(rings: Sequence[Ints], outline: Sequence[Vec2], count: int) -> tuple[Ints, Floats]:
    """Faces between neighbouring rings, and their texture coordinates: round the body and along the profile."""
    faces: list[tuple[int, int, int]] = []
    uv_m: list[tuple[Vec2, Vec2, Vec2]] = []
    run = 0.0
    for ring0, ring1, (r0, z0), (r1, z1) in zip(rings, rings[1:], outline, outline[1:], strict=False):
        length = math.hypot(r1 - r0, z1 - z0)
        if length == 0 or (len(ring0) == 1 and len(ring1) == 1):
            continue
        step = 2 * math.pi / count
        arc = step * (r0 + r1) / 2
        for i in range(count):
            j = (i + 1) % count
            a, b = (ring0[0], ring0[0]) if len(ring0) == 1 else (ring0[i], ring0[j])
            c, d = (ring1[0], ring1[0]) if len(ring1) == 1 else (ring1[i], ring1[j])
            # A band narrows towards one rim: both rims keep their own length about the band's middle.
            m, w0, w1 = (i + 0.5) * arc, step * r0 / 2, step * r1 / 2
            ua, ub, uc, ud = m - w0, m + w0, m - w1, m + w1
            if len(ring0) > 1:
                faces.append((int(a), int(b), int(c if len(ring1) == 1 else d)))
                uv_m.append(((ua, run), (ub, run), (m if len(ring1) == 1 else ud, run + length)))
            if len(ring1) > 1:
                faces.append((int(a), int(d), int(c)))
                uv_m.append(((m if len(ring0) == 1 else ua, run), (ud, run + length), (uc, run + length)))
        run += length
    return np.array(faces, dtype=np.int64), np.array(uv_m, dtype=np.float64)


def rod(radius: float, length: float, edge_radius: float = 0.001, axis: str = "z") -> Solid:
    """A cylinder about the origin along an axis, its rims rounded; its collider is a cylinder."""
    r = min(edge_radius, 0.9 * radius, 0.45 * length)
    h = length / 2
    solid = lathe([(radius - r, -h), (radius, -h + r), (radius, h - r), (radius - r, h)], crease_deg=50.0)
    return solid.with_shapes((Cylinder(radius=radius, height=length), Pose())).transformed(axis_rotation(axis))


def axis_rotation(axis: str) -> Pose:
    """Rotation that takes z to the axis of that name."""
    return {"x": axis_turn("y", math.pi / 2), "y": axis_turn("x", -math.pi / 2), "z": Pose()}[axis]


def ball(radius: float, steps: int = 12) -> Solid:
    """A sphere about the origin; its collider is a sphere."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, steps + 1)
    profile = [(float(radius * np.cos(t)), float(radius * np.sin(t))) for t in tilt]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius)
    return lathe(profile, segments=2 * steps).with_shapes((Sphere(radius=radius), Pose()), crease_deg=60.0)


# Slabs of upright rectangles: a wall with openings, a floor round a corner; a grid of cells of which some are solid.
#
# All faces share the grid's points, so that no edge ends within another one and no crack shows.

Rectangle = tuple[Vec2, Vec2]

# Lengths are rounded to a micrometre, so that sums that should be equal make one line of the grid.
LINE_DECIMALS = 6
FRONT_FACES, BACK_FACES, RIM_FACES = 0, 1, 2


@dataclass(frozen=True)
class Cells:
    """A grid in a plane. us: (M + 1,) and vs: (N + 1,) lines, metres, rising. solid: (M, N) which cells are there."""

    us: Floats
    vs: Floats
    solid: Mask

    @property
    def area(self) -> float:
        """Area of all solid cells, m^2."""
        return float((np.outer(np.diff(self.us), np.diff(self.vs)) * self.solid).sum())

    @property
    def perimeter(self) -> float:
        """Length of the borders between solid cells and what is not solid, metres."""
        padded = np.pad(self.solid, 1).astype(np.int64)
        across = np.abs(np.diff(padded, axis=0))[:, 1:-1]
        along = np.abs(np.diff(padded, axis=1))[1:-1]
        return float((across * np.diff(self.vs)).sum() + (along.T * np.diff(self.us)).sum())

    @property
    def touches_at_a_point(self) -> bool:
        """True where two solid cells meet only at a corner, which would make the slab non-manifold."""
        s = self.solid
        a, b, c, d = s[:-1, :-1], s[1:, :-1], s[:-1, 1:], s[1:, 1:]
        return bool(((a & d & ~b & ~c) | (b & c & ~a & ~d)).any())


def with_holes(lower: Vec2, upper: Vec2, holes: Sequence[Rectangle], us: Sequence[float], vs: Sequence[float]) -> Cells:
    """A rectangle without those in `holes`; `us` and `vs` are more lines that the grid shall have. Metres."""
    u = _lines([lower[0], upper[0], *us, *(p[0] for hole in holes for p in hole)], lower[0], upper[0])
    v = _lines([lower[1], upper[1], *vs, *(p[1] for hole in holes for p in hole)], lower[1], upper[1])
    mid_u, mid_v = (u[:-1] + u[1:]) / 2, (v[:-1] + v[1:]) / 2
    solid = np.ones((len(mid_u), len(mid_v)), dtype=bool)
    for a, b in holes:
        solid &= ~np.outer((mid_u > a[0]) & (mid_u < b[0]), (mid_v > a[1]) & (mid_v < b[1]))
    return Cells(u, v, solid)


def cells_inside(outline: Sequence[Vec2]) -> Cells:
    """The inside of a polygon whose sides run along u and v, either way round. Metres."""
    points = np.round(np.array(outline, dtype=np.float64), LINE_DECIMALS)
    u, v = (np.unique(points[:, k]).astype(np.float64) for k in (0, 1))
    mid_u, mid_v = (u[:-1] + u[1:]) / 2, (v[:-1] + v[1:]) / 2
    solid = np.zeros((len(mid_u), len(mid_v)), dtype=bool)
    for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
        if a[0] == b[0]:  # a ray towards -u crosses it
            lower, upper = sorted((a[1], b[1]))
            solid ^= np.outer(mid_u > a[0], (mid_v > lower) & (mid_v < upper))
    return Cells(u, v, solid)


def rectangles(cells: Cells) -> list[Rectangle]:
    """Few rectangles that fill the solid cells without overlap: lower and upper corners, metres.

    Borders of holes are run on until they meet another border, upright or level, whichever makes fewer pieces: at most
    three for each hole and one more. Ref: vertical decomposition, de Berg et al., Computational Geometry, chapter 6.
    """
    upright = _strips(cells)
    level = [((b, a), (d, c)) for (a, b), (c, d) in _strips(Cells(cells.vs, cells.us, cells.solid.T))]
    return upright if len(upright) <= len(level) else level


def _strips(cells: Cells) -> list[Rectangle]:
    """Pieces as high as they can be, joined sideways where neighbours have the same ends."""
    finished: list[Rectangle] = []
    growing: dict[tuple[int, int], int] = {}
    for i, column in enumerate(cells.solid):
        steps = np.diff(np.concatenate([[0], column.astype(np.int64), [0]]))
        runs = list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))
        finished += [_corners(cells, begin, i, run) for run, begin in growing.items() if run not in runs]
        growing = {run: growing.get(run, i) for run in runs}
    finished += [_corners(cells, begin, len(cells.solid), run) for run, begin in growing.items()]
    return sorted(finished)


def _corners(cells: Cells, begin: int, end: int, run: tuple[int, int]) -> Rectangle:
    u, v = cells.us, cells.vs
    return (float(u[begin]), float(v[run[0]])), (float(u[end]), float(v[run[1]]))


@dataclass(frozen=True)
class Shell:
    """The surface of a slab of cells.

    points: (P, 3) u, v, w, m. faces: (F, 3). side: (F,) FRONT_FACES (low w), BACK_FACES, RIM_FACES. cell: (F, 2).
    """

    points: Floats
    faces: Ints
    side: Ints
    cell: Ints

    def solid(self, mask: Mask | None = None) -> Solid:
        """All faces, or some: then the surface is open, to be drawn but not weighed."""
        used, index = np.unique((self.faces if mask is None else self.faces[mask]), return_inverse=True)
        return Solid(self.points[used], index.reshape(-1, 3).astype(np.int64), crease_deg=35.0)

    def upright(self) -> Shell:
        """The surface as an upright wall: u along x, v along z, w along y."""
        return Shell(self.points[:, [0, 2, 1]], self.faces[:, ::-1], self.side, self.cell)


def cell_shell(cells: Cells, lower: float, upper: float) -> Shell:
    """The surface of the solid cells between w = low and w = high, metres."""
    m, n = len(cells.us), len(cells.vs)
    u, v = np.meshgrid(cells.us, cells.vs, indexing="ij")
    layer = np.stack([u.ravel(), v.ravel()], axis=1)
    points = np.concatenate([np.column_stack([layer, np.full(m * n, w)]) for w in (lower, upper)])
    padded = np.pad(cells.solid, 1)
    faces: list[tuple[int, int, int]] = []
    side: list[int] = []
    cell: list[tuple[int, int]] = []
    for i, j in np.argwhere(cells.solid).tolist():
        ring = (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1)
        a, b, c, d = ring
        top = m * n
        faces += [(a, c, b), (a, d, c), (a + top, b + top, c + top), (a + top, c + top, d + top)]
        side += [FRONT_FACES, FRONT_FACES, BACK_FACES, BACK_FACES]
        for k, filled in enumerate((padded[i + 1, j], padded[i + 2, j + 1], padded[i + 1, j + 2], padded[i, j + 1])):
            if not filled:
                p, q = ring[k], ring[(k + 1) % 4]
                faces += [(p, q, q + top), (p, q + top, p + top)]
                side += [RIM_FACES, RIM_FACES]
        cell += [(i, j)] * (len(faces) - len(cell))
    return Shell(points, np.array(faces, dtype=np.int64), np.array(side), np.array(cell))


def _lines(values: Sequence[float], lower: float, upper: float) -> Floats:
    lines = np.unique(np.round(np.array(values, dtype=np.float64), LINE_DECIMALS))
    low, high = round(lower, LINE_DECIMALS), round(upper, LINE_DECIMALS)
    return np.asarray(lines[(lines >= low) & (lines <= high)], dtype=np.float64)


def union(*solids: Solid) -> Solid:
    """Union of solids; it keeps the colliders of all."""
    body = manifold3d.Manifold.batch_boolean([_manifold(s) for s in solids], manifold3d.OpType.Add)
    return _solid(body, tuple(p for s in solids for p in s.shapes), solids[0].crease_deg)


def subtract(solid: Solid, *tools: Solid, shapes: Sequence[Placed] = ()) -> Solid:
    """Subtract closed tools from a closed solid; no shapes: the caller adds colliders elsewhere or wants the hull."""
    taken = manifold3d.Manifold.batch_boolean([_manifold(t) for t in tools], manifold3d.OpType.Add)
    return _solid(_manifold(solid) - taken, tuple(shapes), solid.crease_deg)


def intersect(solid: Solid, other: Solid) -> Solid:
    """Intersection of two solids, without collision shapes: unless some are added, its hull is taken."""
    return _solid(_manifold(solid) ^ _manifold(other), (), solid.crease_deg)


def _manifold(solid: Solid) -> manifold3d.Manifold:
    points, faces = np.ascontiguousarray(solid.points), np.ascontiguousarray(solid.faces, dtype=np.uint64)
    mesh = manifold3d.Mesh64(vert_properties=points, tri_verts=faces)
    mesh.merge()
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError:
        raise ValueError(f"a solid of {len(solid.faces)} faces is not closed: {body.status()}")
    return body


def _solid(body: manifold3d.Manifold, shapes: tuple[Placed, ...], crease_deg: float) -> Solid:
    if body.is_empty():
        raise ValueError("nothing is left of the solid")
    mesh = body.to_mesh64()
    points = np.array(mesh.vert_properties[:, :3], dtype=np.float64)
    return Solid(points, np.array(mesh.tri_verts, dtype=np.int64), shapes, crease_deg=crease_deg)
