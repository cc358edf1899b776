"""Kitchen faucets: a body on a deck, a spout that swings, a lever for the flow and one for the temperature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import TAP_START_N, FinishId, Params, hand_dynamics
from casa_assets.ext.records import EffectKind, Vec3
from casa_assets.ext.solids import (
    ROOT,
    AssetBuilder,
    BehaviorBuilder,
    Solid,
    ball,
    box,
    lathe,
    rectangle,
    rod,
    round_corners,
    tube,
)

# Ref: RoboCasa v0.2 and v1.0, class Sink: water runs where 0.40 < handle_joint < pi; high from half of the range on.
FLOW_START, FLOW_RANGE = 0.40, 1.0
TEMPERATURE_RANGE = 0.785
SPOUT_RANGE = 1.57
WATER = (0.45, 0.62, 0.75, 0.0)

SpoutForm = StrEnum("SpoutForm", "GOOSENECK PULL_DOWN SQUARE LOW_ARC BRIDGE SPRING TAPERED VICTORIAN")


class Faucet(Params):
    """Parameters of a faucet."""

    form: SpoutForm = Field(SpoutForm.GOOSENECK, description="of the spout")
    reach: float = Field(0.21, description="from the swivel to where the water falls, m")
    height: float = Field(0.36, description="of the highest point, m")
    finish: FinishId = Field("chrome", description="finish of the metal")


@dataclass(frozen=True)
class Spout:
    """The swinging part about its own swivel: solids, and where the water leaves (x, y, z)."""

    solids: tuple[Solid, ...]
    mouth: Vec3


def add_faucet(builder: AssetBuilder, p: Faucet, at: Vec3, fall: float, turn: float = 0.0) -> None:
    """Add a faucet with its links, joints, `water` site and behaviour.

    Args:
        builder: of the sink.
        at: position of its foot; the spout points to -y.
        fall: z at which the water lands, metres.
        turn: of the resting spout to the right, rad.
    """
    x, y, z = at
    bridge = p.form in (SpoutForm.BRIDGE, SpoutForm.VICTORIAN)
    body, swivel = _body(p, bridge)
    for solid in body:
        builder.add(ROOT, solid.translated(x, y, z), p.finish, "faucet", density="tap_body")
    builder.link("spout", at=(x, y, z + swivel))
    spout = _spout(p, p.height - swivel)
    for i, solid in enumerate(spout.solids):
        builder.add(
            "spout",
            solid.rotated("z", turn) if turn else solid,
            p.finish,
            "spout",
            collider="spout_main" if i == 0 else True,
            density="tap_body",
        )
    span = (-SPOUT_RANGE - turn, SPOUT_RANGE - turn)
    builder.hinge("spout_joint", "spout", (0.0, 0.0, 1.0), span, "spout_main", start_n=TAP_START_N)
    mx, my, mz = spout.mouth
    mx, my = mx * math.cos(turn) - my * math.sin(turn), mx * math.sin(turn) + my * math.cos(turn)
    stream = z + swivel + mz - fall
    builder.column("water", (mx, my, mz - stream / 2), (0.016, 0.016, stream), WATER, link="spout")
    _levers(builder, p, at, bridge)
    add_faucet_behavior(builder.behavior)


def _body(p: Faucet, bridge: bool) -> tuple[list[Solid], float]:
    """Make the fixed body about the foot; return its solids and the height of the swivel, metres."""
    if bridge:
        parts = []
        for side in (-0.1, 0.1):
            post = lathe(
                [
                    (0.026, 0.0),
                    (0.026, 0.004),
                    (0.016, 0.012),
                    (0.013, 0.02),
                    (0.015, 0.03),
                    (0.015, 0.095),
                    (0.012, 0.1),
                ]
            )
            parts.append(post.with_colliders_of(rod(0.016, 0.1).translated(z=0.05)).translated(side))
        pipe = tube([(-0.1, 0.0, 0.075), (0.1, 0.0, 0.075)], 0.009)
        hub = lathe([(0.0125, 0.06), (0.017, 0.064), (0.017, 0.092), (0.0125, 0.0945)]).with_colliders_of(
            rod(0.017, 0.035).translated(z=0.077)
        )
        return [*parts, pipe, hub], 0.0955
    if p.form is SpoutForm.SQUARE:
        foot = box((0.05, 0.05, 0.006), (0.0, 0.0, 0.003), 0.001)
        trunk = box((0.042, 0.042, 0.124), (0.0, 0.0, 0.068), 0.002)
        return [foot, trunk], 0.131
    height = 0.09 if p.form is SpoutForm.LOW_ARC else 0.13
    profile = [
        (0.029, 0.0),
        (0.029, 0.003),
        (0.024, 0.007),
        (0.0225, 0.012),
        (0.021, height - 0.01),
        (0.0195, height - 0.002),
        (0.018, height),
    ]
    return [lathe(profile).with_colliders_of(rod(0.024, height).translated(z=height / 2))], height + 0.001


def _spout(p: Faucet, rise: float) -> Spout:
    """The spout; `rise` is its highest point above the swivel."""
    reach = p.reach
    if p.form is SpoutForm.SQUARE:
        outline = rectangle(0.026, 0.026, 0.002, 1)
        path = [(0.0, 0.0, 0.0), (0.0, 0.0, rise - 0.013), (0.0, -reach, rise - 0.013), (0.0, -reach, rise - 0.06)]
        return Spout((tube([path[1], path[2], path[3]], outline), tube(path[:2], outline)), (0.0, -reach, rise - 0.06))
    if p.form is SpoutForm.LOW_ARC:
        path = [(0.0, 0.0, 0.0), (0.0, -0.03, rise * 0.8), (0.0, -reach * 0.75, rise), (0.0, -reach, rise * 0.55)]
        tip = rod(0.016, 0.012).translated(0.0, -reach, rise * 0.55)
        return Spout((_pipe(path, 0.014, 0.09), tip), (0.0, -reach, rise * 0.55 - 0.006))
    if p.form is SpoutForm.VICTORIAN:
        path = [
            (0.0, 0.0, 0.0),
            (0.0, 0.0, rise * 0.55),
            (0.0, -reach * 0.5, rise),
            (0.0, -reach, rise * 0.6),
            (0.0, -reach, rise * 0.35),
        ]
        knob = ball(0.017).translated(0.0, 0.0, 0.02)
        tip = rod(0.0145, 0.012).translated(0.0, -reach, rise * 0.35)
        return Spout((_pipe(path, 0.0125, 0.07), knob, tip), (0.0, -reach, rise * 0.35 - 0.006))
    drop = {
        SpoutForm.GOOSENECK: 0.45,
        SpoutForm.BRIDGE: 0.5,
        SpoutForm.TAPERED: 0.4,
        SpoutForm.PULL_DOWN: 0.3,
        SpoutForm.SPRING: 0.25,
    }[p.form]
    mouth = (0.0, -reach, rise * (1 - drop))
    path = [(0.0, 0.0, 0.0), (0.0, 0.0, rise), (0.0, -reach, rise), mouth]
    radius = {SpoutForm.TAPERED: 0.017, SpoutForm.SPRING: 0.009}.get(p.form, 0.0125)
    neck = _pipe(path, radius, reach / 2)
    if p.form is SpoutForm.PULL_DOWN:
        head = lathe([(0.012, 0.0), (0.0155, -0.02), (0.0185, -0.08), (0.0185, -0.095), (0.016, -0.1)][::-1])
        head = head.with_colliders_of(rod(0.018, 0.1).translated(z=-0.05)).translated(*mouth)
        return Spout((neck, head), (mouth[0], mouth[1], mouth[2] - 0.1))
    if p.form is SpoutForm.SPRING:
        head = lathe(
            [(0.011, 0.0), (0.014, -0.03), (0.014, -0.09), (0.021, -0.1), (0.021, -0.112), (0.018, -0.115)][::-1]
        )
        head = head.with_colliders_of(rod(0.019, 0.115).translated(z=-0.0575)).translated(*mouth)
        arm = tube([(0.0, 0.0, rise * 0.3), (0.0, -reach + 0.014, rise * 0.3)], 0.006)
        low = (mouth[0], mouth[1], mouth[2] - 0.115)
        return Spout((neck, _coil(path, 0.0145, reach / 2), head, arm), low)
    tip = rod(radius + 0.002, 0.014).translated(mouth[0], mouth[1], mouth[2] - 0.004)
    return Spout((neck, tip), (mouth[0], mouth[1], mouth[2] - 0.011))


def _pipe(path: list[Vec3], radius: float, bend: float) -> Solid:
    """A bent round pipe, with boxes round its straight runs as colliders: capsules would stick out of the bends."""
    solid = tube([_vec(q) for q in round_corners(path, bend, 8)], radius)
    line = round_corners(path, bend, 3)
    shapes = []
    for a, b in pairwise(line):
        seg = tube([_vec(a), _vec(b)], radius)
        if np.linalg.norm(b - a) > 0.006:
            shapes += list(seg.shapes)
    # The grip comes first: the run that is farthest from the swivel.
    shapes.sort(key=lambda s: (s[1].position[1], s[1].position[2]))
    return solid.with_shapes(*shapes)


def _vec(point: Floats) -> Vec3:
    x, y, z = (float(v) for v in point)
    return x, y, z


def _coil(path: list[Vec3], radius: float, bend: float) -> Solid:
    """A spring wound round the pipe; seen only."""
    line = round_corners(path, bend, 10)
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(steps)])
    start, end, pitch = 0.02, float(run[-1]) - 0.005, 0.011
    count = int((end - start) / pitch * 9)
    points: list[Vec3] = []
    for k in range(count + 1):
        s = start + (end - start) * k / count
        point = np.array([np.interp(s, run, line[:, i]) for i in range(3)])
        ahead = np.array([np.interp(s + 1e-3, run, line[:, i]) for i in range(3)]) - point
        ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
        side = np.array([1.0, 0.0, 0.0])
        up = np.cross(side, ahead)
        turn = 2 * math.pi * (s - start) / pitch
        x, y, z = point + radius * (math.cos(turn) * side + math.sin(turn) * up)
        points.append((float(x), float(y), float(z)))
    return tube(points, 0.0019).without_colliders()


def _levers(builder: AssetBuilder, p: Faucet, at: Vec3, bridge: bool) -> None:
    """The flow lever on the right tips towards the cook, the temperature lever on the left turns about its stem."""
    x, y, z = at
    hub_x, hub_z = (0.1, 0.1005) if bridge else (0.05, 0.075)
    if p.form is SpoutForm.LOW_ARC:
        hub_z = 0.055
    if not bridge:
        for sign in (-1, 1):
            stem = rod(0.0125, 0.028, axis="x").translated(x + sign * 0.034, y, z + hub_z)
            builder.add(ROOT, stem, p.finish, "faucet", density="tap_body")
    # Flow: a hinge about x; at rest the lever stands up, and tips forward.
    builder.link("handle", at=(x + hub_x + (0.0 if bridge else 0.0075), y, z + hub_z + (0.014 if bridge else 0.0)))
    hub = ball(0.0125) if bridge else rod(0.0135, 0.014, axis="x")
    if p.form is SpoutForm.VICTORIAN:
        parts = [tube([(0.0, 0.0, 0.008), (0.0, 0.0, 0.05)], 0.005), ball(0.0095).translated(z=0.058)]
        builder.add("handle", parts[0], p.finish, "handle", density="tap_body")
        builder.add("handle", parts[1], "ceramic_white", "handle", name="handle_main")
    elif p.form is SpoutForm.SQUARE:
        handle = box((0.011, 0.02, 0.085), (0.0, 0.0, 0.052), 0.0015)
        builder.add("handle", handle, p.finish, "handle", "handle_main", density="tap_body")
    else:
        blade = tube([(0.0, 0.0, 0.01), (0.0, 0.0, 0.098)], rectangle(0.011, 0.016, 0.0045, 4), up=(0.0, 1.0, 0.0))
        builder.add("handle", blade.with_box_collider(), p.finish, "handle", "handle_main", density="tap_body")
    builder.add("handle", hub, p.finish, "handle", density="tap_body")
    flow = hand_dynamics.feel(2e-4, 0.07, FLOW_RANGE, 5.5)
    builder.hinge("handle_joint", "handle", (1.0, 0.0, 0.0), (0.0, FLOW_RANGE), "handle_main", feel=flow)
    # Temperature: a hinge about z; at rest the lever points to the left.
    temp_x = -hub_x - (0.0 if bridge else 0.0125)
    builder.link("handle_temp", at=(x + temp_x, y, z + hub_z + (0.008 if bridge else 0.0)))
    cap = rod(0.0125, 0.012) if bridge else rod(0.0135, 0.026)
    arm = tube([(-0.008, 0.0, 0.002), (-0.066, 0.0, 0.008)], 0.0058)
    builder.add("handle_temp", arm, p.finish, "handle", name="handle_temp_main", density="tap_body")
    builder.add("handle_temp", cap, p.finish, "handle", density="tap_body")
    warm = hand_dynamics.feel(1.5e-4, 0.04, 2 * TEMPERATURE_RANGE, 5.5)
    span = (-TEMPERATURE_RANGE, TEMPERATURE_RANGE)
    builder.hinge("handle_temp_joint", "handle_temp", (0.0, 0.0, 1.0), span, "handle_temp_main", feel=warm)


def add_faucet_behavior(behavior: BehaviorBuilder) -> None:
    """Water by the flow lever, hot or cold by the other."""
    half = FLOW_RANGE / 2
    levels = {"off": (0.0, FLOW_START), "low": (FLOW_START, half), "high": (half, FLOW_RANGE + 0.01)}
    behavior.follow_joint("water", "handle_joint", levels)
    sides = {"cold": (-TEMPERATURE_RANGE - 0.01, 0.0), "hot": (0.0, TEMPERATURE_RANGE + 0.01)}
    behavior.follow_joint("temperature", "handle_temp_joint", sides)
    strengths = {"low": 0.5, "high": 1.0}
    for value, strength in strengths.items():
        behavior.effect(
            EffectKind.SHOW, "water", "water", value=value, color=(0.45, 0.62, 0.75, 0.6), strength=strength
        )
    for value, strength in strengths.items():
        behavior.effect(EffectKind.FLOW, "water", "water", value=value, strength=strength)
