"""What a name stands for."""

from __future__ import annotations

from pathlib import Path

import pytest

from casa_assets.errors import OutputError, UnknownId
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.library.library import Library
from casa_assets.show.view.subject import AssetFolder, Kitchen, Member, ModelFile, find

KITCHEN = "one_wall_small__coastal"


def asset_of(boxes: Path) -> Path:
    """The folder of the first asset of the library of boxes."""
    return next(Library(boxes / "library").accepted())


def test_an_asset_by_its_folder_its_file_and_its_id(boxes: Path, tmp_path: Path) -> None:
    folder = asset_of(boxes)
    assert find(str(folder), tmp_path, ()) == AssetFolder(folder)
    assert find(str(folder / "model.xml"), tmp_path, ()) == AssetFolder(folder)
    assert find(folder.name, tmp_path, (tmp_path / "none", boxes / "library")) == AssetFolder(folder)


def test_a_library_is_no_asset_unless_it_holds_one(boxes: Path, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"is a library; name one of its assets: .*" + asset_of(boxes).name):
        find(str(boxes / "library"), tmp_path, ())
    shelf = tmp_path / "lib" / "mug"
    shelf.mkdir(parents=True)
    (shelf / "mug_0").symlink_to(asset_of(boxes))
    assert find(str(tmp_path / "lib"), tmp_path, ()) == AssetFolder(shelf / "mug_0")


def test_a_kitchen_by_its_id_its_folder_and_its_file(tmp_path: Path) -> None:
    recipe = SceneRecipe("one_wall_small", "coastal")
    assert find(KITCHEN, tmp_path, ()) == Kitchen(recipe, tmp_path)
    folder = tmp_path / KITCHEN
    folder.mkdir()
    (folder / "scene.json").write_text("{}", encoding="utf-8")
    (folder / "scene.xml").write_text("<mujoco/>", encoding="utf-8")
    by_path = Kitchen(recipe, tmp_path, is_named_by_path=True)
    assert find(str(folder), Path("elsewhere"), ()) == by_path
    assert find(str(folder / "scene.xml"), Path("elsewhere"), ()) == by_path
    assert by_path.folder == folder
    assert find(f"{KITCHEN}__s7__o40s3", tmp_path, ()) == Kitchen(
        SceneRecipe("one_wall_small", "coastal", 7, objects=40, objects_seed=3), tmp_path
    )


def test_a_scene_of_no_recipe_is_left_to_mujoco(tmp_path: Path) -> None:
    folder = tmp_path / "barn__baroque"
    folder.mkdir()
    (folder / "scene.json").write_text("{}", encoding="utf-8")
    with pytest.raises(UnknownId, match="barn__baroque"):
        find(str(folder), tmp_path, ())
    (folder / "scene.xml").write_text("<mujoco/>", encoding="utf-8")
    found = find(str(folder), tmp_path, ())
    assert isinstance(found, ModelFile)
    assert (found.path, "barn__baroque" in found.why) == (folder / "scene.xml", True)


def test_a_member_of_a_family_or_of_a_category(tmp_path: Path) -> None:
    titles = {
        "microwave": "microwave/",
        "microwave/steel": "microwave/steel",
        "apple": "apple/#0",
        "apple/3": "apple/#3",
    }
    for name, title in {**titles, "apple/3": "apple/#3"}.items():
        found = find(name, tmp_path, ())
        assert isinstance(found, Member)
        assert found.id.startswith(title)
        assert found.request.is_object == name.startswith("apple")


def test_a_name_of_nothing_is_refused_with_the_nearest(tmp_path: Path) -> None:
    for name, nearest in [
        ("microwave/steal", "steel"),
        ("microwav", "microwave"),
        ("one_wall_smal__coastal", KITCHEN),
        ("aple", "apple"),
        ("apple/first", "apple/0"),
    ]:
        with pytest.raises(UnknownId, match=nearest):
            find(name, tmp_path, ())


def test_a_path_that_shows_nothing_says_what_to_do(tmp_path: Path) -> None:
    for name in ("mug.glb", "mug.txt", f"scenes/{KITCHEN}/scene.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("{}", encoding="utf-8")
    for name, advice in [
        ("nothing", "no such file"),
        ("mug.glb", r"casa-assets ingest .*mug\.glb"),
        ("mug.txt", "is no MJCF"),
        (".", "holds no asset and no scene"),
        ("scenes", rf"is a folder of scenes; name one of them: {KITCHEN}"),
    ]:
        with pytest.raises(OutputError, match=advice):
            find(str(tmp_path / name), tmp_path, ())
