"""Fronts have the colour, the grain and the grooves that were asked for."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.kitchenware.textures.fronts import FrontFace, PaintCoat, PaintedFront, PressedFront, Veneer
from casa_assets.textures.canvas import Layers, rgb
from casa_assets.textures.check import seam
from casa_assets.textures.distance import oklab
from casa_assets.textures.wood import SawCut, WoodPalette, WoodSpecies
from tests.support.library.pictures import painted, runs, steps

pytestmark = pytest.mark.content("code", "textures", keep=0)

QUIET = WoodSpecies(contrast=0.0, pores=0.0, fibre=0.0, clouds=0.0)
PALETTE = WoodPalette(light="#d8b98a", dark="#8a5a30", pore="#5a3a20", heart="#402818")


@pytest.mark.parametrize("coat", [PaintCoat.SPRAYED, PaintCoat.BRUSHED, PaintCoat.CHALK])
def test_paint_has_its_colour(coat: PaintCoat) -> None:
    made = painted(PaintedFront(color="#6d8a78", coat=coat, roughness=0.5), "p")
    assert made.albedo.mean(axis=(0, 1)) == pytest.approx(rgb("#6d8a78"), abs=0.01)
    assert float(made.roughness.mean()) == pytest.approx(0.5, abs=0.02)
    across, along = steps(made.height_m)
    if coat is PaintCoat.BRUSHED:
        assert across > 4 * along


def test_worn_paint_shows_what_is_under_it() -> None:
    bare = []
    for worn in (0.0, 0.5, 0.9):
        front = PaintedFront(color="#ffffff", undercoat="#000000", coat=PaintCoat.CHALK, wear=worn)
        made = painted(front, "p")
        bare.append(float((made.albedo[..., 0] < 0.5).mean()))
    assert bare[0] == 0.0 < bare[1] < bare[2] < 0.9


def test_grain_telegraphs_through_the_paint() -> None:
    oak = WoodSpecies(pores=0.8)
    plain = painted(PaintedFront(color="#c0c0c0"), "p")
    grainy = painted(PaintedFront(color="#c0c0c0", species=oak, telegraph=1.0), "p")
    assert grainy.height_m.std() > 5 * plain.height_m.std()
    across, along = steps(grainy.albedo.mean(axis=2))
    assert across > 1.5 * along


def test_grooves_and_ribs_are_counted() -> None:
    boards = painted(PaintedFront(color="#c0c0c0", groove_spacing_m=0.1), "p")
    assert runs(boards.height_m[5]) == 6
    for face in (FrontFace.RIBBED, FrontFace.FLUTED):
        front = PressedFront(color="#c0c0c0", second="#a0a0a0", face=face, pitch_m=0.03)
        made = painted(front, "p")
        assert runs(made.height_m[5]) == 20
        assert np.ptp(made.height_m, axis=0).max() == pytest.approx(0.0, abs=1e-6)


def test_faces_tile_and_lie_between_their_colours(subtests: pytest.Subtests) -> None:
    for face in list(FrontFace):
        with subtests.test(face=face):
            front = PressedFront(color="#b0a898", second="#807868", face=face, strength=0.7, pitch_m=0.03)
            made = painted(front, "p")
            assert seam(made.albedo).worst < 1.6
            assert seam(made.height_m[..., None] * 500).worst < 1.6
            assert made.albedo[..., 0].mean() < 0.72
            assert made.albedo[..., 0].mean() > 0.35
            again = painted(front, "p")
            assert made.albedo.tobytes() == again.albedo.tobytes()


def veneers(board: Veneer, **changes: float) -> tuple[Layers, Layers]:
    """A veneer, and the same with something changed."""
    return painted(board, "v"), painted(board.replace(**changes), "v")


BOARD = Veneer(species=WoodSpecies(), palette=PALETTE, cut=SawCut.FLAT, leaves=4)


def test_gaps_are_dark_and_deep() -> None:
    whole, gap = veneers(BOARD, gap_m=0.005)
    deep = gap.height_m < -0.0015
    assert deep.all(axis=0).sum() >= 4
    assert gap.albedo[deep].mean() < 0.5 * whole.albedo[deep].mean()


def test_weather_greys_and_roughens() -> None:
    new, old = veneers(BOARD, weather=1.0)
    chroma = [np.hypot(*np.moveaxis(oklab(p.albedo)[..., 1:].mean(axis=(0, 1)), 0, 0)) for p in (new, old)]
    assert chroma[1] < 0.7 * chroma[0]
    assert old.roughness.mean() > new.roughness.mean() + 0.05


def test_saw_marks_lie_level_and_bamboo_has_nodes() -> None:
    _, sawn = veneers(Veneer(species=QUIET, palette=PALETTE, cut=SawCut.RIFT), saw_marks=1.0)
    across, along = steps(sawn.height_m)
    assert along > 2 * across
    strip = Veneer(species=QUIET, palette=PALETTE, cut=SawCut.QUARTER, leaves=8)
    plain, jointed = veneers(strip, node_spacing_m=0.2)
    darker = (plain.albedo - jointed.albedo)[:, 10, 0] > 0.05
    assert np.sum(darker & ~np.roll(darker, 1)) == 3
