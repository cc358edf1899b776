"""Voxel grids: what a surface encloses, what would hold water, and the open rooms of a thing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import face_normals

# Points per side of a triangle at most, and points that are held in memory at once.
MOST_STEPS, SAMPLES_AT_ONCE = 4096, 1_000_000
# All numbers below are choices. Voxels along the longest side.
CELLS = 64
# Radius of the ball, in voxels: its diameter is 8 % of the longest side.
BALL_CELLS = 2.5
# Radius of the ball that looks for the same rooms between collision shapes; smaller, since these are a little thicker.
SMALL_BALL_CELLS = 1.5
# Room that lies so close to the surface, in voxels, is not counted: collision shapes may be off by as much.
MARGIN_CELLS = 1.5
# Rooms smaller than this share of the hull are not looked at. They matter where those that are enclosed take a larger
# share together (the lid of a can that lies deep is a dent), and one that is not enclosed, as the bend of a banana or
# what is around the stalk of an apple, from a still larger one on.
MIN_ROOM_SHARE = 0.03
MIN_ENCLOSED_SHARE = 0.08
MIN_BEND_SHARE = 0.15
# Samples on the surface that show whether faces or their backs look into a room, and how far off it they look, in
# voxels: just beyond those through which the surface passes.
WALL_SAMPLES, LOOK_CELLS = 20_000, 2.0
# Share of the walls of a room that have to show it their faces. Of walls thinner than the look, and of sheets that have
# faces on both sides, it is about one half; of a gap in a surface nothing.
FACING_SHARE = 0.25
_NOWHERE = np.zeros((1, 1, 1), dtype=bool)


@dataclass(frozen=True)
class Grid:
    """Cubes of side `cell` (m); cube (i, j, k) is centred on origin + (i, j, k) * cell.

    `solid`: (X, Y, Z) what the surface encloses, itself included. `skin`: (X, Y, Z) what it passes through.
    """

    origin: Floats
    cell: float
    solid: Mask
    skin: Mask

    @property
    def volume(self) -> float:
        """Enclosed volume, m^3: skin cubes count half, for the surface passes through their middle on average."""
        inner = int((self.solid & ~self.skin).sum())
        return (inner + 0.5 * int((self.solid & self.skin).sum())) * self.cell**3

    def cubes_at(self, places: Floats) -> tuple[Ints, ...]:
        """Index of the cube that each of (N, 3) places lies in, or of the nearest one."""
        at = np.round((places - self.origin) / self.cell).astype(int)
        return tuple(np.clip(at, 0, np.array(self.solid.shape) - 1).T)


def voxelise(points: Floats, faces: Ints, cells: int = 64, bridge: bool = False) -> Grid:
    """Voxel grid of everything that the surface, wound any way, open or not, encloses, flooding from outside.

    `cells`: along the longest side. `bridge`: also fill what lies between two walls along at least two of the axes, so
    that a missing bottom or lid does not empty a thing that is known to be full.
    """
    low = points.min(axis=0)
    extent = np.ptp(points, axis=0)
    cell = float(extent.max()) / cells
    origin = low - 2 * cell
    shape = np.ceil(extent / cell).astype(int) + 5
    skin = _skin(points, faces, origin, cell, tuple(shape))
    solid = ndimage.binary_fill_holes(skin)
    if bridge:
        votes = np.zeros(skin.shape, dtype=np.int8)
        for axis in range(3):
            ahead = np.maximum.accumulate(skin, axis=axis)
            behind = np.flip(np.maximum.accumulate(np.flip(skin, axis), axis=axis), axis)
            votes += (ahead & behind).astype(np.int8)
        solid = ndimage.binary_fill_holes(solid | (votes >= 2))
    return Grid(origin, cell, solid, skin)


def skin_cells(points: Floats, faces: Ints, grid: Grid) -> Mask:
    """(X, Y, Z) cubes of a grid that another surface passes through; what is outside is drawn onto its border."""
    return _skin(points, faces, grid.origin, grid.cell, grid.solid.shape)


def _skin(points: Floats, faces: Ints, origin: Floats, cell: float, shape: tuple[int, ...]) -> Mask:
    skin = np.zeros(shape, dtype=bool)
    for samples in _samples(points, faces, cell * 0.5):
        at = np.clip(np.round((samples - origin) / cell).astype(int), 0, np.array(shape) - 1)
        skin[at[:, 0], at[:, 1], at[:, 2]] = True
    return skin


def _samples(points: Floats, faces: Ints, spacing: float) -> Iterator[Floats]:
    """Points on the surface no farther apart than `spacing`, some at a time.

    Each triangle is cut into rows from its sharpest corner to the side across, which is its shortest: a needle
    costs as many points as it is long, not that number squared.
    """
    yield points
    corners = points[faces]
    across = np.linalg.norm(np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1), axis=2)  # side facing each
    sharpest = np.argmin(across, axis=1)
    turn = (sharpest[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn[:, :, None], axis=1)
    rows = np.clip(np.ceil(across.max(axis=1) / spacing), 1, MOST_STEPS).astype(int)
    columns = np.clip(np.ceil(across.min(axis=1) / spacing), 1, MOST_STEPS).astype(int)
    kinds, kind = np.unique(rows * (MOST_STEPS + 1) + columns, return_inverse=True)
    order = np.argsort(kind, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        along, side = divmod(int(kinds[kind[group[0]]]), MOST_STEPS + 1)
        s, t = (g.ravel() for g in np.meshgrid(np.arange(1, along + 1) / along, np.arange(side + 1) / side))
        weights = np.stack([1 - s, s * (1 - t), s * t], axis=1)
        most = max(1, SAMPLES_AT_ONCE // len(weights))
        for start in range(0, len(group), most):
            yield np.einsum("sk,nkd->nsd", weights, corners[group[start : start + most]]).reshape(-1, 3)


def boundary(grid: Grid) -> tuple[Floats, Ints]:
    """Surface of the solid cubes: (P, 3) corner points and (F, 3) outward triangles."""
    solid = np.pad(grid.solid, 1)
    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            beyond = np.roll(solid, -1 if side else 1, axis=axis)
            cells = np.argwhere(solid & ~beyond) - 1
            corner = cells.copy()
            corner[:, axis] += side
            ring = [corner.copy() for _ in range(4)]
            ring[1][:, u] += 1
            ring[2][:, u] += 1
            ring[2][:, v] += 1
            ring[3][:, v] += 1
            quads.append(np.stack(ring if side else ring[::-1], axis=1))
    corners = np.concatenate(quads)
    keys, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 4)
    faces = np.concatenate([index[:, [0, 1, 2]], index[:, [0, 2, 3]]])
    return grid.origin + (keys - 0.5) * grid.cell, faces.astype(np.int64)


def fillable_volume(solid: Mask) -> Mask:
    """(X, Y, Z) empty voxels in which water from outside stays, running sideways and down; `solid`: matter, z up."""
    air = np.pad(~solid, ((0, 0), (0, 0), (1, 1)), constant_values=True)
    runs = np.zeros_like(air)
    runs[:, :, 0] = True
    plane = np.ones((3, 3), dtype=bool)
    for level in range(1, air.shape[2]):
        here = air[:, :, level]
        start = here & runs[:, :, level - 1]
        for edge in (np.s_[0, :], np.s_[-1, :], np.s_[:, 0], np.s_[:, -1]):
            start[edge] = here[edge]
        runs[:, :, level] = ndimage.binary_propagation(start, plane, mask=here)
    reached = ndimage.binary_propagation(runs & air, ndimage.generate_binary_structure(3, 1), mask=air)
    return np.asarray((air & reached & ~runs)[:, :, 1:-1])


@dataclass(frozen=True)
class OpenRooms:
    """The open rooms of a surface, the largest first.

    `grid`: of the surface. `rooms`: (X, Y, Z) number of the room that a voxel belongs to, from 1 on; 0 outside of them.
    `shares`: volume of each room over that of the hull, with what lies close to the walls. `enclosed`: the same of what
    lies between two walls along at least two of the axes: of the inside of a mug or of a compartment that is nearly
    all, of a bend little. `facing`: share of the walls of each, 0..1, that show it their faces and not their backs.
    """

    grid: Grid
    rooms: Ints
    shares: tuple[float, ...]
    enclosed: tuple[float, ...]
    facing: tuple[float, ...]

    def kept(self, with_gaps: bool) -> tuple[int, ...]:
        """Indices of the rooms that collision shapes have to leave open.

        `with_gaps`: also those that backs of faces look into, of sheets without thickness, not gaps in something full.
        """
        is_hollow = self.encloses(with_gaps)
        return tuple(
            k
            for k in self._shown(with_gaps)
            if (is_hollow and self.enclosed[k] >= MIN_ROOM_SHARE) or self.shares[k] >= MIN_BEND_SHARE
        )

    def encloses(self, with_gaps: bool) -> bool:
        """True if closing every gap of the surface would fill rooms that matter; `with_gaps` as in `kept`."""
        return sum(self.enclosed[k] for k in self._shown(with_gaps)) >= MIN_ENCLOSED_SHARE

    def _shown(self, with_gaps: bool) -> list[int]:
        return [k for k, share in enumerate(self.facing) if with_gaps or share >= FACING_SHARE]


NO_ROOMS = OpenRooms(Grid(np.zeros(3), 1.0, _NOWHERE, _NOWHERE), _NOWHERE.astype(np.int64), (), (), ())


def open_rooms(points: Floats, faces: Ints) -> OpenRooms:
    """Find the rooms of a surface that a ball rolling in from outside can reach, within its hull.

    The inside of a mug, the compartments of a shelf and the space under a table are open rooms. A sealed box has none.
    Space that is open only below, and slits too narrow for the ball, do not count. `points`: all used, z up; the floor
    is at the lowest. Raises DegenerateShape: the points span no volume.
    """
    hull_points, hull_faces = convex_hull(points)
    grid = voxelise(points, faces, CELLS)
    hull = ndimage.binary_fill_holes(skin_cells(hull_points, hull_faces, grid))
    room = swept_by_ball(grid.solid, BALL_CELLS) & hull & ~grid.solid
    core = room & (ndimage.distance_transform_edt(~grid.solid) > MARGIN_CELLS)
    label, count = ndimage.label(core)
    if not count:
        return OpenRooms(grid, np.zeros(core.shape, dtype=np.int64), (), (), ())
    # What lies close to the walls belongs to the nearest room.
    near = label[tuple(ndimage.distance_transform_edt(label == 0, return_distances=False, return_indices=True))]
    whole = np.where(room, near, 0)
    shares = np.bincount(whole.ravel(), minlength=count + 1) / max(int(hull.sum()), 1)
    order = [k for k in np.argsort(-shares[1:], kind="stable") + 1 if shares[k] >= MIN_ROOM_SHARE]
    number = np.zeros(count + 1, dtype=np.int64)
    number[order] = np.arange(len(order)) + 1
    rooms = number[whole]
    samples, face = samples_with_faces(points, faces, WALL_SAMPLES)
    look = LOOK_CELLS * grid.cell * face_normals(points, faces)[0][face]
    seen = np.array(
        [np.bincount(rooms[grid.cubes_at(at)], minlength=len(order) + 1) for at in (samples + look, samples - look)]
    )
    bridged = np.bincount(rooms[voxelise(points, faces, CELLS, bridge=True).solid], minlength=len(order) + 1)
    return OpenRooms(
        grid,
        number[label],
        tuple(float(shares[k]) for k in order),
        tuple(float(v) for v in bridged[1:] / int(hull.sum())),
        tuple(float(v) for v in (seen[0] / np.maximum(seen.sum(axis=0), 1))[1:]),
    )


def swept_by_ball(matter: Mask, radius: float) -> Mask:
    """(X, Y, Z) voxels that a ball, radius in voxels, sweeps from above or the sides, not below matter, z up."""
    rim = int(np.ceil(radius)) + 2
    levels = np.flatnonzero(matter.any(axis=(0, 1)))
    lowest = int(levels[0]) if len(levels) else 0
    blocked = np.pad(matter[:, :, lowest:], ((rim, rim), (rim, rim), (1, rim)))
    blocked[:, :, 0] = True
    center = ndimage.distance_transform_edt(~blocked) > radius
    start = np.zeros_like(center)
    start[:, :, -1] = center[:, :, -1]
    reached = ndimage.binary_propagation(start, mask=center)
    swept = ndimage.distance_transform_edt(~reached) <= radius
    out = np.zeros(matter.shape, dtype=bool)
    out[:, :, lowest:] = swept[rim:-rim, rim:-rim, 1:-rim]
    return out


def closed_shares(found: OpenRooms, points: Floats, faces: Ints) -> list[float]:
    """Share of each room, 0..1, that another surface in the same frame, of collision shapes, fills or closes off."""
    # The grid ends close around the thing: what of the shapes lies farther out takes no room of it.
    matter = ndimage.binary_fill_holes(skin_cells(points, faces, found.grid))
    left = swept_by_ball(matter, SMALL_BALL_CELLS) & ~matter
    return [1.0 - float(left[found.rooms == k + 1].mean()) for k in range(len(found.shares))]
