"""Find what moves with a front though it is hidden: drawer boxes, the layers of a door, bins on its back."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.segment.fragments import FRONT, SIDES, MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.numeric import Floats, Ints

# Drawer boxes ---------------------------------------------------------------------------------------------------------
# Find the box of a drawer inside a shell: surfaces behind a front that look away from its middle.

# A face looks along an axis from this cosine on.
ALONG_COS = 0.9
# Walls of a box that look away from its middle, as axis and sign: left, right, bottom and back.
WALLS = ((0, -1), (0, 1), (1, -1), (2, 1))
# A wall of a box covers this share of what it would at the size of the front and the depth behind it.
MIN_WALL_SHARE = 0.2
# The outermost faces of a wall are this quantile of its area from outside.
OUTERMOST = 0.1
# Faces of a box keep within its walls and this, diagonals.
TOLERANCE = 0.003
# Least number of walls. A box ends so far below the top of its front and a ceiling, diagonals.
MIN_WALLS, CEILING_GAP = 2, 0.008
# Largest roof over a box, as a share of its plan, and height to width of a front above which it is a door.
MAX_ROOF_SHARE, MAX_HEIGHT_RATIO = 0.4, 1.3
# Least width and height of a box as shares of its front.
MIN_WIDTH_SHARE, MIN_HEIGHT_SHARE = 0.6, 0.25


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
    inside = ((place >= low - TOLERANCE) & (place <= high + TOLERANCE)).all(axis=1)
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


# Panel layers ---------------------------------------------------------------------------------------------------------
# Find what moves with a panel though it is hidden: the layers of a door, and bins that hang on its back.

# Depth of layers and bins of a door as a share of the object, and the distance of bins from its edges, diagonals.
MAX_DEPTH_SHARE, MIN_EDGE_DISTANCE = 0.14, 0.008
# A bin that begins so far inside its panel, as a share of the panel's thickness, may be this deep, as a share of the
# object.
BIN_START_SHARE, MAX_BIN_DEPTH_SHARE = 0.25, 0.3
# Layers of a door share its outline within this, diagonals, touch, and fill this share of it, unlike frames.
OUTLINE_TOLERANCE, MIN_LAYER_FILL, MAX_LAYERS = 0.006, 0.8, 3


def find_backing_plates(measured: MeasuredFragments, panel: Panel, taken: set[int]) -> list[int]:
    """Return plates right behind a panel with its outline, as layers of a door; the panel grows by them."""
    lower, upper = corners_from_side(measured, FRONT)
    depth = float(upper[:, 2].max() - lower[:, 2].min())
    found: list[int] = []
    for _ in range(MAX_LAYERS):
        matches = (np.abs(lower[:, :2] - panel.lower[:2]) < OUTLINE_TOLERANCE).all(axis=1)
        matches &= (np.abs(upper[:, :2] - panel.upper[:2]) < OUTLINE_TOLERANCE).all(axis=1)
        matches &= np.abs(lower[:, 2] - panel.upper[2]) < OUTLINE_TOLERANCE
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
