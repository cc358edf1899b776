"""Decide whether a panel is a drawer or a door, and find the hinge edge, axis and range of a door."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.plan import HingeEdge
from casa_assets.core.typing import Floats

# Distance of the hinge line from the back of a door, as a share of its depth. Ref: the articulation bench
# (docs/articulate_measurements.md, The sets), which also scores this: its 67 hinged doors have a median of 0.13 and
# quartiles of 0.00 and 0.34.
HINGE_DEPTH_SHARE = 0.15
# Travel of a drawer as a share of its depth. Ref: the 57 drawers of the same bench have a median of 0.82.
DRAWER_TRAVEL_SHARE = 0.81
DOOR_RANGE_RAD = math.pi / 2
# Width to height from which a door hinges at its top or bottom.
MIN_FOLDING_RATIO = 1.2
# The same for one of several doors above each other: doors of fridges do not fold.
MIN_FLAP_RATIO = 1.8
# The same for a door as wide as the object with a long level handle.
MIN_RATIO_LONG_HANDLE = 0.9


@dataclass(frozen=True)
class HingeChoice:
    """Hinge edge of a panel (None: it slides), the next likely edge, confidence and reason."""

    edge: HingeEdge | None
    runner_up: HingeEdge | None
    confidence: float
    reason: str


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


def is_drawer(
    panel: Panel, box_depth: float, whole: Floats, grip: PanelHandle | None, others: list[Panel]
) -> tuple[bool, float, str]:
    """Return whether a panel is the front of a drawer, with confidence and reason."""
    deep = float(panel.upper[2] - panel.lower[2])
    if deep > 0.34 * whole[2]:
        return True, 0.95, "it is deep, and seen from its front alone"
    if box_depth > 0.3 * whole[2]:
        return True, 0.9, "a box behind it goes with it"
    if panel.has_shelf_behind:
        return False, 0.8, "a shelf behind it leaves no room for a box"
    ratio = panel.width / max(panel.height, 1e-9)
    full = panel.width > 0.8 * whole[0] and panel.height > 0.5 * whole[1]
    centred = grip is None or abs(float(grip.middle[0]) - 0.5) < 0.12
    if full or not centred:
        return False, 0.8, "it closes the front"
    stacked = any(
        abs(o.lower[0] - panel.lower[0]) + abs(o.upper[0] - panel.upper[0]) < 0.03 for o in others if o is not panel
    )
    if grip is not None and not grip.is_upright and ratio >= 1.5 and stacked:
        return True, 0.7, "a wide front with a centred handle, above or below others"
    if ratio >= 2.5 and panel.height < 0.35 * whole[1]:
        return True, 0.6, "a wide, low front"
    return False, 0.6, "no box behind it"


def panel_handle(panel: Panel, lower: Floats, upper: Floats) -> PanelHandle | None:
    """Return the handle of a panel: those grips that stand out at least 0.6 times as far as the farthest."""
    if not panel.grips:
        return None
    out = [float(panel.lower[2] - lower[g, 2].min()) for g in panel.grips]
    chosen = [i for g, s in zip(panel.grips, out, strict=True) if s >= 0.6 * max(out) for i in g]
    a, b = lower[chosen, :2].min(axis=0), upper[chosen, :2].max(axis=0)
    size = np.array([panel.width, panel.height])
    return PanelHandle(((a + b) / 2 - panel.lower[:2]) / size, b - a)


def hinge_edge(panel: Panel, grip: PanelHandle | None, others: list[Panel], whole: Floats) -> HingeChoice:
    """Find the hinge edge of a door: opposite its handle, away from its neighbours."""
    ratio = panel.width / max(panel.height, 1e-9)
    full = panel.width > 0.8 * whole[0] and panel.height > 0.4 * whole[1]
    flap = ratio >= MIN_FOLDING_RATIO or (full and ratio > 0.75)
    if grip is None:
        return _by_neighbours(panel, others, ratio, full)
    x, y = float(grip.middle[0]) - 0.5, float(grip.middle[1]) - 0.5
    side = HingeEdge.LEFT if x > 0 else HingeEdge.RIGHT
    level = HingeEdge.BOTTOM if y > 0 else HingeEdge.TOP
    bar = float(grip.size[0]) / panel.width
    alone = full and not any(o is not panel and o.width * o.height > 0.3 * panel.width * panel.height for o in others)
    if grip.is_level and abs(y) > 0.15 and ((flap and (abs(x) < 0.15 or bar > 0.7)) or (alone and bar > 0.5)):
        return HingeChoice(level, side, 0.9, "a level handle on a wide door")
    if (
        grip.is_level
        and y > 0.3
        and abs(x) < 0.08
        and bar > 0.5
        and ratio > MIN_RATIO_LONG_HANDLE
        and panel.width > 0.8 * whole[0]
    ):
        return HingeChoice(level, side, 0.75, "a long level handle at the top of a door as wide as the thing")
    if grip.is_upright and abs(x) > 0.1:
        return HingeChoice(side, level, 0.95, "an upright handle at one side")
    if flap and abs(x) < 0.08 and abs(y) > 0.15:
        return HingeChoice(level, side, 0.7, "a handle in the middle of a wide door")
    if abs(x) < 0.04:
        return _by_neighbours(panel, others, ratio, full)
    return HingeChoice(side, level, 0.8, "a handle nearer to one side")


def _by_neighbours(panel: Panel, others: list[Panel], ratio: float, full: bool) -> HingeChoice:
    """Find the hinge edge of a door by the fronts beside it; very wide doors fold down."""
    beside = [
        o
        for o in others
        if o is not panel and min(o.upper[1], panel.upper[1]) - max(o.lower[1], panel.lower[1]) > 0.5 * panel.height
    ]
    right = sum(float(o.lower[0]) >= float(panel.upper[0]) - 0.01 for o in beside)
    left = sum(float(o.upper[0]) <= float(panel.lower[0]) + 0.01 for o in beside)
    if right > left:
        return HingeChoice(HingeEdge.LEFT, HingeEdge.RIGHT, 0.75, "another front to its right")
    if left > right:
        return HingeChoice(HingeEdge.RIGHT, HingeEdge.LEFT, 0.75, "another front to its left")
    if ratio >= MIN_FLAP_RATIO:
        for level, over in ((HingeEdge.BOTTOM, True), (HingeEdge.TOP, False)):
            if _stacked(panel, others, over):
                return HingeChoice(level, _opposite(level), 0.6, "a wide front, with another above or below it")
    if ratio > 2.0:
        return HingeChoice(HingeEdge.BOTTOM, HingeEdge.TOP, 0.5, "a very wide door without a handle")
    return HingeChoice(HingeEdge.LEFT, HingeEdge.RIGHT, 0.4, "nothing says which side")


def _opposite(edge: HingeEdge) -> HingeEdge:
    """Return the opposite edge."""
    return {
        HingeEdge.LEFT: HingeEdge.RIGHT,
        HingeEdge.RIGHT: HingeEdge.LEFT,
        HingeEdge.TOP: HingeEdge.BOTTOM,
        HingeEdge.BOTTOM: HingeEdge.TOP,
    }[edge]


def _stacked(panel: Panel, others: list[Panel], over: bool) -> bool:
    """Return whether a front of the same width lies right above a panel, or right below it."""
    for o in others:
        gap = float(o.lower[1] - panel.upper[1]) if over else float(panel.lower[1] - o.upper[1])
        flush = abs(float(o.lower[0] - panel.lower[0])) + abs(float(o.upper[0] - panel.upper[0])) < 0.03
        if o is not panel and flush and abs(gap) < 0.02 and o.height > 0.4 * panel.height:
            return True
    return False


def hinge_line(panel: Panel, edge: HingeEdge) -> tuple[Floats, Floats]:
    """Return the hinge axis and a point of it in (u, v, w); a positive rotation opens the door towards the viewer.

    (u, v, w) is left-handed where w is depth; the axis is given for the right-handed frame right, up, towards viewer.
    """
    w = float(panel.upper[2] - HINGE_DEPTH_SHARE * (panel.upper[2] - panel.lower[2]))
    u, v = (panel.lower[:2] + panel.upper[:2]) / 2
    if edge is HingeEdge.LEFT:
        return np.array([0.0, -1.0, 0.0]), np.array([panel.lower[0], v, w])
    if edge is HingeEdge.RIGHT:
        return np.array([0.0, 1.0, 0.0]), np.array([panel.upper[0], v, w])
    if edge is HingeEdge.BOTTOM:
        return np.array([1.0, 0.0, 0.0]), np.array([u, panel.lower[1], w])
    return np.array([-1.0, 0.0, 0.0]), np.array([u, panel.upper[1], w])
