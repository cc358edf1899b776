"""Plug-ins of a project: they run where they are asked for, add what they say, and fail by themselves."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

import casa_assets as casa
from casa_assets.cache.cache_key import key_of
from casa_assets.errors import CasaError, PluginFailure, RegistryError
from casa_assets.families.build import FamilyRequest, build_all
from casa_assets.library.entry_files import read_certificate
from casa_assets.library.library import Library
from casa_assets.projects import PLUGINS, PluginUse, choose_plugins, use_project, user_settings
from casa_assets.registry.families import family_names
from casa_assets.registry.plugins import ignored_files, load_plugins
from casa_assets.registry.plugins.checks import check_table
from casa_assets.textures.run.recipes import find_recipe, finish_key, finish_of
from tests.support.library.libraries import called, no_workers
from tests.support.program.plugin_code import PLUGIN, PROJECT
from tests.support.program.projects import Project

IMPORT = "from casa_assets.ext.plugins import Plugin\n"


@pytest.fixture(autouse=True)
def no_plugins_after(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Which plug-ins run is as it was after the test, and nobody's own configuration has a say."""
    monkeypatch.setenv(PLUGINS, "")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    with no_workers():
        yield
    choose_plugins(PluginUse.INSTALLED)


@pytest.fixture
def allowed(project: Project) -> Path:
    folder = project(PROJECT)
    choose_plugins(PluginUse.ALL)
    return folder


def run(folder: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    return called(*words, folder=folder, CASA_ASSETS_PROJECT="")


class TestTrust:
    def test_code_of_a_project_does_not_run_unless_asked_for(self, project: Project) -> None:
        folder = project({"plugins/shout.py": "raise SystemExit('ran')\n"})
        assert load_plugins() == ()
        assert ignored_files() == (folder / "plugins" / "shout.py",)

    def test_what_only_that_code_adds_is_told_with_the_way_to_run_it(self, project: Project) -> None:
        project(PROJECT)
        with pytest.raises(RegistryError, match=r"or what testing\.py adds, which does not run .* got 'chequers'"):
            find_recipe("chess")
        with pytest.raises(RegistryError, match=r"or what testing\.py adds, which does not run .* got 'square'"):
            casa.build("coaster")

    def test_it_runs_where_the_caller_or_the_users_own_configuration_says_so(self, project: Project) -> None:
        folder = project(PROJECT)
        assert "plinth" not in family_names()
        with casa.Project(folder, plugins=True) as opened:
            assert list(casa.plugins()) == ["testing"]
            assert "plinth" in family_names()
            assert ignored_files() == ()
        assert list(opened.plugins()) == ["testing"]
        assert "plinth" not in family_names()
        user_settings().parent.mkdir(parents=True)
        user_settings().write_text(f"trusted_projects: [{folder}]\n", encoding="utf-8")
        use_project(folder)
        assert [one.plugin.name for one in load_plugins()] == ["testing"]
        choose_plugins(PluginUse.NONE)
        assert load_plugins() == ()


def test_what_is_wrong_is_told_with_its_file(project: Project) -> None:
    for text, message in [
        ("import nothing_of_that_name\n", r"shout\.py: cannot be imported[\s\S]*nothing_of_that_name"),
        ("PLUGIN = 3\n", r"shout\.py: PLUGIN is no casa_assets\.Plugin but int"),
        (f"{IMPORT}PLUGIN = Plugin('Big', '1')\n", r"plug-in 'Big': expected a name as"),
        (f"{IMPORT}PLUGIN = Plugin('a', '1', sources=(3,))\n", r"source 3 lacks"),
        (PLUGIN.replace('"plinth"', '"microwave"'), r"family 'microwave': a family of that name is there already"),
        (PLUGIN.replace('"depot"', '"s3"'), r"source 's3': expected a name as .* none of a store"),
        (PLUGIN.replace('"TST001"', '"AST001"'), r"check 'AST001': a check of that name is there already"),
    ]:
        project({**PROJECT, "plugins/testing.py": "", "plugins/shout.py": text})
        choose_plugins(PluginUse.ALL)
        with pytest.raises(CasaError, match=message):
            (check_table(), family_names())


def test_a_module_may_import_another_beside_it(project: Project) -> None:
    text = f"from names_of_ours import NAME\n{IMPORT}PLUGIN = Plugin(NAME, '1')\n"
    project({"plugins/shout.py": text, "plugins/names_of_ours.py": "NAME = 'aloud'\n"})
    choose_plugins(PluginUse.ALL)
    assert [one.plugin.name for one in load_plugins()] == ["aloud"]


class TestParts:
    def test_a_family_is_built_checked_and_certified(self, allowed: Path, tmp_path: Path) -> None:
        library = tmp_path / "library"
        wanted = [FamilyRequest("plinth", preset=preset) for preset in ("oak", "wide", "unlucky")]
        done = {result.request.preset: result for result in build_all(wanted, library, 1, drawn=False)}
        assert done["oak"].passed, done["oak"]
        assert done["wide"].passed
        certificate = read_certificate(Path(done["oak"].folder))
        assert certificate.versions["plugin:testing"].startswith("1.0 ")
        assert "TST001" in {result.code for result in certificate.report.results}
        failed = done["unlucky"]
        assert not failed.is_fault
        assert "plug-in testing: family plinth: ValueError: thirteen brings bad luck" in failed.message
        trace = Path(failed.message.rpartition("the trace: ")[2])
        assert "add_plinth" in trace.read_text(encoding="utf-8")
        kept = [result.is_kept for result in build_all(wanted[:2], library, 1, drawn=False)]
        assert kept == [True, True]

    def test_a_kind_of_texture(self, allowed: Path, tmp_path: Path) -> None:
        finish = finish_of(find_recipe("chess"), tmp_path, 64)
        assert finish.material.base_color_texture is not None
        with pytest.raises(PluginFailure, match="texture kind chequers: RuntimeError: dark is lighter than light"):
            finish_of(find_recipe("bad_chess"), tmp_path, 64)

    def test_a_source_fetches_or_fails_once(
        self, allowed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "cache"))
        library = casa.Library(tmp_path / "library")
        results = list(library.ingest("depot:boxes", "depot:gone", jobs=1))
        assert sorted(result.status for result in results) == ["accepted", "rejected"]
        (rejected,) = (result for result in results if result.status == "rejected")
        assert rejected.reasons[0].code == "RUN009"
        assert "OSError: the depot is shut" in rejected.reasons[0].message
        assert len(list((tmp_path / "cache").rglob("cereal_box.obj"))) == 1
        (entry,) = Library(tmp_path / "library").accepted()
        assert "TST001" in {result.code for result in read_certificate(entry).report.results}


def test_code_of_a_plugin_is_part_of_what_it_makes_and_of_nothing_else(allowed: Path, tmp_path: Path) -> None:
    checks, plain = "casa_assets.runs.asset_package:check_package", "casa_assets.registry.load:load"
    before = (key_of(checks), key_of(plain), finish_key(find_recipe("chess")), finish_key(find_recipe("oak_ebony")))
    path = allowed / "plugins" / "testing.py"
    path.write_text(path.read_text(encoding="utf-8") + "\n# another word\n", encoding="utf-8")
    use_project(allowed)
    after = (key_of(checks), key_of(plain), finish_key(find_recipe("chess")), finish_key(find_recipe("oak_ebony")))
    assert [a == b for a, b in zip(before, after, strict=True)] == [False, True, False, True]


def test_plugins_from_a_folder_to_exported_files(tmp_path: Path, project: Project) -> None:
    folder = project(PROJECT)
    silent = run(folder, "families", "list", "--json")
    assert '"plinth"' not in silent.stdout
    assert "does not run; add --plugins if you trust it" in silent.stderr
    rows = [json.loads(line) for line in run(folder, "families", "list", "--json", "--plugins").stdout.splitlines()]
    (row,) = (row for row in rows if row["id"] == "plinth")
    assert (row["from"], row["presets"]) == ("plug-in testing", ["oak", "unlucky", "wide"])
    built = run(folder, "families", "build", "plinth", "--library", "lib", "--no-pictures", "--plugins")
    assert built.returncode == 1, built.stderr
    assert "thirteen brings bad luck" in built.stdout
    wrong = run(folder, "export", "plugin", "bloks", "lib", "--out", "blocks", "--plugins")
    assert wrong.returncode == 2
    assert "did you mean blocks?" in wrong.stderr
    done = run(folder, "export", "plugin", "blocks", "lib", "--out", "blocks", "--plugins")
    assert done.returncode == 0, done.stderr
    sizes = [json.loads(path.read_text(encoding="utf-8")) for path in (folder / "blocks").rglob("block.json")]
    assert sorted(size["mass"] > 0 for size in sizes) == [True, True]
    told = run(folder, "doctor", "--plugins").stdout
    assert "plug-in testing" in told
    assert "TST001" in run(folder, "checks", "--plugins").stdout
    assert "TST001" not in run(folder, "checks", "--no-plugins").stdout
