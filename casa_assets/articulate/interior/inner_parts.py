"""Find what is behind fronts: racks and turntables, boxes of drawers, and what moves with a front."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, PartPlan
from casa_assets.articulate.segment.fragments import (
    MeasuredFragments,
    WeldedMesh,
    corners_from_side,
    corners_of_labels,
    view_from_above,
)
from casa_assets.articulate.segment.orthographic import BOTTOM, FRONT, LEFT, RIGHT, SIDES, render_depth
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.surface import connected_groups, face_components
from casa_assets.model.asset.parts import JointKind

# Longer side of the pictures in which a front is compared with what is before it, and of those of what is behind it.
WAY_PIXELS = BEHIND_PIXELS = 256
# A piece lies within the outline of a front, or touches it, to within this, diagonals. Choices, as is the next.
TOLERANCE = 0.002
# Share of a piece, seen along the way of a front, behind which something of the front follows.
MIN_BLOCKED_SHARE = 0.25
# An axis is one of the six sides where its cosine with it is at least this.
MIN_COSINE = 0.99
# The way that doors open, in the frame.
OUT = np.array([0.0, -1.0, 0.0])
# Least width of a rack and of a turntable as shares of their door, and their greatest height.
MIN_RACK_WIDTH_SHARE, MIN_TURNTABLE_WIDTH_SHARE, MAX_HEIGHT_SHARE = 0.45, 0.2, 0.5
# Least width of a tub as a share of its door, since tubs stand side by side, and the gaps over which fragments are
# grouped, the narrower first; diagonals.
MIN_TUB_WIDTH_SHARE, GROUPING_GAPS = 0.3, (0.0008, 0.004)
# How far behind the front a tub begins at most, by its depth, and its least height by its shorter side. The front of a
# block has its outline within this, diagonals, and lies before it by this share of its depth at most.
MAX_TUB_START_SHARE, MIN_TUB_HEIGHT_SHARE, OUTLINE_TOLERANCE, MAX_FRONT_SHARE = 0.35, 0.08, 0.004, 0.2
# Greatest share of the surface of an inner part that is visible from outside, and of a tub.
MAX_VISIBLE_SHARE, MAX_TUB_VISIBLE_SHARE = 0.02, 0.05
# A plate this near to a wall rests on it, diagonals.
TOUCH_TOLERANCE = 0.001
# What slides or turns behind a door has room: over it this share of the height of the door is free, since things stand
# on it, and on its way out to the door. Shares of the pixels of that opening, without its outer tenths, that are free.
CLEAR_HEIGHT_SHARE, MIN_FREE_SHARE, OPENING_MARGIN = 0.06, 0.7, 0.1
# Greatest depth of the lining of a door as a share of the object.
MAX_LINING_DEPTH = 0.34
# Least share of its plan that a rack covers: the loop of a heating element covers less, rods of a rack over a tenth.
MIN_RACK_COVER = 0.06
# What is thinner than this share of the height of the door and as near to the floor of its cavity is a liner or a
# heating element. Ref: baskets that stand on the floor are higher.
FLOOR_SHARE = 0.03
# A plate that meets other surfaces along this share of its left, right and back border is part of what lines the
# cavity: racks rest on the sides alone, and baskets stand free. Width of a border and greatest gap to what it meets,
# diagonals; samples of the plate and of what is around it.
MIN_MEETING_SHARE, BORDER_DEPTH, MAX_BORDER_GAP = 0.7, 0.004, 0.006
LINING_SAMPLES, SURROUNDINGS_SAMPLES = 4000, 40000
# A face looks along an axis from this cosine on.
ALONG_COS = 0.9
# Walls of a box that look away from its middle, as axis and sign: left, right, bottom and back.
WALLS = ((0, -1), (0, 1), (1, -1), (2, 1))
# A wall of a box covers this share of what it would at the size of the front and the depth behind it.
MIN_WALL_SHARE = 0.2
# The outermost faces of a wall are this quantile of its area from outside.
OUTERMOST = 0.1
# Faces of a box keep within its walls and this, diagonals.
LAYER_TOLERANCE = 0.003
# Least number of walls. A box ends so far below the top of its front and a ceiling, diagonals.
MIN_WALLS, CEILING_GAP = 2, 0.008
# Largest roof over a box, as a share of its plan, and height to width of a front above which it is a door.
MAX_ROOF_SHARE, MAX_HEIGHT_RATIO = 0.4, 1.3
# Least width and height of a box as shares of its front.
MIN_WIDTH_SHARE, MIN_HEIGHT_SHARE = 0.6, 0.25
# Depth of layers and bins of a door as a share of the object, and the distance of bins from its edges, diagonals.
MAX_DEPTH_SHARE, MIN_EDGE_DISTANCE = 0.14, 0.008
# A bin that begins so far inside its panel, by the thickness of that, may be this deep, as a share of the object.
BIN_START_SHARE, MAX_BIN_DEPTH_SHARE = 0.25, 0.3
# Layers of a door share its outline within this, diagonals, touch, and fill this share of it, unlike frames.
LAYER_OUTLINE_TOLERANCE, MIN_LAYER_FILL, MAX_LAYERS = 0.006, 0.8, 3


def with_pieces_in_the_way(articulation: Articulation, mesh: WeldedMesh) -> Articulation:
    """Return the articulation with doors and drawers that carry what they would run into as they open.

    A connected piece of the body, or the rest of one from which parts were taken, goes with a front if it lies within
    the outline of the front, reaches at least its front and no farther than its back, and some surface of the front is
    behind the piece: the sides of a box between front and back, the foot of a handle, a piece of a shell between the
    two sheets of a door. Pieces of the frame reach beyond that outline, or have none of the front behind them.

    Args:
        mesh: in the frame; the faces of the parts are those of this mesh.
    """
    label = _pieces_of_body(articulation.face_owner(len(mesh.faces)) < 0, mesh)
    count = int(label.max(initial=-1)) + 1
    if not count:
        return articulation
    lower, upper = corners_of_labels(mesh, label)
    free = np.ones(count, dtype=bool)
    parts = []
    for part in articulation.parts:
        found = _pieces_in_the_way(part, mesh, label, free, lower, upper)
        free[found] = False
        faces = np.flatnonzero(np.isin(label, found))
        parts.append(part.replace(faces=np.union1d(part.faces, faces)) if len(faces) else part)
    return articulation.replace(parts=tuple(parts))


def _pieces_of_body(is_body: Mask, mesh: WeldedMesh) -> Ints:
    """Return the (F,) connected piece of each face of the body, -1 for others; a fragment may be several."""
    fragment = mesh.fragment_labels
    label = np.where(is_body, fragment, -1)
    count = int(fragment.max(initial=-1)) + 1
    for shared in np.intersect1d(label[label >= 0], fragment[~is_body]).tolist():
        rows = np.flatnonzero(label == shared)
        label[rows] = count + face_components(mesh.faces[rows], len(mesh.points))
        count = int(label.max()) + 1
    return np.unique(label, return_inverse=True)[1].reshape(-1) - int((label < 0).any())


def _pieces_in_the_way(
    part: PartPlan, mesh: WeldedMesh, label: Ints, free: Mask, lower: Floats, upper: Floats
) -> list[int]:
    """Return the free pieces that are in the way of a part; empty if it is neither a door nor a drawer.

    Args:
        label: (F,) piece of each face. free: (N,) whether no part has a piece. lower, upper: (N, 3) corners of pieces.
    """
    way = _way(part, mesh)
    # The view looks from before the front at what comes towards it.
    views = [s for s in SIDES if way is not None and float(-s[2] @ way) >= MIN_COSINE]
    if not views:
        return []
    axes = views[0]
    near, far = (np.sort(np.stack([c @ axes.T for c in (lower, upper)]), axis=0)[k] for k in (0, 1))
    own = mesh.points[mesh.faces[part.faces].reshape(-1)] @ axes.T
    first, last = own.min(axis=0) - TOLERANCE, own.max(axis=0) + TOLERANCE
    inside = free & (near[:, :2] >= first[:2]).all(axis=1) & (far[:, :2] <= last[:2]).all(axis=1)
    inside &= (far[:, 2] >= first[2]) & (far[:, 2] <= last[2])
    if not inside.any():
        return []
    from_behind = render_depth(mesh.points, mesh.faces[part.faces], axes * np.array([[1.0], [1.0], [-1.0]]), WAY_PIXELS)
    rear = float((mesh.points @ axes[2]).max()) - from_behind.depth
    found = []
    for piece in np.flatnonzero(inside).tolist():
        image = render_depth(mesh.points, mesh.faces[label == piece], axes, WAY_PIXELS)
        seen = image.face >= 0
        at = float((mesh.points @ axes[2]).min()) + image.depth[seen]
        if seen.any() and float((rear[seen] > at + TOLERANCE).mean()) >= MIN_BLOCKED_SHARE:
            found.append(piece)
    return found


def _way(part: PartPlan, mesh: WeldedMesh) -> Floats | None:
    """Return the direction in which a front begins to open; None for other parts, and for doors that are no leaf."""
    if part.kind is PartKind.DRAWER and part.joint.kind is JointKind.SLIDE:
        return np.array(part.joint.axis)
    if part.kind is PartKind.DOOR and part.joint.kind is JointKind.HINGE and part.joint.edge is not None:
        extent = np.ptp(mesh.points[mesh.faces[part.faces].reshape(-1)], axis=0)
        return OUT if int(np.argmin(extent)) == int(np.argmax(np.abs(OUT))) else None
    return None


@dataclass(frozen=True)
class InnerPart:
    """Something behind a door that moves: a turntable (`turns`), a drawer (`is_drawer`), or else a rack."""

    fragments: tuple[int, ...]
    turns: bool
    is_drawer: bool
    confidence: float
    reason: str


def find_inner_parts(
    measured: MeasuredFragments, door: Panel, edge: HingeEdge | None, taken: Sequence[int]
) -> list[InnerPart]:
    """Return the drawers and turntables behind a front, and the racks behind one that folds down."""
    lower, upper = corners_from_side(measured, FRONT)
    free = np.ones(measured.count, dtype=bool)
    free[list(taken)] = False
    within = (lower[:, :2] >= door.lower[:2] - 0.03).all(axis=1) & (upper[:, :2] <= door.upper[:2] + 0.03).all(axis=1)
    small = (upper - lower)[:, 1] <= MAX_HEIGHT_SHARE * door.height
    rows = free & within & small & (lower[:, 2] >= door.upper[2] - 0.12)
    surface = MAX_VISIBLE_SHARE * np.maximum(measured.area, 1e-12)
    # A thing without a top or back shows what is in it; what shows elsewhere is a wall.
    covered = (
        measured.visible_area[:, [LEFT, RIGHT, BOTTOM]].sum(axis=1)
        <= MAX_TUB_VISIBLE_SHARE / MAX_VISIBLE_SHARE * surface
    )
    found = []
    gone: set[int] = set()
    for gap in GROUPING_GAPS:
        for group in group_touching(
            lower, upper, [i for i in np.flatnonzero(rows & covered).tolist() if i not in gone], gap
        ):
            if (
                _fills(lower, upper, group, door, MIN_TUB_WIDTH_SHARE)
                and _is_tub(measured, lower, upper, group, door)
                and _has_room(measured, group, door, 0.0)
            ):
                found.append(InnerPart(tuple(group), False, True, 0.7, "a tub behind a front"))
                gone |= set(group)
    for group in _fronted_blocks(lower, upper, np.flatnonzero(rows & covered).tolist(), door):
        if gone.isdisjoint(group) and _has_room(measured, group, door, 0.0):
            found.append(InnerPart(tuple(group), False, True, 0.6, "a block with a front of its own behind a front"))
            gone |= set(group)
    rows &= measured.visible_area.sum(axis=1) <= surface
    rows[sorted(gone)] = False
    for heap in group_touching(lower, upper, np.flatnonzero(rows).tolist()):
        if not _fills(lower, upper, heap, door, MIN_TURNTABLE_WIDTH_SHARE):
            continue
        # With all that lies within its box: tines of a basket need not touch its wires.
        a, b = lower[heap].min(axis=0) - TOUCH_TOLERANCE, upper[heap].max(axis=0) + TOUCH_TOLERANCE
        inside = rows & (lower >= a).all(axis=1) & (upper <= b).all(axis=1)
        group = sorted({*heap, *np.flatnonzero(inside).tolist()})
        tray = _rack(measured, group, edge, door)
        if tray is not None:
            found.append(tray)
            rows[group] = False
    return found


def _fronted_blocks(lower: Floats, upper: Floats, rows: list[int], door: Panel) -> list[list[int]]:
    """Return the drawers that are drawn as blocks: each with a plate at its front that has its outline."""
    size = upper - lower
    found = []
    for i in rows:
        near = float(lower[i, 2] - door.upper[2]) <= MAX_TUB_START_SHARE * float(size[i, 2])
        tall = MIN_TUB_HEIGHT_SHARE * min(size[i, 0], size[i, 2]) <= size[i, 1] <= MAX_HEIGHT_SHARE * door.height
        if not (near and tall and _fills(lower, upper, [i], door, MIN_TUB_WIDTH_SHARE)):
            continue
        others = [
            j
            for j in rows
            if (lower[j, :2] >= lower[i, :2] - OUTLINE_TOLERANCE).all()
            and (upper[j, :2] <= upper[i, :2] + OUTLINE_TOLERANCE).all()
            and -MAX_FRONT_SHARE * size[i, 2] <= upper[j, 2] - lower[i, 2] <= OUTLINE_TOLERANCE
        ]
        if any((size[j, :2] >= size[i, :2] - 2 * OUTLINE_TOLERANCE).all() for j in others):
            found.append(sorted({i, *others}))
    return found


def _fills(lower: Floats, upper: Floats, group: list[int], door: Panel, share: float) -> bool:
    """Return whether a group is wide enough, by a share of its door, and deep enough to be its content."""
    across = upper[group].max(axis=0) - lower[group].min(axis=0)
    return bool(across[0] >= share * door.width and across[2] >= min(0.25, share) * door.width)


def _is_tub(measured: MeasuredFragments, lower: Floats, upper: Floats, group: list[int], door: Panel) -> bool:
    """Return whether a group is a drawer: of solid walls, and starting not far behind the front."""
    across = upper[group].max(axis=0) - lower[group].min(axis=0)
    near = float(lower[group, 2].min() - door.upper[2]) <= MAX_TUB_START_SHARE * float(across[2])
    tall = MIN_TUB_HEIGHT_SHARE * min(across[0], across[2]) <= across[1] <= MAX_HEIGHT_SHARE * door.height
    return bool(near and tall) and view_from_above(measured, group).is_tub


def _rack(measured: MeasuredFragments, group: list[int], edge: HingeEdge | None, door: Panel) -> InnerPart | None:
    """Return a rack or a turntable, or None for neither: boards between the walls do not move."""
    lower, upper = corners_from_side(measured, FRONT)
    across = upper[group].max(axis=0) - lower[group].min(axis=0)
    if across[1] > 0.6 * min(across[0], across[2]):
        return None
    disc = abs(float(across[0] - across[2])) < 0.03 * float(across[0]) and _is_disc(measured, group)
    if not _has_room(measured, group, door, CLEAR_HEIGHT_SHARE):
        return None
    if disc:
        return InnerPart(tuple(group), True, False, 0.7, "a disc behind a door")
    if (
        edge is not HingeEdge.BOTTOM
        or not _fills(lower, upper, group, door, MIN_RACK_WIDTH_SHARE)
        or _is_board(lower, upper, group, measured.count)
        or _lies_on_floor(measured, group, door)
        or view_from_above(measured, group).covered < MIN_RACK_COVER
        or _is_lining(measured, group)
    ):
        return None
    return InnerPart(tuple(group), False, False, 0.6, "a level rack behind a door that folds down")


def _has_room(measured: MeasuredFragments, group: list[int], door: Panel, clear: float) -> bool:
    """Return whether a group could come out once its door is open, with free space above it.

    Args:
        clear: height of that space as a share of the height of the door.
    """
    lower, upper = corners_from_side(measured, FRONT)
    a, b = lower[group].min(axis=0), upper[group].max(axis=0)
    b[1] += clear * door.height
    return _free_share(measured, group, door, a, b) >= MIN_FREE_SHARE


def _lies_on_floor(measured: MeasuredFragments, group: list[int], door: Panel) -> bool:
    """Return whether a group is a thin thing right above the floor of its cavity."""
    lower, upper = corners_from_side(measured, FRONT)
    a, b = lower[group].min(axis=0), upper[group].max(axis=0)
    reach = FLOOR_SHARE * door.height
    if b[1] - a[1] > reach:
        return False
    a[1], b[1] = a[1] - reach, a[1]
    return _free_share(measured, group, door, a, b) < MIN_FREE_SHARE


def _is_lining(measured: MeasuredFragments, group: list[int]) -> bool:
    """Return whether a group meets other surfaces along its left, right and back border, as floors of cavities do."""
    points, faces = measured.mesh.points @ SIDES[FRONT].T, measured.mesh.faces
    mine = np.zeros(len(faces), dtype=bool)
    mine[measured.faces_of(group)] = True
    own = samples_with_faces(points, faces[mine], LINING_SAMPLES)[0]
    lower, upper = own.min(axis=0), own.max(axis=0)
    corners = points[faces]
    near = (corners.min(axis=1) <= upper + BORDER_DEPTH).all(axis=1)
    near &= (corners.max(axis=1) >= lower - BORDER_DEPTH).all(axis=1) & ~mine & (measured.mesh.areas > 0.0)
    if not near.any():
        return False
    around = cKDTree(samples_with_faces(points, faces[near], SURROUNDINGS_SAMPLES)[0])
    for axis, end in ((0, lower[0]), (0, upper[0]), (2, upper[2])):
        border = own[np.abs(own[:, axis] - end) < BORDER_DEPTH]
        if not len(border) or float((around.query(border)[0] < MAX_BORDER_GAP).mean()) < MIN_MEETING_SHARE:
            return False
    return True


def _free_share(measured: MeasuredFragments, group: list[int], door: Panel, lower: Floats, upper: Floats) -> float:
    """Return the share of a rectangle through which one sees the middle of a box, without a door and a group.

    Args:
        lower, upper: (3,) corners of the box in (u, v, w); its outer tenths to the left and right are left out.
    """
    gone = np.zeros(len(measured.label), dtype=bool)
    gone[measured.faces_of([*group, *door.everything, *_inside_door(measured, door)])] = True
    faces = measured.mesh.faces[~gone]
    if not len(faces):
        return 1.0
    image = render_depth(measured.mesh.points, faces, SIDES[FRONT], BEHIND_PIXELS)
    nearest = float((measured.mesh.points @ SIDES[FRONT][2]).min())
    margin = np.array([OPENING_MARGIN * float(upper[0] - lower[0]), 0.0])
    depth = image.window(lower[:2] + margin, upper[:2] - margin) + nearest
    return float((depth > float(lower[2] + upper[2]) / 2).mean())


def _inside_door(measured: MeasuredFragments, door: Panel) -> list[int]:
    """Return the fragments that begin within a door and keep within its outline: its lining, which opens with it."""
    lower, upper = corners_from_side(measured, FRONT)
    begins = (lower[:, 2] >= door.lower[2]) & (lower[:, 2] < door.upper[2] - TOUCH_TOLERANCE)
    shallow = upper[:, 2] - lower[:, 2] <= MAX_LINING_DEPTH * float(upper[:, 2].max() - lower[:, 2].min())
    return [i for i in np.flatnonzero(begins & shallow).tolist() if door.holds(lower[i], upper[i])]


def _is_board(lower: Floats, upper: Floats, group: list[int], count: int) -> bool:
    """Return whether a group is one plate between two walls."""
    a, b = lower[group].min(axis=0), upper[group].max(axis=0)
    plates = [i for i in group if np.prod((upper[i] - lower[i])[[0, 2]]) >= 0.9 * np.prod((b - a)[[0, 2]])]
    others = np.ones(count, dtype=bool)
    others[group] = False
    return len(plates) == 1 and is_shelf(lower, upper, plates[0], others)


def is_shelf(lower: Floats, upper: Floats, plate: int, others: Mask) -> bool:
    """Return whether a level plate lies between two walls among `others`, as shelves, floors and tops do."""
    thick = float((upper - lower)[plate, 1])
    near = (
        others
        & (lower <= upper[plate] + TOUCH_TOLERANCE).all(axis=1)
        & (upper >= lower[plate] - TOUCH_TOLERANCE).all(axis=1)
    )
    walls = near & (upper[:, 1] - lower[:, 1] > 3 * thick)
    left = walls & (upper[:, 0] <= lower[plate, 0] + 2 * TOUCH_TOLERANCE)
    right = walls & (lower[:, 0] >= upper[plate, 0] - 2 * TOUCH_TOLERANCE)
    return bool(left.any() and right.any())


def group_touching(lower: Floats, upper: Floats, rows: list[int], gap: float = 0.004) -> list[list[int]]:
    """Group fragments whose boxes touch, each group ascending; `gap` in diagonals."""
    if not rows:
        return []
    a, b = lower[rows], upper[rows]
    meet = ((a[:, None] <= b[None] + gap) & (a[None] <= b[:, None] + gap)).all(axis=2)
    label = connected_groups(len(rows), *np.nonzero(meet))
    return [[r for r, k in zip(rows, label.tolist(), strict=True) if k == n] for n in range(int(label.max()) + 1)]


def _is_disc(measured: MeasuredFragments, group: Sequence[int]) -> bool:
    """Return whether the outline seen from above is a circle, because its corners are empty."""
    points = measured.points_of(group) @ SIDES[FRONT][[0, 2]].T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.ptp(points, axis=0).max()) / 2
    return bool(np.linalg.norm(points - middle, axis=1).max() <= 1.06 * radius)


def find_drawer_box(mesh: WeldedMesh, flat: Floats, rows: Ints, lower: Floats, upper: Floats) -> Ints:
    """Return the faces of the box behind a front; empty if there is no box.

    The walls of the body face inwards, while a box also has walls that face the body, so that the outermost face that
    faces outwards is the outside of the box. If a box and the body share a wall, the box is as wide as its front there;
    the back is never shared. A space with a roof is the inside of the body, within double walls.

    Args:
        flat: (F, 3) middles of faces as right, up and depth. rows: faces behind the front that nothing outside shows.
        lower, upper: (2,) corners of the front in right and up.
    """
    none = rows[:0]
    if not len(rows):
        return none
    place, area = flat[rows], mesh.areas[rows]
    normals = mesh.normals[rows] @ SIDES[FRONT].T
    first, last = np.quantile(place[:, 2], [0.02, 0.98])
    size = np.append(upper - lower, last - first)
    middle = np.append((lower + upper) / 2, (first + last) / 2)
    low, high = np.append(lower, -np.inf), np.append(upper, np.inf)
    found = []
    walls = np.zeros(len(rows), dtype=bool)
    for axis, sign in WALLS:
        outer = (normals[:, axis] * sign > ALONG_COS) & ((place[:, axis] - middle[axis]) * sign > 0)
        whole = float(np.prod(np.delete(size, axis)))
        found.append(bool(outer.any()) and float(area[outer].sum()) >= MIN_WALL_SHARE * whole)
        if found[-1]:
            walls |= outer & (axis != 1)
            (low if sign < 0 else high)[axis] = _outermost(place[outer, axis] * sign, area[outer]) * sign
    if sum(found) < MIN_WALLS or not (found[2] or found[3]) or size[1] > MAX_HEIGHT_RATIO * size[0]:
        return none
    plan = MAX_ROOF_SHARE * size[0] * size[2]
    above = place[:, 1] > middle[1]
    roof, ceiling = (above & (normals[:, 1] * sign > ALONG_COS) for sign in (1, -1))
    if float(area[roof].sum()) > plan:
        return none
    top = float(upper[1])
    if float(area[ceiling].sum()) > plan:
        top = min(top, -_outermost(-place[ceiling, 1], area[ceiling]))
    heights = (mesh.points[mesh.faces[rows[walls]]] @ SIDES[FRONT][1]).max(axis=1)
    if len(heights) and _outermost(heights, area[walls]) > top - CEILING_GAP:
        return none
    inside = ((place >= low - LAYER_TOLERANCE) & (place <= high + LAYER_TOLERANCE)).all(axis=1)
    if not inside.any():
        return none
    extent = np.ptp(place[inside], axis=0)
    fits = extent[0] >= MIN_WIDTH_SHARE * size[0] and extent[1] >= MIN_HEIGHT_SHARE * size[1]
    return rows[inside] if fits else none


def _outermost(at: Floats, area: Floats) -> float:
    """Return the coordinate beyond which a small share of the area lies."""
    order = np.argsort(-at, kind="stable")
    total = np.cumsum(area[order])
    return float(at[order[np.searchsorted(total, OUTERMOST * total[-1])]])


def find_backing_plates(measured: MeasuredFragments, panel: Panel, taken: set[int]) -> list[int]:
    """Return plates right behind a panel with its outline, as layers of a door; the panel grows by them."""
    lower, upper = corners_from_side(measured, FRONT)
    depth = float(upper[:, 2].max() - lower[:, 2].min())
    found: list[int] = []
    for _ in range(MAX_LAYERS):
        matches = (np.abs(lower[:, :2] - panel.lower[:2]) < LAYER_OUTLINE_TOLERANCE).all(axis=1)
        matches &= (np.abs(upper[:, :2] - panel.upper[:2]) < LAYER_OUTLINE_TOLERANCE).all(axis=1)
        matches &= np.abs(lower[:, 2] - panel.upper[2]) < LAYER_OUTLINE_TOLERANCE
        matches &= upper[:, 2] - lower[:, 2] < MAX_DEPTH_SHARE * depth
        rows = [i for i in np.flatnonzero(matches).tolist() if i not in taken and i not in found]
        rows = [i for i in rows if (measured.render_alone([i], FRONT, 48).face >= 0).mean() >= MIN_LAYER_FILL]
        if not rows:
            break
        found += rows
        panel.upper = np.append(panel.upper[:2], upper[rows, 2].max())
    return found


def find_door_bins(measured: MeasuredFragments, panel: Panel, taken: set[int]) -> list[int]:
    """Return fragments that hang on the back of a panel: shallow, hidden, away from its edges, and touching it."""
    lower, upper = corners_from_side(measured, FRONT)
    size = upper - lower
    hidden = measured.visible_area.sum(axis=1) <= 0.02 * np.maximum(measured.area, 1e-12)
    inset = (lower[:, :2] >= panel.lower[:2] + MIN_EDGE_DISTANCE).all(axis=1)
    inset &= (upper[:, :2] <= panel.upper[:2] - MIN_EDGE_DISTANCE).all(axis=1)
    depth = float(upper[:, 2].max() - lower[:, 2].min())
    # A bin that reaches into the panel hangs on it, though it is deep.
    reaches_in = lower[:, 2] <= panel.upper[2] - BIN_START_SHARE * (panel.upper[2] - panel.lower[2])
    max_depth = np.where(reaches_in, MAX_BIN_DEPTH_SHARE, MAX_DEPTH_SHARE) * depth
    hangs = inset & hidden & (lower[:, 2] >= panel.lower[2]) & (size[:, 2] <= max_depth)
    found: list[int] = []
    edge = float(panel.upper[2])
    rows = [i for i in np.flatnonzero(hangs).tolist() if i not in taken]
    while True:
        hosts = [(panel.lower, np.append(panel.upper[:2], edge)), *((lower[i], upper[i]) for i in found)]
        touching = [
            i
            for i in rows
            if i not in found
            and upper[i, 2] <= edge + max_depth[i]
            and any((lower[i] <= b + 0.003).all() and (upper[i] >= a - 0.003).all() for a, b in hosts)
        ]
        if not touching:
            return sorted(found)
        found += touching
