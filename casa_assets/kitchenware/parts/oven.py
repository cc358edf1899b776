"""Ovens: cavities with a grill, a fan and a lamp, and doors on hinges whose springs carry their weight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext.arrays import Floats, significant
from casa_assets.ext.families import hand_dynamics
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import (
    ROOT,
    AssetBuilder,
    board,
    box,
    box_shape,
    concatenate,
    lathe,
    rectangle,
    subtract,
    tube,
)
from casa_assets.kitchenware.parts.cases import add_liner, cavity_walls
from casa_assets.kitchenware.parts.racks import add_oven_rack

GRAVITY = 9.81  # m/s^2
OVEN_DOOR_TRAVEL = 1.48  # rad
OVEN_DOOR_START_N = 6.0  # least force at the handle that starts an oven door

INSULATION_THICKNESS = 0.045  # metres of insulation between liner and shell
DOOR_GAP = 0.003
DOOR_THICKNESS = 0.045  # of a door: two panes and air
OvenHandle = StrEnum("OvenHandle", "BAR PRO FLAT CURVED")


def balanced_hinge(builder: AssetBuilder, link: str, grip: str, travel: float) -> None:
    """Hinge a link about x through its origin; its spring is fitted to the moment of its weight by least squares.

    grip: collider that a hand takes. travel: rad; it opens to the front where positive, up where negative.
    """
    angles = np.linspace(0.0, travel, 33)
    inertia, lever, moment = _load(builder, link, grip, angles)
    stiffness = float(np.polyfit(angles, moment, 1)[0])
    residual = moment - stiffness * angles
    bias = (float(residual.max()) + float(residual.min())) / 2
    unbalanced = float(residual.max()) - bias
    start_n = max(hand_dynamics.START_N, 1.35 * unbalanced / lever)
    spring, feel = _feel((inertia, lever), (bias, stiffness), travel, unbalanced, start_n)
    span = (min(0.0, travel), max(0.0, travel))
    builder.hinge(f"{link}_joint", link, (1.0, 0.0, 0.0), span, grip, spring=spring, feel=feel)


def oven_door_hinge(builder: AssetBuilder, link: str, name: str | None = None) -> None:
    """Hinge a door at its lower edge; of 61 springs it gets the one whose largest unbalanced moment is least."""
    grip, travel = f"{link}_handle_main", OVEN_DOOR_TRAVEL
    angles = np.linspace(0.0, travel, 25)
    inertia, lever, moment = _load(builder, link, grip, angles)
    stiffnesses = np.linspace(0.2, 1.4, 61) * max(float(moment[-1]), 0.5) / travel
    residual = moment - stiffnesses[:, None] * angles
    bias = (residual.max(axis=1) + residual.min(axis=1)) / 2
    unbalanced = np.abs(residual - bias[:, None]).max(axis=1)
    k = int(np.argmin(unbalanced))
    worst = float(unbalanced[k])
    start_n = max(OVEN_DOOR_START_N, 1.25 * worst / lever)
    spring, feel = _feel((inertia, lever), (float(bias[k]), float(stiffnesses[k])), travel, worst, start_n)
    builder.hinge(name or f"{link}_joint", link, (1.0, 0.0, 0.0), (0.0, travel), grip, spring=spring, feel=feel)


def _load(builder: AssetBuilder, link: str, grip: str, angles: Floats) -> tuple[float, float, Floats]:
    """Inertia (kg*m^2) of a link about x, lever (m) of its grip, and (N,) moments (N*m) of its weight at angles."""
    owner = builder.links[link]
    mass = sum(m.mass for m in owner.masses)
    center = sum((m.mass * m.center for m in owner.masses), np.zeros(3)) / mass
    hand = next(c for c in owner.colliders if c.name == grip).pose.position
    moment = mass * GRAVITY * (center[2] * np.sin(angles) - center[1] * np.cos(angles))
    return mass * float(center[1] ** 2 + center[2] ** 2) * 1.35, math.hypot(hand[1], hand[2]), moment


def _feel(
    load: Vec2, moments: Vec2, travel: float, unbalanced: float, start_n: float
) -> tuple[hand_dynamics.Spring, hand_dynamics.Feel]:
    """Spring and friction of a hinge.

    load: inertia and lever. moments: bias and stiffness; the spring's moment is bias + stiffness * angle. unbalanced:
    N*m of the weight's moment that the spring leaves over. start_n: force that starts the link, N.
    """
    (inertia, lever), (bias, stiffness) = load, moments
    push_n = max(start_n + 2.5, hand_dynamics.PULL_N - unbalanced / lever)
    spring = hand_dynamics.Spring(significant(stiffness, 4), significant(-bias / stiffness, 4))
    return spring, hand_dynamics.feel(inertia, lever, abs(travel), start_n, push_n)


@dataclass(frozen=True)
class OvenLook:
    """Finishes and forms of an oven.

    shell, liner, face, glass, metal: finishes. grip: of the door. window: share of the door that is glass, 0..1.
    border: finish of a border round the window, or None.
    """

    shell: str
    face: str
    metal: str
    grip: OvenHandle = OvenHandle.BAR
    window: float = 0.62
    liner: str = "enamel_charcoal"
    glass: str = "glass_oven_dark"
    border: str | None = None


def add_cavity(
    builder: AssetBuilder,
    lower: Vec3,
    upper: Vec3,
    looks: OvenLook,
    racks: int,
    first: int = 0,
    door: str = "door_joint",
    collider: bool = True,
    rack: str = "rack",
) -> None:
    """Walls round a cavity, open to the front (-y), and its racks.

    lower, upper: corners of the outside; the front plane is lower[1]. racks: how many; they are named <rack><first>,
    <rack><first + 1> from below. door: joint that has to be open before a rack can move. collider: False: no colliders
    for walls. rack: begins the names of racks.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    t = INSULATION_THICKNESS
    inner = ((x0 + t, y0, z0 + t), (x1 - t, y1 - t, z1 - t))
    for corners in cavity_walls((lower, upper), inner):
        builder.add(ROOT, board(*corners, 0.0), looks.shell, "case", collider=collider, density="oven_wall")
    (a0, b0, c0), (a1, b1, c1) = inner
    add_liner(builder, (a0, b0 + 0.001, c0), (a1, b1, c1), looks.liner, "steel")
    seal = subtract(
        board((a0 - 0.014, y0 - 0.0013, c0 - 0.014), (a1 + 0.014, y0 - 0.0003, c1 + 0.014), 0.0),
        board((a0 - 0.004, y0 - 0.01, c0 - 0.004), (a1 + 0.004, y0 + 0.01, c1 + 0.004), 0.0),
    )
    builder.draw(ROOT, seal, "gasket_grey", "gasket", density="soft_gasket")
    furnish_cavity(builder, *inner, f"lamp{first}")
    height = c1 - c0
    for k in range(racks):
        z = c0 + height * (0.22 + 0.56 * k / max(1, racks - 1) if racks > 1 else 0.4)
        clearance = height * (0.56 / max(1, racks - 1)) - 0.03 if k < racks - 1 else c1 - z - 0.05
        add_oven_rack(builder, f"{rack}{first + k}", (a0, b0, z), (a1, b1, z + max(0.07, clearance)), looks.liner, door)


def furnish_cavity(builder: AssetBuilder, lower: Vec3, upper: Vec3, lamp: str) -> None:
    """A grill's element, a fan behind a cover and a lamp in a cavity between two corners; `lamp` names its mesh."""
    (a0, b0, _), (a1, b1, c1) = lower, upper
    line = [
        (a0 + 0.05, b1 - 0.04, c1 - 0.03), (a0 + 0.05, b0 + 0.08, c1 - 0.03), (a1 - 0.05, b0 + 0.08, c1 - 0.03),
        (a1 - 0.05, b1 - 0.04, c1 - 0.03),
    ]  # fmt: skip
    builder.draw(ROOT, tube(line, 0.004, 0.03), "heating_element", "element")
    x, z = (a0 + a1) / 2, (lower[2] + c1) / 2
    r = min(0.085, 0.33 * (c1 - lower[2]), 0.3 * (a1 - a0))
    face = b1 - 0.0008  # the liner's front
    cover = lathe([(r, 0.0), (r, 0.004), (0.9 * r, 0.009), (0.0, 0.009)]).rotated("x", math.pi / 2)
    builder.draw(ROOT, cover.translated(x, face, z), "enamel_charcoal", "fan", density="oven_fan")
    slots = [box((0.0035, 0.0008, 0.5 * r), (0.0, -0.0098, 0.52 * r), 0.0) for _ in range(12)]
    ring = concatenate([s.rotated("y", 2 * math.pi * k / 12) for k, s in enumerate(slots)])
    builder.draw(ROOT, ring.translated(x, face, z), "rubber_black", "fan", density=0.0)
    bulb = lathe([(0.026, 0.0), (0.026, 0.003), (0.021, 0.005), (0.017, 0.011), (0.0, 0.014)]).rotated("x", math.pi / 2)
    at = (a1 - 0.055, face, c1 - 0.05)
    builder.draw(ROOT, bulb.translated(*at), "glass_opal", "lamp", name=lamp, density="oven_lamp")


def add_oven_door(
    builder: AssetBuilder, link: str, lower: Vec2, upper: Vec2, looks: OvenLook, joint: str | None = None
) -> str:
    """A door before y = 0 between corners in x and z, hinged at its lower front edge; returns its joint. Metres."""
    (x0, z0), (x1, z1) = lower, upper
    w, h = x1 - x0, z1 - z0
    builder.link(link, at=(x0, -DOOR_THICKNESS - DOOR_GAP, z0))
    slab = board((0.0, 0.0, 0.0), (w, DOOR_THICKNESS, h), 0.004, 2)
    m = 0.09 + 0.1 * (1 - looks.window)
    pane_low, pane_high = (m, h * (0.5 - looks.window / 2) * 0.8), (w - m, h * (0.5 + looks.window / 2) * 0.96)
    hole = board((pane_low[0], -0.01, pane_low[1]), (pane_high[0], DOOR_THICKNESS + 0.01, pane_high[1]), 0.0)
    frame = subtract(slab, hole, shapes=(box_shape((0, 0, 0), (w, DOOR_THICKNESS, h)),))
    builder.add(link, frame, looks.face, "door", name=f"{link}_main", density="oven_door")
    if looks.border:
        rim = subtract(
            board(
                (pane_low[0] - 0.016, -0.0009, pane_low[1] - 0.016),
                (pane_high[0] + 0.016, -0.0003, pane_high[1] + 0.016),
            ),
            board((pane_low[0], -0.1, pane_low[1]), (pane_high[0], 0.1, pane_high[1]), 0.0),
        )
        builder.draw(link, rim, looks.border, "window")
    for y in (0.004, DOOR_THICKNESS - 0.008):
        pane = board(
            (pane_low[0] - 0.004, y, pane_low[1] - 0.004), (pane_high[0] + 0.004, y + 0.003, pane_high[1] + 0.004), 0.0
        )
        builder.draw(link, pane, looks.glass, "window")
    inner = subtract(
        board((0.012, DOOR_THICKNESS - 0.0002, 0.012), (w - 0.012, DOOR_THICKNESS + 0.0012, h - 0.012), 0.0),
        board((pane_low[0] + 0.002, 0.0, pane_low[1] + 0.002), (pane_high[0] - 0.002, 1.0, pane_high[1] - 0.002), 0.0),
    )
    builder.draw(link, inner, looks.liner, "door", density="oven_door_liner")
    _handle(builder, link, w, h, looks)
    name = joint or f"{link}_joint"
    oven_door_hinge(builder, link, name)
    return name


def _handle(builder: AssetBuilder, link: str, w: float, h: float, looks: OvenLook) -> None:
    """A handle near the upper edge of a door of width w and height h; its collider is `<link>_handle_main`."""
    z, reach, inset = h - 0.05, 0.048, 0.06
    if looks.grip is OvenHandle.CURVED:
        path = [
            (float(w / 2 + s * (w / 2 - inset)), float(-reach * (1 - 0.35 * s**4) if abs(s) < 0.999 else -0.0), z)
            for s in np.linspace(-1, 1, 13)
        ]
        grip_box = box_shape((inset, -reach - 0.008, z - 0.011), (w - inset, -reach + 0.012, z + 0.011))
        ends = [
            box_shape((x - 0.012, -reach, z - 0.011), (x + 0.012, 0.0, z + 0.011))
            for x in (inset + 0.012, w - inset - 0.012)
        ]
        grip = tube(path, rectangle(0.016, 0.022, 0.006, 3)).with_shapes(grip_box, *ends)
    else:
        if looks.grip is OvenHandle.PRO:
            size, edge_radius, steps = (0.03, reach, 0.034), 0.005, 2
            grip = tube([(inset - 0.035, -reach - 0.002, z), (w - inset + 0.035, -reach - 0.002, z)], 0.0145)
        elif looks.grip is OvenHandle.FLAT:
            size, edge_radius, steps = (0.02, reach - 0.01, 0.016), 0.002, 1
            grip = box((w - 2 * inset + 0.05, 0.012, 0.026), (w / 2, -reach + 0.004, z), 0.003, 2)
        else:
            size, edge_radius, steps = (0.018, reach, 0.018), 0.004, 2
            grip = tube([(inset - 0.02, -reach, z), (w - inset + 0.02, -reach, z)], 0.0105)
        posts = [box(size, (x, -size[1] / 2, z), edge_radius, steps) for x in (inset, w - inset)]
        builder.add(link, posts, looks.metal, "handle", density="metal_rod")
    builder.add(link, grip, looks.metal, "handle", name=f"{link}_handle_main", density="handle_pipe")
