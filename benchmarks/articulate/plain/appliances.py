"""Kitchen and laundry machines."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchmarks.articulate.plain.drawing import (
    Drawing,
    Rect,
    add_body,
    add_feet,
    add_front,
    add_key,
    add_keypad,
    add_knob,
    add_knobs,
    add_marks,
)
from benchmarks.articulate.plain.solids import (
    Place,
    box,
    ellipse,
    extrude,
    front_of,
    plate,
    rectangle,
    side_of,
    top_of,
    turned,
)
from casa_assets.core.numeric import Floats


def _corners(wide: float, deep: float, tall: float) -> tuple[Floats, Floats]:
    return np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])


def _kept(hole: Floats | None) -> list[Floats]:
    return [] if hole is None else [hole]


def washing_machine(d: Drawing) -> None:
    """A washing machine or dryer: a round door, a drawer for detergent, a knob and keys."""
    wide, deep, tall = d.uniform(0.5, 0.7), d.uniform(0.45, 0.7), d.uniform(0.75, 1.0)
    low, high = _corners(wide, deep, tall)
    place = front_of(float(low[1]))
    d.style = replace(d.style, boards=False, grip="none", tub="box" if d.chance(0.5) else "none")
    panel = tall * d.uniform(0.78, 0.86)
    radius = d.uniform(0.26, 0.38) * wide
    middle = float(np.clip(tall * d.uniform(0.4, 0.52), radius + 0.03, panel - radius - 0.02))
    side = d.choice(["left", "left", "right"])
    holes, door = list[Floats](), (-radius, middle - radius, radius, middle + radius)
    if d.chance(0.85):
        holes += _kept(add_front(d, place, door, "door", side, outline="round"))
    else:
        d.style = replace(d.style, panel="pane")
        holes += _kept(add_front(d, place, door, "door", side))
    _glass(d, place, side, middle, radius)
    holes += _strip(d, place, float(low[0]), panel, tall)
    if d.chance(0.3):  # a flap over the filter
        rect = (float(high[0]) - 0.2 * wide, 0.03, float(high[0]) - 0.03, 0.12)
        if middle - radius > 0.14:
            holes += _kept(add_front(d, place, rect, "door", "bottom"))
    add_body(d, low, high, [], holes)
    if d.chance(0.5):
        add_feet(d, low, high, 0.02)


def _glass(d: Drawing, place: Place, side: str, middle: float, radius: float) -> None:
    """What is on and around a round door: glass, a grip at the free side, a ring of the body."""
    front = float(min(p[:, 1].min() for (p, _), n in d.pieces if n == 1))
    sides = max(16, d.style.sides)
    if d.chance(0.7):  # a dome of glass, or a flat pane
        r = d.uniform(0.55, 0.8) * radius
        profile = np.array([[r, 0.0005], [0.8 * r, d.uniform(0.002, 0.03)], [0.0, d.uniform(0.03, 0.05)]])
        if d.chance(0.5):
            d.add(turned(front_of(front), 0.0, middle, profile, sides), 1)
        else:
            d.add(plate(front_of(front), ellipse(0.0, middle, r, r, sides), w=5e-4), 1)
    if d.chance(0.6):
        u = (0.88 if side == "left" else -0.88) * radius
        d.add(extrude(front_of(front), rectangle(u - 0.015, middle - 0.04, u + 0.015, middle + 0.04), 0.0, 0.015), 1)
    if d.chance(0.4) and d.style.fronts not in {"flush", "pushed", "inset"}:  # a ring of the body around the door
        rim = ellipse(0.0, middle, 1.12 * radius, 1.12 * radius, sides)
        d.add(
            extrude(place, rim, 0.0, 0.5 * d.style.thick, [ellipse(0.0, middle, 1.01 * radius, 1.01 * radius, sides)])
        )


def _strip(d: Drawing, place: Place, left: float, panel: float, tall: float) -> list[Floats]:
    """The strip above a round door: a drawer, a knob and keys; returns the holes that they need."""
    wide, begin, holes = -2 * left, left + 0.02, list[Floats]()
    if d.chance(0.7):
        rect = (begin, panel + 0.015, begin + d.uniform(0.2, 0.32) * wide, tall - 0.02)
        holes += _kept(add_front(d, place, rect, "drawer", None, depth=0.3))
        begin = rect[2] + 0.02
    if d.chance(0.85):
        r = 0.36 * (tall - panel)
        u = float(d.rng.uniform(begin + r, 0.2 * wide)) if begin + r < 0.2 * wide else begin + r
        holes += _kept(add_knob(d, place, u, (panel + tall) / 2, r, d.uniform(0.4, 1.0) * r))
        begin = u + 1.3 * r
    if d.chance(0.75) and -left - begin > 0.1:
        rows = d.count(1, 2)
        rect = (begin + 0.01, panel + 0.03, -left - 0.03, panel + 0.03 + rows * 0.03)
        holes += add_keypad(d, place, rect, rows, d.count(2, 6))
    return holes


def microwave(d: Drawing) -> None:
    """A microwave: a door that opens sideways, beside it a panel with a grid of keys or with knobs."""
    wide, deep, tall = d.uniform(0.4, 0.62), d.uniform(0.28, 0.45), d.uniform(0.22, 0.36)
    low, high = _corners(wide, deep, tall)
    d.style = replace(d.style, boards=False, panel=d.choice(["window", "pane", "slab"]))
    place, edge = front_of(float(low[1])), d.choice([0.0, 0.005, 0.015])
    split = float(high[0]) - d.uniform(0.2, 0.3) * wide
    door: Rect = (float(low[0]) + edge, edge, split, tall - edge)
    holes = _kept(add_front(d, place, door, "door", "left"))
    panel = (split + 0.012, 0.02, float(high[0]) - 0.012, tall - 0.02)
    display = panel[3] - d.uniform(0.12, 0.25) * tall
    if d.chance(0.7):
        d.add(plate(place, rectangle(panel[0], display, panel[2], panel[3]), w=d.choice([3e-4, 1e-3])))
    else:
        display = panel[3]
    below = panel[1]
    if d.chance(0.35):  # the long key that opens the door
        tall_key = 0.1 * tall
        u = (panel[0] + panel[2]) / 2
        holes += _kept(add_key(d, place, u, below + tall_key / 2, 0.9 * (panel[2] - panel[0]), tall_key, 0.004))
        below += 1.4 * tall_key
    if d.chance(0.7):
        holes += add_keypad(d, place, (panel[0], below, panel[2], display - 0.01), d.count(3, 8), d.count(2, 4))
    else:
        holes += add_knobs(d, place, (panel[0], below, panel[2], display - 0.01), d.count(1, 2))
    add_body(d, low, high, [door], holes)
    _vents(d, side_of(float(high[0]), True), (-0.3 * deep, 0.4 * tall, 0.3 * deep, 0.8 * tall))
    if d.chance(0.6):
        add_feet(d, low, high, 0.012)


def _vents(d: Drawing, place: Place, rect: Rect) -> None:
    """Slots on a side."""
    if d.chance(0.4):
        add_marks(d, place, rect, 1)


def range_(d: Drawing) -> None:
    """A range: a row of knobs over a door that drops, a drawer below, burners on top."""
    wide, deep, tall = d.uniform(0.5, 1.0), d.uniform(0.5, 0.7), d.uniform(0.8, 0.95)
    low, high = _corners(wide, deep, tall)
    d.style = replace(d.style, boards=False, panel=d.choice(["window", "pane", "slab", "framed"]))
    place, edge = front_of(float(low[1])), d.choice([0.0, 0.004, 0.02])
    band = tall - d.uniform(0.09, 0.16)
    holes, fronts = list[Floats](), list[Rect]()
    cut = d.uniform(0.15, 0.28) if d.chance(0.65) else edge
    two = wide > 0.8 and d.chance(0.4)
    bounds = [(-wide / 2 + edge, 0.15 * wide), (0.15 * wide + 0.006, wide / 2 - edge)] if two else []
    for a, b in bounds or [(-wide / 2 + edge, wide / 2 - edge)]:
        fronts.append((a, cut, b, band - 0.004))
        holes += _kept(add_front(d, place, fronts[-1], "door", "bottom", depth=deep))
    if cut > edge:
        fronts.append((-wide / 2 + edge, 0.03, wide / 2 - edge, cut - 0.006))
        kind, hinge = ("drawer", None) if d.chance(0.8) else ("door", "bottom")
        holes += _kept(add_front(d, place, fronts[-1], kind, hinge, depth=deep))  # type: ignore[arg-type]
    knobs = d.count(3, 8)
    back = d.chance(0.25)  # controls on a board at the back
    if back:
        high_board = tall + d.uniform(0.12, 0.22)
        d.add(box((low[0], high[1] - 0.06, tall), (high[0], high[1], high_board), without="f"))
        board = front_of(float(high[1]) - 0.06)
        cut_out = add_knobs(d, board, (low[0] + 0.02, tall + 0.02, high[0] - 0.02, high_board - 0.02), knobs)
        d.add(plate(board, rectangle(low[0], tall, high[0], high_board), cut_out))
    else:
        ends = (low[0] + 0.02, high[0] - 0.02)
        holes += add_knobs(d, place, (ends[0], band + 0.01, ends[1], tall - 0.01), knobs)
    add_body(d, low, high, fronts, holes)
    top = top_of(tall)
    for u in (-0.25, 0.25):
        for v in (-0.22, 0.2):
            r = d.uniform(0.06, 0.1)
            d.add(extrude(top, ellipse(u * wide, v * deep, r, r, max(16, d.style.sides)), 0.0, d.uniform(0.002, 0.02)))


def oven(d: Drawing) -> None:
    """A wall oven or a small one for the worktop: a door that drops, knobs and keys above or beside it."""
    small = d.chance(0.4)
    wide, deep, tall = (0.45, 0.35, 0.27) if small else (0.6, 0.57, d.choice([0.45, 0.6, 1.1]))
    low, high = _corners(wide * d.uniform(0.9, 1.1), deep, tall)
    d.style = replace(d.style, boards=False, panel=d.choice(["window", "pane", "slab"]))
    place, edge = front_of(float(low[1])), d.choice([0.0, 0.005, 0.02])
    holes, fronts = list[Floats](), list[Rect]()
    if small and d.chance(0.6):  # controls beside the door
        split = float(high[0]) - 0.24 * wide
        fronts.append((float(low[0]) + edge, edge + 0.01, split, tall - edge))
        band: Rect = (split + 0.01, 0.02, float(high[0]) - 0.01, tall - 0.02)
    else:
        cut = tall - min(0.13, 0.28 * tall)
        floors = 2 if tall > 0.9 else 1
        levels = np.linspace(edge + 0.01, cut - 0.005, floors + 1).tolist()
        fronts += [(float(low[0]) + edge, a, float(high[0]) - edge, b - 0.008) for a, b in pairwise(levels)]
        band = (float(low[0]) + 0.02, cut + 0.01, float(high[0]) - 0.02, tall - 0.01)
    for rect in fronts:
        holes += _kept(add_front(d, place, rect, "door", "bottom", depth=deep))
    count = d.count(2, 6)
    along = band[2] - band[0] > band[3] - band[1]
    if along and d.chance(0.5):  # knobs at both sides of a display with keys
        middle = (band[0] + band[2]) / 2
        third = (band[2] - band[0]) / 3
        holes += add_knobs(d, place, (band[0], band[1], band[0] + third, band[3]), max(1, count // 2))
        holes += add_knobs(d, place, (band[2] - third, band[1], band[2], band[3]), max(1, count // 2))
        v = (band[1] + band[3]) / 2
        d.add(plate(place, rectangle(middle - 0.4 * third, v, middle + 0.4 * third, band[3] - 0.01), w=4e-4))
        holes += add_keypad(
            d, place, (middle - 0.4 * third, band[1] + 0.005, middle + 0.4 * third, v - 0.005), 1, d.count(2, 5)
        )
    else:
        holes += add_knobs(d, place, band, count)
    if d.chance(0.15) and d.style.hollow and d.style.fronts in {"gap", "contact"}:  # racks in the room
        u0, v0, u1, v1 = fronts[0]
        for k in range(d.count(1, 2)):
            z = v0 + (k + 1) / 3 * (v1 - v0)
            part = d.part(
                "tray", "prismatic", np.array([0, -1.0, 0]), np.array([0, 0, z]), (0.0, 0.6 * deep), interior=True
            )
            d.add(box((u0 + 0.03, low[1] + 0.03, z), (u1 - 0.03, high[1] - 0.05, z + 0.006)), part)
    add_body(d, low, high, fronts, holes)
    if small:
        add_feet(d, low, high, 0.015)


def dishwasher(d: Drawing) -> None:
    """A dishwasher: one door that drops, keys and a knob on a strip above it or on its upper edge."""
    low, high = _corners(d.uniform(0.42, 0.62), d.uniform(0.5, 0.62), d.uniform(0.75, 0.9))
    wide, tall = float(high[0] - low[0]), float(high[2])
    d.style = replace(d.style, boards=False, panel=d.choice(["slab", "slab", "framed"]))
    place, edge = front_of(float(low[1])), d.choice([0.0, 0.005])
    on_door = d.chance(0.4)
    band = tall - d.uniform(0.08, 0.13)
    foot = d.uniform(0.03, 0.12)
    rect = (float(low[0]) + edge, foot, float(high[0]) - edge, (tall if on_door else band) - 0.004)
    holes = _kept(add_front(d, place, rect, "door", "bottom", depth=0.5))
    if on_door and d.style.fronts != "flush":
        first, before = len(d.rows), d.style
        strip = front_of(float(d.pieces[0][0][0][:, 1].min()))  # the leaf is the first that was drawn
        if d.style.controls in {"pushed", "flush"}:
            d.style = replace(d.style, controls="contact")
        add_keypad(d, strip, (0.0, tall - 0.05, 0.45 * wide, tall - 0.02), 1, d.count(2, 7))
        d.style = before
        for row in d.rows[first:]:
            row["parent"] = d.rows[0]["name"]
    elif not on_door:
        holes += add_keypad(d, place, (0.0, band + 0.02, 0.45 * wide, tall - 0.02), 1, d.count(2, 7))
        if d.chance(0.5):
            holes += _kept(add_knob(d, place, -0.3 * wide, (band + tall) / 2, 0.3 * (tall - band), 0.02))
    add_body(d, low, high, [rect], holes)


def fridge(d: Drawing) -> None:
    """A fridge: one door, two above each other, two beside each other, or a pair over drawers."""
    wide, deep, tall = d.uniform(0.5, 0.95), d.uniform(0.5, 0.75), d.uniform(0.8, 1.95)
    low, high = _corners(wide, deep, tall)
    d.style = replace(d.style, boards=False, panel="slab", tub="none" if d.chance(0.7) else "box")
    d.style = replace(d.style, thick=d.uniform(0.02, 0.08) if d.style.fronts != "flush" else d.style.thick)
    place, gap = front_of(float(low[1])), d.choice([0.0, 0.004, 0.012])
    foot, edge = d.choice([0.0, 0.04, 0.08]), d.choice([0.0, 0.004])
    plan = d.choice(["one", "two", "two", "beside", "french"])
    u0, u1 = float(low[0]) + edge, float(high[0]) - edge
    side = d.choice(["left", "right"])
    rows: list[tuple[Rect, str, str | None]] = []
    if plan == "one":
        rows = [((u0, foot, u1, tall), "door", side)]
    elif plan == "two":
        cut = tall * d.uniform(0.3, 0.72)
        rows = [((u0, foot, u1, cut - gap / 2), "door", side), ((u0, cut + gap / 2, u1, tall), "door", side)]
        if d.chance(0.2):
            rows[0] = (rows[0][0], "drawer", None)
    elif plan == "beside":
        cut = wide * d.uniform(-0.12, 0.05)
        rows = [((u0, foot, cut - gap / 2, tall), "door", "left"), ((cut + gap / 2, foot, u1, tall), "door", "right")]
    else:
        cut = tall * d.uniform(0.3, 0.45)
        rows = [((u0, cut + gap, -gap / 2, tall), "door", "left"), ((gap / 2, cut + gap, u1, tall), "door", "right")]
        count = d.count(1, 2)
        levels = np.linspace(foot, cut, count + 1).tolist()
        rows += [((u0, a + (gap if k else 0), u1, b), "drawer", None) for k, (a, b) in enumerate(pairwise(levels))]
    holes = list[Floats]()
    for rect, kind, hinge in rows:
        holes += _kept(add_front(d, place, rect, kind, hinge, depth=deep))  # type: ignore[arg-type]
    add_body(d, low, high, [r for r, _, _ in rows], holes)
    if d.chance(0.4):  # a dispenser on a door that does not move by itself
        u, v = (rows[0][0][0] + rows[0][0][2]) / 2, 0.6 * (rows[0][0][1] + rows[0][0][3])
        flat = place.points(rectangle(u - 0.05, v - 0.08, u + 0.05, v + 0.08), d.style.thick + 3e-3)
        d.add((flat, np.array([[0, 1, 2], [0, 2, 3]])), 1)


def toaster(d: Drawing) -> None:
    """A toaster: a lever that is pressed down at one end, a knob and keys below it."""
    wide, deep, tall = d.uniform(0.14, 0.2), d.uniform(0.24, 0.4), d.uniform(0.16, 0.22)
    low, high = _corners(wide, deep, tall)
    place, holes = front_of(float(low[1])), list[Floats]()
    d.style = replace(d.style, boards=False)
    count = d.count(1, 2)
    for u in [0.0] if count == 1 else [-0.25 * wide, 0.25 * wide]:
        v = tall * d.uniform(0.6, 0.8)
        part = d.part("lever", "prismatic", np.array([0, 0, -1.0]), place.point(u, v), (0.0, 0.4 * tall))
        d.add(extrude(place, rectangle(u - 0.02, v - 0.006, u + 0.02, v + 0.006), 0.0, d.uniform(0.015, 0.03)), part)
    if d.chance(0.8):
        holes += add_knobs(d, place, (-0.4 * wide, 0.1 * tall, 0.4 * wide, 0.4 * tall), d.count(1, count))
    elif d.chance(0.7):
        holes += add_keypad(d, place, (-0.4 * wide, 0.1 * tall, 0.4 * wide, 0.3 * tall), 1, d.count(2, 4))
    rim = rectangle(low[0], low[1], high[0], high[1])
    slots = [rectangle(u - 0.015, 0.8 * low[1], u + 0.015, 0.8 * high[1]) for u in (-0.22 * wide, 0.22 * wide)]
    for slot in slots:
        points, faces = extrude(top_of(tall), slot, -0.7 * tall, 0.0, face=False)
        d.add((points, faces[:, ::-1]))
    d.add(box(low, high, without="fu"))
    d.add(plate(top_of(tall), rim, slots))
    d.add(plate(place, rectangle(low[0], 0.0, high[0], tall), holes))


def coffee_machine(d: Drawing) -> None:
    """A coffee machine: keys and a knob over a recess, a lid on top."""
    wide, deep, tall = d.uniform(0.16, 0.32), d.uniform(0.22, 0.4), d.uniform(0.28, 0.42)
    low, high = _corners(wide, deep, tall)
    d.style = replace(d.style, boards=False)
    shelf, roof, back = 0.12 * tall, d.uniform(0.55, 0.7) * tall, float(low[1]) + 0.5 * deep
    place = front_of(float(low[1]))
    d.add(box(low, (high[0], high[1], shelf)))
    d.add(box((low[0], back, shelf), (high[0], high[1], roof), without="du"))
    holes = add_keypad(
        d, place, (-0.4 * wide, roof + 0.1 * tall, 0.1 * wide, tall - 0.05 * tall), d.count(1, 2), d.count(1, 4)
    )
    if d.chance(0.7):
        r = 0.3 * min(0.35 * wide, tall - roof)
        holes += _kept(add_knob(d, place, 0.3 * wide, (roof + tall) / 2, r, 0.6 * r))
    d.add(box((low[0], low[1], roof), high, without="f"))
    d.add(plate(place, rectangle(low[0], roof, high[0], tall), holes))
    if d.chance(0.6):
        part = d.part("lid", "revolute", np.array([-1.0, 0, 0]), np.array([0, high[1] - 0.02, tall]), (0.0, 1.5))
        air = 0.0 if d.style.fronts in {"contact", "pushed"} else 0.0015
        cover = rectangle(low[0] + 0.01, back, high[0] - 0.01, high[1] - 0.02)
        d.add(extrude(top_of(tall), cover, air, air + 0.012, back=d.style.fronts != "pushed"), part)
    d.add(extrude(top_of(roof), ellipse(0.0, float(low[1]) + 0.25 * deep, 0.02, 0.02, d.style.sides), -0.03, 0.0))


def laptop(d: Drawing) -> None:
    """A laptop: a screen that stands open at the back edge, keys on its base."""
    wide, deep, thick = d.uniform(0.28, 0.4), d.uniform(0.2, 0.28), d.uniform(0.008, 0.02)
    low, high = _corners(wide, deep, thick)
    top, holes = top_of(thick), list[Floats]()
    holes = add_keypad(d, top, (-0.45 * wide, -0.1 * deep, 0.45 * wide, 0.42 * deep), d.count(3, 5), d.count(6, 10))
    d.add(box(low, high, without="u"))
    d.add(plate(top, rectangle(low[0], low[1], high[0], high[1]), holes))
    part = d.part("lid", "revolute", np.array([1.0, 0, 0]), np.array([0, high[1], thick]), (-1.6, 0.6))
    d.rows[part - 1]["joint"] |= {"axis": [1.0, 0.0, 0.0], "range": [0.0, 1.6]}
    d.add(box((low[0], high[1] - 0.008, thick), (high[0], high[1], thick + 0.9 * deep)), part)
    screen = rectangle(0.9 * low[0], thick + 0.05 * deep, 0.9 * high[0], thick + 0.85 * deep)
    d.add(plate(front_of(float(high[1]) - 0.008), screen, w=5e-4), part)
