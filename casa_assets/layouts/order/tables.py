"""Order tables to eat at, with chairs round them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.build_order import BuildOrder, DepthReference, OrderItem, Spot
from casa_assets.layouts.plan.room import Room, resolve_length, wall_of
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.plan.wall_frame import WallFrame
from casa_assets.model.kitchen.furnishing import DiningTable
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.record import Vec2

PLACE_WIDTH_M = 0.6  # along a table for each person; NKBA planning guideline 9
# Length of a table beyond the places along it, the least length of one, and of the rim of a round one for each place.
TABLE_END_M, TABLE_LEAST_M, ROUND_PLACE_M = 0.2, 1.0, 0.22
CHAIR_UNDER_TABLE_M = 0.05  # that a chair's seat reaches under the table
CHAIR_REACH_M = 0.45  # that a chair stands out beside the table


@dataclass(frozen=True)
class PlacedTable:
    """A table in the room: (x, y) of its middle, metres, and length and direction (unit vector) of its long side.

    Attributes:
        outline: corners (x, y) of what it and its chairs take up, metres.
    """

    middle: Vec2
    width: float
    direction: Vec2
    outline: tuple[Vec2, ...]


def order_tables(
    order: BuildOrder, plan: Plan, room: Room, parameters: Mapping[str, float], models: StyleModels
) -> dict[str, PlacedTable]:
    """Order dining tables with chairs around them; return their places, by id."""
    placed: dict[str, PlacedTable] = {}
    for table in plan.tables:
        at = ("tables", table.id)
        wall = wall_of(plan, room, table.wall, *at, "wall")
        u = resolve_length(plan, table.at, parameters, *at, "at")
        v = resolve_length(plan, table.from_wall, parameters, *at, "from_wall")
        for role in ("table", "chair"):
            if not models.has(role):
                raise PlanConflict(plan.id, at, f"a style with a model of {role!r}", models.style.id)
        placed[table.id] = _order_table(order, table, wall.frame, (u, v), models)
    return placed


def _order_table(order: BuildOrder, table: DiningTable, frame: WallFrame, at: Vec2, models: StyleModels) -> PlacedTable:
    """Order one table, made as long as its chairs need, and its chairs."""
    model = models.for_role("table")
    is_round = bool(model.params.get("is_round", False))
    long_sides = table.chairs // 2
    if is_round:
        width = depth = max(model.length("width"), round(table.chairs * ROUND_PLACE_M, 2))
    else:
        width, depth = max(long_sides * PLACE_WIDTH_M + TABLE_END_M, TABLE_LEAST_M), model.length("depth")
    width = round(width, 3)
    angle = math.radians(table.turn_deg)
    # In the frame of the wall: x along it, y away from it, so that a turn to the left is clockwise.
    along, across = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))

    def moved(a: float, b: float) -> Vec2:
        return (at[0] + a * along[0] + b * across[0], at[1] + a * along[1] + b * across[1])

    spot = Spot(frame, *at, 0.0005, table.turn_deg, DepthReference.MIDDLE)
    choice = model.with_params(width=width, **({} if is_round else {"depth": depth}))
    order.add(OrderItem(table.id, "table", choice, spot))
    chair = models.for_role("chair")
    reach = chair.length("depth") / 2 - CHAIR_UNDER_TABLE_M
    for k, (a, b, turn) in enumerate(_places(table.chairs, width, depth, is_round)):
        # A chair faces away from the line that it stands at; it is turned to the table.
        sine, cosine = math.sin(math.radians(turn)), math.cos(math.radians(turn))
        u, v = moved(a - reach * sine, b - reach * cosine)
        seat = Spot(frame, round(u, 5), round(v, 5), 0.0005, turn + table.turn_deg, DepthReference.MIDDLE)
        order.add(OrderItem(f"{table.id}_chair_{k + 1}", "chair", chair.choice, seat))
    around = CHAIR_REACH_M
    us = (-width / 2 - (around if is_round or table.chairs % 2 else 0.0), width / 2 + (around if is_round else 0.0))
    vs = (-depth / 2 - around, depth / 2 + around)
    corners = tuple(
        frame.at(*moved(a, b))[:2] for a, b in ((us[0], vs[0]), (us[1], vs[0]), (us[1], vs[1]), (us[0], vs[1]))
    )
    (x0, y0), (x1, y1) = frame.at(*moved(0.0, 0.0))[:2], frame.at(*moved(1.0, 0.0))[:2]
    return PlacedTable((x0, y0), width, (round(x1 - x0, 5), round(y1 - y0, 5)), corners)


def _places(chairs: int, width: float, depth: float, is_round: bool) -> list[tuple[float, float, float]]:
    """Places of chairs at the edge of a table: along it and across it, metres, and the turn to the table, degrees."""
    if is_round:
        turns = [360.0 * k / chairs for k in range(chairs)]
        return [
            (-width / 2 * math.sin(math.radians(t)), -width / 2 * math.cos(math.radians(t)), t if t <= 180 else t - 360)
            for t in turns
        ]
    out: list[tuple[float, float, float]] = []
    for side, turn in ((-depth / 2, 0.0), (depth / 2, 180.0)):
        count = chairs // 2
        pitch = (width - TABLE_END_M) / max(count, 1)
        out += [((k - (count - 1) / 2) * pitch, side, turn) for k in range(count)]
    return [*out, (-width / 2, 0.0, 90.0)] if chairs % 2 else out


def places_over(table: PlacedTable, count: int) -> Sequence[tuple[WallFrame, float, float]]:
    """Places of lamps along the middle of a table."""
    (x, y), (a, b) = table.middle, table.direction
    shares = [(k + 0.5) / count - 0.5 for k in range(count)]
    return [
        (WallFrame(round(x + s * table.width * a, 5), round(y + s * table.width * b, 5), 0), 0.0, 0.0) for s in shares
    ]
