"""Bricks, boards, tiles and repeats of walls and floors are as large as stated."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.kitchenware.textures import covering, wall_panels
from casa_assets.kitchenware.textures.covering import REPEATS, PaperRepeat
from casa_assets.kitchenware.textures.floors import Encaustic
from casa_assets.kitchenware.textures.motif import DESIGNS, TileDesign
from casa_assets.textures.canvas import Canvas
from casa_assets.textures.check import seam
from casa_assets.textures.laying import Laying, LayingPattern
from casa_assets.textures.pieces import Joint
from tests.support.library.pictures import painted, runs

pytestmark = pytest.mark.content("code", "textures", keep=0)

WHITE, BLACK = "#ffffff", "#000000"
GROUT = Joint(color=BLACK, width_m=0.006, coarseness=0.0, rim_drop_m=0.0)


def test_subway_tiles_are_as_large_as_stated() -> None:
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.075, length_m=0.15, bond=0.5)
    params = wall_panels.CeramicTile(
        laying=laying, joint=GROUT, colors=(WHITE,), variety=0, glaze_pooling=0, tilt=0, wave_m=0
    )
    made = painted(params, "t", Canvas((300, 450), (0.9, 0.6)))
    light = made.albedo[..., 0]
    assert runs(light[:, 4]) == 8
    assert {runs(light[round((n + 0.5) * 0.075 * 500)]) for n in range(8)} == {6}
    assert float(1.0 - light.mean()) == pytest.approx(1 - (0.069 / 0.075) * (0.144 / 0.15), abs=0.01)


SQUARES = Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.1)


def test_grout_lies_lower_and_is_rougher() -> None:
    joint = Joint(width_m=0.004, depth_m=0.001)
    params = wall_panels.CeramicTile(laying=SQUARES, joint=joint, colors=(WHITE,), roughness=0.1, tilt=0)
    made = painted(params, "t", Canvas((400, 400), (0.4, 0.4)))
    assert made.height_m[50, 50] - made.height_m[0, 0] > 0.0008
    assert made.roughness[0, 0] - made.roughness[50, 50] > 0.5


def test_boards_are_as_wide_as_stated(subtests: pytest.Subtests) -> None:
    for profile in wall_panels.BoardProfile:
        with subtests.test(profile=profile):
            params = wall_panels.PaintedBoards(
                color="#808080", profile=profile, pitch_m=0.1, gap_m=0.012, depth_m=0.005, grain=0.0
            )
            made = painted(params, "b", Canvas((100, 400), (0.8, 0.2)))
            relief = made.height_m.mean(axis=0)
            assert runs(relief) == (16 if profile is wall_panels.BoardProfile.BEAD else 8)
            level = painted(params.replace(horizontal=True), "b", Canvas((400, 100), (0.2, 0.8)))
            np.testing.assert_array_equal(level.height_m, made.height_m.T)


def test_designs_use_all_their_inks_and_go_on_over_the_joint(subtests: pytest.Subtests) -> None:
    for design in TileDesign:
        with subtests.test(design=design):
            inks = 1 + max(number for _, number in DESIGNS[design](np.zeros((1, 1)), np.zeros((1, 1))))
            colors = ("#ffffff", "#ff0000", "#00ff00", "#0000ff")[:inks]
            params = Encaustic(design=design, colors=colors, wear=0, bleed=0, variety=0, joint=Joint(width_m=0))
            made = painted(params, "e", Canvas((128, 128), (0.4, 0.4))).albedo
            for color in colors[1:]:
                wanted = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
                assert (np.abs(made - wanted).max(axis=2) < 0.3).mean() > 0.005
            np.testing.assert_allclose(made[:64, :64], made[64:, 64:], atol=0.35)  # the same tile, mottled
            if design is not TileDesign.ARCS:  # its rings end at the edge of the tile
                assert seam(made).worst < 2.0


def test_repeats_of_paper_are_as_large_as_stated_and_close(subtests: pytest.Subtests) -> None:
    for repeat in PaperRepeat:
        with subtests.test(repeat=repeat):
            u = (np.arange(200) + 0.5) / 200 - 0.5
            for depth, _ in REPEATS[repeat](u[None, :] + 0 * u[:, None], u[:, None] + 0 * u[None, :]):
                assert depth.shape == (200, 200)
            params = covering.PrintedPaper(ground=WHITE, inks=(BLACK,), repeat=repeat, width_m=0.2, height_m=0.2)
            light = painted(params, "r", Canvas((256, 256), (0.4, 0.4))).albedo[..., 0]
            np.testing.assert_allclose(light[:128, :128], light[128:, 128:], atol=0.45)
            assert seam(light).worst < 2.0
            assert 0.02 < float(1 - light.mean()) < 0.8
