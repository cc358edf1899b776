"""Order worktops with cutouts for sinks and hobs, and panels for the backs of islands."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from casa_assets.layouts.order.build_order import BuildOrder, HeightReference, Spot, numbered
from casa_assets.layouts.order.cabinets import front_look, group_of
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModel, StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import TALL, BaseKind, BaseUnit, RunCorner, RunSide
from casa_assets.model.kitchen.style import WorktopStyle

MAX_SLAB_M = 3.9
MIN_ARM_M, MIN_WIDTH_M = 0.72, 0.2  # of a corner worktop; of a part of a straight one that a seam ends
CORBEL = "corbel"  # support of an overhang
CORBEL_INSET_M = 0.045  # middle of the outer corbels, from the ends of an island's cabinets
CORBELS_APART_M = 0.5  # from the end of an island, at which one more stands there
MIN_STRIP_M = 0.03  # of a worktop over a filler alone
SINK_RIM_M = 0.004  # height of a drop-in sink's rim over the worktop
SINK_BACK_M = 0.049  # between the wall and a sink; its front clears the rail of the cabinet below
WORKTOP_BREAKS = (*TALL, BaseKind.RANGE, BaseKind.GAP)
MAX_PANEL_M = 1.2  # metres of one panel
FIELD_WIDTH_M = 0.5  # metres of one field of it
PLAY_M = 0.0005


@dataclass(frozen=True)
class WorktopStretch:
    """A part of a run that one worktop covers, metres along it; the slots whose sink or hob is let into it."""

    line: RunLine
    left: float
    right: float
    cutout_slots: tuple[UnitSlot, ...]

    def part(self, left: float, right: float) -> WorktopStretch:
        """A shorter part of it."""
        slots = tuple(s for s in self.cutout_slots if s.left >= left - 1e-6 and s.right <= right + 1e-6)
        return WorktopStretch(self.line, left, right, slots)

    def with_ends(self, left: float, right: float) -> WorktopStretch:
        """Copy with other ends."""
        return replace(self, left=round(left, 4), right=round(right, 4))


def worktop_stretches(line: RunLine, slots: Sequence[UnitSlot]) -> list[WorktopStretch]:
    """Parts of a run under worktop: all floor units except tall ones, ranges and gaps; up to the corners' walls."""
    floor = [s for s in slots if not s.is_upper]
    out: list[WorktopStretch] = []
    begin: float | None = 0.0 if line.left.kind is RunEnd.CORNER else None
    cutouts: list[UnitSlot] = []
    end = 0.0
    for slot in floor:
        if slot.kind in WORKTOP_BREAKS or slot.top > standard_sizes.WORKTOP_HEIGHT:
            if begin is not None and slot.left - begin >= MIN_STRIP_M:
                out.append(WorktopStretch(line, begin, slot.left, tuple(cutouts)))
            begin, cutouts = None, []
        else:
            begin = slot.left if begin is None else begin
            cutouts += [slot] if slot.kind in (BaseKind.SINK, BaseKind.HOB) else []
        end = slot.right
    if begin is not None:
        end = line.length if line.right.kind is RunEnd.CORNER else end
        if end - begin >= MIN_STRIP_M:
            out.append(WorktopStretch(line, begin, end, tuple(cutouts)))
    return out


def order_worktops(order: BuildOrder) -> None:
    """Order all worktops, then sinks and hobs."""
    lines, slots, models = order.kitchen.lines, order.kitchen.slots, order.models
    stretches = {name: worktop_stretches(line, slots[name]) for name, line in lines.items()}
    corners = {e.corner.runs: e.corner for line in lines.values() for e in (line.left, line.right) if e.corner}
    for corner in corners.values():
        _corner_top(order, corner, stretches)
    for name, line in lines.items():
        for k, slab in enumerate(p for s in stretches[name] for p in _slabs(s)):
            _straight(order, numbered(f"{name}_top", k), line, slab)
    for name in lines:
        for slot in slots[name]:
            if slot.kind is BaseKind.SINK:
                _sink(order, slot, models)
            elif slot.kind is BaseKind.HOB:
                model = _model_of(slot, models)
                back = _hob_back(model.length("depth"))
                spot = Spot(slot.line.frame, slot.middle, back, standard_sizes.WORKTOP_HEIGHT - 0.06)
                order.add(f"{slot.name}_plate", "hob", model.choice, spot, unit=slot.name, run=slot.line.id)


def _corner_top(order: BuildOrder, corner: RunCorner, stretches: dict[str, list[WorktopStretch]]) -> None:
    """Order an L round a corner, up to the first cutout on either side, and shorten the stretches by what it covers."""
    first, second = (order.kitchen.lines[name] for name in corner.runs)
    a, b = stretches[first.id].pop(), stretches[second.id].pop(0)
    if first.run.joins or second.run.joins:
        bar, at_wall = (second, first) if second.run.joins else (first, second)
        if (corner.owner or first.id) == bar.id:
            # A worktop faces as the cabinet below it: that of the peninsula goes through to the wall over its corner
            # cabinet, and the one along the wall begins at its edge.
            end, begin = standard_sizes.WORKTOP_DEPTH, 0.0
        else:
            end, begin = -bar.depth_behind, standard_sizes.WORKTOP_DEPTH
        if bar is second:
            a, b = a.with_ends(a.left, at_wall.length - end), b.with_ends(begin, b.right)
        else:
            a, b = a.with_ends(a.left, bar.length - begin), b.with_ends(end, b.right)
        stretches[first.id].append(a)
        stretches[second.id].insert(0, b)
        return
    if min(a.right - a.left, b.right - b.left) < MIN_ARM_M:
        # The unit beside the corner ends the worktop on one side: the other worktop goes through to the wall.
        longer, name = (a, first.id) if b.right - b.left < MIN_ARM_M else (b, second.id)
        stretches[name].insert(len(stretches[name]) if longer is a else 0, longer)
        return
    # Two corners share what is between them; the one that comes second takes what the first has left.
    is_shared = first.left.kind is RunEnd.CORNER and a.left <= 0.0
    arm_a = _arm(a.right, a.left, [s.right for s in a.cutout_slots][::-1], is_shared)
    is_shared = second.right.kind is RunEnd.CORNER and b.right >= second.length
    arm_b = _arm(0.0, b.right, [s.left for s in b.cutout_slots], is_shared)
    if a.right - arm_a - a.left > 0.2:
        stretches[first.id].append(a.part(a.left, round(a.right - arm_a, 4)))
    else:
        arm_a = round(a.right - a.left, 4)
    if b.right - arm_b > 0.2:
        stretches[second.id].insert(0, b.part(round(arm_b, 4), b.right))
    else:
        arm_b = b.right
    top = worktop_of(order.models, first)
    params = {
        **_slab_params(top),
        "back_arm": arm_a,
        "side_arm": arm_b,
        "depth": standard_sizes.WORKTOP_DEPTH,
        "right": True,
        "back_end": False,
        "side_end": second.right.kind is RunEnd.FREE and arm_b == b.right,
    }
    u = round(first.length - arm_a / 2, 4)
    spot = Spot(first.frame, u, 0.0, standard_sizes.WORKTOP_HEIGHT - top.thickness)
    order.add(f"{first.id}_{second.id}_top", "counter", "counter_corner/right", spot, params, run=first.id)


def _arm(start: float, end: float, cutouts: list[float], is_shared: bool) -> float:
    """Length of an arm from a corner to the end of its stretch or to the first cutout; half where corners share it."""
    length = abs(end - start)
    if cutouts:
        length = abs(cutouts[0] - start)
    elif is_shared:
        length = length / 2
    return round(max(MIN_ARM_M, min(MAX_SLAB_M, length)), 4)


def _slabs(stretch: WorktopStretch) -> Iterator[WorktopStretch]:
    """Parts of a stretch with one cutout at most, none longer than a slab."""
    cuts = [stretch.left]
    for slot, right_slot in itertools.pairwise(stretch.cutout_slots):
        cuts.append(round((slot.right + right_slot.left) / 2, 4))
    cuts.append(stretch.right)
    for left, right in itertools.pairwise(cuts):
        yield from _short_enough(stretch.part(left, right))


def _short_enough(part: WorktopStretch) -> Iterator[WorktopStretch]:
    """A part with at most one cutout, divided by seams next to the cutout, or in the middle, until none is too long."""
    left, right = part.left, part.right
    if right - left <= MAX_SLAB_M:
        yield part
        return
    seams = [(left + right) / 2]
    if part.cutout_slots:
        beside = (part.cutout_slots[0].left - MIN_WIDTH_M, part.cutout_slots[0].right + MIN_WIDTH_M)
        seams = [s for s in beside if left + MIN_WIDTH_M <= s <= right - MIN_WIDTH_M]
    # The first seam that leaves no part too long, else the one that leaves the shortest.
    seam = round(min((max(s - left, right - s, MAX_SLAB_M), k, s) for k, s in enumerate(seams))[2], 4)
    yield from _short_enough(part.part(left, seam))
    yield from _short_enough(part.part(seam, right))


def worktop_of(models: StyleModels, line: RunLine) -> WorktopStyle:
    """The style's worktop for a run: along walls, or of islands."""
    return models.style.island if line.is_island else models.style.counter


def _slab_params(top: WorktopStyle) -> dict[str, Any]:
    return {"thickness": top.thickness, "edge": top.edge, "top": top.face}


def _straight(order: BuildOrder, name: str, line: RunLine, slab: WorktopStretch) -> None:
    seats, models = order.seats.get(line.id, ()), order.models
    top, overhang, behind = worktop_of(models, line), line.run.overhang, line.depth_behind
    width, middle = round(slab.right - slab.left, 4), (slab.left + slab.right) / 2
    depth = round(line.depth + standard_sizes.WORKTOP_OVERHANG + behind, 4)
    cutout = _cutout(slab, behind, models)
    if line.is_island:
        # Waterfall ends stand outside the end panels.
        support = top.support if overhang >= 0.25 else "none"
        over = round(top.thickness + 0.002, 4) if support == "waterfall" else 0.03
        params = {
            **_slab_params(top),
            "width": round(width + 2 * over, 4),
            "depth": depth,
            "overhang": overhang,
            "height": standard_sizes.WORKTOP_HEIGHT,
            "support": support,
            "cutout": {**cutout, "left": round(cutout["left"] + over, 4)} if cutout else None,
        }
        if support == CORBEL:
            params["corbels"] = tuple(round(u - slab.left + over, 4) for u in _between(seats, slab))
        high = standard_sizes.WORKTOP_HEIGHT
        spot = Spot(line.frame, middle, -behind, high, height_reference=HeightReference.HEAD)
        order.add(name, "island", "counter_island/plain", spot, params, run=line.id)
        return
    params = {
        **_slab_params(top),
        "width": width,
        "depth": depth,
        "left_end": _is_free(line, slab.left, left=True),
        "right_end": _is_free(line, slab.right, left=False),
        "upstand": models.style.counter.upstand if line.at_wall and models.style.backsplash is None else 0.0,
        "cutout": cutout,
    }
    spot = Spot(line.frame, middle, -behind, standard_sizes.WORKTOP_HEIGHT - top.thickness)
    order.add(name, "counter", "counter/quartz_eased", spot, params, run=line.id)


def _between(seats: Sequence[float], slab: WorktopStretch) -> list[float]:
    """Where corbels are along a run with several seats: between those and at the ends, where no stool turns."""
    if len(seats) < 2:
        return []
    half = (seats[1] - seats[0]) / 2
    low, high = slab.left + CORBEL_INSET_M, slab.right - CORBEL_INSET_M
    places = [min(max(u, low), high) for u in (seats[0] - half, *(u + half for u in seats))]
    ends = [u for u, nearest in ((low, places[0]), (high, places[-1])) if abs(u - nearest) > CORBELS_APART_M]
    return sorted([*places, *ends])


def _is_free(line: RunLine, at: float, left: bool) -> bool:
    end = line.left if left else line.right
    edge = 0.0 if left else line.length
    return abs(at - edge) < 0.01 if end.kind is RunEnd.FREE else not -0.001 < at < line.length + 0.001


def _cutout(slab: WorktopStretch, behind: float, models: StyleModels) -> dict[str, Any] | None:
    if not slab.cutout_slots:
        return None
    slot = slab.cutout_slots[0]
    model = _model_of(slot, models)
    if slot.kind is BaseKind.HOB:
        width, depth = model.length("width") - 0.03, model.length("depth") - 0.03
        back, radius = _hob_back(model.length("depth")) + 0.015, 0.01
    else:
        width, back, depth, radius = _sink_cutout(model.params)
    left = round(slot.middle - width / 2 - slab.left, 4)
    return {"left": left, "back": round(back + behind, 4), "width": width, "depth": round(depth, 4), "radius": radius}


def _model_of(slot: UnitSlot, models: StyleModels) -> StyleModel:
    assert isinstance(slot.unit, BaseUnit), "sinks and hobs are units on the floor"
    return models.for_unit(slot.unit)


def _sink_cutout(sink: Mapping[str, Any]) -> tuple[float, float, float, float]:
    """Width, distance from the wall, depth and corner radius of the cutout for a sink, metres."""
    width, depth = float(sink["width"]), float(sink["depth"])
    if sink["mount"] == "drop_in":
        return round(width - 0.03, 4), SINK_BACK_M + 0.015, round(depth - 0.03, 4), 0.02
    # An undermount sink: the cutout is as large as the basins.
    return round(width - 2 * 0.028, 4), SINK_BACK_M + 0.07, round(depth - 0.1, 4), min(0.1, float(sink["corner"]))


def _hob_back(depth: float) -> float:
    return round((standard_sizes.BASE_DEPTH - 0.02 - depth) / 2 + 0.02, 4)


def _sink(order: BuildOrder, slot: UnitSlot, models: StyleModels) -> None:
    model = _model_of(slot, models)
    top = standard_sizes.WORKTOP_HEIGHT + (SINK_RIM_M if model.params["mount"] == "drop_in" else 0.0)
    spot = Spot(slot.line.frame, slot.middle, SINK_BACK_M, top, height_reference=HeightReference.HEAD)
    params = {**model.choice.params, "deck": worktop_of(models, slot.line).thickness}
    order.add(f"{slot.name}_basin", "sink", model.choice.preset, spot, params, unit=slot.name, run=slot.line.id)


def order_back_panels(order: BuildOrder) -> None:
    """Panels along the back of every free-standing run, from the wall that a peninsula begins at to its free end."""
    for name, line in order.kitchen.lines.items():
        floor = [s for s in order.kitchen.slots[name] if not s.is_upper]
        if not line.has_back or not floor:
            continue
        low, high = floor[0].left, floor[-1].right
        if line.run.joins is not None:
            low, high = (0.0, high) if line.run.joins.end is RunSide.RIGHT else (low, line.length)
        count = math.ceil((high - low) / MAX_PANEL_M)
        width = (high - low) / count
        fronts = front_look(order.models, group_of(floor[0]))
        params = {
            "width": round(width - PLAY_M, 4),
            "height": floor[0].top,
            "thick": standard_sizes.END_PANEL,
            "columns": max(1, min(4, round(width / FIELD_WIDTH_M))),
            "front": fronts["front"],
            "face": fronts["face"],
        }
        for k in range(count):
            spot = Spot(line.frame, low + (k + 0.5) * width, -standard_sizes.END_PANEL - PLAY_M, 0.0, 180.0)
            order.add(numbered(f"{name}_back", k), "panel", "cabinet_panel/slab_oak", spot, params, run=name)
