"""Each check of textures has a good example that stays silent and a bad one that trips exactly that code."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.core.numeric import rng_for
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import Status
from casa_assets.model.registry.rows import Surface
from casa_assets.textures import canvas
from casa_assets.textures.check import TABLE, Pictures, check_pictures, check_set, pictures_of
from casa_assets.textures.distance import TextureDescriptor, describe_texture
from casa_assets.textures.finish import finish, normals, swatch
from casa_assets.textures.run.recipes import layers_of, recipes

LIMITS = registry.load().limits
STONE = Substance(id="stone", density=2600, static_friction=0.6, dynamic_friction=0.5)
SIZE = 512


def good() -> Pictures:
    """A mottled grey of a metre."""
    cloud = canvas.fbm((SIZE, SIZE), (24, 24), rng_for(1, "check"), 4)
    base = np.clip(128 + 30 * cloud, 0, 255).astype(np.uint8)
    relief = 0.0004 * canvas.gradient((256, 256), (40, 40), rng_for(2, "check"))
    rough = np.clip(150 + 20 * cloud[::2, ::2], 0, 255).astype(np.uint8)
    return Pictures("good", (1.0, 1.0), np.stack([base] * 3, axis=2), normals(relief, (1.0, 1.0)), rough, 900_000)


def changed(
    base: np.ndarray | None = None,
    normal: np.ndarray | None = None,
    rough: np.ndarray | None = None,
    tile_m: tuple[float, float] = (1.0, 1.0),
    size_bytes: int = 900_000,
) -> Pictures:
    one = good()
    pairs = ((base, one.base), (normal, one.normal), (rough, one.rough))
    planes = [own if given is None else given.astype(np.uint8) for given, own in pairs]
    return Pictures("bad", tile_m, planes[0], planes[1], planes[2], size_bytes)


def _bad() -> Mapping[str, Pictures]:
    one = good()
    base = one.base.astype(np.float64)
    x = np.linspace(0.0, 1.0, SIZE)[None, :, None]
    flat = np.full_like(one.normal, 128)
    flat[..., 2] = 255
    clipped = base.copy()
    clipped[:80] = 255
    leaning = np.zeros((256, 256, 3))
    leaning[:] = np.rint(127.5 + 127.5 * np.array([0.1, 0.0, np.sqrt(0.99)]))
    leaning[::2, ::2] = (128, 128, 255)
    short = one.normal.astype(np.float64)
    short[10:20, 10:20] = (128, 128, 200)
    wave = 128 + 34 * np.sin(2 * np.pi * x + 0.8)
    rough = one.rough.copy()
    rough[:60] = 2
    return {
        "TEX001": changed(base=base + 40 * (x - 0.5)),
        "TEX002": changed(base=base * 0.08 + 2),
        "TEX003": changed(base=scattered(clipped)),
        "TEX004": changed(base=np.full_like(base, 128), normal=flat, rough=np.full((256, 256), 120)),
        "TEX005": changed(normal=short),
        "TEX006": changed(normal=leaning),
        "TEX007": changed(rough=scattered(rough)),
        "TEX008": changed(tile_m=(2.0, 2.0)),
        "TEX009": changed(tile_m=(0.3, 0.3)),
        "TEX010": changed(base=wave + 0 * base + 4 * (base - 128) / 30),
        "TEX011": changed(size_bytes=4_000_000),
    }


def scattered(image: np.ndarray) -> np.ndarray:
    """The pixels of a picture spread over it, so that neither a seam nor a blotch comes of changed rows."""
    pixels = image.reshape(image.shape[0] * image.shape[1], -1)
    return np.asarray(pixels[rng_for(4, "check").permutation(len(pixels))].reshape(image.shape))


BAD = _bad()


def test_the_good_one_passes_and_says_so() -> None:
    report = check_pictures(good(), LIMITS)
    assert report.passed
    assert [r.code for r in report.results] == [row.code for row in TABLE]
    assert all(r.passed and r.number is not None and r.limit is not None for r in report.results)


@pytest.mark.parametrize("code", [row.code for row in TABLE])
def test_a_bad_one_trips_exactly_its_code(code: str) -> None:
    report = check_pictures(BAD[code], LIMITS)
    assert [i.code for i in report.issues] == [code]
    assert [r.code for r in report.results if r.status is Status.FAILED] == [code]


def test_every_limit_is_in_the_registry_with_the_unit_of_its_row() -> None:
    units = registry.load().limit_units
    assert {row.limit: row.unit for row in TABLE} == {row.limit: units[row.limit] for row in TABLE}
    assert len({row.code for row in TABLE}) == len(TABLE)


def looks(count: int, alike: bool = False) -> dict[str, TextureDescriptor]:
    picture = good().base[::4, ::4] / 255.0
    shades = [1.0 if alike else 0.4 + 0.6 * n / count for n in range(count)]
    return {f"one_{n}": describe_texture(picture * shade, (1.0, 1.0)) for n, shade in enumerate(shades)}


def test_a_set_is_full_and_varied() -> None:
    assert check_set("wall", looks(5), {**LIMITS, "texture_set_count": 5.0}).passed
    assert [i.code for i in check_set("wall", looks(5), LIMITS).issues] == ["TEX012"]
    twins = check_set("wall", looks(2, alike=True), {**LIMITS, "texture_set_count": 2.0})
    assert [(i.code, i.pointer) for i in twins.issues] == [("TEX013", "one_0 one_1")]


def test_finish_of_a_recipe_decodes_to_what_was_painted() -> None:
    recipe = recipes()[Surface.WALL]["subway_white_bevel"]
    layers = layers_of(recipe, 128)
    pictures = pictures_of(finish(recipe.id, recipe.tile_m, layers, STONE))
    np.testing.assert_allclose(pictures.base / 255, layers.albedo, atol=0.003)
    rows, columns = (n // 2 for n in layers.roughness.shape)
    blocks = layers.roughness[: 2 * rows, : 2 * columns].reshape(rows, 2, columns, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(pictures.rough / 255, blocks, atol=0.003)


def test_normals_have_the_slope_of_the_relief_in_metres() -> None:
    x = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)[None, :]
    relief = np.broadcast_to(0.01 * np.sin(x), (256, 256)).astype(np.float32)
    vectors = normals(relief, (0.5, 0.5)).astype(np.float64) / 127.5 - 1.0
    steepest = 0.01 * 2.0 * np.pi / 0.5
    slope = -vectors[..., 0] / vectors[..., 2]
    assert slope.max() == pytest.approx(steepest, rel=0.05)
    assert slope[0, 0] > 0.0  # it rises to the right, so its normal leans to the left
    down = normals(np.ascontiguousarray(relief.T), (0.5, 0.5)).astype(np.float64) / 127.5 - 1.0
    assert down[0, 0, 1] > 0.05  # it rises downwards, so its normal leans up: y is up


def test_a_finish_without_a_tile_is_refused() -> None:
    made = finish("x", (1.0, 1.0), layers_of(recipes()[Surface.WALL]["tin_ceiling_white"], 64), STONE)
    bare = made.replace(material=made.material.replace(normal_texture=None))
    with pytest.raises(ValueError, match="lacks"):
        pictures_of(bare)


def test_png_bytes_are_the_same_each_time_and_hold_no_metadata() -> None:
    recipe = recipes()[Surface.FLOOR]["oak_natural_plank"]
    one, two = (finish("x", recipe.tile_m, layers_of(recipe, 64), STONE) for _ in range(2))
    assert one.digest == two.digest
    for texture in one.material.textures:
        with Image.open(io.BytesIO(texture.png)) as image:
            assert image.info == {}


def test_swatch_cuts_true_metres_and_shows_relief() -> None:
    base = np.zeros((200, 200, 3), dtype=np.uint8)
    base[:, 100:] = 255
    flat = np.full((100, 100, 3), 128, dtype=np.uint8)
    flat[..., 2] = 255
    rough = np.full((100, 100), 230, dtype=np.uint8)
    shown = swatch(Pictures("s", (0.5, 0.5), base, flat, rough, 0), 0.0, side_m=1.0, side_px=80)
    row = shown[40, :, 0] > 120
    assert np.sum(row & ~np.roll(row, 1)) == 2  # two pictures fit into the metre
    wave = np.cos(np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False))[:, None]
    relief = np.broadcast_to(0.02 * wave, (100, 100)).astype(np.float32)  # falls to the middle row, rises below it
    grey = Pictures("s", (0.5, 0.5), np.full((200, 200, 3), 128, np.uint8), normals(relief, (0.5, 0.5)), rough, 0)
    lit = swatch(grey, 0.0, side_m=0.5, side_px=80)
    assert int(lit[60].mean()) - int(lit[20].mean()) > 10  # what faces up catches the light from above
