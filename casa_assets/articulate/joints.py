"""Decide how a front opens (drawer, hinged or sliding door): axis, range, friction, damping and named states."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.front_features import (
    DRAWER_FEATURES,
    DRAWER_TABLE,
    DRAWER_WEIGHTS,
    EDGE_FEATURES,
    EDGE_TABLE,
    EDGE_WEIGHTS,
    EDGES,
    HABITS,
    FrontView,
    PanelHandle,
    drawer_features,
    drawer_share,
    edge_features,
    edge_shares,
)
from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.plan import HingeEdge, PartKind, PartPlan, round7
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import FRONT
from casa_assets.core import hand_dynamics
from casa_assets.core.hand_dynamics import START_N
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Collider, Drive, Joint, JointKind, Link, State

# Sliding doors --------------------------------------------------------------------------------------------------------
# Detect sliding doors: a door in a niche wider than itself, with its handle where a hinge would not want it.

# Beside a sliding door the niche is open for this share of its width, and this much deeper than the door, diagonals.
MIN_OPEN_SHARE, MIN_NICHE_DEPTH = 0.85, 0.02
# The rail that it slides on lies at most this far behind the door, diagonals.
FRAME_TOLERANCE = 0.006
# Distance of the handle from the edge that a hinged door would open at, by the width.
MIN_HANDLE_OFFSET = 0.3


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


# Hinges ---------------------------------------------------------------------------------------------------------------
# Decide whether a front is a drawer or a door, and find the hinge edge, axis and range of a door.
#
# The log odds from the kind of the object and those from the form of the front are added.

# Distance of the hinge line from the back of a door, as a share of its depth. Ref: the articulation bench
# (docs/numbers.md), which also scores this: its 67 hinged doors have a median of 0.13 and
# quartiles of 0.00 and 0.34.
HINGE_DEPTH_SHARE = 0.15
# Travel of a drawer as a share of its depth. Ref: the 57 drawers of the same bench have a median of 0.82.
DRAWER_TRAVEL_SHARE = 0.81
DOOR_RANGE_RAD = math.pi / 2
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


def choose_hinge(view: FrontView, kinds: Mapping[str, float]) -> HingeChoice:
    """Return the likeliest hinge edge of a door."""
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


# Joint dynamics -------------------------------------------------------------------------------------------------------
# Build the joint of each moving part with friction, damping and springs for a human hand, and its named states.

# Force that starts a part; all others start as a door does.
STARTS_N = {
    PartKind.KNOB: hand_dynamics.KNOB_START_N,
    PartKind.LEVER: hand_dynamics.TAP_START_N,
    PartKind.SPOUT: hand_dynamics.TAP_START_N,
    PartKind.TRAY: hand_dynamics.TRAY_START_N,
}
# A door whose weight turns it by less than this torque needs no spring.
MIN_SPRING_TORQUE_NM = 0.05
# Parts that fingers take at the rim.
RIM_GRIPPED_KINDS = frozenset({PartKind.KNOB})
# Shortest travel that friction is computed for, rad or m.
MIN_TRAVEL = 1e-4


def build_joint(part: PartPlan, metres: float, link: Link, behind: int | None, names: Sequence[str]) -> Joint:
    """Return the joint of a part in the child's frame, with friction and damping that fit the hand that moves it.

    Args:
        metres: length of the diagonal, in which the ranges of slides are given. link: the one that moves.
        behind: index of the part that must be open first, or None. names: of all links, the body first.
    """
    slides = part.joint.kind is JointKind.SLIDE
    lower, upper = (r * metres if slides else r for r in part.joint.range)
    way = upper - lower
    axis = np.array(part.joint.axis)
    grip = next((c for c in link.colliders if c.label == "handle"), link.colliders[0] if link.colliders else None)
    arm = 1.0 if slides else _arm(link, grip, axis, part.kind in RIM_GRIPPED_KINDS)
    inertia = link.inertial.mass if slides else _about(link, axis)
    spring = None if slides else _balance(link, axis, upper)
    feel = hand_dynamics.feel_against(spring, inertia, arm, max(way, MIN_TRAVEL), STARTS_N.get(part.kind, START_N))
    if part.kind is PartKind.BUTTON:
        spring = hand_dynamics.press(max(way, MIN_TRAVEL), hand_dynamics.KEY_FULL_N, hand_dynamics.KEY_PRELOAD_N)
        feel = hand_dynamics.KEY
    return Joint(
        name=f"{part.name}_joint",
        child=part.name,
        kind=part.joint.kind,
        axis=part.joint.axis,
        range=(round7(lower), round7(upper)),
        damping=feel.damping,
        frictionloss=feel.frictionloss,
        armature=feel.armature,
        drive=None if spring is None else Drive(stiffness=spring.stiffness, damping=0.0, target=spring.rest),
        grip=None if grip is None else grip.name,
        behind=None if behind is None else f"{names[behind + 1]}_joint",
    )


def _balance(link: Link, axis: Floats, far: float) -> hand_dynamics.Spring | None:
    """Return the spring of a door that would otherwise fall open, None if it would not."""
    center = np.array(link.inertial.center_of_mass)
    turned = center * math.cos(far) + np.cross(axis, center) * math.sin(far)
    turned = turned + axis * float(axis @ center) * (1 - math.cos(far))
    falls = float(np.cross(turned, np.array([0.0, 0.0, -9.81 * link.inertial.mass])) @ axis)
    return None if falls <= MIN_SPRING_TORQUE_NM else hand_dynamics.carry(falls, far)


def _arm(link: Link, grip: Collider | None, axis: Floats, rim: bool) -> float:
    """Return the distance from the axis to the hand, metres: to the handle, or to the rim of what fingers turn."""
    if grip is None:
        return 0.01
    points = tessellate(grip.shape, grip.pose)[0] if rim else np.array([grip.pose.position])
    off = points - np.outer(points @ axis, axis)
    return max(0.005, float(np.linalg.norm(off, axis=1).max()))


def _about(link: Link, axis: Floats) -> float:
    """Return the inertia of a link about an axis through its origin, kg*m^2."""
    center = np.array(link.inertial.center_of_mass)
    off = center - axis * float(center @ axis)
    return float(axis @ link.inertial.tensor @ axis) + link.inertial.mass * float(off @ off)


def open_closed_states(part: PartPlan) -> tuple[State, ...]:
    """Return the closed and open states of a front. Ref: robocasa v1.0, is_closed 0.005, is_open 0.9."""
    if part.kind not in (PartKind.DOOR, PartKind.DRAWER, PartKind.LID):
        return ()
    joint = f"{part.name}_joint"
    return (
        State(name=f"{joint}_closed", joint=joint, value="closed", interval=(0.0, 0.005)),
        State(name=f"{joint}_open", joint=joint, value="open", interval=(0.9, 1.0)),
    )
