"""Find the up and front axes of a mesh: align its walls with the axes, then score the twenty-four candidates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from casa_assets.articulate.frame.evidence import FEATURES, frame_features, hidden_area
from casa_assets.articulate.frame.score_candidate import SCORE_NAMES, score_candidate
from casa_assets.articulate.frame.side_views import measure_side
from casa_assets.articulate.frame.wall_alignment import align_walls
from casa_assets.articulate.plan import Frame
from casa_assets.articulate.segment.fragment_measures import SIDES, MeasuredFragments, measure_fragments, render_sides
from casa_assets.articulate.segment.segmentations import segmentations
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.typing import Floats

# Weight of each feature in the log odds of a candidate; features whose weight came out as zero are left out. Ref:
# conditional logit over members of this project's own families, merged into one mesh each (benchmarks/train/frame.py).
WEIGHTS: Mapping[str, float] = {
    "front_detail": 9.51,
    "back_detail": -3.106,
    "front_juts": 1.4,
    "back_juts": -1.963,
    "top_juts": 1.347,
    "bottom_juts": -1.129,
    "back_knobs": -0.8666,
    "sides_knobs": -1.707,
    "front_bars": 1.11,
    "top_bars": -0.1781,
    "bottom_bars": -0.4074,
    "sides_bars": -0.6111,
    "front_panels": 0.7713,
    "back_panels": -0.8074,
    "front_stands": 0.4779,
    "sides_stands": -0.3255,
    "symmetry": 2.325,
    "front_level": 0.7783,
    "support": 0.9878,
    "shape": 0.5556,
    "inside_upright": -4.81,
    "bars_high": 0.06694,
    "knobs_high": 2.509,
    "top_rings": 1.637,
    "top_slots": 0.9141,
    "knobs_near": 2.816,
    "mass_height": -2.901,
    "back_plain": 0.00708,
    "bottom_legs": 3.768,
}
# Prior of the axis that points up where a file says nothing, by the side that is then the top: modellers write y up
# or z up, hardly anything else.
PRIOR_UP = (0.02, 0.42, 0.02, 0.02, 0.5, 0.02)
# Prior of the side that the file states as its top; the other five sides share the rest.
STATED_UP = 0.95
# Prior of an up direction that is not along an axis of the file.
ASKEW_UP = 0.02
# Pixels along the longer side of a depth image: half of what the analysis of the parts takes, so that the guess is
# faster. The weights were learned from images of this size.
FRAME_IMAGE_PX = 256
# Weight of the log odds by appearance, where the parts are scored too. Ref: as WEIGHTS.
APPEARANCE_WEIGHT = 0.605
# Weights of the scores of the parts that a candidate would have. Ref: as WEIGHTS.
SCORE_WEIGHTS: Mapping[str, float] = {
    "front_coverage": 1.071,
    "drawers": 0.2748,
    "drawers_with_box": 1.119,
    # Cancels `drawers` for drawer fronts without a box. Set by hand.
    "drawers_without_box": -0.2748,
    "knobs": 0.2237,
    "buttons": 0.127,
    "levers": 0.283,
    # A faucet is found only where its spout reaches to the front, over its mount. Set by hand.
    "faucet_levers": 3.0,
    "lids": 1.247,
    "racks": 2.274,
    "turntables": 1.5,
    "front_confidence": 1.565,
    "joint_confidence": 0.7721,
    "with_handle": 0.9607,
    "hinged_aside": -0.11,
    "hinged_below": -0.7205,
    "hinged_above": -1.274,
    "no_parts": -0.4505,
}
# Most candidates that are scored by their parts.
MAX_SCORED = 6
# Candidates whose log odds are this far below those of the best one are not scored by their parts.
MAX_LOG_ODDS_BEHIND = 6.0
# Direction, out of the object, that each of SIDES faces.
OUTWARD = -SIDES[:, 2]
# Pairs (front, top) of indices of SIDES. Opposite sides are 2k and 2k + 1, so a pair of the same k is left out.
CANDIDATES = tuple((f, t) for f in range(len(SIDES)) for t in range(len(SIDES)) if f // 2 != t // 2)
GUESSED_REASON = "detail, handles, proportions and symmetry of the six sides, and what they would let move"


def given_frame(mesh: WeldedMesh, up: Sequence[float], front: Sequence[float]) -> Frame:
    """Return the frame for known up and front directions, file axes, at right angles to each other."""
    z = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    y = -np.asarray(front, dtype=np.float64) / np.linalg.norm(front)
    return _frame_with_axes(mesh, np.stack([np.cross(y, z), y, z]), "given")


def _frame_with_axes(mesh: WeldedMesh, rotation: Floats, reason: str) -> Frame:
    """Return the frame with these axes, centred in the bounding box of the object along them."""
    turned = mesh.points @ rotation.T
    lower, upper = turned.min(axis=0), turned.max(axis=0)
    a, b, c = (float(v) for v in (lower + upper) / 2 @ rotation)
    scale = 1.0 / max(float(np.linalg.norm(upper - lower)), 1e-300)
    return Frame(rotation=rotation, origin=(a, b, c), scale=scale, reason=reason)


def guess_frame(
    mesh: WeldedMesh,
    up: Sequence[float] | None = None,
    front: Sequence[float] | None = None,
    stated: int | None = None,
) -> Frame:
    """Return the likeliest frame of an object, which may be rotated freely in its file.

    Args:
        mesh: file axes and units.
        up, front: directions that the user gave, file axes; None to guess. If only one is given, it is kept exactly. If
            both are, `up` is kept exactly; `front` may turn by up to 45 degrees to follow the walls.
        stated: index in SIDES of the side that the file states as its top; this is likely, but not certain.
    """
    kept = front if up is None else up
    straight = align_walls(mesh, [] if kept is None else [kept])
    plain = _frame_with_axes(mesh, straight, GUESSED_REASON)
    placed = mesh.in_frame(plain)
    images = render_sides(placed, FRAME_IMAGE_PX)
    ways = [measure_fragments(placed, label, images=images) for label in segmentations(placed).values()]
    outward = OUTWARD @ straight
    allowed = [(f, t) for f, t in CANDIDATES if _fits(front, outward[f]) and _fits(up, outward[t])]
    log_prior = {(f, t): float(np.log(_prior(outward[t], stated))) for f, t in allowed}
    probabilities = candidate_probabilities(ways[0], log_prior, ways[1:])
    ranked = sorted(probabilities, key=lambda k: (-round(probabilities[k], 9), k))
    face, top = ranked[0]
    y, z = -outward[face], outward[top]
    reason = GUESSED_REASON if up is None or front is None else "given"
    return _frame_with_axes(mesh, np.stack([np.cross(y, z), y, z]), reason).replace(
        confidence=round(probabilities[ranked[0]], 3),
        runner_up="; ".join(_describe(k, straight) for k in ranked[1:3]),
    )


def candidate_probabilities(
    measured: MeasuredFragments,
    log_prior: Mapping[tuple[int, int], float],
    others: Sequence[MeasuredFragments] = (),
) -> dict[tuple[int, int], float]:
    """Return the probability of each candidate (front, top), by appearance and by the parts that it would move.

    Args:
        log_prior: of each candidate, the logarithm of its prior probability.
        others: the same mesh split in other ways; the parts of the best way count.
    """
    sides = [measure_side(measured, i) for i in range(len(SIDES))]
    inside = hidden_area(measured)
    rows = [FEATURES.index(name) for name in WEIGHTS]
    weights = np.array(list(WEIGHTS.values()))
    scores = {c: float(weights @ frame_features(measured, sides, *c, inside)[rows]) + log_prior[c] for c in log_prior}
    ranked = sorted(scores, key=lambda k: (-round(scores[k], 9), k))
    probabilities = _probabilities(scores)
    likely = [c for c in ranked[:MAX_SCORED] if scores[c] > scores[ranked[0]] - MAX_LOG_ODDS_BEHIND]
    if len(likely) == 1:
        return probabilities
    weights = np.array([SCORE_WEIGHTS.get(name, 0.0) for name in SCORE_NAMES])
    rescored = {
        c: APPEARANCE_WEIGHT * (scores[c] - log_prior[c])
        + log_prior[c]
        + max(float(weights @ score_candidate(way, *c)) for way in (measured, *others))
        for c in likely
    }
    # The candidates that were scored again share the probability that they had together.
    likely_mass = sum(probabilities[c] for c in likely)
    return {**probabilities, **{c: likely_mass * p for c, p in _probabilities(rescored).items()}}


def _probabilities(scores: Mapping[tuple[int, int], float]) -> dict[tuple[int, int], float]:
    """Normalise log odds to probabilities that sum to 1."""
    best = max(scores.values())
    odds = {c: float(np.exp(s - best)) for c, s in scores.items()}
    total = sum(odds.values())
    return {c: o / total for c, o in odds.items()}


def _fits(wanted: Sequence[float] | None, direction: Floats) -> bool:
    """Return whether a direction is within about 45 degrees of the wanted one, or none is wanted."""
    if wanted is None:
        return True
    return float(direction @ np.asarray(wanted, dtype=np.float64)) > 0.7 * float(np.linalg.norm(wanted))


def _prior(up: Floats, stated: int | None) -> float:
    """Return the prior probability that a direction of the file points up."""
    near = OUTWARD @ up
    side = int(np.argmax(near))
    if float(near[side]) < 0.99:
        return ASKEW_UP
    if stated is None:
        return PRIOR_UP[side]
    return STATED_UP if side == stated else (1 - STATED_UP) / 5


def _describe(candidate: tuple[int, int], straight: Floats) -> str:
    """Describe a candidate, such as `front -y, up +z`."""
    face, top = candidate
    return f"front {axis_name(OUTWARD[face] @ straight)}, up {axis_name(OUTWARD[top] @ straight)}"


def axis_name(direction: Floats) -> str:
    """Return the name of the axis nearest to a direction, such as `+x`."""
    axis = int(np.argmax(np.abs(direction)))
    return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"
