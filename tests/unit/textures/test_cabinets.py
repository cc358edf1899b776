"""Every front tiles, has the colour that was asked for, and its grain stands upright."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.model.registry.rows import Surface
from casa_assets.pipeline.textures.recipes import recipes
from casa_assets.textures.canvas import Canvas, Map, rgb
from casa_assets.textures.distance import oklab
from casa_assets.textures.kinds import KINDS, cabinets, counters, floors, objects, walls
from casa_assets.textures.kinds.cabinets.fronts import (
    FrontFace,
    PaintCoat,
    PaintedFront,
    PressedFront,
    Veneer,
    paint_painted,
    paint_veneer,
)
from casa_assets.textures.kinds.cabinets.fronts import paint_board as paint_pressed
from casa_assets.textures.make import make
from casa_assets.textures.seam import seam
from casa_assets.textures.wood import SawCut, WoodPalette, WoodSpecies

pytestmark = pytest.mark.content("code", "textures", keep=0)

RECIPES = recipes()[Surface.CABINET]
CANVAS = Canvas((240, 240), (0.6, 0.6))
PALETTE = WoodPalette(light="#d8b98a", dark="#8a5a30", pore="#5a3a20", heart="#402818")


def steps(image: Map) -> tuple[float, float]:
    """Mean step across and along the height."""
    return float(np.abs(np.diff(image, axis=1)).mean()), float(np.abs(np.diff(image, axis=0)).mean())


def rises(row: Map) -> int:
    middle = (row.max() + row.min()) / 2
    return int(np.sum((row < middle) & (np.roll(row, -1) >= middle)))


def test_there_are_a_hundred_of_three_sorts() -> None:
    kinds = [r.kind for r in RECIPES.values()]
    assert len(kinds) == 100
    assert kinds.count("veneer") == pytest.approx(45, abs=3)
    assert kinds.count("painted_front") == pytest.approx(35, abs=3)
    assert {k.name for k in cabinets.KINDS} <= set(kinds)


def test_kinds_have_names_of_their_own() -> None:
    names = [k.name for group in (walls, floors, counters, cabinets, objects) for k in group.KINDS]
    assert len(names) == len(set(names)) == len(KINDS)


@pytest.mark.content("texture", "{name}")
@pytest.mark.parametrize("name", list(RECIPES))
def test_every_front_is_sound(name: str) -> None:
    made = make(RECIPES[name], 128)
    assert seam(made.albedo).worst < 2.0
    assert made.albedo.dtype == made.height_m.dtype == made.roughness.dtype == np.float32
    assert made.albedo.shape == (*made.height_m.shape, 3)
    assert 0.0 <= made.albedo.min() <= made.albedo.max() <= 1.0
    assert 0.04 <= made.roughness.min() <= made.roughness.max() <= 1.0
    assert np.ptp(made.height_m) < 0.012


def test_wood_stands_upright(subtests: pytest.Subtests) -> None:
    for name in [n for n, r in RECIPES.items() if r.kind == "veneer"]:
        with subtests.test(name=name):
            across, along = steps(make(RECIPES[name], 256).albedo.mean(axis=2))
            figured = name in ("maple_tiger", "eucalyptus_smoked", "birch_rotary", "douglas_fir", "elm_wild")
            assert across > (0.3 if figured else 1.1) * along


def test_colours_are_muted(subtests: pytest.Subtests) -> None:
    """Nothing garish: less than half of the chroma of a signal red. Ref: Oklab chroma of #ff0000, 0.26."""
    for name in [n for n, r in RECIPES.items() if r.kind == "painted_front"]:
        with subtests.test(name=name):
            lab = oklab(make(RECIPES[name], 64).albedo).mean(axis=(0, 1))
            assert np.hypot(lab[1], lab[2]) < 0.125


@pytest.mark.parametrize("coat", [PaintCoat.SPRAYED, PaintCoat.BRUSHED, PaintCoat.CHALK])
def test_paint_has_its_colour(coat: PaintCoat) -> None:
    made = paint_painted(PaintedFront(color="#6d8a78", coat=coat, roughness=0.5), CANVAS, rng_for(1, "p"))
    assert made.albedo.mean(axis=(0, 1)) == pytest.approx(rgb("#6d8a78"), abs=0.01)
    assert float(made.roughness.mean()) == pytest.approx(0.5, abs=0.02)
    across, along = steps(made.height_m)
    if coat is PaintCoat.BRUSHED:
        assert across > 4 * along


def test_worn_paint_shows_what_is_under_it() -> None:
    bare = []
    for worn in (0.0, 0.5, 0.9):
        front = PaintedFront(color="#ffffff", undercoat="#000000", coat=PaintCoat.CHALK, wear=worn)
        made = paint_painted(front, CANVAS, rng_for(1, "p"))
        bare.append(float((made.albedo[..., 0] < 0.5).mean()))
    assert bare[0] == 0.0 < bare[1] < bare[2] < 0.9


def test_grain_telegraphs_through_the_paint() -> None:
    oak = WoodSpecies(pores=0.8)
    plain = paint_painted(PaintedFront(color="#c0c0c0"), CANVAS, rng_for(1, "p"))
    grainy = paint_painted(PaintedFront(color="#c0c0c0", species=oak, telegraph=1.0), CANVAS, rng_for(1, "p"))
    assert grainy.height_m.std() > 5 * plain.height_m.std()
    across, along = steps(grainy.albedo.mean(axis=2))
    assert across > 1.5 * along


def test_grooves_and_ribs_are_counted() -> None:
    boards = paint_painted(PaintedFront(color="#c0c0c0", groove_spacing_m=0.1), CANVAS, rng_for(1, "p"))
    assert rises(boards.height_m[5]) == 6
    for face in (FrontFace.RIBBED, FrontFace.FLUTED):
        front = PressedFront(color="#c0c0c0", second="#a0a0a0", face=face, pitch_m=0.03)
        made = paint_pressed(front, CANVAS, rng_for(1, "p"))
        assert rises(made.height_m[5]) == 20
        assert np.ptp(made.height_m, axis=0).max() == pytest.approx(0.0, abs=1e-6)


def test_faces_tile_and_lie_between_their_colours(subtests: pytest.Subtests) -> None:
    for face in list(FrontFace):
        with subtests.test(face=face):
            front = PressedFront(color="#b0a898", second="#807868", face=face, strength=0.7, pitch_m=0.03)
            made = paint_pressed(front, CANVAS, rng_for(1, "p"))
            assert seam(made.albedo).worst < 1.6
            assert seam(made.height_m[..., None] * 500).worst < 1.6
            assert made.albedo[..., 0].mean() < 0.72
            assert made.albedo[..., 0].mean() > 0.35
            again = paint_pressed(front, CANVAS, rng_for(1, "p"))
            assert made.albedo.tobytes() == again.albedo.tobytes()


def test_gaps_are_dark_and_deep() -> None:
    closed = Veneer(species=WoodSpecies(), palette=PALETTE, cut=SawCut.FLAT, leaves=4)
    gap = paint_veneer(closed.replace(gap_m=0.005), CANVAS, rng_for(1, "v"))
    whole = paint_veneer(closed, CANVAS, rng_for(1, "v"))
    deep = gap.height_m < -0.0015
    assert deep.all(axis=0).sum() >= 4
    assert gap.albedo[deep].mean() < 0.5 * whole.albedo[deep].mean()


def test_weather_greys_and_roughens() -> None:
    board = Veneer(species=WoodSpecies(), palette=PALETTE, cut=SawCut.FLAT, leaves=4)
    new, old = (paint_veneer(board.replace(weather=w), CANVAS, rng_for(1, "v")) for w in (0.0, 1.0))
    chroma = [np.hypot(*np.moveaxis(oklab(p.albedo)[..., 1:].mean(axis=(0, 1)), 0, 0)) for p in (new, old)]
    assert chroma[1] < 0.7 * chroma[0]
    assert old.roughness.mean() > new.roughness.mean() + 0.05


def test_saw_marks_lie_level() -> None:
    board = Veneer(
        species=WoodSpecies(contrast=0.0, pores=0.0, fibre=0.0, clouds=0.0), palette=PALETTE, cut=SawCut.RIFT
    )
    sawn = paint_veneer(board.replace(saw_marks=1.0), CANVAS, rng_for(1, "v"))
    across, along = steps(sawn.height_m)
    assert along > 2 * across


def test_bamboo_has_nodes() -> None:
    strip = Veneer(
        species=WoodSpecies(contrast=0.0, pores=0.0, fibre=0.0, clouds=0.0),
        palette=PALETTE,
        cut=SawCut.QUARTER,
        leaves=8,
    )
    plain, jointed = (paint_veneer(strip.replace(node_spacing_m=n), CANVAS, rng_for(1, "v")) for n in (0.0, 0.2))
    darker = (plain.albedo - jointed.albedo)[:, 10, 0] > 0.05
    assert np.sum(darker & ~np.roll(darker, 1)) == 3
