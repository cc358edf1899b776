"""Find panels on a side that may be doors, drawers or control panels, and merge boards that make up one door."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from casa_assets.articulate.controls.controls import depth_around, has_round_outline
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side, view_from_above
from casa_assets.articulate.segment.orthographic import BACK, BOTTOM, FRONT, LEFT, RIGHT, SIDES, TOP, outline_area
from casa_assets.core.numeric import Floats, Mask

# Lengths are in diagonals of the object; (u, v, w) is right, up, and depth as seen from the side.
# Least side of a panel, diagonals, and its least share of the side of the object.
MIN_SIDE, MIN_AREA_SHARE = 0.03, 0.012
# A panel is at least this long, diagonals, or covers this share of the side: smaller ones are knobs.
MIN_LONG_SIDE, MIN_AREA_SHARE_SMALL = 0.12, 0.06
# Thickness at most, by its smaller side and by the depth of the object, unless it is hidden from the other sides.
MAX_THICKNESS_BY_SIDE, MAX_THICKNESS_OF_DEPTH = 0.7, 0.34
# Deepest start of a panel, as a share of the depth of the object; of one with a handle in a niche.
MAX_START_DEPTH, MAX_START_DEPTH_WITH_HANDLE = 0.35, 0.75
# Length to width of a bar, the same of one that touches its panel (bars of voxelised shells are thickened), and its
# distance from the panel, diagonals.
MIN_BAR_RATIO, MIN_STOUT_BAR_RATIO, MIN_BAR_GAP = 4.0, 3.0, 0.008
# A bar: widest; of one that touches its panel the least protrusion (rails of framed doors reach 0.013), and the
# share of its depth that is outside, because a bulging front falls back beside its middle.
MAX_BAR_WIDTH, MIN_BAR_PROTRUSION, MIN_OUTSIDE_SHARE = 0.075, 0.015, 0.5
# Fronts of shallow drawers: least height and length, diagonals; size of a pull by its front, and how far it stands out.
MIN_SMALL_SIDE, MIN_SMALL_LENGTH, MAX_PULL_SHARE, MIN_PULL_PROTRUSION = 0.018, 0.06, 0.5, 0.006
# The sheet of a body round its fronts: its least share of the width and height of the side, its greatest depth in
# diagonals, its surface by its rectangle (holes make it less), and how far a front stands out of it at least.
MIN_SHEET_SHARE, MAX_SHEET_DEPTH, MAX_SHEET_AREA_SHARE, MIN_STEP = 0.85, 0.004, 0.8, 0.004
# Share of a board of the body that each of two plates covers at least where the board is no front.
MIN_COVER_SHARE = 0.12
# Stiles of a frame upon a board: least length, greatest width, as shares of the board; greatest width of a rail by that
# of a stile, and greatest share of the board that all rails cover: drawers between two posts leave nothing free.
MIN_STILE_LENGTH, MAX_STILE_WIDTH, MAX_RAIL_BY_STILE, MAX_RAILED_SHARE = 0.9, 0.36, 2.0, 0.75
# Closed blocks that are drawers: least depth by that of the thing, greatest share of their sides that is seen (they may
# lie within walls), and least share of their front that is seen beside what lies on it.
MIN_BLOCK_DEPTH_SHARE, MAX_BLOCK_ASIDE_SHARE, MIN_BLOCK_SEEN_SHARE = 0.5, 0.35, 0.2
# Such a block is closed where its front is sunk by this share of its depth at most, over this share of it, in a picture
# of this many pixels along the longer side.
MAX_SUNK_SHARE, MIN_CLOSED_SHARE, CLOSED_PIXELS = 0.1, 0.8, 64
# The convex outline of a panel is at least this share of its rectangle: of a round one it is .79, of a triangle .5.
MIN_HULL_SHARE = 0.65
# Fragments within this much of a rectangle lie inside it, diagonals.
INSIDE_TOLERANCE = 0.006
# Fronts that are let into a board begin where it begins, within this, diagonals; panes lie deeper in their frames.
FLUSH_TOLERANCE = 0.004
# Boards of one door begin at the same depth within this, and touch within this; diagonals.
MERGED_FLUSH_TOLERANCE, TOUCH_TOLERANCE = 0.006, 0.006
# Widest stile or rail, as a share of its door.
MAX_STILE_SHARE = 0.26
# Thickest strip that lies upon a door, diagonals.
MAX_STRIP_THICKNESS = 0.05
# Share of the door that its boards cover.
MIN_LEAF_COVERAGE = 0.93
# Shorter side of equal boards from which they are fronts of their own, diagonals.
MIN_LEAF_SIDE = 0.09
# Widest stile of a narrow door, as a share of it, where this many rails run between the stiles.
MAX_BROAD_STILE_SHARE, MIN_RAILS = 0.36, 2
# Boards that are too slim for panels: least width and length, diagonals, and visible share of their rectangle.
MIN_SLAT_WIDTH, MIN_SLAT_LENGTH, MIN_VISIBLE_SHARE = 0.006, 0.025, 0.5
MAX_SLATS = 80
# Thickness of a slat by its width: flat, or square as rails of thin fronts are.
MAX_THICKNESS_BY_WIDTH = 1.1
# The infill of a framed door lies this much deeper than its stiles and meets them within the gap; a door within a frame
# of the body does neither. Diagonals.
MIN_SUNK_DEPTH, MAX_SUNK_GAP = 0.0004, 0.0012


@dataclass
class Panel:
    """One panel of a front, in the closed pose.

    Attributes:
        members: fragments that it consists of, the largest first.
        lower, upper: (3,) corners of those in (u, v, w).
        grips: handles, each a list of fragments. trims: other fragments that move with it. box: fragments of the box
            that it pulls out.
        controls: number of knobs and buttons on it. visible_area: area of its picture.
        attachment_depths: depths at which objects on it begin: a bar may touch it through its feet alone.
        boards: number of panels merged into it. is_recessed: so deep that only a handle makes it a front.
        has_shelf_behind: a shelf of the body is right behind its middle. is_round: a round door, as of a washer.
    """

    members: list[int]
    lower: Floats
    upper: Floats
    grips: list[list[int]] = field(default_factory=list)
    trims: list[int] = field(default_factory=list)
    box: list[int] = field(default_factory=list)
    controls: int = 0
    visible_area: float = 0.0
    attachment_depths: list[float] = field(default_factory=list)
    boards: int = 1
    is_recessed: bool = False
    has_shelf_behind: bool = False
    is_round: bool = False

    @property
    def width(self) -> float:
        """Return its size along u."""
        return float(self.upper[0] - self.lower[0])

    @property
    def height(self) -> float:
        """Return its size along v."""
        return float(self.upper[1] - self.lower[1])

    @property
    def is_deep(self) -> bool:
        """Return whether it is no plate: it reaches farther back than its shorter side is long."""
        return float(self.upper[2] - self.lower[2]) > MAX_THICKNESS_BY_SIDE * min(self.width, self.height)

    @property
    def everything(self) -> list[int]:
        """Return all fragments that move with it, ascending."""
        return sorted({*self.members, *self.trims, *self.box, *(f for g in self.grips for f in g)})

    def holds(self, lower: Floats, upper: Floats, slack: float = INSIDE_TOLERANCE) -> bool:
        """Return whether a box lies within the rectangle of the panel, at any depth."""
        return bool((lower[:2] >= self.lower[:2] - slack).all() and (upper[:2] <= self.upper[:2] + slack).all())


def find_panels(measured: MeasuredFragments, without: Sequence[int] = ()) -> list[Panel]:
    """Return the panels on a side, largest first."""
    lower, upper = corners_from_side(measured, FRONT)
    size = upper - lower
    extent = upper.max(axis=0) - lower.min(axis=0)
    footprint = size[:, 0] * size[:, 1]
    start = lower[:, 2] - lower[:, 2].min()
    is_large = (size[:, :2].min(axis=1) >= MIN_SIDE) & (footprint >= MIN_AREA_SHARE * extent[0] * extent[1])
    is_large &= (size[:, :2].max(axis=1) >= MIN_LONG_SIDE) | (footprint >= MIN_AREA_SHARE_SMALL * extent[0] * extent[1])
    is_plate = size[:, 2] <= MAX_THICKNESS_BY_SIDE * size[:, :2].min(axis=1)
    is_plate &= size[:, 2] <= MAX_THICKNESS_OF_DEPTH * extent[2]
    is_near = start <= MAX_START_DEPTH * extent[2]
    in_niche = is_plate & (start <= MAX_START_DEPTH_WITH_HANDLE * extent[2])
    in_niche &= measured.visible_area[:, FRONT] >= 0.6 * footprint
    candidates = is_large & (is_near | in_niche) & (measured.visible_area[:, FRONT] >= 0.02 * footprint)
    candidates |= _carry_handles(measured, np.flatnonzero(is_plate & is_near & ~is_large).tolist())
    candidates[list(without)] = False
    boxes = _are_drawers(measured, size, extent) | _are_blocks(measured, lower, upper)
    seeds = np.flatnonzero(candidates & (is_plate | boxes))
    order = seeds[np.lexsort((seeds, -footprint[seeds]))]
    groups: list[list[int]] = []
    for i in order.tolist():
        host = next((g for g in groups if _inside(lower, upper, i, g[0]) and _touch(lower, upper, i, g)), None)
        if host is not None and _is_bar(measured, lower, upper, i, host[0]):
            continue
        if host is None:
            groups.append([i])
        else:
            host.append(i)
    plates = [p for g in groups for p in _plates(measured, lower, upper, g)]
    panels = []
    for g in plates:
        near, visible = lower[g].min(axis=0), float(measured.visible_area[g, FRONT].sum())
        is_recessed = float(near[2] - lower[:, 2].min()) > MAX_START_DEPTH * extent[2]
        panels.append(Panel(list(g), near, upper[g].max(axis=0), visible_area=visible, is_recessed=is_recessed))
    return [p for p in panels if p.visible_area >= 0.12 * p.width * p.height and _fills_rectangle(measured, p)]


def _fills_rectangle(measured: MeasuredFragments, panel: Panel) -> bool:
    """Return whether the outline of the largest piece of a panel is about a rectangle, and no triangle of a face."""
    flat = measured.points_of(panel.members[:1]) @ SIDES[FRONT][:2].T
    hull = outline_area(flat)
    return hull > 0.0 and hull >= MIN_HULL_SHARE * float(np.prod(np.ptp(flat, axis=0)))


def _carry_handles(measured: MeasuredFragments, rows: list[int]) -> Mask:
    """Mark, in an (N,) mask of all fragments, those small plates among `rows` that carry a pull.

    They are fronts of shallow drawers. A pull lies within its plate, is much smaller and protrudes; plates of knobs are
    round.
    """
    lower, upper = corners_from_side(measured, FRONT)
    size = upper - lower
    found: Mask = np.zeros(measured.count, dtype=bool)
    for i in rows:
        across = size[i, :2]
        if across.min() < MIN_SMALL_SIDE or across.max() < MIN_SMALL_LENGTH:
            continue
        on = (lower[:, :2] >= lower[i, :2]).all(axis=1) & (upper[:, :2] <= upper[i, :2]).all(axis=1)
        on &= (size[:, :2] <= MAX_PULL_SHARE * across).any(axis=1) & (size[:, :2] <= 0.9 * across).all(axis=1)
        on &= (lower[:, 2] <= lower[i, 2] - MIN_PULL_PROTRUSION) & (upper[:, 2] >= lower[i, 2] - MIN_BAR_GAP)
        on[i] = False
        found[i] = on.any() and not has_round_outline(measured, FRONT, [i], across)
    return found


def _are_drawers(measured: MeasuredFragments, size: Floats, extent: Floats) -> Mask:
    """Mark (N,) deep fragments that are visible on one side only, as a drawer and its box in one fragment are.

    Where the floor or back of the body is missing, only a tub that something covers is a drawer.
    """
    side_area = measured.visible_area[:, [LEFT, RIGHT]].sum(axis=1)
    hidden_side_area = measured.visible_area[:, [BACK, LEFT, RIGHT, BOTTOM]].sum(axis=1)
    wall_area = size[:, 2] * (size[:, 0] + size[:, 1])
    shows_front = measured.visible_area[:, FRONT] >= 0.3 * size[:, 0] * size[:, 1]
    is_narrow = size[:, 0] * size[:, 1] < 0.97 * extent[0] * extent[1]
    is_covered = measured.visible_area[:, TOP] <= 0.05 * size[:, 0] * size[:, 2]
    found: Mask = (
        (side_area <= 0.12 * wall_area)
        & shows_front
        & is_narrow
        & (size[:, 2] > MAX_THICKNESS_BY_SIDE * size[:, :2].min(axis=1))
    )
    for i in np.flatnonzero(found).tolist():
        above = view_from_above(measured, [i])
        found[i] = above.is_box if hidden_side_area[i] <= 0.12 * wall_area[i] else bool(is_covered[i]) and above.is_tub
    return found


def _are_blocks(measured: MeasuredFragments, lower: Floats, upper: Floats) -> Mask:
    """Mark (N,) deep fragments that only the front shows, each of the size of another in its column or row.

    Drawers are drawn so as closed blocks; a single one may be a device that is built in.
    """
    size = upper - lower
    aside = measured.visible_area[:, [BACK, LEFT, RIGHT]].sum(axis=1)
    found: Mask = (
        (size[:, 2] >= MIN_BLOCK_DEPTH_SHARE * float(np.ptp([lower[:, 2].min(), upper[:, 2].max()])))
        & (size[:, 2] > MAX_THICKNESS_BY_SIDE * size[:, :2].min(axis=1))
        & (aside <= MAX_BLOCK_ASIDE_SHARE * size[:, 2] * (size[:, 0] + size[:, 1]))
        & (measured.visible_area[:, FRONT] >= MIN_BLOCK_SEEN_SHARE * size[:, 0] * size[:, 1])
    )
    for i in np.flatnonzero(found).tolist():
        # It closes its rectangle near its front, unlike the lining of a slot or a niche.
        depth = measured.render_alone([i], FRONT, CLOSED_PIXELS).depth
        found[i] = float((depth <= MAX_SUNK_SHARE * float(size[i, 2])).mean()) >= MIN_CLOSED_SHARE
    rows = np.flatnonzero(found)
    corners = np.concatenate([lower[rows], upper[rows]], axis=1)
    alike = (np.abs(size[rows][:, None, :2] - size[rows][None, :, :2]) <= INSIDE_TOLERANCE).all(axis=2)
    in_line = [
        (np.abs(corners[:, None, [k, k + 3]] - corners[None][..., [k, k + 3]]) <= INSIDE_TOLERANCE).all(axis=2)
        for k in (0, 1)
    ]
    mates = alike & (in_line[0] | in_line[1])
    found[rows] = mates.sum(axis=1) > 1
    return found


def _inside(lower: Floats, upper: Floats, inner: int, outer: int) -> bool:
    """Return whether nine tenths of the rectangle of one fragment lie in that of another."""
    a = np.maximum(lower[inner, :2], lower[outer, :2])
    b = np.minimum(upper[inner, :2], upper[outer, :2])
    footprint = float(np.prod(upper[inner, :2] - lower[inner, :2]))
    return bool((b > a).all() and float(np.prod(b - a)) >= 0.9 * footprint)


def _is_bar(measured: MeasuredFragments, lower: Floats, upper: Floats, i: int, host: int) -> bool:
    """Return whether a fragment is a handle: a bar with a gap to its host, or one that protrudes far from it."""
    size = (upper - lower)[i, :2]
    if size.max() < MIN_STOUT_BAR_RATIO * size.min() or size.min() > MAX_BAR_WIDTH:
        return False
    if size.max() >= MIN_BAR_RATIO * size.min() and upper[i, 2] <= lower[host, 2] - MIN_BAR_GAP:
        return True
    # A bulging host falls back beside its middle.
    ground = depth_around(measured.depth_images[FRONT], lower[i], upper[i])[0] + float(lower[:, 2].min())
    protrusion = max(float(lower[host, 2]), min(ground, float(upper[host, 2]))) - float(lower[i, 2])
    return protrusion >= max(MIN_BAR_PROTRUSION, MIN_OUTSIDE_SHARE * float(upper[i, 2] - lower[i, 2]))


def _touch(lower: Floats, upper: Floats, i: int, group: list[int]) -> bool:
    """Return whether a fragment is at most a little before or behind the first of a group."""
    host = group[0]
    return bool(lower[i, 2] <= upper[host, 2] + 0.02 and upper[i, 2] >= lower[host, 2] - 0.04)


def _plates(measured: MeasuredFragments, lower: Floats, upper: Floats, group: list[int]) -> list[list[int]]:
    """Split a group whose first fragment is a board of the body that other plates cover; else return it whole."""
    first = group[0]
    footprint = np.prod(upper[:, :2] - lower[:, :2], axis=1)
    in_front = [
        i
        for i in group[1:]
        if upper[i, 2] <= lower[first, 2] + 0.35 * (upper[first, 2] - lower[first, 2]) + 0.002
        or lower[i, 2] <= lower[first, 2] + FLUSH_TOLERANCE
    ]
    alone = [
        i
        for i in in_front
        if not any(_inside(lower, upper, i, k) for k in in_front if k != i and footprint[k] >= footprint[i])
    ]
    separate = [i for i in alone if footprint[i] >= MIN_COVER_SHARE * footprint[first]]
    filling = [i for i in separate if _fills_hole(measured, lower, upper, i, first)]
    if (
        (len(separate) < 2 and not filling)
        or measured.visible_area[first, FRONT] >= 0.35 * footprint[first]
        or _is_frame(lower[alone, :2], upper[alone, :2], lower[first, :2], upper[first, :2])
    ):
        return [group]
    out: list[list[int]] = [[i] for i in alone]
    for i in group[1:]:
        host = next((g for g in out if i not in g and _inside(lower, upper, i, g[0])), None)
        if host is not None and i not in alone:
            host.append(i)
    return out


def _is_frame(lower: Floats, upper: Floats, board_lower: Floats, board_upper: Floats) -> bool:
    """Return whether plates are the stiles and rails of a frame along the border of a board, which fills it.

    Args:
        lower, upper: (N, 2) corners of the plates in (u, v). board_lower, board_upper: (2,) those of the board.
    """
    size, whole = upper - lower, board_upper - board_lower
    for across in (0, 1):
        along = 1 - across
        slim = size[:, along] >= MIN_STILE_LENGTH * whole[along]
        slim &= size[:, across] <= MAX_STILE_WIDTH * whole[across]
        first = np.flatnonzero(slim & (lower[:, across] <= board_lower[across] + INSIDE_TOLERANCE))
        last = np.flatnonzero(slim & (upper[:, across] >= board_upper[across] - INSIDE_TOLERANCE))
        if not len(first) or not len(last):
            continue
        a, b = float(upper[first[0], across]), float(lower[last[0], across])
        width = MAX_RAIL_BY_STILE * float(max(size[first[0], across], size[last[0], across]))
        rails = (np.abs(lower[:, across] - a) <= INSIDE_TOLERANCE) & (np.abs(upper[:, across] - b) <= INSIDE_TOLERANCE)
        rails &= size[:, along] <= width
        at_start = (rails & (lower[:, along] <= board_lower[along] + INSIDE_TOLERANCE)).any()
        at_end = (rails & (upper[:, along] >= board_upper[along] - INSIDE_TOLERANCE)).any()
        if at_start and at_end and float(size[rails, along].sum()) <= MAX_RAILED_SHARE * float(whole[along]):
            return True
    return False


def _fills_hole(measured: MeasuredFragments, lower: Floats, upper: Floats, i: int, sheet: int) -> bool:
    """Return whether a fragment closes a hole in a sheet that is the whole front of the body, and protrudes from it."""
    size = upper[sheet, :2] - lower[sheet, :2]
    whole = (upper.max(axis=0) - lower.min(axis=0))[:2]
    is_flat = float(upper[sheet, 2] - lower[sheet, 2]) <= MAX_SHEET_DEPTH
    has_holes = measured.area[sheet] <= MAX_SHEET_AREA_SHARE * float(np.prod(size))
    stands_out = lower[i, 2] <= lower[sheet, 2] - MIN_STEP
    return is_flat and has_holes and bool(stands_out) and bool((size >= MIN_SHEET_SHARE * whole).all())


def merge_framed_panels(panels: list[Panel], handle_spots: list[Floats], slats: list[Panel]) -> list[Panel]:
    """Merge the boards of each framed door into one panel.

    Args:
        handle_spots: (2,) middles in (u, v) of things that look like handles.
        slats: boards that are too slim to be panels: they may be part of one, and are left out otherwise.
    """
    remaining = [*panels, *slats]
    while True:
        boards = _smallest_framed_door(remaining, handle_spots)
        if boards is None:
            slat_ids = {id(p) for p in slats}
            return sorted(
                (p for p in remaining if id(p) not in slat_ids), key=lambda p: (-p.width * p.height, p.members[0])
            )
        remaining = [p for p in remaining if not any(p is q for q in boards)] + [_merge(boards)]


def _merge(panels: list[Panel]) -> Panel:
    return Panel(
        members=[f for p in panels for f in p.members],
        lower=np.min([p.lower for p in panels], axis=0),
        upper=np.max([p.upper for p in panels], axis=0),
        visible_area=sum(p.visible_area for p in panels),
        boards=sum(p.boards for p in panels),
        is_recessed=any(p.is_recessed for p in panels),
    )


def find_slats(measured: MeasuredFragments, panels: list[Panel]) -> list[Panel]:
    """Return flat boards on a side that are too slim to be panels, largest first."""
    lower, upper = corners_from_side(measured, FRONT)
    size = upper - lower
    footprint = size[:, 0] * size[:, 1]
    is_slat = (size[:, :2].min(axis=1) >= MIN_SLAT_WIDTH) & (size[:, :2].max(axis=1) >= MIN_SLAT_LENGTH)
    is_slat &= size[:, 2] < MAX_STRIP_THICKNESS
    is_slat &= size[:, 2] <= MAX_THICKNESS_BY_WIDTH * size[:, :2].min(axis=1)
    is_slat &= measured.visible_area[:, FRONT] >= MIN_VISIBLE_SHARE * footprint
    is_slat[[f for p in panels for f in p.members]] = False
    rows = np.flatnonzero(is_slat)
    order = rows[np.lexsort((rows, -footprint[rows]))][:MAX_SLATS].tolist()
    return [Panel([i], lower[i], upper[i], visible_area=float(measured.visible_area[i, FRONT])) for i in order]


def merge_bridged_panels(measured: MeasuredFragments, panels: list[Panel]) -> list[Panel]:
    """Merge neighbouring panels where a stile lies across the border between them."""
    lower, upper = corners_from_side(measured, FRONT)
    size = upper - lower
    is_stile = size[:, :2].max(axis=1) > 4 * size[:, :2].min(axis=1)
    is_stile &= (size[:, 2] < MAX_STRIP_THICKNESS) & (measured.visible_area[:, FRONT] > 0)
    is_stile[[f for p in panels for f in p.members]] = False
    stiles = np.flatnonzero(is_stile).tolist()
    remaining = list(panels)
    while True:
        pairs = combinations(remaining, 2)
        pair = next(([a, b] for a, b in pairs if any(_bridges(lower[i], upper[i], a, b) for i in stiles)), None)
        if pair is None:
            return remaining
        remaining = [p for p in remaining if p is not pair[0] and p is not pair[1]] + [_merge(pair)]


def _bridges(lower: Floats, upper: Floats, a: Panel, b: Panel) -> bool:
    """Return whether a strip lies upon two flush panels, along most of both."""
    along = int(np.argmax((upper - lower)[:2]))
    across = 1 - along
    ends = abs(float(a.lower[across] - b.lower[across])), abs(float(a.upper[across] - b.upper[across]))
    is_flush = abs(float(a.lower[2] - b.lower[2])) < MERGED_FLUSH_TOLERANCE and max(ends) < TOUCH_TOLERANCE
    gap = max(float(a.lower[along]), float(b.lower[along])) - min(float(a.upper[along]), float(b.upper[along]))
    if not is_flush or abs(gap) > TOUCH_TOLERANCE:
        return False
    for p in (a, b):
        is_upon = lower[2] < p.lower[2] - 0.002 and upper[2] >= p.lower[2] - 0.001
        is_within = (
            lower[across] >= p.lower[across] - TOUCH_TOLERANCE and upper[across] <= p.upper[across] + TOUCH_TOLERANCE
        )
        length = float(min(upper[along], p.upper[along]) - max(lower[along], p.lower[along]))
        if not (is_upon and is_within and length >= 0.6 * float(p.upper[along] - p.lower[along])):
            return False
    return True


def _smallest_framed_door(panels: list[Panel], handle_spots: list[Floats]) -> list[Panel] | None:
    """Return the boards of the smallest door that two of the panels frame, or None."""
    best: tuple[float, list[Panel]] | None = None
    for a, b in combinations(panels, 2):
        for along in (0, 1):
            if not _are_stiles(a, b, along):
                continue
            lower, upper = np.minimum(a.lower, b.lower), np.maximum(a.upper, b.upper)
            area = float(np.prod((upper - lower)[:2]))
            if best is not None and area >= best[0]:
                continue
            inner = [p for p in panels if _within(p, lower, upper)]
            if len(inner) >= 3 and _fills_door(inner, lower, upper, area, handle_spots, (a, b)):
                best = (area, inner)
    return best[1] if best else None


def _are_stiles(a: Panel, b: Panel, along: int) -> bool:
    """Return whether two panels are parallel boards of equal length on two sides; `along` is their long axis."""
    across = 1 - along
    length_a, length_b = float(a.upper[along] - a.lower[along]), float(b.upper[along] - b.lower[along])
    width_a, width_b = float(a.upper[across] - a.lower[across]), float(b.upper[across] - b.lower[across])
    ends = abs(float(a.lower[along] - b.lower[along])), abs(float(a.upper[along] - b.upper[along]))
    span = max(float(a.upper[across]), float(b.upper[across])) - min(float(a.lower[across]), float(b.lower[across]))
    is_slim = max(width_a, width_b) < min(MAX_BROAD_STILE_SHARE * span, 0.8 * min(length_a, length_b))
    return max(ends) < TOUCH_TOLERANCE and is_slim and abs(float(a.lower[2] - b.lower[2])) < MERGED_FLUSH_TOLERANCE


def _within(panel: Panel, lower: Floats, upper: Floats) -> bool:
    """Return whether a panel lies in a rectangle and at about its depth."""
    inside = (panel.lower[:2] >= lower[:2] - TOUCH_TOLERANCE).all()
    inside = inside and (panel.upper[:2] <= upper[:2] + TOUCH_TOLERANCE).all()
    return bool(inside and lower[2] - MERGED_FLUSH_TOLERANCE <= panel.lower[2] <= upper[2] + 0.02)


def _fills_door(
    inner: list[Panel],
    lower: Floats,
    upper: Floats,
    area: float,
    handle_spots: list[Floats],
    frame: tuple[Panel, Panel],
) -> bool:
    """Return whether boards fill a rectangle, and the boards inside their frame have no separate handle."""
    covered = sum(p.width * p.height for p in inner)
    size = np.array([[p.width, p.height] for p in inner])
    if bool((np.ptp(size, axis=0) < TOUCH_TOLERANCE).all() and size.min() >= MIN_LEAF_SIDE):
        return False
    across = 1 - _along(frame)
    width = max(float((p.upper - p.lower)[across]) for p in frame)
    if covered < MIN_LEAF_COVERAGE * area or not (
        width < MAX_STILE_SHARE * float((upper - lower)[across]) or _has_rails(inner, frame)
    ):
        return False
    for p in inner:
        is_slim = min(p.width, p.height) < MAX_STILE_SHARE * float(min((upper - lower)[:2]))
        if p is frame[0] or p is frame[1] or is_slim or p.boards > 1 or _is_recessed_infill(p, frame):
            continue
        if any(((g >= p.lower[:2]) & (g <= p.upper[:2])).all() for g in handle_spots):
            return False
    handles = sum(any(((g >= p.lower[:2]) & (g <= p.upper[:2])).all() for g in handle_spots) for p in inner)
    return handles <= 1


def _has_rails(inner: list[Panel], frame: tuple[Panel, Panel]) -> bool:
    """Return whether boards run between two stiles, from one to the other, at both ends of them."""
    along = _along(frame)
    across = 1 - along
    first, last = sorted(frame, key=lambda p: float(p.lower[across]))
    rails = [
        p
        for p in inner
        if p is not first
        and p is not last
        and abs(float(p.lower[across] - first.upper[across])) < TOUCH_TOLERANCE
        and abs(float(last.lower[across] - p.upper[across])) < TOUCH_TOLERANCE
        and abs(float(p.lower[2] - first.lower[2])) < MERGED_FLUSH_TOLERANCE
    ]
    lower, upper = float(first.lower[along]), float(first.upper[along])
    has_end = [any(abs(float(p.lower[along]) - lower) < TOUCH_TOLERANCE for p in rails)]
    has_end += [any(abs(float(p.upper[along]) - upper) < TOUCH_TOLERANCE for p in rails)]
    is_plain = all(p.boards == 1 for p in frame)
    return is_plain and sum(p.boards for p in rails) >= MIN_RAILS and all(has_end)


def _along(frame: tuple[Panel, Panel]) -> int:
    """Return the axis along which two stiles run: the one on which they begin at the same place."""
    return int(np.argmin(np.abs(frame[0].lower - frame[1].lower)[:2]))


def _is_recessed_infill(panel: Panel, frame: tuple[Panel, Panel]) -> bool:
    """Return whether a panel lies a little deeper than two stiles and meets both."""
    across = 1 - _along(frame)
    first, last = sorted(frame, key=lambda p: float(p.lower[across]))
    gaps = float(panel.lower[across] - first.upper[across]), float(last.lower[across] - panel.upper[across])
    return max(gaps) <= MAX_SUNK_GAP and float(panel.lower[2]) >= max(float(p.lower[2]) for p in frame) + MIN_SUNK_DEPTH
