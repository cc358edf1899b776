"""Every recipe of walls, floors, counters and cabinets tiles and is sound; every kind is used and hangs on its seed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from casa_assets.kitchenware.textures import KINDS, cabinets, counters, floors, objects, walls
from casa_assets.model.registry.rows import Surface, TextureRecipe
from casa_assets.textures.canvas import TextureKind
from casa_assets.textures.distance import oklab
from casa_assets.textures.run.recipes import layers_of, recipes
from casa_assets.textures.seam import seam

pytestmark = pytest.mark.content("code", "textures", keep=0)

SETS = recipes()
KINDS_OF = {
    Surface.WALL: walls.KINDS,
    Surface.FLOOR: floors.KINDS,
    Surface.COUNTER: counters.KINDS,
    Surface.CABINET: cabinets.KINDS,
}
# Of each set: the lowest mean colour, and the highest relief, metres.
BOUNDS = {
    Surface.WALL: (0.06, 0.06),
    Surface.FLOOR: (0.06, 0.06),
    Surface.COUNTER: (0.03, 0.01),
    Surface.CABINET: (0.0, 0.012),
}
PAINTED = [kind for kinds in KINDS_OF.values() for kind in kinds]
ROWS = [(surface, name) for surface, rows in SETS.items() for name in rows]
FIGURED = ("maple_tiger", "eucalyptus_smoked", "birch_rotary", "douglas_fir", "elm_wild")


def of_kind(kind: TextureKind) -> TextureRecipe:
    return next(r for rows in SETS.values() for r in rows.values() if r.kind == kind.name)


def test_there_are_a_hundred_of_each_and_every_kind_is_used() -> None:
    for surface, kinds in KINDS_OF.items():
        assert len(SETS[surface]) == 100
        assert {kind.name for kind in kinds} <= {recipe.kind for recipe in SETS[surface].values()}
    assert len(KINDS) == sum(len(group.KINDS) for group in (walls, floors, counters, cabinets, objects))
    fronts = [recipe.kind for recipe in SETS[Surface.CABINET].values()]
    assert fronts.count("veneer") == pytest.approx(45, abs=3)
    assert fronts.count("painted_front") == pytest.approx(35, abs=3)
    cement = [recipe for recipe in SETS[Surface.FLOOR].values() if recipe.kind == "cement_tile"]
    assert len({json.loads(recipe.params)["design"] for recipe in cement}) >= 14


@pytest.mark.content("texture", "{name}", keep=12)
@pytest.mark.parametrize(("surface", "name"), ROWS)
def test_every_one_is_sound(surface: Surface, name: str) -> None:
    made, (darkest, highest) = layers_of(SETS[surface][name], 128), BOUNDS[surface]
    assert seam(made.albedo).worst < 2.0
    assert made.albedo.dtype == made.height_m.dtype == made.roughness.dtype == np.float32
    assert made.albedo.shape == (*made.height_m.shape, 3)
    assert made.roughness.shape == made.height_m.shape
    assert 0.0 <= made.albedo.min() <= made.albedo.max() <= 1.0
    assert 0.04 <= made.roughness.min() <= made.roughness.max() <= 1.0
    assert darkest < made.albedo.mean() < 0.97
    assert np.ptp(made.height_m) < highest


def test_same_seed_same_bytes_and_another_seed_another_picture(subtests: pytest.Subtests) -> None:
    for kind in PAINTED:
        with subtests.test(kind=kind.name):
            recipe = of_kind(kind)
            one, same, other = (
                layers_of(recipe, 64),
                layers_of(recipe, 64),
                layers_of(recipe.replace(seed=recipe.seed + 1), 64),
            )
            for plane in ("albedo", "height_m", "roughness"):
                assert getattr(one, plane).tobytes() == getattr(same, plane).tobytes()
            assert (one.albedo != other.albedo).any() or (one.height_m != other.height_m).any()


def test_a_coarse_picture_shows_the_same_design(subtests: pytest.Subtests) -> None:
    for kind in PAINTED:
        with subtests.test(kind=kind.name):
            recipe = of_kind(kind)
            fine, coarse = layers_of(recipe, 512).albedo.mean(axis=2), layers_of(recipe, 256).albedo.mean(axis=2)
            step = [n // 32 for n in coarse.shape]
            rows, columns = step[0] * 32, step[1] * 32
            small = coarse[:rows, :columns].reshape(32, step[0], 32, step[1]).mean(axis=(1, 3))
            fine = fine[: 2 * rows, : 2 * columns].reshape(32, 2 * step[0], 32, 2 * step[1]).mean(axis=(1, 3))
            assert np.corrcoef(small.ravel(), fine.ravel())[0, 1] > 0.6  # threads finer than a pixel leave the rest
            assert abs(float(small.mean() - fine.mean())) < 0.02


def test_wood_of_cabinets_stands_upright_and_paint_is_muted(subtests: pytest.Subtests) -> None:
    """Nothing garish: less than half of the chroma of a signal red. Ref: Oklab chroma of #ff0000, 0.26."""
    for name, recipe in SETS[Surface.CABINET].items():
        with subtests.test(name=name):
            if recipe.kind == "veneer":
                light = layers_of(recipe, 256).albedo.mean(axis=2)
                across, along = (float(np.abs(np.diff(light, axis=axis)).mean()) for axis in (1, 0))
                assert across > (0.3 if name in FIGURED else 1.1) * along
            elif recipe.kind == "painted_front":
                lab = oklab(layers_of(recipe, 64).albedo).mean(axis=(0, 1))
                assert np.hypot(lab[1], lab[2]) < 0.125
