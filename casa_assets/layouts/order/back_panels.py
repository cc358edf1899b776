"""Order panels for the backs of islands and peninsulas that are made of ordinary units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from casa_assets.layouts.order.build_order import BuildOrder, OrderItem, Spot, preset_with
from casa_assets.layouts.order.cabinets import front_look, group_of
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.units import RunSide

MAX_PANEL_M = 1.2  # metres of one panel
FIELD_WIDTH_M = 0.5  # metres of one field of it
PLAY_M = 0.0005


def order_back_panels(
    order: BuildOrder, lines: Mapping[str, RunLine], slots: Mapping[str, Sequence[UnitSlot]], models: StyleModels
) -> None:
    """Panels along the back of every free-standing run, from the wall that a peninsula begins at to its free end."""
    for name, line in lines.items():
        floor = [s for s in slots[name] if not s.is_upper]
        if not line.has_back or not floor:
            continue
        low, high = floor[0].left, floor[-1].right
        if line.run.joins is not None:
            low, high = (0.0, high) if line.run.joins.end is RunSide.RIGHT else (low, line.length)
        count = math.ceil((high - low) / MAX_PANEL_M)
        width = (high - low) / count
        fronts = front_look(models, group_of(floor[0]))
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
            stem = f"{name}_back" if k == 0 else f"{name}_back_{k + 1}"
            order.add(OrderItem(stem, "panel", preset_with("cabinet_panel/slab_oak", params), spot, "", name))
