"""Friction, damping and springs of joints, from forces of a hand that a spring scale measures.

A real hinge, runner or knob resists by friction, which a hand feels when it starts to move the part, and by grease or a
damper, which limits the speed under a push of full strength. Both are chosen here from two numbers that can be measured
with a spring scale: the force that starts the part, and the time in which the strongest allowed pull opens it. Joints
of families and joints found in meshes both get their values here, so that the same door feels the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from casa_assets.core.numeric import significant

# Force that starts a door, a drawer or a lid, N: enough that it stays shut, and well under the 5 pounds-force (22.2 N)
# that operable parts may need. Ref: ADA Standards 2010, 309.4.
START_N = 7.0
# The pull under which a part has to open, N, and the time that it then takes, s; the check allows 2 s for 95 %.
PULL_N, OPENS_IN_S = 20.0, 1.3
# What is left of a pull beyond the starting force at least, N, where a spring takes the rest.
LEAST_PULL_N = 2.0
# Force that starts what fingers move, N: taps, racks and trays.
TAP_START_N, TRAY_START_N = 5.0, 6.0
# What finger and thumb turn easily: about 0.1 N*m at a knob of 40 mm, so 4.5 N at its rim.
# Ref: MIL-STD-1472G, 5.1.4.2.1.2.
KNOB_NM, KNOB_START_N = 0.09, 4.5
# Force on a key at rest, and at the end of its stroke, N. Ref: MIL-STD-1472G, 5.1.4.3.1: push buttons for a finger tip
# resist by 2.8 to 11 N.
KEY_PRELOAD_N, KEY_FULL_N = 2.2, 5.5
# Share of a falling door's weight that its spring carries at the end of its way, and of that weight, what it holds
# the door shut with.
CARRIED, SHUT = 0.94, 0.06
# A part that nothing damps still turns in grease: share of the critical time constant. By feel.
LEAST_DAMPING_S = 0.4


@dataclass(frozen=True)
class Feel:
    """Feel of a joint: damping N*m*s/rad (N*s/m), friction loss N*m (N), armature kg*m^2 (kg)."""

    damping: float
    frictionloss: float
    armature: float


def feel(inertia: float, lever: float, way: float, start_n: float, push_n: float = PULL_N) -> Feel:
    """Friction that a hand of `start_n` overcomes, and damping with which `push_n` opens the part in time.

    Args:
        inertia: inertia of everything that moves, about the axis (kg*m^2), or mass (kg) with lever 1.
        lever: distance from the axis to the hand, metres; 1 for a slide. way: whole range, rad or m.
        start_n: force at the hand that just moves the part, N. push_n: the strongest force that is used, N.
    """
    loss = start_n * lever
    drive = (push_n - start_n) * lever
    low, high = inertia / LEAST_DAMPING_S * 0.02, drive / (way / OPENS_IN_S) * 4
    if _time(inertia, low, drive, way) < OPENS_IN_S:
        for _ in range(60):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if _time(inertia, middle, drive, way) < OPENS_IN_S else (low, middle)
    return Feel(damping=_tidy(low), frictionloss=_tidy(loss), armature=_tidy(0.02 * inertia))


def feel_against(
    spring: Spring | None, inertia: float, lever: float, way: float, start_n: float = START_N, push_n: float = PULL_N
) -> Feel:
    """As `feel`, for a part with a spring that holds it shut and takes up a share of the push.

    The holding force is subtracted twice: the surplus of a weight-carrying spring over gravity may take up as much
    again.
    """
    held = abs(spring.stiffness * spring.rest) / lever if spring else 0.0
    return feel(inertia, lever, way, start_n, max(push_n - 2 * held, start_n + LEAST_PULL_N))


def _time(inertia: float, damping: float, drive: float, way: float) -> float:
    """Seconds that a constant drive needs to move a damped part over its way, from rest."""
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
    """Stiffness, N*m/rad (N/m), and rest position, at which the force is zero, rad (m)."""

    stiffness: float
    rest: float


def press(stroke: float, full_n: float, preload_n: float, sign: float = 1.0) -> Spring:
    """Spring of a button: `preload_n` at rest, `full_n` at the end of its stroke (metres, > 0)."""
    stiffness = (full_n - preload_n) / stroke
    return Spring(_tidy(stiffness), _tidy(-sign * preload_n / stiffness))


def carry(moment: float, way: float) -> Spring:
    """Spring of a door or flap that would fall open: it carries most of the weight, and holds the door shut.

    `moment`: moment of its weight about the hinge when open, N*m, > 0. `way`: angle from shut to open, rad, with the
    sign of the opening rotation.
    """
    stiffness = CARRIED * moment / abs(way)
    return Spring(_tidy(stiffness), _tidy(-math.copysign(SHUT * moment / stiffness, way)))


def _tidy(value: float) -> float:
    """Round to three significant digits, since more would be numerical noise."""
    return significant(value, 3)


# Of every key under a fingertip.
KEY = Feel(damping=2.0, frictionloss=0.05, armature=0.02)
