"""What finishes a kitchen: cornices over rows of cabinets, and cloth at windows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from casa_assets.layouts.order.cabinets import face_of
from casa_assets.layouts.order.models import Models
from casa_assets.layouts.order.wanted import Depth, Height, Order, Spot, Wanted, member
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import Hole
from casa_assets.layouts.plan.runs import CornerPart, EndKind, Line, Slot
from casa_assets.model.kitchen.plan import CornerKind
from casa_assets.model.kitchen.units import TALL, BaseKind, BaseUnit, UpperKind

HEIGHT = 0.07  # metres of a cornice
OUT = 0.04  # metres that it stands out
FLAT = "flat"  # the profile that does not
TOUCHING = 0.012  # metres: nearer units are of one row
LEAST = 0.4  # metres of the shortest cornice
PLAY = 0.0005
UNDER = ("under_cabinet", "downlight")  # hoods with a cabinet over them
LONG = ("drapes", "tied", "cafe")  # curtains that hang down to worktops and taps
BEFORE = 0.0235  # metres between a wall and the back of a curtain: the casing that it hangs on is between them
BARE = 0.004  # the same where the window has no casing
OVER = 0.05  # metres from the top of a hole to that of a curtain
VALANCE = 0.3


@dataclass(frozen=True)
class Row:
    """Units side by side of one height and depth: left and right along their run, metres; whether they are tall."""

    left: float
    right: float
    depth: float
    is_tall: bool


def order_cornices(
    order: Order, lines: Mapping[str, Line], slots: Mapping[str, Sequence[Slot]], models: Models
) -> None:
    """A cornice over every row, with returns to the wall at ends that are seen; none where the style has no profile."""
    profile = models.style.cabinets.cornice
    if profile is None:
        return
    out = 0.0 if profile == FLAT else OUT
    for name, line in lines.items():
        if not line.at_wall:
            continue
        rows = [r for r in find_rows(line, slots[name], models) if r.right - r.left >= LEAST]
        for k, row in enumerate(rows):
            left, right = _is_seen(row, row.left, rows, line), _is_seen(row, row.right, rows, line)
            # It ends at the return of a deeper row beside it.
            begin = row.left + (out + PLAY if _is_butted(row, row.left, rows) or _is_at_corner(row.left, line) else 0.0)
            # Of two rows round a corner the first ends earlier only where the other one goes through to the wall.
            meets = line.right.corner is not None and line.right.corner.upper is CornerKind.BLIND
            short = _is_butted(row, row.right, rows) or (meets and _is_at_corner(row.right, line))
            end = row.right - (out + PLAY if short else 0.0)
            if end - begin < LEAST:
                continue
            params = {
                "width": round(end - begin, 4),
                "depth": row.depth,
                "height": HEIGHT,
                "out": out,
                "left_return": left,
                "right_return": right,
                "profile": profile,
                "face": face_of(models, "tall" if row.is_tall else "upper"),
            }
            low, high = begin - (out if left else 0.0), end + (out if right else 0.0)
            spot = Spot(
                line.frame, (low + high) / 2, row.depth + out, standard_sizes.UPPER_TO + 5e-4, depth=Depth.FRONT
            )
            stem = f"{name}_cornice" if k == 0 else f"{name}_cornice_{k + 1}"
            order.add(Wanted(stem, "cornice", member("cornice/white_crown", params), spot, "", name))


def find_rows(line: Line, slots: Sequence[Slot], models: Models) -> list[Row]:
    """Rows of a run from left to right, tall ones and wall units apart."""
    out: list[Row] = []
    for left, right, depth, is_tall in sorted(_topped(line, slots, models)):
        last = out[-1] if out else None
        if last and left - last.right < TOUCHING and last.is_tall is is_tall and abs(last.depth - depth) < 1e-3:
            out[-1] = Row(last.left, right, depth, is_tall)
        else:
            out.append(Row(left, right, depth, is_tall))
    return out


def _topped(line: Line, slots: Sequence[Slot], models: Models) -> Iterator[tuple[float, float, float, bool]]:
    """Left, right, depth of cabinets that reach the height of the wall units, and whether they stand on the floor."""
    for slot in slots:
        if abs(slot.high - standard_sizes.UPPER_TO) > 1e-3:
            continue
        if slot.is_upper:
            hood = slot.kind is UpperKind.HOOD and models.of("hood").numbers["form"] in UNDER
            if hood or slot.kind in (UpperKind.DOORS, UpperKind.GLASS, CornerPart.BLIND, CornerPart.FILLER):
                yield slot.left, slot.right, standard_sizes.UPPER_DEPTH, False
        elif slot.kind in (*TALL, BaseKind.PANEL, BaseKind.FILLER, CornerPart.FILLER):
            bare = isinstance(slot.unit, BaseUnit) and slot.kind is BaseKind.FRIDGE and not slot.unit.housing
            if not bare:
                yield slot.left, slot.right, line.depth, True


def _is_seen(row: Row, at: float, rows: Sequence[Row], line: Line) -> bool:
    """Whether an end of a row is free: no wall, no deeper or equal row beside it."""
    if at < OUT + TOUCHING or at > line.length - OUT - TOUCHING or _is_at_corner(at, line):
        return False
    return all(r.depth < row.depth - 1e-3 for r in _beside(row, at, rows))


def _is_at_corner(at: float, line: Line) -> bool:
    """Whether an end of a row of wall units lies before those of the run round the corner."""
    near_left = line.left.kind is EndKind.CORNER and abs(at - standard_sizes.UPPER_DEPTH) < TOUCHING
    return near_left or (
        line.right.kind is EndKind.CORNER and abs(line.length - at - standard_sizes.UPPER_DEPTH) < TOUCHING
    )


def _is_butted(row: Row, at: float, rows: Sequence[Row]) -> bool:
    """Whether a deeper row stands at an end of a row."""
    return any(r.depth > row.depth + 1e-3 for r in _beside(row, at, rows))


def _beside(row: Row, at: float, rows: Sequence[Row]) -> list[Row]:
    return [r for r in rows if r is not row and min(abs(r.left - at), abs(r.right - at)) < OUT + TOUCHING]


def order_curtains(order: Order, holes: Sequence[Hole], models: Models) -> None:
    """The style's curtain at every window; none where a long one would hang over a worktop."""
    if not models.has("curtain"):
        return
    model = models.of("curtain")
    form = model.numbers["form"]
    for hole in holes:
        width, height = round(hole.right - hole.left, 4), round(hole.high - hole.low, 4)
        if not hole.is_window or not 0.7 <= width <= 2.4 or (form in LONG and hole.opening.over is not None):
            continue
        if form == "valance":
            width, height = round(width - 0.1, 4), VALANCE
        choice = member(model.choice.preset, {**model.choice.params, "width": width, "height": height})
        before = BEFORE if float(models.of("window").numbers.get("casing", 0.0)) else BARE
        spot = Spot(hole.wall.frame, (hole.left + hole.right) / 2, before, hole.high + OVER, height=Height.HEAD)
        order.add(Wanted(f"{hole.opening.id}_curtain", "curtain", choice, spot))
