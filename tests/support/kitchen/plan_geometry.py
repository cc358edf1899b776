"""Resolved kitchens seen from above: boxes of units, and how far runs are from each other and from the walls."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.run.resolve import preset_params
from casa_assets.mesh.outline import penetration_depth
from casa_assets.model.kitchen.plan import BaseKind, Plan
from casa_assets.registry.kitchens import load_plan, load_style, read_plan

PLAY = 0.0015  # metres
STYLE = "coastal"


@dataclass(frozen=True)
class Rect:
    """A rectangle on the floor: least and greatest x, y, metres; `aslant`: the corners of one that stands so."""

    x0: float
    y0: float
    x1: float
    y1: float
    aslant: tuple[tuple[float, float], ...] = ()

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        return self.aslant or ((self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1))

    def gap(self, other: Rect) -> float:
        """Metres between two of them; less than 0 where they overlap by more than their play."""
        if self.aslant or other.aslant:
            return -penetration_depth(self.corners, other.corners)
        dx = max(self.x0 - other.x1, other.x0 - self.x1)
        dy = max(self.y0 - other.y1, other.y0 - self.y1)
        return math.hypot(max(dx, 0.0), max(dy, 0.0)) if max(dx, dy) > -PLAY else max(dx, dy)


def rect(line: RunLine, left: float, right: float, back: float, front: float) -> Rect:
    points = line.frame.rectangle(left, right, back, front)
    xs, ys = zip(*points, strict=True)
    return Rect(min(xs), min(ys), max(xs), max(ys), () if line.frame.is_aligned else points)


def boxes(kitchen: KitchenRequest) -> list[tuple[UnitSlot, Rect]]:
    units = [s for row in kitchen.slots.values() for s in row if s.kind is not BaseKind.GAP]
    return [(s, rect(s.line, s.left, s.right, 0.0, s.depth)) for s in units]


def floor_row(kitchen: KitchenRequest, line: RunLine) -> list[UnitSlot]:
    return [s for s in kitchen.slots[line.id] if not s.is_upper]


def made(name: str, given: Mapping[str, float] | None = None, style: str = STYLE) -> KitchenRequest:
    return request_kitchen(load_plan(name)[0], load_style(style)[0], preset_params(), given)


def kitchen_of(text: str, folder: Path, given: Mapping[str, float] | None = None, style: str = STYLE) -> KitchenRequest:
    """A plan as written, in a style. Raises RegistryError as a run does."""
    path = folder / "tiny.yaml"
    path.write_text(text)
    plan, pages = read_plan(path)
    try:
        return request_kitchen(plan, load_style(style)[0], preset_params(), given)
    except PlanConflict as error:
        raise pages.fault(error.pointer, error.expected, error.got) from None


def extremes(plan: Plan) -> Iterator[dict[str, float]]:
    """A plan's own lengths, then all of their least and greatest ones together."""
    yield {}
    ends = [[(name, p.low), (name, p.high)] for name, p in plan.parameters.items()]
    yield from map(dict, itertools.product(*ends))


def draws(plan: Plan, count: int) -> Iterator[dict[str, float]]:
    rng = np.random.default_rng(20)
    for _ in range(count):
        yield {name: round(float(rng.uniform(p.low, p.high)), 3) for name, p in plan.parameters.items()}
