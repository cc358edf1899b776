"""Verbs on kitchens, textures and views: what they print, write and exit with."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import urllib.request
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.errors import UnknownId
from casa_assets.layouts.run import check
from casa_assets.layouts.run import sample as run
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.model.issue import Issue, Report, Severity
from casa_assets.show.stills import live_viewer
from tests.support.library.libraries import command, no_workers

RUNNER = CliRunner()
SCENE = "one_wall_small__coastal"
Checked = tuple[Path, SceneResult]


@pytest.fixture(autouse=True)
def here() -> Iterator[None]:
    """Scenes are made in this process."""
    with no_workers():
        yield


def test_check_prints_a_table_and_writes_it(checked_kitchen: Checked, monkeypatch: pytest.MonkeyPatch) -> None:
    out, done = checked_kitchen

    def check_all(*_: object, drawn: bool, in_3d: bool, at_eye_level: bool) -> Iterator[SceneResult]:
        return iter([done] if drawn and in_3d and not at_eye_level else [])

    monkeypatch.setattr(check, "check_all", check_all)
    result = RUNNER.invoke(app, ["scenes", "check", SCENE, "--out", str(out)])
    lines = result.stdout.splitlines()
    assert any(all(word in line for word in ("NKBA", "joints", "load ms", "geoms", "tex MB")) for line in lines)
    assert any(line.split()[:1] == [SCENE] for line in lines)
    assert "joints swept" in result.stdout
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["totals"]["scenes"] == 1
    assert "summary.json" in (out / "index.html").read_text(encoding="utf-8")


def test_preview_draws_the_camera_that_is_named(checked_kitchen: Checked, tmp_path: Path) -> None:
    out, _ = checked_kitchen
    shutil.copytree(out / SCENE, tmp_path / SCENE)
    (tmp_path / "assets").symlink_to(out / "assets")
    words = ["scenes", "preview", SCENE, "--camera", "at_sink", "--pose", "open", "--width-px", "64", "--passes", "1"]
    result = RUNNER.invoke(app, [*words, "--out", str(tmp_path)])
    path = tmp_path / SCENE / "at_sink_open.png"
    assert (result.exit_code, result.stdout.replace("\n", "")) == (0, str(path)), result.output
    assert path.read_bytes().startswith(b"\x89PNG")
    wrong = RUNNER.invoke(app, ["scenes", "preview", "galley__x", "--out", str(tmp_path)])
    assert isinstance(wrong.exception, UnknownId)


@pytest.mark.parametrize(("bad", "code"), [(1, 0), (4, 1)])
def test_sample_says_why_draws_fail(bad: int, code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    report = Report(subject="x", issues=(Issue(code="SCN005", severity=Severity.ERROR, message="two doors meet"),))
    asked: dict[str, object] = {}

    def made(recipes: Sequence[SceneRecipe], _: Path, jobs: int, drawn: bool, in_3d: bool) -> Iterator[SceneResult]:
        asked.update(jobs=jobs, drawn=drawn, in_3d=in_3d, objects={recipe.objects for recipe in recipes})
        for i, recipe in enumerate(recipes):
            folder = "" if i < bad else str(tmp_path / recipe.scene_id)
            cost = {"build": 1.0, "check": 2.5}
            yield SceneResult(recipe, folder, report=report if i < bad else None, cpu_s=cost)

    monkeypatch.setattr(run, "sample_all", made)
    words = ["scenes", "sample", "4", "--seed", "9", "--objects", "5", "--out", str(tmp_path), "--jobs", "1"]
    result = RUNNER.invoke(app, [*words, "--no-pictures"])
    assert asked == {"jobs": 1, "drawn": False, "in_3d": False, "objects": {5}}
    assert result.exit_code == code
    if code == 0:
        assert "3 of 4 draws passed (75.0%)" in result.stdout
        assert "3.5 core-seconds per kitchen (build 1.0, write 0.0, draw 0.0, check 2.5, rest 0.0)" in result.stdout
        assert re.search(r"SCN005 +\S+ +\S+ +1 +two doors meet", result.stdout), result.stdout
        assert re.search(r"diversity +these 3 +the 192 of plan x style", result.stdout), result.stdout
        data = json.loads((tmp_path / "diversity.json").read_text(encoding="utf-8"))
        assert (data["kitchens"]["kitchens"], data["reference"]["kitchens"]) == (3, 192)
        data = json.loads((tmp_path / "rejected.json").read_text(encoding="utf-8"))
        assert (data["seed"], data["drawn"], data["passed"], len(data["rejected"])) == (9, 4, 3, 1)


def test_check_exits_with_one_on_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    known = registry.load()
    strict = replace(known, limits={**known.limits, "texture_resolution": 1e6})
    monkeypatch.setattr(registry, "load", lambda *_: strict)
    result = RUNNER.invoke(app, ["textures", "check", "beadboard_white", "--out", str(tmp_path)])
    assert result.exit_code == 1
    assert "TEX008" in result.stdout


PATIENCE_S = 60


def test_serves_a_page_until_it_is_stopped(tmp_path: Path) -> None:
    bare = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    by_ssh = {**bare, "SSH_CONNECTION": "10.0.0.2 50000 10.0.0.9 22", "USER": "ada"}
    running = subprocess.Popen(
        command("view", "mug"), cwd=tmp_path, env=by_ssh, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    address = running.stdout.readline().strip()
    with urllib.request.urlopen(address, timeout=PATIENCE_S) as answer:
        assert b"mug" in answer.read()
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=PATIENCE_S)
    port = address.rstrip("/").rpartition(":")[2]
    assert address == f"http://127.0.0.1:{port}/"
    assert (running.returncode, out) == (0, "")
    assert f"ssh -N -L {port}:127.0.0.1:{port} ada@10.0.0.9" in err
    assert "Ctrl-C ends it" in err
    assert list(tmp_path.iterdir()) == []


def test_with_a_screen_mujoco_shows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":99")
    shown = []
    monkeypatch.setattr(live_viewer, "require_screen", lambda: None)
    monkeypatch.setattr(live_viewer, "show", lambda model, pose, name, _: shown.append((model.nkey, pose, name)))
    done = RUNNER.invoke(app, ["view", "microwave/steel", "--pose", "open"])
    assert done.exit_code == 0, done.output
    assert shown == [(2, "open", "microwave/steel")]
    assert done.stdout == ""
    microwave = casa.build("microwave", "steel")
    microwave.show("open")
    assert shown[1:] == [(2, "open", microwave.id)]


def test_a_port_that_is_taken_is_named(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        done = RUNNER.invoke(app, ["view", "mug", "--web", "--no-browser", "--port", str(taken.getsockname()[1])])
    assert done.exit_code == 1
    assert "leave --port out" in str(done.exception)
