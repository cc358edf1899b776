"""Assets of a project's libraries stand where a style names them: `library:<id>`."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from casa_assets.errors import CasaError, RegistryError, UnknownId
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.pipeline.families.run import FamilyRequest, build_all
from casa_assets.pipeline.kitchens.library_assets import library_asset
from casa_assets.pipeline.kitchens.resolve import SceneRecipe, build_scene, kitchen_key, resolve
from casa_assets.projects import use_project
from tests.projects import Project


def test_a_choice_names_an_asset_as_it_is() -> None:
    choice = PresetChoice.model_validate("library:range_0a1b2c3d4e")
    assert (choice.family, choice.name, choice.is_library) == ("library", "range_0a1b2c3d4e", True)
    assert not PresetChoice.model_validate("range/pro_six").is_library
    with pytest.raises(ValidationError, match="no numbers to change: width"):
        PresetChoice.model_validate({"preset": "library:range_0a1b2c3d4e", "width": 0.7})


@pytest.fixture
def with_toaster(project: Project, tmp_path: Path) -> str:
    """A project with a library of one toaster, named by a style; the id of the toaster."""
    (done,) = build_all([FamilyRequest("toaster", preset="long_navy_brass")], tmp_path / "lib", 1, drawn=False)
    style = f"like: modern_1\ntitle: Ours\nmodels: {{toaster: 'library:{done.asset_id}'}}\n"
    project({"casa.yaml": "name: ours\nlibraries: [lib]\n", "styles/ours.yaml": style})
    return done.asset_id


def test_the_asset_stands_in_the_kitchen_byte_for_byte(with_toaster: str, tmp_path: Path, cache: Path) -> None:
    recipe = SceneRecipe("one_wall_small", "ours")
    _, scene = build_scene(recipe, cache)
    (placed,) = (one for one in scene.placements if one.name == "toaster")
    assert placed.asset == with_toaster
    (asset,) = (one for one in scene.assets if one.id == with_toaster)
    assert asset.mass == pytest.approx(library_asset(with_toaster).mass)
    assert kitchen_key(recipe) != kitchen_key(SceneRecipe("one_wall_small", "modern_1"))


def test_what_is_wrong_is_told(with_toaster: str, tmp_path: Path) -> None:
    style = tmp_path / "styles" / "ours.yaml"
    style.write_text("like: modern_1\nmodels: {toaster: 'library:toaster_nothing'}\n", encoding="utf-8")
    use_project(tmp_path)
    with pytest.raises(UnknownId, match=with_toaster):
        resolve(SceneRecipe("one_wall_small", "ours"))
    style.write_text(f"like: modern_1\nmodels: {{sink: 'library:{with_toaster}'}}\n", encoding="utf-8")
    use_project(tmp_path)
    with pytest.raises(CasaError, match=r"style ours: models\.sink: .* a sink is made to the measure of what it is in"):
        resolve(SceneRecipe("one_wall_small", "ours"))
    style.write_text(f"like: modern_1\nmodels: {{toaster: 'library:{with_toaster}'}}\n", encoding="utf-8")
    (tmp_path / "casa.yaml").write_text("name: ours\nlibraries: [libb]\n", encoding="utf-8")
    use_project(tmp_path)
    with pytest.raises(RegistryError, match=r"casa\.yaml:2: libraries\.0: expected a folder"):
        resolve(SceneRecipe("one_wall_small", "ours"))
