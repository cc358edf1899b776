"""The one key of what somebody calls an appliance and of which nothing else moves: round, alone on its front."""

from __future__ import annotations

from casa_assets.articulate.controls import Control, find_controls, is_round
from casa_assets.articulate.panels import find_panels
from casa_assets.articulate.pieces import FRONT, SIDES, Pieces
from casa_assets.articulate.plan import JointPlan
from casa_assets.model.joint import JointKind

# It is no wider than this, diagonals: a ring round a key is wider than keys are. It stands out so far at least, and by
# its width at most.
WIDEST, LEAST_OUT, MOST_OUT = 0.22, 0.004, 0.6


def sole_key(pieces: Pieces) -> Control | None:
    """What is round on a front, where there is one such thing and no more."""
    found = [c for c in find_controls(pieces, FRONT, []) if c.round]
    taken = {f for c in found for f in c.fragments}
    for panel in find_panels(pieces, FRONT):
        across = (panel.high - panel.low)[:2]
        own = sorted(panel.members)
        if taken.isdisjoint(own) and float(across.max()) <= WIDEST and is_round(pieces, FRONT, own, across):
            found.append(Control(own, panel.low, panel.high, float(panel.high[2] - panel.low[2]), True))
    standing = [c for c in found if LEAST_OUT <= c.stands <= MOST_OUT * float(c.across.max())]
    return standing[0] if len(standing) == 1 else None


def key_joint(key: Control, way: float) -> JointPlan:
    """How it is pressed, `way` diagonals at most."""
    x, y, z = (float(v) for v in (key.low + key.high) / 2 @ SIDES[FRONT])
    into_x, into_y, into_z = (float(v) for v in SIDES[FRONT][2])
    return JointPlan(
        kind=JointKind.SLIDE,
        axis=(into_x, into_y, into_z),
        anchor=(x, y, z),
        range=(0.0, min(way, 0.5 * key.stands)),
        confidence=0.45,
        because="round, and all that stands out of its front",
    )
