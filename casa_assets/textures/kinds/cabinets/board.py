"""Manufactured fronts: laminate, lacquer, thermofoil, linoleum, with the relief that the press gives them."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.kind import TextureKind


class FrontFace(StrEnum):
    """Print or relief of the face."""

    PLAIN = "plain"
    LINEN = "linen"
    CONCRETE = "concrete"
    RIBBED = "ribbed"
    FLUTED = "fluted"
    BRUSHED = "brushed"
    PEEL = "peel"
    LINOLEUM = "linoleum"
    LEATHER = "leather"
    CANE = "cane"


class PressedFront(Record):
    """A manufactured front.

    Attributes:
        color: of the face.
        second: colour of threads, clouds or lines on it.
        face: pattern.
        roughness: 0..1.
        strength: 0..1, how plain the pattern is to see.
        pitch_m: distance of ribs, flutes or cane holes in metres.
    """

    color: HexColor
    second: HexColor
    face: FrontFace = FrontFace.PLAIN
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.6
    strength: Share = 0.5
    pitch_m: Annotated[float, Field(gt=0.003, lt=0.2)] = 0.02


def paint(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet of board; ribs run along v."""
    share, height, gloss, shade = _FACES[params.face](params, canvas, rng)
    color, second = rgb(params.color), rgb(params.second)
    albedo = blend(color, second, np.clip(params.strength * share, 0.0, 1.0)) * shade[..., None]
    return Layers.of(albedo, np.broadcast_to(height, canvas.size_px), params.roughness + gloss)


_Parts = tuple[Map, Map, Map, Map]


def _plain(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    cloud = canvas.noise(0.5, 0.4, rng, 2)
    fine = canvas.noise(0.003, 0.003, rng)
    return 0.08 * cloud, 0.000001 * fine, 0.008 * cloud, np.ones_like(cloud)


def _linen(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Threads of uneven thickness, over and under."""
    warp = canvas.noise(0.4, 0.0021, rng) + 0.45 * canvas.noise(0.037, 0.0023, rng)
    weft = canvas.noise(0.0021, 0.4, rng) + 0.45 * canvas.noise(0.0023, 0.037, rng)
    slub = smoothstep(1.3, 2.2, canvas.noise(0.05, 0.0035, rng)) + smoothstep(1.3, 2.2, canvas.noise(0.0035, 0.05, rng))
    share = 0.5 + 0.24 * (warp + weft) + 0.5 * slub
    return share, 0.00003 * np.maximum(warp, weft), 0.03 * warp, np.ones_like(warp)


def _concrete(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    cloud = 0.6 * canvas.noise(0.45, 0.4, rng, 6) + 0.5 * canvas.noise(0.07, 0.09, rng, 5)
    fine = canvas.noise(0.01, 0.01, rng, 3)
    holes = smoothstep(2.3, 2.7, canvas.noise(0.006, 0.006, rng) + 0.4 * canvas.noise(0.1, 0.1, rng))
    share = 0.45 + 0.35 * cloud + 0.10 * fine
    return share, 0.00001 * fine - 0.0002 * holes, 0.04 * cloud, 1.0 - 0.3 * params.strength * holes


def _ribbed(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Narrow V grooves with flat ground between them."""
    off = canvas.groove_distance(params.pitch_m)
    groove = np.clip(1.0 - off / 0.0022, 0.0, 1.0)
    lines = canvas.noise(0.3, 0.0025, rng)
    return 0.12 * lines, -0.002 * groove, 0.01 * lines, 1.0 - 0.40 * groove + 0.0 * lines


def _fluted(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Half rounds side by side."""
    count = max(1, round(canvas.tile_m[0] / params.pitch_m))
    across = canvas.groove_distance(params.pitch_m) / (canvas.tile_m[0] / count)  # 0 in the groove, 0.5 on the crest
    crest = np.sqrt(np.clip(1.0 - (1.0 - 2.0 * across) ** 2, 0.0, 1.0))
    lines = canvas.noise(0.3, 0.003, rng)
    return 0.3 + 0.25 * lines, 0.3 * params.pitch_m * crest, 0.01 * lines, 0.80 + 0.20 * crest**0.6 + 0.0 * lines


def _brushed(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    lines = canvas.noise(0.5, 0.0014, rng) + 0.6 * canvas.noise(1.0, 0.01, rng)
    return 0.5 + 0.3 * lines, 0.000006 * lines, 0.03 * lines, np.ones_like(lines)


def _peel(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    peel = canvas.noise(0.005, 0.005, rng)
    return 0.06 * canvas.noise(0.4, 0.4, rng), 0.00002 * peel, 0.004 * peel, np.ones_like(peel)


def _linoleum(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Wood flour and cork in a calendered sheet: soft crumbs of two sizes."""
    crumbs = canvas.noise(0.004, 0.003, rng) + 0.7 * canvas.noise(0.012, 0.008, rng)
    return smoothstep(0.2, 2.0, crumbs), 0.000004 * crumbs, 0.02 * crumbs, 1.0 + 0.012 * crumbs


def _leather(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Low round bumps between creases."""
    bumps = np.abs(canvas.noise(0.007, 0.007, rng)) + 0.5 * np.abs(canvas.noise(0.0035, 0.0035, rng))
    crease = 1.0 - smoothstep(0.1, 0.6, bumps)
    cloud = canvas.noise(0.3, 0.3, rng, 3)
    return crease + 0.06 * cloud, 0.00008 * np.minimum(bumps, 1.0), 0.08 * crease, np.ones_like(crease)


def _cane(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Woven cane: pairs of strands upright and level, single ones slanting, six-cornered holes between."""
    x, y = canvas.axes()
    u = x / (canvas.tile_m[0] / max(1, round(canvas.tile_m[0] / params.pitch_m)))
    v = y / (canvas.tile_m[1] / max(1, round(canvas.tile_m[1] / params.pitch_m)))
    upright = _strand(u, 0.30) + 0.0 * v
    level = _strand(v, 0.30) + 0.0 * u
    rising, falling = _strand(u + v + 0.5, 0.17), _strand(u - v + 0.5, 0.17)
    over = np.maximum.reduce([upright * 0.92, level, rising * 0.85, falling * 0.8])
    tint = canvas.noise(0.2, 0.004, rng) * (upright > level) + canvas.noise(0.004, 0.2, rng) * (level >= upright)
    hole = 1.0 - smoothstep(0.05, 0.3, over)
    return hole, 0.0012 * over, 0.25 * hole, (0.80 + 0.2 * np.sqrt(over)) * (1.0 + 0.03 * tint)


def _strand(at: Map, width: float) -> Map:
    """Round profile 0..1 of a strand on every whole number, `width` of the pitch wide."""
    off = np.abs(np.mod(at + 0.5, 1.0) - 0.5) / (width / 2.0)
    return np.asarray(np.sqrt(np.clip(1.0 - off**2, 0.0, 1.0)), dtype=np.float32)


_FACES = {
    FrontFace.PLAIN: _plain,
    FrontFace.LINEN: _linen,
    FrontFace.CONCRETE: _concrete,
    FrontFace.RIBBED: _ribbed,
    FrontFace.FLUTED: _fluted,
    FrontFace.BRUSHED: _brushed,
    FrontFace.PEEL: _peel,
    FrontFace.LINOLEUM: _linoleum,
    FrontFace.LEATHER: _leather,
    FrontFace.CANE: _cane,
}

PRESSED = TextureKind("pressed_front", PressedFront, paint)
