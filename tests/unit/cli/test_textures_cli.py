"""The verbs of textures: what they print, write and exit with."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.verbs.textures import app
from casa_assets.errors import UnknownId
from casa_assets.pipeline.textures import check

RUNNER = CliRunner()


def test_list_names_every_recipe_of_a_set() -> None:
    result = RUNNER.invoke(app, ["list", "--set", "wall", "--json"])
    rows = [json.loads(line) for line in result.stdout.splitlines()]
    assert result.exit_code == 0
    assert len(rows) == 100
    assert {r["surface"] for r in rows} == {"wall"}
    assert isinstance(rows[0]["params"], dict)


def test_make_writes_where_it_is_told(tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["make", "beadboard_white", "--out", str(tmp_path), "--width-px", "64", "--json"])
    assert result.exit_code == 0
    row = json.loads(result.stdout)
    files = row["files"]
    assert (row["verdict"], row["folder"]) == ("made", str(tmp_path / "wall"))
    roles = ("color", "metallic_roughness", "normal")
    assert sorted(files) == [str(tmp_path / "wall" / f"beadboard_white_{role}.png") for role in roles]
    assert all(Path(f).read_bytes().startswith(b"\x89PNG") for f in files)


def test_check_passes_a_sound_one(tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["check", "beadboard_white", "--out", str(tmp_path), "--json"])
    assert result.exit_code == 0
    report = json.loads(result.stdout)
    assert report["verdict"] == "passed"
    assert report["subject"] == "beadboard_white"
    assert {r["status"] for r in report["results"]} <= {"passed", "not_applicable"}
    assert any(r["status"] == "passed" for r in report["results"])


def test_check_exits_with_one_on_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    known = registry.load()
    strict = replace(known, limits={**known.limits, "texture_resolution": 1e6})
    # The verb works in processes of their own, where a changed limit would not be seen; here it works in this one.
    monkeypatch.setattr(check, "check_recipes", lambda wanted, cache, _: (check.check_one(w, cache) for w in wanted))
    monkeypatch.setattr(registry, "load", lambda *_: strict)
    result = RUNNER.invoke(app, ["check", "beadboard_white", "--out", str(tmp_path)])
    assert result.exit_code == 1
    assert "TEX008" in result.stdout


def test_sheet_is_a_picture(tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["sheet", "beadboard_white", "--out", str(tmp_path), "--width-px", "64"])
    assert result.exit_code == 0
    assert (tmp_path / "sheet_chosen.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_id_is_an_error_with_near_names() -> None:
    result = RUNNER.invoke(app, ["make", "beadbord_white"])
    assert isinstance(result.exception, UnknownId)
    assert "beadboard_white" in str(result.exception)


def test_ingest_reports_what_it_left_out(tmp_path: Path) -> None:
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "broken.png").write_bytes(b"no picture")
    command = ["ingest", str(tmp_path / "pack"), "--library", str(tmp_path / "library"), "--surface", "wall"]
    result = RUNNER.invoke(app, command)
    assert result.exit_code == 1
    assert "broken.png" in result.stdout
    assert "0 pictures taken, 1 left out" in result.stdout


def test_ingest_refuses_a_size_that_is_none(tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["ingest", str(tmp_path), "--tile", "-1", "1", "--library", str(tmp_path / "l")])
    assert result.exit_code == 2
    assert "--tile" in result.output
