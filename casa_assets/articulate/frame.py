"""Find the up and front axes of a mesh and its length unit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import permutations

import numpy as np

from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.plan import Frame, HingeEdge, PartKind, to_vec3
from casa_assets.articulate.segment.fragments import MeasuredFragments, WeldedMesh, measure_fragments, render_sides
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, DepthImage
from casa_assets.articulate.segment.segmentations import segmentations
from casa_assets.articulate.side_views import frame_features, hidden_area, measure_side
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.registry.category import SizeRange

# Scores of a candidate by the parts that it would have, and their weights in its log odds. Ref: as WEIGHTS.
SCORE_WEIGHTS: Mapping[str, float] = {
    "front_coverage": 1.071,
    "doors": 0.0,
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
SCORE_NAMES = tuple(SCORE_WEIGHTS)
# Counts of parts are capped at this.
MAX_COUNT = 8
# A drawer that reaches back farther than this share of the depth, and than this in diagonals, has a box.
MIN_BOX_DEPTH_SHARE, MIN_BOX_DEPTH = 0.3, 0.1
# Fronts that cover less than this share of the side count in proportion.
FULL_WEIGHT_COVERAGE = 0.25
UNITS: Mapping[str, float] = {"metre": 1.0, "centimetre": 0.01, "millimetre": 0.001, "inch": 0.0254}
# Longest sides of kitchen appliances and cabinets, from a kettle to a tall fridge, metres.
ANY_APPLIANCE_M = SizeRange(low=0.15, typical=0.75, high=2.6)
# Angle within which a face lies along an axis; bins in which directions of walls are counted.
ALIGNED_RAD, DIRECTION_BIN_RAD = np.radians(1.5), np.radians(0.25)
REFINEMENT_RAD = (ALIGNED_RAD, ALIGNED_RAD / 3, ALIGNED_RAD / 10)
# Directions of the largest surfaces that are tried as the floor.
MAX_TILTS = 12
# A further rotation aligns so much more of the surface, or of the rest of it: round objects keep their axes.
MIN_GAIN, MIN_GAIN_OF_REST = 0.05, 0.25
# Weight of each feature in the log odds of a candidate; features whose weight came out as zero are left out. Ref:
# conditional logit over members of this project's own families, merged into one mesh each (commit 7b3921e3).
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
# Prior of the side that is the top where a file says nothing: modellers write y up or z up, hardly anything else.
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
# Frames that are followed to plans.
MAX_FRAMES = 3
# Most candidates that are scored by their parts.
MAX_SCORED = 6
# Candidates whose log odds are this far below those of the best one are not scored by their parts.
MAX_LOG_ODDS_BEHIND = 6.0
# Direction, out of the object, that each of SIDES faces.
OUTWARD = -SIDES[:, 2]
# Pairs (front, top) of indices of SIDES. Opposite sides are 2k and 2k + 1, so a pair of the same k is left out.
CANDIDATES = tuple((f, t) for f in range(len(SIDES)) for t in range(len(SIDES)) if f // 2 != t // 2)
GUESSED_REASON = "detail, handles, proportions and symmetry of the six sides, and what they would let move"


def candidate_axes(front: int, top: int) -> Floats:
    """Return the (3, 3) rows right, back and up of the candidate, in the axes of the fragments."""
    back, up = SIDES[front][2], -SIDES[top][2]
    return np.stack([np.cross(back, up), back, up])


def rotate_fragments(measured: MeasuredFragments, front: int, top: int) -> MeasuredFragments:
    """Return the fragments in the frame of a candidate: one of their sides the front, another the top."""
    rotation = candidate_axes(front, top)
    a, b = measured.lower @ rotation.T, measured.upper @ rotation.T
    found = [_side(measured, rotation, k) for k in range(len(SIDES))]
    return MeasuredFragments(
        mesh=measured.mesh.transformed(rotation, np.zeros(3), 1.0),
        label=measured.label,
        lower=np.minimum(a, b),
        upper=np.maximum(a, b),
        area=measured.area,
        visible_area=measured.visible_area[:, [old for old, _ in found]],
        depth_images=tuple(image for _, image in found),
    )


def _side(measured: MeasuredFragments, rotation: Floats, side: int) -> tuple[int, DepthImage]:
    """Return the side that becomes this one, and its rotated depth image."""
    right, up, into = SIDES[side] @ rotation
    old = int(np.argmax(SIDES[:, 2] @ into))
    image, axes = measured.depth_images[old], SIDES[old]
    # Rows run down: a step to the next row is a step against `up`.
    face, depth, lower = image.face, image.depth, image.lower
    height, width = face.shape
    upper = lower + image.pixel * np.array([width, height])
    if abs(float(right @ axes[0])) < 0.5:
        face, depth = face.T[::-1, ::-1], depth.T[::-1, ::-1]
        lower, upper, axes = lower[::-1], upper[::-1], axes[[1, 0, 2]]
    corner = lower.copy()
    if float(right @ axes[0]) < 0:
        face, depth, corner[0] = face[:, ::-1], depth[:, ::-1], -upper[0]
    if float(up @ axes[1]) < 0:
        face, depth, corner[1] = face[::-1], depth[::-1], -upper[1]
    return old, DepthImage(np.ascontiguousarray(face), np.ascontiguousarray(depth), corner, image.pixel)


def score_candidate(measured: MeasuredFragments, front: int, top: int) -> Floats:
    """Return the (len(SCORE_NAMES),) scores of what would be found in the frame of a candidate."""
    seen = rotate_fragments(measured, front, top)
    parts = articulate_fragments(seen, Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0)).parts
    fronts = [p for p in parts if p.kind in (PartKind.DOOR, PartKind.DRAWER)]
    doors = [p for p in fronts if p.kind is PartKind.DOOR]
    trays = [p for p in parts if p.kind is PartKind.TRAY]
    hinged = max(len(doors), 1)
    face = seen.depth_images[FRONT].face
    moves = np.zeros(len(seen.label) + 1, dtype=bool)
    for part in fronts:
        moves[part.faces] = True
    coverage = float((moves[face] & (face >= 0)).sum() / max(int((face >= 0).sum()), 1))
    # The confidence in fronts says little where they cover only a small share of the side.
    coverage_weight = min(1.0, coverage / FULL_WEIGHT_COVERAGE)
    points, faces = seen.mesh.points[:, 1], seen.mesh.faces
    deep = max(MIN_BOX_DEPTH_SHARE * float(np.ptp(points)), MIN_BOX_DEPTH)
    with_box = sum(p.kind is PartKind.DRAWER and float(np.ptp(points[faces[p.faces]])) > deep for p in fronts)

    def log_count(kind: PartKind) -> float:
        return _log(sum(p.kind is kind for p in parts))

    return np.array(
        [
            coverage,
            _log(len(doors)),
            _log(len(fronts) - len(doors)),
            _log(with_box),
            _log(len(fronts) - len(doors) - with_box),
            log_count(PartKind.KNOB),
            log_count(PartKind.BUTTON),
            log_count(PartKind.LEVER),
            float(any(p.kind is PartKind.LEVER and p.joint.kind is JointKind.HINGE for p in parts)),
            log_count(PartKind.LID),
            _log(sum(p.joint.kind is JointKind.SLIDE for p in trays)),
            _log(sum(p.joint.kind is JointKind.HINGE for p in trays)),
            coverage_weight * float(np.mean([p.confidence for p in fronts])) if fronts else 0.0,
            coverage_weight * float(np.mean([p.joint.confidence for p in fronts])) if fronts else 0.0,
            coverage_weight * sum(len(p.grip) > 0 for p in fronts) / max(len(fronts), 1),
            sum(p.joint.edge in (HingeEdge.LEFT, HingeEdge.RIGHT) for p in doors) / hinged,
            sum(p.joint.edge is HingeEdge.BOTTOM for p in doors) / hinged,
            sum(p.joint.edge is HingeEdge.TOP for p in doors) / hinged,
            float(not parts),
        ]
    )


def _log(count: int) -> float:
    return float(np.log1p(min(count, MAX_COUNT)))


def metres_per_unit(longest: float, stated: float | None, span: SizeRange | None) -> tuple[float, float, str]:
    """Return the metres in a unit, the confidence 0..1, and the reason.

    Args:
        longest: longest side, units. stated: by the file. span: of the longest side of its kind, where that is known.
    """
    usual = span or ANY_APPLIANCE_M
    if stated is not None and usual.low / 1.3 <= longest * stated <= usual.high * 1.3:
        return stated, 0.95, f"the file's unit gives {longest * stated:.3g} m"
    fits = {
        n: abs(math.log(longest * u / usual.typical))
        for n, u in UNITS.items()
        if usual.low <= longest * u <= usual.high
    }
    normalised = any(abs(longest - n) < 2e-3 for n in (1.0, 2.0))
    if fits and not (normalised and span is not None and "metre" not in fits):
        name = min(fits, key=lambda n: (fits[n], n))
        return UNITS[name], 0.8, f"read as {name}s it is {longest * UNITS[name]:.3g} m long"
    return usual.typical / longest, 0.3, f"no unit fits {longest:.4g}; set to {usual.typical:g} m"


def align_walls(mesh: WeldedMesh, kept_directions: Sequence[Sequence[float]] = ()) -> Floats:
    """Return a (3, 3) proper rotation whose rows are directions of the file that the walls of an object run along.

    The axes of the file stay where they serve; then they are turned about one of themselves, then about the normal of
    a large face. One of `kept_directions`, such as the known up, is kept exactly as a row.
    """
    weight = mesh.areas / max(float(mesh.areas.sum()), 1e-300)
    tiers = (
        [np.asarray(f, dtype=np.float64) / np.linalg.norm(f) for f in kept_directions],
        [] if kept_directions else [np.eye(3)[k] for k in (2, 1, 0)],
        [] if kept_directions else _largest(mesh.normals, weight),
    )
    best = np.eye(3)
    if kept_directions and max(float(np.abs(f).max()) for f in tiers[0]) < 1.0 - 1e-9:
        best = _turned(mesh.normals, weight, tiers[0][0])
    share = _along(mesh.normals, weight, best)
    for tier in tiers:
        found = [_turned(mesh.normals, weight, axis) for axis in tier]
        shares = [_along(mesh.normals, weight, r) for r in found]
        if not found:
            continue
        k = int(np.argmax(np.round(shares, 9)))
        if shares[k] > share + max(MIN_GAIN, MIN_GAIN_OF_REST * (1.0 - share)):
            best, share = found[k], shares[k]
    return best


def _along(normals: Floats, weight: Floats, rotation: Floats) -> float:
    return float(weight[np.abs(normals @ rotation.T).max(axis=1) > np.cos(ALIGNED_RAD)].sum())


def _turned(normals: Floats, weight: Floats, axis: Floats) -> Floats:
    """Return the axes rotated about one direction so that most walls along it lie along the other two."""
    first = np.eye(3)[int(np.argmin(np.abs(axis) + np.array([0.0, 1e-6, 2e-6])))]
    x = first - axis * float(first @ axis)
    x /= np.linalg.norm(x)
    y = np.cross(axis, x)
    wall = np.abs(normals @ axis) < np.sin(ALIGNED_RAD)
    quarter = np.pi / 2
    angle = np.mod(np.arctan2(normals[wall] @ y, normals[wall] @ x), quarter)
    bins = round(quarter / DIRECTION_BIN_RAD)
    count = np.bincount(np.minimum((angle / DIRECTION_BIN_RAD).astype(np.int64), bins - 1), weight[wall], bins)
    wide = sum(np.roll(count, k) for k in (-2, -1, 0, 1, 2))
    peak = (int(np.argmax(np.round(wide, 12))) + 0.5) * DIRECTION_BIN_RAD
    turn = peak
    for within in REFINEMENT_RAD:
        off = np.mod(angle - turn + quarter / 2, quarter) - quarter / 2
        share = np.where(np.abs(off) < within, weight[wall], 0.0)
        turn += float(off @ share) / max(float(share.sum()), 1e-300)
    a = np.cos(turn) * x + np.sin(turn) * y
    return _near_axes(np.stack([a, np.cross(axis, a), axis]))


def _near_axes(rows: Floats) -> Floats:
    """Order and orient three directions so that they are nearest to the file axes, as a proper rotation."""
    orders = list(permutations(range(3)))
    sums = [sum(abs(float(rows[o[i], i])) for i in range(3)) for o in orders]
    order = orders[int(np.argmax(np.round(sums, 9)))]
    found = rows[list(order)]
    found = found * np.where(np.diag(found) < 0, -1.0, 1.0)[:, None]
    if np.linalg.det(found) < 0:
        found[int(np.argmin(np.round(np.diag(found), 9)))] *= -1.0
    return found


def _largest(normals: Floats, weight: Floats) -> list[Floats]:
    """Return the directions that most surface faces, opposite ones merged, the largest first."""
    sign = np.where(normals[:, 2] < -1e-6, -1.0, 1.0)
    level = np.abs(normals[:, 2]) <= 1e-6
    sign = np.where(level & (normals[:, 1] < -1e-6), -1.0, sign)
    cells = np.round(normals * sign[:, None] * 40).astype(np.int64)
    _, place = np.unique(cells, axis=0, return_inverse=True)
    place = place.reshape(-1)
    area = np.bincount(place, weight)
    ranked = np.lexsort((np.arange(len(area)), -np.round(area, 12)))[:MAX_TILTS]
    out = []
    for cell in ranked.tolist():
        rows = place == cell
        mean = (normals[rows] * (sign[rows] * weight[rows])[:, None]).sum(axis=0)
        for within in REFINEMENT_RAD:
            mean /= max(float(np.linalg.norm(mean)), 1e-300)
            along = normals @ mean
            share = np.where(np.abs(along) > np.cos(within), weight, 0.0) * np.sign(along)
            mean = (normals * share[:, None]).sum(axis=0)
            if not mean.any():
                break
        else:
            out.append(mean / np.linalg.norm(mean))
    return out


def given_frame(mesh: WeldedMesh, up: Sequence[float], front: Sequence[float]) -> Frame:
    """Return the frame for known up and front directions, file axes, at right angles to each other."""
    z = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    y = -np.asarray(front, dtype=np.float64) / np.linalg.norm(front)
    return _frame_with_axes(mesh, np.stack([np.cross(y, z), y, z]), "given")


def _frame_with_axes(mesh: WeldedMesh, rotation: Floats, reason: str) -> Frame:
    """Return the frame with these axes, centred in the bounding box of the object along them."""
    turned = mesh.points @ rotation.T
    lower, upper = turned.min(axis=0), turned.max(axis=0)
    scale = 1.0 / max(float(np.linalg.norm(upper - lower)), 1e-300)
    return Frame(rotation=rotation, origin=to_vec3((lower + upper) / 2 @ rotation), scale=scale, reason=reason)


def guess_frame(
    mesh: WeldedMesh, up: Sequence[float] | None = None, front: Sequence[float] | None = None, stated: int | None = None
) -> Frame:
    """Return the likeliest frame of an object; arguments as for `likely_frames`."""
    return likely_frames(mesh, up, front, stated)[0]


def likely_frames(
    mesh: WeldedMesh,
    up: Sequence[float] | None = None,
    front: Sequence[float] | None = None,
    stated: int | None = None,
    most: int = MAX_FRAMES,
) -> list[Frame]:
    """Return the likeliest frames of an object, which may be rotated freely in its file, the likeliest first.

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
    reason = GUESSED_REASON if up is None or front is None else "given"
    out = []
    for face, top in ranked[:most]:
        y, z = -outward[face], outward[top]
        others = [(axis_name(outward[f]), axis_name(outward[t])) for f, t in ranked[:3] if (f, t) != (face, top)]
        frame = _frame_with_axes(mesh, np.stack([np.cross(y, z), y, z]), reason)
        told = "; ".join(f"front {a}, up {b}" for a, b in others[:2])
        out.append(frame.replace(confidence=round(probabilities[face, top], 3), runner_up=told))
    return out


def candidate_probabilities(
    measured: MeasuredFragments, log_prior: Mapping[tuple[int, int], float], others: Sequence[MeasuredFragments] = ()
) -> dict[tuple[int, int], float]:
    """Return the probability of each candidate (front, top), by appearance and by the parts that it would move.

    Args:
        log_prior: of each candidate, the logarithm of its prior probability.
        others: the same mesh split in other ways; the parts of the best way count.
    """
    sides = [measure_side(measured, i) for i in range(len(SIDES))]
    inside = hidden_area(measured)
    weights = np.array(list(WEIGHTS.values()))
    scores = {}
    for candidate, prior in log_prior.items():
        features = frame_features(measured, sides, *candidate, inside)
        scores[candidate] = float(weights @ np.array([features[name] for name in WEIGHTS])) + prior
    ranked = sorted(scores, key=lambda k: (-round(scores[k], 9), k))
    probabilities = _probabilities(scores)
    likely = [c for c in ranked[:MAX_SCORED] if scores[c] > scores[ranked[0]] - MAX_LOG_ODDS_BEHIND]
    if len(likely) == 1:
        return probabilities
    weights = np.array(list(SCORE_WEIGHTS.values()))
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


def axis_name(direction: Floats) -> str:
    """Return the name of the axis nearest to a direction, such as `+x`."""
    axis = int(np.argmax(np.abs(direction)))
    return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"
