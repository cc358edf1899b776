"""Every wall and floor tiles and is sound; bricks, boards, tiles and repeats are as large as their recipes say."""

from __future__ import annotations

import json

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.model.registry.rows import Surface, TextureRecipe
from casa_assets.pipeline.textures.recipes import recipes
from casa_assets.textures.canvas import Canvas, Map
from casa_assets.textures.kinds import floors, walls
from casa_assets.textures.kinds.floors.soft import ResilientFloor, ResilientSort
from casa_assets.textures.kinds.floors.soft import paint_resilient as paint_soft
from casa_assets.textures.kinds.floors.tiles import Encaustic
from casa_assets.textures.kinds.floors.tiles import paint_encaustic as paint_cement
from casa_assets.textures.kinds.walls.covering import (
    FoliagePaper,
    Plaster,
    PlasterFinish,
    PrintedPaper,
    paint_foliage,
    paint_plaster,
    paint_printed,
)
from casa_assets.textures.kinds.walls.masonry import CeramicTile, ColorAssignment, FiredClay, paint_clay
from casa_assets.textures.kinds.walls.masonry import paint_ceramic as paint_tiles
from casa_assets.textures.kinds.walls.panels import (
    BoardProfile,
    Concrete,
    Formwork,
    PaintedBoards,
    PressedTin,
    paint_boards,
    paint_concrete,
    paint_tin,
)
from casa_assets.textures.laying.laying import Laying, LayingPattern
from casa_assets.textures.laying.pieces import Joint
from casa_assets.textures.make import make
from casa_assets.textures.motif.figures import DESIGNS, TileDesign
from casa_assets.textures.motif.foliage import FoliageKind
from casa_assets.textures.motif.repeat import REPEATS, PaperRepeat
from casa_assets.textures.seam import seam

pytestmark = pytest.mark.content("code", "textures", keep=0)

WALLS, FLOORS = recipes()[Surface.WALL], recipes()[Surface.FLOOR]
BOTH = {**WALLS, **FLOORS}
KINDS = [*walls.KINDS, *floors.KINDS]
WHITE, BLACK = "#ffffff", "#000000"
GROUT = Joint(color=BLACK, width_m=0.006, coarseness=0.0, rim_drop_m=0.0)


def runs(row: Map) -> int:
    """How often a row that repeats rises over its middle."""
    middle = (row.max() + row.min()) / 2
    return int(np.sum((row < middle) & (np.roll(row, -1) >= middle)))


def first_of(kind: str) -> TextureRecipe:
    return next(r for r in BOTH.values() if r.kind == kind)


def test_there_are_a_hundred_of_each_and_every_kind_is_used() -> None:
    assert (len(WALLS), len(FLOORS)) == (100, 100)
    assert {k.name for k in KINDS} <= {r.kind for r in BOTH.values()}


def test_cement_tiles_show_fourteen_designs_and_more() -> None:
    shown = {json.loads(r.params)["design"] for r in FLOORS.values() if r.kind == "cement_tile"}
    assert len(shown) >= 14


@pytest.mark.content("texture", "{name}", keep=6)
@pytest.mark.parametrize("name", list(BOTH))
def test_every_one_is_sound(name: str) -> None:
    made = make(BOTH[name], 128)
    assert seam(made.albedo).worst < 2.0
    assert made.albedo.dtype == made.height_m.dtype == made.roughness.dtype == np.float32
    assert made.albedo.shape == (*made.height_m.shape, 3)
    assert made.roughness.shape == made.height_m.shape
    assert 0.0 <= made.albedo.min() <= made.albedo.max() <= 1.0
    assert 0.04 <= made.roughness.min() <= made.roughness.max() <= 1.0
    assert 0.06 < made.albedo.mean() < 0.97
    assert np.ptp(made.height_m) < 0.06


def test_same_seed_same_bytes_and_another_seed_another_picture(subtests: pytest.Subtests) -> None:
    for kind in KINDS:
        with subtests.test(kind=kind):
            recipe = first_of(getattr(kind, "name"))  # noqa: B009
            one, same, other = make(recipe, 64), make(recipe, 64), make(recipe.replace(seed=recipe.seed + 1), 64)
            assert one.albedo.tobytes() == same.albedo.tobytes()
            assert one.height_m.tobytes() == same.height_m.tobytes()
            assert one.roughness.tobytes() == same.roughness.tobytes()
            changed = (one.albedo != other.albedo).any() or (one.height_m != other.height_m).any()
            assert changed


def test_a_coarse_picture_shows_the_same_design(subtests: pytest.Subtests) -> None:
    for kind in KINDS:
        with subtests.test(kind=kind):
            recipe = first_of(getattr(kind, "name"))  # noqa: B009
            fine, coarse = make(recipe, 512).albedo.mean(axis=2), make(recipe, 256).albedo.mean(axis=2)
            step = [n // 32 for n in coarse.shape]
            rows, columns = step[0] * 32, step[1] * 32
            small = coarse[:rows, :columns].reshape(32, step[0], 32, step[1]).mean(axis=(1, 3))
            fine = fine[: 2 * rows, : 2 * columns].reshape(32, 2 * step[0], 32, 2 * step[1]).mean(axis=(1, 3))
            assert np.corrcoef(small.ravel(), fine.ravel())[0, 1] > 0.6  # threads finer than a pixel leave the rest
            assert abs(float(small.mean() - fine.mean())) < 0.02


def test_subway_tiles_are_as_large_as_stated() -> None:
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.075, length_m=0.15, bond=0.5)
    params = CeramicTile(laying=laying, joint=GROUT, colors=(WHITE,), variety=0, glaze_pooling=0, tilt=0, wave_m=0)
    made = paint_tiles(params, Canvas((300, 450), (0.9, 0.6)), rng_for(1, "t"))
    light = made.albedo[..., 0]
    assert runs(light[:, 4]) == 8
    assert {runs(light[round((n + 0.5) * 0.075 * 500)]) for n in range(8)} == {6}
    assert float(1.0 - light.mean()) == pytest.approx(1 - (0.069 / 0.075) * (0.144 / 0.15), abs=0.01)


def test_grout_lies_lower_and_is_rougher() -> None:
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.1)
    params = CeramicTile(
        laying=laying, joint=Joint(width_m=0.004, depth_m=0.001), colors=(WHITE,), roughness=0.1, tilt=0
    )
    made = paint_tiles(params, Canvas((400, 400), (0.4, 0.4)), rng_for(1, "t"))
    assert made.height_m[50, 50] - made.height_m[0, 0] > 0.0008
    assert made.roughness[0, 0] - made.roughness[50, 50] > 0.5


def test_a_checker_takes_turns() -> None:
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.1)
    params = CeramicTile(
        laying=laying, colors=(WHITE, BLACK), color_order=ColorAssignment.SORT, variety=0, glaze_pooling=0
    )
    light = paint_tiles(params, Canvas((200, 200), (0.4, 0.4)), rng_for(1, "t")).albedo[..., 0]
    middles = light[25::50, 25::50] > 0.5
    assert (middles != np.roll(middles, 1, axis=0)).all()
    assert (middles != np.roll(middles, 1, axis=1)).all()


def test_a_full_coat_of_paint_hides_the_brick() -> None:
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.075, length_m=0.225, bond=0.5)
    bare = FiredClay(laying=laying, colors=("#a03020",))
    coated = bare.replace(coat_color=WHITE, coat_share=1.0, paint_share=1.0)
    canvas = Canvas((180, 180), (0.9, 0.9))
    assert paint_clay(bare, canvas, rng_for(1, "c")).albedo[..., 2].mean() < 0.5
    painted = paint_clay(coated, canvas, rng_for(1, "c"))
    assert painted.albedo[..., 2].mean() > 0.85
    assert np.ptp(painted.height_m) > 0.003  # the bond still stands out


def test_boards_are_as_wide_as_stated(subtests: pytest.Subtests) -> None:
    for profile in BoardProfile:
        with subtests.test(profile=profile):
            params = PaintedBoards(color="#808080", profile=profile, pitch_m=0.1, gap_m=0.012, depth_m=0.005, grain=0.0)
            made = paint_boards(params, Canvas((100, 400), (0.8, 0.2)), rng_for(1, "b"))
            relief = made.height_m.mean(axis=0)
            assert runs(relief) == (16 if profile is BoardProfile.BEAD else 8)
            level = paint_boards(params.replace(horizontal=True), Canvas((400, 100), (0.2, 0.8)), rng_for(1, "b"))
            np.testing.assert_array_equal(level.height_m, made.height_m.T)


def test_plaster_holds_its_color_and_its_relief_hangs_on_relief(subtests: pytest.Subtests) -> None:
    for hand in PlasterFinish:
        with subtests.test(hand=hand):
            params = Plaster(color="#808080", second="#606060", technique=hand, strength=0.5, relief=1.0)
            canvas = Canvas((256, 256), (0.8, 0.8))
            made = paint_plaster(params, canvas, rng_for(1, "p"))
            assert float(made.albedo.mean()) == pytest.approx(0.5, abs=0.05)
            flat = paint_plaster(params.replace(relief=0.0), canvas, rng_for(1, "p"))
            assert np.ptp(flat.height_m) == 0.0 < np.ptp(made.height_m) < 0.02


def test_formwork_is_as_large_as_stated(subtests: pytest.Subtests) -> None:
    for form in [Formwork.BOARDS, Formwork.PANELS]:
        with subtests.test(form=form):
            params = Concrete(color="#a0a0a0", second="#a0a0a0", formwork=form, formwork_unit_m=0.2, cloudy=0, holes=0)
            made = paint_concrete(params, Canvas((400, 400), (0.8, 0.8)), rng_for(1, "c"))
            dark = made.albedo.mean(axis=(1, 2))
            assert runs(-dark) == 4


def test_tin_plates_repeat_exactly_but_for_their_dents() -> None:
    params = PressedTin(color="#c0c0c0", hollow_color="#404040", plate_m=0.3)
    made = paint_tin(params, Canvas((240, 240), (0.6, 0.6)), rng_for(1, "t"))
    first, second = made.height_m[:120, :120], made.height_m[120:, 120:]
    assert np.abs(first - second).max() < 0.001 < np.ptp(first)


def test_designs_use_all_their_inks_and_go_on_over_the_joint(subtests: pytest.Subtests) -> None:
    for design in TileDesign:
        with subtests.test(design=design):
            inks = 1 + max(number for _, number in DESIGNS[design](np.zeros((1, 1)), np.zeros((1, 1))))
            colors = ("#ffffff", "#ff0000", "#00ff00", "#0000ff")[:inks]
            params = Encaustic(design=design, colors=colors, wear=0, bleed=0, variety=0, joint=Joint(width_m=0))
            made = paint_cement(params, Canvas((128, 128), (0.4, 0.4)), rng_for(1, "e")).albedo
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
            params = PrintedPaper(ground=WHITE, inks=(BLACK,), repeat=repeat, width_m=0.2, height_m=0.2)
            light = paint_printed(params, Canvas((256, 256), (0.4, 0.4)), rng_for(1, "r")).albedo[..., 0]
            np.testing.assert_allclose(light[:128, :128], light[128:, 128:], atol=0.45)
            assert seam(light).worst < 2.0
            assert 0.02 < float(1 - light.mean()) < 0.8


def test_plants_grow_over_the_border(subtests: pytest.Subtests) -> None:
    for growth in FoliageKind:
        with subtests.test(growth=growth):
            params = FoliagePaper(
                ground=WHITE, inks=("#204020", "#406040", "#608060", "#a0b0a0"), growth=growth, size_m=0.3
            )
            light = paint_foliage(params, Canvas((200, 200), (0.9, 0.9)), rng_for(1, "g")).albedo
            assert seam(light).worst < 2.0
            assert 0.04 < float((light.mean(axis=2) < 0.85).mean()) < 0.999


@pytest.mark.parametrize("sort", [ResilientSort.STUDDED, ResilientSort.WOVEN, ResilientSort.TREAD])
def test_studs_are_as_far_apart_as_stated(sort: ResilientSort) -> None:
    params = ResilientFloor(colors=("#404040", "#808080"), material=sort, grain_m=0.05)
    made = paint_soft(params, Canvas((240, 240), (0.4, 0.4)), rng_for(1, "s"))
    row = made.height_m[:, 15]
    assert runs(row) == (8 if sort is not ResilientSort.WOVEN else runs(row))
    assert 0.0005 < np.ptp(made.height_m) < 0.02
