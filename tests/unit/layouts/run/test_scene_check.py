"""A scene's verdict: on disk, kept, and failed with the right code where something is wrong."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from casa_assets.checks.design.subject import DesignSubject
from casa_assets.checks.scene.formats import SceneFiles
from casa_assets.checks.scene.placement import PreviewImages
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.table import TABLE
from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run import check, scene_folders, scene_page
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.layouts.run.scene_folders import BuildOptions, build_with_options
from casa_assets.layouts.run.scene_json import design_of
from casa_assets.model.issue import Issue, Report, Severity
from casa_assets.model.kitchen.scene import Scene
from casa_assets.show.reports import kitchens
from casa_assets.show.stills.kitchen import PictureSettings
from tests.support.asset.packages import tamper

Checked = tuple[Path, SceneResult]
Composed = tuple[KitchenRequest, Scene]
RECIPE = SceneRecipe("one_wall_small", "coastal")
OUTSIDE = Issue(code="SCN009", severity=Severity.ERROR, message="it is outside")
LABEL = '<text name="main_fridge__class" data="'


@pytest.fixture
def copy(checked_kitchen: Checked, tmp_path: Path) -> Path:
    """A folder of scenes of its own that a test may damage; what is shared is linked."""
    out, _ = checked_kitchen
    shutil.copytree(out / RECIPE.scene_id, tmp_path / RECIPE.scene_id)
    (tmp_path / "assets").symlink_to(out / "assets")
    return tmp_path


@pytest.fixture(scope="module")
def composed(cache: Path) -> Composed:
    return build_scene(RECIPE, cache)


@pytest.fixture
def at_hand(composed: Composed, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (scene_folders, check):
        monkeypatch.setattr(module, "build_scene", lambda recipe, cache: composed)


def report_of(out: Path) -> dict[str, Any]:
    return json.loads((out / RECIPE.scene_id / "report.json").read_text(encoding="utf-8"))


class TestVerdict:
    def test_report_page_and_map_hold_every_check_with_its_number(self, checked_kitchen: Checked) -> None:
        out, done = checked_kitchen
        assert done.report is not None, done.message
        kinds = (SceneSubject, SceneFiles, DesignSubject, PreviewImages)
        wanted = {row.code for row in TABLE if row.subject in kinds} | {"SCN026", "SCN027"}
        data, folder = report_of(out), out / RECIPE.scene_id
        assert [r["code"] for r in data["results"]] == sorted(wanted)
        assert data["passed"] == done.report.passed
        assert Report.model_validate({k: data[k] for k in ("subject", "results", "issues")}) == done.report
        text = (folder / "report.html").read_text(encoding="utf-8")
        reach = "A base of 0.30 m radius reaches every fixture from an entry"
        assert [said for said in ("SCN017", "Reachable fixtures", reach) if said not in text] == []
        assert f"{done.report.tally} passed." in text
        shown = re.sub(r"<(script|style)\b.*?</\1>", "", text, flags=re.DOTALL)
        assert "failed" not in shown, "what is advice in a passed kitchen is shown as advice"
        assert re.search(r'class="advice">\d+ not followed', text)
        assert (folder / "floor_map.png").read_bytes().startswith(b"\x89PNG")

    def test_checks_alone_write_nothing(self, copy: Path, composed: Composed, monkeypatch: pytest.MonkeyPatch) -> None:
        folder = copy / RECIPE.scene_id
        for name in (scene_page.REPORT, scene_page.PAGE, check.FLOOR_MAP):
            (folder / name).unlink()
        before = {path: path.stat().st_mtime_ns for path in [folder, *folder.rglob("*")]}
        monkeypatch.setattr(check, "run_scene", lambda subject, *_: Report(subject=subject.scene.id))
        monkeypatch.setattr(check, "run", lambda subject, name, *_: Report(subject=name))
        monkeypatch.setattr(check, "steps_per_second", lambda model: 4000.0)
        kitchen, scene = composed
        check.run_checks_on_scene(scene, design_of(kitchen, scene), folder)
        assert {path: path.stat().st_mtime_ns for path in [folder, *folder.rglob("*")]} == before

    def test_it_is_kept_while_nothing_changes(self, checked_kitchen: Checked) -> None:
        out, done = checked_kitchen
        before = (out / RECIPE.scene_id / "report.json").stat().st_mtime_ns
        again = check.check_one(RECIPE, out)
        assert (again.kept, again.report) == (True, done.report)
        assert (out / RECIPE.scene_id / "report.json").stat().st_mtime_ns == before

    @pytest.mark.usefixtures("at_hand")
    def test_an_older_model_is_made_again_alone(self, copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        folder = copy / RECIPE.scene_id
        monkeypatch.setattr(check, "_checked_in_place", None)
        (script,) = folder.glob("*.glb.js")
        made = script.read_bytes()
        script.write_text("old", encoding="utf-8")
        assert check.check_one(RECIPE, copy).kept
        assert script.read_text(encoding="utf-8") == "old"
        tamper(folder / "report.json", (scene_page.model_key(), "0" * 64))
        assert check.check_one(RECIPE, copy).kept
        assert script.read_bytes() == made

    def test_the_page_shows_the_picture_and_viewer_that_there_are(
        self, checked_kitchen: Checked, tmp_path: Path
    ) -> None:
        """Whoever writes the page, after an upgrade too, where the folder of all scenes has the viewer of before."""
        out, done = checked_kitchen
        folder = tmp_path / RECIPE.scene_id
        shutil.copytree(out / RECIPE.scene_id, folder)
        scene_page.join_states(folder, done.report)
        named = re.findall(r'data-viewer="([^"]+)"', (folder / "report.html").read_text(encoding="utf-8"))
        assert named
        assert [name for name in named if not (folder / name).resolve().is_file()] == []
        for name, shown in (("eye_open.png", "overview.png"), ("overview.png", "eye_open.png")):
            (folder / name).unlink(missing_ok=True)
            scene_page.join_states(folder, done.report)
            assert f'src="./{shown}"' in (folder / "report.html").read_text(encoding="utf-8")
            (folder / "eye_open.png").write_bytes(b"png")

    @pytest.mark.usefixtures("at_hand")
    def test_a_broken_scene_fails_with_its_codes(self, copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """A label that only one format has, a light form that is another machine, and no speed worth waiting for."""
        folder = copy / RECIPE.scene_id
        tamper(folder / "scene.xml", (LABEL, LABEL + "cold "))
        tamper(folder / "scene_light.xml", ('name="main_fridge__', 'name="main_frigde__'))
        monkeypatch.setattr(check, "CHECK_FRAME", PictureSettings(64, 48, 1))
        monkeypatch.setattr(check, "steps_per_second", lambda model: 4000.0)
        done = check.check_one(RECIPE, copy, force=True)
        assert not done.passed
        assert {i.code for i in done.problems if i.code.startswith("SCN")} == {"SCN017", "SCN021"}
        assert report_of(copy)["passed"] is False
        (row,) = kitchens.read_rows(copy)
        assert row.passed is False
        assert "SCN017 x " in row.verdict


def refuse(recipe: SceneRecipe, scene: Scene, design: DesignSubject, folder: Path) -> Report:
    assert (folder / "scene.xml").is_file()
    assert (folder.parent / "assets").is_dir()
    return Report(subject=scene.id, issues=(OUTSIDE,))


def files_below(out: Path) -> list[Path]:
    return [p for p in out.rglob("*") if p.is_file() and ".casa" not in p.parts]


@pytest.mark.usefixtures("at_hand")
class TestNothingIsPutInPlace:
    @pytest.mark.parametrize("strict", [True, False])
    def test_where_a_strict_judge_refuses(self, strict: bool, tmp_path: Path) -> None:
        done = build_with_options(RECIPE, tmp_path, BuildOptions(drawn=False, judge=refuse, strict=strict))
        assert (done.passed, [i.code for i in done.problems]) == (False, ["SCN009"])
        assert (tmp_path / RECIPE.scene_id / "scene.usda").is_file() is not strict
        assert not strict or (done.folder, files_below(tmp_path)) == ("", [])
        assert list((tmp_path / ".casa" / "staging").iterdir()) == []

    def test_where_writing_breaks_off(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        def broken(*_: object, **__: object) -> None:
            raise OSError("no space left")

        monkeypatch.setattr("casa_assets.formats.usd.kitchen.write", broken)
        done = scene_folders.build_one(RECIPE, tmp_path, drawn=False)
        assert "no space left" in done.message
        assert files_below(tmp_path) == []

    def test_where_it_cannot_be_composed_an_earlier_one_goes(self, copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        def misfit(*_: object) -> None:
            raise PlanConflict("one_wall_small", ("rows", "main"), "at most 3 m", "4 m")

        monkeypatch.setattr(scene_folders, "build_scene", misfit)
        done = scene_folders.build_one(RECIPE, copy, force=True)
        assert not done.passed
        assert not (copy / RECIPE.scene_id).exists()


def test_a_failed_scene_of_before_goes_where_only_sound_ones_stay(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check, "kept_report", lambda folder, key: Report(subject="x", issues=(OUTSIDE,)))
    done = check.check_one(RECIPE, copy, strict=True)
    assert (done.passed, done.folder) == (False, "")
    assert not (copy / RECIPE.scene_id).exists()
