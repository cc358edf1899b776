"""Find the turning handles of faucets, and the spout beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.controls.controls import MIN_STICK_RATIO, has_round_outline
from casa_assets.articulate.plan import JointPlan, PartKind
from casa_assets.articulate.segment.fragment_measures import TOP, MeasuredFragments
from casa_assets.core.typing import Floats
from casa_assets.model.asset.joint import JointKind

# The root of a stick lies across it: length to thickness, ratio of its two thicknesses, its length by that of the
# stick, its thickness by the width of the stick. More sticks than MAX_HANDLES are those of a rack.
MIN_ROOT_RATIO, MAX_ROUND_RATIO, MAX_ROOT_LENGTH, MAX_ROOT_THICKNESS, MAX_HANDLES = 1.3, 1.4, 1.5, 8.0, 2
# Width and length of a stick, diagonals, and the share of its length that stands out of its root.
MIN_HANDLE_WIDTH, MAX_HANDLE_WIDTH, MAX_HANDLE_LENGTH, MIN_HANDLE_OUT_SHARE = 0.005, 0.04, 0.25, 0.5
# Widest gap between fragments that belong together, diagonals.
MAX_GAP = 0.01
# Arm of a spout: length to width, and length in diagonals; height to width of the round column below it, whose width is
# that of the arm within the tolerance.
MIN_ARM_RATIO, MIN_ARM_LENGTH, MIN_COLUMN_RATIO, WIDTH_TOLERANCE = 3.0, 0.15, 2.0, 0.5
# Range of a handle from its closed pose, a quarter turn; of a spout to each side.
HANDLE_RANGE_RAD, SPOUT_RANGE_RAD = np.pi / 2, np.pi / 2


@dataclass(frozen=True)
class FaucetHandle:
    """A stick that turns about the fragment that it is rooted in.

    Attributes:
        fragments: it. axis: (3,) unit direction about which it turns. anchor: (3,) a point of that.
    """

    fragments: list[int]
    axis: Floats
    anchor: Floats


@dataclass(frozen=True)
class Spout:
    """An arm on a column, about which it swivels: fragments, and (3,) a point of the column's axis."""

    fragments: list[int]
    anchor: Floats


def find_faucet_parts(measured: MeasuredFragments, taken: set[int]) -> list[tuple[PartKind, list[int], JointPlan]]:
    """Return turning handles on top and the spout beside them: kind, fragments and joint of each.

    Args:
        taken: fragments of other parts.
    """
    sticks = find_faucet_handles(measured, taken)
    found = [(PartKind.LEVER, s.fragments, faucet_joint(s)) for s in sticks]
    spout = find_spout(measured, taken | {f for s in sticks for f in s.fragments}) if sticks else None
    return found if spout is None else [*found, (PartKind.SPOUT, spout.fragments, faucet_joint(spout))]


def find_faucet_handles(measured: MeasuredFragments, taken: set[int]) -> list[FaucetHandle]:
    """Return long upright sticks that stand across what they are rooted in; none where there are many."""
    size = measured.upper - measured.lower
    wide, least = size[:, :2].max(axis=1), size[:, :2].min(axis=1)
    slim = (
        (size[:, 2] >= MIN_STICK_RATIO * wide)
        & (wide <= MAX_ROUND_RATIO * least)
        & (wide >= MIN_HANDLE_WIDTH)
        & (wide <= MAX_HANDLE_WIDTH)
    )
    slim &= (size[:, 2] <= MAX_HANDLE_LENGTH) & (measured.visible_area[:, TOP] > 0)
    slim[sorted(taken)] = False
    found, hosts = [], []
    for i in np.flatnonzero(slim).tolist():
        host = _root(measured, i)
        if host is not None:
            axis = np.eye(3)[int(np.argmax(size[host]))]
            found.append(FaucetHandle([i], axis, (measured.lower[host] + measured.upper[host]) / 2))
            hosts.append(host)
    return found if len(found) <= MAX_HANDLES and len(set(hosts)) == len(hosts) else []


def _root(measured: MeasuredFragments, stick: int) -> int | None:
    """Return the smallest fragment that a stick is rooted in and stands across; None where there is none."""
    lower, upper = measured.lower[stick], measured.upper[stick]
    length, wide = float(upper[2] - lower[2]), float((upper - lower)[:2].max())
    root = (lower + upper) / 2
    root[2] = lower[2]
    near = ((measured.lower <= root + MAX_GAP) & (measured.upper >= root - MAX_GAP)).all(axis=1)
    near &= measured.upper[:, 2] <= upper[2] - MIN_HANDLE_OUT_SHARE * length
    near[stick] = False
    fits = []
    for i in np.flatnonzero(near).tolist():
        size = measured.upper[i] - measured.lower[i]
        along = int(np.argmax(size))
        others = np.sort(np.delete(size, along))
        slim = size[along] >= MIN_ROOT_RATIO * others[1] and others[1] <= MAX_ROUND_RATIO * max(float(others[0]), 1e-9)
        if along != 2 and slim and size[along] <= MAX_ROOT_LENGTH * length and others[1] <= MAX_ROOT_THICKNESS * wide:
            fits.append(i)
    return min(fits, key=lambda i: (round(float(measured.area[i]), 9), i)) if fits else None


def find_spout(measured: MeasuredFragments, taken: set[int]) -> Spout | None:
    """Return the longest level arm over a round column, on an object that has faucet handles."""
    size = measured.upper - measured.lower
    arms = [i for i in range(measured.count) if i not in taken and _is_arm(size[i])]
    for arm in sorted(arms, key=lambda i: (-round(float(size[i, :2].max()), 9), i)):
        along = int(np.argmax(size[arm, :2]))
        for i in range(measured.count):
            wide = float(size[i, :2].max())
            if (
                i in taken
                or i == arm
                or size[i, 2] < MIN_COLUMN_RATIO * wide
                or not has_round_outline(measured, TOP, [i], size[i, :2])
            ):
                continue
            like = abs(wide - float(size[arm, 1 - along])) <= WIDTH_TOLERANCE * wide
            under = (
                measured.upper[i, 2] <= measured.upper[arm, 2]
                and measured.upper[i, 2] >= measured.lower[arm, 2] - MAX_GAP
            )
            ends = (
                measured.lower[arm, along] - measured.lower[i, along],
                measured.upper[arm, along] - measured.upper[i, along],
            )
            at_end = min(abs(float(e)) for e in ends) <= MAX_GAP
            middle: Floats = (measured.lower[i] + measured.upper[i]) / 2
            over = bool(((middle >= measured.lower[arm]) & (middle <= measured.upper[arm]))[:2].all())
            if like and under and at_end and over:
                return Spout(sorted((arm, i)), middle)
    return None


def _is_arm(size: Floats) -> bool:
    """Return whether the size of a fragment is that of a level bar."""
    return float(size[:2].max()) >= max(MIN_ARM_LENGTH, MIN_ARM_RATIO * float(size[:2].min()))


def faucet_joint(tap: FaucetHandle | Spout) -> JointPlan:
    """Return the hinge of a faucet handle or a spout."""
    if isinstance(tap, FaucetHandle):
        axis, span = tap.axis, (0.0, HANDLE_RANGE_RAD)
        reason = "a stick across what it is rooted in"
    else:
        axis, span = np.array([0.0, 0.0, 1.0]), (-SPOUT_RANGE_RAD, SPOUT_RANGE_RAD)
        reason = "an arm over a round column, beside sticks"
    x, y, z = (float(v) for v in axis)
    a, b, c = (float(v) for v in tap.anchor)
    return JointPlan(kind=JointKind.HINGE, axis=(x, y, z), anchor=(a, b, c), range=span, confidence=0.5, reason=reason)
