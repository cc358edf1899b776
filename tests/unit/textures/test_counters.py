"""Stones, staves, tiles and sheets of counters have the sizes and colours that are stated."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.kitchenware.textures import laid
from casa_assets.kitchenware.textures import stone as slabs
from casa_assets.textures.canvas import Canvas
from casa_assets.textures.check import seam
from casa_assets.textures.wood import WoodPalette, WoodSpecies
from tests.support.library.pictures import painted, runs, steps

pytestmark = pytest.mark.content("code", "textures", keep=0)

WHITE, BLACK = "#ffffff", "#000000"
PALETTE = WoodPalette(light="#d8b98a", dark="#8a5a30", pore="#5a3a20", heart="#402818", variety=0.0)
QUIET = WoodSpecies(contrast=0.0, pores=0.0, fibre=0.0, clouds=0.0)


def test_cells_have_their_size_and_close() -> None:
    canvas = Canvas((200, 200), (0.5, 0.5))
    found = slabs.voronoi_cells(canvas, 0.05, rng_for(1, "cells"))
    assert found.count == 100
    assert len(np.unique(found.id)) == 100
    assert np.all(found.near_m <= found.second_m)
    assert found.near_m == pytest.approx(np.hypot(found.dx_m, found.dy_m), abs=1e-5)
    assert found.near_m.max() < 0.06
    grid = found.id
    assert np.mean(grid[:, 0] == grid[:, -1]) > 0.8  # the same cells on both sides of the border


def ink_of(vein: slabs.Vein) -> float:
    """Share of a white stone that a family of black veins covers."""
    stone = slabs.VeinedStone(ground=WHITE, cloud=WHITE, cloudy=0, crystal=0, veins=(vein,))
    return 1.0 - float(painted(stone, "v", seed=2).albedo.mean())


def test_veins_have_their_width() -> None:
    """Twice the width is about twice the ink."""
    for course in slabs.VeinCourse:
        vein = slabs.Vein(
            color=BLACK, strength=1, course=course, spacing_m=0.15, width_m=0.006, bleed=0, gaps=0, wobble=0.2
        )
        ink = ink_of(vein)
        assert ink > 0.01
        assert 1.5 < ink_of(vein.replace(width_m=0.012)) / ink < 2.5


def test_chips_lie_beside_each_other() -> None:
    """Large and small chips cover their places, a small one never on a large one."""
    large = slabs.ChipSize(colors=(BLACK,), size_m=0.05, share=1.0, spread=0)
    small = slabs.ChipSize(colors=("#ff0000",), size_m=0.01, share=1.0, spread=0)
    made = painted(slabs.MadeStone(binder=WHITE, clouds=0, chips=(large, small)), "m").albedo
    alone = painted(slabs.MadeStone(binder=WHITE, clouds=0, chips=(large,)), "m").albedo
    inside = alone.max(axis=2) < 0.02
    assert 0.2 < inside.mean() < 0.9
    assert made[inside].max() < 0.05
    assert ((made[..., 0] > 0.8) & (made[..., 1] < 0.2)).mean() > 0.02


def test_staves_lie_along_the_counter_and_are_as_wide_as_stated() -> None:
    """0.6 m hold ten staves of 0.06 m, each of one tone from end to end, with a dark line between two."""
    staves = laid.ButcherBlock(species=QUIET, palette=PALETTE.replace(variety=1.0), stave_m=0.06, length_m=0.6)
    made = painted(staves, "s").albedo[..., 0]
    bodies = made.reshape(10, 24, 240)[:, 4:-4]
    assert len(np.unique(bodies.mean(axis=(1, 2)).round(3))) == 10
    assert np.ptp(bodies, axis=(1, 2)).max() < 0.01
    lines = made.reshape(10, 24, 240)[:, [0, -1]].mean(axis=(1, 2))
    assert np.all(lines < bodies.mean(axis=(1, 2)) - 0.02)


def test_tiles_and_joints_are_as_wide_as_stated() -> None:
    tiles = laid.TiledCounter(colors=(WHITE,), grout=BLACK, joint_m=0.01, width_m=0.15, height_m=0.1, unevenness=0)
    made = painted(tiles, "t")
    assert runs(made.albedo[20, :, 0]) == 4
    assert runs(made.albedo[:, 30, 0]) == 6
    dark = float((made.albedo[20, :, 0] < 0.5).mean()) * 0.6
    assert dark == pytest.approx(4 * 0.01, abs=0.008)
    joint = made.albedo[..., 0] < 0.2
    assert made.height_m[joint].max() < made.height_m[~joint].mean()
    assert made.roughness[joint].min() > 0.7 > 0.3 > made.roughness[~joint].mean()


def test_metal_tiles_and_shows_its_tool(subtests: pytest.Subtests) -> None:
    for tooling in list(laid.MetalTooling):
        with subtests.test(tooling=tooling):
            made = painted(laid.SheetMetal(color="#b0b0b0", patina_color="#707070", tooling=tooling, mark_m=0.03), "m")
            assert seam(made.albedo).worst < 1.6
            assert made.metallic == 1.0
            across, along = steps(made.albedo[..., 0])
            if tooling in (laid.MetalTooling.ALONG, laid.MetalTooling.ROLLED):
                assert along > 3 * across
            elif tooling is laid.MetalTooling.UPRIGHT:
                assert across > 3 * along
            else:
                assert 0.3 < along / across < 3.5
