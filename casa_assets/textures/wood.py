"""Wood textures: grain maps and a palette become colour, relief and gloss."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.wood_grain import GrainMaps, SawCut, WoodSpecies, grain_maps

# Between the deepest pore and the face of a planed board. Ref: about the vessel diameter of open woods, 0.1 to 0.3 mm.
_PORE_DEPTH_M = 0.00018
_RING_DEPTH_M = 0.00008
_JOINT_DEPTH_M = 0.00015


class WoodPalette(Record):
    """Colours of a finished wood, as a colour card shows them.

    Attributes:
        light: the plain wood.
        dark: the strong part of a year, and the tone that broad clouds lean to.
        pore: in the pores; pale where they are limed.
        heart: of knots, mineral streaks and dark bands.
        variety: 0..1, how much the leaves differ from each other.
        streaks: 0..1, share of the face that leans to `heart` in long streaks.
        roughness: of the finish, 0..1.
        brushed: 0..1, how far the soft wood was brushed out.
    """

    light: HexColor
    dark: HexColor
    pore: HexColor
    heart: HexColor
    variety: Share = 0.35
    streaks: Share = 0.0
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.45
    brushed: Share = 0.0


def board(
    canvas: Canvas, species: WoodSpecies, cut: SawCut, palette: WoodPalette, rng: np.random.Generator, leaves: int = 1
) -> Layers:
    """A face that tiles in both directions, grain along the height.

    Args:
        sheet: pixels and metres.
        species: anatomy of the wood.
        cut: how it was taken from the log; a flat cut has a joint at the border even with one leaf.
        palette: colours and gloss.
        rng: all of the randomness.
        leaves: boards or veneers side by side.
    """
    return finish_wood(grain_maps(canvas, species, cut, leaves, rng), species, palette, canvas, rng)


def finish_wood(
    grain: GrainMaps, species: WoodSpecies, palette: WoodPalette, canvas: Canvas, rng: np.random.Generator
) -> Layers:
    """Give maps of a face their colours, relief and gloss."""
    light, dark, pore, heart = (rgb(c) for c in (palette.light, palette.dark, palette.pore, palette.heart))
    cloud = np.clip(0.5 + 0.22 * grain.zone, 0.0, 1.0)
    mix = species.contrast * grain.ring * (0.75 + 0.5 * cloud) + 0.75 * species.clouds * (cloud - 0.35)
    mix = mix + 0.5 * palette.variety * grain.tone + 0.10 * species.fibre * grain.fibre
    albedo = _toward(light, dark, np.clip(mix, -0.35, 1.0))
    if palette.streaks > 0:
        vein = 1.0 * grain.zone + 0.6 * canvas.noise(1.8, 0.022, rng) + 0.12 * grain.fibre
        edge = 1.5 - 2.2 * palette.streaks
        albedo = _toward(albedo, heart, 0.6 * smoothstep(edge, edge + 2.0, vein))
    shade = 1.0 + 0.035 * species.fibre * grain.fibre + 0.07 * grain.sheen + 0.03 * palette.variety * grain.tone
    albedo = albedo * shade[..., None]
    open_pores = species.pores * grain.pore * (0.2 + 0.8 * grain.early)
    # The first wood of a year is so full of pores that it takes their colour as a whole.
    porous = np.clip(grain.early - grain.early.mean(), 0.0, 1.0)
    albedo = _toward(albedo, pore, 0.85 * open_pores)
    albedo = _toward(albedo, pore, 0.4 * species.pores * porous)
    albedo = _toward(albedo, pore, 0.45 * grain.dash * species.rays * (1.0 - (grain.fleck.max() > 0)))
    fleck = np.clip(light * 1.05 + 0.02, 0.0, 1.0)
    albedo = _toward(albedo, fleck, 0.6 * species.rays * grain.fleck)
    albedo = _toward(albedo, heart, 0.85 * grain.knot)
    albedo = albedo * (1.0 - 0.22 * grain.joint)[..., None]
    relief = -_PORE_DEPTH_M * (1.0 + 2.0 * palette.brushed) * open_pores
    relief = relief + _RING_DEPTH_M * (0.3 + 4.0 * palette.brushed) * (grain.ring - 0.5)
    relief = relief + 0.00001 * grain.fibre - _JOINT_DEPTH_M * grain.joint
    roughness = palette.roughness + 0.10 * open_pores - 0.06 * species.rays * grain.fleck - 0.03 * grain.sheen
    roughness = roughness + 0.015 * grain.fibre + 0.05 * grain.knot
    return Layers.of(albedo, relief, roughness)


def _toward(albedo: Map, color: Map, share: Map) -> Map:
    """`blend` in single precision; a share below 0 goes on past `albedo`."""
    return np.asarray(blend(albedo, color, share), dtype=np.float32)
