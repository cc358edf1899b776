"""Compute features for the probability that one side of an object is its front and another its top."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from casa_assets.articulate.frame.kind import ControlPlacement, shape_likelihood
from casa_assets.articulate.frame.side_views import SideFeature, SideView
from casa_assets.articulate.segment.fragment_measures import SIDES, MeasuredFragments
from casa_assets.core.typing import Floats

_EACH = ("front", "back", "top", "bottom", "sides")
# Features of a candidate, in the order in which `frame_features` computes them. `sides` stands for the mean of the left
# and the right side; the fields of SideView say how each side is measured.
_SIDE_FEATURES = (
    "detail",  # share that this side has of the detail of all six sides
    "juts",  # SideView.juts
    "knobs",  # log(1 + number of knobs)
    "bars",  # log(1 + number of bars)
    "panels",  # SideView.panels
    "stands",  # SideView.protruding_share
)
FEATURES = (
    *(f"{side}_{what}" for what in _SIDE_FEATURES for side in _EACH),
    "symmetry",  # front and back ends less alike than the other two, mean over top, bottom, left and right
    "front_level",  # how much more alike the left and right ends of the front are than its top and bottom
    "support",  # SideView.support of the bottom
    "shape",  # log likelihood of the proportions, given where the controls are (shape_likelihood)
    "inside_upright",  # share of the surface that no side shows and that faces front or back
    "bars_high",  # mean height of level bars on the front, from its middle, as a share of its height
    "knobs_high",  # the same of its knobs, 0 if they are below the middle
    "top_rings",  # SideView.rings of the top
    "top_slots",  # SideView.slots of the top
    "knobs_near",  # mean offset of knobs on the top towards the front, as a share of the depth
    "mass_height",  # mean height of the surface, from the middle, as a share of the height
    "back_plain",  # 1 if the back has less than half as much detail as the front, else 0
    "bottom_legs",  # by how much SideView.support of the bottom exceeds its SideView.filled
    "top_legs",  # the same of the top
)
# Controls whose mean offset from the middle of the front, by its size, is larger than this are at its side or top; one
# offset exceeds the other by the margin.
CONTROLS_OFF_CENTRE, CONTROLS_MARGIN = 0.2, 0.05


def side_facing(direction: Floats) -> int:
    """Return the index of the side that faces a direction."""
    return int(np.argmax(-SIDES[:, 2] @ direction))


def frame_features(
    measured: MeasuredFragments, sides: Sequence[SideView], front: int, top: int, inside: Floats
) -> Floats:
    """Return the (len(FEATURES),) features of the hypothesis that these sides are the front and the top.

    Args:
        sides: of all six, as `measure_side` measures them. inside: as `hidden_area` measures it.
    """
    back, bottom = front ^ 1, top ^ 1
    up, out = -SIDES[top][2], -SIDES[front][2]
    across = np.cross(up, out)
    left, right = side_facing(-across), side_facing(across)
    lower, upper = measured.lower.min(axis=0), measured.upper.max(axis=0)
    width, depth, height = (float(np.abs(a) @ (upper - lower)) for a in (across, out, up))
    front_view = sides[front]
    knobs = [_offset(b, front, across, up) for b in front_view.blobs if b.is_knob]
    bars = [_offset(b, front, across, up) for b in front_view.blobs if b.is_bar and _is_level(b, front, up)]
    top_knobs = [_offset(b, top, across, out) for b in sides[top].blobs if b.is_knob]
    total = max(sum(s.detail for s in sides), 1e-9)
    rows = ((front,), (back,), (top,), (bottom,), (left, right))

    def each(number: Callable[[SideView], float]) -> list[float]:
        return [float(np.mean([number(sides[i]) for i in r])) for r in rows]

    rise = ((measured.lower + measured.upper) / 2 - (lower + upper) / 2) @ up / max(height, 1e-9)
    return np.array(
        [
            *(d / total for d in each(lambda s: s.detail)),
            *each(lambda s: s.juts),
            *each(lambda s: float(np.log1p(min(sum(b.is_knob for b in s.blobs), 12)))),
            *each(lambda s: float(np.log1p(min(sum(b.is_bar for b in s.blobs), 6)))),
            *each(lambda s: s.panels),
            *each(lambda s: s.protruding_share),
            float(np.mean([-_symmetry(sides[i], i, out) for i in (top, bottom, left, right)])),
            _symmetry(front_view, front, across),
            sides[bottom].support,
            shape_likelihood((width, depth, height), _control_placement(knobs)),
            float(inside @ np.abs(out)),
            _mean(bars),
            max(_mean(knobs), 0.0),
            sides[top].rings,
            sides[top].slots,
            _mean(top_knobs),
            float((rise * measured.area).sum() / max(float(measured.area.sum()), 1e-12)),
            float(sides[back].detail < 0.5 * front_view.detail),
            *(max(sides[i].support - sides[i].filled, 0.0) for i in (bottom, top)),
        ]
    )


def hidden_area(measured: MeasuredFragments) -> Floats:
    """Return the (3,) share of the surface that no side shows, by the axis it faces: shelves and racks are level."""
    visible = np.zeros(len(measured.label), dtype=bool)
    for image in measured.depth_images:
        visible[image.face[image.face >= 0]] = True
    weight = np.where(visible, 0.0, measured.mesh.areas)
    aligned = np.abs(measured.mesh.normals) > 0.9
    found: Floats = (aligned * weight[:, None]).sum(axis=0) / max(float(measured.mesh.areas.sum()), 1e-12)
    return found


def _offset(blob: SideFeature, side: int, right: Floats, up: Floats) -> tuple[float, float]:
    """Return the offset of a feature from the middle of its side, in shares of the side, along two directions."""
    place = (blob.middle[0] - 0.5) * SIDES[side][0] + (blob.middle[1] - 0.5) * SIDES[side][1]
    return float(place @ right), float(place @ up)


def _is_level(blob: SideFeature, side: int, up: Floats) -> bool:
    """Return whether something on a side is wider than high."""
    along_up = abs(float(SIDES[side][1] @ up)) > 0.5
    wide, upper = blob.size if along_up else blob.size[::-1]
    return wide > upper


def _mean(places: Sequence[tuple[float, float]]) -> float:
    """Return the mean of the second coordinates, 0 for none."""
    return float(np.mean([p[1] for p in places])) if places else 0.0


def _symmetry(side: SideView, index: int, axis: Floats) -> float:
    """Return how much more alike the two ends along one direction are than those along the other."""
    first = abs(float(SIDES[index][0] @ axis)) > 0.5
    return (side.mirror[0] - side.mirror[1]) * (1.0 if first else -1.0)


def _control_placement(knobs: Sequence[tuple[float, float]]) -> ControlPlacement:
    """Return where on a front its knobs and buttons are."""
    if not knobs:
        return ControlPlacement.NONE
    x, z = np.abs(np.mean(np.array(knobs), axis=0))
    if x > max(CONTROLS_OFF_CENTRE, z + CONTROLS_MARGIN):
        return ControlPlacement.ASIDE
    return ControlPlacement.ABOVE if z > max(CONTROLS_OFF_CENTRE, x + CONTROLS_MARGIN) else ControlPlacement.NONE
