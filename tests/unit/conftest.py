"""What several folders of tests share: a kitchen that was built and checked once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from casa_assets.pipeline.kitchens import check, scene_folders
from casa_assets.pipeline.kitchens.resolve import SceneRecipe
from casa_assets.pipeline.kitchens.scene_folders import SceneResult
from casa_assets.preview import kitchen

SMALLEST = kitchen.PictureSettings(64, 48, 1)


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of the tests' own, so that they neither use nor fill the user's."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CASA_ASSETS_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="session")
def checked_kitchen(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, SceneResult]:
    """A folder of scenes with one in it, and its verdict; its pictures are tiny."""
    out = tmp_path_factory.mktemp("checked")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check, "CHECK_FRAME", SMALLEST)
        # The function stays the one that the key of pictures is made from; only its own defaults are others.
        patch.setattr(scene_folders.draw_cameras, "__defaults__", ((), SMALLEST, "start"))
        return out, check.check_one(SceneRecipe("one_wall_small", "coastal"), out)
