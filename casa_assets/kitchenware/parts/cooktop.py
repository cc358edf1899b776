"""Burners (gas, coils, rings under glass) and the cast-iron grates over them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext.records import EffectKind, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, BehaviorBuilder, Solid, board, box, lathe, rod, subtract, tube

BAR_WIDTH, BAR_HEIGHT = 0.0095, 0.013  # metres: width and height of a bar
HALF_GRATE_GAP = 0.0015  # half of the gap between two grates
FINGER_END_SHARE = 0.3  # share of a burner's radius at which fingers end before its middle

# Style of the grates: JOINED a grate for each column of burners; together they make one surface; SEPARATE a square one
# for each burner; RING a ring with arms for each burner.
GrateStyle = StrEnum("GrateStyle", "JOINED SEPARATE RING")

_Span = tuple[Vec2, Vec2]  # a bar seen from above: (x0, x1) and (y0, y1), metres

# Ref: RoboCasa v1.0, class Stove: STOVE_LOW_MIN 0.35 rad, STOVE_HIGH_MIN 80 degrees.
KNOB_ON_ANGLE, KNOB_HIGH_ANGLE = 0.35, math.radians(80)
SMALL_RADIUS, LARGE_RADIUS = 0.0725, 0.092  # radii of burners, metres
DRIP_BOWL_RATIO = 1.16  # radius of a drip bowl over that of its coil
FLAME_COLOR, GLOW_COLOR = (0.06, 0.2, 0.75, 0.0), (0.85, 0.12, 0.03, 0.0)

Fuel = StrEnum("Fuel", "GAS COIL CERAMIC INDUCTION")


# Grates ---------------------------------------------------------------------------------------------------------------


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
    x: Vec2
    y: Vec2


def burner_cells(places: Sequence[BurnerSpot], field: Vec2, middle: Vec2) -> list[list[BurnerCell]]:
    """The field (width, depth) about `middle` shared out among columns of burners, by columns."""
    (w, d), (mx, my) = field, middle
    columns = sorted({round(s.x, 4) for s in places})
    pitch = w / len(columns)
    out = []
    for k, x in enumerate(columns):
        in_column = sorted((s for s in places if round(s.x, 4) == x), key=lambda s: s.y)
        x0, cell_depth = mx - w / 2 + pitch * k, d / len(in_column)
        starts = [my - d / 2 + cell_depth * j for j in range(len(in_column))]
        out.append(
            [BurnerCell(s, (x0, x0 + pitch), (y, y + cell_depth)) for s, y in zip(in_column, starts, strict=True)]
        )
    return out


def add_grates(
    builder: AssetBuilder,
    columns: Sequence[Sequence[BurnerCell]],
    top: float,
    pan_z: float,
    finish: str,
    style: GrateStyle = GrateStyle.JOINED,
) -> None:
    """Add grates that rest on z = `top` and carry a pan at z = `pan_z`, metres."""
    places = [cell for column in columns for cell in column]
    if style is GrateStyle.RING:
        for cell in places:
            _ring(builder, cell, top, pan_z, finish)
        return
    inset = HALF_GRATE_GAP if style is GrateStyle.JOINED else 0.011
    for frame in columns if style is GrateStyle.JOINED else [[c] for c in places]:
        builder.draw(ROOT, [_bar(span, pan_z, BAR_HEIGHT) for span in _frame(frame, inset)], finish, "grate")
        for x in (frame[0].x[0] + inset + BAR_WIDTH / 2, frame[0].x[1] - inset - BAR_WIDTH / 2):
            for y in (frame[0].y[0] + inset + 0.02, frame[-1].y[1] - inset - 0.02):
                under = pan_z - BAR_HEIGHT
                pad = 0.0025
                leg = box((BAR_WIDTH, 0.018, under - top - pad + 0.002), (x, y, (under + top + pad + 0.002) / 2), 0.002)
                builder.draw(ROOT, leg, finish, "grate")
                tip = box((BAR_WIDTH - 0.001, 0.014, pad), (x, y, top + 0.0003 + pad / 2), 0.0005)
                builder.draw(ROOT, tip, "rubber_black", "grate")
    rows = sorted({round(c.spot.y, 4) for c in places})
    grates = [_bar(finger, pan_z, BAR_HEIGHT - 0.001) for cell in places for finger in _fingers(cell, inset, rows)]
    builder.draw(ROOT, grates, finish, "grate")
    for span in _collider_bars(columns, inset, rows):
        builder.add_collider(ROOT, _bar(span, pan_z, BAR_HEIGHT), finish, "grate")


def _collider_bars(columns: Sequence[Sequence[BurnerCell]], inset: float, rows: Sequence[float]) -> Iterator[_Span]:
    """A few bars as colliders of the grate: neighbouring bars are one, fingers go across the hole between them."""
    edges = sorted({round(v, 6) for c in columns for v in c[0].x})
    ends = sorted({round(v, 6) for column in columns for c in column for v in c.y})
    x_span, y_span = (edges[0] + inset, edges[-1] - inset), (ends[0] + inset, ends[-1] - inset)
    reach = inset + BAR_WIDTH
    for x in edges:
        yield (max(x - reach, x_span[0]), min(x + reach, x_span[1])), y_span
    for column in columns:
        x = column[0].spot.x
        yield (x - 0.004, x + 0.004), y_span
    for y in ends:
        yield x_span, (max(y - reach, y_span[0]), min(y + reach, y_span[1]))
    for y in rows:
        if all(abs(y - end) > reach for end in ends):
            yield x_span, (y - 0.004, y + 0.004)


def _frame(column: Sequence[BurnerCell], inset: float) -> Iterator[_Span]:
    (x0, x1), y0, y1 = column[0].x, column[0].y[0] + inset, column[-1].y[1] - inset
    x0, x1 = x0 + inset, x1 - inset
    yield (x0, x0 + BAR_WIDTH), (y0, y1)
    yield (x1 - BAR_WIDTH, x1), (y0, y1)
    inner = (x0 + BAR_WIDTH - 0.002, x1 - BAR_WIDTH + 0.002)
    yield inner, (y0, y0 + BAR_WIDTH)
    yield inner, (y1 - BAR_WIDTH, y1)
    for cell in column[1:]:
        yield inner, (cell.y[0] - BAR_WIDTH / 2, cell.y[0] + BAR_WIDTH / 2)


def _fingers(cell: BurnerCell, inset: float, rows: Sequence[float]) -> Iterator[_Span]:
    """Four fingers from the rails to the burner; a long cell has bars across in line with its neighbours' burners."""
    s, half = cell.spot, 0.004
    stop = FINGER_END_SHARE * s.radius
    x0, x1 = cell.x[0] + inset + BAR_WIDTH - 0.002, cell.x[1] - inset - BAR_WIDTH + 0.002
    y0, y1 = cell.y[0] + inset + BAR_WIDTH - 0.002, cell.y[1] - inset - BAR_WIDTH + 0.002
    yield (x0, s.x - stop), (s.y - half, s.y + half)
    yield (s.x + stop, x1), (s.y - half, s.y + half)
    yield (s.x - half, s.x + half), (y0, s.y - stop)
    yield (s.x - half, s.x + half), (s.y + stop, y1)
    for y in rows:
        if y0 < y < y1 and abs(y - s.y) > 0.02:
            yield (x0, x1), (y - half, y + half)


def _bar(span: _Span, top: float, height: float) -> Solid:
    (x0, x1), (y0, y1) = span
    return box((x1 - x0, y1 - y0, height), ((x0 + x1) / 2, (y0 + y1) / 2, top - height / 2), 0.002)


def _ring(builder: AssetBuilder, cell: BurnerCell, top: float, pan_z: float, finish: str) -> None:
    s = cell.spot
    clearance = min(cell.x[1] - s.x, s.x - cell.x[0], cell.y[1] - s.y, s.y - cell.y[0]) - 0.004
    r = min(1.12 * s.radius, 0.78 * clearance)
    z = top + 0.012
    line = [(r - 0.004, z - 0.004), (r + 0.004, z - 0.004), (r + 0.004, z + 0.004), (r - 0.004, z + 0.004)]
    builder.draw(ROOT, lathe(line, 48, closed=True).translated(s.x, s.y), finish, "grate")
    for k in range(4):
        turn = math.pi / 4 + k * math.pi / 2
        reach = min(r + 0.02, clearance * 1.25)
        arm = box(
            (reach - FINGER_END_SHARE * s.radius, 0.0075, 0.011),
            ((reach + FINGER_END_SHARE * s.radius) / 2, 0.0, pan_z - 0.0055),
            0.002,
        )
        post = box((0.012, 0.0075, pan_z - z), (r, 0.0, (pan_z + z) / 2 - 0.001), 0.002)
        for solid in (arm, post, rod(0.006, z - top - 0.0005, 0.001).translated(r, 0.0, (z + top) / 2 + 0.0002)):
            builder.draw(ROOT, solid.rotated("z", turn).translated(s.x, s.y), finish, "grate")
    for k in range(2):
        reach = min(r + 0.02, clearance * 1.25)
        across = box((2 * reach, 0.0075, 0.011), (0.0, 0.0, pan_z - 0.0055), 0.002)
        across = across.rotated("z", math.pi / 4 + k * math.pi / 2)
        builder.add_collider(ROOT, across.translated(s.x, s.y), finish, "grate")
    builder.add_collider(ROOT, rod(r, 0.022, 0.0).translated(s.x, s.y, top + 0.0115), finish, "grate")


def add_griddle(builder: AssetBuilder, lower: Vec2, upper: Vec2, top: float) -> None:
    """A thick steel plate with a rim and a trough in front, between two corners seen from above, on z = top, metres."""
    (x0, y0), (x1, y1), z = lower, upper, top + 2e-4
    tray = board((x0, y0, z), (x1, y1, z + 0.03), 0.003, 2)
    hollow = board((x0 + 0.012, y0 + 0.012, z + 0.018), (x1 - 0.012, y1 - 0.012, z + 1.0), 0.0)
    plate = board((x0 + 0.0125, y0 + 0.05, z + 0.0182), (x1 - 0.0125, y1 - 0.0125, z + 0.025), 0.001)
    builder.add(ROOT, subtract(tray, hollow, shapes=tray.shapes), "stainless_brushed", "grate", density="griddle_plate")
    builder.draw(ROOT, plate, "stainless_polished", "grate")


# Burners --------------------------------------------------------------------------------------------------------------


def burner_positions(count: int, width: float, depth: float, middle: Vec2 = (0.0, 0.0)) -> list[BurnerSpot]:
    """Positions of four, five or six burners on a field about `middle`, metres."""
    # Pans of 145 and 180 mm, and a wide one in the middle; two in a column keep clear of each other, dishes and all.
    scale = min(1.0, (depth / 2 - 0.006) / (DRIP_BOWL_RATIO * (SMALL_RADIUS + LARGE_RADIUS)))
    count_x = 2 if count == 4 else 3
    left, right = -width * (count_x - 1) / (2 * count_x), width * (count_x - 1) / (2 * count_x)
    columns = [("left", left), ("right", right)]
    if count == 6:
        columns.insert(1, ("center", 0.0))
    rows = (("rear", depth / 4), ("front", -depth / 4))
    out = []
    for i, (side, x) in enumerate(columns):
        for j, (row, y) in enumerate(rows):
            out.append(BurnerSpot(f"{row}_{side}", x, y, (LARGE_RADIUS if (i + j) % 2 else SMALL_RADIUS) * scale))
    if count == 5:
        out.append(BurnerSpot("center", 0.0, 0.0, min(0.108, 0.45 * width / 3)))
    return [BurnerSpot(s.loc, s.x + middle[0], s.y + middle[1], s.radius) for s in out]


def add_burners(
    builder: AssetBuilder,
    fuel: Fuel,
    places: list[BurnerSpot],
    top: float,
    grate: str,
    field: Vec2,
    style: GrateStyle,
    middle: Vec2 = (0.0, 0.0),
    ink: str = "plastic_grey_light",
) -> None:
    """Burners on a surface at z = top, with their sites.

    grate: finish of the grates. field: width and depth that the grates cover, metres, about `middle`. style: of the
    grates. ink: finish of rings that are printed on glass.
    """
    pan_z = top
    if fuel is Fuel.GAS:
        pan_z = top + 0.045
        for s in places:
            _gas(builder, s, top)
        add_grates(builder, burner_cells(places, field, middle), top, pan_z, grate, style)
    elif fuel is Fuel.COIL:
        pan_z = top + 0.018
        for s in places:
            lip = [(1.12 * s.radius, top + 0.0004), (1.16 * s.radius, top + 0.004), (1.04 * s.radius, top + 0.003)]
            bowl = lathe([*lip, (0.4 * s.radius, top + 0.0012)], 40)
            builder.draw(ROOT, _moved(bowl, s), "stainless_polished", "burner")
            turns = 3.5 if s.radius < 0.09 else 4.5
            steps = int(turns * 22)
            path = []
            for k in range(steps + 1):
                t = 2 * math.pi * turns * k / steps
                r = 0.2 * s.radius + 0.76 * s.radius * k / steps
                path.append((s.x + r * math.cos(t), s.y + r * math.sin(t), top + 0.0138))
            builder.draw(ROOT, tube(path, 0.0042).without_colliders(), "heating_element", "burner")
            collider_disc = rod(0.98 * s.radius, 0.0178, 0.0).translated(s.x, s.y, top + 0.0091)
            builder.add_collider(ROOT, collider_disc, "heating_element", "burner")
    else:
        pan_z = top + 0.0004
        for s in places:
            _burner_ring(builder, s, top, fuel, ink)
    for s in places:
        color = FLAME_COLOR if fuel is Fuel.GAS else GLOW_COLOR
        marker_height = 0.02 if fuel is Fuel.GAS else 0.004
        builder.column(
            f"burner_on_{s.loc}",
            (s.x, s.y, (top + (0.022 if fuel is Fuel.GAS else 0.0)) + marker_height / 2),
            (1.3 * s.radius, 1.3 * s.radius, marker_height),
            color,
        )
        builder.site(f"burner_{s.loc}_place_site", (s.x, s.y, pan_z), radius=0.01)


def _gas(builder: AssetBuilder, s: BurnerSpot, top: float) -> None:
    r = 0.5 * s.radius
    bowl = lathe([(1.25 * r, top + 0.0003), (1.2 * r, top + 0.004), (1.0 * r, top + 0.005)], 36)
    line = [(0.8 * r, top + 0.0052), (0.92 * r, top + 0.009), (0.92 * r, top + 0.019), (0.86 * r, top + 0.021)]
    head = lathe(line, 36)
    outline = [
        (0.9 * r, top + 0.0212), (0.94 * r, top + 0.023), (0.9 * r, top + 0.0275), (0.6 * r, top + 0.03),
        (0.0, top + 0.0305),
    ]  # fmt: skip
    cap = lathe(outline, 36)
    for solid, finish in ((bowl, "stainless_brushed"), (head, "aluminium_anodised"), (cap, "cast_iron_black")):
        builder.draw(ROOT, _moved(solid, s), finish, "burner")
    ports = 16
    for k in range(ports):
        t = 2 * math.pi * k / ports
        burner = box(
            (0.0025, 0.0012, 0.006), (s.x + 0.925 * r * math.cos(t), s.y + 0.925 * r * math.sin(t), top + 0.0165), 0.0
        ).rotated("z", t + math.pi / 2, (s.x + 0.925 * r * math.cos(t), s.y + 0.925 * r * math.sin(t), 0))
        builder.draw(ROOT, burner, "rubber_black", "burner", density=0.0)


def _moved(solid: Solid, s: BurnerSpot) -> Solid:
    return solid.translated(s.x, s.y)


def _burner_ring(builder: AssetBuilder, s: BurnerSpot, top: float, fuel: Fuel, ink: str) -> None:
    """Rings printed on glass, 0.2 mm above it."""
    z = top + 0.0002
    for r in (s.radius, 0.62 * s.radius) if fuel is Fuel.CERAMIC else (s.radius,):
        ring = lathe([(r - 0.0016, z), (r, z), (r, z + 0.0002), (r - 0.0016, z + 0.0002)], 56, closed=True)
        builder.draw(ROOT, _moved(ring, s), ink, "burner", density=0.0)
    if fuel is Fuel.INDUCTION:
        for t in np.arange(4) * math.pi / 2:
            tick = box((0.0014, 0.3 * s.radius, 0.0002), (0.0, 0.0, z + 0.0001), 0.0)
            tick = tick.translated(0.0, 0.85 * s.radius - 0.15 * s.radius, 0.0)
            builder.draw(ROOT, _moved(tick.rotated("z", float(t)), s), ink, "burner", density=0.0)


def add_burner_behavior(behavior: BehaviorBuilder, places: list[BurnerSpot], fuel: Fuel, turn: float) -> None:
    """Each knob sets its burner to off, low or high."""
    color = (*(FLAME_COLOR if fuel is Fuel.GAS else GLOW_COLOR)[:3], 0.6)
    intervals = {
        "off": (-0.1, KNOB_ON_ANGLE), "low": (KNOB_ON_ANGLE, KNOB_HIGH_ANGLE), "high": (KNOB_HIGH_ANGLE, turn + 0.1),
    }  # fmt: skip
    for s in places:
        name, site = f"burner_{s.loc}", f"burner_on_{s.loc}"
        behavior.follow_joint(name, f"knob_{s.loc}_joint", intervals)
        for value, strength in (("low", 0.5), ("high", 1.0)):
            behavior.effect(EffectKind.SHOW, name, site, value=value, color=color, strength=strength)
            behavior.effect(EffectKind.HEAT, name, site, value=value, strength=strength)
