"""Fronts have the colour, the grain and the grooves that were asked for."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.kitchenware.textures.fronts import FrontFace, PaintCoat, PaintedFront, PressedFront
from casa_assets.textures.canvas import rgb
from casa_assets.textures.check import seam
from tests.support.library.pictures import painted, runs, steps

pytestmark = pytest.mark.content("code", "textures", keep=0)


@pytest.mark.parametrize("coat", [PaintCoat.SPRAYED, PaintCoat.BRUSHED, PaintCoat.CHALK])
def test_paint_has_its_colour(coat: PaintCoat) -> None:
    made = painted(PaintedFront(color="#6d8a78", coat=coat, roughness=0.5), "p")
    assert made.albedo.mean(axis=(0, 1)) == pytest.approx(rgb("#6d8a78"), abs=0.01)
    assert float(made.roughness.mean()) == pytest.approx(0.5, abs=0.02)
    across, along = steps(made.height_m)
    if coat is PaintCoat.BRUSHED:
        assert across > 4 * along


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
