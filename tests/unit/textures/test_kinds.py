"""Every recipe tiles and is sound; kinds of fronts, counters, walls, floors and labels do what their numbers say."""

from __future__ import annotations

import json
from typing import Any, get_args

import numpy as np
import pytest
from PIL import Image

from casa_assets.kitchenware.textures import covering, food, laid, wall_panels
from casa_assets.kitchenware.textures.covering import PaperRepeat
from casa_assets.kitchenware.textures.floors import Encaustic
from casa_assets.kitchenware.textures.fronts import PaintCoat, PaintedFront
from casa_assets.kitchenware.textures.kinds import KINDS
from casa_assets.kitchenware.textures.label import Label, Layout, front, lines_in_picture
from casa_assets.kitchenware.textures.motif import DESIGNS, TileDesign
from casa_assets.model.registry.rows import Surface
from casa_assets.textures.canvas import Canvas, rgb
from casa_assets.textures.check import seam
from casa_assets.textures.distance import oklab
from casa_assets.textures.laying import Laying, LayingPattern
from casa_assets.textures.pieces import Joint
from casa_assets.textures.run.recipes import every_recipe, layers_of, recipes
from tests.support.library.pictures import painted, runs, steps

pytestmark = pytest.mark.content("code", "textures", keep=0)

SETS = recipes()
# Of each set: the lowest mean colour, and the highest relief, metres.
BOUNDS = {"wall": (0.06, 0.06), "floor": (0.06, 0.06), "counter": (0.03, 0.01), "cabinet": (0.0, 0.012)}
ROWS = [(surface, name) for surface, rows in SETS.items() for name in rows]
FIGURED = ("maple_tiger", "eucalyptus_smoked", "birch_rotary", "douglas_fir", "elm_wild")
WHITE, BLACK = "#ffffff", "#000000"
GROUT = Joint(color=BLACK, width_m=0.006, coarseness=0.0, rim_drop_m=0.0)
# One recipe of each kind that surfaces have.
PAINTED = {recipe.kind: recipe for rows in reversed(SETS.values()) for recipe in reversed(rows.values())}


def test_there_are_a_hundred_of_each_and_every_kind_is_used() -> None:
    assert {len(rows) for rows in SETS.values()} == {100}
    assert {recipe.kind for recipe in every_recipe().values()} == set(KINDS)
    fronts = [recipe.kind for recipe in SETS[Surface.CABINET].values()]
    assert fronts.count("veneer") == pytest.approx(45, abs=3)
    assert fronts.count("painted_front") == pytest.approx(35, abs=3)
    cement = [json.loads(recipe.params) for recipe in SETS[Surface.FLOOR].values() if recipe.kind == "cement_tile"]
    assert len({params["design"] for params in cement}) >= 14


@pytest.mark.content("texture", "{name}", keep=12)
@pytest.mark.parametrize(("surface", "name"), ROWS)
def test_every_one_is_sound(surface: Surface, name: str) -> None:
    made, (darkest, highest) = layers_of(SETS[surface][name], 128), BOUNDS[surface.value]
    assert seam(made.albedo).worst < 2.0
    assert made.albedo.dtype == made.height_m.dtype == made.roughness.dtype == np.float32
    assert made.albedo.shape == (*made.height_m.shape, 3)
    assert made.roughness.shape == made.height_m.shape
    assert 0.0 <= made.albedo.min() <= made.albedo.max() <= 1.0
    assert 0.04 <= made.roughness.min() <= made.roughness.max() <= 1.0
    assert darkest < made.albedo.mean() < 0.97
    assert np.ptp(made.height_m) < highest


def test_same_seed_same_bytes_another_seed_another_picture() -> None:
    for kind, recipe in PAINTED.items():
        one, same = (layers_of(recipe, 64) for _ in range(2))
        other = layers_of(recipe.replace(seed=recipe.seed + 1), 64)
        for plane in ("albedo", "height_m", "roughness"):
            assert getattr(one, plane).tobytes() == getattr(same, plane).tobytes(), kind
        assert (one.albedo != other.albedo).any() or (one.height_m != other.height_m).any()


def test_a_coarse_picture_shows_the_same_design() -> None:
    for kind, recipe in PAINTED.items():
        fine, coarse = (layers_of(recipe, size).albedo.mean(axis=2) for size in (512, 256))
        step = [n // 32 for n in coarse.shape]
        rows, columns = step[0] * 32, step[1] * 32
        small = coarse[:rows, :columns].reshape(32, step[0], 32, step[1]).mean(axis=(1, 3))
        fine = fine[: 2 * rows, : 2 * columns].reshape(32, 2 * step[0], 32, 2 * step[1]).mean(axis=(1, 3))
        assert np.corrcoef(small.ravel(), fine.ravel())[0, 1] > 0.6, kind  # threads finer than a pixel leave the rest
        assert abs(float(small.mean() - fine.mean())) < 0.02


def test_wood_of_cabinets_stands_upright_and_paint_is_muted() -> None:
    """Nothing garish: less than half of the chroma of a signal red. Ref: Oklab chroma of #ff0000, 0.26."""
    for name, recipe in SETS[Surface.CABINET].items():
        if recipe.kind == "veneer":
            light = layers_of(recipe, 256).albedo.mean(axis=2)
            across, along = (float(np.abs(np.diff(light, axis=axis)).mean()) for axis in (1, 0))
            assert across > (0.3 if name in FIGURED else 1.1) * along, name
        elif recipe.kind == "painted_front":
            lab = oklab(layers_of(recipe, 64).albedo).mean(axis=(0, 1))
            assert np.hypot(lab[1], lab[2]) < 0.125, name


def test_paint_has_its_colour_and_strokes_where_it_is_brushed() -> None:
    coats: tuple[PaintCoat, ...] = ("sprayed", "brushed", "chalk")
    for coat in coats:
        made = painted(PaintedFront(color="#6d8a78", coat=coat, roughness=0.5), "p")
        assert made.albedo.mean(axis=(0, 1)) == pytest.approx(rgb("#6d8a78"), abs=0.01)
        assert float(made.roughness.mean()) == pytest.approx(0.5, abs=0.02)
        across, along = steps(made.height_m)
        assert coat != "brushed" or across > 4 * along


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


def test_metal_tiles_and_shows_its_tool() -> None:
    for tooling in list(laid.MetalTooling):
        made = painted(laid.SheetMetal(color="#b0b0b0", patina_color="#707070", tooling=tooling, mark_m=0.03), "m")
        assert seam(made.albedo).worst < 1.6
        assert made.metallic == 1.0
        across, along = steps(made.albedo[..., 0])
        spans = {"along": (3.0, np.inf), "rolled": (3.0, np.inf), "upright": (0.0, 1 / 3)}
        low, high = spans.get(tooling.value, (0.3, 3.5))
        assert low < along / across < high


def test_subway_tiles_are_as_large_as_stated() -> None:
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.075, length_m=0.15, bond=0.5)
    even: dict[str, Any] = dict.fromkeys(("variety", "glaze_pooling", "tilt", "wave_m"), 0)
    params = wall_panels.CeramicTile(laying=laying, joint=GROUT, colors=(WHITE,), **even)
    light = painted(params, "t", Canvas((300, 450), (0.9, 0.6))).albedo[..., 0]
    assert runs(light[:, 4]) == 8
    assert {runs(light[round((n + 0.5) * 0.075 * 500)]) for n in range(8)} == {6}
    assert float(1.0 - light.mean()) == pytest.approx(1 - (0.069 / 0.075) * (0.144 / 0.15), abs=0.01)


def test_designs_use_all_their_inks_and_go_on_over_the_joint() -> None:
    for design in get_args(TileDesign):
        inks = 1 + max(number for _, number in DESIGNS[design](np.zeros((1, 1)), np.zeros((1, 1))))
        colors = ("#ffffff", "#ff0000", "#00ff00", "#0000ff")[:inks]
        params = Encaustic(design=design, colors=colors, wear=0, bleed=0, variety=0, joint=Joint(width_m=0))
        made = painted(params, "e", Canvas((128, 128), (0.4, 0.4))).albedo
        for color in colors[1:]:
            wanted = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
            assert (np.abs(made - wanted).max(axis=2) < 0.3).mean() > 0.005
        np.testing.assert_allclose(made[:64, :64], made[64:, 64:], atol=0.35)  # the same tile, mottled
        if design != "arcs":  # its rings end at the edge of the tile
            assert seam(made).worst < 2.0


def test_repeats_of_paper_are_as_large_as_stated_and_close() -> None:
    for repeat in get_args(PaperRepeat):
        params = covering.PrintedPaper(ground=WHITE, inks=(BLACK,), repeat=repeat, width_m=0.2, height_m=0.2)
        light = painted(params, "r", Canvas((256, 256), (0.4, 0.4))).albedo[..., 0]
        np.testing.assert_allclose(light[:128, :128], light[128:, 128:], atol=0.45)
        assert seam(light).worst < 2.0
        assert 0.02 < float(1 - light.mean()) < 0.8, repeat


def test_clouds_of_a_cut_face_are_as_large_as_stated() -> None:
    """What is lighter at a place says little of one that is 8 mm away, where clouds are 4 mm large."""
    flesh = food.Section(colors=("#808080",), mottle=1.0, mottle_mm=4.0, wander=0.0)
    light = painted(flesh, "r", Canvas((200, 200), (0.1, 0.1))).albedo[..., 0]
    light = light - light.mean()
    alike = [float((light * np.roll(light, shift, axis=1)).mean() / (light * light).mean()) for shift in (1, 16)]
    assert alike[0] > 0.7
    assert abs(alike[1]) < 0.35


SIZE = (120, 240)
INK, ACCENT = "#101010", "#c02020"
PLAIN = Label(brand="Acme", words=("SOUP", "400 g"), layout=Layout.MINIMAL, ground=("#ffffff",), ink=INK, accent=ACCENT)


def test_lines_lie_where_their_colour_is_seen() -> None:
    brand, word = lines_in_picture(PLAIN, SIZE)
    assert (brand.text, word.text) == ("Acme", "SOUP")
    seen = np.asarray(front(PLAIN, SIZE)[0].resize(SIZE[::-1], Image.Resampling.BOX)) / 255.0
    for line, color in ((brand, ACCENT), (word, INK)):
        inside = line.cover > 0.95
        assert inside.any()
        assert np.abs(seen[inside] - rgb(color)).max() < 0.2
    # The brand stands above the word, and neither covers the other.
    rows = [np.flatnonzero((line.cover > 0.5).any(axis=1)) for line in (brand, word)]
    assert rows[0].max() < rows[1].min()
