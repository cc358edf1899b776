"""Blender: path-traced stills of an asset and a kitchen, the same each time; `.blend` files, of which nothing runs."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import median_filter, rank_filter

from casa_assets.core.system import BLENDER_VARIABLE
from casa_assets.errors import Rejected
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.scene_folders import BuildOptions, build_all
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Up
from casa_assets.show.stills.photoreal import Still, StillSettings, asset_still, scene_stills
from tests.support.mesh.mesh_files import QUARTERS, codes_of, load_path, png
from tests.support.program.environments import printed, python_of

pytestmark = pytest.mark.consumers
BLACK = 2  # 8-bit value; the tone curve gives anything that some light reaches more
FIREFLY_STEP = 100  # 8-bit brightness of a pixel above all but one of its 24 neighbours, and above their median
SMALL = StillSettings(width_px=240, height_px=135, samples=16)


@pytest.fixture(scope="module", autouse=True)
def blender() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(BLENDER_VARIABLE, str(python_of("blender")))
        yield


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("photoreal") / "scenes"
    (result,) = build_all([SceneRecipe("one_wall_small", "coastal")], out, 1, BuildOptions(drawn=False))
    assert result.folder, result.message
    return Path(result.folder)


def faults(still: Still) -> tuple[int, int]:
    """Numbers of pixels that no light has reached, and of those that are far brighter than all that is round them."""
    brightest = still.pixels.max(axis=2).astype(np.int16)
    # The third brightest of 5 x 5: a firefly and its fringe are two of them.
    others, middle = rank_filter(brightest, rank=-3, size=5), median_filter(brightest, size=5)
    firefly = (brightest - others > FIREFLY_STEP) & (brightest - middle > FIREFLY_STEP)
    return int((brightest < BLACK).sum()), int(firefly.sum())


def test_a_kitchen_is_drawn_from_inside_and_from_above_with_the_same_bytes_twice(kitchen: Path) -> None:
    stills = {still.name: still for still in scene_stills(kitchen, settings=SMALL)}
    assert list(stills) == ["eye", "cutaway"]
    for still in stills.values():
        assert still.pixels.shape == (135, 240, 3)
        assert faults(still) == (0, 0), still.name
        assert 60 < still.pixels.mean() < 215
        assert len(np.unique((still.pixels // 8).reshape(-1, 3), axis=0)) > 300
    assert stills["eye"].pixels[:8].mean() > 60, "light is missing at the ceiling"
    again = next(scene_stills(kitchen, ["eye"], SMALL)).png
    assert again == stills["eye"].png
    assert Image.open(io.BytesIO(again)).info == {}


def test_an_open_appliance_shows_its_inside(kitchen: Path) -> None:
    (layer,) = (kitchen.parent / "assets" / "usd").glob("microwave_*/microwave_*.usda")
    shut, open_ = asset_still(layer, SMALL, "closed"), asset_still(layer, SMALL, "open")
    assert faults(open_) == (0, 0)
    assert np.abs(shut.pixels.astype(int) - open_.pixels).max(axis=2).mean() > 5


@pytest.fixture(scope="module")
def blends(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("blends")
    (folder / "outside").mkdir()
    (folder / "outside" / "secret.png").write_bytes(png(QUARTERS))
    (folder / "in").mkdir()
    printed("blender", "make_blends.py", folder / "in", folder / "outside" / "secret.png", folder / "canary")
    return folder


def test_a_blend_is_read_with_its_unit_axis_and_packed_picture(blends: Path) -> None:
    model = load_path(blends / "in" / "sound.blend")
    assert model.up is Up.Z
    assert model.metres_per_unit == pytest.approx(0.01)
    points = model.parts[0].mesh.vertices
    assert np.allclose(points.min(axis=0), (-5, -5, 15), atol=1e-5)
    assert np.allclose(points.max(axis=0), (5, 5, 25), atol=1e-5)
    assert model.parts[0].material.base_color_texture is not None


def test_nothing_of_a_blend_is_run_and_no_picture_of_the_machine_is_taken_in(blends: Path) -> None:
    model = load_path(blends / "in" / "hostile.blend")
    assert not (blends / "canary").exists()
    assert model.parts[0].material.base_color_texture is None
    assert codes.FEATURE_IGNORED in codes_of(model)


def test_a_broken_blend_is_rejected(blends: Path) -> None:
    data = (blends / "in" / "hostile.blend").read_bytes()
    for name, broken in (("cut", data[: len(data) // 2]), ("noise", data[:12] + b"\xff" * 5000)):
        (blends / "in" / f"{name}.blend").write_bytes(broken)
        with pytest.raises(Rejected) as error:
            load_path(blends / "in" / f"{name}.blend")
        assert error.value.code in (codes.BLENDER_FAILED, codes.NO_GEOMETRY)
