"""What looks alike is near, what looks different is far, and the two do not overlap in our own sets."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.model.registry.rows import Surface, TextureRecipe
from casa_assets.textures import canvas
from casa_assets.textures.canvas import Map
from casa_assets.textures.distance import (
    NEARLY_ALIKE,
    TextureDescriptor,
    closest_pairs,
    describe_texture,
    distance,
    oklab,
    pairwise,
)
from casa_assets.textures.run.recipes import layers_of, recipes

TILE = (0.8, 0.8)


def stripes(seed: int = 1, across_m: float = 0.02, color: tuple[float, float, float] = (0.6, 0.5, 0.4)) -> Map:
    """Upright streaks about a colour."""
    rng = rng_for(seed, "stripes")
    cells = (2, round(TILE[0] / across_m))
    tone = 1.0 + 0.25 * canvas.gradient((160, 160), cells, rng)
    return np.asarray(np.clip(np.array(color)[None, None, :] * tone[..., None], 0.0, 1.0), dtype=np.float32)


def seen(albedo: Map) -> TextureDescriptor:
    return describe_texture(albedo, TILE)


def test_same_is_zero_and_distance_is_symmetric() -> None:
    one, other = seen(stripes(1)), seen(stripes(1, 0.1))
    assert distance(one, one) == 0.0
    assert distance(one, other) == distance(other, one) > 0.0
    assert distance(one, seen(stripes(2))) < NEARLY_ALIKE
    moved = np.roll(stripes(1), (37, 59), axis=(0, 1))
    assert distance(one, seen(moved)) == pytest.approx(0.0, abs=1e-3)


def test_what_is_plainly_different_is_far(subtests: pytest.Subtests) -> None:
    for other in [
        stripes(1, color=(0.6, 0.55, 0.5)),
        stripes(1, color=(0.55, 0.5, 0.5)),
        stripes(1, across_m=0.1),
        stripes(1).swapaxes(0, 1),
        stripes(1) * 0 + stripes(1).mean(axis=(0, 1)),
    ]:
        with subtests.test(other=other):
            assert distance(seen(stripes(1)), seen(other)) > NEARLY_ALIKE


def test_gloss_and_relief_count() -> None:
    picture = stripes(1)
    flat, rough = np.zeros((160, 160)), 0.002 * canvas.gradient((160, 160), (20, 20), rng_for(1, "relief"))
    matt, shiny = np.full((160, 160), 0.8), np.full((160, 160), 0.1)
    plain = describe_texture(picture, TILE, matt, flat)
    assert distance(plain, describe_texture(picture, TILE, shiny, flat)) > NEARLY_ALIKE
    assert distance(plain, describe_texture(picture, TILE, matt, rough)) > 0.5


def test_size_in_metres_counts_not_pixels() -> None:
    """The same picture on a tile of twice the size has stripes twice as wide."""
    assert distance(describe_texture(stripes(1), (0.8, 0.8)), describe_texture(stripes(1), (1.6, 1.6))) > 0.8
    fine, coarse = stripes(1), stripes(1)[::2, ::2]
    assert distance(seen(fine), seen(coarse)) < 0.5


def test_pairs_are_sorted_and_below_the_limit() -> None:
    looks = {"a": seen(stripes(1)), "b": seen(stripes(2)), "c": seen(stripes(1, color=(0.2, 0.3, 0.5)))}
    pairs = closest_pairs(looks)
    assert pairs[0][1:] == ("a", "b")
    assert [p[0] for p in pairs] == sorted(p[0] for p in pairs)
    assert len(pairs) == 3
    assert [p[1:] for p in closest_pairs(looks, below=NEARLY_ALIKE)] == [("a", "b")]
    table = pairwise(list(looks.values()))
    assert table[0, 1] == pytest.approx(pairs[0][0])
    assert np.array_equal(table, table.T)
    assert pairwise([]).shape == (0, 0)
    assert closest_pairs({}) == ()


def test_oklab_of_known_colours() -> None:
    """Ref: the table of B. Ottosson's article, from XYZ of the sRGB primaries."""
    found = oklab(np.array([[[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]]))[0]
    assert found[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)
    assert found[1] == pytest.approx([0.628, 0.2249, 0.1258], abs=1e-3)
    assert found[2] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def look(recipe: TextureRecipe) -> TextureDescriptor:
    picture = layers_of(recipe, 128)
    return describe_texture(picture.albedo, recipe.tile_m, picture.roughness, picture.height_m)


@pytest.mark.content("surface", "{surface.value}", keep=0)
@pytest.mark.parametrize("surface", [Surface.COUNTER, Surface.CABINET])
def test_every_pair_of_ours_is_distinct_and_two_seeds_are_nearly_alike(surface: Surface) -> None:
    looks = {name: look(recipe) for name, recipe in recipes()[surface].items()}
    assert len(looks) == 100
    assert closest_pairs(looks, below=NEARLY_ALIKE) == ()
    for name, recipe in list(recipes()[surface].items())[::3]:
        assert distance(looks[name], look(recipe.replace(seed=recipe.seed + 7777))) <= NEARLY_ALIKE, name
