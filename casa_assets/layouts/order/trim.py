"""Order trim: backsplashes, cornices and curtains."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from casa_assets.layouts.order.build_order import BuildOrder, DepthReference, HeightReference, Spot, numbered
from casa_assets.layouts.order.cabinets import face_of, is_under_cabinet
from casa_assets.layouts.order.worktops import MAX_SLAB_M, PLAY_M
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import WallHole
from casa_assets.layouts.plan.runs import CornerPart, RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import TALL, BaseKind, CornerKind, UpperKind, UpperUnit

THICKNESS_M = 0.01
SILL_OVERHANG_M = 0.02  # of a sill beside the casing, at each end
MIN_PANEL_M = 0.3
CORNICE_HEIGHT_M = 0.07
CORNICE_DEPTH_M = 0.04  # projection before the fronts
FLAT_PROFILE = "flat"  # the profile without projection
NEAR_M = 0.012  # of two things that touch, but for play
NO_RETURN_M = CORNICE_DEPTH_M + NEAR_M  # distance from a wall at which a return has no room
BESIDE_M = 2 * CORNICE_DEPTH_M + NEAR_M  # gap that two returns do not go into
SAME_ROW_M = BESIDE_M  # a cornice runs on over a smaller gap between units of one depth
MIN_CORNICE_M = 0.4
LONG_CURTAINS = ("drapes", "tied", "cafe")  # curtains that hang down to worktops and taps
# Distance of a curtain's back from the wall: where the window has a casing, and where it has none.
CURTAIN_FROM_WALL_M, CURTAIN_FROM_BARE_WALL_M = 0.0235, 0.004
CURTAIN_ABOVE_HOLE_M = 0.05  # top of a curtain over that of the window
VALANCE_HEIGHT_M = 0.3


def order_backsplash(order: BuildOrder) -> None:
    """Order panels between worktops and wall units, lower under windows."""
    kitchen, splash = order.kitchen, order.kitchen.style.backsplash
    if splash is None:
        return
    for name, line in kitchen.lines.items():
        if not line.at_wall:
            continue
        panels = _panels(line, kitchen.slots[name], kitchen.holes, window_reach(order.models))
        for k, (a, b, high) in enumerate(panels):
            params = {
                "width": round(b - a, 4),
                "height": round(high - standard_sizes.WORKTOP_HEIGHT, 4),
                "thickness": THICKNESS_M,
                "face": splash.face,
            }
            spot = Spot(line.frame, (a + b) / 2, 0.0, standard_sizes.WORKTOP_HEIGHT + 5e-4)
            order.add(f"{name}_splash_{k + 1}", "backsplash", "backsplash/subway", spot, params, run=name)


def window_reach(models: StyleModels) -> float:
    """Distance by which a window's casing and sill extend to the sides of its hole and below it, metres."""
    casing = float(models.for_role("window").params.get("casing", 0.0)) if models.has("window") else 0.0
    return round(max(casing + SILL_OVERHANG_M, 0.03) + 0.002, 4)


def _panels(
    line: RunLine, slots: Sequence[UnitSlot], holes: Sequence[WallHole], reach: float
) -> Iterator[tuple[float, float, float]]:
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


@dataclass(frozen=True)
class CabinetRow:
    """Units side by side of one height and depth: left and right along their run, metres; whether they are tall."""

    left: float
    right: float
    depth: float
    is_tall: bool


def order_cornices(order: BuildOrder) -> None:
    """Order a cornice over every row, with returns to the wall at visible ends, if the style has a profile for it."""
    lines, slots, models = order.kitchen.lines, order.kitchen.slots, order.models
    profile = models.style.cabinets.cornice
    if profile is None:
        return
    projection = 0.0 if profile == FLAT_PROFILE else CORNICE_DEPTH_M
    for name, line in lines.items():
        if not line.at_wall:
            continue
        rows = [r for r in find_rows(line, slots[name], models) if r.right - r.left >= MIN_CORNICE_M]
        for k, row in enumerate(rows):
            left, right = _is_free_end(row, row.left, rows, line), _is_free_end(row, row.right, rows, line)
            begin = row.left + (projection + PLAY_M if _is_at_corner(row.left, line) else 0.0)
            # Of two rows round a corner the first ends earlier only where the other one goes through to the wall.
            meets = line.right.corner is not None and line.right.corner.upper is CornerKind.BLIND
            end = row.right - (projection + PLAY_M if meets and _is_at_corner(row.right, line) else 0.0)
            # It ends before the return of a deeper row beside it.
            for deeper in (r for r in rows if r.depth > row.depth + 1e-3):
                if deeper in _beside(row, row.left, rows):
                    begin = max(begin, deeper.right + projection + PLAY_M)
                if deeper in _beside(row, row.right, rows):
                    end = min(end, deeper.left - projection - PLAY_M)
            if end - begin < MIN_CORNICE_M:
                continue
            params = {
                "width": round(end - begin, 4),
                "depth": row.depth,
                "height": CORNICE_HEIGHT_M,
                "out": projection,
                "left_return": left,
                "right_return": right,
                "profile": profile,
                "face": face_of(models, "tall" if row.is_tall else "upper"),
            }
            start, stop = begin - (projection if left else 0.0), end + (projection if right else 0.0)
            middle, out, high = (start + stop) / 2, row.depth + projection, standard_sizes.UPPER_TO + 5e-4
            spot = Spot(line.frame, middle, out, high, depth_reference=DepthReference.FRONT)
            order.add(numbered(f"{name}_cornice", k), "cornice", "cornice/white_crown", spot, params, run=name)


def find_rows(line: RunLine, slots: Sequence[UnitSlot], models: StyleModels) -> list[CabinetRow]:
    """Rows of a run from left to right, tall ones and wall units apart."""
    rows: list[CabinetRow] = []
    for left, right, depth, is_tall in sorted(_cornice_cabinets(line, slots, models)):
        last = rows[-1] if rows else None
        if last and left - last.right < SAME_ROW_M and last.is_tall is is_tall and abs(last.depth - depth) < 1e-3:
            rows[-1] = CabinetRow(last.left, right, depth, is_tall)
        else:
            rows.append(CabinetRow(left, right, depth, is_tall))
    return rows


def _cornice_cabinets(
    line: RunLine, slots: Sequence[UnitSlot], models: StyleModels
) -> Iterator[tuple[float, float, float, bool]]:
    """Left, right, depth of cabinets that reach the height of the wall units, and whether they are on the floor."""
    for slot in slots:
        if abs(slot.top - standard_sizes.UPPER_TO) > 1e-3 or slot.recess:
            continue
        if slot.is_upper:
            hood = is_hood_under_cabinet(slot, models)
            if hood or slot.kind in (UpperKind.DOORS, UpperKind.GLASS, CornerPart.BLIND, CornerPart.FILLER):
                yield slot.left, slot.right, standard_sizes.UPPER_DEPTH, False
        elif slot.kind in (*TALL, BaseKind.PANEL, BaseKind.FILLER, CornerPart.FILLER) and not slot.stands_free:
            yield slot.left, slot.right, line.depth, True


def is_hood_under_cabinet(slot: UnitSlot, models: StyleModels) -> bool:
    """True if it is a hood with a cabinet over it."""
    unit = slot.unit
    return isinstance(unit, UpperUnit) and unit.kind is UpperKind.HOOD and is_under_cabinet(models.for_unit(unit))


def _is_free_end(row: CabinetRow, at: float, rows: Sequence[CabinetRow], line: RunLine) -> bool:
    """True if an end of a row is free: no wall, and no deeper or equal row next to it."""
    if at < NO_RETURN_M or at > line.length - NO_RETURN_M or _is_at_corner(at, line):
        return False
    return all(r.depth < row.depth - 1e-3 for r in _beside(row, at, rows))


def _is_at_corner(at: float, line: RunLine) -> bool:
    """True if an end of a row of wall units lies before those of the run round the corner."""
    ends = ((line.left, at), (line.right, line.length - at))
    return any(e.kind is RunEnd.CORNER and abs(u - standard_sizes.UPPER_DEPTH) < NEAR_M for e, u in ends)


def _beside(row: CabinetRow, at: float, rows: Sequence[CabinetRow]) -> list[CabinetRow]:
    return [r for r in rows if r is not row and min(abs(r.left - at), abs(r.right - at)) < BESIDE_M]


def order_curtains(order: BuildOrder) -> None:
    """Order the style's curtain for every window, except where a long one would hang over a worktop."""
    kitchen, models = order.kitchen, order.models
    if not models.has("curtain"):
        return
    model = models.for_role("curtain")
    form = model.params["form"]
    for hole in (h for h in kitchen.holes if h.wall in kitchen.room.walls):
        width, height = round(hole.right - hole.left, 4), round(hole.top - hole.bottom, 4)
        if not hole.is_window or not 0.7 <= width <= 2.4 or (form in LONG_CURTAINS and hole.opening.over is not None):
            continue
        if form == "valance":
            width, height = round(width - 0.1, 4), VALANCE_HEIGHT_M
        has_casing = float(models.for_role("window").params.get("casing", 0.0)) > 0
        v = CURTAIN_FROM_WALL_M if has_casing else CURTAIN_FROM_BARE_WALL_M
        middle, high = (hole.left + hole.right) / 2, hole.top + CURTAIN_ABOVE_HOLE_M
        spot = Spot(hole.wall.frame, middle, v, high, height_reference=HeightReference.HEAD)
        params = {**model.choice.params, "width": width, "height": height}
        order.add(f"{hole.opening.id}_curtain", "curtain", model.choice.preset, spot, params)
