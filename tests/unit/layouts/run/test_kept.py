"""A kitchen that is there is known by a remembered key, until anything that it could be made from changes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casa_assets.cache import store
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import isaac_lab
from casa_assets.formats.usd import kitchen as usd
from casa_assets.layouts.run import kept
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.scene_files import LIGHT_FILE, OVERVIEW, SCENE_JSON, WRITTEN

RECIPE = SceneRecipe("l_small", "coastal")


@pytest.fixture
def out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files of a kitchen, whose key is remembered in a cache of its own."""
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "cache"))
    kept.remember_kitchen_key(RECIPE, "of a kitchen")
    key = kept.written_key("of a kitchen")
    folder = tmp_path / "scenes" / RECIPE.scene_id
    folder.mkdir(parents=True)
    for name in (*WRITTEN, f"{OVERVIEW}.png"):
        (folder / name).touch()
    (folder / SCENE_JSON).write_text(json.dumps({"key": key, "picture_key": kept.picture_key(key)}))
    return tmp_path / "scenes"


def test_what_is_written_has_these_names() -> None:
    assert set(WRITTEN) == {mjcf.FILE, LIGHT_FILE, usd.FILE, usd.NESTED_FILE, isaac_lab.FILE}


def test_it_is_kept_while_its_files_are_there(out: Path) -> None:
    found = kept.kept_scene(RECIPE, out, drawn=True)
    assert found is not None
    assert (found.kept, found.folder) == (True, str(out / RECIPE.scene_id))
    (out / RECIPE.scene_id / f"{OVERVIEW}.png").unlink()
    assert kept.kept_scene(RECIPE, out, drawn=True) is None
    assert kept.kept_scene(RECIPE, out, drawn=False) is not None, "a picture is not always wanted"


@pytest.mark.parametrize("name", [WRITTEN[0], SCENE_JSON])
def test_not_without_one_of_its_files(name: str, out: Path) -> None:
    (out / RECIPE.scene_id / name).unlink()
    assert kept.kept_scene(RECIPE, out, drawn=False) is None


def test_another_recipe_or_another_state_of_the_program_is_not_known(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert kept.remembered_kitchen_key(SceneRecipe("l_small", "coastal", seed=1)) == ""
    monkeypatch.setattr(store, "state_of_everything", lambda: "after an edit")
    assert kept.kept_scene(RECIPE, out, drawn=True) is None


def test_what_may_be_older_than_a_change_is_not_remembered(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A long run has read the registry at its start; a file that is edited meanwhile must not be taken for read."""
    edited = SceneRecipe("galley", "coastal")
    monkeypatch.setattr(store, "last_change_ns", lambda: store.STARTED_NS + 1)
    kept.remember_kitchen_key(edited, "of before the edit")
    assert kept.remembered_kitchen_key(edited) == ""
