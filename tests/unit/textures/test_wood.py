"""Wood tiles, runs along the height, and its years are as wide as its species says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import ndimage

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


def test_a_flat_cut_has_arches_and_a_straight_one_has_none() -> None:
    """Along the height the years of a flat cut come and go; those of a quarter cut stay."""
    turns = {}
    for cut in (SawCut.FLAT, SawCut.QUARTER):
        ring = ndimage.gaussian_filter(grain(PLAIN, cut, leaves=2).ring, 1.0)
        turns[cut] = float(np.mean(np.abs(ring - np.roll(ring, 60, axis=0)) > 0.3))
    assert turns[SawCut.FLAT] > 1.3 * turns[SawCut.QUARTER]
    middle = grain(PLAIN, SawCut.FLAT, leaves=2, seed=5).ring[:, 60]  # where the plane runs along a year
    assert np.sum((middle < 0.5) & (np.roll(middle, -1) >= 0.5)) >= 1


def test_every_leaf_has_two_joints_and_a_tone_of_its_own() -> None:
    found = grain(PLAIN, SawCut.FLAT, leaves=5)
    assert len(np.unique(found.tone)) == 5
    assert found.tone.mean() == pytest.approx(0.0, abs=0.15)
    lines = found.joint[0] > 0.1
    assert np.sum(lines & ~np.roll(lines, 1)) in (5, 6)  # the one on the border may show on both sides
    assert grain(PLAIN, SawCut.QUARTER).joint.max() == 0.0
    assert np.ptp(grain(PLAIN, SawCut.QUARTER).tone) == 0.0


def test_rays_only_on_a_quartered_face() -> None:
    oak = WoodSpecies(rings=GrowthRings.RING_POROUS, rays=1.0)
    assert grain(oak, SawCut.QUARTER).fleck.max() > 0.2
    assert grain(oak, SawCut.RIFT).fleck.max() == 0.0
    flecks = grain(oak, SawCut.QUARTER).fleck
    across, along = steps(flecks)
    assert along > across  # they lie level


def test_knots_are_as_many_as_asked_for_and_whole() -> None:
    pine = WoodSpecies(rings=GrowthRings.CONIFER, knots_per_m2=10.0)
    dark = np.tile(grain(pine, SawCut.FLAT, leaves=3).knot, (2, 2)) > 0.4
    count = ndimage.label(dark)[1] / 4.0  # of four copies; those on the outer border count twice
    assert count == pytest.approx(0.8 * 0.8 * 10, abs=2.5)
    assert grain(WoodSpecies(), SawCut.FLAT).knot.max() == 0.0


def test_pores_are_longer_than_wide() -> None:
    across, along = steps(grain(WoodSpecies(pores=1.0, pore_m=0.03), SawCut.RIFT).pore)
    assert across > 2.0 * along


def test_colours_are_those_of_the_palette() -> None:
    quiet = WoodSpecies(rings=GrowthRings.DIFFUSE, contrast=0.0, pores=0.0, fibre=0.0, clouds=0.0)
    mean = board(quiet, SawCut.RIFT).albedo.mean(axis=(0, 1))
    assert mean == pytest.approx(rgb(PALETTE.light), abs=0.02)
    assert board(quiet, streaks=0.8).albedo.mean() < mean.mean() - 0.05


def test_limed_pores_are_paler_than_the_wood() -> None:
    open_grained = WoodSpecies(rings=GrowthRings.RING_POROUS, pores=1.0, contrast=0.2)
    limed, dark = (float(board(open_grained, pore=pore).albedo.mean()) for pore in ("#f4f0e8", "#302010"))
    assert limed > dark + 0.02


def test_a_brushed_face_is_deeper() -> None:
    smooth, brushed = board(PLAIN).height_m, board(PLAIN, brushed=1.0).height_m
    assert np.ptp(brushed) > 3.0 * np.ptp(smooth)
    assert np.ptp(brushed) < 0.002
