"""What refrigerators are built of: an insulated body, shelves, crispers, doors with bins, freezer drawers."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.bench import ROOT, Bench
from casa_assets.families.kit.blocks import board, box, rod
from casa_assets.families.kit.carve import cut
from casa_assets.families.kit.solid import Solid, box_shape
from casa_assets.families.kit.sweep import tube
from casa_assets.model.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable

WALL = 0.045  # metres of foam between liner and shell
THICK = 0.062  # of a door
GAP = 0.004
FOOT = 0.03
FOAM = 115.0  # kg/m^3 of a wall: thin sheet on both sides of polyurethane foam of 38 kg/m^3
DOOR_FOAM = 150.0
BIN = 0.088  # metres that a bin reaches into the body
SHELF_FRONT = BIN + 0.03
BESIDE = 0.034
OPEN = math.pi / 2
CLEAR = 0.005 * OPEN  # what counts as closed. Ref: RoboCasa v1.0, class Fridge, is_closed


class Pull(StrEnum):
    """What one opens the doors with."""

    BAR = "bar"
    PRO = "pro"
    FLAT = "flat"
    LIP = "lip"
    RETRO = "retro"


class Fridge(Params):
    """A refrigerator. Metres.

    Attributes:
        width, depth, height: of the body; doors stand in front of the depth.
        split: share of the height (of the width, side by side) that the freezer takes.
        pull: handles. rounded: radius of the doors' edges. shelves: in the fridge. drawers: crispers below them.
        dispenser: a niche for water and ice in a door. hinge_right: single doors hang on their right side.
        face, side, metal: finishes of the doors, of the body, of handles and badge.
    """

    width: Annotated[float, Field(ge=0.54, le=0.95)] = 0.7
    depth: Annotated[float, Field(ge=0.55, le=0.72)] = 0.62
    height: Annotated[float, Field(ge=1.45, le=2.05)] = 1.75
    split: Annotated[float, Field(ge=0.25, le=0.48)] = 0.3
    pull: Pull = Pull.BAR
    rounded: Annotated[float, Field(ge=0.003, le=0.028)] = 0.006
    shelves: Annotated[int, Field(ge=2, le=5)] = 3
    drawers: Annotated[int, Field(ge=1, le=2)] = 2
    dispenser: bool = False
    hinge_right: bool = False
    face: FinishId = "stainless_brushed"
    side: FinishId = "enamel_grey"
    metal: FinishId = "stainless_polished"


def body(bench: Bench, p: Fridge, walls: list[tuple[float, float, float, float]]) -> None:
    """The insulated box on its feet, and the walls (x0, x1, z0, z1) that part its compartments."""
    w, d, h, t = p.width, p.depth, p.height, WALL
    plates = (
        board((0.0, 0.0, FOOT), (t, d, h), 0.003),
        board((w - t, 0.0, FOOT), (w, d, h), 0.003),
        board((t, 0.0, FOOT), (w - t, d, FOOT + t), 0.0),
        board((t, 0.0, h - t), (w - t, d, h), 0.0),
        board((t, d - t, FOOT + t), (w - t, d, h - t), 0.0),
    )
    for plate in plates:
        bench.add(ROOT, plate, p.side, label="case", density=FOAM)
    for x0, x1, z0, z1 in walls:
        bench.add(ROOT, board((x0, 0.002, z0), (x1, d - t, z1), 0.0), "plastic_white", label="liner", density=FOAM)
    grille = board((0.03, 0.03, 0.004), (w - 0.03, 0.04, FOOT - 0.0005), 0.001)
    bench.add(ROOT, grille, "plastic_grey_dark", label="plinth", density=800.0)
    for x in (0.07, w - 0.07):
        for y in (0.09, d - 0.07):
            bench.add(ROOT, rod(0.02, FOOT).at(x, y, FOOT / 2), "plastic_black", label="foot")
    for x in (0.045, w - 0.045):
        cover = box((0.06, 0.085, 0.014), (x, -0.012, h + 0.0075), 0.003)
        bench.add(ROOT, cover, "plastic_grey_dark", label="hinge")
    bench.ballast(ROOT, 14.0, (w / 2, d - 0.12, 0.2), (0.24, 0.16, 0.2))  # compressor, condenser, oil


def room(bench: Bench, low: tuple[float, float], high: tuple[float, float], depth: float) -> None:
    """The white lining of a compartment between corners in x and z, open to the front."""
    (x0, z0), (x1, z1) = low, high
    e, y0, y1 = 0.0008, 0.003, depth - WALL
    sheets = (
        board((x0, y0, z0), (x0 + e, y1, z1), 0.0),
        board((x1 - e, y0, z0), (x1, y1, z1), 0.0),
        board((x0 + e, y0, z0), (x1 - e, y1 - e, z0 + e), 0.0),
        board((x0 + e, y0, z1 - e), (x1 - e, y1 - e, z1), 0.0),
        board((x0 + e, y1 - e, z0 + e), (x1 - e, y1, z1 - e), 0.0),
    )
    for sheet in sheets:
        bench.add(ROOT, sheet, "plastic_white", label="liner", touch=False, density=900.0)


def lamp(bench: Bench, x: float, top: float, depth: float) -> None:
    """The light under the fridge's ceiling."""
    glow = box((0.14, 0.05, 0.006), (x, depth * 0.4, top - 0.0045), 0.002)
    bench.add(ROOT, glow, "bulb_cool", label="light", name="fridge_lamp", touch=False, density=400.0)


def shelves(
    bench: Bench, kind: str, low: tuple[float, float], high: tuple[float, float], depth: float, count: int
) -> None:
    """Glass shelves at equal steps, and a region over each and over the floor; `kind` is fridge or freezer."""
    (x0, z0), (x1, z1) = low, high
    back, step = depth - WALL - 0.006, (z1 - z0) / count
    for k in range(count):
        z = z0 + step * k
        if k > 0:
            glass = board((x0 + 0.004, SHELF_FRONT, z - 0.005), (x1 - 0.004, back, z), 0.001)
            bench.add(ROOT, glass, "glass_clear", label="shelf", name=f"{kind}_plate{k}")
            trim = board(
                (x0 + 0.004, SHELF_FRONT - 0.012, z - 0.014), (x1 - 0.004, SHELF_FRONT - 0.0003, z + 0.003), 0.003, 2
            )
            bench.add(ROOT, trim, "plastic_white", label="shelf")
        top = z + step - (0.018 if k < count - 1 else 0.012)
        floor = z + (0.0 if k else 0.001)
        bench.region(f"{kind}_shelf{k}", (x0 + 0.012, SHELF_FRONT, floor), (x1 - 0.012, back - 0.004, top))


def crispers(
    bench: Bench, low: tuple[float, float], high: tuple[float, float], depth: float, doors: list[str]
) -> None:
    """Clear drawers side by side under a glass lid, one for each name in `doors`: the door that it waits for."""
    count = len(doors)
    (x0, z0), (x1, z1) = low, high
    back = depth - WALL - 0.012
    lid = board((x0 + 0.004, SHELF_FRONT, z1 - 0.006), (x1 - 0.004, back + 0.006, z1), 0.001)
    bench.add(ROOT, lid, "glass_clear", label="shelf", name="crisper_lid")
    # An open door stands in front of the outermost part of the opening: drawers pass beside it.
    pitch = (x1 - x0 - 0.008 - 2 * BESIDE) / count
    for k in range(count):
        a = x0 + 0.004 + BESIDE + pitch * k + 0.004
        name = f"fridge_drawer{k}"
        bench.link(name, at=(a, SHELF_FRONT, z0 + 0.004))
        w, d, h, t = pitch - 0.008, back - SHELF_FRONT, z1 - z0 - 0.018, 0.004
        _tub(bench, name, (w, d, h), t, "plastic_clear", "drawer")
        lip = board((0.02, -0.016, h - 0.03), (w - 0.02, 0.0, h - 0.012), 0.004, 2)
        bench.add(name, lip, "plastic_white", label="handle", name=f"{name}_handle")
        bench.slide(f"{name}_joint", name, (0.0, 1.0, 0.0), (-0.24, 0.0), f"{name}_handle", start_n=6.0, behind=doors[k])
        bench.region(name, (t + 0.004, t + 0.004, t), (w - t - 0.004, d - t - 0.004, h - 0.002), link=name)


def _tub(bench: Bench, link: str, size: tuple[float, float, float], t: float, finish: str, label: str) -> None:
    w, d, h = size
    parts = (
        board((0, 0, 0), (w, d, t), 0.0),
        board((0, 0, t), (t, d, h), 0.001),
        board((w - t, 0, t), (w, d, h), 0.001),
        board((t, 0, t), (w - t, t, h), 0.001),
        board((t, d - t, t), (w - t, d, h), 0.001),
    )
    for part in parts:
        bench.add(link, part, finish, label=label)


def door(
    bench: Bench,
    p: Fridge,
    name: str,
    low: tuple[float, float],
    high: tuple[float, float],
    right: bool,
    bins: int,
    dispenser: bool = False,
    bins_from: float = 0.06,
) -> str:
    """A hinged door with bins, gasket and handle; returns its joint. Corners in x and z; `right`: hinged there.

    Bins start at `bins_from` above the door's foot, over the drawers that pass beside the open door.
    """
    (x0, z0), (x1, z1) = low, high
    w, h = x1 - x0, z1 - z0
    bench.link(name, at=(x1 if right else x0, -THICK - GAP, z0))
    s = -w if right else 0.0
    slab = board((s, 0.0, 0.0), (s + w, THICK, h), p.rounded, 1 if p.rounded < 0.006 else 4)
    if dispenser:
        slab = _niche(bench, name, slab, s + w / 2, h, p)
    bench.add(name, slab, p.face, label="door", name=f"{name}_main", density=DOOR_FOAM)
    seal = cut(
        board((s + 0.016, THICK + 0.0002, 0.016), (s + w - 0.016, THICK + GAP - 0.0008, h - 0.016), 0.0),
        board((s + 0.03, 0.0, 0.03), (s + w - 0.03, 1.0, h - 0.03), 0.0),
    )
    bench.add(name, seal, "gasket_grey", label="gasket", touch=False, density=400.0)
    liner = board((s + 0.034, THICK - 0.0004, 0.034), (s + w - 0.034, THICK + GAP - 0.001, h - 0.034), 0.0)
    bench.add(name, liner, "plastic_white", label="door", touch=False, density=300.0)
    _bins(bench, name, s, w, h, bins, bins_from)
    inset = 0.045 if p.pull is not Pull.LIP else 0.012
    x = s + inset if right else s + w - inset
    _upright(bench, p, name, x, h, right)
    span = (0.0, OPEN) if right else (-OPEN, 0.0)
    bench.hinge(f"{name}_joint", name, (0.0, 0.0, 1.0), span, f"{name}_handle_main", start_n=8.0)
    return f"{name}_joint"


def _bins(bench: Bench, link: str, s: float, w: float, h: float, count: int, low: float) -> None:
    """Open bins on the inside of a door."""
    kind = "freezer" if link.startswith("freezer") else "fridge"
    stem = link.removesuffix("_door")
    a, b = s + 0.075, s + w - 0.1
    if s < 0:
        a, b = s + 0.1, s + w - 0.075
    y0, y1 = THICK + GAP - 0.0008, THICK + GAP + BIN
    tall, t = 0.085, 0.004
    for k in range(count):
        z = low + (h - 0.26 - low) * (k / (count - 1) if count > 1 else 0.3)
        parts = (
            board((a, y0, z), (b, y1, z + t), 0.0),
            board((a, y1 - t, z + t), (b, y1, z + tall), 0.001),
            board((a, y0, z + t), (a + t, y1 - t, z + tall), 0.0),
            board((b - t, y0, z + t), (b, y1 - t, z + tall), 0.0),
        )
        for part in parts:
            bench.add(link, part, "plastic_clear", label="bin")
        name = f"{stem}_bin{k}" if stem != kind else f"{kind}_bin{k}"
        bench.region(name, (a + t + 0.002, y0 + 0.002, z + t), (b - t - 0.002, y1 - t - 0.002, z + 0.16), link=link)


def _upright(bench: Bench, p: Fridge, link: str, x: float, h: float, right: bool) -> None:
    """A handle along the free edge of a door."""
    name, reach = f"{link}_handle_main", 0.05
    long = min(0.62 * h, 0.75)
    z0 = 0.1 * h if h > 1.0 else (h - long) / 2
    if h < 0.75:
        z0 = 0.06
    z1 = z0 + long
    if p.pull is Pull.LIP:
        lip = board((x - 0.01, -0.022, z0), (x + 0.01, 0.0006, z1), 0.005, 2)
        bench.add(link, lip, p.metal, label="handle", name=name, density=1500.0)
        return
    if p.pull is Pull.RETRO:
        for z in (z0 + 0.2 * long, z0 + 0.45 * long):
            bench.add(link, rod(0.011, reach, axis="y").at(x, -reach / 2, z), p.metal, label="handle")
        grip = box((0.028, 0.018, 0.34 * long), (x, -reach - 0.004, z0 + 0.33 * long), 0.008, 4)
        bench.add(link, grip, p.metal, label="handle", name=name, density=3000.0)
        return
    radius = 0.015 if p.pull is Pull.PRO else 0.0105
    for z in (z0 + 0.05, z1 - 0.05):
        post = box((0.024, reach, 0.03) if p.pull is Pull.PRO else (0.016, reach, 0.02), (x, -reach / 2, z), 0.004, 2)
        bench.add(link, post, p.metal, label="handle")
    if p.pull is Pull.FLAT:
        grip = box((0.026, 0.012, long), (x, -reach, (z0 + z1) / 2), 0.004, 2)
    else:
        grip = tube([(x, -reach, z0), (x, -reach, z1)], radius)
    bench.add(link, grip, p.metal, label="handle", name=name, density=2700.0)


def level(bench: Bench, p: Fridge, link: str, w: float, z: float) -> None:
    """A handle across a drawer front whose left lower front corner is the link's origin."""
    name, reach = f"{link}_handle_main", 0.05
    if p.pull is Pull.LIP:
        bench.add(
            link,
            board((0.1, -0.022, z - 0.01), (w - 0.1, 0.0006, z + 0.01), 0.005, 2),
            p.metal,
            "handle",
            name,
            density=1500.0,
        )
        return
    inset = 0.1
    for x in (inset + 0.04, w - inset - 0.04):
        bench.add(link, box((0.024, reach, 0.02), (x, -reach / 2, z), 0.004, 2), p.metal, label="handle")
    if p.pull is Pull.FLAT:
        grip = box((w - 2 * inset, 0.012, 0.026), (w / 2, -reach, z), 0.004, 2)
    elif p.pull is Pull.RETRO:
        grip = box((w - 2 * inset, 0.018, 0.028), (w / 2, -reach - 0.004, z), 0.008, 4)
    else:
        grip = tube([(inset, -reach, z), (w - inset, -reach, z)], 0.015 if p.pull is Pull.PRO else 0.0105)
    bench.add(link, grip, p.metal, label="handle", name=name, density=2700.0)


def freezer_drawer(
    bench: Bench, p: Fridge, low: tuple[float, float], high: tuple[float, float], name: str = "freezer_door"
) -> str:
    """A freezer that is pulled out whole: front, gasket, basket; returns its joint."""
    (x0, z0), (x1, z1) = low, high
    w, h = x1 - x0, z1 - z0
    bench.link(name, at=(x0, -THICK - GAP, z0))
    slab = board((0.0, 0.0, 0.0), (w, THICK, h), p.rounded, 1 if p.rounded < 0.006 else 4)
    bench.add(name, slab, p.face, label="door", name=f"{name}_main", density=DOOR_FOAM)
    seal = cut(
        board((0.016, THICK + 0.0002, 0.016), (w - 0.016, THICK + GAP - 0.0008, h - 0.016), 0.0),
        board((0.03, 0.0, 0.03), (w - 0.03, 1.0, h - 0.03), 0.0),
    )
    bench.add(name, seal, "gasket_grey", label="gasket", touch=False, density=400.0)
    a, b, t = WALL + 0.012, w - WALL - 0.012, 0.004
    y0, y1 = THICK + 0.0005, THICK + GAP + p.depth - WALL - 0.02
    low_z, top = WALL + 0.008, h - WALL - 0.03
    parts = (
        board((a, y0, low_z), (b, y1, low_z + t), 0.0),
        board((a, y0, low_z + t), (a + t, y1, top), 0.001),
        board((b - t, y0, low_z + t), (b, y1, top), 0.001),
        board((a + t, y1 - t, low_z + t), (b - t, y1, top), 0.001),
    )
    for part in parts:
        bench.add(name, part, "plastic_clear", label="basket")
    level(bench, p, name, w, h - 0.07)
    way = 0.62 * p.depth
    bench.slide(f"{name}_joint", name, (0.0, 1.0, 0.0), (-way, 0.0), f"{name}_handle_main", start_n=9.0)
    region = name.replace("door", "drawer") + ("0" if name[-1] == "r" else "")
    bench.region(region, (a + t + 0.004, y0 + 0.004, low_z + t), (b - t - 0.004, y1 - t - 0.004, top), link=name)
    return f"{name}_joint"


def _niche(bench: Bench, link: str, slab: Solid, x: float, h: float, p: Fridge) -> Solid:
    """A recess for water and ice, with a nozzle, a tray and a display above."""
    w, z0, z1, deep = 0.17, 0.5 * h, 0.5 * h + 0.26, 0.045
    hole = board((x - w / 2, -0.01, z0), (x + w / 2, deep, z1), 0.0)
    low, high = slab.bounds
    cut_out = cut(slab, hole, shapes=(box_shape((low[0], 0.0, 0.0), (high[0], THICK, h)),))
    back = board((x - w / 2, deep - 0.001, z0), (x + w / 2, deep + 0.001, z1), 0.0)
    bench.add(link, back, "plastic_black", label="dispenser", touch=False, density=200.0)
    frame = cut(
        board((x - w / 2 - 0.012, -0.003, z0 - 0.012), (x + w / 2 + 0.012, 0.002, z1 + 0.075), 0.001),
        board((x - w / 2 + 0.0005, -0.1, z0 + 0.0005), (x + w / 2 - 0.0005, 0.1, z1 - 0.0005), 0.0),
    )
    bench.add(link, frame, "plastic_black_gloss", label="dispenser", touch=False, density=1000.0)
    glow = box((0.09, 0.0008, 0.02), (x, -0.0036, z1 + 0.035), 0.0)
    bench.add(link, glow, "display_blue", label="display", touch=False, density=0.0)
    for dx in (-0.035, 0.035):
        bench.add(
            link, rod(0.012, 0.03).at(x + dx, 0.024, z1 - 0.016), "plastic_grey_dark", label="dispenser", touch=False
        )
    tray = board((x - w / 2 + 0.006, 0.002, z0 + 0.001), (x + w / 2 - 0.006, deep - 0.002, z0 + 0.012), 0.002)
    bench.add(link, tray, "plastic_grey_dark", label="dispenser", touch=False)
    return cut_out


def badge(bench: Bench, p: Fridge, link: str, x: float, z: float) -> None:
    """A plain plate where a name would be."""
    bench.add(
        link, box((0.07, 0.002, 0.012), (x, -0.0008, z), 0.0008), p.metal, label="badge", touch=False, density=0.0
    )


def behavior(doors: list[str]) -> Behavior:
    """The lamp burns while a door of the fridge is open."""
    ajar = [Condition(joint=j, interval=span) for j in doors for span in ((CLEAR, 3.0), (-3.0, -CLEAR))]
    rules = [Rule(variable="light", to="on", when=(a,)) for a in ajar]
    rules.append(Rule(variable="light", to="off", when=tuple(a.replace(negated=True) for a in ajar)))
    return Behavior(
        variables=(Variable(name="light", values=("off", "on"), initial="off"),),
        rules=tuple(rules),
        effects=(Effect(variable="light", value="on", kind=EffectKind.LIGHT, target="fridge_lamp_visual"),),
    )


def outside(bench: Bench, p: Fridge) -> None:
    """The region `main`: body and doors."""
    bench.region("main", (0.0, -THICK - GAP, 0.0), (p.width, p.depth, p.height))
