"""What a project states is laid over the package, file by file and key by key, and errors name its own lines."""

from __future__ import annotations

from pathlib import Path

import pytest

import casa_assets as casa
from casa_assets import registry
from casa_assets.cache.cache_key import key_of
from casa_assets.errors import RegistryError
from casa_assets.model.registry.document import Document
from casa_assets.projects import VARIABLE, environment, project_folder, use_project
from casa_assets.registry.families import object_family, object_files
from casa_assets.registry.kitchens import load_plan, load_style, style_names
from casa_assets.registry.read import origin_of_row, read_document
from casa_assets.runs.limits import Limits
from casa_assets.runs.pool import Pool
from tests.support.program.projects import Project


def document(path: Path, text: str) -> Document:
    path.write_text(text, encoding="utf-8")
    return read_document(path)


def test_faults_name_the_file_and_the_line_that_state_it(tmp_path: Path) -> None:
    lower = document(tmp_path / "a.yaml", "mug: {mass: [1, 2, 3], size: {x: 1, y: 2}}\ncup: {mass: 4}\n")
    upper = document(tmp_path / "b.yaml", "mug:\n  mass: [5]\n  size: {y: 7}\nbowl: {mass: 6}\n")
    for path, expected in [
        (("mug", "mass", 0), "b.yaml:2"),
        (("mug", "mass", 2), "b.yaml:2"),
        (("mug", "size", "x"), "a.yaml:1"),
        (("mug", "size", "y"), "b.yaml:3"),
        (("mug", "colour"), "a.yaml:1"),
        (("cup", "mass"), "a.yaml:2"),
        (("bowl", "size"), "b.yaml:4"),
    ]:
        assert str(lower.overlaid(upper).fault(path, "a", "b")).startswith(f"{expected}: ")


def test_lists_on_the_top_follow_each_other(tmp_path: Path) -> None:
    lower = document(tmp_path / "a.yaml", "- {code: A}\n- {code: B}\n")
    upper = document(tmp_path / "b.yaml", "# ours\n- {code: C}\n")
    joined = lower.overlaid(upper)
    assert lower.overlaid(document(tmp_path / "c.yaml", "# nothing yet\n")) == lower
    assert [row["code"] for row in joined.value] == ["A", "B", "C"]
    assert str(joined.fault((2, "code"), "a", "b")).startswith("b.yaml:2: ")
    assert str(joined.fault((1, "code"), "a", "b")).startswith("a.yaml:2: ")


class TestTables:
    def test_a_category_is_added_and_another_changed(self, project: Project) -> None:
        before = registry.load()
        canteen = "parent: drinkware, longest_m: [0.1, 0.2, 0.3], mass_kg: [0.1, 0.2, 0.3], shape: [1, 0.5, 0.5]"
        canteen += ", upright: stands, build: vessel, substance: steel, aliases: [field flask]"
        project({"categories.yaml": f"mug: {{mass_kg: [0.2, 0.3, 0.6]}}\ntin_canteen: {{{canteen}}}\n"})
        known = registry.load()
        assert known.categories["mug"].mass_kg.typical == 0.3
        assert known.categories["mug"].longest_m == before.categories["mug"].longest_m
        assert set(known.categories) - set(before.categories) == {"tin_canteen"}
        assert known.find_category(["my field flask"])[0].id == "tin_canteen"
        assert known.digest != before.digest
        for name, origin in (("tin_canteen", "ours"), ("mug", "ours"), ("bowl", "casa-assets")):
            assert origin_of_row("categories.yaml", name) == origin
        use_project(None)
        assert registry.load().digest == before.digest

    def test_a_name_that_another_category_has_is_told_with_both(self, project: Project) -> None:
        folder = project({"categories.yaml": "mug:\n  aliases: [tea mug, canteen]\n"})
        message = "expected a name that no other category has, got 'canteen', also of water_bottle"
        with pytest.raises(RegistryError, match=message) as told:
            registry.load()
        assert str(told.value).startswith(f"{folder}/categories.yaml:2: mug.aliases.1: ")

    def test_a_row_of_objects_stands_in_one_file(self, project: Project) -> None:
        project({"objects/fruit.yaml": "apple: {about: Ours.}\n"})
        assert object_family("apple").description == "Ours."
        assert "apple" in object_files()["fruit"]
        project({"objects/more.yaml": "apple: {about: Theirs.}\n"})
        with pytest.raises(RegistryError, match=r"to change its row, use objects/fruit\.yaml"):
            object_files()


class TestPlansAndStyles:
    def test_a_plan_of_ones_own_takes_the_place_of_one_of_that_name(self, project: Project) -> None:
        whole = load_plan("galley")[0]
        folder = project({"plans/galley.yaml": "like: galley\ntitle: Our galley\nheight: 2.9\n"})
        plan, read = load_plan("galley")
        assert (plan.title, plan.height) == ("Our galley", 2.9)
        assert plan.walls == whole.walls
        assert read.file == str(folder / "plans" / "galley.yaml")
        assert str(read.fault(("height",), "a", "b")).startswith(f"{folder}/plans/galley.yaml:3: ")
        assert str(read.fault(("walls", "back"), "a", "b")).startswith("plans/galley.yaml:")

    def test_a_style_like_another(self, project: Project) -> None:
        beach = "like: coastal\ntitle: Beach\nmodels: {hob: hob/induction}\n"
        project({"styles/beach.yaml": beach, "styles/dunes.yaml": "like: beach\ntitle: Dunes\n"})
        assert {"beach", "dunes"} <= set(style_names())
        assert load_style("dunes")[0].models["hob"].preset == "hob/induction"
        style, coastal = load_style("beach")[0], load_style("coastal")[0]
        assert (style.title, style.models["hob"].preset) == ("Beach", "hob/induction")
        assert (style.models["range"], style.cabinets) == (coastal.models["range"], coastal.cabinets)

    def test_numbers_of_a_preset_are_none_of_the_preset_in_its_place(self, project: Project) -> None:
        files = {
            "styles/b.yaml": "like: coastal\nmodels: {kettle: {preset: kettle/retro_cream, body: copper}}\n",
            "styles/a.yaml": "like: b\nmodels:\n  kettle: {preset: kettle/jug_white, height: 0.21}\n",
            "styles/c.yaml": "like: b\nmodels: {kettle: {height: 0.19}}\n",
        }
        folder = project(files)
        replaced, document = load_style("a")
        assert replaced.models["kettle"].preset == "kettle/jug_white"
        assert replaced.models["kettle"].params == {"height": 0.21}
        assert str(document.fault(("models", "kettle", "body"), "a", "b")).startswith(f"{folder}/styles/a.yaml:3: ")
        changed = load_style("c")[0].models["kettle"]
        assert (changed.preset, changed.params) == ("kettle/retro_cream", {"body": "copper", "height": 0.19})


class TestProject:
    def test_two_are_used_side_by_side(self, tmp_path: Path) -> None:
        opened = []
        for name, width in (("first", 1.2), ("second", 1.3)):
            (tmp_path / name / "plans").mkdir(parents=True)
            (tmp_path / name / "casa.yaml").write_text(f"name: {name}\n", encoding="utf-8")
            (tmp_path / name / "limits.yaml").write_text(f"work_aisle_m: {{value: {width}}}\n", encoding="utf-8")
            (tmp_path / name / "plans" / f"{name}.yaml").write_text("like: galley\n", encoding="utf-8")
            opened.append(casa.Project(tmp_path / name))
        first, second = opened
        for _ in range(2):
            with first, second:
                assert registry.load().limits["work_aisle_m"] == 1.3
                assert environment()[VARIABLE] == str(tmp_path / "second")
            with first:
                assert registry.load().limits["work_aisle_m"] == 1.2
        assert set(first.plans()) ^ set(second.plans()) == {"first", "second"}
        kitchen = first.kitchen("first", "coastal")
        with second:
            assert kitchen.scene.placements, "it keeps to the project that it was made in"
        assert project_folder() is None

    def test_workers_use_the_project_too(self, tmp_path: Path) -> None:
        (tmp_path / "casa.yaml").write_text("name: ours\n", encoding="utf-8")
        with casa.Project(tmp_path), Pool(1, Limits(60.0, 1_000_000_000), "casa_assets.projects:in_use") as pool:
            answers = pool.run("tests.support.program.pool_jobs:folder_in_use", [None])
            assert [answer for _, answer in answers] == [tmp_path]

    @pytest.mark.parametrize(
        ("files", "message"),
        [
            ({"styles/a.yaml": "like: costal\n"}, r"a\.yaml:1: like: expected 'coastal', or another one of"),
            ({"styles/a.yaml": "title: A\nlike: a\n"}, r"a\.yaml:2: like: expected a style that is not like this one"),
            ({"styles/a.yaml": "like: b\n", "styles/b.yaml": "like: a\n"}, r"b\.yaml:1: like: expected a style that"),
            ({"styles/a.yaml": "- 1\n"}, r"a\.yaml:1: \(top\): expected a style, got list"),
            ({"casa.yaml": "nam: ours\n"}, r"casa\.yaml:1: nam: expected 'name'"),
            ({"casa.yaml": "name: ours\nruns:\n  - ingest: {a: 1}\n    find: {}\n"}, r"casa\.yaml:3: runs\.0"),
            ({"catgories.yaml": ""}, r"catgories\.yaml:1: \(top\): expected 'categories\.yaml'"),
            ({"plan/loft.yaml": ""}, r"plan:1: \(top\): expected 'plans'"),
            ({"textures/walls.yaml": ""}, r"walls\.yaml:1: \(top\): expected one of cabinet\.yaml, .* got 'walls"),
            ({"plans/loft.yml": ""}, r"plans/loft\.yml:1: \(top\): expected a name that ends in \.yaml, got"),
        ],
    )
    def test_slips_are_told(self, project: Project, files: dict[str, str], message: str) -> None:
        folder = project(files)
        with pytest.raises(RegistryError, match=message) as told:
            load_style("a") if "styles/a.yaml" in files else registry.load()
        assert str(told.value).startswith(f"{folder}/")


def test_a_key_takes_in_what_the_project_states_of_what_the_code_reads(project: Project) -> None:
    habits, load = "casa_assets.registry.habits:load_habits", "casa_assets.registry.load:load"
    before = key_of(habits), key_of(load)
    project({})
    assert (key_of(habits), key_of(load)) == before
    project({"habits.yaml": "# ours\n"})
    assert key_of(habits) != before[0]
    assert key_of(load) == before[1]
    project({"categories.yaml": "mug: {mass_kg: [0.2, 0.3, 0.6]}\n"})
    assert key_of(load) != before[1]
    use_project(None)
    assert (key_of(habits), key_of(load)) == before
