"""Cast-iron grates over gas burners: joined to one surface, one for each burner, or rings with arms."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import board, box, lathe, rod
from casa_assets.families.kit.solids.boolean import subtract
from casa_assets.families.kit.solids.solid import Solid

BAR_WIDTH, BAR_HEIGHT = 0.0095, 0.013  # metres: width and height of a bar
HALF_GRATE_GAP = 0.0015  # half of the gap between two grates
FINGER_END_SHARE = 0.3  # share of a burner's radius at which fingers end before its middle


class GrateStyle(StrEnum):
    """Style of the grates."""

    JOINED = "joined"  # a grate for each column of burners; together they make one surface
    SEPARATE = "separate"  # a square one for each burner
    RING = "ring"  # a ring with arms for each burner


@dataclass(frozen=True)
class BurnerSpot:
    """A burner: its location's name, its middle and radius in metres."""

    loc: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class BurnerCell:
    """The part of the field that belongs to a burner: (x0, x1) and (y0, y1), metres."""

    spot: BurnerSpot
    x: tuple[float, float]
    y: tuple[float, float]


@dataclass(frozen=True)
class _Span:
    """A bar from one corner to the other, seen from above, metres."""

    x: tuple[float, float]
    y: tuple[float, float]


def burner_cells(
    places: Sequence[BurnerSpot], field: tuple[float, float], middle: tuple[float, float]
) -> list[BurnerCell]:
    """The field (width, depth) about `middle` shared out among columns of burners."""
    (w, d), (mx, my) = field, middle
    columns = sorted({round(s.x, 4) for s in places})
    pitch = w / len(columns)
    out = []
    for k, x in enumerate(columns):
        in_column = sorted((s for s in places if round(s.x, 4) == x), key=lambda s: s.y)
        x0, cell_depth = mx - w / 2 + pitch * k, d / len(in_column)
        for j, s in enumerate(in_column):
            y0 = my - d / 2 + cell_depth * j
            out.append(BurnerCell(s, (x0, x0 + pitch), (y0, y0 + cell_depth)))
    return out


def add_grates(
    builder: AssetBuilder,
    places: Sequence[BurnerCell],
    top: float,
    pan_z: float,
    finish: str,
    style: GrateStyle = GrateStyle.JOINED,
) -> None:
    """Add grates that rest on z = `top` and carry a pan at z = `pan_z`, metres."""
    if style is GrateStyle.RING:
        for cell in places:
            _ring(builder, cell, top, pan_z, finish)
        return
    inset = HALF_GRATE_GAP if style is GrateStyle.JOINED else 0.011
    frames = _columns(places) if style is GrateStyle.JOINED else [[c] for c in places]
    for frame in frames:
        for span in _frame(frame, inset):
            builder.add(ROOT, _bar(span, pan_z, BAR_HEIGHT), finish, label="grate", collider=False)
        for x in (frame[0].x[0] + inset + BAR_WIDTH / 2, frame[0].x[1] - inset - BAR_WIDTH / 2):
            for y in (frame[0].y[0] + inset + 0.02, frame[-1].y[1] - inset - 0.02):
                _foot(builder, x, y, top, pan_z, finish)
    rows = sorted({round(c.spot.y, 4) for c in places})
    for cell in places:
        for finger in _fingers(cell, inset, rows):
            builder.add(ROOT, _bar(finger, pan_z, BAR_HEIGHT - 0.001), finish, label="grate", collider=False)
    for span in _collider_bars(places, inset, rows):
        builder.add_collider(ROOT, _bar(span, pan_z, BAR_HEIGHT), finish, "grate")


def _collider_bars(places: Sequence[BurnerCell], inset: float, rows: Sequence[float]) -> Iterator[_Span]:
    """A few bars as colliders of the grate: neighbouring bars are one, fingers go across the hole between them."""
    columns = _columns(places)
    edges = sorted({round(v, 6) for c in columns for v in c[0].x})
    ends = sorted({round(v, 6) for c in places for v in c.y})
    x_span, y_span = (edges[0] + inset, edges[-1] - inset), (ends[0] + inset, ends[-1] - inset)
    reach = inset + BAR_WIDTH
    for x in edges:
        yield _Span((max(x - reach, x_span[0]), min(x + reach, x_span[1])), y_span)
    for column in columns:
        x = column[0].spot.x
        yield _Span((x - 0.004, x + 0.004), y_span)
    for y in ends:
        yield _Span(x_span, (max(y - reach, y_span[0]), min(y + reach, y_span[1])))
    for y in rows:
        if all(abs(y - end) > reach for end in ends):
            yield _Span(x_span, (y - 0.004, y + 0.004))


def _columns(places: Sequence[BurnerCell]) -> list[list[BurnerCell]]:
    """Cells of one column together, the nearest first."""
    out: dict[float, list[BurnerCell]] = {}
    for cell in places:
        out.setdefault(cell.x[0], []).append(cell)
    return list(out.values())


def _frame(column: Sequence[BurnerCell], inset: float) -> Iterator[_Span]:
    """Rails round a grate, and a bar between two burners."""
    (x0, x1), y0, y1 = column[0].x, column[0].y[0] + inset, column[-1].y[1] - inset
    x0, x1 = x0 + inset, x1 - inset
    yield _Span((x0, x0 + BAR_WIDTH), (y0, y1))
    yield _Span((x1 - BAR_WIDTH, x1), (y0, y1))
    inner = (x0 + BAR_WIDTH - 0.002, x1 - BAR_WIDTH + 0.002)
    yield _Span(inner, (y0, y0 + BAR_WIDTH))
    yield _Span(inner, (y1 - BAR_WIDTH, y1))
    for cell in column[1:]:
        yield _Span(inner, (cell.y[0] - BAR_WIDTH / 2, cell.y[0] + BAR_WIDTH / 2))


def _fingers(cell: BurnerCell, inset: float, rows: Sequence[float]) -> Iterator[_Span]:
    """Four fingers from the rails to the burner; a long cell has bars across in line with its neighbours' burners."""
    s, half = cell.spot, 0.004
    stop = FINGER_END_SHARE * s.radius
    x0, x1 = cell.x[0] + inset + BAR_WIDTH - 0.002, cell.x[1] - inset - BAR_WIDTH + 0.002
    y0, y1 = cell.y[0] + inset + BAR_WIDTH - 0.002, cell.y[1] - inset - BAR_WIDTH + 0.002
    yield _Span((x0, s.x - stop), (s.y - half, s.y + half))
    yield _Span((s.x + stop, x1), (s.y - half, s.y + half))
    yield _Span((s.x - half, s.x + half), (y0, s.y - stop))
    yield _Span((s.x - half, s.x + half), (s.y + stop, y1))
    for y in rows:
        if y0 < y < y1 and abs(y - s.y) > 0.02:
            yield _Span((x0, x1), (y - half, y + half))


def _bar(span: _Span, top: float, height: float) -> Solid:
    (x0, x1), (y0, y1) = span.x, span.y
    return box((x1 - x0, y1 - y0, height), ((x0 + x1) / 2, (y0 + y1) / 2, top - height / 2), 0.002)


def _foot(builder: AssetBuilder, x: float, y: float, top: float, pan_z: float, finish: str) -> None:
    """A leg on a pad of rubber."""
    under = pan_z - BAR_HEIGHT
    pad = 0.0025
    leg = box((BAR_WIDTH, 0.018, under - top - pad + 0.002), (x, y, (under + top + pad + 0.002) / 2), 0.002)
    builder.add(ROOT, leg, finish, label="grate", collider=False)
    tip = box((BAR_WIDTH - 0.001, 0.014, pad), (x, y, top + 0.0003 + pad / 2), 0.0005)
    builder.add(ROOT, tip, "rubber_black", label="grate", collider=False)


def _ring(builder: AssetBuilder, cell: BurnerCell, top: float, pan_z: float, finish: str) -> None:
    """Add a ring around the burner, with four arms that carry the pan."""
    s = cell.spot
    clearance = min(cell.x[1] - s.x, s.x - cell.x[0], cell.y[1] - s.y, s.y - cell.y[0]) - 0.004
    r = min(1.12 * s.radius, 0.78 * clearance)
    z = top + 0.012
    hoop = lathe(
        [(r - 0.004, z - 0.004), (r + 0.004, z - 0.004), (r + 0.004, z + 0.004), (r - 0.004, z + 0.004)],
        48,
        closed=True,
    )
    builder.add(ROOT, hoop.translated(s.x, s.y), finish, label="grate", collider=False)
    for k in range(4):
        turn = math.pi / 4 + k * math.pi / 2
        reach = min(r + 0.02, clearance * 1.25)
        arm = box(
            (reach - FINGER_END_SHARE * s.radius, 0.0075, 0.011),
            ((reach + FINGER_END_SHARE * s.radius) / 2, 0.0, pan_z - 0.0055),
            0.002,
        )
        post = box((0.012, 0.0075, pan_z - z), (r, 0.0, (pan_z + z) / 2 - 0.001), 0.002)
        foot = rod(0.006, z - top - 0.0005, 0.001).translated(r, 0.0, (z + top) / 2 + 0.0002)
        for solid in (arm, post, foot):
            builder.add(ROOT, solid.rotated("z", turn).translated(s.x, s.y), finish, label="grate", collider=False)
    for k in range(2):
        reach = min(r + 0.02, clearance * 1.25)
        across = box((2 * reach, 0.0075, 0.011), (0.0, 0.0, pan_z - 0.0055), 0.002).rotated(
            "z", math.pi / 4 + k * math.pi / 2
        )
        builder.add_collider(ROOT, across.translated(s.x, s.y), finish, "grate")
    skirt = rod(r, 0.022, 0.0).translated(s.x, s.y, top + 0.0115)
    builder.add_collider(ROOT, skirt, finish, "grate")


def add_griddle(builder: AssetBuilder, lower: tuple[float, float], upper: tuple[float, float], top: float) -> None:
    """A thick steel plate with a rim and a trough in front, between two corners seen from above, on z = top, metres."""
    (x0, y0), (x1, y1), z = lower, upper, top + 2e-4
    tray = board((x0, y0, z), (x1, y1, z + 0.03), 0.003, 2)
    hollow = board((x0 + 0.012, y0 + 0.012, z + 0.018), (x1 - 0.012, y1 - 0.012, z + 1.0), 0.0)
    plate = board((x0 + 0.0125, y0 + 0.05, z + 0.0182), (x1 - 0.0125, y1 - 0.0125, z + 0.025), 0.001)
    builder.add(
        ROOT, subtract(tray, hollow, shapes=tray.shapes), "stainless_brushed", label="grate", density="griddle_plate"
    )
    builder.add(ROOT, plate, "stainless_polished", label="grate", collider=False)
