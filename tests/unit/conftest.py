"""What several folders of tests share: a kitchen that was built and checked once, a project."""

from __future__ import annotations

import fcntl
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from casa_assets.layouts.run import check, scene_folders
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.show.stills import kitchen
from tests.support.program.projects import Project, project_in

SMALLEST = kitchen.PictureSettings(64, 48, 1)
RECIPE = SceneRecipe("one_wall_small", "coastal")


@pytest.fixture(scope="session")
def checked_kitchen(common: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, SceneResult]:
    """A folder of scenes with one in it, and its verdict; its pictures are tiny.

    The first process that asks builds and checks it; each has a copy of its own.
    """
    first, out = common / "first_checked", tmp_path_factory.mktemp("checked")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check, "CHECK_FRAME", SMALLEST)
        # The function stays the one that the key of pictures is made from; only its own defaults are others.
        patch.setattr(scene_folders.draw_cameras, "__defaults__", ((), SMALLEST, "start"))
        with (common / "first_checked.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            check.check_one(RECIPE, first)
        shutil.copytree(first, out, symlinks=True, dirs_exist_ok=True)
        return out, check.check_one(RECIPE, out)


@pytest.fixture
def project(tmp_path: Path) -> Iterator[Project]:
    """Write files into a project in the folder of the test, and use it until the test ends."""
    with project_in(tmp_path) as written:
        yield written
