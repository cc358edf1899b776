"""A reference kitchen, as facts without a mesh, that keeps every rule of design, and pieces to change it with."""

from __future__ import annotations

import math
from typing import Any

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.mesh.planar import outline_of
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.floor import (
    Aisle,
    AisleKind,
    Corners,
    Fixture,
    FixtureJoint,
    FixtureRegion,
    FixtureSite,
    Footprint,
    KitchenFacts,
    PlacedRun,
    PlacedUnit,
    Role,
    RoomWall,
    RunEnd,
    SweptArea,
    WallOpening,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Vec2

LIMITS = registry.load().limits
TOP = 0.92
RIGHT = -math.pi / 2  # yaw of what stands at the right wall
OUTLINE = ((0.0, 0.0), (5.0, 0.0), (5.0, -4.0), (0.0, -4.0))


def unit(name: str, kind: str, left: float, right: float, high: float = 0.89, front: float = 0.65) -> PlacedUnit:
    """A unit of a row; tall ones and ranges carry no worktop."""
    carries = kind not in ("range", "gap") and high < 1.5
    return PlacedUnit(name=name, kind=kind, left=left, right=right, front=front, height=high, has_worktop=carries)


def foot_in(row: PlacedRun, left: float, right: float, front: float, back: float = 0.0) -> Footprint:
    middle = row.at((left + right) / 2, (front + back) / 2)
    return Footprint(center=middle, size=(right - left, front - back), yaw=row.yaw)


def box(foot: Footprint, left: float, right: float, back: float, front: float) -> Corners:
    """Corners of a rectangle before a foot's front: to the right of its middle, and before it; counter-clockwise."""
    return (foot.at(left, front), foot.at(right, front), foot.at(right, back), foot.at(left, back))


def flap(foot: Footprint, name: str, out: float, low: float, high: float, slides: bool = False) -> FixtureJoint:
    w = foot.size[0] / 2 - 0.01
    outline = box(foot, -w, w, 0.0, out)
    return FixtureJoint(
        name=name,
        kind=JointKind.SLIDE if slides else JointKind.HINGE,
        range=(-out, 0.0) if slides else (0.0, 1.5),
        grip_point=(*foot.at(0.0, 0.03), high - 0.05),
        swept_area=SweptArea(outline=outline, open_outline=outline, bottom=low, top=high, sweeps_front=True),
    )


def door(
    foot: Footprint, name: str, left: float, right: float, low: float, high: float, hung_left: bool = True
) -> FixtureJoint:
    wide, at = right - left, left if hung_left else right
    way = 1.0 if hung_left else -1.0
    arc = [(at + way * wide * math.cos(a), wide * math.sin(a)) for a in (0.0, 0.4, 0.8, 1.2, math.pi / 2)]
    swept = outline_of([foot.at(at, 0.0), *(foot.at(*p) for p in arc)])
    opened = box(foot, min(at, at + 0.02 * way), max(at, at + 0.02 * way), 0.0, wide)
    return FixtureJoint(
        name=name,
        kind=JointKind.HINGE,
        range=(0.0, 1.57),
        grip_point=(*foot.at(at + way * 0.9 * wide, 0.03), low + 0.1),
        swept_area=SweptArea(
            outline=tuple((float(x), float(y)) for x, y in swept),
            open_outline=opened,
            bottom=low,
            top=high,
            sweeps_front=False,
        ),
    )


def volume(foot: Footprint, name: str, low: float, high: float, moves: bool = False) -> FixtureRegion:
    return FixtureRegion(name=name, footprint=foot, bottom=low, top=high, is_moving=moves)


MAIN = PlacedRun(
    id="main",
    origin=(0.0, 0.0),
    yaw=0.0,
    length=5.0,
    left_end=RunEnd.WALL,
    right_end=RunEnd.CORNER,
    next_run="right",
    corner_right=1.1,
    units=(
        unit("fridge", "fridge", 0.0, 0.95, 2.26, 0.77),
        unit("main_doors", "doors", 0.95, 1.75),
        unit("main_drawers", "drawers", 1.75, 2.45),
        unit("range", "range", 2.45, 3.21, front=0.67),
        unit("main_drawers_2", "drawers", 3.21, 3.9),
    ),
)
SIDE = PlacedRun(
    id="right",
    origin=(5.0, 0.0),
    yaw=RIGHT,
    length=3.4,
    left_end=RunEnd.CORNER,
    corner_left=0.67,
    units=(
        unit("right_doors", "doors", 0.67, 1.35),
        unit("dishwasher", "dishwasher", 1.35, 1.95),
        unit("sink", "sink", 1.95, 2.85),
        unit("right_doors_2", "doors", 2.85, 3.4),
    ),
)
WALLS = (
    RoomWall(id="back", start=OUTLINE[0], end=OUTLINE[1]),
    RoomWall(id="right", start=OUTLINE[1], end=OUTLINE[2]),
    RoomWall(id="front", start=OUTLINE[2], end=OUTLINE[3], is_open=True),
    RoomWall(id="left", start=OUTLINE[3], end=OUTLINE[0]),
)
HOLE = {"bottom": 1.1, "top": 2.1, "clear_width": 1.2, "can_open": True}
WINDOW = WallOpening(id="window", kind=OpeningKind.WINDOW, wall="right", start=(5.0, -1.8), end=(5.0, -3.0), **HOLE)
HOLE = {"bottom": 0.0, "top": 2.0, "clear_width": 0.82}
DOOR = WallOpening(id="door", kind=OpeningKind.DOOR, wall="left", start=(0.0, -3.8), end=(0.0, -2.9), **HOLE)


def placed(
    name: str, role: Role, foot: Footprint, low: float, high: float, category: str = "thing", **more: Any
) -> Fixture:
    return Fixture(name=name, role=role, category=category, footprint=foot, bottom=low, top=high, **more)


def drawers(row: PlacedRun, left: float, right: float, name: str) -> Fixture:
    foot = foot_in(row, left, right, 0.6)
    slide = flap(foot, "drawer2_slidejoint", 0.5, 0.7, 0.87, slides=True)
    parts = {"joints": (slide,), "regions": (volume(foot, "drawer2_int", 0.74, 0.86, moves=True),)}
    return placed(name, Role.DRAWERS, foot, 0.0, 0.89, "drawer_stack", unit=name, run=row.id, **parts)


def cabinet(row: PlacedRun, left: float, right: float, name: str) -> Fixture:
    foot = foot_in(row, left, right, 0.6)
    joints = (door(foot, "doorhinge", -foot.size[0] / 2, foot.size[0] / 2, 0.1, 0.89),)
    return placed(name, Role.CABINET, foot, 0.0, 0.89, "base_cabinet", unit=name, run=row.id, joints=joints)


def upper(left: float, right: float, name: str, doors: int = 1, low: float = 1.38) -> Fixture:
    foot, high = foot_in(MAIN, left, right, 0.35), low + 0.88
    w = foot.size[0] / 2
    leaves = [door(foot, "doorhinge", -w, w, low, high)]
    if doors == 2:
        leaves = [door(foot, "leftdoorhinge", -w, 0.0, low, high)]
        leaves.append(door(foot, "rightdoorhinge", 0.0, w, low, high, hung_left=False))
    parts = {"joints": tuple(leaves), "regions": (volume(foot, "level0", low + 0.02, low + 0.4),)}
    return placed(name, Role.UPPER, foot, low, high, "wall_cabinet", unit=name, run="main", **parts)


def thing(name: str, role: Role, at: Vec2, size: Vec2, low: float, high: float) -> Fixture:
    return placed(name, role, Footprint(center=at, size=size), low, high)


def turn(name: str, low: float, high: float) -> FixtureJoint:
    return FixtureJoint(name=name, kind=JointKind.HINGE, range=(low, high))


def appliances() -> tuple[Fixture, ...]:
    main, side = {"run": "main"}, {"run": "right"}
    fridge, stove = foot_in(MAIN, 0.02, 0.93, 0.77, 0.03), foot_in(MAIN, 2.452, 3.208, 0.67, 0.012)
    washer, basin = foot_in(SIDE, 1.352, 1.948, 0.6), foot_in(SIDE, 2.0, 2.8, 0.58, 0.06)
    cold = (door(fridge, "door_joint", -0.45, 0.45, 0.1, 1.75),)
    hob = ("burner_on_front_left", "burner_front_left_place_site")
    cooker = {
        "joints": (flap(stove, "door_joint", 0.6, 0.2, 0.8), turn("knob_front_left_joint", 0.0, 2.6)),
        "sites": tuple(FixtureSite(name=n, position=(*stove.at(0.2, -0.3), 0.93)) for n in hob),
    }
    rack = (flap(washer, "door_joint", 0.6, 0.1, 0.8),)
    sink = {
        "joints": (turn("spout_joint", -1.57, 1.57), turn("handle_joint", 0.0, 0.6)),
        "sites": (FixtureSite(name="water", position=(*basin.at(0.0, -0.3), 1.0)),),
        "regions": (volume(basin, "basin", 0.73, 0.91),),
    }
    hood = foot_in(MAIN, 2.43, 3.23, 0.5)
    return (
        placed("fridge", Role.FRIDGE, fridge, 0.0, 1.78, "refrigerator", unit="fridge", joints=cold, **main),
        placed("range", Role.RANGE, stove, 0.0, 0.915, "range", unit="range", **main, **cooker),
        placed("dishwasher", Role.DISHWASHER, washer, 0.0, 0.85, "dishwasher", unit="dishwasher", joints=rack, **side),
        placed("hood", Role.HOOD, hood, 1.6, 2.7, "hood", unit="hood", **main),
        placed("sink_basin", Role.SINK, basin, 0.72, 0.92, "appliance", unit="sink", **side, **sink),
    )


def on_top() -> tuple[Fixture, ...]:
    oven, coffee = foot_in(MAIN, 1.1, 1.6, 0.44, 0.06), foot_in(MAIN, 3.55, 3.8, 0.4, 0.06)
    tray = Footprint(center=oven.center, size=(0.3, 0.3), yaw=oven.yaw)
    keys = ("start_button", "stop_button")
    heats = {
        "joints": (door(oven, "microjoint", -0.25, 0.25, 0.93, 1.2),),
        "regions": (volume(tray, "tray", 0.95, 1.15),),
        "buttons": tuple(FixtureSite(name=n, position=(*oven.at(0.2, 0.0), 1.0)) for n in keys),
    }
    brews = {
        "sites": (FixtureSite(name="receptacle_place_site", position=(*coffee.at(0.0, -0.08), 0.97)),),
        "buttons": (FixtureSite(name="start_button", position=(*coffee.at(0.0, 0.0), 1.2)),),
    }
    under, below = {"unit": "main_doors", "run": "main"}, {"unit": "main_drawers_2", "run": "main"}
    return (
        placed("microwave", Role.MICROWAVE, oven, TOP, 1.21, "microwave", **under, **heats),
        placed("coffee_machine", Role.COFFEE_MACHINE, coffee, TOP, 1.26, "coffee_machine", **below, **brews),
    )


def worktops() -> tuple[Fixture, ...]:
    spans = [(MAIN, 0.95, 2.45), (MAIN, 3.21, 4.35), (SIDE, 0.0, 1.95), (SIDE, 2.85, 3.4)]
    feet = [(row.id, foot_in(row, left, right, 0.65)) for row, left, right in spans]
    return tuple(
        placed(
            f"worktop_{k}", Role.WORKTOP, foot, 0.89, TOP, "counter", run=run, regions=(volume(foot, "top", TOP, 1.32),)
        )
        for k, (run, foot) in enumerate(feet)
    )


def kitchen() -> KitchenFacts:
    """An L of 5 x 4 m with everything in its place; its front is open, and it has a door on the left."""
    return KitchenFacts(
        id="worked__plain",
        plan="worked",
        all_tasks=True,
        outline=OUTLINE,
        walls=WALLS,
        openings=(WINDOW, DOOR),
        runs=(MAIN, SIDE),
        fixtures=(
            *appliances(),
            cabinet(MAIN, 0.95, 1.75, "main_doors"),
            drawers(MAIN, 1.75, 2.45, "main_drawers"),
            drawers(MAIN, 3.21, 3.9, "main_drawers_2"),
            cabinet(SIDE, 0.67, 1.35, "right_doors"),
            cabinet(SIDE, 2.85, 3.4, "right_doors_2"),
            upper(0.95, 1.4, "upper_single"),
            upper(1.4, 2.4, "upper_double", doors=2),
            *worktops(),
            *on_top(),
        ),
    )


def changed(facts: KitchenFacts, name: str, fixture: Fixture | None) -> KitchenFacts:
    out = [f if f.name != name else fixture for f in facts.fixtures]
    return facts.replace(fixtures=tuple(f for f in out if f is not None))


def with_more(facts: KitchenFacts, *fixtures: Fixture) -> KitchenFacts:
    return facts.replace(fixtures=(*facts.fixtures, *fixtures))


def with_unit(facts: KitchenFacts, row: str, name: str, left: float, right: float) -> KitchenFacts:
    rows = []
    for r in facts.runs:
        units = [u.replace(left=left, right=right) if r.id == row and u.name == name else u for u in r.units]
        rows.append(r.replace(units=tuple(units)))
    return facts.replace(runs=tuple(rows))


def with_aisle(facts: KitchenFacts, kind: AisleKind, width: float) -> KitchenFacts:
    return facts.replace(aisles=(Aisle(kind=kind, first="main", second="island", width=width, position=(2.0, -1.5)),))


def judged(facts: KitchenFacts) -> Report:
    return run(DesignSubject(facts), facts.id, LIMITS)
