"""Compute the dimensionless features of the controls on a side, from which their type is classified."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from casa_assets.articulate.controls.controls import (
    MIN_ROUND_SHARE_OF_ROW,
    MIN_ROW_LENGTH,
    Control,
    depth_around,
)
from casa_assets.articulate.controls.groups import ControlGroup, group_controls
from casa_assets.articulate.segment.fragment_measures import SIDES, TOP, MeasuredFragments, corners_from_side
from casa_assets.core.typing import Floats

# Lengths are in diagonals of the object or by the size of what the name says; all are 0 where there is none.
CONTROL_FEATURES = (
    "log_width",
    "narrowness",
    "upright",
    "protrusion_by_width",
    "protrusion",
    "depth_by_width",
    "ellipse_fill",
    "is_round",
    "log_fragments",
    "tip_by_base",
    "picture_fill",
    "ground_share",
    "group_count",
    "group_rows",
    "group_columns",
    "group_pitch",
    "group_irregularity",
    "group_round_share",
    "group_largest_by_this",
    "others",
    "other_round",
    "away_from_middle",
    "height",
    "on_top",
    "panel_share",
    "panel_controls",
    "width_by_panel",
    "beside_panel",
    "above_panel",
    "panel_away_from_middle",
    "panel_height",
    "largest_panel",
    "panels",
    "object_width_by_height",
    "object_depth_by_height",
)
# A panel is large from this share of its side on; the tip of a control is this share of its depth.
LARGE_PANEL_SHARE, TIP_SHARE = 0.08, 0.3
Rectangle = tuple[Floats, Floats]


def control_features(
    measured: MeasuredFragments, side: int, controls: Sequence[Control], panels: Sequence[Rectangle]
) -> tuple[Floats, list[ControlGroup]]:
    """Return the (N, len(CONTROL_FEATURES)) features of all controls of a side, and their groups.

    Args:
        panels: (2,) lower and upper corner in (u, v) of each panel of the side.
    """
    if measured.mesh.cell > 0.0:
        controls = _round_as_their_group(controls, measured.mesh.cell)
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
    whole = _hull_area(points[:, :2])
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
        _hull_area(tip[:, :2]) / max(whole, 1e-12),
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
    large = sum(s >= LARGE_PANEL_SHARE for s in shares)
    return (
        float(abs(middle[0] - 0.5)),
        float(middle[1]),
        float(is_on_top),
        *on[:3],
        beside,
        above,
        *on[3:],
        most,
        float(large),
    )


def _round_as_their_group(controls: Sequence[Control], cell: float) -> list[Control]:
    """Return controls of which all of a group are round where many of it are: a disc of few cubes may look square."""
    found = list(controls)
    for group in group_controls(controls, cell):
        if len(group.members) >= MIN_ROW_LENGTH and group.round_share >= MIN_ROUND_SHARE_OF_ROW:
            for i in group.members:
                found[i] = replace(found[i], is_round=True)
    return found


def _hull_area(flat: Floats) -> float:
    """Return the area of the convex hull of (P, 2) points, 0 where they lie on a line."""
    if len(flat) < 3:
        return 0.0
    try:
        return float(ConvexHull(flat).volume)
    except QhullError:
        return 0.0
