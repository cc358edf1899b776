"""Infill of framed fronts: flat, raised and beaded panels, louvres, panes and glazing bars."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.blocks import board, box
from casa_assets.families.kit.solids.loft import loft
from casa_assets.families.kit.solids.slab import offset_sides
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import mitred_frame, prism
from casa_assets.model.record import Vec3

UPRIGHT: Vec3 = (0.0, 0.0, 1.0)
ACROSS: Vec3 = (1.0, 0.0, 0.0)
PANEL_TONGUE = 0.005  # metres by which a panel sits in the groove of its frame
GLAZING_BAR_WIDTH = 0.018  # width of glazing bars


@dataclass(frozen=True)
class FrameOpening:
    """A hole in a frame, front's frame, metres; where `rise` is not 0 its top is an arc that rises by that much."""

    x0: float
    z0: float
    x1: float
    z1: float
    rise: float = 0.0

    @property
    def width(self) -> float:
        """Metres."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """Metres, in its middle."""
        return self.z1 - self.z0

    def outline(self, grown: float = 0.0) -> Floats:
        """(N, 2) points x, z, counter-clockwise, moved outwards by metres."""
        top = arc(self.x0, self.x1, self.z1, self.rise)[::-1] if self.rise else [(self.x1, self.z1), (self.x0, self.z1)]
        loop = np.array([(self.x0, self.z0), (self.x1, self.z0), *top])
        return offset_sides(loop, [-grown] * len(loop)) if grown else loop


def arc(x0: float, x1: float, top: float, rise: float, steps: int = 14) -> list[tuple[float, float]]:
    """(x, z) points of a circle's arc from left to right that is highest, at `top`, in the middle."""
    half = (x1 - x0) / 2
    radius = (half * half + rise * rise) / (2 * rise)
    reach = math.asin(half / radius)
    turns = np.linspace(-reach, reach, steps + 1)
    middle = (x0 + x1) / 2
    return [(float(middle + radius * math.sin(a)), float(top - radius * (1 - math.cos(a)))) for a in turns]


def flat_panel(o: FrameOpening, recess: float) -> Solid:
    """A flat panel behind the face by `recess`."""
    e = PANEL_TONGUE
    return board((o.x0 - e, recess, o.z0 - e), (o.x1 + e, recess + 0.008, o.z1 + e), 0.0)


def raised_panel(o: FrameOpening, t: float) -> Solid:
    """A panel whose middle field is raised above bevelled edges."""
    outline = o.outline(PANEL_TONGUE)
    bevel = min(0.038, 0.28 * min(o.width, o.height))
    steps = [
        (0.0, t - 0.004),
        (0.0, 0.0115),
        (PANEL_TONGUE + 0.006, 0.011),
        (PANEL_TONGUE + bevel, 0.0045),
        (PANEL_TONGUE + bevel + 0.0004, 0.0028),
        (PANEL_TONGUE + bevel + 0.0016, 0.002),
    ]
    rings = []
    for inset, y in steps:
        loop = offset_sides(outline, [inset] * len(outline)) if inset else outline
        rings.append(np.column_stack([loop[:, 0], np.full(len(loop), y), loop[:, 1]]))
    return loft(rings, 20.0)


def frame_moulding(o: FrameOpening) -> list[Solid]:
    """The moulding round the inside of a frame; none along an arc."""
    if o.rise:
        return []
    turns = np.linspace(0.0, math.pi / 2, 5)
    round_ = [(-0.0085 * math.sin(a), -0.0015 - 0.008 * (1 - math.cos(a))) for a in turns]
    profile = np.array([(0.002, -0.013), (0.002, -0.0015), *round_, (-0.0085, -0.013)])
    middle = ((o.x0 + o.x1) / 2, (o.z0 + o.z1) / 2)
    return [mitred_frame(o.width, o.height, profile).translated(middle[0], 0.0, middle[1])]


def beaded_panel(o: FrameOpening) -> Solid:
    """Narrow boards with a bead at each joint."""
    x0, x1 = o.x0 - PANEL_TONGUE, o.x1 + PANEL_TONGUE
    width = x1 - x0
    count = max(2, round(width / 0.045))
    pitch = width / count
    line: list[tuple[float, float]] = [(0.0, 0.0)]
    for k in range(1, count):
        x = k * pitch
        bead = [(x + 0.0032 - 0.0032 * math.cos(a), 0.0018 - 0.0018 * math.sin(a)) for a in np.linspace(0, math.pi, 5)]
        line += [(x - 0.0022, 0.0), (x - 0.0008, 0.0028), (x, 0.0024), *bead[1:-1], (x + 0.0064, 0.0024)]
        line += [(x + 0.0072, 0.0028), (x + 0.0086, 0.0)]
    line.append((width, 0.0))
    outline = np.concatenate([np.array(line), [(width, 0.006), (0.0, 0.006)]])
    solid = prism(outline, o.height + 2 * PANEL_TONGUE, 0.0)
    return solid.translated(x0, 0.008, o.z0 - PANEL_TONGUE)


def v_groove_line(width: float, pitch: float, half: float, depth: float) -> Floats:
    """(N, 2) front line x, y of a board with V grooves, from left to right."""
    count = max(2, round(width / pitch))
    line: list[tuple[float, float]] = [(0.0, 0.001), (0.001, 0.0)]
    for k in range(1, count):
        x = width * k / count
        line += [(x - half, 0.0), (x, depth), (x + half, 0.0)]
    return np.array([*line, (width - 0.001, 0.0), (width, 0.001)])


def reeded_line(width: float, pitch: float, depth: float) -> Floats:
    """(N, 2) front line x, y of a row of half-round reeds, from left to right."""
    count = max(3, round(width / pitch))
    step = width / count
    line = [(0.0, depth)]
    for k in range(count):
        for a in np.linspace(0.0, math.pi, 7)[1:-1]:
            line.append((step * (k + (1 - math.cos(a)) / 2), depth * (1 - math.sin(a))))
        line.append((step * (k + 1), depth))
    return np.array(line)


def louvres(o: FrameOpening, t: float) -> list[Solid]:
    """Louvres that slope down to the front and hide what is behind them."""
    tilt = math.radians(52)
    length = (t - 0.005) / math.cos(tilt)
    count = max(2, math.ceil(o.height / (0.92 * length * math.sin(tilt))))
    pitch = o.height / count
    slat = box((o.width + 0.006, length, 0.005), (0.0, 0.0, 0.0), 0.002).rotated("x", tilt)
    middle = (o.x0 + o.x1) / 2
    return [slat.translated(middle, t / 2, o.z0 + (k + 0.5) * pitch) for k in range(count)]


def glass_pane(o: FrameOpening, y: float, thickness: float = 0.004) -> Solid:
    """A sheet of glass whose middle plane is at y."""
    e = PANEL_TONGUE
    return board((o.x0 - e, y - thickness / 2, o.z0 - e), (o.x1 + e, y + thickness / 2, o.z1 + e), 0.0)


def glazing_beads(o: FrameOpening, t: float) -> list[Solid]:
    """Thin beads that hold a pane from before it."""
    y0, y1, width = 0.0035, t / 2 - 0.0024, 0.005
    out = [board((x, y0, o.z0), (x + width, y1, o.z1), 0.0008) for x in (o.x0, o.x1 - width)]
    inner = (o.x0 + width, o.x1 - width)
    return out + [board((inner[0], y0, z), (inner[1], y1, z + width), 0.0008) for z in (o.z0, o.z1 - width)]


def muntins(o: FrameOpening, t: float) -> list[tuple[Solid, Vec3]]:
    """Bars that divide a pane, before and behind it, with their grain."""
    columns = max(1, round(o.width / 0.2))
    rows = max(2, round(o.height / 0.24))
    out: list[tuple[Solid, Vec3]] = []
    for k in range(1, columns):
        x = o.x0 + o.width * k / columns
        out.append(
            (
                board((x - GLAZING_BAR_WIDTH / 2, 0.002, o.z0), (x + GLAZING_BAR_WIDTH / 2, t - 0.002, o.z1), 0.003),
                UPRIGHT,
            )
        )
    for k in range(1, rows):
        z = o.z0 + o.height * k / rows
        out.append(
            (
                board((o.x0, 0.0024, z - GLAZING_BAR_WIDTH / 2), (o.x1, t - 0.0024, z + GLAZING_BAR_WIDTH / 2), 0.003),
                ACROSS,
            )
        )
    return out


def arched_rail(x0: float, x1: float, z: float, rise: float, top: float, t: float) -> Solid:
    """The upper rail of a frame above an arch: its sides reach down to z, the crown of the arch is at z + rise."""
    outline = np.array([*arc(x0, x1, z + rise, rise), (x1, top), (x0, top)])
    return prism(outline, t, 0.0008).rotated("x", math.pi / 2).translated(0.0, t, 0.0)
