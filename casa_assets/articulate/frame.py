"""Which way is up, and where the front is: the walls laid along axes, then twenty-four candidates weighed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from casa_assets.articulate.evidence import FEATURES, evidence, hidden_area
from casa_assets.articulate.fragments import fragment_labels
from casa_assets.articulate.pieces import SIDES, measure
from casa_assets.articulate.plan import Frame
from casa_assets.articulate.sides import look
from casa_assets.articulate.soup import Floats, Soup
from casa_assets.articulate.turn import straightened

# Weight of each feature in the log odds of a candidate; those that earn none are left out. Ref: conditional logit over
# members of this project's own families, merged into one mesh each (benchmarks/train_frame.py).
WEIGHTS: Mapping[str, float] = {
    "front_detail": 6.64,
    "back_detail": -3.724,
    "front_juts": 2.396,
    "back_juts": -1.427,
    "bottom_juts": -0.321,
    "front_knobs": 0.1867,
    "back_knobs": -1.082,
    "sides_knobs": -1.893,
    "front_bars": 1.116,
    "back_bars": -0.03039,
    "top_bars": -0.04447,
    "bottom_bars": -0.2208,
    "sides_bars": -0.6546,
    "front_panels": 0.1883,
    "back_panels": -0.7066,
    "front_stands": 3.035,
    "sides_stands": -2.926,
    "symmetry": 2.633,
    "front_level": 1.31,
    "support": 0.3304,
    "shape": 0.8908,
    "inside_upright": -4.334,
    "bars_high": 0.4069,
    "knobs_high": 1.57,
    "top_rings": 3.397,
    "top_slots": 1.052,
    "knobs_near": 2.383,
    "low_mass": -1.505,
    "back_plain": 0.2294,
}
# Prior of the axis that points up where a file says nothing, by the side that is then the top: modellers write y up
# or z up, hardly anything else.
PRIOR_UP = (0.02, 0.42, 0.02, 0.02, 0.5, 0.02)
STATED_UP, ASKEW_UP = 0.95, 0.02
PIXELS = 256
GUESSED = "detail, handles, proportions and symmetry of the six sides"


def given_frame(soup: Soup, up: Sequence[float], front: Sequence[float]) -> Frame:
    """The frame of a thing whose up and front directions are known, file axes; they are at right angles."""
    z = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    y = -np.asarray(front, dtype=np.float64) / np.linalg.norm(front)
    return _framed(soup, np.stack([np.cross(y, z), y, z]))


def _framed(soup: Soup, rotation: Floats) -> Frame:
    """The frame with these axes, in the middle of the box that they make round the thing."""
    turned = soup.points @ rotation.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    a, b, c = (float(v) for v in (low + high) / 2 @ rotation)
    scale = 1.0 / max(float(np.linalg.norm(high - low)), 1e-300)
    return Frame(rotation=rotation, origin=(a, b, c), scale=scale, because="given")


def guess_frame(
    soup: Soup, up: Sequence[float] | None = None, front: Sequence[float] | None = None, stated: int | None = None
) -> Frame:
    """The likeliest frame of a thing, which may stand askew in its file.

    Args:
        soup: file axes and units.
        up, front: directions that the user gave, file axes; None to guess. They hold within 45 degrees where walls of
            the thing run along others, but `up` exactly.
        stated: side (of SIDES) that is the top by the file's word; believed, but not blindly.
    """
    straight = straightened(soup, [d for d in (up, front) if d is not None][:1])
    plain = _framed(soup, straight)
    placed = soup.placed(plain.rotation, np.array(plain.origin), plain.scale)
    pieces = measure(placed, fragment_labels(placed), PIXELS)
    sides = [look(pieces, i) for i in range(len(SIDES))]
    inside = hidden_area(pieces)
    rows = [FEATURES.index(name) for name in WEIGHTS]
    weights = np.array(list(WEIGHTS.values()))
    scores: dict[tuple[int, int], float] = {}
    for top in range(len(SIDES)):
        for face in range(len(SIDES)):
            into, down = SIDES[face][2] @ straight, SIDES[top][2] @ straight
            if face // 2 == top // 2 or not (_fits(up, -down) and _fits(front, -into)):
                continue
            told = float(weights @ evidence(pieces, sides, face, top, inside)[rows])
            scores[face, top] = told + float(np.log(_prior(-down, stated)))
    ranked = sorted(scores, key=lambda k: (-round(scores[k], 9), k))
    odds = np.exp(np.array([scores[k] for k in ranked]) - scores[ranked[0]])
    face, top = ranked[0]
    y, z = SIDES[face][2] @ straight, -SIDES[top][2] @ straight
    return _framed(soup, np.stack([np.cross(y, z), y, z])).replace(
        confidence=round(float(1 / odds.sum()), 3),
        because="detail, handles, proportions and symmetry of the six sides"
        if up is None or front is None
        else "given",
        runner_up="; ".join(_words(k, straight) for k in ranked[1:3]),
    )


def _fits(wanted: Sequence[float] | None, direction: Floats) -> bool:
    """Whether a direction is the wanted one of those along the walls, or none is wanted."""
    if wanted is None:
        return True
    return float(direction @ np.asarray(wanted, dtype=np.float64)) > 0.7 * float(np.linalg.norm(wanted))


def _prior(up: Floats, stated: int | None) -> float:
    """Prior of a direction of the file pointing up."""
    near = -SIDES[:, 2] @ up
    side = int(np.argmax(near))
    if float(near[side]) < 0.99:
        return ASKEW_UP
    if stated is None:
        return PRIOR_UP[side]
    return STATED_UP if side == stated else (1 - STATED_UP) / 5


def _words(candidate: tuple[int, int], straight: Floats) -> str:
    face, top = candidate
    return f"front {axis_name(-SIDES[face][2] @ straight)}, up {axis_name(-SIDES[top][2] @ straight)}"


def axis_name(direction: Floats) -> str:
    """Such as `+x` for a direction nearest to that axis."""
    axis = int(np.argmax(np.abs(direction)))
    return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"
