"""Path-traced stills by Blender's Cycles: an asset and a kitchen, without a display or faults, the same each time."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import median_filter, rank_filter

from casa_assets.core.system import BLENDER_VARIABLE
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.scene_folders import BuildOptions, build_all
from casa_assets.show.stills.photoreal import Still, StillSettings, asset_still, scene_stills
from tests.support.program.environments import python_of

pytestmark = pytest.mark.consumers
BLACK = 2  # 8-bit value; the tone curve gives anything that some light reaches more
FIREFLY_STEP = 100  # 8-bit brightness of a pixel above all but one of its 24 neighbours, and above their median
SMALL = StillSettings(width_px=240, height_px=135, samples=16)


@pytest.fixture(autouse=True)
def there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(BLENDER_VARIABLE, str(python_of("blender")))


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("photoreal") / "scenes"
    (result,) = build_all([SceneRecipe("one_wall_small", "coastal")], out, 1, BuildOptions(drawn=False))
    assert result.folder, result.message
    return Path(result.folder)


@pytest.fixture(scope="module")
def stills(kitchen: Path) -> dict[str, Still]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(BLENDER_VARIABLE, str(python_of("blender")))
        return {still.name: still for still in scene_stills(kitchen, settings=SMALL)}


def faults(still: Still) -> tuple[int, int]:
    """Numbers of pixels that no light has reached, and of those that are far brighter than all that is round them."""
    brightest = still.pixels.max(axis=2).astype(np.int16)
    # The third brightest of 5 x 5: a firefly and its fringe are two of them.
    others, middle = rank_filter(brightest, rank=-3, size=5), median_filter(brightest, size=5)
    firefly = (brightest - others > FIREFLY_STEP) & (brightest - middle > FIREFLY_STEP)
    return int((brightest < BLACK).sum()), int(firefly.sum())


def test_a_kitchen_is_drawn_from_inside_and_from_above(stills: dict[str, Still]) -> None:
    assert list(stills) == ["eye", "cutaway"]
    for still in stills.values():
        assert still.pixels.shape == (135, 240, 3)
        assert faults(still) == (0, 0), still.name
        assert 60 < still.pixels.mean() < 215
        assert len(np.unique((still.pixels // 8).reshape(-1, 3), axis=0)) > 300
    assert stills["eye"].pixels[:8].mean() > 60, "light is missing at the ceiling"


def test_the_same_bytes_twice(kitchen: Path, stills: dict[str, Still]) -> None:
    again = next(scene_stills(kitchen, ["eye"], SMALL)).png
    assert again == stills["eye"].png
    assert Image.open(io.BytesIO(again)).info == {}


def test_an_open_appliance_shows_its_inside(kitchen: Path) -> None:
    (layer,) = (kitchen.parent / "assets" / "usd").glob("microwave_*/microwave_*.usda")
    shut, open_ = asset_still(layer, SMALL, "closed"), asset_still(layer, SMALL, "open")
    assert faults(open_) == (0, 0)
    assert np.abs(shut.pixels.astype(int) - open_.pixels).max(axis=2).mean() > 5
