"""The verbs of textures: what they print, write and exit with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.verbs.textures import app
from casa_assets.textures.run import check

RUNNER = CliRunner()


def test_check_exits_with_one_on_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    known = registry.load()
    strict = replace(known, limits={**known.limits, "texture_resolution": 1e6})
    # The verb works in processes of their own, where a changed limit would not be seen; here it works in this one.
    monkeypatch.setattr(check, "check_recipes", lambda wanted, cache, _: (check.check_one(w, cache) for w in wanted))
    monkeypatch.setattr(registry, "load", lambda *_: strict)
    result = RUNNER.invoke(app, ["check", "beadboard_white", "--out", str(tmp_path)])
    assert result.exit_code == 1
    assert "TEX008" in result.stdout


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
