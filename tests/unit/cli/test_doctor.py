"""`doctor` prints what the machine has; its exit code says whether something needed is missing."""

from __future__ import annotations

import json

import pytest
import typer
from typer.testing import CliRunner

from casa_assets.cli.doctor import Finding, _renderers
from casa_assets.cli.verbs import check as verb

GOOD = Finding(subject="python", ok=True, message="3.11")
NOTE = Finding(subject="disk", ok=False, needed=False, message="1 GiB free")
PACKAGES = tuple(Finding(subject=f"package {name}", ok=True, message="1.0") for name in ("numpy", "scipy"))
EXTRA = Finding(subject="package mink", ok=False, needed=False, message="not installed", fix="pip install mink")
DRAWS = Finding(subject="renderer egl", ok=True, needed=False, message="llvmpipe")
UNUSED = Finding(subject="renderer osmesa", ok=False, needed=False, message="its library is not installed")
BAD = Finding(subject="rendering", ok=False, message="[none] works", fix="sudo apt-get install -y libegl1")


def run(monkeypatch: pytest.MonkeyPatch, found: tuple[Finding, ...], *arguments: str) -> tuple[int, str]:
    monkeypatch.setattr("casa_assets.cli.doctor.findings", lambda output: found)
    app = typer.Typer()
    app.command()(verb.doctor)
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.output


def test_a_line_for_each_thing_and_no_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    found = (GOOD, *PACKAGES, EXTRA, DRAWS, UNUSED, NOTE)
    code, output = run(monkeypatch, found)
    assert code == 0
    lines = output.splitlines()
    assert [line.split()[:2] for line in lines[:-1]] == [
        ["note", "disk"],
        ["note", "packages"],
        ["ok", "packages"],
        ["ok", "python"],
    ]
    assert "mink" in lines[1]
    _, output = run(monkeypatch, found, "--verbose")
    assert all(word in output for word in ("numpy", "scipy", "renderer osmesa", "llvmpipe"))
    assert "run: pip install mink" in output
    _, output = run(monkeypatch, (GOOD, UNUSED, BAD))
    assert "renderer osmesa" in output
    assert output.startswith("MISSING"), "what is wrong comes first"


def test_a_library_that_is_missing_and_not_needed_is_told_in_words() -> None:
    """PyOpenGL raises an AttributeError there, which says nothing to anybody."""
    raised = "AttributeError: 'NoneType' object has no attribute 'glGetError'"
    told = {finding.subject: finding for finding in _renderers((("egl", True, "llvmpipe"), ("osmesa", False, raised)))}
    assert told["renderer osmesa"].message == "its library is not installed (libosmesa6); not needed, for egl draws"
    assert told["rendering"].ok


def test_quiet_tells_what_is_missing_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(monkeypatch, (GOOD, NOTE), "--quiet") == (0, "")
    code, output = run(monkeypatch, (GOOD, NOTE, BAD), "--quiet")
    assert code == 1
    assert [line.split()[0] for line in output.splitlines()] == ["MISSING", "Needed"]


@pytest.mark.parametrize("found", [(GOOD, NOTE), (GOOD, BAD)])
def test_json(monkeypatch: pytest.MonkeyPatch, found: tuple[Finding, ...]) -> None:
    monkeypatch.setattr("casa_assets.cli.doctor.findings", lambda output: found)
    app = typer.Typer()
    app.command()(verb.doctor)
    result = CliRunner().invoke(app, ["--json"])
    rows = [json.loads(line) for line in result.stdout.splitlines()]
    assert [row["subject"] for row in rows] == [finding.subject for finding in found]
    assert result.exit_code == int(not all(row["ok"] or not row["needed"] for row in rows))
