"""Cabinets, desks, tables, chests and bins."""

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
    add_keypad,
    add_knob,
    add_marks,
)
from benchmarks.articulate.plain.solids import (
    Place,
    box,
    ellipse,
    extrude,
    front_of,
    inside_out,
    joined,
    plate,
    rectangle,
    top_of,
)
from casa_assets.core.numeric import Floats


def cabinet(d: Drawing) -> None:
    """Columns of doors, pairs of doors, drawers and flaps; some cells are open or blind."""
    wide, deep, tall = d.uniform(0.35, 2.0), d.uniform(0.3, 0.7), d.uniform(0.4, 2.2)
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    columns = max(1, min(4, round(wide / d.uniform(0.35, 0.75))))
    edge = d.choice([0.0, 0.004, 0.02, 0.04])
    gap = d.choice([0.003, 0.006, 0.02, 0.04])
    cuts = np.linspace(low[0] + edge, high[0] - edge, columns + 1)
    if columns > 1 and d.chance(0.4):
        cuts[1:-1] += d.rng.uniform(-0.2, 0.2, columns - 1) * (cuts[1] - cuts[0])
    foot = d.choice([0.0, 0.0, 0.06, 0.1])
    place, fronts, holes = front_of(float(low[1])), list[Rect](), list[Floats]()
    plans = d.choice([("same",), ("mixed",), ("mixed",)])[0]
    plan = d.choice(["door", "drawers", "drawer_over_door", "pair", "flaps", "door_over_drawers"])
    for u0, u1 in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        if plans == "mixed":
            plan = d.choice(["door", "drawers", "drawer_over_door", "pair", "flaps", "door_over_drawers", "open"])
        for rect, kind, hinge in _column(d, (u0 + gap / 2, foot + edge, u1 - gap / 2, tall - edge), plan, gap):
            fronts.append(rect)
            holes.append(add_front(d, place, rect, kind, hinge, depth=deep))  # type: ignore[arg-type]
    if not d.rows:
        fronts.append((float(cuts[0]), foot + edge, float(cuts[1]), tall - edge))
        holes.append(add_front(d, place, fronts[-1], "door", "left", depth=deep))
    add_body(d, low, high, fronts, [h for h in holes if h is not None])
    if d.chance(0.3):
        over = d.uniform(0.0, 0.04)
        d.add(box((low[0] - over, low[1] - over, tall), (high[0] + over, high[1], tall + d.uniform(0.015, 0.05))))
    if d.chance(0.3):
        add_feet(d, low, high, d.uniform(0.03, 0.2))


def _column(d: Drawing, rect: Rect, plan: str, gap: float) -> list[tuple[Rect, str, str | None]]:
    """Rectangles of one column, with the kind of each and the edge that it turns on."""
    u0, v0, u1, v1 = rect
    side = d.choice(["left", "right"])
    if plan == "open":
        return []
    if plan == "pair" or (plan in {"door", "drawer_over_door", "door_over_drawers"} and u1 - u0 > 0.75):
        middle = (u0 + u1) / 2
        top = v1 if plan in {"pair", "door"} else v1 - d.uniform(0.15, 0.3) * (v1 - v0)
        leaves: list[tuple[Rect, str, str | None]] = [
            ((u0, v0, middle - gap / 2, top), "door", "left"),
            ((middle + gap / 2, v0, u1, top), "door", "right"),
        ]
        return leaves if top == v1 else [*leaves, ((u0, top + gap, u1, v1), "drawer", None)]
    if plan == "door":
        return [((u0, v0, u1, v1), "door", side)]
    if plan == "drawer_over_door":
        cut = v1 - d.uniform(0.15, 0.35) * (v1 - v0)
        return [((u0, v0, u1, cut), "door", side), ((u0, cut + gap, u1, v1), "drawer", None)]
    if plan == "door_over_drawers":
        cut = v0 + d.uniform(0.25, 0.5) * (v1 - v0)
        below = _stack(d, (u0, v0, u1, cut), d.count(1, 2), gap)
        return [*((r, "drawer", None) for r in below), ((u0, cut + gap, u1, v1), "door", side)]
    count = d.count(2, 5) if plan == "drawers" else d.count(1, 3)
    rows = _stack(d, rect, count, gap)
    return [(r, "drawer", None) if plan == "drawers" else (r, "door", d.choice(["top", "bottom"])) for r in rows]


def _stack(d: Drawing, rect: Rect, count: int, gap: float) -> list[Rect]:
    """Rectangles one above the other."""
    u0, v0, u1, v1 = rect
    share = np.ones(count) if d.chance(0.6) else d.rng.uniform(0.6, 1.4, count)
    cuts = v0 + np.concatenate([[0.0], np.cumsum(share) / share.sum()]) * (v1 - v0)
    return [(u0, float(a) + (gap if k else 0.0), u1, float(b)) for k, (a, b) in enumerate(pairwise(cuts))]


def wardrobe(d: Drawing) -> None:
    """A tall cabinet with double doors, drawers below them or not."""
    wide, deep, tall = d.uniform(0.7, 1.8), d.uniform(0.4, 0.7), d.uniform(1.5, 2.3)
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    edge, gap = d.choice([0.0, 0.02, 0.05]), d.choice([0.0, 0.003, 0.006])
    place, fronts, holes = front_of(float(low[1])), list[Rect](), list[Floats]()
    below = d.uniform(0.15, 0.35) * tall if d.chance(0.5) else edge
    pairs = 1 if wide < 1.2 else 2
    cuts = np.linspace(low[0] + edge, high[0] - edge, 2 * pairs + 1).tolist()
    for k in range(2 * pairs):
        fronts.append((cuts[k] + gap / 2, below, cuts[k + 1] - gap / 2, tall - edge))
        holes.append(add_front(d, place, fronts[-1], "door", "left" if k % 2 == 0 else "right", depth=deep))
    if below > edge:
        for k in range(pairs):
            fronts.append((cuts[2 * k] + gap / 2, edge, cuts[2 * k + 2] - gap / 2, below - max(gap, 0.003)))
            holes.append(add_front(d, place, fronts[-1], "drawer", None, depth=deep))
    add_body(d, low, high, fronts, [h for h in holes if h is not None])


def desk(d: Drawing) -> None:
    """A table top on legs or panels, with drawers under it, in a row, or in a pedestal at a side."""
    wide, deep, tall = d.uniform(0.6, 1.9), d.uniform(0.4, 0.85), d.uniform(0.45, 0.95)
    top, leg = d.uniform(0.015, 0.06), d.uniform(0.03, 0.09)
    over = d.choice([0.0, 0.01, 0.04])
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    d.add(box((low[0], low[1], tall - top), high))
    apron = d.uniform(0.07, 0.2)
    edge = d.choice([0.004, 0.015, 0.03])
    if d.chance(0.5):
        _pedestals(d, low, np.array([high[0], high[1], tall - top]), leg, over, edge)
        return
    inner_low = np.array([low[0] + over, low[1] + over, tall - top - apron])
    inner_high = np.array([high[0] - over, high[1] - over, tall - top])
    place, fronts, holes = front_of(float(inner_low[1])), list[Rect](), list[Floats]()
    begin, end = inner_low[0] + leg, inner_high[0] - leg
    if d.chance(0.3):  # drawers in the middle only
        begin, end = begin + 0.25 * (end - begin), end - 0.25 * (end - begin)
    for a, b in pairwise(np.linspace(begin, end, d.count(1, 4) + 1).tolist()):
        fronts.append((a + edge / 2, inner_low[2] + edge, b - edge / 2, inner_high[2] - min(edge, 0.01)))
        holes.append(add_front(d, place, fronts[-1], "drawer", None, depth=deep - 2 * over))
    add_body(d, inner_low, inner_high, fronts, [h for h in holes if h is not None])
    _legs(d, low, high, leg, over, tall - top)


def _pedestals(d: Drawing, low: Floats, high: Floats, leg: float, over: float, edge: float) -> None:
    """One or two stacks of drawers and doors below a top, and a panel or one more drawer between them."""
    wide, deep, two = high[0] - low[0], high[1] - low[1], d.chance(0.5)
    width = (d.uniform(0.2, 0.32) if two else d.uniform(0.25, 0.42)) * wide
    sides, near = [0, 1] if two else [d.choice([0, 1])], low[1] + over
    place = front_of(float(near))
    for side in sides:
        x = low[0] + over if side == 0 else high[0] - over - width
        foot = d.choice([0.0, 0.05])
        fronts, holes = list[Rect](), list[Floats]()
        for rect in _stack(d, (x + edge / 2, foot + edge, x + width - edge / 2, high[2] - edge), d.count(1, 4), edge):
            door = rect[3] - rect[1] > 0.35
            hinge = ("left" if side == 0 else "right") if door else None
            fronts.append(rect)
            hole = add_front(d, place, rect, "door" if door else "drawer", hinge, depth=deep)  # type: ignore[arg-type]
            holes += [] if hole is None else [hole]
        corners = np.array([x, near, foot]), np.array([x + width, high[1] - over, high[2]])
        add_body(d, *corners, fronts, holes)
    if not two:
        x = high[0] - leg if sides == [0] else low[0]
        d.add(box((x, near, 0.0), (x + leg, high[1] - over, high[2])))
    elif d.chance(0.4):
        a, b = low[0] + over + width + 0.005, high[0] - over - width - 0.005
        rect = (a, high[2] - 0.1, b, high[2] - 0.006)
        hole = add_front(d, place, rect, "drawer", None, depth=deep)
        corners = np.array([a, near, high[2] - 0.11]), np.array([b, high[1] - over, high[2]])
        add_body(d, *corners, [rect], [] if hole is None else [hole])


def _legs(d: Drawing, low: Floats, high: Floats, leg: float, over: float, tall: float) -> None:
    """Four legs, round or square, or two panels."""
    shape = d.choice(["square", "round", "panel"])
    for x in (low[0] + over, high[0] - over - leg):
        if shape == "panel":
            d.add(box((x, low[1] + over, 0.0), (x + leg, high[1] - over, tall)))
            continue
        for y in (low[1] + over, high[1] - over - leg):
            if shape == "square":
                d.add(box((x, y, 0.0), (x + leg, y + leg, tall)))
            else:
                ring = ellipse(x + leg / 2, y + leg / 2, leg / 2, leg / 2, d.style.sides)
                d.add(extrude(top_of(), ring, 0.0, tall, taper=d.uniform(0.8, 1.3)))


def chest(d: Drawing) -> None:
    """A box with a lid that is hinged at the back, flat or arched."""
    wide, deep, tall = d.uniform(0.2, 1.4), d.uniform(0.15, 0.7), d.uniform(0.12, 0.7)
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    wall = min(0.02, 0.05 * min(wide, deep))
    top, thick = top_of(tall), d.uniform(0.03, 0.35) * min(tall, 0.3)
    over = d.choice([0.0, 0.0, 0.006])
    origin = np.array([0.0, high[1], tall + d.choice([0.0, thick / 2])])
    part = d.part("lid", "revolute", np.array([-1.0, 0.0, 0.0]), origin, (0.0, d.uniform(1.2, 1.9)))
    outline = rectangle(low[0] - over, low[1] - over, high[0] + over, high[1])
    hollow = d.style.hollow
    air = 0.0 if d.style.fronts in {"contact", "pushed"} else 0.002
    room = rectangle(low[0] + wall, low[1] + wall, high[0] - wall, high[1] - wall)
    closed = d.style.fronts != "pushed"
    if d.chance(0.3):  # half a barrel over the width
        angle = np.linspace(0, np.pi, max(6, d.style.sides // 2) + 1)
        arch = np.column_stack([deep / 2 * np.cos(angle), air + d.uniform(0.3, 1.0) * deep / 2 * np.sin(angle)])
        place = Place(np.array([0.0, 0.0, tall]), np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
        d.add(extrude(place, arch, float(low[0]), float(high[0])), part)
    else:
        d.add(extrude(top, outline, air, air + thick, back=closed), part)
        if hollow and closed and d.chance(0.5):
            d.add(inside_out(extrude(top, room, air, air + 0.7 * thick, back=False)), part)
    if hollow:
        rim = rectangle(low[0], low[1], high[0], high[1])
        inner = box((low[0] + wall, low[1] + wall, wall), (high[0] - wall, high[1] - wall, tall), without="u")
        d.add(joined([box(low, high, without="u"), plate(top, rim, [room]), inside_out(inner)]))
    else:
        d.add(box(low, high, without="" if closed else "u"))
    if d.chance(0.5):  # a lock or a handle on the front of the lid
        place = front_of(float(low[1]) - over)
        half, z = d.uniform(0.02, 0.08) * wide, tall + air + thick / 2
        at = rectangle(-half, z - 0.3 * thick, half, z + 0.3 * thick)
        d.add(extrude(place, at, 0.0, d.uniform(0.004, 0.03)), part)
    if d.chance(0.3):
        add_marks(d, front_of(float(low[1])), (low[0], 0.0, high[0], tall), d.count(1, 3))
    if d.chance(0.3):
        add_feet(d, low, high, d.uniform(0.01, 0.1))


def bin_(d: Drawing) -> None:
    """A bin: round or square, with a lid hinged at the back or swinging in the middle."""
    tall, half = d.uniform(0.25, 0.9), d.uniform(0.1, 0.25)
    deep = half * d.uniform(0.7, 1.2)
    around = d.chance(0.5)
    sides = max(12, d.style.sides)
    ring = ellipse(0.0, 0.0, half, half, sides) if around else rectangle(-half, -deep, half, deep)
    back = half if around else deep
    narrow, pushed = d.uniform(0.7, 1.0), d.style.fronts == "pushed"
    walls = extrude(top_of(), ring * narrow, 0.0, tall, taper=1 / narrow, face=not (d.style.hollow or pushed))
    inner = extrude(top_of(), 0.96 * narrow * ring, 0.0, tall, taper=1 / narrow, face=False, back=False)
    d.add(joined([walls, inside_out(inner)]) if d.style.hollow else walls)
    high = d.uniform(0.01, 0.12)
    if d.chance(0.75):
        origin = np.array([0.0, back, tall])
        part = d.part("lid", "revolute", np.array([-1.0, 0, 0]), origin, (0.0, d.uniform(1.0, 1.9)))
        air = 0.0 if d.style.fronts in {"contact", "pushed"} else 0.002
        cover = ring * d.choice([1.0, 1.0, 1.03])
        d.add(extrude(top_of(tall), cover, air, air + high, taper=d.uniform(0.5, 1.0), back=not pushed), part)
        if d.chance(0.5):  # a tab that it is lifted by
            tab = rectangle(-0.2 * half, -back - 0.03, 0.2 * half, -back + 0.01)
            d.add(extrude(top_of(tall), tab, air, air + 0.01), part)
    else:  # a frame with a flap that swings about its middle
        frame = rectangle(-0.7 * half, -0.6 * back, 0.7 * half, 0.6 * back)
        d.add(extrude(top_of(tall), ring, 0.0, high, [frame]))
        origin = np.array([0.0, 0.0, tall + high])
        part = d.part("lid", "revolute", np.array([1.0, 0, 0]), origin, (0.0, 1.0))
        air = 0.0 if d.style.fronts in {"contact", "pushed", "flush"} else 0.003
        leaf = rectangle(-0.7 * half + air, -0.6 * back + air, 0.7 * half - air, 0.6 * back - air)
        d.add(extrude(top_of(tall), leaf, high - 0.008, high), part)
    if d.chance(0.5):  # a pedal, which is left in place
        at = front_of(-back * narrow)
        d.add(extrude(at, rectangle(-0.25 * half, 0.01, 0.25 * half, 0.03), -0.01, 0.05))


def safe(d: Drawing) -> None:
    """A thick box with one door, a wheel or knob, and keys on the door."""
    wide, deep, tall = d.uniform(0.3, 0.7), d.uniform(0.3, 0.6), d.uniform(0.3, 0.9)
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    edge = d.uniform(0.02, 0.06)
    d.style = replace(d.style, panel="slab", grip="none", boards=False)
    rect = (low[0] + edge, edge, high[0] - edge, tall - edge)
    side = d.choice(["left", "right"])
    hole = add_front(d, front_of(float(low[1])), rect, "door", side, depth=deep)
    leaf = 1
    place = front_of(float(min(p[:, 1].min() for (p, _), n in d.pieces if n == leaf)))
    sign = 1.0 if side == "left" else -1.0
    first = len(d.rows)
    d.style = replace(d.style, controls="contact" if d.style.controls in {"pushed", "flush"} else d.style.controls)
    add_knob(d, place, sign * d.uniform(0.0, 0.2) * wide, tall * d.uniform(0.4, 0.6), 0.07 * wide, 0.04)
    if d.chance(0.6):
        u = -sign * 0.18 * wide
        add_keypad(d, place, (u - 0.1 * wide, 0.4 * tall, u + 0.1 * wide, 0.65 * tall), 4, 3)
    for row in d.rows[first:]:
        row["parent"] = d.rows[leaf - 1]["name"]
    add_body(d, low, high, [rect], [] if hole is None else [hole])
