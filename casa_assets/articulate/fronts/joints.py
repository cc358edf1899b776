"""Decide how a front opens (drawer, hinged or sliding door), by its form, its handle and neighbours, and its kind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.controls.controls import Control
from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.plan import HingeEdge, JointPlan, hinge, to_vec3
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import FRONT, SIDES
from casa_assets.core.numeric import Floats

EDGES = (HingeEdge.LEFT, HingeEdge.RIGHT, HingeEdge.BOTTOM, HingeEdge.TOP)
# Axis of (u, v) across which an edge lies, and the way from the edge to the one that opens.
_ACROSS = {HingeEdge.LEFT: (0, 1.0), HingeEdge.RIGHT: (0, -1.0), HingeEdge.BOTTOM: (1, 1.0), HingeEdge.TOP: (1, -1.0)}
# Features of an edge and of a drawer, in the order in which they are computed: the weight of each in the log odds, and
# what it says where it decides. `beyond` is beside the edge that opens, `at` beside the hinge. Ref: logistic regression
# over the articulation bench and drawn furniture and appliances, as they are and as shells (benchmarks/train/hinges.py,
# which states the bounds that four weights of a drawer lie on by choice).
EDGE_TABLE: Mapping[str, tuple[float, str]] = {
    "handle_away": (8.65, "its handle is at the other side"),
    "handle_along": (1.08, "its handle runs along that edge"),
    "handle_long": (0.0, "its handle runs along that edge"),
    "far_and_along": (1.21, "a bar at the other side"),
    "wide": (3.11, "by its proportions"),
    "wide_without_handle": (-1.45, "by its proportions"),
    "alone_and_wide": (-0.0189, "one front as wide as the thing"),
    "front_beyond": (1.59, "another front beside it"),
    "front_at": (0.0, "another front beside it"),
    "panel_beyond": (0.173, "a panel that stays beside it"),
    "panel_at": (0.0, "a panel that stays beside it"),
    "controls_beyond": (0.483, "the controls are at the other side"),
    "controls_at": (-0.86, "the controls are at the other side"),
    "room_beyond": (1.96, "by its place on the front"),
    "others_away": (0.0, "as the fronts above or below it"),
    "knobs_away": (3.28, "its knob is at the other side"),
    "handle_off_middle": (-4.68, "its handle is off its middle"),
    "front_over_or_under": (0.0, "another front above or below it"),
    "handles_face": (-4.34, "its handle is next to that of another front"),
}
DRAWER_TABLE: Mapping[str, tuple[float, str]] = {
    "constant": (0.247, "by its form"),
    "deep": (5.61, "it is deep, and seen from its front alone"),
    "box": (7.04, "a box behind it goes with it"),
    "shelf_behind": (-2.0, "a shelf behind it leaves no room for a box"),
    "wide": (0.914, "by its proportions"),
    "height_share": (-4.91, "by its height"),
    "covers_front": (-0.0195, "it closes the front"),
    "handle_aside": (-2.41, "its handle is at one side"),
    "handle_upright": (-1.5, "its handle is upright"),
    "handle_level": (1.61, "a level handle in its middle"),
    "handle_low": (-0.655, "its handle is at its lower edge"),
    "handle_centred": (2.0, "its handle is in its middle"),
    "no_handle": (0.308, "by its form"),
    "stacked": (0.0, "it is one of several above each other"),
    "many_stacked": (2.62, "it is one of several above each other"),
    "alike": (0.929, "it is one of several alike"),
    "under_larger": (0.0, "it lies under a larger front"),
    "over_larger": (1.4, "it lies above a larger front"),
    "under_pair": (2.0, "it is as wide as the two fronts above it together"),
    "low_beside_larger": (1.5, "it is low and lies over or under a larger front"),
    "level_and_centred": (0.17, "a level handle in its middle"),
    "centred_beside_aside": (0.858, "its handle is in its middle, those of others are at a side"),
    "others_have_boxes": (-2.66, "boxes go with other fronts, none with it"),
}
EDGE_FEATURES, DRAWER_FEATURES = tuple(EDGE_TABLE), tuple(DRAWER_TABLE)
EDGE_WEIGHTS, DRAWER_WEIGHTS = (np.array([w for w, _ in t.values()]) for t in (EDGE_TABLE, DRAWER_TABLE))
# A front or its box that reaches back farther than this share of the thing is deep.
MIN_DEEP_SHARE, MIN_BOX_SHARE = 0.34, 0.3
# Logarithms of proportions are capped at this; counts of neighbours at this.
MAX_LOG_RATIO, MAX_NEIGHBOURS = 1.5, 4
# Fronts above each other that make a stack.
MIN_STACK = 3
# Neighbours share this much of the shorter one's edge; widest gap, and overlap, between them, diagonals.
MIN_SHARED_EDGE, MAX_GAP = 0.5, 0.05
# Fronts of one column, or of one size, differ by less, diagonals.
SAME_PLACE = 0.015
# A handle is aside where it is farther from the middle than this share of the width; it is centred where it is nearer
# than this share of width and height.
ASIDE, CENTRED = 0.12, 0.15
# Width to height of a drawer under a pair of doors at least: an oven in a cupboard is nearly square.
MIN_WIDE_RATIO = 1.4
# Width to height of a low front.
MIN_LOW_RATIO = 2.0
# Handles of two fronts face each other where both are so far from the middle, by the height of their fronts.
FACING = 0.2
# A sliding door is one in a niche wider than itself, with its handle where a hinge would not want it. For all others
# the log odds from the kind of the object and those from the form of the front are added.
# Beside a sliding door the niche is open for this share of its width, and this much deeper than the door, diagonals.
MIN_OPEN_SHARE, MIN_NICHE_DEPTH = 0.85, 0.02
# The rail that it slides on lies at most this far behind the door, diagonals.
FRAME_TOLERANCE = 0.006
# Distance of the handle from the edge that a hinged door would open at, by the width.
MIN_HANDLE_OFFSET = 0.3
# Distance of the hinge line from the back of a door, as a share of its depth. Ref: the articulation bench
# (docs/numbers.md), which also scores this: its 67 hinged doors have a median of 0.13 and
# quartiles of 0.00 and 0.34.
HINGE_DEPTH_SHARE = 0.15
# Travel of a drawer as a share of its depth. Ref: the 57 drawers of the same bench have a median of 0.82.
DRAWER_TRAVEL_SHARE = 0.81
DOOR_RANGE_RAD = math.pi / 2
# At most this many fronts of a thing speak for its kind.
MAX_SPEAKING_FRONTS = 3
# How often a thing of a kind without habits has what looks like a door or drawer.
SHARE_WITH_FRONTS = 0.05
# No guess is surer than this.
MAX_CONFIDENCE = 0.97


@dataclass(frozen=True)
class Habits:
    """Shares of the doors of a kind that hinge at each edge, and share of its fronts that are drawers."""

    left: float
    right: float
    bottom: float
    top: float
    drawers: float


# Set from what makers list and from safety standards (doors of ovens and dishwashers fold down; microwaves carry their
# controls at the right and hinge at the left; loaders of washing machines hinge at the left), rounded, and never below
# one in a hundred.
HABITS: Mapping[str, Habits] = {
    "microwave": Habits(0.86, 0.02, 0.1, 0.02, 0.03),
    "toaster_oven": Habits(0.03, 0.02, 0.94, 0.01, 0.04),
    "wall_oven": Habits(0.05, 0.03, 0.91, 0.01, 0.05),
    "range": Habits(0.03, 0.03, 0.93, 0.01, 0.3),
    "dishwasher": Habits(0.01, 0.01, 0.97, 0.01, 0.04),
    "refrigerator": Habits(0.45, 0.52, 0.02, 0.01, 0.2),
    "base_cabinet": Habits(0.48, 0.48, 0.02, 0.02, 0.4),
    "wall_cabinet": Habits(0.43, 0.43, 0.02, 0.12, 0.03),
    "tall_cabinet": Habits(0.49, 0.49, 0.01, 0.01, 0.15),
    "drawer_stack": Habits(0.45, 0.45, 0.05, 0.05, 0.95),
    "sink_base": Habits(0.49, 0.49, 0.01, 0.01, 0.2),
    "island_base": Habits(0.49, 0.49, 0.01, 0.01, 0.45),
    "washing_machine": Habits(0.93, 0.05, 0.01, 0.01, 0.4),
    "dryer": Habits(0.45, 0.49, 0.05, 0.01, 0.1),
    "safe": Habits(0.46, 0.5, 0.03, 0.01, 0.02),
    "desk": Habits(0.45, 0.45, 0.05, 0.05, 0.85),
    "table": Habits(0.4, 0.4, 0.1, 0.1, 0.9),
    "nightstand": Habits(0.47, 0.47, 0.04, 0.02, 0.8),
    "wardrobe": Habits(0.49, 0.49, 0.01, 0.01, 0.3),
}
# Of what has no habits of its own.
ANY_HABITS = Habits(0.4, 0.36, 0.18, 0.06, 0.3)


def edge_shares(kinds: Mapping[str, float]) -> Floats:
    """Return the (4,) probabilities of a hinge at the left, right, bottom and top of a door.

    Args:
        kinds: probability of each kind that the thing may be; the rest of 1 is any thing.
    """
    rows = [(p, HABITS.get(kind, ANY_HABITS)) for kind, p in kinds.items()]
    rows.append((max(0.0, 1.0 - sum(kinds.values())), ANY_HABITS))
    shares = sum(p * np.array([h.left, h.right, h.bottom, h.top]) for p, h in rows)
    return np.asarray(shares) / np.sum(shares)


def drawer_share(kinds: Mapping[str, float]) -> float:
    """Return the probability that a front is a drawer; `kinds` as for `edge_shares`."""
    rest = max(0.0, 1.0 - sum(kinds.values()))
    share = sum(p * HABITS.get(kind, ANY_HABITS).drawers for kind, p in kinds.items()) + rest * ANY_HABITS.drawers
    return float(share / (sum(kinds.values()) + rest))


def share_with_fronts(kinds: Mapping[str, float]) -> float:
    """Return the probability that a thing is of a kind that has doors or drawers on its front."""
    return sum(p for kind, p in kinds.items() if kind in HABITS)


@dataclass(frozen=True)
class PanelHandle:
    """The handle of a panel, from all its grips: middle relative to the panel 0..1, size in diagonals; (u, v)."""

    middle: Floats
    size: Floats

    @property
    def is_level(self) -> bool:
        """Return whether it is wider than high."""
        return bool(self.size[0] > 1.5 * self.size[1])

    @property
    def is_upright(self) -> bool:
        """Return whether it is higher than wide."""
        return bool(self.size[1] > 1.5 * self.size[0])


@dataclass(frozen=True)
class FrontView:
    """A front and the other panels and controls on its side.

    Attributes:
        handle: of the front, None if it has no handle. box_depth: how far its box reaches behind it, or the box of
            another front of the same size and with such a handle in its column, diagonals.
        others_box_depth: how far the deepest box of the other fronts reaches behind its front, diagonals.
        lower, upper: (3,) corners of the whole object in (u, v, w).
        fronts: panels that open, this one included. handles: of those, in the same order.
        still: panels that do not open. controls: (C, 2) middles of knobs and keys that are not handles.
        knobs: (K, 2) middles of the round controls on this front.
    """

    panel: Panel
    handle: PanelHandle | None
    box_depth: float
    others_box_depth: float
    lower: Floats
    upper: Floats
    fronts: Sequence[Panel]
    handles: Sequence[PanelHandle | None]
    still: Sequence[Panel]
    controls: Floats
    knobs: Floats

    @property
    def extent(self) -> Floats:
        """Return the (3,) size of the whole thing."""
        return self.upper - self.lower

    @property
    def others(self) -> list[Panel]:
        """Return the other panels that open."""
        return [p for p in self.fronts if p is not self.panel]

    @property
    def controls_beside(self) -> float:
        """Return the share of the controls that lie to its left or right."""
        if not len(self.controls):
            return 0.0
        u = self.controls[:, 0]
        return float(((u > self.panel.upper[0]) | (u < self.panel.lower[0])).mean())

    @property
    def log_ratio(self) -> float:
        """Return the logarithm of its width by its height, capped."""
        ratio = math.log(max(self.panel.width, 1e-9) / max(self.panel.height, 1e-9))
        return float(np.clip(ratio, -MAX_LOG_RATIO, MAX_LOG_RATIO))


def view_fronts(
    measured: MeasuredFragments, fronts: Sequence[Panel], panels: Sequence[Panel], controls: Sequence[Control]
) -> list[FrontView]:
    """Return a view of each front of a side, in their order."""
    lower, upper = corners_from_side(measured, FRONT)
    handles = [panel_handle(p, lower, upper) for p in fronts]
    still = [p for p in panels if not any(p is f for f in fronts)]
    middles = np.array([c.middle for c in controls]).reshape(-1, 2)
    depths = [max((float(upper[i, 2] - p.upper[2]) for i in p.box), default=0.0) for p in fronts]
    return [
        FrontView(
            panel=p,
            handle=h,
            box_depth=max(
                d for o, g, d in zip(fronts, handles, depths, strict=True) if o is p or _are_twins(o, p, g, h)
            ),
            others_box_depth=max((d for o, d in zip(fronts, depths, strict=True) if o is not p), default=0.0),
            lower=lower.min(axis=0),
            upper=upper.max(axis=0),
            fronts=fronts,
            handles=handles,
            still=still,
            controls=middles,
            knobs=np.array([c.middle for c in controls if c.is_round and p.holds(c.lower, c.upper)]).reshape(-1, 2),
        )
        for p, h in zip(fronts, handles, strict=True)
    ]


def panel_handle(panel: Panel, lower: Floats, upper: Floats) -> PanelHandle | None:
    """Return the handle of a panel: the grips that protrude at least 0.6 times as far as the farthest; None if bare."""
    if not panel.grips:
        return None
    out = [float(panel.lower[2] - lower[g, 2].min()) for g in panel.grips]
    chosen = [i for g, s in zip(panel.grips, out, strict=True) if s >= 0.6 * max(out) for i in g]
    a, b = lower[chosen, :2].min(axis=0), upper[chosen, :2].max(axis=0)
    size = np.array([panel.width, panel.height])
    return PanelHandle(((a + b) / 2 - panel.lower[:2]) / size, b - a)


def edge_features(view: FrontView) -> Floats:
    """Return the (4, len(EDGE_FEATURES)) numbers that speak for each of EDGES as the hinge of a front."""
    return np.array([_edge(view, edge) for edge in EDGES])


def _edge(view: FrontView, edge: HingeEdge) -> list[float]:
    axis, way = _ACROSS[edge]
    panel, level = view.panel, axis == 1
    away, along, long = _handle(view.panel, view.handle, axis, way)
    share = panel.width * panel.height / max(float(view.extent[0] * view.extent[1]), 1e-12)
    size = max(float(panel.upper[axis] - panel.lower[axis]), 1e-9)
    is_by_knob = view.handle is None and len(view.knobs) == 1
    alone = not any(o.width * o.height > 0.3 * panel.width * panel.height for o in view.others)
    fronts = _beside(panel, view.others, axis, way)
    still = _beside(panel, view.still, axis, way)
    controls = _controls(panel, view.controls, axis, way)
    room = [float(panel.lower[axis] - view.lower[axis]), float(view.upper[axis] - panel.upper[axis])]
    mates = [
        _handle(p, h, axis, way)[0]
        for p, h in zip(view.fronts, view.handles, strict=True)
        if h is not None and p is not panel and not level and _in_column(p, panel)
    ]
    return [
        away,
        along,
        long,
        max(away, 0.0) * max(along, 0.0),
        view.log_ratio if level else 0.0,
        view.log_ratio if level and view.handle is None else 0.0,
        share if level and alone and panel.width > 0.8 * view.extent[0] else 0.0,
        0.0 if level else fronts[0],
        0.0 if level else fronts[1],
        still[0],
        still[1],
        controls[0],
        controls[1],
        way * (room[1] - room[0]) / max(float(view.extent[axis]), 1e-9),
        float(np.mean(mates)) if mates and view.handle is None else 0.0,
        # How far the one knob is on the side that opens, -0.5..0.5.
        float(way * ((view.knobs[0, axis] - panel.lower[axis]) / size - 0.5)) if is_by_knob else 0.0,
        abs(float(view.handle.middle[0]) - 0.5) if level and view.handle is not None else 0.0,
        max(fronts) if level else 0.0,
        float(level and _handles_face(view)),
    ]


def _handles_face(view: FrontView) -> bool:
    """Return whether the handle of a front and that of one above or below it lie at the edges between them."""
    if view.handle is None:
        return False
    high = float(view.handle.middle[1]) - 0.5
    for other, handle in zip(view.fronts, view.handles, strict=True):
        if other is view.panel or handle is None or not _in_column(other, view.panel):
            continue
        above = float(other.lower[1]) >= float(view.panel.upper[1]) - SAME_PLACE
        towards, back = (high, 0.5 - float(handle.middle[1])) if above else (-high, float(handle.middle[1]) - 0.5)
        if min(towards, back) >= FACING:
            return True
    return False


def _handle(panel: Panel, handle: PanelHandle | None, axis: int, way: float) -> tuple[float, float, float]:
    """Return how far a handle is on the side that opens (-0.5..0.5), whether it runs along the edge, how long it is."""
    if handle is None:
        return 0.0, 0.0, 0.0
    away = float(np.clip(way * (handle.middle[axis] - 0.5), -0.5, 0.5))
    ratio = float(handle.size[1 - axis]) / max(float(handle.size[axis]), 1e-9)
    along = float(np.clip(math.log(max(ratio, 1e-6)) / math.log(4.0), -1.0, 1.0))
    edge = panel.height if axis == 0 else panel.width
    long = min(1.0, float(handle.size[1 - axis]) / max(edge, 1e-9)) if along > 0 else 0.0
    return away, along, long


def _beside(panel: Panel, others: Sequence[Panel], axis: int, way: float) -> tuple[float, float]:
    """Return whether a panel lies right beyond the edge that opens, and right at the hinge."""
    found = [0.0, 0.0]
    along = 1 - axis
    for o in others:
        shared = float(min(o.upper[along], panel.upper[along]) - max(o.lower[along], panel.lower[along]))
        shorter = min(float(o.upper[along] - o.lower[along]), float(panel.upper[along] - panel.lower[along]))
        if shared < MIN_SHARED_EDGE * shorter:
            continue
        after, before = float(o.lower[axis] - panel.upper[axis]), float(panel.lower[axis] - o.upper[axis])
        beyond, at = (after, before) if way > 0 else (before, after)
        weight = min(1.0, shared / max(float(panel.upper[along] - panel.lower[along]), 1e-9))
        if abs(beyond) <= MAX_GAP:
            found[0] = max(found[0], weight)
        if abs(at) <= MAX_GAP:
            found[1] = max(found[1], weight)
    return found[0], found[1]


def _controls(panel: Panel, controls: Floats, axis: int, way: float) -> tuple[float, float]:
    """Return the shares of an object's controls that lie beyond the opening edge of a panel, and beyond its hinge."""
    if not len(controls):
        return 0.0, 0.0
    after, before = controls[:, axis] > panel.upper[axis], controls[:, axis] < panel.lower[axis]
    beyond, at = (after, before) if way > 0 else (before, after)
    return float(beyond.mean()), float(at.mean())


def _in_column(a: Panel, b: Panel) -> bool:
    """Return whether two panels are as wide as each other, one above the other."""
    return float(np.abs([a.lower[0] - b.lower[0], a.upper[0] - b.upper[0]]).max()) < SAME_PLACE


def drawer_features(view: FrontView) -> Floats:
    """Return the (len(DRAWER_FEATURES),) numbers that speak for a front being that of a drawer."""
    panel, handle, extent = view.panel, view.handle, view.extent
    area = panel.width * panel.height
    stacked = [o for o in view.others if _in_column(o, panel)]
    size = np.array([panel.width, panel.height])
    has_box = view.box_depth > MIN_BOX_SHARE * extent[2]
    covers = bool(panel.width > 0.8 * extent[0] and panel.height > 0.5 * extent[1])
    is_drawn = handle is not None and handle.is_level and _is_centred(handle)
    # Height speaks for a door, but not where the handle is one that nobody puts on a tall door.
    tells_by_form = covers or not is_drawn
    alike = sum(float(np.abs(np.array([o.width, o.height]) - size).max()) < SAME_PLACE for o in view.others)
    # Larger ones above or below it.
    shared = [float(min(o.upper[0], panel.upper[0]) - max(o.lower[0], panel.lower[0])) for o in view.others]
    over = [
        o
        for o, width in zip(view.others, shared, strict=True)
        if width > MIN_SHARED_EDGE * min(o.width, panel.width) and o.width * o.height > 1.6 * area
    ]
    return np.array(
        [
            1.0,
            float(panel.upper[2] - panel.lower[2] > MIN_DEEP_SHARE * extent[2]),
            float(has_box),
            float(panel.has_shelf_behind),
            view.log_ratio if tells_by_form else max(view.log_ratio, 0.0),
            panel.height / max(float(extent[1]), 1e-9) if tells_by_form else 0.0,
            float(covers),
            float(handle is not None and _is_aside(handle)),
            float(handle is not None and handle.is_upright),
            float(handle is not None and handle.is_level and not _is_aside(handle)),
            0.0 if handle is None else max(0.0, 0.5 - float(handle.middle[1])),
            float(handle is not None and _is_centred(handle)),
            float(handle is None),
            math.log1p(min(len(stacked), MAX_NEIGHBOURS)),
            float(len(stacked) >= MIN_STACK - 1),
            math.log1p(min(alike, MAX_NEIGHBOURS)),
            float(any(o.lower[1] >= panel.upper[1] - SAME_PLACE for o in over)),
            float(any(o.upper[1] <= panel.lower[1] + SAME_PLACE for o in over)),
            float(_is_under_pair(panel, view.others)),
            float(panel.width > MIN_LOW_RATIO * panel.height and len(over) > 0),
            float(is_drawn),
            float(handle is not None and _is_centred(handle) and any(_is_aside(h) for h in view.handles if h)),
            float(view.others_box_depth > MIN_BOX_SHARE * extent[2] and not has_box),
        ]
    )


def _are_twins(a: Panel, b: Panel, of_a: PanelHandle | None, of_b: PanelHandle | None) -> bool:
    """Return whether two panels are of one size in one column, with their handles at the same place, or none."""
    if not _in_column(a, b) or abs(a.height - b.height) >= SAME_PLACE:
        return False
    if of_a is None or of_b is None:
        return of_a is of_b
    return bool(np.abs(of_a.middle - of_b.middle).max() < CENTRED)


def _is_aside(handle: PanelHandle) -> bool:
    return abs(float(handle.middle[0]) - 0.5) > ASIDE


def _is_centred(handle: PanelHandle) -> bool:
    return float(np.abs(handle.middle - 0.5).max()) <= CENTRED


def _is_under_pair(panel: Panel, others: Sequence[Panel]) -> bool:
    """Return whether two fronts of one height that lie side by side above a wide front are as wide together."""
    if panel.width < MIN_WIDE_RATIO * panel.height:
        return False
    above = [o for o in others if o.lower[1] >= panel.upper[1] - SAME_PLACE]
    for a in above:
        for b in above:
            level = max(abs(a.lower[1] - b.lower[1]), abs(a.upper[1] - b.upper[1])) < SAME_PLACE
            ends = max(abs(a.lower[0] - panel.lower[0]), abs(b.upper[0] - panel.upper[0])) < SAME_PLACE
            if level and ends and float(b.lower[0]) >= float(a.upper[0]) - SAME_PLACE:
                return True
    return False


def kind_log_odds(views: Sequence[FrontView]) -> dict[str, float]:
    """Return how well the fronts of an object suit each kind that has habits: log likelihoods, up to a constant.

    A front is a drawer or a door with a hinge at one of four edges, as often as is usual for the kind. Fronts of one
    object are alike, so more than `MAX_SPEAKING_FRONTS` count as that number.
    """
    if not views:
        return {}
    drawers = np.array([float(DRAWER_WEIGHTS @ drawer_features(v)) for v in views])
    scores = np.array([edge_features(v) @ EDGE_WEIGHTS for v in views])
    edges = np.exp(scores - scores.max(axis=1, keepdims=True))
    edges *= len(EDGES) / edges.sum(axis=1, keepdims=True)
    count = min(len(views), MAX_SPEAKING_FRONTS) / len(views)
    found = {}
    for kind in (*HABITS, ""):
        share = drawer_share({kind: 1.0})
        doors = (1.0 - share) / (1.0 + np.exp(drawers)) * (edges @ edge_shares({kind: 1.0}))
        fits = share / (1.0 + np.exp(-drawers)) + doors
        found[kind] = count * float(np.log(fits).sum())
    found[""] += math.log(SHARE_WITH_FRONTS)
    return found


def choose_drawer(view: FrontView, kinds: Mapping[str, float]) -> tuple[bool, float, str]:
    """Return whether a front is that of a drawer, with its probability and the reason."""
    if view.panel.is_round:
        return False, 0.95, "a round door"
    if any(o.is_round and o.upper[1] <= view.panel.upper[1] for o in view.others):
        return True, 0.8, "above a round door"
    share = drawer_share(kinds)
    terms = DRAWER_WEIGHTS * drawer_features(view)
    habit = math.log(share / (1.0 - share))
    odds = float(terms.sum()) + habit
    probability = 1.0 / (1.0 + math.exp(-odds))
    is_drawer = odds > 0.0
    sign = 1.0 if is_drawer else -1.0
    best = int(np.argmax(np.round(sign * terms, 9)))
    by_kind = sign * habit > max(sign * float(terms[best]), 0.0)
    reason = "as such things have" if by_kind else DRAWER_TABLE[DRAWER_FEATURES[best]][1]
    return is_drawer, min(probability if is_drawer else 1.0 - probability, MAX_CONFIDENCE), reason


def choose_hinge(view: FrontView, kinds: Mapping[str, float]) -> JointPlan:
    """Return the hinge of a door at its likeliest edge; `runner_up` is the next likely one."""
    shares = edge_shares(kinds)
    terms = edge_features(view) * EDGE_WEIGHTS
    scores = np.log(shares) + terms.sum(axis=1)
    order = np.lexsort((np.arange(len(EDGES)), -np.round(scores, 9)))
    odds = np.exp(scores - scores.max())
    best, second = int(order[0]), int(order[1])
    gain = terms[best] - terms[second]
    habit = float(np.log(shares[best] / shares[second]))
    first = int(np.argmax(np.round(gain, 9)))
    by_kind = gain[first] <= max(habit, 1e-9)
    reason = "as such things open" if by_kind else EDGE_TABLE[EDGE_FEATURES[first]][1]
    confidence = min(float(odds[best] / odds.sum()), MAX_CONFIDENCE)
    joint = hinge_joint(view.panel, EDGES[best])
    return joint.replace(confidence=confidence, reason=reason, runner_up=EDGES[second].value)


def hinge_joint(panel: Panel, edge: HingeEdge, side: int = FRONT) -> JointPlan:
    """Return the hinge of a front along an edge; a positive rotation opens it towards the viewer."""
    w = float(panel.upper[2] - HINGE_DEPTH_SHARE * (panel.upper[2] - panel.lower[2]))
    middle = (panel.lower[:2] + panel.upper[:2]) / 2
    across, way = _ACROSS[edge]
    # (u, v, w) is left-handed where w is depth; the axis is that of the right-handed frame right, up, towards viewer.
    axis = -way * SIDES[side][1] if across == 0 else way * SIDES[side][0]
    point = np.array([*middle, w])
    point[across] = (panel.lower if way > 0 else panel.upper)[across]
    # No component is -0.0.
    return hinge(to_vec3(axis + 0.0), to_vec3(point @ SIDES[side]), (0.0, DOOR_RANGE_RAD)).replace(edge=edge)


def sliding_direction(measured: MeasuredFragments, panel: Panel, grip: PanelHandle | None) -> float | None:
    """Return 1 for a door that slides to the right, -1 to the left, None for one that does not slide.

    Args:
        grip: its handle; a door without one is not taken for a sliding one.
    """
    if grip is None:
        return None
    lower, upper = corners_from_side(measured, FRONT)
    image, near = measured.depth_images[FRONT], float(lower[:, 2].min())
    margin = 4 * image.pixel
    inset = 0.1 * panel.height
    (left, bottom), (right, top) = panel.lower[:2], panel.upper[:2]
    frame = [
        image.window(np.array([left, top]), np.array([right, top + margin])),
        image.window(np.array([left, bottom - margin]), np.array([right, bottom])),
    ]
    if all(float((f + near <= panel.lower[2] + FRAME_TOLERANCE).mean()) < 0.4 for f in frame):
        return None
    for sign in (1.0, -1.0):
        edge = float(right if sign > 0 else left)
        far = edge + sign * MIN_OPEN_SHARE * panel.width
        if not float(lower[:, 0].min()) <= far <= float(upper[:, 0].max()):
            continue
        a, b = sorted((edge + sign * margin, far))
        beside = image.window(np.array([a, bottom + inset]), np.array([b, top - inset]))
        clear = float((np.isfinite(beside) & (beside + near > panel.upper[2] + MIN_NICHE_DEPTH)).mean())
        place = float(grip.middle[0]) if sign < 0 else 1.0 - float(grip.middle[0])
        if clear >= 0.95 and place >= MIN_HANDLE_OFFSET:
            return sign
    return None
