"""Assets of a project's libraries stand where a style names them: `library:<id>`."""

from __future__ import annotations

import json
import re
import shutil
from contextlib import nullcontext
from pathlib import Path

import pytest

import casa_assets as casa
from casa_assets.asset.scale_asset import scaled
from casa_assets.errors import CasaError, OutputError
from casa_assets.families.build import FamilyRequest, build_all
from casa_assets.layouts.check_plan.check import check_plan
from casa_assets.layouts.compose import box_of
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.run.library_assets import library_asset, placed_asset
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult, recipe_of
from casa_assets.layouts.run.resolve import build_scene, kitchen_key, resolve
from casa_assets.layouts.run.scene_json import describe
from casa_assets.library.entry_files import read_asset
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.kitchen.floor import Role
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.written_formats import SceneFile
from casa_assets.projects import use_project
from casa_assets.registry.kitchens import load_style
from casa_assets.show.view.model import build_command
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.assets import rigid_mug
from tests.support.library.built_libraries import keep
from tests.support.library.libraries import made_once, no_workers
from tests.support.program.projects import Project

pytestmark = pytest.mark.content("code", "layouts.run", keep=0)


def make_toaster(folder: Path) -> None:
    with no_workers():
        (done,) = build_all([FamilyRequest("toaster", preset="long_navy_brass")], folder, 1, drawn=False)
    assert done.passed


@pytest.fixture
def with_toaster(project: Project, tmp_path: Path, common: Path) -> str:
    """A project with a library of one toaster, named by a style; the id of the toaster."""
    shutil.copytree(made_once(common, "toaster", make_toaster), tmp_path / "lib")
    (folder,) = Library(tmp_path / "lib").accepted()
    style = f"like: modern_1\ntitle: Ours\nmodels: {{toaster: 'library:{folder.name}'}}\n"
    project({"casa.yaml": "name: ours\nlibraries: [lib]\n", "styles/ours.yaml": style})
    return folder.name


def test_the_asset_stands_in_the_kitchen_byte_for_byte(with_toaster: str, tmp_path: Path, cache: Path) -> None:
    recipe = SceneRecipe("one_wall_small", "ours")
    _, scene = build_scene(recipe, cache)
    (placed,) = (one for one in scene.placements if one.name == "toaster")
    assert placed.asset == with_toaster
    (asset,) = (one for one in scene.assets if one.id == with_toaster)
    assert asset.mass == pytest.approx(library_asset(with_toaster).mass)
    assert kitchen_key(recipe) != kitchen_key(SceneRecipe("one_wall_small", "modern_1"))


def test_a_kitchen_takes_a_model(with_toaster: str, tmp_path: Path, checked_kitchen: tuple[Path, SceneResult]) -> None:
    """In place of the style's: an asset of a library, and a preset of a family; its id and scene.json tell of them."""
    models = {"toaster": f"library:{with_toaster}"}
    kitchen = casa.kitchen("one_wall_small", "modern_1", models=models)
    assert dict(kitchen.recipe.models) == models
    assert re.fullmatch(r"one_wall_small__modern_1__m[0-9a-f]{8}", kitchen.id)
    assert {p.name: p.asset for p in kitchen.scene.placements}["toaster"] == with_toaster
    SceneFile.model_validate(kitchen.facts)
    assert kitchen.facts["models"] == models
    plain = json.loads((Path(checked_kitchen[1].folder) / "scene.json").read_text(encoding="utf-8"))
    assert "models" not in plain
    place = kitchen.write(tmp_path / "scenes")
    assert recipe_of(place.name, (place.parent,)).models == tuple(models.items())
    told = build_command(recipe_of(place.name, (place.parent,)))
    assert told == f"casa-assets scenes new one_wall_small --style modern_1 --model toaster=library:{with_toaster}"
    items = resolve(SceneRecipe("one_wall_small", "modern_1", models=(("range", "range/pro_six"),))).items
    assert [item.choice.preset for item in items if item.role == "range"] == ["range/pro_six"]


UNSUITED = (
    ({"rang": "range/pro_six"}, "unknown role of models 'rang'; did you mean range"),
    ({"range": "pro_six"}, "model of range: write FAMILY/PRESET or library:ID, got 'pro_six'"),
    ({"range": "library:range_0"}, "unknown library asset 'range_0'; there are toaster_"),
    ({"hob": "hob/gas_five"}, "model of hob: hob/gas_five would stand nowhere: plan one_wall_small has"),
    ({"microwave": "library:TOASTER"}, "model of microwave: expected .*, got"),
)
# Files of the project, what is in them, and what is said of it.
STYLE = "styles/ours.yaml"
WRONG = (
    (STYLE, "like: modern_1\nmodels: {toaster: 'library:toaster_nothing'}\n", "TOASTER"),
    (STYLE, "like: modern_1\nmodels: {sink: 'library:TOASTER'}\n", r"ours\.yaml:2: models\.sink: expected"),
    (STYLE, "like: modern_1\nmodels: {toaster: 'library:TOASTER'}\n", ""),
    ("casa.yaml", "name: ours\nlibraries: [libb]\n", r"casa\.yaml:2: libraries\.0: expected a folder"),
)


def test_what_does_not_suit_or_is_not_there_is_an_error(with_toaster: str, tmp_path: Path) -> None:
    for models, message in UNSUITED:
        named = {role: name.replace("TOASTER", with_toaster) for role, name in models.items()}
        with pytest.raises(CasaError, match=message):
            casa.kitchen("one_wall_small", "modern_1", models=named)
    for file, text, message in WRONG:
        (tmp_path / file).write_text(text.replace("TOASTER", with_toaster), encoding="utf-8")
        use_project(tmp_path)
        with pytest.raises(CasaError, match=message.replace("TOASTER", with_toaster)) if message else nullcontext():
            resolve(SceneRecipe("one_wall_small", "ours"))


def _as_read_back(asset: Asset, folder: Path) -> Asset:
    """An asset with its numbers in single precision, as files have them."""
    library = Library(keep(folder / "drafts", (asset,)))
    return read_asset(library.folder(asset.labels.category, asset.id))


class TestScaledToTheirPlaces:
    """A microwave three times as large as microwaves are, and a mug, in kitchens of a project."""

    @pytest.fixture
    def library(self, project: Project, tmp_path: Path) -> Path:
        """The project, with a style that names the microwave and a plan that names both."""
        assets = scaled(microwave(), 3.0, microwave().mass), rigid_mug()
        large, mug = (_as_read_back(asset, tmp_path) for asset in assets)
        assert large.bounds[1][0] - large.bounds[0][0] > 1.4
        keep(tmp_path / "lib", (large, mug))
        kettle = f"kettle: {{on: main_drawers_2, at: 0.1, model: 'library:{large.id}'}}"
        plan = f"like: one_wall_small\nworktop_items:\n  {kettle}\n"
        files = {
            "casa.yaml": "name: ours\nlibraries: [lib]\n",
            STYLE: f"like: modern_1\ntitle: Ours\nmodels: {{microwave: 'library:{large.id}'}}\n",
            "plans/wrong.yaml": plan,
            "plans/ours.yaml": plan.replace("kettle", "our_mug").replace(large.id, mug.id),
        }
        return project(files)

    def test_it_is_scaled_and_keeps_what_moves(self, library: Path, cache: Path) -> None:
        kitchen, scene = build_scene(SceneRecipe("one_wall_small", "ours"), cache)
        placed = next(one for one in scene.placements if one.name == "microwave")
        asset = scene.asset_of["microwave"]
        assert re.fullmatch(r"microwave_fitted_[0-9a-f]{10}", placed.asset)
        (width, depth, height), before = box_of(asset)[1], library_asset(microwave().id)
        assert max(width - 0.66, depth - 0.54, height - 0.42) <= 1e-6
        assert [joint.name for joint in asset.joints] == [joint.name for joint in before.joints]
        assert {region.name for region in asset.regions} == {region.name for region in before.regions}
        assert asset.base is Base.FIXED
        notes = {guess.subject: guess.value for guess in asset.provenance.guesses}
        assert "of its size in the library" in notes["size_in_the_kitchen"]
        assert notes["asset_in_the_library"] == microwave().id
        facts = describe(SceneRecipe("one_wall_small", "ours"), kitchen, scene)
        (row,) = facts["credits"]
        made = microwave().provenance
        assert (row["asset"], row["licence"], row["sha256"]) == (asset.id, made.licence, made.sha256)
        (fixture,) = (one for one in facts_of(kitchen, scene).fixtures if one.name == "microwave")
        assert fixture.role is Role.MICROWAVE
        assert fixture.bottom == pytest.approx(0.92, abs=0.002)
        (front,) = (region for region in fixture.regions if region.is_moving)
        (stated,) = (one["regions"][front.name] for one in facts["fixtures"] if one["name"] == "microwave")
        assert stated["position"][:2] == pytest.approx(front.footprint.center, abs=1e-4), "its link stands apart"

    def test_roles_of_a_project_say_what_suits(self, library: Path) -> None:
        plan = library / "plans" / "wrong.yaml"
        assert len(check_plan(plan.read_text(encoding="utf-8"), str(plan), load_style("ours")[0]).faults) == 1
        row = "kettle: {categories: [microwave], width: [0.1, 2], depth: [0.1, 2], height: [0.1, 2]}\n"
        (library / "roles.yaml").write_text(row, encoding="utf-8")
        use_project(library)
        (item,) = (item for item in resolve(SceneRecipe("wrong", "modern_1")).items if item.name == "kettle")
        assert item.choice.params == {"base": "free"}

    def test_doors_open_no_wider_than_they_may_reach(self, library: Path) -> None:
        whole = placed_asset(PresetChoice.model_validate(f"library:{microwave().id}"))
        choice = PresetChoice.model_validate({"preset": f"library:{microwave().id}", "reach": 0.01})
        asset = placed_asset(choice)
        (before,), (after,) = whole.joints, asset.joints
        assert 0.5 <= max(after.range, key=abs) / max(before.range, key=abs) < 1.0
        small = placed_asset(PresetChoice.model_validate({"preset": f"library:{rigid_mug().id}", "scale": 1.1}))
        assert small.mass == pytest.approx(1.1**3 * rigid_mug().mass, rel=1e-3)

    def test_an_asset_made_again_makes_another_scene_and_one_changed_by_hand_is_refused(self, library: Path) -> None:
        recipe = SceneRecipe("one_wall_small", "ours")
        before = kitchen_key(recipe)
        use_project(library)
        assert kitchen_key(recipe) == before
        large = scaled(microwave(), 3.0, microwave().mass)
        painted = large.replace(materials=tuple(m.replace(roughness=0.9) for m in large.materials))
        keep(library / "lib", (_as_read_back(painted, library),))
        use_project(library)
        assert kitchen_key(recipe) != before
        mesh = next((library / "lib" / "microwave").glob("*/meshes/*.obj"))
        mesh.write_text(mesh.read_text(encoding="ascii").replace("v -", "v -1", 1), encoding="ascii")
        use_project(library)
        with pytest.raises(OutputError, match="is not what was checked: it was changed by hand"):
            resolve(SceneRecipe("one_wall_small", "ours"))
