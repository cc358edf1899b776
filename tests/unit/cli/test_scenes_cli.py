"""The verbs of scenes: what they print, write and exit with."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets.cli.verbs.scenes import app
from casa_assets.errors import UnknownId
from casa_assets.layouts.run import check, sample
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.model.issue import Issue, Report, Severity
from tests.support.library.libraries import no_workers

RUNNER = CliRunner()
SCENE = "one_wall_small__coastal"
Checked = tuple[Path, SceneResult]


@pytest.fixture(autouse=True)
def here() -> Iterator[None]:
    """Scenes are made in this process."""
    with no_workers():
        yield


def test_list_names_plans_and_styles() -> None:
    rows = [json.loads(line) for line in RUNNER.invoke(app, ["list", "--json"]).stdout.splitlines()]
    assert [row["kind"] for row in rows] == ["plan"] * 16 + ["style"] * 12
    told = RUNNER.invoke(app, ["list"]).stdout
    assert "16 plans x 12 styles = 192 scenes" in told


def test_check_prints_one_object_per_scene_and_a_table(checked_kitchen: Checked) -> None:
    out, done = checked_kitchen
    told = RUNNER.invoke(app, ["check", SCENE, "--out", str(out), "--jobs", "1", "--json"])
    assert told.exit_code == (0 if done.passed else 1)
    (row,) = [json.loads(line) for line in told.stdout.splitlines()]
    assert (row["id"], row["passed"], row["kept"]) == (SCENE, done.passed, True)
    assert [i["code"] for i in row["issues"]] == [i.code for i in done.problems]


def test_check_prints_a_table_and_writes_it(checked_kitchen: Checked, monkeypatch: pytest.MonkeyPatch) -> None:
    out, done = checked_kitchen

    def check_all(*_: object, drawn: bool, in_3d: bool, at_eye_level: bool) -> Iterator[SceneResult]:
        return iter([done] if drawn and in_3d and not at_eye_level else [])

    monkeypatch.setattr(check, "check_all", check_all)
    result = RUNNER.invoke(app, ["check", SCENE, "--out", str(out)])
    lines = result.stdout.splitlines()
    heads = next(line for line in lines if "NKBA" in line)
    assert all(word in heads for word in ("joints", "load ms", "geoms", "tex MB"))
    assert any(line.split()[:1] == [SCENE] for line in lines)
    assert "joints swept" in result.stdout
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["totals"]["scenes"] == 1
    assert "summary.json" in (out / "index.html").read_text(encoding="utf-8")


def test_preview_draws_the_camera_that_is_named(checked_kitchen: Checked, tmp_path: Path) -> None:
    out, _ = checked_kitchen
    shutil.copytree(out / SCENE, tmp_path / SCENE)
    (tmp_path / "assets").symlink_to(out / "assets")
    options = ["--camera", "at_sink", "--pose", "open", "--width-px", "64", "--passes", "1", "--out", str(tmp_path)]
    result = RUNNER.invoke(app, ["preview", SCENE, *options])
    assert result.exit_code == 0, result.output
    path = Path(result.stdout.strip().replace("\n", ""))
    assert path == tmp_path / SCENE / "at_sink_open.png"
    assert path.read_bytes().startswith(b"\x89PNG")
    assert isinstance(RUNNER.invoke(app, ["preview", "galley__x", "--out", str(tmp_path)]).exception, UnknownId)


class TestSample:
    """The verb; that rejected scenes leave nothing behind is tested with the pipeline."""

    def told(self, bad: int, monkeypatch: pytest.MonkeyPatch, out: Path) -> tuple[int, str]:
        """Exit code and words where so many of four draws fail."""
        report = Report(subject="x", issues=(Issue(code="SCN005", severity=Severity.ERROR, message="two doors meet"),))
        asked: dict[str, object] = {}

        def made(recipes: Sequence[SceneRecipe], _: Path, jobs: int, drawn: bool, in_3d: bool) -> Iterator[SceneResult]:
            asked.update(jobs=jobs, drawn=drawn, in_3d=in_3d)
            cost = {"build": 1.0, "check": 2.5}
            for i, recipe in enumerate(recipes):
                folder = "" if i < bad else str(out / recipe.scene_id)
                yield SceneResult(recipe, folder, report=report if i < bad else None, cpu_s=cost)

        monkeypatch.setattr(sample, "sample_all", made)
        result = RUNNER.invoke(app, ["sample", "4", "--seed", "9", "--out", str(out), "--jobs", "1", "--no-pictures"])
        assert asked == {"jobs": 1, "drawn": False, "in_3d": False}
        return result.exit_code, result.stdout

    def test_rate_and_reasons_are_told(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        code, message = self.told(1, monkeypatch, tmp_path)
        assert code == 0
        assert "3 of 4 draws passed (75.0%)" in message
        assert "3.5 core-seconds per kitchen (build 1.0, write 0.0, draw 0.0, check 2.5, rest 0.0)" in message
        assert re.search(r"SCN005 +\S+ +\S+ +1 +two doors meet", message), message
        assert re.search(r"diversity +these 3 +the 192 of plan x style", message), message
        data = json.loads((tmp_path / "diversity.json").read_text(encoding="utf-8"))
        assert (data["kitchens"]["kitchens"], data["reference"]["kitchens"]) == (3, 192)
        data = json.loads((tmp_path / "rejected.json").read_text(encoding="utf-8"))
        assert (data["seed"], data["drawn"], data["passed"], len(data["rejected"])) == (9, 4, 3, 1)

    def test_none_passes(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        assert self.told(4, monkeypatch, tmp_path)[0] == 1
