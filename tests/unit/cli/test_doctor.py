"""`doctor` prints what the machine has; its exit code says whether something needed is missing."""

from __future__ import annotations

import json

import pytest
import typer
from typer.testing import CliRunner

from casa_assets.cli.verbs import doctor as verb
from casa_assets.pipeline.doctor import Finding

GOOD = Finding(subject="python", ok=True, message="3.11")
NOTE = Finding(subject="disk", ok=False, needed=False, message="1 GiB free")
BAD = Finding(subject="rendering", ok=False, message="[none] works", fix="sudo apt-get install -y libegl1")


def run(monkeypatch: pytest.MonkeyPatch, found: tuple[Finding, ...], *arguments: str) -> tuple[int, str]:
    monkeypatch.setattr("casa_assets.pipeline.doctor.findings", lambda output: found)
    app = typer.Typer()
    app.command()(verb.doctor)
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.output


def test_all_is_well(monkeypatch: pytest.MonkeyPatch) -> None:
    code, output = run(monkeypatch, (GOOD, NOTE))
    assert code == 0
    assert "Everything that is needed is here." in output


def test_something_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    code, output = run(monkeypatch, (GOOD, BAD))
    assert code == 1
    assert "[none] works" in output
    assert "sudo apt-get install -y libegl1" in output


@pytest.mark.parametrize("found", [(GOOD, NOTE), (GOOD, BAD)])
def test_json(monkeypatch: pytest.MonkeyPatch, found: tuple[Finding, ...]) -> None:
    code, output = run(monkeypatch, found, "--json")
    report = json.loads(output)
    assert report["ok"] is (code == 0)
    assert [finding["subject"] for finding in report["findings"]] == [finding.subject for finding in found]
