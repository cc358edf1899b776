"""Which way is up, and where the front is: twenty-four candidates weighed by what the sides look like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from casa_assets.articulate.fragments import fragment_labels
from casa_assets.articulate.pieces import SIDES, measure
from casa_assets.articulate.plan import Frame
from casa_assets.articulate.sides import FEATURES, evidence, look
from casa_assets.articulate.soup import Floats, Soup

# Weight of each feature in the log odds of a candidate. Ref: conditional logit over 108 members of this project's own
# families, merged into one mesh each (benchmarks/train_frame.py).
WEIGHTS: Mapping[str, float] = {
    "front_detail": 6.358,
    "back_detail": -11.2,
    "top_detail": -0.923,
    "bottom_detail": 0.3892,
    "front_panels": 0.9033,
    "back_panels": -0.3079,
    "front_stands": 6.305,
    "back_stands": -4.405,
    "top_stands": 9.354,
    "front_mirror": 2.474,
    "top_mirror": 5.605,
    "side_mirror": -1.55,
    "height": 1.121,
    "width": 0.3101,
    "bottom_flat": -4.315,
    "top_flat": 2.179,
    "low_mass": -17.67,
    "bottom_wide": 2.994,
    "front_flat": -2.421,
    "level_bars": -0.2562,
    "inside_level": 1.349,
    "inside_upright": -3.937,
}
# Prior of the axis that points up where a file says nothing, by the side that is then the top: modellers write y up
# or z up, hardly anything else.
PRIOR_UP = (0.02, 0.42, 0.02, 0.02, 0.5, 0.02)
STATED_UP = 0.95
PIXELS = 256


def given_frame(soup: Soup, up: Sequence[float], front: Sequence[float]) -> Frame:
    """The frame of a thing whose up and front directions are known, file axes; they are at right angles."""
    z = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    y = -np.asarray(front, dtype=np.float64) / np.linalg.norm(front)
    low, high = soup.points.min(axis=0), soup.points.max(axis=0)
    a, b, c = (float(v) for v in (low + high) / 2)
    rotation = np.stack([np.cross(y, z), y, z])
    return Frame(rotation=rotation, origin=(a, b, c), scale=1.0 / max(soup.diagonal, 1e-300), because="given")


def guess_frame(
    soup: Soup, up: Sequence[float] | None = None, front: Sequence[float] | None = None, stated: int | None = None
) -> Frame:
    """The likeliest frame of a thing.

    Args:
        soup: file axes and units.
        up, front: directions that the user gave, along axes of the file; None to guess.
        stated: side (of SIDES) that is the top by the file's word; believed, but not blindly.
    """
    plain = given_frame(soup, (0, 0, 1), (0, -1, 0))
    placed = soup.placed(plain.rotation, np.array(plain.origin), plain.scale)
    pieces = measure(placed, fragment_labels(placed), PIXELS)
    sides = [look(pieces, i) for i in range(len(SIDES))]
    weights = np.array([WEIGHTS[name] for name in FEATURES])
    scores: dict[tuple[int, int], float] = {}
    for top in range(len(SIDES)):
        for face in range(len(SIDES)):
            if face // 2 == top // 2 or not (_fits(up, top) and _fits(front, face)):
                continue
            prior = PRIOR_UP[top] if stated is None else STATED_UP if top == stated else (1 - STATED_UP) / 5
            scores[face, top] = float(weights @ evidence(pieces, sides, face, top)) + float(np.log(prior))
    ranked = sorted(scores, key=lambda k: (-round(scores[k], 9), k))
    best = ranked[0]
    odds = np.exp(np.array([scores[k] for k in ranked]) - scores[best])
    frame = given_frame(soup, -SIDES[best[1]][2], -SIDES[best[0]][2])
    return frame.replace(
        confidence=round(float(1 / odds.sum()), 3),
        because="detail, panels and symmetry of the six sides" if up is None or front is None else "given",
        runner_up="; ".join(_words(k) for k in ranked[1:3]),
    )


def _fits(wanted: Sequence[float] | None, side: int) -> bool:
    """Whether a side faces a wanted direction, or none is wanted."""
    if wanted is None:
        return True
    return float(-SIDES[side][2] @ np.asarray(wanted, dtype=np.float64)) > 0.7 * float(np.linalg.norm(wanted))


def _words(candidate: tuple[int, int]) -> str:
    face, top = candidate
    return f"front {axis_name(-SIDES[face][2])}, up {axis_name(-SIDES[top][2])}"


def axis_name(direction: Floats) -> str:
    """Such as `+x` for a direction along an axis."""
    axis = int(np.argmax(np.abs(direction)))
    return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"
