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


@pytest.mark.parametrize(
    ("name", "title"),
    [
        ("microwave", "microwave/"),
        ("microwave/steel", "microwave/steel"),
        ("apple", "apple/#0"),
        ("apple/3", "apple/#3"),
    ],
)
def test_a_member_of_a_family_or_of_a_category(name: str, title: str, tmp_path: Path) -> None:
    found = find(name, tmp_path, ())
    assert isinstance(found, Member)
    assert found.id.startswith(title)
    assert found.request.is_object == name.startswith("apple")


@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("microwave/steal", "steel"),
        ("microwav", "microwave"),
        ("one_wall_smal__coastal", KITCHEN),
        ("aple", "apple"),
        ("apple/first", "apple/0"),
    ],
)
def test_a_name_of_nothing_tells_the_nearest(name: str, nearest: str, tmp_path: Path) -> None:
    with pytest.raises(UnknownId, match=nearest):
        find(name, tmp_path, ())


def test_a_path_that_shows_nothing_says_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="no such file"):
        find(str(tmp_path / "nothing"), tmp_path, ())
    (tmp_path / "mug.glb").write_bytes(b"glTF")
    with pytest.raises(OutputError, match=r"casa-assets ingest .*mug\.glb"):
        find(str(tmp_path / "mug.glb"), tmp_path, ())
    (tmp_path / "mug.txt").write_bytes(b"")
    with pytest.raises(OutputError, match="is no MJCF"):
        find(str(tmp_path / "mug.txt"), tmp_path, ())
    with pytest.raises(OutputError, match="holds no asset and no scene"):
        find(str(tmp_path), tmp_path, ())
    (tmp_path / KITCHEN).mkdir()
    (tmp_path / KITCHEN / "scene.json").write_text("{}", encoding="utf-8")
    with pytest.raises(OutputError, match=rf"is a folder of scenes; name one of them: {KITCHEN}"):
        find(str(tmp_path), tmp_path, ())
