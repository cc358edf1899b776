"""Whole things, built of plain solids: which solids move, as what, and how; and that nothing is invented."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np
import pytest

from casa_assets.articulate.frame import axis_name, guess_frame
from casa_assets.articulate.plan import Articulation, PartKind, PartPlan
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.segment.fragments import weld_triangles
from casa_assets.articulate.unfound_parts import signs_of_parts
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import (
    Floats,
    Ints,
    Part,
    articulate_fragmentation,
    box,
    carcass,
    disc,
    drawers,
    found_in,
    fragments_of,
    in_its_frame,
    microwave,
    together,
)

pytestmark = pytest.mark.content("code", "articulate", keep=0)

Corner = tuple[float, float, float]


def tub(low: Corner, high: Corner, wall: float = 0.01) -> list[Part]:
    """Five boards, open at the top."""
    (x, y, z), (a, b, c) = low, high
    sides = [box((left, y, z + wall), (left + wall, b, c)) for left in (x, a - wall)]
    ends = [box((x + wall, front, z + wall), (a - wall, front + wall, c)) for front in (y, b - wall)]
    return [box((x, y, z), (a, b, z + wall)), *sides, *ends]


def bar(low: Corner, high: Corner, front: float) -> list[Part]:
    """A handle with two feet that reach a front at `y = front`."""
    wide = high[0] - low[0] > high[2] - low[2]
    size = 0.012
    ends = [low, (high[0] - size, low[1], low[2]) if wide else (low[0], low[1], high[2] - size)]
    feet = [box((e[0], high[1], e[2]), (e[0] + size, front, e[2] + size)) for e in ends]
    return [box(low, high), *feet]


def lying(part: Part) -> Part:
    """A disc of `blocks` with its axis made upright: (x, y, z) -> (x, z, -y)."""
    points, faces = part
    return points @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float64), faces


def upright(bottom: Corner, radius: float, height: float) -> Part:
    """A cylinder along z that stands on a point."""
    points, faces = disc((0.0, 0.0, 0.0), radius, height)
    return points[:, [0, 2, 1]] + np.array(bottom), faces[:, ::-1]


def tilted(part: Part, degrees: float, about: Corner) -> Part:
    """A part turned about a line along x through a point."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    rotation: Floats = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    points, faces = part
    return (points - np.array(about)) @ rotation.T + np.array(about), faces


def oven(*inside: Part) -> list[Part]:
    """A carcass whose front folds down, and what is in it. Parts: 0..4 carcass, 5 door, 6..8 handle, 9.. inside."""
    front = [box((0.0, -0.02, 0.0), (0.6, 0.0, 0.5)), *bar((0.05, -0.06, 0.45), (0.55, -0.05, 0.462), -0.02)]
    return [*carcass(0.6, 0.5, 0.5), *front, *inside]


def tall_door(*inside: Part) -> list[Part]:
    """A tall carcass with a door and its handle, parts 5 to 8, and what is in it, from 9 on."""
    door = [box((0.0, -0.02, 0.0), (0.5, 0.0, 1.2)), *bar((0.46, -0.06, 0.5), (0.472, -0.05, 0.8), -0.02)]
    return [*carcass(0.5, 0.5, 1.2), *door, *inside]


def kettle(bail: bool, handle: bool) -> list[Part]:
    """A pot with a lid and its knob (parts 1, 2), with a bail over it from front to back, or a handle at the right."""
    solid = manifold3d.Manifold
    pot = solid.cylinder(0.15, 0.1, 0.1, 64) - solid.cylinder(0.14, 0.09, 0.09, 64).translate((0, 0, 0.02))
    lid = solid.cylinder(0.01, 0.085, 0.085, 64).translate((0, 0, 0.151))
    parts = [pot, lid, solid.cylinder(0.03, 0.014, 0.014, 32).translate((0, 0, 0.162))]
    if bail:
        parts.append(solid.cube((0.02, 0.24, 0.02)).translate((-0.01, -0.12, 0.26)))
        parts += [solid.cube((0.02, 0.02, 0.2)).translate((-0.01, y, 0.06)) for y in (-0.12, 0.1)]
    if handle:
        parts.append(solid.cube((0.06, 0.02, 0.14)).translate((0.1, -0.01, 0.0)))
    return [shape_of(p) for p in parts]


def shape_of(solid: manifold3d.Manifold) -> Part:
    """Vertices and faces of a solid."""
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties, dtype=np.float64)[:, :3], np.array(mesh.tri_verts, dtype=np.int64)


def solids_of(whole: tuple[Floats, Ints, Ints]) -> list[Part]:
    """The solids that were put together."""
    points, faces, owner = whole
    used = [np.unique(faces[owner == k]) for k in range(int(owner.max()) + 1)]
    return [(points[u], np.searchsorted(u, faces[owner == k])) for k, u in enumerate(used)]


def chest(*more: Part) -> list[Part]:
    """The floor and four walls of a chest 0.8 wide, 0.4 deep and 0.3 high, and more."""
    return [*tub((-0.4, -0.2, 0.0), (0.4, 0.2, 0.3), 0.02), *more]


COVER = box((-0.4, -0.2, 0.3), (0.4, 0.2, 0.36))
PEDAL = box((-0.04, -0.2, 0.01), (0.04, -0.1, 0.03))
ROUND_BIN = [upright((0.0, 0.0, 0.0), 0.15, 0.4), upright((0.0, 0.0, 0.401), 0.15, 0.059)]


def hob(*more: Part) -> list[Part]:
    """A slab with four knobs in a row at its front, and more. Parts: 0 slab, 1..4 knobs, 5.. more."""
    knobs = [lying(disc((x, -0.06, 0.05), 0.02, 0.03)) for x in (0.12, 0.24, 0.36, 0.48)]
    return [box((0, 0, 0), (0.6, 0.5, 0.03)), *knobs, *more]


def toaster(*more: Part) -> list[Part]:
    """A body with two slots for bread in its top, and what else there is; its front lies at y = 0."""
    walls = [box((0.0, y, 0.05), (0.4, y + 0.07, 0.25)) for y in (0.0, 0.09, 0.18)]
    ends = [box((x, y, 0.05), (x + 0.05, y + 0.02, 0.25)) for x in (0.0, 0.35) for y in (0.07, 0.16)]
    return [box((0.0, 0.0, 0.0), (0.4, 0.25, 0.05)), *walls, *ends, *more]


def faucet(sticks: int = 2, valves: bool = True) -> list[Part]:
    """A plate, a body, two valves across it with a stick on each, a column with an arm: the last two parts."""
    parts = [box((-0.15, -0.1, 0.0), (0.15, 0.1, 0.01)), upright((0.0, 0.0, 0.01), 0.022, 0.04)]
    for x in (-0.06, 0.02) if valves else ():
        points, faces = disc((0.0, 0.0, 0.0), 0.012, 0.04)
        parts.append((points[:, [1, 0, 2]] + np.array([x, 0.0, 0.035]), faces[:, ::-1]))
    parts += [upright((x, 0.0, 0.04), 0.004, 0.05) for x in (-0.045, 0.045)[:sticks]]
    return [*parts, upright((0.0, 0.0, 0.05), 0.015, 0.2), box((-0.015, -0.18, 0.24), (0.015, 0.015, 0.27))]


PLATE = box((-0.06, 0.0, -0.04), (0.06, 0.008, 0.04))


def rocker(x: float, z: float = 0.0) -> Part:
    return box((x - 0.015, -0.004, z - 0.022), (x + 0.015, -0.0002, z + 0.022))


def plain_door(*more: Part) -> list[Part]:
    return [*carcass(0.6, 0.55, 0.62), box((0.003, -0.02, 0.01), (0.597, -0.001, 0.61)), *more]


# A skin, a core, a liner with a bin on it, and a handle, before a carcass with a shelf.
FRIDGE_DOOR = [
    *carcass(0.6, 0.6, 1.2),
    box((0.0, -0.052, 0.0), (0.6, -0.05, 1.2)),
    box((0.001, -0.05, 0.001), (0.599, -0.005, 1.199)),
    box((0.04, -0.005, 0.04), (0.56, 0.006, 1.16)),
    *tub((0.06, 0.006, 0.5), (0.54, 0.07, 0.58)),
    *bar((0.54, -0.1, 0.4), (0.552, -0.09, 0.9), -0.052),
    box((0.02, 0.15, 0.6), (0.58, 0.55, 0.61)),
]
# A carcass with a shelf (5), two doors (6, 7), their handles, and a wide front below, which is the last.
PAIR_OVER_DRAWER = [
    *carcass(0.9, 0.6, 1.6),
    box((0.02, 0.0, 0.48), (0.88, 0.6, 0.5)),
    *(box((x, -0.02, 0.5), (x + 0.445, 0.0, 1.6)) for x in (0.0, 0.455)),
    *(b for x in (0.42, 0.47) for b in bar((x, -0.06, 0.9), (x + 0.012, -0.05, 1.2), -0.02)),
    box((0.0, -0.02, 0.0), (0.9, 0.0, 0.49)),
]
# Two wide fronts with handles, and a shelf right behind each.
SHALLOW_WITH_SHELVES = carcass(0.8, 0.3, 0.6)
for z in (0.0, 0.31):
    SHALLOW_WITH_SHELVES.append(box((0.0, -0.02, z), (0.8, 0.0, z + 0.29)))
    SHALLOW_WITH_SHELVES += bar((0.3, -0.06, z + 0.2), (0.5, -0.05, z + 0.212), -0.02)
SHALLOW_WITH_SHELVES += [box((0.02, 0.01, z), (0.78, 0.28, z + 0.012)) for z in (0.15, 0.46)]
# A burner under a grate of four bars.
BURNER = [
    lying(disc((0.3, -0.06, 0.3), 0.03, 0.03)),
    *(box((0.15, y, 0.058), (0.45, y + 0.012, 0.07)) for y in (0.25, 0.338)),
    *(box((x, 0.15, 0.058), (x + 0.012, 0.45, 0.07)) for x in (0.25, 0.338)),
]
# A shell, its face, and six keys on it.
REMOTE = [
    box((-0.03, 0.001, -0.1), (0.03, 0.02, 0.1)),
    box((-0.03, -0.002, -0.1), (0.03, 0.0, 0.1)),
    *(box((x, -0.004, z), (x + 0.012, -0.0021, z + 0.01)) for x in (-0.022, 0.008) for z in (-0.05, 0.0, 0.05)),
]
MACHINE = [box((0, 0.1, 0), (0.2, 0.3, 0.25)), box((0, 0, 0.25), (0.2, 0.3, 0.38))]
BLOCK = box((0, 0, 0), (0.5, 0.4, 0.3))
WASHING_MACHINE = [
    box((0, 0, 0), (0.6, 0.55, 0.85)),
    disc((0.3, -0.04, 0.4), 0.18, 0.039, 32),
    disc((0.3, -0.05, 0.4), 0.12, 0.009, 32),
    box((0.02, -0.01, 0.73), (0.17, -0.001, 0.83)),
    disc((0.33, -0.03, 0.78), 0.03, 0.029),
]
# A low front with a level handle at its top (5, 7 to 9) under a panel (6).
FLAP = [
    *carcass(0.6, 0.5, 0.55),
    box((0.0, -0.02, 0.0), (0.6, 0.0, 0.45)),
    box((0.0, -0.02, 0.46), (0.6, 0.0, 0.55)),
    box((0.05, -0.07, 0.4), (0.55, -0.05, 0.415)),
    *(box((x, -0.05, 0.4), (x + 0.02, -0.02, 0.415)) for x in (0.05, 0.53)),
]
UPRIGHT_HANDLE = [box((0.54, -0.06, 0.1), (0.56, -0.045, 0.5))]
UPRIGHT_HANDLE += [box((0.545, -0.045, z), (0.555, -0.02, z + 0.01)) for z in (0.11, 0.48)]
RODS = [box((0.03, 0.05 + 0.05 * k, 0.25), (0.57, 0.054 + 0.05 * k, 0.254)) for k in range(8)]
RODS += [box((x, 0.04, 0.254), (x + 0.004, 0.44, 0.258)) for x in (0.03, 0.298, 0.566)]
LOOP = [box((0.06, y, 0.25), (0.54, y + 0.006, 0.256)) for y in (0.06, 0.42)]
LOOP += [box((x, 0.066, 0.25), (x + 0.006, 0.42, 0.256)) for x in (0.06, 0.534)]
INNER_BLOCK = box((0.05, 0.06, 0.03), (0.45, 0.45, 0.2))


def spans(numbers: Sequence[int]) -> str:
    """Ascending numbers as ranges, such as 5-8 11."""
    found: list[list[int]] = []
    for n in sorted(set(numbers)):
        if found and n == found[-1][1] + 1:
            found[-1][1] = n
        else:
            found.append([n, n])
    return " ".join(str(a) if a == b else f"{a}-{b}" for a, b in found)


def described(parts: Sequence[PartPlan], owner: Ints) -> str:
    """All parts, such as `door 5-8 by 6-8 hinge left 0..90; knob 9/10 turns -y`.

    Of each its solids, its grip, and how far it goes: degrees or percent of the diagonal. Alike ones are one.
    """
    lines: dict[tuple[str, str], str] = {}
    for part in parts:
        joint, axis = part.joint, np.array(part.joint.axis)
        way = joint.edge.value if joint.edge else axis_name(axis) if np.abs(axis).max() > 0.999 else "askew"
        low, high = (round(v * (100 if joint.kind is JointKind.SLIDE else 180 / np.pi)) for v in joint.range)
        motion = f"turns {way}" if joint.endless else f"{joint.kind.value} {way} {low}..{high}"
        solids, grip = (spans(owner[rows].tolist()) for rows in (part.faces, part.grip))
        key = part.kind.value, (f"by {grip} " if 0 < len(part.grip) < len(part.faces) else "") + motion
        lines[key] = f"{lines[key]}/{solids}" if key in lines else solids
    return "; ".join(f"{kind} {solids} {motion}" for (kind, motion), solids in lines.items())


def scene(moves: str, *parts: Part, category: str = "") -> tuple[str, Sequence[Part], str]:
    return moves, parts, category


# Name: what moves, and the solids.
SCENES: dict[str, tuple[str, Sequence[Part], str]] = {
    # Fronts
    "a flap with a level handle at its top folds down": scene("door 5 7-9 by 7-9 hinge bottom 0..90", *FLAP),
    "a door of boards is one door": scene(
        "door 5-10 by 10 hinge left 0..90",
        *carcass(0.5, 0.4, 0.7),
        *(box((x, -0.02, 0.0), (x + 0.07, 0.0, 0.7)) for x in (0.0, 0.43)),
        *(box((0.07, -0.02, z), (0.43, 0.0, z + 0.07)) for z in (0.0, 0.63)),
        box((0.07, -0.016, 0.07), (0.43, -0.012, 0.63)),
        box((0.455, -0.05, 0.3), (0.47, -0.02, 0.45)),
    ),
    "a door takes its core, its liner and the bins on it": scene("door 5-15 by 13-15 hinge left 0..90", *FRIDGE_DOOR),
    "a door flush in a frame of the body leaves the frame": scene(
        "door 9-12 by 10-12 hinge left 0..90",
        *carcass(0.6, 0.5, 0.8),
        *(box((x, -0.02, 0.0), (x + 0.05, 0.0, 0.8)) for x in (0.0, 0.55)),
        *(box((0.05, -0.02, z), (0.55, 0.0, z + 0.05)) for z in (0.0, 0.75)),
        box((0.053, -0.02, 0.053), (0.547, 0.0, 0.747)),
        *bar((0.5, -0.06, 0.3), (0.512, -0.05, 0.5), -0.02),
    ),
    "a drawer over an open floor takes its box": scene(
        "drawer 4-12 by 5-7 slide -y 0..45",
        *(p for i, p in enumerate(carcass(0.5, 0.5, 0.4)) if i != 2),
        box((0.0, -0.02, 0.1), (0.5, 0.0, 0.38)),
        *bar((0.15, -0.06, 0.25), (0.35, -0.05, 0.262), -0.02),
        *tub((0.03, 0.0, 0.12), (0.47, 0.45, 0.3)),
    ),
    "a basin that one looks into stays behind a false front": scene(
        "",
        *(p for i, p in enumerate(carcass(0.6, 0.5, 0.7)) if i != 3),
        box((0.0, -0.02, 0.5), (0.6, 0.0, 0.7)),
        *tub((0.1, 0.01, 0.52), (0.5, 0.45, 0.7)),
    ),
    "a tub behind a door is a drawer of its own": scene(
        "door 5-8 by 6-8 hinge left 0..90; drawer 9-13 slide -y 0..30",
        *carcass(0.5, 0.5, 0.9),
        box((0.0, -0.02, 0.0), (0.5, 0.0, 0.9)),
        *bar((0.44, -0.06, 0.4), (0.452, -0.05, 0.6), -0.02),
        *tub((0.03, 0.02, 0.1), (0.47, 0.45, 0.25)),
    ),
    "a rack of rods slides and a shelf between walls does not": scene(
        "door 5-8 by 6-8 hinge bottom 0..90; tray 10-20 slide -y 0..34",
        *oven(box((0.02, 0.02, 0.12), (0.58, 0.48, 0.13)), *RODS),
    ),
    "the loop of a heating element is no rack": scene("door 5-8 by 6-8 hinge bottom 0..90", *oven(*LOOP)),
    "a turntable turns behind a door": scene(
        "door 5-6 by 6 hinge left 0..90; tray 7 turns +z",
        *carcass(0.5, 0.4, 0.3),
        box((0.0, -0.02, 0.0), (0.5, 0.0, 0.3)),
        box((0.46, -0.05, 0.05), (0.475, -0.02, 0.25)),
        lying(disc((0.25, -0.05, 0.2), 0.14, 0.01)),
    ),
    "a shelf right behind a wide front makes it a door": scene(
        "door 5-8 by 6-8 hinge bottom 0..90; door 9-12 by 10-12 hinge bottom 0..90", *SHALLOW_WITH_SHELVES
    ),
    "a door in a niche twice as wide runs sideways": scene(
        "door 5-8 by 6-8 slide +x 0..39",
        *carcass(1.0, 0.3, 0.5),
        box((0.02, 0.1, 0.02), (0.5, 0.12, 0.48)),
        *bar((0.1, 0.06, 0.15), (0.112, 0.07, 0.35), 0.1),
    ),
    "a plate on a closed block is no door": scene(
        "", box((0, 0, 0), (0.6, 0.5, 0.5)), box((0.02, -0.02, 0.02), (0.58, 0.0, 0.48))
    ),
    "a block with a front of its own behind a door is a drawer": scene(
        "door 5-8 by 6-8 hinge left 0..90; drawer 9-10 slide -y 0..23",
        *tall_door(INNER_BLOCK, box((0.05, 0.04, 0.03), (0.45, 0.058, 0.2))),
    ),
    "a bare block behind a door is none": scene("door 5-8 by 6-8 hinge left 0..90", *tall_door(INNER_BLOCK)),
    "a wide front under a pair of doors is a drawer": scene(
        "door 6 8-10 by 8-10 hinge left 0..90; door 7 11-13 by 11-13 hinge right 0..90; drawer 14 slide -y 0..24",
        *PAIR_OVER_DRAWER,
    ),
    "closed blocks of one size in a column are drawers": scene(
        "drawer 6/5/7 slide -y 0..40",
        *carcass(0.5, 0.5, 0.62),
        *(box((0.02, -0.02, z), (0.48, 0.45, z + 0.18)) for z in (0.025, 0.215, 0.405)),
    ),
    "a dishwasher opens downwards": scene("door 5 hinge bottom 0..90", *plain_door(), category="dishwasher"),
    "so does a wall oven": scene("door 5 hinge bottom 0..90", *plain_door(), category="wall_oven"),
    "a microwave opens to the left": scene("door 5 hinge left 0..90", *plain_door(), category="microwave"),
    "an upright handle at one side beats the kind": scene(
        "door 5-8 by 6-8 hinge left 0..90", *plain_door(*UPRIGHT_HANDLE), category="wall_oven"
    ),
    "a washing machine has a round door, a drawer and a knob": scene(
        "door 1-2 hinge left 0..90; drawer 3 slide -y 0..35; knob 4 turns -y", *WASHING_MACHINE
    ),
    "a control panel over a door is no front": scene(
        "door 11 hinge bottom 0..90; knob 6/7/8/9/10 turns -y",
        *carcass(0.6, 0.55, 0.6),
        box((0.0, -0.02, 0.5), (0.6, -0.001, 0.6)),
        *(disc((x, -0.04, 0.55), 0.018, 0.019) for x in (0.1, 0.2, 0.3, 0.4, 0.5)),
        box((0.0, -0.02, 0.01), (0.6, -0.001, 0.497)),
    ),
    "a microwave has a door, a knob and four buttons": scene(
        "door 5-6 by 6 hinge left 0..90; button 10/12/9/11 slide +y 0..0; knob 8 turns -y", *solids_of(microwave())
    ),
    "drawers take their boxes and leave the carcass": scene(
        "drawer 5-10 by 6 slide -y 0..40; drawer 11-16 by 12 slide -y 0..40", *solids_of(drawers())
    ),
    # Controls
    "the one round thing on a front is the key of what somebody calls a machine": scene(
        "button 2 slide +y 0..0", *MACHINE, disc((0.1, -0.015, 0.31), 0.035, 0.015), category="coffee_machine"
    ),
    "a small panel with knobs and a lever is no door": scene(
        "knob 4/5 turns -y",
        box((0, 0, 0), (0.2, 0.15, 0.2)),
        box((0, 0.15, 0), (0.2, 0.3, 0.2)),
        box((0.06, -0.006, 0.05), (0.14, 0, 0.15)),
        box((0.08, -0.03, 0.13), (0.12, -0.006, 0.14)),
        *(disc((x, -0.016, 0.07), 0.008, 0.01) for x in (0.08, 0.12)),
    ),
    "a knob on a slope turns about the normal of its cap": scene(
        "knob 1/2/3 turns askew",
        BLOCK,
        *(tilted(disc((x, -0.018, 0.15), 0.02, 0.02), 15.0, (x, 0.0, 0.15)) for x in (0.1, 0.25, 0.4)),
    ),
    "octagonal bosses in a row over an oven door are knobs": scene(
        "door 5-6 by 6 hinge bottom 0..90; knob 8/9/10/11/12 turns -y",
        *carcass(0.6, 0.55, 0.7),
        box((0.0, -0.03, 0.0), (0.6, -0.0005, 0.58)),
        box((0.06, -0.07, 0.52), (0.54, -0.0305, 0.54)),
        box((0.0, -0.03, 0.59), (0.6, -0.0005, 0.7)),
        *(disc((0.08 + 0.11 * k, -0.055, 0.645), 0.022, 0.0249, 8) for k in range(5)),
    ),
    "pulls of drawers are no controls": scene(
        "drawer 5 8 by 8 slide -y 0..37; drawer 6 9 by 9 slide -y 0..37; drawer 7 10 by 10 slide -y 0..37",
        *carcass(0.5, 0.45, 0.61),
        *(box((0.005, -0.02, 0.01 + 0.2 * k), (0.495, -0.0005, 0.195 + 0.2 * k)) for k in range(3)),
        *(disc((0.25, -0.045, 0.1 + 0.2 * k), 0.015, 0.0249, 16) for k in range(3)),
    ),
    "a pin is pushed and a knob is turned": scene(
        "button 1 slide +y 0..0; knob 2 turns -y",
        BLOCK,
        disc((0.15, -0.02, 0.15), 0.012, 0.06),
        disc((0.35, -0.02, 0.15), 0.02, 0.03),
    ),
    "a short pin on a top is pressed": scene(
        "button 1 slide -z 0..0", box((0.0, 0.0, 0.0), (0.3, 0.3, 0.2)), upright((0.08, 0.1, 0.2), 0.006, 0.02)
    ),
    "a long one is not": scene("", box((0.0, 0.0, 0.0), (0.3, 0.3, 0.2)), upright((0.08, 0.1, 0.2), 0.006, 0.06)),
    "burners under grates are no knobs": scene("knob 1/2/3/4 turns +z", *hob(*BURNER)),
    "what stands on a plate of a toaster is its lever and its knob": scene(
        "lever 9 slide -z 0..17; knob 10 turns -y",
        *toaster(
            box((0.22, -0.006, 0.02), (0.38, 0.0, 0.23)),
            box((0.275, -0.03, 0.19), (0.325, -0.006, 0.21)),
            disc((0.3, -0.03, 0.06), 0.02, 0.024),
        ),
    ),
    "a painted slot makes a block at its end a lever": scene(
        "lever 2 slide +z 0..22",
        box((0.0, 0.0, 0.0), (0.2, 0.3, 0.25)),
        box((0.09, -0.0001, 0.08), (0.11, 0.0, 0.18)),
        box((0.07, -0.02, 0.05), (0.13, -0.0001, 0.08)),
    ),
    "rockers tilt about a level axis": scene("lever 1/2 hinge +x -9..9", PLATE, rocker(-0.025), rocker(0.025)),
    "a stick on a plate is a toggle": scene(
        "lever 1 hinge +x -29..29", PLATE, box((-0.003, -0.02, -0.006), (0.003, -0.0002, 0.006))
    ),
    "a round one is a dimmer": scene("knob 1 turns -y", PLATE, disc((0.0, -0.015, 0.0), 0.018, 0.0148)),
    "pieces off the middle are no switches": scene("", PLATE, rocker(-0.025, 0.015), rocker(0.025, 0.015)),
    "nor are pieces of two sizes": scene("", PLATE, rocker(-0.025), box((0.02, -0.004, -0.01), (0.03, -0.0002, 0.01))),
    "the leaf of a cupboard is no plate": scene(
        "door 5-6 by 6 hinge right 0..90",
        *carcass(0.5, 0.4, 0.6),
        box((0.0, -0.02, 0.0), (0.5, -0.0002, 0.6)),
        box((0.24, -0.05, 0.28), (0.26, -0.0202, 0.32)),
    ),
    "the face of a remote control is no door": scene("button 4/7/3/6/2/5 slide +y 0..0", *REMOTE),
    "a stick turns with its valve, and the spout beside it about its column": scene(
        "lever 2 4 hinge -x 0..90; lever 3 5 hinge +x 0..90; spout 6-7 hinge +z -90..90", *faucet()
    ),
    "no spout without sticks": scene("", *faucet(0, False)),
    # Lids
    "a round cover with a knob is a lid that opens upwards": scene(
        "lid 1-2 by 2 hinge -x 0..90",
        box((0, 0, 0), (0.3, 0.3, 0.2)),
        lying(disc((0.15, -0.215, 0.15), 0.1, 0.015)),
        lying(disc((0.15, -0.24, 0.15), 0.015, 0.025)),
    ),
    "a lid hinges at the back": scene("lid 1-2 by 2 hinge -x 0..90", *kettle(False, False)),
    "and stops before the bail over it": scene("lid 1-2 by 2 hinge +y 0..45", *kettle(True, False)),
    "or at the handle": scene("lid 1-2 by 2 hinge +y 0..90", *kettle(False, True)),
    "what covers a hollow box is hinged at its back": scene("lid 5 hinge -x 0..90", *chest(COVER)),
    "a lid is hinged opposite to its lock": scene(
        "lid 5 hinge +x 0..90", *chest(COVER, box((-0.03, 0.2, 0.27), (0.03, 0.22, 0.33)))
    ),
    "an open box has no lid": scene("", *chest()),
    "nor has a table": scene(
        "", *(box((x, y, 0.0), (x + 0.04, y + 0.04, 0.3)) for x in (-0.4, 0.36) for y in (-0.2, 0.16)), COVER
    ),
    "a plate with several knobs is no lid": scene(
        "door 3 hinge bottom 0..90; knob 6/7/8 turns +z",
        *chest(
            box((-0.4, -0.2, 0.3), (0.4, 0.2, 0.32)),
            *(upright((x, -0.12, 0.32), 0.025, 0.03) for x in (-0.2, 0.0, 0.2)),
        ),
    ),
    "a bin with a pedal opens away from it": scene("lid 1 hinge -x 0..90", *ROUND_BIN, PEDAL),
    "without a pedal its lid is screwed on": scene("", *ROUND_BIN),
}


@pytest.mark.parametrize("name", SCENES)
def test_what_moves_and_how(name: str) -> None:
    moves, parts, category = SCENES[name]
    found, owner = found_in(parts, category)
    assert described(found.parts, owner) == moves


def plans_of(name: str, kind: PartKind) -> tuple[Articulation, list[PartPlan]]:
    found, _ = found_in(*SCENES[name][1:])
    return found, [p for p in found.parts if p.kind is kind]


def test_where_and_about_what_things_turn() -> None:
    found, (door,) = plans_of("a microwave has a door, a knob and four buttons", PartKind.DOOR)
    anchor = found.frame.to_file(np.array([door.joint.anchor]))[0]
    assert anchor[0] == pytest.approx(0.0, abs=1e-6)
    assert -0.005 <= anchor[1] <= 0.0, "near the back of the door"
    far = np.array([0.37, -0.01, 0.15]) - anchor
    assert np.cross(found.frame.direction_to_file(door.joint.axis), far)[1] < 0
    found, (lid,) = plans_of("what covers a hollow box is hinged at its back", PartKind.LID)
    assert found.frame.to_file(np.array([lid.joint.anchor]))[0][1:] == pytest.approx((0.2, 0.3), abs=1e-3)
    assert plans_of("or at the handle", PartKind.LID)[1][0].joint.anchor[0] > 0.1
    for knob in plans_of("a knob on a slope turns about the normal of its cap", PartKind.KNOB)[1]:
        slope = np.radians(15.0)
        assert np.abs(np.array(knob.joint.axis) @ [0, -np.cos(slope), -np.sin(slope)]) > 0.9999
    tap = "a stick turns with its valve, and the spout beside it about its column"
    found, (spout,) = plans_of(tap, PartKind.SPOUT)
    assert spout.joint.anchor[0] == pytest.approx(-found.frame.origin[0] * found.frame.scale, abs=1e-6)
    for lever in plans_of(tap, PartKind.LEVER)[1]:
        at = np.array(lever.joint.anchor) / found.frame.scale + np.array(found.frame.origin)
        assert at[1:] == pytest.approx((0.0, 0.035), abs=1e-6)


# What has no moving part: boxes with creases, furniture without doors, books, garbage.


def noisy(solid: manifold3d.Manifold, spread: float) -> Part:
    """A solid of many faces whose points are off, as those of a scan."""
    points, faces = shape_of(solid.refine_to_length(0.04))
    return points + np.random.default_rng(0).normal(0.0, spread, points.shape), faces


def carton(crease: float) -> list[Part]:
    """A scanned box: one skin, uneven by a millimetre or two, with a step round it where its lid ends."""
    points, faces = shape_of(manifold3d.Manifold.cube((2, 2, 2), True).refine(27))
    bump = np.random.default_rng(3).normal(0.0, 0.006, points.shape)
    lid = np.where(points[:, 2:] > 0.6, crease, 0.0) * np.array([1.0, 1.0, 0.0])
    return [((points * (1.0 + lid) + bump) * np.array([0.11, 0.07, 0.09]), faces)]


def rubble() -> list[Part]:
    """Triangles that make nothing."""
    rng = np.random.default_rng(5)
    middles = rng.uniform(-1, 1, (300, 1, 3))
    return [((middles + rng.normal(0, 0.1, (300, 3, 3))).reshape(-1, 3), np.arange(900).reshape(-1, 3))]


SOLID = manifold3d.Manifold
CHAIR = [
    box((0, 0, 0.43), (0.4, 0.4, 0.45)),
    *(box((x, y, 0.0), (x + 0.04, y + 0.04, 0.43)) for x in (0.0, 0.36) for y in (0.0, 0.36)),
    *(box((x, 0.36, 0.45), (x + 0.04, 0.4, 0.9)) for x in (0.0, 0.36)),
    box((0.04, 0.37, 0.7), (0.36, 0.39, 0.88)),
]
BOOKCASE = [
    *(box((x, 0, 0), (x + 0.02, 0.28, 1.72)) for x in (0.0, 0.78)),
    box((0.02, 0.27, 0.02), (0.78, 0.28, 1.7)),
    *(box((0.02, 0, z), (0.78, 0.28, z + 0.02)) for z in np.linspace(0.0, 1.7, 6)),
]
BOOK = [
    *(box((0, 0, z), (0.15, 0.21, z + 0.003)) for z in (0.0, 0.027)),
    box((0, 0, 0.003), (0.003, 0.21, 0.027)),
    box((0.003, 0.003, 0.003), (0.147, 0.207, 0.027)),
]
TABLE = [box((0, 0, 0.7), (1.2, 0.7, 0.74))]
TABLE += [box((x, y, 0.0), (x + 0.05, y + 0.05, 0.7)) for x in (0.05, 1.1) for y in (0.05, 0.6)]
STILL: dict[str, list[Part]] = {
    "cube": [box((0, 0, 0), (1, 1, 1))],
    "two blocks": [box((0, 0, 0), (1, 1, 0.6)), box((0, 0, 0.6), (1, 1, 1))],
    "carton": carton(0.0),
    "carton with a lid": carton(0.03),
    "table": TABLE,
    "chair": CHAIR,
    "bookcase": BOOKCASE,
    "book": BOOK,
    "can": [upright((0, 0, 0), 0.033, 0.115), upright((0, 0, 0.115), 0.03, 0.002)],
    "rubble": rubble(),
    "scan of a cube": [noisy(SOLID.cube((1, 1, 1)), 0.003)],
    "scan of a carton": [noisy(SOLID.cube((0.6, 0.4, 0.8)), 0.001)],
    "scan of a fruit": [noisy(SOLID.sphere(0.5, 48), 0.004)],
    "scan of a bottle": [noisy(SOLID.cylinder(1.0, 0.3, 0.2, 48), 0.002)],
}


@pytest.mark.parametrize("name", STILL)
def test_what_does_not_move_is_given_no_part(name: str) -> None:
    mesh = weld_triangles(*together(*STILL[name])[:2])
    frame = guess_frame(mesh)
    assert not articulate_fragmentation(fragments_of(mesh.in_frame(frame)), frame).parts


# What speaks for moving parts of a mesh in which none was found.

CASE = box((0.0, 0.0, 0.0), (0.6, 0.5, 0.8))
WINDOW = box((0.0, 0.0, 0.0), (0.8, 0.06, 1.2))
POST, HUB = disc((0.0, 0.0, 0.0), 0.04, 0.3), disc((0.0, -0.08, 0.0), 0.08, 0.08)
PAN = [disc((0.0, 0.0, 0.0), 0.12, 0.01), disc((0.0, -0.05, 0.0), 0.14, 0.05)]
MUG = [disc((0.0, 0.0, 0.0), 0.04, 0.1, 48), box((0.04, 0.03, -0.005), (0.07, 0.07, 0.005))]


def sash(low: float, high: float) -> Part:
    return box((0.06, -0.01, low), (0.74, 0.02, high))


# The sign, the solids, what somebody calls the thing, and names in its file.
SIGNS: list[tuple[str, list[Part], str, tuple[str, ...]]] = [
    ("", [CASE], "", ()),
    ("", [CASE], "table", ("Cube.001", "Material")),
    ("wardrobe", [CASE], "wardrobe", ()),
    ("door, knob", [CASE], "", ("Door_L", "DoorKnobs")),
    ("right side stands out like a handle", [CASE, box((0.6, 0.2, 0.3), (0.64, 0.22, 0.55))], "", ()),
    ("", MUG, "", ("mug_handle",)),
    ("a lever stands out", [POST, HUB, box((-0.02, -0.06, 0.07), (0.02, -0.02, 0.45))], "", ()),
    ("", [POST, HUB], "", ()),
    ("", [*PAN, box((-0.015, -0.04, 0.139), (0.015, -0.02, 0.35))], "", ()),
    ("sashes of a window", [WINDOW, sash(0.05, 0.6), sash(0.62, 1.15)], "", ()),
]


def test_what_speaks_for_parts_that_were_not_found() -> None:
    for sign, parts, kind, names in SIGNS:
        signs = signs_of_parts(in_its_frame(*together(*parts)[:2])[0], kind, names, load_models())
        assert sign in "; ".join(signs)
        assert bool(signs) is bool(sign), (kind, names, signs)
    signs = signs_of_parts(in_its_frame(*together(WINDOW, sash(0.05, 1.15))[:2])[0], "", (), load_models())
    assert "sashes" not in "; ".join(signs), "a picture in its frame"
