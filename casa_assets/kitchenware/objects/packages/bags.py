"""Packages of film: pillow bags, self-standing pouches, bars in wrappers, sweets in twisted paper."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from casa_assets.ext.arrays import Floats
from casa_assets.ext.solids import Solid, board, rod
from casa_assets.kitchenware.objects.packages.tubs import Part
from casa_assets.kitchenware.objects.packages.wrapping import SEALED, round_sides, two_sheets, with_spot, wrapped

if TYPE_CHECKING:
    from casa_assets.kitchenware.objects.packages.package import Package

# Pieces across a sheet.
ACROSS = 28


def pillow(p: Package) -> list[Part]:
    """A bag of two sheets, full of food and air, with a crimped strip at both ends and folds next to the strips."""
    x, sheet, sides = two_sheets(ACROSS)
    rng = p.rng()
    inner = p.height - 2 * p.crimp
    steps = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 15)) * 0.5 + 0.5
    steps = 0.45 * steps + 0.55 * np.linspace(0, 1, 15)
    half, deep = p.width / 2, p.depth / 2
    slack = _creases(p, x, sheet, rng)
    rings, heights = [], []
    for share in steps:
        full = max(0.0, 1.0 - abs(2 * share - 1) ** p.full) ** 0.62
        back = deep * full * (1.0 + p.sag)
        front = deep * full * (1.0 - p.sag)
        # The skin does not stretch: where the bag is full, it is narrower.
        width = float(np.sqrt(max(half**2 - 1.3 * (deep * full) ** 2, (0.55 * half) ** 2)))
        thick = np.where(sheet < 0, front, back)
        crease = slack(share)
        bulge = thick * np.clip(1 - np.abs(x) ** p.round_by, 0, 1) ** 0.5 * (1.0 + crease)
        y = sheet * (SEALED + np.maximum(0.0, bulge))
        y = np.where(sheet == 0, 0.0, y)
        # The folds reach into the strip, which is never quite flat.
        rings.append(np.column_stack([x * width, y, np.full(len(x), p.crimp + inner * share)]))
        heights.append((p.crimp + inner * share) / p.height)
    low, high = _strip(p, x, sheet, half, rng, 0), _strip(p, x, sheet, half, rng, 1)
    grid = np.stack([*low, *rings, *high])
    strip = [p.crimp * s / p.height for s in CRIMPS]
    levels = np.array([0.0, *strip, *heights, *(1 - s for s in strip[::-1]), 1.0])
    # Ends of the strip may be cut in teeth.
    if p.teeth:
        tooth = np.where(np.arange(len(x)) % 2 == 0, 0.0, 0.0022)
        grid[0, :, 2] += np.where(sheet == 0, 0.0, tooth)
        grid[-1, :, 2] -= np.where(sheet == 0, 0.0, tooth)
    solid = wrapped(grid, sides, levels, along=p.along, crease_deg=62.0)
    parts = [Part(solid, p.skin, "package", p.heft)]
    if p.seam:
        parts.append(Part(_back_seam(p, rings), p.skin, "package"))
    return parts


CRIMPS = (0.25, 0.5, 0.75)


def _creases(p: Package, x: Floats, sheet: Floats, rng: np.random.Generator) -> Callable[[float], Floats]:
    """Function of the height's share: how far each point is in or out of the even surface, by the thickness there."""
    waves = [(rng.uniform(4, 9), rng.uniform(0, 6.3), rng.uniform(0.5, 1), s) for s in (-1, 1) for _ in range(3)]
    broad = [(rng.normal(size=2) * 3.2, rng.uniform(0, 6.3), s) for s in (-1, 1) for _ in range(3)]

    def at(share: float) -> Floats:
        total = np.zeros(len(x))
        for count, phase, size, s in waves:
            for end, away in ((0, share), (1, 1 - share)):
                pull = np.exp(-away / 0.16)
                total += (sheet == s) * size * pull * np.sin(count * x * (1 + 0.25 * away) + phase + 2.0 * end)
        for way, phase, s in broad:
            total += (sheet == s) * 0.35 * np.sin(way[0] * x + 1.4 * way[1] * share + phase)
        return np.asarray(p.pleats * total)

    return at


def _strip(p: Package, x: Floats, sheet: Floats, half: float, rng: np.random.Generator, end: int) -> list[Floats]:
    """Rings of the sealed strip at an end, from below: its ridges go up and down, and it waves a little."""
    phase, bow = rng.uniform(0, 6.3), rng.uniform(0.6, 1.2)
    out = []
    for k, share in enumerate((0.0, *CRIMPS)):
        z = p.crimp * share if end == 0 else p.height - p.crimp * share
        wave = bow * 0.035 * half * (1.0 - share) * np.sin(3.2 * x + phase)
        ridge = 0.0004 * (-1) ** k
        out.append(np.column_stack([x * half, sheet * SEALED + wave + ridge, np.full(len(x), z)]))
    return out if end == 0 else out[::-1]


def _back_seam(p: Package, rings: list[Floats]) -> Solid:
    """The flap of the seam that runs down the middle of the back."""
    wide, middle = 0.05 * p.width + 0.004, 3 * ACROSS // 2
    loops = []
    for ring in rings:
        y, z = float(ring[middle, 1]), float(ring[middle, 2])
        loops.append([(-wide, y + 0.0001, z), (0.001, y - 0.0004, z), (0.001, y + 0.0006, z), (-wide, y + 0.0011, z)])
    seam = wrapped(np.array(loops), np.zeros((4, 2, 2)), np.linspace(0, 1, len(loops)), crease_deg=40.0)
    return with_spot(seam.oriented_outwards(), (0.02, 0.5))


def pouch(p: Package) -> list[Part]:
    """A pouch that rests on its oval bottom; its upper end is sealed flat, with a strip for tearing."""
    x, sheet, sides = two_sheets(ACROSS)
    rng = p.rng()
    half, deep = p.width / 2, p.depth / 2
    seal = 0.045 * p.width
    inside = 1.0 - seal / half
    shape = np.clip(1 - np.abs(x / inside) ** p.round_by, 0, 1) ** 0.8
    phase = rng.uniform(0, 6.3, 4)
    rings, heights = [], []
    for share in (0.0, 0.015, 0.06, 0.14, 0.25, 0.38, 0.52, 0.66, 0.78, 0.87, 0.93):
        full = min(1.0, 0.9 + 2.5 * share) * max(0.0, 1 - (max(0.0, share - 0.12) / 0.83) ** p.full)
        crease = p.pleats * share * (np.sin(5 * x + phase[0] + 4 * share) + 0.6 * np.sin(9 * x + phase[1] - 5 * share))
        crease += 0.5 * p.pleats * np.sin(7 * share + phase[2 + (sheet > 0).astype(int)])
        y = sheet * (SEALED + deep * full * shape * np.maximum(0.2, 1 + crease))
        # The corners of the bottom are cut round.
        width = half * (0.93 + 0.07 * min(1.0, share / 0.06))
        rings.append(np.column_stack([x * width, y, np.full(len(x), share * p.height)]))
        heights.append(share)
    for share in (0.935, 0.94, 0.985, 1.0):
        width, thick = half * (1.0 if share < 0.99 else 0.97), SEALED * (1.6 if share == 0.94 else 1.0)
        rings.append(np.column_stack([x * width, sheet * thick, np.full(len(x), share * p.height)]))
        heights.append(share)
    grid = np.stack(rings)
    lean = 0.02 * p.height * (grid[:, :, 2] / p.height) ** 2 * np.sin(phase[0])
    grid[:, :, 1] += lean
    solid = wrapped(grid, sides, np.array(heights), crease_deg=55.0)
    parts = [Part(solid, p.skin, "package", p.heft)]
    if p.zip_line:
        # In the sealed strip, where both sheets lie together.
        z, y = 0.962 * p.height, float(grid[-2, :, 1].mean())
        for k in (-1, 1):
            low, high = z + 0.003 * k - 0.0008, z + 0.003 * k + 0.0008
            line = board((-0.9 * half, y - 0.0013, low), (0.9 * half, y + 0.0013, high), 0.0004)
            parts.append(Part(with_spot(line, (0.5, 0.99)), p.skin, "package"))
    if p.cap_radius > 0:
        r = p.cap_radius
        neck = rod(0.7 * r, 0.6 * r, 0.0005).translated(z=p.height + 0.2 * r)
        cap = rod(r, 1.3 * r, 0.0012).translated(z=p.height + 1.1 * r)
        parts.append(Part(neck, p.fitting, "cap"))
        parts.append(Part(cap, p.fitting, "cap", 400.0, collider=True))
    return parts


def twist(p: Package) -> list[Part]:
    """A sweet in paper or film that is twisted at both ends and fans out there."""
    count = 24
    outline = round_sides(count)
    rng = p.rng()
    turn = np.arctan2(outline.bent[:, 1], outline.bent[:, 0])
    body = p.height - 2 * p.crimp
    neck = 0.22 * min(p.width, p.depth)
    rings, heights = [], []
    phase = rng.uniform(0, 6.3, 2)
    for share in (0.0, 0.3, 0.62, 0.85, 1.0):
        rings.append(_fan(p, outline.bent, turn, neck, share, phase[0]))
        heights.append(share * p.crimp / p.height)
    for share in (0.06, 0.2, 0.4, 0.6, 0.8, 0.94):
        full = (1.0 - abs(2 * share - 1) ** p.full) ** 0.5
        fold = 1.0 + 0.10 * p.pleats * np.sin(7 * turn + phase[1] + 3 * share) * abs(2 * share - 1)
        half_x, half_y = (max(neck, full * side / 2) for side in (p.width, p.depth))
        ring = outline.bent * (half_x, half_y) * fold[:, None]
        rings.append(np.column_stack([ring, np.full(count, p.crimp + share * body)]))
        heights.append((p.crimp + share * body) / p.height)
    for share in (1.0, 0.85, 0.62, 0.3, 0.0):
        ring = _fan(p, outline.bent, turn, neck, share, phase[1])
        ring[:, 2] = p.height - ring[:, 2]
        rings.append(ring)
        heights.append(1 - share * p.crimp / p.height)
    solid = wrapped(np.stack(rings), outline.sides, np.array(heights), along=p.along, crease_deg=48.0)
    return [Part(solid, p.skin, "package", p.heft)]


def _fan(p: Package, bent: Floats, turn: Floats, neck: float, share: float, phase: float) -> Floats:
    """A ring of a twisted end; at share 1 it is the neck, at 0 the free edge, wide, flat and in pleats."""
    open_by = (1 - share) ** 0.8
    wide = neck + (0.5 * p.fin - neck) * open_by
    thin = neck * (1 - open_by) + 2 * SEALED * open_by
    pleat = 0.09 * p.fin * open_by * np.sin(4.5 * bent[:, 0] * np.pi + phase)
    twisted = 0.9 * (1 - share)
    x, y = bent[:, 0] * wide, bent[:, 1] * thin + pleat
    flat = np.column_stack([x * np.cos(twisted) - y * np.sin(twisted), x * np.sin(twisted) + y * np.cos(twisted)])
    ragged = 0.06 * p.crimp * np.sin(3 * turn + phase) * open_by
    return np.column_stack([flat, p.crimp * share + np.maximum(0.0, ragged + 0.06 * p.crimp * open_by)])
