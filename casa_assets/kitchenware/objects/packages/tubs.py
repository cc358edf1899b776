"""Tubs and cups under foil or a lid, rolls of foil and film; what a part of a package is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from casa_assets.ext.arrays import Floats
from casa_assets.ext.solids import Solid, concatenate, lathe
from casa_assets.kitchenware.objects.closed_surface import smooth_profile
from casa_assets.kitchenware.objects.packages.wrapping import (
    Outline,
    four_sides,
    ramp,
    round_sides,
    with_front_picture,
    wrapped,
)

if TYPE_CHECKING:
    from casa_assets.kitchenware.objects.packages.package import Package

# Part -----------------------------------------------------------------------------------------------------------------
# A solid, its finish, what it is called, what it weighs.


@dataclass(frozen=True)
class Part:
    """A part of a package."""

    solid: Solid  # before the package is laid down: its bottom at z = 0, its front to -y
    finish: str  # id
    label: str
    density: float = 0.0  # kg/m^3; 0: no mass
    collider: bool = False  # it has a separate collision shape
    swings: bool = False  # it is on the link of the lid


# Tubs -----------------------------------------------------------------------------------------------------------------
# Tubs and cups of yoghurt, pudding and the like, under foil or a lid; rolls of foil and film.

FLANGE, FILM = 0.0012, 0.0006


def tub(p: Package) -> list[Part]:
    """A tub or a cup with a flange, closed by foil with a tongue to pull, or by a lid of plastic that snaps on."""
    outline = round_sides(40) if p.corner >= 1 else four_sides(p.front, p.side, 4)
    snaps = p.lid_rise > 0.003
    top = p.height - (p.lid_rise + FILM)
    profile = smooth_profile(p.profile, 13) if p.curved else np.array(p.profile)
    rings = np.stack([_ring(p, outline, share, 0.0, level * top) for share, level in profile])
    levels = profile[:, 1]
    rings[1:-1] = _fluted(p, outline, rings[1:-1])
    body = wrapped(rings, outline.sides, p.lower + (1 - p.lower - p.upper) * levels, crease_deg=35.0)
    parts = [Part(body, p.skin, "package", p.heft)]
    if p.content:
        filled = profile[levels < p.fill]
        size = np.interp(p.fill, levels, profile[:, 0])
        rows = [*filled, (size, p.fill)]
        inner = [_ring(p, outline, s, -0.0012, max(0.0012, level * top)) for s, level in rows]
        # The flutes go farther in than the content lies off the wall.
        rings = _fluted(p, outline, np.stack(inner))
        held = wrapped(rings, outline.sides, np.linspace(0, 1, len(rows)), crease_deg=35.0)
        parts.append(Part(held, p.content, "content"))
    flange = np.stack([_ring(p, outline, 1.0, p.flange, z) for z in (top - FLANGE, top - 0.0004)])
    parts.append(Part(wrapped(flange, outline.sides, ramp(0.0, 1.0), crease_deg=40.0), p.rim_finish, "rim"))
    parts += _snap_lid(p, outline, top) if snaps else _foil_lid(p, outline, top)
    return parts


def _ring(p: Package, outline: Outline, share: float, beyond: float, z: float) -> Floats:
    """A ring of the tub: share of the width, and metres beyond that."""
    half_x, half_y = share * p.width / 2 - p.flange + beyond, share * p.depth / 2 - p.flange + beyond
    return outline.ring(half_x, half_y, p.corner * min(half_x, half_y), z)


def _fluted(p: Package, outline: Outline, rings: Floats) -> Floats:
    """Rings with upright flutes, as cups of pudding have."""
    if p.flutes < 1:
        return rings
    turn = np.arctan2(outline.bent[:, 1], outline.bent[:, 0])
    moved = rings.copy()
    moved[..., :2] -= (0.03 * p.width * np.abs(np.sin(p.flutes * turn / 2))[:, None] ** 2) * outline.bent
    return moved


def _foil_lid(p: Package, outline: Outline, top: float) -> list[Part]:
    """Foil over the flange, a little domed, with a tongue at its right side."""
    rise, edge, small = p.lid_rise, p.flange + 0.0004, min(p.width, p.depth)
    steps = ((0.0, 0.0), (0.0, FILM), (0.06, FILM + 0.05 * rise), (0.35, FILM + 0.75 * rise), (0.75, FILM + rise))
    rings = [_ring(p, outline, 1.0, edge - shrink * small / 2, top + z) for shrink, z in steps]
    lid = wrapped(np.stack(rings), outline.sides, np.linspace(0, 1, 5), crease_deg=60.0)
    lid = with_front_picture(lid, (0.02, 0.02), (0.98, 0.98), (0, 1))
    tongue = p.tongue
    if tongue <= 0:
        return [Part(lid, p.lid, "lid")]
    turns = np.linspace(-np.pi / 2, np.pi / 2, 9)
    half = 0.75 * tongue
    inside = p.width / 2 - 0.35 * half
    end = [(p.width / 2 + (tongue - half) + half * np.cos(t), half * np.sin(t)) for t in turns]
    flat = np.array([(inside, -1.5 * half), *end, (inside, 1.5 * half)])
    # The tongue hangs down a little, seen from the flange on.
    droop = -0.45 * np.maximum(0.0, flat[:, 0] - p.width / 2)
    loops = [np.column_stack([flat, top + FILM * 0.2 + droop]), np.column_stack([flat, top + FILM * 1.05 + droop])]
    flap = wrapped(np.stack(loops), np.zeros((len(flat), 2, 2)), ramp(0.0, 1.0), crease_deg=50.0)
    flap = with_front_picture(flap.oriented_outwards(), (0.9, 0.45), (0.97, 0.55), (0, 1)).rotated("z", p.tongue_turn)
    return [Part(lid, p.lid, "lid"), Part(flap, p.lid, "lid")]


def _snap_lid(p: Package, outline: Outline, top: float) -> list[Part]:
    """A lid of plastic: a skirt over the flange, a ring on top, and within it a sunken field."""
    edge, rise = p.flange + 0.0009, p.lid_rise
    skirt = min(0.3 * p.height, 1.6 * rise)
    small = min(p.width, p.depth) / 2
    steps = ((0.0, FLANGE * -1.3 - 0.6 * skirt), (0.0, 0.6 * rise), (0.02, rise), (0.1, rise), (0.125, 0.45 * rise))
    rings = [_ring(p, outline, 1.0, edge - shrink * small, top + z) for shrink, z in steps]
    lid = wrapped(np.stack(rings), outline.sides, np.linspace(0, 1, 5), crease_deg=35.0)
    field = [_ring(p, outline, 1.0, edge - 0.14 * small, top + z) for z in (0.45 * rise - 0.0005, 0.45 * rise + 0.0004)]
    print_ = wrapped(np.stack(field), outline.sides, ramp(0.0, 1.0), crease_deg=40.0)
    print_ = with_front_picture(print_, (0.02, 0.02), (0.98, 0.98), (0, 1))
    return [Part(lid, p.fitting, "lid"), Part(print_, p.lid, "lid")]


def roll(p: Package) -> list[Part]:
    """A roll of foil, film or paper on a tube of cardboard; it lies, its end a little loose."""
    r, core = p.depth / 2, 0.28 * p.depth
    rim, high = r - 0.0006, p.height
    line = [(core, 0.0), (rim, 0.0), (r, 0.0006), (r, high - 0.0006), (rim, high), (core, high)]
    outer = lathe(line, 40, 40.0, closed=True)
    low, high, inner, wide = -0.004, p.height + 0.004, core - 0.0016, core - 0.0001
    tube = lathe([(inner, low), (wide, low), (wide, high), (inner, high)], 28, 40.0, closed=True)
    # The loose end of the sheet, which stands off more and more.
    turns = np.linspace(0.0, 0.5, 7)
    beyond = r + 0.0012 * turns + 0.0002
    loop = np.column_stack([beyond * np.sin(turns), beyond * np.cos(turns)])
    flat = np.concatenate([loop * (1 + 0.0005 / r), loop[::-1]])
    rows = [np.column_stack([flat, np.full(len(flat), z)]) for z in (0.002, p.height - 0.002)]
    flap = wrapped(np.stack(rows), np.zeros((len(flat), 2, 2)), ramp(0, 1), crease_deg=40.0).oriented_outwards()
    sheet = concatenate([outer, flap])
    return [
        Part(Solid(sheet.points, sheet.faces, crease_deg=40.0), p.skin, "roll", p.heft),
        Part(tube, "paper_kraft", "core"),
    ]
