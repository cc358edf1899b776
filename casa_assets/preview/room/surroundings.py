"""The room as a box that shines: how bright it is seen from a place in it, in a direction.

Ceiling, walls, open sides and floor throw light back, windows let it in. Brightness is a fraction of what makes white
look white, linear.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask, Singles
from casa_assets.preview.exposure import Bounds

# Linear RGB of each side of the box. Chosen by eye: warm below, cool through what is open; the ceiling is what lights
# worktops, walls and open sides light fronts, and the floor keeps undersides from going black.
CEILING = (1.30, 1.27, 1.21)
WALL = (0.58, 0.565, 0.54)
OPEN_SIDE = (0.84, 0.85, 0.87)
FLOOR = (0.40, 0.37, 0.335)
_WINDOW = np.array([1.9, 2.05, 2.25], dtype=np.float32)  # on top of the wall
_BLUR = 0.3  # of the edges between the sides of the box; sharp ones would draw stripes on walls
_LEAST = np.float32(1e-4)  # of a direction along an axis
VISUAL_GROUP = 2  # of the geoms that are seen
_FLOOR, _CEILING, _WALL_PREFIX = "floor", "ceiling", "wall_"  # names of the bodies of a room; walls begin with it
_ON_SIDE_M = 0.02  # from a side
_IN_WALL_M = 0.25  # from the inner face of a wall outwards: glass there is a window
_OPAQUE = 0.999  # alpha from which on nothing is seen through
WINDOW_BLUR_M = 0.35  # how softly a window begins, for the same reason


@dataclass(frozen=True)
class Window:
    """A window in a side of the box: `axis` 0 or 1 of the side, whether it is the upper one, and its rectangle.

    Attributes:
        middle, half: (horizontal, z) metres.
    """

    axis: int
    upper: bool
    middle: tuple[float, float]
    half: tuple[float, float]

    def share(self, across: Singles, high: Singles) -> Singles:
        """(N,) 1 within, falling softly to 0 beyond the edges; `across` and `high` are the place in the side."""
        return _inside(across - self.middle[0], self.half[0]) * _inside(high - self.middle[1], self.half[1])


@dataclass(frozen=True)
class Wall:
    """A wall in a side of the box, which it may leave a part of without one: `axis` and `upper` as of a window.

    Attributes:
        start, end: along the side, metres.
    """

    axis: int
    upper: bool
    start: float
    end: float


@dataclass(frozen=True)
class Surroundings:
    """A box with windows.

    Attributes:
        lower, upper: (3,) corners, metres, world frame.
        open_sides: (axis, upper) of the sides without a wall.
        walls, windows: in its sides.
    """

    lower: Singles
    upper: Singles
    open_sides: frozenset[tuple[int, bool]]
    walls: tuple[Wall, ...]
    windows: tuple[Window, ...]

    def way_out(self, places: Singles, directions: Singles) -> tuple[Singles, Ints]:
        """Where (3, N) rays from (3, N) places in the box leave it.

        Returns:
            (N,) length of the way, in lengths of the direction, and (N,) number of the side: 0 and 1 the lower and the
            upper one along x, 2 and 3 along y, 4 and 5 along z.
        """
        ways, faces = self._ways(places, directions)
        return np.min(ways, axis=0), faces[np.argmin(ways, axis=0), np.arange(places.shape[1])]

    def seen(self, places: Singles, directions: Singles, blur: float = _BLUR) -> Singles:
        """(N, 3) linear RGB that is seen from (3, N) places in the box along (3, N) directions.

        Args:
            blur: how softly one side of the box goes over into the next, as a share of the way to it.
        """
        ways, faces = self._ways(places, directions)
        nearest, next_, face, beside = _two_nearest(ways, faces)
        share = np.float32(0.5) * np.clip(1 - (next_ - nearest) / (np.float32(blur) * nearest + _LEAST), 0.0, 1.0)
        colors = self._faces()
        light = colors[face]
        light += share[:, None] * (colors[beside] - light)
        for side in {(w.axis, w.upper) for w in self.windows}:
            hit = np.flatnonzero(face == 2 * side[0] + side[1])
            across, high = (places[k, hit] + nearest[hit] * directions[k, hit] for k in (1 - side[0], 2))
            shares = [w.share(across, high) for w in self.windows if (w.axis, w.upper) == side]
            light[hit] += np.max(shares, axis=0)[:, None] * _WINDOW
        return np.asarray(light)

    def _ways(self, places: Singles, directions: Singles) -> tuple[Singles, Ints]:
        """(3, N) how far (3, N) rays go to the planes of the sides ahead, and (3, N) the numbers of these."""
        ahead = directions > 0
        ways = np.where(ahead, self.upper[:, None], self.lower[:, None]) - places
        ways /= np.where(np.abs(directions) < _LEAST, _LEAST, directions)
        return np.abs(ways), ahead + np.array([[0], [2], [4]])

    def contains(self, place: Floats) -> bool:
        """True if a (3,) place is within the box."""
        return bool((place > self.lower).all() and (place < self.upper).all())

    def is_bare(self, places: Singles, sides: Ints) -> Mask:
        """(N,) whether no wall stands at (3, N) places in the sides with the (N,) numbers; not of floor and ceiling."""
        bare = sides < 4
        for wall in self.walls:
            along = places[1 - wall.axis]
            bare &= (sides != 2 * wall.axis + wall.upper) | (along < wall.start) | (along > wall.end)
        return bare

    def is_on_bare_side(self, places: Singles) -> Mask:
        """(N,) whether (3, N) places lie where a wall is missing."""
        found = np.zeros(places.shape[1], dtype=np.bool_)
        for axis in (0, 1):
            for end, edge in enumerate((self.lower[axis], self.upper[axis])):
                on = np.flatnonzero(np.abs(places[axis] - edge) < _ON_SIDE_M)
                found[on] |= self.is_bare(places[:, on], np.full(len(on), 2 * axis + end))
        return found

    def _faces(self) -> Singles:
        """(6, 3) colours of the sides: lower and upper along x, y and z."""
        sides = [OPEN_SIDE if (axis, bool(end)) in self.open_sides else WALL for axis in (0, 1) for end in (0, 1)]
        return np.array([*sides, FLOOR, CEILING], dtype=np.float32)


def _two_nearest(ways: Singles, faces: Ints) -> tuple[Singles, Singles, Ints, Ints]:
    """Least and second least of each column of (3, N) ways, and their faces; of equals the earlier row first."""
    swap = ways[1] < ways[0]
    near, far = np.minimum(ways[0], ways[1]), np.maximum(ways[0], ways[1])
    near_face, far_face = np.where(swap, faces[1::-1], faces[:2])
    is_first, is_second = ways[2] < near, ways[2] < far
    second = np.where(is_first, near, np.minimum(far, ways[2]))
    second_face = np.where(is_first, near_face, np.where(is_second, faces[2], far_face))
    return np.minimum(near, ways[2]), second, np.where(is_first, faces[2], near_face), second_face


def _inside(off: Singles, half: float) -> Singles:
    """1 within a strip, falling softly to 0 beyond its edges."""
    share = (np.float32(half + WINDOW_BLUR_M) - np.abs(off)) / np.float32(2 * WINDOW_BLUR_M)
    return np.asarray(np.clip(share, 0.0, 1.0))


def surroundings_of(model: Any, data: Any, bounds: Bounds) -> Surroundings:
    """The room of a compiled kitchen after `mj_forward`: its floor, its ceiling, its walls and the glass in them.

    Args:
        bounds: of all that is seen, which stand in for what is missing.
    """
    lower, upper = (corner.copy() for corner in bounds)
    names = {model.body(i).name: i for i in range(1, model.nbody)}
    if _FLOOR in names:
        parts = _boxes(model, data, names[_FLOOR])
        least, most = np.min([p[0] for p in parts], axis=0), np.max([p[1] for p in parts], axis=0)
        lower[:2], upper[:2], lower[2] = least[:2], most[:2], most[2]
    if _CEILING in names:
        # Beams hang from it.
        upper[2] = max(geom_bounds(model, data, geom)[0][2] for geom in _geoms(model, names[_CEILING]))
    walls = tuple(
        wall
        for name, body in names.items()
        if name.startswith(_WALL_PREFIX)
        for wall in _walls(model, data, body, lower, upper)
    )
    is_open = {(axis, end) for axis in (0, 1) for end in (False, True)} - {(w.axis, w.upper) for w in walls}
    windows = tuple(
        window
        for geom in range(model.ngeom)
        if model.geom_group[geom] == VISUAL_GROUP and is_clear(model, geom)
        for window in _windows(*geom_bounds(model, data, geom), lower, upper)
    )
    return Surroundings(lower.astype(np.float32), upper.astype(np.float32), frozenset(is_open), walls, windows)


def is_clear(model: Any, geom: int) -> bool:
    """True if a geom is seen through."""
    material = int(model.geom_matid[geom])
    return float((model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])[3]) < _OPAQUE


def is_shell(model: Any, geom: int) -> bool:
    """True if a geom is of floor, ceiling or a wall."""
    name = model.body(model.geom_bodyid[geom]).name
    return name in (_FLOOR, _CEILING) or name.startswith(_WALL_PREFIX)


def geom_bounds(model: Any, data: Any, geom: int) -> Bounds:
    """(3,) lower and (3,) upper corner of the bounds of a geom, world frame, metres."""
    turn, half = data.geom_xmat[geom].reshape(3, 3), model.geom_aabb[geom][3:]
    middle = data.geom_xpos[geom] + turn @ model.geom_aabb[geom][:3]
    return middle - np.abs(turn) @ half, middle + np.abs(turn) @ half


def _geoms(model: Any, body: int) -> range:
    first = int(model.body_geomadr[body])
    return range(first, first + int(model.body_geomnum[body])) if first >= 0 else range(0)


def _boxes(model: Any, data: Any, body: int) -> list[Bounds]:
    """Bounds of the parts of a body; of its boxes where it has some, as the bounds of a mesh may lie askew."""
    boxes = [g for g in _geoms(model, body) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX]
    return [geom_bounds(model, data, geom) for geom in boxes or _geoms(model, body)]


def _walls(model: Any, data: Any, body: int, lower: Floats, upper: Floats) -> Iterator[Wall]:
    """The wall that a body is, if it stands in a side of the box from `lower` to `upper`."""
    # It faces the room with its -y.
    outwards = data.xmat[body].reshape(3, 3)[:, 1]
    axis = int(np.abs(outwards[:2]).argmax())
    end = bool(outwards[axis] > 0)
    parts = _boxes(model, data, body)
    if abs(data.xpos[body][axis] - (lower, upper)[end][axis]) < _IN_WALL_M:
        other = 1 - axis
        yield Wall(axis, end, min(p[0][other] for p in parts) - 0.01, max(p[1][other] for p in parts) + 0.01)


def _windows(least: Floats, most: Floats, lower: Floats, upper: Floats) -> Iterator[Window]:
    """The window that a pane of glass is, if it stands in a wall: corners of the pane, then of the room."""
    middle, half = (least + most) / 2.0, (most - least) / 2.0
    for axis in (0, 1):
        for end, off in ((False, lower[axis] - middle[axis]), (True, middle[axis] - upper[axis])):
            if 0.0 < off < _IN_WALL_M and half[axis] < 0.1:
                other = 1 - axis
                yield Window(axis, end, (middle[other], middle[2]), (half[other], half[2]))
