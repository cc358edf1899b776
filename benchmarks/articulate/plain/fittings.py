"""Faucets, switches and remote controls."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from benchmarks.articulate.plain.drawing import (
    Drawing,
    add_keypad,
    add_knob,
    add_knobs,
    add_marks,
    bent_tube,
    stamp,
)
from benchmarks.articulate.plain.solids import (
    Place,
    box,
    ellipse,
    extrude,
    front_of,
    plate,
    rectangle,
    rounded,
    top_of,
    tube,
    turned,
)
from casa_assets.core.numeric import Floats


def faucet(d: Drawing) -> None:
    """A base, a spout that swivels or not, and one or two levers."""
    sides, radius = max(8, d.style.sides), d.uniform(0.012, 0.03)
    tall = d.uniform(0.08, 0.22)
    two = d.chance(0.5)
    span = d.uniform(0.08, 0.16)
    ends = span + 0.03
    foot = rounded(-ends, -0.03, ends, 0.03, 0.02) if d.chance(0.5) else rectangle(-ends, -0.03, ends, 0.03)
    if not two and d.chance(0.7):
        foot = ellipse(0, 0, 1.5 * radius, 1.5 * radius, sides)
    d.add(extrude(top_of(), foot, 0.0, d.uniform(0.006, 0.03) if two else 0.008))
    swivels = d.chance(0.65)
    body_tall = tall * (d.uniform(0.4, 0.7) if swivels else 1.0)
    d.add(extrude(top_of(), ellipse(0, 0, radius, radius, sides), 0.0, body_tall))
    reach, rise = d.uniform(0.1, 0.25), d.uniform(0.02, 0.25)
    slim = d.uniform(0.4, 0.8) * radius
    on_top = not (two or swivels) and d.chance(0.6)
    lever_at = body_tall
    body_tall *= 0.6 if on_top else 1.0  # the spout leaves the body below the lever
    start = (0.0, 0.0, body_tall)
    tip = (0.0, -reach, body_tall + rise - d.uniform(0.3, 1.0) * rise)
    shape = d.choice(["arch", "straight", "box"])
    if shape == "arch":
        way = [start, (0, 0, body_tall + rise), (0, -reach, body_tall + rise), tip]
        surface = bent_tube(way, slim, sides)
    elif shape == "straight":
        surface = bent_tube(
            [start, (0, -0.01, body_tall + 0.4 * slim), (0, -reach, body_tall + 0.3 * rise)], slim, sides
        )
    else:
        surface = box((-slim, -reach, body_tall), (slim, slim, body_tall + 0.02))
    spout = 0
    if swivels:
        spout = d.part("spout", "revolute", np.array([0.0, 0, 1.0]), np.array(start), (-1.57, 1.57))
        collar = ellipse(0, 0, 1.05 * radius, 1.05 * radius, sides)
        d.add(extrude(top_of(body_tall), collar, d.choice([0.0, 0.001]), 0.012), spout)
    d.add(surface, spout)
    if two:
        for sign in (-1.0, 1.0):
            _two_handles(d, sign * span, sign, radius, sides)
    else:
        _one_lever(d, lever_at, radius, sides, on_top)


def _two_handles(d: Drawing, x: float, sign: float, radius: float, sides: int) -> None:
    """A handle at one end of a base: a cross, a blade or a round grip that turns around the upright."""
    foot = d.uniform(0.015, 0.04)
    d.add(extrude(top_of(), ellipse(x, 0, 0.8 * radius, 0.8 * radius, sides), 0.0, foot))
    axis = np.array([0.0, 0.0, 1.0])
    span = (0.0, d.uniform(1.2, 1.8)) if d.chance(0.5) else (-d.uniform(0.8, 1.6), d.uniform(0.8, 1.6))
    part = d.part("lever", "revolute", axis * sign, np.array([x, 0.0, foot]), span)
    top = top_of(foot)
    air = 0.0 if d.style.controls in {"contact", "pushed"} else 0.0008
    stem = d.uniform(0.012, 0.03)
    d.add(extrude(top, ellipse(x, 0, 0.7 * radius, 0.7 * radius, sides), air, stem), part)
    kind = d.choice(["cross", "blade", "round"])
    length, slim = d.uniform(0.03, 0.07), d.uniform(0.004, 0.008)
    if kind == "cross":
        d.add(extrude(top, rectangle(x - length / 2, -slim, x + length / 2, slim), stem, stem + 2 * slim), part)
        d.add(extrude(top, rectangle(x - slim, -length / 2, x + slim, length / 2), stem, stem + 2 * slim), part)
    elif kind == "blade":
        a, b = sorted((x - sign * slim, x + sign * length))
        d.add(extrude(top, rectangle(a, -slim, b, slim), stem, stem + 1.5 * slim), part)
    else:
        d.add(extrude(top, ellipse(x, 0, 0.4 * length, 0.4 * length, max(8, sides)), stem, stem + 0.02), part)


def _one_lever(d: Drawing, body: float, radius: float, sides: int, on_top: bool) -> None:
    """One lever: on a stub at a side, or on top of the body."""
    length, slim = d.uniform(0.05, 0.12), d.uniform(0.003, 0.008)
    air = 0.0 if d.style.controls in {"contact", "pushed"} else 0.0008
    if not on_top:  # at the right side, tilting around the stub
        z = body * d.uniform(0.4, 0.8)
        place = Place(np.array([0.0, 0.0, z]), np.array([[0, 1.0, 0], [0, 0, 1.0], [1.0, 0, 0]]))
        stub = radius + d.uniform(0.008, 0.02)
        d.add(extrude(place, ellipse(0, 0, 0.6 * radius, 0.6 * radius, sides), 0.5 * radius, stub))
        part = d.part("lever", "revolute", np.array([1.0, 0, 0]), np.array([stub, 0, z]), (-0.6, 0.6))
        d.add(extrude(place, ellipse(0, 0, 0.65 * radius, 0.65 * radius, sides), stub + air, stub + 0.015), part)
        tip = np.array([stub + 0.012, -d.uniform(0.0, 0.5) * length, z + length])
        d.add(tube(np.array([[stub + 0.008, 0, z], tip]), slim, max(6, sides // 2)), part)
        return
    z = body
    axis = np.array([0.0, 0.0, 1.0]) if d.chance(0.5) else np.array([1.0, 0.0, 0.0])
    part = d.part("lever", "revolute", axis, np.array([0.0, 0.0, z]), (-0.7, 0.7) if d.chance(0.5) else (0.0, 0.8))
    cap = radius * d.uniform(0.9, 1.1)
    d.add(extrude(top_of(z), ellipse(0, 0, cap, cap, sides), air, 0.02), part)
    back = d.choice([-1.0, 1.0])
    d.add(
        tube(np.array([[0, 0, z + 0.015], [0, back * length, z + d.uniform(0.015, 0.06)]]), slim, max(6, sides // 2)),
        part,
    )


def switch(d: Drawing) -> None:
    """A wall switch: a plate with rockers, toggles, keys or a dimmer."""
    kind = d.choice(["rocker", "rocker", "toggle", "key", "dimmer"])
    count = 1 if kind == "dimmer" else d.count(1, 4)
    tall, deep = d.uniform(0.07, 0.12), d.uniform(0.004, 0.015)
    wide = tall * (0.65 + 0.5 * (count - 1)) if d.chance(0.7) else tall
    outline = rectangle(-wide / 2, -tall / 2, wide / 2, tall / 2)
    outline = rounded(-wide / 2, -tall / 2, wide / 2, tall / 2, 0.1 * tall) if d.chance(0.5) else outline
    place, holes = front_of(-deep), list[Floats]()
    cuts = np.linspace(-wide / 2, wide / 2, count + 1) * 0.85
    for a, b in pairwise(cuts):
        u, half_u, half_v = (a + b) / 2, 0.42 * (b - a), 0.28 * tall
        if kind == "dimmer":
            hole = add_knob(d, place, u, 0.0, min(half_u, half_v) * 0.8, 0.012)
            holes += [] if hole is None else [hole]
        elif kind == "key":
            part = d.part("button", "prismatic", np.array([0, 1.0, 0]), place.point(u, 0.0), (0.0, 0.003))
            holes += _piece(d, place, rectangle(u - half_u, -half_v, u + half_u, half_v), d.uniform(0.001, 0.005), part)
        elif kind == "rocker":
            part = d.part("lever", "revolute", np.array([1.0, 0, 0]), place.point(u, 0.0), (-0.15, 0.15))
            rim = rectangle(u - half_u, -half_v, u + half_u, half_v)
            high = d.uniform(0.002, 0.006)
            if d.style.controls in {"printed", "flush"} or d.chance(0.4):
                holes += _piece(d, place, rim, high, part)
            else:  # tilted: one end stands out
                flat = place.points(rim, np.array([0.3 * high, 0.3 * high, 2 * high, 2 * high]))
                feet = place.points(rim, 0.0)
                n = np.arange(4)
                walls = np.concatenate(
                    [np.stack([n, (n + 1) % 4, (n + 1) % 4 + 4], 1), np.stack([n, (n + 1) % 4 + 4, n + 4], 1)]
                )
                d.add((np.concatenate([feet, flat]), np.concatenate([walls, [[4, 5, 6], [4, 6, 7]]])), part)
                holes += [rim] if d.style.controls == "pushed" else []
        else:
            part = d.part("lever", "revolute", np.array([1.0, 0, 0]), place.point(u, 0.0), (-0.5, 0.5))
            slim = 0.12 * min(half_u, half_v) + 0.002
            d.add(plate(place, rectangle(u - 2 * slim, -3 * slim, u + 2 * slim, 3 * slim), w=3e-4))
            reach = d.uniform(0.012, 0.025)
            d.add(tube(np.array([place.point(u, 0.0, -0.002), place.point(u, 0.5 * reach, reach)]), slim, 6), part)
    body = extrude(front_of(0.0), outline, 0.0, deep, face=False)
    d.add(body)
    d.add(plate(place, outline, holes))
    if d.chance(0.5):
        for v in (-0.42, 0.42):
            d.add(extrude(place, ellipse(0.0, v * tall, 0.003, 0.003, 8), 0.0, 0.001))


def _piece(d: Drawing, place: Place, outline: Floats, high: float, part: int) -> list[Floats]:
    """An outline on a plane as the style has controls, and the hole that it needs."""
    hole = stamp(d, place, outline, high, part)
    return [] if hole is None else [hole]


def remote(d: Drawing) -> None:
    """A remote control or telephone pad: a flat box with grids of keys, lying or upright."""
    wide, long, deep = d.uniform(0.035, 0.09), d.uniform(0.1, 0.24), d.uniform(0.01, 0.03)
    lying = d.chance(0.6)
    place = top_of(deep) if lying else front_of(-deep)
    d.front = None if lying else "-Y"
    outline = rectangle(-wide / 2, -long / 2, wide / 2, long / 2)
    if d.chance(0.5):
        outline = rounded(-wide / 2, -long / 2, wide / 2, long / 2, d.uniform(0.1, 0.5) * wide)
    holes = list[Floats]()
    v = -0.45 * long
    for _ in range(d.count(1, 3)):
        columns, rows = d.count(2, 5), d.count(1, 6)
        tall = min(rows * wide / columns * d.uniform(0.6, 1.0), 0.44 * long - v)
        if tall < 0.006 * rows:
            break
        half = d.uniform(0.36, 0.45) * wide
        holes += add_keypad(d, place, (-half, v, half, v + tall), rows, columns)
        v += tall + 0.03 * long
    if v < 0.25 * long and d.chance(0.5):
        r = min(0.3 * wide, 0.2 * (0.45 * long - v))
        key = d.part("button", "prismatic", -place.axes[2], place.point(0.0, 0.36 * long), (0.0, 0.001))
        holes += _piece(d, place, ellipse(0.0, 0.36 * long, r, r, d.style.sides), 0.002, key)
    elif v < 0.3 * long:
        add_marks(d, place, (-wide / 2, v, wide / 2, 0.48 * long), 1)
    d.add(extrude(Place(place.origin - deep * place.axes[2], place.axes), outline, 0.0, deep, face=False))
    d.add(plate(place, outline, holes))


def button_box(d: Drawing) -> None:
    """A box of a machine with large buttons, knobs and a lever, on its front or its top."""
    wide, deep, tall = d.uniform(0.15, 0.5), d.uniform(0.1, 0.3), d.uniform(0.1, 0.4)
    on_top = d.chance(0.5)
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    place = top_of(tall) if on_top else front_of(-deep / 2)
    rect = (-wide / 2, -deep / 2, wide / 2, deep / 2) if on_top else (-wide / 2, 0.0, wide / 2, tall)
    u0, v0, u1, v1 = rect
    middle = (v0 + v1) / 2
    holes = add_keypad(d, place, (u0, middle, u1, v1), d.count(1, 2), d.count(1, 4))
    if d.chance(0.6):
        r = 0.3 * min((u1 - u0) / 3, (middle - v0))
        for u in [0.0] if d.chance(0.5) else [u0 + 0.25 * wide, u1 - 0.25 * wide]:
            hole = add_knob(d, place, u, (v0 + middle) / 2, r, d.uniform(0.5, 1.0) * r)
            holes += [] if hole is None else [hole]
    d.add(box(low, high, without="u" if on_top else "f"))
    d.add(plate(place, rectangle(*rect), holes))


def stove_top(d: Drawing) -> None:
    """A hob: a flat plate with burners and a row of knobs on it or on its front edge."""
    wide, deep, tall = d.uniform(0.5, 0.95), d.uniform(0.42, 0.6), d.uniform(0.03, 0.12)
    low, high = np.array([-wide / 2, -deep / 2, 0.0]), np.array([wide / 2, deep / 2, tall])
    on_top = tall < 0.07 or d.chance(0.5)
    count = d.count(2, 6)
    top, holes = top_of(tall), list[Floats]()
    if on_top:
        holes = add_knobs(d, top, (low[0] + 0.15 * wide, low[1], high[0] - 0.15 * wide, low[1] + 0.2 * deep), count)
    else:
        holes = add_knobs(d, front_of(float(low[1])), (low[0], 0.0, high[0], tall), count)
    for u in (-0.25, 0.25):
        for v in (0.0, 0.3):
            r = d.uniform(0.06, 0.1)
            ring = ellipse(u * wide, v * deep, r, r, max(16, d.style.sides))
            d.add(extrude(top, ring, 0.0, d.uniform(0.001, 0.02)))
            if d.chance(0.5):
                profile = np.array([[0.4 * r, 0.0], [0.4 * r, 0.02], [0.0, 0.025]])
                d.add(turned(top, u * wide, v * deep, profile, d.style.sides))
    d.add(box(low, high, without="u" if on_top else "uf"))
    rim = rectangle(low[0], low[1], high[0], high[1])
    d.add(plate(top, rim, holes if on_top else []))
    if not on_top:
        d.add(plate(front_of(float(low[1])), rectangle(low[0], 0.0, high[0], tall), holes))
