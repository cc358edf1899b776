"""Burners: gas burners under grates, coils, and rings under glass, with their sites and behaviour."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.behavior_builder import BehaviorBuilder
from casa_assets.families.kit.solids.blocks import box, lathe, rod
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import tube
from casa_assets.families.parts.cooktop.grates import BurnerSpot, GrateStyle, add_grates, burner_cells
from casa_assets.model.asset.behavior import EffectKind

# Ref: RoboCasa v1.0, class Stove: STOVE_LOW_MIN 0.35 rad, STOVE_HIGH_MIN 80 degrees.
KNOB_ON_ANGLE, KNOB_HIGH_ANGLE = 0.35, math.radians(80)
SMALL_RADIUS, LARGE_RADIUS = 0.0725, 0.092  # radii of burners, metres
DRIP_BOWL_RATIO = 1.16  # radius of a drip bowl over that of its coil
FLAME_COLOR, GLOW_COLOR = (0.06, 0.2, 0.75, 0.0), (0.85, 0.12, 0.03, 0.0)


class Fuel(StrEnum):
    """Kind of burner."""

    GAS = "gas"
    COIL = "coil"
    CERAMIC = "ceramic"
    INDUCTION = "induction"


def burner_positions(
    count: int, width: float, depth: float, middle: tuple[float, float] = (0.0, 0.0)
) -> list[BurnerSpot]:
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
    field: tuple[float, float],
    style: GrateStyle,
    middle: tuple[float, float] = (0.0, 0.0),
    ink: str = "plastic_grey_light",
) -> None:
    """Burners on a surface at z = top, with their sites.

    Args:
        grate: finish of the grates. field: width and depth that the grates cover, metres, about `middle`.
        style: of the grates. ink: finish of rings that are printed on glass.
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
            _coil(builder, s, top)
    else:
        pan_z = top + 0.0004
        for s in places:
            _ring(builder, s, top, fuel, ink)
    for s in places:
        color = FLAME_COLOR if fuel is Fuel.GAS else GLOW_COLOR
        marker_height = 0.02 if fuel is Fuel.GAS else 0.004
        base = top + (0.022 if fuel is Fuel.GAS else 0.0)
        builder.column(
            f"burner_on_{s.loc}",
            (s.x, s.y, base + marker_height / 2),
            (1.3 * s.radius, 1.3 * s.radius, marker_height),
            color,
        )
        builder.site(f"burner_{s.loc}_place_site", (s.x, s.y, pan_z), radius=0.01)


def _gas(builder: AssetBuilder, s: BurnerSpot, top: float) -> None:
    r = 0.5 * s.radius
    bowl = lathe([(1.25 * r, top + 0.0003), (1.2 * r, top + 0.004), (1.0 * r, top + 0.005)], 36)
    head = lathe(
        [(0.8 * r, top + 0.0052), (0.92 * r, top + 0.009), (0.92 * r, top + 0.019), (0.86 * r, top + 0.021)], 36
    )
    cap = lathe(
        [
            (0.9 * r, top + 0.0212),
            (0.94 * r, top + 0.023),
            (0.9 * r, top + 0.0275),
            (0.6 * r, top + 0.03),
            (0.0, top + 0.0305),
        ],
        36,
    )
    for solid, finish in ((bowl, "stainless_brushed"), (head, "aluminium_anodised"), (cap, "cast_iron_black")):
        builder.add(ROOT, _moved(solid, s), finish, label="burner", collider=False)
    ports = 16
    for k in range(ports):
        t = 2 * math.pi * k / ports
        slit = box(
            (0.0025, 0.0012, 0.006), (s.x + 0.925 * r * math.cos(t), s.y + 0.925 * r * math.sin(t), top + 0.0165), 0.0
        )
        builder.add(
            ROOT,
            slit.rotated("z", t + math.pi / 2, (s.x + 0.925 * r * math.cos(t), s.y + 0.925 * r * math.sin(t), 0)),
            "rubber_black",
            "burner",
            collider=False,
            density=0.0,
        )


def _moved(solid: Solid, s: BurnerSpot) -> Solid:
    return solid.translated(s.x, s.y)


def _coil(builder: AssetBuilder, s: BurnerSpot, top: float) -> None:
    bowl = lathe(
        [
            (1.12 * s.radius, top + 0.0004),
            (1.16 * s.radius, top + 0.004),
            (1.04 * s.radius, top + 0.003),
            (0.4 * s.radius, top + 0.0012),
        ],
        40,
    )
    builder.add(ROOT, _moved(bowl, s), "stainless_polished", label="burner", collider=False)
    turns = 3.5 if s.radius < 0.09 else 4.5
    steps = int(turns * 22)
    path = []
    for k in range(steps + 1):
        t = 2 * math.pi * turns * k / steps
        r = 0.2 * s.radius + 0.76 * s.radius * k / steps
        path.append((s.x + r * math.cos(t), s.y + r * math.sin(t), top + 0.0138))
    builder.add(ROOT, tube(path, 0.0042).without_colliders(), "heating_element", label="burner", collider=False)
    collider_disc = rod(0.98 * s.radius, 0.0178, 0.0).translated(s.x, s.y, top + 0.0091)
    builder.add_collider(ROOT, collider_disc, "heating_element", "burner")


def _ring(builder: AssetBuilder, s: BurnerSpot, top: float, fuel: Fuel, ink: str) -> None:
    """Rings printed on glass, 0.2 mm above it."""
    z = top + 0.0002
    radii = (s.radius, 0.62 * s.radius) if fuel is Fuel.CERAMIC else (s.radius,)
    for r in radii:
        ring = lathe([(r - 0.0016, z), (r, z), (r, z + 0.0002), (r - 0.0016, z + 0.0002)], 56, closed=True)
        builder.add(ROOT, _moved(ring, s), ink, label="burner", collider=False, density=0.0)
    if fuel is Fuel.INDUCTION:
        for t in np.arange(4) * math.pi / 2:
            tick = box((0.0014, 0.3 * s.radius, 0.0002), (0.0, 0.0, z + 0.0001), 0.0).translated(
                0.0, 0.85 * s.radius - 0.15 * s.radius, 0.0
            )
            builder.add(ROOT, _moved(tick.rotated("z", float(t)), s), ink, label="burner", collider=False, density=0.0)


def add_burner_behavior(behavior: BehaviorBuilder, places: list[BurnerSpot], fuel: Fuel, turn: float) -> None:
    """Each knob sets its burner to off, low or high."""
    color = (*(FLAME_COLOR if fuel is Fuel.GAS else GLOW_COLOR)[:3], 0.6)
    intervals = {
        "off": (-0.1, KNOB_ON_ANGLE),
        "low": (KNOB_ON_ANGLE, KNOB_HIGH_ANGLE),
        "high": (KNOB_HIGH_ANGLE, turn + 0.1),
    }
    for s in places:
        name, site = f"burner_{s.loc}", f"burner_on_{s.loc}"
        behavior.follow_joint(name, f"knob_{s.loc}_joint", intervals)
        for value, strength in (("low", 0.5), ("high", 1.0)):
            behavior.effect(EffectKind.SHOW, name, site, value=value, color=color, strength=strength)
            behavior.effect(EffectKind.HEAT, name, site, value=value, strength=strength)
