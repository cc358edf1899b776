"""Decide whether a front is a drawer or a door, and find the hinge edge, axis and range of a door.

The log odds from the kind of the object and those from the form of the front are added.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.joints.front_view import (
    DRAWER_FEATURES,
    EDGE_FEATURES,
    EDGES,
    FrontView,
    drawer_features,
    edge_features,
)
from casa_assets.articulate.joints.kind_habits import HABITS, drawer_share, edge_shares
from casa_assets.articulate.plan import HingeEdge
from casa_assets.core.typing import Floats

# Distance of the hinge line from the back of a door, as a share of its depth. Ref: the articulation bench
# (docs/numbers.md), which also scores this: its 67 hinged doors have a median of 0.13 and
# quartiles of 0.00 and 0.34.
HINGE_DEPTH_SHARE = 0.15
# Travel of a drawer as a share of its depth. Ref: the 57 drawers of the same bench have a median of 0.82.
DRAWER_TRAVEL_SHARE = 0.81
DOOR_RANGE_RAD = math.pi / 2
# Weight of each feature in the log odds of a hinge edge, and of a drawer. Ref: logistic regression over the
# articulation bench and drawn furniture and appliances, as they are and as shells (benchmarks/train/hinges.py),
# which states the bounds that four weights of a drawer lie on by choice.
EDGE_WEIGHTS: Mapping[str, float] = {
    "handle_away": 8.65,
    "handle_along": 1.08,
    "far_and_along": 1.21,
    "wide": 3.11,
    "wide_without_handle": -1.45,
    "alone_and_wide": -0.0189,
    "front_beyond": 1.59,
    "panel_beyond": 0.173,
    "controls_beyond": 0.483,
    "controls_at": -0.86,
    "room_beyond": 1.96,
    "knobs_away": 3.28,
    "handle_off_middle": -4.68,
    "handles_face": -4.34,
}
DRAWER_WEIGHTS: Mapping[str, float] = {
    "constant": 0.247,
    "deep": 5.61,
    "box": 7.04,
    "shelf_behind": -2.0,
    "wide": 0.914,
    "height_share": -4.91,
    "covers_front": -0.0195,
    "handle_aside": -2.41,
    "handle_upright": -1.5,
    "handle_level": 1.61,
    "handle_low": -0.655,
    "handle_centred": 2.0,
    "no_handle": 0.308,
    "many_stacked": 2.62,
    "alike": 0.929,
    "over_larger": 1.4,
    "under_pair": 2.0,
    "low_beside_larger": 1.5,
    "level_and_centred": 0.17,
    "centred_beside_aside": 0.858,
    "others_have_boxes": -2.66,
}
# What a feature says, where it decides.
EDGE_REASONS: Mapping[str, str] = {
    "handle_away": "its handle is at the other side",
    "handle_along": "its handle runs along that edge",
    "handle_long": "its handle runs along that edge",
    "far_and_along": "a bar at the other side",
    "wide": "by its proportions",
    "wide_without_handle": "by its proportions",
    "alone_and_wide": "one front as wide as the thing",
    "front_beyond": "another front beside it",
    "front_at": "another front beside it",
    "panel_beyond": "a panel that stays beside it",
    "panel_at": "a panel that stays beside it",
    "controls_beyond": "the controls are at the other side",
    "controls_at": "the controls are at the other side",
    "room_beyond": "by its place on the front",
    "others_away": "as the fronts above or below it",
    "knobs_away": "its knob is at the other side",
    "handle_off_middle": "its handle is off its middle",
    "handles_face": "its handle is next to that of another front",
    "front_over_or_under": "another front above or below it",
}
DRAWER_REASONS: Mapping[str, str] = {
    "constant": "by its form",
    "deep": "it is deep, and seen from its front alone",
    "box": "a box behind it goes with it",
    "shelf_behind": "a shelf behind it leaves no room for a box",
    "wide": "by its proportions",
    "height_share": "by its height",
    "covers_front": "it closes the front",
    "handle_aside": "its handle is at one side",
    "handle_upright": "its handle is upright",
    "handle_level": "a level handle in its middle",
    "handle_centred": "its handle is in its middle",
    "handle_low": "its handle is at its lower edge",
    "no_handle": "by its form",
    "stacked": "it is one of several above each other",
    "many_stacked": "it is one of several above each other",
    "alike": "it is one of several alike",
    "under_larger": "it lies under a larger front",
    "over_larger": "it lies above a larger front",
    "low_beside_larger": "it is low and lies over or under a larger front",
    "level_and_centred": "a level handle in its middle",
    "centred_beside_aside": "its handle is in its middle, those of others are at a side",
    "others_have_boxes": "boxes go with other fronts, none with it",
    "under_pair": "it is as wide as the two fronts above it together",
}
# At most so many fronts of a thing speak for its kind.
MAX_SPEAKING_FRONTS = 3
# How often a thing of a kind without habits has what looks like a door or drawer.
SHARE_WITH_FRONTS = 0.05
# No guess is surer than this.
MAX_CONFIDENCE = 0.97


@dataclass(frozen=True)
class HingeChoice:
    """Hinge edge of a door, the next likely edge, the probability of the edge, and the reason."""

    edge: HingeEdge
    runner_up: HingeEdge
    confidence: float
    reason: str


def kind_log_odds(views: Sequence[FrontView]) -> dict[str, float]:
    """Return how well the fronts of an object suit each kind that has habits: log likelihoods, up to a constant.

    A front is a drawer or a door with a hinge at one of four edges, as often as is usual for the kind. Fronts of one
    object are alike, so more than `MAX_SPEAKING_FRONTS` count as that number.
    """
    if not views:
        return {}
    drawers = np.array([float(_weights_of_drawers() @ drawer_features(v)) for v in views])
    scores = np.array([edge_features(v) @ _weights_of_edges() for v in views])
    edges = np.exp(scores - scores.max(axis=1, keepdims=True))
    edges *= len(EDGES) / edges.sum(axis=1, keepdims=True)
    count = min(len(views), MAX_SPEAKING_FRONTS) / len(views)
    found = {}
    for kind in (*HABITS, ""):
        share = drawer_share({kind: 1.0})
        fits = share / (1.0 + np.exp(-drawers)) + (1.0 - share) / (1.0 + np.exp(drawers)) * (
            edges @ edge_shares({kind: 1.0})
        )
        found[kind] = count * float(np.log(fits).sum())
    found[""] += math.log(SHARE_WITH_FRONTS)
    return found


def _weights_of_drawers() -> Floats:
    """Return the (len(DRAWER_FEATURES),) weights."""
    return np.array([DRAWER_WEIGHTS.get(name, 0.0) for name in DRAWER_FEATURES])


def _weights_of_edges() -> Floats:
    """Return the (len(EDGE_FEATURES),) weights."""
    return np.array([EDGE_WEIGHTS.get(name, 0.0) for name in EDGE_FEATURES])


def choose_drawer(view: FrontView, kinds: Mapping[str, float]) -> tuple[bool, float, str]:
    """Return whether a front is that of a drawer, with its probability and the reason.

    Args:
        kinds: probability of each kind that the thing may be.
    """
    if view.panel.is_round:
        return False, 0.95, "a round door"
    if any(o.is_round and o.upper[1] <= view.panel.upper[1] for o in view.others):
        return True, 0.8, "above a round door"
    share = drawer_share(kinds)
    terms = _weights_of_drawers() * drawer_features(view)
    habit = math.log(share / (1.0 - share))
    odds = float(terms.sum()) + habit
    probability = 1.0 / (1.0 + math.exp(-odds))
    is_drawer = odds > 0.0
    sign = 1.0 if is_drawer else -1.0
    best = int(np.argmax(np.round(sign * terms, 9)))
    by_kind = sign * habit > max(sign * float(terms[best]), 0.0)
    reason = "as such things have" if by_kind else DRAWER_REASONS[DRAWER_FEATURES[best]]
    return is_drawer, min(probability if is_drawer else 1.0 - probability, MAX_CONFIDENCE), reason


def choose_hinge(view: FrontView, kinds: Mapping[str, float]) -> HingeChoice:
    """Return the likeliest hinge edge of a door.

    Args:
        kinds: probability of each kind that the thing may be.
    """
    shares = edge_shares(kinds)
    terms = edge_features(view) * _weights_of_edges()
    scores = np.log(shares) + terms.sum(axis=1)
    order = np.lexsort((np.arange(len(EDGES)), -np.round(scores, 9)))
    odds = np.exp(scores - scores.max())
    best, second = int(order[0]), int(order[1])
    gain = terms[best] - terms[second]
    habit = float(np.log(shares[best] / shares[second]))
    first = int(np.argmax(np.round(gain, 9)))
    reason = EDGE_REASONS[EDGE_FEATURES[first]] if gain[first] > max(habit, 1e-9) else "as such things open"
    return HingeChoice(EDGES[best], EDGES[second], min(float(odds[best] / odds.sum()), MAX_CONFIDENCE), reason)


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
