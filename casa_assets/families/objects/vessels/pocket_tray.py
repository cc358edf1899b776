"""Trays with pockets in rows, for ice cubes, muffins and the like."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.core.typing import Floats
from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import box
from casa_assets.families.kit.solids.loft import inset_rings, loft
from casa_assets.families.kit.solids.solid import concatenate
from casa_assets.families.kit.solids.sweep import circle, prism, rectangle
from casa_assets.families.parametric_model import ParametricModel
from casa_assets.model.asset.asset import Base


class PocketTray(Params):
    """Parameters of a tray with pockets; lengths in metres.

    Attributes:
        columns, rows: of pockets. pitch_x, pitch_y: between their middles. gap: between two of them.
        depth: of a pocket. narrow: its floor by its mouth. rounding: of its corners by half its lesser side; 1 for
            round ones. border: of the tray about them. end: more of it at both ends, to be held by.
        wall: thickness. rim: height of a rim that goes down around the tray.
        skin: finish.
    """

    columns: Annotated[int, Field(ge=1, le=10)] = 6
    rows: Annotated[int, Field(ge=1, le=6)] = 2
    pitch_x: Annotated[float, Field(ge=0.014, le=0.12)] = 0.036
    pitch_y: Annotated[float, Field(ge=0.014, le=0.12)] = 0.045
    gap: Annotated[float, Field(ge=0.002, le=0.03)] = 0.004
    depth: Annotated[float, Field(ge=0.01, le=0.06)] = 0.03
    narrow: Annotated[float, Field(ge=0.4, le=1)] = 0.8
    rounding: Annotated[float, Field(ge=0.02, le=1)] = 0.3
    border: Annotated[float, Field(ge=0.001, le=0.05)] = 0.004
    end: Annotated[float, Field(ge=0, le=0.06)] = 0.008
    wall: Annotated[float, Field(ge=0.0008, le=0.004)] = 0.0015
    rim: Annotated[float, Field(ge=0, le=0.05)] = 0.008
    skin: FinishId


def build(builder: AssetBuilder, p: PocketTray) -> None:
    """Build the asset: it rests on the floors of its pockets, at z = 0, its length along x."""
    length = p.columns * p.pitch_x + 2 * (p.border + p.end)
    width = p.rows * p.pitch_y + 2 * p.border
    mouth = _mouth(p)
    top = p.depth + p.wall
    places = [
        ((i - (p.columns - 1) / 2) * p.pitch_x, (j - (p.rows - 1) / 2) * p.pitch_y)
        for i in range(p.columns)
        for j in range(p.rows)
    ]
    outline = rectangle(length, width, min(0.012, 0.4 * width), 4)
    cover = prism(outline, p.wall, 0.0004, [mouth + place for place in places]).translated(z=top - p.wall)
    half = float(np.abs(mouth[:, 1]).max()) * (1 - p.narrow)
    inside = [(0.0, p.depth), (half, 0.18 * p.depth), (1.0 * half + 0.12 * p.depth, 0.0)]
    w = p.wall - 0.0002
    outside = [(half + 0.12 * p.depth - 0.4 * w, 0.0), (half - w, 0.16 * p.depth)]
    steps = [*outside, (-w, p.depth - 0.0004), (-0.0001, p.depth - 0.0004), *((d, z + p.wall) for d, z in inside[1:])]
    cup = loft(inset_rings(mouth, steps), 40.0)
    cups = [cup.translated(*place) for place in places]
    parts = [cover, *cups]
    if p.rim > 0:
        hoop = inset_rings(outline, [(0.0006, top - 0.0004), (0.0, top - 0.001), (-0.001, top - p.rim)])
        back = inset_rings(outline, [(p.wall - 0.001, top - p.rim), (p.wall, top - 0.0004)])
        ring = [*hoop, *back, hoop[0]]
        n = len(outline)
        faces = []
        for k in range(len(ring) - 1):
            a = k * n + np.arange(n)
            b, c = np.roll(a, -1), ((k + 1) % (len(ring) - 1)) * n + np.arange(n)
            d = np.roll(c, -1)
            faces += [np.stack([a, b, d], 1), np.stack([a, d, c], 1)]
        points = np.concatenate(ring[:-1])
        parts.append(type(cup)(points, np.concatenate(faces).astype(np.int64), crease_deg=50.0).oriented_outwards())
    body = concatenate([part.without_colliders() for part in parts])
    builder.add(ROOT, body, p.skin, label="body", name="body", collider=False)
    _add_shapes(builder, p, length, width, top)


def _mouth(p: PocketTray) -> Floats:
    """The outline of a pocket's mouth."""
    x, y = p.pitch_x - p.gap, p.pitch_y - p.gap
    if p.rounding >= 1:
        return circle(min(x, y) / 2, 14)
    return rectangle(x, y, p.rounding * min(x, y) / 2, 2)


def _add_shapes(builder: AssetBuilder, p: PocketTray, length: float, width: float, top: float) -> None:
    """A floor, walls between the rows and columns, and a border: pockets stay open."""
    x, y = p.columns * p.pitch_x, p.rows * p.pitch_y
    builder.add_collider(ROOT, box((0.96 * x, 0.94 * y, p.wall), (0.0, 0.0, p.wall / 2), 0.0), p.skin, "body", "floor")
    for i in range(1, p.columns):
        at = (i - p.columns / 2) * p.pitch_x
        builder.add_collider(ROOT, box((p.gap, y, top - 0.001), (at, 0.0, top / 2), 0.0), p.skin, "body")
    for j in range(1, p.rows):
        at = (j - p.rows / 2) * p.pitch_y
        builder.add_collider(ROOT, box((x, p.gap, top - 0.001), (0.0, at, top / 2), 0.0), p.skin, "body")
    side, high = (width - y) / 2 + 0.4 * p.gap, max(p.rim, 0.6 * top)
    end = (length - x) / 2 + 0.4 * p.gap
    for s in (-1, 1):
        at = s * (width - side) / 2
        builder.add_collider(ROOT, box((length, side, high), (0.0, at, top - high / 2), 0.0), p.skin, "body")
        at = s * (length - end) / 2
        builder.add_collider(ROOT, box((end, width, high), (at, 0.0, top - high / 2), 0.0), p.skin, "body")


FORM = ParametricModel("pocket_tray", PocketTray, build, base=Base.FREE)
