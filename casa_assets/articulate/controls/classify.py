"""Classify small things on a side as knob, key or neither, group by group, with a learned forest of decision trees."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from casa_assets.articulate.controls.controls import (
    MIN_ROUND_SHARE_OF_ROW,
    MIN_ROW_LENGTH,
    Control,
    ControlGroup,
    depth_around,
    group_controls,
)
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import SIDES, TOP, outline_area
from casa_assets.core.numeric import Floats, Forest, Ints, Mask

# Lengths are in diagonals of the object or by the size of what the name says; all are 0 where there is none.
CONTROL_FEATURES = (
    *("log_width", "narrowness", "upright", "protrusion_by_width", "protrusion", "depth_by_width", "ellipse_fill"),
    *("is_round", "log_fragments", "tip_by_base", "picture_fill", "ground_share", "group_count", "group_rows"),
    *("group_columns", "group_pitch", "group_irregularity", "group_round_share", "group_largest_by_this", "others"),
    *("other_round", "away_from_middle", "height", "on_top", "panel_share", "panel_controls", "width_by_panel"),
    *("beside_panel", "above_panel", "panel_away_from_middle", "panel_height", "largest_panel", "panels"),
    *("object_width_by_height", "object_depth_by_height"),
)
# A panel is large from this share of its side on; the tip of a control is this share of its depth.
LARGE_PANEL_SHARE, TIP_SHARE = 0.08, 0.3
Rectangle = tuple[Floats, Floats]  # (2,) lower and upper corner of a panel in (u, v)
ControlType = tuple[PartKind | None, float, str]
# Type of a control among others of its side, how sure it is, and why.
ControlClassifier = Callable[[Control, Sequence[Control]], ControlType]
# Classes of the forest, in their order.
CONTROL_CLASSES = ("neither", PartKind.KNOB.value, PartKind.BUTTON.value)
# Probabilities are averaged as logarithms; less than this counts as this.
LEAST_PROBABILITY = 1e-4
# Probability from which on something is a knob or a key. Ref: with its source left out, of the things of the benchmark
# below .5 61 % are right, of those at .5 to .6 54 % (benchmarks/train/controls.py).
MIN_PROBABILITY = 0.45
# The same on the top, where little else is round and in rows. Ref: with its source left out, of drawn things on the top
# 306 fewer controls are lost than from .45 on, and 63 more things are taken for one.
MIN_PROBABILITY_ON_TOP = 0.33
# What is neither with at most this probability is the likelier of the two, unsure as that may be: without this rule
# whole rows of knobs of fused shells were lost. From a third on, the forest says nothing.
MAX_PROBABILITY_OF_NEITHER = 0.3
# What stands out by less than this, diagonals, is printed or stuck on. Unless it is round, this many alike and more
# are flat keys, where distances between them differ by at most this share of their mean: those of letters vary.
MAX_FLAT_PROTRUSION, MIN_FLAT_KEYS, MAX_FLAT_IRREGULARITY = 0.0015, 3, 0.3
# Round keys of toasters are at most this wide by their dials.
MAX_KEY_BY_DIAL = 0.8
# A side with more small things than this is no front with controls, but a lattice or a scan in pieces.
MAX_CONTROLS = 1000


def control_features(
    measured: MeasuredFragments, side: int, controls: Sequence[Control], panels: Sequence[Rectangle]
) -> tuple[Floats, list[ControlGroup]]:
    """Return the (N, len(CONTROL_FEATURES)) features of all controls of a side, and their groups."""
    controls = list(controls)
    # A disc of few cubes may look square: all of a group are round where many of it are.
    for group in group_controls(controls, measured.mesh.cell) if measured.mesh.cell > 0.0 else ():
        if len(group.members) >= MIN_ROW_LENGTH and group.round_share >= MIN_ROUND_SHARE_OF_ROW:
            for i in group.members:
                controls[i] = replace(controls[i], is_round=True)
    groups = group_controls(controls, measured.mesh.cell)
    lower, upper = corners_from_side(measured, side)
    lower, upper = lower.min(axis=0), upper.max(axis=0)
    width, depth, height = np.maximum(measured.upper.max(axis=0) - measured.lower.min(axis=0), 1e-9)
    shape = (float(np.log(width / height)), float(np.log(depth / height)))
    out = np.zeros((len(controls), len(CONTROL_FEATURES)))
    largest = max((float(controls[i].across.max()) for g in groups for i in g.members), default=0.0)
    rounds = sum(c.is_round for c in controls)
    for group in groups:
        for i in group.members:
            own = controls[i]
            out[i] = (
                *_own(measured, side, own),
                len(group.members),
                group.rows,
                group.columns,
                group.pitch,
                group.irregularity,
                group.round_share,
                largest / max(float(own.across.max()), 1e-9),
                len(controls) - len(group.members),
                rounds - sum(controls[k].is_round for k in group.members),
                *_place(own, controls, panels, lower[:2], upper[:2], side == TOP),
                *shape,
            )
    return out, groups


def _own(measured: MeasuredFragments, side: int, control: Control) -> tuple[float, ...]:
    """Return what a control looks like by itself."""
    width, narrow = float(control.across.max()), float(control.across.min())
    points = measured.points_of(control.fragments) @ SIDES[side].T
    whole = outline_area(points[:, :2])
    depth = float(np.ptp(points[:, 2]))
    tip = points[points[:, 2] <= points[:, 2].min() + TIP_SHARE * depth]
    box = max(float(np.prod(control.across)), 1e-12)
    return (
        float(np.log(max(width, 1e-6))),
        narrow / max(width, 1e-9),
        float(np.log(max(float(control.across[1]), 1e-6) / max(float(control.across[0]), 1e-6))),
        control.protrusion / max(width, 1e-9),
        control.protrusion,
        depth / max(width, 1e-9),
        whole / (np.pi / 4 * box),
        float(control.is_round),
        float(np.log(len(control.fragments))),
        outline_area(tip[:, :2]) / max(whole, 1e-12),
        float(measured.visible_area[control.fragments, side].sum()) / box,
        depth_around(measured.depth_images[side], control.lower, control.upper)[1],
    )


def _place(
    control: Control,
    controls: Sequence[Control],
    panels: Sequence[Rectangle],
    lower: Floats,
    upper: Floats,
    is_on_top: bool,
) -> tuple[float, ...]:
    """Return where a control is on its side, of (2,) corners `lower` and `upper`, and on its panel."""
    extent = np.maximum(upper - lower, 1e-9)
    middle = (control.middle - lower) / extent
    front = float(extent[0] * extent[1])
    shares = [float(np.prod(b - a)) / front for a, b in panels]
    hosts = [k for k, (a, b) in enumerate(panels) if (a <= control.middle).all() and (control.middle <= b).all()]
    on = (0.0, 0.0, 0.0, 0.0, 0.0)
    if hosts:
        k = min(hosts, key=lambda n: shares[n])
        a, b = panels[k]
        size = np.maximum(b - a, 1e-9)
        place = (control.middle - a) / size
        on = (
            shares[k],
            float(sum((a <= c.middle).all() and (c.middle <= b).all() for c in controls)),
            float(control.across.max() / size.min()),
            float(abs(place[0] - 0.5)),
            float(place[1]),
        )
    beside = above = most = 0.0
    if panels:
        k = int(np.argmax(shares))
        a, b = panels[k]
        most = shares[k]
        beside = float((max(a[0] - control.middle[0], 0.0) + max(control.middle[0] - b[0], 0.0)) / extent[0])
        above = float((min(control.middle[1] - a[1], 0.0) + max(control.middle[1] - b[1], 0.0)) / extent[1])
    return (
        float(abs(middle[0] - 0.5)),
        float(middle[1]),
        float(is_on_top),
        *on[:3],
        beside,
        above,
        *on[3:],
        most,
        float(sum(s >= LARGE_PANEL_SHARE for s in shares)),
    )


def classify_by_forest(
    measured: MeasuredFragments, side: int, controls: Sequence[Control], panels: Sequence[Rectangle], forest: Forest
) -> ControlClassifier:
    """Return the type of each control of a side: all of a group have the type that fits the group best."""
    types: dict[tuple[int, ...], ControlType] = {}
    if 0 < len(controls) <= MAX_CONTROLS:
        features, groups = control_features(measured, side, controls, panels)
        chances = forest.probabilities(features)
        for group in groups:
            rows = list(group.members)
            is_flat = max(controls[i].protrusion for i in rows) <= MAX_FLAT_PROTRUSION
            is_regular = len(rows) >= MIN_FLAT_KEYS and group.irregularity <= MAX_FLAT_IRREGULARITY
            is_mark = is_flat and not is_regular and group.round_share < 0.5
            found = (None, 0.0, "") if is_mark else _type(pooled(chances[rows]), group, side == TOP)
            types |= {tuple(controls[i].fragments): found for i in rows}
    return lambda control, _others: types.get(tuple(control.fragments), (None, 0.0, ""))


def classify_with_dials(classify: ControlClassifier) -> ControlClassifier:
    """Return a classifier for controls of a toaster: round ones that are clearly smaller than its dials are keys."""

    def classified(control: Control, others: Sequence[Control]) -> ControlType:
        kind, confidence, reason = classify(control, others)
        if kind is not PartKind.KNOB:
            return kind, confidence, reason
        width = max(float(o.across.max()) for o in (control, *others) if classify(o, others)[0] is PartKind.KNOB)
        if float(control.across.max()) > MAX_KEY_BY_DIAL * width:
            return kind, confidence, reason
        return PartKind.BUTTON, confidence, "smaller than the dial beside it"

    return classified


def pooled(chances: Floats) -> Floats:
    """Return the (C,) probabilities of a group from the (N, C) ones of its members: their geometric mean."""
    mean = np.exp(np.log(np.maximum(chances, LEAST_PROBABILITY)).mean(axis=0))
    return np.asarray(mean / mean.sum())


def decided(chances: Floats, on_top: Mask) -> Ints:
    """Return the (N,) indices in CONTROL_CLASSES for (N, C) probabilities; less will do for those `on_top` (N,)."""
    best = 1 + chances[:, 1:].argmax(axis=1)
    least = np.where(on_top, MIN_PROBABILITY_ON_TOP, MIN_PROBABILITY)
    is_one = chances[np.arange(len(chances)), best] >= least
    return np.where(is_one | (chances[:, 0] <= MAX_PROBABILITY_OF_NEITHER), best, 0)


def _type(chances: Floats, group: ControlGroup, on_top: bool) -> ControlType:
    best = int(decided(chances[None], np.array([on_top]))[0])
    if best == 0:
        return None, 0.0, ""
    count = len(group.members)
    shape = "stands alone" if count == 1 else f"{count} alike in {group.rows} rows and {group.columns} columns"
    return PartKind(CONTROL_CLASSES[best]), float(chances[best]), f"{shape}, by form and place"
