"""Checks of textures: seams, repairs, distances, limits; pictures of finishes."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.core.numeric import rng_for
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import Status
from casa_assets.model.registry.rows import Surface, TextureRecipe
from casa_assets.textures import canvas
from casa_assets.textures.check import TABLE, Picture, Pictures, check_pictures, check_set, jump, repair, seam
from casa_assets.textures.distance import NEARLY_ALIKE, TextureDescriptor, closest_pairs, describe_texture, distance
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


def changed(tile_m: tuple[float, float] = (1.0, 1.0), size_bytes: int = 900_000, **planes: Any) -> Pictures:
    """The good one with other planes: base, normal, rough."""
    told = {name: plane.astype(np.uint8) for name, plane in planes.items()}
    return replace(good(), id="bad", tile_m=tile_m, size_bytes=size_bytes, **told)


def _bad() -> Mapping[str, Pictures]:
    one = good()
    base = one.base.astype(np.float64)
    x = np.linspace(0.0, 1.0, SIZE)[None, :, None]
    flat = np.where(np.arange(3) == 2, 255, np.full_like(one.normal, 128))
    clipped = np.where(np.arange(SIZE)[:, None, None] < 80, 255, base)
    leaning = np.tile(np.rint(127.5 + 127.5 * np.array([0.1, 0.0, np.sqrt(0.99)])), (256, 256, 1))
    leaning[::2, ::2] = (128, 128, 255)
    short = one.normal.astype(np.float64)
    short[10:20, 10:20] = (128, 128, 200)
    wave = 128 + 34 * np.sin(2 * np.pi * x + 0.8)
    rough = np.where(np.arange(256)[:, None] < 60, 2, one.rough)
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
    units = registry.load().limit_units
    assert {row.limit: row.unit for row in TABLE} == {row.limit: units[row.limit] for row in TABLE}


@pytest.mark.parametrize("code", [row.code for row in TABLE])
def test_a_bad_one_trips_exactly_its_code(code: str) -> None:
    report = check_pictures(BAD[code], LIMITS)
    failed = [r.code for r in report.results if r.status is Status.FAILED]
    assert [i.code for i in report.issues] == failed == [code]


def test_a_set_is_full_and_varied() -> None:
    picture = good().base[::4, ::4] / 255.0
    shades = {f"one_{n}": describe_texture(picture * (0.4 + 0.12 * n), (1.0, 1.0)) for n in range(5)}
    assert check_set("wall", shades, {**LIMITS, "texture_set_count": 5.0}).passed
    assert [i.code for i in check_set("wall", shades, LIMITS).issues] == ["TEX012"]
    twins = check_set("wall", dict.fromkeys(("one", "two"), shades["one_4"]), {**LIMITS, "texture_set_count": 2.0})
    assert [(i.code, i.pointer) for i in twins.issues] == [("TEX013", "one two")]


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


def clouds(seed: int = 1, size: int = 192) -> Picture:
    """A picture that repeats: coloured noise."""
    rng = rng_for(seed, "clouds")
    planes = [0.5 + 0.35 * canvas.fbm((size, size), (6, 6), rng, 4) for _ in range(3)]
    return np.clip(np.stack(planes, axis=-1), 0.0, 1.0).astype(np.float32)


def bricks(size: int = 240) -> Picture:
    """Running bond of 8 by 6 with a joint on the border, which is as it should be."""
    y, x = np.mgrid[0:size, 0:size] / size
    row = np.floor(y * 8).astype(int)
    along = x * 6 + 0.5 * (row % 2)
    tone = rng_for(3, "bricks").uniform(0.4, 0.7, (8, 6))[row, np.floor(along).astype(int) % 6]
    joint = (np.abs(np.mod(y * 8 + 0.5, 1) - 0.5) < 0.06) | (np.abs(np.mod(along + 0.5, 1) - 0.5) < 0.045)
    return np.repeat(np.where(joint, 0.9, tone)[..., None], 3, axis=2).astype(np.float32)


def test_what_repeats_has_no_seam_and_a_cut_is_found_in_its_direction() -> None:
    assert seam(clouds()).worst < 1.2
    assert seam(bricks()).worst < 1.2
    assert jump(clouds()).worst < 1.5
    for axis in (0, 1):
        cut = np.take(clouds(), range(130), axis=axis)
        found = seam(cut)
        across, along = (found.y, found.x) if axis == 0 else (found.x, found.y)
        assert across > 2.5
        assert along < 1.2
        assert seam(cut[..., 0]).worst == pytest.approx(seam(cut[..., :1]).worst)  # grey pictures have seams too


@pytest.mark.parametrize("lit", [False, True])
def test_repair_leaves_a_picture_that_repeats(lit: bool) -> None:
    cut = clouds()[:150, :140]
    if lit:
        cut = cut * np.linspace(0.8, 1.15, 140, dtype=np.float32)[None, :, None]
    repaired = repair(cut)
    assert seam(cut).worst > 2.5
    assert seam(repaired).worst < 1.2
    assert repaired.dtype == np.float32
    assert 0.0 <= repaired.min() <= repaired.max() <= 1.0
    assert repaired.mean(axis=(0, 1)) == pytest.approx(cut.mean(axis=(0, 1)), abs=0.03)
    assert np.array_equal(repaired, repair(cut))
    assert all(0.55 * old <= new <= old for new, old in zip(repaired.shape[:2], cut.shape[:2], strict=True))


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
