"""Wood tiles, runs along the height, and its years are as wide as its species says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.textures import wood
from casa_assets.textures.canvas import Canvas, Layers, rgb
from casa_assets.textures.check import seam
from casa_assets.textures.wood import GrainMaps, GrowthRings, SawCut, WoodPalette, WoodSpecies, grain_maps
from tests.support.library.pictures import steps

pytestmark = pytest.mark.content("code", "textures", keep=0)

PALETTE = WoodPalette(light="#d8b98a", dark="#8a5a30", pore="#5a3a20", heart="#402818")
PLAIN = WoodSpecies(
    rings=GrowthRings.BANDED, ring_m=0.02, unevenness=0.0, contrast=1.0, pores=0.0, fibre=0.0, clouds=0.0
)
CANVAS = Canvas((240, 240), (0.8, 0.8))


def board(species: WoodSpecies, cut: SawCut = SawCut.RIFT, leaves: int = 1, **palette: Any) -> Layers:
    rng = rng_for(3, "board")
    return wood.finish_wood(
        grain_maps(CANVAS, species, cut, leaves, rng), species, PALETTE.replace(**palette), CANVAS, rng
    )


def grain(species: WoodSpecies, cut: SawCut, leaves: int = 1, seed: int = 3) -> GrainMaps:
    return grain_maps(CANVAS, species, cut, leaves, rng_for(seed, "board"))


def test_boards_tile(subtests: pytest.Subtests) -> None:
    for rings in list(GrowthRings):
        for cut in list(SawCut):
            with subtests.test(cut=cut, rings=rings):
                species = WoodSpecies(
                    rings=rings, ring_m=0.008, contrast=0.7, pores=0.5, rays=0.5, ribbon=0.4, curl=0.4, knots_per_m2=8
                )
                made = board(species, cut, leaves=4 if cut is SawCut.FLAT else 1)
                assert seam(made.albedo).worst < 1.8
                assert seam(made.height_m[..., None] * 1000).worst < 1.8


def test_the_grain_runs_along_the_height(subtests: pytest.Subtests) -> None:
    for cut in list(SawCut):
        with subtests.test(cut=cut):
            across, along = steps(board(PLAIN, cut, leaves=3).albedo[..., 0])
            assert across > (1.2 if cut is SawCut.ROTARY else 2.0) * along


def test_a_straight_cut_has_the_years_of_its_species() -> None:
    """0.8 m of years of 0.02 m are 40 years, on every row."""
    ring = grain(PLAIN, SawCut.QUARTER).ring
    for row in ring[::40]:
        starts = np.sum((row < 0.5) & (np.roll(row, -1) >= 0.5))
        assert starts == pytest.approx(40, abs=2)


def test_colours_are_those_of_the_palette() -> None:
    quiet = WoodSpecies(rings=GrowthRings.DIFFUSE, contrast=0.0, pores=0.0, fibre=0.0, clouds=0.0)
    mean = board(quiet, SawCut.RIFT).albedo.mean(axis=(0, 1))
    assert mean == pytest.approx(rgb(PALETTE.light), abs=0.02)
    assert board(quiet, streaks=0.8).albedo.mean() < mean.mean() - 0.05
