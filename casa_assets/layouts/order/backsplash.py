"""Order backsplash panels for the walls between worktops and wall units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from casa_assets.layouts.order.build_order import BuildOrder, OrderItem, Spot, preset_with
from casa_assets.layouts.order.worktops import MAX_SLAB_M
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import WallHole
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.units import TALL, BaseKind, UpperKind

THICKNESS_M = 0.01
SILL_OVERHANG_M = 0.02  # of a sill beside the casing, at each end
MIN_PANEL_M = 0.3


def order_backsplash(
    order: BuildOrder,
    lines: Mapping[str, RunLine],
    slots: Mapping[str, Sequence[UnitSlot]],
    holes: Sequence[WallHole],
    models: StyleModels,
) -> None:
    """Order panels between worktops and wall units, lower under windows."""
    splash = models.style.backsplash
    if splash is None:
        return
    for name, line in lines.items():
        if not line.at_wall:
            continue
        for k, (a, b, high) in enumerate(_panels(line, slots[name], holes, window_reach(models))):
            params = {
                "width": round(b - a, 4),
                "height": round(high - standard_sizes.WORKTOP_HEIGHT, 4),
                "thickness": THICKNESS_M,
                "face": splash.face,
            }
            spot = Spot(line.frame, (a + b) / 2, 0.0, standard_sizes.WORKTOP_HEIGHT + 5e-4)
            order.add(
                OrderItem(
                    f"{name}_splash_{k + 1}", "backsplash", preset_with("backsplash/subway", params), spot, "", name
                )
            )


def window_reach(models: StyleModels) -> float:
    """Distance by which a window's casing and sill extend to the sides of its hole and below it, metres."""
    casing = float(models.for_role("window").params.get("casing", 0.0)) if models.has("window") else 0.0
    return round(max(casing + SILL_OVERHANG_M, 0.03) + 0.002, 4)


def _panels(
    line: RunLine, slots: Sequence[UnitSlot], holes: Sequence[WallHole], reach: float
) -> Iterator[tuple[float, float, float]]:
    """Left, right and upper edge of the panels of a run."""
    floor = [s for s in slots if not s.is_upper]
    parts: list[tuple[float, float]] = []
    for slot in floor:
        if slot.kind in (*TALL, BaseKind.GAP) or slot.top > standard_sizes.WORKTOP_HEIGHT:
            continue
        if parts and slot.left - parts[-1][1] < 0.01:
            parts[-1] = (parts[-1][0], slot.right)
        else:
            parts.append((slot.left, slot.right))
    if line.left.kind is RunEnd.CORNER and parts:
        parts[0] = (THICKNESS_M, parts[0][1])
    if line.right.kind is RunEnd.CORNER and parts:
        parts[-1] = (parts[-1][0], line.length)
    for a, b in parts:
        for c, d, high in _up_to_hoods(_under_windows(line, a, b, holes, reach), slots):
            while d - c > MAX_SLAB_M:
                yield c, c + MAX_SLAB_M, high
                c += MAX_SLAB_M
            if d - c >= MIN_PANEL_M and high - standard_sizes.WORKTOP_HEIGHT >= 0.1:
                yield round(c, 4), round(d, 4), high


def _up_to_hoods(
    panels: Iterator[tuple[float, float, float]], slots: Sequence[UnitSlot]
) -> Iterator[tuple[float, float, float]]:
    """Panels raised behind a hob or range; one whole panel if the rest next to the raised part would be too narrow."""
    hoods = sorted((s.left, s.right) for s in slots if s.kind is UpperKind.HOOD)
    for a, b, high in panels:
        at = a
        for left, right in hoods:
            fits = left - at >= MIN_PANEL_M or abs(left - at) < 0.002
            ends = b - right >= MIN_PANEL_M or abs(b - right) < 0.002
            if high < standard_sizes.UPPER_FROM or left < at - 0.002 or right > b + 0.002 or not (fits and ends):
                continue
            if left - at >= MIN_PANEL_M:
                yield at, left, high
            yield left, right, standard_sizes.HOOD_FROM
            at = right
        if b - at > 0.002:
            yield at, b, high


def _under_windows(
    line: RunLine, a: float, b: float, holes: Sequence[WallHole], casing: float
) -> Iterator[tuple[float, float, float]]:
    full = standard_sizes.UPPER_FROM
    at = a
    for hole in sorted((h for h in holes if h.wall.id == line.run.on), key=lambda h: h.left):
        shift = line.frame.to_local(*hole.wall.frame.at(0.0, 0.0)[:2])[0]
        left, right = hole.left + shift - casing, hole.right + shift + casing
        if right <= at or left >= b or hole.bottom - casing >= full:
            continue
        if left > at:
            yield at, left, full
        yield max(at, left), min(b, right), round(hole.bottom - casing, 4)
        at = right
    if at < b:
        yield at, b, full
