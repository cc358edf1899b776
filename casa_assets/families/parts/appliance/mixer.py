"""Parts of stand mixers: the head, and the tools that hang from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.blocks import lathe, rod
from casa_assets.families.kit.solids.loft import loft
from casa_assets.families.kit.solids.solid import Solid, concatenate
from casa_assets.families.kit.solids.sweep import circle, rectangle, tube
from casa_assets.model.record import Vec3

UNDERSIDE_SHARE = 0.8  # share of half the height at which a section of the head is cut off below


class MixerTool(StrEnum):
    """Tool of a stand mixer."""

    WHISK = "whisk"
    BEATER = "beater"
    HOOK = "hook"


def head_section(y: float, width: float, height: float, middle: float, power: float, count: int = 28) -> Floats:
    """(N, 3) outline of the head in a plane across it, flat below; metres. `power` 2 is an ellipse, more is boxy."""
    turns = np.arange(count) * 2 * np.pi / count
    c, s = np.cos(turns), np.sin(turns)
    x = width / 2 * np.sign(c) * np.abs(c) ** (2 / power)
    z = height / 2 * np.sign(s) * np.abs(s) ** (2 / power)
    return np.column_stack([-x, np.full(count, y), middle + np.maximum(z, -UNDERSIDE_SHARE * height / 2)])


@dataclass(frozen=True)
class MixerHead:
    """A head from y = front to back, its flat underside on z = 0.

    Attributes:
        width, height: metres. nose_share: share of both that is left at the front. power: of its sections.
        bluntness: of its ends; 2 is a half ball, 8 nearly flat.
    """

    front: float
    back: float
    width: float
    height: float
    nose_share: float
    power: float
    bluntness: float

    @property
    def middle(self) -> float:
        """Height of the axis, metres."""
        return UNDERSIDE_SHARE * self.height / 2

    def scale(self, t: float) -> float:
        """Share of the full section at a share of its length from the front."""
        end = (1 - abs(2 * t - 1) ** self.bluntness) ** (1 / self.bluntness)
        return float(end * (1 - (1 - self.nose_share) * (1 - t) ** 1.6))

    def ring(self, t: float, more: float = 0.0, count: int = 28) -> Floats:
        """(N, 3) outline at a share of its length, wider all round by `more` metres."""
        k, y = self.scale(t), self.front + t * (self.back - self.front)
        return head_section(y, self.width * k + 2 * more, self.height * k + 2 * more, self.middle, self.power, count)


def head_solid(form: MixerHead) -> Solid:
    """The skin of a head."""
    shares = 0.5 - 0.5 * np.cos(np.linspace(0.04, math.pi - 0.04, 17))
    return loft([form.ring(float(t)) for t in shares], 50.0).oriented_outwards()


def head_band(form: MixerHead, y: float, length: float) -> Solid:
    """A strip around a head at y, `length` long in y, that projects by a millimetre. Metres."""
    shares = [(y + d - form.front) / (form.back - form.front) for d in (-length / 2, 0.0, length / 2)]
    return loft([form.ring(t, 0.001, 44) for t in shares], 50.0).oriented_outwards()


def tool_solid(kind: MixerTool, length: float) -> Solid:
    """Solid of a tool that hangs from z = 0 to -length on the axis x = y = 0, with a hull collider."""
    shaft = rod(0.0055, 0.034, 0.001).translated(z=-0.017)
    collar = lathe([(0.011, -0.036), (0.013, -0.033), (0.013, -0.027), (0.008, -0.024)], 20)
    tool = concatenate([shaft, collar, *_MAKERS[kind](length)])
    return tool.with_hull_collider()


def _whisk(length: float) -> list[Solid]:
    wires = []
    for k in range(5):
        turn = math.pi * k / 5
        path: list[Vec3] = []
        for t in np.linspace(0.0, 2 * math.pi, 19)[1:-1]:
            r = 0.043 * math.sin(t) * (1.0 - 0.3 * (1 + math.cos(t)) / 2)
            z = -0.03 - (length - 0.032) * (1 - math.cos(t)) / 2
            path.append((r * math.cos(turn), r * math.sin(turn), z))
        wires.append(tube(path, circle(0.0011, 6)).without_colliders())
    return wires


def _beater(length: float) -> list[Solid]:
    """A flat frame with ribs."""
    half_width, bottom = 0.041, -length
    loop: list[Vec3] = [
        (0.0, 0.0, -0.034),
        (half_width, 0.0, -0.05),
        (half_width, 0.0, bottom + 0.03),
        (0.004, 0.0, bottom + 0.003),
        (-0.004, 0.0, bottom + 0.003),
        (-half_width, 0.0, bottom + 0.03),
        (-half_width, 0.0, -0.05),
        (0.0, 0.0, -0.034),
    ]
    frame = tube(loop, rectangle(0.006, 0.0075, 0.002, 2), 0.006, up=(0.0, 1.0, 0.0)).without_colliders()
    rib = tube([(0.0, 0.0, -0.036), (0.0, 0.0, bottom + 0.004)], rectangle(0.005, 0.006, 0.0015, 2), up=(0.0, 1.0, 0.0))
    bar = tube(
        [(-half_width, 0.0, -0.068), (half_width, 0.0, -0.068)], rectangle(0.005, 0.006, 0.0015, 2), up=(0.0, 1.0, 0.0)
    )
    return [frame, rib.without_colliders(), bar.without_colliders()]


def _hook(length: float) -> list[Solid]:
    path: list[Vec3] = [(0.0, 0.0, -0.03)]
    for t in np.linspace(0.0, 1.0, 15):
        angle = 2 * math.pi * 0.9 * float(t)
        r = 0.034 * math.sin(math.pi * (0.15 + 0.75 * float(t)))
        path.append((r * math.cos(angle), r * math.sin(angle), -0.04 - (length - 0.046) * float(t)))
    return [tube(path, circle(0.0055, 10)).without_colliders()]


_MAKERS = {MixerTool.WHISK: _whisk, MixerTool.BEATER: _beater, MixerTool.HOOK: _hook}


def bowl_profile(base_radius: float, rim_radius: float, depth: float, steps: int = 9) -> list[tuple[float, float]]:
    """(radius, z) of a bowl's outside from its foot to its rim, metres; z from 0 to depth."""
    line = []
    for t in np.linspace(0.0, 1.0, steps):
        line.append(
            (float(base_radius + (rim_radius - base_radius) * math.sin(t * math.pi / 2) ** 0.8), float(depth * t))
        )
    return line


def radius_at(line: Sequence[tuple[float, float]], z: float) -> float:
    """Radius of a profile at a height, metres."""
    return float(np.interp(z, [b for _, b in line], [a for a, _ in line]))
