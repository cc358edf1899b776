"""Tell round buttons from other round things: the single button on a front, and burner caps on a top."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.controls.controls import Control, find_controls, has_round_outline
from casa_assets.articulate.fronts.panels import find_panels
from casa_assets.articulate.plan import JointPlan
from casa_assets.articulate.segment.fragment_measures import FRONT, SIDES, MeasuredFragments
from casa_assets.model.asset.joint import JointKind

# Width of a single button, diagonals (a ring around a button is wider than a button), its least protrusion, and its
# most by its width.
MAX_BUTTON_WIDTH, MIN_PROTRUSION, MAX_PROTRUSION_BY_WIDTH = 0.22, 0.004, 0.6

# Burner caps are surrounded by slim arms that bear pans: fewest arms, their length to width, and their distance from
# the cap by its width. The knobs of an object are alike: from so many knobs on its front on, a round control of another
# width on the top is none.
MIN_PAN_SUPPORT_ARMS, MIN_ARM_RATIO, MAX_ARM_GAP_BY_WIDTH, MIN_FRONT_KNOBS, KNOB_WIDTH_TOLERANCE = 3, 4.0, 0.5, 2, 0.25


def drop_burner_caps(over: Sequence[Control], top: Sequence[Control], front: Sequence[Control]) -> list[Control]:
    """Return the round controls on the top without the caps of burners.

    Args:
        over: round things that may be knobs. top, front: all controls of those sides.
    """
    knobs = [float(c.across.max()) for c in front if c.is_round and c.protrusion >= MIN_PROTRUSION]
    usual = float(np.median(knobs)) if len(knobs) >= MIN_FRONT_KNOBS else 0.0
    alike = [c for c in over if not usual or abs(float(c.across.max()) - usual) <= KNOB_WIDTH_TOLERANCE * usual]
    return [c for c in alike if len({_way(c, a) for a in top if _is_arm(c, a)}) < MIN_PAN_SUPPORT_ARMS]


def _is_arm(cap: Control, bar: Control) -> bool:
    """Return whether something slim begins at the rim of a cap, or nearly."""
    if bar.long < MIN_ARM_RATIO:
        return False
    middle = cap.middle
    nearest = np.clip(middle, bar.lower[:2], bar.upper[:2])
    away = float(np.linalg.norm(nearest - middle)) / float(cap.across.max())
    return 0.0 < away <= 0.5 + MAX_ARM_GAP_BY_WIDTH


def _way(cap: Control, bar: Control) -> int:
    """The side of a cap on which something is: right, up, left, down."""
    x, y = (float(v) for v in bar.middle - cap.middle)
    return int(np.round(np.arctan2(y, x) / (np.pi / 2))) % 4


def find_single_button(measured: MeasuredFragments) -> Control | None:
    """Return what is round on a front, where there is one such thing and no more."""
    found = [c for c in find_controls(measured, FRONT, []) if c.is_round]
    taken = {f for c in found for f in c.fragments}
    for panel in find_panels(measured, FRONT):
        across = (panel.upper - panel.lower)[:2]
        own = sorted(panel.members)
        if (
            taken.isdisjoint(own)
            and float(across.max()) <= MAX_BUTTON_WIDTH
            and has_round_outline(measured, FRONT, own, across)
        ):
            found.append(Control(own, panel.lower, panel.upper, float(panel.upper[2] - panel.lower[2]), True))
    standing = [c for c in found if MIN_PROTRUSION <= c.protrusion <= MAX_PROTRUSION_BY_WIDTH * float(c.across.max())]
    return standing[0] if len(standing) == 1 else None


def button_joint(key: Control, way: float) -> JointPlan:
    """Return the joint of a push button, with a travel of `way` diagonals at most."""
    x, y, z = (float(v) for v in (key.lower + key.upper) / 2 @ SIDES[FRONT])
    into_x, into_y, into_z = (float(v) for v in SIDES[FRONT][2])
    return JointPlan(
        kind=JointKind.SLIDE,
        axis=(into_x, into_y, into_z),
        anchor=(x, y, z),
        range=(0.0, min(way, 0.5 * key.protrusion)),
        confidence=0.45,
        reason="round, and all that stands out of its front",
    )
