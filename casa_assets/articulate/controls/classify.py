"""Classify small things on a side as knob, key or neither, group by group, with a learned forest of decision trees."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from casa_assets.articulate.controls.controls import Control
from casa_assets.articulate.controls.features import CONTROL_FEATURES, Rectangle, control_features
from casa_assets.articulate.controls.groups import ControlGroup
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.segment.fragment_measures import TOP, MeasuredFragments
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.forest import Forest
from casa_assets.core.typing import Floats, Ints

ControlType = tuple[PartKind | None, float, str]
# Tells what a control is among others of its side, how sure that is, and why.
TellControl = Callable[[Control, Sequence[Control]], ControlType]

# Classes of the forest, in their order.
CONTROL_CLASSES = ("neither", PartKind.KNOB.value, PartKind.BUTTON.value)
# Probabilities are averaged as logarithms; less than this counts as this.
LEAST_PROBABILITY = 1e-4
# Probability from which on something is a knob or a key. Ref: with its source left out, of the things of the benchmark
# that are told below .5 61 % are right, of those told at .5 to .6 54 % (benchmarks/train/controls.py).
MIN_PROBABILITY = 0.45
# The same on the top, where little else is round and in rows. Ref: with its source left out, of drawn things on the top
# 306 fewer controls are lost than from .45 on, and 63 more things are told as one.
MIN_PROBABILITY_ON_TOP = 0.33
# What is neither with at most this probability is the likelier of the two, unsure as that may be: without this rule
# whole rows of knobs of fused shells were lost. From a third on, the forest says nothing.
MAX_PROBABILITY_OF_NEITHER = 0.3
# What stands out by less than this, diagonals, is printed or stuck on. Unless it is round, so many alike and more
# are flat keys, where distances between them differ by at most this share of their mean: those of letters vary.
MAX_FLAT_PROTRUSION, MIN_FLAT_KEYS, MAX_FLAT_IRREGULARITY = 0.0015, 3, 0.3
# Round keys of toasters are at most this wide by their dials.
MAX_KEY_BY_DIAL = 0.8
# A side with more small things than this is no front with controls, but a lattice or a scan in pieces.
MAX_CONTROLS = 1000


def tell_by_forest(
    measured: MeasuredFragments,
    side: int,
    controls: Sequence[Control],
    panels: Sequence[Rectangle],
    forest: Forest,
) -> TellControl:
    """Return the type of each control of a side: all of a group have the type that fits the group best.

    Args:
        panels: (2,) lower and upper corner in (u, v) of each panel of the side.
    """
    told: dict[tuple[int, ...], ControlType] = {}
    if 0 < len(controls) <= MAX_CONTROLS:
        features, groups = control_features(measured, side, controls, panels)
        chances = forest.probabilities(features)
        for group in groups:
            rows = list(group.members)
            is_flat = max(controls[i].protrusion for i in rows) <= MAX_FLAT_PROTRUSION
            is_regular = len(rows) >= MIN_FLAT_KEYS and group.irregularity <= MAX_FLAT_IRREGULARITY
            is_mark = is_flat and not is_regular and group.round_share < 0.5
            found = (None, 0.0, "") if is_mark else _type(pooled(chances[rows]), group, side == TOP)
            told |= {tuple(controls[i].fragments): found for i in rows}
    return lambda control, _others: told.get(tuple(control.fragments), (None, 0.0, ""))


def tell_beside_dials(tell: TellControl) -> TellControl:
    """Return a classifier for the controls of a toaster: round ones that are clearly smaller than its dials are keys.

    Args:
        tell: classifies a control by its form and place alone.
    """

    def told(control: Control, others: Sequence[Control]) -> ControlType:
        kind, confidence, reason = tell(control, others)
        if kind is not PartKind.KNOB:
            return kind, confidence, reason
        width = max(float(o.across.max()) for o in (control, *others) if tell(o, others)[0] is PartKind.KNOB)
        if float(control.across.max()) > MAX_KEY_BY_DIAL * width:
            return kind, confidence, reason
        return PartKind.BUTTON, confidence, "smaller than the dial beside it"

    return told


def pooled(chances: Floats) -> Floats:
    """Return the (C,) probabilities of a group from the (N, C) ones of its members: their geometric mean."""
    mean = np.exp(np.log(np.maximum(chances, LEAST_PROBABILITY)).mean(axis=0))
    found: Floats = mean / mean.sum()
    return found


def decided(chances: Floats, on_top: Bools) -> Ints:
    """Return the (N,) indices in CONTROL_CLASSES for (N, C) probabilities: a knob or key is at least rather likely.

    Args:
        on_top: (N,) whether each is on the top, where less will do.
    """
    best = 1 + chances[:, 1:].argmax(axis=1)
    least = np.where(on_top, MIN_PROBABILITY_ON_TOP, MIN_PROBABILITY)
    is_one = chances[np.arange(len(chances)), best] >= least
    found: Ints = np.where(is_one | (chances[:, 0] <= MAX_PROBABILITY_OF_NEITHER), best, 0)
    return found


def _type(chances: Floats, group: ControlGroup, on_top: bool) -> ControlType:
    """Return the type of a group, its probability and a reason."""
    best = int(decided(chances[None], np.array([on_top]))[0])
    if best == 0:
        return None, 0.0, ""
    count = len(group.members)
    shape = "stands alone" if count == 1 else f"{count} alike in {group.rows} rows and {group.columns} columns"
    return PartKind(CONTROL_CLASSES[best]), float(chances[best]), f"{shape}, by form and place"


def check_forest(forest: Forest) -> Forest:
    """Return a forest that knows the features and types of controls. Raises ValueError for another."""
    if forest.features != CONTROL_FEATURES or forest.classes != CONTROL_CLASSES:
        raise ValueError("a forest for other features or types than those of controls")
    return forest
