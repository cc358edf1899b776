"""Merge boxes and other primitives into fewer, without closing a space that something could get into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from casa_assets import Asset
from casa_assets.ext.arrays import Floats, Ints, Mask
from casa_assets.ext.kitchens import LightScene
from casa_assets.ext.records import Box, Capsule, Collider, Cylinder, Pose, Shape, Sphere
from casa_assets.ext.solids import box_around, shape_bounds

# A gap twice as wide as this counts as closed: neither a finger nor a thing that a kitchen holds gets in, metres.
CLOSED_GAP_HALF_M = 0.006
TOLERANCE_M = 0.0025  # how far what is merged may stick out of what it replaces, metres
# Besides the faces of boxes, lines of the grid lie this far apart, metres: shapes that stand askew have no such faces.
LINE_STEP_M = 0.1
BORDER_M = 0.1  # free room around all boxes, metres
SAME_LINE_M = 1e-3  # lines closer than this are one, metres
ROUNDING_M = 1e-6  # numbers on either side that are equal but for rounding, metres
ORDERS = ((0, 1, 2), (1, 2, 0), (2, 0, 1))  # orders in which a box grows along the axes: each axis comes first once
SAMPLES = 14  # points along each axis of a wall on which it is counted how much of it is filled
# Points in the box around a body on which it is counted how empty parts of that are, about; along an axis at least.
POINTS, LEAST_POINTS = 12_000, 5
CUTS = 6  # places along an axis at which a group is divided, besides its widest gap, about
RIM_POINTS = 16  # points around the rim of a cylinder, and of a ball from pole to pole
NEGLIGIBLE_SHARE = 0.05  # shapes that are together smaller than this share of all are left out where the outline stays
# None of them is longer than this, but for rods that are thinner than that, metres: walls of a vessel are thin and
# still hold what is in it.
SMALL_M, SLENDER_M = 0.03, 0.02
EXCHANGES = 3  # times that shapes may change groups
MOST_JOINED = 28  # shapes up to which a thing is tried from the bottom up, too
OUTLINE_M = 0.005  # how far the outline may change, metres
FREE_MARGIN_M = 0.001  # what has to be free is so but for its outermost layer of this thickness, metres
# Walls around it are at least as thick as this, metres; less of a wall than this share filled is an opening, 0..1.
WALL_M = 0.001
MIN_WALL_SHARE = 0.08
MOST_SEEN_M = 0.004
MOST_CUT_OFF = 0.5  # no more than this share of a primitive is cut off where it would reach into another body, 0..1
EMPTY_SHARE_OF_VESSEL = 0.7  # share of the walls of a vessel that may be empty: a round one has square walls
SIZE_STEP_M = 1e-6  # sizes and positions are multiples of this, metres: the last digits of a computation are no promise
AROUND_M = 0.05  # points around boxes are this far from them, metres
ALIGNED = 1 - 1e-9  # cosine of the angle between axes that are the same


class ReachableSpace:
    """The space of a room that can be reached from given points, on a grid along the faces of the obstacles.

    Gaps of up to 12 mm count as closed. Moving parts are not obstacles: the inside of a cupboard with a door is
    reachable. `boxes`: (N, 2, 3) lower and upper corners of the obstacles, metres, world frame.
    """

    def __init__(self, boxes: Floats, seeds: Floats, askew: Sequence[tuple[Shape, Pose]] = ()) -> None:
        """Find the space among (N, 2, 3) corners of axis-aligned boxes, N > 0, metres, and other shapes, in the world.

        `seeds`: (M, 3) points from which it is reached; those inside of boxes are passed over.
        """
        self.boxes = boxes
        closed = boxes + np.array([[-CLOSED_GAP_HALF_M] * 3, [CLOSED_GAP_HALF_M] * 3])
        self._lines = [_lines(closed[:, :, axis]) for axis in range(3)]
        self._centers = [(lines[1:] + lines[:-1]) / 2 for lines in self._lines]
        solid = np.zeros([len(centers) for centers in self._centers], dtype=bool)
        for lower, upper in closed:
            solid[self._cells(lower, upper)] = True
        for shape, pose in askew:
            self._mark(solid, shape, pose)
        self._reached = self._flooded(solid, seeds)

    def touches(self, lower: Floats, upper: Floats, margin: float) -> bool:
        """True where a box, `margin` metres larger on each side, holds reachable space.

        A margin of CLOSED_GAP_HALF_M and more asks whether anything can touch it; that less TOLERANCE_M asks whether it
        would take away space from what could be there.
        """
        ranges = []
        for axis in range(3):
            lines = self._lines[axis]
            first = int(np.searchsorted(lines, lower[axis] - margin + SAME_LINE_M, side="right")) - 1
            last = int(np.searchsorted(lines, upper[axis] + margin - SAME_LINE_M, side="left"))
            first, last = max(first, 0), min(last, len(lines) - 1)
            if first >= last:
                return False
            ranges.append(slice(first, last))
        return bool(self._reached[tuple(ranges)].any())

    def takes_room(self, lower: Floats, upper: Floats) -> bool:
        """True where a box, (3,) and (3,) its corners, would take away space that something can get into."""
        return self.touches(lower, upper, CLOSED_GAP_HALF_M - TOLERANCE_M)

    def is_exposed(self, lower: Floats, upper: Floats) -> bool:
        """True where something can get at a box, (3,) and (3,) its corners, metres."""
        return self.touches(lower, upper, CLOSED_GAP_HALF_M + TOLERANCE_M)

    def _cells(self, lower: Floats, upper: Floats) -> tuple[slice, slice, slice]:
        """Cells whose centres lie within a box."""
        spans = [
            slice(int(np.searchsorted(centers, low)), int(np.searchsorted(centers, high)))
            for centers, low, high in zip(self._centers, lower, upper, strict=True)
        ]
        return spans[0], spans[1], spans[2]

    def _mark(self, solid: Mask, shape: Shape, pose: Pose) -> None:
        """Mark the cells whose centres lie in a shape, with half a gap around it."""
        lower, upper = shape_bounds(shape, pose)
        cells = self._cells(lower - 2 * CLOSED_GAP_HALF_M, upper + 2 * CLOSED_GAP_HALF_M)
        grids = np.meshgrid(*(c[s] for c, s in zip(self._centers, cells, strict=True)), indexing="ij")
        points = pose.inverse().apply(np.stack([g.ravel() for g in grids], axis=1))
        solid[cells] |= is_inside(shape, points, CLOSED_GAP_HALF_M).reshape(grids[0].shape)

    def _flooded(self, solid: Mask, seeds: Floats) -> Mask:
        """The free cells that hang together with a seed; all free ones where every seed is inside of something."""
        labels, _ = ndimage.label(~solid)
        found: set[int] = set()
        for point in seeds:
            places = zip(self._lines, point, strict=True)
            index: Ints = np.array([np.searchsorted(lines, value) - 1 for lines, value in places])
            if (index >= 0).all() and (index < np.array(labels.shape)).all():
                found.add(int(labels[tuple(index)]))
        wanted = np.zeros(int(labels.max()) + 1, dtype=bool)
        wanted[sorted(found - {0}) or slice(1, None)] = True
        return np.asarray(wanted[labels])


def is_inside(shape: Shape, points: Floats, margin: float = 0.0) -> Mask:
    """(N,) whether points of a primitive's frame lie in it, or at most `margin` m off. ValueError: no primitive."""
    if isinstance(shape, Box):
        beside = np.abs(points) - np.array(shape.size) / 2
        return np.asarray(beside.max(axis=1) <= margin, dtype=bool)
    if isinstance(shape, Sphere):
        return np.asarray(np.linalg.norm(points, axis=1) <= shape.radius + margin, dtype=bool)
    if isinstance(shape, Cylinder):
        round_ = np.hypot(points[:, 0], points[:, 1]) <= shape.radius + margin
        return np.asarray(round_ & (np.abs(points[:, 2]) <= shape.height / 2 + margin), dtype=bool)
    if isinstance(shape, Capsule):
        beyond = points - np.clip(points, [0, 0, -shape.height / 2], [0, 0, shape.height / 2])
        return np.asarray(np.linalg.norm(beyond, axis=1) <= shape.radius + margin, dtype=bool)
    raise ValueError(f"a {shape.kind} is no primitive")


def _lines(faces: Floats) -> Floats:
    """Lines of the grid along one axis: the faces of all boxes, those between, and the border."""
    low, high = float(faces.min()) - BORDER_M, float(faces.max()) + BORDER_M
    between = np.arange(low, high, LINE_STEP_M)
    every = np.unique(np.concatenate([faces.ravel(), between, [high]]))
    is_new = np.concatenate([[True], np.diff(every) > SAME_LINE_M])
    return np.asarray(every[is_new], dtype=np.float64)


class CoveringBox(NamedTuple):
    """A box: its (2, 3) corners in metres, and the indices of the boxes that it replaces, the largest first."""

    corners: Floats
    covered: tuple[int, ...]


def cover_boxes(space: ReachableSpace) -> list[CoveringBox]:
    """Replace the boxes of a space by fewer; none sticks out by more than TOLERANCE_M into reachable space.

    Each box grows through solid or closed space as far as the faces of others. Then the grown box that holds most of
    the boxes not yet covered is taken, until all are covered. Boxes that nothing can touch are left out.
    """
    boxes = space.boxes
    exposed = np.array([space.is_exposed(lower, upper) for lower, upper in boxes], dtype=bool)
    grown = np.concatenate([boxes, *([_grown(space, box, order) for box in boxes] for order in ORDERS)])
    # (G, N) which of the boxes each of the grown holds.
    sticks_out = np.maximum(grown[:, None, 0] - boxes[None, :, 0], boxes[None, :, 1] - grown[:, None, 1]).max(axis=2)
    inside = np.asarray(sticks_out <= TOLERANCE_M, dtype=bool)
    volumes = np.prod(boxes[:, 1] - boxes[:, 0], axis=1)
    left, found = exposed.copy(), list[CoveringBox]()
    while left.any():
        counts = (inside & left).sum(axis=1)
        best = int(np.argmax(counts))
        held: Ints = np.flatnonzero(inside[best] & left)
        corners = np.array([boxes[held, 0].min(axis=0), boxes[held, 1].max(axis=0)])
        found.append(CoveringBox(corners, tuple(int(i) for i in held[np.argsort(-volumes[held], kind="stable")])))
        left[held] = False
    return found


def _grown(space: ReachableSpace, box: Floats, order: tuple[int, int, int]) -> Floats:
    """A box as large as it gets along each axis in turn, up to faces of others and without taking room."""
    grown = box.copy()
    for axis in order:
        others = [other for other in range(3) if other != axis]
        beside = (space.boxes[:, 0, others] < grown[1, others] - ROUNDING_M).all(axis=1)
        beside &= (space.boxes[:, 1, others] > grown[0, others] + ROUNDING_M).all(axis=1)
        for side, sign in ((1, 1.0), (0, -1.0)):
            faces = np.unique(sign * space.boxes[beside, side, axis])
            for face in sign * faces[faces > sign * grown[side, axis] + ROUNDING_M]:
                slab = grown.copy()
                slab[1 - side, axis], slab[side, axis] = grown[side, axis], face
                if space.takes_room(slab[0], slab[1]):
                    break
                grown[side, axis] = face
    return grown


class Fitted(NamedTuple):
    """A primitive with its pose in the body, and the indices of the primitives that it replaces, the largest first."""

    shape: Shape
    pose: Pose
    covered: tuple[int, ...]


@dataclass(frozen=True)
class FitLimits:
    """How closely primitives are fitted.

    At most `most` groups (one that reaches into what is kept free becomes a few boxes); a primitive of which more than
    `empty_share` is empty is divided. `free`: primitives with their poses whose space is kept free for things.
    `neighbours`: (N, 2, 3) corners of boxes of other bodies, frame of the body, metres; nothing reaches into them.
    """

    most: int
    empty_share: float
    free: Sequence[tuple[Shape, Pose]] = ()
    neighbours: Floats | None = None


def fit_primitives(shapes: Sequence[tuple[Shape, Pose]], limits: FitLimits) -> list[Fitted]:
    """Boxes and upright cylinders around groups of primitives with their poses in a body.

    One is fitted around all. The one that is most empty is divided in two along an axis, until all are full enough or
    there are enough of them. A group of one stays as it is. A box that holds what has to be free becomes its walls.
    """
    bounds = np.array([shape_bounds(shape, pose) for shape, pose in shapes])
    sizes = np.array([np.diff(shape_bounds(shape, Pose()), axis=0)[0] for shape, _ in shapes])  # along the own axes
    volumes = np.prod(sizes, axis=1)
    wanted = _not_negligible(bounds, volumes, np.sort(sizes, axis=1))
    grid = _Grid.around(shapes, bounds, limits)
    groups = [grid.group(wanted)]
    while len(groups) < limits.most:
        allowed = [EMPTY_SHARE_OF_VESSEL if g.takes_room else limits.empty_share for g in groups]
        divisible = [i for i, g in enumerate(groups) if len(g.members) > 1 and g.empty_share > allowed[i]]
        if not divisible:
            break
        worst = max(divisible, key=lambda i: groups[i].empty_m3)
        groups[worst : worst + 1] = _divided(grid, groups[worst])
    groups = _exchanged(grid, groups)
    if 1 < len(groups) < len(wanted) <= MOST_JOINED and not any(group.takes_room for group in groups):
        # Legs and a seat are found from the bottom up, a case and its handle from the top down.
        groups = min(groups, _joined(grid, wanted, len(groups)), key=lambda found: sum(g.empty_m3 for g in found))
    found = []
    for group in groups:
        covered = tuple(sorted(map(int, group.members), key=lambda i: (-volumes[i], i)))
        found += _around([shapes[i] for i in covered], covered, group, limits)
    if limits.neighbours is None:
        return found
    return [_cut_off(piece, limits.neighbours) if len(piece.covered) > 1 else piece for piece in found]


class _Group(NamedTuple):
    """Some primitives, by index, and the aligned (2, 3) box around them; what is empty in it but for free space."""

    members: Ints
    box: Floats
    empty_m3: float
    empty_share: float
    takes_room: bool


@dataclass(frozen=True)
class _Grid:
    """(N, 3) points evenly within the box around a body, each for `cell_m3` of volume.

    `held`: (P, N) whether a primitive holds a point. `free`: (N,) whether it has to be free. `bounds`: (P, 2, 3),
    metres.
    """

    points: Floats
    cell_m3: float
    held: Mask
    free: Mask
    bounds: Floats

    @classmethod
    def around(cls, shapes: Sequence[tuple[Shape, Pose]], bounds: Floats, limits: FitLimits) -> _Grid:
        """The grid of a body. Cells are cubes where it is not very thin."""
        lower, upper = box_around(bounds)
        size = np.maximum(upper - lower, WALL_M)
        step = float(np.cbrt(np.prod(size) / POINTS))
        counts = np.clip(np.ceil(size / step).astype(int), LEAST_POINTS, None)
        points = _even_points(lower, lower + size, counts)
        # Half a cell around it, so that a wall thinner than a cell is there.
        margin = min(float((size / counts).min()) / 2, MOST_SEEN_M)
        held = np.array([is_inside(shape, pose.inverse().apply(points), margin) for shape, pose in shapes])
        free: Mask = np.zeros(len(points), dtype=bool)
        for kept, at in limits.free:
            free |= is_inside(kept, at.inverse().apply(points), -FREE_MARGIN_M)
        return cls(points, float(np.prod(size / counts)), held, free & ~held.any(axis=0), bounds)

    def group(self, members: Ints) -> _Group:
        """The aligned box around some primitives."""
        box = box_around(self.bounds[members])
        if len(members) == 1:
            return _Group(members, box, 0.0, 0.0, False)
        inside = ((self.points >= box[0]) & (self.points <= box[1])).all(axis=1)
        empty = inside & ~self.held[members].any(axis=0)
        takes = bool((empty & self.free).any())
        number = int((empty & ~self.free).sum())
        return _Group(members, box, number * self.cell_m3, number / max(int((inside & ~self.free).sum()), 1), takes)


def _not_negligible(bounds: Floats, volumes: Floats, sizes: Floats) -> Ints:
    """Indices of shapes, smallest first, without those that are small together and reach no farther out than others.

    Shapes at the bottom, which the body rests on, are kept. `sizes`: (N, 3) along the own axes, ascending; metres.
    """
    kept = np.ones(len(volumes), dtype=bool)
    lower, upper = bounds[:, 0].min(axis=0) + OUTLINE_M, bounds[:, 1].max(axis=0) - OUTLINE_M
    left_out = 0.0
    for i in np.argsort(volumes, kind="stable"):
        left_out += float(volumes[i])
        if left_out > NEGLIGIBLE_SHARE * volumes.sum():
            break
        if bounds[i, 0, 2] < lower[2] or (sizes[i, 2] > SMALL_M and sizes[i, 1] > SLENDER_M):
            continue
        rest = kept.copy()
        rest[i] = False
        if (bounds[rest, 0].min(axis=0) <= lower).all() and (bounds[rest, 1].max(axis=0) >= upper).all():
            kept = rest
    return np.flatnonzero(kept)


def _divided(grid: _Grid, group: _Group) -> list[_Group]:
    """A group in two, along the axis and at the place where the two are least empty together."""
    members = group.members
    middles = grid.bounds[members].mean(axis=1)
    best: tuple[float, list[_Group]] | None = None
    for axis in range(3):
        order = np.argsort(middles[:, axis], kind="stable")
        gaps = np.diff(middles[order, axis])
        # The widest gap, and some places between.
        places = np.unique(np.linspace(1, len(members) - 1, min(CUTS, len(members) - 1)).round().astype(int))
        for cut in sorted({int(np.argmax(gaps)) + 1, *map(int, places)}):
            pair = [grid.group(np.sort(members[half])) for half in (order[:cut], order[cut:])]
            cost = sum(g.empty_m3 for g in pair)
            if best is None or cost < best[0]:
                best = (cost, pair)
    assert best is not None
    return best[1]


def _joined(grid: _Grid, members: Ints, count: int) -> list[_Group]:
    """So many groups: of all pairs those two become one again and again that leave least more empty."""
    groups = [grid.group(np.array([member])) for member in members]
    pairs: dict[tuple[tuple[int, ...], tuple[int, ...]], _Group] = {}
    while len(groups) > count:
        best: tuple[float, int, int, _Group] | None = None
        for i, first in enumerate(groups):
            for k in range(i + 1, len(groups)):
                second = groups[k]
                key = (tuple(first.members.tolist()), tuple(second.members.tolist()))
                if key not in pairs:
                    pairs[key] = grid.group(np.sort(np.concatenate([first.members, second.members])))
                more = pairs[key].empty_m3 - first.empty_m3 - second.empty_m3
                if best is None or more < best[0]:
                    best = (more, i, k, pairs[key])
        assert best is not None
        _, i, k, both = best
        groups = [group for n, group in enumerate(groups) if n not in (i, k)] + [both]
    return groups


def _exchanged(grid: _Grid, groups: list[_Group]) -> list[_Group]:
    """The groups, after each shape went to that in which it leaves least empty. No group is left without any."""
    for _ in range(EXCHANGES):
        changed = False
        for member in [int(m) for group in groups for m in group.members]:
            own = next(i for i, group in enumerate(groups) if member in group.members)
            if len(groups[own].members) == 1:
                continue
            without = grid.group(groups[own].members[groups[own].members != member])
            freed = groups[own].empty_m3 - without.empty_m3
            best: tuple[float, int, _Group] | None = None
            for other, group in enumerate(groups):
                if other != own:
                    grown = grid.group(np.sort(np.append(group.members, member)))
                    cost = grown.empty_m3 - group.empty_m3
                    if cost < freed - grid.cell_m3 and (best is None or cost < best[0]):
                        best = (cost, other, grown)
            if best is not None:
                groups[own], groups[best[1]] = without, best[2]
                changed = True
        if not changed:
            break
    return groups


def _around(
    parts: Sequence[tuple[Shape, Pose]], covered: tuple[int, ...], group: _Group, limits: FitLimits
) -> list[Fitted]:
    """The box or cylinder around the primitives of a group that is smallest, or its walls where it takes room."""
    if len(parts) == 1:
        return [Fitted(*parts[0], covered)]
    if group.takes_room:
        walls = _walls(parts, group.box, limits)
        if len(walls) < len(parts):
            return [Fitted(shape, pose, covered) for shape, pose in walls]
        return [Fitted(*part, (i,)) for part, i in zip(parts, covered, strict=True)]
    points = np.concatenate([pose.apply(_points(shape)) for shape, pose in parts])
    options: list[tuple[float, Shape, Pose]] = []
    for turn in (np.eye(3), parts[0][1].rotation):
        local = points @ turn
        low, high = local.min(axis=0), local.max(axis=0)
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn, turn @ ((low + high) / 2)
        x, y, z = (float(s) for s in high - low)
        shape, pose = Box(size=(x, y, z)), Pose.from_matrix(matrix)
        sides = shape_bounds(shape, pose)
        # A leg that leans must not stand deeper than it did.
        if sides[0, 2] >= group.box[0, 2] - FREE_MARGIN_M and np.abs(sides - group.box).max() <= OUTLINE_M:
            options.append((x * y * z, shape, pose))
    lower, upper = points.min(axis=0), points.max(axis=0)
    a, b, c = (float(s) for s in (lower + upper) / 2)
    radius = float(np.hypot(points[:, 0] - a, points[:, 1] - b).max())
    height = float(upper[2] - lower[2])
    if 2 * radius <= (upper - lower)[:2].min() + 2 * OUTLINE_M:
        upright = Pose(position=(a, b, c))
        options.append((float(np.pi) * radius**2 * height, Cylinder(radius=radius, height=height), upright))
    # The first of equals: an aligned box rather than one that is turned by nothing.
    _, found, at = min(options, key=lambda option: round(option[0], 9))
    return [Fitted(found, at, covered)]


def _walls(parts: Sequence[tuple[Shape, Pose]], box: Floats, limits: FitLimits) -> list[tuple[Shape, Pose]]:
    """Return the rest of an aligned (2, 3) box, less the space to be kept free, as boxes shrunk to parts in them."""
    left = [box]
    for kept, at in limits.free:
        hole = shape_bounds(kept, at) + np.array([[FREE_MARGIN_M], [-FREE_MARGIN_M]])
        left = [rest for piece in left for rest in _without(piece, hole)]
    found: list[tuple[Shape, Pose]] = []
    for piece in left:
        whole, middle = box_between(piece)
        lower, upper = shape_bounds(whole, Pose())
        points = middle.apply(_even_points(lower, upper, [SAMPLES] * 3))
        cell = (piece[1] - piece[0]) / SAMPLES
        filled: Mask = np.zeros(len(points), dtype=bool)
        for part, at in parts:
            # Half a cell around it, so that sheet metal is seen.
            filled |= is_inside(part, at.inverse().apply(points), min(float(cell.max()) / 2, MOST_SEEN_M))
        if filled.mean() < MIN_WALL_SHARE:
            continue
        lower = np.maximum(points[filled].min(axis=0) - cell / 2, piece[0])
        upper = np.minimum(points[filled].max(axis=0) + cell / 2, piece[1])
        found.append(box_between(np.array([lower, upper])))
    return found


def _cut_off(piece: Fitted, neighbours: Floats) -> Fitted:
    """An aligned box or upright cylinder, cut out of other bodies, each time where least is lost; others unchanged."""
    shape, pose = piece.shape, piece.pose
    if isinstance(shape, Sphere | Capsule) or not is_aligned(pose):
        return piece
    if isinstance(shape, Cylinder) and abs(pose.rotation[2, 2]) < ALIGNED:
        return piece
    box = shape_bounds(shape, pose)
    for other in neighbours:
        axes = [] if isinstance(shape, Cylinder) else [0, 1]
        if other[:, 2].mean() > box[:, 2].mean():
            # Of two things that stand in each other the lower one makes room: what stands on it goes on standing there.
            axes.append(2)
        if not axes or (other[0] + FREE_MARGIN_M >= box[1]).any() or (other[1] - FREE_MARGIN_M <= box[0]).any():
            continue
        size = box[1] - box[0]
        cuts = [((box[1, a] - other[0, a]) / size[a], a, 1, other[0, a]) for a in axes]
        cuts += [((other[1, a] - box[0, a]) / size[a], a, 0, other[1, a]) for a in axes]
        share, axis, side, face = min(cuts, key=lambda cut: cut[:3])
        if share < MOST_CUT_OFF:
            box[side, axis] = face
    rest, at = box_between(box)
    if isinstance(shape, Cylinder):
        return piece._replace(shape=shape.replace(height=rest.size[2]), pose=pose.replace(position=at.position))
    return piece._replace(shape=rest, pose=at)


def _without(box: Floats, hole: Floats) -> list[Floats]:
    """Boxes that are together a box, (2, 3) its corners, without another; thinner ones than WALL_M are left out."""
    if (hole[0] >= box[1]).any() or (hole[1] <= box[0]).any():
        return [box]
    rest, found = box.copy(), list[Floats]()
    for axis in range(3):
        for side, face in ((0, hole[0, axis]), (1, hole[1, axis])):
            piece = rest.copy()
            piece[1 - side, axis] = face
            if piece[1, axis] - piece[0, axis] >= WALL_M:
                found.append(piece)
            rest[side, axis] = max(rest[0, axis], face) if side == 0 else min(rest[1, axis], face)
    return found


def _even_points(lower: Floats, upper: Floats, counts: Sequence[int] | Ints) -> Floats:
    """(N, 3) points evenly within a box, in the middles of `counts` cells along each axis, metres."""
    axes = [np.linspace(low, high, 2 * n + 1)[1::2] for low, high, n in zip(lower, upper, counts, strict=True)]
    return np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)


def _points(shape: Shape) -> Floats:
    """(N, 3) points whose hull holds a primitive, in its frame, metres; round ones to within half a percent."""
    if isinstance(shape, Box):
        signs = np.array(np.meshgrid(*([-0.5, 0.5],) * 3)).reshape(3, -1).T
        return np.asarray(signs * np.array(shape.size))
    around = np.linspace(0.0, 2 * np.pi, RIM_POINTS, endpoint=False)
    rim = np.stack([np.cos(around), np.sin(around), np.zeros(RIM_POINTS)], axis=1)
    if isinstance(shape, Cylinder):
        up = np.array([0.0, 0.0, shape.height / 2])
        return np.concatenate([shape.radius * rim - up, shape.radius * rim + up])
    if isinstance(shape, Sphere | Capsule):
        half = shape.height / 2 if isinstance(shape, Capsule) else 0.0
        rings = []
        for angle in np.linspace(-np.pi / 2, np.pi / 2, RIM_POINTS // 2 + 1):
            up = np.array([0.0, 0.0, np.copysign(half, angle) + shape.radius * np.sin(angle)])
            rings.append(shape.radius * np.cos(angle) * rim + up)
        return np.concatenate(rings)
    raise ValueError(f"a {shape.kind} is no primitive")


def fitted_colliders(colliders: Sequence[Collider], limits: FitLimits) -> tuple[Collider, ...]:
    """Fit fewer colliders around some, named after the largest that each replaces or after a piece of it."""
    if len(colliders) < 2:
        return tuple(colliders)
    found: list[Collider] = []
    taken: set[str] = set()
    for fitted in fit_primitives([(c.shape, c.pose) for c in colliders], limits):
        owner = colliders[fitted.covered[0]]
        name, number = owner.name, 0
        while name in taken:
            number += 1
            name = LightScene.part_name(LightScene.collider_of(owner.name), number)
        taken.add(name)
        found.append(replaced(owner, fitted.shape, fitted.pose).replace(name=name))
    return tuple(found)


def replaced(collider: Collider, shape: Shape, pose: Pose) -> Collider:
    """The collider with another shape, rounded."""
    x, y, z = (round(value / SIZE_STEP_M) * SIZE_STEP_M for value in pose.position)
    pose = pose.replace(position=(x, y, z))
    if isinstance(shape, Box):
        a, b, c = (max(round(size / SIZE_STEP_M), 1) * SIZE_STEP_M for size in shape.size)
        shape = Box(size=(a, b, c))
    elif isinstance(shape, Cylinder):
        radius, height = (max(round(size / SIZE_STEP_M), 1) * SIZE_STEP_M for size in (shape.radius, shape.height))
        shape = Cylinder(radius=radius, height=height)
    return collider.replace(shape=shape, pose=pose)


def box_between(corners: Floats) -> tuple[Box, Pose]:
    """The aligned box between two corners, (2, 3) metres, and its pose."""
    x, y, z = (float(s) for s in corners[1] - corners[0])
    a, b, c = (float(s) for s in corners.mean(axis=0))
    return Box(size=(x, y, z)), Pose(position=(a, b, c))


def is_aligned(pose: Pose) -> bool:
    """True where the axes of a pose are those of the frame, in any order."""
    return bool(np.abs(pose.rotation).max(axis=1).min() > ALIGNED)


def points_around(corners: Floats) -> Floats:
    """(8, 3) points around boxes, from which anything gets at them."""
    low, high = corners[:, 0].min(axis=0) - AROUND_M, corners[:, 1].max(axis=0) + AROUND_M
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def touched_colliders(form: Asset) -> set[str]:
    """Names of the colliders whose contacts the asset's behaviour looks at."""
    return set() if form.behavior is None else set(form.behavior.contacts)
