"""How hard a part moves: friction and damping from the force of a hand.

A real hinge, runner or knob resists by friction, which is what a hand feels when it starts, and by grease or a damper,
which sets how fast a push of full strength takes it along. Both are chosen here from two numbers that can be measured
with a spring scale: the force that starts the part, and the time in which the strongest allowed pull opens it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# Ref: ADA Standards 2010, 309.4: operable parts need no more than 5 pounds-force.
MOST_N = 22.2
# The pull under which a part has to open, and the time that it then takes; the check allows 2 s for 95 %.
PULL_N, OPENS_IN_S = 20.0, 1.3
# A part that nothing damps still turns in grease: share of the critical time constant. By feel.
LEAST_DAMPING_S = 0.4


@dataclass(frozen=True)
class Feel:
    """What a joint is like: damping N*m*s/rad (N*s/m), friction loss N*m (N), armature kg*m^2 (kg)."""

    damping: float
    frictionloss: float
    armature: float


def feel(inertia: float, lever: float, way: float, start_n: float, push_n: float = PULL_N) -> Feel:
    """Friction that a hand of `start_n` overcomes, and damping under which `push_n` opens the part in time.

    Args:
        inertia: of all that moves, about the axis (kg*m^2), or mass (kg) with lever 1.
        lever: from the axis to the hand, metres; 1 for a slide.
        way: whole range, rad or m.
        start_n: force at the hand that just moves it, N.
        push_n: the strongest force that is used, N.
    """
    loss = start_n * lever
    drive = (push_n - start_n) * lever
    low, high = inertia / LEAST_DAMPING_S * 0.02, drive / (way / OPENS_IN_S) * 4
    if _time(inertia, low, drive, way) < OPENS_IN_S:
        for _ in range(60):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if _time(inertia, middle, drive, way) < OPENS_IN_S else (low, middle)
    return Feel(damping=_tidy(low), frictionloss=_tidy(loss), armature=_tidy(0.02 * inertia))


def _time(inertia: float, damping: float, drive: float, way: float) -> float:
    """Seconds in which a constant drive moves a damped part over its way, from rest."""
    fastest, settle = drive / damping, inertia / damping
    # way = fastest * (t - settle * (1 - exp(-t / settle))), solved by halving.
    low, high = 0.0, way / fastest + settle + 1e-9
    high += math.sqrt(2 * way * inertia / drive)
    for _ in range(60):
        t = (low + high) / 2
        gone = fastest * (t + settle * math.expm1(-t / settle))
        low, high = (t, high) if gone < way else (low, t)
    return high


@dataclass(frozen=True)
class Spring:
    """Stiffness N*m/rad (N/m) and the position at which it pushes no more, rad (m)."""

    stiffness: float
    rest: float


def press(stroke: float, full_n: float, preload_n: float, sign: float = 1.0) -> Spring:
    """The spring of a button: `preload_n` at rest, `full_n` at the end of its stroke (metres, > 0)."""
    stiffness = (full_n - preload_n) / stroke
    return Spring(_tidy(stiffness), _tidy(-sign * preload_n / stiffness))


def balance(weight: float, reach: float, way: float, sign: float) -> Spring:
    """The spring of a flap that folds down from upright: it carries the flap's weight over its range, and closes it.

    Args:
        weight: N. reach: from the hinge to the centre of mass, metres. way: rad. sign: of the opening turn.
    """
    moment = weight * reach
    # Best straight line through the sine over the way; a little more holds it shut.
    stiffness = moment * math.sin(way) / way * 0.94 if way > 0.3 else moment
    shut = 0.06 * moment
    return Spring(_tidy(stiffness), _tidy(-sign * shut / stiffness))


def _tidy(value: float) -> float:
    """Three digits: more would be noise of the arithmetic."""
    return float(f"{value:.3g}")
