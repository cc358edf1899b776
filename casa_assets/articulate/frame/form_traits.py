"""Detect by form alone, before any joint is decided, whether an object has fronts, controls or legs, and which."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.segment.fragment_measures import FRONT, MeasuredFragments

# Width to height of a wide front, and of a tall one; share of the side that one covering front has at least.
MIN_WIDE_RATIO, MAX_TALL_RATIO, MIN_COVERING_SHARE = 1.2, 0.8, 0.4
# Knobs in a row, and keys of a key pad, at least.
MIN_ROW, MIN_KEYS = 3, 6
# Fronts that differ by less in size and height are a pair, diagonals.
PAIR_TOLERANCE = 0.015
# A thing stands on legs where, in the stretch of its height between these shares, at most so much of its width is seen.
LEGS_STRETCH, MAX_LEGS_SHARE = (0.03, 0.1), 0.5


def form_traits(
    measured: MeasuredFragments,
    panels: Sequence[Panel],
    controls: Sequence[PartKind],
    beside: float,
    has_top_knobs: bool,
) -> dict[str, bool]:
    """Return traits of KIND_TRAITS (frame/kind.py), and whether the object has each.

    Args:
        panels: those that open.
        controls: types of the controls of the front. beside: share of them that lie next to the largest front.
        has_top_knobs: whether there are knobs on its top.
    """
    extent = np.ptp(measured.mesh.points, axis=0)
    largest = max(panels, key=lambda p: p.width * p.height, default=None)
    ratio = largest.width / max(largest.height, 1e-9) if largest is not None else 1.0
    share = largest.width * largest.height / float(extent[0] * extent[2]) if largest is not None else 0.0
    knobs = sum(c is PartKind.KNOB for c in controls)
    buttons = sum(c is PartKind.BUTTON for c in controls)
    return {
        **({"fronts": len(panels) > 1} if panels else {"door": False, "drawer": False}),
        "knobs": knobs > 0 or has_top_knobs,
        "above": has_top_knobs,
        "buttons": buttons > 0,
        "beside": beside > 0.5,
        "row": knobs >= MIN_ROW,
        "keys": buttons >= MIN_KEYS,
        "pair": any(_are_pair(a, b) for i, a in enumerate(panels) for b in panels[:i]),
        "wide": largest is not None and ratio > MIN_WIDE_RATIO,
        "tall": largest is not None and ratio < MAX_TALL_RATIO,
        "covers": share > MIN_COVERING_SHARE,
        "legs": stands_on_legs(measured),
        "round": any(p.is_round for p in panels),
    }


def _are_pair(a: Panel, b: Panel) -> bool:
    """Return whether two panels of the same size lie side by side."""
    away = np.abs([a.lower[1] - b.lower[1], a.upper[1] - b.upper[1], a.width - b.width]).max()
    return float(away) < PAIR_TOLERANCE


def stands_on_legs(measured: MeasuredFragments) -> bool:
    """Return whether one sees past a thing near the floor, between its legs."""
    seen = measured.depth_images[FRONT].face >= 0
    rows = np.flatnonzero(seen.any(axis=1))
    columns = np.flatnonzero(seen.any(axis=0))
    if not len(rows):
        return False
    high = len(rows)
    first, last = (rows[-1] + 1 - round(s * high) for s in reversed(LEGS_STRETCH))
    band = seen[first : max(last, first + 1), columns[0] : columns[-1] + 1]
    return bool(band.mean() < MAX_LEGS_SHARE) if band.size else False
