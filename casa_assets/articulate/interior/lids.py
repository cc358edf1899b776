"""Find the lids of vessels and boxes, and how far they open."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from casa_assets.articulate.controls.controls import has_round_outline
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side, view_from_above
from casa_assets.articulate.segment.orthographic import BACK, FRONT, LEFT, RIGHT, TOP
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.deviation import surface_samples

# Least width of a lid, diagonals, its thickness by its width, and its share of all surface.
MIN_LID_WIDTH, MAX_THICKNESS_BY_WIDTH, MAX_AREA_SHARE = 0.12, 0.5, 0.3
# Share of its square that is visible from above; less under a bail, if it has a knob.
MIN_VISIBLE_SHARE, MIN_VISIBLE_SHARE_UNDER_BAIL = 0.6, 0.2
# Offset of its knob from the middle and size of the knob, by the width of the lid.
MAX_KNOB_OFFSET, MAX_KNOB_WIDTH = 0.12, 0.4
# A vessel has something in the upper quarter of its height over at most this share of its plan.
MAX_COVERED_MOUTH = 0.35
# Directions from a lid to its hinge in order of preference: backwards as of jugs, sides, front.
HINGE_DIRECTIONS = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
HINGE_SIDES = (BACK, RIGHT, LEFT, FRONT)
# Protrusion of a vessel's handle, diagonals, and its height over that of what protrudes elsewhere.
MIN_HANDLE_REACH, MIN_HANDLE_HEIGHT_RATIO = 0.04, 1.3
# A lid that opens so far is open; clearance to other fragments, diagonals; samples of its surface.
OPEN_ANGLE_RAD, CLEARANCE, LID_SAMPLES = 1.2, 0.012, 1500
# Height of the lid of a box by that of the whole; depth to which pieces may overlap at the rim, diagonals; share of the
# surface that crosses the rim, as hinges and locks do; share of the plan that a lid covers.
MAX_LID_HEIGHT, RIM_OVERLAP, MAX_CROSSING, MIN_LID_COVER = 0.5, 0.012, 0.04, 0.85
# Share of a side that its wall fills; margin of the middle of a box, by its size, and share of the surface in the
# middle that may lie in its upper half.
MIN_WALL_SHARE, MIDDLE_INSET, MAX_FILLED_MIDDLE = 0.75, 0.2, 0.1
# A catch of a box: its size, and offset from the middle of its side, diagonals. A pedal is below this share of the rim.
MAX_CATCH_SIZE, MAX_CATCH_OFFSET, PEDAL_HEIGHT = 0.25, 0.05, 0.2
# A pedal sticks out by so much, diagonals.
PEDAL_REACH = 0.02
# The lid of a box rather than the worktop of a cabinet: least height by that of the whole, or most height of the whole
# by its width.
MIN_BOX_LID_HEIGHT, MAX_CHEST_HEIGHT = 0.07, 0.85
# Widest gap between a lid and what it lies on, diagonals.
MAX_GAP = 0.015
# Least height of the lid of a box: a sheet on it is paint, glass or the top of a closed body, diagonals.
MIN_LID_HEIGHT = 0.008


@dataclass(frozen=True)
class Lid:
    """A lid with its hinge.

    Attributes:
        fragments: all of it. knob: those of its knob. lower, upper: corners in the frame.
        way: (3,) level unit direction from its middle to its hinge. opening_angle: how far it opens, rad.
    """

    fragments: list[int]
    knob: list[int]
    lower: Floats
    upper: Floats
    way: Floats
    opening_angle: float

    @property
    def hinge(self) -> tuple[Floats, Floats]:
        """Return the (3,) axis about which a positive rotation lifts it, and a point of it."""
        middle = (self.lower + self.upper) / 2
        return np.cross([0.0, 0.0, 1.0], self.way), middle + self.way * (self.upper - self.lower) / 2


def find_lids(measured: MeasuredFragments, taken: set[int]) -> list[Lid]:
    """Return the lid of an object; empty if it has no lid, or several parts look like one, as burners do."""
    lower, upper = corners_from_side(measured, TOP)
    size = upper - lower
    across = size[:, :2].max(axis=1)
    fits = (
        (across >= MIN_LID_WIDTH)
        & (size[:, :2].min(axis=1) >= across / 1.2)
        & (size[:, 2] <= MAX_THICKNESS_BY_WIDTH * across)
    )
    fits &= measured.area <= MAX_AREA_SHARE * float(measured.area.sum())
    bare = measured.visible_area[:, TOP] / np.maximum(size[:, 0] * size[:, 1], 1e-12)
    fits &= bare >= MIN_VISIBLE_SHARE_UNDER_BAIL
    fits[sorted(taken)] = False
    discs = [i for i in np.flatnonzero(fits).tolist() if has_round_outline(measured, TOP, [i], size[i, :2])]
    if len(discs) != 1:
        return []
    disc = discs[0]
    knob = _knob(lower, upper, disc, across)
    host = _host(lower, upper, disc)
    if host is None or not (knob or (bare[disc] >= MIN_VISIBLE_SHARE and _is_vessel(measured, host))):
        return []
    fragments = [disc, *knob]
    corners = measured.box(fragments)
    held = _handle_side(measured, host, fragments)
    ways = sorted(range(len(HINGE_DIRECTIONS)), key=lambda k: (k != held, k))
    lids = [_opened(measured, Lid(fragments, knob, *corners, HINGE_DIRECTIONS[k], 0.0)) for k in ways]
    wide = [lid for lid in lids if lid.opening_angle >= OPEN_ANGLE_RAD]
    return [wide[0] if wide else max(lids, key=lambda lid: lid.opening_angle)]


def find_box_lid(measured: MeasuredFragments) -> Lid | None:
    """Return the lid of a box: everything above a level plane that ends its walls; None if there is no such plane.

    It is hinged opposite its only catch, grip or pedal, otherwise at the back. Many boxes are modelled as blocks, for
    which a catch is required. The lid of a round box without a catch is screwed on, so None is returned.
    """
    lower, upper = measured.lower.min(axis=0), measured.upper.max(axis=0)
    height = float(upper[2] - lower[2])
    footprint = float((measured.depth_images[TOP].face >= 0).sum()) * measured.depth_images[TOP].pixel ** 2
    total = float(measured.area.sum())
    for rim in np.unique(np.round(measured.lower[:, 2], 4)).tolist():
        crosses = (measured.lower[:, 2] < rim - RIM_OVERLAP) & (measured.upper[:, 2] > rim + RIM_OVERLAP)
        if rim - lower[2] < (1 - MAX_LID_HEIGHT) * height or measured.area[crosses].sum() > MAX_CROSSING * total:
            continue
        above = np.flatnonzero((measured.lower + measured.upper)[:, 2] / 2 > rim)
        below = np.flatnonzero((measured.lower + measured.upper)[:, 2] / 2 <= rim)
        covers = float(measured.visible_area[above, TOP].sum()) >= MIN_LID_COVER * footprint
        if not len(above) or not covers or not _has_walls(measured, below.tolist(), rim):
            continue
        corners = measured.box(above.tolist())
        catches = _sides_with_catch(measured, corners, rim)
        is_held, is_hollow = len(catches) == 1, _is_hollow(measured, below.tolist(), rim)
        if has_round_outline(measured, TOP, above.tolist(), (corners[1] - corners[0])[:2]) and not is_held:
            return None
        if float(corners[1][2]) - rim < MIN_LID_HEIGHT or not (is_hollow or is_held):
            continue
        # The hinge is at the height of the rim, whatever the lid's height is.
        level = np.array([[*corners[0][:2], rim], [*corners[1][:2], rim]])
        way = int(np.argmin(HINGE_DIRECTIONS @ HINGE_DIRECTIONS[catches[0]])) if is_held else 0
        return Lid(above.tolist(), [], level[0], level[1], HINGE_DIRECTIONS[way], np.pi / 2)
    return None


def is_chest(measured: MeasuredFragments, lid: Lid) -> bool:
    """Return whether a box is lower than wide, or its lid higher than a worktop is thick."""
    lower, upper = measured.lower.min(axis=0), measured.upper.max(axis=0)
    size = upper - lower
    high = float(upper[2] - lid.lower[2]) >= MIN_BOX_LID_HEIGHT * float(size[2])
    return high or float(size[2]) <= MAX_CHEST_HEIGHT * float(size[:2].max())


def _sides_with_catch(measured: MeasuredFragments, lid: tuple[Floats, Floats], rim: float) -> list[int]:
    """Return the indices of the directions to the sides of a box that have a pedal, a lock or a grip in their middle.

    Args:
        lid: (3,) lower and upper corner.
    """
    floor = float(measured.lower[:, 2].min())
    small = (measured.upper - measured.lower).max(axis=1) <= MAX_CATCH_SIZE
    is_low = measured.upper[:, 2] < floor + PEDAL_HEIGHT * (rim - floor)
    at_lid = (measured.lower[:, 2] < lid[1][2] - RIM_OVERLAP) & (measured.upper[:, 2] > rim - RIM_OVERLAP)
    foot = measured.points_of(np.flatnonzero(~small).tolist())
    foot = foot[foot[:, 2] < floor + PEDAL_HEIGHT * (rim - floor)]
    found = []
    for k, way in enumerate(HINGE_DIRECTIONS):
        out = measured.lower @ np.minimum(way, 0.0) + measured.upper @ np.maximum(way, 0.0)
        edge = float(lid[0] @ np.minimum(way, 0.0) + lid[1] @ np.maximum(way, 0.0))
        is_pedal = is_low & (out > float((foot @ way).max(initial=-1.0)) + PEDAL_REACH)
        centre = ((measured.lower + measured.upper) - (lid[0] + lid[1])) / 2 @ np.cross(way, [0.0, 0.0, 1.0])
        is_catch = is_pedal | (at_lid & (out > edge - RIM_OVERLAP))
        is_catch &= measured.visible_area[:, HINGE_SIDES[k]] > 0.0
        rows = np.flatnonzero(small & is_catch & (np.abs(centre) < MAX_CATCH_OFFSET)).tolist()
        # What is round from there is a knob or a key.
        lower, upper = corners_from_side(measured, HINGE_SIDES[k])
        if any(not has_round_outline(measured, HINGE_SIDES[k], [i], (upper - lower)[i, :2]) for i in rows):
            found.append(k)
    return found


def _has_walls(measured: MeasuredFragments, below: list[int], rim: float) -> bool:
    """Return whether fragments are walls on all sides up to a rim; small ones, as pedals are, do not count."""
    large = [i for i in below if float((measured.upper - measured.lower)[i].max()) > MAX_CATCH_SIZE]
    if not large:
        return False
    lower, upper = measured.box(large)
    size = np.append((upper - lower)[:2], rim - lower[2])
    seen = {axis: float(measured.visible_area[large, side].sum()) for side, axis in ((FRONT, 0), (LEFT, 1))}
    return all(area >= MIN_WALL_SHARE * size[axis] * size[2] for axis, area in seen.items())


def _is_hollow(measured: MeasuredFragments, below: list[int], rim: float) -> bool:
    """Return whether fragments leave the middle of their upper half empty."""
    lower, upper = measured.box(below)
    size = np.append((upper - lower)[:2], rim - lower[2])
    faces = measured.mesh.faces[measured.faces_of(below)]
    points = surface_samples(measured.mesh.points, faces, LID_SAMPLES)
    inset = MIDDLE_INSET * size[:2]
    middle = ((points[:, :2] > lower[:2] + inset) & (points[:, :2] < upper[:2] - inset)).all(axis=1)
    high = points[:, 2] > lower[2] + size[2] / 2
    return bool(middle.any()) and float(high[middle].mean()) <= MAX_FILLED_MIDDLE


def _handle_side(measured: MeasuredFragments, host: int, lid: list[int]) -> int:
    """Return the index of the direction to a vessel's handle, or away from its spout; backwards by default.

    Of what sticks out at the sides the tallest is the handle; under a bail what sticks out alone is the spout.
    """
    own = [host, *lid]
    floor, rim = float(measured.lower[:, 2].min()), float(measured.box(lid)[0][2])
    low = measured.upper[:, 2] < floor + PEDAL_HEIGHT * (rim - floor)
    ends = [measured.lower @ np.minimum(way, 0.0) + measured.upper @ np.maximum(way, 0.0) for way in HINGE_DIRECTIONS]
    pedals = [k for k, end in enumerate(ends) if (low & (end > end[host] + PEDAL_REACH)).any()]
    if len(pedals) == 1:
        return int(np.argmin(HINGE_DIRECTIONS @ HINGE_DIRECTIONS[pedals[0]]))
    reach = []
    for end in ends:
        out = end - end[host]
        out[own] = 0.0
        rows = np.flatnonzero((out > MIN_HANDLE_REACH) & ~low)
        reach.append(float(measured.upper[rows, 2].max() - measured.lower[rows, 2].min()) if len(rows) else 0.0)
    best = int(np.argmax(reach))
    others = max(r for k, r in enumerate(reach) if k != best)
    if reach[best] <= MIN_HANDLE_HEIGHT_RATIO * others:
        return 0
    lower, upper = measured.box(lid)
    over = (measured.lower[:, :2] < upper[:2]).all(axis=1) & (measured.upper[:, :2] > lower[:2]).all(axis=1)
    over &= measured.upper[:, 2] > upper[2] + MIN_HANDLE_REACH
    over[own] = False
    spout = others == 0.0 and bool(over.any())
    return int(np.argmin(HINGE_DIRECTIONS @ HINGE_DIRECTIONS[best])) if spout else best


def _opened(measured: MeasuredFragments, lid: Lid) -> Lid:
    """Return the lid with the angle to which it opens before it meets what it does not touch when shut."""
    rows = np.zeros(len(measured.label), dtype=bool)
    rows[measured.faces_of(lid.fragments)] = True
    others = ~rows & (measured.label >= 0)
    points, faces = measured.mesh.points, measured.mesh.faces
    own = surface_samples(points, faces[rows], LID_SAMPLES)
    tree = cKDTree(surface_samples(points, faces[others], 8 * LID_SAMPLES))
    own = own[tree.query(own)[0] > CLEARANCE]
    axis, anchor = lid.hinge
    own = own[(anchor - own) @ lid.way > CLEARANCE]
    far = 0.0
    for angle in np.radians(np.arange(5.0, 90.1, 5.0)):
        moved = Rotation.from_rotvec(axis * angle).apply(own - anchor) + anchor
        if len(own) and float(tree.query(moved)[0].min()) < CLEARANCE:
            break
        far = float(angle)
    return replace(lid, opening_angle=far)


def _is_vessel(measured: MeasuredFragments, host: int) -> bool:
    """Return whether a fragment is open at the top and closed all around."""
    size = measured.upper[host] - measured.lower[host]
    closed = all(measured.visible_area[host, s] >= 0.6 * size[a] * size[2] for s, a in ((FRONT, 0), (LEFT, 1)))
    return closed and view_from_above(measured, [host]).lid <= MAX_COVERED_MOUTH


def _knob(lower: Floats, upper: Floats, disc: int, across: Floats) -> list[int]:
    """Return the small fragments in the middle of a disc that rise from it."""
    off = np.linalg.norm((lower + upper)[:, :2] / 2 - (lower + upper)[disc, :2] / 2, axis=1)
    stands = (
        (lower[:, 2] < lower[disc, 2] - 0.01)
        & (upper[:, 2] >= lower[disc, 2] - MAX_GAP)
        & (upper[:, 2] <= upper[disc, 2] + MAX_GAP)
    )
    found = stands & (off <= MAX_KNOB_OFFSET * across[disc]) & (across <= MAX_KNOB_WIDTH * across[disc])
    found[disc] = False
    return [int(i) for i in np.flatnonzero(found)]


def _host(lower: Floats, upper: Floats, disc: int) -> int | None:
    """Return the largest fragment that a disc lies on."""
    under = (lower[:, 2] <= upper[disc, 2] + MAX_GAP) & (upper[:, 2] > upper[disc, 2] + MAX_GAP)
    middle = (lower[disc, :2] + upper[disc, :2]) / 2
    under &= (lower[:, :2] <= middle).all(axis=1) & (upper[:, :2] >= middle).all(axis=1)
    under[disc] = False
    rows = np.flatnonzero(under)
    if not len(rows):
        return None
    footprint = np.prod((upper - lower)[rows, :2], axis=1)
    return int(rows[int(np.argmax(footprint))])
