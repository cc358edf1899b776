"""What guests see of islands and peninsulas that are made of ordinary units: panels behind them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from casa_assets.layouts.order.cabinets import group_of, look
from casa_assets.layouts.order.models import Models
from casa_assets.layouts.order.wanted import Order, Spot, Wanted, member
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import Line, Slot
from casa_assets.model.kitchen.units import BaseKind, Side

WIDEST = 1.2  # metres of one panel
COLUMN = 0.5  # metres of one field of it
PLAY = 0.0005


def has_back(line: Line) -> bool:
    """Whether a run needs panels behind it: it stands at no wall, and its units are not finished on all sides."""
    return not line.at_wall and all(u.kind is not BaseKind.ISLAND for u in line.run.base)


def order_backs(order: Order, lines: Mapping[str, Line], slots: Mapping[str, Sequence[Slot]], models: Models) -> None:
    """Panels along the back of every free-standing run, from the wall that a peninsula begins at to its free end."""
    for name, line in lines.items():
        floor = [s for s in slots[name] if not s.is_upper]
        if not has_back(line) or not floor:
            continue
        low, high = floor[0].left, floor[-1].right
        if line.run.joins is not None:
            low, high = (0.0, high) if line.run.joins.end is Side.RIGHT else (low, line.length)
        count = math.ceil((high - low) / WIDEST)
        width = (high - low) / count
        fronts = look(models, group_of(floor[0]))
        params = {
            "width": round(width - PLAY, 4),
            "height": floor[0].high,
            "thick": standard_sizes.PANEL,
            "columns": max(1, min(4, round(width / COLUMN))),
            "front": fronts["front"],
            "face": fronts["face"],
        }
        for k in range(count):
            spot = Spot(line.frame, low + (k + 0.5) * width, -standard_sizes.PANEL - PLAY, 0.0, 180.0)
            stem = f"{name}_back" if k == 0 else f"{name}_back_{k + 1}"
            order.add(Wanted(stem, "panel", member("cabinet_panel/slab_oak", params), spot, "", name))
